//! The states of a spline of Riemannian cubics on both sides of its knots, in units of the mean leg.

use faer::{Mat, MatRef, Scale};
use rayon::prelude::*;

use super::given::Given;
use super::piecewise::Piecewise;
use crate::cubic::RiemannianCubic;
use crate::cubic::turning::{bracket_of, lowered};
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::dot;
use crate::manifold::grassmann::joining::alignment;
use crate::space::Quotient;

pub(super) const SOLVER: &str = "derivative of a spline";

/// Point, and the tangent vectors `g x, g x', g x''` there, shape `(n, k)`.
pub(super) type State = [Mat<f64>; 4];

/// States at both ends of every piece.
#[derive(Debug, Clone)]
pub(super) struct KnotStates {
    /// In the time of the curve divided by [`KnotStates::unit`].
    pub(super) ends: Vec<[State; 2]>,
    pub(super) lengths: Vec<f64>,
    /// The mean length of a leg, in the time of the curve.
    pub(super) unit: f64,
    /// Tension in units of the mean leg.
    pub(super) tension: f64,
    pub(super) quotient: Quotient,
}

/// Point, velocity, covariant acceleration and covariant jerk at both ends of every piece, in its own time.
///
/// # Errors
/// The errors of evaluating the pieces; `Interrupted`.
pub(super) fn piece_states(
    curve: &Piecewise<RiemannianCubic>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<[State; 2]>> {
    let of_piece = |piece: &RiemannianCubic| {
        interrupt.check(SOLVER)?;
        Ok([piece.state(0.0)?, piece.state(1.0)?])
    };
    curve.pieces().par_iter().map(of_piece).collect()
}

impl KnotStates {
    /// Built from the states of the pieces.
    pub(super) fn new(curve: &Piecewise<RiemannianCubic>, states: &[[State; 2]]) -> Self {
        let (knots, pieces) = (curve.knots(), curve.pieces());
        let unit = (knots[pieces.len()] - knots[0]) / pieces.len() as f64;
        let lengths: Vec<f64> = knots.windows(2).map(|t| (t[1] - t[0]) / unit).collect();
        let quotient = curve.quotient();
        let scaled = |[s, v, a, j]: &State, h: f64| {
            let bracket = bracket_of(quotient, s.as_ref(), v.as_ref(), a.as_ref());
            [
                s.clone(),
                v * Scale(1.0 / h),
                a * Scale(h.powi(-2)),
                (j - bracket * Scale(0.5)) * Scale(h.powi(-3)),
            ]
        };
        let ends = states.iter().zip(&lengths);
        let ends = ends.map(|(ends, h)| ends.each_ref().map(|state| scaled(state, *h)));
        KnotStates {
            ends: ends.collect(),
            tension: pieces[0].tension() / lengths[0].powi(2),
            lengths,
            unit,
            quotient,
        }
    }

    /// Number of knots.
    pub(super) fn count(&self) -> usize {
        self.ends.len() + 1
    }

    /// The state at a knot: of the piece after it, at the last knot of the piece before it.
    pub(super) fn at(&self, knot: usize) -> &State {
        match self.ends.get(knot) {
            Some([start, _]) => start,
            None => &self.ends[knot - 1][1],
        }
    }

    pub(super) fn point(&self, knot: usize) -> MatRef<'_, f64> {
        self.at(knot)[0].as_ref()
    }

    /// The holonomy of a closed curve of subspaces, by which the basis at the first knot is multiplied to obtain the
    /// one at the last knot; `None` for frames, and for curves that are not closed.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn holonomy(&self, given: [Given; 2]) -> Result<Option<Mat<f64>>> {
        if self.quotient == Quotient::Frames || given[0] != Given::OtherEnd {
            return Ok(None);
        }
        alignment(self.point(self.count() - 1), self.point(0)).map(Some)
    }

    /// `<v, w>` at a knot.
    pub(super) fn inner(&self, knot: usize, v: &Mat<f64>, w: &Mat<f64>) -> f64 {
        dot(v.as_ref(), lowered(self.point(knot), w.as_ref()).as_ref())
    }
}
