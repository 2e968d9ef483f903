//! Starts of Newton's method from curves that have the boundary data but are no Riemannian cubics.
//!
//! Their covariant accelerations and jerks at the start are guesses.

use faer::Mat;

use super::initial::Horizontal;
use super::problem::{Problem, pack};
use crate::curve::{Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

/// Unknowns up to which polynomials of least cost are looked for.
const MINIMAL_COST_UNKNOWNS: usize = 64;

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

    /// `(x', x'')` at the start of the curve of a problem; `None` if the family has none.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn start(
        self,
        problem: &Problem,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Vec<f64>>> {
        let ends = problem.initial();
        let [s0, v0] = ends.each_ref().map(|x| x.as_ref());
        let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
        let start = match self {
            CurveFamily::Geometric => GeometricCubic::from_boundary(s0, v0, s1, v1)
                .and_then(|curve| start_of(problem, &curve)),
            CurveFamily::Geodesic => GeodesicPolynomial::from_boundary(s0, v0, s1, v1)
                .and_then(|curve| start_of(problem, &curve)),
            CurveFamily::MinimalCost(degree) => {
                if problem.unknowns() > MINIMAL_COST_UNKNOWNS {
                    return Ok(None);
                }
                GeometricPolynomial::minimal_cost_interruptible(s0, v0, s1, v1, degree, interrupt)
                    .and_then(|(curve, _)| start_of(problem, &curve))
            }
        };
        match start {
            Ok(start) => Ok(Some(start)),
            Err(error @ Error::Interrupted { .. }) => Err(error),
            Err(_) => Ok(None),
        }
    }
}

/// `(x', x'')` of a curve at the start.
fn start_of(problem: &Problem, curve: &impl Curve) -> Result<Vec<f64>> {
    let (r, _) = problem.end[0].shape();
    let identity = Mat::identity(r, r);
    let horizontal = |v: Mat<f64>| Horizontal::of_tangent(identity.as_ref(), v.as_ref());
    let a = horizontal(curve.acceleration(0.0)?);
    // j = x'' + [x, x']_m / 2.
    let second = horizontal(curve.jerk(0.0)?).plus_bracket(-0.5, &problem.velocity, &a);
    Ok(pack(&[a, second]))
}
