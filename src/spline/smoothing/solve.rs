//! Solves the equations of a smoothing spline from several starts.

use faer::Mat;

use super::flat_smoothing::FlatSmoothing;
use super::generalised_cross_validation::GeneralisedCrossValidation;
use super::interpolating::{Interpolated, Interpolating};
use super::smoothing_equations::{SmoothingData, SmoothingEquations, work_of_residual};
use super::smoothing_options::SmoothingOptions;
use super::straight::Straight;
use crate::cubic::RiemannianCubic;
use crate::cubic::taylor::work::Work;
use crate::curve::Curve;
use crate::error::{Error, Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::{Appearance, appearance};
use crate::report::{SolverReport, StopReason};
use crate::spline::chains::chain::{SpannedSpace, pieces};
use crate::spline::chains::motion::Motion;
use crate::spline::chains::solution::Effort;
use crate::spline::reduced_knots::ReducedKnots;
use crate::threads;

/// Microseconds of the cost of a piece; 32 on St(20,5).
const COST: f64 = 4.0;

/// Minimal number of trials allowed for many data: with two threads, 120 random points on St(9, 7) are refused after
/// 2.0 s. With 40 trials they are refused after 1.4 s, but a hundred noisy points of a geodesic on St(12, 4) are not
/// solved.
const TRIALS: f64 = 57.0;

/// Work limit of all starts together, in units of the first one's. With 1, sixteen of 288 sets of noisy points of
/// geodesics are not solved; with 2, no further ones are. Measured when the geodesic was the only further start.
const FURTHER_STARTS: f64 = 1.6;

/// Relative amount by which the objective of a minimum may exceed that of another curve: the square of the defects left
/// at convergence, and round-off.
const NO_WORSE: f64 = 1e-9;

pub(super) struct SolvedSmoothing {
    pub(super) pieces: Vec<RiemannianCubic>,
    pub(super) report: SolverReport,
    /// In units of the mean leg.
    pub(super) lambda: f64,
    pub(super) misfit: f64,
    /// Misfit plus `lambda` times cost; infinite unless solved.
    objective: f64,
    pub(super) degrees_of_freedom: f64,
}

impl SolvedSmoothing {
    /// Whether it is solved, and not worse than a curve with the given objective.
    fn is_minimal(&self, bound: f64) -> bool {
        self.report.converged
            && self.objective <= bound * (1.0 + NO_WORSE) + self.report.tolerance.powi(2)
    }

    /// With a report that says so if a curve with the given objective is better.
    fn judged(mut self, bound: f64) -> Self {
        if self.report.converged && !self.is_minimal(bound) {
            let SolverReport {
                iterations,
                residual,
                tolerance,
                ..
            } = self.report;
            let reason = StopReason::NotMinimal;
            self.report = SolverReport::new(reason, iterations, residual, tolerance);
        }
        self
    }
}

/// Solves the equations from one start after another.
struct Attempts<'a, F> {
    /// Makes a chain through points.
    through: F,
    data: &'a SmoothingData,
    lambda: f64,
    flat: FlatSmoothing,
    work: &'a Work,
    space: &'a SpannedSpace,
    options: &'a SmoothingOptions,
    interrupt: Interrupt<'a>,
}

impl<F> Attempts<'_, F> {
    /// From the smoothing spline of flat space, for a chain through points near the data.
    fn at_points<C: Interpolated>(&self, points: &[Mat<f64>]) -> Result<SolvedSmoothing>
    where
        F: Fn(&[Mat<f64>]) -> Result<C>,
    {
        let (flat, chain) = (self.flat.clone(), (self.through)(points)?);
        self.solved(SmoothingEquations::new(chain, self.data, flat, self.work)?)
    }

    /// From a motion along the chain through points.
    fn near<C: Interpolated>(&self, points: &[Mat<f64>], motion: &Motion) -> Result<SolvedSmoothing>
    where
        F: Fn(&[Mat<f64>]) -> Result<C>,
    {
        let (flat, chain) = (self.flat.clone(), (self.through)(points)?);
        let motion = motion.clone();
        self.solved(SmoothingEquations::near(
            chain, motion, self.data, flat, self.work,
        ))
    }

    fn solved<C: Interpolated>(
        &self,
        mut equations: SmoothingEquations<'_, C>,
    ) -> Result<SolvedSmoothing> {
        let interrupt = self.interrupt;
        let SmoothingOptions {
            tolerance,
            max_iterations,
            ..
        } = *self.options;
        let report = equations.solve(tolerance, max_iterations)?;
        let (chain, motion) = (equations.chain(), equations.motion());
        let (mut found, mut objective) = (Vec::new(), f64::INFINITY);
        if report.converged {
            found = pieces(chain.lengths().len(), self.space, |leg| {
                chain.integrated(leg, motion, interrupt)
            })?;
            objective =
                equations.misfit() + self.flat.lambda() * cost(&found, chain.lengths(), interrupt)?;
        }
        Ok(SolvedSmoothing {
            pieces: found,
            report,
            lambda: self.lambda,
            misfit: equations.misfit(),
            objective,
            degrees_of_freedom: self.flat.degrees_of_freedom(chain.lengths())?,
        })
    }
}

