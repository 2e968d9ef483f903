//! Principal logarithm of a unitary matrix: skew-Hermitian, with angles in `(-pi, pi]`.
//!
//! | size | algorithm |
//! |---|---|
//! | 1, 2 | the argument; the arguments of the determinant and of a rotation of SU(2) |
//! | all angles below 0.03 | series of the inverse hyperbolic sine of `(U - U^H)/2`: relative accuracy for the smallest angles |
//! | any other | eigenproblem of the Hermitian `(e^{-ia} U + e^{ia} U^H)/2`; within each group of equal eigenvalues the one of `(e^{-ia} U - e^{ia} U^H)/2i`; one Newton correction in that basis |
//!
//! The two Hermitian matrices commute and have the eigenvalues `cos(t - a)` and `sin(t - a)` for the angles `t`. The
//! direction `a` is not a rational multiple of pi, so that angles of opposite sign and roots of unity have different
//! cosines.
//!
//! General complex eigenvectors are not used, since they are not orthogonal if angles repeat. Every basis here is
//! unitary to round-off by construction.
//!
//! # Source
//! Commuting Hermitian parts: Goldstine, Horwitz (1959), J. ACM 6, 176-195. The correction is the one of
//! [`super::orthogonal_log()`].

use std::f64::consts::PI;

use faer::linalg::matmul::matmul;
use faer::prelude::*;
use faer::{Accum, Mat, MatMut, MatRef, Par, c64};

use super::asinh_series::{NEAR_IDENTITY, asinh_series};
use super::complex_square::{ComplexSquare, Scratch};
use super::decomp::SymmetricEigen;
use super::orthogonal_log::{GROUP_GAP, ORTHOGONALITY_TOLERANCE, pi_tolerance};
use super::square::Symmetry;
use super::structure::{check_finite_entries, check_shape, check_square};
use crate::error::{Error, Result};

/// The direction `a` in radians.
const DIRECTION: f64 = 0.7;

/// If the difference of two angles is within this of 2 pi, the derivative of the logarithm is singular. The cosines of
/// the two angles are as far apart as the angles on the circle, so the eigenvectors need no correction.
const NEAR_TWO_PI: f64 = 1e-4;

/// A matrix whose distance from unitarity, relative to the square root of its size, exceeds this is replaced by the
/// nearest unitary one.
const ROUND_OFF: f64 = 1e-14;

/// Principal logarithm of a unitary matrix: the skew-Hermitian `L` with `e^L = Q` and all angles in `(-pi, pi]`.
///
/// ```math
/// L = \log Q,\qquad e^L = Q,\quad L^H = -L,\quad -\pi < \lambda(-iL) \le \pi
/// ```
///
/// It exists for every unitary matrix: on the eigenspace of -1 it is `i pi`. The angles `pi` and `-pi` are equal to
/// working precision; angles closer to `-pi` than `4 m eps` are treated as `pi`.
///
/// # Arguments
/// * `q` - unitary, shape `(m, m)`, `|Q^H Q - I|_F <= ORTHOGONALITY_TOLERANCE`
/// # Accuracy
/// Backward error `|e^L - Q|_2` at most `2 m * 1e-15`, including repeated and clustered angles and angles near pi;
/// relative to `|L|` the error is a few `m eps` if all angles are below 0.03. Asserted in `tests/complex_linalg/`. For
/// a matrix with `|Q^H Q - I|_F = d` the result is the logarithm of the nearest unitary matrix, up to `d^2`.
/// # Errors
/// `Shape`, `NonFinite`, `NotUnitary`; `Decomposition`.
/// # Source
/// See the module documentation.
///
/// # Examples
/// ```
/// use faer::{c64, mat};
/// use stiefel_rs::unitary_log;
/// // The exchange of two coordinates has the eigenvalues 1 and -1.
/// let (zero, one) = (c64::new(0.0, 0.0), c64::new(1.0, 0.0));
/// let log = unitary_log(mat![[zero, one], [one, zero]].as_ref())?;
/// let half = c64::new(0.0, std::f64::consts::FRAC_PI_2);
/// assert!((log - mat![[half, -half], [-half, half]]).norm_l2() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn unitary_log(q: MatRef<'_, c64>) -> Result<Mat<c64>> {
    let m = check_square("Q", q)?;
    let mut out = Mat::zeros(m, m);
    UnitaryLog::new(m).checked_into(out.as_mut(), q)?;
    Ok(out)
}

