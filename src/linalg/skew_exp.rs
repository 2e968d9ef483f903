//! Exponential of skew-symmetric matrices: a rotation, orthogonal to round-off.
//!
//! | size | algorithm |
//! |---|---|
//! | 1, 2 | 1; a plane rotation |
//! | 3 | Rodrigues' formula |
//! | any, moderate norm | `e^A = C(A^2) + A S(A^2)`: even and odd Taylor parts in the symmetric `A^2`, by Paterson-Stockmeyer, 4 to 8 products, then squaring; no linear system is solved |
//! | any, large norm | real Schur form ([`SkewSchur`]): the cost does not grow with the norm |
//!
//! # Source
//! Even and odd parts: Higham (2008), "Functions of Matrices", section 12.4. Newton-Schulz: section 8.3.

use faer::{Mat, MatMut, MatRef};

use super::product::{axpy, mul_add, mul_into, scale};
use super::skew_schur::SkewSchur;
use super::structure::{check_finite, check_range, check_square, norm, skew_defect};
use crate::error::{Error, Result};

/// A skew-symmetric argument may be off by this much, relative to its norm; the symmetric part is dropped.
pub const SKEW_TOLERANCE: f64 = 1e-12;

/// Taylor degrees in `A^2` with the largest norm for which the first dropped term of the even part is below
/// `eps / 4`: `theta^(2d+2) / (2d+2)! <= 2^-54`.
const DEGREES: [(usize, f64); 3] = [(3, 0.035), (6, 0.417), (9, 1.278)];

/// What an `Overflow` is about.
const EXPONENTIAL: &str = "exponential of a skew matrix";

/// Above this norm (five squarings) the Schur form costs less and loses less.
const LARGE: f64 = 1.278 * 32.0;

/// `1/(2j)!` and `1/(2j+1)!` for `j = 0..=9`.
const EVEN: [f64; 10] = inverse_factorials(0);
const ODD: [f64; 10] = inverse_factorials(1);

const fn inverse_factorials(offset: usize) -> [f64; 10] {
    let mut out = [1.0; 10];
    let mut j = 0;
    while j < 10 {
        let mut factorial = 1.0;
        let mut l = 2;
        while l <= 2 * j + offset {
            factorial *= l as f64;
            l += 1;
        }
        out[j] = 1.0 / factorial;
        j += 1;
    }
    out
}

/// Exponential of a skew-symmetric matrix.
///
/// ```math
/// e^A = \sum_{j \ge 0} A^j / j!,\qquad A^T = -A
/// ```
///
/// # Arguments
/// * `a` - skew-symmetric, shape `(m, m)`, `m >= 1`
/// # Accuracy
/// Orthogonality defect (spectral) at most `m * 1e-15` for every norm; backward error a small multiple of
/// `m eps |A|`. Asserted in `tests/skew_exp.rs`.
/// # Errors
/// `Shape`, `NonFinite`, `NotSkew` (relative defect above [`SKEW_TOLERANCE`]).
/// # Source
/// See the module page.
pub fn skew_exp(a: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let m = check_square("A", a)?;
    check_finite("A", a)?;
    check_skew("A", a)?;
    let mut out = Mat::zeros(m, m);
    SkewExp::new(m).exp_into(out.as_mut(), a, 1.0)?;
    Ok(out)
}

/// Error `NotSkew` unless `|A + A^T|_F / 2 <= SKEW_TOLERANCE |A|_F`.
pub(crate) fn check_skew(name: &'static str, a: MatRef<'_, f64>) -> Result<()> {
    let tolerance = SKEW_TOLERANCE * norm(a);
    let defect = skew_defect(a);
    if defect > tolerance {
        Err(Error::NotSkew {
            name,
            defect,
            tolerance,
        })
    } else {
        Ok(())
    }
}

/// Buffers for exponentials of one size: no allocation per call.
pub struct SkewExp {
    m: usize,
    a: Mat<f64>,
    /// `B, B^2, B^3` with `B = A^2`.
    powers: [Mat<f64>; 3],
    even: Mat<f64>,
    odd: Mat<f64>,
    work: Mat<f64>,
    schur: Option<SkewSchur>,
}

