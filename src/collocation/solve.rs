//! Solves a chain: first on few nodes, then on as many as the polynomials need.

use std::sync::Arc;

use super::chain::Chain;
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::legs::{Curves, Knots, Options, Progress};
use crate::linalg::field::Field;
use crate::report::{SolverReport, StopReason};
use crate::space::Homogeneous;

/// Number of nodes for legs without rotation, and additional ones per radian: at first, and afterwards. Splines through
/// 200 random rotations need 16 nodes in the second phase for steps of 0.2 rad and 21 for steps of 1.2 rad, where the
/// largest speeds are 0.27 and 1.6; those through 20 points on St(8,4) and St(12,4), one radian apart, take 1.5 and 1.3
/// times as long with `15 + 4 s` nodes at once.
const COARSE: [f64; 2] = [3.0, 1.5];
const FIRST: [f64; 2] = [9.0, 2.5];

/// Number of nodes added if the truncation error of the polynomials is too large.
const MORE: usize = 5;

/// Allowed size of the last Legendre coefficients of the frames' derivative: the following ones are a tenth of it, and
/// a fortieth of that after integration.
const TAIL: f64 = 5e-13;

/// Maximal number of nodes, in both phases.
const MOST: [usize; 2] = [24, 48];

/// Largest number of nodes for which polynomials written in powers are accurate at the ends of legs: with 44,
/// accelerations jump by up to 4e-10.
const EXACT: usize = 32;

/// Residual below which the second phase begins.
const ROUGH: f64 = 1e-3;

/// Solves the equations from velocities at the knots, per unit of time, and `x'` and `x''` at the start of each leg, in
/// the time of the leg. They are replaced by those of the solution; returns the polynomials if they are accurate.
///
/// # Errors
/// `Interrupted`, `Overflow`, and the errors of the start.
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

/// The number of nodes, or of iterations, for a leg along which the frame rotates by `speed`; the maximum if `speed` is
/// not finite.
pub(crate) fn nodes([still, radian]: [f64; 2], speed: f64, most: usize) -> usize {
    let wanted = (still + radian * speed).ceil();
    match wanted < most as f64 {
        true => wanted as usize,
        false => most,
    }
}

impl<T: Field, S: Homogeneous> Chain<'_, T, S> {
    /// Solves on a few nodes, then on more until the truncation error is negligible.
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
