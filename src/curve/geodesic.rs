//! Geodesics as curves.

use faer::MatRef;

use super::curve::Curve;
use crate::error::Result;
use crate::linalg::jet::MatrixJet;
use crate::manifold::Geodesic;
use crate::manifold::exponential::Flow;
use crate::space::Quotient;

impl Curve for Geodesic {
    type Workspace = Flow;

    fn n(&self) -> usize {
        Geodesic::n(self)
    }

    fn k(&self) -> usize {
        Geodesic::k(self)
    }

    fn quotient(&self) -> Quotient {
        Geodesic::quotient(self)
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        Some(self.frame())
    }

    fn workspace(&self) -> Flow {
        Flow::new(self)
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Flow,
        out: &mut MatrixJet,
    ) -> Result<()> {
        Geodesic::coordinates_into(self, t, order, work, out)
    }
}
