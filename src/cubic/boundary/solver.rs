//! Strategies for boundary value problems of Riemannian cubics: Newton's method, descents, continuation from curves with
//! other ends; and their work.

use std::rc::Rc;

use super::continuation::Tracer;
use super::end_equations::Target;
use super::homotopy::Homotopy;
use super::problem::BoundaryProblem;
use super::random::Random;
use super::shooting::{ROUND_OFF, SingleShooting};
use super::solution::SolvedStart;
use crate::collocation::BoundaryStart;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::taylor::march::{Accuracy, allowed_steps};
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::work::{TRIALS, Work, work_of_curve, work_of_step};
use crate::error::{Error, Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::Appearance;
use crate::report::{SolverReport, StopReason, Strategy};
use crate::solve::gmres::norm;
use crate::space::Quotient;

const SOLVER: &str = "boundary value problem of a Riemannian cubic";

/// A caller who allows no more steps than this wants Newton's method from the first start alone; from good starts it takes
/// at most as many.
const FEW_STEPS: usize = 12;

/// Newton steps from the end of a continuation.
const POLISH_STEPS: usize = 16;

/// Distances of random initial data from those of flat space, relative to their size; used in turn.
const SPREADS: [f64; 4] = [0.3, 0.6, 1.0, 1.5];

/// Integration accuracy of the curves from which continuation starts.
const ACCURACY: f64 = 1e-9;

/// Integration accuracy of curves that are not solutions.
const ROUGH: f64 = 1e-6;

/// Round-off at the end of a fast curve, relative to its length.
const ROUND_OFF_SHARE: f64 = 32.0 * f64::EPSILON;

/// Tries the strategies in turn and keeps the account of work and steps.
pub(crate) struct Solver<'a> {
    pub(crate) problem: &'a BoundaryProblem,
    pub(crate) options: &'a BoundaryOptions<'a>,
    pub(crate) interrupt: Interrupt<'a>,
    pub(crate) work: Rc<Work>,
    /// Tolerance of the options, raised to what round-off allows.
    tolerance: f64,
    shooting: Option<SingleShooting<'a>>,
    newton_steps: usize,
    /// The smallest distance reached that was not small enough, and why the attempt stopped.
    nearest: (f64, StopReason),
}

/// A solution, and how it was found.
pub(crate) type Reported = (SolvedStart, SolverReport);

impl<'a> Solver<'a> {
    pub(crate) fn new(
        problem: &'a BoundaryProblem,
        options: &'a BoundaryOptions<'a>,
        interrupt: Interrupt<'a>,
    ) -> Self {
        let curve = work_of_curve(problem.blocks());
        let work = Work::of_trials(TRIALS, curve, Appearance::Usual);
        work.allow(options.allowance());
        Solver {
            problem,
            options,
            interrupt,
            work: Rc::new(work),
            // At most the bound on round-off: the ends of faster curves have no correct digits.
            tolerance: options
                .tolerance
                .max((ROUND_OFF_SHARE * problem.speed).min(ROUND_OFF)),
            shooting: None,
            newton_steps: 0,
            nearest: (f64::INFINITY, StopReason::Stagnated),
        }
    }

    /// A solution near a start, or else the one that is found without a start; `None` if all strategies fail.
    pub(crate) fn near(&mut self, start: &[f64]) -> Result<Option<Reported>> {
        if let Some(found) = self.restarted(start)? {
            return Ok(Some((found, self.report(Strategy::Direct))));
        }
        let found = match self.has_few_steps() {
            true => None,
            false => self.of_low_cost()?,
        };
        if found.is_none() {
            if self.has_few_steps() {
                self.refuse(StopReason::MaxIterations);
            }
            self.measure(start)?;
        }
        Ok(found)
    }

    /// Whether the caller allows no more steps than a good start takes.
    pub(crate) fn has_few_steps(&self) -> bool {
        self.options.max_iterations <= FEW_STEPS
    }

    /// Records why nothing more is tried, if nothing else is known.
    pub(crate) fn refuse(&mut self, reason: StopReason) {
        if self.nearest.0.is_infinite() {
            self.nearest.1 = reason;
        }
    }

