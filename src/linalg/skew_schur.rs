//! Real Schur form of a skew-symmetric matrix, with an orthogonal basis for every spectrum.
//!
//! Householder reflections reduce `A` to skew tridiagonal form; even and odd basis vectors then split it into `[[0,
//! -B^T], [B, 0]]` with `B` bidiagonal of half the size, and the singular value decomposition of `B` gives angles and
//! planes. The basis is a product of reflections and singular vectors, so it is orthogonal to round-off also for zero,
//! repeated and clustered angles, for which complex eigenvectors are not.
//!
//! # Source
//! Ward, Gray (1978), "Eigensystem computation for skew-symmetric matrices", ACM TOMS 4, 278-285. Deviation: for large
//! sizes a divide-and-conquer singular value decomposition of `B` instead of the QR iteration.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::bidiagonal::diagonalise;
use super::decomp::Svd;
use super::field::add;
use super::simd::vectorised;
use super::square::{LANES, Square};
use crate::error::{Error, Result};

/// Matrices whose largest entry is outside this range are first scaled by a power of two.
const PLAIN: std::ops::Range<f64> = 1e-100..1e100;

/// Number of planes up to which the rotations of the QR iteration are applied directly to the basis.
const DIRECT: usize = 40;

/// `A = V blockdiag(theta_i J) V^T` with `J = [[0, -1], [1, 0]]`, with buffers allocated once for a largest size.
///
/// Columns `2i` and `2i + 1` of `V` span the plane of `theta_i >= 0`; for odd sizes the last column is a null
/// vector. Cost about `10/3 m^3` operations. The backward error is a small multiple of `m eps |A|`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::SkewSchur;
/// // Turns about the axis (1, 2, 2) at the rate 3.
/// let a = mat![[0.0, -2.0, 2.0], [2.0, 0.0, -1.0], [-2.0, 1.0, 0.0]];
/// let mut schur = SkewSchur::new(3);
/// schur.compute(a.as_ref())?;
/// assert!((schur.angles()[0] - 3.0).abs() < 1e-14);
/// assert!((&a * schur.basis().col(2)).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct SkewSchur {
    m: usize,
    size: usize,
    /// Columns of the initially given size, of which `m` rows and columns are used.
    reduced: Square,
    basis: Square,
    householder: Square,
    angles: Vec<f64>,
    reflector: [Vec<f64>; 2],
    image: [Vec<f64>; 2],
    superdiagonal: Vec<f64>,
    large: Option<Box<(Mat<f64>, Svd)>>,
}

impl SkewSchur {
    /// Buffers for matrices of at most `m x m`.
    pub fn new(m: usize) -> Self {
        let (odd, even) = (m / 2, m.div_ceil(2));
        let line = || vec![0.0; m.next_multiple_of(LANES)];
        SkewSchur {
            m: 0,
            size: m,
            reduced: Square::new(m),
            basis: Square::new(m),
            householder: Square::new(m),
            angles: vec![0.0; odd],
            reflector: [line(), line()],
            image: [line(), line()],
            superdiagonal: vec![0.0; odd],
            large: (odd > DIRECT).then(|| Box::new((Mat::zeros(odd, even), Svd::new(odd, even)))),
        }
    }

