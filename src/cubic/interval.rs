//! A Riemannian cubic over another interval: restricted, extended, reparametrised, reversed.

use std::sync::Arc;

use super::riemannian_cubic::{RiemannianCubic, extend};
use super::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::check_finite_scalar;

impl RiemannianCubic {
    /// The same curve on another interval, which may be a part of the interval or exceed it.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`start >= end`); the errors of [`RiemannianCubic::from_initial`] if the curve
    /// cannot be extended.
    pub fn restricted(&self, start: f64, end: f64, interrupt: Interrupt<'_>) -> Result<Self> {
        check_interval(start, end)?;
        let longer = self.continued(start, end, interrupt)?;
        let mut out = longer.unwrap_or_else(|| self.clone());
        out.span = (start, end);
        Ok(out)
    }

    /// The curve with its interval mapped to `[start, end]`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`start >= end`, or an interval so short or long that speeds are not normal
    /// numbers).
    pub fn reparametrised(&self, start: f64, end: f64) -> Result<Self> {
        check_interval(start, end)?;
        Ok(RiemannianCubic {
            time_map: self.time_map.reparametrised(self.span, (start, end))?,
            span: (start, end),
            ..self.clone()
        })
    }

    /// The curve traversed backwards over the same interval.
    pub fn reversed(&self) -> Self {
        RiemannianCubic {
            time_map: self.time_map.reversed(self.span),
            ..self.clone()
        }
    }

    /// The curve extended to reach two times; `None` if it reaches them already.
    fn continued(&self, lower: f64, upper: f64, interrupt: Interrupt<'_>) -> Result<Option<Self>> {
        let moments = [lower, upper].map(|t| self.time_map.taylor_time(t));
        if moments.iter().all(|t| self.taylor.covers(*t)) {
            return Ok(None);
        }
        let mut taylor = PiecewiseTaylor::clone(&self.taylor);
        for t in moments {
            extend(&mut taylor, self.time_map, t, interrupt)?;
        }
        Ok(Some(RiemannianCubic {
            taylor: Arc::new(taylor.into()),
            ..self.clone()
        }))
    }

    /// The curve extended to reach all given times; `None` if it reaches them already, or if one of them is not finite.
    pub(super) fn reaching(&self, t: &[f64], interrupt: Interrupt<'_>) -> Result<Option<Self>> {
        let (lower, upper) = range(t);
        if t.is_empty() || !t.iter().all(|t| t.is_finite()) {
            return Ok(None);
        }
        self.continued(lower, upper, interrupt)
    }
}

/// The smallest and the largest time.
fn range(t: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    t.iter()
        .fold(start, |(low, high), t| (low.min(*t), high.max(*t)))
}

/// Return an error unless `start < end`, both finite.
fn check_interval(start: f64, end: f64) -> Result<()> {
    check_finite_scalar("start", start)?;
    check_finite_scalar("end", end)?;
    if start < end && (end - start).is_finite() {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "end",
        requirement: "greater than the start",
        found: end,
    })
}