impl SkewExp {
    /// Buffers for `m x m` matrices.
    pub fn new(m: usize) -> Self {
        let size = if m <= 3 { 0 } else { m };
        let zeros = || Mat::zeros(size, size);
        SkewExp {
            m,
            a: zeros(),
            powers: [zeros(), zeros(), zeros()],
            even: zeros(),
            odd: zeros(),
            work: zeros(),
            schur: None,
        }
    }

    /// `out = e^{tA}`; only the skew part of `a` counts. `a` and `t` must be finite.
    ///
    /// # Errors
    /// `Overflow` where an angle is too large for a number; `Decomposition` (large norms only).
    pub fn exp_into(&mut self, mut out: MatMut<'_, f64>, a: MatRef<'_, f64>, t: f64) -> Result<()> {
        debug_assert!(
            a.nrows() == self.m
                && a.ncols() == self.m
                && out.nrows() == self.m
                && out.ncols() == self.m
        );
        let skew = |i: usize, j: usize| t * (0.5 * a[(i, j)] - 0.5 * a[(j, i)]);
        match self.m {
            0 => {}
            1 => out[(0, 0)] = 1.0,
            2 => plane_rotation(out, skew(1, 0))?,
            3 => rodrigues(out, [skew(2, 1), skew(0, 2), skew(1, 0)])?,
            m => {
                for j in 0..m {
                    for i in 0..m {
                        self.a[(i, j)] = skew(i, j);
                    }
                }
                check_range(EXPONENTIAL, self.a.as_ref())?;
                // The singular values of a skew matrix come in pairs: |A|_2 <= |A|_F / sqrt(2).
                let bound = (norm(self.a.as_ref()) * std::f64::consts::FRAC_1_SQRT_2)
                    .min(column_sum_norm(&self.a));
                if bound > LARGE {
                    self.by_schur_form(out)?;
                } else {
                    self.by_series(out, bound);
                }
            }
        }
        Ok(())
    }

    fn by_series(&mut self, mut out: MatMut<'_, f64>, bound: f64) {
        let largest = DEGREES[DEGREES.len() - 1];
        let (degree, squarings) = match DEGREES.iter().find(|(_, limit)| bound <= *limit) {
            Some((degree, _)) => (*degree, 0),
            None => (largest.0, (bound / largest.1).log2().ceil() as i32),
        };
        scale(&mut self.a, 0.5_f64.powi(squarings));
        self.even_and_odd(degree);
        mul_into(&mut out, 1.0, &self.a, &self.odd);
        axpy(&mut out, 1.0, &self.even);
        for _ in 0..squarings {
            self.work.copy_from(out.as_ref());
            mul_into(&mut out, 1.0, &self.work, &self.work);
        }
        // Each squaring doubles the orthogonality defect; one Newton-Schulz step toward the polar factor
        // squares it instead.
        if squarings >= 2 {
            self.newton_schulz(out);
        }
    }

    /// `even = sum B^j / (2j)!`, `odd = sum B^j / (2j+1)!` up to the given degree, `B = A^2`.
    fn even_and_odd(&mut self, degree: usize) {
        let [b1, b2, b3] = &mut self.powers;
        mul_into(&mut *b1, 1.0, &self.a, &self.a);
        mul_into(&mut *b2, 1.0, &*b1, &*b1);
        mul_into(&mut *b3, 1.0, &*b2, &*b1);
        for (part, coefficients) in [(&mut self.even, &EVEN), (&mut self.odd, &ODD)] {
            // Horner in B^3: the innermost group also carries the top power c_degree B^3.
            let mut group = degree - 3;
            group_into(part.as_mut(), coefficients, group, [b1, b2]);
            axpy(&mut *part, coefficients[degree], &*b3);
            while group > 0 {
                group -= 3;
                self.work.copy_from(part.as_ref());
                group_into(part.as_mut(), coefficients, group, [b1, b2]);
                mul_add(&mut *part, 1.0, &*b3, &self.work);
            }
        }
    }