    /// The orthogonal basis `V`, `m x m`.
    pub fn basis(&self) -> MatRef<'_, f64> {
        self.basis.view().submatrix(0, 0, self.m, self.m)
    }

    /// The `m / 2` angles `theta_i >= 0`, in decreasing order.
    pub fn angles(&self) -> &[f64] {
        &self.angles[..self.m / 2]
    }

    /// Factors a skew-symmetric matrix, of which the lower triangle is read.
    ///
    /// # Errors
    /// `Decomposition` if the singular value iteration does not converge; `Overflow` if an angle is too large for a
    /// floating-point number.
    pub fn compute(&mut self, a: MatRef<'_, f64>) -> Result<()> {
        let m = a.nrows();
        debug_assert!(m == a.ncols() && m <= self.size);
        self.m = m;
        let mut largest = 0.0_f64;
        for j in 0..m {
            for i in j + 1..m {
                largest = largest.max(a[(i, j)].abs());
            }
        }
        // Squares must neither overflow nor underflow.
        let scale = if largest == 0.0 || PLAIN.contains(&largest) {
            1.0
        } else {
            2.0_f64.powi(-(largest.log2() as i32).clamp(-1000, 1000))
        };
        self.reduced.clear(m);
        let mut reduced = self.reduced.view_mut();
        for j in 0..m {
            for i in j + 1..m {
                let x = scale * a[(i, j)];
                reduced[(i, j)] = x;
                reduced[(j, i)] = -x;
            }
        }
        vectorised(
            #[inline(always)]
            || {
                self.tridiagonalise();
                self.accumulate_reflections();
            },
        );
        self.split_even_odd()?;
        for angle in &mut self.angles[..m / 2] {
            *angle /= scale;
            if !angle.is_finite() {
                return Err(Error::Overflow {
                    quantity: "skew Schur form",
                });
            }
        }
        Ok(())
    }

    /// Makes `H_j ... H_1 A H_1 ... H_j` tridiagonal; the unit reflectors are stored in the columns of `householder`.
    ///
    /// `H A H = A + w p^T - p w^T` with `p = 2 A w`: the quadratic term vanishes because `w^T A w = 0`. The update of
    /// one step and the product `A w` of the next share one pass over the matrix.
    ///
    /// Columns are processed in whole groups of rows, from the group that contains the first remaining row: above it
    /// the vectors are zero.
    #[inline(always)]
    fn tridiagonalise(&mut self) {
        let m = self.m;
        let rows = m.next_multiple_of(LANES);
        let [w, next_w] = &mut self.reflector;
        let [p, next_p] = &mut self.image;
        w.fill(0.0);
        p.fill(0.0);
        for j in 0..m.saturating_sub(2) {
            let top = (j + 1) / LANES * LANES;
            let column = self.reduced.rows_mut(j, rows);
            update(&mut column[top..], &w[top..rows], &p[top..rows], w[j], p[j]);
            next_w.fill(0.0);
            let subdiagonal = reflector(&column[j + 1..m], &mut next_w[j + 1..m]);
            column[j + 1] = subdiagonal;
            self.householder
                .rows_mut(j, rows)
                .copy_from_slice(&next_w[..rows]);
            next_p.fill(0.0);
            for l in j + 1..m {
                let column = &mut self.reduced.rows_mut(l, rows)[top..];
                update(column, &w[top..rows], &p[top..rows], w[l], p[l]);
                add(&mut next_p[top..rows], 2.0 * next_w[l], column);
            }
            next_p[top..=j].fill(0.0);
            std::mem::swap(w, next_w);
            std::mem::swap(p, next_p);
        }
        // Only the last entry of the remainder matters.
        if m >= 2 {
            let column = self.reduced.rows_mut(m - 2, rows);
            column[m - 1] += w[m - 1] * p[m - 2] - p[m - 1] * w[m - 2];
        }
    }

    /// `basis = H_1 H_2 ... H_{m-2}`.
    #[inline(always)]
    fn accumulate_reflections(&mut self) {
        let m = self.m;
        let rows = m.next_multiple_of(LANES);
        self.basis.clear(m);
        for j in 0..m {
            self.basis.rows_mut(j, rows)[j] = 1.0;
        }
        for j in (0..m.saturating_sub(2)).rev() {
            let top = (j + 1) / LANES * LANES;
            let w = &self.householder.rows(j, rows)[top..];
            for l in j + 1..m {
                let column = &mut self.basis.rows_mut(l, rows)[top..];
                let factor = -2.0 * dot(w, column);
                add(column, factor, w);
            }
        }
    }

    /// Angles and planes from the singular value decomposition of the bidiagonal half.
    fn split_even_odd(&mut self) -> Result<()> {
        let m = self.m;
        let (odd, even) = (m / 2, m.div_ceil(2));
        if odd == 0 {
            return Ok(());
        }
        for i in 0..odd {
            self.angles[i] = self.reduced.col(2 * i)[2 * i + 1];
            self.superdiagonal[i] = if i + 1 < even {
                -self.reduced.col(2 * i + 1)[2 * i + 2]
            } else {
                0.0
            };
        }
        let (d, e) = (&mut self.angles[..odd], &mut self.superdiagonal[..odd]);
        if odd <= DIRECT {
            let basis = &mut self.basis;
            return vectorised(
                #[inline(always)]
                || diagonalise(d, e, even, m.next_multiple_of(LANES), basis),
            );
        }
        let Some((bidiagonal, svd)) = self.large.as_deref_mut() else {
            return Ok(());
        };
        let mut b = bidiagonal.as_mut().submatrix_mut(0, 0, odd, even);
        b.fill(0.0);
        for i in 0..odd {
            b[(i, i)] = d[i];
            if i + 1 < even {
                b[(i, i + 1)] = e[i];
            }
        }
        svd.compute(bidiagonal.as_ref().submatrix(0, 0, odd, even))?;
        for (first, count, vectors) in [(0, even, svd.v()), (1, odd, svd.u())] {
            let from = self.basis.every_other(first, count).subrows(0, m);
            let to = self.reduced.every_other_mut(first, count).subrows_mut(0, m);
            matmul(to, Accum::Replace, from, vectors, 1.0, Par::Seq);
        }
        std::mem::swap(&mut self.basis, &mut self.reduced);
        for (l, angle) in d.iter_mut().enumerate() {
            *angle = svd.s(l);
        }
        Ok(())
    }
}

