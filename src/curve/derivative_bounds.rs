//! The largest velocity, covariant acceleration and covariant jerk of a curve.

use super::norms::{Norm, NormEvaluation, Norms};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::lanes::LANES;

/// Number of samples of each smooth piece.
const SAMPLES: usize = 32;

/// Number of samples per refinement, on the two intervals next to a largest sample: those that are computed at once.
const FINER: usize = LANES;

/// Number of refinements; each reduces the interval to 2/7, so that after nine the maximum of a function that is smooth
/// between samples is known to about `1e-10`.
const ROUNDS: usize = 9;

/// Number of local maxima that are refined.
const CANDIDATES: usize = 3;

/// The kind of guarantee for the values of [`DerivativeBounds`].
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::BoundaryOptions;
/// use stiefel_rs::curve::{Curve, GeometricCubic, Guarantee};
/// use stiefel_rs::{Interrupt, RiemannianCubic};
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let geometric = GeometricCubic::from_boundary(s0, v0, s1, v1)?;
/// assert_eq!(geometric.derivative_bounds(Interrupt::NEVER)?.guarantee, Guarantee::Sampling);
/// let cubic = RiemannianCubic::from_boundary(s0, v0, s1, v1, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// assert_eq!(cubic.derivative_bounds(Interrupt::NEVER)?.guarantee, Guarantee::Enclosure);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guarantee {
    /// Strict bounds, up to round-off: the norms exceed them nowhere, and they are at most a factor 1e-3 above the
    /// largest norms. If a derivative of lower order is more than ten times as large, with the length of the interval
    /// (of a piece of a spline) as the unit of time, they are at most 1e-4 of that derivative above.
    Enclosure,
    /// The largest norms of a dense sample, refined near the largest ones. They never exceed the true maxima, but a
    /// peak narrower than 1/32 of a piece may be missed.
    Sampling,
}

impl Guarantee {
    /// The guarantee with a given name, the inverse of [`Guarantee::as_str`].
    pub fn from_word(word: &str) -> Option<Self> {
        let mut all = [Guarantee::Enclosure, Guarantee::Sampling].into_iter();
        all.find(|guarantee| guarantee.as_str() == word)
    }

    /// The name of the guarantee, the same in Rust and Python.
    pub fn as_str(self) -> &'static str {
        match self {
            Guarantee::Enclosure => "enclosure",
            Guarantee::Sampling => "sampling",
        }
    }
}

/// The largest norms of velocity, covariant acceleration and covariant jerk on an interval, in the canonical metric.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, GeometricCubic, Interrupt};
/// // From rest to rest along a circle, by the angle 3 t^2 - 2 t^3.
/// let (s0, s1) = (mat![[1.0], [0.0]], mat![[1.0_f64.cos()], [1.0_f64.sin()]]);
/// let rest = mat![[0.0], [0.0]];
/// let curve = GeometricCubic::from_boundary(s0.as_ref(), rest.as_ref(), s1.as_ref(), rest.as_ref())?;
/// let bounds = curve.derivative_bounds(Interrupt::NEVER)?;
/// assert!((bounds.velocity - 1.5).abs() < 1e-10);
/// assert!((bounds.acceleration - 6.0).abs() < 1e-10);
/// assert!((bounds.jerk - 12.0).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DerivativeBounds {
    /// Largest `|S'|`.
    pub velocity: f64,
    /// Largest `|D_t S'|`.
    pub acceleration: f64,
    /// Largest `|D_t D_t S'|`.
    pub jerk: f64,
    /// The guarantee for all three.
    pub guarantee: Guarantee,
}

impl DerivativeBounds {
    /// The larger values of both, with the weaker guarantee.
    pub(crate) fn max(self, other: Self) -> Self {
        let guarantee = match (self.guarantee, other.guarantee) {
            (Guarantee::Enclosure, Guarantee::Enclosure) => Guarantee::Enclosure,
            _ => Guarantee::Sampling,
        };
        DerivativeBounds {
            velocity: self.velocity.max(other.velocity),
            acceleration: self.acceleration.max(other.acceleration),
            jerk: self.jerk.max(other.jerk),
            guarantee,
        }
    }

