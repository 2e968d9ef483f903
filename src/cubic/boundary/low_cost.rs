//! The boundary value solution of least cost among those found from several starts.
//!
//! Nearby data have one cheap solution, and Newton's method from the cubic of flat space finds it. For larger distances
//! the cost has several minima: descents start from a curve that rolls from one velocity to the other and from the
//! cubic of flat space, and Newton's method refines the cheapest result to the tolerance.

use std::cell::Cell;

use super::descent_start::{DescentStart, LEGS, LONGEST_LEG};
use super::guess::FlatData;
use super::shooting::takes_response;
use super::solution::SolvedStart;
use super::solver::{Reported, Solver};
use crate::cubic::taylor::work::of_products;
use crate::error::{Result, unless_interrupted};
use crate::legs::Options;
use crate::linalg::lanes::Lanes;
use crate::report::{StopReason, Strategy};
use crate::shooting::{
    ChainKnots, ChainLayout, DescentProblem, LeastCost, StartResponse, least_cost, products_of_step,
};
use crate::space::{Homogeneous, in_space};

/// Norm of the gradient at which descents stop, in the time of a leg; a few Newton steps then remain. With 1e-6, problems
/// with distance up to 3 and speeds up to 6 on St(6,3) and St(10,3) take 1.2 and 1.4 times as long, and none of 440
/// problems costs less; with 0.1, one of 40 on St(10,3) costs 1.2 times as much.
const TOLERANCE: f64 = 1e-3;

/// Second tolerance, near round-off, if Newton's method finds no solution from there. It is needed in the narrow
/// valleys between opposite points: without it, no such problem with speeds of 1e-6 is solved on St(3,1).
const FINER: f64 = 1e-15;

/// Maximal number of steps of a descent: while no solution has been found, and afterwards. Of 158 solvable problems
/// with speeds of 30 to 100, 36 take more than 100 steps; with 20 instead of 30 afterwards, one of 40 hard problems
/// costs 1.2 times as much.
const MAX_STEPS: usize = 300;
const LATER_STEPS: usize = 30;

/// A descent begins only if at least this many steps fit into the remaining work.
const FEWEST_STEPS: f64 = 20.0;

/// Only solutions that are cheaper by at least one percent are looked for.
const SLACK: f64 = 0.99;

/// Fraction of the work limit available to descents after one of them has found a solution.
const SHARE: f64 = 0.8;

/// Larger end speed from which the cubic of flat space is no longer tried in addition to the rolling curve: from speeds
/// of 20 on it takes four fifths of the time, and in none of 100 such problems does it reach a lower cost.
const FAST: f64 = 16.0;

/// Leg length of finer chains, as a fraction of the usual one.
const SHORT: f64 = 0.6;

/// The curve along which a descent starts.
#[derive(Clone, Copy)]
enum StartCurve {
    /// The rolling curve.
    Rolling,
    /// The cubic of flat space. Without it, 6 of 332 hard problems cost 1.05 to 1.33 times as much.
    Flat,
    /// The adjusted de Casteljau curve, used if no unique quasi-geodesic determines the frame at the end of the rolling
    /// curve. Without it, and with only the rolling curve there, 35 of 180 problems between coordinate and permuted
    /// frames cost up to 3.3 times as much.
    Geometric,
    /// The rolling curve with shorter legs, if the usual ones did not lead to a solution.
    RollingFinely,
}

const STARTS: [StartCurve; 4] = [
    StartCurve::Rolling,
    StartCurve::Flat,
    StartCurve::Geometric,
    StartCurve::RollingFinely,
];

/// The result of a descent.
struct DescentEnd {
    /// `(x', x'')` at the start of the curve.
    y: Vec<f64>,
    cost: f64,
    gradient: f64,
    is_at_rest: bool,
    knots: ChainKnots,
    response: Option<StartResponse>,
}

