//! Polynomials through values at nodes, in powers of the time from the middle of a leg.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::leg::Leg;
use crate::curve::nodes::{Nodes, integral};
use crate::legs::{Dense, Polynomials};
use crate::linalg::field::{Field, accumulate, multiply};
use crate::space::Homogeneous;

/// The matrices that map values at nodes to coefficients.
pub(super) struct Expansion {
    order: usize,
    /// Maps values at the nodes to Legendre coefficients.
    analysis: Vec<f64>,
    /// Map Legendre coefficients of a function to coefficients in `s - 1/2` of its first and its third integral from 0.
    first: Vec<f64>,
    third: Vec<f64>,
}

/// Cache, by the number of nodes.
static EXPANSIONS: Mutex<BTreeMap<usize, Arc<Expansion>>> = Mutex::new(BTreeMap::new());

impl Expansion {
    pub(super) fn of(nodes: &Nodes) -> Arc<Self> {
        let mut known = EXPANSIONS.lock().unwrap_or_else(PoisonError::into_inner);
        let expansion = known.entry(nodes.len());
        Arc::clone(expansion.or_insert_with(|| Arc::new(Expansion::new(nodes))))
    }

    fn new(nodes: &Nodes) -> Self {
        let count = nodes.len();
        let order = count + 2;
        let centered = centered_legendre(order);
        let (mut first, mut third) = (
            vec![0.0; (order + 1) * count],
            vec![0.0; (order + 1) * count],
        );
        for degree in 0..count {
            let mut series = vec![0.0; degree + 1];
            series[degree] = 1.0;
            for times in 1..=3 {
                series = integral(&series);
                let out = match times {
                    1 => &mut first,
                    3 => &mut third,
                    _ => continue,
                };
                for (c, polynomial) in series.iter().zip(&centered) {
                    for (power, coefficient) in polynomial.iter().enumerate() {
                        out[power * count + degree] += c * coefficient;
                    }
                }
            }
        }
        Expansion {
            order,
            analysis: nodes.analysis(),
            first,
            third,
        }
    }

    /// Writes the polynomials of a group of legs, starting at leg `first`.
    #[inline(always)]
    pub(super) fn write<T: Field>(
        &self,
        space: impl Homogeneous,
        first: usize,
        leg: &Leg<T>,
        dense: &mut Dense,
    ) {
        let (d, r) = (space.dim(), space.size());
        let (count, square, terms) = (leg.f.len() / d, r * r, self.order + 1);
        let zeros = |size: usize| vec![T::ZERO; size];
        let (mut series, mut x) = (zeros(count * d), zeros(terms * d));
        accumulate(&self.analysis, count, &leg.f, d, &mut series);
        for p in 0..d {
            // The quadratic part about the middle.
            let (v, a, b) = (leg.velocity[p], leg.acceleration[p], leg.third[p]);
            x[p] = v + a * 0.5 + b * 0.125;
            x[d + p] = a + b * 0.5;
            x[2 * d + p] = b * 0.5;
        }
        accumulate(&self.third, count, &series, d, &mut x);
        let (mut rates, mut matrix) = (zeros(count * square), zeros(square));
        for j in 0..count {
            space.matrix_into(&leg.x[0][j * d..], &mut matrix);
            let out = &mut rates[j * square..][..square];
            multiply(r, &leg.frames[j * square..][..square], &matrix, out);
        }
        let (mut series, mut frames) = (zeros(count * square), zeros(terms * square));
        accumulate(&self.analysis, count, &rates, square, &mut series);
        for i in 0..r {
            frames[i * r + i] = T::constant(1.0);
        }
        accumulate(&self.first, count, &series, square, &mut frames);
        let [v, a, b] = leg.x.each_ref().map(|x| &x[count * d..]);
        let polynomials = Polynomials {
            x: &x,
            frames: &frames,
            ends: [&leg.velocity, &leg.acceleration, &leg.third, v, a, b],
            last_frame: &leg.frames[count * square..],
        };
        dense.write(first, &polynomials);
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
