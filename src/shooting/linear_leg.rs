//! A leg of a curve, linearised about its middle.
//!
//! A variation is described by four vectors of `m`: the displacement `p` of the point, `(g^{-1} dg)_m`, and the changes
//! `w, a, b` of `x, x', x''` relative to the rotation of the whole space that displaces the point,
//!
//! ```math
//! p = (g^{-1}\,\delta g)_m,\qquad w = \delta x + [(g^{-1}\,\delta g)_h, x],\qquad a, b\ \text{alike from}\ x', x''
//! ```
//!
//! At the middle they are the displacement `u` and the changes of the three given coefficients. With the change `dx` of
//! the series the frame rotates by
//!
//! ```math
//! g^{-1}\,\delta g\,(s) = \mathrm{Ad}_{g(s)^{-1}} \Bigl(u + \int_0^s \mathrm{Ad}_g\,\delta x\Bigr)
//! ```
//!
//! where the integral is that of the interpolation polynomial at Gauss nodes. A map between two times preserves the
//! form
//!
//! ```math
//! \omega(1, 2) = \langle a_1, w_2\rangle - \langle w_1, a_2\rangle - \langle b_1, p_2\rangle + \langle p_1, b_2\rangle
//!     + \langle x'', [p_1, p_2]_m\rangle - \langle [x, x']_h, [p_1, p_2]_h\rangle
//! ```
//!
//! so its inverse needs no linear solve: `M^{-1} = omega^{-1} M^T omega`. In tension `b - tau w` and `x'' - tau x` take
//! the place of `b` and `x''`.
//!
//! # Source
//! Conservation of the symplectic form by Hamiltonian flows: Arnold (1989), "Mathematical Methods of Classical Mechanics", 2nd
//! ed., sec. 38.

use std::borrow::Cow;
use std::sync::Arc;

use super::orders::{LONGEST, MOST, Orders};
use super::series::{Series, turn_into, turn_size};
use super::variation::{Node, Variation};
use crate::curve::nodes::Antiderivative;
use crate::linalg::field::{
    Field, accumulate, larger, largest, multiply, multiply_transposed, transposed_multiply,
};
use crate::linalg::simd::vectorised;
use crate::space::Homogeneous;

/// Number of additional terms of the derivative of a series.
const MORE: usize = 2;

/// `x, x', x''` at a time.
pub(super) type State<T> = [Vec<T>; 3];

/// One leg, or eight of them, parametrised by `s` in `[-1/2, 1/2]`. Matrices in row-major order.
#[derive(Debug)]
pub(super) struct LinearLeg<T> {
    /// Coefficients of the frame relative to the one at the middle; quaternions in three dimensions.
    frames: Vec<T>,
    integral: Arc<Antiderivative>,
    /// `Ad_g dx` at the nodes as functions of the changes at the middle, shape `(d + h, 3 d)` each.
    rates: Vec<T>,
    /// The maps of `(p, w, a, b)` from the first end to the middle, and from the middle to the last end, shape `(4 d, 4
    /// d)`.
    pub(super) from_first: Vec<T>,
    pub(super) to_last: Vec<T>,
    /// `x, x', x''` at the last end.
    pub(super) last: State<T>,
}

impl<T: Field> LinearLeg<T> {
    /// The leg with `x, x', x''` at the first end, in the time in which it takes one unit; `None` if a shorter one is
    /// needed.
    pub(super) fn from_start(
        space: impl Homogeneous,
        first: &State<T>,
        tension: Option<T>,
    ) -> Option<Self> {
        let d = space.dim();
        let mut series = Series::new(space, MOST);
        // To the middle, by the series about the first end.
        let order = resolve(space, first, tension, &mut series)?;
        let mut middle: State<T> = std::array::from_fn(|_| vec![T::ZERO; d]);
        let mut before = vec![T::ZERO; d];
        for (derivative, x) in middle.iter_mut().enumerate() {
            series.at_ends(d, order + 3, derivative, [&mut before, x]);
        }
        let order = resolve(space, &middle, tension, &mut series)?;
        let order = (order + MORE).min(MOST);
        Some(Self::about(space, series, &middle, tension, order))
    }

