//! Symmetric block tridiagonal systems by Cholesky factors, which exist only for positive definite matrices.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.2.5 and 4.5.1.

use crate::linalg::simd::vectorised;

/// Square blocks of one size, row by row: the diagonal ones, and those beside them on the right up to the last row but one.
#[derive(Clone)]
pub(crate) struct SymmetricBlocks {
    pub(crate) size: usize,
    pub(crate) diagonal: Vec<f64>,
    pub(crate) beside: Vec<f64>,
}

impl SymmetricBlocks {
    /// The zero matrix of `count` by `count` blocks.
    pub(crate) fn zeros(count: usize, size: usize) -> Self {
        let square = size * size;
        SymmetricBlocks {
            size,
            diagonal: vec![0.0; count * square],
            beside: vec![0.0; (count - 1) * square],
        }
    }

    /// `self + factor other`.
    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + factor * b).collect();
        SymmetricBlocks {
            size: self.size,
            diagonal: sum(&self.diagonal, &other.diagonal),
            beside: sum(&self.beside, &other.beside),
        }
    }

    /// `x^T A x`.
    pub(crate) fn form(&self, x: &[f64]) -> f64 {
        let (d, square) = (self.size, self.size * self.size);
        let product = |a: &[f64], x: &[f64], y: &[f64]| -> f64 {
            let rows = a.chunks_exact(d).zip(x);
            rows.map(|(row, x)| x * dot(row, y)).sum()
        };
        let blocks = x.chunks_exact(d);
        let diagonal = self.diagonal.chunks_exact(square).zip(blocks.clone());
        let beside = self
            .beside
            .chunks_exact(square)
            .zip(blocks.clone().zip(blocks.skip(1)));
        vectorised(
            #[inline(always)]
            || {
                diagonal.map(|(a, x)| product(a, x, x)).sum::<f64>()
                    + 2.0 * beside.map(|(a, (x, y))| product(a, x, y)).sum::<f64>()
            },
        )
    }

    /// The Cholesky factor; `None` where the matrix is not positive definite.
    pub(crate) fn factored(mut self) -> Option<CholeskyFactor> {
        vectorised(
            #[inline(always)]
            || self.factor(),
        )?;
        Some(CholeskyFactor(self))
    }

    /// `A = U^T U` in place.
    #[inline(always)]
    fn factor(&mut self) -> Option<()> {
        let (d, square) = (self.size, self.size * self.size);
        let mut before: Option<&[f64]> = None;
        let mut beside = self.beside.chunks_exact_mut(square);
        for diagonal in self.diagonal.chunks_exact_mut(square) {
            if let Some(before) = before {
                for (i, row) in diagonal.chunks_exact_mut(d).enumerate() {
                    subtract_rows(d, before, i, before, &mut row[i..]);
                }
            }
            cholesky(d, diagonal)?;
            let Some(beside) = beside.next() else {
                break;
            };
            for i in 0..d {
                let (known, rest) = beside.split_at_mut(i * d);
                let row = &mut rest[..d];
                subtract_rows(d, diagonal, i, known, row);
                let pivot = diagonal[i * d + i];
                row.iter_mut().for_each(|entry| *entry /= pivot);
            }
            before = Some(beside);
        }
        Some(())
    }
}

/// The factor of a positive definite matrix: upper triangles of the blocks on the diagonal, and the blocks beside them.
pub(crate) struct CholeskyFactor(SymmetricBlocks);

impl CholeskyFactor {
    /// Solves the system in place.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        vectorised(
            #[inline(always)]
            || {
                self.solve_transposed(b);
                self.solve_upper(b);
            },
        );
    }

    /// `U^T x = b` in place.
    #[inline(always)]
    fn solve_transposed(&self, b: &mut [f64]) {
        let (d, square) = (self.0.size, self.0.size * self.0.size);
        for (block, diagonal) in self.0.diagonal.chunks_exact(square).enumerate() {
            let (here, after) = b[block * d..].split_at_mut(d);
            for (i, row) in diagonal.chunks_exact(d).enumerate() {
                let x = here[i] / row[i];
                here[i] = x;
                subtract(x, &row[i + 1..], &mut here[i + 1..]);
            }
            if let Some(beside) = self.0.beside.get(block * square..(block + 1) * square) {
                for (x, row) in here.iter().zip(beside.chunks_exact(d)) {
                    subtract(*x, row, &mut after[..d]);
                }
            }
        }
    }

    /// `U x = b` in place.
    #[inline(always)]
    fn solve_upper(&self, b: &mut [f64]) {
        let (d, square) = (self.0.size, self.0.size * self.0.size);
        for (block, diagonal) in self.0.diagonal.chunks_exact(square).enumerate().rev() {
            let (here, after) = b[block * d..].split_at_mut(d);
            if let Some(beside) = self.0.beside.get(block * square..(block + 1) * square) {
                for (x, row) in here.iter_mut().zip(beside.chunks_exact(d)) {
                    *x -= dot(row, &after[..d]);
                }
            }
            for (i, row) in diagonal.chunks_exact(d).enumerate().rev() {
                here[i] = (here[i] - dot(&row[i + 1..], &here[i + 1..])) / row[i];
            }
        }
    }
}

