//! A quasi-geodesic as a curve.

use faer::prelude::*;
use faer::{MatMut, MatRef};

use super::Curve;
use crate::error::Result;
use crate::linalg::jet::Jet;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::Evaluation;

impl Curve for QuasiGeodesic {
    type Workspace = Evaluation;

    fn n(&self) -> usize {
        QuasiGeodesic::n(self)
    }

    fn k(&self) -> usize {
        QuasiGeodesic::k(self)
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        Some(self.frame())
    }

    fn workspace(&self) -> Evaluation {
        Evaluation::new(QuasiGeodesic::k(self))
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Evaluation,
        out: &mut Jet,
    ) -> Result<()> {
        QuasiGeodesic::coordinates_into(self, t, order, &mut work.turning, out)
    }

    fn positions_into(
        &self,
        t: &[f64],
        work: &mut Evaluation,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let k = QuasiGeodesic::k(self);
        for (i, &t) in t.iter().enumerate() {
            self.coordinates_into(t, 0, &mut work.turning, &mut work.coordinates)?;
            let position = work.coordinates.c[0].as_ref();
            out.rb_mut().subcols_mut(i * k, k).copy_from(position);
        }
        Ok(())
    }
}
