//! A leg of a curve, linearised about its middle.
//!
//! A variation is described by the displacement `u` of the first point and the changes of `x, x', x''` at the middle. The
//! frame, relative to the one at the first end, rotates by
//!
//! ```math
//! g^{-1}\,\delta g\,(s) = \mathrm{Ad}_{g(s)^{-1}} \Bigl(u + \int_0^s \mathrm{Ad}_g\,\delta x\Bigr)
//! ```
//!
//! where the integral is that of the interpolation polynomial at Gauss nodes. From it follow the displacement `p` of a point
//! and the changes `w, a, b` of `x, x', x''` relative to the rotation of the whole space that displaces the point,
//!
//! ```math
//! p = (g^{-1}\,\delta g)_m,\qquad w = \delta x + [(g^{-1}\,\delta g)_h, x],\qquad a, b\ \text{alike from}\ x', x''
//! ```

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use crate::curve::nodes::Nodes;
use crate::linalg::field::{
    Field, accumulate, larger, largest, multiply, set_identity, transposed_multiply,
};
use crate::shooting::taylor::orders::{LONGEST, Orders};
use crate::shooting::taylor::series::{LegSeries, turn_into, turn_size};
use crate::shooting::taylor::variation::{MiddleVariation, Node};
use crate::space::Homogeneous;

/// Number of additional terms of the derivative of a series.
const MORE: usize = 2;

/// Number of Gauss nodes beyond half the number of terms.
const NODES: usize = 6;

/// `x, x', x''` at a time.
pub(crate) type VectorsAt<T> = [Vec<T>; 3];

/// A linear function of a variation: of the displacement of the first point, shape `(rows, d)`, and of the changes of `x, x',
/// x''` at the middle, shape `(rows, 3 d)`; in row-major order.
#[derive(Debug)]
pub(crate) struct LegResponse<T> {
    pub(crate) direct: Vec<T>,
    pub(crate) bent: Vec<T>,
}

/// One leg, or eight of them, in the time in which it takes one unit.
///
/// Its points are the first end, the Gauss nodes and the last end.
#[derive(Debug)]
pub(crate) struct LinearLeg<T> {
    pub(crate) nodes: Arc<Nodes>,
    /// Frames at the points relative to the one at the first end, shape `(r, r)` in row-major order.
    pub(crate) frames: Vec<T>,
    /// Displacements of the points, `d` rows for each; only of the first one if the others are not wanted.
    pub(crate) displacements: LegResponse<T>,
    /// `(w, a, b)` at the first end by the changes at the middle, shape `(3 d, 3 d)`.
    pub(crate) first: Vec<T>,
    /// `(p, w, a, b)` at the last end.
    pub(crate) last: LegResponse<T>,
    /// `x, x', x''` at the last end.
    pub(crate) last_state: VectorsAt<T>,
}

impl<T: Field> LinearLeg<T> {
    /// The leg with `x, x', x''` at the first end, in the time in which it takes one unit; `None` if a shorter one is
    /// needed.
    pub(crate) fn from_start(
        space: impl Homogeneous,
        first: &VectorsAt<T>,
        tension: Option<T>,
        has_points: bool,
    ) -> Option<Self> {
        let d = space.dim();
        let mut series = LegSeries::new(space, LONGEST + MORE);
        // To the middle, by the series about the first end.
        let order = resolve(space, first, tension, &mut series)?;
        let mut middle: VectorsAt<T> = std::array::from_fn(|_| vec![T::ZERO; d]);
        let mut before = vec![T::ZERO; d];
        for (derivative, x) in middle.iter_mut().enumerate() {
            series.at_ends(d, order + 3, derivative, [&mut before, x]);
        }
        let known = resolve(space, &middle, tension, &mut series)?;
        let order = known + MORE;
        series.extend_curve(space, tension, known..order);
        extend_turns(space, &mut series, known..order + 2);
        Some(Self::about(space, &series, tension, order, has_points))
    }

