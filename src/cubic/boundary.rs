//! Riemannian cubics from boundary data: Newton from a start; then continuation from easier problems, chains of low cost.

use std::fmt;
use std::sync::Arc;

use faer::{Mat, MatRef};

use super::continuation::{MAX_STEPS, Next, Tracer, norm};
use super::curve_start::CurveFamily;
use super::end_map::EndMap;
use super::homotopy::Homotopy;
use super::problem::{Problem, unpack};
use super::random::Random;
use super::relaxation::{Chain, slowed};
use super::riemannian_cubic::RiemannianCubic;
use super::shooting::SOLVER;
use super::taylor::Accuracy;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Steps after which a start counts as bad; from good ones Newton's method takes at most 6, Broyden's up to 12.
const DIRECT_STEPS: usize = 12;

/// Steps of the first continuation: where it takes more it has met a fold.
const FIRST_STEPS: usize = 40;

/// Newton steps from where a continuation arrives.
const POLISH_STEPS: usize = 16;

/// Random attempts of each kind.
const ATTEMPTS: u32 = 16;

/// How far the random initial data are from those of flat space, relative to their size; one after the other.
const SPREADS: [f64; 4] = [0.3, 0.6, 1.0, 1.5];

/// Shares of displacement and speeds that detours set out with, one after the other.
const SHARES: [f64; 4] = [0.5, 0.3, 0.7, 0.2];

/// Integration of the curves that continuation sets out from.
const ACCURACY: f64 = 1e-9;

/// Below this, Newton's method is on its way.
const NEAR: f64 = 0.1;

/// Unknowns up to which chains are relaxed: it takes as many differences of every node.
const CHAIN_UNKNOWNS: usize = 64;

/// How far the nodes of a chain are moved at random, more and more.
const CHAIN_SPREAD: f64 = 0.5;

/// Legs of chains, one after the other.
const CHAIN_LEGS: [usize; 2] = [16, 40];

/// Below this, a residual that does not fall any more has met round-off.
const ROUND_OFF: f64 = 1e-9;

/// Round-off at the end of a fast curve, relative to its length.
const ROUND_OFF_SHARE: f64 = 32.0 * f64::EPSILON;

/// Costs of curves are known to a percent.
const SLACK: f64 = 1.01;

/// Chains that are relaxed where other solutions are dearer than a known curve.
const CHAINS: u32 = 4;

/// How a boundary value problem is solved.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
/// use stiefel_rs::Curve;
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let first = RiemannianCubic::from_boundary(s0, v0, s1, v1, &BoundaryOptions::default())?;
/// assert!((first.point(1.0)? - s1).norm_l2() < 1e-12);
/// // From a solution there is less to do.
/// let (a, j) = (first.acceleration(0.0)?, first.jerk(0.0)?);
/// let options = BoundaryOptions { guess: Some((a.as_ref(), j.as_ref())), ..Default::default() };
/// let again = RiemannianCubic::from_boundary(s0, v0, s1, v1, &options)?;
/// let iterations = |curve: &RiemannianCubic| curve.report().map(|report| report.iterations);
/// assert!(iterations(&again) < iterations(&first));
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct BoundaryOptions<'a> {
    /// Converged once `(|S(1) - S1|^2 + |V(1) - V1|^2 / u^2)^(1/2)` is at most this; between 1e-15 and 0.1.
    ///
    /// The unit `u` is 1 where both end speeds are at most 10 (Frobenius norm), else it is the larger of them: a round-off
    /// of `eps |V|` in the angle along a curve of that speed is one of `eps |V|^2` in the velocity. Below
    /// `32 eps` times the larger speed, about `1e-12` for speeds of 140 and never more than `1e-9`, that bound stands for the
    /// tolerance, also in the report.
    pub tolerance: f64,
    /// Newton steps at the most from the first start, and from any other; at least 1. With 12 or fewer a first start that
    /// runs out of them ends the search: nothing but Newton's method from there is wanted.
    pub max_iterations: usize,
    /// Covariant acceleration and covariant jerk at `S0` to start from, shape `(n, k)` each; by default those of the cubic of
    /// flat space. Parts outside of the span of the boundary data, where no solution has any, are left out.
    pub guess: Option<(MatRef<'a, f64>, MatRef<'a, f64>)>,
    /// Asked before every step.
    pub interrupt: Interrupt<'a>,
}

impl Default for BoundaryOptions<'_> {
    /// Residual `1e-12`, at most 50 steps, the start of flat space.
    fn default() -> Self {
        BoundaryOptions {
            tolerance: 1e-12,
            max_iterations: 50,
            guess: None,
            interrupt: Interrupt::NEVER,
        }
    }
}

