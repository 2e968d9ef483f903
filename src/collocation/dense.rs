//! The polynomials of a solved leg: the curve between its knots.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::leg::Leg;
use super::nodes::{Nodes, legendre};
use crate::linalg::field::{Field, accumulate, multiply, transposed_multiply};
use crate::space::Homogeneous;

/// Polynomials in `s - 1/2`, coefficient by coefficient: `x` (coordinates) and the frame (row by row), leg by leg.
#[derive(Debug, Clone)]
pub(crate) struct Dense {
    /// Coefficients of a polynomial, less one.
    pub(crate) order: usize,
    x: Vec<f64>,
    frames: Vec<f64>,
    /// `x, x', x''` at both ends, and the frame at the last one.
    ends: Vec<f64>,
    last_frames: Vec<f64>,
}

/// The matrices that take values at nodes to coefficients.
pub(super) struct Expansion {
    order: usize,
    /// From values at the nodes to Legendre coefficients.
    analysis: Vec<f64>,
    /// From those of a function to coefficients in `s - 1/2` of its first and its third integral from 0.
    first: Vec<f64>,
    third: Vec<f64>,
}

/// Those that were asked for before, by the number of nodes.
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
        let mut analysis = vec![0.0; count * count];
        for (node, (s, weight)) in nodes.s.iter().zip(&nodes.weights).enumerate() {
            for (degree, p) in legendre(count - 1, *s).into_iter().enumerate() {
                analysis[degree * count + node] = (2 * degree + 1) as f64 * weight * p;
            }
        }
        let centered = centered_legendre(order);
        let (mut first, mut third) = (
            vec![0.0; (order + 1) * count],
            vec![0.0; (order + 1) * count],
        );
        for degree in 0..count {
            let mut series = vec![0.0; degree + 1];
            series[degree] = 1.0;
            for times in 1..=3 {
                series = super::nodes::integral(&series);
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
            analysis,
            first,
            third,
        }
    }
}

/// Coefficients in `s - 1/2` of the Legendre polynomials on `[0, 1]`, degree by degree.
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

/// The curves of solved legs.
pub(crate) trait Curves: Send + Sync {
    /// Polynomials that have those of a leg among them, and which these are.
    fn of_leg(&self, leg: usize) -> (&Dense, usize);
}

impl Curves for Dense {
    fn of_leg(&self, leg: usize) -> (&Dense, usize) {
        (self, leg)
    }
}

impl Dense {
    /// Room for legs with `nodes + 3` coefficients.
    pub(crate) fn new(legs: usize, nodes: usize, space: impl Homogeneous) -> Self {
        let (d, square, order) = (space.dim(), space.size() * space.size(), nodes + 2);
        Dense {
            order,
            x: vec![0.0; legs * (order + 1) * d],
            frames: vec![0.0; legs * (order + 1) * square],
            ends: vec![0.0; legs * 6 * d],
            last_frames: vec![0.0; legs * square],
        }
    }

    /// Coefficients of `x` of a leg, for `d` coordinates.
    pub(crate) fn x(&self, leg: usize, d: usize) -> &[f64] {
        let size = (self.order + 1) * d;
        &self.x[leg * size..][..size]
    }

    /// Coefficients of the frames of a leg, for `square` entries.
    pub(crate) fn frames(&self, leg: usize, square: usize) -> &[f64] {
        let size = (self.order + 1) * square;
        &self.frames[leg * size..][..size]
    }

    /// `x, x', x''` at the first or the last end of a leg, for `d` coordinates.
    pub(crate) fn end(&self, leg: usize, end: usize, d: usize) -> impl Iterator<Item = &[f64]> {
        self.ends[(2 * leg + end) * 3 * d..][..3 * d].chunks_exact(d)
    }

    /// The frame at the last end of a leg.
    pub(crate) fn last_frame(&self, leg: usize, square: usize) -> &[f64] {
        &self.last_frames[leg * square..][..square]
    }