impl DescentEnd {
    /// Sort key, smaller is better: converged descents by cost, then the others by gradient.
    fn rank(&self) -> (bool, f64) {
        match self.is_at_rest {
            true => (false, self.cost),
            false => (true, self.gradient),
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
        let may_descend = self.may_descend(LEGS, 0.0);
        let near = flat
            .as_ref()
            .filter(|flat| self.problem.is_moderate(flat) || !may_descend);
        if let Some(flat) = near
            && let Some(found) = self.by_flat_start(flat)?
        {
            return Ok(Some((found, self.report(Strategy::Direct))));
        }
        if near.is_some() || !may_descend || self.has_few_steps() {
            let start = self.problem.flat_start(flat.as_ref());
            if let Some(found) = self.by_shooting(&start, None)? {
                return Ok(Some((found, self.report(Strategy::Direct))));
            }
            if self.is_out_of_steps() {
                return Ok(None);
            }
        }
        self.by_descents()
    }

    /// The solution from the cheapest result of the descents.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(crate) fn by_descents(&mut self) -> Result<Option<Reported>> {
        let reserve = (1.0 - SHARE) * self.map.work().left();
        // Whether the data determine the rolling curve, and whether its descent has come to rest.
        let (mut is_unique, mut has_rolled, mut ends) = (false, false, Vec::new());
        for start in STARTS {
            let known = least_cost_of(&ends);
            let is_wanted = match start {
                StartCurve::Rolling => true,
                StartCurve::Flat => !is_unique || self.problem.speed() <= FAST,
                StartCurve::Geometric => !is_unique,
                StartCurve::RollingFinely => !has_rolled,
            };
            if !is_wanted {
                continue;
            }
            let Some(curve) = self.start(start)? else {
                continue;
            };
            let limits = match known.is_finite() {
                false => (MAX_STEPS, known, 0.0),
                true => (LATER_STEPS, SLACK * known, reserve),
            };
            let end = self.descend(curve.chain_knots(), (limits, &ends), TOLERANCE)?;
            if matches!(start, StartCurve::Rolling) {
                is_unique = curve.is_unique();
                has_rolled = end.as_ref().is_some_and(|end| end.is_at_rest);
            }
            ends.extend(end);
        }
        self.polished(ends)
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
        let knots = start.chain_knots();
        let limits = (MAX_STEPS, f64::INFINITY, 0.0);
        let end = self.descend(knots, (limits, &[]), TOLERANCE)?;
        self.polished(end.into_iter().collect())
    }

    /// `None` if the curve does not exist.
    fn start(&self, start: StartCurve) -> Result<Option<DescentStart>> {
        let problem = self.problem;
        let ends = problem.relative_ends();
        let curve = match start {
            StartCurve::Rolling => DescentStart::rolling(problem.kind(), ends, LONGEST_LEG, LEGS),
            StartCurve::RollingFinely => {
                DescentStart::rolling(problem.kind(), ends, SHORT * LONGEST_LEG, LEGS)
            }
            StartCurve::Flat => match problem.flat()? {
                Some(flat) => DescentStart::along_flat(self.problem.kind(), ends, &flat),
                None => return Ok(None),
            },
            StartCurve::Geometric => DescentStart::along_geometric(problem),
        };
        unless_interrupted(curve)
    }

    /// Applies Newton's method to the results, best first, until it finds a solution; of those not at rest only the
    /// first is tried.
    fn polished(&mut self, mut ends: Vec<DescentEnd>) -> Result<Option<Reported>> {
        ends.sort_by(|a, b| {
            let [(a, x), (b, y)] = [a.rank(), b.rank()];
            a.cmp(&b).then(x.total_cmp(&y))
        });
        // One or two steps remain, whatever was done before.
        let left = self.map.work().left();
        self.map.work().allow(2.0);
        let reserve = self.map.work().left() - left;
        let mut solution = None;
        for mut end in ends {
            let is_at_rest = end.is_at_rest;
            let response = end.response.take();
            let found = match self.restarted(&end.y, response.as_ref())? {
                None => self.found_finely(&mut end, reserve)?,
                found => found,
            };
            solution = found.map(|found| (found, self.report(Strategy::Descent)));
            if solution.is_some() || !is_at_rest {
                break;
            }
        }
        self.map.work().allow(0.5);
        Ok(solution)
    }

