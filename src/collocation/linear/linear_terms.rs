//! The linearised equation of a cubic, and how changes of its vector displace the points after them, at Gauss nodes.
//!
//! Along a family of curves `g' = g x`, let `w, a, b` be the changes of `x, x', x''`. They satisfy `w' = a`, `a' = b`
//! and
//!
//! ```math
//! b' = [b, x]_m + [x'', w]_m - [[w, x']_h + [x, a]_h, x] - [[x, x']_h, w] + \tau a
//! ```
//!
//! and with `u` in `m` for the displacement of the start, the change of `g` is
//!
//! ```math
//! \zeta(s) = g^{-1} \delta g = \operatorname{Ad}_{g(s)^{-1}} \Bigl( u + \int_0^s \operatorname{Ad}_{g} w \Bigr)
//! ```
//!
//! Its part in `m` displaces the point, and its part in `h` turns the velocity by `[zeta_h, x]`. Rows outside of the
//! span of the curve are in [`linear_row`](super::linear_row).
//!
//! # Source
//! Derived here, by differentiating `g' = g x` and the equation of cubics in the frame of the curve.

use std::borrow::Borrow;

use crate::collocation::along::Along;
use crate::collocation::lane_matrices::add_product;
use crate::linalg::field::{accumulate, multiply_rows};
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::space::{Homogeneous, Shape, in_space};

/// The linear maps at groups of eight nodes, and their transposes with respect to coordinates of `m` and the metric.
///
/// What moves the points is transported to the frame at the end, and is there an element of the algebra or a row. The
/// group after the last one stands for the start.
pub(crate) trait Terms: Send + Sync {
    /// Number of coordinates of a vector of `m`.
    fn dim(&self) -> usize;

    /// Number of entries of what is transported.
    fn transported(&self) -> usize;

    /// Number of eights of numbers that the maps need as a buffer.
    fn buffer(&self) -> usize;

    /// Adds the brackets in the change of `x'''` that `w, a, b` cause.
    fn add_change(&self, group: usize, x: [&[Lanes]; 3], buffer: &mut [Lanes], out: &mut [Lanes]);

    /// The transpose of `add_change`.
    fn add_change_transposed(
        &self,
        group: usize,
        f: &[Lanes],
        buffer: &mut [Lanes],
        out: [&mut [Lanes]; 3],
    );

    /// Adds a multiple of a vector, transported to the end; [`complete`](Terms::complete) follows the last one.
    fn add_transported(
        &self,
        group: usize,
        weighted: (Lanes, &[Lanes]),
        buffer: &mut [Lanes],
        out: &mut [Lanes],
    );

    /// Completes sums of transported vectors.
    fn complete(&self, sum: &mut [Lanes]);

    /// Adds a multiple of what is transported back from the end, and projected to `m`: the transpose of
    /// `add_transported` with `complete`.
    fn add_projected(
        &self,
        group: usize,
        weighted: (Lanes, &[Lanes]),
        buffer: &mut [Lanes],
        out: &mut [Lanes],
    );

    /// Sets the displacement of the end, and adds the turn of its velocity.
    fn arrive(&self, z: &[f64], point: &mut [f64], velocity: &mut [f64]);

    /// The transpose of `arrive`.
    fn arrive_transposed(&self, by_end: [&[f64]; 2], z: &mut [f64]);
}

/// A curve at Gauss nodes: the number of nodes is a multiple of eight.
#[derive(Clone, Copy)]
pub(crate) struct CurveAtNodes<'a> {
    /// The vectors `x, x', x''`, one node after another.
    pub(crate) x: [&'a [f64]; 3],
    /// `x` at the end.
    pub(crate) last: &'a [f64],
    /// Frames at the nodes and at the end, relative to the one at the start, shape `(r, r)` by rows.
    pub(crate) frames: &'a [f64],
    pub(crate) end: &'a [f64],
}

/// The terms for variations in the span, from coordinates of vectors.
pub(crate) fn in_span(shape: Shape, curve: CurveAtNodes<'_>) -> Box<dyn Terms> {
    in_space!(shape, |space| Box::new(InSpan::of_curve(space, curve)))
}

/// The terms in the span of the curve.
pub(crate) struct InSpan<S, A> {
    space: S,
    groups: A,
    /// Frames relative to the one at the end, as [`relative`] returns them.
    frames: Vec<Lanes>,
    /// The skew matrix of the velocity at the end that `h` turns: of `x` there, in Newton's method of the required one.
    last: Vec<f64>,
}

