//! Solves a chain through given knots ([`solve`]), descends to the knots of least cost ([`least_cost`]), or takes a chain
//! to rest near given knots ([`nearest_stationary`]) or near the end of a descent ([`stationary_end`]): first with short
//! series, then with as many terms as the curves need.

use super::chains::chain::{LegGroup, SeriesChain};
use super::chains::solved::SolvedSeries;
use super::descents::chain_knots::ChainKnots;
use super::descents::free_chain::FreeChain;
use super::descents::layout::ChainLayout;
use super::taylor::orders::MOST;
use crate::error::Result;
use crate::legs::{Curves, Knots, Options, Progress};
use crate::linalg::field::Field;
use crate::report::{SolverReport, StopReason};
use crate::space::Homogeneous;

/// Solves the equations from velocities at the knots, per unit of time, and `x'` and `x''` at the start of each leg, in
/// the time of the leg. They are replaced by those of the solution, if it is found; returns its curves.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn solve<T, S>(
    space: S,
    knots: &Knots<'_>,
    velocities: &mut [f64],
    derivatives: &mut [f64],
    options: &Options<'_>,
) -> Result<(SolverReport, Option<Box<dyn Curves>>)>
where
    T: Field + Send + Sync + 'static,
    S: Homogeneous + 'static,
{
    let mut progress = Progress::new(options.tolerance);
    let groups = knots.lengths.len().div_ceil(T::COUNT);
    let mut room = vec![T::ZERO; groups * LegGroup::<T>::len(space)];
    let mut chain = SeriesChain::<T, S>::new(space, knots, velocities, &mut room, MOST);
    chain.set_middles(derivatives);
    let reason = chain.newton(&mut progress, options)?;
    if reason != StopReason::Converged {
        return Ok((progress.report(reason), None));
    }
    chain.write(velocities, derivatives);
    chain.step_blindly();
    let curves = SolvedSeries::new(space, knots.lengths.len(), &chain.groups);
    Ok((progress.report(reason), Some(Box::new(curves))))
}

/// Tolerances below this need a second derivative that is more accurate than the first few terms give.
const FINE: f64 = 1e-9;

/// A chain of legs at the end of a descent, or a stationary one.
pub(crate) struct LeastCost {
    pub(crate) report: SolverReport,
    /// `x'` and `x''` at the starts of the legs, per unit of time.
    pub(crate) derivatives: Vec<f64>,
    /// `int |x'|^2 + tau |x|^2 dt / 2`, plus the contribution of accelerations at the ends.
    pub(crate) cost: f64,
    /// Frames and velocities at the knots.
    pub(crate) knots: ChainKnots,
}

impl LeastCost {
    pub(crate) fn legs(&self) -> usize {
        self.derivatives.len() / (2 * self.dim())
    }

    /// Number of coordinates of a vector: one velocity per knot, two vectors per leg.
    pub(crate) fn dim(&self) -> usize {
        self.knots.velocities.len() - self.derivatives.len() / 2
    }

    /// `x, x', x''` at a knot, where a leg starts, in a unit of time of the given length; without `x'` and `x''` at the last
    /// knot.
    pub(crate) fn vectors(&self, knot: usize, unit: f64) -> Vec<f64> {
        let d = self.dim();
        let velocity = &self.knots.velocities[knot * d..][..d];
        let derivatives = self.derivatives.chunks_exact(2 * d).nth(knot);
        let all = velocity
            .iter()
            .chain(derivatives.unwrap_or(&[]))
            .enumerate();
        let scaled = all.map(|(i, x)| x * unit.powi(1 + (i / d) as i32));
        let mut vectors: Vec<f64> = scaled.collect();
        vectors.resize(3 * d, 0.0);
        vectors
    }
}

/// Options of a descent.
pub(crate) struct DescentProblem<'a> {
    pub(crate) layout: ChainLayout,
    /// Tension of the curves.
    pub(crate) tension: f64,
    /// The descent may stop if it would end at a higher cost.
    pub(crate) below: f64,
    /// Ends of other descents, of legs of unit duration; the descent may stop if it comes near one of them.
    pub(crate) known: &'a [&'a ChainKnots],
}

