//! The curves that join neighbouring knots: quasi-geodesics, or geodesics between subspaces.

use faer::{Mat, MatRef};

use crate::error::Result;
use crate::manifold::QuasiGeodesic;
use crate::manifold::grassmann::joining::join_spans;
use crate::manifold::quasi_geodesic::EndpointProblem;
use crate::space::Quotient;
use crate::threads::{self, scaled};

/// Microseconds of a quasi-geodesic between neighbouring rotations.
pub(crate) const JOIN: f64 = 3.0;

/// Angle between consecutive bases up to which they count as aligned: round-off.
const ALIGNED: f64 = 16.0 * f64::EPSILON;

/// The curve that joins a knot to the next one.
#[derive(Debug, Clone)]
pub(crate) struct JoiningCurve {
    pub(crate) curve: QuasiGeodesic,
    /// For subspaces whose bases are not aligned, the matrix that maps the basis reached by the curve to the one at the
    /// knot.
    pub(crate) turn: Option<Mat<f64>>,
}

/// What `finish` makes of the quasi-geodesics between neighbours, or of the geodesics between their spans.
///
/// # Errors
/// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`, `RightAngle` and the errors of `finish`, wrapped in `AtKnot`
/// of the first of the two knots.
pub(crate) fn joining_curves<T: Send>(
    points: &[Mat<f64>],
    quotient: Quotient,
    finish: impl Fn(JoiningCurve) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let (n, k) = points[0].shape();
    threads::map(
        points.len() - 1,
        scaled(JOIN, (n, k)),
        || EndpointProblem::new(n, k),
        |problem, knot| {
            let [first, last] = [knot, knot + 1].map(|knot| points[knot].as_ref());
            let joining_curve = joining_curve(first, last, quotient, problem).and_then(&finish);
            joining_curve.map_err(|error| error.at_knot(knot))
        },
    )
}

/// The curve from one point to another.
///
/// # Errors
/// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`, `RightAngle`.
pub(crate) fn joining_curve(
    first: MatRef<'_, f64>,
    last: MatRef<'_, f64>,
    quotient: Quotient,
    problem: &mut EndpointProblem,
) -> Result<JoiningCurve> {
    match quotient {
        Quotient::Frames => {
            let mut curve = QuasiGeodesic::zeros(first.nrows(), first.ncols());
            curve.join(first, last, problem)?;
            Ok(JoiningCurve { curve, turn: None })
        }
        Quotient::Subspaces => {
            let (curve, turn) = join_spans(first, last, problem)?;
            let k = turn.nrows();
            let off = (&turn - Mat::<f64>::identity(k, k)).norm_max();
            Ok(JoiningCurve {
                curve,
                turn: (off > ALIGNED).then_some(turn),
            })
        }
    }
}
