//! Strategies for boundary value problems of Riemannian cubics: Newton's method, continuation from curves with other
//! ends, descents; and their work.

use super::continuation::{MAX_STEPS, Next, Tracer};
use super::end_map::EndMap;
use super::homotopy::Homotopy;
use super::problem::BoundaryProblem;
use super::random::Random;
use super::shooting::ROUND_OFF;
use super::solution::SolvedStart;
use crate::collocation::BoundaryStart;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::work::work_of_curve;
use crate::error::{Result, unless_interrupted};
use crate::report::{SolverReport, StopReason, Strategy};
use crate::shooting::StartResponse;
use crate::solve::gmres::norm;

/// Number of steps after which a start counts as bad; from good ones Newton's method takes at most 6, Broyden's up
/// to 12.
const DIRECT_STEPS: usize = 12;

/// Newton steps from the end of a continuation.
const POLISH_STEPS: usize = 16;

/// Distances of random initial data from those of flat space, relative to their size; used in turn.
const SPREADS: [f64; 4] = [0.3, 0.6, 1.0, 1.5];

/// Integration accuracy of the curves from which continuation starts.
const ACCURACY: f64 = 1e-9;

/// Residual below which Newton's method is assumed to be converging.
const NEAR: f64 = 0.1;

/// Round-off at the end of a fast curve, relative to its length.
const ROUND_OFF_SHARE: f64 = 32.0 * f64::EPSILON;

/// Random initial data near those of a start, for a problem with the given speeds.
pub(crate) fn scattered(
    start: &[f64],
    speeds: f64,
    attempt: usize,
    random: &mut Random,
) -> Vec<f64> {
    let spread = SPREADS[attempt % SPREADS.len()];
    let size = norm(start).max(1.0 + speeds) / (start.len().max(1) as f64).sqrt();
    let around = |y: &f64| y + spread * size * random.normal();
    start.iter().map(around).collect()
}

/// Tries the strategies in turn and keeps the account of work and steps.
pub(crate) struct Solver<'a> {
    pub(crate) problem: &'a BoundaryProblem,
    pub(crate) options: &'a BoundaryOptions<'a>,
    /// Tolerance of the options, raised to what round-off allows.
    tolerance: f64,
    pub(crate) map: Box<dyn EndMap + 'a>,
    newton_steps: usize,
    /// The smallest distance reached that was not small enough, and why the attempt stopped.
    nearest: (f64, StopReason),
}

/// A solution, and how it was found.
pub(crate) type Reported = (SolvedStart, SolverReport);

impl<'a> Solver<'a> {
    pub(crate) fn new(problem: &'a BoundaryProblem, options: &'a BoundaryOptions<'a>) -> Self {
        let map = problem.end_map(options.interrupt);
        map.work().allow(options.allowance());
        Solver {
            problem,
            options,
            map,
            newton_steps: 0,
            // At most the bound on round-off: the ends of faster curves have no correct digits.
            tolerance: options
                .tolerance
                .max((ROUND_OFF_SHARE * problem.speed()).min(ROUND_OFF)),
            nearest: (f64::INFINITY, StopReason::Diverged),
        }
    }

    /// A solution near a start; `None` if all strategies fail.
    pub(crate) fn near(&mut self, start: &[f64]) -> Result<Option<Reported>> {
        if let Some(found) = self.restarted(start, None)? {
            return Ok(Some((found, self.report(Strategy::Direct))));
        }
        if self.is_out_of_steps() || self.has_met_round_off() {
            return Ok(None);
        }
        if let Some(y) = self.moved(start, norm(start))? {
            let found = SolvedStart::of_start(y);
            return Ok(Some((found, self.report(Strategy::Continuation))));
        }
        self.by_descents()
    }

    /// Whether the caller allows no more steps than those from the first start.
    pub(crate) fn is_out_of_steps(&self) -> bool {
        self.has_few_steps() && self.nearest.1 == StopReason::MaxIterations
    }

