//! The paper's charts for arrays.

use super::array_namespace::Namespace;
use super::batch::{map_batch, read_batches};
use super::prelude::*;
use super::state::{ChartKind, check_finite, on_chart, state};
use crate::chart::{Chart, covariant_from_state};

/// Coordinate chart of arXiv 2404.19407: ``Chart.sphere()`` for St(3,1), ``Chart.frame()`` for St(3,2).
///
/// Coordinates ``q`` have ``d`` entries: ``(theta, phi)`` or ``(theta, phi, psi)``, radians, ``0 < theta < pi``. A
/// state is ``z = (q, qdot, p_q, p_qdot)``, shape ``(..., 4 d)``; leading axes are batches and broadcast.
///
/// Notes
/// -----
/// See the sections of arXiv 2404.19407 on St(3,1) and St(3,2). The Hamiltonian of the frame chart is derived from the
/// canonical metric; unlike the longer form in the paper it does not divide by ``cos(theta)``.
///
/// Examples
/// --------
/// A curve of the paper on the sphere, and its end after 100 midpoint steps:
///
/// >>> import numpy as np
/// >>> from stiefel_rs import Chart
/// >>> chart = Chart.sphere()
/// >>> q, qdot, qddot, qdddot = [np.pi / 2, np.pi], [0.1, 0.2], [1.0, 0.5], [0.1, 0.2]
/// >>> z0 = np.concatenate([q, qdot, *chart.momenta(q, qdot, qddot, qdddot)])
/// >>> trajectory = chart.integrate(z0, 100, map="midpoint")
/// >>> trajectory.shape
/// (101, 8)
/// >>> exact = chart.reference(z0, [1.0])
/// >>> bool(abs(trajectory[-1] - exact[0]).max() < 1e-4)
/// True
#[pyclass(name = "Chart", module = "stiefel_rs", frozen, eq, hash)]
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct PyChart(pub(super) ChartKind);

impl PyChart {
    /// Reads batches of vectors of the given length.
    pub(super) fn read<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        length: usize,
    ) -> PyResult<[Batch; N]> {
        let batches = read_batches(Field::Real, objects, 1)?;
        for (Batch { rows, .. }, (_, name)) in batches.iter().zip(objects) {
            let expected = format!("{name}: expected shape (..., {length})");
            ensure!(*rows == length, "{expected}, found (..., {rows})");
        }
        Ok(batches)
    }

    /// Joins a pair of momenta `(p_q, p_qdot)`.
    pub(super) fn read_guess(&self, pair: &Any) -> PyResult<Vec<f64>> {
        let d = self.d();
        if let Ok([p_q, p_qdot]) = two(pair)? {
            let [p_q, p_qdot] = self.read([(&p_q, "guess"), (&p_qdot, "guess")], d)?;
            if p_q.shape.is_empty() {
                return Ok([p_q.row(0), p_qdot.row(0)].concat());
            }
        }
        Err(invalid!("guess: expected two arrays of shape ({d},)"))
    }

    /// Apply `member` to vectors with `length` entries, member by member; its values have shape `core`.
    pub(super) fn map<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        length: usize,
        core: &[usize],
        member: impl Fn(ChartKind, [&[f64]; N], &mut [f64], Interrupt<'_>) -> Result<()> + Shared,
    ) -> PyResult<Numbers> {
        Numbers::from(self.map_array(objects, length, core, member)?).like(objects)
    }

    /// [`PyChart::map`] that returns a NumPy array.
    fn map_array<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        length: usize,
        core: &[usize],
        member: impl Fn(ChartKind, [&[f64]; N], &mut [f64], Interrupt<'_>) -> Result<()> + Shared,
    ) -> PyResult<Array> {
        let (py, kind) = (objects[0].0.py(), self.0);
        let batches = self.read(objects, length)?;
        let size: f64 = core.iter().map(|axis| *axis as f64).product();
        let numbers = (size + (N * length) as f64) * batches[0].len() as f64;
        let call = Call::new(py, None, numbers)?;
        map_batch(&call, batches, core, move |batches, i, out, interrupt| {
            member(kind, batches.map(|batch| batch.row(i)), out, interrupt)
        })
    }

    /// [`PyChart::map`] for states, which are validated.
    fn map_states(
        &self,
        z: &Any,
        core: &[usize],
        member: impl Fn(ChartKind, &[f64], &mut [f64]) -> Result<()> + Shared,
    ) -> PyResult<Numbers> {
        Numbers::from(self.map_state_array(z, core, member)?).like(named![z])
    }

    fn map_state_array(
        &self,
        z: &Any,
        core: &[usize],
        member: impl Fn(ChartKind, &[f64], &mut [f64]) -> Result<()> + Shared,
    ) -> PyResult<Array> {
        self.map_array(named![z], self.0.width(), core, move |kind, [z], out, _| {
            on_chart!(kind, chart => chart.check("z", z))?;
            member(kind, z, out)
        })
    }
}

#[pymethods]
impl PyChart {
    /// Return the chart of the sphere St(3,1): ``(theta, phi)``, metric ``diag(1, sin(theta)^2)``.
    #[staticmethod]
    fn sphere() -> Self {
        PyChart(ChartKind::Sphere)
    }

    /// Return the chart of the 2-frames St(3,2): ``(theta, phi, psi)``, with the canonical metric.
    ///
    /// The metric is ``dtheta^2 + dphi^2 + dpsi^2 + 2 cos(theta) dphi dpsi``.
    #[staticmethod]
    fn frame() -> Self {
        PyChart(ChartKind::Frame)
    }

    /// Dimension of the chart, 2 or 3.
    #[getter]
    pub(super) fn d(&self) -> usize {
        self.0.dimension()
    }

