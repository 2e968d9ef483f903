//! Products and sums of the blocks of Taylor coefficients of one order.

use super::blocks::block;
use crate::linalg::dual::Number;

#[inline(always)]
pub(crate) fn write_scaled<T: Number>(out: &mut [T], a: &[T], factor: f64) {
    for (out, a) in out.iter_mut().zip(a) {
        *out = *a * factor;
    }
}

/// The coefficient of order `j + 1` of a function, from the coefficient of order `j` of its derivative.
#[inline(always)]
pub(crate) fn integrate<T: Number>(
    f: &mut [T],
    derivative: &[T],
    j: usize,
    size: usize,
    next: f64,
) {
    write_scaled(
        &mut f[block(j + 1, size)],
        &derivative[block(j, size)],
        next,
    );
}

/// `out += a b`, with the second factor optionally transposed.
#[inline(always)]
pub(crate) fn add_product<T: Number, const TRANSPOSED: bool>(
    out: &mut [T],
    a: &[T],
    b: &[T],
    [rows, inner, cols]: [usize; 3],
) {
    for (col, out) in out.chunks_exact_mut(rows).enumerate() {
        for (l, a) in a.chunks_exact(rows).enumerate() {
            let factor = if TRANSPOSED {
                b[col + cols * l]
            } else {
                b[l + inner * col]
            };
            for (out, a) in out.iter_mut().zip(a) {
                *out += *a * factor;
            }
        }
    }
}

/// `out += factor tension a`, if there is a tension.
#[inline(always)]
pub(crate) fn add_tension<T: Number>(out: &mut [T], tension: Option<T>, a: &[T], factor: f64) {
    let Some(tension) = tension else { return };
    for (out, a) in out.iter_mut().zip(a) {
        *out += tension * *a * factor;
    }
}
