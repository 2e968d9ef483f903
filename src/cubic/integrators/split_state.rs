//! The interface between a splitting and a state, and compensated sums.

use crate::error::{Error, Result};

/// The state `(g, x, p, mu)` of a cubic with the exact flows of the two parts of its Hamiltonian.
///
/// ```math
/// H_A = \langle \mu, x \rangle:\quad g \leftarrow g\, e^{hx},\quad
/// p \leftarrow p - \Bigl(\int_0^h e^{-sx} \mu\, e^{sx} ds\Bigr)_m,\quad \mu \leftarrow e^{-hx} \mu\, e^{hx};\qquad
/// H_B = \tfrac12 |p|^2:\quad x \leftarrow x + h p
/// ```
///
/// In tension `H_A` has the additional term `- tau |x|^2 / 2`, and its flow also changes `p <- p + h tau x`; `x` is
/// constant in both.
pub(crate) trait SplitState {
    /// The flow of `H_A`.
    ///
    /// # Errors
    /// `TooFewSteps` if it turns too far; `Overflow`.
    fn rotate(&mut self, h: f64) -> Result<()>;

    /// The flow of `H_B`.
    fn drift(&mut self, h: f64);
}

/// Largest angle of one exponential, in radians: beyond it, a step says little about the curve.
const LARGEST_TURN: f64 = 100.0;

/// Return an error if an exponential turns too far.
#[inline(always)]
pub(crate) fn check_turn(angle: f64) -> Result<()> {
    if angle <= LARGEST_TURN {
        return Ok(());
    }
    if angle.is_finite() {
        return Err(Error::TooFewSteps {
            angle,
            largest: LARGEST_TURN,
        });
    }
    Err(Error::Overflow {
        quantity: "rotation of a step",
    })
}

/// `sum += increment`, where `low` accumulates the rounding errors (Kahan's compensated sum).
///
/// Every flow adds an increment of the size of the step, with a round-off relative to the increment, so the errors of
/// many steps grow with the time covered and not with the number of steps.
#[inline(always)]
pub(crate) fn add(sum: &mut f64, low: &mut f64, increment: f64) {
    let small = increment + *low;
    let total = *sum + small;
    *low = small - (total - *sum);
    *sum = total;
}

/// Applies [`add`] to each entry, with `factor` times the increments.
#[inline(always)]
pub(crate) fn add_all(sum: &mut [f64], low: &mut [f64], factor: f64, increments: &[f64]) {
    for ((sum, low), increment) in sum.iter_mut().zip(low).zip(increments) {
        add(sum, low, factor * increment);
    }
}
