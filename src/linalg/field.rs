//! Numbers that can be divided, one or eight at a time, and small dense linear systems.

use std::ops::{Div, Mul, Range};

use super::dual::Number;
use super::lanes::{LANES, Lanes};

/// One number, or eight numbers that undergo the same operations.
pub(crate) trait Field: Number + Div<Output = Self> {
    /// How many numbers it holds.
    const COUNT: usize;

    /// Derivatives in several directions at once: eight of one number, or one of eight numbers.
    type Columns: Field + Mul<Self, Output = Self::Columns>;

    /// Number of directions.
    const COLUMNS: usize;

    /// The derivative in one direction.
    fn column(columns: Self::Columns, i: usize) -> Self;

    /// Sets the derivative in one direction, for every number.
    fn set_column(columns: &mut Self::Columns, i: usize, change: f64);

    fn lane(self, lane: usize) -> f64;

    fn set_lane(&mut self, lane: usize, value: f64);

    /// 1 or -1.
    fn sign(self) -> Self;

    /// The maximum of `self` and the absolute value of `other`; NaN is propagated.
    fn larger(self, other: Self) -> Self;
}

impl Field for f64 {
    const COUNT: usize = 1;

    type Columns = Lanes;

    const COLUMNS: usize = LANES;

    #[inline(always)]
    fn column(columns: Lanes, i: usize) -> f64 {
        columns.0[i]
    }

    #[inline(always)]
    fn set_column(columns: &mut Lanes, i: usize, change: f64) {
        columns.0[i] = change;
    }

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

    #[inline(always)]
    fn larger(self, other: f64) -> f64 {
        larger(self, other.abs())
    }
}

impl Field for Lanes {
    const COUNT: usize = LANES;

    type Columns = Lanes;

    const COLUMNS: usize = 1;

    #[inline(always)]
    fn column(columns: Lanes, _: usize) -> Lanes {
        columns
    }

    #[inline(always)]
    fn set_column(columns: &mut Lanes, _: usize, change: f64) {
        *columns = Lanes::splat(change);
    }

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

    #[inline(always)]
    fn larger(mut self, other: Lanes) -> Lanes {
        for (size, x) in self.0.iter_mut().zip(other.0) {
            *size = larger(*size, x.abs());
        }
        self
    }
}

/// The maximum of two magnitudes; NaN is propagated.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

/// The largest absolute value in each lane; NaN is propagated.
#[inline(always)]
pub(crate) fn largest_each<T: Field>(values: &[T]) -> T {
    let mut size = T::ZERO;
    for x in values {
        size = size.larger(*x);
    }
    size
}

/// The largest absolute value of all numbers; NaN is propagated.
#[inline(always)]
pub(crate) fn largest<T: Field>(values: &[T]) -> f64 {
    let size = largest_each(values);
    (0..T::COUNT).fold(0.0, |all, lane| larger(all, size.lane(lane)))
}

/// `sum += factor other`, entry by entry.
#[inline(always)]
pub(crate) fn add(sum: &mut [f64], factor: f64, other: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(other) {
        *sum += factor * x;
    }
}

/// Factors `a = l u` in place, shape `(n, n)` in row-major order, without pivoting: for matrices near the identity, or
/// near matrices that are diagonally dominant by blocks. Pivots are replaced by their inverses.
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

/// Solves `l u x = b` in place for `columns` right-hand sides, shape `(n, columns)` in row-major order.
#[inline(always)]
pub(crate) fn substitute<T: Field>(n: usize, factors: &[T], columns: usize, b: &mut [T]) {
    for i in 0..n {
        let (above, below) = b.split_at_mut((i + 1) * columns);
        let known = &above[i * columns..];
        for (j, row) in below.chunks_exact_mut(columns).enumerate() {
            subtract(row, factors[(i + 1 + j) * n + i], known);
        }
    }
    for i in (0..n).rev() {
        let (above, known) = b.split_at_mut(i * columns);
        let known = &mut known[..columns];
        for entry in &mut *known {
            *entry = *entry * factors[i * n + i];
        }
        for (j, row) in above.chunks_exact_mut(columns).enumerate() {
            subtract(row, factors[j * n + i], known);
        }
    }
}

