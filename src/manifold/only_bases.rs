//! Frames that are far apart only since their columns are turned: bases of subspaces that are close.

use faer::MatRef;

use super::grassmann::joining::alignment;
use crate::linalg::structure::distance;

/// Frames this far apart in the Frobenius norm, and the nearest bases of their spans at most half as far, are taken for bases.
const FAR: f64 = 1.0;

/// How far two frames are apart, and the nearest bases of their spans, in the Frobenius norm; `None` for frames that are not bases.
pub(crate) fn apart(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Option<[f64; 2]> {
    if s0.nrows() == s0.ncols() {
        return None;
    }
    let turn = alignment(s0, s1).ok()?;
    let [frames, subspaces] = [distance(s0, s1), distance(s0, (s1 * turn).as_ref())];
    (frames > FAR && 2.0 * subspaces < frames).then_some([frames, subspaces])
}
