//! Exponential of skew-symmetric and skew-Hermitian matrices, which is a rotation or a unitary matrix to round-off.
//!
//! The table is for real matrices. Complex matrices use the same polynomials, in the Hermitian `A^2`; they have closed
//! forms for one and two rows, and the Hermitian eigenproblem of `-i A` is used for large norms
//! (`skew_hermitian_exp.rs`).
//!
//! | size | algorithm |
//! |---|---|
//! | 1, 2 | 1; a plane rotation |
//! | 3 | Rodrigues' formula |
//! | any, moderate norm | `e^A = C(A^2) + A S(A^2)`: near-best polynomials of degree 1 to 8 in the symmetric `A^2`, by Paterson-Stockmeyer, 2 to 7 products of which only half is computed, then squaring; no linear system is solved |
//! | any, large norm | real Schur form ([`SkewSchur`]): the cost does not grow with the norm |
//!
//! The degree follows from bounds on `|A|_2` by norms of `A`, `A^2` and `A^4`. Every product except the squarings is
//! symmetric or skew, since all factors are polynomials in `A`; from size 80 on only the half below the diagonal is
//! computed. `docs/development/rejected_alternatives.md` lists what was tried.
//!
//! # Source
//! Evaluation: Paterson, Stockmeyer (1973), SIAM J. Comput. 2, 60-66. Polynomials fitted to the imaginary axis: Bader,
//! Blanes, Seydaoglu (2015), SIAM J. Matrix Anal. Appl. 36, 594-613. Bounds by powers: Al-Mohy, Higham (2009), SIAM J.
//! Matrix Anal. Appl. 31, 970-989.
//! Even and odd parts: Higham (2008), "Functions of Matrices", section 12.4. Newton-Schulz: section 8.3.

use std::f64::consts::FRAC_1_SQRT_2;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::exp_polynomials::{SCHEMES, Scheme, combine, combine_in_place, last_scheme};
use super::scalar::{Entry, Scalar, SquareBuffer};
use super::skew_schur::SkewSchur;
use super::square::{Square, Symmetry};
use super::structure::{
    SAFE_SQUARES, check_finite, check_range, check_shape, check_square, norm, skew_defect,
};
use crate::error::{Error, Result};

/// Allowed defect of a skew-symmetric argument, relative to its norm; the symmetric part is dropped.
pub const SKEW_TOLERANCE: f64 = 1e-12;

/// Quantity named in `Overflow` errors.
const EXPONENTIAL: &str = "exponential of a skew matrix";

/// Size from which products are so much faster than the steps of the Schur form that more squarings pay off.
const BLOCKED: usize = 64;

/// Exponential of a skew-symmetric (`f64`) or skew-Hermitian (`c64`) matrix.
///
/// ```math
/// e^A = \sum_{j \ge 0} A^j / j!,\qquad A^H = -A
/// ```
///
/// # Arguments
/// * `a` - skew-symmetric or skew-Hermitian, shape `(m, m)`, `m >= 1`
/// # Accuracy
/// Orthogonality defect (spectral) at most `m * 1e-15` for every norm; backward error a small multiple of `m eps |A|`.
/// Asserted in `tests/skew_exp.rs` and `tests/complex_linalg/`.
/// # Errors
/// `Shape`, `NonFinite`, `NotSkew` or `NotSkewHermitian` (relative defect above [`SKEW_TOLERANCE`]); `Overflow` if an
/// angle is too large for a floating-point number; `Decomposition` (large norms only).
/// # Source
/// See the module documentation.
///
/// # Examples
/// ```
/// use faer::{c64, mat};
/// use stiefel_rs::skew_exp;
/// let half_turn = skew_exp(mat![[0.0, -std::f64::consts::PI], [std::f64::consts::PI, 0.0]].as_ref())?;
/// assert!((half_turn - mat![[-1.0, 0.0], [0.0, -1.0]]).norm_l2() < 1e-15);
/// // i t times the exchange of two coordinates.
/// let (zero, it) = (c64::new(0.0, 0.0), c64::new(0.0, 0.3));
/// let u = skew_exp(mat![[zero, it], [it, zero]].as_ref())?;
/// assert!((u[(0, 1)] - c64::new(0.0, 0.3_f64.sin())).norm() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn skew_exp<T: Scalar>(a: MatRef<'_, T>) -> Result<Mat<T>> {
    let m = check_square("A", a)?;
    let mut out = Mat::zeros(m, m);
    SkewExp::new(m).checked_into(out.as_mut(), a)?;
    Ok(out)
}

