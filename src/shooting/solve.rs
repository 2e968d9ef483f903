//! Solving a chain: with short series first, then with as many terms as the curves need.

use super::chain::{Chain, Group};
use super::orders::{MOST, Orders};
use super::solved::Solved;
use crate::error::Result;
use crate::legs::{Curves, Knots, Options, Progress};
use crate::linalg::field::Field;
use crate::report::{SolverReport, StopReason};
use crate::space::Homogeneous;

/// Solves the equations from velocities at the knots, per unit of time, and `x'` and `x''` at the start of each leg, in the time
/// of the leg, which become those of the solution; the curves where it is found.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn solve<T, S>(
    space: S,
    knots: &Knots<'_>,
    velocities: &mut [f64],
    bends: &mut [f64],
    options: &Options<'_>,
) -> Result<(SolverReport, Option<Box<dyn Curves>>)>
where
    T: Field + Send + Sync + 'static,
    S: Homogeneous + 'static,
{
    let mut progress = Progress::new(options.tolerance);
    let groups = knots.lengths.len().div_ceil(T::COUNT);
    let mut room = vec![T::ZERO; groups * Group::<T>::len(space)];
    let mut chain = Chain::<T, S>::new(space, knots, velocities, &mut room, MOST);
    let order = options
        .third_derivative
        .map(|_| Orders::last().of_leg(knots.speed(space, velocities), 0));
    chain.set_middles(bends, order);
    let reason = chain.newton(&mut progress, options)?;
    if reason != StopReason::Converged {
        return Ok((progress.report(reason), None));
    }
    chain.write(velocities, bends);
    chain.step_blindly();
    let curves = Solved::new(space, knots.lengths.len(), &chain.groups);
    Ok((progress.report(reason), Some(Box::new(curves))))
}
