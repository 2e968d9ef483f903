//! Newton's method for the exponential: the geodesic that reaches a given point, in `k + p` dimensions.
//!
//! The unknown is the generator `L = [[2 w A, -B^T], [B, 0]]`; the equation, for the coordinates `X` of the target,
//!
//! ```math
//! e^L \begin{bmatrix} I \\ 0 \end{bmatrix} = X e^{-\nu A},\qquad \nu = 1 - 2w
//! ```
//!
//! At an iterate `D = e^{-L} X e^{-nu A}` is close to `[I; 0]`, that is to the first columns of `e^Delta` for a small
//! skew `Delta`. The derivative of the logarithm at `e^L`, `f(ad_L)`, turns `Delta` into a correction of `L`. The
//! action of `e^L` on the other `p` columns is free; it is described by a skew `Gamma` in their block of `Delta`,
//! chosen such that this block of the corrected `L` stays zero. Neither a completion of `X` to a rotation nor a
//! logarithm is needed, and each step takes one exponential. With the terms of second order in `Delta` (canonical
//! metric) the order of convergence is 3 up to the error of `f`.

mod damped;

use faer::{Mat, MatRef};

use super::adjoint::{AdjointFunction, bracket, frobenius};
use crate::error::Result;
use crate::linalg::SkewExp;
use crate::linalg::product::{mul_add, mul_into};
use crate::solve::gmres::Gmres;

/// Range of the tolerance of a step, relative to the size of `Delta`.
const STEP_TOLERANCE: std::ops::RangeInclusive<f64> = 1e-8..=1e-3;

/// Each step from a close start must reduce the residual by this factor; otherwise the points are not close.
pub(super) const CLOSE_CONTRACTION: f64 = 0.3;

/// Maximal number of Newton steps from a close start.
pub(super) const CLOSE_STEPS: usize = 10;

/// Maximal number of terms of the series of `(1 - e^{-x}) / x`, enough for arguments up to 20.
const DEXP_TERMS: usize = 80;

pub(super) struct GeodesicShooting {
    k: usize,
    p: usize,
    /// `2 w` and `1 - 2 w`.
    twice: f64,
    nu: f64,
    target: Mat<f64>,
    pub(super) generator: Mat<f64>,
    exp: SkewExp,
    rotation: Mat<f64>,
    turn_exp: SkewExp,
    turn: Mat<f64>,
    /// `D - [I; 0]`.
    defect: Mat<f64>,
    work: Mat<f64>,
    delta: Mat<f64>,
    image: Mat<f64>,
    other: Mat<f64>,
    product: Mat<f64>,
    small: [Mat<f64>; 4],
    tall: Mat<f64>,
    /// Buffers of shape `(p, p)`, for the free block.
    free: [Mat<f64>; 3],
    adjoint: AdjointFunction,
    krylov: Gmres,
    unknown: Vec<f64>,
}

/// The result of a run.
#[derive(Clone, Copy)]
pub(super) struct ShootingOutcome {
    pub(super) converged: bool,
    pub(super) iterations: usize,
    pub(super) residual: f64,
}

impl ShootingOutcome {
    /// The result before any attempt.
    pub(super) const NONE: ShootingOutcome = ShootingOutcome {
        converged: false,
        iterations: 0,
        residual: f64::INFINITY,
    };
}

impl GeodesicShooting {
    /// Built for a target `X` of shape `(k + p, k)` with orthonormal columns, and the weight `w` of the metric.
    pub(super) fn new(target: &Mat<f64>, weight: f64) -> Self {
        let (m, k) = target.shape();
        let p = m - k;
        let twice = 2.0 * weight;
        let nu = 1.0 - twice;
        let turning = if nu == 0.0 { 0 } else { k };
        let square = || Mat::zeros(m, m);
        let size = if turning == 0 { p * p } else { k * k + p * k };
        GeodesicShooting {
            k,
            p,
            twice,
            nu,
            target: target.clone(),
            generator: square(),
            exp: SkewExp::new(m),
            rotation: square(),
            turn_exp: SkewExp::new(turning),
            turn: Mat::zeros(turning, turning),
            defect: Mat::zeros(m, k),
            work: Mat::zeros(m, k),
            delta: square(),
            image: square(),
            other: square(),
            product: square(),
            small: std::array::from_fn(|_| Mat::zeros(k, k)),
            tall: Mat::zeros(p, k),
            free: std::array::from_fn(|_| Mat::zeros(p, p)),
            adjoint: AdjointFunction::new(m),
            krylov: Gmres::new(size),
            unknown: vec![0.0; size],
        }
    }

    /// Switches to another metric of the family, with the generator for the same `A` and `B`.
    pub(super) fn set_weight(&mut self, weight: f64) {
        let factor = 2.0 * weight / self.twice;
        for j in 0..self.k {
            for i in 0..self.k {
                self.generator[(i, j)] *= factor;
            }
        }
        self.twice = 2.0 * weight;
        self.nu = 1.0 - self.twice;
    }

