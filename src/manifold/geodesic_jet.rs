//! Derivatives of a geodesic with moving end points: one stage of de Casteljau's algorithm with geodesics.
//!
//! The geodesic of the canonical metric with velocity `W` at `S_0` is `e^{t Xi} S_0` with the skew
//!
//! ```math
//! \Xi = K S_0^T - S_0 K^T + S_0 \Omega S_0^T,\qquad W = K + S_0 \Omega
//! ```
//!
//! so the Taylor polynomial of `W` follows from `e^{Xi} S_0 = S_1` order by order. Each order enters linearly, through
//! the derivative of the exponential, which is the same for all orders. No moving basis of the normal space is needed,
//! so nothing becomes singular where the points coincide.

use faer::{Mat, MatRef};

use super::stiefel::Stiefel;
use crate::error::{Error, Result};
use crate::linalg::decomp::{solve_square, thin_q};
use crate::linalg::jet::MatrixJet;
use crate::linalg::jet_exp::JetExp;
use crate::linalg::product::mul_into;
use crate::linalg::skew_schur::apply_ad_function;
use crate::linalg::{SkewSchur, dexp};

/// Quantity named in `Overflow` errors.
const DERIVATIVES: &str = "derivative of a geodesic polynomial";

/// Buffers for points of one shape.
pub(crate) struct MovingGeodesic {
    manifold: Stiefel,
    velocity: MatrixJet,
    gram: MatrixJet,
    omega: MatrixJet,
    normal: MatrixJet,
    tall: MatrixJet,
    outer: MatrixJet,
    generator: MatrixJet,
    exponential: JetExp,
    schur: SkewSchur,
}

impl MovingGeodesic {
    /// Buffers for points of shape `(r, k)`.
    ///
    /// # Errors
    /// `Shape` unless `1 <= k <= r`.
    pub(crate) fn new(r: usize, k: usize) -> Result<Self> {
        let (square, tall) = (|| MatrixJet::zeros(r, r), || MatrixJet::zeros(r, k));
        Ok(MovingGeodesic {
            manifold: Stiefel::new(r, k)?,
            velocity: tall(),
            gram: MatrixJet::zeros(k, k),
            omega: MatrixJet::zeros(k, k),
            normal: tall(),
            tall: tall(),
            outer: square(),
            generator: square(),
            exponential: JetExp::new(r),
            schur: SkewSchur::new(r),
        })
    }

    /// `out(tau) = beta(S0(tau), S1(tau); t + tau)` up to the given order.
    ///
    /// # Errors
    /// The errors of [`Stiefel::log`]; `NoJoiningCurve` if the points are conjugate.
    pub(crate) fn jet_into(
        &mut self,
        s0: &MatrixJet,
        s1: &MatrixJet,
        t: f64,
        order: usize,
        out: &mut MatrixJet,
    ) -> Result<()> {
        let (r, k) = (self.manifold.n(), self.manifold.k());
        let velocity = self.manifold.log(s0.c[0].as_ref(), s1.c[0].as_ref())?;
        for c in &mut self.velocity.c {
            c.fill(0.0);
        }
        self.velocity.c[0].copy_from(&velocity);
        self.set_generator(s0, order);
        let basis = completed(s0.c[0].as_ref());
        let derivative = (order > 0)
            .then(|| self.arrival_derivative(&basis))
            .transpose()?;
        for j in 1..=order {
            self.exponential
                .compute(&[1.0, 0.0, 0.0, 0.0], &self.generator, j, DERIVATIVES)?;
            self.tall.set_product(&self.exponential.value, s0, j);
            // In the basis that the geodesic carries to its end.
            let missing = &s1.c[j] - &self.tall.c[j];
            let arrived = &self.exponential.value.c[0] * &basis;
            let given = arrived.transpose() * missing;
            let given = tangent_entries(r, k).map(|(i, l)| given[(i, l)]);
            let Some(matrix) = &derivative else { break };
            let Some(change) = solve_square(matrix.as_ref(), &given.collect::<Vec<_>>()) else {
                let angle = self.manifold.norm(s0.c[0].as_ref(), velocity.as_ref())?;
                return Err(Error::NoJoiningCurve { angle });
            };
            let mut columns = Mat::zeros(r, k);
            for ((i, l), x) in tangent_entries(r, k).zip(change) {
                columns[(i, l)] = x;
                if i < k {
                    columns[(l, i)] = -x;
                }
            }
            mul_into(&mut self.velocity.c[j], 1.0, &basis, &columns);
            self.set_generator(s0, order);
        }
        self.exponential
            .compute(&[t, 1.0, 0.0, 0.0], &self.generator, order, DERIVATIVES)?;
        out.set_product(&self.exponential.value, s0, order);
        Ok(())
    }

