//! Taylor series of a leg about its middle.

use std::ops::Range;

use super::brackets::{isotropy_bracket_into, minus_bracket_into, subtract_action};
use super::orders::MOST;
use super::rotation_series::{
    extend_matrices, extend_quaternions, is_of_rotations, rotation_reached_into, sum_of_brackets,
    write_rotation,
};
use crate::linalg::field::{Field, largest_each, set_identity, transposed_multiply};
use crate::space::{Homogeneous, RowProducts, SLACK, skew, write_row};

/// Coefficients of `x` and of the frame `g` in powers of `s`, the time from the middle of the leg.
///
/// With `w = [x, x']` the equation of cubics is `x''' = -(w_m)' - [w_h, x]`, and the coefficients of `w` are
///
/// ```math
/// w_s = \sum_{i < j,\ i + j = s + 1} (j - i)\, [x_i, x_j]
/// ```
#[derive(Clone)]
pub(crate) struct LegSeries<T> {
    /// Coefficients of `x`: `order + 3` coordinate vectors, and the same as skew matrices.
    pub(crate) x: Vec<T>,
    pub(crate) matrices: Vec<T>,
    /// Coefficients of `w_h`, as skew matrices.
    pub(crate) isotropy: Vec<T>,
    /// Coefficients of the frame: matrices in row-major order. In three dimensions quaternions after
    /// [`LegSeries::set_turns`], and those of the rotation between opposite times after [`LegSeries::reached_into`].
    pub(crate) frames: Vec<T>,
    /// Buffer for a run of coordinates.
    run: Vec<T>,
}

/// Values of vectors or matrices at both ends of a leg.
pub(crate) type AtEnds<'a, T> = [&'a mut [T]; 2];

impl<T: Field> LegSeries<T> {
    /// Allocates series up to an order.
    pub(crate) fn new(space: impl Homogeneous, order: usize) -> Self {
        let (d, square) = (space.dim(), space.size() * space.size());
        let matrices = |count: usize| vec![T::ZERO; count * square + SLACK];
        LegSeries {
            x: vec![T::ZERO; (order + 3) * d],
            matrices: matrices(order + 3),
            isotropy: matrices(order),
            frames: matrices(order + 3),
            run: vec![T::ZERO; d.max(space.isotropy_dim())],
        }
    }

    /// Computes the coefficients of `x` up to an order, from `x, x', x''` at the middle and the tension of the curve.
    #[inline(always)]
    pub(crate) fn set_curve(
        &mut self,
        space: impl Homogeneous,
        middle: [&[T]; 3],
        tension: Option<T>,
        order: usize,
    ) {
        let d = space.dim();
        for (k, (x, factor)) in middle.into_iter().zip([1.0, 1.0, 0.5]).enumerate() {
            for p in 0..d {
                self.x[k * d + p] = x[p] * factor;
            }
            self.set_matrix(space, k);
        }
        self.extend_curve(space, tension, 0..order);
    }

    /// Computes the coefficients `k + 3` of `x` for `k` in `powers`, after all before them.
    ///
    /// Compiled once instead of into every caller, like [`LegSeries::extend_frames`].
    #[inline(never)]
    pub(crate) fn extend_curve(
        &mut self,
        space: impl Homogeneous,
        tension: Option<T>,
        powers: Range<usize>,
    ) {
        space.vectorised(
            #[inline(always)]
            || {
                for k in powers {
                    self.set_next(space, tension, k);
                    self.set_matrix(space, k + 3);
                }
            },
        );
    }

