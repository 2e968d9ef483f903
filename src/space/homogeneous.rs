//! The interface of a naturally reductive space `G/H`: sizes, coordinates and brackets.

use std::ops::Range;

use crate::linalg::dual::Number;
use crate::linalg::field::{Field, multiply, transposed_multiply};
use crate::linalg::simd::Width;

/// A quotient `G/H` of a group of orthogonal matrices of size `r`, whose Lie algebra is split into `m` (horizontal) and
/// `h`.
///
/// Elements of `m` and `h` are given by coordinates in an orthonormal basis of the metric `tr(A^T B) / 2`; products are
/// formed from skew matrices of shape `(r, r)`, in row-major order. The equation of cubics is
///
/// ```math
/// x''' = [x'', x]_m - [[x, x']_h, x],\qquad g' = g\,x
/// ```
///
/// # Source
/// Crouch, Silva Leite (1995), "The dynamic interpolation problem: on Riemannian manifolds, Lie groups, and symmetric spaces",
/// J. Dynam. Control Systems 1, 177-202, sec. 4.
pub(crate) trait Homogeneous: Copy + Send + Sync {
    /// Vector instructions of its kernels.
    type Width: Width;

    /// Runs a kernel by its vector instructions.
    #[inline(always)]
    fn vectorised<R>(self, work: impl FnOnce() -> R) -> R {
        Self::Width::run(work)
    }

    /// Size of the matrices of the group.
    fn size(self) -> usize;

    /// Dimension of `m`, which is the dimension of the space.
    fn dim(self) -> usize;

    /// Dimension of `h`.
    fn isotropy_dim(self) -> usize;

    /// Visits the coordinates of `m` in runs: in `visit(p, row, column, count)`, the coordinates from `p` on are the
    /// negated entries `(row, column)`, `(row, column + 1)`, ... of the skew matrix, times their
    /// [scales](Homogeneous::scale).
    fn each_run(self, visit: impl FnMut(usize, usize, usize, usize));

    /// As `each_run`, for the coordinates of `h`.
    fn each_isotropy_run(self, visit: impl FnMut(usize, usize, usize, usize));

    /// As `each_run`, for those coordinates of `m` on which `h` acts.
    fn each_turned_run(self, visit: impl FnMut(usize, usize, usize, usize));

    /// Whether `[m, m]` lies in `h`.
    fn is_symmetric(self) -> bool;

    /// Rows and columns of an element of `h` that act on the rows of the coordinates visited by `each_turned_run`.
    fn isotropy_range(self) -> Range<usize>;

    /// Rows and columns of an element of `h` that act on the columns of these coordinates.
    #[inline(always)]
    fn column_isotropy_range(self) -> Range<usize> {
        0..0
    }

    /// Factor from an entry to its coordinate: the square root of the entry's weight in the metric.
    #[inline(always)]
    fn scale(self, _row: usize, _column: usize) -> f64 {
        1.0
    }

    /// In a group of embedded complex matrices, the row or column that the complex structure exchanges with the given one,
    /// and the sign with which it acts there. Entry `(i, j)` of an element times both signs is the entry of both partners.
    #[inline(always)]
    fn partner(self, _row: usize) -> Option<(usize, f64)> {
        None
    }

    /// Another entry of a skew matrix that always equals the given one up to a sign, and that sign.
    #[inline(always)]
    fn copy_of(self, row: usize, column: usize) -> Option<([usize; 2], f64)> {
        let ((i, sign), (j, other)) = (self.partner(row)?, self.partner(column)?);
        // The imaginary part on the diagonal is its own copy.
        ([i, j] != [column, row]).then_some(([i, j], sign * other))
    }

    /// Writes entry `(i, j)` of a skew matrix, and its copies, from a coordinate.
    #[inline(always)]
    fn write_entry<T: Number>(self, coordinate: T, [i, j]: [usize; 2], out: &mut [T]) {
        let r = self.size();
        let entry = coordinate * self.scale(i, j).recip();
        out[i * r + j] = entry;
        out[j * r + i] = -entry;
        if let Some(([i, j], sign)) = self.copy_of(i, j) {
            out[i * r + j] = entry * sign;
            out[j * r + i] = -entry * sign;
        }
    }

