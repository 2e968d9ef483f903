//! The flows of the paper's charts for arrays: discrete, exact, and between two ends.

use pyo3::prelude::*;

use super::call::Call;
use super::chart::{Array, PyChart, count};
use super::convert::{Batch, map_batch, parameters, to_array, tuple, whole};
use super::discretization::NamedMap;
use super::error::invalid_input;
use super::shooting::{PyShootingResult, Shot};
use super::state::{Kind, check_finite, state, write_states};
use crate::chart::{Chart, DiscretizationMap, Frame, Sphere, integrate_composed, reference};
use crate::error::Result;
use crate::interrupt::Interrupt;

/// The two points of a discretization map for one member of a batch.
fn discretize<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    rows: [&[f64]; 2],
    out: &mut [f64],
) -> Result<()> {
    chart.check("x", rows[0])?;
    check_finite("v", rows[1])?;
    let points = map.map(&state(rows[0]), &state(rows[1]));
    write_states(&points, out);
    Ok(())
}

impl PyChart {
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
        let kind = self.kind();
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
    /// The two points of a discretization map of the tangent bundle.
    ///
    /// Parameters
    /// ----------
    /// x, v : array_like, shape (..., 2 d)
    ///     A position with its velocity, ``(q, qdot)``, and the vector ``(dq, dqdot)``.
    /// map : str, default "initial_point"
    ///     As for `integrate`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., 2, 2 d)
    ///     ``R_d(x, v) = (x_0, x_1)``.
    #[pyo3(signature = (x, v, map="initial_point"))]
    fn discretize<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        map: &str,
    ) -> PyResult<Array<'py>> {
        let map = NamedMap::read(py, map)?;
        let width = 2 * self.dimension();
        let batches = self.read([(x, "x"), (v, "v")], width)?;
        let call = Call::new(py, None, 1e3 * batches[0].len() as f64)?;
        let shape = [&batches[0].shape[..], &[2, width]].concat();
        let kind = self.kind();
        let member = move |batches: [&Batch; 2], i: usize, out: &mut [f64], _: Interrupt<'_>| {
            let rows = batches.map(|batch| batch.row(i));
            match kind {
                Kind::Sphere => discretize(&Sphere, &map, rows, out),
                Kind::Frame => discretize(&Frame, &map, rows, out),
            }
        };
        to_array(
            py,
            map_batch(py, &call, batches, 2 * width, member)?,
            &shape,
        )
    }

    /// The symplectic one-step method of a discretization map.
    ///
    /// ==========================  =========================================================================  =====
    /// map                         ``R_d(x, v)``, ``x = (q, qdot)``                                           order
    /// ==========================  =========================================================================  =====
    /// "initial_point"             ``(x, x + v)``                                                             1
    /// "midpoint"                  ``(x - v/2, x + v/2)``                                                     2
    /// "exponential"               ``(x, rho(x, v))``, ``rho`` the Riemannian exponential, lifted             1
    /// "exponential_midpoint"      ``(rho(x, -v/2), rho(x, v/2))``                                            2
    /// "cayley"                    with the Cayley retraction                                                 1
    /// "cayley_midpoint"           the same                                                                   2
    /// "quasi_geodesic"            with the paper's quasi-geodesics; on the sphere they are the geodesics     1
    /// "quasi_geodesic_midpoint"   the same                                                                   2
    /// ==========================  =========================================================================  =====
    ///
    /// The methods of a retraction commute with the rotations of space and keep the momentum of all three.
    ///
    /// Parameters
    /// ----------
    /// z0 : array_like, shape (..., 4 d)
    ///     Initial state.
    /// steps : int
    ///     Equal steps over ``[0, t_end]``, at least 1.
    /// t_end : float, default 1.0
    /// map : str, default "initial_point"
    ///     One of the table.
    /// order : int, optional
    ///     Order of the method: by default that of the map. 2, 4, 6 and 8 compose a step from 1, 5, 9 and 17 shorter
    ///     ones; with a map of order 1 each of them is a half step of its adjoint and a half step of itself.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., steps + 1, 4 d)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Not finite, ``steps < 1``, unknown map or order.
    /// OutsideDomainError
    ///     The trajectory leaves the chart; carries ``angle``.
    /// ConvergenceError
    ///     A step is too large for its implicit equations; carries ``report``.
    ///
    /// Notes
    /// -----
    /// arXiv 2404.19407, from the cotangent lift of the discretization map (Barbero-Linan, Martin de Diego 2023).
    #[pyo3(signature = (z0, steps, t_end=1.0, map="initial_point", *, order=None))]
    #[allow(clippy::too_many_arguments)]
    fn integrate<'py>(
        &self,
        py: Python<'py>,
        z0: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole)] steps: i64,
        t_end: f64,
        map: &str,
        order: Option<i64>,
    ) -> PyResult<Array<'py>> {
        let map = NamedMap::read(py, map)?;
        let composition = map.composition(py, order)?;
        let steps = count(py, "steps", steps, 1)?;
        self.flow(
            py,
            z0,
            &[steps.saturating_add(1)],
            1e4 * steps as f64,
            move |kind, row, out, interrupt| {
                match kind {
                    Kind::Sphere => write_states(
                        &integrate_composed(
                            &Sphere,
                            &map,
                            &composition,
                            &state(row),
                            steps,
                            t_end,
                            interrupt,
                        )?,
                        out,
                    ),
                    Kind::Frame => write_states(
                        &integrate_composed(
                            &Frame,
                            &map,
                            &composition,
                            &state(row),
                            steps,
                            t_end,
                            interrupt,
                        )?,
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
    /// map : str, default "midpoint"
    ///     As for `integrate`.
    /// t_end : float, default 1.0
    /// tol : float, default 1e-12
    ///     Euclidean norm of the end's defect.
    /// max_iterations : int, default 50
    ///     Newton steps.
    /// guess : pair of array_like, each of shape (d,), optional
    ///     Initial momenta ``(p_q, p_qdot)`` to start from.
    /// order : int, optional
    ///     As for `integrate`.
    ///
    /// Returns
    /// -------
    /// ShootingResult
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shapes, not finite, ``steps < 1``, unknown map or order, ``tol`` negative or not finite, ``t_end = 0``.
    /// OutsideDomainError
    ///     An end, or the trajectory that the iteration starts from, is outside of the chart; carries ``angle``.
    /// ConvergenceError
    ///     No trajectory found; carries ``report``. One step has none in general: the end point of a single step does
    ///     not depend on all of the momenta.
    ///
    /// Notes
    /// -----
    /// Damped Newton iteration on the initial momenta; the Jacobian is the exact derivative of the discrete flow.
    #[pyo3(signature = (q0, qdot0, q1, qdot1, steps, map="midpoint", *, t_end=1.0, tol=1e-12, max_iterations=50,
        guess=None, order=None))]
    #[allow(clippy::too_many_arguments)]
    fn shoot<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        qdot0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        qdot1: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = whole)] steps: i64,
        map: &str,
        t_end: f64,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        guess: Option<&Bound<'py, PyAny>>,
        order: Option<i64>,
    ) -> PyResult<PyShootingResult> {
        let map = NamedMap::read(py, map)?;
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
            map,
            composition: map.composition(py, order)?,
            t_end,
            tol,
            max_iterations: count(py, "max_iterations", max_iterations, 0)?,
            guess,
        };
        arguments.solve(py, self.kind())
    }
}
