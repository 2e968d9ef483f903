//! Exponential of skew-symmetric matrices: a rotation, orthogonal to round-off.
//!
//! | size | algorithm |
//! |---|---|
//! | 1, 2 | 1; a plane rotation |
//! | 3 | Rodrigues' formula |
//! | any, moderate norm | `e^A = C(A^2) + A S(A^2)`: near-best polynomials of degree 1 to 8 in the symmetric `A^2`, by Paterson-Stockmeyer, 2 to 7 products of which half is formed, then squaring; no linear system is solved |
//! | any, large norm | real Schur form ([`SkewSchur`]): the cost does not grow with the norm |
//!
//! The degree follows from bounds of `|A|_2` by norms of `A`, `A^2` and `A^4`. Every product but the squarings is
//! symmetric or skew, as all factors are polynomials in `A`; from size 80 on only the half below the diagonal is
//! computed. `docs/algorithms.md` says what was tried beside this.
//!
//! # Source
//! Evaluation: Paterson, Stockmeyer (1973), SIAM J. Comput. 2, 60-66. Polynomials fitted to the imaginary axis: Bader,
//! Blanes, Seydaoglu (2015), SIAM J. Matrix Anal. Appl. 36, 594-613. Bounds by powers: Al-Mohy, Higham (2009), SIAM J.
//! Matrix Anal. Appl. 31, 970-989.
//! Even and odd parts: Higham (2008), "Functions of Matrices", section 12.4. Newton-Schulz: section 8.3.

use std::f64::consts::FRAC_1_SQRT_2;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::simd::vectorised;
use super::skew_schur::SkewSchur;
use super::square::{LANES, Square, Symmetry};
use super::structure::{
    SAFE_SQUARES, check_finite, check_range, check_shape, check_square, norm, skew_defect,
};
use crate::error::{Error, Result};

/// A skew-symmetric argument may be off by this much, relative to its norm; the symmetric part is dropped.
pub const SKEW_TOLERANCE: f64 = 1e-12;

/// Polynomials in `B = A^2` for the even and the odd part. Up to degree 4 the powers are all products; above, the
/// coefficients from `powers` on are multiplied by `B^powers` in one Horner step.
struct Scheme {
    /// The largest norm of `A` for which `|cos x - even(-x^2)|` and `|sin x - x odd(-x^2)|` are at most `2^-54`.
    limit: f64,
    powers: usize,
    even: &'static [f64],
    odd: &'static [f64],
}

/// What an `Overflow` is about.
const EXPONENTIAL: &str = "exponential of a skew matrix";

/// Interpolation of `(cos x - 1) / x^2` and `(sin x - x) / x^3` in `x^2` at the Chebyshev points of `[0, limit^2]`:
/// exact at 0, and for the same error a norm up to a third larger than that of the Taylor polynomial.
#[rustfmt::skip]
const SCHEMES: [Scheme; 6] = [
    Scheme { limit: 0.000227, powers: 1,
        even: &[1.0, 0.49999999892647917],
        odd: &[1.0, 0.1666666664519625] },
    Scheme { limit: 0.008261, powers: 2,
        even: &[1.0, 0.4999999999991914, 0.04166657188326635],
        odd: &[1.0, 0.16666666666655117, 0.008333319792844365] },
    Scheme { limit: 0.05388, powers: 3,
        even: &[1.0, 0.499999999999981, 0.041666666549097855, 0.0013887808922722297],
        odd: &[1.0, 0.16666666666666455, 0.008333333320270022, 0.00019840069870945357] },
    Scheme { limit: 0.1741, powers: 4,
        even: &[1.0, 0.49999999999999817, 0.041666666664749, 0.001388888572542734,
        2.4784886881822717e-05],
        odd: &[1.0, 0.1666666666666665, 0.008333333333158988, 0.00019841266965212826,
        2.754213628674306e-06] },
    Scheme { limit: 0.7189, powers: 3,
        even: &[1.0, 0.4999999999999999, 0.04166666666665189, 0.0013888888885553372,
        2.4801584547014487e-05, 2.7556290689001687e-07, 2.06996248830853e-09],
        odd: &[1.0, 0.16666666666666666, 0.008333333333332348, 0.0001984126983904452,
        2.755731738631664e-06, 2.5051422264281525e-08, 1.594089970302928e-10] },
    Scheme { limit: 1.684, powers: 4,
        even: &[1.0, 0.5, 0.04166666666666579, 0.0013888888888824184,
        2.4801587283323645e-05, 2.7557316691423217e-07, 2.0876566164063676e-09, 1.1462770642855358e-11,
        4.605407096549608e-14],
        odd: &[1.0, 0.16666666666666666, 0.008333333333333286, 0.00019841269841235692,
        2.755731921434689e-06, 2.5052107048956896e-08, 1.605894315072643e-10, 7.642956974951286e-13,
        2.7196871475899573e-15] },
];

/// Squarings up to which the series is preferred to the Schur form, for sizes below and from [`BLOCKED`].
const SQUARINGS: [i32; 2] = [5, 8];

