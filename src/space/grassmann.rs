//! `Gr(r, k) = O(r) / (O(k) x O(r - k))`: `h` consists of both diagonal blocks, `m` of the lower left one.

use std::ops::Range;

use super::homogeneous::Homogeneous;
use crate::linalg::dual::Number;
use crate::linalg::field::Field;
use crate::linalg::simd::Four;

/// Subspaces of dimension `k` in `R^r`, `k < r`, with sizes known at run time.
///
/// A vector of `m` is the block `b` of shape `(r - k, k)`, column by column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Subspaces {
    pub(crate) r: usize,
    pub(crate) k: usize,
}

impl Subspaces {
    /// The rows and columns of the diagonal block to which `i` belongs.
    #[inline(always)]
    fn is_in_block(self, i: usize, j: usize) -> bool {
        (i < self.k) == (j < self.k)
    }

    /// Number of rows of the diagonal block to which `i` belongs.
    #[inline(always)]
    fn block_size(self, i: usize) -> usize {
        if i < self.k { self.k } else { self.r - self.k }
    }

    /// `out = q_2 b q_1^T` with the diagonal blocks of `q` or of its transpose.
    #[inline(always)]
    fn turn<T: Number>(self, q: &[T], x: &[T], out: &mut [T], is_back: bool) {
        let Subspaces { r, k } = self;
        let rows = r - k;
        let entry = |i: usize, j: usize| if is_back { q[j * r + i] } else { q[i * r + j] };
        for (c, out) in out.chunks_exact_mut(rows).take(k).enumerate() {
            for (i, out) in out.iter_mut().enumerate() {
                let mut sum = T::ZERO;
                for (d, column) in x.chunks_exact(rows).take(k).enumerate() {
                    let mut turned = T::ZERO;
                    for (l, x) in column.iter().enumerate() {
                        turned += entry(k + i, k + l) * *x;
                    }
                    sum += turned * entry(c, d);
                }
                *out = sum;
            }
        }
    }
}

impl Homogeneous for Subspaces {
    type Width = Four;

    #[inline(always)]
    fn size(self) -> usize {
        self.r
    }

    #[inline(always)]
    fn dim(self) -> usize {
        (self.r - self.k) * self.k
    }

    #[inline(always)]
    fn isotropy_dim(self) -> usize {
        let of_block = |size: usize| size * size.saturating_sub(1) / 2;
        of_block(self.k) + of_block(self.r - self.k)
    }

    #[inline(always)]
    fn each_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let rows = self.r - self.k;
        for j in 0..self.k {
            visit(j * rows, j, self.k, rows);
        }
    }

    #[inline(always)]
    fn each_turned_run(self, visit: impl FnMut(usize, usize, usize, usize)) {
        self.each_run(visit);
    }

    #[inline(always)]
    fn each_isotropy_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let mut p = 0;
        for j in 0..self.r {
            let end = if j < self.k { self.k } else { self.r };
            let count = end - 1 - j;
            if count > 0 {
                visit(p, j, j + 1, count);
                p += count;
            }
        }
    }

    #[inline(always)]
    fn is_symmetric(self) -> bool {
        true
    }

    #[inline(always)]
    fn isotropy_range(self) -> Range<usize> {
        self.k..self.r
    }

    #[inline(always)]
    fn column_isotropy_range(self) -> Range<usize> {
        0..self.k
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
        let r = self.r;
        for i in 0..r {
            for j in 0..r {
                out[i * r + j] = match (self.is_in_block(i, j), self.block_size(i)) {
                    (true, 1) => u[i * r + j].sign(),
                    (true, _) => u[i * r + j],
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
        // [z, x] has the lower left block `z_2 b - b z_1`; the coordinates of `z` are the negated entries above its
        // diagonal.
        let (r, k) = (self.r, self.k);
        let rows = r - k;
        self.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| {
                // Here i > j: z_ij = z[p], z_ji = -z[p].
                let z = z[p];
                if j >= k {
                    for c in 0..k {
                        out[c * rows + i - k] -= z * x[j * r + c];
                        out[c * rows + j - k] += z * x[i * r + c];
                    }
                } else {
                    for row in 0..rows {
                        out[j * rows + row] += x[(k + row) * r + i] * z;
                        out[i * rows + row] -= x[(k + row) * r + j] * z;
                    }
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [[usize; 2]; 5] = [[2, 1], [3, 2], [4, 2], [5, 2], [7, 4]];

    fn numbers(count: usize, seed: usize) -> Vec<f64> {
        let number = |i: usize| ((7 * i + 3 * seed) % 11) as f64 - 5.0;
        (0..count).map(number).collect()
    }

    fn product(r: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
        let entry = |at: usize| (0..r).map(|l| a[at / r * r + l] * b[l * r + at % r]).sum();
        (0..r * r).map(entry).collect()
    }

    fn commutator(r: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
        let (ab, ba) = (product(r, a, b), product(r, b, a));
        ab.iter().zip(ba).map(|(x, y)| x - y).collect()
    }

    fn matrices(space: Subspaces, seed: usize) -> [Vec<f64>; 2] {
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

    fn horizontal(space: Subspaces, a: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; space.dim()];
        space.each_entry(|p, i, j| out[p] = a[i * space.r + j]);
        out
    }

    #[test]
    fn coordinates_are_all_entries_once() {
        for [r, k] in SHAPES {
            let space = Subspaces { r, k };
            let mut seen = vec![0; r * r];
            space.each_entry(|_, i, j| seen[i * r + j] += 1);
            space.each_isotropy_entry(|_, i, j| seen[i * r + j] += 1);
            for (at, seen) in seen.into_iter().enumerate() {
                assert_eq!(
                    seen,
                    usize::from(at / r > at % r),
                    "r = {r}, k = {k}, entry {at}"
                );
            }
        }
    }

    #[test]
    fn brackets_of_horizontal_vectors_are_in_h_and_act_on_both_sides() {
        for [r, k] in SHAPES {
            let space = Subspaces { r, k };
            let ([x, z], [y, _]) = (matrices(space, 1), matrices(space, 2));
            assert!(
                horizontal(space, &commutator(r, &x, &y))
                    .iter()
                    .all(|x| *x == 0.0)
            );
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
        for [r, k] in SHAPES {
            let space = Subspaces { r, k };
            // Signed permutations of both blocks.
            let mut q = vec![0.0; r * r];
            for i in 0..r {
                let image = match i < k {
                    true => (i + 1) % k,
                    false => k + (i - k + 1) % (r - k),
                };
                q[image * r + i] = if i % 2 == 0 { 1.0 } else { -1.0 };
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