    /// Computes the coefficient `k + 3` of `x` from the power `k` of the equation.
    #[inline(always)]
    fn set_next(&mut self, space: impl Homogeneous, tension: Option<T>, k: usize) {
        let (d, square) = (space.dim(), space.size() * space.size());
        let (known, next) = self.x.split_at_mut((k + 3) * d);
        let next = &mut next[..d];
        let matrices = &self.matrices;
        match is_of_rotations(space) {
            true => {
                let product = skew(sum_of_brackets(matrices, k + 2));
                space.each_entry(
                    #[inline(always)]
                    |p, i, j| next[p] = -product[i * 3 + j],
                );
            }
            false => minus_bracket_into(space, bracket_pairs(matrices, square, k + 1), next),
        }
        for x in &mut *next {
            *x = *x * (k + 1) as f64;
        }
        if space.isotropy_dim() > 0 {
            let run = &mut self.run;
            isotropy_bracket_into(space, bracket_pairs(matrices, square, k), run);
            space.isotropy_matrix_into(run, &mut self.isotropy[k * square..]);
            let isotropy = &self.isotropy;
            let pairs = (0..=k).map(|i| (&matrices[(k - i) * square..], &isotropy[i * square..]));
            subtract_action(space, pairs, product, run, next);
        }
        if let Some(tension) = tension {
            for (next, x) in next.iter_mut().zip(&known[(k + 1) * d..]) {
                *next += tension * *x * (k + 1) as f64;
            }
        }
        let factor = 1.0 / ((k + 3) * (k + 2) * (k + 1)) as f64;
        for x in next {
            *x = *x * factor;
        }
    }

    /// Computes the coefficients of the frames up to a power, after those of `x`.
    #[inline(always)]
    pub(crate) fn set_frames(&mut self, space: impl Homogeneous, power: usize) {
        let r = space.size();
        set_identity(r, &mut self.frames[..r * r]);
        self.extend_frames(space, 0..power);
    }

    /// Computes the coefficients `k + 1` of the frames for `k` in `powers`, after all before them.
    #[inline(never)]
    fn extend_frames(&mut self, space: impl Homogeneous, powers: Range<usize>) {
        space.vectorised(
            #[inline(always)]
            || match space.size() {
                3 => extend_matrices(&self.matrices, &mut self.frames, powers),
                _ => self.set_frame_coefficients(space, powers),
            },
        );
    }

    #[inline(always)]
    fn set_frame_coefficients(&mut self, space: impl Homogeneous, powers: Range<usize>) {
        let r = space.size();
        let square = r * r;
        for k in powers {
            let (known, next) = self.frames.split_at_mut((k + 1) * square);
            let (known, matrices) = (&*known, &self.matrices);
            let pairs = (0..=k).map(|i| (&known[i * square..], &matrices[(k - i) * square..]));
            let factor = 1.0 / (k + 1) as f64;
            for row in 0..r {
                if copy_partner(space, row, next) {
                    continue;
                }
                let mut column = 0;
                while column < r {
                    // As many leading entries of a column of `x` as of a row may be nonzero.
                    let len = space.row_len(column);
                    let alike = (column..r).take_while(|c| space.row_len(*c) == len);
                    let count = alike.count();
                    let products = RowProducts {
                        r,
                        inner: 0..len,
                        row,
                        pairs: pairs.clone(),
                        multiply: product,
                    };
                    write_row(&products, column, &mut next[row * r + column..][..count]);
                    column += count;
                }
            }
            for entry in &mut next[..square] {
                *entry = *entry * factor;
            }
        }
    }

    /// The frame at the last end relative to the one at the first end, after the series of `x`; returns the contribution of
    /// the last two terms to the rate of rotation there.
    #[inline(always)]
    pub(crate) fn reached_into(
        &mut self,
        space: impl Homogeneous,
        order: usize,
        out: &mut [T],
    ) -> T {
        let r = space.size();
        if r == 3 {
            return rotation_reached_into(&self.matrices, order, &mut self.frames, out);
        }
        self.set_frames(space, order);
        let (mut first, mut last) = (vec![T::ZERO; r * r], vec![T::ZERO; r * r]);
        let frames = &self.frames[..(order + 1) * r * r];
        at_ends(frames, r * r, 0, [&mut first, &mut last]);
        transposed_multiply(r, &first, &last, out);
        self.frame_tail(r * r, order)
    }

    /// Computes the frames up to a power, after the series of `x`: unit quaternions in three dimensions, matrices
    /// otherwise.
    #[inline(always)]
    pub(crate) fn set_turns(&mut self, space: impl Homogeneous, power: usize) {
        if space.size() != 3 {
            return self.set_frames(space, power);
        }
        self.frames[0] = T::constant(1.0);
        self.frames[1..4].fill(T::ZERO);
        extend_quaternions(&self.matrices, &mut self.frames, 0..power);
    }

