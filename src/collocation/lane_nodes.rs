//! Gauss nodes in groups of eight, and integrals of the polynomials through values at them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::curve::nodes::Nodes;
use crate::linalg::field::larger;
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::{Eight, Width};

/// Largest number of repeated integrals.
const TIMES: usize = 3;

/// Largest number of nodes.
pub(crate) const MOST: usize = 48;

/// A multiple of eight nodes. Values of several functions at them are stored by groups of nodes, then by functions.
#[derive(Debug)]
pub(crate) struct LaneNodes {
    pub(crate) nodes: Arc<Nodes>,
    pub(crate) s: Vec<Lanes>,
    pub(crate) weights: Vec<Lanes>,
    /// For one to three integrals: to all groups of nodes, of the polynomial that is one at a node, node by node.
    columns: [Vec<Lanes>; TIMES],
    /// The same for the transposed matrices.
    rows: [Vec<Lanes>; TIMES],
}

/// Cache, by the number of nodes.
static KNOWN: Mutex<BTreeMap<usize, Arc<LaneNodes>>> = Mutex::new(BTreeMap::new());

/// Cache of the matrices between nodes, by both numbers. Computed for every leg, they take 4 % of the time of a spline
/// through 20 points of St(10,3).
static MAPS: Mutex<BTreeMap<[usize; 2], Columns>> = Mutex::new(BTreeMap::new());

/// A matrix by columns, as [`by_columns`] writes it.
type Columns = Arc<Vec<Lanes>>;

impl LaneNodes {
    /// At least the given number of nodes; `None` for more than [`MOST`].
    pub(crate) fn at_least(count: usize) -> Option<Arc<Self>> {
        let count = count.next_multiple_of(LANES);
        (count <= MOST).then(|| Self::of(count))
    }

    /// The smallest number of nodes.
    pub(crate) fn few() -> Arc<Self> {
        Self::of(LANES)
    }

    fn of(count: usize) -> Arc<Self> {
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.entry(count);
        Arc::clone(found.or_insert_with(|| Arc::new(Self::new(count))))
    }

    fn new(count: usize) -> Self {
        let nodes = Nodes::of(count);
        let columns = |times: usize| {
            by_columns(count, count, |to, from| {
                nodes.at[times + 1][to * count + from]
            })
        };
        let rows = |times: usize| {
            by_columns(count, count, |to, from| {
                nodes.at[times + 1][from * count + to]
            })
        };
        LaneNodes {
            s: in_lanes(&nodes.s),
            weights: in_lanes(&nodes.weights),
            columns: std::array::from_fn(columns),
            rows: std::array::from_fn(rows),
            nodes,
        }
    }

    /// Number of nodes.
    pub(crate) fn count(&self) -> usize {
        self.nodes.len()
    }

    /// Number of groups.
    pub(crate) fn groups(&self) -> usize {
        self.s.len()
    }

    /// Adds repeated integrals from 0 to the nodes, of functions with the given values.
    pub(crate) fn add_integrals(
        &self,
        times: usize,
        values: &[Lanes],
        functions: usize,
        out: &mut [Lanes],
    ) {
        add_polynomials(
            self.groups(),
            &self.columns[times - 1],
            values,
            functions,
            out,
        );
    }

    /// Adds the gradient with respect to the values, from the one with respect to repeated integrals from 0 to the
    /// nodes.
    pub(crate) fn add_transposed_integrals(
        &self,
        times: usize,
        integrals: &[Lanes],
        functions: usize,
        out: &mut [Lanes],
    ) {
        let rows = &self.rows[times - 1];
        add_polynomials(self.groups(), rows, integrals, functions, out);
    }

    /// Adds repeated integrals from 0 to 1.
    #[inline(always)]
    pub(crate) fn add_integrals_to_end(
        &self,
        times: usize,
        values: &[Lanes],
        functions: usize,
        out: &mut [f64],
    ) {
        let count = self.count();
        let row = &self.nodes.at[times][count * count..];
        for (values, factors) in values.chunks_exact(functions).zip(row.chunks_exact(LANES)) {
            let mut weights = Lanes::ZERO;
            weights.0.copy_from_slice(factors);
            for (value, out) in values.iter().zip(&mut *out) {
                *out += (*value * weights).sum();
            }
        }
    }

    /// Adds the gradient with respect to the values, from the one with respect to repeated integrals from 0 to 1.
    #[inline(always)]
    pub(crate) fn add_transposed_integrals_to_end(
        &self,
        times: usize,
        integrals: &[f64],
        out: &mut [Lanes],
    ) {
        let count = self.count();
        let row = self.nodes.at[times][count * count..].chunks_exact(LANES);
        for (factors, out) in row.zip(out.chunks_exact_mut(integrals.len())) {
            for (x, out) in integrals.iter().zip(out) {
                for (out, factor) in out.0.iter_mut().zip(factors) {
                    *out += x * factor;
                }
            }
        }
    }

