//! Solving a chain: on few nodes first, then on as many as the polynomials need.

use std::sync::Arc;

use super::chain::Chain;
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::legs::{Curves, Knots, Options, Progress};
use crate::linalg::field::Field;
use crate::report::{SolverReport, StopReason};
use crate::space::Homogeneous;

/// Nodes for legs along which nothing turns, to begin with and then, and more of them for a radian. Splines through 200 random
/// rotations need 16 fine ones for steps of 0.2 rad and 21 for steps of 1.2 rad, where the largest speeds are 0.27 and 1.6; those
/// through 20 points on St(8,4) and St(12,4), a radian apart, take 1.5 and 1.3 times as long with `15 + 4 s` at once.
const COARSE: [f64; 2] = [3.0, 1.5];
const FIRST: [f64; 2] = [9.0, 2.5];

/// More nodes where polynomials through the present ones leave out too much.
const MORE: usize = 5;

/// The last Legendre coefficients of the frames' derivative: what follows them is a tenth of it, and a fortieth of that after
/// integration.
const TAIL: f64 = 5e-13;

/// Nodes at the most.
const MOST: [usize; 2] = [24, 48];

/// Polynomials of more nodes lose digits at the ends of legs where they are written in powers: with 44 accelerations jump by up to
/// 4e-10.
const EXACT: usize = 32;

/// Residual from which on the fine nodes count.
const ROUGH: f64 = 1e-3;

/// Solves the equations from velocities at the knots, per unit of time, and `x'` and `x''` at the start of each leg, in the time
/// of the leg, which become those of the solution; the polynomials where they are exact.
///
/// # Errors
/// `Interrupted`, `Overflow`, those of the start.
pub(crate) fn solve<T: Field, S: Homogeneous>(
    space: S,
    knots: &Knots<'_>,
    velocities: &mut [f64],
    bends: &mut [f64],
    options: &Options<'_>,
) -> Result<(SolverReport, Option<Box<dyn Curves>>)> {
    let rough = Nodes::of(nodes(COARSE, knots.speed(space, velocities), MOST[0]));
    let mut progress = Progress::new(options.tolerance);
    let mut chain = Chain::<T, S>::new(space, knots, velocities, bends, &rough);
    if let Some(third_derivative) = options.third_derivative {
        chain.set_third_derivatives(&rough, third_derivative)?;
    }
    let (reason, curves) = chain.solve(rough, &mut progress, options)?;
    if reason == StopReason::Converged {
        chain.write(velocities, bends);
    }
    Ok((progress.report(reason), curves))
}

/// So many nodes, or sweeps, for a leg along which the frame turns by `speed`; as many as there may be where that is not finite.
pub(crate) fn nodes([still, radian]: [f64; 2], speed: f64, most: usize) -> usize {
    let wanted = (still + radian * speed).ceil();
    match wanted < most as f64 {
        true => wanted as usize,
        false => most,
    }
}

impl<T: Field, S: Homogeneous> Chain<'_, T, S> {
    /// On a few nodes, then on more until the polynomials leave nothing out.
    fn solve(
        &mut self,
        rough: Arc<Nodes>,
        progress: &mut Progress,
        options: &Options<'_>,
    ) -> Result<(StopReason, Option<Box<dyn Curves>>)> {
        let mut present = rough;
        let mut reason = self.sweep(&present, ROUGH, progress, options)?;
        let mut count = nodes(FIRST, self.speed(), MOST[1]);
        while reason == StopReason::Converged {
            let finer = Nodes::of(count);
            self.refine(&present, &finer);
            present = finer;
            reason = self.sweep(&present, options.tolerance, progress, options)?;
            if reason == StopReason::Converged && self.tail(&present) <= TAIL {
                let curves: Option<Box<dyn Curves>> = match count <= EXACT {
                    true => Some(Box::new(self.dense(&present))),
                    false => None,
                };
                return Ok((reason, curves));
            }
            if count == MOST[1] {
                return Ok((StopReason::Stagnated, None));
            }
            count = (count + MORE).min(MOST[1]);
        }
        Ok((reason, None))
    }
}
