//! The cost of a curve by composite Gauss-Legendre quadrature.

use super::gauss_legendre::PANEL;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::Jet;
use crate::manifold::{Stiefel, covariant};
use crate::report::{SolverReport, StopReason};

/// Relative change between two refinements at which the integral counts as converged.
const TOLERANCE: f64 = 1e-12;

/// Error of the acceleration relative to the ambient `|S''|`: the residual acceleration along a geodesic.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// At most `2^MAX_DOUBLINGS` panels.
const MAX_DOUBLINGS: usize = 10;

/// `int |D_t S'|^2 dt` over the interval `span`; panels are doubled until the value converges.
///
/// The curve has coordinates of shape `(rows, k)`, whose Taylor coefficients up to order 2 are written by `jet_at`.
pub(super) fn squared_acceleration(
    [rows, k]: [usize; 2],
    (start, end): (f64, f64),
    mut jet_at: impl FnMut(f64, &mut Jet) -> Result<()>,
    interrupt: Interrupt<'_>,
) -> Result<f64> {
    let manifold = Stiefel::new(rows.max(k), k)?;
    let mut jet = Jet::zeros(rows, k);
    let mut integrand = |t: f64| {
        jet_at(t, &mut jet)?;
        squares(&manifold, &jet)
    };
    // Positions have norm sqrt(k), so accelerations below that over the squared interval are round-off as well.
    let still = k as f64 / (end - start).abs().powi(3);
    let (nodes, weights) = &*PANEL;
    let (mut previous, mut change, mut tolerance) = (f64::NAN, f64::INFINITY, 0.0);
    for doubling in 0..=MAX_DOUBLINGS {
        let panels = 1_usize << doubling;
        let width = (end - start) / panels as f64;
        let (mut sum, mut ambient) = (0.0, 0.0);
        for panel in 0..panels {
            interrupt.check("cost quadrature")?;
            let middle = start + (panel as f64 + 0.5) * width;
            for (x, w) in nodes.iter().zip(weights) {
                let [covariant, full] = integrand(middle + 0.5 * width * x)?;
                sum += 0.5 * width * w * covariant;
                ambient += 0.5 * width * w * full;
            }
        }
        if !(sum.is_finite() && ambient.is_finite()) {
            return Err(Error::Overflow { quantity: "cost" });
        }
        let noise = ROUND_OFF * ambient.max(still).sqrt();
        tolerance = TOLERANCE * sum + 2.0 * noise * sum.sqrt() + noise * noise;
        change = (sum - previous).abs();
        if change <= tolerance {
            return Ok(sum);
        }
        previous = sum;
    }
    let report = SolverReport {
        converged: false,
        iterations: MAX_DOUBLINGS,
        residual: change,
        tolerance,
        reason: StopReason::MaxIterations,
    };
    Err(Error::NoConvergence {
        solver: "cost quadrature",
        report,
    })
}

/// The squared norms of the covariant and of the ambient acceleration.
fn squares(manifold: &Stiefel, jet: &Jet) -> Result<[f64; 2]> {
    let second = &jet.c[2] * faer::Scale(2.0);
    let a = covariant::acceleration(jet.c[0].as_ref(), jet.c[1].as_ref(), second.as_ref());
    Ok([
        manifold
            .norm_along("cost", jet.c[0].as_ref(), a.as_ref())?
            .powi(2),
        second.squared_norm_l2(),
    ])
}
