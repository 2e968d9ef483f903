//! Knots in coordinates of the span of their data (if it is small), orthonormal to round-off, in units of the mean
//! length of a leg.

use std::sync::Arc;

use faer::traits::ComplexField;
use faer::{Mat, MatRef, Scale};

use super::chains::chain::SpannedSpace;
use super::ends::{End, EndCondition, EndConditions, Ends};
use crate::curve::span::Span;
use crate::error::Result;
use crate::linalg::complex_embedding::{embed, nearest};
use crate::linalg::product::{mul_add, mul_into};
use crate::manifold::grassmann::alignment::alignment;
use crate::manifold::tangent::tangent_part;
use crate::space::{Kind, Quotient, ScalarField};

/// Number of knots up to which the dimension is reduced: the factorisation takes time quadratic in that number.
const FEW: usize = 64;

/// Rows of small frames.
const SMALL: usize = 12;

/// Points and lengths of legs.
pub(super) struct ReducedKnots {
    kind: Kind,
    span: Span,
    /// For subspaces, the matrices that map the given bases to those of the points.
    turns: Vec<Mat<f64>>,
    pub(super) points: Vec<Mat<f64>>,
    pub(super) lengths: Vec<f64>,
    /// The mean length of a leg, in the caller's time.
    pub(super) unit: f64,
}

