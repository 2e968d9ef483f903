//! What a naturally reductive space `G/H` gives to the engine: sizes, coordinates and brackets.

use crate::linalg::dual::Number;
use crate::linalg::field::Field;

/// A quotient `G/H` of a group of orthogonal matrices of size `r`, its algebra split into `m` (horizontal) and `h`.
///
/// Elements of `m` and `h` are given by their coordinates, in an orthonormal basis of the metric `tr(A^T B) / 2`; where a
/// product is formed they are skew matrices of shape `(r, r)`, row by row. The equation of cubics is
///
/// ```math
/// x''' = [x'', x]_m - [[x, x']_h, x],\qquad g' = g\,x
/// ```
///
/// # Source
/// Crouch, Silva Leite (1995), "The dynamic interpolation problem: on Riemannian manifolds, Lie groups, and symmetric spaces",
/// J. Dynam. Control Systems 1, 177-202, sec. 4.
pub(crate) trait Homogeneous: Copy + Send + Sync {
    /// Size of the matrices of the group.
    fn size(self) -> usize;

    /// Dimension of `m`, that of the space.
    fn dim(self) -> usize;

    /// Dimension of `h`.
    fn isotropy_dim(self) -> usize;

    /// The entries `(i, j)` of a skew matrix that are its coordinates in `m`: `visit(coordinate, i, j)`.
    fn each_entry(self, visit: impl FnMut(usize, usize, usize));

    /// The same of `h`.
    fn each_isotropy_entry(self, visit: impl FnMut(usize, usize, usize));

    /// `out = Ad_q x` for `q` in `H`, shape `(r, r)`, and `x` in `m`, both in coordinates.
    fn turn_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]);

    /// `out = Ad_q^{-1} x`.
    fn turn_back_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]);

    /// The blocks of `H` of an element `u` of `G`: an element of `H` up to the square of the distance of `u` from `H`.
    fn isotropy_part_into<T: Field>(self, u: &[T], out: &mut [T]);

    /// The skew matrix with the given coordinates of `m`.
    #[inline(always)]
    fn matrix_into<T: Number>(self, x: &[T], out: &mut [T]) {
        let r = self.size();
        out[..r * r].fill(T::ZERO);
        self.each_entry(
            #[inline(always)]
            |p, i, j| {
                out[i * r + j] = x[p];
                out[j * r + i] = -x[p];
            },
        );
    }

    /// Coordinates of `[x, y]_m` of two skew matrices.
    #[inline(always)]
    fn bracket_into<T: Number>(self, x: &[T], y: &[T], out: &mut [T]) {
        let r = self.size();
        self.each_entry(
            #[inline(always)]
            |p, i, j| out[p] = commutator_entry(r, x, y, [i, j]),
        );
    }

    /// Coordinates of `[x, y]_h` of two skew matrices.
    #[inline(always)]
    fn isotropy_bracket_into<T: Number>(self, x: &[T], y: &[T], out: &mut [T]) {
        let r = self.size();
        self.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| out[p] = commutator_entry(r, x, y, [i, j]),
        );
    }

    /// Coordinates of `[z, x]`, in `m`, for `z` in `h` by its coordinates and the skew matrix of `x` in `m`.
    #[inline(always)]
    fn act_into<T: Number>(self, z: &[T], x: &[T], out: &mut [T]) {
        let r = self.size();
        out[..self.dim()].fill(T::ZERO);
        // [z, x] = z x - (z x)^T for skew matrices, with z = z_q (E_uv - E_vu).
        self.each_entry(
            #[inline(always)]
            |p, i, j| {
                self.each_isotropy_entry(
                    #[inline(always)]
                    |q, u, v| {
                        if i == u {
                            out[p] += z[q] * x[v * r + j];
                        } else if i == v {
                            out[p] -= z[q] * x[u * r + j];
                        }
                        if j == u {
                            out[p] -= z[q] * x[v * r + i];
                        } else if j == v {
                            out[p] += z[q] * x[u * r + i];
                        }
                    },
                );
            },
        );
    }

    /// The right-hand side of the equation of cubics, from coordinates of `x, x', x''`; `work` has room for two matrices and
    /// two vectors.
    #[inline(always)]
    fn third_derivative_into<T: Number>(self, x: [&[T]; 3], work: &mut [T], out: &mut [T]) {
        let (square, d) = (self.size() * self.size(), self.dim());
        let (matrix, rest) = work.split_at_mut(square);
        let (other, rest) = rest.split_at_mut(square);
        self.matrix_into(x[0], matrix);
        self.matrix_into(x[2], other);
        self.bracket_into(other, matrix, out);
        if self.isotropy_dim() > 0 {
            let (isotropy, turned) = rest.split_at_mut(self.isotropy_dim());
            self.matrix_into(x[1], other);
            self.isotropy_bracket_into(matrix, other, isotropy);
            self.act_into(isotropy, matrix, turned);
            for p in 0..d {
                out[p] -= turned[p];
            }
        }
    }
}

/// Entry `(i, j)` of `x y - y x`.
#[inline(always)]
fn commutator_entry<T: Number>(r: usize, x: &[T], y: &[T], [i, j]: [usize; 2]) -> T {
    let mut sum = T::ZERO;
    for l in 0..r {
        sum += x[i * r + l] * y[l * r + j];
        sum -= y[i * r + l] * x[l * r + j];
    }
    sum
}
