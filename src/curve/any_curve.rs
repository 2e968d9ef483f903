//! The trait `Curve` for curves whose type is known only at run time.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::{ArcLength, Curve, DerivativeBounds, Quantity, Samples};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::space::Quotient;
use crate::stored::{Fields, Stored};

/// A curve of any type behind a pointer.
pub(crate) trait AnyCurve: Send + Sync {
    fn shape(&self) -> (usize, usize);
    fn quotient(&self) -> Quotient;
    fn t_span(&self) -> (f64, f64);
    fn continued(&self) -> Option<Arc<dyn AnyCurve>>;
    fn frame(&self) -> Option<MatRef<'_, f64>>;
    fn stored(&self) -> (&'static str, Fields);
    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples>;
    fn sample_coordinates(
        &self,
        t: &[f64],
        quantity: Quantity,
        interrupt: Interrupt<'_>,
    ) -> Result<Mat<f64>>;
    fn cost(&self, interrupt: Interrupt<'_>) -> Result<f64>;
    fn arc_length(&self, t0: f64, t1: f64, interrupt: Interrupt<'_>) -> Result<f64>;
    fn resample(&self, count: usize, interrupt: Interrupt<'_>) -> Result<Vec<f64>>;
    fn derivative_bounds(&self, interrupt: Interrupt<'_>) -> Result<DerivativeBounds>;
}

impl<C: Curve + Stored + Send + 'static> AnyCurve for C {
    fn shape(&self) -> (usize, usize) {
        (self.n(), self.k())
    }

    fn quotient(&self) -> Quotient {
        Curve::quotient(self)
    }

    fn t_span(&self) -> (f64, f64) {
        Curve::t_span(self)
    }

    fn continued(&self) -> Option<Arc<dyn AnyCurve>> {
        Some(Arc::new(Curve::continued(self)?))
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        Curve::frame(self)
    }

    fn stored(&self) -> (&'static str, Fields) {
        let mut fields = Fields::default();
        self.store(&mut fields);
        (C::KIND, fields)
    }

    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples> {
        Curve::sample(self, t, quantity, interrupt)
    }

    fn sample_coordinates(
        &self,
        t: &[f64],
        quantity: Quantity,
        interrupt: Interrupt<'_>,
    ) -> Result<Mat<f64>> {
        Curve::sample_coordinates(self, t, quantity, interrupt)
    }

    fn cost(&self, interrupt: Interrupt<'_>) -> Result<f64> {
        Curve::cost(self, interrupt)
    }

    fn arc_length(&self, t0: f64, t1: f64, interrupt: Interrupt<'_>) -> Result<f64> {
        Curve::arc_length(self, t0, t1, interrupt)
    }

    fn resample(&self, count: usize, interrupt: Interrupt<'_>) -> Result<Vec<f64>> {
        ArcLength::of(self, interrupt)?.equal(count)
    }

    fn derivative_bounds(&self, interrupt: Interrupt<'_>) -> Result<DerivativeBounds> {
        Curve::derivative_bounds(self, interrupt)
    }
}
