//! Boundary value problems of single cubics by Newton's method at Gauss nodes.
//!
//! The linear equations are those of flat space plus a smoothing operator, so GMRES, preconditioned by flat space,
//! solves them in a few products. The first steps use few nodes; the number that the curve needs is chosen where they
//! have led, and raised until the last Legendre coefficients of the frames are negligible, and up to 32 nodes also
//! those of the fourth derivative of the points.
//!
//! # Source
//! Eisenstat, Walker (1996), "Choosing the forcing terms in an inexact Newton method", SIAM J. Sci. Comput. 17, 16-32.

use std::sync::Arc;

use super::boundary_curve::boundary_curve;
use super::boundary_leg::{BoundaryData, BoundaryLeg};
use crate::collocation::expansion::EXACT;
use crate::collocation::lane_nodes::{FINE, LaneNodes, MOST, nodes};
use crate::collocation::linear::linear_operator::{Operator, Way};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::legs::Dense;
use crate::linalg::field::larger;
use crate::solve::gmres::{Gmres, norm};
use crate::solve::line_search::backtracked;
use crate::space::{Homogeneous, Shape, in_space};

const SOLVER: &str = "boundary value problem of a Riemannian cubic";

/// As [`FINE`], for the first steps.
const COARSE: [f64; 2] = [3.0, 1.5];

/// Residual below which the first phase ends.
const ROUGH: f64 = 1e-3;

/// Largest residual of the equations along the curve, absolute and relative to its largest `x'` or `x''` at a node.
const INSIDE: f64 = 1e-12;
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Largest size of the last Legendre coefficients of the frames' derivative: integrals over the whole interval are far
/// more accurate, so that `x'` and `x''` at the start are exact to round-off.
const TAIL: f64 = 1e-11;

/// Number of multiplications in one product with the linearised equations beyond which another method is used: work,
/// memory and time without a poll for interruption grow with it. An estimate of a second, not measured.
const LARGEST: f64 = 1e9;

/// Largest relative residual of a solution of the linear equations; smaller ones near the solution, where Newton's
/// method squares the residual.
const FORCING: f64 = 0.1;

/// Linear equations are not solved more accurately than this fraction of the tolerance.
const SHARE: f64 = 0.1;

/// Largest defect of the frames, relative to the residual that the next step can reach.
const FRAMES: f64 = 0.1;

/// Number of lengths of a step that are tried.
const STEP_LENGTHS: i32 = 4;

/// When to stop.
#[derive(Clone, Copy)]
pub(crate) struct BoundaryLimits<'a> {
    /// Distance of the end, in point and velocity, from the given one.
    pub(crate) tolerance: f64,
    pub(crate) steps: usize,
    /// Called with the number of products that a step has taken: whether another one may begin.
    pub(crate) may_go_on: &'a dyn Fn(f64) -> bool,
    pub(crate) interrupt: Interrupt<'a>,
}

/// The curve at which Newton's method starts, for given `x'` and `x''` at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BoundaryStart {
    /// The cubic of flat space, whose end is near the given one.
    Flat,
    /// The curve that satisfies the equations.
    Curve,
}

/// The solution, if one is found, and the number of Newton steps.
pub(crate) struct BoundaryOutcome {
    pub(crate) found: Option<SolvedLeg>,
    pub(crate) steps: usize,
}

/// A solution: `x'` and `x''` at its start, and its polynomials if these are accurate.
pub(crate) struct SolvedLeg {
    pub(crate) derivatives: [Vec<f64>; 2],
    pub(crate) curve: Option<Dense>,
}

/// The cubic between given ends that Newton's method finds from `x'` and `x''` at the start; none if the curve is too
/// fast for this method, or the space too large.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn solve_between_ends(
    shape: Shape,
    data: &BoundaryData,
    start: ([Vec<f64>; 2], BoundaryStart),
    limits: BoundaryLimits<'_>,
) -> Result<BoundaryOutcome> {
    in_space!(shape, |space| {
        let Some(mut newton) = Newton::new(space, data, start, limits) else {
            return Ok(BoundaryOutcome {
                found: None,
                steps: 0,
            });
        };
        let found = newton.solve()?;
        Ok(BoundaryOutcome {
            found,
            steps: newton.steps,
        })
    })
}

/// The state of the iteration.
struct Newton<'a, S> {
    leg: BoundaryLeg<'a, S>,
    limits: BoundaryLimits<'a>,
    steps: usize,
}

