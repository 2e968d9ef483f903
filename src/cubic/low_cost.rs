//! The solution of a boundary value problem that costs least among those that several starts lead to.
//!
//! Near data have one cheap solution, and Newton's method from the cubic of flat space leads to it. Farther apart the cost has
//! several minima: descents start along a curve that rolls from one velocity to the other, and along the cubic of flat space;
//! Newton's method takes the cheapest end of them to the tolerance.

use std::cell::Cell;

use super::boundary::BoundaryStrategy;
use super::descent_start::{DescentStart, LEGS, LONGEST_LEG};
use super::guess::FlatData;
use super::shooting::takes_response;
use super::solver::{Solution, Solver};
use super::work::of_products;
use crate::error::{Error, Result};
use crate::legs::Options;
use crate::linalg::lanes::Lanes;
use crate::report::StopReason;
use crate::shooting::{Descent, Layout, LeastCost, StartResponse, least_cost, products_of_step};
use crate::space::{Homogeneous, in_space};

/// Descents end with a gradient of this size, in the time of a leg: a step or two of Newton's method are left.
const TOLERANCE: f64 = 1e-6;

/// And where Newton's method finds none from there, in the narrow valleys between opposite points, down to round-off: without
/// that no problem there with speeds of 1e-6 is solved on St(3,1).
const FINER: f64 = 1e-15;

/// Steps of a descent at most: until one has found a solution, and after that. Of 158 problems with speeds of 30 to 100 that
/// are solved, 36 take more than 100; with 20 in place of 30 one of 40 hard problems costs 1.2 times as much.
const MAX_STEPS: usize = 300;
const LATER_STEPS: usize = 30;

/// A descent is begun if so many steps of it may be done.
const FEWEST_STEPS: f64 = 20.0;

/// Solutions that cost less by at least a percent are looked for.
const SLACK: f64 = 0.99;

/// Share of the limit of work for descents that follow one which has found a solution.
const SHARE: f64 = 0.8;

/// Larger of the end speeds from which on the cubic of flat space is no start beside the rolling curve: from speeds of 20 on it
/// takes four fifths of the time, and of 100 such problems none ends lower.
const FAST: f64 = 16.0;

/// Share of the length of legs that shorter ones have.
const SHORT: f64 = 0.6;

/// What descents start along, one after the other.
#[derive(Clone, Copy)]
enum Start {
    /// The rolling curve.
    Rolling,
    /// The cubic of flat space. Without it 6 of 332 hard problems cost 1.05 to 1.33 times as much.
    Flat,
    /// The adjusted de Casteljau curve, where no unique quasi-geodesic says where the rolling one's frame ends. Without it, and
    /// the rolling one there, 35 of 180 problems between coordinate and permuted frames cost up to 3.3 times as much.
    Geometric,
    /// The rolling curve with shorter legs, where that has not led to a solution.
    RollingFinely,
}

const STARTS: [Start; 4] = [
    Start::Rolling,
    Start::Flat,
    Start::Geometric,
    Start::RollingFinely,
];

/// Where a descent ends.
struct End {
    /// `(x', x'')` at the start of the curve.
    y: Vec<f64>,
    cost: f64,
    gradient: f64,
    is_at_rest: bool,
    knots: Knots,
    response: Option<StartResponse>,
}

/// Frames and velocities of a chain, the latter in the time of a leg.
type Knots = (Vec<f64>, Vec<f64>);

impl End {
    /// Smaller is better: first ends at rest by their costs, then the others by their gradients.
    fn rank(&self) -> (bool, f64) {
        match self.is_at_rest {
            true => (false, self.cost),
            false => (true, self.gradient),
        }
    }
}

