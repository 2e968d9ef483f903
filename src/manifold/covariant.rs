//! Covariant derivatives along a curve from its ambient derivatives, for the canonical metric.
//!
//! ```math
//! D_t W = W' + \Gamma(S', W),\qquad
//! \Gamma(V,W) = \tfrac12 (V W^T + W V^T) S + \tfrac12 S (V^T P W + W^T P V),\quad P = I - S S^T
//! ```
//!
//! The formulas only use products of points and vectors, so they hold in any orthonormal frame that contains
//! the curve.
//!
//! # Source
//! Edelman, Arias, Smith (1998), eq. (2.49).

use faer::{Mat, MatRef};

/// The Christoffel term `Gamma(V, W)` at `s`; all shapes `(n, k)`.
pub fn christoffel(s: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
    let normal_product = projected_product(s, v, w);
    let symmetric = &normal_product + normal_product.transpose();
    (v * (w.transpose() * s) + w * (v.transpose() * s) + s * symmetric) * faer::Scale(0.5)
}

/// `V^T (I - S S^T) W`.
fn projected_product(s: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
    v.transpose() * w - (v.transpose() * s) * (s.transpose() * w)
}

/// Covariant acceleration `D_t S'` from position and the first two ambient derivatives.
pub fn acceleration(s: MatRef<'_, f64>, d1: MatRef<'_, f64>, d2: MatRef<'_, f64>) -> Mat<f64> {
    d2 + christoffel(s, d1, d1)
}

/// Covariant jerk `D_t D_t S'` from position and the first three ambient derivatives.
pub fn jerk(
    s: MatRef<'_, f64>,
    d1: MatRef<'_, f64>,
    d2: MatRef<'_, f64>,
    d3: MatRef<'_, f64>,
) -> Mat<f64> {
    let a = acceleration(s, d1, d2);
    d3 + christoffel_derivative(s, d1, d2) + christoffel(s, d1, a.as_ref())
}

/// `d/dt Gamma(S', S')` along the curve: `Gamma(V, V) = V V^T S + S V^T P V` with `V = S'`, by the product rule.
fn christoffel_derivative(s: MatRef<'_, f64>, v: MatRef<'_, f64>, dv: MatRef<'_, f64>) -> Mat<f64> {
    let first = dv * (v.transpose() * s) + v * (dv.transpose() * s) + v * (v.transpose() * v);
    let kinetic = projected_product(s, v, v);
    let mixed = projected_product(s, dv, v);
    // V^T P' V = -(V^T V)(S^T V) - (V^T S)(V^T V).
    let turning = (v.transpose() * v) * (s.transpose() * v);
    let rate = &mixed + mixed.transpose() - &turning - turning.transpose();
    first + v * kinetic + s * rate
}
