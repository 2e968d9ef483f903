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
use crate::linalg::skew_schur::apply_ad_function;
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
    embedded: Mat<f64>,
    product: Mat<f64>,
    turned: Mat<f64>,
    basis: Vec<Vec<f64>>,
}

/// Eigenvalues in increasing order, and their eigenvectors.
pub(super) struct Spectrum {
    pub(super) values: Vec<f64>,
    pub(super) vectors: Vec<Vec<f64>>,
}

impl FibreHessian {
    pub(super) fn new(k: usize, p: usize) -> Self {
        let square = || Mat::zeros(k + p, k + p);
        FibreHessian {
            k,
            p,
            schur: SkewSchur::new(k + p),
            embedded: square(),
            product: square(),
            turned: square(),
            basis: Vec::new(),
        }
    }

    /// Sets `L`.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn set(&mut self, log: MatRef<'_, f64>) -> Result<()> {
        self.schur.compute(log)
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
        let vector = |j: usize| {
            let mut out = vec![0.0; self.p * self.p];
            for (i, direction) in self.basis.iter().enumerate() {
                let share = eigen.vectors()[(i, j)];
                for (to, from) in out.iter_mut().zip(direction) {
                    *to += share * from;
                }
            }
            out
        };
        Ok(Spectrum {
            values: (0..used).map(|j| eigen.value(j)).collect(),
            vectors: (0..used).map(vector).collect(),
        })
    }

    /// `x <- H x`.
    fn apply(&mut self, x: &mut [f64]) {
        let (k, p, basis) = (self.k, self.p, self.schur.basis());
        self.embedded.fill(0.0);
        write_block(x, self.embedded.as_mut(), k, p, 1.0);
        mul_into(&mut self.product, 1.0, basis.transpose(), &self.embedded);
        mul_into(&mut self.turned, 1.0, &self.product, basis);
        apply_ad_function(self.schur.angles(), self.turned.as_mut(), |t, _| {
            (inverse_dexp(t).0.max(LOWEST), 0.0)
        });
        mul_into(&mut self.product, 1.0, basis, &self.turned);
        mul_into(&mut self.embedded, 1.0, &self.product, basis.transpose());
        read_block(self.embedded.as_ref(), k, p, 1.0, x);
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
