//! Derivatives of the exponential of skew matrices and of the logarithm of rotations, and their transposes.
//!
//! With `phi(x) = (1 - e^{-x}) / x`,
//!
//! ```math
//! D\exp_A[E] = e^A\, \varphi(\mathrm{ad}_A)\, E,\qquad
//! D\log_Q[F] = \varphi(\mathrm{ad}_L)^{-1}\, Q^T F,\quad L = \log Q
//! ```
//!
//! In the real Schur basis of `A` or `L`, a function of `ad` acts by multiplication with its values at `i (theta_a -
//! theta_b)` and at `i (theta_a + theta_b)`, so repeated and vanishing angles are not special cases. Since `ad` is
//! skew, the transpose has `-ad` in place of `ad`. Cost `O(m^3)`.
//!
//! # Source
//! Higham (2008), "Functions of Matrices", sec. 10.2 (the derivative of the exponential as a function of `ad`).

use faer::{Mat, MatRef};

use super::field::larger;
use super::orthogonal_log::inverse_dexp;
use super::product::{mul_into, product};
use super::skew_schur::apply_ad_function;
use super::structure::{check_finite, check_range, check_shape};
use super::{OrthogonalLog, SkewSchur, skew_exp};
use crate::error::{Error, Result};

/// The derivative of the exponential at a skew matrix; all shapes `(m, m)`.
///
/// ```math
/// D\exp_A[E] = e^A\, \frac{1 - e^{-\mathrm{ad}_A}}{\mathrm{ad}_A}\, E
/// ```
///
/// Accurate to about `m eps` relative to the norm of the direction. Source: see Higham (2008), sec. 10.2.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::{SkewExpDifferential, skew_exp};
/// let a = mat![[0.0, -0.3, 0.1], [0.3, 0.0, -0.8], [-0.1, 0.8, 0.0]];
/// let e = mat![[0.0, 1.0, 0.5], [-1.0, 0.0, 0.2], [-0.5, -0.2, 0.0]];
/// let found = SkewExpDifferential::new(a.as_ref())?.apply(e.as_ref())?;
/// let h = 1e-5;
/// let [before, after] = [-h, h].map(|h| skew_exp((&a + faer::Scale(h) * &e).as_ref()));
/// let difference = (after? - before?) * faer::Scale(0.5 / h);
/// assert!((found - difference).norm_l2() < 1e-9);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct SkewExpDifferential {
    schur: SkewSchur,
    value: Mat<f64>,
}

impl SkewExpDifferential {
    /// The derivative at a skew matrix.
    ///
    /// # Errors
    /// As [`skew_exp`](super::skew_exp()).
    pub fn new(a: MatRef<'_, f64>) -> Result<Self> {
        let value = skew_exp(a)?;
        let mut schur = SkewSchur::new(a.nrows());
        schur.compute(a)?;
        Ok(SkewExpDifferential { schur, value })
    }

    /// `e^A`.
    pub fn value(&self) -> MatRef<'_, f64> {
        self.value.as_ref()
    }

    /// `D exp_A[E]`; only the skew part of `E` matters.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn apply(&self, e: MatRef<'_, f64>) -> Result<Mat<f64>> {
        check(&self.value, "E", e)?;
        let turned = function_of_ad(&self.schur, skew_part(e), dexp);
        finite(&self.value * turned)
    }

    /// The skew matrix `G` with `tr(G^T E) = tr(W^T D exp_A[E])` for every skew `E`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn pull_back(&self, w: MatRef<'_, f64>) -> Result<Mat<f64>> {
        check(&self.value, "W", w)?;
        let back = self.value.transpose() * w;
        finite(function_of_ad(&self.schur, skew_part(back.as_ref()), |x| {
            conjugate(dexp(x))
        }))
    }
}

/// The derivative of the principal logarithm at a rotation; all shapes `(m, m)`.
///
/// ```math
/// D\log_Q[F] = \frac{\mathrm{ad}_L}{1 - e^{-\mathrm{ad}_L}}\, Q^T F,\qquad L = \log Q
/// ```
///
/// It is finite for all angles below `pi`; if two of them approach `pi` together, it grows as the inverse of the
/// difference of their sum from `2 pi`, and is refused next to it.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::{OrthogonalLogDifferential, SkewExpDifferential};
/// let a = mat![[0.0, -0.3, 0.1], [0.3, 0.0, -0.8], [-0.1, 0.8, 0.0]];
/// let e = mat![[0.0, 1.0, 0.5], [-1.0, 0.0, 0.2], [-0.5, -0.2, 0.0]];
/// let exp = SkewExpDifferential::new(a.as_ref())?;
/// let log = OrthogonalLogDifferential::new(exp.value())?;
/// assert!((log.apply(exp.apply(e.as_ref())?.as_ref())? - e).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct OrthogonalLogDifferential {
    schur: SkewSchur,
    rotation: Mat<f64>,
    value: Mat<f64>,
}

