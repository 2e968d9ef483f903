//! A leg of a curve, linearised about its middle.
//!
//! A variation is told by four vectors of `m`: the displacement `p` of the point, `(g^{-1} dg)_m`, and the changes `w, a, b` of
//! `x, x', x''` beside the rotation of everything that displaces the point,
//!
//! ```math
//! p = (g^{-1}\,\delta g)_m,\qquad w = \delta x + [(g^{-1}\,\delta g)_h, x],\qquad a, b\ \text{alike from}\ x', x''
//! ```
//!
//! In the middle they are the displacement `u` and the changes of the three given coefficients. With the change `dx` of the series
//! the frame turns in itself by
//!
//! ```math
//! g^{-1}\,\delta g\,(s) = \mathrm{Ad}_{g(s)^{-1}} \Bigl(u + \int_0^s \mathrm{Ad}_g\,\delta x\Bigr)
//! ```
//!
//! where the integral is that of the polynomial through values at Gauss nodes. A map between two times leaves the form
//!
//! ```math
//! \omega(1, 2) = \langle a_1, w_2\rangle - \langle w_1, a_2\rangle - \langle b_1, p_2\rangle + \langle p_1, b_2\rangle
//!     + \langle x'', [p_1, p_2]_m\rangle - \langle [x, x']_h, [p_1, p_2]_h\rangle
//! ```
//!
//! as it is, which gives its inverse without a solution: `M^{-1} = omega^{-1} M^T omega`. In tension `b - tau w` and `x'' - tau x`
//! take the place of `b` and `x''`.
//!
//! # Source
//! Conservation of the symplectic form by Hamiltonian flows: Arnold (1989), "Mathematical Methods of Classical Mechanics", 2nd
//! ed., sec. 38.

use std::borrow::Cow;
use std::sync::Arc;

use faer::{Mat, Scale};

use super::orders::{LONGEST, MOST, Orders};
use super::series::Series;
use super::variation::{Node, Variation, value_at};
use crate::curve::nodes::Antiderivative;
use crate::linalg::field::{accumulate, multiply, multiply_transposed, transposed_multiply};
use crate::linalg::simd::vectorised;
use crate::space::Homogeneous;

/// Terms of the derivative of a series beyond its own.
const MORE: usize = 2;

/// `x, x', x''` at a time.
pub(super) type State = [Vec<f64>; 3];

/// A leg, run through for `s` in `[-1/2, 1/2]`.
#[derive(Debug)]
pub(super) struct LinearLeg {
    /// Coefficients of the frame relative to that in the middle.
    frames: Vec<f64>,
    integral: Arc<Antiderivative>,
    /// `Ad_g dx` at the nodes by the changes in the middle, shape `(d + h, 3 d)` each.
    rates: Vec<f64>,
    /// `(p, w, a, b)` in the middle by those at the first end, and at the last end by those in the middle.
    pub(super) from_first: Mat<f64>,
    pub(super) to_last: Mat<f64>,
    /// `x, x', x''` at the last end.
    pub(super) last: State,
}

/// What a leg of a given start takes.
pub(super) enum Found {
    Leg(LinearLeg),
    /// A shorter one.
    TooLong,
}

impl LinearLeg {
    /// Of the curve with `x, x', x''` at the first end, in the time in which the leg takes one.
    pub(super) fn from_start(
        space: impl Homogeneous,
        first: &State,
        tension: Option<f64>,
    ) -> Found {
        let d = space.dim();
        // To the middle by the series about the first end.
        let Some((series, order)) = resolved(space, first, tension) else {
            return Found::TooLong;
        };
        let mut middle: State = std::array::from_fn(|_| vec![0.0; d]);
        let mut before = vec![0.0; d];
        for (derivative, x) in middle.iter_mut().enumerate() {
            series.at_ends(d, order + 3, derivative, [&mut before, x]);
        }
        match resolved(space, &middle, tension) {
            Some((series, order)) => {
                let order = (order + MORE).min(MOST);
                Found::Leg(Self::about(space, series, &middle, tension, order))
            }
            None => Found::TooLong,
        }
    }