    /// The leg about its middle, with the given number of terms.
    fn about(
        space: impl Homogeneous,
        mut series: Series<T>,
        middle: &State<T>,
        tension: Option<T>,
        order: usize,
    ) -> Self {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let views = middle.each_ref().map(Vec::as_slice);
        series.set_curve(space, views, tension, order);
        series.set_turns(space, order + 2);
        let integral = Antiderivative::of(order / 2 + 6);
        let nodes: Vec<Node> = integral.nodes.iter().map(|s| (s - 0.5, 0.0)).collect();
        let mut variation = Variation::<T>::with_nodes(space, 3, order, Cow::Owned(nodes));
        variation.set_changes(space, &series, tension, order);
        let frames = series.frames[..(order + 3) * turn_size(space)].to_vec();
        let rates = rates(space, &frames, &integral, &variation);
        let mut states: [State<T>; 2] =
            std::array::from_fn(|_| std::array::from_fn(|_| vec![T::ZERO; d]));
        let [first, last] = &mut states;
        for (derivative, (first, last)) in first.iter_mut().zip(last).enumerate() {
            series.at_ends(d, order + 3, derivative, [first, last]);
        }
        let mut leg = LinearLeg {
            frames,
            integral,
            rates,
            from_first: Vec::new(),
            to_last: Vec::new(),
            last: Default::default(),
        };
        [leg.from_first, leg.to_last] = vectorised(
            #[inline(always)]
            || {
                let map = |end: usize| {
                    let mut eta = vec![T::ZERO; (d + h) * 4 * d];
                    leg.eta_into(space, [-0.5, 0.5][end], &mut eta);
                    let changes =
                        std::array::from_fn(|order| variation.ends[order][end].as_slice());
                    by_middle(space, &eta, &states[end], changes)
                };
                let tau = tension.unwrap_or(T::ZERO);
                let from_first = inverse(space, &map(0), [middle, &states[0]], tau);
                [from_first, map(1)]
            },
        );
        let [_, last] = states;
        leg.last = last;
        leg
    }

    /// One leg of eight.
    pub(super) fn lane(&self, lane: usize) -> LinearLeg<f64> {
        let of = |x: &[T]| x.iter().map(|x| x.lane(lane)).collect::<Vec<f64>>();
        LinearLeg {
            frames: of(&self.frames),
            integral: Arc::clone(&self.integral),
            rates: of(&self.rates),
            from_first: of(&self.from_first),
            to_last: of(&self.to_last),
            last: self.last.each_ref().map(|x| of(x)),
        }
    }

    /// `g^{-1} dg` at a time as a function of `(p, w, a, b)` at the middle, shape `(d + h, 4 d)`.
    #[inline(always)]
    fn eta_into(&self, space: impl Homogeneous, s: f64, out: &mut [T]) {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let wide = 4 * d;
        let weights = self.integral.weights_at(s + 0.5);
        out.fill(T::ZERO);
        for (weight, rates) in weights.iter().zip(self.rates.chunks_exact((d + h) * 3 * d)) {
            for (out, rates) in out.chunks_exact_mut(wide).zip(rates.chunks_exact(3 * d)) {
                for (out, rate) in out[d..].iter_mut().zip(rates) {
                    *out += *rate * *weight;
                }
            }
        }
        for p in 0..d {
            out[p * wide + p] = T::constant(1.0);
        }
        let frame = self.frame_at(space, s);
        let mut work = vec![T::ZERO; 3 * space.size().pow(2)];
        let mut column = vec![T::ZERO; d + h];
        for i in 0..wide {
            for (entry, row) in column.iter_mut().zip(out.chunks_exact(wide)) {
                *entry = row[i];
            }
            conjugate(space, &frame, Way::Back, &mut column, &mut work);
            for (entry, row) in column.iter().zip(out.chunks_exact_mut(wide)) {
                row[i] = *entry;
            }
        }
    }

    /// The frame at a time relative to the one at the middle.
    #[inline(always)]
    pub(super) fn frame_at(&self, space: impl Homogeneous, s: f64) -> Vec<T> {
        let mut frame = vec![T::ZERO; space.size().pow(2)];
        turn_into(space, &self.frames, s, &mut frame);
        frame
    }
}

impl LinearLeg<f64> {
    /// The displacement at a time, for `(p, w, a, b)` at the middle.
    pub(super) fn displacement(&self, space: impl Homogeneous, s: f64, middle: &[f64]) -> Vec<f64> {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let (u, changes) = middle.split_at(d);
        let mut sum = vec![0.0; d + h];
        sum[..d].copy_from_slice(u);
        let weights = self.integral.weights_at(s + 0.5);
        for (weight, rates) in weights.iter().zip(self.rates.chunks_exact((d + h) * 3 * d)) {
            for (sum, rates) in sum.iter_mut().zip(rates.chunks_exact(3 * d)) {
                let product: f64 = rates.iter().zip(changes).map(|(a, b)| a * b).sum();
                *sum += weight * product;
            }
        }
        let mut work = vec![0.0; 3 * space.size().pow(2)];
        conjugate(
            space,
            &self.frame_at(space, s),
            Way::Back,
            &mut sum,
            &mut work,
        );
        sum.truncate(d);
        sum
    }

