//! A chain of many dimensions: vectors are matrices as tall as the points, and every leg is integrated in the span of its data.
//!
//! Work and memory are linear in the number of rows.

use faer::{Mat, MatMut, MatRef, Scale};
use rayon::prelude::*;

use super::chain::{Chain, JOINS, Means, Motion, Movable, links, square};
use crate::cubic::guess::carry;
use crate::cubic::initial::Coordinates;
use crate::cubic::leg::arrival;
use crate::cubic::problem::entries;
use crate::cubic::reduced::Sized;
use crate::cubic::state::State;
use crate::cubic::taylor::Accuracy;
use crate::cubic::work::{work_of_curve, work_of_join};
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::distance;
use crate::manifold::carrier::{Carrier, Direction};
use crate::manifold::{QuasiGeodesic, Stiefel};

/// Knots and the quasi-geodesics between them.
pub(super) struct Ambient<'a> {
    points: Vec<Mat<f64>>,
    curves: Vec<QuasiGeodesic>,
    lengths: Vec<f64>,
    tension: f64,
    interrupt: Interrupt<'a>,
}

impl<'a> Ambient<'a> {
    pub(super) fn new(
        points: Vec<Mat<f64>>,
        curves: Vec<QuasiGeodesic>,
        lengths: Vec<f64>,
        interrupt: Interrupt<'a>,
    ) -> Self {
        Ambient {
            points,
            curves,
            lengths,
            tension: 0.0,
            interrupt,
        }
    }

    /// The same for curves in tension.
    pub(super) fn in_tension(mut self, tension: f64) -> Self {
        self.tension = tension;
        self
    }

    /// In the time of a leg.
    fn leg_tension(&self, leg: usize) -> f64 {
        self.tension * self.lengths[leg].powi(2)
    }

    /// The length of the longest quasi-geodesic between neighbours.
    pub(super) fn longest(&self) -> f64 {
        let lengths = self.curves.iter().map(QuasiGeodesic::speed);
        lengths.fold(0.0, f64::max)
    }

    /// The same knots, passed backwards.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn reversed(&self) -> Result<Self> {
        let curves = self.curves.iter().rev().map(QuasiGeodesic::reversed);
        Ok(Ambient {
            points: self.points.iter().rev().cloned().collect(),
            curves: curves.collect::<Result<_>>()?,
            lengths: self.lengths.iter().rev().copied().collect(),
            tension: self.tension,
            interrupt: self.interrupt,
        })
    }

    /// One leg; returns `|S(1) - S_1|`.
    fn arrive(
        &self,
        leg: usize,
        start: &[f64],
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64> {
        let size = self.size();
        let vectors = [0, 1, 2].map(|i| self.matrix(&start[size * i..][..size]));
        let (point, tension) = (self.points[leg].as_ref(), self.leg_tension(leg));
        let end = arrival(point, vectors, tension, accuracy, self.interrupt)?;
        let next = self.points[leg + 1].as_ref();
        for (end, values) in end.iter().zip(values.chunks_exact_mut(size)) {
            write(&tangent(next, end.as_ref()), values);
        }
        Ok(distance(end[0].as_ref(), next))
    }

    fn matrix<'b>(&self, v: &'b [f64]) -> MatRef<'b, f64> {
        let (n, k) = self.points[0].shape();
        MatRef::from_column_major_slice(v, n, k)
    }
}