    /// Starts as if the target were close: `L = Delta` for `D = X`.
    pub(super) fn start_close(&mut self) {
        self.defect.copy_from(&self.target);
        for i in 0..self.k {
            self.defect[(i, i)] -= 1.0;
        }
        self.extract();
        let (k, twice) = (self.k, self.twice);
        self.generator.copy_from(&self.delta);
        for j in 0..k {
            for i in 0..k {
                self.generator[(i, j)] *= twice;
            }
        }
    }

    /// Starts from a canonical generator, whose lower right block is dropped.
    pub(super) fn start_from(&mut self, generator: MatRef<'_, f64>) {
        self.generator.copy_from(generator);
        let (k, p) = (self.k, self.p);
        self.generator.as_mut().submatrix_mut(k, k, p, p).fill(0.0);
    }

    /// `|A|_F` and `|B|_F`.
    pub(super) fn norms(&self) -> (f64, f64) {
        let (k, p) = (self.k, self.p);
        let block = |i, rows| self.generator.as_ref().submatrix(i, 0, rows, k).norm_l2();
        (block(0, k) / self.twice, block(k, p))
    }

    /// Takes steps until the residual is at most `tolerance`, as long as each reduces it by the given factor.
    ///
    /// # Errors
    /// The errors of the exponential.
    pub(super) fn run(
        &mut self,
        tolerance: f64,
        contraction: f64,
        max_iterations: usize,
    ) -> Result<ShootingOutcome> {
        let mut residual = self.residual()?;
        let mut iterations = 0;
        while residual > tolerance && iterations < max_iterations {
            self.step(residual, tolerance);
            iterations += 1;
            let next = self.residual()?;
            let contracts = next <= contraction * residual || next <= tolerance;
            residual = next;
            if !contracts {
                break;
            }
        }
        Ok(ShootingOutcome {
            converged: residual <= tolerance,
            iterations,
            residual,
        })
    }

    /// `|e^{-L} X e^{-nu A} - [I; 0]|_F`, which is the distance of the geodesic's end from the target.
    pub(super) fn residual(&mut self) -> Result<f64> {
        let k = self.k;
        self.exp
            .exp_into(self.rotation.as_mut(), self.generator.as_ref(), 1.0)?;
        if self.nu == 0.0 {
            mul_into(
                &mut self.defect,
                1.0,
                self.rotation.transpose(),
                &self.target,
            );
        } else {
            let a = self.generator.as_ref().submatrix(0, 0, k, k);
            self.turn_exp
                .exp_into(self.turn.as_mut(), a, -self.nu / self.twice)?;
            mul_into(&mut self.work, 1.0, self.rotation.transpose(), &self.target);
            mul_into(&mut self.defect, 1.0, &self.work, &self.turn);
        }
        for i in 0..k {
            self.defect[(i, i)] -= 1.0;
        }
        Ok(frobenius(&self.defect))
    }

    /// `Delta = [[W, -Z^T], [Z, 0]]` such that the first columns of `e^Delta` equal `D`, up to fourth order.
    fn extract(&mut self) {
        let (k, p) = (self.k, self.p);
        let [w, zz, square, cube] = &mut self.small;
        let z = self.defect.as_ref().submatrix(k, 0, p, k);
        for j in 0..k {
            for i in 0..k {
                w[(i, j)] = 0.5 * (self.defect[(i, j)] - self.defect[(j, i)]);
            }
        }
        mul_into(&mut *zz, 1.0, z.transpose(), z);
        mul_into(&mut *square, 1.0, &*w, &*w);
        for j in 0..k {
            for i in 0..k {
                square[(i, j)] -= zz[(i, j)];
            }
        }
        // W = w - (w^3 - z^T z w - w z^T z) / 6 and Z = z - z (w/2 + (w^2 - z^T z) / 6).
        mul_into(&mut *cube, 1.0, &*square, &*w);
        mul_add(&mut *cube, -1.0, &*w, &*zz);
        for j in 0..k {
            for i in 0..k {
                self.delta[(i, j)] = w[(i, j)] - (cube[(i, j)] - cube[(j, i)]) / 12.0;
                square[(i, j)] = 0.5 * w[(i, j)] + square[(i, j)] / 6.0;
            }
        }
        mul_into(&mut self.tall, 1.0, z, &*square);
        for j in 0..k {
            for i in 0..p {
                let entry = z[(i, j)] - self.tall[(i, j)];
                self.delta[(k + i, j)] = entry;
                self.delta[(j, k + i)] = -entry;
            }
        }
        self.delta.as_mut().submatrix_mut(k, k, p, p).fill(0.0);
    }