    /// From the series of the curve, by so many terms.
    fn about(
        space: impl Homogeneous,
        mut series: Series<f64>,
        middle: &State,
        tension: Option<f64>,
        order: usize,
    ) -> Self {
        let (d, h, r) = (space.dim(), space.isotropy_dim(), space.size());
        let views = middle.each_ref().map(Vec::as_slice);
        series.set_curve(space, views, tension, order);
        series.set_frames(space, order + 3);
        let integral = Antiderivative::of(order / 2 + 6);
        let nodes: Vec<Node> = integral.nodes.iter().map(|s| (s - 0.5, 0.0)).collect();
        let mut variation = Variation::<3, f64>::with_nodes(space, order, Cow::Owned(nodes));
        variation.set_changes(space, &series, tension, order);
        let frames = series.frames[..(order + 4) * r * r].to_vec();
        let rates = rates(space, &frames, &integral, &variation);
        let mut states: [State; 2] = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; d]));
        let [first, last] = &mut states;
        for (derivative, (first, last)) in first.iter_mut().zip(last).enumerate() {
            series.at_ends(d, order + 3, derivative, [first, last]);
        }
        let mut leg = LinearLeg {
            frames,
            integral,
            rates,
            from_first: Mat::new(),
            to_last: Mat::new(),
            last: Default::default(),
        };
        let map = |end: usize| {
            let mut eta = vec![0.0; (d + h) * 4 * d];
            leg.turn_at(space, [-0.5, 0.5][end], &mut eta);
            let changes = variation.ends.each_ref().map(|ends| ends[end].as_slice());
            by_middle(space, &eta, &states[end], changes)
        };
        let [to_first, to_last] = [map(0), map(1)];
        let tau = tension.unwrap_or_default();
        leg.from_first = inverse(space, &to_first, [middle, &states[0]], tau);
        leg.to_last = to_last;
        let [_, last] = states;
        leg.last = last;
        leg
    }

    /// `g^{-1} dg` at a time by `(p, w, a, b)` in the middle, shape `(d + h, 4 d)`.
    fn turn_at(&self, space: impl Homogeneous, s: f64, out: &mut [f64]) {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let wide = 4 * d;
        let weights = self.integral.weights_at(s + 0.5);
        out.fill(0.0);
        for (weight, rates) in weights.iter().zip(self.rates.chunks_exact((d + h) * 3 * d)) {
            for (out, rates) in out.chunks_exact_mut(wide).zip(rates.chunks_exact(3 * d)) {
                for (out, rate) in out[d..].iter_mut().zip(rates) {
                    *out += weight * rate;
                }
            }
        }
        for p in 0..d {
            out[p * wide + p] = 1.0;
        }
        let frame = self.frame_at(space, s);
        let mut work = vec![0.0; 3 * space.size().pow(2)];
        let mut column = vec![0.0; d + h];
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

    /// The frame at a time relative to that in the middle, row by row.
    pub(super) fn frame_at(&self, space: impl Homogeneous, s: f64) -> Vec<f64> {
        let square = space.size().pow(2);
        let mut frame = vec![0.0; square];
        value_at(&self.frames, square, s, &mut frame);
        frame
    }

    /// The displacement at a time, for `(p, w, a, b)` in the middle.
    pub(super) fn displacement(&self, space: impl Homogeneous, s: f64, middle: &[f64]) -> Vec<f64> {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let (u, changes) = middle.split_at(d);
        let mut sum = vec![0.0; d + h];
        sum[..d].copy_from_slice(u);
        let weights = self.integral.weights_at(s + 0.5);
        for (weight, rates) in weights.iter().zip(self.rates.chunks_exact((d + h) * 3 * d)) {
            for (sum, rates) in sum.iter_mut().zip(rates.chunks_exact(3 * d)) {
                *sum += weight * dot(rates, changes);
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

    /// The gradient by `(p, w, a, b)` in the middle of the sum of products of cotangents, coordinates in the frames at their times,
    /// with the displacements there.
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

    /// How many numbers it is made of.
    pub(super) fn len(&self) -> usize {
        let maps = self.to_last.nrows().pow(2);
        self.frames.len() + self.rates.len() + 2 * maps
    }
}

/// The series of a curve about a time, and how many terms it needs at both ends of a leg; `None` where those are too many.
fn resolved(
    space: impl Homogeneous,
    state: &State,
    tension: Option<f64>,
) -> Option<(Series<f64>, usize)> {
    let orders = Orders::finest();
    let views = state.each_ref().map(Vec::as_slice);
    let speed = speed(state, tension);
    let mut reached = vec![0.0; space.size().pow(2)];
    let mut more = 0;
    let mut series = Series::new(space, MOST);
    loop {
        let order = orders.of_leg(speed, more);
        if order > LONGEST {
            return None;
        }
        series.set_curve(space, views, tension, order);
        series.reached_into(space, order, &mut reached);
        let next = orders.more(more, series.tail(space, order));
        if next == more {
            return Some((series, order));
        }
        more = next;
    }
}

/// As that of a leg.
fn speed(state: &State, tension: Option<f64>) -> f64 {
    let [v, a, b] = state.each_ref().map(|x| dot(x, x).sqrt());
    (v + 0.5 * a + 0.125 * b).max(tension.unwrap_or_default().sqrt())
}

/// `Ad_g dx` at the nodes.
fn rates(
    space: impl Homogeneous,
    frames: &[f64],
    integral: &Antiderivative,
    variation: &Variation<3, f64>,
) -> Vec<f64> {
    let (d, h, square) = (space.dim(), space.isotropy_dim(), space.size().pow(2));
    let count = (d + h) * 3 * d;
    let mut rates = vec![0.0; integral.nodes.len() * count];
    let (mut frame, mut adjoint) = (vec![0.0; square], vec![0.0; (d + h) * d]);
    let changes = variation.at_nodes.chunks_exact(3 * d * d);
    vectorised(
        #[inline(always)]
        || {
            for ((s, changes), rates) in integral
                .nodes
                .iter()
                .zip(changes)
                .zip(rates.chunks_exact_mut(count))
            {
                value_at(frames, square, s - 0.5, &mut frame);
                space.adjoint_into(&frame, &mut adjoint);
                accumulate(&adjoint, d, changes, 3 * d, rates);
            }
        },
    );
    rates
}

/// `(p, w, a, b)` at an end by those in the middle: from `g^{-1} dg` there, the state and its changes.
fn by_middle(
    space: impl Homogeneous,
    eta: &[f64],
    state: &State,
    changes: [&[f64]; 3],
) -> Mat<f64> {
    let d = space.dim();
    let wide = 4 * d;
    let mut map = vec![0.0; wide * wide];
    let (p, rest) = map.split_at_mut(d * wide);
    p.copy_from_slice(&eta[..d * wide]);
    let levels = rest.chunks_exact_mut(d * wide).zip(state).zip(changes);
    for ((rows, x), changes) in levels {
        for (row, change) in rows.chunks_exact_mut(wide).zip(changes.chunks_exact(3 * d)) {
            row[d..].copy_from_slice(change);
        }
        space.add_turning(x, eta, wide, rows);
    }
    Mat::from_fn(wide, wide, |i, j| map[i * wide + j])
}

/// The inverse of the map from the middle to an end, with the states at both.
fn inverse(
    space: impl Homogeneous,
    map: &Mat<f64>,
    [middle, end]: [&State; 2],
    tau: f64,
) -> Mat<f64> {
    let (d, wide) = (space.dim(), map.nrows());
    let [at_middle, at_end] = [middle, end].map(|state| displacement_form(space, state, tau));
    let by = |level: usize| map.subrows(level * d, d).transpose();
    let [p, w, a, b] = [0, 1, 2, 3].map(by);
    // The transpose times the form at the end, for columns p, w, a, b; then the inverse of the form in the middle.
    let by_displacement = p * at_end - b + w * Scale(tau);
    let right = |i: usize, j: usize| match j / d {
        0 => by_displacement[(i, j)],
        1 => a[(i, j - d)] - tau * p[(i, j - d)],
        2 => -w[(i, j - 2 * d)],
        _ => p[(i, j - 3 * d)],
    };
    let mut out = Mat::from_fn(wide, wide, |i, j| match i / d {
        0 => -right(i + 3 * d, j),
        1 => right(i + d, j),
        2 => -tau * right(i + d, j) - right(i - d, j),
        _ => right(i - 3 * d, j) + tau * right(i - d, j),
    });
    let turned = at_middle * out.subrows(0, d);
    let mut last = out.subrows_mut(3 * d, d);
    last -= turned;
    out
}

/// The part of `omega` of two displacements: by a displacement `p`, `[p, x'' - tau x]_m - [p, [x, x']_h]`.
fn displacement_form(space: impl Homogeneous, [x, a, b]: &State, tau: f64) -> Mat<f64> {
    let (d, h, square) = (space.dim(), space.isotropy_dim(), space.size().pow(2));
    let mut matrices = vec![0.0; 3 * square];
    let (x_matrix, rest) = matrices.split_at_mut(square);
    let (other, unit) = rest.split_at_mut(square);
    space.matrix_into(x, x_matrix);
    space.matrix_into(a, other);
    let mut turn = vec![0.0; h];
    space.add_isotropy_bracket(x_matrix, other, -1.0, &mut turn);
    let pull: Vec<f64> = b.iter().zip(x).map(|(b, x)| b - tau * x).collect();
    space.matrix_into(&pull, other);
    let (mut e, mut column, mut form) = (vec![0.0; d], vec![0.0; d], Mat::zeros(d, d));
    for j in 0..d {
        e[j] = 1.0;
        space.matrix_into(&e, unit);
        e[j] = 0.0;
        column.fill(0.0);
        space.add_bracket(unit, other, 1.0, &mut column);
        if h > 0 {
            space.subtract_action(&turn, unit, &mut column);
        }
        for (i, entry) in column.iter().enumerate() {
            form[(i, j)] = *entry;
        }
    }
    form
}

/// Which of `Ad_g` and its inverse.
#[derive(Clone, Copy)]
enum Way {
    Forth,
    Back,
}

/// `v <- Ad_g v` or `Ad_g^{-1} v`, coordinates of `m` before those of `h`; `work` has room for three matrices.
fn conjugate(space: impl Homogeneous, g: &[f64], way: Way, v: &mut [f64], work: &mut [f64]) {
    let (d, r) = (space.dim(), space.size());
    let (x, rest) = work.split_at_mut(r * r);
    let (product, other) = rest.split_at_mut(r * r);
    let other = &mut other[..r * r];
    space.matrix_into(v, x);
    if space.isotropy_dim() > 0 {
        space.isotropy_matrix_into(&v[d..], other);
        add(x, 1.0, other);
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
    space.each_entry(|p, i, j| v[p] = space.skew_coordinate(other, [i, j]));
    space.each_isotropy_entry(|p, i, j| v[d + p] = space.skew_coordinate(other, [i, j]));
}

fn add(sum: &mut [f64], factor: f64, other: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(other) {
        *sum += factor * x;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
