//! The damped least-squares iteration, for ends that are nearly conjugate: there Newton steps along a flat direction are
//! far too long.
//!
//! # Source
//! Marquardt (1963), "An algorithm for least-squares estimation of nonlinear parameters", J. SIAM 11, 431-441.

use faer::Mat;

use super::{Outcome, Shooting};
use crate::error::Result;
use crate::linalg::decomp::solve_square;
use crate::linalg::product::mul_into;

/// Unknowns at most: the derivative is a full matrix. Larger problems do without this iteration.
const MAX_UNKNOWNS: usize = 200;

/// The damping of the first step, its factor from step to step, and where it ends.
const FIRST: f64 = 1e-2;
const FACTOR: f64 = 10.0;
const LAST: f64 = 1e8;

impl Shooting {
    /// Steps until the residual is at most `tolerance`, each of which makes it smaller. For metrics with `nu != 0`.
    ///
    /// # Errors
    /// Those of the exponential.
    pub(in super::super) fn run_damped(
        &mut self,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<Outcome> {
        let mut residual = self.residual()?;
        let (mut damping, mut iterations) = (FIRST, 0);
        let directions = self.directions();
        let solvable = directions.len() <= MAX_UNKNOWNS && self.nu != 0.0;
        while solvable && residual > tolerance && iterations < max_iterations {
            iterations += 1;
            let (normal, gradient) = self.normal_equations(&directions);
            let kept = self.generator.clone();
            loop {
                let next = self.damped_step(&normal, &gradient, damping, &directions)?;
                if next < residual {
                    damping = (damping / FACTOR).max(f64::EPSILON);
                    residual = next;
                    break;
                }
                self.generator.copy_from(&kept);
                damping *= FACTOR;
                if damping > LAST {
                    return Ok(Outcome {
                        converged: false,
                        iterations,
                        residual,
                    });
                }
            }
        }
        Ok(Outcome {
            converged: residual <= tolerance,
            iterations,
            residual,
        })
    }

    /// Entries of `unknown` for a basis of `A` and `B`: the second of a pair changes with the other sign.
    fn directions(&self) -> Vec<(usize, Option<usize>)> {
        let (k, p) = (self.k, self.p);
        let skew = (0..k).flat_map(|j| (j + 1..k).map(move |i| (j * k + i, Some(i * k + j))));
        skew.chain((0..p * k).map(|i| (k * k + i, None))).collect()
    }

    /// `J^T J` and `J^T Delta`.
    fn normal_equations(&mut self, directions: &[(usize, Option<usize>)]) -> (Mat<f64>, Vec<f64>) {
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
        let mut normal = Mat::zeros(count, count);
        mul_into(&mut normal, 1.0, jacobian.transpose(), &jacobian);
        let dot = |j: usize| {
            let column = jacobian.col_as_slice(j).iter();
            column.zip(&self.unknown).map(|(x, y)| x * y).sum()
        };
        (normal, (0..count).map(dot).collect())
    }

    /// Takes the step for a damping; the residual there.
    fn damped_step(
        &mut self,
        normal: &Mat<f64>,
        gradient: &[f64],
        damping: f64,
        directions: &[(usize, Option<usize>)],
    ) -> Result<f64> {
        let mut damped = normal.clone();
        for i in 0..gradient.len() {
            damped[(i, i)] += damping;
        }
        let Some(step) = solve_square(damped.as_ref(), gradient) else {
            return Ok(f64::INFINITY);
        };
        self.unknown.fill(0.0);
        for (&(plus, minus), entry) in directions.iter().zip(step) {
            self.unknown[plus] = entry;
            if let Some(minus) = minus {
                self.unknown[minus] = -entry;
            }
        }
        self.update_turning();
        self.residual()
    }
}
