//! Symmetric block tridiagonal systems, plain and cyclic: positive definite ones by Cholesky factors, others by elimination.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.2.5 and 4.5.1.

use super::block_tridiagonal::{BlockTridiagonal, Factors};
use crate::linalg::simd::vectorised;

/// Square blocks of one size, by rows: the diagonal blocks, and the blocks to their right, except in the last row; for
/// a cyclic matrix of at least three rows also the last block of the first row.
#[derive(Clone)]
pub(crate) struct SymmetricBlocks {
    pub(crate) size: usize,
    pub(crate) diagonal: Vec<f64>,
    pub(crate) beside: Vec<f64>,
    pub(crate) corner: Vec<f64>,
}

impl SymmetricBlocks {
    /// The zero matrix of `count` by `count` blocks.
    pub(crate) fn zeros(count: usize, size: usize) -> Self {
        let square = size * size;
        SymmetricBlocks {
            size,
            diagonal: vec![0.0; count * square],
            beside: vec![0.0; (count - 1) * square],
            corner: Vec::new(),
        }
    }

    /// The cyclic zero matrix of `count >= 3` by `count` blocks.
    pub(crate) fn closed(count: usize, size: usize) -> Self {
        SymmetricBlocks {
            corner: vec![0.0; size * size],
            ..Self::zeros(count, size)
        }
    }

    /// Replaces rows and columns of the first `held` entries of a block by those of the identity.
    pub(crate) fn hold(&mut self, block: usize, held: usize) {
        let (d, square) = (self.size, self.size * self.size);
        let last = self.diagonal.len() / square - 1;
        let clear_rows = |a: &mut [f64]| a[..held * d].fill(0.0);
        let clear_columns = |a: &mut [f64]| {
            a.chunks_exact_mut(d).for_each(|row| row[..held].fill(0.0));
        };
        let diagonal = &mut self.diagonal[block * square..][..square];
        clear_rows(diagonal);
        clear_columns(diagonal);
        for i in 0..held {
            diagonal[i * d + i] = 1.0;
        }
        if block < last {
            clear_rows(&mut self.beside[block * square..][..square]);
        }
        if block > 0 {
            clear_columns(&mut self.beside[(block - 1) * square..][..square]);
        }
        if !self.corner.is_empty() && block == 0 {
            clear_rows(&mut self.corner);
        }
        if !self.corner.is_empty() && block == last {
            clear_columns(&mut self.corner);
        }
    }

    /// `self + factor other`.
    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + factor * b).collect();
        SymmetricBlocks {
            size: self.size,
            diagonal: sum(&self.diagonal, &other.diagonal),
            beside: sum(&self.beside, &other.beside),
            corner: sum(&self.corner, &other.corner),
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
                let around = match self.corner.is_empty() {
                    true => 0.0,
                    false => product(&self.corner, &x[..d], &x[x.len() - d..]),
                };
                diagonal.map(|(a, x)| product(a, x, x)).sum::<f64>()
                    + 2.0 * (beside.map(|(a, (x, y))| product(a, x, y)).sum::<f64>() + around)
            },
        )
    }

    /// The Cholesky factor; `None` if the matrix is not positive definite.
    pub(crate) fn factored(mut self) -> Option<CholeskyFactor> {
        let last_column = vectorised(
            #[inline(always)]
            || self.factor(),
        )?;
        Some(CholeskyFactor {
            blocks: self,
            last_column,
        })
    }

    /// Factors `A = U^T U` in place; returns the blocks of `U` in the last column of a cyclic matrix, except for the
    /// last two rows.
    #[inline(always)]
    fn factor(&mut self) -> Option<Vec<f64>> {
        let (d, square) = (self.size, self.size * self.size);
        let last = self.diagonal.len() / square - 1;
        let mut column = self.last_column();
        let around = column.len() / square;
        for block in 0..=last {
            let (diagonal, after) = self.diagonal[block * square..].split_at_mut(square);
            let (before, beside) = self.beside.split_at_mut(block * square);
            // The first row has none.
            let before = &before[block.saturating_sub(1) * square..];
            if block > 0 {
                subtract_square(d, before, diagonal);
            }
            cholesky(d, diagonal)?;
            if block == last {
                break;
            }
            let beside = &mut beside[..square];
            if block < around {
                let (known, here) = column.split_at_mut(block * square);
                let here = &mut here[..square];
                if block > 0 {
                    subtract_product(d, before, &known[(block - 1) * square..], here);
                }
                substitute_transposed(d, diagonal, here);
                let at = after.len() - square;
                subtract_square(d, here, &mut after[at..]);
            } else if around > 0 {
                subtract_product(d, before, &column[(around - 1) * square..], beside);
            }
            substitute_transposed(d, diagonal, beside);
        }
        Some(column)
    }

    /// The factors by elimination, also of an indefinite matrix; `None` if a block on its way is singular.
    pub(crate) fn eliminated(&self) -> Option<Factors> {
        let (d, square) = (self.size, self.size * self.size);
        let count = self.diagonal.len() / square;
        let mut all = BlockTridiagonal::zeros(count, d);
        all.diagonal.copy_from_slice(&self.diagonal);
        all.above[..self.beside.len()].copy_from_slice(&self.beside);
        for (block, beside) in self.beside.chunks_exact(square).enumerate() {
            transpose(d, beside, &mut all.below[(block + 1) * square..]);
        }
        if self.corner.is_empty() {
            return all.factored();
        }
        all.below[..square].copy_from_slice(&self.corner);
        transpose(d, &self.corner, &mut all.above[(count - 1) * square..]);
        all.factored_cyclic()
    }

    /// The last column of a cyclic matrix, for all rows but the last two.
    fn last_column(&self) -> Vec<f64> {
        let mut column = self.corner.clone();
        if !column.is_empty() {
            column.resize(self.diagonal.len() - 2 * column.len(), 0.0);
        }
        column
    }
}