/// From this size on a product is so much faster than the steps of the Schur form that more squarings pay.
const BLOCKED: usize = 64;

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
    let mut out = Mat::zeros(m, m);
    SkewExp::new(m).checked_into(out.as_mut(), a)?;
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

/// Buffers for exponentials of one size: no allocation per call once each branch was taken.
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
pub struct SkewExp {
    m: usize,
    a: Square,
    /// `B, B^2, ..` with `B = A^2`, as many as the largest degree so far needed.
    powers: Vec<Square>,
    even: Square,
    odd: Square,
    schur: Option<SkewSchur>,
}

impl SkewExp {
    /// Buffers for `m x m` matrices.
    pub fn new(m: usize) -> Self {
        let size = if m <= 3 { 0 } else { m };
        SkewExp {
            m,
            a: Square::new(size),
            powers: Vec::new(),
            even: Square::new(size),
            odd: Square::new(size),
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
            // e^A = (e^{A^T})^T: then both are read and written along their columns.
            _ if out.row_stride() != 1 && out.col_stride() == 1 => {
                self.general_into(out.transpose_mut(), a.transpose(), None, t)?;
            }
            _ => self.general_into(out, a, None, t)?,
        }
        Ok(())
    }

    /// `out = e^A` after the checks of [`skew_exp`]; `a` and `out` have the size given to [`SkewExp::new`].
    ///
    /// # Errors
    /// As [`skew_exp`].
    pub fn checked_into(&mut self, out: MatMut<'_, f64>, a: MatRef<'_, f64>) -> Result<()> {
        check_shape("A", a, self.m, self.m)?;
        if self.m <= 3 {
            check_finite("A", a)?;
            check_skew("A", a)?;
            return self.exp_into(out, a, 1.0);
        }
        if out.row_stride() != 1 && out.col_stride() == 1 {
            self.general_into(out.transpose_mut(), a.transpose(), Some("A"), 1.0)
        } else {
            self.general_into(out, a, Some("A"), 1.0)
        }
    }

    /// `out = e^{tA}`; with a name, `a` is checked under it.
    fn general_into(
        &mut self,
        out: MatMut<'_, f64>,
        a: MatRef<'_, f64>,
        name: Option<&'static str>,
        t: f64,
    ) -> Result<()> {
        let symmetric = self.a.set_skew_part(t, a).sqrt();
        let (column_sum, frobenius) = self.a.norms();
        if let Some(name) = name {
            // NaN fails as well; where squares overflow or vanish, the slow checks decide.
            let plain = SAFE_SQUARES.contains(&(frobenius * frobenius))
                && symmetric <= SKEW_TOLERANCE * frobenius;
            if !plain {
                check_finite(name, a)?;
                check_skew(name, a)?;
            }
        }
        if !frobenius.is_finite() {
            check_range(EXPONENTIAL, self.a.view())?;
        }
        // The singular values of a skew matrix come in pairs: |A|_2 <= |A|_F / sqrt(2).
        let mut bound = column_sum.min(frobenius * FRAC_1_SQRT_2);
        let switch = last_scheme().limit * 2.0_f64.powi(SQUARINGS[usize::from(self.m >= BLOCKED)]);
        // What the powers tell is at most this much smaller.
        if bound <= switch * (self.m as f64).sqrt() {
            self.power(1);
            bound = self.bound_by_power(bound, 1);
            if bound > SCHEMES[0].limit {
                self.power(2);
                bound = self.bound_by_power(bound, 2);
            }
        }
        if bound > switch {
            self.by_schur_form(out)
        } else {
            self.by_series(out, bound);
            Ok(())
        }
    }

    /// Forms `B^j`, where the powers below are there.
    fn power(&mut self, j: usize) {
        if self.powers.len() < j {
            self.powers.push(Square::new(self.m));
        }
        let (known, new) = self.powers.split_at_mut(j - 1);
        let (left, right) = match j {
            1 => (&self.a, &self.a),
            2 => (&known[0], &known[0]),
            _ => (&known[j - 2], &known[0]),
        };
        new[0].set_product(Accum::Replace, 1.0, left.view(), right.view());
        new[0].reflect_product(Symmetry::Symmetric);
    }

    /// `|A|_2 = |B^j|_2^(1/(2j))` for `j = 1, 2`, by two norms that bound it, and the bound known.
    fn bound_by_power(&self, known: f64, j: usize) -> f64 {
        let (column_sum, frobenius) = self.powers[j - 1].norms();
        let mut root = column_sum.min(frobenius * FRAC_1_SQRT_2);
        for _ in 0..j {
            root = root.sqrt();
        }
        // Powers that vanish say nothing.
        if root > 1e-60 { known.min(root) } else { known }
    }

