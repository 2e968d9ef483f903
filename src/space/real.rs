//! Real frames, `St(r, k) = SO(r) / SO(r - k)`, and subspaces, `Gr(r, k) = O(r) / (O(k) x O(r - k))`: `h` is the lower right
//! block, of subspaces the upper left one too; `m` is the rest.

use std::ops::Range;

use super::homogeneous::Homogeneous;
use super::quotient::Quotient;
use crate::linalg::dual::Number;
use crate::linalg::field::Field;
use crate::linalg::simd::{Eight, Four, Width};

/// Frames of `k` vectors in `R^r`, or the subspaces that they span, `k < r`, with sizes known at run time. `k = r - 1` is
/// the group `SO(r)`.
///
/// A vector of `m` is `omega` above its diagonal, only of frames, then the block `b` of shape `(r - k, k)`, column by column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RealSpace {
    pub(crate) r: usize,
    pub(crate) k: usize,
    pub(crate) quotient: Quotient,
}

#[cfg(test)]
impl RealSpace {
    pub(crate) fn frames(r: usize, k: usize) -> Self {
        let quotient = Quotient::Frames;
        RealSpace { r, k, quotient }
    }

    pub(crate) fn subspaces(r: usize, k: usize) -> Self {
        let quotient = Quotient::Subspaces;
        RealSpace { r, k, quotient }
    }
}

/// Frames with sizes known at compile time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixedFrames<const R: usize, const K: usize>;

/// Sizes of a real space, and what follows from them.
pub(crate) trait RealSizes: Copy + Send + Sync {
    /// Vector instructions of its kernels.
    type Width: Width;

    /// `[r, k]`.
    fn shape(self) -> [usize; 2];

    fn quotient(self) -> Quotient;

    /// Number of coordinates of `omega`.
    #[inline(always)]
    fn turns(self) -> usize {
        match self.quotient() {
            Quotient::Frames => above_diagonal(self.shape()[1]),
            Quotient::Subspaces => 0,
        }
    }

    /// Number of coordinates of the upper left block of `h`, which precede those of the lower right one.
    #[inline(always)]
    fn column_turns(self) -> usize {
        match self.quotient() {
            Quotient::Frames => 0,
            Quotient::Subspaces => above_diagonal(self.shape()[1]),
        }
    }

    /// `Omega` is unchanged; `B` becomes `q_2 B`, for subspaces `q_2 B q_1^T`, with the diagonal blocks of `q`, which is
    /// given by its entries.
    #[inline(always)]
    fn turn<T: Number>(self, q: impl Fn(usize, usize) -> T, x: &[T], out: &mut [T]) {
        let ([r, k], turns) = (self.shape(), self.turns());
        let rows = r - k;
        out[..turns].copy_from_slice(&x[..turns]);
        if rows == 0 {
            return;
        }
        let x = &x[turns..][..rows * k];
        let turned = |column: &[T], i: usize| {
            let mut sum = T::ZERO;
            for (l, x) in column.iter().enumerate() {
                sum += q(k + i, k + l) * *x;
            }
            sum
        };
        let columns = out[turns..].chunks_exact_mut(rows).take(k).enumerate();
        for (c, out) in columns {
            for (i, out) in out.iter_mut().enumerate() {
                *out = match self.quotient() {
                    Quotient::Frames => turned(&x[c * rows..][..rows], i),
                    Quotient::Subspaces => {
                        let mut sum = T::ZERO;
                        for (d, column) in x.chunks_exact(rows).enumerate() {
                            sum += turned(column, i) * q(c, d);
                        }
                        sum
                    }
                };
            }
        }
    }
}

/// Number of entries above the diagonal of a matrix.
#[inline(always)]
fn above_diagonal(size: usize) -> usize {
    size * size.saturating_sub(1) / 2
}

impl RealSizes for RealSpace {
    type Width = Four;

    #[inline(always)]
    fn shape(self) -> [usize; 2] {
        [self.r, self.k]
    }

    #[inline(always)]
    fn quotient(self) -> Quotient {
        self.quotient
    }
}

impl<const R: usize, const K: usize> RealSizes for FixedFrames<R, K> {
    type Width = Eight;

    #[inline(always)]
    fn shape(self) -> [usize; 2] {
        [R, K]
    }