/// Solves `x l u = b` in place for every row of `b`, shape `(rows, n)` in row-major order.
#[inline(always)]
pub(crate) fn substitute_rows<T: Field>(n: usize, factors: &[T], b: &mut [T]) {
    if T::COUNT == 1 {
        for row in b.chunks_exact_mut(n) {
            substitute_row(n, factors, row);
        }
        return;
    }
    let mut groups = b.chunks_exact_mut(ROWS * n);
    for rows in groups.by_ref() {
        substitute_few_rows::<ROWS, T>(n, factors, rows);
    }
    for row in groups.into_remainder().chunks_exact_mut(n) {
        substitute_few_rows::<1, T>(n, factors, row);
    }
}

/// Solves for one row, using rows of the factors.
#[inline(always)]
fn substitute_row<T: Field>(n: usize, factors: &[T], b: &mut [T]) {
    for j in 0..n {
        let (known, rest) = b.split_at_mut(j + 1);
        let pivots = &factors[j * n..][..n];
        known[j] = known[j] * pivots[j];
        subtract(rest, known[j], &pivots[j + 1..]);
    }
    for j in (0..n).rev() {
        let (rest, known) = b.split_at_mut(j);
        subtract(rest, known[0], &factors[j * n..]);
    }
}

/// Solves for several rows at once, because each sum must wait for its last addition.
#[inline(always)]
fn substitute_few_rows<const N: usize, T: Field>(n: usize, factors: &[T], b: &mut [T]) {
    let mut rows = b.chunks_exact_mut(n);
    let mut rows: [&mut [T]; N] = std::array::from_fn(|_| rows.next().unwrap_or_default());
    for j in 0..n {
        let sums = left_over(n, factors, &rows, j, 0..j);
        for (row, sum) in rows.iter_mut().zip(sums) {
            row[j] = sum * factors[j * n + j];
        }
    }
    for j in (0..n).rev() {
        let sums = left_over(n, factors, &rows, j, j + 1..n);
        for (row, sum) in rows.iter_mut().zip(sums) {
            row[j] = sum;
        }
    }
}

/// Entry `j` of several rows, minus the products of their other entries with those of a column.
#[inline(always)]
fn left_over<const N: usize, T: Field>(
    n: usize,
    factors: &[T],
    rows: &[&mut [T]; N],
    j: usize,
    others: Range<usize>,
) -> [T; N] {
    let rows: [&[T]; N] = std::array::from_fn(|row| &rows[row][..n]);
    let mut sums = rows.map(|row| row[j]);
    for l in others {
        let entry = factors[l * n + j];
        for (sum, row) in sums.iter_mut().zip(rows) {
            *sum -= row[l] * entry;
        }
    }
    sums
}

#[inline(always)]
fn subtract<T: Field>(row: &mut [T], share: T, other: &[T]) {
    for (entry, other) in row.iter_mut().zip(other) {
        *entry -= share * *other;
    }
}

/// Number of rows of a product that are summed at once: a single sum would wait four times as long as an addition
/// takes.
const ROWS: usize = 4;

/// Number of columns of a product of real numbers that are summed at once: a vector register.
const ABREAST: usize = 4;

/// `out += a b` for `a` of shape `(rows, inner)` and `b` of shape `(inner, columns)`, in row-major order.
#[inline(always)]
pub(crate) fn accumulate<A: Copy, T: Number + Mul<A, Output = T>>(
    a: &[A],
    inner: usize,
    b: &[T],
    columns: usize,
    out: &mut [T],
) {
    let mut a = a.chunks_exact(ROWS * inner);
    let mut out = out.chunks_exact_mut(ROWS * columns);
    for (a, out) in a.by_ref().zip(out.by_ref()) {
        accumulate_rows::<ROWS, A, T>(a, inner, b, columns, out);
    }
    let rest = a.remainder().chunks_exact(inner);
    for (a, out) in rest.zip(out.into_remainder().chunks_exact_mut(columns)) {
        accumulate_rows::<1, A, T>(a, inner, b, columns, out);
    }
}

