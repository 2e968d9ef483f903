//! Block tridiagonal systems, plain or cyclic, in time linear in the number of blocks.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.5.1 (block LU factorisation); the cyclic system by
//! elimination of its last block.

use faer::Mat;

use super::decomp::solve_matrix;

/// Square blocks of one size: row `i` has blocks for the unknowns `i - 1`, `i` and `i + 1`.
///
/// In a cyclic system the first row's block below and the last row's block above belong to the other end.
#[derive(Debug, Clone)]
pub(crate) struct BlockRows {
    pub(crate) below: Vec<Mat<f64>>,
    pub(crate) diagonal: Vec<Mat<f64>>,
    pub(crate) above: Vec<Mat<f64>>,
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

    /// Solution by block elimination, pivoting inside of blocks only; blocks beyond the ends count as zero. `None` where a
    /// block is singular.
    pub(crate) fn solve(&self, right: &[Mat<f64>]) -> Option<Vec<Mat<f64>>> {
        self.eliminate(right, self.diagonal.len())
    }

    /// Solution of the cyclic system. `None` where a block is singular.
    pub(crate) fn solve_cyclic(&self, right: &[Mat<f64>]) -> Option<Vec<Mat<f64>>> {
        let (last, size) = (self.diagonal.len() - 1, self.diagonal.first()?.nrows());
        if last == 0 {
            let all = &self.diagonal[0] + &self.below[0] + &self.above[0];
            return Some(vec![solve_matrix(all.as_ref(), right[0].as_ref())?]);
        }
        // Right-hand sides, and the columns of the last unknown.
        let columns = right[0].ncols();
        let mut wide: Vec<Mat<f64>> = right[..last]
            .iter()
            .map(|r| {
                let mut both = Mat::zeros(size, columns + size);
                both.as_mut().subcols_mut(0, columns).copy_from(r);
                both
            })
            .collect();
        for (row, block) in [(0, &self.below[0]), (last - 1, &self.above[last - 1])] {
            let mut part = wide[row].as_mut().subcols_mut(columns, size);
            part += block;
        }
        let solved = self.eliminate(&wide, last)?;
        let (first, end) = (&solved[0], &solved[last - 1]);
        let rest = &self.above[last] * first + &self.below[last] * end;
        let pivot = &self.diagonal[last] - rest.as_ref().subcols(columns, size);
        let value = &right[last] - rest.as_ref().subcols(0, columns);
        let border = solve_matrix(pivot.as_ref(), value.as_ref())?;
        let mut out: Vec<Mat<f64>> = solved
            .iter()
            .map(|both| {
                let (value, share) = both.as_ref().split_at_col(columns);
                value - share * &border
            })
            .collect();
        out.push(border);
        Some(out)
    }

    /// The leading `count` block rows.
    fn eliminate(&self, right: &[Mat<f64>], count: usize) -> Option<Vec<Mat<f64>>> {
        let (mut shares, mut values): (Vec<Mat<f64>>, Vec<Mat<f64>>) = (Vec::new(), Vec::new());
        for i in 0..count {
            let (mut pivot, mut value) = (self.diagonal[i].clone(), right[i].clone());
            if let (Some(share), Some(before)) = (shares.last(), values.last()) {
                pivot -= &self.below[i] * share;
                value -= &self.below[i] * before;
            }
            let (size, columns) = value.shape();
            let mut both = Mat::zeros(size, columns + size);
            both.as_mut().subcols_mut(0, columns).copy_from(&value);
            both.as_mut()
                .subcols_mut(columns, size)
                .copy_from(&self.above[i]);
            let solved = solve_matrix(pivot.as_ref(), both.as_ref())?;
            let (value, share) = solved.as_ref().split_at_col(columns);
            values.push(value.to_owned());
            shares.push(share.to_owned());
        }
        for i in (1..count).rev() {
            let correction = &shares[i - 1] * &values[i];
            values[i - 1] -= correction;
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(count: usize) -> (BlockRows, Vec<Mat<f64>>) {
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
        let x = (0..count)
            .map(|i| Mat::from_fn(size, 2, |a, b| entry(i, a, b)))
            .collect();
        (rows, x)
    }

    fn distance(a: &[Mat<f64>], b: &[Mat<f64>]) -> f64 {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a - b).norm_max()).fold(0.0, f64::max)
    }

    // Well conditioned systems of at most 15 unknowns.
    const ROUND_OFF: f64 = 15.0 * 4.0 * f64::EPSILON;

    #[test]
    fn solves_a_tridiagonal_system() {
        for count in [1, 2, 5] {
            let (rows, x) = system(count);
            let right: Vec<Mat<f64>> = (0..count)
                .map(|i| {
                    let mut sum = &rows.diagonal[i] * &x[i];
                    if i > 0 {
                        sum += &rows.below[i] * &x[i - 1];
                    }
                    if i + 1 < count {
                        sum += &rows.above[i] * &x[i + 1];
                    }
                    sum
                })
                .collect();
            let found = rows.solve(&right).unwrap();
            assert!(distance(&found, &x) < ROUND_OFF, "{count}");
        }
    }

    #[test]
    fn solves_a_cyclic_system() {
        for count in [1, 2, 3, 5] {
            let (rows, x) = system(count);
            let right: Vec<Mat<f64>> = (0..count)
                .map(|i| {
                    let (before, after) = ((i + count - 1) % count, (i + 1) % count);
                    &rows.diagonal[i] * &x[i]
                        + &rows.below[i] * &x[before]
                        + &rows.above[i] * &x[after]
                })
                .collect();
            let found = rows.solve_cyclic(&right).unwrap();
            assert!(distance(&found, &x) < ROUND_OFF, "{count}");
        }
    }
}
