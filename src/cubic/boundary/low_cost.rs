//! The boundary value solution of least cost among those found from several starts.
//!
//! Nearby data have one cheap solution, and Newton's method from the cubic of flat space finds it. For larger distances
//! the cost has several minima: descents start from a curve that rolls from one velocity to the other and from the
//! cubic of flat space. Newton's method at Gauss nodes takes the cheapest result to the tolerance; where it fails, the
//! descent goes on to the tolerance itself. Guesses between subspaces start from their own curve
//! ([`Solver::near_curve`]).

use std::cell::Cell;

use super::descent_start::{DescentStart, LEGS};
use super::guess::FlatData;
use super::solution::SolvedStart;
use super::solver::{Reported, Solver};
use crate::collocation::BoundaryStart;
use crate::cubic::taylor::work::{of_products, work_of_step};
use crate::error::{Result, unless_interrupted};
use crate::legs::Options;
use crate::linalg::lanes::Lanes;
use crate::report::{StopReason, Strategy};
use crate::shooting::{
    ChainKnots, ChainLayout, DescentProblem, LeastCost, least_cost, nearest_stationary,
    products_of_step,
};
use crate::space::{Homogeneous, in_space};

/// Norm of the gradient at which descents stop, in the time of a leg; a few Newton steps then remain. With 1e-6, problems
/// with distance up to 3 and speeds up to 6 on St(6,3) and St(10,3) take 1.2 and 1.4 times as long, and none of 440
/// problems costs less; with 0.1, one of 40 on St(10,3) costs 1.2 times as much.
const TOLERANCE: f64 = 1e-3;

/// Second tolerance, near round-off, if Newton's method at nodes finds no solution from there: in the narrow valleys
/// between opposite points, and for curves that are too fast for nodes. At 1e-15, 10 of 100 hard problems on St(3,1) do not
/// come to rest.
const FINER: f64 = 1e-13;

/// Largest norm of the gradient of a chain whose legs count as one curve. With the tolerance of a caller who allows 1e-2,
/// velocities and accelerations jump where legs meet, and the energy drifts by a tenth.
const AT_REST: f64 = 1e-12;

/// Maximal number of steps of a descent: while no solution has been found, and afterwards. Of 158 solvable problems
/// with speeds of 30 to 100, 36 take more than 100 steps; with 20 instead of 30 afterwards, one of 40 hard problems
/// costs 1.2 times as much.
const MAX_STEPS: usize = 300;
const LATER_STEPS: usize = 30;

/// A descent begins only if at least this many steps fit into the remaining work. To the second tolerance a few steps are
/// enough, each of which takes the work of three.
const FEWEST_STEPS: f64 = 20.0;
const FEWEST_FINE_STEPS: f64 = 9.0;

/// The work limit is raised by this for the way to the tolerance, whatever was done before, up to this larger end speed.
/// With 3, three of 1000 hard problems on St(16,4) are not solved; with 2, two of 10 on St(10,3) with speeds of 30. With 4,
/// refusals take up to 2.2 s, on St(4,2) with speeds of 100. For faster curves it would solve up to 4 of 20 problems with
/// speeds of 1000, and their refusals would take more than a second.
const FINISH: f64 = 4.0;
const VERY_FAST: f64 = 200.0;

/// The work limit is raised by this for descents that would exceed it, after Newton's method has failed: in dimensions up to
/// 68 they may begin then. Without it, one more of 40 hard problems on St(15,5) is not solved.
const UNUSUAL: f64 = 2.0;

/// Only solutions that are cheaper by at least one percent are looked for.
const SLACK: f64 = 0.99;

/// Fraction of the work limit available to descents after one of them has found a solution.
const SHARE: f64 = 0.8;

/// Larger end speed from which the cubic of flat space is no longer tried in addition to the rolling curve: from speeds
/// of 20 on it takes four fifths of the time, and in none of 100 such problems does it reach a lower cost.
const FAST: f64 = 16.0;

