//! Iterative solution of the equations of a spline. Steps of flat space cost almost nothing; if they converge slowly,
//! steps of the linearised equations are used, which are kept as long as they are effective. Both use Anderson mixing.
//! If no derivatives are available, Newton steps are computed by GMRES with difference quotients, preconditioned by the
//! step of flat space.

use super::chain::Chain;
use super::interpolation::{ChainResidual, Interpolation};
use super::linearised::LinearisedChain;
use super::motion::Motion;
use super::solution::{ChainSolution, Effort};
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::work::Work;
use crate::error::{Result, unless_interrupted};
use crate::legs::ROUND_OFF;
use crate::report::{SolverReport, StopReason};
use crate::solve::anderson::Anderson;
use crate::solve::gmres::norm;
use crate::solve::line_search::backtracked;
use crate::solve::newton_krylov::newton_step;

pub(crate) const SOLVER: &str = "spline of Riemannian cubics";

/// Number of past steps used by Anderson mixing.
const DEPTH: usize = 6;

/// Integration accuracy of residuals, relative to the previous residual: a step seldom leaves less than 1/200 of it,
/// and the errors at the ends of legs are much smaller than the last terms of the steps.
const ACCURACY_SHARE: f64 = 5e-4;

/// Typical number of steps with the linear equations after they are set up.
const LINEAR_STEPS: f64 = 5.0;

/// The linear equations are set up anew if a step leaves more than this fraction of the residual.
const SLOW: f64 = 0.2;

/// Number of consecutive steps of flat space that may leave more than half of the smallest residual so far, if no
/// derivatives are available.
const PATIENCE: usize = 8;

/// Integration accuracy of residuals in difference quotients.
const DIFFERENCE_ACCURACY: f64 = 1e-11;

/// Relative residual to which GMRES solves the linear equations.
const KRYLOV_SHARE: f64 = 1e-2;

/// Number of lengths of a Newton step that are tried.
const STEP_LENGTHS: i32 = 8;

/// The method of the next step.
enum Method {
    Flat,
    Linear(Box<LinearisedChain>),
    Krylov,
}

/// The state of the iteration.
pub(crate) struct ChainIteration<'p, 'c, C> {
    problem: &'p Interpolation<'c, C>,
    work: &'p Work,
    motion: Motion,
    found: ChainResidual,
    accuracy: Accuracy,
    method: Method,
    mixing: Anderson,
    /// Ratio of the residuals after and before the last step.
    rate: f64,
    /// The smallest residual when it was last halved, and the number of steps since.
    least: f64,
    failures: usize,
}

impl<'p, 'c, C: Chain> ChainIteration<'p, 'c, C> {
    /// # Errors
    /// An error if the start cannot be integrated; `Interrupted`.
    fn new(problem: &'p Interpolation<'c, C>, motion: Motion, work: &'p Work) -> Result<Self> {
        let accuracy = Accuracy::of_tolerance(ACCURACY_SHARE);
        let found = problem.residual(&motion, accuracy, work)?;
        Ok(ChainIteration {
            problem,
            work,
            least: found.size,
            found,
            motion,
            accuracy,
            method: Method::Flat,
            mixing: Anderson::new(DEPTH),
            rate: 0.0,
            failures: 0,
        })
    }

    /// Solves the equations, starting from a motion.
    ///
    /// # Errors
    /// An error if the start cannot be integrated; `Interrupted`.
    pub(crate) fn solve(
        problem: &'p Interpolation<'c, C>,
        motion: Motion,
        effort: Effort<'p>,
    ) -> Result<ChainSolution> {
        Self::new(problem, motion, effort.work)?.run(effort)
    }

    /// Solves the equations from a motion near a solution: by Newton's method from the first step on if derivatives are
    /// available. Steps of flat space might lead to another solution.
    ///
    /// # Errors
    /// As [`ChainIteration::solve`].
    pub(crate) fn solve_near(
        problem: &'p Interpolation<'c, C>,
        motion: Motion,
        effort: Effort<'p>,
    ) -> Result<ChainSolution> {
        let mut this = Self::new(problem, motion, effort.work)?;
        if this.has_derivatives() {
            this.linearise()?;
        }
        this.run(effort)
    }

    fn run(mut self, effort: Effort<'_>) -> Result<ChainSolution> {
        let (tolerance, max_iterations) = (effort.tolerance, effort.max_iterations);
        let mut iterations = 0;
        let reason = loop {
            effort.interrupt.check(SOLVER)?;
            let goal = self.goal(tolerance);
            if self.found.size <= goal {
                if self.accuracy.truncation <= Accuracy::FULL.truncation {
                    break StopReason::Converged;
                }
                self.accuracy = Accuracy::FULL;
                self.found = self.residual(&self.motion)?;
                continue;
            }
            if iterations == max_iterations {
                break StopReason::MaxIterations;
            }
            if self.work.is_done() {
                break StopReason::WorkLimit;
            }
            iterations += 1;
            if let Some(reason) = self.advance(goal)? {
                break match self.work.is_done() {
                    true => StopReason::WorkLimit,
                    false => reason,
                };
            }
        };
        let goal = self.goal(tolerance);
        Ok(ChainSolution {
            report: SolverReport::new(reason, iterations, self.found.size, goal),
            motion: self.motion,
            legs: None,
        })
    }

    fn residual(&self, motion: &Motion) -> Result<ChainResidual> {
        self.problem.residual(motion, self.accuracy, self.work)
    }

    fn goal(&self, tolerance: f64) -> f64 {
        tolerance.max(ROUND_OFF * self.motion.largest_derivative())
    }