impl<S: Homogeneous> InSpan<S, Vec<Along>> {
    fn of_curve(space: S, curve: CurveAtNodes<'_>) -> Self {
        let (d, square) = (space.dim(), space.size().pow(2));
        let group = |group: usize| {
            let vectors = curve.x.map(|x| first_eight(&x[group * LANES * d..], d));
            let mut along = Along::new(space);
            along.set(space, vectors.each_ref().map(Vec::as_slice));
            along
        };
        let groups = (0..curve.x[0].len() / (d * LANES)).map(group).collect();
        let frames = groups_of_frames(curve.frames, square);
        InSpan::new(space, groups, (&frames, curve.end), curve.last)
    }
}

impl<S: Homogeneous, A: Borrow<[Along]> + Send + Sync> InSpan<S, A> {
    /// From the curve at groups of nodes, frames there and at the end, and coordinates of the velocity at the end.
    pub(crate) fn new(
        space: S,
        groups: A,
        (frames, end): (&[Lanes], &[f64]),
        last: &[f64],
    ) -> Self {
        let mut matrix = vec![0.0; space.size().pow(2)];
        space.matrix_into(last, &mut matrix);
        InSpan {
            space,
            groups,
            frames: relative(frames, end, space.size()),
            last: matrix,
        }
    }

    fn frame(&self, group: usize) -> &[Lanes] {
        let square = self.space.size().pow(2);
        &self.frames[group * square..][..square]
    }
}

impl<S: Homogeneous, A: Borrow<[Along]> + Send + Sync> Terms for InSpan<S, A> {
    fn dim(&self) -> usize {
        self.space.dim()
    }

    fn transported(&self) -> usize {
        self.space.size().pow(2)
    }

    fn buffer(&self) -> usize {
        4 * self.space.size().pow(2) + self.space.isotropy_dim()
    }

    fn add_change(&self, group: usize, x: [&[Lanes]; 3], buffer: &mut [Lanes], out: &mut [Lanes]) {
        let (space, square) = (self.space, self.space.size().pow(2));
        vectorised(
            #[inline(always)]
            || {
                let (matrices, z) = buffer.split_at_mut(3 * square);
                for (matrix, x) in matrices.chunks_exact_mut(square).zip(x) {
                    space.matrix_into(x, matrix);
                }
                let z = &mut z[..space.isotropy_dim()];
                let x = std::array::from_fn(|level| &matrices[level * square..][..square]);
                self.groups.borrow()[group].add_change(space, x, z, out);
            },
        );
    }

    fn add_change_transposed(
        &self,
        group: usize,
        f: &[Lanes],
        buffer: &mut [Lanes],
        out: [&mut [Lanes]; 3],
    ) {
        let space = self.space;
        vectorised(
            #[inline(always)]
            || {
                let (matrix, z) = buffer.split_at_mut(space.size().pow(2));
                space.matrix_into(f, matrix);
                let z = &mut z[..space.isotropy_dim()];
                self.groups.borrow()[group].add_change_transposed(space, matrix, z, out);
            },
        );
    }

    /// `Ad_g w` is twice the skew part of `g y g^T`, for the part `y` of `w` below the diagonal; the sum is of `g y
    /// g^T`.
    fn add_transported(
        &self,
        group: usize,
        (weight, w): (Lanes, &[Lanes]),
        buffer: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        let (space, r, frame) = (self.space, self.space.size(), self.frame(group));
        let columns = columns(space);
        let (y, rest) = buffer.split_at_mut(r * columns);
        let turned = &mut rest[..r * columns];
        vectorised(
            #[inline(always)]
            || {
                y.fill(Lanes::ZERO);
                write_below(space, w, weight, y);
                multiply_rows(frame, y, r, |_| r, turned);
                for (turned, out) in turned.chunks_exact(columns).zip(out.chunks_exact_mut(r)) {
                    for (frame, out) in frame.chunks_exact(r).zip(out) {
                        let mut sum = *out;
                        for (x, y) in turned.iter().zip(frame) {
                            sum += *x * *y;
                        }
                        *out = sum;
                    }
                }
            },
        );
    }

    fn complete(&self, sum: &mut [Lanes]) {
        let r = self.space.size();
        for i in 0..r {
            sum[i * r + i] = Lanes::ZERO;
            for j in 0..i {
                let entry = sum[i * r + j] - sum[j * r + i];
                sum[i * r + j] = entry;
                sum[j * r + i] = -entry;
            }
        }
    }

