//! The solution of a boundary value problem that costs least among those that several starts lead to.
//!
//! Near data have one cheap solution, and the cubic of flat space leads to it. Farther apart it may lead to one that costs a
//! thousand times as much, and where it leads depends on the direction in which the curve is run. So the data are solved from
//! both ends, along quasi-geodesic and geodesic, and from other curves that have them.
//!
//! Two bounds end the search. With the speed `u = |S'|` every curve of length at least `d` has, as `|D_t S'| >= |u'|`,
//!
//! ```math
//! J \ge \min_{\int u \ge d} \int_0^1 u'^2\, dt = (u_1 - u_0)^2 + 12 \max\Bigl(0,\ d - \frac{u_0 + u_1}{2}\Bigr)^2,
//! ```
//!
//! which the geodesic run from rest to rest attains. And the cheapest solution costs at most as much as any curve with the
//! data.

use super::boundary::BoundaryStrategy;
use super::continuation::norm;
use super::curve_start::CurveFamily;
use super::guess::FlatData;
use super::problem::Problem;
use super::random::Random;
use super::solver::{Solution, Solver};
use super::taylor::Accuracy;
use crate::error::{Error, Result};

/// Costs of curves are known to a percent.
const SLACK: f64 = 1.01;

/// Chains that are relaxed where other solutions cost more than a known curve.
const CHAINS: u32 = 4;

/// Unknowns up to which all curves and a chain are tried even if no known curve costs less than the solutions so far: with more
/// that takes 0.3 s on St(6,3), where the rest takes 0.05 s.
const SMALL: usize = 16;

/// Unknowns up to which a polynomial of least cost is looked for: on St(8,4), with 44, that takes a second where there is none.
const MINIMAL_COST_UNKNOWNS: usize = 32;

/// Share of the limit of work for each of the two ends.
const SHARE: f64 = 0.6;

impl<'a> Solver<'a> {
    /// The cheapest solution of those that are found; `None` if no strategy finds one.
    ///
    /// # Errors
    /// `DifferentComponents`, `Interrupted`.
    pub(super) fn of_low_cost(&mut self) -> Result<Option<Solution>> {
        let flat = self.problem.flat()?;
        let start = self.problem.flat_start(flat.as_ref());
        let mut best = Cheapest::default();
        self.consider(&mut best, start.clone(), BoundaryStrategy::Direct)?;
        let is_near = |flat| self.problem.is_moderate(flat);
        let settled = match best.found {
            Some(_) => flat.as_ref().is_some_and(is_near),
            None => self.is_out_of_steps(),
        };
        if settled {
            return Ok(best.solution());
        }
        self.map.allow(SHARE);
        self.try_all(&mut best, &start)?;
        if best.is_least() {
            return Ok(best.solution());
        }
        // The same from the other end.
        let back = self.problem.reversed();
        let start_there = back.flat_start(back.flat()?.as_ref());
        let mut there = self.at_other_end(&back);
        let mut found = Cheapest::default();
        there.consider(&mut found, start_there.clone(), BoundaryStrategy::Direct)?;
        there.try_all(&mut found, &start_there)?;
        let mut solution = found.solution();
        if solution.is_none() && best.found.is_none() && !self.has_met_round_off() {
            if let Some(found) = self.anywhere(&start)? {
                return Ok(Some(found));
            }
            solution = there.anywhere(&start_there)?;
        }
        self.join(&there);
        if let Some((y, _)) = solution {
            let y = there.reversed(&y)?;
            self.consider(&mut best, y, BoundaryStrategy::Reversed)?;
        }
        Ok(best.solution())
    }

