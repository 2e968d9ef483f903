//! Generalised cross-validation of smoothing splines, in flat space, to which the data are unrolled.

use super::flat_smoothing::FlatSmoothing;
use super::smoothing_equations::SmoothingData;
use crate::cubic::taylor::work::Work;
use crate::error::{Error, Result};
use crate::linalg::field::add;
use crate::solve::direction::Direction;
use crate::spline::chains::chain::Movable;

/// Number of values of `lambda` per factor of ten in the initial scan.
const PER_DECADE: f64 = 2.0;

/// Golden-section steps around the best of them, to a relative accuracy of `1e-4`.
const REFINEMENTS: usize = 24;

/// The problem in flat space.
pub(crate) struct GeneralisedCrossValidation<'c, 'd, C> {
    chain: &'c C,
    data: &'d SmoothingData,
    /// Displacements from the first datum at each knot to all data there.
    displacements: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

impl<'c, 'd, C: Movable> GeneralisedCrossValidation<'c, 'd, C> {
    /// Built for a chain through the first datum of each knot.
    ///
    /// # Errors
    /// An error if data at one knot are too far apart.
    pub(crate) fn new(chain: &'c C, data: &'d SmoothingData, work: &Work) -> Result<Self> {
        Ok(GeneralisedCrossValidation {
            chain,
            data,
            displacements: data.displacements(chain, work)?,
            weights: data.weight_of_knots(),
        })
    }

    /// The system of flat space.
    ///
    /// # Errors
    /// `InvalidArgument` (times so unequal that the arithmetic overflows or underflows).
    pub(crate) fn flat(&self, lambda: f64) -> Result<FlatSmoothing> {
        FlatSmoothing::new(self.chain.lengths(), self.weights.clone(), lambda)
    }

    /// `N` times the weighted sum of squared residuals, divided by the square of `N` minus the degrees of freedom.
    fn score(&self, lambda: f64) -> Result<f64> {
        let (d, count) = (self.chain.size(), self.data.len() as f64);
        let (flat, lengths) = (self.flat(lambda)?, self.chain.lengths());
        let mut right = vec![0.0; 2 * d * self.weights.len()];
        let mut displacement = vec![0.0; d];
        let mut worker = self.chain.worker();
        let mut ahead = vec![0.0; d];
        for (leg, h) in lengths.iter().enumerate() {
            self.chain.displacement_into(leg, &mut displacement);
            self.chain.carry_into(
                &mut worker,
                leg,
                Direction::Forward,
                &displacement,
                &mut ahead,
            )?;
            let (before, after) = right[2 * d * leg..].split_at_mut(2 * d);
            if leg > 0 {
                add(&mut before[d..], -1.0 / h, &displacement);
            }
            if leg + 1 < lengths.len() {
                add(&mut after[d..2 * d], 1.0 / h, &ahead);
            }
        }
        let each = || {
            self.data
                .knots()
                .iter()
                .zip(&self.data.weights)
                .zip(&self.displacements)
        };
        for ((&knot, weight), away) in each() {
            add(&mut right[2 * d * knot..], weight * flat.pull(), away);
        }
        flat.solve(self.chain, &mut worker, &mut right)?;
        let mut squares = 0.0;
        for ((&knot, weight), away) in each() {
            let moved = &right[2 * d * knot..][..d];
            let rest: Vec<f64> = moved.iter().zip(away).map(|(p, e)| p - e).collect();
            squares += weight * self.chain.square(knot, &rest);
        }
        let left = count - flat.degrees_of_freedom(lengths)?;
        Ok(count * squares / (left * left))
    }

    /// The score at `10^exponent`; infinite if the arithmetic overflows or underflows.
    ///
    /// # Errors
    /// The errors of carrying.
    fn score_at(&self, exponent: f64) -> Result<f64> {
        match self.score(10.0_f64.powf(exponent)) {
            Ok(score) if score.is_finite() => Ok(score),
            Ok(_) | Err(Error::InvalidArgument { .. }) => Ok(f64::INFINITY),
            Err(error) => Err(error),
        }
    }

    /// The `lambda` with the smallest score, in units of the mean leg.
    ///
    /// Searched between the values for which the curve follows every datum and for which it is a straight line, both to
    /// one part in a million.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn best(&self) -> Result<f64> {
        let count = self.weights.len() as f64;
        let mean = self.weights.iter().sum::<f64>() / count;
        let (low, high) = (mean.log10() - 4.0, mean.log10() + 4.0 * count.log10() + 4.0);
        let values = ((high - low) * PER_DECADE).ceil() as usize;
        let step = (high - low) / values as f64;
        let mut best = (f64::INFINITY, low);
        for i in 0..=values {
            let exponent = low + step * i as f64;
            let score = self.score_at(exponent)?;
            if score < best.0 {
                best = (score, exponent);
            }
        }
        if best.0 == f64::INFINITY {
            return Err(Error::InvalidArgument {
                name: "t",
                requirement: "more evenly spaced for cross-validation, or lam given; ratio of longest to mean interval",
                found: self.chain.lengths().iter().fold(0.0, |h, x| h.max(*x)),
            });
        }
        let exponent = self.refined([best.1 - step, best.1 + step])?;
        Ok(10.0_f64.powf(exponent))
    }

    /// Golden-section search between two exponents.
    fn refined(&self, [mut low, mut high]: [f64; 2]) -> Result<f64> {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let score = |exponent: f64| self.score_at(exponent);
        let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_left, mut at_right) = (score(left)?, score(right)?);
        for _ in 0..REFINEMENTS {
            if at_left < at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - golden * (high - low);
                at_left = score(left)?;
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + golden * (high - low);
                at_right = score(right)?;
            }
        }
        Ok(0.5 * (low + high))
    }
}
