//! The derivative of the inverse retraction with respect to the end point.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use super::QuasiGeodesic;
use crate::error::Result;
use crate::linalg::SkewSchur;
use crate::linalg::orthogonal_log::inverse_dexp;
use crate::linalg::product::{axpy, mul_add, mul_into};
use crate::linalg::skew_schur::apply_ad_function;
use crate::linalg::structure::check_range;

/// Quantity named in `Overflow` errors.
const DIFFERENTIAL: &str = "derivative of the inverse retraction";

/// Dimension up to which rotations commute.
const COMMUTING: usize = 2;

/// The inverse of the derivative of `R(u) = e^X S e^Omega` at `u = K + S Omega`, with buffers allocated once per shape.
///
/// The argument is a tangent vector at `R(u)` carried back to `S`, `Z = e^{-X} U e^{-Omega} = L + S Psi`. With the
/// singular value decomposition `K = Q Sigma W^T`, the derivative `K' + S Omega'` of the velocity satisfies
///
/// ```math
/// L = \Bigl( \frac{\sinh \mathrm{ad}_X}{\mathrm{ad}_X} X' \Bigr) S,\qquad
/// \Psi = S^T \Bigl( \frac{1 - \cosh \mathrm{ad}_X}{\mathrm{ad}_X} X' \Bigr) S
///     + \frac{e^{\mathrm{ad}_\Omega} - 1}{\mathrm{ad}_\Omega}\, \Omega'
/// ```
///
/// Between two principal planes, `ad_X` acts on the part of `X'` that commutes with them by the difference of their
/// angles, and on the part that anticommutes by the sum; on the rest of the space it acts by the angle itself. So the
/// first equation is solved entry by entry, and the second in the planes of `Omega`. Cost `O(n k^2)`.
///
/// It is singular if two angles add up to pi, or two angles of `Omega` to two pi: the result then has large entries.
pub(crate) struct InverseDifferential {
    schur: SkewSchur,
    psi: Mat<f64>,
    /// `Q^T L W`, later changed by the planes.
    inner: Mat<f64>,
    /// `W^T Psi W`, the contribution of `X'`.
    curl: Mat<f64>,
    small: Mat<f64>,
    tall: Mat<f64>,
}

impl InverseDifferential {
    pub(crate) fn new(n: usize, k: usize) -> Self {
        let square = || Mat::zeros(k, k);
        InverseDifferential {
            schur: SkewSchur::new(k),
            psi: square(),
            inner: square(),
            curl: square(),
            small: square(),
            tall: Mat::zeros(n, k),
        }
    }

    /// Replaces `z` at `s`, shapes `(n, k)`, by the derivative of the velocity of `curve`, which starts at `s`.
    ///
    /// # Errors
    /// `Overflow` if the derivative is singular to working precision; `Decomposition`.
    pub(crate) fn apply(
        &mut self,
        curve: &QuasiGeodesic,
        s: MatRef<'_, f64>,
        z: MatMut<'_, f64>,
    ) -> Result<()> {
        let (k, mut z) = (s.ncols(), z);
        mul_into(&mut self.psi, 1.0, s.transpose(), z.rb());
        mul_add(z.rb_mut(), -1.0, s, &self.psi);
        self.make_skew();
        let normals = curve.frame().subcols(k, k);
        mul_into(&mut self.tall, 1.0, z.rb(), curve.right().transpose());
        mul_into(&mut self.inner, 1.0, normals.transpose(), &self.tall);
        self.solve_planes(curve.angles());
        for (j, angle) in curve.angles().iter().enumerate() {
            let factor = 1.0 / sinc(*angle);
            self.tall
                .col_mut(j)
                .iter_mut()
                .for_each(|entry| *entry *= factor);
        }
        mul_add(&mut self.tall, 1.0, normals, &self.inner);
        mul_into(z.rb_mut(), 1.0, &self.tall, curve.right());
        mul_into(&mut self.small, 1.0, &self.curl, curve.right());
        mul_add(&mut self.psi, -1.0, curve.right().transpose(), &self.small);
        if k > COMMUTING {
            self.solve_turn(curve.omega())?;
        }
        mul_add(z.rb_mut(), 1.0, s, &self.psi);
        check_range(DIFFERENTIAL, z.rb())
    }

    fn make_skew(&mut self) {
        let k = self.psi.ncols();
        for j in 0..k {
            for i in 0..=j {
                let entry = 0.5 * (self.psi[(i, j)] - self.psi[(j, i)]);
                self.psi[(i, j)] = entry;
                self.psi[(j, i)] = -entry;
            }
        }
    }

