//! Gauss nodes on `[0, 1]`, and integrals of the polynomials that interpolate values at them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::gauss_legendre::gauss_legendre;

/// Largest number of repeated integrals.
const TIMES: usize = 4;

/// Gauss nodes, and the matrices that map values at them to values and repeated integrals from 0 of the interpolation
/// polynomial.
#[derive(Debug, Clone)]
pub(crate) struct Nodes {
    pub(crate) s: Vec<f64>,
    pub(crate) weights: Vec<f64>,
    /// Values and one to four integrals at the nodes and, in the last row, at 1; in row-major order.
    pub(crate) at: [Vec<f64>; TIMES + 1],
    /// Maps values at the nodes to the last two Legendre coefficients.
    pub(crate) tail: Vec<f64>,
}

impl Nodes {
    pub(crate) fn new(count: usize) -> Self {
        let (x, weights) = gauss_legendre(count);
        let mut nodes = Nodes {
            s: x.iter().rev().map(|x| 0.5 + 0.5 * x).collect(),
            weights: weights.iter().rev().map(|w| 0.5 * w).collect(),
            at: Default::default(),
            tail: vec![0.0; 2 * count],
        };
        let analysis = nodes.analysis();
        nodes.tail.copy_from_slice(&analysis[(count - 2) * count..]);
        let mut points = nodes.s.clone();
        points.push(1.0);
        nodes.at = nodes.integrals_at(&points);
        nodes
    }

    pub(crate) fn len(&self) -> usize {
        self.s.len()
    }

    /// Values and one to four integrals at given points, one row per point.
    pub(crate) fn integrals_at(&self, points: &[f64]) -> [Vec<f64>; TIMES + 1] {
        let count = self.len();
        let bases: Vec<Vec<f64>> = points.iter().map(|s| legendre(count + TIMES, *s)).collect();
        let mut out: [Vec<f64>; TIMES + 1] =
            std::array::from_fn(|_| vec![0.0; points.len() * count]);
        for node in 0..count {
            let mut series = self.lagrange(node);
            for matrix in &mut out {
                for (row, basis) in matrix.chunks_exact_mut(count).zip(&bases) {
                    row[node] = series.iter().zip(basis).map(|(c, p)| c * p).sum();
                }
                series = integral(&series);
            }
        }
        out
    }

    /// Maps values at the nodes to Legendre coefficients, one row per degree.
    pub(crate) fn analysis(&self) -> Vec<f64> {
        let count = self.len();
        let mut out = vec![0.0; count * count];
        for node in 0..count {
            for (degree, c) in self.lagrange(node).into_iter().enumerate() {
                out[degree * count + node] = c;
            }
        }
        out
    }

    /// Legendre coefficients of the polynomial that is one at a node and zero at the others.
    fn lagrange(&self, node: usize) -> Vec<f64> {
        let basis = legendre(self.len() - 1, self.s[node]);
        let scaled = basis.iter().enumerate();
        scaled
            .map(|(degree, p)| (2 * degree + 1) as f64 * self.weights[node] * p)
            .collect()
    }
}

/// Legendre polynomials of degrees `0..=degree` on `[0, 1]`.
fn legendre(degree: usize, s: f64) -> Vec<f64> {
    let x = 2.0 * s - 1.0;
    let mut p = vec![1.0, x];
    for j in 2..=degree {
        let n = j as f64;
        p.push(((2.0 * n - 1.0) * x * p[j - 1] - (n - 1.0) * p[j - 2]) / n);
    }
    p.truncate(degree + 1);
    p
}

/// Legendre coefficients on `[0, 1]` of the integral from 0.
pub(crate) fn integral(series: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; series.len() + 1];
    for (degree, c) in series.iter().enumerate() {
        let share = 0.5 * c / (2 * degree + 1) as f64;
        out[degree + 1] += share;
        // The recurrence uses the constant as the polynomial of degree -1.
        out[degree.saturating_sub(1)] += if degree == 0 { share } else { -share };
    }
    out
}

/// Cache of nodes: computing 14 of them takes as long as a spline through ten rotations.
static KNOWN: Mutex<BTreeMap<usize, Arc<Nodes>>> = Mutex::new(BTreeMap::new());

impl Nodes {
    pub(crate) fn of(count: usize) -> Arc<Self> {
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let nodes = known.entry(count);
        Arc::clone(nodes.or_insert_with(|| Arc::new(Nodes::new(count))))
    }

    /// The matrix from values at these nodes to the values of the polynomials at other nodes, row by row.
    pub(crate) fn onto(&self, others: &Nodes) -> Vec<f64> {
        let [values, ..] = self.integrals_at(&others.s);
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for count in [3, 6, 12, 20] {
            let nodes = Nodes::new(count);
            for degree in 0..count {
                let values: Vec<f64> = nodes.s.iter().map(|s| s.powi(degree as i32)).collect();
                let mut points = nodes.s.clone();
                points.push(1.0);
                let mut factor = 1.0;
                for times in 0..=TIMES {
                    let rows = nodes.at[times].chunks_exact(count);
                    for (row, s) in rows.zip(&points) {
                        let found: f64 = row.iter().zip(&values).map(|(a, b)| a * b).sum();
                        let exact = factor * s.powi((degree + times) as i32);
                        let error = (found - exact).abs();
                        assert!(
                            error < 2e-15 * count as f64,
                            "{count} {degree} {times}: {error:e}"
                        );
                    }
                    factor /= (degree + times + 1) as f64;
                }
            }
        }
    }
}