impl OrthogonalLogDifferential {
    /// The derivative at a rotation.
    ///
    /// # Errors
    /// As [`orthogonal_log`](super::orthogonal_log()); `LogNotDifferentiable`.
    pub fn new(q: MatRef<'_, f64>) -> Result<Self> {
        let m = super::structure::check_square("Q", q)?;
        let mut value = Mat::zeros(m, m);
        OrthogonalLog::new(m).checked_into(value.as_mut(), q)?;
        let mut schur = SkewSchur::new(m);
        schur.compute(value.as_ref())?;
        let mut largest = [0.0; 2];
        for angle in schur.angles() {
            let [first, second] = largest;
            largest = [larger(first, *angle), larger(second, first.min(*angle))];
        }
        check_smooth(largest[0] + largest[1])?;
        Ok(OrthogonalLogDifferential {
            schur,
            rotation: q.to_owned(),
            value,
        })
    }

    /// `log Q`.
    pub fn value(&self) -> MatRef<'_, f64> {
        self.value.as_ref()
    }

    /// `D log_Q[F]`; only the skew part of `Q^T F` matters.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn apply(&self, f: MatRef<'_, f64>) -> Result<Mat<f64>> {
        check(&self.rotation, "F", f)?;
        let body = self.rotation.transpose() * f;
        finite(function_of_ad(
            &self.schur,
            skew_part(body.as_ref()),
            inverse_dexp,
        ))
    }

    /// The matrix `G`, tangent at `Q`, with `tr(G^T F) = tr(W^T D log_Q[F])` for every `F` tangent at `Q`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn pull_back(&self, w: MatRef<'_, f64>) -> Result<Mat<f64>> {
        check(&self.rotation, "W", w)?;
        let turned = function_of_ad(&self.schur, skew_part(w), |x| conjugate(inverse_dexp(x)));
        finite(&self.rotation * turned)
    }
}

/// Singular value of the derivative of the exponential, whose largest is 1, below which the logarithm counts as not
/// differentiable, as for boundary problems: round-off of the angles changes the derivative by a part in 1e4.
const SINGULAR: f64 = 1e-11;

/// Checks that the exponential is smoothly invertible where the largest distance of two eigenvalues of its argument is
/// `x`.
///
/// # Errors
/// `LogNotDifferentiable`.
pub(super) fn check_smooth(x: f64) -> Result<()> {
    let (re, im) = dexp(x);
    match re.hypot(im) < SINGULAR {
        true => Err(Error::LogNotDifferentiable { angle: 0.5 * x }),
        false => Ok(()),
    }
}

fn check(like: &Mat<f64>, name: &'static str, matrix: MatRef<'_, f64>) -> Result<()> {
    check_shape(name, matrix, like.nrows(), like.ncols())?;
    check_finite(name, matrix)
}

fn finite(matrix: Mat<f64>) -> Result<Mat<f64>> {
    check_range("derivative", matrix.as_ref())?;
    Ok(matrix)
}

fn skew_part(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        0.5 * a[(i, j)] - 0.5 * a[(j, i)]
    })
}

/// `function(ad)` applied to a skew matrix, where `function` gives real and imaginary part at `i x`.
fn function_of_ad(
    schur: &SkewSchur,
    mut skew: Mat<f64>,
    function: impl Fn(f64) -> (f64, f64),
) -> Mat<f64> {
    let basis = schur.basis();
    let mut half = product(&skew, basis);
    mul_into(&mut skew, 1.0, basis.transpose(), &half);
    apply_ad_function(schur.angles(), skew.as_mut(), |x, _| function(x));
    mul_into(&mut half, 1.0, &skew, basis.transpose());
    mul_into(&mut skew, 1.0, basis, &half);
    skew_part(skew.as_ref())
}

fn conjugate((re, im): (f64, f64)) -> (f64, f64) {
    (re, -im)
}

