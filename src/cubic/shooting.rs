//! Newton shooting for Riemannian cubics: from the end point and end velocity to the initial `x'` and `x''`.
//!
//! In coordinates in which the start is the identity, an end `(S1, V1)` gives the `2d` equations
//!
//! ```math
//! \mathrm{hor}(g^T S_1) = 0,\qquad \mathrm{hor}(g^T V_1) - x = 0\qquad\text{at } t = 1
//! ```
//!
//! with the horizontal part `hor(Y) = (skew(Y_1), Y_2)` of the upper and the lower block. Their exact derivatives come from the
//! Taylor recurrence on [dual numbers](crate::linalg::dual): a Jacobian for few unknowns, products with it inside of the
//! minimal residual method for many.

use faer::Mat;

use super::reduced::Blocks;
use super::taylor::{Accuracy, March};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::solve_square;
use crate::linalg::dual::{Dual, Number};
use crate::linalg::gmres::Gmres;
use crate::report::{SolverReport, StopReason};

pub(super) const SOLVER: &str = "shooting for a Riemannian cubic";

/// Unknowns up to which the whole Jacobian is formed.
const DENSE: usize = 24;

/// Directions that one pass of dual numbers carries.
const DIRECTIONS: usize = 8;

/// A step is accepted if it lowers the residual by this share of what the linear model predicts.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Halvings of a step before the direction is given up.
const MAX_HALVINGS: i32 = 8;

/// Residuals are integrated to this share of the square of the residual before: what Newton's method can gain.
const ACCURACY_SHARE: f64 = 1e-4;

/// Linear equations of many unknowns are solved to this share of the residual, or to the residual if that is less.
const FORCING: f64 = 0.1;

/// Work of a step on dual numbers with [`DIRECTIONS`] directions, in steps on plain numbers.
pub(super) const DUAL_WORK: f64 = 4.0;

/// The same with one direction.
const SINGLE_WORK: f64 = 2.0;

/// Taylor steps that one integration may take: curves that need more are too fast to be shot.
const MAX_STEPS: usize = 4_000;

/// Boundary data in coordinates in which the start is the identity, blocks column by column.
#[derive(Debug, Clone)]
pub(super) struct Target {
    /// `omega` and `b` of the initial velocity.
    pub(super) velocity: [Vec<f64>; 2],
    /// End point and end velocity, shape `(r, k)`.
    pub(super) end: [Vec<f64>; 2],
}

/// The boundary value problem for blocks of one size.
pub(super) struct Shooting<'a, B> {
    pub(super) blocks: B,
    pub(super) target: Target,
    /// Integration work so far, in units of [`work_of_step`].
    pub(super) work: f64,
    /// No further step is begun beyond this much work.
    pub(super) work_limit: f64,
    pub(super) plain: March<f64, B>,
    several: Option<March<Dual<DIRECTIONS>, B>>,
    single: Option<March<Dual<1>, B>>,
    interrupt: Interrupt<'a>,
}

/// Equations and how far the end is off.
pub(super) struct Residual<T> {
    pub(super) equations: Vec<T>,
    /// `(|S(1) - S1|^2 + |V(1) - V1|^2)^(1/2)`.
    pub(super) distance: f64,
}

impl<'a, B: Blocks> Shooting<'a, B> {
    pub(super) fn new(
        blocks: B,
        target: &Target,
        work_limit: f64,
        interrupt: Interrupt<'a>,
    ) -> Self {
        Shooting {
            blocks,
            target: target.clone(),
            work: 0.0,
            work_limit,
            plain: March::new(blocks, Accuracy::FULL),
            several: None,
            single: None,
            interrupt,
        }
    }

