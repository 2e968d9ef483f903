//! Block tridiagonal systems, plain or cyclic, in time linear in the number of blocks.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.5.1 (block LU factorisation); the cyclic system by
//! elimination of its last block.

/// Square blocks of one size, by rows: row `i` has blocks for the unknowns `i - 1`, `i` and `i + 1`.
///
/// In a cyclic system, the first row's block `i - 1` and the last row's block `i + 1` belong to the unknown at the
/// other end; in a plain one they are ignored.
#[derive(Clone)]
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

    /// Number of rows of blocks.
    pub(crate) fn count(&self) -> usize {
        self.diagonal.len() / self.size.pow(2)
    }

    /// The blocks of a row.
    pub(crate) fn row_mut(&mut self, row: usize) -> [&mut [f64]; 3] {
        let square = self.size.pow(2);
        let blocks = [&mut self.below, &mut self.diagonal, &mut self.above];
        blocks.map(|blocks| &mut blocks[row * square..][..square])
    }

    /// The factors of the plain matrix; `None` if a block is singular.
    pub(crate) fn factored(&self) -> Option<Factors> {
        let blocks = || vec![0.0; self.diagonal.len()];
        let mut factors = Factors {
            size: self.size,
            below: blocks(),
            above: blocks(),
            inverses: blocks(),
            border: None,
        };
        factors.update(self, |_| true)?;
        Some(factors)
    }

    /// The factors of the cyclic matrix; `None` if a block is singular.
    pub(crate) fn factored_cyclic(mut self) -> Option<Factors> {
        let d = self.size;
        let square = d * d;
        let last = self.diagonal.len() / square - 1;
        if last == 0 {
            for i in 0..square {
                self.diagonal[i] += self.below[i] + self.above[i];
            }
            return self.factored();
        }
        // The columns of the last unknown, by blocks.
        let mut columns = vec![0.0; last * square];
        for i in 0..square {
            columns[i] += self.below[i];
            columns[(last - 1) * square + i] += self.above[(last - 1) * square + i];
        }
        let ends = [
            self.above.split_off(last * square),
            self.below.split_off(last * square),
        ];
        let mut corner = self.diagonal.split_off(last * square);
        let mut factors = self.factored()?;
        factors.substitute(&mut columns, d);
        for (block, end) in [0, last - 1].into_iter().zip(&ends) {
            subtract_product(d, end, &columns[block * square..][..square], d, &mut corner);
        }
        let mut inverse = vec![0.0; square];
        invert(d, &mut corner, &mut inverse)?;
        factors.border = Some(Border {
            columns,
            ends,
            corner: inverse,
        });
        Some(factors)
    }
}

/// A block tridiagonal matrix as a product of factors.
pub(crate) struct Factors {
    size: usize,
    below: Vec<f64>,
    /// Blocks above the diagonal of the factor with unit diagonal.
    above: Vec<f64>,
    /// Inverses of the diagonal blocks.
    inverses: Vec<f64>,
    border: Option<Border>,
}

/// The additional factors of a cyclic matrix.
struct Border {
    /// The plain system solved for the columns of the last unknown.
    columns: Vec<f64>,
    /// The blocks of the last row for the first and for the last unknown but one.
    ends: [Vec<f64>; 2],
    /// The inverse of the Schur complement of the last unknown.
    corner: Vec<f64>,
}

impl Factors {
    /// Factors a plain matrix again of which only some rows have changed since; `None` if a block is singular, after which the
    /// factors are of no use.
    ///
    /// Factors below a changed row change too. If the matrix is diagonally dominant they do so ever less, until they are the
    /// same to the last digit.
    pub(crate) fn update(
        &mut self,
        matrix: &BlockTridiagonal,
        is_changed: impl Fn(usize) -> bool,
    ) -> Option<()> {
        debug_assert!(self.border.is_none(), "factors of a cyclic matrix");
        // Small sizes are compile-time constants: splines through 200 rotations then take 0.8 times as long.
        match self.size {
            2 => self.update_sized(2, matrix, is_changed),
            3 => self.update_sized(3, matrix, is_changed),
            d => self.update_sized(d, matrix, is_changed),
        }
    }

    #[inline(always)]
    fn update_sized(
        &mut self,
        d: usize,
        matrix: &BlockTridiagonal,
        is_changed: impl Fn(usize) -> bool,
    ) -> Option<()> {
        let square = d * d;
        let (mut pivot, mut share) = (vec![0.0; square], vec![0.0; square]);
        let mut has_moved = false;
        for row in 0..matrix.count() {
            if !has_moved && !is_changed(row) {
                continue;
            }
            let block = row * square..(row + 1) * square;
            let below = &mut self.below[block.clone()];
            below.copy_from_slice(&matrix.below[block.clone()]);
            pivot.copy_from_slice(&matrix.diagonal[block.clone()]);
            let (before, above) = self.above.split_at_mut(row * square);
            if row > 0 {
                let before = &before[(row - 1) * square..];
                subtract_product(d, below, before, d, &mut pivot);
            }
            let inverse = &mut self.inverses[block.clone()];
            invert(d, &mut pivot, inverse)?;
            share.fill(0.0);
            add_product(d, inverse, &matrix.above[block], d, &mut share);
            let above = &mut above[..square];
            has_moved = *above != *share;
            above.copy_from_slice(&share);
        }
        Some(())
    }