    /// Takes one step; returns a reason if no step is possible.
    fn advance(&mut self, tolerance: f64) -> Result<Option<StopReason>> {
        if self.needs_linear(tolerance) && !self.linearise()? {
            return Ok(Some(StopReason::SingularJacobian));
        }
        let step = match &self.method {
            Method::Flat => self.problem.flat_step(&self.found)?,
            Method::Linear(linear) => self.problem.linear_step(linear, &self.found),
            Method::Krylov => match unless_interrupted(self.krylov_step())?.flatten() {
                Some(step) => step,
                None => return Ok(Some(StopReason::Stagnated)),
            },
        };
        let newton = match self.method {
            Method::Flat => false,
            Method::Linear(_) => self.mixing.is_empty(),
            Method::Krylov => true,
        };
        let next = self.found.size.powi(if newton { 2 } else { 1 }).min(1.0);
        let accuracy = Accuracy::of_tolerance(ACCURACY_SHARE * next);
        self.accuracy = self.accuracy.finer(accuracy);
        if let Method::Krylov = self.method {
            return self.descend(&step);
        }
        let increment = self.mixing.increment(step);
        if newton {
            return self.descend(&increment);
        }
        match self.tried(1.0, &increment)? {
            Some((motion, found)) if self.is_acceptable(&found) => self.accept(motion, found),
            // Retry from here with new linear equations.
            _ if self.has_derivatives() => self.rate = f64::INFINITY,
            _ => self.method = Method::Krylov,
        }
        Ok(None)
    }

    fn has_derivatives(&self) -> bool {
        self.problem.chain.derivative_work().is_finite()
    }

    /// Whether to set up the linear equations now.
    fn needs_linear(&self, tolerance: f64) -> bool {
        match self.method {
            Method::Linear(_) => self.rate > SLOW,
            Method::Krylov => false,
            Method::Flat if !self.has_derivatives() || self.mixing.is_empty() => false,
            Method::Flat => {
                let work = self.problem.chain.derivative_work();
                let left = (tolerance / self.found.size).ln() / self.rate.min(0.9).ln();
                self.rate > 1.0 || left > work + LINEAR_STEPS
            }
        }
    }

    /// Sets up the linear equations, unless they take more than the work that is left; whether it did.
    fn linearise(&mut self) -> Result<bool> {
        let chain = self.problem.chain;
        let legs = chain.lengths().len() as f64;
        let needed = legs * chain.work_of_derivative();
        if needed > self.work.left() {
            self.work.refuse();
            return Ok(false);
        }
        self.work.count(needed);
        let linear = self.problem.linearised(&self.motion, &self.found)?;
        self.mixing = Anderson::new(DEPTH);
        self.method = linear.map_or(Method::Flat, |linear| Method::Linear(Box::new(linear)));
        Ok(matches!(self.method, Method::Linear(_)))
    }

    /// Without derivatives, the residual may increase for some steps of flat space.
    fn is_acceptable(&mut self, found: &ChainResidual) -> bool {
        if self.has_derivatives() {
            return found.size < self.found.size;
        }
        if found.size > 0.5 * self.least {
            self.failures += 1;
        } else {
            (self.least, self.failures) = (found.size, 0);
        }
        self.failures < PATIENCE
    }

    /// The Newton step: the flat step `g` has the same zeros as the equations, and its derivative is near minus the
    /// identity.
    fn krylov_step(&mut self) -> Result<Option<Vec<f64>>> {
        let accuracy = DIFFERENCE_ACCURACY * self.found.size.min(1.0);
        self.accuracy = self.accuracy.finer(Accuracy::of_tolerance(accuracy));
        self.found = self.residual(&self.motion)?;
        let here = self.problem.flat_step(&self.found)?;
        let size = norm(&self.motion.entries);
        newton_step(&here, size, KRYLOV_SHARE, |share, direction| {
            if self.work.is_done() {
                return Ok(None);
            }
            let mut beside = self.motion.clone();
            beside.add(share, direction);
            self.problem.flat_step(&self.residual(&beside)?).map(Some)
        })
    }

    fn accept(&mut self, motion: Motion, found: ChainResidual) {
        self.rate = found.size / self.found.size;
        (self.motion, self.found) = (motion, found);
    }

    /// `None` if the motion cannot be integrated.
    fn tried(&self, share: f64, increment: &[f64]) -> Result<Option<(Motion, ChainResidual)>> {
        let mut motion = self.motion.clone();
        motion.add(share, increment);
        let found = unless_interrupted(self.residual(&motion))?;
        let found = found.filter(|found| found.size.is_finite());
        Ok(found.map(|found| (motion, found)))
    }

    /// Merit function of a Newton step: the norm in which its linear equations were solved.
    fn merit(&self, found: &ChainResidual) -> Result<f64> {
        match self.method {
            Method::Krylov => Ok(norm(&self.problem.flat_step(found)?)),
            _ => Ok(self.problem.total(found)),
        }
    }

    /// Takes a Newton step, shortened until the merit function decreases.
    fn descend(&mut self, step: &[f64]) -> Result<Option<StopReason>> {
        let found = backtracked(self.merit(&self.found)?, STEP_LENGTHS, |share| {
            if self.work.is_done() {
                return Ok(None);
            }
            let Some((motion, found)) = self.tried(share, step)? else {
                return Ok(None);
            };
            let merit = self.merit(&found)?;
            Ok(Some((merit, (motion, found))))
        })?;
        if let Some(((motion, found), share)) = found {
            self.accept(motion, found);
            if share < 1.0 {
                self.rate = f64::INFINITY;
            }
            return Ok(None);
        }
        Ok(Some(StopReason::Stagnated))
    }
}
