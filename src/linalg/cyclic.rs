//! Block tridiagonal systems, plain or cyclic, in time linear in the number of blocks.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.5.1 (block LU factorisation); the cyclic system by
//! elimination of its last block.

use faer::Mat;

use super::decomp::solve_matrix;

/// Square blocks of one size: row `i` has blocks for the unknowns `i - 1`, `i` and `i + 1`.
///
/// In a cyclic system the first row's block below and the last row's block above belong to the other end; in a plain one they
/// do not count.
#[derive(Debug, Clone)]
pub(crate) struct BlockRows {
    pub(crate) below: Vec<Mat<f64>>,
    pub(crate) diagonal: Vec<Mat<f64>>,
    pub(crate) above: Vec<Mat<f64>>,
}

/// Factors of such a matrix, for many right-hand sides.
#[derive(Debug, Clone)]
pub(crate) struct BlockFactors {
    size: usize,
    below: Vec<Mat<f64>>,
    /// Inverse pivots, and inverse pivots times the blocks above.
    inverse: Vec<Mat<f64>>,
    share: Vec<Mat<f64>>,
    border: Option<Border>,
}

/// The last row and column of a cyclic system.
#[derive(Debug, Clone)]
struct Border {
    /// Solutions of the other rows for the last column.
    columns: Vec<Mat<f64>>,
    /// Blocks of the last row for the first unknown and for the one before.
    above: Mat<f64>,
    below: Mat<f64>,
    inverse: Mat<f64>,
}

impl BlockRows {
    /// The zero matrix of `count` by `count` blocks.
    pub(crate) fn zeros(count: usize, size: usize) -> Self {
        let blocks = || vec![Mat::zeros(size, size); count];
        BlockRows {
            below: blocks(),
            diagonal: blocks(),
            above: blocks(),
        }
    }

    /// Factors of the plain system, pivoting inside of blocks only. `None` where a block is singular.
    pub(crate) fn factor(self) -> Option<BlockFactors> {
        let count = self.diagonal.len();
        self.eliminated(count)
    }

    /// Factors of the cyclic system. `None` where a block is singular.
    pub(crate) fn factor_cyclic(mut self) -> Option<BlockFactors> {
        let last = self.diagonal.len() - 1;
        if last == 0 {
            self.diagonal[0] = &self.diagonal[0] + &self.below[0] + &self.above[0];
            return self.eliminated(1);
        }
        let mut factors = self.eliminated(last)?;
        let size = factors.size;
        let mut columns = vec![Mat::zeros(size, size); last];
        for (row, block) in [(0, &self.below[0]), (last - 1, &self.above[last - 1])] {
            columns[row] += block;
        }
        let mut flat = vec![0.0; last * size];
        for j in 0..size {
            for (entry, (i, row)) in flat.iter_mut().zip(places(last, size)) {
                *entry = columns[i][(row, j)];
            }
            factors.solve_rows(&mut flat);
            for (entry, (i, row)) in flat.iter().zip(places(last, size)) {
                columns[i][(row, j)] = *entry;
            }
        }
        let (above, below) = (self.above[last].clone(), self.below[last].clone());
        let pivot = &self.diagonal[last] - &above * &columns[0] - &below * &columns[last - 1];
        factors.border = Some(Border {
            inverse: inverse(&pivot)?,
            columns,
            above,
            below,
        });
        Some(factors)
    }

    /// The leading `count` block rows.
    fn eliminated(&self, count: usize) -> Option<BlockFactors> {
        let (mut inverses, mut shares): (Vec<Mat<f64>>, Vec<Mat<f64>>) = (Vec::new(), Vec::new());
        for i in 0..count {
            let mut pivot = self.diagonal[i].clone();
            if let Some(share) = shares.last() {
                pivot -= &self.below[i] * share;
            }
            let inverse = inverse(&pivot)?;
            shares.push(&inverse * &self.above[i]);
            inverses.push(inverse);
        }
        Some(BlockFactors {
            size: self.diagonal.first()?.nrows(),
            below: self.below[..count].to_vec(),
            inverse: inverses,
            share: shares,
            border: None,
        })
    }
}

impl BlockFactors {
    /// Solution in place, block after block.
    pub(crate) fn solve(&self, right: &mut [f64]) {
        let Some(border) = &self.border else {
            return self.solve_rows(right);
        };
        let (rows, last) = right.split_at_mut(right.len() - self.size);
        self.solve_rows(rows);
        subtract_product(&border.above, &rows[..self.size], last);
        subtract_product(&border.below, &rows[rows.len() - self.size..], last);
        multiply(&border.inverse, last);
        for (row, column) in rows.chunks_exact_mut(self.size).zip(&border.columns) {
            subtract_product(column, last, row);
        }
    }

