//! Derivatives and integrals of a curve from its points at Gauss-Legendre nodes.
//!
//! With enough nodes, a smooth curve on `[0, 1]` equals its interpolation polynomial to round-off. Differentiating that
//! costs one product with a constant matrix, less than exact derivatives of a de Casteljau curve.
//!
//! # Source
//! Wang, Xiang (2012), "On the convergence rates of Legendre approximation", Math. Comp. 81, 861-877
//! (barycentric weights of the nodes); Berrut, Trefethen (2004), "Barycentric Lagrange interpolation", SIAM Review 46,
//! 501-517 (differentiation matrices).

use faer::{Mat, MatMut, MatRef};

use super::gauss_legendre::gauss_legendre;
use crate::linalg::product::mul_into;

/// Nodes and matrices on `[0, 1]` for a given number of nodes.
pub(super) struct Collocation {
    pub(super) nodes: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// Transposed differentiation matrix: values side by side, one column per node, times this matrix give derivatives.
    first: Mat<f64>,
    second: Mat<f64>,
    /// Values times this matrix give the last two Legendre coefficients.
    tail: Mat<f64>,
}

impl Collocation {
    pub(super) fn new(points: usize) -> Self {
        let (x, weights) = gauss_legendre(points);
        let barycentric: Vec<f64> = (0..points)
            .map(|j| ((1.0 - x[j] * x[j]) * weights[j]).sqrt() * [1.0, -1.0][j % 2])
            .collect();
        let mut first = Mat::<f64>::zeros(points, points);
        for i in 0..points {
            for j in (0..points).filter(|j| *j != i) {
                // On [0, 1] derivatives are twice those on [-1, 1].
                let entry = 2.0 * barycentric[j] / (barycentric[i] * (x[i] - x[j]));
                first[(j, i)] = entry;
                // The derivative of a constant is exactly zero, also in floating-point arithmetic.
                first[(i, i)] -= entry;
            }
        }
        let second = &first * &first;
        let tail = Mat::from_fn(points, 2, |i, j| {
            let degree = points - 2 + j;
            (degree as f64 + 0.5) * weights[i] * legendre(degree, x[i])
        });
        Collocation {
            nodes: x.iter().map(|x| 0.5 + 0.5 * x).collect(),
            weights: weights.iter().map(|w| 0.5 * w).collect(),
            first,
            second,
            tail,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// First and second derivatives at the nodes from the values there, node by node.
    pub(super) fn derivatives_into(&self, values: &[f64], first: &mut [f64], second: &mut [f64]) {
        let size = values.len() / self.len();
        let values = MatRef::from_column_major_slice(values, size, self.len());
        for (matrix, out) in [(&self.first, first), (&self.second, second)] {
            let out = MatMut::from_column_major_slice_mut(out, size, self.len());
            mul_into(out, 1.0, values, matrix);
        }
    }

    /// Norm of the last two Legendre coefficients of the values, which measures how well the nodes resolve them.
    pub(super) fn unresolved(&self, values: &[f64]) -> f64 {
        let size = values.len() / self.len();
        let values = MatRef::from_column_major_slice(values, size, self.len());
        (values * &self.tail).norm_max()
    }
}

/// The Legendre polynomial of the given degree.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut p, mut q) = (1.0, 0.0);
    for j in 1..=degree {
        let j = j as f64;
        (p, q) = (((2.0 * j - 1.0) * x * p - (j - 1.0) * q) / j, p);
    }
    p
}
