//! The response of the ends of a leg to changes of its middle, from the first terms of the series.

use std::borrow::Cow;

use super::brackets::{isotropy_bracket_into, minus_bracket_into, subtract_action};
use super::rotation_series::{add_cross_products, is_of_rotations, set_coordinates, weigh};
use super::series::{LegSeries, at_ends, at_opposite_times, value_at};
use crate::linalg::dual::Number;
use crate::linalg::field::{Field, accumulate, transposed_multiply};
use crate::space::{Homogeneous, axis};

/// Number of terms of the series of the derivative, after the three given ones. With two, splines through 400 rotations
/// up to 1.2 rad apart take ten steps instead of seven; six do not save any.
pub(crate) const TERMS: usize = 4;

/// The same on `SO(3)`, where terms are cheapest, for legs up to a speed: six up to 2 rad, one more for each further 2
/// rad. With six at any speed, splines through 10, 50, 200 and 2000 rotations up to 1.2 rad apart take 1.0, 1.04, 1.03
/// and 1.08 times as long.
pub(crate) fn terms_of_rotations(speed: f64) -> usize {
    // A speed that is not a number gives the largest number.
    (5.0 + 0.5 * speed)
        .min(MOST_TERMS_OF_ROTATIONS as f64)
        .ceil() as usize
}

/// Largest number of terms on `SO(3)`.
pub(crate) const MOST_TERMS_OF_ROTATIONS: usize = 12;

/// Number of terms in tension, and for a second derivative with an error of 1e-10 instead of a percent.
pub(crate) const MORE_TERMS: usize = 14;

/// A Gauss node on `[-1/2, 1/2]` and its weight, for the integral over the frames.
pub(crate) type Node = (f64, f64);

