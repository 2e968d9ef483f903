//! Trajectories of Riemannian cubics by the explicit symplectic splitting.

use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use super::call::Call;
use super::chart::count;
use super::convert::{Batch, freeze, matrix, parameters, to_array, tuple, whole};
use super::error::{invalid_input, to_exception};
use crate::cubic::{
    CubicTrajectory, SplittingOptions, SplittingOrder, integrate_cubic as integrate,
};
use crate::curve::Samples;
use crate::manifold::stored::check_orthonormal;

type Array = Py<PyArrayDyn<f64>>;

/// Arrays in the order of the attributes, and both drifts.
type Pickled = ([Array; 6], f64, f64);

/// A discrete trajectory of a Riemannian cubic. Its arrays are read-only.
///
/// Attributes
/// ----------
/// t : ndarray, shape (steps + 1,)
///     Times.
/// point : ndarray, shape (steps + 1, n, k)
/// velocity : ndarray, shape (steps + 1, n, k)
/// acceleration : ndarray, shape (steps + 1, n, k)
///     Covariant.
/// jerk : ndarray, shape (steps + 1, n, k)
///     Covariant.
/// energy : ndarray, shape (steps + 1,)
///     The Hamiltonian ``|A|^2 / 2 - <J, V>`` in the canonical metric.
/// momentum_drift : float
///     Largest deviation of the spatial momentum from its start: ``|A|^2 = tr(A^T A) / 2``.
/// constraint_drift : float
///     Largest deviation of the conserved constraint ``mu_h = [x, p]_h`` from zero, in the same norm.
#[pyclass(name = "CubicTrajectory", module = "stiefel_rs", frozen)]
pub struct PyCubicTrajectory {
    t: Array,
    point: Array,
    velocity: Array,
    acceleration: Array,
    jerk: Array,
    energy: Array,
    momentum_drift: f64,
    constraint_drift: f64,
}

#[pymethods]
impl PyCubicTrajectory {
    #[getter]
    fn t(&self, py: Python<'_>) -> Array {
        self.t.clone_ref(py)
    }
    #[getter]
    fn point(&self, py: Python<'_>) -> Array {
        self.point.clone_ref(py)
    }
    #[getter]
    fn velocity(&self, py: Python<'_>) -> Array {
        self.velocity.clone_ref(py)
    }
    #[getter]
    fn acceleration(&self, py: Python<'_>) -> Array {
        self.acceleration.clone_ref(py)
    }
    #[getter]
    fn jerk(&self, py: Python<'_>) -> Array {
        self.jerk.clone_ref(py)
    }
    #[getter]
    fn energy(&self, py: Python<'_>) -> Array {
        self.energy.clone_ref(py)
    }
    #[getter]
    fn momentum_drift(&self) -> f64 {
        self.momentum_drift
    }
    #[getter]
    fn constraint_drift(&self) -> f64 {
        self.constraint_drift
    }
    /// For pickle: a trajectory from its arrays.
    #[staticmethod]
    fn _restored(
        py: Python<'_>,
        arrays: [Bound<'_, PyAny>; 6],
        momentum_drift: f64,
        constraint_drift: f64,
    ) -> PyResult<Self> {
        const NAMES: [&str; 6] = ["t", "point", "velocity", "acceleration", "jerk", "energy"];
        let mut parts = Vec::with_capacity(NAMES.len());
        let mut common: Vec<usize> = Vec::new();
        for (i, (array, name)) in arrays.iter().zip(NAMES).enumerate() {
            let (shape, entries) = parameters(array, name)?;
            if i == 1 {
                common.clone_from(&shape);
            }
            let scalar = i == 0 || i == NAMES.len() - 1;
            let expected = if scalar { 1 } else { 3 };
            let fits = scalar || shape == common;
            if shape.len() != expected || !fits || !entries.iter().all(|x| x.is_finite()) {
                let message = format!("{name}: no part of a trajectory, shape {}", tuple(&shape));
                return Err(invalid_input(py, message));
            }
            parts.push((shape, entries));
        }
        if [0, 5].iter().any(|i| parts[*i].0[0] != common[0]) {
            let message = format!("t, energy: expected shape ({},)", common[0]);
            return Err(invalid_input(py, message));
        }
        let points = Batch::of([common[0], common[1], common[2]], parts[1].1.clone());
        for i in 0..points.len() {
            check_orthonormal(&format!("{}: state {i}", NAMES[1]), points.get(i))
                .map_err(|error| to_exception(py, &error, ""))?;
        }
        let mut parts = parts.into_iter().map(|(shape, entries)| {
            let array = to_array(py, entries, &shape)?;
            freeze(&array)?;
            PyResult::Ok(array.unbind())
        });
        let mut next = || parts.next().expect("as many as names");
        Ok(PyCubicTrajectory {
            t: next()?,
            point: next()?,
            velocity: next()?,
            acceleration: next()?,
            jerk: next()?,
            energy: next()?,
            momentum_drift,
            constraint_drift,
        })
    }
    /// For pickle.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Pickled)> {
        let (py, this) = (slf.py(), slf.get());
        let arrays = [
            &this.t,
            &this.point,
            &this.velocity,
            &this.acceleration,
            &this.jerk,
            &this.energy,
        ];
        let arrays = arrays.map(|array| array.clone_ref(py));
        let state = (arrays, this.momentum_drift, this.constraint_drift);
        Ok((slf.get_type().getattr("_restored")?, state))
    }
    /// Trajectories do not change: a copy is the trajectory itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }
    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.point.bind(py).getattr("shape")?;
        Ok(format!("<CubicTrajectory of shape {shape}>"))
    }
}