impl BoundaryOptions<'_> {
    pub(super) fn check(&self) -> Result<()> {
        if !(1e-15..=0.1).contains(&self.tolerance) {
            return Err(Error::InvalidArgument {
                name: "tolerance",
                requirement: "between 1e-15 and 0.1",
                found: self.tolerance,
            });
        }
        if self.max_iterations == 0 {
            return Err(Error::InvalidArgument {
                name: "max_iterations",
                requirement: "at least 1",
                found: 0.0,
            });
        }
        Ok(())
    }
}

/// The way on which the solution of a boundary value problem was found.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, BoundaryStrategy, RiemannianCubic};
/// // Ends so near that Newton's method needs no help.
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, v0, s1, v1, &BoundaryOptions::default())?;
/// let report = curve.boundary_report().expect("it comes from a boundary value problem");
/// assert_eq!(report.strategy, BoundaryStrategy::Direct);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum BoundaryStrategy {
    /// Newton's method from the first start: the cubic of flat space or the guess.
    Direct,
    /// Continuation from the curve that stands still, displacement and velocities growing.
    Growing,
    /// Newton's method or continuation from a chain of points, relaxed to low cost.
    Relaxation,
    /// Newton's method from acceleration and jerk of a geometric or geodesic polynomial with the same data.
    Polynomial,
    /// Newton's method from random initial data around the first start.
    Restart,
    /// Continuation from easier data, with velocities that make a detour.
    Detour,
    /// Continuation from a curve with other end data: that of a guess, or of random initial data.
    Moving,
}

impl BoundaryStrategy {
    /// The strategy as a word.
    pub fn as_str(self) -> &'static str {
        match self {
            BoundaryStrategy::Direct => "direct",
            BoundaryStrategy::Growing => "growing",
            BoundaryStrategy::Relaxation => "relaxation",
            BoundaryStrategy::Polynomial => "polynomial",
            BoundaryStrategy::Restart => "restart",
            BoundaryStrategy::Detour => "detour",
            BoundaryStrategy::Moving => "moving",
        }
    }
}

/// How the solution of a boundary value problem was found.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
/// // Nearly to the other side of the sphere, with speed across the way: Newton's method needs help.
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [0.0], [4.0]]);
/// let (s1, v1) = (mat![[-0.96], [0.28], [0.0]], mat![[0.0], [0.0], [4.0]]);
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, v0, s1, v1, &BoundaryOptions::default())?;
/// let report = curve.boundary_report().expect("it comes from a boundary value problem");
/// assert!(report.starts > 1);
/// assert!(report.solver.converged && report.solver.residual <= 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryReport {
    /// Of the whole solution: its iterations count every Newton step, corrections of continuations among them.
    pub solver: SolverReport,
    /// What led to the solution; where none was found, what was tried last.
    pub strategy: BoundaryStrategy,
    /// Steps of continuations, all together.
    pub continuation_steps: usize,
    /// Starts that were tried, the one that led to the solution among them.
    pub starts: usize,
}

impl fmt::Display for BoundaryReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {}, {} starts, {} steps of continuation",
            self.strategy.as_str(),
            self.solver,
            self.starts,
            self.continuation_steps
        )
    }
}

impl RiemannianCubic {
    /// A Riemannian cubic on `[0, 1]` with end points `s0, s1` and end velocities `v0, v1`, all of shape `(n, k)`.
    ///
    /// Cubics with given ends are stationary, not unique. Newton's method starts from the cubic of flat space (or from the
    /// guess). Where that fails, the solution is followed along a family of boundary data that grows from nothing, and then
    /// looked for near a chain of points of least cost, part by part. Beyond distance 2 or speed 2 (and without a guess), a
    /// solution that is dearer than the adjusted de Casteljau curve is given up for a cheaper one, where starts from such
    /// curves and from chains find one.
    /// [`boundary_report`](Self::boundary_report) says how it was found, [`cost`](crate::Curve::cost) what it costs, and
    /// [`all_from_boundary`](Self::all_from_boundary) looks for others.
    ///
    /// Points and velocities that are only nearly orthonormal and tangent, as rounded decimals are (defects up to 1e-9), stand
    /// for the nearest exact ones.
    ///
    /// # Accuracy
    /// The end is met to the tolerance. For distance up to 2 and speeds up to 2 the first start is enough, for distance up to 3
    /// and speeds up to 6 more than 99 in 100 random problems are solved; both are asserted in `tests/boundary.rs`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `InvalidArgument`, `DifferentComponents`, `NoConvergence` (also
    /// for velocities so large that no curve can be integrated: the residual is infinite then), `Interrupted`.
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
    ) -> Result<Self> {
        options.check()?;
        let problem = Problem::new(s0, v0, s1, v1)?;
        let start = first_start(&problem, s0, options)?;
        let mut solver = Solver::new(&problem, options);
        let Some(mut found) = solver.solve(start)? else {
            return Err(Error::NoConvergence {
                solver: SOLVER,
                report: solver.report(BoundaryStrategy::Moving).solver,
            });
        };
        if options.guess.is_none() && !problem.is_moderate() {
            found = solver.cheaper(found)?;
        }
        let (y, report) = found;
        drop(solver);
        let path = problem.path(&y, options.interrupt)?;
        Ok(Self::of_path(
            problem.n,
            problem.k,
            problem.frame.map(Arc::new),
            path,
            Some(report),
        ))
    }
}

