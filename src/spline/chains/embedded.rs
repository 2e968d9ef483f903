//! How chains with and without frames are solved by legs in the embedding: conversion between their vectors and matrices.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::{Chain, SpannedPiece};
use super::motion::Motion;
use super::solution::{ChainSolution, Effort, SolvedLegs};
use crate::collocation;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::lazy_taylor::LazyTaylor;
use crate::cubic::taylor::leg_curve::leg_curve;
use crate::error::Result;
use crate::legs::Knots;
use crate::linalg::product::entries;
use crate::space::{Kind, in_space};
use crate::spline::ends::{End, Ends};

/// Largest ratio of the lengths of neighbouring legs for which legs in the embedding are used where there are other methods.
/// They meet the tolerance in
/// the time of the shorter leg; in the time of the longer one, accelerations jump by 1e-9 to 6e-9 at a ratio of 1000, and
/// by up to 1e-4 at 1e8.
const UNEVEN: f64 = 100.0;

/// A chain whose vectors are matrices in other coordinates.
pub(crate) trait InEmbedding: Chain {
    /// Points at the knots.
    fn points(&self) -> Vec<Mat<f64>>;

    /// The matrix of a vector at a knot.
    fn matrix_of(&self, knot: usize, v: &[f64]) -> Mat<f64>;

    /// The vector with a given matrix.
    fn vector_of(&self, knot: usize, v: MatRef<'_, f64>) -> Vec<f64>;

    /// Frames at the knots that begin with the points, if there are any.
    fn frames_of_space(&self) -> Option<Arc<[Mat<f64>]>>;

    /// The meaning of the points and their scalars.
    fn kind(&self) -> Kind;

    /// The space of the equations, and the number of columns of a point.
    fn space(&self) -> (Sizes, usize);

    /// Tension of the curves.
    fn tension(&self) -> f64;

    /// Whether the lengths of the legs are even enough for continuous accelerations.
    fn is_even(&self, ends: &Ends) -> bool {
        let lengths = self.lengths();
        let around = match ends {
            Ends::Open(_) => None,
            Ends::Periodic => lengths.first(),
        };
        let next = lengths.iter().skip(1).chain(around);
        let mut pairs = lengths.iter().zip(next);
        pairs.all(|(a, b)| a.max(*b) <= UNEVEN * a.min(*b))
    }

    /// Solves with legs in the embedding, from the spline of flat space.
    ///
    /// # Errors
    /// `Interrupted`, `Overflow`.
    fn in_embedding(&self, ends: &Ends, effort: Effort<'_>) -> Result<ChainSolution> {
        let (points, legs) = (self.points(), self.lengths().len());
        let matrix = |knot: usize, v: &[f64]| entries(self.matrix_of(knot, v));
        let end = |knot: usize, end: &End| match end {
            End::Velocity(v) => End::Velocity(matrix(knot, v)),
            End::Acceleration(a) => End::Acceleration(matrix(knot, a)),
        };
        let ends = match ends {
            Ends::Open([first, last]) => Ends::Open([end(0, first), end(legs, last)]),
            Ends::Periodic => Ends::Periodic,
        };
        let knots = Knots {
            lengths: self.lengths(),
            targets: Vec::new(),
            ends: &ends,
            tension: self.tension(),
        };
        let may_go_on = |products| effort.work.may_go_on(products);
        let options = effort.options(&may_go_on);
        let chain = collocation::EmbeddedChain {
            kind: self.kind(),
            points: &points,
            knots: &knots,
        };
        let (report, solved) = chain.solve(&options)?;
        let mut motion = Motion::zeros(self.size(), legs + 1);
        if report.converged {
            let (n, k) = points[0].shape();
            for (knot, v) in solved.velocities.chunks_exact(n * k).enumerate() {
                let v = MatRef::from_column_major_slice(v, n, k);
                let v = self.vector_of(knot, v);
                motion.velocity_mut(knot).copy_from_slice(&v);
            }
            for leg in 0..legs {
                let derivatives = solved
                    .derivatives(leg)
                    .map(|derivative| self.vector_of(leg, derivative.as_ref()));
                motion
                    .derivatives_mut(leg)
                    .copy_from_slice(&derivatives.concat());
            }
        }
        let legs = report.converged.then(|| SolvedLegs {
            polynomials: None,
            turns: solved.turns().map(Arc::from),
            piece: self.embedded_piece(solved),
        });
        Ok(ChainSolution {
            motion,
            report,
            legs,
        })
    }

    /// The curves of the legs.
    fn embedded_piece(
        &self,
        solved: collocation::SolvedChain,
    ) -> Arc<dyn Fn(usize) -> Option<SpannedPiece> + Send + Sync> {
        let (frames, (blocks, columns)) = (self.frames_of_space(), self.space());
        let (tension, lengths) = (self.tension(), self.lengths().to_vec());
        let solved = Arc::new(solved);
        Arc::new(move |leg| {
            if !solved.is_polynomial(leg) {
                return None;
            }
            let (basis, to_basis, frame, blocks) = match (solved.basis(leg), &frames) {
                (Some([basis, map]), _) => {
                    let r = basis.ncols();
                    let spanned = Sizes::new(r - columns, columns, blocks.quotient);
                    (Some(basis), map, None, spanned)
                }
                (None, frames) => {
                    let frame = frames.as_ref()?[leg].clone();
                    (None, frame.transpose().to_owned(), Some(frame), blocks)
                }
            };
            let (solved, tension) = (Arc::clone(&solved), tension * lengths[leg].powi(2));
            let compute = move || {
                let to_basis = to_basis.as_ref();
                let dense = in_space!(blocks.shape(), |space| solved
                    .polynomials(space, leg, to_basis));
                leg_curve(&dense, 0, frame.as_ref(), blocks, columns, tension)
            };
            Some((basis, LazyTaylor::of(compute)))
        })
    }
}