/// The upper factor in place of the upper triangle; `None` where a pivot is not positive.
#[inline(always)]
fn cholesky(d: usize, a: &mut [f64]) -> Option<()> {
    for i in 0..d {
        let (known, rest) = a.split_at_mut(i * d);
        let row = &mut rest[i..d];
        subtract_rows(d, known, i, known, row);
        let square = row[0];
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        let pivot = square.sqrt();
        row[0] = pivot;
        row[1..].iter_mut().for_each(|entry| *entry /= pivot);
    }
    Some(())
}

/// Rows that are subtracted abreast: each entry of `out` is then read and written once for as many products.
const ROWS: usize = 4;

/// `out -= sum_l f_l row_l` with the ends of all `rows`, as long as `out`, and as factors the entries of a column of `factors`,
/// rows of length `d` both.
#[inline(always)]
fn subtract_rows(d: usize, factors: &[f64], column: usize, rows: &[f64], out: &mut [f64]) {
    let first = d - out.len();
    let mut rows = rows.chunks_exact(ROWS * d);
    let mut factors = factors.chunks_exact(d).map(|row| row[column]);
    for rows in rows.by_ref() {
        let share: [f64; ROWS] = std::array::from_fn(|_| factors.next().unwrap_or(0.0));
        let rows: [&[f64]; ROWS] = std::array::from_fn(|l| &rows[l * d + first..(l + 1) * d]);
        for (i, out) in out.iter_mut().enumerate() {
            *out -= (share[0] * rows[0][i] + share[1] * rows[1][i])
                + (share[2] * rows[2][i] + share[3] * rows[3][i]);
        }
    }
    for (row, share) in rows.remainder().chunks_exact(d).zip(factors) {
        subtract(share, &row[first..], out);
    }
}

/// `out -= factor row`.
#[inline(always)]
fn subtract(factor: f64, row: &[f64], out: &mut [f64]) {
    for (out, x) in out.iter_mut().zip(row) {
        *out -= factor * x;
    }
}

/// In four sums, which vector instructions add abreast.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let whole = a.len() - a.len() % ROWS;
    let ((a, rest), (b, other)) = (a.split_at(whole), b.split_at(whole));
    let mut sums = [0.0; ROWS];
    for (a, b) in a.chunks_exact(ROWS).zip(b.chunks_exact(ROWS)) {
        for i in 0..ROWS {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = rest.iter().zip(other).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three blocks of size two, `A = B B^T + shift`.
    fn matrix(shift: f64) -> SymmetricBlocks {
        let mut a = SymmetricBlocks::zeros(3, 2);
        for (i, x) in a.beside.iter_mut().enumerate() {
            *x = 0.3 * (1.0 + i as f64).sin();
        }
        for block in 0..3 {
            let at = 4 * block;
            a.diagonal[at..at + 4].copy_from_slice(&[2.0 + shift, 0.5, 0.5, 1.5 + shift]);
        }
        a
    }

    /// `A x`.
    fn product(a: &SymmetricBlocks, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; 6];
        for i in 0..6 {
            let mut unit = vec![0.0; 6];
            unit[i] = 1.0;
            let sum: Vec<f64> = unit.iter().zip(x).map(|(u, x)| u + x).collect();
            // The form is quadratic: its polar form gives the entry.
            out[i] = 0.5 * (a.form(&sum) - a.form(&unit) - a.form(x));
        }
        out
    }

    #[test]
    fn the_factor_solves_the_system() {
        let a = matrix(0.0);
        let x: Vec<f64> = (0..6).map(|i| (0.7 * i as f64).cos()).collect();
        let mut b = product(&a, &x);
        a.factored().expect("positive definite").solve(&mut b);
        for (found, x) in b.iter().zip(&x) {
            assert!((found - x).abs() < 1e-14, "{found} {x}");
        }
    }

    #[test]
    fn an_indefinite_matrix_has_no_factor() {
        assert!(matrix(-1.5).factored().is_none());
        assert!(matrix(f64::NAN).factored().is_none());
    }

    #[test]
    fn a_multiple_is_added() {
        let (a, x) = (matrix(0.0), [0.3, -1.0, 0.2, 0.9, -0.4, 1.1]);
        let sum = a.plus(2.0, &matrix(1.0));
        let expected = a.form(&x) + 2.0 * matrix(1.0).form(&x);
        assert!((sum.form(&x) - expected).abs() < 1e-13);
    }
}
