//! The affine map from the time of a curve to the time of its Taylor polynomials.
//!
//! The polynomials are computed in the natural time of the data, in which velocity, acceleration and jerk are at most
//! about one, so that very slow and very fast data neither underflow nor overflow. Reparametrisation is free and exact.

use crate::error::{Error, Result};

/// `t_taylor = taylor_origin + rate (t - curve_origin)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeMap {
    pub(super) rate: f64,
    /// A time of the curve, and the corresponding time of the polynomials.
    pub(super) curve_origin: f64,
    pub(super) taylor_origin: f64,
}

impl TimeMap {
    /// Both times start at zero; one unit of the curve's time is `rate` units of the polynomials'.
    pub(super) fn new(rate: f64) -> Self {
        TimeMap {
            rate,
            curve_origin: 0.0,
            taylor_origin: 0.0,
        }
    }

    /// The time of the polynomials; finite for every finite `t`.
    #[inline(always)]
    pub(super) fn taylor_time(&self, t: f64) -> f64 {
        (self.taylor_origin + self.rate * (t - self.curve_origin)).clamp(f64::MIN, f64::MAX)
    }

    /// Whether both run in the same direction.
    pub(super) fn is_forward(&self) -> bool {
        self.rate > 0.0
    }

    /// Converts a derivative of the given order to the time of the curve.
    ///
    /// Multiplies one factor at a time: a power of the rate may overflow where its product with a small number does
    /// not.
    #[inline(always)]
    pub(super) fn derivative(&self, value: f64, order: usize) -> f64 {
        (0..order).fold(value, |value, _| value * self.rate)
    }

    /// Converts a duration from the time of the polynomials to the time of the curve.
    pub(super) fn curve_length(&self, length: f64) -> f64 {
        (length / self.rate.abs()).min(f64::MAX)
    }

    /// The map after the curve's interval `from` has become `to`.
    ///
    /// # Errors
    /// `InvalidArgument` if the ratio of the lengths is not a normal number.
    pub(super) fn reparametrised(&self, from: (f64, f64), to: (f64, f64)) -> Result<Self> {
        // In this order, since the length in the time of the polynomials is of moderate size.
        let rate = self.rate * (from.1 - from.0) / (to.1 - to.0);
        if !rate.is_normal() {
            return Err(Error::InvalidArgument {
                name: "end",
                requirement: "such that speeds on the new interval neither overflow nor underflow",
                found: to.1,
            });
        }
        Ok(TimeMap {
            rate,
            curve_origin: to.0,
            taylor_origin: self.taylor_time(from.0),
        })
    }

    /// The map of the curve reversed over the same interval.
    pub(super) fn reversed(&self, span: (f64, f64)) -> Self {
        TimeMap {
            rate: -self.rate,
            curve_origin: span.0,
            taylor_origin: self.taylor_time(span.1),
        }
    }
}