/// Starts at the points of a chain through the data; if that leads to no minimum, at the spline through the data and at
/// the geodesic nearest to them, the better of the two first.
///
/// # Errors
/// `Interrupted`, and the errors of the first start.
pub(super) fn solve<C: Interpolated>(
    through: impl Fn(&[Mat<f64>]) -> Result<C>,
    knots: &ReducedKnots,
    data: &SmoothingData,
    lambda: Option<f64>,
    options: &SmoothingOptions,
    interrupt: Interrupt<'_>,
) -> Result<SolvedSmoothing> {
    let (points, space) = (&knots.points[..], knots.space());
    let (chain, seem) = (through(points)?, appearance(options.quotient, points));
    let trial = work_of_residual(&chain);
    let work = options.spline().work(TRIALS, trial, seem);
    let validation = GeneralisedCrossValidation::new(&chain, data, &work)?;
    let lambda = match lambda {
        Some(lambda) => lambda,
        None => validation.best()?,
    };
    let attempts = Attempts {
        through,
        data,
        lambda,
        flat: validation.flat(lambda)?,
        work: &work,
        space: &space,
        options,
        interrupt,
    };
    let straight = Straight::nearest(chain.lengths(), data, options.quotient, interrupt)?;
    let bound = straight.as_ref().map_or(f64::INFINITY, |one| one.misfit);
    let first = attempts.at_points(points);
    let is_minimal = |bound: f64| first.as_ref().is_ok_and(|one| one.is_minimal(bound));
    if first.as_ref().is_err_and(Error::is_interrupted)
        || seem == Appearance::Bases
        || is_minimal(bound) && !chain.is_far()
    {
        return first.map(|first| first.judged(bound));
    }
    work.allow(FURTHER_STARTS);
    let effort = Effort::new(&options.spline(), &work, interrupt);
    let has_work = first
        .as_ref()
        .map_or(true, |one| one.report.reason != StopReason::WorkLimit);
    // What is left of the work then belongs to the geodesic, from which noisy points of geodesics are solved.
    let interpolating = match has_work {
        true => Interpolating::of(&chain, data, attempts.flat.lambda(), effort)?,
        false => None,
    };
    let bound = interpolating
        .as_ref()
        .map_or(bound, |one| bound.min(one.objective));
    if is_minimal(bound) {
        return first;
    }
    let at_spline = || Some(attempts.near(points, &interpolating.as_ref()?.motion));
    let at_straight = || Some(attempts.at_points(&straight.as_ref()?.points));
    let mut starts: [&dyn Fn() -> Option<Result<SolvedSmoothing>>; 2] = [&at_straight, &at_spline];
    if interpolating
        .as_ref()
        .is_some_and(|one| one.objective <= bound)
    {
        starts.reverse();
    }
    for start in starts {
        if let Some(found) = start()
            && let Some(found) = unless_interrupted(found)?
            && found.is_minimal(bound)
        {
            return Ok(found);
        }
    }
    // The error of the start at the data is more informative.
    first.map(|first| first.judged(bound))
}

/// The cost of pieces on `[0, 1]` that take the given durations.
///
/// # Errors
/// `Interrupted`, and the errors of [`Curve::cost`].
fn cost(pieces: &[RiemannianCubic], lengths: &[f64], interrupt: Interrupt<'_>) -> Result<f64> {
    let each = threads::map(
        pieces.len(),
        COST,
        || (),
        |(), leg| Ok(pieces[leg].cost(interrupt)? * lengths[leg].powi(-3)),
    )?;
    Ok(each.iter().sum())
}
