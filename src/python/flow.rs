//! The flows of the paper's charts for arrays: discrete, exact, and between two ends.

use super::chart::PyChart;
use super::prelude::*;
use super::state::{ChartKind, Steps, check_finite, map_of, on_chart, state, write_states};
use crate::chart::{
    Chart, DiscretizationMap, NamedMap, ShootingOptions, integrate_composed, reference, shoot,
};
use crate::solve::newton::NewtonOptions;

#[pymethods]
impl PyChart {
    /// Evaluate a discretization map of the tangent bundle: two points for each vector.
    ///
    /// Parameters
    /// ----------
    /// x, v : array_like, shape (..., 2 d)
    ///     A position with its velocity, ``(q, qdot)``, and a vector ``(dq, dqdot)`` at it.
    /// map : str, default "initial_point"
    ///     As for :meth:`integrate`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., 2, 2 d)
    ///     ``R_d(x, v) = (x_0, x_1)``.
    #[pyo3(signature = (x, v, map="initial_point"))]
    fn discretize(&self, x: &Any, v: &Any, map: &str) -> PyResult<Numbers> {
        let map = map_of(map)?;
        let (width, core) = (2 * self.d(), [2, 2 * self.d()]);
        self.map(named![x, v], width, &core, move |kind, [x, v], out, _| {
            on_chart!(kind, chart => chart.check("x", x))?;
            check_finite("v", v)?;
            match kind {
                ChartKind::Sphere => write_states::<4>(&map.map(&state(x), &state(v)), out),
                ChartKind::Frame => write_states::<6>(&map.map(&state(x), &state(v)), out),
            }
            Ok(())
        })
    }

    /// Integrate by the symplectic one-step method of a discretization map.
    ///
    /// ==========================  =========================================================================  =====
    /// map                         ``R_d(x, v)``, ``x = (q, qdot)``                                           order
    /// ==========================  =========================================================================  =====
    /// "initial_point"             ``(x, x + v)``                                                             1
    /// "midpoint"                  ``(x - v/2, x + v/2)``                                                     2
    /// "exponential"               ``(x, rho(x, v))``, ``rho`` the Riemannian exponential, lifted             1
    /// "exponential_midpoint"      ``(rho(x, -v/2), rho(x, v/2))``                                            2
    /// "cayley"                    as "exponential", with the Cayley retraction                               1
    /// "cayley_midpoint"           as "exponential_midpoint", with the Cayley retraction                      2
    /// "quasi_geodesic"            as "exponential", with quasi-geodesics; the same on the sphere             1
    /// "quasi_geodesic_midpoint"   as "exponential_midpoint", with quasi-geodesics; the same on the sphere    2
    /// ==========================  =========================================================================  =====
    ///
    /// The maps of a retraction (all but the first two) commute with rotations of space, so that all three components
    /// of the momentum are conserved.
    ///
    /// Parameters
    /// ----------
    /// z0 : array_like, shape (..., 4 d)
    ///     Initial state.
    /// steps : int
    ///     Number of equal steps over ``[0, t_end]``, at least 1.
    /// t_end : float, default 1.0
    ///     End time.
    /// map : str, default "initial_point"
    ///     A map from the table.
    /// order : int, optional
    ///     Order of the method; by default the order of the map. Orders 2, 4, 6 and 8 compose each step of 1, 5, 9 and
    ///     17 shorter ones; with a map of order 1 each shorter step is a half step of the adjoint method followed by a
    ///     half step of the method.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., steps + 1, 4 d)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Non-finite entries, ``steps < 1``, unknown map or order.
    /// OutsideDomainError
    ///     The trajectory leaves the chart; carries ``angle``.
    /// ConvergenceError
    ///     A step is too long for its implicit equations to be solved; carries ``report``.
    ///
    /// Notes
    /// -----
    /// arXiv 2404.19407, by the cotangent lift of the discretization map (Barbero-Linan, Martin de Diego 2023).
    #[pyo3(signature = (z0, steps, t_end=1.0, map="initial_point", *, order=None))]
    fn integrate(
        &self,
        z0: &Any,
        #[pyo3(from_py_with = whole)] steps: i64,
        t_end: f64,
        map: &str,
        order: Option<i64>,
    ) -> PyResult<Numbers> {
        let steps = Steps::read(map, order, steps, t_end)?;
        let width = self.0.width();
        let core = [steps.count.saturating_add(1), width];
        self.map(named![z0], width, &core, move |kind, [z], out, stop| {
            on_chart!(kind, chart => {
                let (s, z) = (&steps, state(z));
                let states =
                    integrate_composed(chart, &s.map, &s.composition, &z, s.count, s.t_end, stop)?;
                write_states(&states, out);
            });
            Ok(())
        })
    }

