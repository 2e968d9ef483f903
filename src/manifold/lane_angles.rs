//! Functions of the angles of symmetric Taylor polynomials, eight at once.
//!
//! For `X = cos Theta` with eigenvalues above -1, the matrices `cos(t Theta)` and `sin(t Theta) / sin(Theta)` are
//! analytic in `X` and `t`. With `Y = Theta^2`, which gains one order at a time from `cos sqrt(Y) = X`, they are series
//! in `t^2 Y`, evaluated in the eigenbasis of the constant term: there all products with it are elementwise.

use super::lane_margin::TINY;
use super::quasi_geodesic_jet::series_terms;
use crate::linalg::lane_jet::SpectralJet;
use crate::linalg::lane_square::LaneSquare;
use crate::linalg::lanes::Lanes;

/// Angle below which `sin(x) / x` is its series of two terms.
const SMALL: f64 = 1e-4;

/// Largest number of terms; 17 are needed for an angle of pi.
const MOST_TERMS: usize = 20;

/// Coefficients of `cos sqrt(W)` and of `sin sqrt(W) / sqrt(W)`.
const EVEN: [f64; MOST_TERMS + 1] = coefficients(0);
const ODD: [f64; MOST_TERMS + 1] = coefficients(1);

const fn coefficients(offset: usize) -> [f64; MOST_TERMS + 1] {
    let mut out = [1.0; MOST_TERMS + 1];
    let mut j = 1;
    while j <= MOST_TERMS {
        out[j] = -out[j - 1] / ((2 * j + offset - 1) * (2 * j + offset)) as f64;
        j += 1;
    }
    out
}

/// Buffers for matrices of one size.
pub(super) struct LaneAngles<M: LaneSquare> {
    angles: M::Diagonal,
    /// The inverse of the divided differences of `cos sqrt(Y)`.
    inverse_difference: M,
    squared: SpectralJet<M>,
    argument: SpectralJet<M>,
    sine: SpectralJet<M>,
    work: M,
    /// `sin(Theta) / Theta`.
    own: SpectralJet<M>,
    scaled: SpectralJet<M>,
    inverse: SpectralJet<M>,
    /// `cos(t Theta)`.
    pub(super) cosine: SpectralJet<M>,
    /// `sin(t Theta) / sin(Theta)`.
    pub(super) ratio: SpectralJet<M>,
}

impl<M: LaneSquare> LaneAngles<M> {
    pub(super) fn new(k: usize) -> Self {
        let jet = || SpectralJet::zeros(k);
        LaneAngles {
            angles: M::zero_diagonal(k),
            inverse_difference: M::zeros(k),
            squared: jet(),
            argument: jet(),
            sine: jet(),
            work: M::zeros(k),
            own: jet(),
            scaled: jet(),
            inverse: jet(),
            cosine: jet(),
            ratio: jet(),
        }
    }

    /// Computes both functions of `x` at `t + tau`, `|t| <= 1`, for orders of at least 1.
    #[inline(always)]
    pub(super) fn compute(&mut self, x: &SpectralJet<M>, t: Lanes, order: usize) {
        let terms = self.square_angles(x, order);
        let (argument, sine, work) = (&mut self.argument, &mut self.sine, &mut self.work);
        argument.set_scaled([t * t, t * 2.0, Lanes::ONE], &self.squared, order);
        // All three series in one loop: the steps of one of them wait for each other.
        let (cosine, own) = (&mut self.cosine, &mut self.own);
        let [even, odd] = [EVEN[terms], ODD[terms]];
        cosine.set_constant(even, order);
        sine.set_constant(odd, order);
        own.set_constant(odd, order);
        for j in (0..terms).rev() {
            cosine.horner_step(argument, EVEN[j], work, order);
            sine.horner_step(argument, ODD[j], work, order);
            own.horner_step(&self.squared, ODD[j], work, order);
        }
        // (t + tau) sin(t Theta) / (t Theta).
        self.scaled
            .set_scaled([t, Lanes::ONE, Lanes::ZERO], sine, order);
        self.inverse.set_inverse(own, order);
        self.ratio.set_product(&self.scaled, &self.inverse, order);
    }

    /// Computes `Y`; returns the number of terms of the series.
    #[inline(always)]
    fn square_angles(&mut self, x: &SpectralJet<M>, order: usize) -> usize {
        let k = self.work.size();
        let mut largest = 0.0_f64;
        for i in 0..k {
            let cosine = x.diagonal[i];
            let sine = ((Lanes::ONE - cosine) * (Lanes::ONE + cosine)).max(Lanes::splat(TINY));
            self.angles[i] = sine.sqrt().atan2(cosine);
            self.squared.diagonal[i] = self.angles[i] * self.angles[i];
            largest = self.squared.diagonal[i]
                .0
                .iter()
                .fold(largest, |m, y| m.max(*y));
        }
        let half = Lanes::splat(0.5);
        for l in 0..k {
            for i in 0..=l {
                let (a, b) = (self.angles[i], self.angles[l]);
                let slope = match i == l {
                    true => sinc(a),
                    false => sinc((a + b) * half) * sinc((a - b) * half),
                };
                let inverse = Lanes::splat(-2.0) / slope;
                self.inverse_difference.set(i, l, inverse);
                self.inverse_difference.set(l, i, inverse);
            }
        }
        let terms = series_terms(largest);
        debug_assert!(terms <= MOST_TERMS);
        for j in 1..=order {
            // The cosine of what is known of Y; its part of order 1 is zero.
            self.squared.order_mut(j).fill_zero();
            if j > 1 {
                self.cosine.set_constant(EVEN[terms], j);
                for i in (0..terms).rev() {
                    let (squared, work) = (&self.squared, &mut self.work);
                    self.cosine.horner_step(squared, EVEN[i], work, j);
                }
            }
            let known = (j > 1).then(|| self.cosine.order(j));
            let out = self.squared.order_mut(j);
            for l in 0..k {
                for i in 0..k {
                    let mut missing = x.order(j).at(i, l);
                    if let Some(known) = known {
                        missing -= known.at(i, l);
                    }
                    out.set(i, l, missing * self.inverse_difference.at(i, l));
                }
            }
        }
        terms
    }
}

#[inline(always)]
fn sinc(x: Lanes) -> Lanes {
    let (sin, _) = x.sin_cos();
    let small = Lanes::splat(SMALL).greater(x.abs());
    let series = Lanes::ONE - x * x * (1.0 / 6.0);
    small.select(series, sin / small.select(Lanes::ONE, x))
}
