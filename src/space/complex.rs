//! Complex frames and subspaces, as embedded real matrices: the blocks of [`RealSpace`](super::RealSpace) for the unitary
//! group.
//!
//! ```math
//! S \mapsto \begin{pmatrix} \operatorname{Re} S & -\operatorname{Im} S \\ \operatorname{Im} S & \operatorname{Re} S \end{pmatrix}
//! ```
//!
//! Every entry occurs twice, except the imaginary parts on the diagonal, which have half the weight in the metric
//! `tr(A^H B) / 2`. The coordinates contain each entry once, so their number is the dimension of the complex space.
//! Only half of the entries of a bracket are computed: four real products for a complex one.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use super::homogeneous::Homogeneous;
use super::quotient::Quotient;
use crate::linalg::dual::Number;
use crate::linalg::field::Field;
use crate::linalg::simd::Four;

/// `U(p)/U(p - q)`, or `U(p)/(U(q) x U(p - q))`, for `p = r / 2` and `q = k / 2`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ComplexSpace {
    /// Rows and columns of the embedded matrices.
    pub(crate) r: usize,
    pub(crate) k: usize,
    pub(crate) quotient: Quotient,
}

/// A diagonal block of the embedded unitary matrices.
#[derive(Clone, Copy)]
struct ComplexBlock {
    /// Its first row.
    first: usize,
    size: usize,
}

impl ComplexBlock {
    /// Visits runs of entries of a skew-Hermitian matrix, starting at coordinate `p`: the real parts left of the
    /// diagonal, and the imaginary parts left of and on it.
    #[inline(always)]
    fn each_run(self, mut p: usize, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let ComplexBlock { first, size } = self;
        // A single call site of `visit`: kernels are inlined into it.
        for row in 1..2 * size {
            let count = if row < size { row } else { row - size + 1 };
            visit(p, first + row, first, count);
            p += count;
        }
    }
}

impl ComplexSpace {
    /// Complex columns, and complex rows below them.
    #[inline(always)]
    fn sizes(self) -> [usize; 2] {
        [self.k / 2, (self.r - self.k) / 2]
    }

    #[inline(always)]
    fn blocks(self) -> [ComplexBlock; 2] {
        let [columns, rows] = self.sizes();
        let block = |first, size| ComplexBlock { first, size };
        [block(0, columns), block(self.k, rows)]
    }

    #[inline(always)]
    fn block_of(self, row: usize) -> ComplexBlock {
        self.blocks()[usize::from(row >= self.k)]
    }

    /// Number of coordinates of `omega`.
    #[inline(always)]
    fn turns(self) -> usize {
        match self.quotient {
            Quotient::Frames => self.sizes()[0].pow(2),
            Quotient::Subspaces => 0,
        }
    }

    /// `out = q_2 b q_1^T` for the columns of `b`, where `q_1, q_2` are the diagonal blocks of `q` or of its transpose;
    /// `q_1` only for subspaces.
    #[inline(always)]
    fn turn<T: Number>(self, q: &[T], x: &[T], out: &mut [T], is_back: bool) {
        let ([columns, half], first) = (self.sizes(), self.turns());
        let (r, k, rows) = (self.r, self.k, 2 * half);
        let entry = |i: usize, j: usize| if is_back { q[j * r + i] } else { q[i * r + j] };
        out[..first].copy_from_slice(&x[..first]);
        if rows == 0 {
            return;
        }
        let turned = |column: &[T], i: usize| {
            let mut sum = T::ZERO;
            for (l, x) in column.iter().enumerate() {
                sum += entry(k + i, k + l) * *x;
            }
            sum
        };
        let x = &x[first..][..rows * columns];
        let out = out[first..].chunks_exact_mut(rows).take(columns);
        for (c, out) in out.enumerate() {
            if self.quotient == Quotient::Frames {
                let column = &x[c * rows..][..rows];
                for (i, out) in out.iter_mut().enumerate() {
                    *out = turned(column, i);
                }
                continue;
            }
            out.fill(T::ZERO);
            for (d, column) in x.chunks_exact(rows).enumerate() {
                // The other copy of the column is `i` times the first.
                let [re, im] = [entry(c, d), entry(c, columns + d)];
                for i in 0..half {
                    let [upper, lower] = [turned(column, i), turned(column, half + i)];
                    out[i] += upper * re;
                    out[i] -= lower * im;
                    out[half + i] += lower * re;
                    out[half + i] += upper * im;
                }
            }
        }
    }

