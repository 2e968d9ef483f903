//! The exact second derivative of the squared length over the fibre, and its spectrum in a Krylov space.
//!
//! ```math
//! H\,\Gamma = \big[ g(-\mathrm{ad}_L^2)\, \mathrm{diag}(0, \Gamma) \big]_{22},\qquad g(t^2) = \frac t2 \cot \frac t2
//! ```
//!
//! A zero of the gradient is a minimum only if `H` has no negative eigenvalue; at any other zero the geodesic is a
//! saddle of the length. `H` is evaluated in the Schur basis of `L`, since the polynomial of `adjoint.rs` is only
//! accurate to 1e-3.

use faer::{Mat, MatRef};

use super::shooting::{read_block, write_block};
use crate::error::Result;
use crate::linalg::SkewSchur;
use crate::linalg::decomp::SymmetricEigen;
use crate::linalg::orthogonal_log::inverse_dexp;
use crate::linalg::product::mul_into;
use crate::linalg::skew_schur::apply_ad_by_planes;
use crate::solve::gmres::{dot, norm};

/// Maximal dimension of a Krylov space; it is the full space up to `p = 9`.
const MAX_DIRECTIONS: usize = 36;

/// `g` has poles where two angles add up to `2 pi`; it is truncated at this value, far below all others.
const LOWEST: f64 = -1e3;

/// Norm of an orthogonalised image, relative to the largest image, at which the Krylov space counts as invariant.
const INVARIANT: f64 = 1e-12;

pub(super) struct FibreHessian {
    k: usize,
    p: usize,
    schur: SkewSchur,
    /// `g` at the differences and the sums of two angles, plane by plane.
    factors: Vec<[f64; 2]>,
    block: Mat<f64>,
    product: Mat<f64>,
    turned: Mat<f64>,
    /// Of the Krylov space.
    basis: Vec<Vec<f64>>,
}

/// Eigenvalues in increasing order, and their eigenvectors in the basis of the Krylov space, which starts with the given
/// matrix.
pub(super) struct Spectrum {
    pub(super) values: Vec<f64>,
    pub(super) vectors: Mat<f64>,
}

impl FibreHessian {
    pub(super) fn new(k: usize, p: usize) -> Self {
        FibreHessian {
            k,
            p,
            schur: SkewSchur::new(k + p),
            factors: Vec::new(),
            block: Mat::zeros(p, p),
            product: Mat::zeros(k + p, p),
            turned: Mat::zeros(k + p, k + p),
            basis: Vec::new(),
        }
    }

    /// Sets `L`.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn set(&mut self, log: MatRef<'_, f64>) -> Result<()> {
        self.schur.compute(log)?;
        let angles = self.schur.angles();
        let planes = self.planes();
        let angle = |a: usize| angles.get(a).copied().unwrap_or(0.0);
        let factor = |t: f64| inverse_dexp(t).0.max(LOWEST);
        self.factors.clear();
        for b in 0..planes {
            self.factors.extend((0..planes).map(|a| {
                let (a, b) = (angle(a), angle(b));
                [factor(a - b), factor(a + b)]
            }));
        }
        Ok(())
    }

    /// Planes that `L` rotates, null vectors included.
    fn planes(&self) -> usize {
        (self.k + self.p).div_ceil(2)
    }

    /// The spectrum of `H` in the Krylov space of a nonzero skew matrix, given in column-major order.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn spectrum(&mut self, start: &[f64]) -> Result<Spectrum> {
        self.basis.clear();
        let dimension = (self.p * (self.p - 1) / 2).min(MAX_DIRECTIONS);
        let mut projected = Mat::zeros(MAX_DIRECTIONS, MAX_DIRECTIONS);
        let mut next = start.to_vec();
        // Relative to the largest image: in a direction without curvature the image itself is round-off.
        let mut largest = 0.0_f64;
        loop {
            let length = norm(&next);
            if length <= INVARIANT * largest || self.basis.len() == dimension {
                break;
            }
            next.iter_mut().for_each(|x| *x /= length);
            self.basis.push(next.clone());
            let used = self.basis.len();
            self.apply(&mut next);
            largest = largest.max(norm(&next));
            // Twice, so that the basis is orthogonal to round-off.
            for pass in 0..2 {
                for i in 0..used {
                    let part = dot(&self.basis[i], &next);
                    if pass == 0 {
                        projected[(used - 1, i)] = part;
                    }
                    for (to, from) in next.iter_mut().zip(&self.basis[i]) {
                        *to -= part * from;
                    }
                }
            }
        }
        self.ritz(projected.as_ref())
    }

    fn ritz(&self, projected: MatRef<'_, f64>) -> Result<Spectrum> {
        let used = self.basis.len();
        let mut eigen = SymmetricEigen::new(used);
        eigen.compute(projected.submatrix(0, 0, used, used))?;
        Ok(Spectrum {
            values: (0..used).map(|j| eigen.value(j)).collect(),
            vectors: eigen.vectors().to_owned(),
        })
    }

    /// The matrix with the given coordinates in the Krylov space, in column-major order.
    pub(super) fn combine(&self, coordinates: impl Iterator<Item = f64>, out: &mut [f64]) {
        out.fill(0.0);
        for (share, direction) in coordinates.zip(&self.basis) {
            for (to, from) in out.iter_mut().zip(direction) {
                *to += share * from;
            }
        }
    }

    /// `x <- H x`.
    fn apply(&mut self, x: &mut [f64]) {
        let (k, p, planes) = (self.k, self.p, self.planes());
        // Only the rows of the free block take part.
        let rows = self.schur.basis().subrows(k, p);
        write_block(x, self.block.as_mut(), 0, p, 1.0);
        mul_into(&mut self.product, 1.0, rows.transpose(), &self.block);
        mul_into(&mut self.turned, 1.0, &self.product, rows);
        let factors = &self.factors;
        apply_ad_by_planes(self.turned.as_mut(), |a, b| {
            factors[b * planes + a].map(|factor| (factor, 0.0))
        });
        mul_into(&mut self.product, 1.0, &self.turned, rows.transpose());
        mul_into(&mut self.block, 1.0, rows, &self.product);
        read_block(self.block.as_ref(), 0, p, 1.0, x);
        // Exactly skew: divided by a small remainder, round-off would become a spurious direction.
        for j in 0..p {
            x[j * p + j] = 0.0;
            for i in 0..j {
                let entry = 0.5 * (x[j * p + i] - x[i * p + j]);
                (x[j * p + i], x[i * p + j]) = (entry, -entry);
            }
        }
    }
}
