//! A chain in many dimensions: vectors are matrices as tall as the points, and every leg is integrated in the span of
//! its data.
//!
//! Work and memory are linear in the number of rows.

use std::sync::Arc;

use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use super::chain::{Chain, JOINS, Means, Movable, square};
use super::embedded::InEmbedding;
use super::motion::Motion;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::Coordinates;
use crate::cubic::taylor::state::State;
use crate::cubic::taylor::work::{work_of_curve, work_of_join};
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::product::entries;
use crate::linalg::structure::distance;
use crate::manifold::carrier::{Carrier, carried};
use crate::manifold::grassmann::alignment::alignment;
use crate::manifold::tangent::tangent_part;
use crate::manifold::{Grassmann, QuasiGeodesic, Stiefel};
use crate::solve::direction::Direction;
use crate::space::{Kind, Quotient};
use crate::spline::chains::integrated_legs::{Passage, end_of_leg};
use crate::spline::joining_curves::{JoiningCurve, joining_curves};
use crate::threads::{self, ALWAYS};

/// Knots, and the quasi-geodesics between them.
pub(crate) struct Ambient<'a> {
    kind: Kind,
    points: Vec<Mat<f64>>,
    joining_curves: Vec<JoiningCurve>,
    lengths: Vec<f64>,
    tension: f64,
    interrupt: Interrupt<'a>,
}

impl<'a> Ambient<'a> {
    /// # Errors
    /// An error if neighbouring knots cannot be joined.
    pub(crate) fn new(
        kind: Kind,
        points: Vec<Mat<f64>>,
        lengths: Vec<f64>,
        interrupt: Interrupt<'a>,
    ) -> Result<Self> {
        Ok(Ambient {
            kind,
            joining_curves: joining_curves(&points, kind.quotient, Ok)?,
            points,
            lengths,
            tension: 0.0,
            interrupt,
        })
    }

    /// The same chain for curves in tension.
    pub(crate) fn in_tension(mut self, tension: f64) -> Self {
        self.tension = tension;
        self
    }

    /// The tension in the time of a leg.
    fn leg_tension(&self, leg: usize) -> f64 {
        self.tension * self.lengths[leg].powi(2)
    }

    /// Integrates one leg; returns `|S(1) - S_1|`.
    fn arrive(
        &self,
        leg: usize,
        start: &[f64],
        means: &Means<'_>,
        values: &mut [f64],
    ) -> Result<f64> {
        let size = self.size();
        let vectors = [0, 1, 2].map(|i| self.matrix(&start[size * i..][..size]));
        let passage = Passage {
            tension: self.leg_tension(leg),
            accuracy: means.accuracy,
            kind: self.kind,
            work: means.work,
            interrupt: self.interrupt,
        };
        means.work.count(self.work_of_span());
        let (quotient, next) = (self.kind.quotient, self.points[leg + 1].as_ref());
        let mut end = end_of_leg(self.points[leg].as_ref(), vectors, &passage)?;
        if quotient == Quotient::Subspaces {
            // Expressed in the basis at the knot.
            let turn = alignment(next, end[0].as_ref())?;
            end = end.map(|a| a * &turn);
        }
        for (end, values) in end.iter().zip(values.chunks_exact_mut(size)) {
            write(&tangent_part(quotient, next, end.as_ref()), values);
        }
        Ok(distance(end[0].as_ref(), next))
    }

    /// Work of an orthonormal basis of the span of a leg.
    fn work_of_span(&self) -> f64 {
        let (n, k) = self.points[0].shape();
        (n * n.min(4 * k).pow(2)) as f64
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
        out.copy_from_slice(&entries(self.joining_curves[leg].curve.initial_velocity()));
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
        let JoiningCurve { curve, turn } = &self.joining_curves[leg];
        out.copy_from_slice(v);
        carrier.set(curve)?;
        let mut out = MatMut::from_column_major_slice_mut(out, n, k);
        if let (Some(turn), Direction::Backward) = (turn, way) {
            out.copy_from(out.rb() * turn.transpose());
        }
        carrier.carry(curve, out.rb_mut(), way);
        if let (Some(turn), Direction::Forward) = (turn, way) {
            out.copy_from(out.rb() * turn);
        }
        Ok(())
    }

