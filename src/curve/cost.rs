//! The cost of a curve by composite Gauss-Legendre quadrature.

use super::Curve;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::Jet;
use crate::manifold::{Stiefel, covariant};
use crate::report::{SolverReport, StopReason};

/// Points per panel: exact for polynomials of degree 23.
pub(crate) const POINTS: usize = 12;

/// Relative change between two refinements at which the integral counts as found.
const TOLERANCE: f64 = 1e-12;

/// The acceleration is known to this much of the ambient `|S''|`: what is left of it along a geodesic.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// At most `2^MAX_DOUBLINGS` panels.
const MAX_DOUBLINGS: usize = 10;

/// `int |D_t S'|^2 dt` over the curve's interval, panels doubled until the value settles.
pub(super) fn squared_acceleration<C: Curve>(curve: &C, interrupt: Interrupt<'_>) -> Result<f64> {
    let r = curve.frame().map_or(curve.n(), |frame| frame.ncols());
    let manifold = Stiefel::new(r.max(curve.k()), curve.k())?;
    let (mut work, mut jet) = (curve.workspace(), Jet::zeros(r, curve.k()));
    let mut integrand = |t: f64| squares(curve, &manifold, t, &mut work, &mut jet);
    let (start, end) = curve.t_span();
    // Positions have norm sqrt(k), so accelerations below that over the squared interval are noise as well.
    let still = curve.k() as f64 / (end - start).abs().powi(3);
    let (nodes, weights) = gauss_legendre(POINTS);
    let (mut previous, mut change, mut tolerance) = (f64::NAN, f64::INFINITY, 0.0);
    for doubling in 0..=MAX_DOUBLINGS {
        let panels = 1_usize << doubling;
        let width = (end - start) / panels as f64;
        let (mut sum, mut ambient) = (0.0, 0.0);
        for panel in 0..panels {
            interrupt.check("cost quadrature")?;
            let middle = start + (panel as f64 + 0.5) * width;
            for (x, w) in nodes.iter().zip(&weights) {
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

/// The squares of the covariant and of the ambient acceleration at a parameter.
fn squares<C: Curve + ?Sized>(
    curve: &C,
    manifold: &Stiefel,
    t: f64,
    work: &mut C::Workspace,
    jet: &mut Jet,
) -> Result<[f64; 2]> {
    curve.coordinates_into(t, 2, work, jet)?;
    let second = &jet.c[2] * faer::Scale(2.0);
    let a = covariant::acceleration(jet.c[0].as_ref(), jet.c[1].as_ref(), second.as_ref());
    Ok([
        manifold
            .norm_along("cost", jet.c[0].as_ref(), a.as_ref())?
            .powi(2),
        second.squared_norm_l2(),
    ])
}

/// Nodes, in decreasing order, and weights on `[-1, 1]`: roots of the Legendre polynomial by Newton's method.
pub(crate) fn gauss_legendre(points: usize) -> (Vec<f64>, Vec<f64>) {
    let n = points as f64;
    let node = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p, mut q) = (1.0, 0.0);
            for j in 1..=points {
                let j = j as f64;
                (p, q) = (((2.0 * j - 1.0) * x * p - (j - 1.0) * q) / j, p);
            }
            slope = n * (x * p - q) / (x * x - 1.0);
            x -= p / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..points).map(node).unzip()
}
