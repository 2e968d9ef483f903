//! Functions on `[0, 1]` with given values and first derivatives at both ends, from their fourth derivatives at Gauss nodes.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::collocation::lane_nodes::{LaneNodes, add_polynomials, by_columns};
use crate::linalg::lanes::{LANES, Lanes};

/// Number of derivatives below the fourth, and of data at the ends.
pub(crate) const LEVELS: usize = 4;

/// Gauss nodes, and the matrices of Green's function of `S'''' = f`, `S = S' = 0` at both ends.
#[derive(Debug)]
pub(crate) struct Clamped {
    pub(crate) nodes: Arc<LaneNodes>,
    /// For each derivative, to all groups of nodes, of the polynomial `f` that is one at a node, node by node.
    columns: [Vec<Lanes>; LEVELS],
    /// For each derivative and group, the factors of the data `S(0), S'(0), S(1), S'(1)` in the cubic polynomial.
    hermite: [Vec<[Lanes; LEVELS]>; LEVELS],
    /// `S''` and `S'''` at 0 and 1 from `f` at the nodes.
    at_ends: [[Vec<f64>; 2]; 2],
}

/// Cache, by the number of nodes.
static KNOWN: Mutex<BTreeMap<usize, Arc<Clamped>>> = Mutex::new(BTreeMap::new());

impl Clamped {
    /// At least the given number of nodes; `None` if there are not so many.
    pub(crate) fn at_least(count: usize) -> Option<Arc<Self>> {
        LaneNodes::at_least(count).map(Self::of)
    }

    /// The smallest number of nodes.
    pub(crate) fn few() -> Arc<Self> {
        Self::of(LaneNodes::few())
    }

    fn of(nodes: Arc<LaneNodes>) -> Arc<Self> {
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.entry(nodes.count());
        Arc::clone(found.or_insert_with(|| Arc::new(Self::new(nodes))))
    }

