//! Block tridiagonal systems, plain or cyclic, in time linear in the number of blocks.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.5.1 (block LU factorisation); the cyclic system by elimination
//! of its last block.

/// Square blocks of one size, row by row: row `i` has blocks for the unknowns `i - 1`, `i` and `i + 1`.
///
/// In a cyclic system the first row's block below and the last row's block above belong to the other end; in a plain one they
/// do not count.
pub(crate) struct BlockTridiagonal {
    size: usize,
    pub(crate) below: Vec<f64>,
    pub(crate) diagonal: Vec<f64>,
    pub(crate) above: Vec<f64>,
}

impl BlockTridiagonal {
    /// The zero matrix of `count` by `count` blocks.
    pub(crate) fn zeros(count: usize, size: usize) -> Self {
        let blocks = || vec![0.0; count * size * size];
        BlockTridiagonal {
            size,
            below: blocks(),
            diagonal: blocks(),
            above: blocks(),
        }
    }

    /// Solves the plain system in place; `None` where a block is singular.
    pub(crate) fn solve(mut self, b: &mut [f64]) -> Option<()> {
        let count = b.len() / self.size;
        self.eliminate(count, b, 1)
    }

    /// Solves the cyclic system in place; `None` where a block is singular.
    pub(crate) fn solve_cyclic(mut self, b: &mut [f64]) -> Option<()> {
        let (d, count) = (self.size, b.len() / self.size);
        let square = d * d;
        if count == 1 {
            for i in 0..square {
                self.diagonal[i] += self.below[i] + self.above[i];
            }
            return self.eliminate(1, b, 1);
        }
        let last = count - 1;
        // The right-hand side and, beside it, the columns of the last unknown.
        let columns = d + 1;
        let mut sides = vec![0.0; last * d * columns];
        for (row, side) in sides.chunks_exact_mut(columns).enumerate() {
            side[d] = b[row];
            let (block, within) = (row / d, row % d);
            for j in 0..d {
                if block == 0 {
                    side[j] += self.below[within * d + j];
                }
                if block == last - 1 {
                    side[j] += self.above[block * square + within * d + j];
                }
            }
        }
        let ends = [
            self.above[last * square..].to_vec(),
            self.below[last * square..].to_vec(),
        ];
        let mut corner = self.diagonal[last * square..].to_vec();
        self.eliminate(last, &mut sides, columns)?;
        // The last row: above x_0 + below x_{last - 1} + diagonal x_last = b_last.
        let mut rest = b[last * d..].to_vec();
        for (block, end) in [0, last - 1].into_iter().zip(&ends) {
            for p in 0..d {
                for l in 0..d {
                    let side = &sides[(block * d + l) * columns..][..columns];
                    for q in 0..d {
                        corner[p * d + q] -= end[p * d + l] * side[q];
                    }
                    rest[p] -= end[p * d + l] * side[d];
                }
            }
        }
        solve_dense(d, &mut corner, &mut rest, 1)?;
        for (entry, side) in b.iter_mut().zip(sides.chunks_exact(columns)) {
            let due: f64 = side.iter().zip(&rest).map(|(a, x)| a * x).sum();
            *entry = side[d] - due;
        }
        b[last * d..].copy_from_slice(&rest);
        Some(())
    }

    /// Solves the first `count` rows for right-hand sides of some columns, row by row.
    fn eliminate(&mut self, count: usize, b: &mut [f64], columns: usize) -> Option<()> {
        let d = self.size;
        let (square, width) = (d * d, d + columns);
        let mut side = vec![0.0; d * width];
        for block in 0..count {
            let row = block * d * columns;
            if block > 0 {
                let (before, here) = b.split_at_mut(row);
                let before = &before[row - d * columns..];
                let above = &self.above[(block - 1) * square..][..square];
                let diagonal = &mut self.diagonal[block * square..][..square];
                let below = &self.below[block * square..][..square];
                subtract_product(d, below, above, d, diagonal);
                subtract_product(d, below, before, columns, &mut here[..d * columns]);
            }
            for (p, side) in side.chunks_exact_mut(width).enumerate() {
                side[..d].copy_from_slice(&self.above[block * square + p * d..][..d]);
                side[d..].copy_from_slice(&b[row + p * columns..][..columns]);
            }
            solve_dense(
                d,
                &mut self.diagonal[block * square..][..square],
                &mut side,
                width,
            )?;
            for (p, side) in side.chunks_exact(width).enumerate() {
                self.above[block * square + p * d..][..d].copy_from_slice(&side[..d]);
                b[row + p * columns..][..columns].copy_from_slice(&side[d..]);
            }
        }
        for block in (0..count.saturating_sub(1)).rev() {
            let (here, after) = b.split_at_mut((block + 1) * d * columns);
            let above = &self.above[block * square..][..square];
            let here = &mut here[block * d * columns..];
            subtract_product(d, above, &after[..d * columns], columns, here);
        }
        Some(())
    }
}