    /// Solves the system in place.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let d = self.size;
        let Some(Border {
            columns,
            ends,
            corner,
        }) = &self.border
        else {
            return self.substitute(b, 1);
        };
        let (b, rest) = b.split_at_mut(b.len() - d);
        self.substitute(b, 1);
        for (side, end) in [&b[..d], &b[b.len() - d..]].into_iter().zip(ends) {
            subtract_product(d, end, side, 1, rest);
        }
        let known = rest.to_vec();
        rest.fill(0.0);
        add_product(d, corner, &known, 1, rest);
        for (b, columns) in b.chunks_exact_mut(d).zip(columns.chunks_exact(d * d)) {
            subtract_product(d, columns, rest, 1, b);
        }
    }

    /// Solves the plain system for several right-hand sides, in row-major order.
    fn substitute(&self, b: &mut [f64], columns: usize) {
        match (self.size, columns) {
            (2, 1) => self.substitute_sized(2, b, 1),
            (3, 1) => self.substitute_sized(3, b, 1),
            (d, columns) => self.substitute_sized(d, b, columns),
        }
    }

    #[inline(always)]
    fn substitute_sized(&self, d: usize, b: &mut [f64], columns: usize) {
        let (square, width) = (d * d, d * columns);
        let mut here = vec![0.0; width];
        let count = self.inverses.len() / square;
        for block in 0..count {
            let (before, b) = b.split_at_mut(block * width);
            let b = &mut b[..width];
            if block > 0 {
                let before = &before[(block - 1) * width..];
                let below = &self.below[block * square..][..square];
                subtract_product(d, below, before, columns, b);
            }
            here.copy_from_slice(b);
            b.fill(0.0);
            let inverse = &self.inverses[block * square..][..square];
            add_product(d, inverse, &here, columns, b);
        }
        for block in (1..count).rev() {
            let (before, after) = b.split_at_mut(block * width);
            let above = &self.above[(block - 1) * square..][..square];
            let before = &mut before[(block - 1) * width..];
            subtract_product(d, above, &after[..width], columns, before);
        }
    }
}

/// Writes the inverse of a matrix; `None` if it is singular.
#[inline(always)]
fn invert(d: usize, a: &mut [f64], out: &mut [f64]) -> Option<()> {
    out.fill(0.0);
    for i in 0..d {
        out[i * d + i] = 1.0;
    }
    solve_dense(d, a, out, d)
}

/// `out += a b` for `a` of shape `(d, d)` and `b` of shape `(d, columns)`, in row-major order.
#[inline(always)]
fn add_product(d: usize, a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    for (a, out) in a.chunks_exact(d).zip(out.chunks_exact_mut(columns)) {
        for (a, b) in a.iter().zip(b.chunks_exact(columns)) {
            for (out, b) in out.iter_mut().zip(b) {
                *out += a * b;
            }
        }
    }
}

/// `out -= a b` for `a` of shape `(d, d)` and `b` of shape `(d, columns)`, in row-major order.
#[inline(always)]
fn subtract_product(d: usize, a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    for (a, out) in a.chunks_exact(d).zip(out.chunks_exact_mut(columns)) {
        for (a, b) in a.iter().zip(b.chunks_exact(columns)) {
            for (out, b) in out.iter_mut().zip(b) {
                *out -= a * b;
            }
        }
    }
}

/// Solves `a x = b` in place, with partial pivoting; `None` if the matrix is singular.
#[inline(always)]
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

    /// A matrix that is diagonally dominant by blocks.
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
                    true => system(count, d).factored_cyclic(),
                    false => system(count, d).factored(),
                };
                solved.unwrap().solve(&mut x);
                let left = residual(&system(count, d), cyclic, &x, &b);
                assert!(left < 1e-13, "{count} blocks of {d}: {left:e}");
            }
        }
    }

    /// Factors after a change of some rows are those of the new matrix, to the last digit.
    #[test]
    fn factors_of_changed_rows_are_those_of_the_matrix() {
        for d in 1..5 {
            let mut matrix = system(40, d);
            let mut factors = matrix.factored().unwrap();
            let changed = [0, 7, 8, 30, 39];
            for row in changed {
                for block in matrix.row_mut(row) {
                    block.iter_mut().for_each(|x| *x *= 1.25);
                }
            }
            // A row of a given unknown.
            let [below, diagonal, above] = matrix.row_mut(7);
            for block in [below, &mut *diagonal, above] {
                block.fill(0.0);
            }
            diagonal.iter_mut().step_by(d + 1).for_each(|x| *x = 1.0);
            factors
                .update(&matrix, |row| changed.contains(&row))
                .unwrap();
            let expected = matrix.factored().unwrap();
            assert_eq!(factors.below, expected.below);
            assert_eq!(factors.above, expected.above);
            assert_eq!(factors.inverses, expected.inverses);
        }
    }

    #[test]
    fn a_singular_block_is_none() {
        assert!(BlockTridiagonal::zeros(2, 2).factored().is_none());
    }
}
