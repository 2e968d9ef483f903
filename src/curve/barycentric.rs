//! The polynomial interpolating values at Gauss nodes and at both ends of `[0, 1]`.
//!
//! For the nodes in order, including the ends, the barycentric weights have alternating signs and magnitudes
//!
//! ```math
//! |\lambda_0| = |\lambda_{N+1}| = \tfrac12,\qquad |\lambda_i| = \sqrt{\frac{w_i}{4 s_i (1 - s_i)}},
//! ```
//!
//! computed from the weights `w_i` of Gauss quadrature on `[0, 1]`. Constants are reproduced to the last bit but one,
//! however inaccurate the weights are, and values at the nodes are reproduced exactly; coefficients of Legendre
//! polynomials lose a factor of 10 (measured with 20 nodes).
//!
//! # Source
//! Berrut, Trefethen (2004), "Barycentric Lagrange interpolation", SIAM Review 46, 501-517, eq. (4.2); Wang, Xiang
//! (2012), "On the convergence rates of Legendre approximation", Math. Comp. 81, 861-877 (weights of Gauss nodes; those
//! with the ends follow).

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::nodes::Nodes;

/// Nodes including both ends, in increasing order, and their barycentric weights.
#[derive(Debug, Clone)]
pub(crate) struct Barycentric {
    s: Vec<f64>,
    weights: Vec<f64>,
}

/// Cache, by the number of nodes.
static KNOWN: Mutex<BTreeMap<usize, Arc<Barycentric>>> = Mutex::new(BTreeMap::new());

impl Barycentric {
    pub(crate) fn of(nodes: &Nodes) -> Arc<Self> {
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.entry(nodes.len());
        Arc::clone(found.or_insert_with(|| Arc::new(Barycentric::new(nodes))))
    }

    /// Number of values, at the nodes and at both ends.
    pub(crate) fn len(&self) -> usize {
        self.s.len()
    }

    pub(crate) fn new(nodes: &Nodes) -> Self {
        let inner = nodes.s.iter().zip(&nodes.weights);
        let inner = inner.map(|(s, w)| (*s, (w / (4.0 * s * (1.0 - s))).sqrt()));
        let all = std::iter::once((0.0, 0.5)).chain(inner).chain([(1.0, 0.5)]);
        let signed = |(i, (s, size)): (usize, (f64, f64))| match i % 2 {
            0 => (s, size),
            _ => (s, -size),
        };
        let (s, weights) = all.enumerate().map(signed).unzip();
        Barycentric { s, weights }
    }

    /// Writes the factors by which values are combined to the polynomial's value at `s`.
    pub(crate) fn factors_into(&self, s: f64, out: &mut [f64]) {
        if let Some(node) = self.s.iter().position(|node| *node == s) {
            out.fill(0.0);
            out[node] = 1.0;
            return;
        }
        let mut sum = 0.0;
        for ((out, node), weight) in out.iter_mut().zip(&self.s).zip(&self.weights) {
            *out = weight / (s - node);
            sum += *out;
        }
        out.iter_mut().for_each(|factor| *factor /= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_met() {
        for count in [5, 6, 20] {
            let through = Barycentric::new(&Nodes::new(count));
            let mut factors = vec![0.0; count + 2];
            for degree in 0..count + 2 {
                let value = |s: f64| (s - 0.3).powi(degree as i32);
                for i in 0..=100 {
                    let s = f64::from(i) / 100.0;
                    through.factors_into(s, &mut factors);
                    let nodes = through.s.iter().zip(&factors);
                    let found: f64 = nodes.map(|(node, factor)| factor * value(*node)).sum();
                    let error = (found - value(s)).abs();
                    assert!(
                        error < 16.0 * f64::EPSILON,
                        "{count} {degree} {s}: {error:e}"
                    );
                }
            }
        }
    }
}