impl<'a, S: Homogeneous> Newton<'a, S> {
    /// `None` for a start that is too fast.
    fn new(
        space: S,
        data: &'a BoundaryData,
        (derivatives, start): ([Vec<f64>; 2], BoundaryStart),
        limits: BoundaryLimits<'a>,
    ) -> Option<Self> {
        let few = LaneNodes::at_least(1)?;
        let mut leg = BoundaryLeg::new(space, data, derivatives, &few);
        leg.smooth();
        let speed = larger(leg.speed(), data.tension.sqrt());
        let first = lane_nodes(COARSE, speed)?;
        lane_nodes(FINE, speed)?;
        if leg.multiplications() > LARGEST {
            return None;
        }
        if first.count() > few.count() {
            leg = leg.on_nodes(&first);
        }
        if start == BoundaryStart::Curve {
            leg.follow(ROUGH);
        }
        leg.evaluate(FRAMES * ROUGH);
        Some(Newton {
            leg,
            limits,
            steps: 0,
        })
    }

    /// The solution, on as many nodes as its frames need, and its polynomials with it; without these, if they would
    /// need too many.
    ///
    /// # Errors
    /// `Interrupted`.
    fn solve(&mut self) -> Result<Option<SolvedLeg>> {
        if !self.run(ROUGH, |_| ROUGH)? {
            return Ok(None);
        }
        let speed = larger(self.leg.speed(), self.leg.tension().sqrt());
        let mut more = lane_nodes(FINE, speed);
        let inside = |leg: &BoundaryLeg<'_, S>| INSIDE.max(ROUND_OFF * leg.largest_derivative());
        let mut found = None;
        while let Some(nodes) = more {
            if nodes.count() > self.leg.nodes.count() {
                self.leg = self.leg.on_nodes(&nodes);
                self.leg.evaluate(f64::EPSILON);
            }
            if !self.run(self.limits.tolerance, inside)? {
                break;
            }
            if self.leg.tail() <= TAIL {
                let (derivatives, curve) =
                    (self.leg.derivatives.clone(), boundary_curve(&self.leg));
                let is_last = curve.is_some() || self.leg.nodes.count() >= EXACT;
                found = Some(SolvedLeg { derivatives, curve });
                if is_last {
                    break;
                }
            }
            let count = self.leg.nodes.count().max(nodes.count());
            more = lane_nodes([0.0, 1.0], count as f64 + 1.0);
        }
        Ok(found)
    }

    /// Iterates until the end is as near as wanted, and the equations are satisfied along the curve; `false` if they
    /// cannot be.
    ///
    /// # Errors
    /// `Interrupted`.
    fn run(&mut self, distance: f64, inside: impl Fn(&BoundaryLeg<'a, S>) -> f64) -> Result<bool> {
        loop {
            let wanted = inside(&self.leg);
            if self.leg.residual.is_within((distance, wanted)) {
                return Ok(true);
            }
            if self.steps == self.limits.steps || !self.step(distance.min(wanted))? {
                return Ok(false);
            }
            self.steps += 1;
        }
    }

    /// Takes one step; returns `false` if no step reduces the residual, if nothing is left of it although the end is
    /// not the given one, or if no work is left.
    ///
    /// # Errors
    /// `Interrupted`.
    fn step(&mut self, wanted: f64) -> Result<bool> {
        let leg = &self.leg;
        let (mut step, mut products) = (leg.flat_step(), 0.0);
        let size = norm(&step);
        if size <= f64::EPSILON || !size.is_finite() {
            return Ok(false);
        }
        let terms = leg.terms();
        let mut linear = Operator::new(&terms, &leg.nodes, leg.tension());
        let forcing = larger(FORCING.min(size), SHARE * wanted / size).min(FORCING);
        Gmres::new(step.len()).try_solve(&mut step, forcing, |y, image| {
            self.limits.interrupt.check(SOLVER)?;
            products += 1.0;
            linear.apply(y, image, Way::Forward);
            Result::Ok(())
        })?;
        let product = leg.multiplications();
        // An upper estimate for the evaluations: one took the instructions of two to three products on St(20,5).
        if !(self.limits.may_go_on)((products + 5.0) * product) {
            return Ok(false);
        }
        let before = leg.unknowns();
        let found = backtracked(size, STEP_LENGTHS, |share| {
            self.leg.set_unknowns(&before, &step, -share);
            self.leg.evaluate(FRAMES * size * size);
            Ok(Some((norm(&self.leg.flat_step()), ())))
        })?;
        Ok(found.is_some())
    }
}

/// Nodes for a curve with the given largest velocity; `None` if it is too fast.
fn lane_nodes(rule: [f64; 2], speed: f64) -> Option<Arc<LaneNodes>> {
    let count = nodes(rule, speed, MOST + 1);
    (count <= MOST).then(|| LaneNodes::at_least(count))?
}
