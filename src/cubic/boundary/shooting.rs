//! Newton shooting for Riemannian cubics: from the end point and end velocity to the initial `x'` and `x''`.
//!
//! The exact derivatives of the [equations](crate::cubic::boundary::end_equations) come from the Taylor recurrence on
//! [dual numbers](crate::linalg::dual). Problems with few unknowns use Newton's method. Larger ones use
//! [Broyden's](super::broyden), which starts from one Jacobian of low order, or from the Jacobian of flat space if even
//! one costs too much; if its steps fail, a Newton step is computed by GMRES from products with the derivative. At the
//! end of a descent with many unknowns the chain itself provides the response of the start to a motion of the end.

use faer::Mat;

use super::broyden::{Broyden, InitialJacobian};
use crate::cubic::boundary::end_equations::{EndResidual, Target, evaluate, flat_inverse};
use crate::cubic::taylor::blocks::BlockSizes;
use crate::cubic::taylor::march::{Accuracy, TaylorMarch};
use crate::cubic::taylor::work::{TRIALS, Work, work_of_curve, work_of_step};
use crate::error::{Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::solve_square;
use crate::linalg::dual::{Dual, jacobian};
use crate::manifold::only_bases::Appearance;
use crate::report::{SolverReport, StopReason};
use crate::shooting::StartResponse;
use crate::solve::gmres::Gmres;
use crate::solve::line_search::backtracked;

pub(crate) const SOLVER: &str = "shooting for a Riemannian cubic";

/// Number of unknowns up to which every step computes a Jacobian.
const FEW: usize = 6;

/// Number of unknowns up to which a Jacobian is computed at all.
const DENSE: usize = 64;

/// Integration accuracy of the initial Jacobian of Broyden's method.
const ROUGH: f64 = 1e-3;

/// A step of Broyden's method that leaves more than this fraction of the residual is rejected.
const USELESS: f64 = 0.9;

/// A step that leaves more than this fraction of the residual justifies another Jacobian.
const SLOW: f64 = 0.1;

/// Number of lengths of a Newton step that are tried.
const STEP_LENGTHS: i32 = 8;

/// Integration accuracy of residuals, relative to the residual that the next step can reach.
const ACCURACY_SHARE: f64 = 1e-4;

/// Integration accuracy of Jacobians, relative to the residual: the remaining error is of second order, as in Newton's
/// method.
const JACOBIAN_SHARE: f64 = 1e-2;

/// The same for Broyden's method, which gains less per step.
const LINEAR_SHARE: f64 = 1e-4;

/// Residuals above this are not round-off.
pub(crate) const ROUND_OFF: f64 = 1e-9;

/// Relative change of the start used to measure the round-off of the end: a solution cannot be known more accurately.
const LAST_DIGITS: f64 = 16.0 * f64::EPSILON;

/// Relative residual to which large linear systems are solved, or the residual itself if it is smaller.
const FORCING: f64 = 0.1;

/// Work of a step on dual numbers, in units of a step on real numbers.
const DUAL_WORK: f64 = 4.0;

/// The same for a single direction.
const SINGLE_WORK: f64 = 2.0;

/// Integration accuracy of the first residuals at the start of a chain at rest: a descent leaves a residual of about
/// this size.
const RESPONSE_ACCURACY: f64 = 1e-9;

/// Whether a problem with this many unknowns uses the response of a chain at rest. With it, 40 hard problems on
/// St(4,2), (5,2), (6,3) and (10,3) take 1.14, 1.07, 1.02 and 1.20 times the instructions; without it, one of 60 on
/// St(12,4) is not solved.
pub(crate) fn takes_response(unknowns: usize) -> bool {
    unknowns > DENSE
}

/// The boundary value problem for blocks of one size; a pass of dual numbers carries `N` directions.
pub(crate) struct SingleShooting<'a, B, const N: usize> {
    pub(crate) blocks: B,
    pub(crate) target: Target,
    pub(crate) work: Work,
    pub(crate) plain: TaylorMarch<f64, B>,
    several: Option<TaylorMarch<Dual<N>, B>>,
    single: Option<TaylorMarch<Dual<1>, B>>,
    interrupt: Interrupt<'a>,
}

