//! Real Schur form of a skew-symmetric matrix, with an orthogonal basis for every spectrum.
//!
//! Householder reflections bring `A` to skew tridiagonal form; even and odd basis vectors then split it into
//! `[[0, -B^T], [B, 0]]` with `B` bidiagonal of half the size, and the singular value decomposition of `B`
//! gives angles and planes. The basis is a product of reflections and of singular vectors, so it is
//! orthogonal to round-off also for zero, repeated and clustered angles, where complex eigenvectors are not.
//!
//! # Source
//! Ward, Gray (1978), "Eigensystem computation for skew-symmetric matrices", ACM TOMS 4, 278-285.
//! Deviation: a full singular value decomposition of `B` in place of their QR iteration.

use faer::prelude::*;
use faer::{Mat, MatRef};

use super::decomp::Svd;
use crate::error::{Error, Result};

/// Entries above this are scaled down first, by a power of two.
const HUGE: f64 = 1e290;

/// `2^-100`.
const SHRINK: f64 = 1.0 / (1_u128 << 100) as f64;

/// `A = V blockdiag(theta_i J) V^T` with `J = [[0, -1], [1, 0]]`, in buffers made once for a largest size.
///
/// Columns `2i` and `2i + 1` of `V` span the plane of `theta_i >= 0`; for odd sizes the last column is a null
/// vector. Cost about `10/3 m^3` operations. The backward error is a small multiple of `m eps |A|`.
pub struct SkewSchur {
    m: usize,
    reduced: Mat<f64>,
    basis: Mat<f64>,
    householder: Mat<f64>,
    angles: Vec<f64>,
    reflector: Vec<f64>,
    image: Vec<f64>,
    bidiagonal: Mat<f64>,
    svd: Svd,
}

impl SkewSchur {
    /// Buffers for matrices of at most `m x m`.
    pub fn new(m: usize) -> Self {
        let (odd, even) = (m / 2, m.div_ceil(2));
        SkewSchur {
            m: 0,
            reduced: Mat::zeros(m, m),
            basis: Mat::zeros(m, m),
            householder: Mat::zeros(m, m),
            angles: vec![0.0; odd],
            reflector: vec![0.0; m],
            image: vec![0.0; m],
            bidiagonal: Mat::zeros(odd, even),
            svd: Svd::new(odd, even),
        }
    }