    /// Visits the entries `(i, j)` of a skew matrix that are its coordinates in `m`, up to their scales:
    /// `visit(coordinate, i, j)`.
    #[inline(always)]
    fn each_entry(self, mut visit: impl FnMut(usize, usize, usize)) {
        self.each_run(
            #[inline(always)]
            |p, row, column, count| {
                for c in 0..count {
                    visit(p + c, column + c, row);
                }
            },
        );
    }

    /// As `each_entry`, for `h`.
    #[inline(always)]
    fn each_isotropy_entry(self, mut visit: impl FnMut(usize, usize, usize)) {
        self.each_isotropy_run(
            #[inline(always)]
            |p, row, column, count| {
                for c in 0..count {
                    visit(p + c, column + c, row);
                }
            },
        );
    }

    /// `out = Ad_q x` for `q` in `H`, shape `(r, r)`, and `x` in `m`, both in coordinates.
    fn turn_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]);

    /// `out = Ad_q^{-1} x`.
    fn turn_back_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]);

    /// Projects an element `u` of `G` to the blocks of `H`: the result is in `H` up to the square of the distance of
    /// `u` from `H`.
    fn isotropy_part_into<T: Field>(self, u: &[T], out: &mut [T]);

    /// Number of leading entries of a row of an element of `m` that may be nonzero.
    fn row_len(self, row: usize) -> usize;

    /// `out -= [z, x]`, for `z` in `h` by coordinates and the skew matrix of `x` in `m`.
    fn subtract_action<T: Number>(self, z: &[T], x: &[T], out: &mut [T]);

    /// Writes the skew matrix with the given coordinates in `m`.
    #[inline(always)]
    fn matrix_into<T: Number>(self, x: &[T], out: &mut [T]) {
        let r = self.size();
        out[..r * r].fill(T::ZERO);
        self.each_entry(
            #[inline(always)]
            |p, i, j| self.write_entry(x[p], [i, j], out),
        );
    }

    /// Writes the skew matrix with the given coordinates in `h`.
    #[inline(always)]
    fn isotropy_matrix_into<T: Number>(self, z: &[T], out: &mut [T]) {
        let r = self.size();
        out[..r * r].fill(T::ZERO);
        self.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| self.write_entry(z[p], [i, j], out),
        );
    }

    /// Entry `(i, j)` of `x y - y x` for the skew matrices of two elements of `m`.
    #[inline(always)]
    fn commutator_entry<'a, T: Number>(self, x: &'a [T], y: &'a [T], [i, j]: [usize; 2]) -> T {
        let (r, inner) = (self.size(), self.row_len(i).min(self.row_len(j)));
        let rows = |a: &'a [T]| [&a[i * r..][..inner], &a[j * r..][..inner]];
        let ([x_i, x_j], [y_i, y_j]) = (rows(x), rows(y));
        let mut sum = T::ZERO;
        for l in 0..inner {
            if l != i && l != j {
                sum += y_i[l] * x_j[l];
                sum -= x_i[l] * y_j[l];
            }
        }
        sum
    }

    /// `out += factor [x, y]_m`, for two skew matrices, in coordinates.
    #[inline(always)]
    fn add_bracket<T: Number>(self, x: &[T], y: &[T], factor: f64, out: &mut [T]) {
        self.each_entry(
            #[inline(always)]
            |p, i, j| {
                let factor = factor * self.scale(i, j);
                out[p] += self.commutator_entry(x, y, [i, j]) * factor;
            },
        );
    }

    /// `out += factor [x, y]_h`.
    #[inline(always)]
    fn add_isotropy_bracket<T: Number>(self, x: &[T], y: &[T], factor: f64, out: &mut [T]) {
        self.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| {
                let factor = factor * self.scale(i, j);
                out[p] += self.commutator_entry(x, y, [i, j]) * factor;
            },
        );
    }

    /// The coordinate belonging to entry `(i, j)` of the skew part of a matrix.
    #[inline(always)]
    fn skew_coordinate<T: Number>(self, a: &[T], [i, j]: [usize; 2]) -> T {
        let r = self.size();
        (a[i * r + j] - a[j * r + i]) * (0.5 * self.scale(i, j))
    }

    /// The matrix of `Ad_u` from `m` to the whole algebra, for `u` in `G`: rows for `m` before rows for `h`, shape
    /// `(dim + h, dim)`.
    #[inline(always)]
    fn adjoint_into<T: Field>(self, u: &[T], out: &mut [T]) {
        let d = self.dim();
        self.each_entry(
            #[inline(always)]
            |p, i, j| {
                self.each_entry(
                    #[inline(always)]
                    |q, a, b| out[p * d + q] = self.adjoint_entry(u, [i, j], [a, b]),
                );
            },
        );
        self.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| {
                self.each_entry(
                    #[inline(always)]
                    |q, a, b| out[(d + p) * d + q] = self.adjoint_entry(u, [i, j], [a, b]),
                );
            },
        );
    }

    /// The coordinate of `Ad_u a` belonging to entry `(i, j)`, where `a` is the basis vector belonging to entry `(a,
    /// b)`.
    #[inline(always)]
    fn adjoint_entry<T: Field>(self, u: &[T], [i, j]: [usize; 2], [a, b]: [usize; 2]) -> T {
        let mut entry = adjoint_entry(self.size(), u, [i, j], [a, b]);
        if let Some((copy, sign)) = self.copy_of(a, b) {
            entry += adjoint_entry(self.size(), u, [i, j], copy) * sign;
        }
        entry * (self.scale(i, j) / self.scale(a, b))
    }

    /// `out += [eta_h, vector]` for every column of `eta`, whose coordinates in `m` precede those in `h`.
    #[inline(always)]
    fn add_turning<T: Field>(self, vector: &[T], eta: &[T], columns: usize, out: &mut [T]) {
        let (d, h, r) = (self.dim(), self.isotropy_dim(), self.size());
        if h == 0 {
            return;
        }
        let mut matrix = vec![T::ZERO; r * r];
        let mut isotropy = vec![T::ZERO; h];
        let mut turned = vec![T::ZERO; d];
        self.matrix_into(vector, &mut matrix);
        for column in 0..columns {
            for (p, z) in isotropy.iter_mut().enumerate() {
                *z = eta[(d + p) * columns + column];
            }
            turned.fill(T::ZERO);
            self.subtract_action(&isotropy, &matrix, &mut turned);
            for (p, x) in turned.iter().enumerate() {
                out[p * columns + column] -= *x;
            }
        }
    }

    /// `out = Ad_q x` for every column of `x`.
    #[inline(always)]
    fn turn_columns<T: Field>(self, q: &[T], x: &[T], columns: usize, out: &mut [T]) {
        let d = self.dim();
        let (mut column, mut turned) = (vec![T::ZERO; d], vec![T::ZERO; d]);
        for i in 0..columns {
            for (p, entry) in column.iter_mut().enumerate() {
                *entry = x[p * columns + i];
            }
            self.turn_into(q, &column, &mut turned);
            for (p, entry) in turned.iter().enumerate() {
                out[p * columns + i] = *entry;
            }
        }
    }
}

/// Entry `(i, j)` of `Ad_u (E_ab - E_ba)`.
#[inline(always)]
fn adjoint_entry<T: Field>(r: usize, u: &[T], [i, j]: [usize; 2], [a, b]: [usize; 2]) -> T {
    u[i * r + a] * u[j * r + b] - u[i * r + b] * u[j * r + a]
}

/// Iterations of [`orthonormalise`].
const POLAR_STEPS: usize = 4;

/// Approximates the polar factor by a few steps of the Newton-Schulz iteration `q <- q (3 - q^T q) / 2`.
#[inline(always)]
pub(crate) fn orthonormalise<T: Field>(r: usize, q: &mut [T], work: &mut [T]) {
    let (gram, rest) = work.split_at_mut(r * r);
    let product = &mut rest[..r * r];
    for _ in 0..POLAR_STEPS {
        transposed_multiply(r, q, q, gram);
        multiply(r, q, gram, product);
        for (q, product) in q.iter_mut().zip(&*product) {
            *q = *q * 1.5 - *product * 0.5;
        }
    }
}