const NODES: [Node; 4] = [
    (-0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
    (-0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
    (0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
    (0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The same for [`MORE_TERMS`].
const MORE_NODES: [Node; 8] = [
    (-0.480_144_928_248_768_1, 0.050_614_268_145_188_13),
    (-0.398_333_238_706_813_4, 0.111_190_517_226_687_23),
    (-0.262_766_204_958_164_5, 0.156_853_322_938_943_64),
    (-0.091_717_321_247_824_9, 0.181_341_891_689_181),
    (0.091_717_321_247_824_9, 0.181_341_891_689_181),
    (0.262_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.398_333_238_706_813_4, 0.111_190_517_226_687_23),
    (0.480_144_928_248_768_1, 0.050_614_268_145_188_13),
];

fn nodes(terms: usize) -> &'static [Node] {
    match terms >= MORE_TERMS {
        true => &MORE_NODES,
        false => &NODES,
    }
}

/// Changes at the ends as functions of changes of `x, x', x''` at the middle, `3 d` columns each, in row-major order.
#[derive(Clone)]
pub(crate) struct MiddleVariation<T: Field> {
    /// Changes of `x` and of its derivatives at the first and the last end, shape `(d, 3 d)`, by order.
    pub(crate) ends: Vec<[Vec<T>; 2]>,
    /// Change of the frame at the last end relative to the one at the first, `g eta`: coordinates of `m` before those
    /// of `h`.
    pub(crate) eta: Vec<T>,
    nodes: Cow<'static, [Node]>,
    /// Coefficients of the change of `x` for a few columns at once, as vectors and as matrices; and of the change of
    /// `w_h`. For rotations as axial vectors for all columns, a few after the other, and the coefficients by which they
    /// are multiplied.
    terms: Vec<T::Columns>,
    weighted: Vec<T>,
    matrices: Vec<T::Columns>,
    isotropy: Vec<T::Columns>,
    run: Vec<T::Columns>,
    /// The change of `x` or of a derivative, at both ends or at a node.
    values: [Vec<T::Columns>; 2],
    /// `Ad` from the nodes to the last end, times the weights, shape `(d + h, d)`.
    adjoints: Vec<T>,
    /// The change of `x` at the nodes, shape `(d, 3 d)`.
    pub(crate) at_nodes: Vec<T>,
    work: Vec<T>,
}

impl<T: Field> MiddleVariation<T> {
    /// Allocates `terms + 3` coefficients, and the changes of `x, x', x''` at the ends, as many of them as wanted.
    ///
    /// Their number is not part of the type: compiled for each, the kernels would take a megabyte more.
    pub(crate) fn new(space: impl Homogeneous, wanted: usize, terms: usize) -> Self {
        Self::with_nodes(space, wanted, terms, Cow::Borrowed(nodes(terms)))
    }

    pub(crate) fn with_nodes(
        space: impl Homogeneous,
        wanted: usize,
        terms: usize,
        nodes: Cow<'static, [Node]>,
    ) -> Self {
        let (d, h, square) = (
            space.dim(),
            space.isotropy_dim(),
            space.size() * space.size(),
        );
        // Groups of columns that are kept, the room for them as matrices, and that for weighted coefficients.
        let (kept, plain, axes) = match is_of_rotations(space) {
            true => ((3 * d).div_ceil(T::COLUMNS), 0, terms + 3),
            false => (1, terms + 3, 0),
        };
        let zeros = |count: usize| vec![T::ZERO; count];
        let columns = |count: usize| vec![T::Columns::ZERO; count];
        let wide = || std::array::from_fn(|_| zeros(3 * d * d));
        MiddleVariation {
            ends: (0..wanted).map(|_| wide()).collect(),
            eta: zeros((d + h) * 3 * d),
            terms: columns((terms + 3) * d * kept),
            weighted: zeros(3 * axes),
            matrices: columns(plain * square),
            isotropy: columns(plain * square),
            run: columns(d.max(h)),
            values: std::array::from_fn(|_| columns(d)),
            adjoints: zeros(nodes.len() * (d + h) * d),
            at_nodes: zeros(nodes.len() * 3 * d * d),
            work: zeros(3 * square),
            nodes,
        }
    }

    /// Computes the variation from `terms` terms after the three given ones of a series that has as many, and the
    /// tension of the curve.
    pub(crate) fn set(
        &mut self,
        space: impl Homogeneous,
        series: &LegSeries<T>,
        tension: Option<T>,
        terms: usize,
    ) {
        self.set_changes(space, series, tension, terms);
        self.set_eta(space, series, terms);
    }

    /// Computes only the changes at the ends and at the nodes.
    ///
    /// Compiled once instead of into every caller.
    #[inline(never)]
    pub(crate) fn set_changes(
        &mut self,
        space: impl Homogeneous,
        series: &LegSeries<T>,
        tension: Option<T>,
        terms: usize,
    ) {
        space.vectorised(
            #[inline(always)]
            || self.set_columns(space, series, tension, terms),
        );
    }

    #[inline(always)]
    fn set_columns(
        &mut self,
        space: impl Homogeneous,
        series: &LegSeries<T>,
        tension: Option<T>,
        terms: usize,
    ) {
        let d = space.dim();
        let (wide, count) = (3 * d, terms + 3);
        let is_of_rotations = is_of_rotations(space);
        if is_of_rotations {
            self.set_axes(space, series, tension, terms);
        }
        for column in (0..wide).step_by(T::COLUMNS) {
            let from = match is_of_rotations {
                true => column / T::COLUMNS * count * d,
                false => {
                    self.set_terms(space, series, tension, column, terms);
                    0
                }
            };
            let all = &self.terms[from..][..count * d];
            let abreast = T::COLUMNS.min(wide - column);
            let write = |values: &[T::Columns], out: &mut [T]| {
                for (value, row) in values.iter().zip(out.chunks_exact_mut(wide)) {
                    for (i, out) in row[column..][..abreast].iter_mut().enumerate() {
                        *out = T::column(*value, i);
                    }
                }
            };
            let [first, last] = &mut self.values;
            for (derivative, out) in self.ends.iter_mut().enumerate() {
                at_ends(all, d, derivative, [first, last]);
                if is_of_rotations {
                    set_coordinates(space, first);
                    set_coordinates(space, last);
                }
                for (out, values) in out.iter_mut().zip([&*first, &*last]) {
                    write(values, out);
                }
            }
            // Nodes are symmetric about the middle.
            for (node, (s, _)) in self.nodes.iter().enumerate().skip(self.nodes.len() / 2) {
                at_opposite_times(all, d, *s, [first, last]);
                if is_of_rotations {
                    set_coordinates(space, first);
                    set_coordinates(space, last);
                }
                let opposite = self.nodes.len() - 1 - node;
                for (node, values) in [(opposite, &*first), (node, &*last)] {
                    write(values, &mut self.at_nodes[node * d * wide..][..d * wide]);
                }
            }
        }
    }

    /// Computes the change of the frame, after the changes at the nodes.
    #[inline(never)]
    fn set_eta(&mut self, space: impl Homogeneous, series: &LegSeries<T>, terms: usize) {
        space.vectorised(
            #[inline(always)]
            || {
                let (d, h) = (space.dim(), space.isotropy_dim());
                self.set_adjoints(space, series, terms + 4);
                self.eta.fill(T::ZERO);
                let adjoints = self.adjoints.chunks_exact((d + h) * d);
                let at_nodes = self.at_nodes.chunks_exact(d * 3 * d);
                for (adjoint, at_node) in adjoints.zip(at_nodes) {
                    accumulate(adjoint, d, at_node, 3 * d, &mut self.eta);
                }
            },
        );
    }

    /// Coefficients of the change of `x` for changes of the three given coefficients, as axial vectors of rotations.
    #[inline(always)]
    fn set_axes(
        &mut self,
        space: impl Homogeneous,
        series: &LegSeries<T>,
        tension: Option<T>,
        terms: usize,
    ) {
        // Fewer terms than allocated leave more room than groups of columns.
        let (count, groups) = ((terms + 3) * 3, 9_usize.div_ceil(T::COLUMNS));
        let all = &mut self.terms[..groups * count];
        for (group, axes) in all.chunks_exact_mut(count).enumerate() {
            axes[..9].fill(T::Columns::ZERO);
            for (i, column) in (group * T::COLUMNS..9).take(T::COLUMNS).enumerate() {
                let (level, p) = (column / 3, column % 3);
                let (mut unit, mut matrix) = ([0.0; 3], [0.0; 9]);
                unit[p] = if level < 2 { 1.0 } else { 0.5 };
                space.matrix_into(&unit, &mut matrix);
                for (out, x) in axes[3 * level..].iter_mut().zip(axis(&matrix)) {
                    T::set_column(out, i, x);
                }
            }
        }
        for k in 0..terms {
            let weighted = &mut self.weighted[..3 * (k + 3)];
            weigh(&series.matrices, weighted);
            let factor = 1.0 / ((k + 3) * (k + 2)) as f64;
            for (group, axes) in all.chunks_exact_mut(count).enumerate() {
                let columns = group * T::COLUMNS..9.min((group + 1) * T::COLUMNS);
                let levels = columns.start / 3..(columns.end - 1) / 3 + 1;
                let (known, next) = axes.split_at_mut(3 * (k + 3));
                let mut sums = [T::Columns::ZERO; 3];
                // Only the given coefficients that belong to the columns change.
                let given = 3 * levels.start..3 * levels.end;
                add_cross_products(&known[given.clone()], &weighted[given], &mut sums);
                add_cross_products(&known[9..], &weighted[9..], &mut sums);
                if let Some(tension) = tension {
                    for (sum, x) in sums.iter_mut().zip(&known[3 * (k + 1)..]) {
                        *sum -= *x * tension;
                    }
                }
                for (next, sum) in next.iter_mut().zip(sums) {
                    *next = -sum * factor;
                }
            }
        }
    }

    /// Coefficients of the change of `x` for changes of the three given coefficients, for a few columns from `column`
    /// on.
    #[inline(always)]
    fn set_terms(
        &mut self,
        space: impl Homogeneous,
        series: &LegSeries<T>,
        tension: Option<T>,
        column: usize,
        terms: usize,
    ) {
        let (d, square) = (space.dim(), space.size() * space.size());
        let (x, w) = (&series.matrices, &series.isotropy);
        self.terms[..3 * d].fill(T::Columns::ZERO);
        let abreast = T::COLUMNS.min(3 * d - column);
        for i in 0..abreast {
            let change = if column + i < 2 * d { 1.0 } else { 0.5 };
            T::set_column(&mut self.terms[column + i], i, change);
        }
        for k in 0..3 {
            space.matrix_into(&self.terms[k * d..], &mut self.matrices[k * square..]);
        }
        // Only the given coefficients that belong to the columns change.
        let [first, last] = [column, column + abreast - 1].map(|column| column / d);
        let is_changed = |i: usize| i >= 3 || (first..=last).contains(&i);
        for k in 0..terms {
            let (before, next) = self.terms.split_at_mut((k + 3) * d);
            let next = &mut next[..d];
            let changes = &self.matrices;
            // All pairs of the brackets w_s.
            let pairs = |s: usize| {
                let changed = (0..=s + 1).filter(move |i| is_changed(*i) && 2 * i != s + 1);
                changed.map(move |i| {
                    let weight = (s + 1) as i32 - 2 * i as i32;
                    (
                        f64::from(weight),
                        &changes[i * square..],
                        &x[(s + 1 - i) * square..],
                    )
                })
            };
            minus_bracket_into(space, pairs(k + 1), next);
            for x in &mut *next {
                *x = *x * (k + 1) as f64;
            }
            if space.isotropy_dim() > 0 {
                let run = &mut self.run;
                isotropy_bracket_into(space, pairs(k), run);
                space.isotropy_matrix_into(run, &mut self.isotropy[k * square..]);
                let turns = &self.isotropy;
                let turned = (0..=k).map(|i| (&x[(k - i) * square..], &turns[i * square..]));
                let turning = (0..=k).filter(|i| is_changed(k - i));
                let turning = turning.map(|i| (&changes[(k - i) * square..], &w[i * square..]));
                subtract_action(
                    space,
                    turned,
                    #[inline(always)]
                    |x: T, z: T::Columns| z * x,
                    run,
                    next,
                );
                subtract_action(
                    space,
                    turning,
                    #[inline(always)]
                    |x: T::Columns, z: T| x * z,
                    run,
                    next,
                );
            }
            if let Some(tension) = tension {
                for (next, x) in next.iter_mut().zip(&before[(k + 1) * d..]) {
                    *next += *x * tension * (k + 1) as f64;
                }
            }
            let factor = 1.0 / ((k + 3) * (k + 2) * (k + 1)) as f64;
            for x in &mut *next {
                *x = *x * factor;
            }
            space.matrix_into(next, &mut self.matrices[(k + 3) * square..]);
        }
    }

    /// `Ad_{g(1/2)^{-1} g(s)}` at the nodes, times the weights.
    #[inline(always)]
    fn set_adjoints(&mut self, space: impl Homogeneous, series: &LegSeries<T>, count: usize) {
        let (d, h, r) = (space.dim(), space.isotropy_dim(), space.size());
        let square = r * r;
        let frames = &series.frames[..count * square];
        let (last, rest) = self.work.split_at_mut(square);
        let (frame, turn) = rest.split_at_mut(square);
        value_at(frames, square, 0.5, last);
        let adjoints = self.adjoints.chunks_exact_mut((d + h) * d);
        for ((s, weight), adjoint) in self.nodes.iter().zip(adjoints) {
            value_at(frames, square, *s, frame);
            transposed_multiply(r, last, frame, turn);
            space.adjoint_into(turn, adjoint);
            for entry in adjoint {
                *entry = *entry * *weight;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_of_rotations_grow_with_speed_and_are_bounded() {
        let terms = [0.0, 2.0, 2.1, 14.0, 100.0, f64::INFINITY, f64::NAN].map(terms_of_rotations);
        assert_eq!(terms, [5, 6, 7, 12, 12, 12, 12]);
        // With more, other nodes would be taken.
        const { assert!(MOST_TERMS_OF_ROTATIONS < MORE_TERMS) };
    }
}
