//! Frames that are far apart only because their columns are rotated: bases of nearby subspaces.

use faer::MatRef;

use super::grassmann::joining::alignment;
use crate::linalg::structure::distance;

/// Frames at least this far apart in the Frobenius norm, with nearest bases of their spans at most half as far apart,
/// are taken for mere bases.
const FAR: f64 = 1.0;

/// The Frobenius distances of two frames, and of the nearest bases of their spans; `None` unless the frames look like
/// mere bases.
pub(crate) fn apart(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Option<[f64; 2]> {
    if s0.nrows() == s0.ncols() {
        return None;
    }
    let turn = alignment(s0, s1).ok()?;
    let [frames, subspaces] = [distance(s0, s1), distance(s0, (s1 * turn).as_ref())];
    (frames > FAR && 2.0 * subspaces < frames).then_some([frames, subspaces])
}