    /// `Q <- Q (3 I - Q^T Q) / 2`.
    fn newton_schulz(&mut self, mut out: MatMut<'_, f64>) {
        self.work.copy_from(out.as_ref());
        mul_into(&mut self.even, -0.5, self.work.transpose(), &self.work);
        for i in 0..self.m {
            self.even[(i, i)] += 1.5;
        }
        mul_into(&mut out, 1.0, &self.work, &self.even);
    }

    fn by_schur_form(&mut self, out: MatMut<'_, f64>) -> Result<()> {
        let m = self.m;
        let schur = self.schur.get_or_insert_with(|| SkewSchur::new(m));
        schur.compute(self.a.as_ref())?;
        let v = schur.basis();
        for (l, theta) in schur.angles().iter().enumerate() {
            let (sin, cos) = theta.sin_cos();
            for i in 0..m {
                let (x, y) = (v[(i, 2 * l)], v[(i, 2 * l + 1)]);
                self.work[(i, 2 * l)] = cos * x + sin * y;
                self.work[(i, 2 * l + 1)] = cos * y - sin * x;
            }
        }
        if m % 2 == 1 {
            for i in 0..m {
                self.work[(i, m - 1)] = v[(i, m - 1)];
            }
        }
        mul_into(out, 1.0, &self.work, v.transpose());
        Ok(())
    }
}

/// `part = c_g I + c_{g+1} B + c_{g+2} B^2`.
fn group_into(
    mut part: MatMut<'_, f64>,
    coefficients: &[f64; 10],
    group: usize,
    [b1, b2]: [&Mat<f64>; 2],
) {
    for j in 0..part.ncols() {
        for i in 0..part.nrows() {
            part[(i, j)] =
                coefficients[group + 1] * b1[(i, j)] + coefficients[group + 2] * b2[(i, j)];
        }
        part[(j, j)] += coefficients[group];
    }
}

fn column_sum_norm(a: &Mat<f64>) -> f64 {
    let sum = |j: usize| (0..a.nrows()).map(|i| a[(i, j)].abs()).sum::<f64>();
    (0..a.ncols()).map(sum).fold(0.0, f64::max)
}

fn check_angle(angle: f64) -> Result<()> {
    if angle.is_finite() {
        Ok(())
    } else {
        Err(Error::Overflow {
            quantity: EXPONENTIAL,
        })
    }
}

fn plane_rotation(mut out: MatMut<'_, f64>, angle: f64) -> Result<()> {
    check_angle(angle)?;
    let (sin, cos) = angle.sin_cos();
    out[(0, 0)] = cos;
    out[(1, 0)] = sin;
    out[(0, 1)] = -sin;
    out[(1, 1)] = cos;
    Ok(())
}

/// Rotation about `omega` by the angle `|omega|`.
///
/// ```math
/// R = \cos\theta\, I + \sin\theta\, \hat u + (1 - \cos\theta)\, u u^T,\qquad \theta = |\omega|,\ u = \omega/\theta
/// ```
fn rodrigues(mut out: MatMut<'_, f64>, omega: [f64; 3]) -> Result<()> {
    let largest = omega.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
    let mut u = omega.map(|x| if largest > 0.0 { x / largest } else { 0.0 });
    let length = u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let theta = largest * length;
    check_angle(theta)?;
    if length > 0.0 {
        u = u.map(|x| x / length);
    }
    let (sin, cos) = theta.sin_cos();
    let half = (0.5 * theta).sin();
    let versine = 2.0 * half * half;
    for j in 0..3 {
        for i in 0..3 {
            out[(i, j)] = versine * u[i] * u[j];
        }
        out[(j, j)] += cos;
        let (next, last) = ((j + 1) % 3, (j + 2) % 3);
        out[(next, j)] += sin * u[last];
        out[(last, j)] -= sin * u[next];
    }
    Ok(())
}
