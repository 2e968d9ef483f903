//! The shortest rotation over the fibre: far points, where shooting needs a better start.
//!
//! `St(n, k)` with the canonical metric is the quotient of `SO(k + p)` (in the frame of the two points) by `SO(p)`, so
//! its distance is the smallest distance over the fibre:
//!
//! ```math
//! d^2 = \min_{\Phi \in SO(p)} \tfrac12 |L|_F^2,\qquad L = \log\big( V\, \mathrm{diag}(I, \Phi) \big) =
//! \begin{bmatrix} A & -B^T \\ B & C \end{bmatrix}
//! ```
//!
//! The gradient on the fibre is `C`, the Hessian the lower right block of `g(-ad_L^2)`. A damped Newton method on a
//! function that it lowers in every step cannot run away to another branch of the logarithm.
//!
//! # Source
//! The equation `C = 0` and the first completion (a symmetric block): Zimmermann (2017), "A matrix-algebraic algorithm
//! for the Riemannian logarithm on the Stiefel manifold under the canonical metric", SIAM J. Matrix Anal. Appl. 38,
//! 322-342. Deviations: other completions beside it, the minimum instead of the equation, and Newton's method with
//! the exact derivative instead of an iteration of first order.

use faer::{Mat, MatRef};

use super::adjoint::{Adjoint, frobenius};
use super::shooting::{read_block, write_block};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::{Svd, thin_q};
use crate::linalg::gmres::{Gmres, norm};
use crate::linalg::product::{determinant_sign, mul_into};
use crate::linalg::{OrthogonalLog, SkewExp};

/// The smallest directions of the completion, whose signs are tried.
const TRIED_SIGNS: usize = 3;

/// The descent ends at this size of the gradient; shooting goes on from there.
const GRADIENT: f64 = 1e-4;

/// Newton steps of one descent at the most.
const MAX_STEPS: usize = 30;

/// The longest step, Frobenius norm of the skew matrix.
const MAX_LENGTH: f64 = 2.8;

/// A direction that goes down less steeply than this cosine is replaced by the gradient.
const STEEPNESS: f64 = 0.02;

/// Share of the predicted decrease that a step must bring.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Shortest step before a direction is given up.
const MIN_STEP: f64 = 1e-4;

/// Relative tolerance of a Newton step.
const STEP_TOLERANCE: f64 = 1e-3;

/// A completion of the target to a rotation, and its logarithm.
pub(super) struct Start {
    rotation: Mat<f64>,
    log: Mat<f64>,
    length: f64,
}

pub(super) struct Descent {
    k: usize,
    p: usize,
    log: OrthogonalLog,
    exp: SkewExp,
    adjoint: Adjoint,
    krylov: Gmres,
    direction: Vec<f64>,
    gradient: Vec<f64>,
    turn: Mat<f64>,
    step: Mat<f64>,
    embedded: Mat<f64>,
    image: Mat<f64>,
    trial: Mat<f64>,
    trial_log: Mat<f64>,
}

impl Descent {
    pub(super) fn new(k: usize, p: usize) -> Self {
        let square = || Mat::zeros(k + p, k + p);
        Descent {
            k,
            p,
            log: OrthogonalLog::new(k + p),
            exp: SkewExp::new(p),
            adjoint: Adjoint::new(k + p),
            krylov: Gmres::new(p * p),
            direction: vec![0.0; p * p],
            gradient: vec![0.0; p * p],
            turn: Mat::zeros(p, p),
            step: Mat::zeros(p, p),
            embedded: square(),
            image: square(),
            trial: square(),
            trial_log: square(),
        }
    }

    /// Completions of the target with a logarithm, the shortest first.
    ///
    /// The lower right block is made symmetric, with signs for its smallest directions that give determinant +1: the
    /// positive one is the closest to the identity, but for far points not always the one of the shortest logarithm.
    ///
    /// # Errors
    /// `OutsideLogDomain` where none has a logarithm; `Decomposition`.
    pub(super) fn starts(&mut self, target: &Mat<f64>) -> Result<Vec<Start>> {
        let (k, p) = (self.k, self.p);
        let complement = complement(target.as_ref());
        let mut svd = Svd::new(p, p);
        svd.compute(complement.as_ref().submatrix(k, 0, p, p))?;
        let mut rotation = Mat::zeros(k + p, k + p);
        rotation.as_mut().subcols_mut(0, k).copy_from(target);
        let mut starts: Vec<Start> = Vec::new();
        let mut failure = Error::OutsideLogDomain {
            angle: std::f64::consts::PI,
        };
        let mut parity = None;
        for signs in 0..1_usize << p.min(TRIED_SIGNS) {
            if parity.is_some_and(|parity| signs.count_ones() % 2 != parity) {
                continue;
            }
            let right = Mat::from_fn(p, p, |i, j| {
                let sign = |l: usize| {
                    let flipped = p - l <= TRIED_SIGNS && signs >> (p - 1 - l) & 1 == 1;
                    if flipped { -1.0 } else { 1.0 }
                };
                (0..p)
                    .map(|l| svd.v()[(i, l)] * sign(l) * svd.u()[(j, l)])
                    .sum()
            });
            mul_into(
                rotation.as_mut().subcols_mut(k, p),
                1.0,
                &complement,
                &right,
            );
            if parity.is_none() {
                let negative = determinant_sign(rotation.clone().as_mut()) < 0.0;
                parity = Some(u32::from(negative));
                if negative {
                    continue;
                }
            }
            let mut log = Mat::zeros(k + p, k + p);
            match self.log.log_into(log.as_mut(), rotation.as_ref()) {
                Ok(()) => {
                    let length = frobenius(&log);
                    let rotation = rotation.clone();
                    starts.push(Start {
                        rotation,
                        log,
                        length,
                    });
                }
                Err(error @ Error::OutsideLogDomain { .. }) => failure = error,
                Err(error) => return Err(error),
            }
        }
        if starts.is_empty() {
            return Err(failure);
        }
        starts.sort_by(|a, b| a.length.total_cmp(&b.length));
        Ok(starts)
    }

