//! Arc length of a curve, its inverse, and the curve at constant speed.

use super::curve::{Curve, coordinate_shape, jets, length_between};
use super::length::{Length, ROUND_OFF, Speed, TOLERANCE};
use super::quantity::Quantity;
use super::sampling::Samples;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

/// The length of a curve from the start of an interval, as a function that can be inverted.
///
/// ```math
/// s(t) = \int_{t_0}^{t} |S'(\tau)|\, d\tau
/// ```
///
/// in the canonical metric. Gauss-Legendre quadrature on panels that are halved until both halves together agree with
/// the whole; panels end at the breakpoints of the curve.
///
/// # Accuracy
/// Lengths and inverses relative to 1e-12 of the total, or to round-off of the velocity or of the parameter where that is more.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::curve::ArcLength;
/// use stiefel_rs::{Interrupt, QuasiGeodesic};
/// let (x, y) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
/// let quarter = QuasiGeodesic::between(x.as_ref(), y.as_ref())?;
/// let length = ArcLength::of(&quarter, Interrupt::NEVER)?;
/// assert!((length.total() - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
/// assert!((length.parameter(length.total() / 4.0)? - 0.25).abs() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct ArcLength<'a, C: Curve> {
    curve: &'a C,
    length: Length,
    interrupt: Interrupt<'a>,
}

impl<'a, C: Curve> ArcLength<'a, C> {
    /// Over the interval that the curve is made for.
    ///
    /// # Errors
    /// `NoConvergence`, `Overflow`, `Interrupted`, and where the curve does not exist.
    pub fn of(curve: &'a C, interrupt: Interrupt<'a>) -> Result<Self> {
        let (start, end) = curve.t_span();
        Self::between(curve, start.min(end), start.max(end), interrupt)
    }

    /// From `start` to `end >= start`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument`, and those of [`ArcLength::of`].
    pub fn between(curve: &'a C, start: f64, end: f64, interrupt: Interrupt<'a>) -> Result<Self> {
        Ok(ArcLength {
            curve,
            length: length_between(curve, start, end, interrupt)?,
            interrupt,
        })
    }

    /// The length of the whole interval.
    pub fn total(&self) -> f64 {
        self.length.total()
    }

    /// The parameter at which the length from the start is `length`.
    ///
    /// Where the curve rests there are many: one of them.
    ///
    /// # Errors
    /// `NonFinite`; `InvalidArgument` unless `0 <= length <= total` (to round-off).
    pub fn parameter(&self, length: f64) -> Result<f64> {
        Ok(self.parameters(&[length])?[0])
    }

    /// [`ArcLength::parameter`] of many lengths.
    ///
    /// # Errors
    /// As [`ArcLength::parameter`], with the index of a length that is not finite; `Interrupted`.
    pub fn parameters(&self, lengths: &[f64]) -> Result<Vec<f64>> {
        let slack = 4.0 * TOLERANCE * self.length.total();
        for (index, &length) in lengths.iter().enumerate() {
            if !length.is_finite() {
                return Err(Error::NonFinite {
                    name: "length",
                    index,
                });
            }
            if length < -slack || length > self.length.total() + slack {
                return Err(Error::InvalidArgument {
                    name: "length",
                    requirement: "from 0 to the length of the curve",
                    found: length,
                });
            }
        }
        let speed = || Speed::new(coordinate_shape(self.curve), jets(self.curve, 1));
        self.length.parameters(lengths, speed, self.interrupt)
    }

    /// Parameters of `count` points at equal lengths, the first and the last one at the ends of the interval.
    ///
    /// For a curve that does not move, equal steps of the parameter.
    ///
    /// # Errors
    /// `InvalidArgument` for fewer than two, or more than fit in memory; `Interrupted`.
    pub fn equal(&self, count: usize) -> Result<Vec<f64>> {
        if count < 2 {
            return Err(Error::InvalidArgument {
                name: "count",
                requirement: "at least 2",
                found: count as f64,
            });
        }
        // Lengths, parameters, and the parts that these are put together from.
        if Vec::<[f64; 3]>::new().try_reserve_exact(count).is_err() {
            return Err(Error::InvalidArgument {
                name: "count",
                requirement: "small enough for the points to fit in memory",
                found: count as f64,
            });
        }
        let (start, end) = self.length.interval();
        let share = |i: usize| i as f64 / (count - 1) as f64;
        if self.length.total() <= ROUND_OFF {
            return Ok((0..count)
                .map(|i| start + share(i) * (end - start))
                .collect());
        }
        let lengths: Vec<f64> = (0..count).map(|i| share(i) * self.length.total()).collect();
        let mut parameters = self.parameters(&lengths)?;
        (parameters[0], parameters[count - 1]) = (start, end);
        Ok(parameters)
    }

    /// The curve at constant speed, sampled: its positions at [`ArcLength::equal`] parameters.
    ///
    /// # Errors
    /// As [`ArcLength::equal`] and [`Curve::sample`].
    pub fn sample(&self, count: usize) -> Result<Samples> {
        let parameters = self.equal(count)?;
        self.curve
            .sample(&parameters, Quantity::Derivative(0), self.interrupt)
    }
}
