//! Hint in errors about frames whose spans are much closer than the frames: they may be bases of subspaces.

use super::prelude::*;
use crate::manifold::only_bases::apart;

/// Adds to an error about two points their distances as frames and as subspaces, if these suggest that the points are
/// bases.
pub(super) fn advised(error: Error, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Error {
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

/// Adds the hint to an error about consecutive points.
pub(super) fn advised_knots(error: Error, points: &[MatRef<'_, f64>]) -> Error {
    let at =
        |knot: usize, error: Error| advised(error, points[knot], points[knot + 1]).at_knot(knot);
    match error {
        Error::AtKnot { knot, source } if knot + 1 < points.len() => at(knot, *source),
        error if error.is_about_distance() => {
            let pairs = points.windows(2);
            match pairs
                .map(|pair| apart(pair[0], pair[1]))
                .position(|found| found.is_some())
            {
                Some(knot) => at(knot, error),
                None => error,
            }
        }
        error => error,
    }
}