    /// Whether the caller allows no more steps than a good start takes.
    pub(crate) fn has_few_steps(&self) -> bool {
        self.options.max_iterations <= DIRECT_STEPS
    }

    /// Records the work limit as the reason for failure, if no curve came near the end.
    pub(crate) fn refuse(&mut self) {
        if self.nearest.0.is_infinite() {
            self.nearest.1 = StopReason::WorkLimit;
        }
    }

    /// Tolerance of the options, raised to what round-off allows.
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Counts the steps from a start.
    pub(crate) fn account_start(&mut self, steps: usize) {
        self.newton_steps += steps;
    }

    /// Records the smallest distance reached.
    pub(crate) fn set_nearest(&mut self, residual: f64, reason: StopReason) {
        self.nearest = (residual, reason);
    }

    /// Counts a descent.
    pub(crate) fn account(&mut self, report: SolverReport) {
        self.newton_steps += report.iterations;
    }

    /// Whether some start led to a curve whose end is as accurate as round-off allows, but not to the tolerance.
    pub(crate) fn has_met_round_off(&self) -> bool {
        self.nearest.0 < ROUND_OFF
    }

    /// Newton from a start, in place, with more steps if it is converging.
    fn persistent(&mut self, y: &mut [f64], response: Option<&StartResponse>) -> Result<bool> {
        let most = self.options.max_iterations;
        let first = most.min(DIRECT_STEPS);
        let report = self.newton(y, response, first)?;
        let on_its_way = report.reason == StopReason::MaxIterations && report.residual < NEAR;
        if report.converged || first == most || !on_its_way {
            return Ok(report.converged);
        }
        Ok(self.newton(y, None, most - first)?.converged)
    }

    /// The solution to which Newton's method leads from a start, at Gauss nodes or else by shooting; the response of a
    /// chain that ends there is used first. A curve that cannot be integrated is no solution.
    pub(crate) fn restarted(
        &mut self,
        start: &[f64],
        response: Option<&StartResponse>,
    ) -> Result<Option<SolvedStart>> {
        if let Some(found) = self.at_nodes(start, BoundaryStart::Curve)? {
            return Ok(Some(found));
        }
        self.by_shooting(start, response)
    }

    /// As [`Solver::restarted`], by shooting.
    pub(crate) fn by_shooting(
        &mut self,
        start: &[f64],
        response: Option<&StartResponse>,
    ) -> Result<Option<SolvedStart>> {
        let mut y = start.to_vec();
        let is_found = unless_interrupted(self.persistent(&mut y, response))?;
        Ok((is_found == Some(true)).then(|| SolvedStart::of_start(y)))
    }

