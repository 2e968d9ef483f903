//! Principal vectors and angles between two points, as accurate for small angles as for large ones.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use crate::error::{Error, Result};
use crate::linalg::decomp::Svd;
use crate::linalg::product::{determinant_sign, mul_add, mul_into};

/// Principal directions whose sines are below this are separated by sines, the others by cosines.
const LARGE_SINE: f64 = 0.5;

/// Maximal number of sweeps of plane rotations that separate principal directions; three or four are usual.
const MAX_SWEEPS: usize = 30;

/// Principal vectors of points of one shape, with buffers allocated once.
pub(super) struct PrincipalVectors {
    svd: Svd,
    gram: Mat<f64>,
    pub(super) normal: Mat<f64>,
    coefficients: Vec<f64>,
    pub(super) cosines: Vec<f64>,
    pub(super) u: Mat<f64>,
    pub(super) z: Mat<f64>,
    pub(super) rotation: Mat<f64>,
}

impl PrincipalVectors {
    pub(super) fn new(n: usize, k: usize) -> Self {
        PrincipalVectors {
            svd: Svd::new(k, k),
            gram: Mat::zeros(k, k),
            normal: Mat::zeros(n, k),
            coefficients: vec![0.0; 2 * k],
            cosines: vec![0.0; k],
            u: Mat::zeros(k, k),
            z: Mat::zeros(k, k),
            rotation: Mat::zeros(k, k),
        }
    }

    /// Computes `S0^T S1 = U diag(c) Z^T` with `det(U Z^T) = +1`, the rotation `U Z^T`, and `normal = (I - S0 S0^T) S1
    /// Z`, with principal angles increasing before the sign change of the last one.
    pub(super) fn compute(&mut self, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<()> {
        let (n, k) = (s0.nrows(), s0.ncols());
        mul_into(&mut self.gram, 1.0, s0.transpose(), s1);
        self.svd.compute(self.gram.as_ref())?;
        self.u.copy_from(self.svd.u());
        self.z.copy_from(self.svd.v());
        for i in 0..k {
            self.cosines[i] = self.svd.s(i);
        }
        if n > k {
            mul_into(&mut self.normal, 1.0, s1, &self.z);
            mul_into(&mut self.gram, 1.0, s0.transpose(), &self.normal);
            mul_add(&mut self.normal, -1.0, s0, &self.gram);
            self.separate_small_angles()?;
            self.sort_by_angle();
        }
        mul_into(&mut self.rotation, 1.0, &self.u, self.z.transpose());
        self.gram.copy_from(&self.rotation);
        if determinant_sign(self.gram.as_mut()) < 0.0 {
            if n == k {
                return Err(Error::DifferentComponents { n });
            }
            self.cosines[k - 1] = -self.cosines[k - 1];
            for i in 0..k {
                self.u[(i, k - 1)] = -self.u[(i, k - 1)];
            }
            mul_into(&mut self.rotation, 1.0, &self.u, self.z.transpose());
        }
        Ok(())
    }

    /// Orthogonalises the columns of `normal` with small sines, by one-sided Jacobi rotations that are also applied to
    /// `U` and `Z`.
    ///
    /// Cosines do not separate small angles (all are 1 below 1e-8), so the factorisation of `S0^T S1` leaves their
    /// principal vectors undetermined; the sines determine them. If both sines are small, both cosines are near 1, and
    /// the rotation that diagonalises the sine part keeps `U^T S0^T S1 Z` diagonal to round-off.
    fn separate_small_angles(&mut self) -> Result<()> {
        let k = self.cosines.len();
        let negligible = f64::EPSILON * (self.normal.nrows() as f64).max(4.0);
        for _ in 0..MAX_SWEEPS {
            let mut separated = true;
            for j in 1..k {
                for i in 0..j {
                    let [a, b] = [i, j].map(|l| self.normal.col(l).squared_norm_l2());
                    let overlap = self.normal.col(i).transpose() * self.normal.col(j);
                    let larger = a.max(b).sqrt();
                    if larger < LARGE_SINE && overlap.abs() > negligible * larger {
                        self.rotate(i, j, 0.5 * (b - a) / overlap);
                        separated = false;
                    }
                }
            }
            if separated {
                return Ok(());
            }
        }
        Err(Error::Decomposition {
            kind: "separation of small principal angles",
        })
    }

    /// Applies the plane rotation of columns `i` and `j` whose angle `phi <= pi/4` has `cot(2 phi) = cotangent`.
    fn rotate(&mut self, i: usize, j: usize, cotangent: f64) {
        let tangent = 1.0_f64.copysign(cotangent) / (cotangent.abs() + 1.0_f64.hypot(cotangent));
        let cos = 1.0 / 1.0_f64.hypot(tangent);
        let sin = tangent * cos;
        for columns in [&mut self.normal, &mut self.u, &mut self.z] {
            for row in 0..columns.nrows() {
                let (x, y) = (columns[(row, i)], columns[(row, j)]);
                columns[(row, i)] = cos * x - sin * y;
                columns[(row, j)] = sin * x + cos * y;
            }
        }
        let (x, y) = (self.cosines[i], self.cosines[j]);
        self.cosines[i] = cos * cos * x + sin * sin * y;
        self.cosines[j] = sin * sin * x + cos * cos * y;
    }

    /// Sorts the principal directions by increasing angle, by insertion, since they are nearly sorted.
    fn sort_by_angle(&mut self) {
        let angle =
            |problem: &Self, i: usize| problem.normal.col(i).norm_l2().atan2(problem.cosines[i]);
        for end in 1..self.cosines.len() {
            let mut i = end;
            while i > 0 && angle(self, i) < angle(self, i - 1) {
                for columns in [&mut self.normal, &mut self.u, &mut self.z] {
                    for row in 0..columns.nrows() {
                        let swap = columns[(row, i)];
                        columns[(row, i)] = columns[(row, i - 1)];
                        columns[(row, i - 1)] = swap;
                    }
                }
                self.cosines.swap(i, i - 1);
                i -= 1;
            }
        }
    }

    /// Projects column `i` of `normal` off `s0` and off the previous directions; returns its length.
    pub(super) fn orthogonalise(
        &mut self,
        s0: MatRef<'_, f64>,
        found: MatRef<'_, f64>,
        i: usize,
    ) -> f64 {
        let k = s0.ncols();
        let (mut column, coefficients) = (
            self.normal.as_mut().subcols_mut(i, 1),
            self.coefficients.as_mut_slice(),
        );
        let mut projection = MatMut::from_column_major_slice_mut(coefficients, 2 * k, 1);
        mul_into(
            projection.rb_mut().subrows_mut(0, k),
            1.0,
            s0.transpose(),
            column.rb(),
        );
        mul_add(column.rb_mut(), -1.0, s0, projection.rb().subrows(0, k));
        let later = found.subcols(i + 1, k - i - 1);
        let mut overlap = projection.subrows_mut(k, k - i - 1);
        mul_into(overlap.rb_mut(), 1.0, later.transpose(), column.rb());
        mul_add(column.rb_mut(), -1.0, later, overlap.rb());
        column.norm_l2()
    }
}
