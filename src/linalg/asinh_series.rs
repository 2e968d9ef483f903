//! Logarithm of a rotation or unitary matrix near the identity, as a series in its skew part.

use faer::{Accum, MatMut};

use super::scalar::SquareBuffer;
use super::square::Symmetry;

/// Value of `m - tr Q` below which the series is used: no angle exceeds the square root of this.
pub(super) const NEAR_IDENTITY: f64 = 1e-3;

/// Coefficients of `asinh(x) / x` in `x^2`, up to the degree that is exact to round-off for `|x|^2 <= NEAR_IDENTITY`.
const ASINH: [f64; 5] = [1.0, -1.0 / 6.0, 3.0 / 40.0, -5.0 / 112.0, 35.0 / 1152.0];

/// `asinh(K)` of a skew matrix, with an error relative to its size; a basis of planes would leave an error of `eps`.
pub(super) fn asinh_series<S: SquareBuffer>(
    skew: &S,
    [square, mut sum, mut next]: [&mut S; 3],
    scratch: &mut S::Scratch,
    out: MatMut<'_, S::Entry>,
) {
    square.half_product(Accum::Replace, 1.0, skew, skew, scratch);
    square.mirror(Symmetry::Symmetric);
    let [lower @ .., last] = ASINH;
    for (target, source) in sum.parts_mut().iter_mut().zip(square.parts()) {
        for (target, source) in target.lanes_mut().iter_mut().zip(source.lanes()) {
            *target = source.map(|x| last * x);
        }
    }
    let [first @ .., constant] = lower;
    sum.add_to_diagonal(constant);
    for coefficient in first.into_iter().rev() {
        next.half_product(Accum::Replace, 1.0, square, sum, scratch);
        next.mirror(Symmetry::Symmetric);
        next.add_to_diagonal(coefficient);
        std::mem::swap(&mut sum, &mut next);
    }
    next.half_product(Accum::Replace, 1.0, skew, sum, scratch);
    next.reflect_lower(Symmetry::Skew);
    next.write_to(out);
}
