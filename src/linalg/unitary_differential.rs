//! The derivative of the logarithm of unitary matrices, and its transpose.
//!
//! In an eigenbasis of `L = log Q`, with eigenvalues `i theta_a`, a function of `ad_L` multiplies entry `(a, b)` by its
//! value at `i (theta_a - theta_b)`. In the embedding into rotations there would also be sums of angles, which are
//! singular where two angles approach `pi`, though nothing complex is.

use std::f64::consts::PI;

use faer::{Mat, MatRef, c64};

use super::UnitaryLog;
use super::decomp::SymmetricEigen;
use super::differential::check_smooth;
use super::orthogonal_log::inverse_dexp;
use super::structure::{check_finite_entries, check_shape, check_square};
use crate::error::{Error, Result};

/// The derivative of the principal logarithm at a unitary matrix; all shapes `(m, m)`.
///
/// ```math
/// D\log_Q[F] = \frac{\mathrm{ad}_L}{1 - e^{-\mathrm{ad}_L}}\, Q^H F,\qquad L = \log Q
/// ```
///
/// It grows as the inverse of the distance of a difference of two angles from `2 pi`, of an angle near `pi` from one
/// near `-pi`, and is refused next to it. Source: see Higham (2008), "Functions of Matrices", sec. 10.2. Cost `O(m^3)`.
///
/// # Examples
/// ```
/// use faer::{c64, mat};
/// use stiefel_rs::linalg::UnitaryLogDifferential;
/// // The angle of a phase has the derivative 1 along the circle.
/// let (phase, i) = (mat![[c64::new(0.0, 1.0)]], c64::new(0.0, 1.0));
/// let along = mat![[phase[(0, 0)] * i]];
/// let found = UnitaryLogDifferential::new(phase.as_ref())?.apply(along.as_ref())?;
/// assert!((found[(0, 0)] - i).norm() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct UnitaryLogDifferential {
    matrix: Mat<c64>,
    basis: Mat<c64>,
    angles: Vec<f64>,
}

impl UnitaryLogDifferential {
    /// The derivative at a unitary matrix.
    ///
    /// # Errors
    /// As [`unitary_log`](super::unitary_log()); `LogNotDifferentiable`.
    pub fn new(q: MatRef<'_, c64>) -> Result<Self> {
        let m = check_square("Q", q)?;
        let mut log = Mat::zeros(m, m);
        UnitaryLog::new(m).checked_into(log.as_mut(), q)?;
        // -i L is Hermitian.
        let hermitian = Mat::from_fn(m, m, |i, j| c64::new(log[(i, j)].im, -log[(i, j)].re));
        let mut eigen = SymmetricEigen::new(m);
        eigen.compute(hermitian.as_ref())?;
        let angles: Vec<f64> = (0..m).map(|a| eigen.value(a)).collect();
        let smallest = angles.iter().copied().fold(PI, f64::min);
        let largest = angles.iter().copied().fold(-PI, f64::max);
        check_smooth((largest - smallest).max(0.0))?;
        Ok(UnitaryLogDifferential {
            matrix: q.to_owned(),
            basis: eigen.vectors().to_owned(),
            angles,
        })
    }

    /// `D log_Q[F]`; only the skew-Hermitian part of `Q^H F` matters.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn apply(&self, f: MatRef<'_, c64>) -> Result<Mat<c64>> {
        self.check("F", f)?;
        let body = self.matrix.adjoint() * f;
        finite(self.function_of_ad(body.as_ref(), |x| {
            let (re, im) = inverse_dexp(x);
            c64::new(re, im)
        }))
    }

    /// The matrix `G`, tangent at `Q`, with `Re tr(G^H F) = Re tr(W^H D log_Q[F])` for every `F` tangent at `Q`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn pull_back(&self, w: MatRef<'_, c64>) -> Result<Mat<c64>> {
        self.check("W", w)?;
        let turned = self.function_of_ad(w, |x| {
            let (re, im) = inverse_dexp(x);
            c64::new(re, -im)
        });
        finite(&self.matrix * turned)
    }

    fn check(&self, name: &'static str, matrix: MatRef<'_, c64>) -> Result<()> {
        let m = self.angles.len();
        check_shape(name, matrix, m, m)?;
        check_finite_entries(name, matrix)
    }

    /// `function(ad)` applied to the skew-Hermitian part of a matrix, where `function` gives the value at `i x`.
    fn function_of_ad(&self, a: MatRef<'_, c64>, function: impl Fn(f64) -> c64) -> Mat<c64> {
        let m = self.angles.len();
        let skew = skew_part(a);
        let mut turned = self.basis.adjoint() * &skew * &self.basis;
        for b in 0..m {
            for a in 0..m {
                turned[(a, b)] *= function(self.angles[a] - self.angles[b]);
            }
        }
        skew_part((&self.basis * turned * self.basis.adjoint()).as_ref())
    }
}

