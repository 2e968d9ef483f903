//! The spline through the data of a smoothing spline: where `lambda` is small, a start near the solution, and in any
//! case a curve that must not be better.

use super::smoothing_equations::SmoothingData;
use crate::error::{Result, unless_interrupted};
use crate::legs::{End, Ends};
use crate::spline::chains::ambient::Ambient;
use crate::spline::chains::chain::Movable;
use crate::spline::chains::embedded::InEmbedding as _;
use crate::spline::chains::framed::Framed;
use crate::spline::chains::low_cost::{cost, is_far};
use crate::spline::chains::motion::Motion;
use crate::spline::chains::solution::{ChainSolution, Effort};
use crate::spline::chains::solve::cheapest;

/// A chain through data that may be far apart.
pub(crate) trait Interpolated: Movable {
    /// Whether there may be several splines through the points.
    fn is_far(&self) -> bool;

    /// The spline through the points.
    ///
    /// # Errors
    /// `Interrupted`, and the errors of the chain.
    fn interpolated(&self, ends: &Ends, effort: Effort<'_>) -> Result<ChainSolution>;
}

impl Interpolated for Framed<'_> {
    fn is_far(&self) -> bool {
        is_far(self.longest())
    }

    fn interpolated(&self, ends: &Ends, effort: Effort<'_>) -> Result<ChainSolution> {
        cheapest(self, ends, effort, 1.0)
    }
}

impl Interpolated for Ambient<'_> {
    /// Other solutions are not sought in many dimensions.
    fn is_far(&self) -> bool {
        false
    }

    fn interpolated(&self, ends: &Ends, effort: Effort<'_>) -> Result<ChainSolution> {
        self.in_embedding(ends, effort)
    }
}

/// The natural spline through the first datum at each time.
pub(crate) struct Interpolating {
    pub(crate) motion: Motion,
    /// Its misfit, which comes from further data at the same times, plus `lambda` times its cost.
    pub(crate) objective: f64,
}

impl Interpolating {
    /// `None` if no spline is found.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn of(
        chain: &impl Interpolated,
        data: &SmoothingData,
        lambda: f64,
        effort: Effort<'_>,
    ) -> Result<Option<Self>> {
        let natural = Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; chain.size()])));
        let found = unless_interrupted(chain.interpolated(&natural, effort))?;
        let Some(found) = found.filter(|found| found.report.converged) else {
            return Ok(None);
        };
        let objective = || {
            let cost = cost(chain, &found, effort.interrupt)?;
            Ok(data.misfit_of(chain, effort.work)? + lambda * cost)
        };
        let objective = unless_interrupted(objective())?;
        Ok(objective.map(|objective| Interpolating {
            motion: found.motion,
            objective,
        }))
    }
}
