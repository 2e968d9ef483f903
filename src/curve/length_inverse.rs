//! The inverse of the length of a curve: on a part of a panel, the speed is a polynomial through its values at the
//! Gauss nodes and at both ends, so the parameter of a length needs no more speeds.
//!
//! With the polynomial `q` through the values at the nodes, the roots of `P_12`, and its errors `e` at both ends,
//!
//! ```math
//! f = q + \Bigl( \frac{e_+ + e_-}{2} + \frac{e_+ - e_-}{2}\, x \Bigr) P_{12},\qquad x P_{12} = \frac{13 P_{13} + 12 P_{11}}{25}
//! ```
//!
//! # Source
//! Derived here, from the recurrence of the Legendre polynomials.

use std::sync::LazyLock;

use super::gauss_legendre::{PANEL, POINTS};

/// Values on a part: at its start, at its end, and at the nodes in decreasing order.
pub(super) const VALUES: usize = POINTS + 2;

/// Maximal number of steps of the inversion in one part; bisection alone needs 53.
const MAX_STEPS: usize = 120;

/// Factors of the values at the nodes in the Legendre coefficients of the polynomial through them, by coefficient.
static ANALYSIS: LazyLock<[[f64; POINTS]; POINTS]> = LazyLock::new(|| {
    let (nodes, weights) = &*PANEL;
    let mut all = [[0.0; POINTS]; POINTS];
    for (i, (x, weight)) in nodes.iter().zip(weights).enumerate() {
        let basis = legendre(*x);
        for (j, row) in all.iter_mut().enumerate() {
            row[i] = (j as f64 + 0.5) * weight * basis[j];
        }
    }
    all
});

/// The Legendre polynomials up to the degree `VALUES`.
fn legendre(x: f64) -> [f64; VALUES + 1] {
    let mut p = [1.0; VALUES + 1];
    p[1] = x;
    for j in 1..VALUES {
        let degree = j as f64;
        p[j + 1] = ((2.0 * degree + 1.0) * x * p[j] - degree * p[j - 1]) / (degree + 1.0);
    }
    p
}

/// The length along a part of a curve, with a polynomial as speed.
#[derive(Debug)]
pub(super) struct LengthPart {
    start: f64,
    end: f64,
    /// Legendre coefficients of the speed, and of the length from the start.
    speed: [f64; VALUES],
    length: [f64; VALUES + 1],
}

impl LengthPart {
    /// Built from the interval and the speeds there.
    pub(super) fn new([start, end]: [f64; 2], values: &[f64; VALUES]) -> Self {
        let (at_ends, inner) = values.split_at(2);
        let mut speed = [0.0; VALUES];
        let (mut first, mut last, mut sign) = (at_ends[0], at_ends[1], 1.0);
        for (c, row) in speed.iter_mut().zip(&*ANALYSIS) {
            *c = row.iter().zip(inner).map(|(factor, x)| factor * x).sum();
            first -= sign * *c;
            last -= *c;
            sign = -sign;
        }
        let (even, odd) = (0.5 * (last + first), 0.5 * (last - first));
        let degree = POINTS as f64;
        speed[POINTS] = even;
        speed[POINTS + 1] = odd * (degree + 1.0) / (2.0 * degree + 1.0);
        speed[POINTS - 1] += odd * degree / (2.0 * degree + 1.0);
        // The integral of P_j is (P_{j+1} - P_{j-1}) / (2j + 1), and zero at the start.
        let half = 0.5 * (end - start);
        let mut length = [0.0; VALUES + 1];
        length[0] = half * speed[0];
        for (j, c) in speed.iter().enumerate() {
            let share = half * c / (2 * j + 1) as f64;
            length[j + 1] += share;
            if j > 0 {
                length[j - 1] -= share;
            }
        }
        LengthPart {
            start,
            end,
            speed,
            length,
        }
    }

    /// The length of the whole part.
    pub(super) fn total(&self) -> f64 {
        (self.end - self.start) * self.speed[0]
    }

    /// An estimate of the error of the length, from the last two coefficients of the speed. It is too large for smooth
    /// speeds, and up to twenty times too small at a corner.
    pub(super) fn error(&self) -> f64 {
        let tail = self.speed[POINTS].abs() + self.speed[POINTS + 1].abs();
        0.5 * (self.end - self.start) * tail / POINTS as f64
    }