    /// Evaluate the exact flow: states at the times ``t``, from ``z0`` at time 0.
    ///
    /// Parameters
    /// ----------
    /// z0 : array_like, shape (..., 4 d)
    ///     State at time 0.
    /// t : array_like, shape T
    ///     Finite times in any order.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (...,) + T + (4 d,)
    ///     States with an error of at most 1e-13, for curves of the size of those in the paper.
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
    fn reference(&self, z0: &Any, t: &Any) -> PyResult<Numbers> {
        let (t, width) = (read(t, "t")?, self.0.width());
        let core = [&t.shape[..], &[width]].concat();
        self.map(named![z0], width, &core, move |kind, [z], out, stop| {
            on_chart!(kind, chart => {
                write_states(&reference(chart, &state(z), &t.entries, stop)?, out);
            });
            Ok(())
        })
    }

    /// Find the discrete trajectory with given ends by shooting.
    ///
    /// Parameters
    /// ----------
    /// q0, qdot0, q1, qdot1 : array_like, shape (d,)
    ///     Coordinates and velocities at time 0 and ``t_end``. Angles are not wrapped: pass the intended branch.
    /// steps : int
    ///     Number of equal steps, at least 1.
    /// map : str, default "midpoint"
    ///     As for :meth:`integrate`.
    /// t_end : float, default 1.0
    ///     End time.
    /// tol : float, default 1e-12
    ///     Largest Euclidean norm of the error at the end.
    /// max_iterations : int, default 50
    ///     Largest number of Newton steps.
    /// guess : pair of array_like, each of shape (d,), optional
    ///     Initial momenta ``(p_q, p_qdot)`` to start from.
    /// order : int, optional
    ///     As for :meth:`integrate`.
    ///
    /// Returns
    /// -------
    /// ShootingResult
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shapes, non-finite entries, ``steps < 1``, unknown map or order, ``tol`` negative or not finite,
    ///     ``t_end = 0``.
    /// OutsideDomainError
    ///     An end, or the trajectory of the initial guess, is outside the chart; carries ``angle``.
    /// ConvergenceError
    ///     No trajectory was found; carries ``report``. In general none exists for ``steps = 1``, because the end point
    ///     of a single step does not depend on all of the momenta.
    ///
    /// Notes
    /// -----
    /// Damped Newton iteration on the initial momenta, with the exact derivative of the discrete flow as Jacobian.
    #[pyo3(signature = (q0, qdot0, q1, qdot1, steps, map="midpoint", *, t_end=1.0, tol=1e-12, max_iterations=50,
        guess=None, order=None))]
    fn shoot(
        &self,
        q0: &Any,
        qdot0: &Any,
        q1: &Any,
        qdot1: &Any,
        #[pyo3(from_py_with = whole)] steps: i64,
        map: &str,
        t_end: f64,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        guess: Option<&Any>,
        order: Option<i64>,
    ) -> PyResult<PyShootingResult> {
        let steps = Steps::read(map, order, steps, t_end)?;
        let ends = self.read(named![q0, qdot0, q1, qdot1], self.d())?;
        if !ends[0].shape.is_empty() {
            let found = [&ends[0].shape[..], &[ends[0].rows]].concat();
            return Err(unexpected("q0", &tuple(&[self.d()]), &found));
        }
        let guess = guess.map(|pair| self.read_guess(pair)).transpose()?;
        let arguments = Shot {
            ends: ends.each_ref().map(|end| end.row(0).to_vec()),
            steps,
            tol,
            max_iterations: count("max_iterations", max_iterations, 0)?,
            guess,
        };
        arguments.solve(q0.py(), self.0)
    }
}

