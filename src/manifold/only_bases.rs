//! Frames that are far apart only because their columns are rotated: bases of nearby subspaces.

use faer::MatRef;

use super::grassmann::joining::alignment;
use crate::error::Error;
use crate::linalg::structure::distance;
use crate::space::Quotient;

/// Frames at least this far apart in the Frobenius norm, with nearest bases of their spans at most half as far apart,
/// are taken for mere bases.
const FAR: f64 = 1.0;

/// The Frobenius distances of two frames, and of the nearest bases of their spans; `None` unless the frames look like
/// mere bases.
pub(crate) fn apart(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Option<[f64; 2]> {
    let frames = distance(s0, s1);
    if frames <= FAR || s0.nrows() == s0.ncols() {
        return None;
    }
    let turn = alignment(s0, s1).ok()?;
    let subspaces = distance(s0, (s1 * turn).as_ref());
    (2.0 * subspaces < frames).then_some([frames, subspaces])
}

/// The index of the first point that looks like a mere basis beside the next one.
pub(crate) fn position(points: &[MatRef<'_, f64>]) -> Option<usize> {
    let mut pairs = points.windows(2);
    pairs.position(|pair| apart(pair[0], pair[1]).is_some())
}

/// Adds to an error about two points the distances of the frames and of the nearest bases of their spans, if these
/// suggest that the points are mere bases.
pub(crate) fn advised(error: Error, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Error {
    let found = match error.is_about_distance() {
        true => apart(s0, s1),
        false => None,
    };
    match found {
        Some([frames, subspaces]) => Error::OnlyBases {
            source: Box::new(error),
            frames,
            subspaces,
        },
        None => error,
    }
}

/// Adds the hint to an error about consecutive points, if they are meant as frames.
pub(crate) fn advised_knots(error: Error, quotient: Quotient, points: &[MatRef<'_, f64>]) -> Error {
    let knot = match &error {
        _ if quotient == Quotient::Subspaces => None,
        Error::AtKnot { knot, .. } => Some(*knot).filter(|knot| knot + 1 < points.len()),
        error if error.is_about_distance() => position(points),
        _ => None,
    };
    match (knot, error) {
        (Some(knot), Error::AtKnot { source: error, .. }) => {
            advised(*error, points[knot], points[knot + 1]).at_knot(knot)
        }
        (Some(knot), error) => advised(error, points[knot], points[knot + 1]).at_knot(knot),
        (None, error) => error,
    }
}