/// `(x', x'')` to start from: those of the guess or of flat space.
pub(super) fn first_start(
    problem: &Problem,
    s0: MatRef<'_, f64>,
    options: &BoundaryOptions<'_>,
) -> Result<Vec<f64>> {
    if let Some((a, j)) = options.guess {
        return problem.start_from(s0, a, j);
    }
    match problem.flat_start() {
        // Continuation will look for another way there.
        Err(Error::NoJoiningCurve { .. } | Error::OutsideLogDomain { .. }) => {
            Ok(vec![0.0; problem.unknowns()])
        }
        other => other,
    }
}

/// Tries one strategy after the other, and keeps account.
pub(super) struct Solver<'a> {
    problem: &'a Problem,
    options: &'a BoundaryOptions<'a>,
    /// That of the options, or what round-off allows.
    tolerance: f64,
    pub(super) map: Box<dyn EndMap + 'a>,
    newton_steps: usize,
    continuation_steps: usize,
    starts: usize,
    /// The nearest end so far that was not near enough, and why it was left.
    nearest: (f64, StopReason),
}

/// `(x', x'')` of a solution and how it was found.
pub(super) type Solution = (Vec<f64>, BoundaryReport);

impl<'a> Solver<'a> {
    pub(super) fn new(problem: &'a Problem, options: &'a BoundaryOptions<'a>) -> Self {
        Solver {
            problem,
            options,
            map: problem.end_map(options.interrupt),
            newton_steps: 0,
            continuation_steps: 0,
            starts: 0,
            // Not beyond what counts as round-off: faster curves are not met to any digits.
            tolerance: options
                .tolerance
                .max((ROUND_OFF_SHARE * problem.speed()).min(ROUND_OFF)),
            nearest: (f64::INFINITY, StopReason::Diverged),
        }
    }

    /// A solution; none where all strategies fail.
    fn solve(&mut self, start: Vec<f64>) -> Result<Option<Solution>> {
        let mut y = start.clone();
        if self.restarted(&mut y)? {
            return Ok(Some((y, self.report(BoundaryStrategy::Direct))));
        }
        let limited = self.options.max_iterations <= DIRECT_STEPS;
        let (distance, reason) = self.nearest;
        if (limited && reason == StopReason::MaxIterations) || distance < ROUND_OFF {
            return Ok(None);
        }
        let size = norm(&start);
        if self.options.guess.is_some()
            && let Some(y) = self.moved(&start, size)?
        {
            return Ok(Some((y, self.report(BoundaryStrategy::Moving))));
        }
        if let Ok(homotopy) = Homotopy::growing(self.problem) {
            let rest = vec![0.0; start.len()];
            if let Some(y) = self.follow_to_first(&homotopy, &rest, size, FIRST_STEPS)? {
                return Ok(Some((y, self.report(BoundaryStrategy::Growing))));
            }
        }
        let mut random = Random::new(0);
        for attempt in 0..ATTEMPTS {
            if self.map.exhausted() {
                break;
            }
            if let Some(found) = self.relaxed(attempt, size, &mut random)? {
                return Ok(Some(found));
            }
            let mut y = self.scattered(&start, attempt, &mut random);
            if self.restarted(&mut y)? {
                return Ok(Some((y, self.report(BoundaryStrategy::Restart))));
            }
            if attempt % 2 == 1
                && let Some((homotopy, from)) = self.detour(&start, attempt, &mut random)?
                && let Some(y) = self.follow_to_first(&homotopy, &from, size, MAX_STEPS)?
            {
                return Ok(Some((y, self.report(BoundaryStrategy::Detour))));
            }
        }
        Ok(None)
    }