    /// The leg about its middle, from series with the given number of terms.
    fn about(
        space: impl Homogeneous,
        series: &LegSeries<T>,
        tension: Option<T>,
        order: usize,
        has_points: bool,
    ) -> Self {
        let d = space.dim();
        let nodes = Nodes::of(order / 2 + NODES);
        let at: Vec<Node> = nodes.s.iter().map(|s| (s - 0.5, 0.0)).collect();
        let mut variation = MiddleVariation::<T>::with_nodes(space, 3, order, Cow::Owned(at));
        variation.set_changes(space, series, tension, order);
        let mut last_state: VectorsAt<T> = std::array::from_fn(|_| vec![T::ZERO; d]);
        let mut before = vec![T::ZERO; d];
        for (derivative, x) in last_state.iter_mut().enumerate() {
            series.at_ends(d, order + 3, derivative, [&mut before, x]);
        }
        let turns = &series.frames[..(order + 3) * turn_size(space)];
        space.vectorised(
            #[inline(always)]
            || {
                let frames = frames(space, turns, &nodes.s);
                let Turns {
                    displacements,
                    last: turned,
                } = Turns::of(space, &nodes, &frames, &variation.at_nodes, has_points);
                LinearLeg {
                    last: last(space, &turned, &last_state, &variation),
                    first: variation
                        .ends
                        .iter()
                        .flat_map(|[first, _]| first)
                        .copied()
                        .collect(),
                    nodes: Arc::clone(&nodes),
                    frames,
                    displacements,
                    last_state,
                }
            },
        )
    }
}

/// Frames at the points, from their series about the middle.
#[inline(always)]
fn frames<T: Field>(space: impl Homogeneous, turns: &[T], nodes: &[f64]) -> Vec<T> {
    let r = space.size();
    let square = r * r;
    let mut frames = vec![T::ZERO; (nodes.len() + 2) * square];
    let (mut first, mut frame) = (vec![T::ZERO; square], vec![T::ZERO; square]);
    turn_into(space, turns, -0.5, &mut first);
    let (start, rest) = frames.split_at_mut(square);
    set_identity(r, start);
    let times = nodes.iter().map(|s| s - 0.5).chain([0.5]);
    for (s, out) in times.zip(rest.chunks_exact_mut(square)) {
        turn_into(space, turns, s, &mut frame);
        transposed_multiply(r, &first, &frame, out);
    }
    frames
}

/// `g^{-1} dg` as a function of a variation: its part in `m` at all points, and the whole, `d + h` rows, at the last end.
struct Turns<T> {
    displacements: LegResponse<T>,
    last: LegResponse<T>,
}

impl<T: Field> Turns<T> {
    /// From the frames at the points and the changes of `x` at the nodes.
    #[inline(always)]
    fn of(
        space: impl Homogeneous,
        nodes: &Nodes,
        frames: &[T],
        at_nodes: &[T],
        has_points: bool,
    ) -> Self {
        let (d, h, r, count) = (space.dim(), space.isotropy_dim(), space.size(), nodes.len());
        let (all, wide) = (d + h, 3 * d);
        let zeros = |size: usize| vec![T::ZERO; size];
        // `Ad_g` from `m`, and its products with the changes of `x`: their integrals are those of the rotation.
        let mut adjoints = zeros((count + 1) * all * d);
        let mut rates = zeros(count * all * wide);
        let mut sums = zeros((count + 1) * all * wide);
        let inner = frames.chunks_exact(r * r).skip(1);
        for (frame, adjoint) in inner.zip(adjoints.chunks_exact_mut(all * d)) {
            space.adjoint_into(frame, adjoint);
        }
        let changes = adjoints
            .chunks_exact(all * d)
            .zip(at_nodes.chunks_exact(d * wide));
        for ((adjoint, change), rates) in changes.zip(rates.chunks_exact_mut(all * wide)) {
            accumulate(adjoint, d, change, wide, rates);
        }
        accumulate(&nodes.at[1], count, &rates, all * wide, &mut sums);
        let points = if has_points { count + 2 } else { 1 };
        let mut displacements = LegResponse {
            direct: zeros(points * d * d),
            bent: zeros(points * d * wide),
        };
        set_identity(d, &mut displacements.direct[..d * d]);
        // In orthonormal coordinates the part in `m` of the inverse of `Ad_g` is the transpose.
        let mut transposed = zeros(d * all);
        let inner = adjoints.chunks_exact(all * d).take(points - 1);
        for (point, adjoint) in inner.enumerate() {
            for (i, row) in adjoint.chunks_exact(d).enumerate() {
                for (j, x) in row.iter().enumerate() {
                    transposed[j * all + i] = *x;
                }
            }
            let direct = displacements.direct[(point + 1) * d * d..].chunks_exact_mut(d);
            for (row, out) in transposed.chunks_exact(all).zip(direct) {
                out.copy_from_slice(&row[..d]);
            }
            let bent = &mut displacements.bent[(point + 1) * d * wide..][..d * wide];
            let sums = &sums[point * all * wide..][..all * wide];
            accumulate(&transposed, all, sums, wide, bent);
        }
        let mut last = LegResponse {
            direct: zeros(all * d),
            bent: sums.split_off(count * all * wide),
        };
        set_identity(d, &mut last.direct[..d * d]);
        let frame = &frames[(count + 1) * r * r..];
        conjugate_back(space, frame, d, &mut last.direct);
        conjugate_back(space, frame, wide, &mut last.bent);
        Turns {
            displacements,
            last,
        }
    }
}

