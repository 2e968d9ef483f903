//! Quasi-geodesics between neighbouring knots (geodesics between subspaces), along which vectors are carried from knot
//! to knot: for geometric splines, splines of flat space, and velocities from points.

use faer::{Mat, MatMut, MatRef};

use crate::error::Result;
use crate::legs::{End, Knots};
use crate::linalg::field::add;
use crate::linalg::product::{axpy, columns, columns_mut};
use crate::manifold::QuasiGeodesic;
use crate::manifold::carrier::Carrier;
use crate::solve::direction::Direction;
use crate::solve::tridiagonal::Isometries;
use crate::space::Quotient;
use crate::spline::joining_curves::{JoiningCurve, joining_curves};

/// The curves, in order.
pub(crate) struct Links {
    links: Vec<GeodesicLink>,
}

struct GeodesicLink {
    curve: QuasiGeodesic,
    carrier: Carrier,
    /// Velocities at the start and at the end.
    displacements: [Mat<f64>; 2],
}

impl GeodesicLink {
    fn new(JoiningCurve { curve, turn }: JoiningCurve) -> Result<Self> {
        let mut carrier = Carrier::new(curve.n(), curve.k());
        carrier.set(&curve)?;
        if let Some(turn) = &turn {
            carrier.turn_basis(turn);
        }
        let first = curve.initial_velocity();
        let mut last = first.clone();
        carrier.carry(&curve, last.as_mut(), Direction::Forward);
        Ok(GeodesicLink {
            curve,
            carrier,
            displacements: [first, last],
        })
    }
}

impl Links {
    /// # Errors
    /// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`, `RightAngle`, `Decomposition`, wrapped in `AtKnot` of
    /// the first of the two points.
    pub(crate) fn new(points: &[Mat<f64>], quotient: Quotient) -> Result<Self> {
        let links = joining_curves(points, quotient, GeodesicLink::new)?;
        Ok(Links { links })
    }

    /// The velocity of a link at its start.
    pub(crate) fn first(&self, link: usize) -> &Mat<f64> {
        &self.links[link].displacements[0]
    }

    /// The velocity of a link at its end.
    pub(crate) fn last(&self, link: usize) -> &Mat<f64> {
        &self.links[link].displacements[1]
    }

    /// The right-hand sides of a cubic spline of flat space, of `n k` entries per knot, for the velocities at the
    /// knots; given velocities and accelerations enter the equations of their knots.
    ///
    /// ```math
    /// \frac{2 v_{i-1} + 4 v_i}{h_-} + \frac{4 v_i + 2 v_{i+1}}{h_+}
    ///     = 6 \Bigl( \frac{\Delta_-}{h_-^2} + \frac{\Delta_+}{h_+^2} \Bigr)
    /// ```
    ///
    /// with the displacements of the links, carried from knot to knot.
    pub(crate) fn right_sides(&self, knots: &Knots<'_>) -> Vec<f64> {
        let (count, size) = (knots.count(), self.size());
        let mut right = vec![0.0; count * size];
        for (leg, h) in knots.lengths.iter().enumerate() {
            for (knot, displacement) in
                [(leg, self.first(leg)), ((leg + 1) % count, self.last(leg))]
            {
                let here = &mut right[knot * size..][..size];
                axpy(
                    columns_mut(here, displacement.nrows()),
                    6.0 / (h * h),
                    displacement,
                );
            }
        }
        for (knot, right) in right.chunks_exact_mut(size).enumerate() {
            match knots.end_at(knot) {
                Some((End::Velocity(v), _)) => right.copy_from_slice(v),
                Some((End::Acceleration(a), sign)) => add(right, -sign, a),
                None => {}
            }
        }
        right
    }

    /// Carries a vector from one end of a link to the other.
    pub(crate) fn carry(
        &mut self,
        link: usize,
        v: MatRef<'_, f64>,
        mut to: MatMut<'_, f64>,
        way: Direction,
    ) {
        let GeodesicLink { curve, carrier, .. } = &mut self.links[link];
        to.copy_from(v);
        carrier.carry(curve, to, way);
    }
}

impl Isometries for Links {
    fn size(&self) -> usize {
        let (n, k) = self.first(0).shape();
        n * k
    }

    fn carry_into(
        &mut self,
        link: usize,
        way: Direction,
        from: &[f64],
        to: &mut [f64],
    ) -> Result<()> {
        let n = self.first(link).nrows();
        self.carry(link, columns(from, n), columns_mut(to, n), way);
        Ok(())
    }
}