    /// A cheaper solution, where curves of the data or a relaxed chain show that there is one; else the same.
    fn cheaper(&mut self, first: Solution) -> Result<Solution> {
        let mut best = (self.cost(&first.0)?, first);
        // What the cheapest solution costs at the most.
        let mut bound = f64::INFINITY;
        for family in CurveFamily::QUICK {
            let Some(start) = family.start(self.problem, self.options.interrupt)? else {
                continue;
            };
            bound = bound.min(start.cost);
            if best.0 <= SLACK * bound {
                break;
            }
            let mut y = start.y;
            if self.restarted(&mut y)? {
                self.keep_cheaper(&mut best, y, BoundaryStrategy::Polynomial)?;
            }
        }
        let mut random = Random::new(0);
        let size = norm(&best.1.0);
        // A chain tells as well as a curve what is cheap, where there is no curve.
        let unknown = bound.is_infinite();
        let chains = if unknown { 1 } else { CHAINS };
        for attempt in 0..chains {
            if (best.0 <= SLACK * bound && !unknown) || self.map.exhausted() {
                break;
            }
            if let Some((y, report)) = self.relaxed(attempt, size, &mut random)? {
                self.keep_cheaper(&mut best, y, report.strategy)?;
            }
        }
        Ok(best.1)
    }

    fn keep_cheaper(
        &self,
        best: &mut (f64, Solution),
        y: Vec<f64>,
        strategy: BoundaryStrategy,
    ) -> Result<()> {
        let cost = self.cost(&y)?;
        if cost < best.0 {
            *best = (cost, (y, self.report(strategy)));
        }
        Ok(())
    }

    /// Of the curve from `y`.
    fn cost(&self, y: &[f64]) -> Result<f64> {
        Ok(self.problem.path(y, self.options.interrupt)?.cost(0.0, 1.0))
    }

    /// Newton from a start, in place; longer where it is on its way.
    fn persistent(&mut self, y: &mut [f64]) -> Result<bool> {
        let most = self.options.max_iterations;
        let first = most.min(DIRECT_STEPS);
        self.starts += 1;
        let report = self.newton(y, first)?;
        let on_its_way = report.reason == StopReason::MaxIterations && report.residual < NEAR;
        if report.converged || first == most || !on_its_way {
            return Ok(report.converged);
        }
        Ok(self.newton(y, most - first)?.converged)
    }

    /// From a chain of low cost: Newton for longer and longer parts of it, then for the whole.
    pub(super) fn relaxed(
        &mut self,
        attempt: u32,
        size: f64,
        random: &mut Random,
    ) -> Result<Option<Solution>> {
        // A finer chain is nearer to its cubic; a moved one may relax to another.
        let fineness = attempt as usize % CHAIN_LEGS.len();
        let spread = CHAIN_SPREAD * f64::from(attempt / CHAIN_LEGS.len() as u32);
        if self.problem.unknowns() > CHAIN_UNKNOWNS {
            return Ok(None);
        }
        let Ok(mut chain) = Chain::new(self.problem, CHAIN_LEGS[fineness], spread, random) else {
            return Ok(None);
        };
        chain.relax(self.options.interrupt)?;
        self.map.count(chain.work());
        let Ok(mut y) = chain.start(0) else {
            return Ok(None);
        };
        for count in 1..chain.legs() {
            self.map.set_target(&chain.part(self.problem, count));
            if !self.approximate(&mut y)? {
                return Ok(None);
            }
            y = slowed(&y, (count + 1) as f64 / count as f64);
        }
        let near = y.clone();
        if self.restarted(&mut y)? {
            return Ok(Some((y, self.report(BoundaryStrategy::Relaxation))));
        }
        let found = self.moved(&near, size)?;
        Ok(found.map(|y| (y, self.report(BoundaryStrategy::Relaxation))))
    }

    /// Newton from `y` for the data that are set, in place; whether it comes near.
    fn approximate(&mut self, y: &mut [f64]) -> Result<bool> {
        match self.map.solve(y, ACCURACY, DIRECT_STEPS) {
            Ok(report) => {
                self.newton_steps += report.iterations;
                Ok(report.converged)
            }
            Err(error @ Error::Interrupted { .. }) => Err(error),
            Err(_) => Ok(false),
        }
    }

    /// Newton from a start, in place; a curve that cannot be integrated is no solution.
    pub(super) fn restarted(&mut self, y: &mut [f64]) -> Result<bool> {
        match self.persistent(y) {
            Err(error @ Error::Interrupted { .. }) => Err(error),
            Err(_) => Ok(false),
            converged => converged,
        }
    }