    #[inline(always)]
    fn quotient(self) -> Quotient {
        Quotient::Frames
    }
}

impl<S: RealSizes> Homogeneous for S {
    type Width = S::Width;

    #[inline(always)]
    fn size(self) -> usize {
        self.shape()[0]
    }

    #[inline(always)]
    fn dim(self) -> usize {
        let [r, k] = self.shape();
        self.turns() + (r - k) * k
    }

    #[inline(always)]
    fn isotropy_dim(self) -> usize {
        let [r, k] = self.shape();
        self.column_turns() + above_diagonal(r - k)
    }

    #[inline(always)]
    fn each_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        // The order of `cubic::packing::pack`: entries above the diagonal of omega, then b, in column-major order.
        // A single call site of `visit`: kernels are inlined into it.
        let ([r, k], turns) = (self.shape(), self.turns());
        let start = match self.quotient() {
            Quotient::Frames => 1,
            Quotient::Subspaces => k,
        };
        for i in start..2 * k {
            let (p, row, column, count) = match i.checked_sub(k) {
                None => (above_diagonal(i), i, 0, i),
                Some(j) => (turns + j * (r - k), j, k, r - k),
            };
            visit(p, row, column, count);
        }
    }

    #[inline(always)]
    fn each_turned_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let ([r, k], turns) = (self.shape(), self.turns());
        for j in 0..k {
            visit(turns + j * (r - k), j, k, r - k);
        }
    }

    #[inline(always)]
    fn each_isotropy_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let [r, k] = self.shape();
        let start = match self.quotient() {
            Quotient::Frames => k,
            Quotient::Subspaces => 0,
        };
        let mut p = 0;
        for j in start..r {
            let end = if j < k { k } else { r };
            let count = end - 1 - j;
            if count > 0 {
                visit(p, j, j + 1, count);
                p += count;
            }
        }
    }

    #[inline(always)]
    fn is_symmetric(self) -> bool {
        self.turns() == 0
    }

    #[inline(always)]
    fn isotropy_range(self) -> Range<usize> {
        let [r, k] = self.shape();
        k..r
    }

    #[inline(always)]
    fn column_isotropy_range(self) -> Range<usize> {
        match self.quotient() {
            Quotient::Frames => 0..0,
            Quotient::Subspaces => 0..self.shape()[1],
        }
    }

    #[inline(always)]
    fn turn_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]) {
        let r = self.size();
        self.turn(|i, j| q[i * r + j], x, out);
    }

    #[inline(always)]
    fn turn_back_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]) {
        let r = self.size();
        self.turn(|i, j| q[j * r + i], x, out);
    }

    #[inline(always)]
    fn row_len(self, row: usize) -> usize {
        let [r, k] = self.shape();
        if row < k { r } else { k }
    }

    #[inline(always)]
    fn subtract_action<T: Number>(self, z: &[T], x: &[T], out: &mut [T]) {
        // [z, x] has the lower left block `z_2 b - b z_1`.
        let [r, k] = self.shape();
        let (column_turns, z) = z.split_at(self.column_turns());
        let b = &mut out[self.turns()..];
        for (c, column) in b.chunks_exact_mut(r - k).take(k).enumerate() {
            let mut z = z.iter();
            for j in 0..r - k {
                let (upper, lower) = column.split_at_mut(j + 1);
                let x_j = x[(k + j) * r + c];
                let mut sum = upper[j];
                for ((i, b_i), z) in (j + 1..r - k).zip(lower).zip(&mut z) {
                    *b_i -= *z * x_j;
                    sum += *z * x[(k + i) * r + c];
                }
                upper[j] = sum;
            }
        }
        if self.quotient() == Quotient::Frames {
            return;
        }
        let mut z = column_turns.iter();
        for j in 0..k {
            for (i, z) in (j + 1..k).zip(&mut z) {
                for (row, x) in x[k * r..].chunks_exact(r).take(r - k).enumerate() {
                    b[j * (r - k) + row] += x[i] * *z;
                    b[i * (r - k) + row] -= x[j] * *z;
                }
            }
        }
    }

    #[inline(always)]
    fn isotropy_part_into<T: Field>(self, u: &[T], out: &mut [T]) {
        let [r, k] = self.shape();
        for i in 0..r {
            let rows = if i < k { k } else { r - k };
            for j in 0..r {
                let is_free = i >= k || self.quotient() == Quotient::Subspaces;
                out[i * r + j] = match ((i < k) == (j < k), i == j) {
                    (true, true) if is_free && rows == 1 => u[i * r + j].sign(),
                    (true, _) if is_free => u[i * r + j],
                    (true, true) => T::constant(1.0),
                    _ => T::ZERO,
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::test_matrices::{commutator, numbers, product};

    const SHAPES: [[usize; 2]; 5] = [[2, 1], [3, 2], [4, 2], [5, 2], [7, 4]];

    fn spaces() -> impl Iterator<Item = RealSpace> {
        let both = |[r, k]: [usize; 2]| [RealSpace::frames(r, k), RealSpace::subspaces(r, k)];
        SHAPES.into_iter().flat_map(both)
    }

    fn matrices(space: RealSpace, seed: usize) -> [Vec<f64>; 2] {
        let square = space.r * space.r;
        let (x, z) = (
            numbers(space.dim(), seed),
            numbers(space.isotropy_dim(), seed + 5),
        );
        let mut out = [vec![0.0; square], vec![0.0; square]];
        space.matrix_into(&x, &mut out[0]);
        space.isotropy_matrix_into(&z, &mut out[1]);
        out
    }

    fn horizontal(space: RealSpace, a: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; space.dim()];
        space.each_entry(|p, i, j| out[p] = a[i * space.r + j]);
        out
    }

    #[test]
    fn coordinates_are_all_entries_once() {
        for space in spaces() {
            let r = space.r;
            let mut seen = vec![0; r * r];
            space.each_entry(|_, i, j| seen[i * r + j] += 1);
            space.each_isotropy_entry(|_, i, j| seen[i * r + j] += 1);
            for i in 0..r {
                for j in 0..r {
                    let both = seen[i * r + j] + seen[j * r + i];
                    assert_eq!(both, usize::from(i != j), "{space:?}, entry {i}, {j}");
                }
            }
        }
    }

    #[test]
    fn h_acts_by_brackets_and_contains_those_of_symmetric_spaces() {
        for space in spaces() {
            let RealSpace { r, k, .. } = space;
            let ([x, z], [y, _]) = (matrices(space, 1), matrices(space, 2));
            let bracket = horizontal(space, &commutator(r, &x, &y));
            assert!(!space.is_symmetric() || bracket.iter().all(|x| *x == 0.0));
            let mut out = vec![0.0; space.dim()];
            let coordinates = numbers(space.isotropy_dim(), 6);
            space.subtract_action(&coordinates, &x, &mut out);
            let expected = horizontal(space, &commutator(r, &z, &x));
            for (out, expected) in out.iter().zip(expected) {
                assert_eq!(-out, expected, "r = {r}, k = {k}");
            }
        }
    }

    #[test]
    fn turning_is_conjugation_and_back() {
        for space in spaces() {
            let RealSpace { r, k, .. } = space;
            // Signed permutations of both blocks; for frames, the first one is the identity.
            let mut q = vec![0.0; r * r];
            for i in 0..r {
                let (image, sign) = match i < k {
                    true if space.quotient == Quotient::Frames => (i, 0),
                    true => ((i + 1) % k, i),
                    false => (k + (i - k + 1) % (r - k), i),
                };
                q[image * r + i] = if sign % 2 == 0 { 1.0 } else { -1.0 };
            }
            let transposed: Vec<f64> = (0..r * r).map(|at| q[at % r * r + at / r]).collect();
            let coordinates = numbers(space.dim(), 3);
            let mut x = vec![0.0; r * r];
            space.matrix_into(&coordinates, &mut x);
            let turned = product(r, &product(r, &q, &x), &transposed);
            let [mut there, mut back] = [(); 2].map(|()| vec![0.0; space.dim()]);
            space.turn_into(&q, &coordinates, &mut there);
            assert_eq!(there, horizontal(space, &turned));
            space.turn_back_into(&q, &there, &mut back);
            assert_eq!(back, coordinates);
            let mut part = vec![0.0; r * r];
            space.isotropy_part_into(&q, &mut part);
            assert_eq!(part, q);
        }
    }
}