/// The curve along which a descent starts.
#[derive(Clone, Copy)]
enum StartCurve {
    /// The rolling curve. Without it, hard problems take 1.5 to 2.2 times as long, and of 40 to 60 with speeds of 30 or 100
    /// on St(3,1), (3,2) and (4,2), up to 6 cost up to 2.1 times as much.
    Rolling,
    /// The cubic of flat space. Without it, 6 of 332 hard problems cost 1.05 to 1.33 times as much.
    Flat,
    /// The adjusted de Casteljau curve, used if no unique quasi-geodesic determines the frame at the end of the rolling
    /// curve. Without it, and with only the rolling curve there, 35 of 180 problems between coordinate and permuted
    /// frames cost up to 3.3 times as much.
    Geometric,
}

const STARTS: [StartCurve; 3] = [StartCurve::Rolling, StartCurve::Flat, StartCurve::Geometric];

/// The end of a descent, or of Newton's method to a stationary curve.
struct DescentEnd {
    /// In the time of a leg.
    chain: LeastCost,
    /// In the time of the curve.
    cost: f64,
}

/// Limits of a descent.
struct Limits<'a> {
    max_iterations: usize,
    /// It must be possible to take this many steps.
    fewest: f64,
    /// It ends if its cost would not be below this, or if it would repeat one of the others.
    below: f64,
    others: &'a [DescentEnd],
    /// Work that must remain.
    reserve: f64,
    tolerance: f64,
    wanted: Wanted,
}

/// Which chain is looked for.
#[derive(Clone, Copy)]
enum Wanted {
    /// One of least cost, down the cost.
    LeastCost,
    /// The nearest stationary one, up or down.
    Stationary,
}

impl Limits<'_> {
    /// A descent for its own sake.
    const ALONE: Limits<'static> = Limits {
        max_iterations: MAX_STEPS,
        fewest: FEWEST_STEPS,
        below: f64::INFINITY,
        others: &[],
        reserve: 0.0,
        tolerance: TOLERANCE,
        wanted: Wanted::LeastCost,
    };
}

impl DescentEnd {
    /// `(x', x'')` at the start of the curve.
    fn start(&self) -> Vec<f64> {
        let start = self.chain.vectors(0, self.chain.legs() as f64);
        start[start.len() / 3..].to_vec()
    }

    fn is_at_rest(&self) -> bool {
        self.chain.report.converged
    }

    /// Sort key, smaller is better: converged descents by cost, then the others by gradient.
    fn rank(&self) -> (bool, f64) {
        match self.is_at_rest() {
            true => (false, self.cost),
            false => (true, self.chain.report.residual),
        }
    }
}

