//! Arc length of a curve, its inverse, and reparametrisation to constant speed.

use super::curve::{Curve, length_between, speed_of};
use super::length::{Length, ROUND_OFF, TOLERANCE};
use super::quantity::Quantity;
use super::sampling::Samples;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

/// The length of a curve from the start of an interval, as an invertible function.
///
/// ```math
/// s(t) = \int_{t_0}^{t} |S'(\tau)|\, d\tau
/// ```
///
/// in the canonical metric. It is computed by Gauss-Legendre quadrature on panels, which are halved until the sum over
/// both halves agrees with the whole; panels end at the breakpoints of the curve.
///
/// # Accuracy
/// Lengths, and the lengths at computed parameters, are accurate to 1e-12 of the total, or to the round-off of the
/// velocity or of the parameter if that is larger.
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
    /// The length over the whole interval of the curve.
    ///
    /// # Errors
    /// `NoConvergence`, `Overflow`, `Interrupted`, and an error if the curve does not exist somewhere.
    pub fn of(curve: &'a C, interrupt: Interrupt<'a>) -> Result<Self> {
        let (start, end) = curve.t_span();
        Self::between(curve, start.min(end), start.max(end), interrupt)
    }

    /// The length from `start` to `end >= start`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument`, and the errors of [`ArcLength::of`].
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
    /// If the curve rests there, this is one of several such parameters.
    ///
    /// # Errors
    /// `NonFinite`; `InvalidArgument` unless `0 <= length <= total` (to round-off).
    pub fn parameter(&self, length: f64) -> Result<f64> {
        Ok(self.parameters(&[length])?[0])
    }

    /// [`ArcLength::parameter`] for many lengths.
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
        let speed = || speed_of(self.curve);
        self.length.parameters(lengths, speed, self.interrupt)
    }

    /// Parameters of `count` points at equal distances along the curve, including both ends of the interval.
    ///
    /// For a curve that does not move, the parameters are equidistant.
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
        // Lengths, parameters, and the intermediate results for both.
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

    /// The positions at the parameters of [`ArcLength::equal`], which sample the curve at constant speed.
    ///
    /// # Errors
    /// As [`ArcLength::equal`] and [`Curve::sample`].
    pub fn sample(&self, count: usize) -> Result<Samples> {
        let parameters = self.equal(count)?;
        self.curve
            .sample(&parameters, Quantity::Derivative(0), self.interrupt)
    }
}
