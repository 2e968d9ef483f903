//! Knots in the coordinates of the span of their data (where it is small), orthonormal to round-off, in units of the mean
//! length of a leg.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::Space;
use crate::curve::span::Span;
use crate::linalg::product::{mul_add, mul_into};
use crate::linalg::structure::symmetric_part;

/// The factorisation that reduces the dimension takes time quadratic in the number of knots: for so many it pays.
const FEW: usize = 64;

/// Rows of small frames.
const SMALL: usize = 12;

/// Points and lengths of legs.
pub(super) struct ReducedKnots {
    span: Span,
    pub(super) points: Vec<Mat<f64>>,
    pub(super) lengths: Vec<f64>,
    /// The mean length of a leg, in the caller's time.
    pub(super) unit: f64,
}

impl ReducedKnots {
    /// Of checked knots; `vectors` are in the span as well.
    pub(super) fn new(t: &[f64], points: &[MatRef<'_, f64>], vectors: &[MatRef<'_, f64>]) -> Self {
        let all = [points, vectors].concat();
        let (n, k) = points[0].shape();
        let span = if all.len() <= FEW && 2 * k * all.len() <= n {
            Span::of(&all)
        } else {
            Span::whole()
        };
        let mut gram = Mat::zeros(k, k);
        let points = points
            .iter()
            .map(|point| orthonormalised(span.down(*point), &mut gram))
            .collect();
        let unit = (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64;
        let lengths = t.windows(2).map(|pair| (pair[1] - pair[0]) / unit);
        ReducedKnots {
            lengths: lengths.collect(),
            span,
            points,
            unit,
        }
    }

    /// The last point is the first one, to the last bit.
    pub(super) fn close(&mut self) {
        let last = self.points.len() - 1;
        self.points[last] = self.points[0].clone();
    }

    /// A vector that is tangent at a knot to `1e-9`, in the coordinates of the span and tangent to round-off.
    pub(super) fn down(&self, knot: usize, v: MatRef<'_, f64>) -> Mat<f64> {
        tangent_part(self.points[knot].as_ref(), self.span.down(v))
    }

    /// A point near the manifold in the coordinates of the span, orthonormal to round-off.
    pub(super) fn point(&self, s: MatRef<'_, f64>) -> Mat<f64> {
        orthonormalised(self.span.down(s), &mut Mat::zeros(s.ncols(), s.ncols()))
    }

    /// Whether frames of the whole span are small matrices, or a leg spans all of it.
    pub(super) fn is_small(&self) -> bool {
        let (r, k) = self.shape();
        r <= SMALL.max(4 * k)
    }

    /// Where the points are.
    pub(super) fn space(&self) -> Space {
        let (n, k) = self.shape();
        let basis = self.span.basis().map(|basis| Arc::new(basis.to_owned()));
        Space {
            n: basis.as_ref().map_or(n, |basis| basis.nrows()),
            k,
            basis,
        }
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

/// `V - S sym(S^T V)`.
pub(super) fn tangent_part(s: MatRef<'_, f64>, v: Mat<f64>) -> Mat<f64> {
    let along = s.transpose() * &v;
    v - s * symmetric_part(along.as_ref())
}

/// A point that is orthonormal to `1e-9` made so to round-off: one Newton step towards its polar factor.
fn orthonormalised(mut s: Mat<f64>, gram: &mut Mat<f64>) -> Mat<f64> {
    mul_into(&mut *gram, 0.5, s.transpose(), &s);
    let before = s.clone();
    s *= faer::Scale(1.5);
    mul_add(&mut s, -1.0, &before, &*gram);
    s
}