    /// A family from easier data, in part as far apart and as fast, on with a random detour, and its known solution.
    pub(super) fn detour(
        &mut self,
        start: &[f64],
        attempt: u32,
        random: &mut Random,
    ) -> Result<Option<(Homotopy, Vec<f64>)>> {
        let Ok(growing) = Homotopy::growing(self.problem) else {
            return Ok(None);
        };
        let share = SHARES[attempt as usize % SHARES.len()];
        self.map.set_target(&growing.target(share)?);
        let mut y: Vec<f64> = start.iter().map(|y| share * y).collect();
        if !self.approximate(&mut y)? {
            return Ok(None);
        }
        let spread = SPREADS[attempt as usize % SPREADS.len()];
        let unknowns = self.problem.unknowns() as f64;
        let size = spread * (1.0 + 0.5 * self.speeds()) / (0.5 * unknowns).sqrt();
        let entries: Vec<f64> = start.iter().map(|_| size * random.normal()).collect();
        let detour = unpack(&entries, self.problem.blocks());
        Ok(growing
            .around(share, detour)
            .ok()
            .map(|homotopy| (homotopy, y)))
    }

    /// Initial and end speed together.
    fn speeds(&self) -> f64 {
        self.problem.velocity.inner(&self.problem.velocity).sqrt() + self.problem.end[1].norm_l2()
    }

    /// Newton from `y` for the problem itself, in place.
    pub(super) fn newton(&mut self, y: &mut [f64], max_iterations: usize) -> Result<SolverReport> {
        self.map.set_target(&self.problem.target);
        let report = self.map.solve(y, self.tolerance, max_iterations)?;
        self.newton_steps += report.iterations;
        if report.converged || report.residual < self.nearest.0 {
            self.nearest = (report.residual, report.reason);
        }
        Ok(report)
    }

    /// Initial data around those of a start.
    pub(super) fn scattered(&self, start: &[f64], attempt: u32, random: &mut Random) -> Vec<f64> {
        let spread = SPREADS[attempt as usize % SPREADS.len()];
        let size = norm(start).max(1.0 + self.speeds()) / (start.len().max(1) as f64).sqrt();
        start
            .iter()
            .map(|y| y + spread * size * random.normal())
            .collect()
    }

    /// The solution that continuation from the curve with the given initial data finds.
    pub(super) fn moved(&mut self, from: &[f64], size: f64) -> Result<Option<Vec<f64>>> {
        match self.family_from(from)? {
            Some(homotopy) => self.follow_to_first(&homotopy, from, size, MAX_STEPS),
            None => Ok(None),
        }
    }

    /// The family from the end of a curve to the wanted one; none where there is none.
    pub(super) fn family_from(&mut self, from: &[f64]) -> Result<Option<Homotopy>> {
        let end: [Mat<f64>; 2] = match self.map.end(from, Accuracy::of_tolerance(ACCURACY)) {
            Ok(end) => end,
            Err(error @ Error::Interrupted { .. }) => return Err(error),
            Err(_) => return Ok(None),
        };
        Ok(Homotopy::moving(self.problem, end).ok())
    }

    /// The first solution of the problem on the way along a family.
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

    /// Follows the solutions of a family; `see` decides at every solution of the problem whether to go on.
    pub(super) fn follow(
        &mut self,
        homotopy: &Homotopy,
        from: &[f64],
        size: f64,
        max_steps: usize,
        mut see: impl FnMut(&[f64]) -> Next,
    ) -> Result<()> {
        self.starts += 1;
        let (tolerance, target) = (self.tolerance, &self.problem.target);
        let most = self.options.max_iterations.min(POLISH_STEPS);
        let (mut newton_steps, mut nearest) = (0, self.nearest);
        let mut tracer = Tracer::new(self.map.as_mut(), homotopy, size, max_steps);
        let outcome = tracer.run(from, |map, near| {
            map.set_target(target);
            let mut y = near.to_vec();
            let report = match map.solve(&mut y, tolerance, most) {
                Ok(report) => report,
                Err(error @ Error::Interrupted { .. }) => return Err(error),
                Err(_) => return Ok(Next::Refine),
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
        self.continuation_steps += tracer.steps;
        self.nearest = nearest;
        outcome
    }

    /// The account so far.
    pub(super) fn report(&self, strategy: BoundaryStrategy) -> BoundaryReport {
        let (residual, reason) = self.nearest;
        BoundaryReport {
            solver: SolverReport {
                converged: reason == StopReason::Converged,
                iterations: self.newton_steps,
                residual,
                tolerance: self.tolerance,
                reason,
            },
            strategy,
            continuation_steps: self.continuation_steps,
            starts: self.starts,
        }
    }
}