impl ReducedKnots {
    /// Built from checked knots; the span includes `vectors`.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn new(
        kind: Kind,
        t: &[f64],
        points: &[MatRef<'_, f64>],
        vectors: &[MatRef<'_, f64>],
    ) -> Result<Self> {
        let all = [points, vectors].concat();
        let (n, k) = points[0].shape();
        let span = if all.len() <= FEW && 2 * k * all.len() <= n {
            Span::over(kind.field, &all)
        } else {
            Span::whole()
        };
        let mut work = Polar::new(k);
        let points = points
            .iter()
            .map(|point| work.orthonormalised(kind.field.nearest(span.down(*point))))
            .collect();
        let [points, turns] = match kind.quotient {
            Quotient::Frames => [points, Vec::new()],
            Quotient::Subspaces => aligned(kind.field, points)?,
        };
        let unit = (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64;
        let lengths = t.windows(2).map(|pair| (pair[1] - pair[0]) / unit);
        Ok(ReducedKnots {
            kind,
            lengths: lengths.collect(),
            span,
            turns,
            points,
            unit,
        })
    }

    /// Built from the checked knots of a spline, closed if it is periodic.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn of_spline(
        kind: Kind,
        t: &[f64],
        points: &[MatRef<'_, f64>],
        ends: &EndConditions,
    ) -> Result<Self> {
        let mut knots = ReducedKnots::new(kind, t, points, &ends.vectors())?;
        if matches!(ends, EndConditions::Periodic) {
            knots.close()?;
        }
        Ok(knots)
    }

    /// For subspaces, the matrix that maps the basis at the first knot to the given one.
    pub(super) fn first_turn(&self) -> Option<MatRef<'_, f64>> {
        self.turns.first().map(|turn| turn.transpose())
    }

    /// The meaning of the points: frames or subspaces.
    pub(super) fn quotient(&self) -> Quotient {
        self.kind.quotient
    }

    /// Makes the last point exactly equal to the first one.
    ///
    /// # Errors
    /// `Decomposition`.
    fn close(&mut self) -> Result<()> {
        let last = self.points.len() - 1;
        if let Some(turn) = self.turns.last_mut() {
            let holonomy = alignment(self.points[0].as_ref(), self.points[last].as_ref())?;
            *turn = &*turn * holonomy;
        }
        self.points[last] = self.points[0].clone();
        Ok(())
    }

    /// Converts a vector that is tangent at a knot to `1e-9` to coordinates of the span, tangent to round-off.
    pub(super) fn down(&self, knot: usize, v: MatRef<'_, f64>) -> Mat<f64> {
        let mut low = self.kind.field.nearest(self.span.down(v));
        if let Some(turn) = self.turns.get(knot) {
            low = low * turn;
        }
        tangent_part(self.kind.quotient, self.points[knot].as_ref(), low.as_ref())
    }

    /// End conditions in the time of the mean leg, their vectors tangent at the reduced points and then converted by
    /// `entries`.
    pub(super) fn ends(
        &self,
        ends: &EndConditions,
        entries: impl Fn(usize, &Mat<f64>) -> Vec<f64>,
    ) -> Ends {
        let (last, unit) = (self.points.len() - 1, self.unit);
        let end = |knot: usize, end: &EndCondition| {
            let vector = self.down(knot, end.vector().as_ref()) * Scale(unit);
            match end {
                EndCondition::Velocity(_) => End::Velocity(entries(knot, &vector)),
                // Multiply one factor at a time: the product of the factors may overflow.
                EndCondition::Acceleration(_) => {
                    End::Acceleration(entries(knot, &(vector * Scale(unit))))
                }
            }
        };
        match ends {
            EndConditions::Natural => {
                let (r, k) = self.shape();
                let zero = Mat::zeros(r, k);
                Ends::Open([0, last].map(|knot| End::Acceleration(entries(knot, &zero))))
            }
            EndConditions::Each(each) => Ends::Open([end(0, &each[0]), end(last, &each[1])]),
            EndConditions::Periodic => Ends::Periodic,
        }
    }

    /// Converts a point near the manifold to coordinates of the span, orthonormal to round-off.
    pub(super) fn point(&self, s: MatRef<'_, f64>) -> Mat<f64> {
        let low = self.kind.field.nearest(self.span.down(s));
        Polar::new(s.ncols()).orthonormalised(low)
    }

    /// Whether frames of the whole span are small matrices, or a single leg spans it: the points have at most `max(12, 4k)`
    /// rows, half as many if they are complex.
    pub(super) fn is_small(&self) -> bool {
        let (mut r, mut k) = self.shape();
        if self.kind.field == ScalarField::Complex {
            (r, k) = (r / 2, k / 2);
        }
        r <= SMALL.max(4 * k)
    }

    /// The space of the points.
    pub(super) fn space(&self) -> SpannedSpace {
        let (n, k) = self.shape();
        let basis = self.span.basis().map(|basis| Arc::new(basis.to_owned()));
        SpannedSpace {
            n: basis.as_ref().map_or(n, |basis| basis.nrows()),
            k,
            basis,
        }
    }

    /// The tangent vector at the given basis of a knot, from coordinates.
    pub(super) fn lift_vector(
        &self,
        knot: usize,
        point: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Mat<f64> {
        let mut lifted = self.lift(v);
        if let Some(turn) = self.turns.get(knot) {
            lifted = lifted * turn.transpose();
        }
        tangent_part(self.quotient(), point, lifted.as_ref())
    }

    /// The matrix with the given coordinates.
    pub(super) fn lift(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        self.span.lift(a)
    }

    /// `(r, k)`.
    pub(super) fn shape(&self) -> (usize, usize) {
        self.points[0].shape()
    }
}

/// Bases of the same subspaces, each as near to the previous one as possible, and the matrices that map the given bases
/// to them. All of them depend on the subspaces alone, so the solution does not depend on the given bases.
fn aligned(field: ScalarField, mut points: Vec<Mat<f64>>) -> Result<[Vec<Mat<f64>>; 2]> {
    let first = match field {
        ScalarField::Real => principal_rows(points[0].as_ref()),
        ScalarField::Complex => {
            embed(principal_rows(nearest(points[0].as_ref()).as_ref()).as_ref())
        }
    };
    // Removes the round-off of the projections.
    let mut turns = vec![Polar::new(first.ncols()).orthonormalised(first)];
    points[0] = &points[0] * &turns[0];
    for knot in 1..points.len() {
        let turn = alignment(points[knot - 1].as_ref(), points[knot].as_ref())?;
        points[knot] = &points[knot] * &turn;
        turns.push(turn);
    }
    Ok([points, turns])
}

/// Relative difference in length up to which rows count as equally long: the first of them is taken.
const EQUALLY_LONG: f64 = 1e-6;

/// The orthogonal or unitary matrix whose columns are rows of a basis, orthonormalised one after another, the longest
/// remaining row first, conjugated if complex.
///
/// For the basis `Y Q` it is `Q^H` times the matrix for `Y`.
fn principal_rows<T: ComplexField<Real = f64>>(y: MatRef<'_, T>) -> Mat<T> {
    let (n, k) = y.shape();
    let mut rest = y.to_owned();
    let mut out = Mat::zeros(k, k);
    for col in 0..k {
        let lengths: Vec<f64> = (0..n).map(|row| rest.row(row).norm_l2()).collect();
        let longest = lengths
            .iter()
            .fold(0.0_f64, |most, length| most.max(*length));
        let is_long = |length: &f64| *length >= (1.0 - EQUALLY_LONG) * longest;
        let row = lengths.iter().position(is_long).unwrap_or(0);
        let direction = rest.row(row) * Scale(T::from_f64_impl(longest.recip()));
        out.col_mut(col).copy_from(direction.adjoint());
        let along = &rest * direction.adjoint();
        rest -= along * direction;
    }
    out
}

/// Buffers for a Newton step towards the polar factor of a point.
struct Polar {
    before: Mat<f64>,
    gram: Mat<f64>,
}

impl Polar {
    fn new(k: usize) -> Self {
        Polar {
            before: Mat::new(),
            gram: Mat::zeros(k, k),
        }
    }

    /// Makes a point that is orthonormal to `1e-9` orthonormal to round-off, by one Newton step.
    fn orthonormalised(&mut self, mut s: Mat<f64>) -> Mat<f64> {
        let Polar { before, gram } = self;
        mul_into(&mut *gram, 0.5, s.transpose(), &s);
        before.resize_with(s.nrows(), s.ncols(), |_, _| 0.0);
        before.copy_from(&s);
        s *= Scale(1.5);
        mul_add(&mut s, -1.0, &*before, &*gram);
        s
    }
}
