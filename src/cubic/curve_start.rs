//! Starts of Newton's method from curves that have the boundary data but are no Riemannian cubics.
//!
//! Their covariant accelerations and jerks at the start are guesses, their costs upper bounds: the cheapest Riemannian cubic
//! costs at most as much as any curve with the same data.

use faer::Mat;

use super::initial::Horizontal;
use super::problem::{Problem, pack};
use crate::curve::cost::rough_squared_acceleration;
use crate::curve::{Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

/// Unknowns up to which polynomials of least cost are looked for.
const MINIMAL_COST_UNKNOWNS: usize = 64;

/// Nodes of the quadrature of costs.
const NODES: usize = 32;

/// A family of curves that has one for most boundary data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CurveFamily {
    /// The adjusted de Casteljau algorithm.
    Geometric,
    /// De Casteljau's algorithm with geodesics.
    Geodesic,
    /// The geometric polynomial of a degree that costs least.
    MinimalCost(usize),
}

impl CurveFamily {
    /// From the cheapest to compute on.
    pub(super) const ALL: [CurveFamily; 6] = [
        CurveFamily::Geometric,
        CurveFamily::Geodesic,
        CurveFamily::MinimalCost(4),
        CurveFamily::MinimalCost(5),
        CurveFamily::MinimalCost(6),
        CurveFamily::MinimalCost(7),
    ];

    /// Those beside the geometric one that take little more than a solution of most problems.
    pub(super) const QUICK: [CurveFamily; 2] = [CurveFamily::Geodesic, CurveFamily::MinimalCost(5)];

    /// Whether its curve is the result of a search of its own.
    pub(super) fn is_of_least_cost(self) -> bool {
        matches!(self, CurveFamily::MinimalCost(_))
    }

    /// The start from the curve of a problem; none where the family has none.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn start(
        self,
        problem: &Problem,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<CurveStart>> {
        let ends = problem.initial();
        let [s0, v0] = ends.each_ref().map(|x| x.as_ref());
        let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
        let start = match self {
            CurveFamily::Geometric => GeometricCubic::from_boundary(s0, v0, s1, v1)
                .and_then(|curve| CurveStart::new(problem, &curve)),
            CurveFamily::Geodesic => GeodesicPolynomial::from_boundary(s0, v0, s1, v1)
                .and_then(|curve| CurveStart::new(problem, &curve)),
            CurveFamily::MinimalCost(degree) => {
                if problem.unknowns() > MINIMAL_COST_UNKNOWNS {
                    return Ok(None);
                }
                GeometricPolynomial::minimal_cost_interruptible(s0, v0, s1, v1, degree, interrupt)
                    .and_then(|(curve, _)| CurveStart::new(problem, &curve))
            }
        };
        match start {
            Ok(start) => Ok(Some(start)),
            Err(error @ Error::Interrupted { .. }) => Err(error),
            Err(_) => Ok(None),
        }
    }
}

/// What Newton's method needs of a curve, and the cost of that.
pub(super) struct CurveStart {
    /// `(x', x'')` at the start.
    pub(super) y: Vec<f64>,
    /// To about a percent.
    pub(super) cost: f64,
}

impl CurveStart {
    fn new(problem: &Problem, curve: &impl Curve) -> Result<Self> {
        let (r, _) = problem.end[0].shape();
        let identity = Mat::identity(r, r);
        let horizontal = |v: Mat<f64>| Horizontal::of_tangent(identity.as_ref(), v.as_ref());
        let a = horizontal(curve.acceleration(0.0)?);
        // j = x'' + [x, x']_m / 2.
        let second = horizontal(curve.jerk(0.0)?).plus_bracket(-0.5, &problem.velocity, &a);
        Ok(CurveStart {
            y: pack(&[a, second]),
            cost: rough_squared_acceleration(curve, NODES)?,
        })
    }
}