    /// The orthogonal basis `V`, `m x m`.
    pub fn basis(&self) -> MatRef<'_, f64> {
        self.basis.as_ref().submatrix(0, 0, self.m, self.m)
    }

    /// The angles `theta_i >= 0`, decreasing, `m / 2` of them.
    pub fn angles(&self) -> &[f64] {
        &self.angles[..self.m / 2]
    }

    /// Factors a skew-symmetric matrix, of which the lower triangle is read.
    ///
    /// # Errors
    /// `Decomposition` where the singular value iteration does not converge, `Overflow` where an angle is too large
    /// for a number.
    pub fn compute(&mut self, a: MatRef<'_, f64>) -> Result<()> {
        let m = a.nrows();
        debug_assert!(m == a.ncols() && m <= self.reduced.nrows());
        self.m = m;
        // Sums of entries near the largest number must not overflow.
        let largest = (0..m)
            .flat_map(|j| (j + 1..m).map(move |i| a[(i, j)].abs()))
            .fold(0.0, f64::max);
        let shrink = if largest > HUGE { SHRINK } else { 1.0 };
        for j in 0..m {
            self.reduced[(j, j)] = 0.0;
            for i in j + 1..m {
                self.reduced[(i, j)] = shrink * a[(i, j)];
                self.reduced[(j, i)] = -shrink * a[(i, j)];
            }
        }
        self.tridiagonalise();
        self.accumulate_reflections();
        self.split_even_odd()?;
        for angle in &mut self.angles[..m / 2] {
            *angle /= shrink;
            if !angle.is_finite() {
                return Err(Error::Overflow {
                    quantity: "skew Schur form",
                });
            }
        }
        Ok(())
    }

    /// `H_j ... H_1 A H_1 ... H_j` tridiagonal; the unit reflectors are kept in the columns of `householder`.
    fn tridiagonalise(&mut self) {
        let m = self.m;
        for j in 0..m.saturating_sub(2) {
            let w = &mut self.reflector;
            let scale = (j + 1..m).fold(0.0_f64, |s, i| s.max(self.reduced[(i, j)].abs()));
            let tail = (j + 2..m).fold(0.0_f64, |s, i| s.max(self.reduced[(i, j)].abs()));
            for i in j + 1..m {
                self.householder[(i, j)] = 0.0;
            }
            if tail == 0.0 {
                continue;
            }
            let mut sum = 0.0;
            for i in j + 1..m {
                w[i] = self.reduced[(i, j)] / scale;
                sum += w[i] * w[i];
            }
            let alpha = -sum.sqrt().copysign(w[j + 1]);
            w[j + 1] -= alpha;
            let length = (sum - 2.0 * alpha * (w[j + 1] + alpha) + alpha * alpha).sqrt();
            for i in j + 1..m {
                w[i] /= length;
                self.householder[(i, j)] = w[i];
            }
            self.reduced[(j + 1, j)] = scale * alpha;
            self.reduced[(j, j + 1)] = -scale * alpha;
            for i in j + 2..m {
                self.reduced[(i, j)] = 0.0;
                self.reduced[(j, i)] = 0.0;
            }
            // H A H = A + w p^T - p w^T with p = 2 A w: the quadratic term vanishes because w^T A w = 0.
            let p = &mut self.image;
            p[j + 1..m].fill(0.0);
            for l in j + 1..m {
                for i in j + 1..m {
                    p[i] += 2.0 * self.reduced[(i, l)] * w[l];
                }
            }
            for l in j + 1..m {
                for i in l + 1..m {
                    let entry = self.reduced[(i, l)] + w[i] * p[l] - p[i] * w[l];
                    self.reduced[(i, l)] = entry;
                    self.reduced[(l, i)] = -entry;
                }
            }
        }
    }

    /// `basis = H_1 H_2 ... H_{m-2}`.
    fn accumulate_reflections(&mut self) {
        let m = self.m;
        for j in 0..m {
            for i in 0..m {
                self.basis[(i, j)] = f64::from(u8::from(i == j));
            }
        }
        for j in (0..m.saturating_sub(2)).rev() {
            for l in j + 1..m {
                let mut dot = 0.0;
                for i in j + 1..m {
                    dot += self.householder[(i, j)] * self.basis[(i, l)];
                }
                for i in j + 1..m {
                    self.basis[(i, l)] -= 2.0 * dot * self.householder[(i, j)];
                }
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
        let mut b = self.bidiagonal.as_mut().submatrix_mut(0, 0, odd, even);
        b.fill(0.0);
        for i in 0..odd {
            b[(i, i)] = self.reduced[(2 * i + 1, 2 * i)];
            if i + 1 < even {
                b[(i, i + 1)] = -self.reduced[(2 * i + 2, 2 * i + 1)];
            }
        }
        self.svd.compute(b.rb())?;
        // Use `reduced` for the rotated basis: columns (V_even v_i, V_odd u_i).
        for i in 0..m {
            for l in 0..odd {
                let (mut from_even, mut from_odd) = (0.0, 0.0);
                for e in 0..even {
                    from_even += self.basis[(i, 2 * e)] * self.svd.v()[(e, l)];
                }
                for o in 0..odd {
                    from_odd += self.basis[(i, 2 * o + 1)] * self.svd.u()[(o, l)];
                }
                self.reduced[(i, 2 * l)] = from_even;
                self.reduced[(i, 2 * l + 1)] = from_odd;
            }
            if even > odd {
                let mut null = 0.0;
                for e in 0..even {
                    null += self.basis[(i, 2 * e)] * self.svd.v()[(e, odd)];
                }
                self.reduced[(i, m - 1)] = null;
            }
        }
        std::mem::swap(&mut self.basis, &mut self.reduced);
        for l in 0..odd {
            self.angles[l] = self.svd.s(l);
        }
        Ok(())
    }
}

/// Applies a function of `ad_L` to a skew matrix given in the Schur basis of `L`, in place.
///
/// `ad_L` leaves the 2 x 2 block of two planes invariant; on its part that commutes with `J` it is the
/// multiplication by `i (theta_a - theta_b)`, on the part that anticommutes by `i (theta_a + theta_b)`.
/// `function(x, sum)` returns real and imaginary part of the function at `i x`; `sum` tells the two apart.
pub(crate) fn apply_ad_function(
    angles: &[f64],
    mut skew: faer::MatMut<'_, f64>,
    function: impl Fn(f64, bool) -> (f64, f64),
) {
    let m = skew.nrows();
    let rotate = |(re, im): (f64, f64), (x, y): (f64, f64)| (re * x - im * y, im * x + re * y);
    for b in 0..m / 2 {
        // The diagonal block is a multiple of J and commutes: the function at 0.
        let entry = function(0.0, false).0 * skew[(2 * b + 1, 2 * b)];
        skew[(2 * b + 1, 2 * b)] = entry;
        skew[(2 * b, 2 * b + 1)] = -entry;
        for a in b + 1..m / 2 {
            let (i, j) = (2 * a, 2 * b);
            let (m00, m01) = (skew[(i, j)], skew[(i, j + 1)]);
            let (m10, m11) = (skew[(i + 1, j)], skew[(i + 1, j + 1)]);
            let commuting = (0.5 * (m00 + m11), 0.5 * (m10 - m01));
            let anticommuting = (0.5 * (m00 - m11), 0.5 * (m01 + m10));
            let (p, q) = rotate(function(angles[a] - angles[b], false), commuting);
            let (r, s) = rotate(function(angles[a] + angles[b], true), anticommuting);
            let block = [[p + r, s - q], [q + s, p - r]];
            for (di, row) in block.iter().enumerate() {
                for (dj, &x) in row.iter().enumerate() {
                    skew[(i + di, j + dj)] = x;
                    skew[(j + dj, i + di)] = -x;
                }
            }
        }
        if m % 2 == 1 {
            // Against the null vector: the row (x, y) belongs to the column (-x, -y), on which ad acts as i theta.
            let column = (skew[(2 * b, m - 1)], skew[(2 * b + 1, m - 1)]);
            let (x, y) = rotate(function(angles[b], false), column);
            for (d, value) in [x, y].into_iter().enumerate() {
                skew[(2 * b + d, m - 1)] = value;
                skew[(m - 1, 2 * b + d)] = -value;
            }
        }
    }
}
