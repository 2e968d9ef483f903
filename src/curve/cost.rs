//! The cost of a curve by composite Gauss-Legendre quadrature.

use super::gauss_legendre::{PANEL, POINTS};
use super::norms::{Norm, NormEvaluation, Norms};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Relative change between two refinements at which the integral counts as converged.
const TOLERANCE: f64 = 1e-12;

/// Error of the acceleration relative to the ambient `|S''|`: the residual acceleration along a geodesic.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// At most `2^MAX_DOUBLINGS` panels.
const MAX_DOUBLINGS: usize = 10;

/// `int |D_t S'|^2 dt` over an interval of a curve with `k` columns; panels are doubled until the value converges.
pub(super) fn squared_acceleration(
    norms: &mut Norms<impl NormEvaluation>,
    (start, end): (f64, f64),
    k: usize,
    interrupt: Interrupt<'_>,
) -> Result<f64> {
    // Positions have norm sqrt(k), so accelerations below that over the squared interval are round-off as well.
    let still = k as f64 / (end - start).abs().powi(3);
    let (nodes, weights) = &*PANEL;
    let (mut t, mut found) = ([0.0; POINTS], [Norm::default(); POINTS]);
    let (mut previous, mut change, mut tolerance) = (f64::NAN, f64::INFINITY, 0.0);
    for doubling in 0..=MAX_DOUBLINGS {
        let panels = 1_usize << doubling;
        let width = (end - start) / panels as f64;
        let (mut sum, mut ambient) = (0.0, 0.0);
        for panel in 0..panels {
            interrupt.check("cost quadrature")?;
            let middle = start + (panel as f64 + 0.5) * width;
            for (t, x) in t.iter_mut().zip(nodes) {
                *t = middle + 0.5 * width * x;
            }
            norms.read(&t, 2, &mut found)?;
            for (norm, w) in found.iter().zip(weights) {
                sum += 0.5 * width * w * norm.covariant[1].powi(2);
                ambient += 0.5 * width * w * norm.ambient.powi(2);
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
    let report = SolverReport::new(StopReason::MaxIterations, MAX_DOUBLINGS, change, tolerance);
    Err(Error::NoConvergence {
        solver: "cost quadrature",
        report,
    })
}
