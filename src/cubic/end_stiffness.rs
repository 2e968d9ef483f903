//! The second derivative of the cost of a cubic by points and velocities at its ends, in the time in which it takes one unit.
//!
//! With displacements `u` of the ends in their frames and `w` the variations of the velocities beside them,
//!
//! ```math
//! \tfrac12 J:\qquad \text{gradient}\ (x''_0,\,-x'_0,\,-x''_1,\,x'_1)\ \text{by}\ (u_0, w_0, u_1, w_1)
//! ```
//!
//! and its derivative is a matrix of four times four blocks. It is symmetric but for the blocks of two displacements of one end,
//! which do not commute, and in tension for those of `x''` by `w` at the same end: the gradient has `x'' - tau x` there.
//!
//! The `(x', x'')` at the start that move the end as wanted are measured by the change of point and velocity that they make in flat
//! space, where `s = a / 2 + x'' / 6` and `v = a + x'' / 2`: then the matrix of their equations is near the identity for slow
//! curves, and its singular values tell how far the ends are from conjugate ones.

use faer::Mat;

use super::linear_flow::VARIATION;
use crate::error::{Error, Result};
use crate::linalg::decomp::{singular_range, solve_matrix};
use crate::linalg::structure::check_range;

/// Ends whose smallest singular value is below this share of the largest count as conjugate.
///
/// Ten times what boundary problems are solved to by default: ends that are no nearer cannot be told from conjugate ones.
const CONJUGATE: f64 = 1e-11;

/// Changes of `x'` (first row) and `x''` that move the end of a curve of flat space by a unit in the point, and in the velocity.
const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// Sign of the gradient, and which of `(p, w, a, b)` it is, for each of its four parts.
const PARTS: [(f64, usize); 4] = [(1.0, 3), (-1.0, 2), (-1.0, 3), (1.0, 2)];

/// The matrix, shape `(4 d, 4 d)`, from that of `(p, w, a, b)` at the end by those at the start.
///
/// # Errors
/// `ConjugateEnds`, `Overflow`, `Decomposition`.
pub(super) fn end_stiffness(flow: &Mat<f64>) -> Result<Mat<f64>> {
    let d = flow.nrows() / 4;
    if d == 0 {
        return Ok(flow.clone());
    }
    check_range(VARIATION, flow.as_ref())?;
    let unknown = Mat::from_fn(2 * d, 2 * d, |i, j| {
        let [by_a, by_b] = [2, 3].map(|level| flow[(i, level * d + j % d)]);
        FLAT[0][j / d] * by_a + FLAT[1][j / d] * by_b
    });
    // What of the end is to be made up for by `(x', x'')` at the start.
    let right = Mat::from_fn(2 * d, 4 * d, |i, j| match j.checked_sub(2 * d) {
        None => -flow[(i, j)],
        Some(j) => f64::from(u8::from(i == j)),
    });
    let Some(found) = solve_matrix(unknown.as_ref(), right.as_ref()) else {
        let [smallest, largest] = singular_range(unknown.as_ref())?;
        return Err(Error::ConjugateEnds { smallest, largest });
    };
    // Its last columns are the inverse: a bound of the condition.
    let inverse = found.subcols(2 * d, 2 * d);
    if (unknown.norm_l2() * inverse.norm_l2()).recip() <= CONJUGATE {
        let [smallest, largest] = singular_range(unknown.as_ref())?;
        if smallest.is_nan() || smallest <= CONJUGATE * largest {
            return Err(Error::ConjugateEnds { smallest, largest });
        }
    }
    let start = Mat::from_fn(2 * d, 4 * d, |i, j| {
        let [point, velocity] = [0, d].map(|part| found[(part + i % d, j)]);
        FLAT[i / d][0] * point + FLAT[i / d][1] * velocity
    });
    let mut end = flow.submatrix(2 * d, 2 * d, 2 * d, 2 * d) * &start;
    let mut known = end.subcols_mut(0, 2 * d);
    known += flow.submatrix(2 * d, 0, 2 * d, 2 * d);
    let matrix = Mat::from_fn(4 * d, 4 * d, |i, j| {
        let (sign, level) = PARTS[i / d];
        let from = if i < 2 * d { &start } else { &end };
        sign * from[((level - 2) * d + i % d, j)]
    });
    check_range(VARIATION, matrix.as_ref())?;
    Ok(matrix)
}
