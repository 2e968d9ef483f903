//! Principal skew logarithm of a rotation: real and skew, accurate up to angles of pi - 1e-13.
//!
//! | size | algorithm |
//! |---|---|
//! | 1, 2 | 0; the angle of a plane rotation |
//! | 3 | the unit quaternion, largest component first, and `2 atan2(|v|, w)` |
//! | all angles below 0.03 | series of the inverse hyperbolic sine of `(Q - Q^T)/2`: relative accuracy for the smallest rotation |
//! | up to 128, separated sines of the angles | Schur form of the skew part `(Q - Q^T)/2`, cosines from `V^T Q V`; one Newton correction in that basis |
//! | any other | symmetric eigenproblem of `(Q + Q^T)/2`; within each group of equal cosines the Schur form of the skew part; the same correction |
//!
//! The first method costs a singular value decomposition of half the size. If angles are supplementary, equal or zero,
//! their sines are not separated, and the second method is used.
//!
//! Neither a general real Schur form nor complex eigenvectors are used: the iteration for the former does not end for
//! some orthogonal matrices, and the latter are not orthogonal if angles repeat. Every basis here is orthogonal to
//! round-off by construction.

use std::f64::consts::PI;

use faer::linalg::matmul::matmul;
use faer::prelude::*;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::asinh_series::{NEAR_IDENTITY, asinh_series};
use super::decomp::SymmetricEigen;
use super::skew_schur::{SkewSchur, apply_ad_by_planes};
use super::square::{Square, Symmetry};
use super::structure::{check_finite, check_shape, check_square, orthonormality_defect};
use crate::error::{Error, Result};

/// Allowed defect `|Q^T Q - I|_F` of a rotation.
pub const ORTHOGONALITY_TOLERANCE: f64 = 1e-9;

/// Cosines closer than this are treated as one group; wider gaps lose accuracy of `eps / gap`, which the correction
/// restores.
pub(super) const GROUP_GAP: f64 = 1e-7;

/// Size up to which the planes are first computed from the skew part, by a singular value decomposition of half the
/// size; above, the blocked symmetric eigenproblem is faster.
const SINES: usize = 128;

/// Two angles whose sum is within this of 2 pi have cosines closer than `GROUP_GAP` (by at most half its square), so
/// they belong to one group, for which the first result is already accurate to round-off. The derivative of the
/// logarithm is singular there, so the correction skips them.
const NEAR_TWO_PI: f64 = 1e-4;

