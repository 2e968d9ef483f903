//! The damped least-squares iteration, for nearly conjugate ends, where Newton steps along a flat direction are far too
//! long.
//!
//! # Source
//! Marquardt (1963), "An algorithm for least-squares estimation of nonlinear parameters", J. SIAM 11, 431-441.

use faer::Mat;

use super::{GeodesicShooting, ShootingOutcome};
use crate::error::Result;
use crate::linalg::decomp::Svd;

/// Maximal number of unknowns, since the derivative is a full matrix. Larger problems do without this iteration.
const MAX_UNKNOWNS: usize = 200;

/// The damping of the first step, its factors after accepted and rejected steps, and the damping at which to stop.
const FIRST: f64 = 1e-2;
const TAKEN: f64 = 1e-2;
const REFUSED: f64 = 10.0;
const LAST: f64 = 1e8;

impl GeodesicShooting {
    /// Takes steps until the residual is at most `tolerance`, each of which reduces it. For metrics with `nu != 0`.
    ///
    /// # Errors
    /// The errors of the exponential.
    pub(in super::super) fn run_damped(
        &mut self,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<ShootingOutcome> {
        let mut residual = self.residual()?;
        let (mut damping, mut iterations) = (FIRST, 0);
        let directions = self.directions();
        let solvable = directions.len() <= MAX_UNKNOWNS && self.nu != 0.0;
        while solvable && residual > tolerance && iterations < max_iterations {
            iterations += 1;
            let (svd, rhs) = self.factored_derivative(&directions)?;
            let kept = self.generator.clone();
            loop {
                let next = self.damped_step(&svd, &rhs, damping, &directions)?;
                if next < residual {
                    damping = (TAKEN * damping).max(f64::MIN_POSITIVE);
                    residual = next;
                    break;
                }
                self.generator.copy_from(&kept);
                damping *= REFUSED;
                if damping > LAST {
                    return Ok(ShootingOutcome {
                        converged: false,
                        iterations,
                        residual,
                    });
                }
            }
        }
        Ok(ShootingOutcome {
            converged: residual <= tolerance,
            iterations,
            residual,
        })
    }

    /// Entries of `unknown` for a basis of `A` and `B`; the second entry of a pair changes with the opposite sign.
    fn directions(&self) -> Vec<(usize, Option<usize>)> {
        let (k, p) = (self.k, self.p);
        let skew = (0..k).flat_map(|j| (j + 1..k).map(move |i| (j * k + i, Some(i * k + j))));
        skew.chain((0..p * k).map(|i| (k * k + i, None))).collect()
    }

    /// `J = U diag(s) V^T` and `U^T Delta`. Not from `J^T J`, in which a flat direction of 1e-6 would become 1e-12 and
    /// be lost.
    fn factored_derivative(
        &mut self,
        directions: &[(usize, Option<usize>)],
    ) -> Result<(Svd, Vec<f64>)> {
        self.extract();
        self.prepare_turning();
        let size = self.unknown.len();
        let (count, mut x) = (directions.len(), vec![0.0; size]);
        let mut jacobian = Mat::zeros(size, count);
        for (j, &(plus, minus)) in directions.iter().enumerate() {
            x.fill(0.0);
            x[plus] = 1.0;
            if let Some(minus) = minus {
                x[minus] = -1.0;
            }
            self.turning_operator(&x, jacobian.col_as_slice_mut(j));
        }
        let mut svd = Svd::new(size, count);
        svd.compute(jacobian.as_ref())?;
        let dot = |j: usize| (0..size).map(|i| svd.u()[(i, j)] * self.unknown[i]).sum();
        let rhs = (0..count).map(dot).collect();
        Ok((svd, rhs))
    }

    /// Takes the step for a given damping; returns the new residual.
    fn damped_step(
        &mut self,
        svd: &Svd,
        rhs: &[f64],
        damping: f64,
        directions: &[(usize, Option<usize>)],
    ) -> Result<f64> {
        let share = |j: usize| rhs[j] * svd.s(j) / (svd.s(j) * svd.s(j) + damping);
        let shares: Vec<f64> = (0..rhs.len()).map(share).collect();
        self.unknown.fill(0.0);
        for (i, &(plus, minus)) in directions.iter().enumerate() {
            let entry = (0..shares.len())
                .map(|j| svd.v()[(i, j)] * shares[j])
                .sum::<f64>();
            self.unknown[plus] = entry;
            if let Some(minus) = minus {
                self.unknown[minus] = -entry;
            }
        }
        self.update_turning();
        self.residual()
    }
}
