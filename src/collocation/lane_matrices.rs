//! Products of square matrices at eight nodes at once, in row-major order.

use crate::linalg::field::{accumulate, multiply_rows};
use crate::linalg::lanes::Lanes;
use crate::linalg::simd::vectorised;

/// `out = a b^T` for matrices with rows of length `inner`; in row `j` of `b`, only the first `lengths[j]` entries may be
/// nonzero.
pub(super) fn times_transposed(
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
pub(super) fn add_product(a: &[Lanes], b: &[Lanes], r: usize, out: &mut [Lanes]) {
    vectorised(
        #[inline(always)]
        || accumulate(a, r, b, r, out),
    );
}

/// The same for matrices of numbers.
pub(super) fn add_product_of_numbers(a: &[f64], b: &[f64], r: usize, out: &mut [f64]) {
    vectorised(
        #[inline(always)]
        || accumulate(a, r, b, r, out),
    );
}
