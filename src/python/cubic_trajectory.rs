//! Trajectories of Riemannian cubics, and the explicit symplectic splitting that computes them.

use numpy::Complex64;

use super::field::write_sample;
use super::points::Points;
use super::prelude::*;
use crate::cubic::{
    CubicTrajectory, SplittingOptions, SplittingOrder, integrate_cubic as integrate,
};
use crate::curve::{Quantity, Samples};
use crate::manifold::stored::check_orthonormal;

/// Arrays in the order of the attributes, and both drifts.
type Pickled<'py> = ([Any<'py>; 6], f64, f64);

/// Discrete trajectory of a Riemannian cubic; its arrays are read-only.
#[pyclass(name = "CubicTrajectory", module = "stiefel_rs", frozen, get_all)]
pub struct PyCubicTrajectory {
    /// Times, shape (steps + 1,).
    t: Owned,
    /// Points, shape (steps + 1, n, k).
    point: Owned,
    /// Velocities, shape (steps + 1, n, k).
    velocity: Owned,
    /// Covariant accelerations, shape (steps + 1, n, k).
    acceleration: Owned,
    /// Covariant jerks, shape (steps + 1, n, k).
    jerk: Owned,
    /// Hamiltonian ``|A|^2 / 2 - <J, V>`` in the canonical metric, shape (steps + 1,).
    energy: Owned,
    /// Largest deviation of the spatial momentum from its initial value, in the norm ``|A|^2 = tr(A^T A) / 2``.
    momentum_drift: f64,
    /// Largest violation of the constraints.
    ///
    /// For `integrate_cubic`, of ``mu_h = [x, p]_h`` in the norm of `momentum_drift`. For `integrate_embedded`, of
    /// ``S^T S = I`` and of the skew symmetry of ``S^T V``, ``S^T p_S`` and ``S^T p_V``, Frobenius norm.
    constraint_drift: f64,
}

/// Names of the arrays; the first and the last have one axis.
const NAMES: [&str; 6] = ["t", "point", "velocity", "acceleration", "jerk", "energy"];

#[pymethods]
impl PyCubicTrajectory {
    /// For pickle: rebuilds a trajectory from its arrays.
    #[staticmethod]
    fn _restored(
        py: Python<'_>,
        arrays: [Any<'_>; 6],
        momentum_drift: f64,
        constraint_drift: f64,
    ) -> PyResult<Self> {
        let field = Field::of(&arrays)?;
        let part = |i: usize| match NAMES[i] {
            "t" | "energy" => read(&arrays[i], NAMES[i]),
            name => {
                let [batch] = field.batches([(&arrays[i], name)])?;
                Ok(batch.into_array())
            }
        };
        let parts = collected(std::array::from_fn(part))?;
        let common = parts[1].shape.clone();
        for (Array { shape, entries }, name) in parts.iter().zip(NAMES) {
            let fits = match name {
                "t" | "energy" => shape.len() == 1,
                _ => shape.len() == 3 && *shape == common,
            };
            let (fits, found) = (fits && entries.iter().all(|x| x.is_finite()), tuple(shape));
            ensure!(fits, "{name}: shape {found} does not fit a trajectory");
        }
        let [count, n, k] = [common[0], common[1], common[2]];
        let fits = [0, 5].iter().all(|i| parts[*i].shape[0] == count);
        ensure!(fits, "t, energy: expected shape ({count},)");
        for (i, point) in parts[1].entries.chunks((n * k).max(1)).enumerate() {
            let point = MatRef::from_row_major_slice(point, n, k);
            check_orthonormal(&format!("{}: state {i}", NAMES[1]), point)?;
        }
        let frozen = |part: Array| match part.shape.len() {
            1 => part.frozen(py),
            _ => field.vectors(part)?.frozen(py),
        };
        let arrays = collected(parts.map(frozen))?;
        Ok(Self::of(arrays, [momentum_drift, constraint_drift]))
    }

    /// For pickle.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Any<'py>, Pickled<'py>)> {
        let (class, this) = (slf.get_type(), slf.get());
        let arrays = collected(NAMES.map(|name| slf.getattr(name)))?;
        let state = (arrays, this.momentum_drift, this.constraint_drift);
        Ok((class.getattr("_restored")?, state))
    }

    /// Trajectories are immutable: a copy is the trajectory itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Any) -> Py<Self> {
        slf
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.point.bind(py).getattr("shape")?;
        Ok(format!("<CubicTrajectory of shape {shape}>"))
    }
}

/// Point, velocity, acceleration and jerk of all states, computed without the interpreter.
pub(super) type Sampled = (CubicTrajectory, [Samples; 4]);

/// A trajectory with its points, velocities, accelerations and jerks.
pub(super) fn sampled(trajectory: CubicTrajectory) -> Result<Sampled> {
    let samples = [
        trajectory.points()?,
        trajectory.velocities()?,
        trajectory.accelerations()?,
        trajectory.jerks()?,
    ];
    Ok((trajectory, samples))
}