/// The curve of least cost that a descent reaches from frames and velocities at consecutive knots, per unit of time.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn least_cost<T: Field + Send + Sync, S: Homogeneous>(
    space: S,
    knots: ChainKnots,
    descent: DescentProblem<'_>,
    options: &Options<'_>,
) -> Result<LeastCost> {
    in_chain(space, knots, &descent, |mut chain: FreeChain<'_, T, S>| {
        match options.tolerance < FINE {
            true => {
                // Flat legs are too far off for an accurate second derivative.
                (options.may_go_on)(chain.products_of_equations());
                chain.meet_knots();
                chain.refine();
            }
            false => chain.set_tolerance(options.tolerance),
        }
        let mut progress = Progress::new(options.tolerance);
        let reason = chain.descend(&mut progress, (descent.below, descent.known), options)?;
        Ok(result(chain, progress.report(reason)))
    })
}

/// The stationary chain near given knots.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn nearest_stationary<T: Field + Send + Sync, S: Homogeneous>(
    space: S,
    knots: ChainKnots,
    descent: DescentProblem<'_>,
    options: &Options<'_>,
) -> Result<LeastCost> {
    in_chain(space, knots, &descent, |mut chain: FreeChain<'_, T, S>| {
        (options.may_go_on)(chain.products_of_equations());
        chain.meet_knots();
        settled(chain, options)
    })
}

/// The stationary chain near the end of a descent from given knots; the report is that of Newton's method, or of the
/// descent if it ends with a gradient above `near`.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn stationary_end<T: Field + Send + Sync, S: Homogeneous>(
    space: S,
    knots: ChainKnots,
    descent: DescentProblem<'_>,
    (descending, near): (&Options<'_>, f64),
    options: &Options<'_>,
) -> Result<LeastCost> {
    in_chain(space, knots, &descent, |mut chain: FreeChain<'_, T, S>| {
        chain.set_tolerance(descending.tolerance);
        let mut progress = Progress::new(descending.tolerance);
        let bounds = (descent.below, descent.known);
        let reason = chain.descend(&mut progress, bounds, descending)?;
        if chain.rest() <= near {
            return settled(chain, options);
        }
        // The limit of steps is not the caller's.
        let reason = match reason {
            StopReason::MaxIterations => StopReason::Stagnated,
            other => other,
        };
        let SolverReport {
            iterations,
            residual,
            ..
        } = progress.report(reason);
        let report = SolverReport::new(reason, iterations, residual, options.tolerance);
        Ok(result(chain, report))
    })
}

/// What is made of a chain with the given knots, with legs of flat space.
fn in_chain<T: Field, S: Homogeneous>(
    space: S,
    knots: ChainKnots,
    descent: &DescentProblem<'_>,
    act: impl FnOnce(FreeChain<'_, T, S>) -> Result<LeastCost>,
) -> Result<LeastCost> {
    let layout = descent.layout.clone();
    let mut room = vec![T::ZERO; FreeChain::<T, S>::len(space, layout.legs())];
    act(FreeChain::new(
        space,
        knots,
        layout,
        descent.tension,
        &mut room,
    ))
}

/// The stationary chain near the current one.
fn settled<T: Field, S: Homogeneous>(
    mut chain: FreeChain<'_, T, S>,
    options: &Options<'_>,
) -> Result<LeastCost> {
    let mut progress = Progress::new(options.tolerance);
    let reason = chain.settle(&mut progress, options)?;
    Ok(result(chain, progress.report(reason)))
}

fn result<T: Field, S: Homogeneous>(chain: FreeChain<'_, T, S>, report: SolverReport) -> LeastCost {
    let legs = 0..chain.layout.legs();
    LeastCost {
        report,
        derivatives: legs.flat_map(|leg| chain.derivatives(leg)).collect(),
        cost: chain.cost,
        knots: chain.state.knots,
    }
}