/// Buffers for logarithms of one size; calls do not allocate.
///
/// # Examples
/// ```
/// use faer::{Mat, c64, mat};
/// use stiefel_rs::linalg::UnitaryLog;
/// let (mut log, mut out) = (UnitaryLog::new(1), Mat::zeros(1, 1));
/// for angle in [0.0_f64, 1.0, -3.0] {
///     let phase = mat![[c64::new(angle.cos(), angle.sin())]];
///     log.checked_into(out.as_mut(), phase.as_ref())?;
///     assert!((out[(0, 0)] - c64::new(0.0, angle)).norm() < 1e-15);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct UnitaryLog {
    m: usize,
    general: Option<Box<GeneralUnitary>>,
}

impl UnitaryLog {
    /// Buffers for `m x m` matrices.
    pub fn new(m: usize) -> Self {
        UnitaryLog {
            m,
            general: (m > 2).then(|| Box::new(GeneralUnitary::new(m))),
        }
    }

    /// `out = log(Q)` with the checks of [`unitary_log`]; `q` and `out` have the size given to [`UnitaryLog::new`].
    ///
    /// # Errors
    /// As [`unitary_log`].
    pub fn checked_into(&mut self, out: MatMut<'_, c64>, q: MatRef<'_, c64>) -> Result<()> {
        check_shape("Q", q, self.m, self.m)?;
        check_shape("out", out.as_ref(), self.m, self.m)?;
        match &mut self.general {
            // log Q = (log Q^T)^T, so that both are read and written along their columns.
            Some(general) if out.row_stride() != 1 && out.col_stride() == 1 => {
                general.log_into(out.transpose_mut(), q.transpose())
            }
            Some(general) => general.log_into(out, q),
            None => small_log(out, q),
        }
    }
}

/// Return `NonFinite` or `NotUnitary` unless the defect is within the tolerance.
fn check_unitary(u: MatRef<'_, c64>, defect: f64) -> Result<()> {
    // NaN fails as well.
    if defect <= ORTHOGONALITY_TOLERANCE {
        return Ok(());
    }
    check_finite_entries("Q", u)?;
    Err(Error::NotUnitary {
        name: "Q",
        // Overflowing products of both signs sum to NaN.
        defect: if defect.is_nan() {
            f64::INFINITY
        } else {
            defect
        },
        tolerance: ORTHOGONALITY_TOLERANCE,
    })
}

/// For at most two rows.
fn small_log(mut out: MatMut<'_, c64>, u: MatRef<'_, c64>) -> Result<()> {
    let m = u.nrows();
    let mut squares = 0.0;
    for j in 0..m {
        for i in 0..m {
            let entry: c64 = (0..m).map(|l| u[(l, i)].conj() * u[(l, j)]).sum();
            let unit = if i == j { 1.0 } else { 0.0 };
            squares += (entry - unit).norm_sqr();
        }
    }
    check_unitary(u, squares.sqrt())?;
    match m {
        0 => {}
        1 => {
            let x = u[(0, 0)];
            out[(0, 0)] = c64::new(0.0, principal(x.im.atan2(x.re), 1));
        }
        _ => log_two(out, u),
    }
    Ok(())
}

/// The equivalent angle of at most pi, and above -pi by more than round-off.
fn principal(angle: f64, m: usize) -> f64 {
    let angle = if angle > PI { angle - 2.0 * PI } else { angle };
    // From -2 pi on.
    if angle + PI <= pi_tolerance(m) {
        PI.min(angle + 2.0 * PI)
    } else {
        angle
    }
}