    /// Divides columns by `sinc` of their angle; stores the remaining correction in `inner`, and the curl.
    fn solve_planes(&mut self, angles: &[f64]) {
        for j in 0..angles.len() {
            self.curl[(j, j)] = 0.0;
            self.inner[(j, j)] -= self.inner[(j, j)] / sinc(angles[j]);
            for i in 0..j {
                let (difference, sum) = (angles[i] - angles[j], angles[i] + angles[j]);
                let (x, y) = (self.inner[(i, j)], self.inner[(j, i)]);
                let commuting = 0.5 * (x + y) / sinc(difference);
                let anticommuting = 0.5 * (x - y) / sinc(sum);
                self.inner[(i, j)] = commuting + anticommuting - x / sinc(angles[j]);
                self.inner[(j, i)] = commuting - anticommuting - y / sinc(angles[i]);
                let curl = commuting * versine(difference) + anticommuting * versine(sum);
                self.curl[(i, j)] = curl;
                self.curl[(j, i)] = -curl;
            }
        }
    }

    /// `psi <- ad / (e^{ad} - 1) psi`.
    fn solve_turn(&mut self, omega: MatRef<'_, f64>) -> Result<()> {
        self.schur.compute(omega)?;
        let basis = self.schur.basis();
        mul_into(&mut self.small, 1.0, &self.psi, basis);
        mul_into(&mut self.psi, 1.0, basis.transpose(), &self.small);
        apply_ad_function(self.schur.angles(), self.psi.as_mut(), |x, _| {
            let (re, im) = inverse_dexp(x);
            (re, -im)
        });
        mul_into(&mut self.small, 1.0, &self.psi, basis.transpose());
        mul_into(&mut self.psi, 1.0, basis, &self.small);
        self.small.copy_from(&self.psi);
        self.psi.fill(0.0);
        axpy(&mut self.psi, 0.5, &self.small);
        axpy(&mut self.psi, -0.5, self.small.transpose());
        Ok(())
    }
}

/// `sin(x) / x`.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}

/// `(1 - cos x) / x`.
fn versine(x: f64) -> f64 {
    let half = 0.5 * x;
    half.sin() * sinc(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifold::Stiefel;
    use crate::manifold::carrier::Carrier;
    use crate::manifold::retraction_differential::retraction_differential;
    use crate::solve::direction::Direction;

    fn entry(i: usize, j: usize, seed: usize) -> f64 {
        ((17 * i + 5 * j + 11 * seed) as f64).sin()
    }

    fn tangent(s: &Mat<f64>, size: f64, seed: usize) -> Mat<f64> {
        let (n, k) = s.shape();
        let z = Mat::from_fn(n, k, |i, j| entry(i, j, seed));
        let manifold = Stiefel::new(n, k).unwrap();
        let v = manifold.project_tangent(s.as_ref(), z.as_ref()).unwrap();
        let length = v.norm_l2();
        v * faer::Scale(if length > 0.0 { size / length } else { 0.0 })
    }

    #[test]
    fn undoes_the_derivative_of_the_retraction() {
        let shapes = [
            (1, 1),
            (2, 1),
            (3, 1),
            (3, 2),
            (5, 3),
            (3, 3),
            (4, 4),
            (9, 4),
            (20, 2),
        ];
        for (n, k) in shapes {
            let manifold = Stiefel::new(n, k).unwrap();
            let any = Mat::from_fn(n, k, |i, j| entry(i, j, 1) + f64::from(u8::from(i == j)));
            let s = manifold.project(any.as_ref()).unwrap();
            let (mut carrier, mut inverse) = (Carrier::new(n, k), InverseDifferential::new(n, k));
            for size in [0.0, 1e-9, 0.3, 1.5] {
                let (u, z) = (tangent(&s, size, 2), tangent(&s, 1.0, 3));
                let curve = QuasiGeodesic::from_velocity(s.as_ref(), u.as_ref()).unwrap();
                let mut image =
                    retraction_differential(s.as_ref(), u.as_ref(), z.as_ref()).unwrap();
                carrier.set(&curve).unwrap();
                carrier.carry(&curve, image.as_mut(), Direction::Backward);
                inverse.apply(&curve, s.as_ref(), image.as_mut()).unwrap();
                let error = (&image - &z).norm_l2();
                // Allows for products of n x n matrices in the reference's exponentials.
                let bound = 32.0 * n as f64 * f64::EPSILON;
                assert!(error <= bound, "{n} {k} {size}: {error:e}");
            }
        }
    }

    #[test]
    fn velocities_of_low_rank_are_no_special_case() {
        // One principal angle for two columns: the frame lacks the other direction.
        let (n, k) = (6, 2);
        let s = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
        let u = Mat::from_fn(n, k, |i, j| match (i, j) {
            (0, 1) => -0.4,
            (1, 0) => 0.4,
            (3, 0) => 0.7,
            _ => 0.0,
        });
        let z = tangent(&s, 1.0, 4);
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), u.as_ref()).unwrap();
        let mut image = retraction_differential(s.as_ref(), u.as_ref(), z.as_ref()).unwrap();
        let mut carrier = Carrier::new(n, k);
        carrier.set(&curve).unwrap();
        carrier.carry(&curve, image.as_mut(), Direction::Backward);
        let mut inverse = InverseDifferential::new(n, k);
        inverse.apply(&curve, s.as_ref(), image.as_mut()).unwrap();
        let error = (&image - &z).norm_l2();
        assert!(error <= 32.0 * n as f64 * f64::EPSILON, "{error:e}");
    }
}
