//! Functions of the angles of symmetric Taylor polynomials, eight at once.
//!
//! For `X = cos Theta` with eigenvalues above -1, the matrices `cos(t Theta)` and `sin(t Theta) / sin(Theta)` are
//! analytic in `X` and `t`. With `Y = Theta^2`, which gains one order at a time from `cos sqrt(Y) = X`, they are series
//! in `t^2 Y`, evaluated in the eigenbasis of the constant term: there all products with it are elementwise.

use super::lane_margin::TINY;
use super::quasi_geodesic_jet::{Parity, series_terms};
use crate::linalg::lane_jet::SpectralJet;
use crate::linalg::lane_matrix::LaneMatrix;
use crate::linalg::lanes::Lanes;

/// Angle below which `sin(x) / x` is its series of two terms.
const SMALL: f64 = 1e-4;

/// Buffers for matrices of one size.
pub(super) struct LaneAngles {
    angles: Vec<Lanes>,
    /// The inverse of the divided differences of `cos sqrt(Y)`.
    inverse_difference: LaneMatrix,
    squared: SpectralJet,
    argument: SpectralJet,
    work: SpectralJet,
    sine: SpectralJet,
    inverse: SpectralJet,
    /// `cos(t Theta)`.
    pub(super) cosine: SpectralJet,
    /// `sin(t Theta) / sin(Theta)`.
    pub(super) ratio: SpectralJet,
}

impl LaneAngles {
    pub(super) fn new(k: usize) -> Self {
        let jet = || SpectralJet::zeros(k);
        LaneAngles {
            angles: vec![Lanes::ZERO; k],
            inverse_difference: LaneMatrix::zeros(k, k),
            squared: jet(),
            argument: jet(),
            work: jet(),
            sine: jet(),
            inverse: jet(),
            cosine: jet(),
            ratio: jet(),
        }
    }

    /// Computes both functions of `x` at `t + tau`, `|t| <= 1`, for orders of at least 1.
    #[inline(always)]
    pub(super) fn compute(&mut self, x: &SpectralJet, t: Lanes, order: usize) {
        let terms = self.square_angles(x, order);
        let (argument, work) = (&mut self.argument, &mut self.work);
        argument.set_scaled([t * t, t * 2.0, Lanes::ONE], &self.squared, order);
        series(&mut self.cosine, argument, work, Parity::Even, terms, order);
        series(&mut self.sine, argument, work, Parity::Odd, terms, order);
        // (t + tau) sin(t Theta) / (t Theta).
        work.set_scaled([t, Lanes::ONE, Lanes::ZERO], &self.sine, order);
        series(
            &mut self.sine,
            &self.squared,
            argument,
            Parity::Odd,
            terms,
            order,
        );
        self.inverse.set_inverse(&self.sine, order);
        self.ratio.set_product(1.0, work, &self.inverse, order);
    }

    /// Computes `Y`; returns the number of terms of the series.
    #[inline(always)]
    fn square_angles(&mut self, x: &SpectralJet, order: usize) -> usize {
        let k = self.angles.len();
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
                let slope = sinc((a + b) * half) * sinc((a - b) * half);
                let inverse = Lanes::splat(-2.0) / slope;
                self.inverse_difference.set(i, l, inverse);
                self.inverse_difference.set(l, i, inverse);
            }
        }
        let terms = series_terms(largest);
        for j in 1..=order {
            // The cosine of what is known of Y; its part of order 1 is zero.
            self.squared.order_mut(j).fill_zero();
            if j > 1 {
                series(
                    &mut self.cosine,
                    &self.squared,
                    &mut self.work,
                    Parity::Even,
                    terms,
                    j,
                );
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

/// `cos sqrt(W)` or `sin sqrt(W) / sqrt(W)`, by Horner's rule; one and two columns stay in registers.
#[inline(always)]
fn series(
    target: &mut SpectralJet,
    argument: &SpectralJet,
    work: &mut SpectralJet,
    parity: Parity,
    terms: usize,
    order: usize,
) {
    let offset = match parity {
        Parity::Even => 0,
        Parity::Odd => 1,
    };
    let factors = (1..=terms)
        .rev()
        .map(|j| -1.0 / ((2 * j + offset - 1) * (2 * j + offset)) as f64);
    match (target.diagonal.len(), order) {
        (1, 1) => small_series::<1, 1>(target, argument, factors),
        (1, 2) => small_series::<1, 2>(target, argument, factors),
        (1, _) => small_series::<1, 3>(target, argument, factors),
        (2, 1) => small_series::<2, 1>(target, argument, factors),
        (2, 2) => small_series::<2, 2>(target, argument, factors),
        (2, _) => small_series::<2, 3>(target, argument, factors),
        _ => {
            target.set_identity(order);
            for factor in factors {
                work.set_product(factor, target, argument, order);
                work.add_identity();
                std::mem::swap(work, target);
            }
        }
    }
}

/// The same for `K` columns and orders up to `N`.
#[inline(always)]
fn small_series<const K: usize, const N: usize>(
    target: &mut SpectralJet,
    argument: &SpectralJet,
    factors: impl Iterator<Item = f64>,
) {
    let mut w = [[[Lanes::ZERO; K]; K]; N];
    for n in 0..N {
        for l in 0..K {
            for i in 0..K {
                w[n][l][i] = argument.order(n + 1).at(i, l);
            }
        }
    }
    let diagonal: [Lanes; K] = std::array::from_fn(|i| argument.diagonal[i]);
    let (mut first, mut sum) = ([Lanes::ONE; K], [[[Lanes::ZERO; K]; K]; N]);
    for factor in factors {
        // Highest order first, since it needs the lower ones as they were.
        for n in (0..N).rev() {
            for l in 0..K {
                for i in 0..K {
                    let mut entry = first[i] * w[n][l][i] + sum[n][l][i] * diagonal[l];
                    for m in 0..n {
                        for h in 0..K {
                            entry += sum[m][h][i] * w[n - m - 1][l][h];
                        }
                    }
                    sum[n][l][i] = entry * factor;
                }
            }
        }
        for i in 0..K {
            first[i] = first[i] * diagonal[i] * factor + Lanes::ONE;
        }
    }
    target.diagonal.copy_from_slice(&first);
    for n in 0..N {
        for l in 0..K {
            for i in 0..K {
                target.order_mut(n + 1).set(i, l, sum[n][l][i]);
            }
        }
    }
}

#[inline(always)]
fn sinc(x: Lanes) -> Lanes {
    let (sin, _) = x.sin_cos();
    let small = Lanes::splat(SMALL).greater(x.abs());
    let series = Lanes::ONE - x * x * (1.0 / 6.0);
    small.select(series, sin / small.select(Lanes::ONE, x))
}