struct GeneralUnitary {
    /// The matrix, then its skew part, then the logarithm in the basis.
    matrix: ComplexSquare,
    /// The matrix in the basis.
    turned: ComplexSquare,
    basis: ComplexSquare,
    work: ComplexSquare,
    scratch: Scratch,
    /// The Hermitian matrix, in column-major order.
    hermitian: Mat<c64>,
    eigen: SymmetricEigen<c64>,
    /// Eigenvectors within groups.
    inner: Option<SymmetricEigen<c64>>,
    angles: Vec<f64>,
    cos_sin: Vec<(f64, f64)>,
    /// Cosines and sines of half the angles.
    half_cos_sin: Vec<(f64, f64)>,
}

impl GeneralUnitary {
    fn new(m: usize) -> Self {
        let square = || ComplexSquare::new(m);
        GeneralUnitary {
            matrix: square(),
            turned: square(),
            basis: square(),
            work: square(),
            scratch: Scratch::new(m),
            hermitian: Mat::zeros(m, m),
            eigen: SymmetricEigen::new(m),
            inner: None,
            angles: vec![0.0; m],
            cos_sin: vec![(1.0, 0.0); m],
            half_cos_sin: vec![(1.0, 0.0); m],
        }
    }

    fn log_into(&mut self, out: MatMut<'_, c64>, u: MatRef<'_, c64>) -> Result<()> {
        let m = u.nrows();
        self.matrix.read(u);
        let defect = self.unitarity_defect(m);
        check_unitary(u, defect)?;
        if defect > ROUND_OFF * (m as f64).sqrt() {
            self.replace_by_nearest();
        }
        let real = &self.matrix.parts[0];
        if (0..m).map(|i| 1.0 - real.col(i)[i]).sum::<f64>() < NEAR_IDENTITY {
            self.by_series(out);
            return Ok(());
        }
        self.diagonalise()?;
        self.correct();
        self.assemble(out);
        Ok(())
    }

    /// `|U^H U - I|_F`; stores `U^H U - I` in `work`, the half below the diagonal.
    fn unitarity_defect(&mut self, m: usize) -> f64 {
        let (gram, u) = (&mut self.work, &self.matrix);
        gram.set_product(
            Accum::Replace,
            1.0,
            u.adjoint(),
            u.factor(),
            &mut self.scratch,
        );
        gram.parts[0].add_to_diagonal(-1.0);
        let mut sum = 0.0;
        for part in &gram.parts {
            for j in 0..m {
                let column = &part.col(j)[j..];
                let below: f64 = column[1..].iter().map(|x| x * x).sum();
                sum += column[0] * column[0] + 2.0 * below;
            }
        }
        sum.sqrt()
    }

    /// `U <- U (I - (U^H U - I) / 2)`, which squares the defect.
    fn replace_by_nearest(&mut self) {
        self.work.reflect_product(Symmetry::Symmetric);
        let (half, scratch) = (-0.5, &mut self.scratch);
        let (u, defect) = (self.matrix.factor(), self.work.factor());
        self.basis
            .multiply(Accum::Replace, half, u, defect, scratch);
        for (u, change) in self.matrix.parts.iter_mut().zip(&self.basis.parts) {
            let entries = u.lanes_mut().as_flattened_mut().iter_mut();
            for (x, change) in entries.zip(change.lanes().as_flattened()) {
                *x += change;
            }
        }
    }

    /// `L = asinh(K)` of the skew part `K = sinh(L)`.
    fn by_series(&mut self, out: MatMut<'_, c64>) {
        self.work.set_skew_part_of(&self.matrix);
        let buffers = [&mut self.turned, &mut self.basis, &mut self.matrix];
        asinh_series(&self.work, buffers, &mut self.scratch, out);
    }

