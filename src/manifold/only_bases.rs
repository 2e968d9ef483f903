//! Frames that are far apart only because their columns are rotated: bases of nearby subspaces.

use faer::{Mat, MatRef};

use super::grassmann::alignment::unique_alignment;
use crate::error::Error;
use crate::linalg::structure::distance;
use crate::space::Quotient;

/// Frames further apart than this in the root mean square of their columns, which is a rotation of all of them by 60
/// degrees, and more than twice as far as the nearest bases of their spans, are taken for mere bases.
const FAR: f64 = 1.0;

/// The Frobenius distances of two frames, and of the nearest bases of their spans; `None` unless the frames look like
/// mere bases. Unit vectors and square matrices never do: the first are points of a sphere, the second span everything.
fn apart(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Option<[f64; 2]> {
    let (n, k) = s0.shape();
    let frames = distance(s0, s1);
    if k == 1 || n == k || frames <= FAR * (k as f64).sqrt() {
        return None;
    }
    let (turn, _) = unique_alignment(s0, s1).ok()?;
    let subspaces = distance(s0, (s1 * turn).as_ref());
    (2.0 * subspaces < frames).then_some([frames, subspaces])
}

/// What consecutive points seem to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Appearance {
    /// Frames, or subspaces that are meant as such.
    Usual,
    /// Frames that are mere bases.
    Bases,
}

/// What points with a given meaning seem to be.
pub(crate) fn appearance(quotient: Quotient, points: &[Mat<f64>]) -> Appearance {
    let points: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
    match quotient {
        Quotient::Frames if first_of_many(&points).is_some() => Appearance::Bases,
        Quotient::Frames | Quotient::Subspaces => Appearance::Usual,
    }
}

/// The index of the first of several points that looks like a mere basis beside the next one, if more than half of them
/// do.
fn first_of_many(points: &[MatRef<'_, f64>]) -> Option<usize> {
    let pairs = points.windows(2).enumerate();
    let turned = pairs.filter(|(_, pair)| apart(pair[0], pair[1]).is_some());
    let turned: Vec<usize> = turned.map(|(knot, _)| knot).collect();
    let are_most = 2 * turned.len() >= points.len();
    turned.first().copied().filter(|_| are_most)
}

/// Adds to an error about two points the distances of the frames and of the nearest bases of their spans, if these
/// suggest that the points are mere bases.
pub(crate) fn advised(error: Error, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Error {
    if !error.is_about_distance() {
        return error;
    }
    match apart(s0, s1) {
        Some([frames, subspaces]) => Error::OnlyBases {
            source: Box::new(error),
            frames,
            subspaces,
        },
        None => error,
    }
}

/// Adds the hint to an error about a leg between consecutive points, or about all of them, if they are meant as frames.
pub(crate) fn advised_knots(error: Error, quotient: Quotient, points: &[MatRef<'_, f64>]) -> Error {
    match error {
        error if quotient == Quotient::Subspaces => error,
        Error::AtKnot { knot, source } if matches!(*source, Error::UnevenTimes { .. }) => {
            // Uneven times explain less.
            let uneven = Error::AtKnot { knot, source };
            match advised_curve(uneven.cause().clone(), quotient, points) {
                bases @ Error::AtKnot { .. } => bases,
                _ => uneven,
            }
        }
        Error::AtKnot { knot, source } if knot + 1 < points.len() => {
            advised(*source, points[knot], points[knot + 1]).at_knot(knot)
        }
        error => advised_curve(error, quotient, points),
    }
}

/// Adds the hint to an error about all points together.
pub(crate) fn advised_curve(error: Error, quotient: Quotient, points: &[MatRef<'_, f64>]) -> Error {
    if quotient == Quotient::Subspaces || !error.is_about_distance() {
        return error;
    }
    match first_of_many(points) {
        Some(knot) => advised(error, points[knot], points[knot + 1]).at_knot(knot),
        None => error,
    }
}