    /// The gradient with respect to `(p, w, a, b)` at the middle of the sum of products of cotangents, in coordinates
    /// of the frames at their times, with the displacements there.
    pub(super) fn pull_back(
        &self,
        space: impl Homogeneous,
        loads: impl Iterator<Item = (f64, Vec<f64>)>,
    ) -> Vec<f64> {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let mut gradient = vec![0.0; 4 * d];
        let mut moments = vec![0.0; self.integral.nodes.len() * (d + h)];
        let mut work = vec![0.0; 3 * space.size().pow(2)];
        for (s, mut load) in loads {
            load.resize(d + h, 0.0);
            conjugate(
                space,
                &self.frame_at(space, s),
                Way::Forth,
                &mut load,
                &mut work,
            );
            add(&mut gradient[..d], 1.0, &load[..d]);
            let weights = self.integral.weights_at(s + 0.5);
            for (weight, moment) in weights.iter().zip(moments.chunks_exact_mut(d + h)) {
                add(moment, *weight, &load);
            }
        }
        for (moment, row) in moments.iter().zip(self.rates.chunks_exact(3 * d)) {
            add(&mut gradient[d..], *moment, row);
        }
        gradient
    }

    /// Number of floating-point numbers of the leg.
    pub(super) fn len(&self) -> usize {
        self.frames.len() + self.rates.len()
    }
}

/// Sets the series of a curve about a time, with as many terms as it needs at both ends of a leg; `None` if these are
/// too many.
fn resolve<T: Field>(
    space: impl Homogeneous,
    state: &State<T>,
    tension: Option<T>,
    series: &mut Series<T>,
) -> Option<usize> {
    let orders = Orders::finest();
    let views = state.each_ref().map(Vec::as_slice);
    let speed = speed(state, tension);
    let mut reached = vec![T::ZERO; space.size().pow(2)];
    let mut more = 0;
    loop {
        let order = orders.of_leg(speed, more);
        if order > LONGEST {
            return None;
        }
        series.set_curve(space, views, tension, order);
        series.reached_into(space, order, &mut reached);
        let next = orders.more(more, largest(&[series.tail(space, order)]));
        if next == more {
            return Some(order);
        }
        more = next;
    }
}