impl Chain for Ambient<'_> {
    type Worker = Carrier;

    fn size(&self) -> usize {
        self.points[0].nrows() * self.points[0].ncols()
    }

    fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    fn worker(&self) -> Carrier {
        let (n, k) = self.points[0].shape();
        Carrier::new(n, k)
    }

    fn displacement_into(&self, leg: usize, out: &mut [f64]) {
        out.copy_from_slice(&entries(&self.curves[leg].initial_velocity()));
    }

    fn carry_into(
        &self,
        carrier: &mut Carrier,
        leg: usize,
        way: Direction,
        v: &[f64],
        out: &mut [f64],
    ) -> Result<()> {
        let (n, k) = self.points[0].shape();
        out.copy_from_slice(v);
        carrier.set(&self.curves[leg])?;
        let out = MatMut::from_column_major_slice_mut(out, n, k);
        carrier.carry(&self.curves[leg], out, way);
        Ok(())
    }

    fn arrive_into(
        &self,
        _: &mut Carrier,
        first: usize,
        starts: &[Vec<f64>],
        means: &Means<'_>,
        values: &mut [f64],
        distances: &mut [f64],
    ) -> Result<()> {
        let each = values.chunks_exact_mut(values.len() / starts.len());
        for (i, (start, values)) in starts.iter().zip(each).enumerate() {
            let arrived = self.arrive(first + i, start, means.accuracy, values);
            means.work.count(self.work_of_leg());
            distances[i] = arrived.map_err(|error| error.at_knot(first + i))?;
        }
        Ok(())
    }

    /// In an orthonormal basis of the span of the point and three vectors.
    fn work_of_leg(&self) -> f64 {
        let (n, k) = self.points[0].shape();
        let r = n.min(4 * k);
        work_of_curve(Sized { m: r - k, k }) + (n * r * r) as f64
    }

    fn state(&self, leg: usize, start: &[f64]) -> (Option<Mat<f64>>, State) {
        let size = self.size();
        let [v, a, j] = [0, 1, 2].map(|i| self.matrix(&start[size * i..][..size]));
        let data = Coordinates::of_checked([self.points[leg].as_ref(), v, a, j], 1.0);
        let state = State::of_coordinates(data.blocks, data.entries);
        (data.frame, state.in_tension(self.leg_tension(leg)))
    }
}

impl Movable for Ambient<'_> {
    fn work_of_knot(&self) -> f64 {
        let (n, k) = self.points[0].shape();
        let r = n.min(2 * k);
        JOINS * (work_of_join(Sized { m: r - k, k }) + (n * r * k) as f64)
    }

    /// Vectors may come from points nearby: their tangential parts count.
    fn moved(&self, shifts: &[f64], motion: &mut Motion) -> Result<Self> {
        let size = self.size();
        let moves = shifts
            .par_chunks_exact(size)
            .zip(&self.points)
            .enumerate()
            .map(|(knot, (shift, point))| {
                let shift = tangent(point.as_ref(), self.matrix(shift));
                let curve = QuasiGeodesic::from_velocity(point.as_ref(), shift.as_ref());
                curve.map_err(|error| error.at_knot(knot))
            })
            .collect::<Result<Vec<_>>>()?;
        let carried = |knot: usize, v: &mut [f64]| -> Result<()> {
            for v in v.chunks_exact_mut(size) {
                let along = tangent(self.points[knot].as_ref(), self.matrix(v));
                write(&carry(&moves[knot], along.as_ref(), 1.0)?, v);
            }
            Ok(())
        };
        for knot in 0..self.points.len() {
            carried(knot, motion.velocity_mut(knot))?;
            if knot < self.lengths.len() {
                carried(knot, motion.bend_mut(knot))?;
            }
        }
        let points = moves.iter().map(|curve| curve.point(1.0));
        let points = points.collect::<Result<Vec<_>>>()?;
        let curves = links(&points)?;
        let moved = Ambient::new(points, curves, self.lengths.clone(), self.interrupt);
        Ok(moved.in_tension(self.tension))
    }

    fn towards(&self, knot: usize, point: &Mat<f64>) -> Result<Vec<f64>> {
        let (n, k) = point.shape();
        let v = Stiefel::new(n, k)?.log(self.points[knot].as_ref(), point.as_ref())?;
        Ok(entries(&v))
    }

    fn square(&self, knot: usize, v: &[f64]) -> f64 {
        let inner = self.points[knot].transpose() * self.matrix(v);
        square(v) - 0.5 * inner.squared_norm_l2()
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
