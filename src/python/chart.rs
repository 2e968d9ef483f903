//! The paper's charts for arrays.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyEllipsis, PySlice, PyTuple};

use super::call::Call;
use super::convert::{Batch, map_batch, parameters, to_array, tuple, vectors, write};
use super::error::invalid_input;
use super::shooting::{PyShootingResult, Shot};
use super::state::{Kind, check_finite, state, write_states};
use crate::chart::{Chart, Frame, LinearMap, Sphere, integrate, reference};
use crate::error::Result;
use crate::interrupt::Interrupt;

type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

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

fn discretization_map(py: Python<'_>, name: &str) -> PyResult<LinearMap> {
    match name {
        "initial_point" => Ok(LinearMap::INITIAL_POINT),
        "midpoint" => Ok(LinearMap::MIDPOINT),
        _ => Err(invalid_input(
            py,
            format!("map: must be 'initial_point' or 'midpoint', found '{name}'"),
        )),
    }
}

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
    fn dimension(&self) -> usize {
        match self.0 {
            Kind::Sphere => 2,
            Kind::Frame => 3,
        }
    }

    fn columns(&self) -> usize {
        match self.0 {
            Kind::Sphere => 1,
            Kind::Frame => 2,
        }
    }

    /// Reads batches of vectors of the given length.
    fn read<const N: usize>(
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
    fn read_guess(&self, pair: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
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

    /// Maps every initial state to `states` states.
    fn flow<'py>(
        &self,
        py: Python<'py>,
        z0: &Bound<'py, PyAny>,
        states: &[usize],
        operations: f64,
        member: impl Fn(Kind, &[f64], &mut [f64], Interrupt<'_>) -> Result<()> + Sync + Send + 'static,
    ) -> PyResult<Array<'py>> {
        let width = 4 * self.dimension();
        let batches = self.read([(z0, "z0")], width)?;
        let len = states
            .iter()
            .fold(1_usize, |product, count| product.saturating_mul(*count));
        let call = Call::new(py, None, operations * batches[0].len() as f64)?;
        let shape: Vec<usize> = batches[0]
            .shape
            .iter()
            .chain(states)
            .chain(&[width])
            .copied()
            .collect();
        let kind = self.0;
        let wrapped =
            move |[batch]: [&Batch; 1], i: usize, out: &mut [f64], interrupt: Interrupt<'_>| {
                member(kind, batch.row(i), out, interrupt)
            };
        to_array(
            py,
            map_batch(py, &call, batches, len.saturating_mul(width), wrapped)?,
            &shape,
        )
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

    /// The symplectic one-step method of a discretization map.
    ///
    /// Parameters
    /// ----------
    /// z0 : array_like, shape (..., 4 d)
    ///     Initial state.
    /// steps : int
    ///     Equal steps over ``[0, t_end]``, at least 1.
    /// t_end : float, default 1.0
    /// map : {"initial_point", "midpoint"}
    ///     Order 1 or 2.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., steps + 1, 4 d)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Not finite, ``steps < 1``, unknown map.
    /// OutsideDomainError
    ///     The trajectory leaves the chart; carries ``angle``.
    /// ConvergenceError
    ///     A step is too large for its implicit equations; carries ``report``.
    ///
    /// Notes
    /// -----
    /// arXiv 2404.19407, from the cotangent lift of the discretization map (Barbero-Linan, Martin de Diego 2023).
    #[pyo3(signature = (z0, steps, t_end=1.0, map="initial_point"))]
    fn integrate<'py>(
        &self,
        py: Python<'py>,
        z0: &Bound<'py, PyAny>,
        steps: i64,
        t_end: f64,
        map: &str,
    ) -> PyResult<Array<'py>> {
        let map = discretization_map(py, map)?;
        let steps = count(py, "steps", steps, 1)?;
        self.flow(
            py,
            z0,
            &[steps.saturating_add(1)],
            1e4 * steps as f64,
            move |kind, row, out, interrupt| {
                match kind {
                    Kind::Sphere => write_states(
                        &integrate(&Sphere, &map, &state(row), steps, t_end, interrupt)?,
                        out,
                    ),
                    Kind::Frame => write_states(
                        &integrate(&Frame, &map, &state(row), steps, t_end, interrupt)?,
                        out,
                    ),
                }
                Ok(())
            },
        )
    }

    /// The exact flow: states at the times ``t``, from ``z0`` at time 0.
    ///
    /// Parameters
    /// ----------
    /// z0 : array_like, shape (..., 4 d)
    /// t : array_like, shape T
    ///     Finite times in any order.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (...,) + T + (4 d,)
    ///     Error at most 1e-13 for curves of the size of the paper's.
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     The curve leaves the chart; carries ``angle``.
    /// ConvergenceError
    ///     Too many steps; carries ``report``.
    ///
    /// Notes
    /// -----
    /// Taylor method of order 26 with variable steps (Jorba, Zou 2005).
    fn reference<'py>(
        &self,
        py: Python<'py>,
        z0: &Bound<'py, PyAny>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let (shape, t) = parameters(t, "t")?;
        // How many steps it takes shows only on the way: always watched.
        self.flow(
            py,
            z0,
            &shape,
            f64::INFINITY,
            move |kind, row, out, interrupt| {
                match kind {
                    Kind::Sphere => {
                        write_states(&reference(&Sphere, &state(row), &t, interrupt)?, out)
                    }
                    Kind::Frame => {
                        write_states(&reference(&Frame, &state(row), &t, interrupt)?, out)
                    }
                }
                Ok(())
            },
        )
    }

    /// Shooting: the discrete trajectory with given ends.
    ///
    /// Parameters
    /// ----------
    /// q0, qdot0, q1, qdot1 : array_like, shape (d,)
    ///     Coordinates and velocities at time 0 and ``t_end``. Angles are not wrapped: give the branch that is meant.
    /// steps : int
    ///     At least 1.
    /// map : {"initial_point", "midpoint"}
    /// t_end : float, default 1.0
    /// tol : float, default 1e-12
    ///     Euclidean norm of the end's defect.
    /// max_iterations : int, default 50
    ///     Newton steps.
    /// guess : pair of array_like, each of shape (d,), optional
    ///     Initial momenta ``(p_q, p_qdot)`` to start from.
    ///
    /// Returns
    /// -------
    /// ShootingResult
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shapes, not finite, ``steps < 1``, unknown map, ``tol`` negative or not finite, ``t_end = 0``.
    /// OutsideDomainError
    ///     An end, or the trajectory that the iteration starts from, is outside of the chart; carries ``angle``.
    /// ConvergenceError
    ///     No trajectory found; carries ``report``. One step has none in general: the end point of a single step does
    ///     not depend on all of the momenta.
    ///
    /// Notes
    /// -----
    /// Damped Newton iteration on the initial momenta; the Jacobian is the exact derivative of the discrete flow.
    #[pyo3(signature = (q0, qdot0, q1, qdot1, steps, map="midpoint", *, t_end=1.0, tol=1e-12, max_iterations=50, guess=None))]
    #[allow(clippy::too_many_arguments)]
    fn shoot<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        qdot0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        qdot1: &Bound<'py, PyAny>,
        steps: i64,
        map: &str,
        t_end: f64,
        tol: f64,
        max_iterations: i64,
        guess: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<PyShootingResult> {
        let objects = [(q0, "q0"), (qdot0, "qdot0"), (q1, "q1"), (qdot1, "qdot1")];
        let ends = self.read(objects, self.dimension())?;
        if !ends[0].shape.is_empty() {
            let found = tuple(&[&ends[0].shape[..], &[ends[0].rows]].concat());
            return Err(invalid_input(
                py,
                format!("q0: expected shape ({},), found {found}", self.dimension()),
            ));
        }
        let guess = guess.map(|pair| self.read_guess(pair)).transpose()?;
        let arguments = Shot {
            ends: ends.each_ref().map(|end| end.row(0).to_vec()),
            steps: count(py, "steps", steps, 1)?,
            map: discretization_map(py, map)?,
            t_end,
            tol,
            max_iterations: count(py, "max_iterations", max_iterations, 0)?,
            guess,
        };
        arguments.solve(py, self.0)
    }
}

/// The rows of the last but one axis as separate arrays.
fn split<'py>(py: Python<'py>, joined: &Array<'py>, parts: usize) -> PyResult<Bound<'py, PyTuple>> {
    let everything = PySlice::full(py);
    let row = |i: usize| joined.get_item((PyEllipsis::get(py), i, &everything));
    PyTuple::new(py, (0..parts).map(row).collect::<PyResult<Vec<_>>>()?)
}