impl<'a, B: BlockSizes, const N: usize> SingleShooting<'a, B, N> {
    pub(crate) fn new(blocks: B, target: &Target, interrupt: Interrupt<'a>) -> Self {
        SingleShooting {
            blocks,
            target: target.clone(),
            work: Work::of_trials(TRIALS, work_of_curve(blocks), Appearance::Usual),
            plain: TaylorMarch::new(blocks, Accuracy::FULL),
            several: None,
            single: None,
            interrupt,
        }
    }

    /// Damped Newton from `y = (x', x'')`, in place; if `y` is the start of a chain at rest, steps with the chain's
    /// response come first.
    ///
    /// # Errors
    /// `Interrupted`, and an error if the start cannot be integrated.
    pub(crate) fn solve(
        &mut self,
        y: &mut [f64],
        response: Option<&StartResponse>,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<SolverReport> {
        let mut accuracy = Accuracy::of_tolerance(match response {
            Some(_) => RESPONSE_ACCURACY,
            None => ACCURACY_SHARE,
        });
        let mut found = self.residual(y, accuracy)?;
        // Accuracy of the current residual.
        let mut known = accuracy;
        let mut broyden =
            Broyden::new(response.map_or(InitialJacobian::Flat, InitialJacobian::Response));
        let (mut iterations, mut reached) = (0, tolerance);
        let reason = loop {
            if found.distance <= tolerance {
                if accuracy.truncation <= Accuracy::FULL.truncation {
                    break StopReason::Converged;
                }
                (accuracy, known) = (Accuracy::FULL, Accuracy::FULL);
                found = self.residual(y, accuracy)?;
                continue;
            }
            if iterations == max_iterations {
                break StopReason::MaxIterations;
            }
            if self.work.is_done() {
                break StopReason::WorkLimit;
            }
            iterations += 1;
            if y.len() > FEW {
                accuracy = Accuracy::of_tolerance(LINEAR_SHARE * found.distance);
                if let Some(nearer) = self.broyden_step(y, &found, accuracy, &mut broyden)? {
                    (found, known) = (nearer, accuracy);
                    continue;
                }
                broyden = Broyden::new(InitialJacobian::Flat);
            }
            let Some(step) = self.newton_step(y, &found)? else {
                break StopReason::SingularJacobian;
            };
            // The next residual decides about the step after it: twice the gain of Newton's method.
            let next = found.distance.powi(4);
            accuracy = accuracy.finer(Accuracy::of_tolerance(ACCURACY_SHARE * next.min(1.0)));
            let Some((accepted, nearer)) = self.descend(y, &step, accuracy, found.distance)? else {
                if known.truncation > Accuracy::FULL.truncation {
                    // A residual of low accuracy may be small by chance.
                    (accuracy, known) = (Accuracy::FULL, Accuracy::FULL);
                    found = self.residual(y, accuracy)?;
                    continue;
                }
                if found.distance < ROUND_OFF && found.distance <= self.noise(y, &found)? {
                    reached = found.distance;
                    break StopReason::Converged;
                }
                break StopReason::Stagnated;
            };
            y.copy_from_slice(&accepted);
            (found, known) = (nearer, accuracy);
        };
        Ok(SolverReport::new(
            reason,
            iterations,
            found.distance,
            reached,
        ))
    }

    /// A bound on the round-off in the distance of the end: the effect of changing the last digits of the start.
    fn noise(&mut self, y: &[f64], found: &EndResidual<f64>) -> Result<f64> {
        let digit = |i: usize| 1.0 + LAST_DIGITS * [1.0, -1.0][i % 2];
        let beside: Vec<f64> = y.iter().enumerate().map(|(i, y)| digit(i) * y).collect();
        let beside = self.residual(&beside, Accuracy::FULL)?;
        let pairs = beside.equations.iter().zip(&found.equations);
        let squares = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        Ok((self.blocks.weight() * squares).sqrt())
    }

    /// A step of Broyden's method; `None` if it was rejected.
    fn broyden_step(
        &mut self,
        y: &mut [f64],
        found: &EndResidual<f64>,
        accuracy: Accuracy,
        broyden: &mut Broyden<'_>,
    ) -> Result<Option<EndResidual<f64>>> {
        if matches!(broyden.start, InitialJacobian::Flat) && y.len() <= DENSE {
            let (jacobian, _) = self.jacobian(y, Accuracy::of_tolerance(ROUGH))?;
            *broyden = Broyden::new(InitialJacobian::Jacobian(jacobian));
        }
        let Some(step) = broyden.step(&found.equations) else {
            return Ok(None);
        };
        let trial: Vec<f64> = y.iter().zip(&step).map(|(y, s)| y + s).collect();
        let Some(nearer) = unless_interrupted(self.residual(&trial, accuracy))? else {
            return Ok(None);
        };
        if nearer.distance > USELESS * found.distance {
            return Ok(None);
        }
        y.copy_from_slice(&trial);
        // The response costs nothing more, so its steps continue as long as they help.
        let has_response = matches!(broyden.start, InitialJacobian::Response(_));
        if y.len() <= DENSE && nearer.distance > SLOW * found.distance && !has_response {
            *broyden = Broyden::new(InitialJacobian::Flat);
        }
        Ok(Some(nearer))
    }

    /// The first halved step that brings the end nearer, and the new residual.
    fn descend(
        &mut self,
        y: &[f64],
        step: &[f64],
        accuracy: Accuracy,
        distance: f64,
    ) -> Result<Option<(Vec<f64>, EndResidual<f64>)>> {
        let found = backtracked(distance, STEP_LENGTHS, |share| {
            self.interrupt.check(SOLVER)?;
            let trial: Vec<f64> = y.iter().zip(step).map(|(y, s)| y - share * s).collect();
            let found = unless_interrupted(self.residual(&trial, accuracy))?;
            Ok(found.map(|found| (found.distance, (trial, found))))
        })?;
        Ok(found.map(|(state, _)| state))
    }

    pub(crate) fn residual(&mut self, y: &[f64], accuracy: Accuracy) -> Result<EndResidual<f64>> {
        self.plain.accuracy = accuracy;
        let found = evaluate(&mut self.plain, &self.target, y, self.interrupt);
        self.work
            .count(work_of_step(self.blocks) * self.plain.steps as f64);
        found
    }

    /// `DF(y)^{-1} F(y)`; `None` if the derivative is singular.
    fn newton_step(&mut self, y: &[f64], found: &EndResidual<f64>) -> Result<Option<Vec<f64>>> {
        self.interrupt.check(SOLVER)?;
        if y.len() > FEW {
            return self.krylov_step(y, found);
        }
        let accuracy = Accuracy::of_tolerance(JACOBIAN_SHARE * found.distance.min(1.0));
        let (jacobian, _) = self.jacobian(y, accuracy)?;
        Ok(solve_square(jacobian.as_ref(), &found.equations))
    }

    /// The derivative of the equations, shape `(2d, 2d)`, and the equations.
    pub(crate) fn jacobian(
        &mut self,
        y: &[f64],
        accuracy: Accuracy,
    ) -> Result<(Mat<f64>, Vec<f64>)> {
        let march = self
            .several
            .get_or_insert_with(|| TaylorMarch::new(self.blocks, Accuracy::FULL));
        march.accuracy = accuracy;
        jacobian(y, |unknown| {
            let outcome = evaluate(march, &self.target, unknown, self.interrupt);
            self.work
                .count(DUAL_WORK * work_of_step(self.blocks) * march.steps as f64);
            Ok(outcome?.equations)
        })
    }

    /// The Newton step from products with the derivative; unknowns are scaled by their effect in flat space.
    fn krylov_step(&mut self, y: &[f64], found: &EndResidual<f64>) -> Result<Option<Vec<f64>>> {
        let forcing = found.distance.min(FORCING);
        let march = self
            .single
            .get_or_insert_with(|| TaylorMarch::new(self.blocks, Accuracy::FULL));
        march.accuracy = Accuracy::of_tolerance(ACCURACY_SHARE * forcing);
        let (target, interrupt) = (&self.target, self.interrupt);
        let mut steps = 0;
        let mut step = found.equations.clone();
        let solved = Gmres::new(y.len()).try_solve(&mut step, forcing, |direction, image| {
            let slopes = flat_inverse(direction);
            let dual = |(&value, &slope): (&f64, &f64)| Dual {
                value,
                slope: [slope],
            };
            let unknown: Vec<Dual<1>> = y.iter().zip(&slopes).map(dual).collect();
            let outcome = evaluate(march, target, &unknown, interrupt);
            steps += march.steps;
            for (image, equation) in image.iter_mut().zip(&outcome?.equations) {
                *image = equation.slope[0];
            }
            Result::Ok(())
        });
        self.work
            .count(SINGLE_WORK * work_of_step(self.blocks) * steps as f64);
        solved?;
        let step = flat_inverse(&step);
        Ok(step.iter().all(|s| s.is_finite()).then_some(step))
    }
}