/// Discrete trajectory with given ends, found by :meth:`Chart.shoot`.
#[pyclass(name = "ShootingResult", module = "stiefel_rs", frozen)]
pub struct PyShootingResult {
    /// States, shape (steps + 1, 4 d).
    #[pyo3(get)]
    trajectory: Owned,
    /// Initial momenta ``(p_q, p_qdot)``, each of shape (d,).
    #[pyo3(get)]
    momenta: (Owned, Owned),
    /// Outcome of the solver.
    #[pyo3(get)]
    report: PySolverReport,
    /// The report as text.
    text: String,
}

#[pymethods]
impl PyShootingResult {
    fn __repr__(&self) -> String {
        format!("<ShootingResult {}>", self.text)
    }
}

/// Arguments of a shooting problem.
struct Shot {
    ends: [Vec<f64>; 4],
    steps: Steps,
    tol: f64,
    max_iterations: usize,
    guess: Option<Vec<f64>>,
}

/// States row by row, initial momenta, and report.
type FoundTrajectory = (Vec<f64>, Vec<f64>, SolverReport);

impl Shot {
    /// Solves without the interpreter.
    fn solve(self, py: Python<'_>, kind: ChartKind) -> PyResult<PyShootingResult> {
        let steps = self.steps.count;
        let work =
            move |interrupt: Interrupt<'_>| on_chart!(kind, chart => self.run(chart, interrupt));
        let (trajectory, momenta, report) = run(py, Field::Real, SOLVES * steps as f64, work)?;
        let (p_q, p_qdot) = momenta.split_at(momenta.len() / 2);
        let shape = [steps + 1, 2 * momenta.len()];
        let vector = |numbers: &[f64]| Array::flat(numbers.to_vec()).into_pyobject(py);
        Ok(PyShootingResult {
            trajectory: to_array(py, trajectory, &shape)?.into_any().unbind(),
            momenta: (
                vector(p_q)?.into_any().unbind(),
                vector(p_qdot)?.into_any().unbind(),
            ),
            text: report.to_string(),
            report: report.into(),
        })
    }

    fn run<const X: usize, const Z: usize>(
        &self,
        chart: &impl Chart<X, Z>,
        interrupt: Interrupt<'_>,
    ) -> Result<FoundTrajectory>
    where
        NamedMap: DiscretizationMap<X>,
    {
        let [q0, qdot0, q1, qdot1] = &self.ends;
        chart.check("q0", q0)?;
        chart.check("q1", q1)?;
        check_finite("qdot0", qdot0)?;
        check_finite("qdot1", qdot1)?;
        let [x0, x1] = [0, 2].map(|i| state::<X>(&self.ends[i..i + 2].concat()));
        let newton = NewtonOptions {
            tolerance: self.tol,
            max_iterations: self.max_iterations,
        };
        let Shot { steps, .. } = self;
        let options = ShootingOptions {
            t_end: steps.t_end,
            composition: steps.composition,
            newton,
            guess: self.guess.as_ref().map(|guess| state::<X>(guess)),
        };
        let found = shoot(
            chart,
            &steps.map,
            &x0,
            &x1,
            steps.count,
            &options,
            interrupt,
        )?;
        let mut trajectory = vec![0.0; found.trajectory.len() * Z];
        write_states(&found.trajectory, &mut trajectory);
        Ok((trajectory, found.momenta.as_slice().to_vec(), found.report))
    }
}
