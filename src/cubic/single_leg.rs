//! Moderate boundary value problems, whose solution is one Taylor series about its middle.

use super::guess::FlatData;
use super::initial::{Horizontal, complete_relative};
use super::packing::pack;
use super::problem::Problem;
use super::solver::Solver;
use super::taylor::Accuracy;
use crate::error::{Error, Result};
use crate::report::StopReason;
use crate::shooting::{EndData, lone_leg};
use crate::space::{Homogeneous, in_space};

/// Maximal number of steps; solved problems take five to nine.
pub(super) const STEPS: usize = 11;

impl Solver<'_> {
    /// `(x', x'')` at the start of the solution, found with one series from the cubic of flat space; `None` if there is
    /// none.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn by_one_series(&mut self, flat: &FlatData) -> Result<Option<Vec<f64>>> {
        let problem = self.problem;
        let unknowns = 2 * in_space!(problem.shape(), |space| space.dim());
        if !(1..=MOST_UNKNOWNS).contains(&unknowns) || problem.target.tension > 0.0 {
            return Ok(None);
        }
        let data = end_data(problem, flat);
        let steps = STEPS.min(self.options.max_iterations);
        let legs = lone_leg(problem.shape())(&[data], self.tolerance(), steps);
        let Some(leg) = legs.into_iter().flatten().next() else {
            return Ok(None);
        };
        let start = leg.start;
        let distance = match self.map.equations(&start, Accuracy::FULL) {
            Ok((_, distance)) => distance,
            Err(error @ Error::Interrupted { .. }) => return Err(error),
            Err(_) => return Ok(None),
        };
        let mut y = start;
        self.account_start(leg.steps);
        if distance <= self.tolerance() {
            self.set_nearest(distance, StopReason::Converged);
            return Ok(Some(y));
        }
        Ok(self.restarted(&mut y, None)?.then_some(y))
    }
}

/// Largest number of unknowns for which one series is tried. With a limit of 64, problems with speeds up to 1.6 on
/// St(12,4), complex St(10,3) and (8,4), and St(20,5) (76, 102, 96 and 170 unknowns) take 5, 4, 4 and 3 times as long,
/// but slow ones on St(20,5), with speeds of 0.6, only 0.7 times as long. With a limit of 1000, problems on St(40,10),
/// with 690 unknowns, take 2 to 10 times as long.
const MOST_UNKNOWNS: usize = 256;

/// The end data, and the state at the middle of the cubic of flat space.
pub(super) fn end_data(problem: &Problem, flat: &FlatData) -> EndData {
    let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
    let r = s1.nrows();
    let frame = complete_relative(problem.kind().field, s1);
    let last = Horizontal::of_tangent(frame.as_ref(), v1);
    EndData {
        target: (0..r * r).map(|i| frame[(i / r, i % r)]).collect(),
        velocities: [&problem.velocity, &last]
            .map(|v| pack(problem.blocks(), std::slice::from_ref(v))),
        middle: middle(problem, flat),
    }
}

/// `x, x', x''` at the middle of the cubic of flat space.
fn middle(problem: &Problem, flat: &FlatData) -> [Vec<f64>; 3] {
    let vectors = [&flat.displacement, &problem.velocity, &flat.end_velocity];
    let [delta, first, last] = vectors.map(|v| pack(problem.blocks(), std::slice::from_ref(v)));
    let combined = |[a, b, c]: [f64; 3]| {
        let entries = delta.iter().zip(&first).zip(&last);
        entries.map(|((x, y), z)| a * x + b * y + c * z).collect()
    };
    [[1.5, -0.25, -0.25], [0.0, -1.0, 1.0], [-12.0, 6.0, 6.0]].map(combined)
}