    /// The parameter at which the length from the start of the part is `wanted`, to the given error of the length or to
    /// the spacing of floating-point numbers: by Newton's method, safeguarded by bisection.
    pub(super) fn parameter(&self, wanted: f64, error: f64) -> f64 {
        let total = self.total();
        if wanted <= 0.0 || wanted >= total {
            return if wanted <= 0.0 { self.start } else { self.end };
        }
        let half = 0.5 * (self.end - self.start);
        let spacing = 2.0 * f64::EPSILON * (self.start.abs().max(self.end.abs()) / half).max(1.0);
        let (mut low, mut high) = (-1.0, 1.0);
        let mut x = 2.0 * wanted / total - 1.0;
        for _ in 0..MAX_STEPS {
            let basis = legendre(x);
            let sum = |c: &[f64]| -> f64 { c.iter().zip(&basis).map(|(c, p)| c * p).sum() };
            let excess = sum(&self.length) - wanted;
            if excess > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - excess / (half * sum(&self.speed));
            if excess.abs() <= error || (newton - x).abs() <= spacing || high - low <= spacing {
                break;
            }
            x = if low < newton && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        (0.5 * (self.start + self.end) + half * x).clamp(self.start, self.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(interval: [f64; 2], speed: impl Fn(f64) -> f64) -> LengthPart {
        let (nodes, _) = &*PANEL;
        let [start, end] = interval;
        let places = [-1.0, 1.0].into_iter().chain(nodes.iter().copied());
        let mut values = [0.0; VALUES];
        for (value, x) in values.iter_mut().zip(places) {
            *value = speed(0.5 * (start + end) + 0.5 * (end - start) * x);
        }
        LengthPart::new(interval, &values)
    }

    #[test]
    fn polynomials_of_degree_thirteen_are_exact() {
        let part = part([1.0, 3.0], |t| 14.0 * (t - 1.0).powi(13));
        let total = 2.0_f64.powi(14);
        assert!((part.total() - total).abs() < 1e-11);
        for share in [0.0, 0.25, 0.5, 0.99, 1.0] {
            let t = 1.0 + 2.0 * share;
            let found = part.parameter((t - 1.0_f64).powi(14), 0.0);
            // The round-off of the length, divided by the speed.
            let bound = 16.0 * f64::EPSILON * total / (14.0 * (t - 1.0_f64).powi(13));
            assert!((found - t).abs() <= bound, "{t}: {found}");
        }
    }

    #[test]
    fn the_error_of_smooth_speeds_is_not_underestimated() {
        for pole in [1.05, 1.3, 2.0, 4.0] {
            let part = part([-1.0, 1.0], |t| 1.0 / (pole - t));
            let mut most = 0.0_f64;
            for i in 0..=100 {
                let x = f64::from(i) / 50.0 - 1.0;
                let sum = part.length.iter().zip(legendre(x)).map(|(c, p)| c * p);
                let exact = ((pole + 1.0) / (pole - x)).ln();
                most = most.max((sum.sum::<f64>() - exact).abs());
            }
            assert!(most <= part.error() + 4e-16, "{pole}: {most:e}");
            // Not by more than the decay of a few coefficients.
            assert!(part.error() < 1e3 * most.max(1e-15), "{pole}: {most:e}");
        }
    }

    #[test]
    fn the_error_at_a_corner_is_underestimated_by_a_factor_of_twenty_at_most() {
        for i in 0..200 {
            let corner = f64::from(i) / 100.0 - 0.995;
            let part = part([-1.0, 1.0], |t| (t - corner).abs());
            let mut most = 0.0_f64;
            for j in 0..=100 {
                let x = f64::from(j) / 50.0 - 1.0;
                let sum = part.length.iter().zip(legendre(x)).map(|(c, p)| c * p);
                let square = |t: f64| 0.5 * (t - corner) * (t - corner).abs();
                let exact = square(x) - square(-1.0);
                most = most.max((sum.sum::<f64>() - exact).abs());
            }
            assert!(most <= 20.0 * part.error(), "{corner}: {most:e}");
        }
    }
}