    /// The bounds for the same curve traversed in `length` times the time.
    pub(crate) fn slowed(self, length: f64) -> Result<Self> {
        let rate = 1.0 / length;
        let out = DerivativeBounds {
            velocity: self.velocity * rate,
            acceleration: self.acceleration * rate * rate,
            jerk: self.jerk * rate * rate * rate,
            guarantee: self.guarantee,
        };
        if out.velocity.is_finite() && out.acceleration.is_finite() && out.jerk.is_finite() {
            return Ok(out);
        }
        Err(Error::Overflow {
            quantity: "derivative bounds",
        })
    }
}

/// Bounds by sampling each smooth piece of a curve, between its breakpoints.
pub(super) fn sampled_bounds(
    norms: &mut Norms<impl NormEvaluation>,
    breakpoints: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<DerivativeBounds> {
    let mut largest = [0.0_f64; 3];
    for pair in breakpoints.windows(2) {
        let samples = sample(norms, 3, [pair[0], pair[1]], SAMPLES, interrupt)?;
        for which in 0..3 {
            let values = samples.iter().map(|(_, values)| values[which]);
            largest[which] = values.fold(largest[which], f64::max);
            for (low, high) in peaks(&samples, which) {
                let peak = refined(norms, low, high, which, interrupt)?;
                largest[which] = largest[which].max(peak);
            }
        }
    }
    Ok(DerivativeBounds {
        velocity: largest[0],
        acceleration: largest[1],
        jerk: largest[2],
        guarantee: Guarantee::Sampling,
    })
}

type BoundSample = (f64, [f64; 3]);

fn sample(
    norms: &mut Norms<impl NormEvaluation>,
    order: usize,
    [low, high]: [f64; 2],
    count: usize,
    interrupt: Interrupt<'_>,
) -> Result<Vec<BoundSample>> {
    interrupt.check("derivative bounds")?;
    let share = |i: usize| i as f64 / (count - 1) as f64;
    let t: Vec<f64> = (0..count)
        .map(|i| (low + share(i) * (high - low)).clamp(low, high))
        .collect();
    let mut found = vec![Norm::default(); count];
    norms.read(&t, order, &mut found)?;
    let found = found.into_iter().map(|norm| norm.covariant);
    Ok(t.into_iter().zip(found).collect())
}

/// The intervals next to the largest local maxima of one norm.
fn peaks(samples: &[BoundSample], which: usize) -> Vec<(f64, f64)> {
    let value = |i: usize| samples[i].1[which];
    let last = samples.len() - 1;
    let mut tops: Vec<usize> = (0..=last)
        .filter(|&i| {
            (i == 0 || value(i) >= value(i - 1)) && (i == last || value(i) >= value(i + 1))
        })
        .collect();
    tops.sort_by(|a, b| value(*b).total_cmp(&value(*a)));
    tops.truncate(CANDIDATES);
    tops.into_iter()
        .map(|i| (samples[i.saturating_sub(1)].0, samples[(i + 1).min(last)].0))
        .collect()
}

/// The largest value between two parameters.
fn refined(
    norms: &mut Norms<impl NormEvaluation>,
    low: f64,
    high: f64,
    which: usize,
    interrupt: Interrupt<'_>,
) -> Result<f64> {
    let (mut low, mut high, mut largest) = (low, high, 0.0_f64);
    for _ in 0..ROUNDS {
        let samples = sample(norms, which + 1, [low, high], FINER, interrupt)?;
        let top = (0..FINER).fold(0, |top, i| {
            if samples[i].1[which] > samples[top].1[which] {
                i
            } else {
                top
            }
        });
        largest = largest.max(samples[top].1[which]);
        low = samples[top.saturating_sub(1)].0;
        high = samples[(top + 1).min(FINER - 1)].0;
    }
    Ok(largest)
}
