//! Boundary value problems in few dimensions, whose solution is one Taylor series about its middle.

use super::at_nodes::boundary_data;
use super::guess::FlatData;
use super::problem::BoundaryProblem;
use super::solution::SolvedStart;
use super::solver::Solver;
use crate::collocation::{BoundaryData, BoundaryStart};
use crate::cubic::taylor::packing::pack;
use crate::error::Result;
use crate::shooting::{EndData, lone_leg};

/// Maximal number of steps; most solved problems take five to nine. With 11, groups of eight miss 3 instead of 0.4 % of
/// the problems with distance and speeds up to 2 on St(3,1), which then take four times as long.
pub(crate) const STEPS: usize = 20;

impl Solver<'_> {
    /// The solution found with one series from the cubic of flat space, or by Newton's method at Gauss nodes from there, if
    /// one series is not accurate enough; `None` if there is none.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn by_one_series(&mut self, flat: &FlatData) -> Result<Option<SolvedStart>> {
        let problem = self.problem;
        let data = end_data(problem, flat);
        let steps = STEPS.min(self.options.max_iterations);
        let legs = lone_leg(problem.shape())(&[data], self.tolerance(), steps);
        let Some(leg) = legs.into_iter().flatten().next() else {
            return Ok(None);
        };
        self.count_steps(leg.steps);
        match self.integrated(&leg.start)? {
            None => self.at_nodes(&leg.start, BoundaryStart::Curve),
            found => Ok(found),
        }
    }
}

/// The end data, and the state at the middle of the cubic of flat space.
pub(crate) fn end_data(problem: &BoundaryProblem, flat: &FlatData) -> EndData {
    let BoundaryData {
        target, velocities, ..
    } = boundary_data(problem);
    EndData {
        target,
        velocities,
        middle: middle(problem, flat),
    }
}

/// `x, x', x''` at the middle of the cubic of flat space.
fn middle(problem: &BoundaryProblem, flat: &FlatData) -> [Vec<f64>; 3] {
    let vectors = [&flat.displacement, &problem.velocity, &flat.end_velocity];
    let [delta, first, last] = vectors.map(|v| pack(problem.blocks(), std::slice::from_ref(v)));
    let combined = |[a, b, c]: [f64; 3]| {
        let entries = delta.iter().zip(&first).zip(&last);
        entries.map(|((x, y), z)| a * x + b * y + c * z).collect()
    };
    [[1.5, -0.25, -0.25], [0.0, -1.0, 1.0], [-12.0, 6.0, 6.0]].map(combined)
}