/// The Riemannian cubic with the given initial data, by equal steps of an explicit symplectic splitting.
///
/// Any shape, no chart, no equation to solve: each step is a sequence of exact flows. Points stay orthonormal, spatial
/// momentum and constraint conserved, to round-off; the energy has no drift.
///
/// Parameters
/// ----------
/// S, V, A, J : array_like, shape (n, k)
///     Point, and velocity, covariant acceleration and covariant jerk at it.
/// steps : int
///     Equal steps over ``[0, t_end]``, at least 1.
/// t_end : float, default 1.0
///     Negative to run backwards, not zero.
/// order : {2, 4, 6, 8}, default 6
///     Order of the method: 1, 4, 5 or 12 exponentials per step.
///
/// Returns
/// -------
/// CubicTrajectory
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal, not tangent, ``steps < 1``, ``t_end`` zero, unknown order, an exponential by
///     more than 100 radians where ``n > 3``, a result too large for a number.
///
/// Notes
/// -----
/// ``H = <mu, x> + |p|^2 / 2`` on the cotangent bundle of ``SO(n) x m`` (Crouch, Silva Leite 1995), split into its two
/// terms. Compositions of order 4, 6 and 8 made for such splittings; the Rust documentation of ``SplittingOrder`` has
/// their error constants.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import integrate_cubic
/// >>> S = np.array([[1.0], [0.0], [0.0]])
/// >>> V, A, J = np.array([[0.0], [1.0], [0.0]]), np.array([[0.0], [0.0], [1.0]]), np.zeros((3, 1))
/// >>> trajectory = integrate_cubic(S, V, A, J, 20, order=8)
/// >>> trajectory.point.shape
/// (21, 3, 1)
/// >>> bool(np.ptp(trajectory.energy) < 1e-9)
/// True
#[pyfunction]
#[pyo3(signature = (S, V, A, J, steps, t_end=1.0, order=6))]
#[allow(non_snake_case)] // the names of the mathematics
#[allow(clippy::too_many_arguments)] // and as many
pub fn integrate_cubic(
    py: Python<'_>,
    S: &Bound<'_, PyAny>,
    V: &Bound<'_, PyAny>,
    A: &Bound<'_, PyAny>,
    J: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = whole)] steps: i64,
    t_end: f64,
    #[pyo3(from_py_with = whole)] order: i64,
) -> PyResult<PyCubicTrajectory> {
    let data = [
        matrix(S, "S")?,
        matrix(V, "V")?,
        matrix(A, "A")?,
        matrix(J, "J")?,
    ];
    let order = SplittingOrder::try_from(order).map_err(|error| to_exception(py, &error, ""))?;
    let steps = count(py, "steps", steps, 1)?;
    let (n, k) = data[0].shape();
    let call = Call::new(
        py,
        None,
        operations(n, k, order.stages()) * (steps as f64 + 1.0),
    )?;
    let (trajectory, samples) = call.run(py, move |interrupt| {
        let options = SplittingOptions {
            t_end,
            order,
            interrupt,
        };
        let [s, v, a, j] = data.each_ref().map(|m| m.as_ref());
        let trajectory = integrate(s, v, a, j, steps, &options)?;
        interrupt.check("splitting of a cubic")?;
        let samples = [
            trajectory.points()?,
            trajectory.velocities()?,
            trajectory.accelerations()?,
            trajectory.jerks()?,
        ];
        Ok((trajectory, samples))
    })?;
    wrapped(py, &trajectory, samples)
}

/// Rough operations of a step and the lift of its state.
fn operations(n: usize, k: usize, stages: usize) -> f64 {
    let (n, k) = (n as f64, k as f64);
    let r = n.min(4.0 * k);
    stages as f64 * (200.0 + 40.0 * r * r * r) + 8.0 * n * r * k
}

fn wrapped(
    py: Python<'_>,
    trajectory: &CubicTrajectory,
    samples: [Samples; 4],
) -> PyResult<PyCubicTrajectory> {
    let (n, k, states) = (trajectory.n(), trajectory.k(), trajectory.steps() + 1);
    // Stored column by column; the transposed view has the documented shape and copies nothing.
    let array = |samples: Samples| -> PyResult<Array> {
        let stored = PyArray1::from_vec(py, samples.into_entries()).reshape([states, k, n])?;
        freeze(&stored)?;
        let view = stored.call_method1("swapaxes", (-1, -2))?;
        Ok(view.cast_into::<PyArrayDyn<f64>>()?.unbind())
    };
    let [point, velocity, acceleration, jerk] = samples;
    let frozen = |entries: Vec<f64>| -> PyResult<Array> {
        let array = to_array(py, entries, &[states])?;
        freeze(&array)?;
        Ok(array.unbind())
    };
    let times = (0..states).map(|i| trajectory.time(i)).collect();
    Ok(PyCubicTrajectory {
        t: frozen(times)?,
        point: array(point)?,
        velocity: array(velocity)?,
        acceleration: array(acceleration)?,
        jerk: array(jerk)?,
        energy: frozen(trajectory.energy().to_vec())?,
        momentum_drift: trajectory.momentum_drift(),
        constraint_drift: trajectory.constraint_drift(),
    })
}