    fn new(lanes: Arc<LaneNodes>) -> Self {
        let nodes = Arc::clone(&lanes.nodes);
        let count = nodes.len();
        // `S''` and `S'''` at 0, which make the third and fourth integrals of `f` vanish at 1.
        let start = |node: usize| {
            let last = |times: usize| nodes.at[times][count * count + node];
            let (p, q) = (-last(4), -last(3));
            [6.0 * p - 2.0 * q, 6.0 * q - 12.0 * p]
        };
        let entry = |level: usize, at: usize, s: f64, node: usize| {
            let [b, c] = start(node);
            let polynomial = match level {
                0 => s * s * (0.5 * b + s * c / 6.0),
                1 => s * (b + 0.5 * s * c),
                2 => b + s * c,
                _ => c,
            };
            nodes.at[LEVELS - level][at * count + node] + polynomial
        };
        let columns =
            |level: usize| by_columns(count, count, |to, from| entry(level, to, nodes.s[to], from));
        let hermite = |level: usize| lanes.s.iter().map(|s| hermite(level, *s)).collect();
        let ends = |level: usize| (0..count).map(move |node| (level, node));
        Clamped {
            columns: std::array::from_fn(columns),
            hermite: std::array::from_fn(hermite),
            at_ends: [
                [2, 3].map(|level| {
                    ends(level)
                        .map(|(level, node)| start(node)[level - 2])
                        .collect()
                }),
                [2, 3].map(|level| {
                    ends(level)
                        .map(|(level, node)| entry(level, count, 1.0, node))
                        .collect()
                }),
            ],
            nodes: lanes,
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.nodes.count()
    }

    /// Number of groups of nodes.
    pub(crate) fn groups(&self) -> usize {
        self.nodes.groups()
    }

    /// The derivatives below the fourth at the nodes, from data at the ends and the fourth derivatives of several functions.
    pub(crate) fn derivatives_into(
        &self,
        data: [&[f64]; LEVELS],
        f: &[Lanes],
        out: &mut [Vec<Lanes>; LEVELS],
    ) {
        let functions = data[0].len();
        for (level, out) in out.iter_mut().enumerate() {
            for (factors, out) in self.hermite[level]
                .iter()
                .zip(out.chunks_exact_mut(functions))
            {
                for (p, out) in out.iter_mut().enumerate() {
                    let mut sum = factors[0] * data[0][p];
                    for i in 1..LEVELS {
                        sum += factors[i] * data[i][p];
                    }
                    *out = sum;
                }
            }
            add_polynomials(self.groups(), &self.columns[level], f, functions, out);
        }
    }

    /// The second (0) or third (1) derivative at an end.
    pub(crate) fn at_end(
        &self,
        end: usize,
        which: usize,
        data: [&[f64]; LEVELS],
        f: &[Lanes],
        out: &mut [f64],
    ) {
        let functions = out.len();
        let factors = hermite(2 + which, Lanes::splat(end as f64));
        for (p, out) in out.iter_mut().enumerate() {
            *out = (0..LEVELS).map(|i| factors[i].0[0] * data[i][p]).sum();
        }
        let row = &self.at_ends[end][which];
        for (f, factors) in f.chunks_exact(functions).zip(row.chunks_exact(LANES)) {
            for (f, out) in f.iter().zip(&mut *out) {
                let mut sum = 0.0;
                for (f, factor) in f.0.iter().zip(factors) {
                    sum += f * factor;
                }
                *out += sum;
            }
        }
    }
}

/// A derivative of the cubic polynomials that belong to `S(0), S'(0), S(1), S'(1)`.
fn hermite(level: usize, s: Lanes) -> [Lanes; LEVELS] {
    let number = Lanes::splat;
    match level {
        0 => {
            let (square, cube) = (s * s, s * s * s);
            let third = square * 3.0 - cube * 2.0;
            [
                Lanes::ONE - third,
                s - square * 2.0 + cube,
                third,
                cube - square,
            ]
        }
        1 => {
            let square = s * s;
            let third = (s - square) * 6.0;
            [
                -third,
                Lanes::ONE - s * 4.0 + square * 3.0,
                third,
                square * 3.0 - s * 2.0,
            ]
        }
        2 => {
            let third = number(6.0) - s * 12.0;
            [-third, s * 6.0 - number(4.0), third, s * 6.0 - number(2.0)]
        }
        _ => [12.0, 6.0, -12.0, 6.0].map(number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A derivative of a power.
    fn derivative(degree: usize, level: usize, s: f64) -> f64 {
        let factor: f64 = (0..level).map(|i| degree as f64 - i as f64).product();
        match degree >= level {
            true => factor * s.powi((degree - level) as i32),
            false => 0.0,
        }
    }

    /// Polynomials are recovered from their fourth derivatives at the nodes, with all derivatives.
    #[test]
    fn polynomials_are_recovered() {
        let degrees: Vec<usize> = (0..8).collect();
        let data = [(0, 0.0), (1, 0.0), (0, 1.0), (1, 1.0)].map(|(level, s)| {
            let all = degrees.iter().map(|p| derivative(*p, level, s));
            all.collect::<Vec<f64>>()
        });
        let data = data.each_ref().map(Vec::as_slice);
        for count in [8, 16, 24, 48] {
            let nodes = Clamped::at_least(count).unwrap();
            let at = |level: usize| -> Vec<Lanes> {
                let groups = nodes.nodes.s.iter();
                let each = groups.flat_map(|s| degrees.iter().map(move |p| (*p, *s)));
                each.map(|(p, s)| Lanes(s.0.map(|s| derivative(p, level, s))))
                    .collect()
            };
            let f = at(4);
            let mut found = std::array::from_fn(|_| vec![Lanes::ZERO; f.len()]);
            nodes.derivatives_into(data, &f, &mut found);
            for (level, found) in found.iter().enumerate() {
                for (found, exact) in found.iter().zip(at(level)) {
                    let error = (*found - exact).abs();
                    assert!(
                        error.0.iter().all(|e| *e < 1e-12),
                        "{count} {level}: {error:?}"
                    );
                }
            }
            for (end, which) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let mut found = vec![0.0; degrees.len()];
                nodes.at_end(end, which, data, &f, &mut found);
                for (p, found) in degrees.iter().zip(found) {
                    let error = (found - derivative(*p, 2 + which, end as f64)).abs();
                    assert!(error < 1e-11, "{count} {p} at {end}: {error:e}");
                }
            }
        }
    }
}
