//! A chain of many dimensions: vectors are matrices as tall as the points, and every leg is integrated in the span of its data.
//!
//! Work and memory are linear in the number of rows.

use faer::{Mat, MatRef, Scale};

use super::chain::{Chain, Way};
use crate::cubic::guess::carry;
use crate::cubic::leg::arrival;
use crate::cubic::problem::entries;
use crate::cubic::taylor::Accuracy;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::distance;
use crate::manifold::QuasiGeodesic;

/// Knots and the quasi-geodesics between them.
pub(super) struct Ambient<'a> {
    points: Vec<Mat<f64>>,
    curves: Vec<QuasiGeodesic>,
    lengths: Vec<f64>,
    interrupt: Interrupt<'a>,
}

impl<'a> Ambient<'a> {
    pub(super) fn new(
        points: Vec<Mat<f64>>,
        curves: Vec<QuasiGeodesic>,
        lengths: &[f64],
        interrupt: Interrupt<'a>,
    ) -> Self {
        Ambient {
            points,
            curves,
            lengths: lengths.to_vec(),
            interrupt,
        }
    }

    fn matrix<'b>(&self, v: &'b [f64]) -> MatRef<'b, f64> {
        let (n, k) = self.points[0].shape();
        MatRef::from_column_major_slice(v, n, k)
    }
}

impl Chain for Ambient<'_> {
    type Worker = ();

    fn size(&self) -> usize {
        self.points[0].nrows() * self.points[0].ncols()
    }

    fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    fn worker(&self) {}

    fn displacement_into(&self, leg: usize, out: &mut [f64]) {
        out.copy_from_slice(&entries(&self.curves[leg].initial_velocity()));
    }

    fn carry_into(
        &self,
        (): &mut (),
        leg: usize,
        way: Way,
        v: &[f64],
        out: &mut [f64],
    ) -> Result<()> {
        let t = match way {
            Way::Forward => 1.0,
            Way::Back => -1.0,
        };
        let carried = carry(&self.curves[leg], self.matrix(v), t)?;
        write(&carried, out);
        Ok(())
    }

    fn arrive_into(
        &self,
        (): &mut (),
        leg: usize,
        start: &[f64],
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64> {
        let size = self.size();
        let vectors = [0, 1, 2].map(|i| self.matrix(&start[size * i..][..size]));
        let end = arrival(self.points[leg].as_ref(), vectors, accuracy, self.interrupt)?;
        let next = self.points[leg + 1].as_ref();
        for (end, values) in end.iter().zip(values.chunks_exact_mut(size)) {
            write(&tangent(next, end.as_ref()), values);
        }
        Ok(distance(end[0].as_ref(), next))
    }
}

/// The tangential part at a point.
fn tangent(s: MatRef<'_, f64>, a: MatRef<'_, f64>) -> Mat<f64> {
    let inner = s.transpose() * a;
    let symmetric = (&inner + inner.transpose()) * Scale(0.5);
    a - s * symmetric
}

fn write(a: &Mat<f64>, out: &mut [f64]) {
    for (out, column) in out.chunks_exact_mut(a.nrows()).zip(a.col_iter()) {
        for (out, x) in out.iter_mut().zip(column.iter()) {
            *out = *x;
        }
    }
}
