//! Splines through knots with more rows: by legs in the embedding, or by integrated legs if these find nothing.

use super::ambient::Ambient;
use super::embedded::InEmbedding;
use super::interpolation::Interpolation;
use super::iteration::ChainIteration;
use super::solution::{ChainSolution, Effort};
use crate::error::Result;
use crate::spline::ends::Ends;

impl Ambient<'_> {
    /// Solves the equations of a spline from the spline of flat space.
    ///
    /// # Errors
    /// An error if the start cannot be integrated; `Interrupted`.
    pub(crate) fn solve(&self, ends: &Ends, effort: Effort<'_>) -> Result<ChainSolution> {
        if let Some(found) = self.in_embedding(ends, None, effort)? {
            return Ok(found);
        }
        let problem = Interpolation::new(self, ends)?;
        ChainIteration::solve(&problem, problem.start()?, effort)
    }
}