#[inline(always)]
fn accumulate_rows<const N: usize, A: Copy, T: Number + Mul<A, Output = T>>(
    a: &[A],
    inner: usize,
    b: &[T],
    columns: usize,
    out: &mut [T],
) {
    let mut column = 0;
    if size_of::<T>() == size_of::<f64>() {
        while column + ABREAST <= columns {
            accumulate_block::<N, ABREAST, A, T>(a, inner, b, columns, column, out);
            column += ABREAST;
        }
    }
    for column in column..columns {
        accumulate_block::<N, 1, A, T>(a, inner, b, columns, column, out);
    }
}

#[inline(always)]
fn accumulate_block<const N: usize, const M: usize, A: Copy, T: Number + Mul<A, Output = T>>(
    a: &[A],
    inner: usize,
    b: &[T],
    columns: usize,
    column: usize,
    out: &mut [T],
) {
    let rows: [&[A]; N] = std::array::from_fn(|row| &a[row * inner..][..inner]);
    let mut sums = [[T::ZERO; M]; N];
    for (row, sums) in sums.iter_mut().enumerate() {
        sums.copy_from_slice(&out[row * columns + column..][..M]);
    }
    for (l, b) in b.chunks_exact(columns).take(inner).enumerate() {
        let b = &b[column..][..M];
        for (sums, row) in sums.iter_mut().zip(rows) {
            for (sum, b) in sums.iter_mut().zip(b) {
                *sum += *b * row[l];
            }
        }
    }
    for (row, sums) in sums.iter().enumerate() {
        out[row * columns + column..][..M].copy_from_slice(sums);
    }
}

/// `out = a b` for square matrices of size `r`, in row-major order.
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

/// The identity matrix of size `r`.
#[inline(always)]
pub(crate) fn set_identity<T: Number>(r: usize, out: &mut [T]) {
    out.fill(T::ZERO);
    for i in 0..r {
        out[i * r + i] = T::constant(1.0);
    }
}

/// `out = a b^T` for matrices with rows of length `r`, where row `j` of `b` has `inner(j)` leading entries that may be
/// nonzero.
#[inline(always)]
pub(crate) fn multiply_rows<T: Number>(
    a: &[T],
    b: &[T],
    r: usize,
    inner: impl Fn(usize) -> usize,
    out: &mut [T],
) {
    let columns = b.len() / r;
    let mut a = a.chunks_exact(ROWS * r);
    let mut out = out.chunks_exact_mut(ROWS * columns);
    for (a, out) in a.by_ref().zip(out.by_ref()) {
        multiply_few_rows::<ROWS, T>(a, b, r, &inner, out);
    }
    let rest = a.remainder().chunks_exact(r);
    for (a, out) in rest.zip(out.into_remainder().chunks_exact_mut(columns)) {
        multiply_few_rows::<1, T>(a, b, r, &inner, out);
    }
}

#[inline(always)]
fn multiply_few_rows<const N: usize, T: Number>(
    a: &[T],
    b: &[T],
    r: usize,
    inner: &impl Fn(usize) -> usize,
    out: &mut [T],
) {
    let columns = b.len() / r;
    for (j, b) in b.chunks_exact(r).enumerate() {
        let b = &b[..inner(j)];
        let rows: [&[T]; N] = std::array::from_fn(|row| &a[row * r..][..b.len()]);
        let mut sums = [T::ZERO; N];
        for (l, b) in b.iter().enumerate() {
            for (sum, row) in sums.iter_mut().zip(rows) {
                *sum += row[l] * *b;
            }
        }
        for (row, sum) in sums.iter().enumerate() {
            out[row * columns + j] = *sum;
        }
    }
}