    fn add_projected(
        &self,
        group: usize,
        (weight, z): (Lanes, &[Lanes]),
        buffer: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        let (space, r, frame) = (self.space, self.space.size(), self.frame(group));
        let size = r * columns(space);
        let (head, rest) = buffer.split_at_mut(size);
        let (turned, rest) = rest.split_at_mut(size);
        let found = &mut rest[..size];
        vectorised(
            #[inline(always)]
            || {
                for (j, column) in head.chunks_exact_mut(r).enumerate() {
                    for (entry, row) in column.iter_mut().zip(frame.chunks_exact(r)) {
                        *entry = row[j];
                    }
                }
                // The negative of the first columns of `z g`, as rows, and of `g^T z g`.
                turned.fill(Lanes::ZERO);
                accumulate(head, r, z, r, turned);
                found.fill(Lanes::ZERO);
                accumulate(turned, r, frame, r, found);
                space.each_entry(
                    #[inline(always)]
                    |p, i, j| out[p] -= found[j * r + i] * weight * space.scale(i, j),
                );
            },
        );
    }

    fn arrive(&self, z: &[f64], point: &mut [f64], velocity: &mut [f64]) {
        let space = self.space;
        space.each_entry(|p, i, j| point[p] = space.skew_coordinate(z, [i, j]));
        if space.isotropy_dim() > 0 {
            let mut back = vec![0.0; space.isotropy_dim()];
            space.each_isotropy_entry(|p, i, j| back[p] = -space.skew_coordinate(z, [i, j]));
            space.subtract_action(&back, &self.last, velocity);
        }
    }

    /// `<[z, x], v> = <z, [x, v]>`.
    fn arrive_transposed(&self, [point, velocity]: [&[f64]; 2], z: &mut [f64]) {
        let space = self.space;
        space.matrix_into(point, z);
        if space.isotropy_dim() > 0 {
            let (mut turning, mut other) = (vec![0.0; space.isotropy_dim()], vec![0.0; z.len()]);
            space.matrix_into(velocity, &mut other);
            space.add_isotropy_bracket(&self.last, &other, 1.0, &mut turning);
            space.isotropy_matrix_into(&turning, &mut other);
            for (z, other) in z.iter_mut().zip(&other) {
                *z += other;
            }
        }
    }
}

/// Number of columns of an element of `m` below the diagonal.
pub(crate) fn columns(space: impl Homogeneous) -> usize {
    space.row_len(space.size() - 1)
}

/// Writes the columns of a vector below the diagonal as rows, times a weight.
#[inline(always)]
fn write_below<S: Homogeneous>(space: S, w: &[Lanes], weight: Lanes, out: &mut [Lanes]) {
    let r = space.size();
    let mut write = |i: usize, j: usize, entry: Lanes| match i > j {
        true => out[j * r + i] = entry,
        false => out[i * r + j] = -entry,
    };
    space.each_entry(
        #[inline(always)]
        |p, i, j| {
            let entry = w[p] * weight * space.scale(i, j).recip();
            write(i, j, entry);
            if let Some(([i, j], sign)) = space.copy_of(i, j) {
                write(i, j, entry * sign);
            }
        },
    );
}

/// The first eight vectors with `d` entries each.
fn first_eight(numbers: &[f64], d: usize) -> Vec<Lanes> {
    let entry = |p: usize| Lanes(std::array::from_fn(|lane| numbers[lane * d + p]));
    (0..d).map(entry).collect()
}

/// Frames in groups of eight.
pub(super) fn groups_of_frames(frames: &[f64], square: usize) -> Vec<Lanes> {
    let groups = frames.chunks_exact(LANES * square);
    groups
        .flat_map(|group| first_eight(group, square))
        .collect()
}

/// Frames relative to the one at the end, in groups, followed by the frame at the start.
pub(super) fn relative(frames: &[Lanes], end: &[f64], r: usize) -> Vec<Lanes> {
    let entry = |at: usize| Lanes::splat(end[at % r * r + at / r]);
    let back: Vec<Lanes> = (0..r * r).map(entry).collect();
    let mut out = vec![Lanes::ZERO; frames.len()];
    for (frame, out) in frames.chunks_exact(r * r).zip(out.chunks_exact_mut(r * r)) {
        add_product(&back, frame, r, out);
    }
    out.extend(back);
    out
}