    /// The solution with the given `(x', x'')` at the start, integrated, or the one to which shooting leads from there if
    /// its end is not near enough; `None` if there is none, or if the curve cannot be integrated.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn integrated(&mut self, start: Vec<f64>) -> Result<Option<SolvedStart>> {
        let taylor = self.problem.integrated(&start, self.options.interrupt);
        let Some(taylor) = unless_interrupted(taylor)? else {
            return Ok(None);
        };
        self.map.work().count(work_of_curve(self.problem.blocks()));
        match self.accepted(&start, taylor) {
            Some(found) => Ok(Some(found)),
            None => self.by_shooting(&start, None),
        }
    }

    /// The solution with the given curve and `(x', x'')` at its start, if its ends are near enough.
    pub(crate) fn accepted(
        &mut self,
        start: &[f64],
        taylor: PiecewiseTaylor,
    ) -> Option<SolvedStart> {
        let distance = self.problem.distance(&taylor);
        let is_near = distance <= self.tolerance;
        is_near.then(|| {
            self.set_nearest(distance, StopReason::Converged);
            SolvedStart::new(start.to_vec(), taylor)
        })
    }

    /// The sum of initial and end speed.
    fn speeds(&self) -> f64 {
        self.problem.velocity.inner(&self.problem.velocity).sqrt() + self.problem.end[1].norm_l2()
    }

    /// Newton from `y` for the problem itself, in place.
    pub(crate) fn newton(
        &mut self,
        y: &mut [f64],
        response: Option<&StartResponse>,
        max_iterations: usize,
    ) -> Result<SolverReport> {
        self.map.set_target(&self.problem.target);
        let report = self
            .map
            .solve(y, response, self.tolerance, max_iterations)?;
        self.newton_steps += report.iterations;
        if report.converged || report.residual < self.nearest.0 {
            self.nearest = (report.residual, report.reason);
        }
        Ok(report)
    }

    /// Random initial data near those of a start.
    pub(crate) fn scattered(&self, start: &[f64], attempt: usize, random: &mut Random) -> Vec<f64> {
        scattered(start, self.speeds(), attempt, random)
    }

    /// The solution found by continuation from the curve with the given initial data.
    pub(crate) fn moved(&mut self, from: &[f64], size: f64) -> Result<Option<Vec<f64>>> {
        match self.family_from(from)? {
            Some(homotopy) => self.follow_to_first(&homotopy, from, size, MAX_STEPS),
            None => Ok(None),
        }
    }

    /// The family from the end of a curve to the given end; `None` if the two ends cannot be joined.
    pub(crate) fn family_from(&mut self, from: &[f64]) -> Result<Option<Homotopy>> {
        let end = self.map.end(from, Accuracy::of_tolerance(ACCURACY));
        let end = unless_interrupted(end)?;
        Ok(end.and_then(|end| Homotopy::new(self.problem, end).ok()))
    }

    /// The first solution of the problem along a family.
    fn follow_to_first(
        &mut self,
        homotopy: &Homotopy,
        from: &[f64],
        size: f64,
        max_steps: usize,
    ) -> Result<Option<Vec<f64>>> {
        let mut found = None;
        self.follow(homotopy, from, size, max_steps, |y| {
            found = Some(y.to_vec());
            Next::Stop
        })?;
        Ok(found)
    }

    /// Follows the solutions of a family; `see` decides at every solution of the problem whether to continue.
    pub(crate) fn follow(
        &mut self,
        homotopy: &Homotopy,
        from: &[f64],
        size: f64,
        max_steps: usize,
        mut see: impl FnMut(&[f64]) -> Next,
    ) -> Result<()> {
        let (tolerance, target) = (self.tolerance, &self.problem.target);
        let most = self.options.max_iterations.min(POLISH_STEPS);
        let (mut newton_steps, mut nearest) = (0, self.nearest);
        let mut tracer = Tracer::new(self.map.as_mut(), homotopy, size, max_steps);
        let outcome = tracer.run(from, |map, near| {
            map.set_target(target);
            let mut y = near.to_vec();
            let solved = map.solve(&mut y, None, tolerance, most);
            let Some(report) = unless_interrupted(solved)? else {
                return Ok(Next::Refine);
            };
            newton_steps += report.iterations;
            if report.converged || report.residual < nearest.0 {
                nearest = (report.residual, report.reason);
            }
            Ok(if report.converged {
                see(&y)
            } else {
                Next::Refine
            })
        });
        self.newton_steps += newton_steps + tracer.corrections;
        self.nearest = nearest;
        outcome
    }

    /// The account so far, with the strategy if it has just found a solution.
    pub(crate) fn report(&self, strategy: Strategy) -> SolverReport {
        let (residual, reason) = match self.nearest {
            (residual, reason) if reason != StopReason::Converged && self.map.work().is_done() => {
                (residual, StopReason::WorkLimit)
            }
            nearest => nearest,
        };
        let tolerance = match reason {
            StopReason::Converged => self.tolerance.max(residual),
            _ => self.tolerance,
        };
        SolverReport::new(reason, self.newton_steps, residual, tolerance).found_by(strategy)
    }
}
