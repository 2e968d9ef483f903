//! Splines through knots with more rows: by legs in the embedding, or by integrated legs if these find nothing.

use super::ambient::Ambient;
use super::embedded::InEmbedding;
use super::ends::Ends;
use super::interpolation::Interpolation;
use super::iteration::Iteration;
use super::solvable::{Effort, Solution, Solvable, Start};
use crate::error::Result;

impl Solvable for Ambient<'_> {
    fn solve(&self, ends: &Ends, start: Start, effort: Effort<'_>) -> Result<Solution> {
        if let Start::Flat = start
            && let Some(found) = self.in_embedding(ends, None, effort)?
        {
            return Ok(found);
        }
        let problem = Interpolation::new(self, ends)?;
        match start {
            Start::Flat => Iteration::solve(&problem, problem.start()?, effort),
            Start::Near(motion) => Iteration::solve(&problem, motion, effort),
        }
    }
}
