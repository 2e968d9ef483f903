//! What errors add where frames are far apart only since their columns are turned: they may be bases of subspaces.

use super::prelude::*;
use crate::manifold::only_bases::apart;

/// An error about two points, with their distances as frames and as subspaces where these tell that they may be bases.
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

/// The same for points in a row.
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