    /// Computes the coefficients `k + 1` of [`LegSeries::set_turns`] for `k` in `powers`, after all before them.
    #[inline(always)]
    pub(crate) fn extend_turns(&mut self, space: impl Homogeneous, powers: Range<usize>) {
        match space.size() {
            3 => extend_quaternions(&self.matrices, &mut self.frames, powers),
            _ => self.extend_frames(space, powers),
        }
    }

    /// A coefficient of `x` as a skew matrix.
    #[inline(always)]
    fn set_matrix(&mut self, space: impl Homogeneous, k: usize) {
        let (d, square) = (space.dim(), space.size() * space.size());
        let matrix = &mut self.matrices[k * square..][..square];
        space.matrix_into(&self.x[k * d..], matrix);
    }

    /// `x` or one of its derivatives at both ends, from `count` coefficients.
    #[inline(always)]
    pub(crate) fn at_ends(&self, d: usize, count: usize, derivative: usize, out: AtEnds<'_, T>) {
        at_ends(&self.x[..count * d], d, derivative, out);
    }

    /// The largest contribution of the last two terms to `x'` and to the frame's derivative at the ends, after
    /// [`LegSeries::set_turns`].
    #[inline(always)]
    pub(crate) fn tail(&self, space: impl Homogeneous, order: usize) -> T {
        let frame = self.frame_tail(turn_size(space), order);
        self.curve_tail(space, order).larger(frame)
    }

    /// The largest contribution of the last two terms to `x'` at the ends.
    #[inline(always)]
    pub(crate) fn curve_tail(&self, space: impl Homogeneous, order: usize) -> T {
        let d = space.dim();
        let weight = 0.5_f64.powi(order as i32 + 1) * (order + 2) as f64;
        largest_each(&self.x[(order + 1) * d..][..2 * d]) * weight
    }

    /// The same for the frame's derivative, for coefficients of the given size.
    #[inline(always)]
    fn frame_tail(&self, size: usize, order: usize) -> T {
        let weight = 2.0 * 0.5_f64.powi(order as i32) * order as f64;
        largest_each(&self.frames[(order - 1) * size..][..2 * size]) * weight
    }
}

/// Number of entries of a coefficient computed by [`LegSeries::set_turns`].
#[inline(always)]
pub(crate) fn turn_size(space: impl Homogeneous) -> usize {
    match space.size() {
        3 => 4,
        r => r * r,
    }
}

/// The frame at a time, from the coefficients of [`LegSeries::set_turns`].
#[inline(always)]
pub(crate) fn turn_into<T: Field>(
    space: impl Homogeneous,
    coefficients: &[T],
    s: f64,
    out: &mut [T],
) {
    if space.size() != 3 {
        return value_at(coefficients, turn_size(space), s, out);
    }
    let mut quaternion = [T::ZERO; 4];
    value_at(coefficients, 4, s, &mut quaternion);
    write_rotation(quaternion, out);
}

/// The value of polynomials with the given coefficients, vectors of the given size.
#[inline(always)]
pub(crate) fn value_at<T: Field>(coefficients: &[T], size: usize, s: f64, out: &mut [T]) {
    out[..size].fill(T::ZERO);
    let mut power = 1.0;
    for c in coefficients.chunks_exact(size) {
        for (out, c) in out.iter_mut().zip(c) {
            *out += *c * power;
        }
        power *= s;
    }
}

/// The values at `-s` and `s` of polynomials with the given coefficients, vectors of the given size.
#[inline(always)]
pub(crate) fn at_opposite_times<T: Field>(
    coefficients: &[T],
    size: usize,
    s: f64,
    [before, after]: AtEnds<'_, T>,
) {
    let pairs = coefficients.chunks_exact(2 * size);
    let rest = pairs.remainder();
    for p in 0..size {
        let (mut even, mut odd, mut power) = (T::ZERO, T::ZERO, 1.0);
        for c in pairs.clone() {
            even += c[p] * power;
            odd += c[size + p] * (power * s);
            power *= s * s;
        }
        if let Some(c) = rest.get(p) {
            even += *c * power;
        }
        (before[p], after[p]) = (even - odd, even + odd);
    }
}

