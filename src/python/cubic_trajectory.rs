//! Trajectories of Riemannian cubics by the explicit symplectic splitting.

use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use super::call::Call;
use super::convert::{matrix, to_array};
use super::error::{invalid_input, to_exception};
use crate::cubic::{
    CubicTrajectory, SplittingOptions, SplittingOrder, integrate_cubic as integrate,
};
use crate::curve::Samples;

type Array = Py<PyArrayDyn<f64>>;

/// A discrete trajectory of a Riemannian cubic.
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
///     Negative to run backwards.
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
///     Shape, not finite, not orthonormal, not tangent, ``steps < 1``, unknown order, an exponential by more
///     than 100 radians where ``n > 3``, a result too large for a number.
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
    steps: i64,
    t_end: f64,
    order: i64,
) -> PyResult<PyCubicTrajectory> {
    let data = [
        matrix(S, "S")?,
        matrix(V, "V")?,
        matrix(A, "A")?,
        matrix(J, "J")?,
    ];
    let order = SplittingOrder::try_from(order).map_err(|error| to_exception(py, &error, ""))?;
    let Ok(steps) = usize::try_from(steps) else {
        return Err(invalid_input(
            py,
            format!("steps: must be at least 1, found {steps}"),
        ));
    };
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
        let view = stored.call_method1("swapaxes", (-1, -2))?;
        Ok(view.cast_into::<PyArrayDyn<f64>>()?.unbind())
    };
    let [point, velocity, acceleration, jerk] = samples;
    let times = (0..states).map(|i| trajectory.time(i)).collect();
    Ok(PyCubicTrajectory {
        t: to_array(py, times, &[states])?.unbind(),
        point: array(point)?,
        velocity: array(velocity)?,
        acceleration: array(acceleration)?,
        jerk: array(jerk)?,
        energy: to_array(py, trajectory.energy().to_vec(), &[states])?.unbind(),
        momentum_drift: trajectory.momentum_drift(),
        constraint_drift: trajectory.constraint_drift(),
    })
}