    /// A unitary basis in which the matrix is diagonal up to round-off and within groups, and the angles.
    fn diagonalise(&mut self) -> Result<()> {
        let m = self.angles.len();
        let (sin, cos) = DIRECTION.sin_cos();
        for j in 0..m {
            for i in j..m {
                let (x, y) = (self.matrix.get(i, j), self.matrix.get(j, i));
                // (e^{-ia} x + e^{ia} conj(y)) / 2
                self.hermitian[(i, j)] = c64::new(
                    0.5 * (cos * (x.re + y.re) + sin * (x.im + y.im)),
                    0.5 * (cos * (x.im - y.im) - sin * (x.re - y.re)),
                );
            }
        }
        self.eigen.compute(self.hermitian.as_ref())?;
        self.basis.read(self.eigen.vectors());
        self.turn();
        if self.separate_groups()? {
            self.turn();
        }
        for (j, angle) in self.angles.iter_mut().enumerate() {
            let x = self.turned.get(j, j);
            *angle = principal(x.im.atan2(x.re), m);
        }
        Ok(())
    }

    /// `turned = B^H U B`.
    fn turn(&mut self) {
        let (b, u, scratch) = (&self.basis, self.matrix.factor(), &mut self.scratch);
        self.work
            .multiply(Accum::Replace, 1.0, u, b.factor(), scratch);
        let right = self.work.factor();
        self.turned
            .multiply(Accum::Replace, 1.0, b.adjoint(), right, scratch);
    }

    /// Rotates the basis within each group of equal eigenvalues to eigenvectors of the other Hermitian matrix; returns
    /// whether anything changed.
    fn separate_groups(&mut self) -> Result<bool> {
        let m = self.angles.len();
        let (mut start, mut changed) = (0, false);
        while start < m {
            let mut end = start + 1;
            while end < m && self.eigen.value(end) - self.eigen.value(end - 1) <= GROUP_GAP {
                end += 1;
            }
            if end > start + 1 && !self.is_diagonal(start, end) {
                self.separate(start, end)?;
                changed = true;
            }
            start = end;
        }
        Ok(changed)
    }

    /// Whether a block of the matrix in the basis is diagonal to round-off.
    fn is_diagonal(&self, start: usize, end: usize) -> bool {
        let size = |i, j| self.turned.get(i, j).norm_sqr();
        let entries = |j| {
            (start..end)
                .filter(move |i| *i != j)
                .map(move |i| size(i, j))
        };
        let sum: f64 = (start..end).flat_map(entries).sum();
        sum.sqrt() <= pi_tolerance(end - start)
    }

    fn separate(&mut self, start: usize, end: usize) -> Result<()> {
        let (m, size) = (self.angles.len(), end - start);
        let (sin, cos) = DIRECTION.sin_cos();
        let mut block = self.hermitian.as_mut().submatrix_mut(0, 0, size, size);
        for j in 0..size {
            for i in j..size {
                let x = self.turned.get(start + i, start + j);
                let y = self.turned.get(start + j, start + i);
                // (e^{-ia} x - e^{ia} conj(y)) / 2i
                block[(i, j)] = c64::new(
                    0.5 * (cos * (x.im + y.im) - sin * (x.re + y.re)),
                    -0.5 * (cos * (x.re - y.re) + sin * (x.im - y.im)),
                );
            }
        }
        let inner = self.inner.get_or_insert_with(|| SymmetricEigen::new(m));
        inner.compute(block.as_ref())?;
        let mut target = self.hermitian.as_mut().submatrix_mut(0, 0, m, size);
        let (all, one) = (self.eigen.vectors(), c64::new(1.0, 0.0));
        let vectors = all.submatrix(0, start, m, size);
        matmul(
            target.rb_mut(),
            Accum::Replace,
            vectors,
            inner.vectors(),
            one,
            Par::Seq,
        );
        for j in 0..size {
            for i in 0..m {
                self.basis.set(i, start + j, target[(i, j)]);
            }
        }
        Ok(())
    }