    /// Continues a descent at rest to the finer tolerance and applies Newton's method.
    fn found_finely(&mut self, end: &mut DescentEnd, reserve: f64) -> Result<Option<SolvedStart>> {
        if !end.is_at_rest {
            return Ok(None);
        }
        let limits = (MAX_STEPS, f64::INFINITY, reserve);
        let knots = std::mem::take(&mut end.knots);
        match self.descend(knots, (limits, &[]), FINER)? {
            Some(finer) => self.restarted(&finer.y, finer.response.as_ref()),
            None => Ok(None),
        }
    }

    /// Whether a descent with the given number of legs may begin: enough steps must fit into the remaining work minus
    /// `reserve`.
    fn may_descend(&self, legs: usize, reserve: f64) -> bool {
        let products = in_space!(self.problem.shape(), |space| products_of_step(space, legs));
        FEWEST_STEPS * of_products(products) <= self.map.work().left() - reserve
    }

    /// The result of a descent; `None` if its cost would not be below `below`, if it would repeat one of the others, or if
    /// it would cut into `reserve`.
    fn descend(
        &mut self,
        knots: ChainKnots,
        ((max_iterations, below, reserve), others): ((usize, f64, f64), &[DescentEnd]),
        tolerance: f64,
    ) -> Result<Option<DescentEnd>> {
        if self.problem.unknowns() == 0 {
            return Ok(None);
        }
        let (left, work) = (self.map.work().left() - reserve, Cell::new(0.0));
        let shape = self.problem.shape();
        let d = in_space!(shape, |space| space.dim());
        let legs = knots.velocities.len() / d - 1;
        // The chain uses the time of a leg as its unit.
        let rate = legs as f64;
        if !self.may_descend(legs, reserve) {
            self.refuse();
            return Ok(None);
        }
        let may_go_on = |products: f64| {
            work.set(work.get() + of_products(products));
            work.get() <= left
        };
        let options = Options {
            third_derivative: None,
            tolerance,
            max_iterations,
            may_go_on: &may_go_on,
            interrupt: self.options.interrupt,
        };
        let at_rest = others.iter().filter(|end| end.is_at_rest);
        let known: Vec<_> = at_rest.map(|end| &end.knots).collect();
        let descent = DescentProblem {
            layout: ChainLayout::between_ends(legs),
            tension: self.problem.target.tension / (rate * rate),
            below: 0.5 * below / rate.powi(3),
            known: &known,
            with_response: takes_response(self.problem.unknowns()),
        };
        let LeastCost {
            report,
            derivatives,
            cost,
            knots,
            response,
        } = in_space!(shape, |space| least_cost::<Lanes, _>(
            space, knots, descent, &options
        ))?;
        self.map.work().count(work.get());
        self.account(report);
        let is_left = report.reason == StopReason::Stagnated && below.is_finite();
        let derivatives = derivatives.iter().take(2 * d).enumerate();
        let y: Vec<f64> = derivatives
            .map(|(i, x)| match i < d {
                true => rate.powi(2) * x,
                false => rate.powi(3) * x,
            })
            .collect();
        Ok((cost.is_finite() && !is_left).then_some(DescentEnd {
            y,
            cost: 2.0 * rate.powi(3) * cost,
            gradient: report.residual,
            is_at_rest: report.converged,
            knots,
            response,
        }))
    }
}

/// The least cost of the results at rest.
fn least_cost_of(ends: &[DescentEnd]) -> f64 {
    let at_rest = ends.iter().filter(|end| end.is_at_rest);
    at_rest.fold(f64::INFINITY, |least, end| least.min(end.cost))
}