/// Return `NotSkew` (`NotSkewHermitian`) unless `|A + A^H|_F / 2 <= SKEW_TOLERANCE |A|_F`.
pub(crate) fn check_skew<T: Scalar>(name: &'static str, a: MatRef<'_, T>) -> Result<()> {
    let (defect, tolerance) = (T::skew_defect(a), SKEW_TOLERANCE * T::norm(a));
    if defect > tolerance {
        Err(T::not_skew(name, defect, tolerance))
    } else {
        Ok(())
    }
}

/// Buffers for exponentials of one size; calls do not allocate once each branch has been used.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::linalg::SkewExp;
/// let a = mat![[0.0, -1.0], [1.0, 0.0]];
/// let (mut exp, mut out) = (SkewExp::new(2), Mat::zeros(2, 2));
/// for t in [0.0_f64, 1.0, 100.0] {
///     exp.exp_into(out.as_mut(), a.as_ref(), t)?;
///     assert!((&out - mat![[t.cos(), -t.sin()], [t.sin(), t.cos()]]).norm_l2() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct SkewExp<T: Scalar = f64> {
    m: usize,
    a: T::Square,
    /// `B, B^2, ..` with `B = A^2`, up to the largest degree needed so far.
    powers: Vec<T::Square>,
    even: T::Square,
    odd: T::Square,
    scratch: <T::Square as SquareBuffer>::Scratch,
    spectrum: Option<T::Spectrum>,
}

impl<T: Scalar> SkewExp<T> {
    /// Buffers for `m x m` matrices.
    pub fn new(m: usize) -> Self {
        let size = if m <= T::CLOSED_FORM { 0 } else { m };
        SkewExp {
            m,
            a: T::Square::zeros(size),
            powers: Vec::new(),
            even: T::Square::zeros(size),
            odd: T::Square::zeros(size),
            scratch: T::Square::scratch(size),
            spectrum: None,
        }
    }

    /// `out = e^{tA}`; only the skew part of `a` matters. `a` and `t` must be finite.
    ///
    /// # Errors
    /// `Overflow` if an angle is too large for a floating-point number; `Decomposition` (large norms only).
    pub fn exp_into(&mut self, out: MatMut<'_, T>, a: MatRef<'_, T>, t: f64) -> Result<()> {
        debug_assert!(
            a.nrows() == self.m
                && a.ncols() == self.m
                && out.nrows() == self.m
                && out.ncols() == self.m
        );
        if self.m <= T::CLOSED_FORM {
            T::exp_closed(out, a, t)
        } else if out.row_stride() != 1 && out.col_stride() == 1 {
            // e^A = (e^{A^T})^T, so that both are read and written along their columns.
            self.general_into(out.transpose_mut(), a.transpose(), None, t)
        } else {
            self.general_into(out, a, None, t)
        }
    }

    /// `out = e^A` with the checks of [`skew_exp`]; `a` and `out` have the size given to [`SkewExp::new`].
    ///
    /// # Errors
    /// As [`skew_exp`].
    pub fn checked_into(&mut self, out: MatMut<'_, T>, a: MatRef<'_, T>) -> Result<()> {
        check_shape("A", a, self.m, self.m)?;
        if self.m <= T::CLOSED_FORM {
            T::check_finite("A", a)?;
            check_skew("A", a)?;
            return self.exp_into(out, a, 1.0);
        }
        if out.row_stride() != 1 && out.col_stride() == 1 {
            self.general_into(out.transpose_mut(), a.transpose(), Some("A"), 1.0)
        } else {
            self.general_into(out, a, Some("A"), 1.0)
        }
    }