    /// In the basis: `L = L_0 + f(ad_{L_0}) skew(E)` with `I + E = e^{-L_0} U` and `f(x) = x / (1 - e^{-x})`; the result
    /// in `matrix`.
    fn correct(&mut self) {
        let m = self.angles.len();
        for (l, theta) in self.angles.iter().enumerate() {
            let ((sin, cos), (half_sin, half_cos)) = (theta.sin_cos(), (0.5 * theta).sin_cos());
            (self.cos_sin[l], self.half_cos_sin[l]) = ((cos, sin), (half_cos, half_sin));
        }
        let (turned, angles) = (&self.turned, &self.angles);
        // The rows of e^{-L_0} U.
        let error = |i: usize, j: usize| {
            let (cos, sin) = self.cos_sin[i];
            c64::new(cos, -sin) * turned.get(i, j)
        };
        for j in 0..m {
            let angle = PI.min(angles[j] + error(j, j).im);
            self.matrix.set(j, j, c64::new(0.0, angle));
            let (cos, sin) = self.half_cos_sin[j];
            for i in j + 1..m {
                let half = 0.5 * (angles[i] - angles[j]);
                let (half_cos, half_sin) = self.half_cos_sin[i];
                let real = if half.abs() < 1e-4 {
                    1.0 - half * half / 3.0
                } else {
                    half * (half_cos * cos + half_sin * sin) / (half_sin * cos - half_cos * sin)
                };
                let factor = if PI - half.abs() < 0.5 * NEAR_TWO_PI {
                    c64::new(0.0, 0.0)
                } else {
                    c64::new(real, half)
                };
                let x = factor * (error(i, j) - error(j, i).conj()) * 0.5;
                self.matrix.set(i, j, x);
                self.matrix.set(j, i, -x.conj());
            }
        }
    }

    /// `out = B L B^H`, of which only the half below the diagonal is computed.
    fn assemble(&mut self, out: MatMut<'_, c64>) {
        let (b, l, scratch) = (&self.basis, self.matrix.factor(), &mut self.scratch);
        self.turned
            .multiply(Accum::Replace, 1.0, b.factor(), l, scratch);
        let left = self.turned.factor();
        self.work
            .set_product(Accum::Replace, 1.0, left, b.adjoint(), scratch);
        self.work.reflect(Symmetry::Skew);
        self.work.write(out);
    }
}

/// The determinant is `e^{2i phi}`, and `e^{-i phi} U` is a multiple of a rotation in SU(2). If `U` is only nearly
/// unitary, this rotation is its polar factor.
fn log_two(mut out: MatMut<'_, c64>, u: MatRef<'_, c64>) {
    let determinant = u[(0, 0)] * u[(1, 1)] - u[(0, 1)] * u[(1, 0)];
    let mean = 0.5 * determinant.im.atan2(determinant.re);
    let back = c64::new(mean.cos(), -mean.sin());
    let (first, last) = (back * u[(0, 0)], back * u[(1, 1)]);
    let below = 0.5 * (back * u[(1, 0)] - (back * u[(0, 1)]).conj());
    let (cos, z) = (0.5 * (first.re + last.re), 0.5 * (first.im - last.im));
    let sin = z.hypot(below.re).hypot(below.im);
    let radius = sin.atan2(cos);
    let (high, low) = (principal(mean + radius, 2), principal(mean - radius, 2));
    let factor = if sin > 0.0 {
        0.5 * (high - low) / sin
    } else {
        0.0
    };
    let centre = 0.5 * (high + low);
    out[(0, 0)] = c64::new(0.0, centre + factor * z);
    out[(1, 1)] = c64::new(0.0, centre - factor * z);
    out[(1, 0)] = below * factor;
    out[(0, 1)] = -out[(1, 0)].conj();
}
