//! Rows of sums of matrix products and brackets, several entries at once: vector instructions process eight numbers of
//! a row, and sums of different entries are independent.

use std::ops::{Mul, Range};

use crate::linalg::dual::Number;
use crate::linalg::field::Field;

/// Padding after the last row of a matrix: rows are read in pieces of up to eight numbers.
pub(crate) const SLACK: usize = 8;

/// A row of a sum, `N` entries at a time starting at a column.
pub(crate) trait RowSums<X> {
    fn entries<const N: usize>(&self, column: usize) -> [X; N];
}

/// Writes entries of a row, starting at a column.
#[inline(always)]
pub(crate) fn write_row<X: Field>(row: &impl RowSums<X>, column: usize, out: &mut [X]) {
    let mut done = 0;
    while done < out.len() {
        let (at, out) = (column + done, &mut out[done..]);
        // Real numbers are summed in full vectors, even if fewer are needed.
        done += match (X::COUNT, out.len()) {
            (1, 5..) => put::<8, X>(row, at, out),
            (1, _) => put::<4, X>(row, at, out),
            (_, 1) => put::<1, X>(row, at, out),
            (_, 2 | 3) => put::<2, X>(row, at, out),
            _ => put::<4, X>(row, at, out),
        };
    }
}

#[inline(always)]
fn put<const N: usize, X: Field>(row: &impl RowSums<X>, column: usize, out: &mut [X]) -> usize {
    for (out, entry) in out.iter_mut().zip(row.entries::<N>(column)) {
        *out = entry;
    }
    N
}

/// `N` entries of each row of a matrix of size `r`, starting at a column.
#[inline(always)]
fn pieces<const N: usize, X>(
    a: &[X],
    r: usize,
    first: usize,
    column: usize,
) -> impl Iterator<Item = &[X]> {
    a[first * r + column..].windows(N).step_by(r)
}

/// A row of `sum weight (x y - y x)` over pairs of matrices of size `r`; only the given number of leading entries of
/// the rows of `x` and `y` multiply nonzero entries.
pub(crate) struct Brackets<I> {
    pub(crate) r: usize,
    pub(crate) inner: usize,
    pub(crate) row: usize,
    pub(crate) pairs: I,
}

impl<'a, X, Y, I> RowSums<X> for Brackets<I>
where
    X: Number + Mul<Y, Output = X>,
    Y: Number,
    I: Iterator<Item = (f64, &'a [X], &'a [Y])> + Clone,
{
    #[inline(always)]
    fn entries<const N: usize>(&self, column: usize) -> [X; N] {
        let &Brackets { r, inner, row, .. } = self;
        let mut sums = [X::ZERO; N];
        for (weight, x, y) in self.pairs.clone() {
            let factors = x[row * r..][..inner].iter().zip(&y[row * r..][..inner]);
            let rows = pieces::<N, X>(x, r, 0, column).zip(pieces::<N, Y>(y, r, 0, column));
            for ((a, b), (x, y)) in factors.zip(rows) {
                let (a, b) = (*a * weight, *b * weight);
                for c in 0..N {
                    sums[c] += a * y[c];
                    sums[c] -= x[c] * b;
                }
            }
        }
        sums
    }
}

/// A row of `sum a b` over pairs of matrices of size `r`, restricted to some entries of the row of `a`. `multiply`
/// handles pairs in which one matrix holds derivatives in several directions and the other real numbers.
pub(crate) struct RowProducts<I, F> {
    pub(crate) r: usize,
    pub(crate) inner: Range<usize>,
    pub(crate) row: usize,
    pub(crate) pairs: I,
    pub(crate) multiply: F,
}

impl<'a, A, B, X, I, F> RowSums<X> for RowProducts<I, F>
where
    A: Copy + 'a,
    B: Copy + 'a,
    X: Number,
    I: Iterator<Item = (&'a [A], &'a [B])> + Clone,
    F: Fn(A, B) -> X,
{
    #[inline(always)]
    fn entries<const N: usize>(&self, column: usize) -> [X; N] {
        let (r, Range { start, end }) = (self.r, self.inner.clone());
        let mut sums = [X::ZERO; N];
        for (a, b) in self.pairs.clone() {
            let factors = &a[self.row * r..][start..end];
            for (a, b) in factors.iter().zip(pieces::<N, B>(b, r, start, column)) {
                for c in 0..N {
                    sums[c] += (self.multiply)(*a, b[c]);
                }
            }
        }
        sums
    }
}