    /// Lowers the length over the fibre from a start; returns how many steps that took.
    ///
    /// # Errors
    /// `Interrupted`, `Decomposition`.
    pub(super) fn run(&mut self, start: &mut Start, interrupt: Interrupt<'_>) -> Result<usize> {
        let (k, p) = (self.k, self.p);
        for steps in 0..MAX_STEPS {
            interrupt.check("Riemannian logarithm")?;
            read_block(start.log.as_ref(), k, p, 1.0, &mut self.gradient);
            let size = norm(&self.gradient);
            if size <= GRADIENT {
                return Ok(steps);
            }
            self.newton_direction(start.log.as_ref());
            if !self.search(start, size)? {
                return Ok(steps + 1);
            }
        }
        Ok(MAX_STEPS)
    }

    /// `direction = -J^{-1} C`, or `-C` where that does not go down.
    fn newton_direction(&mut self, log: MatRef<'_, f64>) {
        let (k, p) = (self.k, self.p);
        self.adjoint.set(log, STEP_TOLERANCE);
        for (to, from) in self.direction.iter_mut().zip(&self.gradient) {
            *to = -from;
        }
        self.embedded.fill(0.0);
        let (adjoint, image, embedded) = (&mut self.adjoint, &mut self.image, &mut self.embedded);
        self.krylov
            .solve(&mut self.direction, STEP_TOLERANCE, |x, y| {
                write_block(x, embedded.as_mut(), k, p, 1.0);
                adjoint.apply_even(image, embedded);
                read_block(image.as_ref(), k, p, 1.0, y);
            });
        let sizes = norm(&self.direction) * norm(&self.gradient);
        if dot(&self.direction, &self.gradient) > -STEEPNESS * sizes {
            for (to, from) in self.direction.iter_mut().zip(&self.gradient) {
                *to = -from;
            }
        }
        let shrink = (MAX_LENGTH / norm(&self.direction)).min(1.0);
        self.direction.iter_mut().for_each(|x| *x *= shrink);
    }

    /// Halves the step until it lowers the length; `false` where none does.
    fn search(&mut self, start: &mut Start, size: f64) -> Result<bool> {
        let (k, p) = (self.k, self.p);
        let slope = dot(&self.direction, &self.gradient);
        write_block(&self.direction, self.step.as_mut(), 0, p, 1.0);
        let energy = 0.5 * start.length * start.length;
        let mut factor = 1.0;
        while factor >= MIN_STEP {
            self.exp
                .exp_into(self.turn.as_mut(), self.step.as_ref(), factor)?;
            self.trial.copy_from(&start.rotation);
            let free = start.rotation.as_ref().subcols(k, p);
            mul_into(self.trial.as_mut().subcols_mut(k, p), 1.0, free, &self.turn);
            match self
                .log
                .log_into(self.trial_log.as_mut(), self.trial.as_ref())
            {
                Ok(()) => {
                    let length = frobenius(&self.trial_log);
                    let lowered = 0.5 * length * length;
                    let block = self.trial_log.as_ref().submatrix(k, k, p, p);
                    // At the end round-off of the energy hides its decrease, but the gradient still shows it.
                    let flat = block.norm_l2() < size && lowered <= energy * (1.0 + 1e-13);
                    if lowered <= energy + SUFFICIENT_DECREASE * factor * slope || flat {
                        std::mem::swap(&mut start.rotation, &mut self.trial);
                        std::mem::swap(&mut start.log, &mut self.trial_log);
                        start.length = length;
                        return Ok(true);
                    }
                }
                Err(Error::OutsideLogDomain { .. }) => {}
                Err(error) => return Err(error),
            }
            factor *= 0.5;
        }
        Ok(false)
    }
}

impl Start {
    pub(super) fn log(&self) -> MatRef<'_, f64> {
        self.log.as_ref()
    }
}

/// Orthonormal columns orthogonal to those of `target`, shape `(m, m - k)`.
fn complement(target: MatRef<'_, f64>) -> Mat<f64> {
    let (m, k) = target.shape();
    let wide = Mat::from_fn(m, m + k, |i, j| {
        if j < k {
            target[(i, j)]
        } else {
            f64::from(u8::from(i == j - k))
        }
    });
    thin_q(wide.as_ref()).as_ref().subcols(k, m - k).to_owned()
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}
