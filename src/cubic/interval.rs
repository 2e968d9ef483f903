//! The same Riemannian cubic over another interval: parts of it, more of it, other times, backwards.

use std::sync::Arc;

use super::path::Path;
use super::riemannian_cubic::{RiemannianCubic, extend};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::check_finite_scalar;

impl RiemannianCubic {
    /// The same curve, made for another interval: a part of it, or more.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`start >= end`), and where the curve cannot be integrated on: as
    /// [`RiemannianCubic::from_initial`].
    pub fn restricted(&self, start: f64, end: f64, interrupt: Interrupt<'_>) -> Result<Self> {
        check_interval(start, end)?;
        let longer = self.continued(start, end, interrupt)?;
        let mut out = longer.unwrap_or_else(|| self.clone());
        out.span = (start, end);
        Ok(out)
    }

    /// The same points at other times: the interval of the curve becomes `[start, end]`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`start >= end`, an interval so short or long that speeds are no normal numbers).
    pub fn reparametrised(&self, start: f64, end: f64) -> Result<Self> {
        check_interval(start, end)?;
        Ok(RiemannianCubic {
            clock: self.clock.reparametrised(self.span, (start, end))?,
            span: (start, end),
            ..self.clone()
        })
    }

    /// The curve run backwards over the same interval.
    pub fn reversed(&self) -> Self {
        RiemannianCubic {
            clock: self.clock.reversed(self.span),
            ..self.clone()
        }
    }

    /// The curve integrated on until it reaches two times; none where it does.
    fn continued(&self, lower: f64, upper: f64, interrupt: Interrupt<'_>) -> Result<Option<Self>> {
        let moments = [lower, upper].map(|t| self.clock.path_time(t));
        if moments.iter().all(|t| self.path.covers(*t)) {
            return Ok(None);
        }
        let mut path = Path::clone(&self.path);
        for t in moments {
            extend(&mut path, self.clock, t, interrupt)?;
        }
        Ok(Some(RiemannianCubic {
            path: Arc::new(path.into()),
            ..self.clone()
        }))
    }

    /// The curve integrated on until it reaches all of some times; none where it does, or where one is not finite.
    pub(super) fn reaching(&self, t: &[f64], interrupt: Interrupt<'_>) -> Result<Option<Self>> {
        let (lower, upper) = range(t);
        if t.is_empty() || !t.iter().all(|t| t.is_finite()) {
            return Ok(None);
        }
        self.continued(lower, upper, interrupt)
    }
}

/// The least and the largest.
fn range(t: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    t.iter()
        .fold(start, |(low, high), t| (low.min(*t), high.max(*t)))
}

/// Error unless `start < end`, both finite.
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