    /// Records how far the end of the curve of a start is from the given one, if nothing else is known.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn measure(&mut self, start: &[f64]) -> Result<()> {
        if self.nearest.0.is_finite() {
            return Ok(());
        }
        if let Some(curve) = self.roughly_integrated(start)? {
            self.nearest.0 = self.problem.distance(&curve);
        }
        Ok(())
    }

    /// The curve with the given `(x', x'')` at its start, roughly, in the frame at the start of the problem; `None` if it is
    /// too fast.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn roughly_integrated(&mut self, start: &[f64]) -> Result<Option<PiecewiseTaylor>> {
        let problem = self.problem;
        let mut curve = PiecewiseTaylor::at(problem.start(start), Accuracy::of_tolerance(ROUGH));
        let outcome = curve.extend_within(allowed_steps(problem.speed), 1.0, self.interrupt);
        self.work
            .count(curve.len() as f64 * work_of_step(problem.blocks()));
        Ok(unless_interrupted(outcome)?.map(|()| curve))
    }

    /// Tolerance of the options, raised to what round-off allows.
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Counts steps.
    pub(crate) fn count_steps(&mut self, steps: usize) {
        self.newton_steps += steps;
    }

    /// The solution to which Newton's method leads from a start, at Gauss nodes or else, between frames, by shooting, between
    /// subspaces for a chain of short legs.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn restarted(&mut self, start: &[f64]) -> Result<Option<SolvedStart>> {
        match self.at_nodes(start, BoundaryStart::Curve)? {
            None => match self.problem.kind().quotient {
                Quotient::Frames => self.by_shooting(start),
                Quotient::Subspaces => self.near_curve(start),
            },
            found => Ok(found),
        }
    }

    /// The solution to which Newton's method for the equations at the end leads from a start between frames.
    ///
    /// # Errors
    /// `Interrupted`.
    fn by_shooting(&mut self, start: &[f64]) -> Result<Option<SolvedStart>> {
        let (tolerance, most) = (self.tolerance, self.options.max_iterations);
        let mut y = start.to_vec();
        let solved = self.shooting().solve(&mut y, tolerance, most);
        let Some(report) = unless_interrupted(solved)? else {
            return Ok(None);
        };
        self.count_steps(report.iterations);
        self.set_nearest(&report);
        Ok(report.converged.then(|| SolvedStart::of_start(y)))
    }

    /// The equations at the end.
    fn shooting(&mut self) -> &mut SingleShooting<'a> {
        let (problem, interrupt) = (self.problem, self.interrupt);
        self.shooting
            .get_or_insert_with(|| SingleShooting::new(problem, self.work.clone(), interrupt))
    }

    /// The solution with the given `(x', x'')` at the start, integrated; `None` if its end is not near enough, or if the
    /// curve cannot be integrated.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn integrated(&mut self, start: &[f64]) -> Result<Option<SolvedStart>> {
        let taylor = self.problem.integrated(start, self.interrupt);
        let Some(taylor) = unless_interrupted(taylor)? else {
            return Ok(None);
        };
        self.work.count(work_of_curve(self.problem.blocks()));
        Ok(self.accepted(start, taylor))
    }

    /// The solution with the given curve and `(x', x'')` at its start, if its ends are near enough.
    pub(crate) fn accepted(
        &mut self,
        start: &[f64],
        taylor: PiecewiseTaylor,
    ) -> Option<SolvedStart> {
        let distance = self.problem.distance(&taylor);
        if distance <= self.tolerance {
            self.nearest = (distance, StopReason::Converged);
            return Some(SolvedStart::new(start.to_vec(), taylor));
        }
        if distance < self.nearest.0 {
            self.nearest.0 = distance;
        }
        None
    }

    /// The sum of initial and end speed.
    fn speeds(&self) -> f64 {
        self.problem.velocity.inner(&self.problem.velocity).sqrt() + self.problem.end[1].norm_l2()
    }

    fn set_nearest(&mut self, report: &SolverReport) {
        if report.converged || report.residual < self.nearest.0 {
            self.nearest = (report.residual, report.reason);
        }
    }

    /// Random initial data near those of a start.
    pub(crate) fn scattered(&self, start: &[f64], attempt: usize, random: &mut Random) -> Vec<f64> {
        let spread = SPREADS[attempt % SPREADS.len()];
        let size = norm(start).max(1.0 + self.speeds()) / (start.len().max(1) as f64).sqrt();
        let around = |y: &f64| y + spread * size * random.normal();
        start.iter().map(around).collect()
    }

    /// The family from the end of a curve to the given end; `None` if the two ends cannot be joined.
    pub(crate) fn family_from(&mut self, from: &[f64]) -> Result<Option<Homotopy>> {
        let end = self.shooting().end(from, Accuracy::of_tolerance(ACCURACY));
        let end = unless_interrupted(end)?;
        Ok(end.and_then(|end| Homotopy::new(self.problem, end).ok()))
    }

    /// The solutions of the problem that a family passes.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn passed_by(
        &mut self,
        homotopy: &Homotopy,
        from: &[f64],
        size: f64,
    ) -> Result<Vec<Reported>> {
        let problem = self.problem;
        let target = Target::new(&problem.velocity, &problem.end, problem.tension);
        let tolerance = self.tolerance;
        let most = self.options.max_iterations.min(POLISH_STEPS);
        let (mut passed, mut reports) = (Vec::new(), Vec::new());
        let mut tracer = Tracer::new(self.shooting(), homotopy, size);
        let outcome = tracer.run(from, |map, near| {
            map.target.clone_from(&target);
            let mut y = near.to_vec();
            let solved = map.solve(&mut y, tolerance, most);
            let Some(report) = unless_interrupted(solved)? else {
                return Ok(false);
            };
            reports.push(report);
            if report.converged {
                passed.push((SolvedStart::of_start(y), report));
            }
            Ok(report.converged)
        });
        let corrections = tracer.corrections;
        self.shooting().target = target.clone();
        self.count_steps(corrections);
        for report in &reports {
            self.newton_steps += report.iterations;
            self.set_nearest(report);
        }
        outcome?;
        let reported = |(solution, report): Reported| {
            let report = SolverReport {
                iterations: self.newton_steps,
                ..report.found_by(Strategy::Continuation)
            };
            (solution, report)
        };
        Ok(passed.into_iter().map(reported).collect())
    }

    /// The account so far, after a strategy has found a solution.
    pub(crate) fn report(&self, strategy: Strategy) -> SolverReport {
        self.account().found_by(strategy)
    }

    fn account(&self) -> SolverReport {
        let (residual, reason) = match self.nearest {
            (residual, reason) if reason != StopReason::Converged && self.work.is_done() => {
                (residual, StopReason::WorkLimit)
            }
            nearest => nearest,
        };
        let tolerance = match reason {
            StopReason::Converged => self.tolerance.max(residual),
            _ => self.tolerance,
        };
        SolverReport::new(reason, self.newton_steps, residual, tolerance)
    }

    /// The error if no strategy finds a solution.
    pub(crate) fn failure(&self) -> Error {
        Error::NoConvergence {
            solver: SOLVER,
            report: self.account(),
        }
    }
}