    /// `out -= z [E_ij - E_ji, x]`, for two rows of the same block.
    #[inline(always)]
    fn subtract_entry<T: Number>(self, z: T, [i, j]: [usize; 2], x: &[T], out: &mut [T]) {
        let ([columns, half], first) = (self.sizes(), self.turns());
        let (r, k, rows) = (self.r, self.k, 2 * half);
        if i >= k {
            for c in 0..columns {
                let out = &mut out[first + c * rows..][..rows];
                out[i - k] -= z * x[j * r + c];
                out[j - k] += z * x[i * r + c];
            }
            return;
        }
        for row in 0..rows {
            let b = &x[(k + row) * r..][..k];
            if j < columns {
                out[first + j * rows + row] += b[i] * z;
            }
            if i < columns {
                out[first + i * rows + row] -= b[j] * z;
            }
        }
    }
}

impl Homogeneous for ComplexSpace {
    type Width = Four;

    #[inline(always)]
    fn size(self) -> usize {
        self.r
    }

    #[inline(always)]
    fn dim(self) -> usize {
        let [columns, rows] = self.sizes();
        self.turns() + 2 * rows * columns
    }

    #[inline(always)]
    fn isotropy_dim(self) -> usize {
        let [columns, rows] = self.sizes();
        match self.quotient {
            Quotient::Frames => rows * rows,
            Quotient::Subspaces => columns * columns + rows * rows,
        }
    }