/// `(1 - e^{-i x}) / (i x)`.
pub(crate) fn dexp(x: f64) -> (f64, f64) {
    if x.abs() < 1e-4 {
        (1.0 - x * x / 6.0, -0.5 * x * (1.0 - x * x / 12.0))
    } else {
        let half = (0.5 * x).sin();
        (x.sin() / x, -2.0 * half * half / x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(i: usize, j: usize, seed: usize) -> f64 {
        ((17 * i + 5 * j + 11 * seed) as f64).sin()
    }

    fn skew(m: usize, seed: usize) -> Mat<f64> {
        skew_part(Mat::from_fn(m, m, |i, j| entry(i, j, seed)).as_ref())
    }

    fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
        (a.transpose() * b).diagonal().column_vector().sum()
    }

    /// Rotations by the given angles in coordinate planes.
    fn planes(m: usize, angles: &[f64]) -> Mat<f64> {
        let mut a = Mat::zeros(m, m);
        for (i, angle) in angles.iter().enumerate() {
            a[(2 * i + 1, 2 * i)] = *angle;
            a[(2 * i, 2 * i + 1)] = -angle;
        }
        a
    }

    /// Matrices with vanishing, repeated and close angles, and angles near pi.
    fn cases() -> Vec<Mat<f64>> {
        let near = std::f64::consts::PI - 1e-9;
        vec![
            Mat::zeros(1, 1),
            Mat::zeros(2, 2),
            Mat::zeros(3, 3),
            Mat::zeros(5, 5),
            planes(2, &[near]),
            planes(3, &[near]),
            planes(3, &[1e-9]),
            planes(4, &[0.7, 0.7]),
            planes(5, &[0.7, 0.7 + 1e-9]),
            planes(6, &[2.0, 0.0, near]),
            skew(3, 1),
            skew(4, 2) * faer::Scale(0.8),
            skew(7, 3) * faer::Scale(0.5),
        ]
    }

    #[test]
    fn the_logarithm_undoes_the_exponential() {
        for a in cases() {
            let m = a.nrows();
            let exp = SkewExpDifferential::new(a.as_ref()).unwrap();
            let log = OrthogonalLogDifferential::new(exp.value()).unwrap();
            let e = skew(m, 4);
            let moved = exp.apply(e.as_ref()).unwrap();
            let error = (log.apply(moved.as_ref()).unwrap() - &e).norm_max();
            assert!(error < 1e-13 * (1.0 + a.norm_l2()), "{a:?} {error:e}");
        }
    }

    #[test]
    fn the_series_next_to_zero_goes_on() {
        let edge = 1e-4_f64;
        let [(a, b), (c, d)] = [edge * (1.0 - 1e-12), edge * (1.0 + 1e-12)].map(dexp);
        assert!((a - c).abs() < 1e-15, "{a} {c}");
        // The function changes by 1e-16 between the two.
        assert!((b - d).abs() < 1e-15, "{b} {d}");
    }

    #[test]
    fn pulling_back_is_the_transpose() {
        for a in cases() {
            let m = a.nrows();
            let exp = SkewExpDifferential::new(a.as_ref()).unwrap();
            let log = OrthogonalLogDifferential::new(exp.value()).unwrap();
            let (e, w) = (skew(m, 5), Mat::from_fn(m, m, |i, j| entry(i, j, 6)));
            let moved = exp.apply(e.as_ref()).unwrap();
            let back = exp.pull_back(w.as_ref()).unwrap();
            let error = (inner(&w, &moved) - inner(&back, &e)).abs();
            assert!(error < 1e-13 * (m * m) as f64, "exp {a:?} {error:e}");
            let f = exp.value() * skew(m, 7);
            let found = log.apply(f.as_ref()).unwrap();
            let back = log.pull_back(w.as_ref()).unwrap();
            let error = (inner(&w, &found) - inner(&back, &f)).abs();
            assert!(error < 1e-13 * (m * m) as f64, "log {a:?} {error:e}");
        }
    }

    #[test]
    fn the_derivative_is_the_limit_of_differences() {
        let h = 1e-5;
        for a in cases() {
            let m = a.nrows();
            let e = skew(m, 8);
            let found = SkewExpDifferential::new(a.as_ref())
                .and_then(|exp| exp.apply(e.as_ref()))
                .unwrap();
            let [before, after] =
                [-h, h].map(|h| skew_exp((&a + faer::Scale(h) * &e).as_ref()).unwrap());
            let error = (found - (after - before) * faer::Scale(0.5 / h)).norm_max();
            assert!(error < 1e-9, "{a:?} {error:e}");
        }
    }
}
