//! A linearised cubic: variations in terms of those of points and velocities at its ends, forward and transposed.
//!
//! A variation of the ends is described by displacements `u` and by the rest of the velocities' variation, relative to
//! the rotations that cause the displacements: `dV = A(u) V + w`. All are tangent vectors, shape `(n, k)`, by columns. In the
//! span of the curve they satisfy one linear system, and every row outside it satisfies another one, of `4k` equations.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::linear_layout::LinearLayout;
use super::linear_start::LinearStart;
use crate::cubic::taylor::blocks::{BlockSizes, Sizes};
use crate::cubic::taylor::packing::{pack_gradient, read_vector, write_vector};
use crate::curve::barycentric::Barycentric;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::{accumulate, add};
use crate::linalg::lanes::LANES;
use crate::linalg::product::{columns, columns_mut, entries, mul_add, mul_into};
use crate::shooting::{CurvePart, LinearCurve, linearise, linearise_all};
use crate::threads;

/// Microseconds of up to eight cubics of rotations; 940 on St(4,2).
const GROUP: f64 = 100.0;

/// Displacement and change of the velocity, at the start and at the end.
pub(crate) type PieceVariation = [Vec<f64>; 4];

/// A cubic on `[0, 1]`, linearised.
#[derive(Debug)]
pub(crate) struct LinearPiece {
    pub(crate) n: usize,
    pub(crate) blocks: Sizes,
    tension: f64,
    /// The frames at both ends, shape `(n, r)` by columns, whose columns span the curve.
    frames: [Vec<f64>; 2],
    pub(crate) inside: PieceResponse,
    /// The response in a row outside the span; `None` if the span is all of `R^n`.
    pub(crate) outside: Option<PieceResponse>,
    parts: Vec<PointsOfPart>,
}

/// The response to `(u_0, w_0, u_1, w_1)`, each of a number of coordinates, in row-major order.
#[derive(Debug)]
pub(crate) struct PieceResponse {
    /// The second derivative of half the cost.
    pub(crate) stiffness: Vec<f64>,
    /// Displacements at the points of every part.
    displacements: Vec<Vec<f64>>,
}

/// The points of a part of the curve.
#[derive(Debug)]
struct PointsOfPart {
    start: f64,
    length: f64,
    through: Arc<Barycentric>,
    /// Frames relative to the one at the start, shape `(r, r)` by rows.
    frames: Vec<f64>,
}

impl LinearPiece {
    /// Linearises one cubic.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`; `InvalidArgument` if a leg would take too
    /// much memory.
    pub(crate) fn new(start: LinearStart, interrupt: Interrupt<'_>) -> Result<Self> {
        let layout = LinearLayout::of(start.blocks, start.has_rows());
        let vectors = layout.vectors(&start);
        let curve = linearise(layout.shape, vectors, start.tension, interrupt)?;
        Ok(Self::of_curve(start, &layout, curve))
    }

    /// Linearises several cubics on one manifold, eight at once if that is quicker.
    ///
    /// # Errors
    /// As [`LinearPiece::new`].
    pub(crate) fn all(starts: Vec<LinearStart>, interrupt: Interrupt<'_>) -> Result<Vec<Self>> {
        // Curves that need about equally many terms together.
        let mut sorted: Vec<(usize, LinearStart)> = starts.into_iter().enumerate().collect();
        sorted.sort_by_cached_key(|(_, start)| {
            let blocks = start.blocks;
            (blocks.m, blocks.are_subspaces(), start.speed().to_bits())
        });
        let is_alike = |one: &LinearStart, other: &LinearStart| {
            let [one, other] = [one.blocks, other.blocks];
            (one.m, one.quotient) == (other.m, other.quotient)
        };
        let mut groups: Vec<Vec<(usize, LinearStart)>> = Vec::new();
        for (index, start) in sorted {
            match groups.last_mut() {
                Some(group) if group.len() < LANES && is_alike(&group[0].1, &start) => {
                    group.push((index, start));
                }
                _ => groups.push(vec![(index, start)]),
            }
        }
        let linear = |(): &mut (), _, group: &mut Vec<(usize, LinearStart)>| {
            let layout = LinearLayout::of(group[0].1.blocks, group[0].1.has_rows());
            let vectors = group
                .iter()
                .map(|(_, start)| layout.vectors(start))
                .collect();
            let tensions: Vec<f64> = group.iter().map(|(_, start)| start.tension).collect();
            let curves = linearise_all(layout.shape, vectors, &tensions, interrupt)?;
            let pieces = group.drain(..).zip(curves);
            let piece = |((index, start), curve)| (index, Self::of_curve(start, &layout, curve));
            Ok(pieces.map(piece).collect::<Vec<_>>())
        };
        let found = threads::map_parts(groups.into_iter(), GROUP, || (), linear)?;
        let mut pieces: Vec<(usize, Self)> = found.into_iter().flatten().collect();
        pieces.sort_unstable_by_key(|(index, _)| *index);
        Ok(pieces.into_iter().map(|(_, piece)| piece).collect())
    }