    /// One Newton step, no more accurate than necessary: the remaining residual is about `residual^3 + tolerance
    /// residual`.
    fn step(&mut self, residual: f64, goal: f64) {
        let last = 0.2 * goal / residual;
        let tolerance = if last < *STEP_TOLERANCE.start() {
            0.03 * residual
        } else {
            last
        };
        let tolerance = tolerance.clamp(*STEP_TOLERANCE.start(), *STEP_TOLERANCE.end());
        self.extract();
        if self.nu != 0.0 {
            self.solve_turning(tolerance);
            return self.update_turning();
        }
        self.adjoint.set(self.generator.as_ref(), tolerance);
        if self.p > 1 {
            self.adjoint.apply(&mut self.image, &self.delta);
            let (k, p) = (self.k, self.p);
            read_block(self.image.as_ref(), k, p, -1.0, &mut self.unknown);
            self.solve_free_block(tolerance);
            write_block(&self.unknown, self.delta.as_mut(), k, p, 1.0);
            // e^Delta e^Gamma = e^{Delta + Gamma + [Delta, Gamma] / 2 + ..}.
            let tall = self.delta.as_ref().submatrix(k, 0, p, k);
            let gamma = self.delta.as_ref().submatrix(k, k, p, p);
            mul_into(&mut self.tall, 0.5, gamma, tall);
            for j in 0..k {
                for i in 0..p {
                    self.delta[(k + i, j)] -= self.tall[(i, j)];
                    self.delta[(j, k + i)] += self.tall[(i, j)];
                }
            }
        }
        self.adjoint.apply(&mut self.image, &self.delta);
        self.second_order();
        self.update();
    }

    /// `image -= [Delta, [L, Delta]] / 12`, the quadratic term of the Baker-Campbell-Hausdorff series.
    fn second_order(&mut self) {
        self.adjoint.bracket_into(&mut self.other, &self.delta);
        // `rotation` is unused until the next residual.
        bracket(
            &mut self.rotation,
            &self.delta,
            &self.other,
            &mut self.product,
        );
        let m = self.image.nrows();
        for j in 0..m {
            for i in 0..m {
                self.image[(i, j)] -= self.rotation[(i, j)] / 12.0;
            }
        }
    }

    /// Adds the correction. The remaining part of the free block (of higher order) is removed by a rotation: `e =
    /// -image_22` changes the other blocks by `[L, e] / 2`.
    fn update(&mut self) {
        let (k, p) = (self.k, self.p);
        let rest = self.image.as_ref().submatrix(k, k, p, p);
        let b = self.generator.as_ref().submatrix(k, 0, p, k);
        mul_into(&mut self.tall, 0.5, rest, b);
        for j in 0..k {
            for i in 0..k {
                self.generator[(i, j)] += self.image[(i, j)];
            }
            for i in 0..p {
                let entry = self.generator[(k + i, j)] + self.image[(k + i, j)] + self.tall[(i, j)];
                self.generator[(k + i, j)] = entry;
                self.generator[(j, k + i)] = -entry;
            }
        }
    }

    /// Solves `[g(-ad_L^2) diag(0, Gamma)]_22 = unknown` for `Gamma`.
    ///
    /// To second order in `L` the operator is `Gamma -> Gamma - (B B^T Gamma + Gamma B B^T) / 12`; with the opposite
    /// sign it is a preconditioner that takes one small product and halves the number of directions.
    fn solve_free_block(&mut self, tolerance: f64) {
        let (k, p) = (self.k, self.p);
        let b = self.generator.as_ref().submatrix(k, 0, p, k);
        mul_into(&mut self.free[0], 1.0 / 12.0, b, b.transpose());
        let [gram, gamma, product] = &mut self.free;
        let mut precondition = |x: &[f64], out: &mut Mat<f64>| {
            write_block(x, gamma.as_mut(), 0, p, 1.0);
            mul_into(&mut *product, 1.0, &*gram, &*gamma);
            for j in 0..p {
                for i in 0..p {
                    // Gamma G = -(G Gamma)^T.
                    out[(k + i, k + j)] = gamma[(i, j)] + product[(i, j)] - product[(j, i)];
                }
            }
        };
        let (adjoint, image, other) = (&mut self.adjoint, &mut self.image, &mut self.other);
        other.fill(0.0);
        self.krylov.solve(&mut self.unknown, tolerance, |x, y| {
            precondition(x, other);
            adjoint.apply_even(image, other);
            read_block(image.as_ref(), k, p, 1.0, y);
        });
        precondition(&self.unknown, other);
        read_block(other.as_ref(), k, p, 1.0, &mut self.unknown);
    }