    /// `out = e^{tA}`; if a name is given, `a` is checked, and errors use that name.
    fn general_into(
        &mut self,
        out: MatMut<'_, T>,
        a: MatRef<'_, T>,
        name: Option<&'static str>,
        t: f64,
    ) -> Result<()> {
        let symmetric = self.a.read_skew_part(t, a).sqrt();
        let (column_sum, frobenius) = self.a.sizes();
        if let Some(name) = name {
            // NaN fails as well; if squares overflow or underflow, the slow checks decide.
            let plain = SAFE_SQUARES.contains(&(frobenius * frobenius))
                && symmetric <= SKEW_TOLERANCE * frobenius;
            if !plain {
                T::check_finite(name, a)?;
                check_skew(name, a)?;
            }
        }
        if !frobenius.is_finite() {
            for part in self.a.parts() {
                check_range(EXPONENTIAL, part.view())?;
            }
        }
        let mut bound = column_sum.min(frobenius * T::FROBENIUS);
        let switch =
            last_scheme().limit * 2.0_f64.powi(T::SQUARINGS[usize::from(self.m >= BLOCKED)]);
        // The bound from powers is smaller by at most this factor.
        if bound <= switch * (self.m as f64).sqrt() {
            self.power(1);
            bound = self.bound_by_power(bound, 1);
            if bound > SCHEMES[0].limit {
                self.power(2);
                bound = self.bound_by_power(bound, 2);
            }
        }
        if bound > switch {
            T::exp_by_spectrum(&mut self.spectrum, &self.a, &mut self.even, out)
        } else {
            self.by_series(out, bound);
            Ok(())
        }
    }

    /// Computes `B^j`, if the lower powers exist.
    fn power(&mut self, j: usize) {
        if self.powers.len() < j {
            self.powers.push(T::Square::zeros(self.m));
        }
        let (known, new) = self.powers.split_at_mut(j - 1);
        let (left, right) = match j {
            1 => (&self.a, &self.a),
            2 => (&known[0], &known[0]),
            _ => (&known[j - 2], &known[0]),
        };
        new[0].half_product(Accum::Replace, 1.0, left, right, &mut self.scratch);
        new[0].mirror(Symmetry::Symmetric);
    }

    /// A bound on `|A|_2 = |B^j|_2^(1/(2j))` for `j = 1, 2`, from two norms and the known bound.
    fn bound_by_power(&self, known: f64, j: usize) -> f64 {
        let (column_sum, frobenius) = self.powers[j - 1].sizes();
        let mut root = column_sum.min(frobenius * T::FROBENIUS);
        for _ in 0..j {
            root = root.sqrt();
        }
        // Powers that underflow give no information.
        if root > 1e-60 { known.min(root) } else { known }
    }

    fn by_series(&mut self, out: MatMut<'_, T>, bound: f64) {
        let last = last_scheme();
        let scheme = SCHEMES.iter().find(|s| bound <= s.limit).unwrap_or(last);
        let squarings = if bound <= last.limit {
            0
        } else {
            (bound / last.limit).log2().ceil() as i32
        };
        for j in 3..=scheme.powers {
            self.power(j);
        }
        self.even_and_odd(scheme, 0.25_f64.powi(squarings));
        let (odd_part, scratch) = (&mut self.powers[0], &mut self.scratch);
        let factor = 0.5_f64.powi(squarings);
        odd_part.half_product(Accum::Replace, factor, &self.a, &self.odd, scratch);
        self.even.plus_skew(odd_part);
        for _ in 0..squarings {
            self.odd.full_product(1.0, &self.even, &self.even, scratch);
            std::mem::swap(&mut self.even, &mut self.odd);
        }
        // Each squaring doubles the orthogonality defect; one Newton-Schulz step towards the polar factor squares it.
        if squarings >= 2 {
            self.newton_schulz();
        }
        self.even.write_to(out);
    }