    /// The polynomials of a group of legs, the first of which is `first`.
    #[inline(always)]
    pub(super) fn write<T: Field>(
        &mut self,
        space: impl Homogeneous,
        expansion: &Expansion,
        first: usize,
        leg: &Leg<T>,
        legs: usize,
    ) {
        let (d, r) = (space.dim(), space.size());
        let (count, square, terms) = (leg.f.len() / d, r * r, expansion.order + 1);
        let zeros = |size: usize| vec![T::ZERO; size];
        let (mut series, mut x) = (zeros(count * d), zeros(terms * d));
        accumulate(&expansion.analysis, count, &leg.f, d, &mut series);
        for p in 0..d {
            // The quadratic part around the middle.
            let (v, a, b) = (leg.velocity[p], leg.acceleration[p], leg.third[p]);
            x[p] = v + a * 0.5 + b * 0.125;
            x[d + p] = a + b * 0.5;
            x[2 * d + p] = b * 0.5;
        }
        accumulate(&expansion.third, count, &series, d, &mut x);
        let (mut rates, mut matrix) = (zeros(count * square), zeros(square));
        for j in 0..count {
            space.matrix_into(&leg.x[0][j * d..], &mut matrix);
            let out = &mut rates[j * square..][..square];
            multiply(r, &leg.frames[j * square..][..square], &matrix, out);
        }
        let (mut series, mut frames) = (zeros(count * square), zeros(terms * square));
        accumulate(&expansion.analysis, count, &rates, square, &mut series);
        for i in 0..r {
            frames[i * r + i] = T::constant(1.0);
        }
        accumulate(&expansion.first, count, &series, square, &mut frames);
        let lanes = T::COUNT.min(legs - first);
        for lane in 0..lanes {
            let at = first + lane;
            copy_lane(&x, lane, &mut self.x[at * terms * d..]);
            copy_lane(&frames, lane, &mut self.frames[at * terms * square..]);
            let last = &leg.frames[count * square..];
            copy_lane(last, lane, &mut self.last_frames[at * square..]);
            let first = [&leg.velocity, &leg.acceleration, &leg.third].map(|x| &x[..]);
            let end = leg.x.each_ref().map(|x| &x[count * d..]);
            let vectors = first.into_iter().chain(end);
            for (to, x) in self.ends[at * 6 * d..].chunks_exact_mut(d).zip(vectors) {
                copy_lane(x, lane, to);
            }
        }
    }

    /// Taylor series of all legs: coefficients of `x` and of
    /// frames, and `x, x', x''` at both ends.
    #[inline(always)]
    pub(crate) fn write_series<T: Field>(
        &mut self,
        space: impl Homogeneous,
        [x, frames]: [&[T]; 2],
        ends: &[Vec<T>; 6],
    ) {
        let (d, r) = (space.dim(), space.size());
        let (square, terms) = (r * r, self.order + 1);
        let legs = self.last_frames.len() / square;
        let turned = |s: f64| {
            let mut frame = vec![T::ZERO; square];
            let mut power = 1.0;
            for c in frames.chunks_exact(square).take(terms) {
                for (frame, c) in frame.iter_mut().zip(c) {
                    *frame += *c * power;
                }
                power *= s;
            }
            frame
        };
        let (start, end) = (turned(-0.5), turned(0.5));
        let mut relative = vec![T::ZERO; terms * square];
        let known = frames.chunks_exact(square);
        for (c, out) in known.zip(relative.chunks_exact_mut(square)) {
            transposed_multiply(r, &start, c, out);
        }
        let mut last = vec![T::ZERO; square];
        transposed_multiply(r, &start, &end, &mut last);
        for at in 0..legs {
            let lane = at;
            copy_lane(&x[..terms * d], lane, &mut self.x[at * terms * d..]);
            copy_lane(&relative, lane, &mut self.frames[at * terms * square..]);
            copy_lane(&last, lane, &mut self.last_frames[at * square..]);
            for (to, x) in self.ends[at * 6 * d..].chunks_exact_mut(d).zip(ends) {
                copy_lane(x, lane, to);
            }
        }
    }
}

#[inline(always)]
fn copy_lane<T: Field>(from: &[T], lane: usize, to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from.lane(lane);
    }
}
