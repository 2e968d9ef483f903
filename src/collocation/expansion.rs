//! Polynomials through values at nodes and their integrals, in powers of the time from the middle.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::curve::nodes::{Nodes, integral};
use crate::linalg::field::accumulate;
use crate::linalg::simd::vectorised;

/// Largest number of repeated integrals.
const TIMES: usize = 4;

/// Largest number of nodes for which polynomials written in powers are accurate at the ends of legs: with 44,
/// accelerations jump by up to 4e-10.
pub(crate) const EXACT: usize = 32;

/// The matrices that map values at nodes to coefficients.
pub(crate) struct NodeExpansion {
    /// Degree of all polynomials: that of the fourth integrals.
    pub(crate) order: usize,
    /// Maps values at the nodes to Legendre coefficients.
    analysis: Vec<f64>,
    /// Maps Legendre coefficients of a function to coefficients in `s - 1/2` of its values and repeated integrals from 0.
    powers: [Vec<f64>; TIMES + 1],
}

/// Cache, by the number of nodes.
static EXPANSIONS: Mutex<BTreeMap<usize, Arc<NodeExpansion>>> = Mutex::new(BTreeMap::new());

impl NodeExpansion {
    pub(crate) fn of(nodes: &Nodes) -> Arc<Self> {
        let mut known = EXPANSIONS.lock().unwrap_or_else(PoisonError::into_inner);
        let expansion = known.entry(nodes.len());
        Arc::clone(expansion.or_insert_with(|| Arc::new(NodeExpansion::new(nodes))))
    }

    fn new(nodes: &Nodes) -> Self {
        let count = nodes.len();
        let order = count - 1 + TIMES;
        let centered = centered_legendre(order);
        let mut powers: [Vec<f64>; TIMES + 1] =
            std::array::from_fn(|_| vec![0.0; (order + 1) * count]);
        for degree in 0..count {
            let mut series = vec![0.0; degree + 1];
            series[degree] = 1.0;
            for out in &mut powers {
                for (c, polynomial) in series.iter().zip(&centered) {
                    for (power, coefficient) in polynomial.iter().enumerate() {
                        out[power * count + degree] += c * coefficient;
                    }
                }
                series = integral(&series);
            }
        }
        NodeExpansion {
            order,
            analysis: nodes.analysis(),
            powers,
        }
    }

    /// Coefficients of several functions from their values, node by node.
    pub(crate) fn values(&self, values: &[f64], functions: usize) -> Vec<f64> {
        self.coefficients(0, values, functions)
    }

    /// Those of their third integrals from 0.
    pub(crate) fn third_integrals(&self, values: &[f64], functions: usize) -> Vec<f64> {
        self.coefficients(3, values, functions)
    }

    /// Those of their fourth integrals.
    pub(crate) fn fourth_integrals(&self, values: &[f64], functions: usize) -> Vec<f64> {
        self.coefficients(TIMES, values, functions)
    }

    fn coefficients(&self, times: usize, values: &[f64], functions: usize) -> Vec<f64> {
        let count = self.order + 1 - TIMES;
        let mut series = vec![0.0; count * functions];
        let mut out = vec![0.0; (self.order + 1) * functions];
        if functions > 0 {
            vectorised(
                #[inline(always)]
                || {
                    accumulate(&self.analysis, count, values, functions, &mut series);
                    accumulate(&self.powers[times], count, &series, functions, &mut out);
                },
            );
        }
        out
    }
}

/// Adds the cubic polynomials in powers of `s - 1/2` with the given values, first, second and third derivatives at 0.
pub(crate) fn add_cubic([s, v, second, third]: [&[f64]; 4], out: &mut [f64]) {
    let size = s.len();
    for p in 0..size {
        let [s, v, second, third] = [s[p], v[p], second[p] / 2.0, third[p] / 6.0];
        out[p] += s + 0.5 * (v + 0.5 * (second + 0.5 * third));
        out[size + p] += v + second + 0.75 * third;
        out[2 * size + p] += second + 1.5 * third;
        out[3 * size + p] += third;
    }
}

/// Coefficients in `s - 1/2` of the Legendre polynomials on `[0, 1]`, by degree.
fn centered_legendre(degree: usize) -> Vec<Vec<f64>> {
    let mut all = vec![vec![1.0], vec![0.0, 2.0]];
    for j in 2..=degree {
        let n = j as f64;
        let mut next = vec![0.0; j + 1];
        for (power, c) in all[j - 1].iter().enumerate() {
            next[power + 1] += (2.0 * n - 1.0) * 2.0 * c / n;
        }
        for (power, c) in all[j - 2].iter().enumerate() {
            next[power] -= (n - 1.0) * c / n;
        }
        all.push(next);
    }
    all
}
