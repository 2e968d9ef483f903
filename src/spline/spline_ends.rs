//! Whether a curve of Riemannian cubics is a spline with the given ends.

use faer::Mat;

use super::ends::{EndCondition, EndConditions};
use super::knot_states::KnotStates;
use crate::error::{Error, Result};
use crate::linalg::structure::norm;

/// Jumps of velocity and acceleration up to here, in the time of the shorter leg at a knot and relative to one more than their
/// size, are those of a solver.
const JUMP: f64 = 1e-6;

/// Error where the curve jumps at a knot, or does not do at its ends what it should. Vectors of `states` are in units of the mean
/// leg.
///
/// # Errors
/// `InvalidArgument`, in `AtKnot`.
pub(super) fn check_ends(states: &KnotStates, ends: &EndConditions) -> Result<()> {
    let last = states.count() - 1;
    for knot in 1..last {
        for order in [1, 2] {
            let [before, after] = [&states.ends[knot - 1][1], &states.ends[knot][0]];
            let h = states.lengths[knot - 1].min(states.lengths[knot]);
            check(
                &before[order],
                &after[order],
                h.powi(order as i32),
                SMOOTH,
                knot,
            )?;
        }
    }
    let [first, end] = [states.at(0), states.at(last)];
    let lengths = [states.lengths[0], states.lengths[last - 1]];
    match ends {
        EndConditions::Natural => {
            let zero = Mat::zeros(first[0].nrows(), first[0].ncols());
            check(&first[2], &zero, lengths[0].powi(2), ENDS, 0)?;
            check(&end[2], &zero, lengths[1].powi(2), ENDS, last)
        }
        EndConditions::Periodic => {
            check(&first[0], &end[0], 1.0, ENDS, last)?;
            for order in [1, 2] {
                let h = lengths[0].min(lengths[1]).powi(order as i32);
                check(&first[order], &end[order], h, ENDS, last)?;
            }
            Ok(())
        }
        EndConditions::Each(each) => {
            for (i, (state, knot)) in [(first, 0), (end, last)].into_iter().enumerate() {
                let (order, vector) = match &each[i] {
                    EndCondition::Velocity(v) => (1, v),
                    EndCondition::Acceleration(a) => (2, a),
                };
                if vector.shape() != state[0].shape() {
                    return Err(Error::Shape {
                        name: "bc_type",
                        expected: format!("{:?}", state[0].shape()),
                        found: format!("{:?}", vector.shape()),
                    }
                    .at_knot(knot));
                }
                // One factor after the other: their product may overflow.
                let scaled = (0..order).fold(vector.clone(), |v, _| v * faer::Scale(states.unit));
                check(
                    &state[order],
                    &scaled,
                    lengths[i].powi(order as i32),
                    ENDS,
                    knot,
                )?;
            }
            Ok(())
        }
    }
}

const SMOOTH: &str = "a spline: velocity and acceleration are continuous to 1e-6 (solve with a smaller tolerance), this far from it";
const ENDS: &str = "the end conditions of this spline, met to 1e-6 (solve with a smaller tolerance), this far from it";

fn check(
    found: &Mat<f64>,
    wanted: &Mat<f64>,
    factor: f64,
    requirement: &'static str,
    knot: usize,
) -> Result<()> {
    let gap = factor * norm((found - wanted).as_ref());
    if gap <= JUMP * (1.0 + factor * norm(wanted.as_ref())) {
        return Ok(());
    }
    let error = Error::InvalidArgument {
        name: "curve",
        requirement,
        found: gap,
    };
    Err(error.at_knot(knot))
}