impl Solver<'_> {
    /// The cheapest solution found; `None` if none is found.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(crate) fn of_low_cost(&mut self) -> Result<Option<Reported>> {
        let flat = self.problem.flat()?;
        // Without descents, the cubic of flat space is the only start at any distance.
        let may_descend = self.may_descend(LEGS, &Limits::ALONE);
        let is_near = |flat: &FlatData| self.problem.is_moderate(flat);
        if flat.as_ref().is_some_and(is_near) || !may_descend || self.has_few_steps() {
            if let Some(found) = self.by_flat_start(flat.as_ref())? {
                return Ok(Some((found, self.report(Strategy::Direct))));
            }
            if self.has_few_steps() {
                self.refuse(StopReason::MaxIterations);
                self.measure(&self.problem.flat_start(flat.as_ref()))?;
                return Ok(None);
            }
        }
        let found = self.by_descents()?;
        if found.is_none() {
            self.measure(&self.problem.flat_start(flat.as_ref()))?;
        }
        Ok(found)
    }

    /// The solution from the cheapest result of the descents.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(crate) fn by_descents(&mut self) -> Result<Option<Reported>> {
        let more = match self.may_descend(LEGS, &Limits::ALONE) {
            true => 1.0,
            false => UNUSUAL,
        };
        self.work.allow(more);
        let reserve = (1.0 - SHARE) * self.work.left();
        // Whether the data determine the rolling curve.
        let (mut is_unique, mut ends) = (false, Vec::new());
        for start in STARTS {
            let known = least_cost_of(&ends);
            let is_wanted = match start {
                StartCurve::Rolling => true,
                StartCurve::Flat => !is_unique || self.problem.speed <= FAST,
                StartCurve::Geometric => !is_unique,
            };
            if !is_wanted {
                continue;
            }
            let Some(curve) = self.start(start)? else {
                continue;
            };
            let limits = match known.is_finite() {
                false => Limits::ALONE,
                true => Limits {
                    max_iterations: LATER_STEPS,
                    below: SLACK * known,
                    reserve,
                    ..Limits::ALONE
                },
            };
            let others = &ends;
            let end = self.descend(curve.chain_knots(), &Limits { others, ..limits })?;
            if matches!(start, StartCurve::Rolling) {
                is_unique = curve.is_unique();
            }
            ends.extend(end);
        }
        let found = self.polished(ends)?;
        self.work.allow(more.recip());
        Ok(found)
    }

    /// The solution from a descent along the given cubic of flat space.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(crate) fn by_descent_along(&mut self, flat: &FlatData) -> Result<Option<Reported>> {
        let ends = self.problem.relative_ends();
        let Ok(start) = DescentStart::along_flat(self.problem.kind(), ends, flat) else {
            return Ok(None);
        };
        let end = self.descend(start.chain_knots(), &Limits::ALONE)?;
        self.polished(end.into_iter().collect())
    }

    /// `None` if the curve does not exist.
    fn start(&self, start: StartCurve) -> Result<Option<DescentStart>> {
        let problem = self.problem;
        let ends = problem.relative_ends();
        let curve = match start {
            StartCurve::Rolling => DescentStart::rolling(problem.kind(), ends, LEGS),
            StartCurve::Flat => match problem.flat()? {
                Some(flat) => DescentStart::along_flat(self.problem.kind(), ends, &flat),
                None => return Ok(None),
            },
            StartCurve::Geometric => DescentStart::along_geometric(problem),
        };
        unless_interrupted(curve)
    }

    /// Takes the results to the tolerance, best first, until this leads to a solution; of those not at rest only the first
    /// is tried.
    fn polished(&mut self, mut ends: Vec<DescentEnd>) -> Result<Option<Reported>> {
        ends.sort_by(|a, b| {
            let [(a, x), (b, y)] = [a.rank(), b.rank()];
            a.cmp(&b).then(x.total_cmp(&y))
        });
        let more = match self.problem.speed <= VERY_FAST {
            true => FINISH,
            false => 1.0,
        };
        self.work.allow(more);
        let mut solution = None;
        for end in ends {
            let (start, is_at_rest) = (end.start(), end.is_at_rest());
            let mut found = self.at_nodes(&start, BoundaryStart::Curve)?;
            if found.is_none() {
                found = self.found_finely(end.chain.knots)?;
            }
            solution = found.map(|found| (found, self.report(Strategy::Descent)));
            if solution.is_some() || !is_at_rest {
                break;
            }
        }
        self.work.allow(more.recip());
        Ok(solution)
    }

    /// Continues a descent to the finer tolerance: its legs are then one curve. Without it, 41 of 400 hard problems on
    /// St(3,1) are not solved, 32 of 200 on St(4,2), and 58 of 60 there with speeds of 30.
    fn found_finely(&mut self, knots: ChainKnots) -> Result<Option<SolvedStart>> {
        let limits = Limits {
            fewest: FEWEST_FINE_STEPS,
            tolerance: FINER,
            ..Limits::ALONE
        };
        let end = self.descend(knots, &limits)?;
        end.map_or(Ok(None), |end| self.integrated_legs(&end))
    }

    /// The solution near the curve with the given `(x', x'')` at its start: by Newton's method from its chain of legs.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn near_curve(&mut self, start: &[f64]) -> Result<Option<SolvedStart>> {
        let limits = Limits {
            fewest: FEWEST_FINE_STEPS,
            max_iterations: self.options.max_iterations,
            tolerance: self.tolerance().min(AT_REST),
            wanted: Wanted::Stationary,
            ..Limits::ALONE
        };
        if !self.may_descend(LEGS, &limits) {
            return Ok(None);
        }
        let Some(cubic) = self.roughly_integrated(start)? else {
            return Ok(None);
        };
        let Ok(curve) = DescentStart::along_cubic(self.problem, &cubic) else {
            return Ok(None);
        };
        let end = self.descend(curve.chain_knots(), &limits)?;
        end.map_or(Ok(None), |end| self.integrated_legs(&end))
    }

    /// The curve of a chain at rest, if its legs and its end are near enough.
    fn integrated_legs(&mut self, end: &DescentEnd) -> Result<Option<SolvedStart>> {
        if !end.is_at_rest() {
            return Ok(None);
        }
        let problem = self.problem;
        let legs = problem.integrated_legs(&end.chain, self.interrupt);
        let Some((taylor, gap)) = unless_interrupted(legs)? else {
            return Ok(None);
        };
        let steps = taylor.len() as f64;
        self.work.count(steps * work_of_step(problem.blocks()));
        Ok(match gap <= self.tolerance() {
            true => self.accepted(&end.start(), taylor),
            false => None,
        })
    }

    /// Whether a descent with the given number of legs may begin.
    fn may_descend(&self, legs: usize, limits: &Limits<'_>) -> bool {
        let products = in_space!(self.problem.shape(), |space| products_of_step(space, legs));
        limits.fewest * of_products(products) <= self.work.left() - limits.reserve
    }

    /// The result of a descent within limits; `None` if there is nothing to be gained, or not enough work left.
    fn descend(&mut self, knots: ChainKnots, limits: &Limits<'_>) -> Result<Option<DescentEnd>> {
        if self.problem.unknowns() == 0 {
            return Ok(None);
        }
        let (left, work) = (self.work.left() - limits.reserve, Cell::new(0.0));
        let shape = self.problem.shape();
        let d = in_space!(shape, |space| space.dim());
        let legs = knots.velocities.len() / d - 1;
        // The chain uses the time of a leg as its unit.
        let rate = legs as f64;
        if !self.may_descend(legs, limits) {
            self.refuse(StopReason::WorkLimit);
            return Ok(None);
        }
        let may_go_on = |products: f64| {
            work.set(work.get() + of_products(products));
            work.get() <= left
        };
        let options = Options {
            tolerance: limits.tolerance,
            max_iterations: limits.max_iterations,
            may_go_on: &may_go_on,
            interrupt: self.interrupt,
        };
        let at_rest = limits.others.iter().filter(|end| end.is_at_rest());
        let known: Vec<_> = at_rest.map(|end| &end.chain.knots).collect();
        let descent = DescentProblem {
            layout: ChainLayout::between_ends(legs),
            tension: self.problem.tension / (rate * rate),
            below: 0.5 * limits.below / rate.powi(3),
            known: &known,
        };
        let chain = in_space!(shape, |space| match limits.wanted {
            Wanted::LeastCost => least_cost::<Lanes, _>(space, knots, descent, &options),
            Wanted::Stationary => {
                nearest_stationary::<Lanes, _>(space, knots, descent, &options)
            }
        })?;
        self.work.count(work.get());
        self.count_steps(chain.report.iterations);
        let is_left = chain.report.reason == StopReason::Stagnated && limits.below.is_finite();
        let cost = 2.0 * rate.powi(3) * chain.cost;
        Ok((cost.is_finite() && !is_left).then_some(DescentEnd { chain, cost }))
    }
}

/// The least cost of the results at rest.
fn least_cost_of(ends: &[DescentEnd]) -> f64 {
    let at_rest = ends.iter().filter(|end| end.is_at_rest());
    at_rest.fold(f64::INFINITY, |least, end| least.min(end.cost))
}
