//! The linearised equation of a cubic, and how changes of its vector displace the points after them, at Gauss nodes.
//!
//! Along a family of curves `g' = g x`, let `w, a, b` be the changes of `x, x', x''`. They satisfy `w' = a`, `a' = b` and
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
//! Its part in `m` displaces the point, and its part in `h` turns the velocity by `[zeta_h, x]`. In a row outside the span of
//! the curve, where the curve is zero, `w, a, b` are rows of length `k` and `zeta` is one of length `r`,
//!
//! ```math
//! b' = b\,\omega + w\,({b_x'}^T b_x - \omega'') + a\,(\tau - b_x^T b_x),\qquad
//! \zeta(s) = \Bigl( u + \int_0^s (w, 0)\, g^T \Bigr) g(s)
//! ```
//!
//! with the blocks `omega` and `b_x` of `x`; for subspaces with `w (2 b_x'^T b_x - b_x^T b_x')` instead.
//!
//! # Source
//! Derived here, by differentiating `g' = g x` and the equation of cubics in the frame of the curve.

use std::borrow::Borrow;

use crate::collocation::along::Along;
use crate::linalg::field::multiply_rows;
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::space::{Homogeneous, Quotient, Shape, in_space};

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

    /// The displacement of the end, to whose velocity its change is added.
    fn arrive(&self, z: &[f64], velocity: &mut [f64]) -> Vec<f64>;

    /// The transpose of `arrive`.
    fn arrive_transposed(&self, point: &[f64], velocity: &[f64]) -> Vec<f64>;
}

/// A curve at Gauss nodes: the number of nodes is a multiple of eight.
#[derive(Clone, Copy)]
pub(crate) struct CurveAtNodes<'a> {
    /// The vectors `x, x', x''`, one node after another.
    pub(crate) x: [&'a [f64]; 3],
    /// `x` at the end.
    pub(crate) last: &'a [f64],
    /// Frames at the nodes relative to the one at the end, and at last the one at the start, shape `(r, r)` by rows.
    pub(crate) frames: &'a [f64],
}

/// The terms for variations in the span, from coordinates of vectors.
pub(crate) fn in_span(shape: Shape, curve: CurveAtNodes<'_>) -> Box<dyn Terms> {
    in_space!(shape, |space| Box::new(InSpan::of_curve(space, curve)))
}

/// The terms in the span of the curve.
pub(crate) struct InSpan<S, A> {
    space: S,
    groups: A,
    /// The frames of [`CurveAtNodes`].
    frames: Vec<Lanes>,
    /// The skew matrix of `x` at the end.
    last: Vec<f64>,
}

impl<S: Homogeneous> InSpan<S, Vec<Along>> {
    fn of_curve(space: S, curve: CurveAtNodes<'_>) -> Self {
        let (d, square) = (space.dim(), space.size().pow(2));
        let group = |group: usize| {
            let vectors = curve.x.map(|x| in_lanes(&x[group * LANES * d..], d));
            let mut along = Along::new(space);
            along.set(space, vectors.each_ref().map(Vec::as_slice));
            along
        };
        let groups = (0..curve.x[0].len() / (d * LANES)).map(group).collect();
        InSpan::new(
            space,
            groups,
            frames_in_lanes(curve.frames, square),
            curve.last,
        )
    }
}