    /// Number of columns of an embedded point, 1 or 2.
    #[getter]
    fn k(&self) -> usize {
        self.0.columns()
    }

    fn __repr__(&self) -> String {
        format!("Chart.{}()", self.0.name())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Any<'py>, ())> {
        Ok((slf.get_type().getattr(slf.get().0.name())?, ()))
    }

    /// Return the points with coordinates ``q``: shape (..., d) -> (..., 3, k).
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     ``theta`` is not in ``(0, pi)``; carries ``angle``. The same holds for every method.
    fn embed(&self, q: &Any) -> PyResult<Numbers> {
        let (d, core) = (self.d(), [3, self.k()]);
        self.map(named![q], d, &core, |kind, [q], out, _| {
            on_chart!(kind, chart => {
                chart.check("q", q)?;
                write(chart.embed(q)?.as_ref(), out);
            });
            Ok(())
        })
    }

    /// Return the ambient velocities for coordinates ``q`` and rates ``qdot``: shape (..., d) -> (..., 3, k).
    fn embed_velocity(&self, q: &Any, qdot: &Any) -> PyResult<Numbers> {
        let (d, core) = (self.d(), [3, self.k()]);
        self.map(named![q, qdot], d, &core, |kind, [q, qdot], out, _| {
            on_chart!(kind, chart => {
                chart.check("q", q)?;
                check_finite("qdot", qdot)?;
                write(chart.embed_velocity(q, qdot)?.as_ref(), out);
            });
            Ok(())
        })
    }

    /// Return the momenta ``(p_q, p_qdot)`` of a curve from its coordinate derivatives up to the third.
    ///
    /// All arrays have shape (..., d).
    ///
    /// Notes
    /// -----
    /// ``p_qdot = g (qddot + Gamma(qdot, qdot))`` and
    /// ``p_q[i] = 2 Gamma[k, i, j] qdot[j] p_qdot[k] - d/dt p_qdot[i]``.
    fn momenta<'py>(
        &self,
        q: &Any<'py>,
        qdot: &Any<'py>,
        qddot: &Any<'py>,
        qdddot: &Any<'py>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let (d, objects) = (self.d(), named![q, qdot, qddot, qdddot]);
        let joined = self.map_array(objects, d, &[2, d], |kind, [q, qdot, a, j], out, _| {
            on_chart!(kind, chart => {
                chart.check("q", q)?;
                check_finite("qdot", qdot)?;
                out.copy_from_slice(chart.momenta(q, qdot, a, j)?.as_slice());
            });
            Ok(())
        })?;
        split(joined, 1, objects)
    }

    /// Return the coordinate derivatives ``(q, qdot, qddot, qdddot)`` of a state, each of shape (..., d).
    fn derivatives<'py>(&self, z: &Any<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let joined = self.map_state_array(z, &[4, self.d()], |kind, z, out| {
            on_chart!(kind, chart => out.copy_from_slice(chart.derivatives(&state(z)).as_slice()));
            Ok(())
        })?;
        split(joined, 1, named![z])
    }

    /// Return point, velocity, covariant acceleration and covariant jerk ``(S, V, A, J)`` of a state.
    ///
    /// The inverse of :meth:`state`. Shape (..., 4 d) -> four arrays of shape (..., 3, k).
    fn covariant<'py>(&self, z: &Any<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let core = [4, 3, self.0.columns()];
        let joined = self.map_state_array(z, &core, |kind, z, out| {
            let data = on_chart!(kind, chart => covariant_from_state(chart, &state(z)))?;
            let parts = [&data.point, &data.velocity, &data.acceleration, &data.jerk];
            let size = out.len() / parts.len();
            for (part, target) in parts.into_iter().zip(out.chunks_mut(size)) {
                write(part.as_ref(), target);
            }
            Ok(())
        })?;
        split(joined, 2, named![z])
    }

    /// Evaluate the Hamiltonian, shape (..., 4 d) -> (...).
    fn hamiltonian(&self, z: &Any) -> PyResult<Numbers> {
        self.map_states(z, &[], |kind, z, out| {
            out[0] = on_chart!(kind, chart => chart.hamiltonian(&state(z)));
            Ok(())
        })
    }

    /// Evaluate the exact gradient of the Hamiltonian, shape (..., 4 d).
    fn gradient(&self, z: &Any) -> PyResult<Numbers> {
        self.map_states(z, &[self.0.width()], |kind, z, out| {
            on_chart!(kind, chart => out.copy_from_slice(chart.gradient(&state(z)).as_slice()));
            Ok(())
        })
    }

    /// Evaluate the exact Hessian of the Hamiltonian, shape (..., 4 d, 4 d).
    fn hessian(&self, z: &Any) -> PyResult<Numbers> {
        self.map_states(z, &[self.0.width(); 2], |kind, z, out| {
            on_chart!(kind, chart => out.copy_from_slice(chart.hessian(&state(z)).as_slice()));
            Ok(())
        })
    }
}

/// Splits an array along the axis before the last `axes` ones into separate arrays, in the library of the arguments.
fn split<'py, const N: usize>(
    joined: Array,
    axes: isize,
    arguments: [Named<'_, 'py>; N],
) -> PyResult<Bound<'py, PyTuple>> {
    let (py, namespace) = (arguments[0].0.py(), Namespace::of(arguments)?);
    let parts = numpy(py)?.call_method1("moveaxis", (joined, -1 - axes, 0))?;
    let parts = parts.try_iter()?.map(|part| namespace.array(part?));
    PyTuple::new(py, parts.collect::<PyResult<Vec<_>>>()?)
}
