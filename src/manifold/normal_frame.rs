//! An orthonormal basis of the directions normal to the span of a curve's point.

use faer::{Mat, MatMut, MatRef};

use crate::linalg::decomp::thin_q;
use crate::linalg::product::{mul_add, mul_into};

/// Ratio of the smallest to the largest pivot above which one pass of Cholesky's factorisation is orthonormal to a few
/// units of round-off (the defect is `eps / ratio`).
const WELL_CONDITIONED: f64 = 0.05;

/// Ratio below which two passes are not enough either, and Householder reflections are used.
const ILL_CONDITIONED: f64 = 1e-8;

/// Normal parts below this get their frame from reflections, which make it orthogonal to the point in any case.
const ROUND_OFF: f64 = 1e-12;

/// Maximal number of normal directions of a curve from a point of `St(n, k)`: `min(k, n - k)`.
pub(crate) fn normal_rank(n: usize, k: usize) -> usize {
    k.min(n - k)
}

/// An orthonormal `Q`, shape `(n, p)` with `p = min(k, n - k)`, orthogonal to `s`, whose span contains `normal`.
///
/// `normal` (shape `(n, k)`, any rank, `S^T normal = 0`) is factored by Cholesky's method on its Gram matrix, which
/// only takes products, if its condition allows, and by Householder reflections otherwise.
///
/// # Source
/// Two passes: Yamamoto, Nakatsukasa, Yanagisawa, Fukaya (2015), "Roundoff error analysis of the CholeskyQR2
/// algorithm", ETNA 44, 306-326.
pub(crate) fn normal_frame(s: MatRef<'_, f64>, normal: MatRef<'_, f64>) -> Mat<f64> {
    let (n, k) = (s.nrows(), s.ncols());
    let p = normal_rank(n, k);
    if p == 0 {
        return Mat::zeros(n, 0);
    }
    let largest = normal.norm_max();
    // A subnormal entry has no reciprocal.
    let scale = if largest > f64::MIN_POSITIVE {
        1.0 / largest
    } else {
        1.0
    };
    // A normal part of the size of round-off has no direction: repeated projections keep shrinking it.
    if p == k && scale.is_finite() && largest > ROUND_OFF {
        let mut q = Mat::from_fn(n, k, |i, j| scale * normal[(i, j)]);
        if orthonormalise(s, &mut q) {
            return q;
        }
    }
    let both = Mat::from_fn(n, 2 * k, |i, j| {
        if j < k {
            s[(i, j)]
        } else {
            scale * normal[(i, j - k)]
        }
    });
    thin_q(both.as_ref()).as_ref().subcols(k, p).to_owned()
}

/// Makes the columns of `q` orthonormal; `false` if they are too ill-conditioned.
fn orthonormalise(s: MatRef<'_, f64>, q: &mut Mat<f64>) -> bool {
    let mut pass = Pass::new(q.nrows(), q.ncols());
    let ratio = pass.run(q);
    if ratio >= WELL_CONDITIONED {
        return true;
    }
    if ratio < ILL_CONDITIONED {
        return false;
    }
    mul_into(&mut pass.gram, 1.0, s.transpose(), &*q);
    mul_add(&mut *q, -1.0, s, &pass.gram);
    pass.run(q) >= WELL_CONDITIONED
}

struct Pass {
    gram: Mat<f64>,
    inverse: Mat<f64>,
    copy: Mat<f64>,
}

impl Pass {
    fn new(n: usize, k: usize) -> Self {
        Pass {
            gram: Mat::zeros(k, k),
            inverse: Mat::zeros(k, k),
            copy: Mat::zeros(n, k),
        }
    }

    /// `Q <- Q R^{-1}` with `Q^T Q = R^T R`; returns the ratio of the pivots, and leaves `q` unchanged if it is small.
    fn run(&mut self, q: &mut Mat<f64>) -> f64 {
        mul_into(&mut self.gram, 1.0, q.transpose(), &*q);
        let ratio = cholesky_in_place(self.gram.as_mut());
        if ratio >= ILL_CONDITIONED {
            invert_upper(self.inverse.as_mut(), self.gram.as_ref());
            self.copy.copy_from(&*q);
            mul_into(q, 1.0, &self.copy, &self.inverse);
        }
        ratio
    }
}

/// The upper factor `R` of `G = R^T R`, in the upper triangle; returns the ratio of the smallest to the largest squared
/// pivot, 0 if `G` is not positive definite.
fn cholesky_in_place(mut g: MatMut<'_, f64>) -> f64 {
    let k = g.nrows();
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
    for j in 0..k {
        for i in 0..=j {
            let mut sum = g[(i, j)];
            for l in 0..i {
                sum -= g[(l, i)] * g[(l, j)];
            }
            if i < j {
                g[(i, j)] = sum / g[(i, i)];
            } else if sum > 0.0 {
                smallest = smallest.min(sum);
                largest = largest.max(sum);
                g[(j, j)] = sum.sqrt();
            } else {
                return 0.0;
            }
        }
    }
    smallest / largest
}

/// `out = R^{-1}` for an upper triangular `R`.
fn invert_upper(mut out: MatMut<'_, f64>, r: MatRef<'_, f64>) {
    let k = r.nrows();
    out.fill(0.0);
    for j in 0..k {
        out[(j, j)] = 1.0 / r[(j, j)];
        for i in (0..j).rev() {
            let mut sum = 0.0;
            for l in i + 1..=j {
                sum += r[(i, l)] * out[(l, j)];
            }
            out[(i, j)] = -sum / r[(i, i)];
        }
    }
}