/// The factor of a positive definite matrix: upper triangles of the diagonal blocks, the blocks to their right, and the
/// blocks of the last column.
pub(crate) struct CholeskyFactor {
    blocks: SymmetricBlocks,
    last_column: Vec<f64>,
}

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

    /// The block of a row in the last column, if there is one.
    fn in_last_column(&self, block: usize) -> Option<&[f64]> {
        let square = self.blocks.size * self.blocks.size;
        self.last_column.get(block * square..(block + 1) * square)
    }

    /// Solves `U^T x = b` in place.
    #[inline(always)]
    fn solve_transposed(&self, b: &mut [f64]) {
        let blocks = &self.blocks;
        let (d, square) = (blocks.size, blocks.size * blocks.size);
        for (block, diagonal) in blocks.diagonal.chunks_exact(square).enumerate() {
            let (here, after) = b[block * d..].split_at_mut(d);
            for (i, row) in diagonal.chunks_exact(d).enumerate() {
                let x = here[i] / row[i];
                here[i] = x;
                subtract(x, &row[i + 1..], &mut here[i + 1..]);
            }
            if let Some(beside) = blocks.beside.get(block * square..(block + 1) * square) {
                for (x, row) in here.iter().zip(beside.chunks_exact(d)) {
                    subtract(*x, row, &mut after[..d]);
                }
            }
            if let Some(column) = self.in_last_column(block) {
                let at = after.len() - d;
                for (x, row) in here.iter().zip(column.chunks_exact(d)) {
                    subtract(*x, row, &mut after[at..]);
                }
            }
        }
    }

    /// Solves `U x = b` in place.
    #[inline(always)]
    fn solve_upper(&self, b: &mut [f64]) {
        let blocks = &self.blocks;
        let (d, square) = (blocks.size, blocks.size * blocks.size);
        for (block, diagonal) in blocks.diagonal.chunks_exact(square).enumerate().rev() {
            let (here, after) = b[block * d..].split_at_mut(d);
            if let Some(beside) = blocks.beside.get(block * square..(block + 1) * square) {
                for (x, row) in here.iter_mut().zip(beside.chunks_exact(d)) {
                    *x -= dot(row, &after[..d]);
                }
            }
            if let Some(column) = self.in_last_column(block) {
                let last = &after[after.len() - d..];
                for (x, row) in here.iter_mut().zip(column.chunks_exact(d)) {
                    *x -= dot(row, last);
                }
            }
            for (i, row) in diagonal.chunks_exact(d).enumerate().rev() {
                here[i] = (here[i] - dot(&row[i + 1..], &here[i + 1..])) / row[i];
            }
        }
    }
}

/// `out = A^T`.
fn transpose(d: usize, a: &[f64], out: &mut [f64]) {
    for (i, row) in a.chunks_exact(d).enumerate() {
        for (j, x) in row.iter().enumerate() {
            out[j * d + i] = *x;
        }
    }
}

/// Replaces the upper triangle by the upper factor; `None` if a pivot is not positive.
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

