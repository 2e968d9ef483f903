//! Symmetric block tridiagonal systems, in time linear in the number of blocks.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.5.1 (block LU factorisation).

use faer::Mat;

use super::decomp::solve_matrix;

/// A symmetric block tridiagonal matrix of square blocks of one size.
#[derive(Debug, Clone)]
pub(crate) struct BlockTridiagonal {
    /// Blocks `(i, i)`.
    pub(crate) diagonal: Vec<Mat<f64>>,
    /// Blocks `(i, i + 1)`, one fewer.
    pub(crate) above: Vec<Mat<f64>>,
}

impl BlockTridiagonal {
    /// The zero matrix of `count` by `count` blocks.
    pub(crate) fn zeros(count: usize, size: usize) -> Self {
        BlockTridiagonal {
            diagonal: vec![Mat::zeros(size, size); count],
            above: vec![Mat::zeros(size, size); count.saturating_sub(1)],
        }
    }

    /// Solution by block elimination without pivoting between blocks: for positive definite matrices. `None` where a block is
    /// singular.
    pub(crate) fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let size = self.diagonal.first()?.nrows();
        let (mut shares, mut values): (Vec<Mat<f64>>, Vec<Mat<f64>>) = (Vec::new(), Vec::new());
        for (i, diagonal) in self.diagonal.iter().enumerate() {
            let mut pivot = diagonal.clone();
            let mut value = Mat::from_fn(size, 1, |row, _| right[i * size + row]);
            if let (Some(share), Some(before)) = (shares.last(), values.last()) {
                let below = self.above[i - 1].transpose();
                pivot -= below * share;
                value -= below * before;
            }
            values.push(solve_matrix(pivot.as_ref(), value.as_ref())?);
            if let Some(above) = self.above.get(i) {
                shares.push(solve_matrix(pivot.as_ref(), above.as_ref())?);
            }
        }
        for i in (1..values.len()).rev() {
            let correction = &shares[i - 1] * &values[i];
            values[i - 1] -= correction;
        }
        let entries = values.iter().flat_map(|v| (0..size).map(|row| v[(row, 0)]));
        Some(entries.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_positive_definite_system() {
        let (count, size) = (5, 3);
        let mut matrix = BlockTridiagonal::zeros(count, size);
        let entry = |i: usize, j: usize, l: usize| ((7 * i + 3 * j + 5 * l) as f64).sin();
        for i in 0..count {
            matrix.diagonal[i] = Mat::from_fn(size, size, |a, b| {
                entry(a + b, a * b, i) + if a == b { 8.0 } else { 0.0 }
            });
            if i + 1 < count {
                matrix.above[i] = Mat::from_fn(size, size, |a, b| entry(a, b, i));
            }
        }
        let x: Vec<f64> = (0..count * size).map(|i| entry(i, 1, 2)).collect();
        let part = |i: usize| Mat::from_fn(size, 1, |row, _| x[i * size + row]);
        let mut right = Vec::new();
        for i in 0..count {
            let mut sum = &matrix.diagonal[i] * part(i);
            if i > 0 {
                sum += matrix.above[i - 1].transpose() * part(i - 1);
            }
            if i + 1 < count {
                sum += &matrix.above[i] * part(i + 1);
            }
            right.extend((0..size).map(|row| sum[(row, 0)]));
        }
        let found = matrix.solve(&right).unwrap();
        let error = found
            .iter()
            .zip(&x)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        // A well conditioned system of 15 unknowns.
        assert!(error < 15.0 * 4.0 * f64::EPSILON, "{error:e}");
    }
}
