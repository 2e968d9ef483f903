//! Newton's method for a chain: on few nodes first, then on as many as the polynomials need.

use super::chain::{Chain, ThirdDerivative};
use super::dense::Dense;
use super::knots::Knots;
use super::nodes::Grid;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::{Field, larger};
use crate::report::StopReason;
use crate::space::Homogeneous;

/// Nodes for legs along which nothing turns, of the derivative and of the equations, and more of them for a radian.
const COARSE: [f64; 2] = [3.0, 1.5];
const FINE: [f64; 2] = [9.0, 2.5];

/// More nodes where polynomials through the present ones leave out too much.
const MORE: usize = 5;

/// The last Legendre coefficients of the frames' derivative: what follows them is a tenth of it, and integrated.
const TAIL: f64 = 2e-14;

/// Nodes at the most.
const MOST: [usize; 2] = [24, 48];

/// Residual from which on the fine nodes count.
const ROUGH: f64 = 1e-3;

/// Halvings of a step before it is given up.
const MAX_HALVINGS: i32 = 8;

/// A step is shortened until the residual falls by this share of what it would by the linear equations.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Residuals are known to this share of the largest acceleration or third vector of a leg, in its own time.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

const SOLVER: &str = "collocation";

/// What a start is.
#[derive(Clone, Copy)]
pub(crate) enum Start<'a> {
    /// The solution of flat space: `x'''` is left out.
    Flat,
    /// Near a solution, with its third derivative.
    Near(&'a ThirdDerivative<'a>),
}

/// Where to start, and when to stop.
pub(crate) struct Options<'a> {
    pub(crate) start: Start<'a>,
    /// Of all equations, in the time of the legs.
    pub(crate) tolerance: f64,
    pub(crate) max_iterations: usize,
    /// Asked before every iteration: whether there is work left for it.
    pub(crate) may_go_on: &'a dyn Fn() -> bool,
    /// Asked before every iteration.
    pub(crate) interrupt: Interrupt<'a>,
}

/// How an iteration ended.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) reason: StopReason,
    pub(crate) iterations: usize,
    pub(crate) residual: f64,
    /// What was asked for, or round-off where that is more.
    pub(crate) tolerance: f64,
}

/// Solves the equations from velocities at the knots, per unit of time, and `x'` and `x''` at the start of each leg, in the time
/// of the leg, which become the last that were reached.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn solve<T: Field, S: Homogeneous>(
    space: S,
    knots: &Knots<'_>,
    velocities: &mut [f64],
    bends: &mut [f64],
    options: &Options<'_>,
) -> Result<(Outcome, Option<Dense>)> {
    let speed = start_speed(space, knots, velocities);
    let coarse = nodes(COARSE, speed, MOST[0]);
    let rough = Grid::new(coarse, coarse);
    let mut chain = Chain::<T, S>::new(space, knots, velocities, bends, &rough);
    if let Start::Near(third_derivative) = options.start {
        chain.set_third_derivatives(&rough.fine, third_derivative)?;
    }
    let mut outcome = chain.iterate(&rough, ROUGH, 0, options)?;
    let (mut grid, mut fine) = (rough, nodes(FINE, chain.speed(), MOST[1]));
    let mut dense = None;
    while outcome.reason == StopReason::Converged {
        let finer = Grid::new(fine, coarse);
        chain.refine(&grid.fine, &finer);
        grid = finer;
        outcome = chain.iterate(&grid, options.tolerance, outcome.iterations, options)?;
        if outcome.reason == StopReason::Converged && chain.tail(&grid.fine) <= TAIL {
            dense = Some(chain.dense(&grid.fine));
            break;
        }
        if fine == MOST[1] {
            outcome.reason = StopReason::Stagnated;
        }
        fine = (fine + MORE).min(MOST[1]);
    }
    chain.write(velocities, bends);
    Ok((outcome, dense))
}

/// The largest velocity at a knot, in the time of a leg, or distance of a knot from the next one.
fn start_speed(space: impl Homogeneous, knots: &Knots<'_>, velocities: &[f64]) -> f64 {
    let (d, r) = (space.dim(), space.size());
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let speed = |knot: usize| norm(&velocities[knot * d..][..d]);
    let mut largest = 0.0;
    for (leg, (h, target)) in knots.lengths.iter().zip(&knots.targets).enumerate() {
        let mut chord = target.to_vec();
        for i in 0..r {
            chord[i * r + i] -= 1.0;
        }
        largest = larger(largest, h * speed(leg).max(speed(leg + 1)));
        largest = larger(largest, norm(&chord));
    }
    largest
}

/// So many nodes, or sweeps, for a leg along which the frame turns by `speed`.
pub(super) fn nodes([still, radian]: [f64; 2], speed: f64, most: usize) -> usize {
    ((still + radian * speed).ceil() as usize).min(most)
}

impl<T: Field, S: Homogeneous> Chain<'_, T, S> {
    /// Newton's method, damped, on one grid.
    fn iterate(
        &mut self,
        grid: &Grid,
        tolerance: f64,
        mut iterations: usize,
        options: &Options<'_>,
    ) -> Result<Outcome> {
        self.evaluate(grid);
        let mut goal;
        let reason = loop {
            goal = tolerance.max(ROUND_OFF * self.largest_bend());
            if self.size <= goal {
                break StopReason::Converged;
            }
            if iterations >= options.max_iterations {
                break StopReason::MaxIterations;
            }
            if !(options.may_go_on)() {
                break StopReason::WorkLimit;
            }
            options.interrupt.check(SOLVER)?;
            iterations += 1;
            if !self.linearise(grid) {
                break StopReason::SingularJacobian;
            }
            if !self.descend(grid, goal) {
                break StopReason::Stagnated;
            }
        };
        Ok(Outcome {
            reason,
            iterations,
            residual: self.size,
            tolerance: goal,
        })
    }

    /// The step, shortened until it leads down; `false` where none does.
    fn descend(&mut self, grid: &Grid, goal: f64) -> bool {
        let before = self.merit;
        let mut share = 1.0;
        self.advance(share);
        for _ in 0..MAX_HALVINGS {
            self.evaluate(grid);
            // The frames lag behind by a step, which the merit does not see.
            let wanted = (1.0 - SUFFICIENT_DECREASE * share) * before;
            if self.merit <= wanted || self.merit <= goal {
                return true;
            }
            share *= 0.5;
            self.advance(-share);
        }
        // Back to where the residual is known.
        self.advance(-share);
        self.evaluate(grid);
        false
    }
}
