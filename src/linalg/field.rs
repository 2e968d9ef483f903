//! Numbers that can be divided, one or eight at a time, and small dense systems of them.

use std::ops::Div;

use super::dual::Number;
use super::lanes::{LANES, Lanes};

/// One number, or eight that go through the same operations.
pub(crate) trait Field: Number + Div<Output = Self> {
    /// How many numbers it is.
    const COUNT: usize;

    fn lane(self, lane: usize) -> f64;

    fn set_lane(&mut self, lane: usize, value: f64);

    /// 1 or -1.
    fn sign(self) -> Self;
}

impl Field for f64 {
    const COUNT: usize = 1;

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: f64) {
        *self = value;
    }

    #[inline(always)]
    fn sign(self) -> f64 {
        1.0_f64.copysign(self)
    }
}

impl Field for Lanes {
    const COUNT: usize = LANES;

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }

    #[inline(always)]
    fn sign(self) -> Lanes {
        Lanes::ONE.copysign(self)
    }
}

/// The larger of two sizes; NaN if there is one.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

/// The largest absolute value of all numbers; NaN if there is one.
#[inline(always)]
pub(crate) fn largest<T: Number>(values: &[T]) -> f64 {
    values
        .iter()
        .fold(0.0, |size, x| larger(size, x.value().abs()))
}

/// Factors `a = l u` in place, shape `(n, n)` row by row, without pivoting: for matrices near to the identity or to ones that
/// are diagonally dominant by blocks. Pivots are replaced by their inverses.
#[inline(always)]
pub(crate) fn factor<T: Field>(n: usize, a: &mut [T]) {
    for i in 0..n {
        let (above, below) = a.split_at_mut((i + 1) * n);
        let pivot = &mut above[i * n..];
        let inverse = T::constant(1.0) / pivot[i];
        pivot[i] = inverse;
        for row in below.chunks_exact_mut(n) {
            let share = row[i] * inverse;
            row[i] = share;
            for (entry, pivot) in row[i + 1..].iter_mut().zip(&pivot[i + 1..]) {
                *entry -= share * *pivot;
            }
        }
    }
}

/// Solves `l u x = b` in place for `columns` right-hand sides, shape `(n, columns)` row by row.
#[inline(always)]
pub(crate) fn substitute<T: Field>(n: usize, factors: &[T], columns: usize, b: &mut [T]) {
    for i in 1..n {
        let (above, row) = b.split_at_mut(i * columns);
        let row = &mut row[..columns];
        for (share, other) in factors[i * n..][..i]
            .iter()
            .zip(above.chunks_exact(columns))
        {
            subtract(row, *share, other);
        }
    }
    for i in (0..n).rev() {
        let (above, below) = b.split_at_mut((i + 1) * columns);
        let row = &mut above[i * columns..];
        let factors = &factors[i * n..][..n];
        for (share, other) in factors[i + 1..].iter().zip(below.chunks_exact(columns)) {
            subtract(row, *share, other);
        }
        for entry in row {
            *entry = *entry * factors[i];
        }
    }
}

#[inline(always)]
fn subtract<T: Field>(row: &mut [T], share: T, other: &[T]) {
    for (entry, other) in row.iter_mut().zip(other) {
        *entry -= share * *other;
    }
}

/// `out += a b` for `a` of shape `(rows, inner)`, constant, and `b` of shape `(inner, columns)`, row by row.
#[inline(always)]
pub(crate) fn accumulate<T: Number>(
    a: &[f64],
    inner: usize,
    b: &[T],
    columns: usize,
    out: &mut [T],
) {
    for (a, out) in a.chunks_exact(inner).zip(out.chunks_exact_mut(columns)) {
        for (column, out) in out.iter_mut().enumerate() {
            let mut sum = *out;
            for (a, b) in a.iter().zip(b.chunks_exact(columns)) {
                sum += b[column] * *a;
            }
            *out = sum;
        }
    }
}

/// `out = a b` for square matrices of size `r`, row by row.
#[inline(always)]
pub(crate) fn multiply<T: Number>(r: usize, a: &[T], b: &[T], out: &mut [T]) {
    for (a, out) in a.chunks_exact(r).zip(out.chunks_exact_mut(r)) {
        for (j, out) in out.iter_mut().enumerate() {
            let mut sum = a[0] * b[j];
            for l in 1..r {
                sum += a[l] * b[l * r + j];
            }
            *out = sum;
        }
    }
}

/// `out = a b^T`.
#[inline(always)]
pub(crate) fn multiply_transposed<T: Number>(r: usize, a: &[T], b: &[T], out: &mut [T]) {
    for (a, out) in a.chunks_exact(r).zip(out.chunks_exact_mut(r)) {
        for (b, out) in b.chunks_exact(r).zip(out.iter_mut()) {
            let mut sum = a[0] * b[0];
            for l in 1..r {
                sum += a[l] * b[l];
            }
            *out = sum;
        }
    }
}

/// `out = a^T b`.
#[inline(always)]
pub(crate) fn transposed_multiply<T: Number>(r: usize, a: &[T], b: &[T], out: &mut [T]) {
    for i in 0..r {
        for j in 0..r {
            let mut sum = a[i] * b[j];
            for l in 1..r {
                sum += a[l * r + i] * b[l * r + j];
            }
            out[i * r + j] = sum;
        }
    }
}