    /// Computes `even(B)`, of which only the lower half is defined, and `odd(B)`, with `B = scale A^2`. The powers are
    /// overwritten.
    fn even_and_odd(&mut self, scheme: &Scheme, scale: f64) {
        let (s, degree) = (scheme.powers, scheme.even.len() - 1);
        let (mut even, mut odd, mut factor) = ([0.0; 9], [0.0; 9], 1.0);
        for j in 0..=degree {
            (even[j], odd[j]) = (factor * scheme.even[j], factor * scheme.odd[j]);
            factor *= scale;
        }
        if degree == s {
            combine(&mut self.even, &self.powers[..s], &even);
            combine(&mut self.odd, &self.powers[..s], &odd);
            return;
        }
        // The upper group carries the top coefficient: one multiplication by B^s gives degree 2s.
        combine(&mut self.even, &self.powers[..s], &even[s..]);
        combine(&mut self.odd, &self.powers[..s], &odd[s..]);
        combine_in_place(&mut self.powers[..s - 1], &even, &odd);
        let (low, top) = self.powers.split_at_mut(s - 1);
        let scratch = &mut self.scratch;
        low[0].half_product(Accum::Add, 1.0, &top[0], &self.even, scratch);
        low[1].half_product(Accum::Add, 1.0, &top[0], &self.odd, scratch);
        low[1].mirror(Symmetry::Symmetric);
        std::mem::swap(&mut self.even, &mut low[0]);
        std::mem::swap(&mut self.odd, &mut low[1]);
    }

    /// `Q <- Q (3 I - Q^H Q) / 2`.
    fn newton_schulz(&mut self) {
        let (q, gram, scratch) = (&self.even, &mut self.odd, &mut self.scratch);
        gram.half_gram(-0.5, q, scratch);
        gram.mirror(Symmetry::Symmetric);
        gram.add_to_diagonal(1.5);
        self.powers[0].full_product(1.0, q, gram, scratch);
        std::mem::swap(&mut self.even, &mut self.powers[0]);
    }
}

impl Entry for f64 {
    type Square = Square;
    type Spectrum = SkewSchur;

    const CLOSED_FORM: usize = 3;

    /// The singular values of a real skew matrix come in pairs.
    const FROBENIUS: f64 = FRAC_1_SQRT_2;

    const SQUARINGS: [i32; 2] = [5, 8];

    fn exp_closed(mut out: MatMut<'_, f64>, a: MatRef<'_, f64>, t: f64) -> Result<()> {
        let skew = |i: usize, j: usize| t * (0.5 * a[(i, j)] - 0.5 * a[(j, i)]);
        match a.nrows() {
            0 => {}
            1 => out[(0, 0)] = 1.0,
            2 => plane_rotation(out, skew(1, 0))?,
            _ => rodrigues(out, [skew(2, 1), skew(0, 2), skew(1, 0)])?,
        }
        Ok(())
    }

    fn exp_by_spectrum(
        spectrum: &mut Option<SkewSchur>,
        a: &Square,
        work: &mut Square,
        out: MatMut<'_, f64>,
    ) -> Result<()> {
        let m = a.view().nrows();
        let schur = spectrum.get_or_insert_with(|| SkewSchur::new(m));
        schur.compute(a.view())?;
        work.view_mut().copy_from(schur.basis());
        for (l, theta) in schur.angles().iter().enumerate() {
            let (sin, cos) = theta.sin_cos();
            let (first, second) = work.two_mut(2 * l, 2 * l + 1, m);
            for (x, y) in first.iter_mut().zip(second) {
                (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
            }
        }
        let v = schur.basis().transpose();
        matmul(out, Accum::Replace, work.view(), v, 1.0, Par::Seq);
        Ok(())
    }

    fn not_skew(name: &'static str, defect: f64, tolerance: f64) -> Error {
        Error::NotSkew {
            name,
            defect,
            tolerance,
        }
    }

    fn check_finite(name: &'static str, a: MatRef<'_, f64>) -> Result<()> {
        check_finite(name, a)
    }

    fn norm(a: MatRef<'_, f64>) -> f64 {
        norm(a)
    }

    fn skew_defect(a: MatRef<'_, f64>) -> f64 {
        skew_defect(a)
    }
}

pub(super) fn check_angle(angle: f64) -> Result<()> {
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