    fn of_curve(start: LinearStart, layout: &LinearLayout, curve: LinearCurve) -> Self {
        let LinearCurve {
            frame,
            stiffness,
            parts,
        } = curve;
        let r = start.blocks.m + start.blocks.k;
        let n = start.n;
        let mut last = vec![0.0; n * r];
        let frame = layout.frames(frame, r);
        let relative = MatRef::from_row_major_slice(&frame, r, r);
        mul_into(
            columns_mut(&mut last, n),
            1.0,
            columns(&start.frame, n),
            relative,
        );
        let outside = layout.has_row().then(|| PieceResponse {
            stiffness: layout.of_row(&stiffness),
            displacements: parts
                .iter()
                .map(|part| layout.of_row(&part.displacements))
                .collect(),
        });
        let mut displacements = Vec::with_capacity(parts.len());
        let place = |part: CurvePart| {
            displacements.push(layout.of_span(part.displacements));
            PointsOfPart {
                start: part.start,
                length: part.length,
                frames: layout.frames(part.frames, r),
                through: part.through,
            }
        };
        let parts = parts.into_iter().map(place).collect();
        LinearPiece {
            n,
            blocks: start.blocks,
            tension: start.tension,
            frames: [start.frame, last],
            inside: PieceResponse {
                stiffness: layout.of_span(stiffness),
                displacements,
            },
            outside,
            parts,
        }
    }

    /// The change of the gradient of half the cost, `(x''_0, -x'_0, -x''_1, x'_1)`, for `(u_0, w_0, u_1, w_1)`, as
    /// tangent vectors; in tension with `x'' - tau x` in place of `x''`.
    pub(crate) fn stiffness(&self, z: [&[f64]; 4]) -> PieceVariation {
        let mut out = self.product(z, |matrix| matrix);
        for (to, from, tau) in [(0, 1, -self.tension), (2, 3, self.tension)] {
            if tau != 0.0 {
                add(&mut out[to], tau, z[from]);
            }
        }
        out
    }

    /// The changes of `x'` and `x''` at the start for `(u_0, w_0, u_1, w_1)`.
    pub(crate) fn at_start(&self, z: [&[f64]; 4]) -> [Vec<f64>; 2] {
        let [second, mut first, ..] = self.product(z, |matrix| matrix);
        first.iter_mut().for_each(|x| *x = -*x);
        [first, second]
    }

    /// The gradient with respect to `(u_0, w_0, u_1, w_1)` of a function of `x'` and `x''` at the start with the given one.
    pub(crate) fn pull_back_start(&self, [by_first, by_second]: [&[f64]; 2]) -> PieceVariation {
        let first: Vec<f64> = by_first.iter().map(|x| -x).collect();
        let zero = vec![0.0; first.len()];
        self.product([by_second, &first, &zero, &zero], |matrix| {
            matrix.transpose()
        })
    }