/// `(p, w, a, b)` at the last end, from `g^{-1} dg` there.
#[inline(always)]
fn last<T: Field>(
    space: impl Homogeneous,
    turned: &LegResponse<T>,
    state: &VectorsAt<T>,
    variation: &MiddleVariation<T>,
) -> LegResponse<T> {
    let d = space.dim();
    let part = |turned: &[T], columns: usize| {
        let mut out = vec![T::ZERO; 4 * d * columns];
        out[..d * columns].copy_from_slice(&turned[..d * columns]);
        let rows = out.chunks_exact_mut(d * columns).skip(1);
        for ((rows, x), [_, change]) in rows.zip(state).zip(&variation.ends) {
            if columns == 3 * d {
                rows.copy_from_slice(change);
            }
            space.add_turning(x, turned, columns, rows);
        }
        out
    };
    LegResponse {
        direct: part(&turned.direct, d),
        bent: part(&turned.bent, 3 * d),
    }
}

/// Sets the series of a curve about a time, with as many terms as it needs at both ends of a leg; `None` if these are too many.
///
/// Variations need the terms that the speed predicts even where the curve does with fewer: at rest, or where its vectors
/// commute.
fn resolve<T: Field>(
    space: impl Homogeneous,
    state: &VectorsAt<T>,
    tension: Option<T>,
    series: &mut LegSeries<T>,
) -> Option<usize> {
    let orders = Orders::finest();
    let views = state.each_ref().map(Vec::as_slice);
    let speed = speed(state, tension);
    let (mut more, mut known) = (0, 0);
    series.set_curve(space, views, tension, known);
    series.set_turns(space, known);
    loop {
        let order = orders.of_leg(speed, more);
        if order > LONGEST {
            return None;
        }
        series.extend_curve(space, tension, known..order);
        extend_turns(space, series, known..order);
        let next = orders.more(more, largest(&[series.tail(space, order)]));
        if next == more {
            return Some(order);
        }
        (more, known) = (next, order);
    }
}

/// [`LegSeries::extend_turns`] by vector instructions.
fn extend_turns<T: Field>(
    space: impl Homogeneous,
    series: &mut LegSeries<T>,
    powers: Range<usize>,
) {
    space.vectorised(
        #[inline(always)]
        || series.extend_turns(space, powers),
    );
}

/// A bound on the velocity, as for a leg.
fn speed<T: Field>(state: &VectorsAt<T>, tension: Option<T>) -> f64 {
    let bound = |lane: usize| {
        let [v, a, b] = state.each_ref().map(|x| {
            let square: f64 = x.iter().map(|x| x.lane(lane).powi(2)).sum();
            square.sqrt()
        });
        let tension = tension.map_or(0.0, |tension| tension.lane(lane));
        larger(v + 0.5 * a + 0.125 * b, tension.sqrt())
    };
    (0..T::COUNT).map(bound).fold(0.0, larger)
}

/// Replaces the columns of a matrix, coordinates of `m` before those of `h`, by `Ad_g^{-1}` of them.
#[inline(always)]
fn conjugate_back<T: Field>(space: impl Homogeneous, g: &[T], columns: usize, matrix: &mut [T]) {
    let (d, r) = (space.dim(), space.size());
    let mut work = vec![T::ZERO; 3 * r * r];
    let (x, rest) = work.split_at_mut(r * r);
    let (product, other) = rest.split_at_mut(r * r);
    let mut v = vec![T::ZERO; d + space.isotropy_dim()];
    for column in 0..columns {
        for (x, row) in v.iter_mut().zip(matrix.chunks_exact(columns)) {
            *x = row[column];
        }
        space.matrix_into(&v, x);
        if space.isotropy_dim() > 0 {
            space.isotropy_matrix_into(&v[d..], other);
            for (x, other) in x.iter_mut().zip(&*other) {
                *x += *other;
            }
        }
        transposed_multiply(r, g, x, product);
        multiply(r, product, g, other);
        space.each_entry(
            #[inline(always)]
            |p, i, j| v[p] = space.skew_coordinate(other, [i, j]),
        );
        space.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| v[d + p] = space.skew_coordinate(other, [i, j]),
        );
        for (x, row) in v.iter().zip(matrix.chunks_exact_mut(columns)) {
            row[column] = *x;
        }
    }
}
