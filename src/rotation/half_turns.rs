//! Half turns between rotations at which rates are given: the rates decide the direction.

use std::f64::consts::PI;

use nalgebra::{UnitQuaternion, Vector3};

use crate::error::{Error, Result};

/// Rotations by angles this close to `pi` have no unique shortest path: round-off of the angle, as for the logarithm of
/// rotations.
const ROUND_OFF: f64 = 12.0 * f64::EPSILON;

/// Checks that the rates decide the direction of every half turn: the turn about its axis at the mean of both rates
/// must exceed `ROUND_OFF (1 + s)`, where `s` is the turn at the mean of their norms.
///
/// # Errors
/// `UndecidedTurn` in `AtKnot`.
pub(super) fn check_directions(
    t: &[f64],
    rotations: &[UnitQuaternion<f64>],
    rates: &[Vector3<f64>],
) -> Result<()> {
    let pairs = rotations.windows(2).zip(rates.windows(2)).zip(t.windows(2));
    for (knot, ((rotations, rates), t)) in pairs.enumerate() {
        let [p, q] = [&rotations[0].coords, &rotations[1].coords];
        // The angle is pi less twice this number, to third order.
        let scalar = p.dot(q).abs();
        if 2.0 * scalar > ROUND_OFF {
            continue;
        }
        let turn = rotations[0].inverse() * rotations[1];
        let (axis, mean) = (turn.imag().normalize(), 0.5 * (t[1] - t[0]));
        let along = mean * axis.dot(&(rates[0] + rates[1])).abs();
        let at_norms = mean * (rates[0].norm() + rates[1].norm());
        if along <= ROUND_OFF * (1.0 + at_norms) {
            let angle = PI - 2.0 * scalar;
            return Err(Error::UndecidedTurn { angle }.at_knot(knot));
        }
    }
    Ok(())
}