impl<S: Homogeneous, A: Borrow<[Along]> + Send + Sync> InSpan<S, A> {
    /// From the curve at groups of nodes, frames as [`CurveAtNodes`] has them, and coordinates of `x` at the end.
    pub(crate) fn new(space: S, groups: A, frames: Vec<Lanes>, last: &[f64]) -> Self {
        let mut matrix = vec![0.0; space.size().pow(2)];
        space.matrix_into(last, &mut matrix);
        InSpan {
            space,
            groups,
            frames,
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

    /// `Ad_g w` is twice the skew part of `g y g^T`, for the part `y` of `w` below the diagonal; the sum is of `g y g^T`.
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
        let columns = columns(space);
        let (back, rest) = buffer.split_at_mut(r * r);
        let (turned, found) = rest.split_at_mut(r * columns);
        let found = &mut found[..r * columns];
        vectorised(
            #[inline(always)]
            || {
                for (i, entry) in back.iter_mut().enumerate() {
                    *entry = frame[i % r * r + i / r];
                }
                // The first columns of `z g`, as rows, and of `g^T z g`.
                multiply_rows(&back[..r * columns], z, r, |_| r, turned);
                multiply_rows(back, turned, r, |_| r, found);
                space.each_entry(
                    #[inline(always)]
                    |p, i, j| out[p] += found[i * columns + j] * weight * space.scale(i, j),
                );
            },
        );
    }

    fn arrive(&self, z: &[f64], velocity: &mut [f64]) -> Vec<f64> {
        let space = self.space;
        let mut point = vec![0.0; space.dim()];
        space.each_entry(|p, i, j| point[p] = space.skew_coordinate(z, [i, j]));
        if space.isotropy_dim() > 0 {
            let mut back = vec![0.0; space.isotropy_dim()];
            space.each_isotropy_entry(|p, i, j| back[p] = -space.skew_coordinate(z, [i, j]));
            space.subtract_action(&back, &self.last, velocity);
        }
        point
    }

    /// `<[z, x], v> = <z, [x, v]>`.
    fn arrive_transposed(&self, point: &[f64], velocity: &[f64]) -> Vec<f64> {
        let (space, square) = (self.space, self.space.size().pow(2));
        let (mut z, mut other) = (vec![0.0; square], vec![0.0; square]);
        space.matrix_into(point, &mut z);
        if space.isotropy_dim() > 0 {
            let mut turning = vec![0.0; space.isotropy_dim()];
            space.matrix_into(velocity, &mut other);
            space.add_isotropy_bracket(&self.last, &other, 1.0, &mut turning);
            space.isotropy_matrix_into(&turning, &mut other);
            for (z, other) in z.iter_mut().zip(&other) {
                *z += other;
            }
        }
        z
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

/// The terms in a row outside the span.
struct InRow {
    k: usize,
    /// For eight nodes each, the matrices that multiply `w, a, b` from the right, shape `(k, k)`.
    groups: Vec<[Vec<Lanes>; 3]>,
    /// The frames of [`CurveAtNodes`].
    frames: Vec<Lanes>,
    /// The lower block of `x` at the end, shape `(r - k, k)` in column-major order.
    last: Vec<f64>,
}

/// The terms for a row outside the span, from the blocks of vectors: `omega`, then `b`, in column-major order; `r` rows in
/// total.
pub(crate) fn in_row(shape: Shape, curve: CurveAtNodes<'_>) -> Box<dyn Terms> {
    let Shape { r, k, kind } = shape;
    let size = r * k;
    let node = |node: usize| {
        let [x, x1, x2] = curve.x.map(|x| &x[node * size..][..size]);
        let omega = |x: &[f64], i: usize, j: usize| x[i + k * j];
        let product = |x: &[f64], y: &[f64], i: usize, j: usize| -> f64 {
            let [x, y] = [(x, i), (y, j)].map(|(x, i)| &x[k * k + (r - k) * i..][..r - k]);
            x.iter().zip(y).map(|(x, y)| x * y).sum()
        };
        let turned = f64::from(u8::from(kind.quotient == Quotient::Subspaces));
        let entry = |level: usize, i: usize, j: usize| match level {
            0 => {
                let turning = product(x1, x, i, j) - product(x, x1, i, j);
                product(x1, x, i, j) - omega(x2, i, j) + turned * turning
            }
            1 => -product(x, x, i, j),
            _ => omega(x, i, j),
        };
        let matrix = |level: usize| -> Vec<f64> {
            let entries = (0..k * k).map(|at| entry(level, at / k, at % k));
            entries.collect()
        };
        std::array::from_fn::<_, 3, _>(matrix)
    };
    let nodes: Vec<[Vec<f64>; 3]> = (0..curve.x[0].len() / size).map(node).collect();
    let group = |nodes: &[[Vec<f64>; 3]]| {
        std::array::from_fn(|level| {
            let entry = |at: usize| Lanes(std::array::from_fn(|lane| nodes[lane][level][at]));
            (0..k * k).map(entry).collect()
        })
    };
    Box::new(InRow {
        k,
        groups: nodes.chunks_exact(LANES).map(group).collect(),
        frames: frames_in_lanes(curve.frames, r * r),
        last: curve.last[k * k..].to_vec(),
    })
}

impl InRow {
    fn r(&self) -> usize {
        self.k + self.last.len() / self.k
    }

    fn frame(&self, group: usize) -> &[Lanes] {
        let square = self.r().pow(2);
        &self.frames[group * square..][..square]
    }
}

impl Terms for InRow {
    fn dim(&self) -> usize {
        self.k
    }

    fn transported(&self) -> usize {
        self.r()
    }

    fn buffer(&self) -> usize {
        0
    }

    fn add_change(&self, group: usize, x: [&[Lanes]; 3], _: &mut [Lanes], out: &mut [Lanes]) {
        for (matrix, x) in self.groups[group].iter().zip(x) {
            for (x, row) in x.iter().zip(matrix.chunks_exact(self.k)) {
                for (entry, out) in row.iter().zip(&mut *out) {
                    *out += *x * *entry;
                }
            }
        }
    }

    fn add_change_transposed(
        &self,
        group: usize,
        f: &[Lanes],
        _: &mut [Lanes],
        out: [&mut [Lanes]; 3],
    ) {
        for (matrix, out) in self.groups[group].iter().zip(out) {
            for (out, row) in out.iter_mut().zip(matrix.chunks_exact(self.k)) {
                for (entry, f) in row.iter().zip(f) {
                    *out += *f * *entry;
                }
            }
        }
    }

    fn add_transported(
        &self,
        group: usize,
        (weight, w): (Lanes, &[Lanes]),
        _: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        let rows = self.frame(group).chunks_exact(self.r());
        for (out, row) in out.iter_mut().zip(rows) {
            for (x, entry) in w.iter().zip(row) {
                *out += *x * weight * *entry;
            }
        }
    }

    fn complete(&self, _: &mut [Lanes]) {}

    fn add_projected(
        &self,
        group: usize,
        (weight, z): (Lanes, &[Lanes]),
        _: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        let rows = self.frame(group).chunks_exact(self.r());
        for (z, row) in z.iter().zip(rows) {
            for (out, entry) in out.iter_mut().zip(row) {
                *out += *z * weight * *entry;
            }
        }
    }

    fn arrive(&self, z: &[f64], velocity: &mut [f64]) -> Vec<f64> {
        let (point, turning) = z.split_at(self.k);
        let columns = self.last.chunks_exact(turning.len().max(1));
        for (velocity, column) in velocity.iter_mut().zip(columns) {
            *velocity += turning.iter().zip(column).map(|(z, x)| z * x).sum::<f64>();
        }
        point.to_vec()
    }

    fn arrive_transposed(&self, point: &[f64], velocity: &[f64]) -> Vec<f64> {
        let m = self.r() - self.k;
        let turning = (0..m).map(|i| {
            let entries = velocity.iter().zip(self.last[i..].iter().step_by(m));
            entries.map(|(v, x)| v * x).sum()
        });
        point.iter().copied().chain(turning).collect()
    }
}

/// The first eight vectors with `d` entries each.
fn in_lanes(numbers: &[f64], d: usize) -> Vec<Lanes> {
    let entry = |p: usize| Lanes(std::array::from_fn(|lane| numbers[lane * d + p]));
    (0..d).map(entry).collect()
}

/// Frames in groups of eight, the last one by itself.
fn frames_in_lanes(frames: &[f64], square: usize) -> Vec<Lanes> {
    let (nodes, start) = frames.split_at(frames.len() - square);
    let groups = nodes.chunks_exact(LANES * square);
    let nodes = groups.flat_map(|group| in_lanes(group, square));
    nodes
        .chain(start.iter().map(|x| Lanes::splat(*x)))
        .collect()
}