    fn ends_into(
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
            let arrived = self.arrive(first + i, start, means, values);
            distances[i] = arrived.map_err(|error| error.at_knot(first + i))?;
        }
        Ok(())
    }

    /// Legs are integrated in an orthonormal basis of the span of the point and three vectors.
    fn work_of_leg(&self) -> f64 {
        let (n, k) = self.points[0].shape();
        let r = n.min(4 * k);
        work_of_curve(Sizes::frames(r - k, k)) + self.work_of_span()
    }

    fn state(&self, leg: usize, start: &[f64]) -> (Option<Mat<f64>>, State) {
        let size = self.size();
        let [v, a, j] = [0, 1, 2].map(|i| self.matrix(&start[size * i..][..size]));
        let data = [self.points[leg].as_ref(), v, a, j];
        let kind = Kind::real(self.kind.quotient);
        let data = Coordinates::of_checked(data, 1.0, kind);
        let state = State::of_coordinates(data.blocks, data.entries);
        (data.frame, state.in_tension(self.leg_tension(leg)))
    }
}

impl InEmbedding for Ambient<'_> {
    fn points(&self) -> Vec<Mat<f64>> {
        self.points.clone()
    }

    fn matrix_of(&self, _: usize, v: &[f64]) -> Mat<f64> {
        self.matrix(v).to_owned()
    }

    fn vector_of(&self, _: usize, v: MatRef<'_, f64>) -> Vec<f64> {
        entries(v.to_owned())
    }

    fn frames_of_space(&self) -> Option<Arc<[Mat<f64>]>> {
        None
    }

    fn kind(&self) -> Kind {
        self.kind
    }

    fn space(&self) -> (Sizes, usize) {
        let (n, k) = self.points[0].shape();
        let r = n.min(4 * k);
        (Sizes::new(r - k, k, self.kind.quotient), k)
    }

    fn tension(&self) -> f64 {
        self.tension
    }
}

impl Movable for Ambient<'_> {
    fn work_of_knot(&self) -> f64 {
        let (n, k) = self.points[0].shape();
        let r = n.min(2 * k);
        JOINS * (work_of_join(Sizes::frames(r - k, k)) + (n * r * k) as f64)
    }

    /// Vectors may come from points nearby, so only their tangential parts are used.
    fn moved(&self, shifts: &[f64], motion: &mut Motion) -> Result<Self> {
        let size = self.size();
        let along = |(): &mut (), knot: usize| {
            let (point, shift) = (self.points[knot].as_ref(), &shifts[size * knot..][..size]);
            let shift = tangent_part(self.kind.quotient, point, self.matrix(shift));
            let curve = QuasiGeodesic::from_velocity(point, shift.as_ref());
            curve.map_err(|error| error.at_knot(knot))
        };
        let moves = threads::map(self.points.len(), ALWAYS, || (), along)?;
        let carried = |knot: usize, v: &mut [f64]| -> Result<()> {
            for v in v.chunks_exact_mut(size) {
                let point = self.points[knot].as_ref();
                let along = tangent_part(self.kind.quotient, point, self.matrix(v));
                write(&carried(&moves[knot], along.as_ref(), 1.0)?, v);
            }
            Ok(())
        };
        for knot in 0..self.points.len() {
            carried(knot, motion.velocity_mut(knot))?;
            if knot < self.lengths.len() {
                carried(knot, motion.derivatives_mut(knot))?;
            }
        }
        let points = moves.iter().map(|curve| curve.point(1.0));
        let points = points.collect::<Result<Vec<_>>>()?;
        let lengths = self.lengths.clone();
        let moved = Ambient::new(self.kind, points, lengths, self.interrupt)?;
        Ok(moved.in_tension(self.tension))
    }

    fn towards(&self, knot: usize, point: &Mat<f64>) -> Result<Vec<f64>> {
        let (n, k) = point.shape();
        let here = self.points[knot].as_ref();
        let v = match self.kind.quotient {
            Quotient::Frames => Stiefel::new(n, k)?.log(here, point.as_ref())?,
            Quotient::Subspaces => Grassmann::new(n, k)?.log(here, point.as_ref())?,
        };
        Ok(entries(&v))
    }

    fn square(&self, knot: usize, v: &[f64]) -> f64 {
        let inner = self.points[knot].transpose() * self.matrix(v);
        square(v) - 0.5 * inner.squared_norm_l2()
    }
}

fn write(a: &Mat<f64>, out: &mut [f64]) {
    for (out, column) in out.chunks_exact_mut(a.nrows()).zip(a.col_iter()) {
        for (out, x) in out.iter_mut().zip(column.iter()) {
            *out = *x;
        }
    }
}