impl Solver<'_> {
    /// The cheapest solution of those that are found; `None` if none is.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(super) fn of_low_cost(&mut self) -> Result<Option<Solution>> {
        let flat = self.problem.flat()?;
        // Without descents the cubic of flat space is the only start, however far the end is.
        let may_descend = self.may_descend(LEGS, 0.0);
        let near = flat
            .as_ref()
            .filter(|flat| self.problem.is_moderate(flat) || !may_descend);
        if let Some(flat) = near
            && let Some(y) = self.by_one_series(flat)?
        {
            return Ok(Some((y, self.report(BoundaryStrategy::Direct))));
        }
        if near.is_some() || !may_descend || self.has_few_steps() {
            let mut y = self.problem.flat_start(flat.as_ref());
            if self.restarted(&mut y, None)? {
                return Ok(Some((y, self.report(BoundaryStrategy::Direct))));
            }
            if self.is_out_of_steps() {
                return Ok(None);
            }
        }
        self.by_descents()
    }

    /// From the cheapest end of descents.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(super) fn by_descents(&mut self) -> Result<Option<Solution>> {
        let reserve = (1.0 - SHARE) * self.map.left();
        // Whether the data say how the rolling curve goes, and whether the descent from there has come to rest.
        let (mut is_unique, mut has_rolled, mut ends) = (false, false, Vec::new());
        for start in STARTS {
            let known = least_cost_of(&ends);
            let is_wanted = match start {
                Start::Rolling => true,
                Start::Flat => !is_unique || self.problem.speed() <= FAST,
                Start::Geometric => !is_unique,
                Start::RollingFinely => !has_rolled,
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
            let end = self.descend(curve.frames(), limits, TOLERANCE)?;
            if matches!(start, Start::Rolling) {
                is_unique = curve.is_unique();
                has_rolled = end.as_ref().is_some_and(|end| end.is_at_rest);
            }
            ends.extend(end);
        }
        self.polished(ends)
    }

    /// From the end of a descent along a cubic of flat space.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(super) fn by_descent_along(&mut self, flat: &FlatData) -> Result<Option<Solution>> {
        let ends = self.problem.relative_ends();
        let Ok(start) = DescentStart::along_flat(self.problem.kind(), ends, flat) else {
            return Ok(None);
        };
        let knots = start.frames();
        let end = self.descend(knots, (MAX_STEPS, f64::INFINITY, 0.0), TOLERANCE)?;
        self.polished(end.into_iter().collect())
    }

    /// `None` where there is no such curve.
    fn start(&self, start: Start) -> Result<Option<DescentStart>> {
        let problem = self.problem;
        let ends = problem.relative_ends();
        let curve = match start {
            Start::Rolling => DescentStart::rolling(problem.kind(), ends, LONGEST_LEG, LEGS),
            Start::RollingFinely => {
                DescentStart::rolling(problem.kind(), ends, SHORT * LONGEST_LEG, LEGS)
            }
            Start::Flat => match problem.flat()? {
                Some(flat) => DescentStart::along_flat(self.problem.kind(), ends, &flat),
                None => return Ok(None),
            },
            Start::Geometric => DescentStart::along_geometric(problem),
        };
        match curve {
            Err(error @ Error::Interrupted { .. }) => Err(error),
            curve => Ok(curve.ok()),
        }
    }

    /// By Newton's method from the best end from which it finds a solution; of those that are not at rest only the first is
    /// tried.
    fn polished(&mut self, mut ends: Vec<End>) -> Result<Option<Solution>> {
        ends.sort_by(|a, b| {
            let [(a, x), (b, y)] = [a.rank(), b.rank()];
            a.cmp(&b).then(x.total_cmp(&y))
        });
        // What is left is a step or two, whatever was done before.
        let left = self.map.left();
        self.map.allow(2.0);
        let reserve = self.map.left() - left;
        let mut solution = None;
        for mut end in ends {
            let is_at_rest = end.is_at_rest;
            let response = end.response.take();
            if self.restarted(&mut end.y, response.as_ref())?
                || self.found_finely(&mut end, reserve)?
            {
                solution = Some((end.y, self.report(BoundaryStrategy::Descent)));
            }
            if solution.is_some() || !is_at_rest {
                break;
            }
        }
        self.map.allow(0.5);
        Ok(solution)
    }

    /// Newton's method from where a descent from an end at rest comes to rest by a finer measure.
    fn found_finely(&mut self, end: &mut End, reserve: f64) -> Result<bool> {
        if !end.is_at_rest {
            return Ok(false);
        }
        let limits = (MAX_STEPS, f64::INFINITY, reserve);
        let knots = std::mem::take(&mut end.knots);
        let Some(mut finer) = self.descend(knots, limits, FINER)? else {
            return Ok(false);
        };
        let found = self.restarted(&mut finer.y, finer.response.as_ref())?;
        end.y = finer.y;
        Ok(found)
    }

    /// Whether so many steps of a descent with a number of legs may be done that it is begun, when only so much work is left.
    fn may_descend(&self, legs: usize, reserve: f64) -> bool {
        let products = in_space!(self.problem.shape(), |space| products_of_step(space, legs));
        FEWEST_STEPS * of_products(products) <= self.map.left() - reserve
    }

    /// Where a descent ends; `None` where that would not be below a cost, and where it would go on when only so much work is
    /// left.
    fn descend(
        &mut self,
        knots: Knots,
        (max_iterations, below, reserve): (usize, f64, f64),
        tolerance: f64,
    ) -> Result<Option<End>> {
        if self.problem.unknowns() == 0 {
            return Ok(None);
        }
        let (left, work) = (self.map.left() - reserve, Cell::new(0.0));
        let shape = self.problem.shape();
        let d = in_space!(shape, |space| space.dim());
        let legs = knots.1.len() / d - 1;
        // The time of a leg is the unit of the chain.
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
        let descent = Descent {
            layout: Layout::between_ends(legs),
            tension: self.problem.target.tension / (rate * rate),
            below: 0.5 * below / rate.powi(3),
            with_response: takes_response(self.problem.unknowns()),
        };
        let LeastCost {
            report,
            bends,
            cost,
            frames,
            velocities,
            response,
        } = in_space!(shape, |space| least_cost::<Lanes, _>(
            space, knots, descent, &options
        ))?;
        self.map.count(work.get());
        self.account(report);
        let is_left = report.reason == StopReason::Stagnated && below.is_finite();
        let bends = bends.iter().take(2 * d).enumerate();
        let y: Vec<f64> = bends
            .map(|(i, x)| match i < d {
                true => rate.powi(2) * x,
                false => rate.powi(3) * x,
            })
            .collect();
        Ok((cost.is_finite() && !is_left).then_some(End {
            y,
            cost: 2.0 * rate.powi(3) * cost,
            gradient: report.residual,
            is_at_rest: report.converged,
            knots: (frames, velocities),
            response,
        }))
    }
}

/// Of ends at rest.
fn least_cost_of(ends: &[End]) -> f64 {
    let at_rest = ends.iter().filter(|end| end.is_at_rest);
    at_rest.fold(f64::INFINITY, |least, end| least.min(end.cost))
}