/// A bound on the velocity, as for a leg.
fn speed<T: Field>(state: &State<T>, tension: Option<T>) -> f64 {
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

/// `Ad_g dx` at the nodes.
fn rates<T: Field>(
    space: impl Homogeneous,
    frames: &[T],
    integral: &Antiderivative,
    variation: &Variation<T>,
) -> Vec<T> {
    let (d, h, square) = (space.dim(), space.isotropy_dim(), space.size().pow(2));
    let count = (d + h) * 3 * d;
    let mut rates = vec![T::ZERO; integral.nodes.len() * count];
    let (mut frame, mut adjoint) = (vec![T::ZERO; square], vec![T::ZERO; (d + h) * d]);
    let changes = variation.at_nodes.chunks_exact(3 * d * d);
    vectorised(
        #[inline(always)]
        || {
            let nodes = integral.nodes.iter().zip(changes);
            for ((s, changes), rates) in nodes.zip(rates.chunks_exact_mut(count)) {
                turn_into(space, frames, s - 0.5, &mut frame);
                space.adjoint_into(&frame, &mut adjoint);
                accumulate(&adjoint, d, changes, 3 * d, rates);
            }
        },
    );
    rates
}

/// The map of `(p, w, a, b)` from the middle to an end, from `g^{-1} dg` there, the state and its changes.
#[inline(always)]
fn by_middle<T: Field>(
    space: impl Homogeneous,
    eta: &[T],
    state: &State<T>,
    changes: [&[T]; 3],
) -> Vec<T> {
    let d = space.dim();
    let wide = 4 * d;
    let mut map = vec![T::ZERO; wide * wide];
    let (p, rest) = map.split_at_mut(d * wide);
    p.copy_from_slice(&eta[..d * wide]);
    let levels = rest.chunks_exact_mut(d * wide).zip(state).zip(changes);
    for ((rows, x), changes) in levels {
        for (row, change) in rows.chunks_exact_mut(wide).zip(changes.chunks_exact(3 * d)) {
            row[d..].copy_from_slice(change);
        }
        space.add_turning(x, eta, wide, rows);
    }
    map
}

/// The inverse of the map from the middle to an end, given the states at both.
#[inline(always)]
fn inverse<T: Field>(
    space: impl Homogeneous,
    map: &[T],
    [middle, end]: [&State<T>; 2],
    tau: T,
) -> Vec<T> {
    let d = space.dim();
    let (wide, block) = (4 * d, 4 * d * d);
    let [at_middle, at_end] = [middle, end].map(|state| displacement_form(space, state, tau));
    // The transpose times the form at the end, for columns p, w, a, b.
    let entry = |i: usize, [level, j]: [usize; 2]| map[(level * d + j) * wide + i];
    let mut transposed = vec![T::ZERO; block];
    let mut by_displacement = vec![T::ZERO; block];
    for i in 0..wide {
        for j in 0..d {
            transposed[i * d + j] = entry(i, [0, j]);
            by_displacement[i * d + j] = tau * entry(i, [1, j]) - entry(i, [3, j]);
        }
    }
    accumulate(&transposed, d, &at_end, d, &mut by_displacement);
    let right = |i: usize, j: usize| match [j / d, j % d] {
        [0, j] => by_displacement[i * d + j],
        [1, j] => entry(i, [2, j]) - tau * entry(i, [0, j]),
        [2, j] => -entry(i, [1, j]),
        [_, j] => entry(i, [0, j]),
    };
    // The inverse of the form at the middle.
    let mut out = vec![T::ZERO; wide * wide];
    for i in 0..d {
        for j in 0..wide {
            let [p, w, a, b] = [0, 1, 2, 3].map(|level| right(level * d + i, j));
            let values = [-b, a, -(tau * b) - w, p + tau * a];
            for (level, value) in values.into_iter().enumerate() {
                out[(level * d + i) * wide + j] = value;
            }
        }
    }
    let (known, last) = out.split_at_mut(3 * block);
    let minus: Vec<T> = at_middle.iter().map(|x| -*x).collect();
    accumulate(&minus, d, &known[..block], wide, last);
    out
}

/// The part of `omega` for two displacements: for a displacement `p`, `[p, x'' - tau x]_m - [p, [x, x']_h]`.
#[inline(always)]
fn displacement_form<T: Field>(space: impl Homogeneous, [x, a, b]: &State<T>, tau: T) -> Vec<T> {
    let (d, h, square) = (space.dim(), space.isotropy_dim(), space.size().pow(2));
    let mut matrices = vec![T::ZERO; 3 * square];
    let (x_matrix, rest) = matrices.split_at_mut(square);
    let (other, unit) = rest.split_at_mut(square);
    space.matrix_into(x, x_matrix);
    space.matrix_into(a, other);
    let mut turn = vec![T::ZERO; h];
    space.add_isotropy_bracket(x_matrix, other, -1.0, &mut turn);
    let pull: Vec<T> = b.iter().zip(x).map(|(b, x)| *b - tau * *x).collect();
    space.matrix_into(&pull, other);
    let [mut e, mut column] = [(); 2].map(|()| vec![T::ZERO; d]);
    let mut form = vec![T::ZERO; d * d];
    for j in 0..d {
        e[j] = T::constant(1.0);
        space.matrix_into(&e, unit);
        e[j] = T::ZERO;
        column.fill(T::ZERO);
        space.add_bracket(unit, other, 1.0, &mut column);
        if h > 0 {
            space.subtract_action(&turn, unit, &mut column);
        }
        for (i, entry) in column.iter().enumerate() {
            form[i * d + j] = *entry;
        }
    }
    form
}

/// Selects `Ad_g` or its inverse.
#[derive(Clone, Copy)]
enum Way {
    Forth,
    Back,
}

/// `v <- Ad_g v` or `Ad_g^{-1} v`, with coordinates of `m` before those of `h`; `work` holds three matrices.
#[inline(always)]
fn conjugate<T: Field>(space: impl Homogeneous, g: &[T], way: Way, v: &mut [T], work: &mut [T]) {
    let (d, r) = (space.dim(), space.size());
    let (x, rest) = work.split_at_mut(r * r);
    let (product, other) = rest.split_at_mut(r * r);
    let other = &mut other[..r * r];
    space.matrix_into(v, x);
    if space.isotropy_dim() > 0 {
        space.isotropy_matrix_into(&v[d..], other);
        for (x, other) in x.iter_mut().zip(&*other) {
            *x += *other;
        }
    }
    match way {
        Way::Forth => {
            multiply(r, g, x, product);
            multiply_transposed(r, product, g, other);
        }
        Way::Back => {
            transposed_multiply(r, g, x, product);
            multiply(r, product, g, other);
        }
    }
    space.each_entry(
        #[inline(always)]
        |p, i, j| v[p] = space.skew_coordinate(other, [i, j]),
    );
    space.each_isotropy_entry(
        #[inline(always)]
        |p, i, j| v[d + p] = space.skew_coordinate(other, [i, j]),
    );
}

fn add(sum: &mut [f64], factor: f64, other: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(other) {
        *sum += factor * x;
    }
}
