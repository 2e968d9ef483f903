//! Checks that a curve of Riemannian cubics is a spline with the given ends.

use faer::{Mat, MatRef};

use super::given::GivenEnd;
use super::knot_states::KnotStates;
use crate::error::{Error, Result};
use crate::linalg::structure::{check_shape, norm};
use crate::spline::ends::{EndCondition, EndConditions};

/// Jumps of velocity and acceleration up to this are attributed to the solver's tolerance; in the time of the shorter
/// leg at a knot, relative to one plus their size.
const JUMP: f64 = 1e-6;

/// Return an error if the curve jumps at a knot or violates its end conditions. Vectors of `states` are in units of the
/// mean leg.
///
/// # Errors
/// `InvalidArgument`, wrapped in `AtKnot`.
pub(crate) fn check_ends(states: &KnotStates, ends: &EndConditions) -> Result<()> {
    let last = states.count() - 1;
    for knot in 1..last {
        for order in [1, 2] {
            let [before, after] = [&states.ends[knot - 1][1], &states.ends[knot][0]];
            let h = states.lengths[knot - 1].min(states.lengths[knot]);
            let factor = h.powi(order as i32);
            let [before, after] = [before, after].map(|state| states.matrix(&state[order]));
            check(before, after, factor, SMOOTH, knot)?;
        }
    }
    let found = |end: usize, order: usize| states.matrix(&states.at([0, last][end])[order]);
    let meets = |end: usize, order: usize, wanted: MatRef<'_, f64>| {
        let h = [states.lengths[0], states.lengths[last - 1]][end];
        let (found, knot) = (found(end, order), [0, last][end]);
        check(found, wanted, h.powi(order as i32), ENDS, knot)
    };
    let (n, k) = states.shape;
    match ends {
        EndConditions::Natural => {
            (0..2).try_for_each(|end| meets(end, 2, Mat::zeros(n, k).as_ref()))
        }
        EndConditions::Periodic => (0..3).try_for_each(|order| {
            let h = states.lengths[0].min(states.lengths[last - 1]);
            let first = match states.holonomy(GivenEnd::of(ends))? {
                Some(holonomy) => found(0, order) * holonomy,
                None => found(0, order).to_owned(),
            };
            check(
                first.as_ref(),
                found(1, order),
                h.powi(order as i32),
                ENDS,
                last,
            )
        }),
        EndConditions::Each(each) => (0..2).try_for_each(|end| {
            let (order, vector) = match &each[end] {
                EndCondition::Velocity(v) => (1, v),
                EndCondition::Acceleration(a) => (2, a),
            };
            check_shape("bc_type", vector.as_ref(), n, k)
                .map_err(|error| error.at_knot([0, last][end]))?;
            // Multiply one factor at a time: the product of the factors may overflow.
            let scaled = (0..order).fold(vector.clone(), |v, _| v * faer::Scale(states.unit));
            meets(end, order, scaled.as_ref())
        }),
    }
}

const SMOOTH: &str = "a spline whose velocity and acceleration jump by at most 1e-6 (solve with a smaller tolerance)";
const ENDS: &str =
    "a spline that meets its end conditions to 1e-6 (solve with a smaller tolerance)";

fn check(
    found: MatRef<'_, f64>,
    wanted: MatRef<'_, f64>,
    factor: f64,
    requirement: &'static str,
    knot: usize,
) -> Result<()> {
    let gap = factor * norm((found - wanted).as_ref());
    if gap <= JUMP * (1.0 + factor * norm(wanted)) {
        return Ok(());
    }
    let error = Error::InvalidArgument {
        name: "curve",
        requirement,
        found: gap,
    };
    Err(error.at_knot(knot))
}
