//! The second derivative of the cost of a cubic with respect to points and velocities at its ends, in a time in which
//! it takes one unit.
//!
//! With displacements `u` of the ends in their frames, and variations `w` of the velocities relative to the rotations
//! that displace the ends,
//!
//! ```math
//! \tfrac12 J:\qquad \text{gradient}\ (x''_0,\,-x'_0,\,-x''_1,\,x'_1)\ \text{by}\ (u_0, w_0, u_1, w_1)
//! ```
//!
//! and its derivative is a matrix of four by four blocks. It is symmetric except for the blocks of two displacements of
//! the same end, which do not commute, and, in tension, for the blocks of `x''` by `w` at the same end: the gradient
//! contains `x'' - tau x` there.
//!
//! The variables `(x', x'')` at the start that move the end as required are scaled by the change of point and velocity
//! they cause in flat space, `s = a / 2 + x'' / 6` and `v = a + x'' / 2`. The matrix of their equations is then near
//! the identity for slow curves, and its singular values measure the distance of the ends from conjugate ones.

use faer::Mat;

use super::linear_flow::VARIATION;
use crate::error::{Error, Result};
use crate::linalg::decomp::{singular_range, solve_matrix};
use crate::linalg::structure::check_range;

/// Ends count as conjugate if the smallest singular value is below this fraction of the largest.
///
/// Ten times the default tolerance of boundary problems: closer ends cannot be told from conjugate ones.
const CONJUGATE: f64 = 1e-11;

/// Changes of `x'` (first row) and `x''` (second row) that move the end of a curve of flat space by one unit in the
/// point and in the velocity.
const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// For each of the four parts of the gradient, its sign and its index in `(p, w, a, b)`.
const PARTS: [(f64, usize); 4] = [(1.0, 3), (-1.0, 2), (-1.0, 3), (1.0, 2)];

/// The matrix, shape `(4 d, 4 d)`, from the flow that maps `(p, w, a, b)` at the start to those at the end.
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
    // The part of the end's change that `(x', x'')` at the start must compensate.
    let right = Mat::from_fn(2 * d, 4 * d, |i, j| match j.checked_sub(2 * d) {
        None => -flow[(i, j)],
        Some(j) => f64::from(u8::from(i == j)),
    });
    // The last columns are the inverse. They bound the condition number without singular values, which would take
    // longer than everything else here.
    let bound = |found: &Mat<f64>| {
        let inverse = found.subcols(2 * d, 2 * d);
        (unknown.norm_l2() * inverse.norm_l2()).recip()
    };
    let found = match solve_matrix(unknown.as_ref(), right.as_ref()) {
        Some(found) if bound(&found) > CONJUGATE => found,
        found => {
            let [smallest, largest] = singular_range(unknown.as_ref())?;
            match found {
                Some(found) if smallest > CONJUGATE * largest => found,
                _ => return Err(Error::ConjugateEnds { smallest, largest }),
            }
        }
    };
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