impl PyCubicTrajectory {
    /// The Python object of a trajectory.
    pub(super) fn wrap(
        py: Python<'_>,
        field: Field,
        trajectory: &CubicTrajectory,
        samples: [Samples; 4],
    ) -> PyResult<Self> {
        let (n, k, states) = (trajectory.n(), trajectory.k(), trajectory.steps() + 1);
        let array = |quantity, samples| sampled_array(py, field, quantity, samples, [states, k, n]);
        let [points, velocities, accelerations, jerks] = samples;
        let [point, velocity, acceleration, jerk] = collected([
            array(Quantity::Derivative(0), points),
            array(Quantity::Derivative(1), velocities),
            array(Quantity::Acceleration, accelerations),
            array(Quantity::Jerk, jerks),
        ])?;
        let times = (0..states).map(|i| trajectory.time(i)).collect();
        let t = Array::flat(times).frozen(py)?;
        let energy = trajectory
            .energy()
            .iter()
            .map(|energy| field.squared(*energy));
        let energy = Array::flat(energy.collect()).frozen(py)?;
        Ok(Self::of(
            [t, point, velocity, acceleration, jerk, energy],
            [trajectory.momentum_drift(), trajectory.constraint_drift()]
                .map(|drift| field.length(drift)),
        ))
    }

    fn of(
        [t, point, velocity, acceleration, jerk, energy]: [Owned; 6],
        [momentum_drift, constraint_drift]: [f64; 2],
    ) -> Self {
        PyCubicTrajectory {
            t,
            point,
            velocity,
            acceleration,
            jerk,
            energy,
            momentum_drift,
            constraint_drift,
        }
    }
}

/// A read-only array of shape `(states, n, k)` from samples of the core, which are stored by columns.
fn sampled_array(
    py: Python<'_>,
    field: Field,
    quantity: Quantity,
    samples: Samples,
    [states, k, n]: [usize; 3],
) -> PyResult<Owned> {
    // The transposed view of an array of transposed matrices copies nothing.
    let stored = match field {
        Field::Real => {
            let stored = PyArray1::from_vec(py, samples.into_entries());
            stored.reshape([states, k, n])?.into_any()
        }
        Field::Complex => {
            let (n, k) = field.own((n, k));
            let mut out = vec![Complex64::ZERO; states * n * k];
            for (sample, out) in samples.iter().zip(out.chunks_mut(n * k)) {
                write_sample(
                    quantity,
                    MatMut::from_column_major_slice_mut(out, n, k),
                    sample,
                )?;
            }
            to_array(py, out, &[states, k, n])?.into_any()
        }
    };
    freeze(&stored)?;
    let view = stored.call_method1("swapaxes", (-1, -2))?;
    Ok(view.unbind())
}

/// Integrate a Riemannian cubic with given initial data, by equal steps of an explicit symplectic splitting.
///
/// Works for any n and k, without charts and without solving equations: each step is a sequence of exact flows.
/// Orthonormality, spatial momentum and the constraint are preserved to round-off; the energy does not drift.
///
/// Parameters
/// ----------
/// S, V, A, J : array_like, shape (n, k)
///     Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
/// steps : int
///     Number of equal steps over ``[0, t_end]``, at least 1.
/// t_end : float, default 1.0
///     End time, not zero; negative to integrate backwards.
/// order : {2, 4, 6, 8}, default 6
///     Order of the method, with 1, 4, 5 or 12 exponentials per step; with tension 1, 5, 9 or 17.
/// tension : float, default 0.0
///     As for :meth:`RiemannianCubic.from_initial`.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
///     start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Returns
/// -------
/// CubicTrajectory
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent, ``steps < 1``, ``t_end`` zero,
///     unknown order, ``tension`` out of range, an exponential that turns by more than 100 radians if ``n > 3``, a
///     result that overflows.
///
/// Notes
/// -----
/// The Hamiltonian ``H = <mu, x> + |p|^2 / 2 - tension |x|^2 / 2`` on the cotangent bundle of ``SO(n) x m`` (Crouch,
/// Silva Leite 1995) is split into two terms. The compositions of order 4, 6 and 8 are designed for such splittings;
/// the Rust documentation of ``SplittingOrder`` lists their error constants.
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
#[pyo3(signature = (S, V, A, J, steps, t_end=1.0, order=6, *, tension=0.0, manifold=None, project=false))]
pub fn integrate_cubic(
    S: &Any,
    V: &Any,
    A: &Any,
    J: &Any,
    #[pyo3(from_py_with = whole)] steps: i64,
    t_end: f64,
    #[pyo3(from_py_with = whole)] order: i64,
    tension: f64,
    manifold: Option<&Any>,
    project: bool,
) -> PyResult<PyCubicTrajectory> {
    let (py, points) = (S.py(), Points::read(manifold, project)?);
    let arguments = named![S, V, A, J];
    let field = points.field(arguments.map(|(object, _)| object))?;
    let data = points.matrices(field, arguments)?;
    let quotient = points.quotient;
    let order = SplittingOrder::try_from(order)?;
    let steps = count("steps", steps, 1)?;
    let weight = steps as f64 + 1.0;
    let (trajectory, samples) = run_on(py, field, data, weight, move |[s, v, a, j], interrupt| {
        let options = SplittingOptions {
            t_end,
            tension,
            quotient,
            order,
        };
        let trajectory = integrate(s, v, a, j, steps, &options, interrupt)?;
        interrupt.check("splitting of a cubic")?;
        sampled(trajectory)
    })?;
    PyCubicTrajectory::wrap(py, field, &trajectory, samples)
}