fn skew_part(a: MatRef<'_, c64>) -> Mat<c64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        a[(i, j)] * 0.5 - a[(j, i)].conj() * 0.5
    })
}

fn finite(matrix: Mat<c64>) -> Result<Mat<c64>> {
    match matrix.is_all_finite() {
        true => Ok(matrix),
        false => Err(Error::Overflow {
            quantity: "derivative",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::complex_embedding::{embed, nearest};
    use crate::linalg::{SkewExpDifferential, unitary_log};

    fn entry(i: usize, j: usize, seed: usize) -> c64 {
        let at = (17 * i + 5 * j + 11 * seed) as f64;
        c64::new(at.sin(), (3.0 * at).cos())
    }

    fn skew(m: usize, seed: usize) -> Mat<c64> {
        skew_part(Mat::from_fn(m, m, |i, j| entry(i, j, seed)).as_ref())
    }

    /// Skew-Hermitian matrices with the given angles.
    fn with_angles(angles: &[f64]) -> Mat<c64> {
        let m = angles.len();
        let basis = nearest(
            crate::linalg::skew_exp(embed(skew(m, 9).as_ref()).as_ref())
                .unwrap()
                .as_ref(),
        );
        let turned = Mat::from_fn(m, m, |i, j| basis[(i, j)] * c64::new(0.0, angles[j]));
        skew_part((turned * basis.adjoint()).as_ref())
    }

    /// Vanishing, repeated and opposite angles, and several near pi.
    fn cases() -> Vec<Mat<c64>> {
        let near = |d: f64| PI - d;
        vec![
            with_angles(&[0.0]),
            with_angles(&[0.0, 0.0, 0.0]),
            with_angles(&[0.7, 0.7, -0.7]),
            with_angles(&[0.7, 0.7 + 1e-9, 2.0, -1.0]),
            with_angles(&[near(1e-4), near(1.5e-4)]),
            with_angles(&[near(1e-9), near(1e-9), 0.0, 0.0]),
            with_angles(&[near(1e-9), near(2e-9), 0.3, -2.0, 1.0]),
        ]
    }

    #[test]
    fn it_undoes_the_derivative_of_the_exponential() {
        for a in cases() {
            let m = a.nrows();
            let exp = SkewExpDifferential::new(embed(a.as_ref()).as_ref()).unwrap();
            let log = UnitaryLogDifferential::new(nearest(exp.value()).as_ref()).unwrap();
            let e = skew(m, 4);
            let moved = nearest(exp.apply(embed(e.as_ref()).as_ref()).unwrap().as_ref());
            let error = (log.apply(moved.as_ref()).unwrap() - &e).norm_max();
            assert!(error < 1e-13 * (1.0 + a.norm_l2()), "{a:?} {error:e}");
        }
    }

    #[test]
    fn pulling_back_is_the_transpose() {
        let inner = |a: &Mat<c64>, b: &Mat<c64>| -> f64 {
            (a.adjoint() * b).diagonal().column_vector().sum().re
        };
        for a in cases() {
            let m = a.nrows();
            let exp = SkewExpDifferential::new(embed(a.as_ref()).as_ref()).unwrap();
            let q = nearest(exp.value());
            assert!((unitary_log(q.as_ref()).unwrap() - &a).norm_max() < 1e-14 * m as f64);
            let log = UnitaryLogDifferential::new(q.as_ref()).unwrap();
            let (f, w) = (&q * skew(m, 5), Mat::from_fn(m, m, |i, j| entry(i, j, 6)));
            let found = log.apply(f.as_ref()).unwrap();
            let back = log.pull_back(w.as_ref()).unwrap();
            let error = (inner(&w, &found) - inner(&back, &f)).abs();
            assert!(error < 1e-13 * (m * m) as f64, "{a:?} {error:e}");
        }
    }
}