/// `x += w p_l - p w_l`: the difference first, so that the result stays exactly skew. In whole groups.
#[inline(always)]
fn update(x: &mut [f64], w: &[f64], p: &[f64], w_l: f64, p_l: f64) {
    for ((x, w), p) in x.iter_mut().zip(w).zip(p) {
        *x += w * p_l - p * w_l;
    }
}

/// The unit `w` with `(I - 2 w w^T) x = alpha e_1`, or zero if `x` already has that form; returns `alpha`.
#[inline(always)]
fn reflector(x: &[f64], w: &mut [f64]) -> f64 {
    w.fill(0.0);
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
    if x.len() < 2 || largest(&x[1..]) == 0.0 {
        return x.first().copied().unwrap_or(0.0);
    }
    let scale = largest(x);
    for (w, x) in w.iter_mut().zip(x) {
        *w = x / scale;
    }
    let alpha = -dot(w, w).sqrt().copysign(w[0]);
    w[0] -= alpha;
    let length = dot(w, w).sqrt();
    for w in w {
        *w /= length;
    }
    scale * alpha
}

/// Scalar product in `LANES` partial sums.
#[inline(always)]
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<LANES>(), y.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (x, y) in x.iter().zip(y) {
        for l in 0..LANES {
            sums[l] += x[l] * y[l];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

/// Applies a function of `ad_L` to a skew matrix given in the Schur basis of `L`, in place.
///
/// `ad_L` leaves the 2 x 2 block of two planes invariant. It acts on the part of the block that commutes with `J` as
/// multiplication by `i (theta_a - theta_b)`, and on the part that anticommutes by `i (theta_a + theta_b)`.
/// `function(x, sum)` returns real and imaginary part of the function at `i x`; `sum` distinguishes the two cases.
pub(crate) fn apply_ad_function(
    angles: &[f64],
    skew: MatMut<'_, f64>,
    function: impl Fn(f64, bool) -> (f64, f64),
) {
    let angle = |a: usize| angles.get(a).copied().unwrap_or(0.0);
    apply_ad_by_planes(skew, |a, b| {
        let (a, b) = (angle(a), angle(b));
        [function(a - b, false), function(a + b, true)]
    });
}

/// As [`apply_ad_function`], with `function(a, b)` of the indices of two planes, which returns the values at the
/// difference and at the sum of their angles; a null vector counts as an additional last plane with angle 0.
pub(crate) fn apply_ad_by_planes(
    mut skew: MatMut<'_, f64>,
    function: impl Fn(usize, usize) -> [(f64, f64); 2],
) {
    let m = skew.nrows();
    let rotate = |(re, im): (f64, f64), (x, y): (f64, f64)| (re * x - im * y, im * x + re * y);
    for b in 0..m / 2 {
        // The diagonal block is a multiple of J and commutes with it: the function at 0.
        let entry = function(b, b)[0].0 * skew[(2 * b + 1, 2 * b)];
        skew[(2 * b + 1, 2 * b)] = entry;
        skew[(2 * b, 2 * b + 1)] = -entry;
        for a in b + 1..m / 2 {
            let (i, j) = (2 * a, 2 * b);
            let (m00, m01) = (skew[(i, j)], skew[(i, j + 1)]);
            let (m10, m11) = (skew[(i + 1, j)], skew[(i + 1, j + 1)]);
            let commuting = (0.5 * (m00 + m11), 0.5 * (m10 - m01));
            let anticommuting = (0.5 * (m00 - m11), 0.5 * (m01 + m10));
            let [difference, sum] = function(a, b);
            let (p, q) = rotate(difference, commuting);
            let (r, s) = rotate(sum, anticommuting);
            let block = [[p + r, s - q], [q + s, p - r]];
            for (di, row) in block.iter().enumerate() {
                for (dj, &x) in row.iter().enumerate() {
                    skew[(i + di, j + dj)] = x;
                    skew[(j + dj, i + di)] = -x;
                }
            }
        }
        if m % 2 == 1 {
            // For the null vector: the row (x, y) corresponds to the column (-x, -y), on which ad acts as i theta.
            let column = (skew[(2 * b, m - 1)], skew[(2 * b + 1, m - 1)]);
            let (x, y) = rotate(function(b, m / 2)[0], column);
            for (d, value) in [x, y].into_iter().enumerate() {
                skew[(2 * b + d, m - 1)] = value;
                skew[(m - 1, 2 * b + d)] = -value;
            }
        }
    }
}