    /// A solver of the reversed problem.
    pub(super) fn at_other_end<'b>(&self, back: &'b Problem) -> Solver<'b>
    where
        'a: 'b,
    {
        let mut there = Solver::new(back, self.options);
        there.map.allow(SHARE);
        there
    }

    /// The start of a solution of this problem, run backwards.
    pub(super) fn reversed(&mut self, y: &[f64]) -> Result<Vec<f64>> {
        self.map.set_target(&self.problem.target);
        let [.., a, second] = self.map.end(y, Accuracy::FULL)?;
        Ok(self.problem.reversed_start(&a, &second))
    }

    /// From all other starts at this end; chains of low cost first where nothing was found.
    fn try_all(&mut self, best: &mut Cheapest, start: &[f64]) -> Result<()> {
        self.try_geodesic(best)?;
        if best.is_least() {
            return Ok(());
        }
        let (size, mut random) = (norm(start), Random::new(0));
        // Where ends are hard to join a chain is most likely to, and the next one to lead elsewhere.
        let alone = best.found.is_none();
        if alone {
            self.try_chain(best, 0, size, &mut random)?;
        }
        self.try_curves(best)?;
        for attempt in u32::from(alone)..CHAINS {
            let needed = match attempt {
                0 => self.is_small() || !best.is_low(),
                _ => !best.is_low() && best.at_most.is_finite(),
            };
            if !needed || self.map.exhausted() {
                break;
            }
            self.try_chain(best, attempt, size, &mut random)?;
        }
        Ok(())
    }

    /// Newton's method from a start, and whether it leads to a cheaper solution.
    fn consider(
        &mut self,
        best: &mut Cheapest,
        mut y: Vec<f64>,
        strategy: BoundaryStrategy,
    ) -> Result<()> {
        if self.restarted(&mut y)? {
            let report = self.report(strategy);
            best.keep(self.cost(&y)?, (y, report));
        }
        Ok(())
    }

    /// From the cubic of flat space along the geodesic, an exact solution where both velocities are zero.
    fn try_geodesic(&mut self, best: &mut Cheapest) -> Result<()> {
        let Some((flat, length)) = geodesic(self.problem)? else {
            return Ok(());
        };
        best.at_least = length.map_or(0.0, |length| lower_bound(self.problem, length));
        if best.is_least() {
            return Ok(());
        }
        let y = self.problem.start_of(&flat);
        self.consider(best, y, BoundaryStrategy::Geodesic)
    }

    /// From other curves with the same data.
    fn try_curves(&mut self, best: &mut Cheapest) -> Result<()> {
        for family in CurveFamily::QUICK {
            let is_affordable = self.problem.unknowns() <= MINIMAL_COST_UNKNOWNS;
            if family.is_of_least_cost() && (best.is_low() || !is_affordable) {
                break;
            }
            let Some(start) = family.start(self.problem, self.options.interrupt)? else {
                continue;
            };
            best.at_most = best.at_most.min(start.cost);
            if family == CurveFamily::Geometric {
                self.try_geometric(best, start.y)?;
            } else if self.is_small() || !best.is_low() {
                self.consider(best, start.y, BoundaryStrategy::Polynomial)?;
            }
        }
        Ok(())
    }

    /// From the adjusted de Casteljau curve, by continuation where Newton's method leads nowhere: without, 3 of 200 hard
    /// problems are solved by curves that cost up to 2.3 times as much.
    fn try_geometric(&mut self, best: &mut Cheapest, start: Vec<f64>) -> Result<()> {
        let mut y = start.clone();
        if self.restarted(&mut y)? {
            let report = self.report(BoundaryStrategy::Polynomial);
            best.keep(self.cost(&y)?, (y, report));
        } else if let Some(y) = self.moved(&start, norm(&start))? {
            let report = self.report(BoundaryStrategy::Moving);
            best.keep(self.cost(&y)?, (y, report));
        }
        Ok(())
    }

    /// Whether a start more costs little.
    fn is_small(&self) -> bool {
        self.problem.unknowns() <= SMALL
    }

    /// From a chain of low cost.
    fn try_chain(
        &mut self,
        best: &mut Cheapest,
        attempt: u32,
        size: f64,
        random: &mut Random,
    ) -> Result<()> {
        if let Some((y, report)) = self.relaxed(attempt, size, random)? {
            best.keep(self.cost(&y)?, (y, report));
        }
        Ok(())
    }
}

/// The cheapest solution so far, and bounds of the least cost.
struct Cheapest {
    found: Option<(f64, Solution)>,
    at_least: f64,
    at_most: f64,
}

impl Default for Cheapest {
    fn default() -> Self {
        Cheapest {
            found: None,
            at_least: 0.0,
            at_most: f64::INFINITY,
        }
    }
}

impl Cheapest {
    fn keep(&mut self, cost: f64, solution: Solution) {
        if self.found.as_ref().is_none_or(|(least, _)| cost < *least) {
            self.found = Some((cost, solution));
        }
    }

    /// Whether no solution costs less, to a percent.
    fn is_least(&self) -> bool {
        self.costs_at_most(SLACK * self.at_least)
    }

    /// Whether no known curve costs less, to a percent.
    fn is_low(&self) -> bool {
        self.costs_at_most(SLACK * self.at_most)
    }

    fn costs_at_most(&self, bound: f64) -> bool {
        self.found.as_ref().is_some_and(|(cost, _)| *cost <= bound)
    }

    fn solution(self) -> Option<Solution> {
        self.found.map(|(_, solution)| solution)
    }
}

/// Displacement and end velocity along the geodesic between the end points, and its length if it is certainly the shortest;
/// `None` if no geodesic is found.
pub(super) fn geodesic(problem: &Problem) -> Result<Option<(FlatData, Option<f64>)>> {
    let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
    match FlatData::along_geodesic(s1, v1) {
        Ok((flat, report)) => {
            let length = report.certainly_shortest.then_some(report.length);
            Ok(Some((flat, length)))
        }
        Err(error @ Error::Interrupted { .. }) => Err(error),
        Err(_) => Ok(None),
    }
}

/// The least cost of a curve of at least the given length with the end speeds of a problem.
fn lower_bound(problem: &Problem, length: f64) -> f64 {
    let velocity = &problem.velocity;
    let (first, last) = (velocity.inner(velocity).sqrt(), problem.end_speed());
    let missing = (length - 0.5 * (first + last)).max(0.0);
    (last - first).powi(2) + 12.0 * missing.powi(2)
}