    /// All rows but that of the border.
    fn solve_rows(&self, right: &mut [f64]) {
        let size = self.size;
        for i in 0..self.inverse.len() {
            let (before, at) = right.split_at_mut(size * i);
            let at = &mut at[..size];
            if i > 0 {
                subtract_product(&self.below[i], &before[size * (i - 1)..], at);
            }
            multiply(&self.inverse[i], at);
        }
        for i in (1..self.inverse.len()).rev() {
            let (before, at) = right.split_at_mut(size * i);
            subtract_product(
                &self.share[i - 1],
                &at[..size],
                &mut before[size * (i - 1)..],
            );
        }
    }
}

fn inverse(a: &Mat<f64>) -> Option<Mat<f64>> {
    let identity: Mat<f64> = Mat::identity(a.nrows(), a.nrows());
    solve_matrix(a.as_ref(), identity.as_ref())
}

/// Which block and row the entries of `count` blocks of one column belong to.
fn places(count: usize, size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count * size).map(move |i| (i / size, i % size))
}

/// `out += factor a x`.
pub(crate) fn add_product(factor: f64, a: &Mat<f64>, x: &[f64], out: &mut [f64]) {
    for (column, x) in a.col_iter().zip(x) {
        for (out, a) in out.iter_mut().zip(column.iter()) {
            *out += factor * a * x;
        }
    }
}

fn subtract_product(a: &Mat<f64>, x: &[f64], out: &mut [f64]) {
    add_product(-1.0, a, x, out);
}

/// `x = a x`.
fn multiply(a: &Mat<f64>, x: &mut [f64]) {
    let old = x.to_vec();
    x.fill(0.0);
    add_product(1.0, a, &old, x);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(count: usize) -> (BlockRows, Vec<f64>) {
        let size = 3;
        let entry = |i: usize, j: usize, l: usize| ((7 * i + 3 * j + 5 * l) as f64).sin();
        let mut rows = BlockRows::zeros(count, size);
        for i in 0..count {
            rows.diagonal[i] = Mat::from_fn(size, size, |a, b| {
                entry(a + b, a * b, i) + if a == b { 9.0 } else { 0.0 }
            });
            rows.below[i] = Mat::from_fn(size, size, |a, b| entry(a, b, i));
            rows.above[i] = Mat::from_fn(size, size, |a, b| entry(b, a + 1, i));
        }
        let x = (0..count * size).map(|i| entry(i, 1, 2)).collect();
        (rows, x)
    }

    fn distance(a: &[f64], b: &[f64]) -> f64 {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    // Well conditioned systems of at most 15 unknowns.
    const ROUND_OFF: f64 = 15.0 * 8.0 * f64::EPSILON;

    #[test]
    fn solves_a_tridiagonal_system() {
        for count in [1, 2, 5] {
            let (rows, x) = system(count);
            let mut right = vec![0.0; x.len()];
            for i in 0..count {
                let out = &mut right[3 * i..][..3];
                add_product(1.0, &rows.diagonal[i], &x[3 * i..], out);
                if i > 0 {
                    add_product(1.0, &rows.below[i], &x[3 * (i - 1)..], out);
                }
                if i + 1 < count {
                    add_product(1.0, &rows.above[i], &x[3 * (i + 1)..], out);
                }
            }
            rows.factor().unwrap().solve(&mut right);
            assert!(distance(&right, &x) < ROUND_OFF, "{count}");
        }
    }

    #[test]
    fn solves_a_cyclic_system() {
        for count in [1, 2, 3, 5] {
            let (rows, x) = system(count);
            let mut right = vec![0.0; x.len()];
            for i in 0..count {
                let (before, after) = ((i + count - 1) % count, (i + 1) % count);
                let out = &mut right[3 * i..][..3];
                add_product(1.0, &rows.diagonal[i], &x[3 * i..], out);
                add_product(1.0, &rows.below[i], &x[3 * before..], out);
                add_product(1.0, &rows.above[i], &x[3 * after..], out);
            }
            rows.factor_cyclic().unwrap().solve(&mut right);
            assert!(distance(&right, &x) < ROUND_OFF, "{count}");
        }
    }
}