    /// `generator = K S0^T - S0 K^T + S0 Omega S0^T`.
    fn set_generator(&mut self, s0: &MatrixJet, order: usize) {
        self.gram.set_product_tn(s0, &self.velocity, order);
        for (omega, gram) in self.omega.c.iter_mut().zip(&self.gram.c) {
            omega.copy_from((gram - gram.transpose()) * faer::Scale(0.5));
        }
        self.tall.set_product(s0, &self.gram, order);
        self.normal.copy_from(&self.velocity, order);
        self.normal.add(-1.0, &self.tall, order);
        self.tall.set_product(s0, &self.omega, order);
        // K S0^T + S0 Omega S0^T / 2, minus its transpose.
        self.normal.add(0.5, &self.tall, order);
        self.outer.set_product_nt(&self.normal, s0, order);
        for (generator, outer) in self.generator.c.iter_mut().zip(&self.outer.c) {
            generator.copy_from(outer - outer.transpose());
        }
    }

    /// The derivative of the end with respect to the velocity, both in moving bases: `x -> [phi(ad_xi) x]_m` with
    /// `phi(x) = (1 - e^{-x}) / x`, where `xi` is the generator in the basis.
    fn arrival_derivative(&mut self, basis: &Mat<f64>) -> Result<Mat<f64>> {
        let (r, k) = (self.manifold.n(), self.manifold.k());
        let xi = basis.transpose() * &self.generator.c[0] * basis;
        self.schur.compute(xi.as_ref())?;
        let v = self.schur.basis();
        let size = tangent_entries(r, k).count();
        let mut matrix = Mat::zeros(size, size);
        let (mut image, mut half) = (Mat::zeros(r, r), Mat::zeros(r, r));
        for (column, (a, b)) in tangent_entries(r, k).enumerate() {
            for j in 0..r {
                for i in 0..r {
                    image[(i, j)] = v[(a, i)] * v[(b, j)] - v[(b, i)] * v[(a, j)];
                }
            }
            apply_ad_function(self.schur.angles(), image.as_mut(), |x, _| dexp(x));
            mul_into(&mut half, 1.0, v, &image);
            mul_into(&mut image, 1.0, &half, v.transpose());
            for (row, (i, l)) in tangent_entries(r, k).enumerate() {
                matrix[(row, column)] = image[(i, l)];
            }
        }
        Ok(matrix)
    }
}

/// Indices of the independent entries of a tangent vector in a basis that starts with the point.
fn tangent_entries(r: usize, k: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..k).flat_map(move |l| (l + 1..r).map(move |i| (i, l)))
}

/// An orthogonal matrix whose first columns are those of `s`.
fn completed(s: MatRef<'_, f64>) -> Mat<f64> {
    let (r, k) = (s.nrows(), s.ncols());
    let padded = Mat::from_fn(r, r + k, |i, j| {
        if j < k {
            s[(i, j)]
        } else {
            f64::from(u8::from(i == j - k))
        }
    });
    thin_q(padded.as_ref())
}
