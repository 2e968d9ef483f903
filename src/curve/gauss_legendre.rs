//! Gauss-Legendre quadrature.

use std::sync::LazyLock;

/// Points per panel; exact for polynomials of degree 23.
pub(crate) const POINTS: usize = 12;

/// Nodes and weights of a panel, computed once: computing them takes three times as long as the cost of a piece of a
/// spline.
pub(crate) static PANEL: LazyLock<(Vec<f64>, Vec<f64>)> = LazyLock::new(|| gauss_legendre(POINTS));

/// Nodes, in decreasing order, and weights on `[-1, 1]`, from the roots of the Legendre polynomial by Newton's method.
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
