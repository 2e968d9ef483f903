//! Backtracking: how much of a step to take.
//!
//! # Source
//! Dennis, Schnabel (1996), "Numerical Methods for Unconstrained Optimization and Nonlinear Equations", sec. 6.3.

use crate::error::Result;

/// The residual must decrease by this fraction of the decrease that the linear model predicts.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// The first of the shares `1, 1/2, 1/4, ...` of a Newton step, `trials` at most, that reduces the norm of the
/// residual, with the state there; `trial` returns the norm for a share, and the state.
///
/// ```math
/// |F(x + \lambda s)| \le (1 - 10^{-4} \lambda) |F(x)|
/// ```
///
/// A trial without a state, because it cannot be evaluated, counts as one that does not reduce the norm.
///
/// # Errors
/// The errors of `trial`.
pub(crate) fn backtracked<S>(
    norm: f64,
    trials: i32,
    mut trial: impl FnMut(f64) -> Result<Option<(f64, S)>>,
) -> Result<Option<(S, f64)>> {
    for halvings in 0..trials {
        let share = 0.5_f64.powi(halvings);
        if let Some((now, state)) = trial(share)?
            && now <= (1.0 - SUFFICIENT_DECREASE * share) * norm
        {
            return Ok(Some((state, share)));
        }
    }
    Ok(None)
}
