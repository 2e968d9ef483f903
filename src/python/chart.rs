//! The paper's charts for arrays.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyEllipsis, PySlice, PyTuple};

use super::call::Call;
use super::convert::{Batch, map_batch, to_array, vectors, write};
use super::error::invalid_input;
use super::state::{Kind, check_finite, state};
use crate::chart::{Chart, Frame, Sphere, covariant_from_state};
use crate::error::Result;
use crate::interrupt::Interrupt;

pub type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// A chart of the paper: ``Chart.sphere()`` for St(3,1), ``Chart.frame()`` for St(3,2).
///
/// Coordinates ``q`` have ``d`` entries: ``(theta, phi)`` or ``(theta, phi, psi)``, radians, ``0 < theta < pi``. A
/// state is ``z = (q, qdot, p_q, p_qdot)``, shape ``(..., 4 d)``; leading axes are batches and broadcast.
///
/// Notes
/// -----
/// arXiv 2404.19407, sections on St(3,1) and St(3,2). The Hamiltonian of the frame chart follows from
/// the canonical metric; unlike the paper's longer form it does not divide by ``cos(theta)``.
///
/// Examples
/// --------
/// The paper's curve on the sphere, and its end after 100 mid-point steps:
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
pub struct PyChart(Kind);

/// An integer argument of at least `least`.
pub(super) fn count(py: Python<'_>, name: &str, value: i64, least: i64) -> PyResult<usize> {
    match usize::try_from(value) {
        Ok(count) if value >= least => Ok(count),
        _ => Err(invalid_input(
            py,
            format!("{name}: must be at least {least}, found {value}"),
        )),
    }
}

/// Answers a query for one member of a batch.
fn evaluate<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    query: Query,
    rows: &[&[f64]],
    out: &mut [f64],
) -> Result<()> {
    // A query on coordinates alone is checked like a state at rest.
    chart.check(query.argument(), rows[0])?;
    match query {
        Query::Embed => write(chart.embed(rows[0])?.as_ref(), out),
        Query::EmbedVelocity => {
            check_finite("qdot", rows[1])?;
            write(chart.embed_velocity(rows[0], rows[1])?.as_ref(), out);
        }
        Query::Momenta => {
            check_finite("qdot", rows[1])?;
            out.copy_from_slice(
                chart
                    .momenta(rows[0], rows[1], rows[2], rows[3])?
                    .as_slice(),
            );
        }
        Query::Derivatives => out.copy_from_slice(chart.derivatives(&state(rows[0])).as_slice()),
        Query::Covariant => {
            let data = covariant_from_state(chart, &state(rows[0]))?;
            let parts = [&data.point, &data.velocity, &data.acceleration, &data.jerk];
            let size = out.len() / parts.len();
            for (part, target) in parts.into_iter().zip(out.chunks_mut(size)) {
                write(part.as_ref(), target);
            }
        }
        Query::Hamiltonian => out[0] = chart.hamiltonian(&state(rows[0])),
        Query::Gradient => out.copy_from_slice(chart.gradient(&state(rows[0])).as_slice()),
        Query::Hessian => out.copy_from_slice(chart.hessian(&state(rows[0])).as_slice()),
    }
    Ok(())
}

#[derive(Clone, Copy)]
enum Query {
    Embed,
    EmbedVelocity,
    Momenta,
    Derivatives,
    Covariant,
    Hamiltonian,
    Gradient,
    Hessian,
}

impl Query {
    fn argument(self) -> &'static str {
        match self {
            Query::Embed | Query::EmbedVelocity | Query::Momenta => "q",
            _ => "z",
        }
    }
}

impl PyChart {
    /// Which chart.
    pub(super) fn kind(&self) -> Kind {
        self.0
    }

    pub(super) fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn columns(&self) -> usize {
        self.0.columns()
    }

    /// Reads batches of vectors of the given length.
    pub(super) fn read<const N: usize>(
        &self,
        objects: [(&Bound<'_, PyAny>, &'static str); N],
        length: usize,
    ) -> PyResult<[Batch; N]> {
        let batches = vectors(objects)?;
        for (batch, (object, name)) in batches.iter().zip(objects) {
            if batch.rows != length {
                let found = batch.rows;
                let message =
                    format!("{name}: expected shape (..., {length}), found (..., {found})");
                return Err(invalid_input(object.py(), message));
            }
        }
        Ok(batches)
    }

    /// A pair of momenta `(p_q, p_qdot)`, joined.
    pub(super) fn read_guess(&self, pair: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
        let momenta = pair.try_iter()?.collect::<PyResult<Vec<_>>>()?;
        if let [p_q, p_qdot] = &momenta[..] {
            let [p_q, p_qdot] = self.read([(p_q, "guess"), (p_qdot, "guess")], self.dimension())?;
            if p_q.shape.is_empty() {
                return Ok([p_q.row(0), p_qdot.row(0)].concat());
            }
        }
        let message = format!(
            "guess: expected two arrays of shape ({},)",
            self.dimension()
        );
        Err(invalid_input(pair.py(), message))
    }

