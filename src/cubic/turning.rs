//! Variations of a point as rotations of everything: `dS = A S` for the skew matrix `A` of least rank.
//!
//! ```math
//! A = N S^T - S N^T + S\,\Omega\,S^T,\qquad \Omega = S^T dS,\quad N = dS - S\,\Omega
//! ```
//!
//! A tangent vector `Y` at `S` is varied by `dY = A Y + w` with `w` tangent: the part `w` is what remains to be said of it. Both
//! maps and their transposes take products of tall matrices only.

use faer::{Mat, MatRef, Scale};

/// `A Y`.
pub(crate) fn turned(s: MatRef<'_, f64>, ds: MatRef<'_, f64>, y: MatRef<'_, f64>) -> Mat<f64> {
    let inner = s.transpose() * ds;
    let omega = (&inner - inner.transpose()) * Scale(0.5);
    let normal = ds.to_owned() - s * &inner;
    let along = s.transpose() * y;
    &normal * &along - s * (normal.transpose() * y) + s * (omega * along)
}

/// The gradient of `<C, A Y>`, the sum of products of entries, with respect to `dS`.
pub(crate) fn turned_transposed(
    s: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
) -> Mat<f64> {
    // (C Y^T - Y C^T) S.
    let along = c * (y.transpose() * s) - y * (c.transpose() * s);
    let inner = s.transpose() * &along;
    along - s * inner * Scale(0.5)
}

/// The matrix whose product of entries with a tangent vector is the inner product of `w` with it: `w - S S^T w / 2`.
pub(crate) fn lowered(s: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
    w.to_owned() - s * (s.transpose() * w) * Scale(0.5)
}