/// `B = U^{-T} B`.
#[inline(always)]
fn substitute_transposed(d: usize, factor: &[f64], b: &mut [f64]) {
    for i in 0..d {
        let (known, rest) = b.split_at_mut(i * d);
        let row = &mut rest[..d];
        subtract_rows(d, factor, i, known, row);
        let pivot = factor[i * d + i];
        row.iter_mut().for_each(|entry| *entry /= pivot);
    }
}

/// `out -= A^T A`, upper triangle only.
#[inline(always)]
fn subtract_square(d: usize, a: &[f64], out: &mut [f64]) {
    for (i, row) in out.chunks_exact_mut(d).enumerate() {
        subtract_rows(d, a, i, a, &mut row[i..]);
    }
}

/// `out -= A^T B`.
#[inline(always)]
fn subtract_product(d: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    for (i, row) in out.chunks_exact_mut(d).enumerate() {
        subtract_rows(d, a, i, b, row);
    }
}

/// Number of rows subtracted at once: each entry of `out` is then read and written only once for that many products.
const ROWS: usize = 4;

/// `out -= sum_l f_l row_l`, with the last `out.len()` entries of each of `rows`, and factors from a column of
/// `factors`; both have rows of length `d`.
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

/// Dot product in four sums, for vector instructions.
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

    /// Five or three blocks with a corner block.
    fn cyclic(count: usize) -> SymmetricBlocks {
        let mut a = SymmetricBlocks::closed(count, 2);
        for (i, x) in a.beside.iter_mut().chain(&mut a.corner).enumerate() {
            *x = 0.3 * (1.0 + i as f64).sin();
        }
        for diagonal in a.diagonal.chunks_exact_mut(4) {
            diagonal.copy_from_slice(&[2.0, 0.5, 0.5, 1.5]);
        }
        a
    }

    /// `A x`.
    fn product(a: &SymmetricBlocks, x: &[f64]) -> Vec<f64> {
        let count = x.len();
        let mut out = vec![0.0; count];
        for i in 0..count {
            let mut unit = vec![0.0; count];
            unit[i] = 1.0;
            let sum: Vec<f64> = unit.iter().zip(x).map(|(u, x)| u + x).collect();
            // The form is quadratic; its polarisation gives the entry.
            out[i] = 0.5 * (a.form(&sum) - a.form(&unit) - a.form(x));
        }
        out
    }

    #[test]
    fn the_factor_solves_the_system() {
        for a in [matrix(0.0), cyclic(3), cyclic(4), cyclic(5)] {
            let count = a.diagonal.len() / a.size;
            let x: Vec<f64> = (0..count).map(|i| (0.7 * i as f64).cos()).collect();
            let mut b = product(&a, &x);
            a.factored().expect("positive definite").solve(&mut b);
            for (found, x) in b.iter().zip(&x) {
                assert!((found - x).abs() < 1e-14, "{found} {x}");
            }
        }
    }

    #[test]
    fn elimination_solves_indefinite_systems_too() {
        for (shift, a) in [
            (-1.2, matrix(0.0)),
            (-1.2, cyclic(3)),
            (-1.2, cyclic(5)),
            (0.0, cyclic(4)),
        ] {
            let count = a.diagonal.len() / a.size;
            let mut unit = SymmetricBlocks {
                beside: vec![0.0; a.beside.len()],
                corner: vec![0.0; a.corner.len()],
                ..a.clone()
            };
            for diagonal in unit.diagonal.chunks_exact_mut(4) {
                diagonal.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
            }
            let a = a.plus(shift, &unit);
            assert_eq!(a.clone().factored().is_none(), shift < 0.0);
            let x: Vec<f64> = (0..count).map(|i| (0.7 * i as f64).cos()).collect();
            let mut b = product(&a, &x);
            a.eliminated().expect("regular").solve(&mut b);
            for (found, x) in b.iter().zip(&x) {
                assert!((found - x).abs() < 1e-13, "{found} {x}");
            }
        }
        assert!(SymmetricBlocks::zeros(3, 2).eliminated().is_none());
    }

    #[test]
    fn entries_that_are_held_solve_for_themselves() {
        for (block, mut a) in [
            (0, cyclic(4)),
            (1, cyclic(4)),
            (3, cyclic(4)),
            (2, matrix(0.0)),
        ] {
            a.hold(block, 1);
            let mut unit = vec![0.0; a.diagonal.len() / a.size];
            unit[2 * block] = 1.0;
            assert_eq!(product(&a, &unit), unit);
            let expected = unit.clone();
            a.factored().expect("positive definite").solve(&mut unit);
            assert_eq!(unit, expected);
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
