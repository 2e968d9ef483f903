//! Quasi-geodesics as curves.

use faer::MatRef;

use super::curve::Curve;
use crate::error::Result;
use crate::linalg::jet::MatrixJet;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::Turning;

impl Curve for QuasiGeodesic {
    type Workspace = Turning;

    fn n(&self) -> usize {
        QuasiGeodesic::n(self)
    }

    fn k(&self) -> usize {
        QuasiGeodesic::k(self)
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        Some(self.frame())
    }

    fn workspace(&self) -> Turning {
        Turning::new(QuasiGeodesic::k(self))
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Turning,
        out: &mut MatrixJet,
    ) -> Result<()> {
        QuasiGeodesic::coordinates_into(self, t, order, work, out)
    }
}