    /// Values of the polynomials through given values, at other nodes.
    pub(crate) fn values_at(
        &self,
        others: &Self,
        values: &[Lanes],
        functions: usize,
    ) -> Vec<Lanes> {
        let columns = self.columns_to(others);
        let mut out = vec![Lanes::ZERO; others.groups() * functions];
        add_polynomials(others.groups(), &columns, values, functions, &mut out);
        out
    }

    /// The matrix from values at these nodes to those at others.
    fn columns_to(&self, others: &Self) -> Columns {
        let count = self.count();
        let mut known = MAPS.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.entry([count, others.count()]);
        Arc::clone(found.or_insert_with(|| {
            let factors = self.nodes.onto(&others.nodes);
            let entry = |to: usize, from: usize| factors[to * count + from];
            Arc::new(by_columns(count, others.count(), entry))
        }))
    }

    /// The largest of the last two Legendre coefficients of all functions.
    pub(crate) fn largest_tail(&self, values: &[Lanes], functions: usize) -> f64 {
        let mut most = 0.0;
        for row in self.nodes.tail.chunks_exact(self.count()) {
            for function in 0..functions {
                let mut sum = 0.0;
                let values = values.chunks_exact(functions);
                for (values, factors) in values.zip(row.chunks_exact(LANES)) {
                    for (x, factor) in values[function].0.iter().zip(factors) {
                        sum += x * factor;
                    }
                }
                most = larger(most, sum.abs());
            }
        }
        most
    }
}

/// Number of nodes for single cubics without rotation, and additional ones per radian of the largest velocity.
pub(crate) const FINE: [f64; 2] = [15.0, 2.5];

/// The number of nodes, or of iterations, for a leg along which the frame rotates by `speed`; the maximum if `speed` is
/// not finite.
pub(crate) fn nodes([still, radian]: [f64; 2], speed: f64, most: usize) -> usize {
    let wanted = (still + radian * speed).ceil();
    match wanted < most as f64 {
        true => wanted as usize,
        false => most,
    }
}

/// A matrix by columns, one for each node, which have the entries for all groups of other nodes.
pub(crate) fn by_columns(
    count: usize,
    others: usize,
    entry: impl Fn(usize, usize) -> f64,
) -> Vec<Lanes> {
    let groups = (0..others).step_by(LANES);
    let all = (0..count).flat_map(|from| groups.clone().map(move |first| (from, first)));
    let entry = &entry;
    all.map(|(from, first)| Lanes(std::array::from_fn(|lane| entry(first + lane, from))))
        .collect()
}

/// The numbers in groups of eight.
fn in_lanes(numbers: &[f64]) -> Vec<Lanes> {
    let groups = numbers.chunks_exact(LANES);
    groups
        .map(|group| Lanes(std::array::from_fn(|lane| group[lane])))
        .collect()
}

/// Numbers of groups of nodes and of functions whose sums are formed at once: each waits for its last addition, and all
/// of them are kept in registers. Boundary problems on St(20,5), with three groups, take 1.09 times as long with all
/// groups at once, where one sum is not kept there, and 1.05 times with one group and four functions.
const GROUPS: usize = 2;
const ABREAST: usize = 2;

/// Adds to values at all nodes what a matrix makes of given ones; for each node, the matrix has its column by groups.
pub(crate) fn add_polynomials(
    groups: usize,
    columns: &[Lanes],
    values: &[Lanes],
    functions: usize,
    out: &mut [Lanes],
) {
    Eight::run(
        #[inline(always)]
        || {
            let matrix = Matrix { groups, columns };
            let mut group = 0;
            while group + GROUPS <= groups {
                matrix.add_to_groups::<GROUPS>(group, values, functions, out);
                group += GROUPS;
            }
            if group < groups {
                matrix.add_to_groups::<1>(group, values, functions, out);
            }
        },
    );
}

/// A matrix of [`by_columns`], for a number of groups.
#[derive(Clone, Copy)]
struct Matrix<'a> {
    groups: usize,
    columns: &'a [Lanes],
}