/// The skew matrix of size three with the given axial vector.
#[inline(always)]
pub(crate) fn skew<T: Number>([x, y, z]: [T; 3]) -> [T; 9] {
    let zero = T::ZERO;
    [zero, -z, y, z, zero, -x, -y, x, zero]
}

/// The axial vector of a skew matrix of size three.
#[inline(always)]
pub(crate) fn axis<T: Number>(a: &[T]) -> [T; 3] {
    [a[7], a[2], a[3]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::lanes::Lanes;

    const COUNT: usize = 3;

    /// `COUNT` skew matrices of size `r` with small integer entries, exact in any order of summation, and padding.
    fn matrices(r: usize, seed: usize) -> Vec<f64> {
        let mut all = vec![0.0; COUNT * r * r + SLACK];
        for (at, matrix) in all[..COUNT * r * r].chunks_exact_mut(r * r).enumerate() {
            for i in 0..r {
                for j in 0..i {
                    let entry = ((7 * i + 3 * j + 5 * at + seed) % 11) as f64 - 5.0;
                    (matrix[i * r + j], matrix[j * r + i]) = (entry, -entry);
                }
            }
        }
        all
    }

    fn splat(all: &[f64]) -> Vec<Lanes> {
        all.iter().map(|x| Lanes::splat(*x)).collect()
    }

    fn entry(r: usize, a: &[f64], b: &[f64], [i, j]: [usize; 2]) -> f64 {
        (0..r).map(|l| a[i * r + l] * b[l * r + j]).sum()
    }

    #[test]
    fn rows_of_brackets_and_products_are_those_of_whole_matrices() {
        for r in [4, 5, 9, 12] {
            let (x, y) = (matrices(r, 1), matrices(r, 4));
            let square = r * r;
            let at = |all: &[f64], i: usize| all[i * square..].to_vec();
            let (lanes_x, lanes_y) = (splat(&x), splat(&y));
            for (row, column, count) in [(0, 1, r - 1), (r - 1, 0, r), (1, r - 1, 1), (2, 0, 3)] {
                let mut brackets = vec![0.0; count];
                let mut products = vec![0.0; count];
                let [mut lane_brackets, mut wide] = [(); 2].map(|()| vec![Lanes::ZERO; count]);
                let pairs = (0..COUNT).map(|i| (i as f64, &x[i * square..], &y[i * square..]));
                write_row(
                    &Brackets {
                        r,
                        inner: r,
                        row,
                        pairs,
                    },
                    column,
                    &mut brackets,
                );
                let pairs =
                    (0..COUNT).map(|i| (i as f64, &lanes_x[i * square..], &lanes_y[i * square..]));
                write_row(
                    &Brackets {
                        r,
                        inner: r,
                        row,
                        pairs,
                    },
                    column,
                    &mut lane_brackets,
                );
                let pairs = (0..COUNT).map(|i| (&x[i * square..], &y[i * square..]));
                write_row(
                    &RowProducts {
                        r,
                        inner: 0..r,
                        row,
                        pairs,
                        multiply: |a: f64, b: f64| a * b,
                    },
                    column,
                    &mut products,
                );
                let pairs = (0..COUNT).map(|i| (&lanes_x[i * square..], &y[i * square..]));
                write_row(
                    &RowProducts {
                        r,
                        inner: 0..r,
                        row,
                        pairs,
                        multiply: |a: Lanes, b: f64| a * b,
                    },
                    column,
                    &mut wide,
                );
                for c in 0..count {
                    let place = [row, column + c];
                    let [mut bracket, mut product] = [0.0; 2];
                    for i in 0..COUNT {
                        let (x, y) = (at(&x, i), at(&y, i));
                        product += entry(r, &x, &y, place);
                        bracket += i as f64 * (entry(r, &x, &y, place) - entry(r, &y, &x, place));
                    }
                    assert_eq!(brackets[c], bracket, "r = {r}, {place:?}");
                    assert_eq!(
                        lane_brackets[c],
                        Lanes::splat(bracket),
                        "r = {r}, {place:?}"
                    );
                    assert_eq!(products[c], product, "r = {r}, {place:?}");
                    assert_eq!(wide[c], Lanes::splat(product), "r = {r}, {place:?}");
                }
            }
        }
    }
}