    /// Damped Newton from `y = (x', x'')`, in place.
    ///
    /// # Errors
    /// `Interrupted`, and where the start cannot be integrated.
    pub(super) fn solve(
        &mut self,
        y: &mut [f64],
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<SolverReport> {
        let mut accuracy = Accuracy::of_tolerance(ACCURACY_SHARE);
        let mut distance = self.residual(y, accuracy)?.distance;
        let mut iterations = 0;
        let reason = loop {
            if distance <= tolerance {
                if accuracy.truncation <= Accuracy::FULL.truncation {
                    break StopReason::Converged;
                }
                accuracy = Accuracy::FULL;
                distance = self.residual(y, accuracy)?.distance;
                continue;
            }
            if iterations == max_iterations || self.work > self.work_limit {
                break StopReason::MaxIterations;
            }
            accuracy = Accuracy::of_tolerance(ACCURACY_SHARE * distance * distance);
            let Some(step) = self.newton_step(y, accuracy, distance)? else {
                break StopReason::SingularJacobian;
            };
            let Some((accepted, nearer)) = self.descend(y, &step, accuracy, distance)? else {
                break StopReason::Stagnated;
            };
            y.copy_from_slice(&accepted);
            distance = nearer;
            iterations += 1;
        };
        Ok(SolverReport {
            converged: reason == StopReason::Converged,
            iterations,
            residual: distance,
            tolerance,
            reason,
        })
    }

    /// The first of the halved steps that brings the end nearer, and how near.
    fn descend(
        &mut self,
        y: &[f64],
        step: &[f64],
        accuracy: Accuracy,
        distance: f64,
    ) -> Result<Option<(Vec<f64>, f64)>> {
        for halving in 0..MAX_HALVINGS {
            self.interrupt.check(SOLVER)?;
            let damping = 0.5_f64.powi(halving);
            let trial: Vec<f64> = y.iter().zip(step).map(|(y, s)| y - damping * s).collect();
            match self.residual(&trial, accuracy) {
                Ok(found) if found.distance <= (1.0 - SUFFICIENT_DECREASE * damping) * distance => {
                    return Ok(Some((trial, found.distance)));
                }
                Err(error @ Error::Interrupted { .. }) => return Err(error),
                Ok(_) | Err(_) => {}
            }
        }
        Ok(None)
    }

    pub(super) fn residual(&mut self, y: &[f64], accuracy: Accuracy) -> Result<Residual<f64>> {
        self.plain.accuracy = accuracy;
        let found = evaluate(&mut self.plain, &self.target, y, self.interrupt);
        self.work += work_of_step(self.blocks) * self.plain.steps as f64;
        found
    }

    /// `DF(y)^{-1} F(y)`; none where the derivative is singular.
    fn newton_step(
        &mut self,
        y: &[f64],
        accuracy: Accuracy,
        distance: f64,
    ) -> Result<Option<Vec<f64>>> {
        self.interrupt.check(SOLVER)?;
        if y.len() > DENSE {
            return self.krylov_step(y, accuracy, distance);
        }
        let (jacobian, equations) = self.jacobian(y, accuracy)?;
        Ok(solve_square(jacobian.as_ref(), &equations))
    }

    /// The derivative of the equations, shape `(2d, 2d)`, and the equations.
    pub(super) fn jacobian(
        &mut self,
        y: &[f64],
        accuracy: Accuracy,
    ) -> Result<(Mat<f64>, Vec<f64>)> {
        let march = self
            .several
            .get_or_insert_with(|| March::new(self.blocks, Accuracy::FULL));
        march.accuracy = accuracy;
        let mut jacobian = Mat::zeros(y.len(), y.len());
        let mut equations = Vec::new();
        for first in (0..y.len()).step_by(DIRECTIONS) {
            let mut unknown: Vec<Dual<DIRECTIONS>> = y.iter().map(|y| Dual::constant(*y)).collect();
            let last = (first + DIRECTIONS).min(y.len());
            for direction in first..last {
                unknown[direction].slope[direction - first] = 1.0;
            }
            let found = evaluate(march, &self.target, &unknown, self.interrupt)?;
            self.work += DUAL_WORK * work_of_step(self.blocks) * march.steps as f64;
            for (row, equation) in found.equations.iter().enumerate() {
                for column in first..last {
                    jacobian[(row, column)] = equation.slope[column - first];
                }
            }
            equations = found.equations.iter().map(|f| f.value).collect();
        }
        Ok((jacobian, equations))
    }

    /// The Newton step from products with the derivative, the unknowns measured by what they do in flat space.
    fn krylov_step(
        &mut self,
        y: &[f64],
        accuracy: Accuracy,
        distance: f64,
    ) -> Result<Option<Vec<f64>>> {
        let equations = self.residual(y, accuracy)?.equations;
        let forcing = distance.min(FORCING);
        let march = self
            .single
            .get_or_insert_with(|| March::new(self.blocks, Accuracy::FULL));
        march.accuracy = Accuracy::of_tolerance(ACCURACY_SHARE * forcing);
        let (target, interrupt) = (&self.target, self.interrupt);
        let (mut failure, mut products) = (None, 0.0);
        let mut apply = |direction: &[f64], image: &mut [f64]| {
            products += 1.0;
            let slopes = flat_inverse(direction);
            let unknown: Vec<Dual<1>> = y
                .iter()
                .zip(&slopes)
                .map(|(y, s)| Dual {
                    value: *y,
                    slope: [*s],
                })
                .collect();
            match evaluate(march, target, &unknown, interrupt) {
                Ok(found) => {
                    for (image, equation) in image.iter_mut().zip(&found.equations) {
                        *image = equation.slope[0];
                    }
                }
                Err(error) => {
                    image.fill(0.0);
                    failure = Some(error);
                }
            }
        };
        let mut step = equations;
        Gmres::new(y.len()).solve(&mut step, forcing, &mut apply);
        self.work += products * SINGLE_WORK * work_of_step(self.blocks) * self.plain.steps as f64;
        if let Some(error) = failure {
            return Err(error);
        }
        let step = flat_inverse(&step);
        Ok(step.iter().all(|s| s.is_finite()).then_some(step))
    }
}

/// Products of numbers for one order of one Taylor step, about `r k (2 r + k)`: the unit in which work is counted.
pub(super) fn work_of_step(blocks: impl Blocks) -> f64 {
    let (m, k) = (blocks.m() as f64, blocks.k() as f64);
    (m + k) * k * (2.0 * m + 3.0 * k)
}

/// The changes of `(x', x'')` that move the end of a curve of flat space by minus the given equations:
/// `a = -6 s + 2 v`, `x'' = 12 s - 6 v`.
fn flat_inverse(equations: &[f64]) -> Vec<f64> {
    let (points, velocities) = equations.split_at(equations.len() / 2);
    let pairs = || points.iter().zip(velocities);
    let accelerations = pairs().map(|(s, v)| -6.0 * s + 2.0 * v);
    accelerations
        .chain(pairs().map(|(s, v)| 12.0 * s - 6.0 * v))
        .collect()
}

/// Integrates from `y = (x', x'')` and compares the end with the target.
fn evaluate<T: Number, B: Blocks>(
    march: &mut March<T, B>,
    target: &Target,
    y: &[T],
    interrupt: Interrupt<'_>,
) -> Result<Residual<T>> {
    let (m, k) = (march.blocks.m(), march.blocks.k());
    let r = m + k;
    start(march, target, y);
    march.run(1.0, interrupt, |_, _, _| Ok(()))?;
    let series = &march.series;
    let half = T::constant(0.5);
    let mut equations = Vec::with_capacity(y.len());
    let mut square = 0.0;
    // Components of the target in the frame at the end.
    let component = |column: &[T], of: &[f64]| {
        let mut sum = T::ZERO;
        for (x, y) in column.iter().zip(of) {
            sum += *x * *y;
        }
        sum
    };
    for (which, of) in target.end.iter().enumerate() {
        let upper: Vec<T> = (0..k * k)
            .map(|i| component(&series.s[r * (i % k)..][..r], &of[r * (i / k)..][..r]))
            .collect();
        for col in 0..k {
            for row in 0..k {
                let expected = match which {
                    0 => f64::from(u8::from(row == col)),
                    _ => series.omega[0][row + k * col].value(),
                };
                square += (upper[row + k * col].value() - expected).powi(2);
                if row < col {
                    let skew = (upper[row + k * col] - upper[col + k * row]) * half;
                    equations.push(match which {
                        0 => skew,
                        _ => skew - series.omega[0][row + k * col],
                    });
                }
            }
        }
        for col in 0..k {
            for row in 0..m {
                let lower = component(&series.e[r * row..][..r], &of[r * col..][..r]);
                let equation = match which {
                    0 => lower,
                    _ => lower - series.b[0][row + m * col],
                };
                square += equation.value().powi(2);
                equations.push(equation);
            }
        }
    }
    let distance = square.sqrt();
    if distance.is_finite() {
        return Ok(Residual {
            equations,
            distance,
        });
    }
    Err(Error::Overflow {
        quantity: "end of the curve",
    })
}

/// Puts a march at the start: the identity, the given velocity, `(x', x'') = y`.
fn start<T: Number, B: Blocks>(march: &mut March<T, B>, target: &Target, y: &[T]) {
    let (m, k) = (march.blocks.m(), march.blocks.k());
    let r = m + k;
    (march.time, march.steps, march.max_steps) = (0.0, 0, MAX_STEPS);
    let series = &mut march.series;
    for col in 0..r {
        for row in 0..r {
            let entry = T::constant(f64::from(u8::from(row == col)));
            match col.checked_sub(k) {
                None => series.s[row + r * col] = entry,
                Some(col) => series.e[row + r * col] = entry,
            }
        }
    }
    for (to, from) in series.omega[0].iter_mut().zip(&target.velocity[0]) {
        *to = T::constant(*from);
    }
    for (to, from) in series.b[0].iter_mut().zip(&target.velocity[1]) {
        *to = T::constant(*from);
    }
    let mut entries = y.iter();
    for derivative in 1..3 {
        let omega = &mut series.omega[derivative];
        for col in 0..k {
            omega[col + k * col] = T::ZERO;
            for row in 0..col {
                let entry = *entries.next().expect("as many as unknowns");
                omega[row + k * col] = entry;
                omega[col + k * row] = -entry;
            }
        }
        for (to, from) in series.b[derivative][..m * k].iter_mut().zip(&mut entries) {
            *to = *from;
        }
    }
}