    /// The product of the second derivative, optionally transposed, with two tangent vectors at the start and two at the
    /// end.
    fn product(
        &self,
        z: [&[f64]; 4],
        view: fn(MatRef<'_, f64>) -> MatRef<'_, f64>,
    ) -> PieceVariation {
        let [size, width] = [self.blocks.dim(), self.blocks.k].map(|d| 4 * d);
        let mut found = vec![0.0; size];
        if size > 0 {
            let matrix = MatRef::from_row_major_slice(&self.inside.stiffness, size, size);
            let z = self.coordinates(z);
            mul_into(
                columns_mut(&mut found, size),
                1.0,
                view(matrix),
                columns(&z, size),
            );
        }
        let rows = self.outside.as_ref().map(|outside| {
            let matrix = MatRef::from_row_major_slice(&outside.stiffness, width, width);
            let (off, mut rows) = (self.outside(&z), vec![0.0; self.n * width]);
            let by_ends = view(matrix).transpose();
            mul_into(
                columns_mut(&mut rows, self.n),
                1.0,
                columns(&off, self.n),
                by_ends,
            );
            rows
        });
        self.lifted(&found, rows.as_deref())
    }

    /// The variations of the points at given times in `[0, 1]` for `(u_0, w_0, u_1, w_1)`.
    pub(crate) fn points(&self, z: [&[f64]; 4], times: &[f64]) -> Vec<Vec<f64>> {
        let (n, Sizes { k, .. }, r) = (self.n, self.blocks, self.r());
        let coordinates = self.coordinates(z);
        let off = self.outside.as_ref().map(|_| self.outside(&z));
        let mut at_points: Vec<Vec<f64>> = vec![Vec::new(); self.parts.len()];
        let mut factors = Vec::new();
        let point = |t: &f64| {
            let mut out = vec![0.0; n * k];
            let Some(part) = self.part_at(*t, &mut factors) else {
                return out;
            };
            if at_points[part].is_empty() {
                at_points[part] = self.displaced(part, &coordinates);
            }
            let mut low = vec![0.0; r * k];
            for (factor, x) in factors.iter().zip(at_points[part].chunks_exact(r * k)) {
                add(&mut low, *factor, x);
            }
            mul_into(
                columns_mut(&mut out, n),
                1.0,
                self.frame(0),
                columns(&low, r),
            );
            if let (Some(outside), Some(off)) = (&self.outside, &off) {
                let flow = self.row_response(outside, part, &factors);
                let flow = MatRef::from_row_major_slice(&flow, k, 4 * k);
                mul_add(
                    columns_mut(&mut out, n),
                    1.0,
                    columns(off, n),
                    flow.transpose(),
                );
            }
            out
        };
        times.iter().map(point).collect()
    }

    /// The gradient with respect to `(u_0, w_0, u_1, w_1)`, as tangent vectors, of `sum tr(W^T S(t))` over cotangents
    /// `W` at given times `t` in `[0, 1]`.
    pub(crate) fn pull_back<'a>(
        &self,
        loads: impl Iterator<Item = (f64, MatRef<'a, f64>)>,
    ) -> PieceVariation {
        let (n, Sizes { k, .. }, r) = (self.n, self.blocks, self.r());
        let mut sums: Vec<Vec<f64>> = vec![Vec::new(); self.parts.len()];
        let mut rows = self.outside.as_ref().map(|_| vec![0.0; 4 * n * k]);
        let (mut low, mut factors) = (vec![0.0; r * k], Vec::new());
        for (t, cotangent) in loads {
            let Some(part) = self.part_at(t, &mut factors) else {
                continue;
            };
            mul_into(
                columns_mut(&mut low, r),
                1.0,
                self.frame(0).transpose(),
                cotangent,
            );
            let sums = &mut sums[part];
            sums.resize(factors.len() * r * k, 0.0);
            for (factor, sum) in factors.iter().zip(sums.chunks_exact_mut(r * k)) {
                add(sum, *factor, &low);
            }
            if let (Some(outside), Some(rows)) = (&self.outside, &mut rows) {
                let mut off = entries(cotangent);
                self.leave_span(&mut off);
                let flow = self.row_response(outside, part, &factors);
                let flow = MatRef::from_row_major_slice(&flow, k, 4 * k);
                mul_add(columns_mut(rows, n), 1.0, columns(&off, n), flow);
            }
        }
        let found = self.gathered(&sums);
        self.lifted(&found, rows.as_deref())
    }

    /// The gradient by the coordinates of `(u_0, w_0, u_1, w_1)`, from sums of cotangents at the points of all parts, in
    /// coordinates of the frame at the start.
    fn gathered(&self, sums: &[Vec<f64>]) -> Vec<f64> {
        let (blocks, r, d) = (self.blocks, self.r(), self.blocks.dim());
        let mut found = vec![0.0; 4 * d];
        let mut turned = vec![0.0; r * blocks.k];
        for ((sums, place), by_ends) in sums.iter().zip(&self.parts).zip(&self.inside.displacements)
        {
            let frames = place.frames.chunks_exact(r * r);
            let points = frames.zip(sums.chunks_exact(r * blocks.k));
            for ((frame, sum), by_ends) in points.zip(by_ends.chunks_exact(4 * d * d)) {
                let frame = MatRef::from_row_major_slice(frame, r, r);
                mul_into(
                    columns_mut(&mut turned, r),
                    1.0,
                    frame.transpose(),
                    columns(sum, r),
                );
                let gradient = pack_gradient(blocks, |i, j| turned[i + r * j]);
                for (x, row) in gradient.iter().zip(by_ends.chunks_exact(4 * d)) {
                    add(&mut found, *x, row);
                }
            }
        }
        found
    }

    /// Displacements at the points of a part, tangent vectors in coordinates of the frame at the start, shape `(r, k)`.
    fn displaced(&self, part: usize, coordinates: &[f64]) -> Vec<f64> {
        let (blocks, r, d) = (self.blocks, self.r(), self.blocks.dim());
        let by_ends = &self.inside.displacements[part];
        let mut all = vec![0.0; by_ends.len() / (4 * d)];
        accumulate(by_ends, 4 * d, coordinates, 1, &mut all);
        let frames = self.parts[part].frames.chunks_exact(r * r);
        let mut out = vec![0.0; r * blocks.k * self.parts[part].through.len()];
        let mut tangent = vec![0.0; r * blocks.k];
        let points = frames.zip(all.chunks_exact(d));
        for ((frame, x), out) in points.zip(out.chunks_exact_mut(r * blocks.k)) {
            write_vector(&mut tangent, x, r, blocks);
            let frame = MatRef::from_row_major_slice(frame, r, r);
            mul_into(columns_mut(out, r), 1.0, frame, columns(&tangent, r));
        }
        out
    }

    /// The displacement of a row outside the span by `(u_0, w_0, u_1, w_1)` there, shape `(k, 4 k)`.
    fn row_response(&self, outside: &PieceResponse, part: usize, factors: &[f64]) -> Vec<f64> {
        let size = 4 * self.blocks.k * self.blocks.k;
        let mut out = vec![0.0; size];
        let points = outside.displacements[part].chunks_exact(size);
        for (factor, x) in factors.iter().zip(points) {
            add(&mut out, *factor, x);
        }
        out
    }

    /// The part of the curve at a time, and the factors of the values at its points; `None` if points cannot move.
    fn part_at(&self, t: f64, factors: &mut Vec<f64>) -> Option<usize> {
        let after = |points: &PointsOfPart| points.start <= t;
        let part = self.parts.partition_point(after).saturating_sub(1);
        let place = self.parts.get(part)?;
        factors.resize(place.through.len(), 0.0);
        place
            .through
            .factors_into((t - place.start) / place.length, factors);
        Some(part)
    }

    /// Coordinates in the span of two tangent vectors at the start and two at the end.
    fn coordinates(&self, z: [&[f64]; 4]) -> Vec<f64> {
        let (r, d) = (self.r(), self.blocks.dim());
        let mut out = vec![0.0; 4 * d];
        let mut low = vec![0.0; r * self.blocks.k];
        for (i, z) in z.into_iter().enumerate() {
            let frame = self.frame(i / 2);
            mul_into(
                columns_mut(&mut low, r),
                1.0,
                frame.transpose(),
                columns(z, self.n),
            );
            read_vector(&low, &mut out[i * d..], r, self.blocks);
        }
        out
    }

    /// The parts of four tangent vectors outside the span, side by side.
    fn outside(&self, z: &[&[f64]; 4]) -> Vec<f64> {
        let mut off = z.concat();
        self.leave_span(&mut off);
        off
    }

    /// Subtracts the part of columns in the span.
    pub(crate) fn leave_span(&self, columns_of: &mut [f64]) {
        let (n, frame) = (self.n, self.frame(0));
        for _ in 0..2 {
            let along: Mat<f64> = frame.transpose() * columns(columns_of, n);
            mul_add(columns_mut(columns_of, n), -1.0, frame, &along);
        }
    }

    /// Tangent vectors from their coordinates in the span, and the rows outside it side by side.
    fn lifted(&self, coordinates: &[f64], rows: Option<&[f64]>) -> PieceVariation {
        let (n, r, d, k) = (self.n, self.r(), self.blocks.dim(), self.blocks.k);
        let mut low = vec![0.0; r * k];
        std::array::from_fn(|i| {
            let mut out = match rows {
                Some(rows) => rows[i * n * k..][..n * k].to_vec(),
                None => vec![0.0; n * k],
            };
            write_vector(&mut low, &coordinates[i * d..], r, self.blocks);
            mul_add(
                columns_mut(&mut out, n),
                1.0,
                self.frame(i / 2),
                columns(&low, r),
            );
            out
        })
    }

    /// The frame at an end, shape `(n, r)`.
    pub(crate) fn frame(&self, end: usize) -> MatRef<'_, f64> {
        columns(&self.frames[end], self.n)
    }

    /// Whether displacements can be computed.
    pub(crate) fn has_points(&self) -> bool {
        !self.parts.is_empty() || self.blocks.dim() == 0
    }

    fn r(&self) -> usize {
        self.blocks.m + self.blocks.k
    }
}
