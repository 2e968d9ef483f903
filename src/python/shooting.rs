//! Shooting in a chart: the arguments of one call, and its result.

use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::call::run;
use super::convert::to_array;
use super::discretization::NamedMap;
use super::error::PySolverReport;
use super::state::{Kind, check_finite, on_chart, state, write_states};
use crate::chart::{Chart, Composition, DiscretizationMap, ShootingOptions, shoot};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::newton::NewtonOptions;
use crate::report::SolverReport;

type Owned = Py<PyArrayDyn<f64>>;

/// A discrete trajectory that meets its boundary data.
///
/// Attributes
/// ----------
/// trajectory : ndarray, shape (steps + 1, 4 d)
///     The states.
/// momenta : tuple of ndarray, each of shape (d,)
///     The initial momenta ``(p_q, p_qdot)``.
/// report : SolverReport
#[pyclass(name = "ShootingResult", module = "stiefel_rs", frozen, get_all)]
pub struct PyShootingResult {
    trajectory: Owned,
    momenta: (Owned, Owned),
    report: PySolverReport,
}

#[pymethods]
impl PyShootingResult {
    fn __repr__(&self) -> String {
        format!("<ShootingResult {}>", self.report.0)
    }
}

/// The arguments of one shot.
pub struct Shot {
    pub ends: [Vec<f64>; 4],
    pub steps: usize,
    pub map: NamedMap,
    pub composition: Composition,
    pub t_end: f64,
    pub tol: f64,
    pub max_iterations: usize,
    pub guess: Option<Vec<f64>>,
}

/// States row by row, initial momenta, and how it ended.
type Found = (Vec<f64>, Vec<f64>, SolverReport);

impl Shot {
    /// Shoots, detached from the interpreter.
    pub fn solve(self, py: Python<'_>, kind: Kind) -> PyResult<PyShootingResult> {
        let steps = self.steps;
        let (trajectory, momenta, report) = run(
            py,
            1e6 * steps as f64,
            move |interrupt| on_chart!(kind, chart => self.run(chart, interrupt)),
        )?;
        let (p_q, p_qdot) = momenta.split_at(momenta.len() / 2);
        let shape = [steps + 1, 2 * momenta.len()];
        let vector =
            |entries: &[f64]| to_array(py, entries.to_vec(), &[entries.len()]).map(Bound::unbind);
        Ok(PyShootingResult {
            trajectory: to_array(py, trajectory, &shape)?.unbind(),
            momenta: (vector(p_q)?, vector(p_qdot)?),
            report: PySolverReport(report),
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
        let join = |q: &[f64], qdot: &[f64]| state::<X>(&[q, qdot].concat());
        let (x0, x1) = (
            join(&self.ends[0], &self.ends[1]),
            join(&self.ends[2], &self.ends[3]),
        );
        let newton = NewtonOptions {
            tolerance: self.tol,
            max_iterations: self.max_iterations,
            interrupt,
        };
        let guess = self.guess.as_ref().map(|guess| state::<X>(guess));
        let options = ShootingOptions {
            t_end: self.t_end,
            composition: self.composition,
            newton,
            guess,
        };
        let found = shoot(chart, &self.map, &x0, &x1, self.steps, &options)?;
        let mut trajectory = vec![0.0; found.trajectory.len() * Z];
        write_states(&found.trajectory, &mut trajectory);
        Ok((trajectory, found.momenta.as_slice().to_vec(), found.report))
    }
}
