//! Products of square matrices at eight nodes at once, in row-major order.

use crate::linalg::field::{accumulate, larger, multiply_rows};
use crate::linalg::lanes::Lanes;
use crate::linalg::simd::vectorised;

/// `out = a b^T` for matrices with rows of length `inner`; in row `j` of `b`, only the first `lengths[j]` entries may be
/// nonzero.
pub(crate) fn times_transposed(
    a: &[Lanes],
    b: &[Lanes],
    inner: usize,
    lengths: &[usize],
    out: &mut [Lanes],
) {
    vectorised(
        #[inline(always)]
        || multiply_rows(a, b, inner, |j| lengths[j], out),
    );
}

/// `out += a b` for matrices of size `r`.
pub(crate) fn add_product(a: &[Lanes], b: &[Lanes], r: usize, out: &mut [Lanes]) {
    vectorised(
        #[inline(always)]
        || accumulate(a, r, b, r, out),
    );
}

/// The same for matrices of numbers.
pub(crate) fn add_product_of_numbers(a: &[f64], b: &[f64], r: usize, out: &mut [f64]) {
    vectorised(
        #[inline(always)]
        || accumulate(a, r, b, r, out),
    );
}

/// Maximal number of steps of [`polar_factor`], which square the defect.
const MOST_POLAR_STEPS: usize = 5;

/// Replaces a matrix of size `r` near an orthogonal one by its polar factor, by the Newton-Schulz iteration
/// `q <- q (3 - q^T q) / 2`. It stops where the defect is round-off;
/// [`orthonormalise`](crate::space::orthonormalise), for eight matrices at once, takes the same steps whatever the defect.
///
/// # Source
/// Higham (2008), "Functions of Matrices", sec. 8.3.
pub(crate) fn polar_factor(q: &mut [f64], r: usize) {
    let square = r * r;
    let mut work = vec![0.0; 2 * square];
    let (transposed, gram) = work.split_at_mut(square);
    for _ in 0..MOST_POLAR_STEPS {
        for (i, entry) in transposed.iter_mut().enumerate() {
            *entry = q[i % r * r + i / r];
        }
        gram.fill(0.0);
        add_product_of_numbers(transposed, q, r, gram);
        let mut defect = 0.0;
        for (i, entry) in gram.iter_mut().enumerate() {
            *entry -= f64::from(u8::from(i % (r + 1) == 0));
            defect = larger(defect, entry.abs());
            *entry *= -0.5;
        }
        transposed.copy_from_slice(q);
        add_product_of_numbers(transposed, gram, r, q);
        // The next defect is about three quarters of the square.
        let is_round_off = defect * defect <= f64::EPSILON;
        if is_round_off {
            break;
        }
    }
}