impl Matrix<'_> {
    #[inline(always)]
    fn add_to_groups<const G: usize>(
        self,
        group: usize,
        values: &[Lanes],
        functions: usize,
        out: &mut [Lanes],
    ) {
        let mut first = 0;
        while first + ABREAST <= functions {
            self.add_few::<G, ABREAST>(group, values, [functions, first], out);
            first += ABREAST;
        }
        if first < functions {
            self.add_few::<G, 1>(group, values, [functions, first], out);
        }
    }

    #[inline(always)]
    fn add_few<const G: usize, const N: usize>(
        self,
        group: usize,
        values: &[Lanes],
        [functions, first]: [usize; 2],
        out: &mut [Lanes],
    ) {
        let mut sums = [[Lanes::ZERO; N]; G];
        let per_group = self.columns.chunks_exact(self.groups * LANES);
        for (columns, values) in per_group.zip(values.chunks_exact(functions)) {
            let values = &values[first..][..N];
            for (lane, columns) in columns.chunks_exact(self.groups).enumerate() {
                for (sums, column) in sums.iter_mut().zip(&columns[group..][..G]) {
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += *column * value.0[lane];
                    }
                }
            }
        }
        let out = out.chunks_exact_mut(functions).skip(group);
        for (sums, out) in sums.iter().zip(out) {
            for (sum, out) in sums.iter().zip(&mut out[first..]) {
                *out += *sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of several degrees, and their first integrals, at some times.
    fn polynomial(function: usize, s: f64) -> f64 {
        s.powi(function as i32)
    }

    fn values(nodes: &LaneNodes, functions: usize) -> Vec<Lanes> {
        let groups = nodes.s.iter().flat_map(|s| {
            (0..functions).map(|function| Lanes(s.0.map(|s| polynomial(function, s))))
        });
        groups.collect()
    }

    /// `<y, I f> = <I^T y, f>` for the integrals of `f` at the nodes and at the end.
    fn assert_transposed(
        nodes: &LaneNodes,
        times: usize,
        (values, integrals, at_end): (&[Lanes], &[Lanes], &[f64]),
    ) {
        let dot = |one: &[Lanes], other: &[Lanes]| -> f64 {
            let each = one.iter().zip(other);
            each.map(|(x, y)| (*x * *y).sum()).sum()
        };
        let at = |seed: f64| Lanes(std::array::from_fn(|lane| (seed + 1.3 * lane as f64).cos()));
        let y: Vec<Lanes> = (0..values.len()).map(|i| at(0.7 * i as f64)).collect();
        let at_one: Vec<f64> = (0..at_end.len()).map(|i| (0.9 * i as f64).cos()).collect();
        let mut back = vec![Lanes::ZERO; values.len()];
        nodes.add_transposed_integrals(times, &y, at_end.len(), &mut back);
        nodes.add_transposed_integrals_to_end(times, &at_one, &mut back);
        let ends: f64 = at_one.iter().zip(at_end).map(|(x, y)| x * y).sum();
        let error = dot(&y, integrals) + ends - dot(&back, values);
        assert!(
            error.abs() < 1e-13 * values.len() as f64,
            "{times}: {error:e}"
        );
    }

    #[test]
    fn polynomials_are_integrated_and_interpolated() {
        for (count, functions) in [(8, 1), (8, 5), (16, 4), (24, 3), (32, 2), (40, 7), (48, 6)] {
            let nodes = LaneNodes::at_least(count).unwrap();
            let values = values(&nodes, functions);
            for times in 1..=TIMES {
                let mut integrals = vec![Lanes::ZERO; values.len()];
                let mut at_end = vec![0.0; functions];
                nodes.add_integrals(times, &values, functions, &mut integrals);
                nodes.add_integrals_to_end(times, &values, functions, &mut at_end);
                assert_transposed(&nodes, times, (&values, &integrals, &at_end));
                for function in 0..functions {
                    let factor: f64 = (1..=times).map(|i| 1.0 / (function + i) as f64).product();
                    let exact = |s: f64| factor * polynomial(function + times, s);
                    assert!((at_end[function] - exact(1.0)).abs() < 1e-14);
                    for (group, s) in nodes.s.iter().enumerate() {
                        let found = integrals[group * functions + function];
                        for (s, found) in s.0.into_iter().zip(found.0) {
                            assert!((found - exact(s)).abs() < 1e-14, "{count} {function}");
                        }
                    }
                }
            }
            let others = LaneNodes::at_least(13).unwrap();
            let found = nodes.values_at(&others, &values, functions);
            for (found, exact) in found.iter().zip(super::tests::values(&others, functions)) {
                for (found, exact) in found.0.into_iter().zip(exact.0) {
                    assert!((found - exact).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn the_last_two_coefficients_are_found() {
        let nodes = LaneNodes::at_least(8).unwrap();
        assert!(nodes.largest_tail(&values(&nodes, 6), 6) < 1e-15);
        // The leading coefficient of the Legendre polynomial of degree 6 on [0, 1] is 924.
        let tail = nodes.largest_tail(&values(&nodes, 7), 7);
        assert!((tail - 1.0 / 924.0).abs() < 1e-15);
    }

    #[test]
    fn there_are_no_more_than_most_nodes() {
        assert!(LaneNodes::at_least(MOST).is_some());
        assert!(LaneNodes::at_least(MOST + 1).is_none());
    }
}
