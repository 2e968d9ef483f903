//! The states of a spline of Riemannian cubics on both sides of its knots, in units of the mean leg.

use faer::{Mat, MatRef};

use super::given::GivenEnd;
use crate::cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::product::columns;
use crate::manifold::grassmann::alignment::alignment;
use crate::solve::gmres::dot;
use crate::space::Quotient;
use crate::spline::piecewise::Piecewise;
use crate::threads::{self, scaled};

/// Microseconds of the ends of a piece between rotations, whose curve is computed for them.
const ENDS: f64 = 5.0;

pub(crate) const SOLVER: &str = "derivative of a spline";

/// Point, and the tangent vectors `g x, g x', g x''` there, shape `(n, k)` by columns.
pub(crate) type EndState = [Vec<f64>; 4];

/// States at both ends of every piece.
#[derive(Debug, Clone)]
pub(crate) struct KnotStates {
    /// In the time of the curve divided by [`KnotStates::unit`].
    pub(crate) ends: Vec<[EndState; 2]>,
    pub(crate) lengths: Vec<f64>,
    /// The mean length of a leg, in the time of the curve.
    pub(crate) unit: f64,
    /// Tension in units of the mean leg.
    pub(crate) tension: f64,
    pub(crate) quotient: Quotient,
    /// Shape of a point.
    pub(crate) shape: (usize, usize),
}

impl KnotStates {
    /// # Errors
    /// The errors of evaluating the pieces; `Interrupted`.
    pub(crate) fn new(
        curve: &Piecewise<RiemannianCubic>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let (knots, pieces) = (curve.knots(), curve.pieces());
        let unit = (knots[pieces.len()] - knots[0]) / pieces.len() as f64;
        let lengths: Vec<f64> = knots.windows(2).map(|t| (t[1] - t[0]) / unit).collect();
        let of_piece = |(): &mut (), leg: usize| {
            interrupt.check(SOLVER)?;
            let (piece, h) = (&pieces[leg], lengths[leg]);
            let mut ends = [piece.tangents(0.0)?, piece.tangents(1.0)?];
            for state in &mut ends {
                for (order, vector) in state.iter_mut().enumerate() {
                    let rate = h.powi(-(order as i32));
                    vector.iter_mut().for_each(|x| *x *= rate);
                }
            }
            Ok(ends)
        };
        let shape = (curve.n(), curve.k());
        Ok(KnotStates {
            ends: threads::map(pieces.len(), scaled(ENDS, shape), || (), of_piece)?,
            tension: pieces[0].tension() / lengths[0].powi(2),
            lengths,
            unit,
            quotient: curve.quotient(),
            shape,
        })
    }

    /// Number of knots.
    pub(crate) fn count(&self) -> usize {
        self.ends.len() + 1
    }

    /// Number of entries of a tangent vector.
    pub(crate) fn size(&self) -> usize {
        self.shape.0 * self.shape.1
    }

    /// The state at a knot: of the piece after it, at the last knot of the piece before it.
    pub(crate) fn at(&self, knot: usize) -> &EndState {
        match self.ends.get(knot) {
            Some([start, _]) => start,
            None => &self.ends[knot - 1][1],
        }
    }

    pub(crate) fn point(&self, knot: usize) -> MatRef<'_, f64> {
        self.matrix(&self.at(knot)[0])
    }

    /// A tangent vector as a matrix.
    pub(crate) fn matrix<'a>(&self, v: &'a [f64]) -> MatRef<'a, f64> {
        columns(v, self.shape.0)
    }

    /// The holonomy of a closed curve of subspaces, by which the basis at the first knot is multiplied to obtain the
    /// one at the last knot; `None` for frames, and for curves that are not closed.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(crate) fn holonomy(&self, given: [GivenEnd; 2]) -> Result<Option<Mat<f64>>> {
        if self.quotient == Quotient::Frames || given[0] != GivenEnd::OtherEnd {
            return Ok(None);
        }
        alignment(self.point(self.count() - 1), self.point(0)).map(Some)
    }

    /// `<v, w> = tr(v^T w) - tr(v^T S S^T w) / 2` at a knot.
    pub(crate) fn inner(&self, knot: usize, v: &[f64], w: &[f64]) -> f64 {
        let (n, s) = (self.shape.0, &self.at(knot)[0]);
        let mut along = 0.0;
        for (v, w) in v.chunks_exact(n).zip(w.chunks_exact(n)) {
            for s in s.chunks_exact(n) {
                along += dot(s, v) * dot(s, w);
            }
        }
        dot(v, w) - 0.5 * along
    }
}
