//! Passes boundary value problems to the solver at Gauss nodes, and makes a curve of its result.

use std::cell::Cell;

use super::guess::FlatData;
use super::problem::BoundaryProblem;
use super::solution::SolvedStart;
use super::solver::Solver;
use crate::collocation::{
    BoundaryData, BoundaryLimits, BoundaryStart, SolvedLeg, solve_between_ends,
};
use crate::cubic::taylor::initial::{Horizontal, complete_relative};
use crate::cubic::taylor::leg_curve::leg_curve;
use crate::cubic::taylor::packing::pack;
use crate::cubic::taylor::work::of_products;
use crate::error::Result;

/// Largest number of unknowns for which one series is tried instead, without tension: on St(3,1) and St(3,2) it takes less
/// than half as long. Curves are always integrated there: the rates of rotations, as polynomials through nodes, were up to
/// 1.4e-11 off.
const FEW: usize = 6;

/// Maximal number of steps. Random problems with distance and speeds up to 2 take 4 to 13.
const STEPS: usize = 16;

/// Part of the tolerance for the end of the curve at nodes: the end of an integrated curve differs by its truncation.
const SHARE: f64 = 0.5;

impl Solver<'_> {
    /// The solution from the cubic of flat space, by the quicker method; `None` if it finds none.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn by_flat_start(&mut self, flat: Option<&FlatData>) -> Result<Option<SolvedStart>> {
        let problem = self.problem;
        if (1..=FEW).contains(&problem.unknowns())
            && problem.tension == 0.0
            && let Some(flat) = flat
            && let Some(found) = self.by_one_series(flat)?
        {
            return Ok(Some(found));
        }
        let kind = match flat {
            Some(_) => BoundaryStart::Flat,
            None => BoundaryStart::Curve,
        };
        self.at_nodes(&problem.flat_start(flat), kind)
    }

    /// The solution that Newton's method at Gauss nodes finds from `(x', x'')` at the start, compared with the given end;
    /// `None` if it finds none.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn at_nodes(
        &mut self,
        start: &[f64],
        kind: BoundaryStart,
    ) -> Result<Option<SolvedStart>> {
        let problem = self.problem;
        if problem.unknowns() == 0 {
            // Nothing can move.
            return self.integrated(start);
        }
        let (left, work) = (self.work.left(), Cell::new(0.0));
        let limits = BoundaryLimits {
            tolerance: SHARE * self.tolerance(),
            steps: STEPS.min(self.options.max_iterations),
            may_go_on: &|products| {
                work.set(work.get() + of_products(products));
                work.get() <= left
            },
            interrupt: self.interrupt,
        };
        let data = boundary_data(problem);
        let (a, b) = start.split_at(start.len() / 2);
        let derivatives = [a, b].map(<[f64]>::to_vec);
        let outcome = solve_between_ends(problem.shape(), &data, (derivatives, kind), limits)?;
        self.work.count(work.get());
        self.count_steps(outcome.steps);
        let Some(SolvedLeg { derivatives, curve }) = outcome.found else {
            return Ok(None);
        };
        let start = derivatives.concat();
        if let Some(curve) = curve.filter(|_| problem.unknowns() > FEW) {
            let (blocks, tension) = (problem.blocks(), problem.tension);
            let taylor = leg_curve(&curve, 0, Some(&problem.g), blocks, problem.k, tension);
            if let Some(found) = self.accepted(&start, taylor) {
                return Ok(Some(found));
            }
        }
        self.integrated(&start)
    }
}

/// The data at the ends, relative to the frame at the start.
pub(crate) fn boundary_data(problem: &BoundaryProblem) -> BoundaryData {
    let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
    let r = s1.nrows();
    let frame = complete_relative(problem.kind().field, s1);
    let last = Horizontal::of_tangent(frame.as_ref(), v1);
    BoundaryData {
        target: (0..r * r).map(|i| frame[(i / r, i % r)]).collect(),
        velocities: [&problem.velocity, &last]
            .map(|v| pack(problem.blocks(), std::slice::from_ref(v))),
        tension: problem.tension,
    }
}
