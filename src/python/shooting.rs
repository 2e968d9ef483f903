//! Shooting in a chart: the arguments of one call, and its result.

use super::prelude::*;
use super::state::{Kind, check_finite, on_chart, state, write_states};
use super::steps::Steps;
use crate::chart::{Chart, DiscretizationMap, NamedMap, ShootingOptions, shoot};
use crate::newton::NewtonOptions;
use crate::report::SolverReport;

/// A discrete trajectory that meets its boundary data.
///
/// Attributes
/// ----------
/// trajectory : ndarray, shape (steps + 1, 4 d)
///     The states.
/// momenta : tuple of ndarray, each of shape (d,)
///     The initial momenta ``(p_q, p_qdot)``.
/// report : SolverReport
#[pyclass(name = "ShootingResult", module = "stiefel_rs", frozen)]
pub struct PyShootingResult {
    #[pyo3(get)]
    trajectory: Owned,
    #[pyo3(get)]
    momenta: (Owned, Owned),
    #[pyo3(get)]
    report: PySolverReport,
    /// The report in words.
    text: String,
}

#[pymethods]
impl PyShootingResult {
    fn __repr__(&self) -> String {
        format!("<ShootingResult {}>", self.text)
    }
}

/// The arguments of one shot.
pub struct Shot {
    pub ends: [Vec<f64>; 4],
    pub steps: Steps,
    pub tol: f64,
    pub max_iterations: usize,
    pub guess: Option<Vec<f64>>,
}

/// States row by row, initial momenta, and how it ended.
type Found = (Vec<f64>, Vec<f64>, SolverReport);

impl Shot {
    /// Shoots, detached from the interpreter.
    pub fn solve(self, py: Python<'_>, kind: Kind) -> PyResult<PyShootingResult> {
        let steps = self.steps.count;
        let (trajectory, momenta, report) = run(
            py,
            SOLVES * steps as f64,
            move |interrupt| on_chart!(kind, chart => self.run(chart, interrupt)),
        )?;
        let (p_q, p_qdot) = momenta.split_at(momenta.len() / 2);
        let shape = [steps + 1, 2 * momenta.len()];
        let vector = |numbers: &[f64]| Array::flat(numbers.to_vec()).into_pyobject(py);
        Ok(PyShootingResult {
            trajectory: to_array(py, trajectory, &shape)?.unbind(),
            momenta: (vector(p_q)?.unbind(), vector(p_qdot)?.unbind()),
            text: report.to_string(),
            report: report.into(),
        })
    }

    fn run<const X: usize, const Z: usize>(
        &self,
        chart: &impl Chart<X, Z>,
        interrupt: Interrupt<'_>,
    ) -> Result<Found>
    where
        NamedMap: DiscretizationMap<X>,
    {
        for (name, q) in [("q0", &self.ends[0]), ("q1", &self.ends[2])] {
            chart.check(name, q)?;
        }
        for (name, qdot) in [("qdot0", &self.ends[1]), ("qdot1", &self.ends[3])] {
            check_finite(name, qdot)?;
        }
        let [x0, x1] = [0, 2].map(|i| state::<X>(&self.ends[i..i + 2].concat()));
        let newton = NewtonOptions {
            tolerance: self.tol,
            max_iterations: self.max_iterations,
            interrupt,
        };
        let Shot { steps, .. } = self;
        let options = ShootingOptions {
            t_end: steps.t_end,
            composition: steps.composition,
            newton,
            guess: self.guess.as_ref().map(|guess| state::<X>(guess)),
        };
        let found = shoot(chart, &steps.map, &x0, &x1, steps.count, &options)?;
        let mut trajectory = vec![0.0; found.trajectory.len() * Z];
        write_states(&found.trajectory, &mut trajectory);
        Ok((trajectory, found.momenta.as_slice().to_vec(), found.report))
    }
}