/// Principal logarithm of a rotation: the skew `L` with `e^L = Q` and all angles below pi.
///
/// ```math
/// L = \log Q,\qquad e^L = Q,\quad L^T = -L,\quad \|L\|_2 < \pi
/// ```
///
/// # Arguments
/// * `q` - orthogonal of determinant +1, shape `(m, m)`, `|Q^T Q - I|_F <= ORTHOGONALITY_TOLERANCE`
/// # Accuracy
/// Backward error `|e^L - Q|_F` at most 1e-13 at `m = 50`, including repeated and clustered angles, angles of `pi -
/// 1e-10` and permutations; relative to `|L|` the error is a few `m eps` if all angles are below 0.03. Asserted in
/// `tests/orthogonal_log/` and, against 60 digits, in `tests/python/test_accuracy.py`. For a matrix with `|Q^T Q - I|_F
/// = d` the result is the logarithm of the nearest rotation, up to `d^2`.
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`; `OutsideLogDomain` for determinant -1 or for an angle equal to pi to working
/// precision (closer than `4 m eps`).
/// # Source
/// Symmetric part and groups: Higham (2008), "Functions of Matrices", section 11; the correction is one Newton step for
/// `e^{-L} Q = I`, with the inverse derivative of the exponential in closed form. Skew Schur form: Ward, Gray (1978).
pub fn orthogonal_log(q: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let m = check_square("Q", q)?;
    let mut out = Mat::zeros(m, m);
    OrthogonalLog::new(m).checked_into(out.as_mut(), q)?;
    Ok(out)
}

/// Buffers for logarithms of one size; calls do not allocate.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::linalg::OrthogonalLog;
/// let (mut log, mut out) = (OrthogonalLog::new(2), Mat::zeros(2, 2));
/// for angle in [0.0_f64, 1.0, -3.0] {
///     let rotation = mat![[angle.cos(), -angle.sin()], [angle.sin(), angle.cos()]];
///     log.checked_into(out.as_mut(), rotation.as_ref())?;
///     assert!((out[(1, 0)] - angle).abs() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct OrthogonalLog {
    m: usize,
    general: Option<Box<GeneralOrthogonal>>,
}

impl OrthogonalLog {
    /// Buffers for `m x m` matrices.
    pub fn new(m: usize) -> Self {
        OrthogonalLog {
            m,
            general: (m > 3).then(|| Box::new(GeneralOrthogonal::new(m))),
        }
    }

    /// `out = log(Q)` with the checks of [`orthogonal_log`]; `q` and `out` have the size given to
    /// [`OrthogonalLog::new`].
    ///
    /// # Errors
    /// As [`orthogonal_log`].
    pub fn checked_into(&mut self, out: MatMut<'_, f64>, q: MatRef<'_, f64>) -> Result<()> {
        check_shape("Q", q, self.m, self.m)?;
        check_finite("Q", q)?;
        let defect = orthonormality_defect(q);
        if defect > ORTHOGONALITY_TOLERANCE {
            return Err(Error::NotOrthonormal {
                name: "Q",
                defect,
                tolerance: ORTHOGONALITY_TOLERANCE,
            });
        }
        self.log_into(out, q)
    }

    /// `out = log(Q)`; `q` must be finite and orthogonal to round-off.
    ///
    /// # Errors
    /// `OutsideLogDomain`, `Decomposition`.
    pub fn log_into(&mut self, out: MatMut<'_, f64>, q: MatRef<'_, f64>) -> Result<()> {
        debug_assert!(
            q.nrows() == self.m
                && q.ncols() == self.m
                && out.nrows() == self.m
                && out.ncols() == self.m
        );
        match (&mut self.general, self.m) {
            // log Q = (log Q^T)^T, so that both are read and written along their columns.
            (Some(general), _) if out.row_stride() != 1 && out.col_stride() == 1 => {
                general.log_into(out.transpose_mut(), q.transpose())
            }
            (Some(general), _) => general.log_into(out, q),
            (None, 3) => log_space(out, q),
            (None, 2) => log_plane(out, q),
            (None, _) => log_line(out, q),
        }
    }
}

/// Angles within this of pi have no reliable plane or sign.
pub(super) fn pi_tolerance(m: usize) -> f64 {
    4.0 * m as f64 * f64::EPSILON
}

fn log_line(mut out: MatMut<'_, f64>, q: MatRef<'_, f64>) -> Result<()> {
    if q.nrows() == 1 {
        if q[(0, 0)] < 0.0 {
            return Err(Error::OutsideLogDomain { angle: PI });
        }
        out[(0, 0)] = 0.0;
    }
    Ok(())
}

fn log_plane(mut out: MatMut<'_, f64>, q: MatRef<'_, f64>) -> Result<()> {
    let determinant = q[(0, 0)] * q[(1, 1)] - q[(0, 1)] * q[(1, 0)];
    let angle = (q[(1, 0)] - q[(0, 1)]).atan2(q[(0, 0)] + q[(1, 1)]);
    if determinant < 0.0 || PI - angle.abs() <= pi_tolerance(2) {
        return Err(Error::OutsideLogDomain {
            angle: if determinant < 0.0 { PI } else { angle.abs() },
        });
    }
    out.fill(0.0);
    out[(1, 0)] = angle;
    out[(0, 1)] = -angle;
    Ok(())
}

/// Computed from the unit quaternion `(w, v)`: four times the products of its components are sums of entries, and the
/// row of the largest component has no cancellation (Shepperd 1978, J. Guidance and Control 1, 223-224).
///
/// For a matrix with defect `d`, the nearest rotation corresponds to the dominant eigenvector of the table of these
/// sums, whose other eigenvalues have size `d` compared with 4 (Bar-Itzhack 2000, J. Guidance, Control and Dynamics 23,
/// 1085-1087): a row has an error of size `d`, the table times the row one of size `d^2`.
fn log_space(mut out: MatMut<'_, f64>, q: MatRef<'_, f64>) -> Result<()> {
    let (a, b, c) = (q[(0, 0)], q[(1, 1)], q[(2, 2)]);
    let determinant_positive = {
        let cofactor = |i: usize, j: usize| {
            let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            q[(i1, j1)] * q[(i2, j2)] - q[(i1, j2)] * q[(i2, j1)]
        };
        (0..3).map(|j| q[(0, j)] * cofactor(0, j)).sum::<f64>() > 0.0
    };
    if !determinant_positive {
        return Err(Error::OutsideLogDomain { angle: PI });
    }
    let (x, y, z) = (
        q[(2, 1)] - q[(1, 2)],
        q[(0, 2)] - q[(2, 0)],
        q[(1, 0)] - q[(0, 1)],
    );
    let (xy, xz, yz) = (
        q[(0, 1)] + q[(1, 0)],
        q[(0, 2)] + q[(2, 0)],
        q[(1, 2)] + q[(2, 1)],
    );
    let rows = [
        [1.0 + a + b + c, x, y, z],
        [x, 1.0 + a - b - c, xy, xz],
        [y, xy, 1.0 - a + b - c, yz],
        [z, xz, yz, 1.0 - a - b + c],
    ];
    let largest = (0..4)
        .max_by(|&i, &j| rows[i][i].total_cmp(&rows[j][j]))
        .unwrap_or(0);
    let row = rows[largest];
    let sign = if row[0] < 0.0 { -1.0 } else { 1.0 };
    let [w, vx, vy, vz] = rows.map(|other| sign * (0..4).map(|i| other[i] * row[i]).sum::<f64>());
    let length = vx.hypot(vy).hypot(vz);
    let angle = 2.0 * length.atan2(w);
    if PI - angle <= pi_tolerance(3) {
        return Err(Error::OutsideLogDomain { angle });
    }
    let factor = if length > 0.0 { angle / length } else { 0.0 };
    out.fill(0.0);
    for (i, j, value) in [(2, 1, vx), (0, 2, vy), (1, 0, vz)] {
        out[(i, j)] = factor * value;
        out[(j, i)] = -factor * value;
    }
    Ok(())
}

struct GeneralOrthogonal {
    /// Skew part of the rotation, later of its correction.
    skew: Square,
    /// The rotation in the basis of its planes.
    turned: Square,
    /// The planes first; for odd sizes the null vector is last.
    basis: Square,
    work: Square,
    schur: SkewSchur,
    eigen: Option<SymmetricEigen>,
    angles: Vec<f64>,
    cos_sin: Vec<(f64, f64)>,
    /// Cosines and sines of half the angles.
    half_cos_sin: Vec<(f64, f64)>,
}

impl GeneralOrthogonal {
    fn new(m: usize) -> Self {
        GeneralOrthogonal {
            skew: Square::new(m),
            turned: Square::new(m),
            basis: Square::new(m),
            work: Square::new(m),
            schur: SkewSchur::new(m),
            eigen: None,
            angles: vec![0.0; m / 2],
            cos_sin: vec![(1.0, 0.0); m / 2],
            half_cos_sin: vec![(1.0, 0.0); m / 2],
        }
    }

    fn log_into(&mut self, out: MatMut<'_, f64>, q: MatRef<'_, f64>) -> Result<()> {
        let m = q.nrows();
        self.skew.set_skew_part(1.0, q);
        if (0..m).map(|i| 1.0 - q[(i, i)]).sum::<f64>() < NEAR_IDENTITY {
            self.skew_part_of_nearest(q);
            self.by_series(out);
            return Ok(());
        }
        if m > SINES || !self.planes_by_sines(q)? {
            self.planes_by_cosines(q)?;
            self.turn(q);
        }
        self.correct();
        self.assemble(out);
        Ok(())
    }

    /// The skew part of the nearest rotation `Q (I - (Q^T Q - I) / 2)`, up to second order in the defect of `Q`: the
    /// series has no correction that would remove the defect.
    fn skew_part_of_nearest(&mut self, q: MatRef<'_, f64>) {
        let m = q.nrows();
        product(self.work.view_mut(), q.transpose(), q);
        for j in 0..m {
            let column = self.work.col_mut(j);
            column[j] -= 1.0;
            column[..m].iter_mut().for_each(|x| *x *= 0.5);
        }
        product(self.turned.view_mut(), q, self.work.view());
        for j in 0..m {
            let column = self.turned.col_mut(j);
            for i in 0..m {
                column[i] = q[(i, j)] - column[i];
            }
        }
        self.skew.set_skew_part(1.0, self.turned.view());
    }

    /// `L = asinh(K)` of the skew part `K = sinh(L)`.
    fn by_series(&mut self, out: MatMut<'_, f64>) {
        let buffers = [&mut self.turned, &mut self.work, &mut self.basis];
        asinh_series(&self.skew, buffers, &mut (), out);
    }

    /// `turned = B^T Q B`.
    fn turn(&mut self, q: MatRef<'_, f64>) {
        let b = self.basis.view();
        product(self.work.view_mut(), q, b);
        product(self.turned.view_mut(), b.transpose(), self.work.view());
    }

    /// Planes from the Schur form of the skew part, if its angles (the sines) are separated from each other and from
    /// zero; otherwise returns `false`.
    fn planes_by_sines(&mut self, q: MatRef<'_, f64>) -> Result<bool> {
        let m = q.nrows();
        self.schur.compute(self.skew.view())?;
        let sines = self.schur.angles();
        let apart = sines.windows(2).all(|pair| pair[0] - pair[1] > GROUP_GAP);
        if !apart || sines.last().is_some_and(|last| *last <= GROUP_GAP) {
            return Ok(false);
        }
        self.basis.view_mut().copy_from(self.schur.basis());
        self.turn(q);
        let cosine = |i: usize| self.turned.col(i)[i];
        if m % 2 == 1 && cosine(m - 1) < 0.0 {
            return Err(Error::OutsideLogDomain { angle: PI });
        }
        for (l, (angle, sine)) in self.angles.iter_mut().zip(self.schur.angles()).enumerate() {
            *angle = sine.atan2(0.5 * (cosine(2 * l) + cosine(2 * l + 1)));
        }
        Ok(true)
    }

    /// Planes from the symmetric eigenproblem; each group of equal cosines is split by the Schur form of the skew part
    /// restricted to it.
    fn planes_by_cosines(&mut self, q: MatRef<'_, f64>) -> Result<()> {
        let m = q.nrows();
        // Q = S + K.
        for j in 0..m {
            let (target, skew) = (self.work.col_mut(j), self.skew.col(j));
            for i in 0..m {
                target[i] = q[(i, j)] - skew[i];
            }
        }
        let eigen = self.eigen.get_or_insert_with(|| SymmetricEigen::new(m));
        eigen.compute(self.work.view())?;
        let w = eigen.vectors();
        product(self.work.view_mut(), self.skew.view(), w);
        let right = self.work.view();
        self.skew
            .set_product(Accum::Replace, 1.0, w.transpose(), right);
        self.skew.reflect(Symmetry::Skew);
        let (mut start, mut plane, mut null_found) = (0, 0, false);
        while start < m {
            let mut end = start + 1;
            while end < m && eigen.value(end) - eigen.value(end - 1) <= GROUP_GAP {
                end += 1;
            }
            let size = end - start;
            self.schur
                .compute(self.skew.view().submatrix(start, start, size, size))?;
            let planes = size / 2;
            let cosine = |column: usize| -> f64 {
                let v = self.schur.basis();
                (0..size)
                    .map(|i| v[(i, column)] * v[(i, column)] * eigen.value(start + i))
                    .sum()
            };
            for l in 0..planes {
                let angle = self.schur.angles()[l].atan2(0.5 * (cosine(2 * l) + cosine(2 * l + 1)));
                if PI - angle <= pi_tolerance(m) {
                    return Err(Error::OutsideLogDomain { angle });
                }
                self.angles[plane + l] = angle;
            }
            // An unpaired vector belongs to the eigenvalue +1 or -1. A rotation has one, for +1, if m is odd and none
            // if m is even; otherwise the number of eigenvalues -1 is odd.
            if size % 2 == 1 && (cosine(size - 1) < 0.0 || null_found || m.is_multiple_of(2)) {
                return Err(Error::OutsideLogDomain { angle: PI });
            }
            let vectors = eigen.vectors().submatrix(0, start, m, size);
            let (schur, mut basis) = (self.schur.basis(), self.basis.view_mut());
            let target = basis.rb_mut().submatrix_mut(0, 2 * plane, m, 2 * planes);
            product(target, vectors, schur.subcols(0, 2 * planes));
            if size % 2 == 1 {
                let target = basis.submatrix_mut(0, m - 1, m, 1);
                product(target, vectors, schur.subcols(size - 1, 1));
                null_found = true;
            }
            plane += planes;
            start = end;
        }
        Ok(())
    }

    /// The cotangents of half sums and differences are accurate enough for a correction of the size of round-off
    /// divided by `GROUP_GAP`. In the basis: `L = L_0 + f(ad_{L_0}) skew(E)` with `I + E = e^{-L_0} Q` and `f(x) = x /
    /// (1 - e^{-x})`.
    fn correct(&mut self) {
        let m = 2 * self.angles.len() + self.basis.view().ncols() % 2;
        for (l, theta) in self.angles.iter().enumerate() {
            let (sin, cos) = theta.sin_cos();
            let (half_sin, half_cos) = (0.5 * theta).sin_cos();
            (self.cos_sin[l], self.half_cos_sin[l]) = ((cos, sin), (half_cos, half_sin));
        }
        for j in 0..m {
            let (pairs, _) = self.turned.col_mut(j).as_chunks_mut::<2>();
            for ([x, y], (cos, sin)) in pairs.iter_mut().zip(&self.cos_sin) {
                (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
            }
        }
        self.skew.set_skew_part(1.0, self.turned.view());
        let (angles, halves) = (&self.angles, &self.half_cos_sin);
        let zero = (0.0, (1.0, 0.0));
        let plane = |a: usize| angles.get(a).map_or(zero, |angle| (*angle, halves[a]));
        apply_ad_by_planes(self.skew.view_mut(), |a, b| {
            let ((x, (cos_x, sin_x)), (y, (cos_y, sin_y))) = (plane(a), plane(b));
            let cotangent = |cos: f64, sin: f64, half: f64| {
                if half.abs() < 1e-4 {
                    (1.0 - half * half / 3.0, half)
                } else {
                    (half * cos / sin, half)
                }
            };
            let difference = cotangent(
                cos_x * cos_y + sin_x * sin_y,
                sin_x * cos_y - cos_x * sin_y,
                0.5 * (x - y),
            );
            if 2.0 * PI - (x + y) < NEAR_TWO_PI {
                return [difference, (0.0, 0.0)];
            }
            let sum = cotangent(
                cos_x * cos_y - sin_x * sin_y,
                sin_x * cos_y + cos_x * sin_y,
                0.5 * (x + y),
            );
            [difference, sum]
        });
        for (l, theta) in self.angles.iter().enumerate() {
            self.skew.col_mut(2 * l)[2 * l + 1] += theta;
            self.skew.col_mut(2 * l + 1)[2 * l] -= theta;
        }
    }

    /// `out = B L B^T`, of which only the half below the diagonal is computed.
    fn assemble(&mut self, out: MatMut<'_, f64>) {
        product(self.turned.view_mut(), self.basis.view(), self.skew.view());
        let right = self.basis.view().transpose();
        self.work
            .set_product(Accum::Replace, 1.0, self.turned.view(), right);
        if self.work.halves_products() {
            self.work.reflect(Symmetry::Skew);
            self.work.write(out);
        } else {
            // Both halves are available; their mean is more accurate.
            self.skew.set_skew_part(1.0, self.work.view());
            self.skew.write(out);
        }
    }
}

fn product(out: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
}

/// `i x / (1 - e^{-i x}) = (x/2) cot(x/2) + i x/2`: the inverse of `(1 - e^{-ad}) / ad` on one eigenvalue.
pub(crate) fn inverse_dexp(x: f64) -> (f64, f64) {
    let half = 0.5 * x;
    let real = if half.abs() < 1e-4 {
        1.0 - half * half / 3.0
    } else {
        half / half.tan()
    };
    (real, half)
}