    /// Solves for `delta A` and `delta B` for a metric with `nu != 0`, whose generator may have angles above pi. There
    /// `f` has poles, so the derivative of the exponential is used instead, which is entire.
    ///
    /// ```math
    /// [\phi(\mathrm{ad}_L)\, \delta L]_{\cdot 1} - \begin{bmatrix} H \\ 0 \end{bmatrix} = \Delta_{\cdot 1},\qquad
    /// H = -\nu\, \phi(-\nu\, \mathrm{ad}_A)\, \delta A,\qquad \phi(x) = \frac{1 - e^{-x}}{x}
    /// ```
    fn solve_turning(&mut self, tolerance: f64) {
        self.prepare_turning();
        // Taken out of `self`, whose other fields the operator needs; this does not allocate.
        let mut krylov = std::mem::replace(&mut self.krylov, Gmres::new(0));
        let mut unknown = std::mem::take(&mut self.unknown);
        krylov.solve(&mut unknown, tolerance, |x, y| self.turning_operator(x, y));
        (self.krylov, self.unknown) = (krylov, unknown);
    }

    /// Sets `unknown` to the right-hand side `Delta`, and fills the buffers of the operator.
    fn prepare_turning(&mut self) {
        let (k, p) = (self.k, self.p);
        read_block(self.delta.as_ref(), 0, k, 1.0, &mut self.unknown[..k * k]);
        for j in 0..k {
            for i in 0..p {
                self.unknown[k * k + j * p + i] = self.delta[(k + i, j)];
            }
        }
        self.small[0].copy_from(self.generator.as_ref().submatrix(0, 0, k, k));
        self.other.fill(0.0);
    }

    fn turning_operator(&mut self, x: &[f64], y: &mut [f64]) {
        let (k, p, nu, twice) = (self.k, self.p, self.nu, self.twice);
        let [a, term, bracketed, sum] = &mut self.small;
        let (other, image, rotation) = (&mut self.other, &mut self.image, &mut self.rotation);
        let (product, small_product) = (&mut self.product, &mut self.turn);
        let (change, tall) = x.split_at(k * k);
        write_block(change, other.as_mut(), 0, k, twice);
        other.as_mut().submatrix_mut(k, k, p, p).fill(0.0);
        for j in 0..k {
            for i in 0..p {
                other[(k + i, j)] = tall[j * p + i];
                other[(j, k + i)] = -tall[j * p + i];
            }
        }
        dexp(&self.generator, 1.0, other, rotation, image, product);
        write_block(change, term.as_mut(), 0, k, 1.0);
        dexp(a, -nu / twice, term, bracketed, sum, small_product);
        for j in 0..k {
            for i in 0..k {
                y[j * k + i] = image[(i, j)] + nu * sum[(i, j)];
            }
            for i in 0..p {
                y[k * k + j * p + i] = image[(k + i, j)];
            }
        }
    }

    /// `A += delta A`, `B += delta B`.
    fn update_turning(&mut self) {
        let (k, p) = (self.k, self.p);
        let (change, tall) = self.unknown.split_at(k * k);
        for j in 0..k {
            for i in 0..k {
                self.generator[(i, j)] +=
                    0.5 * self.twice * (change[j * k + i] - change[i * k + j]);
            }
            for i in 0..p {
                let entry = self.generator[(k + i, j)] + tall[j * p + i];
                self.generator[(k + i, j)] = entry;
                self.generator[(j, k + i)] = -entry;
            }
        }
    }
}

/// `sum = phi(ad_{s a}) term` with `phi(x) = (1 - e^{-x}) / x`, by its series.
fn dexp(
    a: &Mat<f64>,
    s: f64,
    term: &mut Mat<f64>,
    bracketed: &mut Mat<f64>,
    sum: &mut Mat<f64>,
    product: &mut Mat<f64>,
) {
    sum.copy_from(&*term);
    let size = frobenius(term);
    for j in 2..DEXP_TERMS {
        bracket(bracketed, a, term, product);
        let factor = -s / j as f64;
        let k = a.nrows();
        for c in 0..k {
            for r in 0..k {
                term[(r, c)] = factor * bracketed[(r, c)];
                sum[(r, c)] += term[(r, c)];
            }
        }
        if frobenius(term) <= f64::EPSILON * size {
            return;
        }
    }
}

/// Reads a diagonal block of `source`, times a factor, in column-major order.
pub(super) fn read_block(
    source: MatRef<'_, f64>,
    start: usize,
    size: usize,
    factor: f64,
    out: &mut [f64],
) {
    for j in 0..size {
        for i in 0..size {
            out[j * size + i] = factor * source[(start + i, start + j)];
        }
    }
}

/// The inverse of [`read_block`].
pub(super) fn write_block(
    source: &[f64],
    mut out: faer::MatMut<'_, f64>,
    start: usize,
    size: usize,
    factor: f64,
) {
    for j in 0..size {
        for i in 0..size {
            out[(start + i, start + j)] = factor * source[j * size + i];
        }
    }
}