    /// Answers a query for every member; the result has the trailing shape `core`.
    fn query<'py, const N: usize>(
        &self,
        py: Python<'py>,
        query: Query,
        objects: [(&Bound<'py, PyAny>, &'static str); N],
        length: usize,
        core: &[usize],
    ) -> PyResult<Array<'py>> {
        let batches = self.read(objects, length)?;
        let call = Call::new(py, None, 1e3 * batches[0].len() as f64)?;
        let shape: Vec<usize> = batches[0].shape.iter().chain(core).copied().collect();
        let kind = self.0;
        let member = move |batches: [&Batch; N], i: usize, out: &mut [f64], _: Interrupt<'_>| {
            let rows = batches.map(|batch| batch.row(i));
            match kind {
                Kind::Sphere => evaluate(&Sphere, query, &rows, out),
                Kind::Frame => evaluate(&Frame, query, &rows, out),
            }
        };
        to_array(
            py,
            map_batch(py, &call, batches, core.iter().product(), member)?,
            &shape,
        )
    }

    fn state_query<'py>(
        &self,
        py: Python<'py>,
        query: Query,
        z: &Bound<'py, PyAny>,
        core: &[usize],
    ) -> PyResult<Array<'py>> {
        self.query(py, query, [(z, "z")], 4 * self.dimension(), core)
    }

    /// Point, velocity, covariant acceleration and covariant jerk of states.
    pub(super) fn covariant_parts<'py>(
        &self,
        py: Python<'py>,
        z: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let columns = self.columns();
        let joined = self.state_query(py, Query::Covariant, z, &[4, 3 * columns])?;
        let parts = split(py, &joined, 4)?;
        let reshape = |part: Bound<'py, PyAny>| {
            let shape: Vec<usize> = part.getattr("shape")?.extract()?;
            let lead = &shape[..shape.len() - 1];
            part.call_method1(
                "reshape",
                (PyTuple::new(py, [lead, &[3, columns]].concat())?,),
            )
        };
        PyTuple::new(py, parts.iter().map(reshape).collect::<PyResult<Vec<_>>>()?)
    }
}

#[pymethods]
impl PyChart {
    /// The sphere St(3,1): ``(theta, phi)``, metric ``diag(1, sin(theta)^2)``.
    #[staticmethod]
    fn sphere() -> Self {
        PyChart(Kind::Sphere)
    }

    /// The 2-frames St(3,2): ``(theta, phi, psi)``, the canonical metric
    /// ``dtheta^2 + dphi^2 + dpsi^2 + 2 cos(theta) dphi dpsi``.
    #[staticmethod]
    fn frame() -> Self {
        PyChart(Kind::Frame)
    }

    /// Dimension of the chart, 2 or 3.
    #[getter]
    fn d(&self) -> usize {
        self.dimension()
    }

    /// Columns of an embedded point, 1 or 2.
    #[getter]
    fn k(&self) -> usize {
        self.columns()
    }

    fn __repr__(&self) -> &'static str {
        match self.0 {
            Kind::Sphere => "Chart.sphere()",
            Kind::Frame => "Chart.frame()",
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let name = if slf.get().0 == Kind::Sphere {
            "sphere"
        } else {
            "frame"
        };
        Ok((slf.get_type().getattr(name)?, ()))
    }

    /// The point of coordinates ``q``, shape (..., d) -> (..., 3, k).
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     Unless ``0 < theta < pi``; carries ``angle``. The same holds for every method.
    fn embed<'py>(&self, py: Python<'py>, q: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        self.query(
            py,
            Query::Embed,
            [(q, "q")],
            self.dimension(),
            &[3, self.columns()],
        )
    }

    /// The velocity of coordinates ``q``, ``qdot``, shapes (..., d) -> (..., 3, k).
    fn embed_velocity<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qdot: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let objects = [(q, "q"), (qdot, "qdot")];
        self.query(
            py,
            Query::EmbedVelocity,
            objects,
            self.dimension(),
            &[3, self.columns()],
        )
    }

    /// Momenta ``(p_q, p_qdot)`` of a curve from its coordinate derivatives up to the third, all of shape (..., d).
    ///
    /// Notes
    /// -----
    /// ``p_qdot = g (qddot + Gamma(qdot, qdot))`` and
    /// ``p_q[i] = 2 Gamma[k, i, j] qdot[j] p_qdot[k] - d/dt p_qdot[i]``.
    fn momenta<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qdot: &Bound<'py, PyAny>,
        qddot: &Bound<'py, PyAny>,
        qdddot: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let objects = [
            (q, "q"),
            (qdot, "qdot"),
            (qddot, "qddot"),
            (qdddot, "qdddot"),
        ];
        let joined = self.query(
            py,
            Query::Momenta,
            objects,
            self.dimension(),
            &[2, self.dimension()],
        )?;
        split(py, &joined, 2)
    }

    /// Coordinate derivatives ``(q, qdot, qddot, qdddot)`` of the curve through a state, each of shape (..., d).
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        z: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let joined = self.state_query(py, Query::Derivatives, z, &[4, self.dimension()])?;
        split(py, &joined, 4)
    }

    /// The Hamiltonian, shape (..., 4 d) -> (...).
    fn hamiltonian<'py>(
        &self,
        py: Python<'py>,
        z: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let values = self.state_query(py, Query::Hamiltonian, z, &[1])?;
        values.get_item((PyEllipsis::get(py), 0))
    }

    /// The exact gradient of the Hamiltonian, shape (..., 4 d).
    fn gradient<'py>(&self, py: Python<'py>, z: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        self.state_query(py, Query::Gradient, z, &[4 * self.dimension()])
    }

    /// The exact Hessian of the Hamiltonian, shape (..., 4 d, 4 d).
    fn hessian<'py>(&self, py: Python<'py>, z: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let width = 4 * self.dimension();
        self.state_query(py, Query::Hessian, z, &[width, width])
    }
}

/// The rows of the last but one axis as separate arrays.
fn split<'py>(py: Python<'py>, joined: &Array<'py>, parts: usize) -> PyResult<Bound<'py, PyTuple>> {
    let everything = PySlice::full(py);
    let row = |i: usize| joined.get_item((PyEllipsis::get(py), i, &everything));
    PyTuple::new(py, (0..parts).map(row).collect::<PyResult<Vec<_>>>()?)
}