    #[inline(always)]
    fn each_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        if self.quotient == Quotient::Frames {
            self.blocks()[0].each_run(0, &mut visit);
        }
        self.each_turned_run(visit);
    }

    #[inline(always)]
    fn each_turned_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let ([columns, half], first) = (self.sizes(), self.turns());
        if half == 0 {
            return;
        }
        for j in 0..columns {
            visit(first + j * 2 * half, j, self.k, 2 * half);
        }
    }

    #[inline(always)]
    fn each_isotropy_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let [upper, lower] = self.blocks();
        let mut first = 0;
        if self.quotient == Quotient::Subspaces {
            upper.each_run(0, &mut visit);
            first = upper.size * upper.size;
        }
        lower.each_run(first, visit);
    }

    #[inline(always)]
    fn is_symmetric(self) -> bool {
        self.quotient == Quotient::Subspaces
    }

    #[inline(always)]
    fn isotropy_range(self) -> Range<usize> {
        self.k..self.r
    }

    #[inline(always)]
    fn column_isotropy_range(self) -> Range<usize> {
        match self.quotient {
            Quotient::Frames => 0..0,
            Quotient::Subspaces => 0..self.k,
        }
    }

    #[inline(always)]
    fn scale(self, row: usize, column: usize) -> f64 {
        let ComplexBlock { size, .. } = self.block_of(row);
        match row == column + size || column == row + size {
            // Both in one block: in different blocks, rows that far apart hold `b`.
            true if (row < self.k) == (column < self.k) => FRAC_1_SQRT_2,
            _ => 1.0,
        }
    }

    #[inline(always)]
    fn partner(self, row: usize) -> Option<(usize, f64)> {
        let ComplexBlock { first, size } = self.block_of(row);
        Some(match row < first + size {
            true => (row + size, 1.0),
            false => (row - size, -1.0),
        })
    }

    #[inline(always)]
    fn turn_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]) {
        self.turn(q, x, out, false);
    }

    #[inline(always)]
    fn turn_back_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]) {
        self.turn(q, x, out, true);
    }

    #[inline(always)]
    fn isotropy_part_into<T: Field>(self, u: &[T], out: &mut [T]) {
        let (r, k) = (self.r, self.k);
        let is_free = |row: usize| row >= k || self.quotient == Quotient::Subspaces;
        for i in 0..r {
            for j in 0..r {
                out[i * r + j] = match ((i < k) == (j < k), i == j) {
                    (true, _) if is_free(i) => u[i * r + j],
                    (true, true) => T::constant(1.0),
                    _ => T::ZERO,
                };
            }
        }
    }

    #[inline(always)]
    fn row_len(self, row: usize) -> usize {
        if row < self.k { self.r } else { self.k }
    }

    #[inline(always)]
    fn subtract_action<T: Number>(self, z: &[T], x: &[T], out: &mut [T]) {
        self.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| {
                let z = z[p] * self.scale(i, j).recip();
                self.subtract_entry(z, [i, j], x, out);
                if let Some((copy, sign)) = self.copy_of(i, j) {
                    self.subtract_entry(z * sign, copy, x, out);
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::test_matrices::{commutator, numbers, product};

    /// Numbers of complex rows and columns.
    const SHAPES: [[usize; 2]; 7] = [[1, 1], [2, 1], [3, 1], [2, 2], [3, 2], [5, 2], [6, 4]];

    fn spaces() -> impl Iterator<Item = ComplexSpace> {
        SHAPES.into_iter().flat_map(|[p, q]| {
            let space = |quotient| ComplexSpace {
                r: 2 * p,
                k: 2 * q,
                quotient,
            };
            [Quotient::Frames, Quotient::Subspaces].map(space)
        })
    }

    fn matrix(space: ComplexSpace, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; space.r * space.r];
        space.matrix_into(x, &mut out);
        out
    }

    fn isotropy_matrix(space: ComplexSpace, z: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; space.r * space.r];
        space.isotropy_matrix_into(z, &mut out);
        out
    }

    /// Coordinates of the parts in `m` and in `h`.
    fn parts(space: ComplexSpace, a: &[f64]) -> [Vec<f64>; 2] {
        let mut out = [vec![0.0; space.dim()], vec![0.0; space.isotropy_dim()]];
        let [x, z] = &mut out;
        space.each_entry(|p, i, j| x[p] = space.skew_coordinate(a, [i, j]));
        space.each_isotropy_entry(|p, i, j| z[p] = space.skew_coordinate(a, [i, j]));
        out
    }

    /// The complex structure of both blocks, in row-major order.
    fn structure(space: ComplexSpace) -> Vec<f64> {
        let r = space.r;
        let mut out = vec![0.0; r * r];
        for row in 0..r {
            let (other, sign) = space.partner(row).unwrap();
            out[other * r + row] = sign;
        }
        out
    }

    /// A random element of `H`, or of the whole group: a product of exponentials.
    fn turn(space: ComplexSpace, is_whole: bool) -> Vec<f64> {
        let r = space.r;
        let mut a = isotropy_matrix(space, &numbers(space.isotropy_dim(), 2));
        if is_whole {
            let x = matrix(space, &numbers(space.dim(), 8));
            a.iter_mut().zip(x).for_each(|(a, x)| *a += x);
        }
        let mut sum: Vec<f64> = (0..r * r)
            .map(|at| f64::from(u8::from(at / r == at % r)))
            .collect();
        let mut term = sum.clone();
        for k in 1..60 {
            term = product(r, &term, &a);
            term.iter_mut().for_each(|x| *x *= 0.1 / k as f64);
            sum.iter_mut().zip(&term).for_each(|(sum, x)| *sum += x);
        }
        sum
    }

    fn assert_near(a: &[f64], b: &[f64], space: ComplexSpace) {
        assert_eq!(a.len(), b.len());
        let size = b.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < 1e-13 * size, "{space:?}: {a} {b}");
        }
    }

    #[test]
    fn matrices_are_embedded_and_coordinates_orthonormal() {
        for space in spaces() {
            let (r, j) = (space.r, structure(space));
            let (x, z) = (numbers(space.dim(), 1), numbers(space.isotropy_dim(), 4));
            for (a, coordinates) in [(matrix(space, &x), &x), (isotropy_matrix(space, &z), &z)] {
                assert_eq!(product(r, &a, &j), product(r, &j, &a), "{space:?}");
                let back = (0..r * r).all(|at| a[at] == -a[at % r * r + at / r]);
                assert!(back, "{space:?}");
                // tr(A^H A) / 2 of the complex matrix; each of its entries occurs twice.
                let square = a.iter().map(|x| x * x).sum::<f64>() / 4.0;
                let expected: f64 = coordinates.iter().map(|x| x * x).sum();
                assert!((square - expected).abs() <= 1e-14 * expected, "{space:?}");
            }
            let all: Vec<f64> = matrix(space, &x)
                .iter()
                .zip(isotropy_matrix(space, &z))
                .map(|(x, z)| x + z)
                .collect();
            let [m, h] = parts(space, &all);
            assert_near(&m, &x, space);
            assert_near(&h, &z, space);
            // Together a basis of the unitary Lie algebra.
            assert_eq!(x.len() + z.len(), r * r / 4);
        }
    }

    #[test]
    fn brackets_and_actions_are_those_of_matrices() {
        for space in spaces() {
            let r = space.r;
            let [x, y] = [1, 5].map(|seed| matrix(space, &numbers(space.dim(), seed)));
            let z = numbers(space.isotropy_dim(), 3);
            let [m, h] = parts(space, &commutator(r, &x, &y));
            let mut found = [vec![0.0; m.len()], vec![0.0; h.len()]];
            space.add_bracket(&x, &y, 1.0, &mut found[0]);
            space.add_isotropy_bracket(&x, &y, 1.0, &mut found[1]);
            assert_near(&found[0], &m, space);
            assert_near(&found[1], &h, space);
            if space.is_symmetric() {
                assert_near(&m, &vec![0.0; m.len()], space);
            }
            let mut action = vec![0.0; m.len()];
            space.subtract_action(&z, &x, &mut action);
            let [expected, _] = parts(space, &commutator(r, &isotropy_matrix(space, &z), &x));
            action.iter_mut().for_each(|x| *x = -*x);
            assert_near(&action, &expected, space);
        }
    }

    #[test]
    fn turning_and_the_adjoint_are_conjugation() {
        for space in spaces() {
            let r = space.r;
            let x = numbers(space.dim(), 6);
            let conjugated = |q: &[f64]| {
                let transposed: Vec<f64> = (0..r * r).map(|at| q[at % r * r + at / r]).collect();
                product(r, &product(r, q, &matrix(space, &x)), &transposed)
            };
            let q = turn(space, false);
            let [mut there, mut back] = [(); 2].map(|()| vec![0.0; x.len()]);
            space.turn_into(&q, &x, &mut there);
            assert_near(&there, &parts(space, &conjugated(&q))[0], space);
            space.turn_back_into(&q, &there, &mut back);
            assert_near(&back, &x, space);
            let mut part = vec![0.0; r * r];
            space.isotropy_part_into(&q, &mut part);
            assert_near(&part, &q, space);

            let u = turn(space, true);
            let (d, h) = (space.dim(), space.isotropy_dim());
            if d == 0 {
                continue;
            }
            let mut adjoint = vec![0.0; (d + h) * d];
            space.adjoint_into(&u, &mut adjoint);
            let rows = adjoint.chunks(d);
            let found: Vec<f64> = rows
                .map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum())
                .collect();
            assert_near(&found, &parts(space, &conjugated(&u)).concat(), space);
        }
    }
}