    fn by_series(&mut self, out: MatMut<'_, f64>, bound: f64) {
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
        let scratch = &mut self.powers[0];
        let factor = 0.5_f64.powi(squarings);
        scratch.set_product(Accum::Replace, factor, self.a.view(), self.odd.view());
        self.even.add_skew(scratch);
        for _ in 0..squarings {
            let (from, to) = (self.even.view(), self.odd.view_mut());
            matmul(to, Accum::Replace, from, from, 1.0, Par::Seq);
            std::mem::swap(&mut self.even, &mut self.odd);
        }
        // Each squaring doubles the orthogonality defect; one Newton-Schulz step toward the polar factor
        // squares it instead.
        if squarings >= 2 {
            self.newton_schulz();
        }
        self.even.write(out);
    }

    /// `even(B)`, of which the lower half counts, and `odd(B)`, with `B = scale A^2`. The powers are used up.
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
        low[0].set_product(Accum::Add, 1.0, top[0].view(), self.even.view());
        low[1].set_product(Accum::Add, 1.0, top[0].view(), self.odd.view());
        low[1].reflect_product(Symmetry::Symmetric);
        std::mem::swap(&mut self.even, &mut low[0]);
        std::mem::swap(&mut self.odd, &mut low[1]);
    }

    /// `Q <- Q (3 I - Q^T Q) / 2`.
    fn newton_schulz(&mut self) {
        let (q, gram) = (&self.even, &mut self.odd);
        gram.set_product(Accum::Replace, -0.5, q.view().transpose(), q.view());
        gram.reflect_product(Symmetry::Symmetric);
        gram.add_to_diagonal(1.5);
        let to = self.powers[0].view_mut();
        matmul(to, Accum::Replace, q.view(), gram.view(), 1.0, Par::Seq);
        std::mem::swap(&mut self.even, &mut self.powers[0]);
    }

    fn by_schur_form(&mut self, out: MatMut<'_, f64>) -> Result<()> {
        let m = self.m;
        let schur = self.schur.get_or_insert_with(|| SkewSchur::new(m));
        schur.compute(self.a.view())?;
        self.even.view_mut().copy_from(schur.basis());
        for (l, theta) in schur.angles().iter().enumerate() {
            let (sin, cos) = theta.sin_cos();
            let (first, second) = self.even.two_mut(2 * l, 2 * l + 1, m);
            for (x, y) in first.iter_mut().zip(second) {
                (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
            }
        }
        let v = schur.basis().transpose();
        matmul(out, Accum::Replace, self.even.view(), v, 1.0, Par::Seq);
        Ok(())
    }
}

fn last_scheme() -> &'static Scheme {
    &SCHEMES[SCHEMES.len() - 1]
}

/// `out = c_0 I + c_1 B + c_2 B^2 + ..`, as many terms as powers are given.
fn combine(out: &mut Square, powers: &[Square], c: &[f64]) {
    match powers {
        [b1] => combine_powers(out, [b1], c),
        [b1, b2] => combine_powers(out, [b1, b2], c),
        [b1, b2, b3] => combine_powers(out, [b1, b2, b3], c),
        [b1, b2, b3, b4, ..] => combine_powers(out, [b1, b2, b3, b4], c),
        [] => {}
    }
}

fn combine_powers<const N: usize>(out: &mut Square, powers: [&Square; N], c: &[f64]) {
    let powers = powers.map(Square::lanes);
    let weights: [f64; N] = std::array::from_fn(|j| c[j + 1]);
    let target = out.lanes_mut();
    vectorised(
        #[inline(always)]
        || {
            for (k, sums) in target.iter_mut().enumerate() {
                let terms: [&[f64; LANES]; N] = std::array::from_fn(|j| &powers[j][k]);
                for l in 0..LANES {
                    let mut sum = weights[0] * terms[0][l];
                    for j in 1..N {
                        sum += weights[j] * terms[j][l];
                    }
                    sums[l] = sum;
                }
            }
        },
    );
    out.add_to_diagonal(c[0]);
}

/// The first two of the powers become the two polynomials in all of them (two or three).
fn combine_in_place(powers: &mut [Square], even: &[f64], odd: &[f64]) {
    let (first, rest) = powers.split_at_mut(2);
    let [x, y] = first else { return };
    let (x_lanes, y_lanes) = (x.lanes_mut(), y.lanes_mut());
    let (even, odd) = (&even[..4], &odd[..4]);
    vectorised(
        #[inline(always)]
        || match rest {
            [z, ..] => {
                for ((x, y), z) in x_lanes.iter_mut().zip(y_lanes).zip(z.lanes()) {
                    for l in 0..LANES {
                        let (p, q, r) = (x[l], y[l], z[l]);
                        x[l] = even[1] * p + even[2] * q + even[3] * r;
                        y[l] = odd[1] * p + odd[2] * q + odd[3] * r;
                    }
                }
            }
            [] => {
                for (x, y) in x_lanes.iter_mut().zip(y_lanes) {
                    for l in 0..LANES {
                        let (p, q) = (x[l], y[l]);
                        x[l] = even[1] * p + even[2] * q;
                        y[l] = odd[1] * p + odd[2] * q;
                    }
                }
            }
        },
    );
    x.add_to_diagonal(even[0]);
    y.add_to_diagonal(odd[0]);
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