/// Copies a row of an element of the group from the partner before it; `false` if there is none.
#[inline(always)]
fn copy_partner<T: Field>(space: impl Homogeneous, row: usize, matrix: &mut [T]) -> bool {
    let r = space.size();
    let Some((before, sign)) = space.partner(row).filter(|(partner, _)| *partner < row) else {
        return false;
    };
    let (known, rest) = matrix.split_at_mut(row * r);
    let known = &known[before * r..][..r];
    for (j, entry) in rest[..r].iter_mut().enumerate() {
        if let Some((column, other)) = space.partner(j) {
            *entry = known[column] * (sign * other);
        }
    }
    true
}

/// The pairs of `w_s`, with their weights.
#[inline(always)]
fn bracket_pairs<T>(
    x: &[T],
    square: usize,
    s: usize,
) -> impl Iterator<Item = (f64, &[T], &[T])> + Clone {
    let sum = s + 1;
    (0..sum.div_ceil(2)).map(move |i| {
        let j = sum - i;
        ((j - i) as f64, &x[i * square..], &x[j * square..])
    })
}

/// A function instead of a closure, so that it is inlined at every call.
#[inline(always)]
fn product<T: Field>(a: T, b: T) -> T {
    b * a
}

/// The value or a derivative at `s = -1/2` and `1/2` of polynomials with the given coefficients, vectors of the given
/// size.
#[inline(always)]
pub(crate) fn at_ends<T: Field>(
    coefficients: &[T],
    size: usize,
    derivative: usize,
    [first, last]: AtEnds<'_, T>,
) {
    let pairs = coefficients[derivative * size..].chunks_exact(2 * size);
    let rest = pairs.remainder();
    let (weights, after) = AT_HALF[derivative].split_at(pairs.len());
    for p in 0..size {
        let (mut even, mut odd) = (T::ZERO, T::ZERO);
        for (c, [w, v]) in pairs.clone().zip(weights) {
            even += c[p] * *w;
            odd += c[size + p] * *v;
        }
        if let Some(c) = rest.get(p) {
            even += *c * after[0][0];
        }
        (first[p], last[p]) = (even - odd, even + odd);
    }
}

/// The derivatives of order up to two of the powers of `s` from the order on, at `s = 1/2`, in pairs.
static AT_HALF: [[[f64; 2]; MOST_PAIRS]; 3] = [at_half(0), at_half(1), at_half(2)];

/// At least half of the largest number of coefficients of a series.
const MOST_PAIRS: usize = MOST / 2 + 8;

const fn at_half(derivative: usize) -> [[f64; 2]; MOST_PAIRS] {
    let mut weights = [[0.0; 2]; MOST_PAIRS];
    let (mut power, mut value) = (0, 1.0);
    while power < 2 * MOST_PAIRS {
        let (mut weight, mut i) = (value, 1);
        while i <= derivative {
            weight *= (power + i) as f64;
            i += 1;
        }
        weights[power / 2][power % 2] = weight;
        (power, value) = (power + 1, 0.5 * value);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{FixedFrames, RealSpace};

    /// The special case is the general sum without its zeros, bit by bit.
    #[test]
    fn frames_of_rotations_are_those_of_all_matrices() {
        fn compare(space: impl Homogeneous) {
            let d = space.dim();
            let middle = [1.0, 2.3, 5.7].map(|seed: f64| {
                let entries = (0..d).map(|p| (seed + 1.9 * p as f64).sin());
                entries.collect::<Vec<f64>>()
            });
            let mut series = LegSeries::new(space, 12);
            let middle = middle.each_ref().map(Vec::as_slice);
            series.set_curve(space, middle, None, 12);
            series.set_frames(space, 14);
            let found = series.frames.clone();
            series.set_frame_coefficients(space, 0..14);
            assert_eq!(found, series.frames);
        }
        compare(FixedFrames::<3, 2>);
        compare(FixedFrames::<3, 1>);
        compare(RealSpace::subspaces(3, 1));
    }
}