/// `out -= a b` for `a` of shape `(d, d)` and `b` of shape `(d, columns)`, row by row.
fn subtract_product(d: usize, a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    for (a, out) in a.chunks_exact(d).zip(out.chunks_exact_mut(columns)) {
        for (a, b) in a.iter().zip(b.chunks_exact(columns)) {
            for (out, b) in out.iter_mut().zip(b) {
                *out -= a * b;
            }
        }
    }
}

/// Solves `a x = b` in place, with partial pivoting; `None` for a singular matrix.
fn solve_dense(n: usize, a: &mut [f64], b: &mut [f64], columns: usize) -> Option<()> {
    for i in 0..n {
        let size = |row: usize| a[row * n + i].abs();
        let pivot = (i + 1..n).fold(
            i,
            |best, row| if size(row) > size(best) { row } else { best },
        );
        let inverse = 1.0 / a[pivot * n + i];
        if !inverse.is_finite() {
            return None;
        }
        if pivot != i {
            for j in 0..n {
                a.swap(pivot * n + j, i * n + j);
            }
            for j in 0..columns {
                b.swap(pivot * columns + j, i * columns + j);
            }
        }
        let (above, below) = a.split_at_mut((i + 1) * n);
        let (b_above, b_below) = b.split_at_mut((i + 1) * columns);
        let (top, b_top) = (&above[i * n..], &b_above[i * columns..]);
        let rows = below
            .chunks_exact_mut(n)
            .zip(b_below.chunks_exact_mut(columns));
        for (row, b_row) in rows {
            let share = row[i] * inverse;
            for (entry, top) in row[i + 1..].iter_mut().zip(&top[i + 1..]) {
                *entry -= share * top;
            }
            for (entry, top) in b_row.iter_mut().zip(b_top) {
                *entry -= share * top;
            }
        }
    }
    for i in (0..n).rev() {
        let (above, below) = b.split_at_mut((i + 1) * columns);
        let row = &mut above[i * columns..];
        for (share, other) in a[i * n + i + 1..][..n - i - 1]
            .iter()
            .zip(below.chunks_exact(columns))
        {
            for (entry, other) in row.iter_mut().zip(other) {
                *entry -= share * other;
            }
        }
        for entry in row {
            *entry /= a[i * n + i];
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of a matrix whose blocks on the diagonal dominate.
    fn system(count: usize, d: usize) -> BlockTridiagonal {
        let mut system = BlockTridiagonal::zeros(count, d);
        let entry = |i: usize, shift: usize| (1.7 * i as f64 + shift as f64).sin();
        for i in 0..count * d * d {
            system.below[i] = entry(i, 1);
            system.above[i] = entry(i, 2);
            system.diagonal[i] = entry(i, 3);
        }
        for row in 0..count * d {
            system.diagonal[row * d + row % d] += 4.0 * d as f64;
        }
        system
    }

    fn residual(system: &BlockTridiagonal, cyclic: bool, x: &[f64], b: &[f64]) -> f64 {
        let (d, count) = (system.size, x.len() / system.size);
        let mut largest = 0.0_f64;
        for row in 0..count * d {
            let block = row / d;
            let mut sum = -b[row];
            let parts = [
                (&system.below, block > 0, (block + count - 1) % count),
                (&system.diagonal, true, block),
                (&system.above, block + 1 < count, (block + 1) % count),
            ];
            for (matrix, inside, other) in parts {
                if inside || cyclic {
                    sum += (0..d)
                        .map(|j| matrix[row * d + j] * x[other * d + j])
                        .sum::<f64>();
                }
            }
            largest = largest.max(sum.abs());
        }
        largest
    }

    #[test]
    fn systems_are_solved() {
        for (count, d) in [(1, 3), (2, 1), (2, 3), (3, 2), (7, 4)] {
            let b: Vec<f64> = (0..count * d).map(|i| (0.3 * i as f64).cos()).collect();
            for cyclic in [false, true] {
                let mut x = b.clone();
                let solved = match cyclic {
                    true => system(count, d).solve_cyclic(&mut x),
                    false => system(count, d).solve(&mut x),
                };
                assert!(solved.is_some());
                let left = residual(&system(count, d), cyclic, &x, &b);
                assert!(left < 1e-13, "{count} blocks of {d}: {left:e}");
            }
        }
    }

    #[test]
    fn a_singular_block_is_none() {
        assert!(BlockTridiagonal::zeros(2, 2).solve(&mut [1.0; 4]).is_none());
    }
}
