//! Variations of a cubic by the series of its legs: in the span of the curve, and in the rows outside of it.
//!
//! A row outside of the span is one row more of the blocks, in which the curve stays zero; variations in the span and in the row do
//! not mix.
//!
//! Square matrices of more than one column go by all columns but the last, which is determined by the others: the entries of `omega`
//! beside the last column become those of `b`, with the other sign.

use faer::{Mat, MatRef, Scale};

use super::initial::Horizontal;
use super::linear_flow::{LinearFlow, side_by_side};
use super::packing::{pack, unpack};
use super::reduced::Sized;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::shooting::LinearCurve;
use crate::space::{Homogeneous, Quotient, in_space};

/// The series of the legs of a curve from its start to a time.
#[derive(Debug)]
pub(super) struct LinearSeries {
    curve: LinearCurve,
    /// With the row outside of the span, where there is one.
    blocks: Sized,
    /// Which coordinates of the four vectors are in the span, and which are those of the row.
    inside: Vec<usize>,
    row: Vec<usize>,
    /// Coordinates of a vector, and from which on they have the other sign in the space of the series.
    size: usize,
    unchanged: usize,
}

impl LinearSeries {
    /// # Errors
    /// `TooManySteps`, `Interrupted`.
    pub(super) fn new(flow: &LinearFlow, until: f64, interrupt: Interrupt<'_>) -> Result<Self> {
        let inner = flow.blocks();
        let blocks = Sized {
            m: inner.m + usize::from(flow.has_rows()),
            ..inner
        };
        let data = &flow.data;
        let (d, k) = (blocks.dim(), blocks.k);
        let is_square = blocks.m == 0 && k > 1 && blocks.quotient == Quotient::Frames;
        let (shape, unchanged) = match is_square {
            true => (Sized::frames(1, k - 1).shape(), d + 1 - k),
            false => (blocks.shape(), d),
        };
        let start = [&data.velocity, &data.acceleration, &data.second()].map(|x| {
            let mut x = pack(blocks, &[longer(x.clone(), blocks)]);
            turn_signs(&mut x, d, unchanged);
            x
        });
        let curve = LinearCurve::new(shape, start, data.tension, until, interrupt)?;
        let mut is_row = vec![false; d];
        in_space!(blocks.shape(), |space| space
            .each_entry(|p, i, _| is_row[p] = i >= inner.m + inner.k));
        let (row, inside) = (0..4 * d).partition(|i| is_row[i % d]);
        Ok(LinearSeries {
            curve,
            blocks,
            inside,
            row,
            size: d,
            unchanged,
        })
    }

    /// `(p, w, a, b)` at the end by those at the start, in the span and for a row outside of it.
    pub(super) fn flows(&self) -> [Mat<f64>; 2] {
        let flow = &self.curve.flow;
        [&self.inside, &self.row]
            .map(|which| Mat::from_fn(which.len(), which.len(), |i, j| flow[(which[i], which[j])]))
    }

    /// The frame at the end, shape `(n, r)`.
    pub(super) fn end(&self, flow: &LinearFlow) -> Mat<f64> {
        self.lifted(flow, &self.curve.frame)
    }

    /// The variation of the point at a time, for the coordinates of `(p, w, a, b)` at the start and for all rows outside of the
    /// span, side by side.
    pub(super) fn point(
        &self,
        flow: &LinearFlow,
        t: f64,
        start: &[f64],
        rows: Option<&Mat<f64>>,
    ) -> Mat<f64> {
        let mut all = vec![0.0; 4 * self.blocks.dim()];
        for (i, x) in self.inside.iter().zip(start) {
            all[*i] = *x;
        }
        turn_signs(&mut all, self.size, self.unchanged);
        let (mut displaced, frame) = self.curve.displacement(t, &all);
        turn_signs(&mut displaced, self.size, self.unchanged);
        let inside = self.inside.iter().map_while(|i| displaced.get(*i).copied());
        let [p] = unpack(&inside.collect::<Vec<f64>>(), flow.blocks());
        let mut out = self.lifted(flow, &frame) * p.tangent();
        if let Some(rows) = rows {
            out += rows * self.row_flow(t).transpose();
        }
        out
    }

    /// The gradient by `(p, w, a, b)` at the start, tangent vectors, of the sum of products of entries of cotangents with the points
    /// at increasing times.
    pub(super) fn pull_back(
        &self,
        flow: &LinearFlow,
        loads: &[(f64, MatRef<'_, f64>)],
    ) -> [Mat<f64>; 4] {
        let packed = |&(t, cotangent): &(f64, MatRef<'_, f64>)| {
            let frame = self.lifted(flow, &self.curve.frame_at(t));
            let mut bar = Horizontal::of_tangent(frame.as_ref(), cotangent);
            // Entries of `omega` are there twice.
            bar.omega *= Scale(2.0);
            let mut bar = pack(self.blocks, &[longer(bar, self.blocks)]);
            turn_signs(&mut bar, self.size, self.unchanged);
            (t, bar)
        };
        let packed: Vec<(f64, Vec<f64>)> = loads.iter().map(packed).collect();
        let mut all = self.curve.pull_back(&packed);
        turn_signs(&mut all, self.size, self.unchanged);
        let inside: Vec<f64> = self.inside.iter().map(|i| all[*i]).collect();
        let found: [Horizontal; 4] = unpack(&inside, flow.blocks());
        let mut out = found.each_ref().map(|x| &flow.frame * x.tangent());
        if flow.has_rows() {
            let k = self.blocks.k;
            for (t, cotangent) in loads {
                let bars = flow.off(cotangent.to_owned()) * self.row_flow(*t);
                for (part, out) in out.iter_mut().enumerate() {
                    *out += bars.subcols(part * k, k);
                }
            }
        }
        out
    }

    /// The displacement of a row outside of the span by its `(p, w, a, b)` at the start, shape `(k, 4 k)`.
    fn row_flow(&self, t: f64) -> Mat<f64> {
        let mut unit = vec![0.0; 4 * self.blocks.dim()];
        let mut out = Mat::zeros(self.blocks.k, self.row.len());
        for (j, at) in self.row.iter().enumerate() {
            unit[*at] = 1.0;
            let (displaced, _) = self.curve.displacement(t, &unit);
            unit[*at] = 0.0;
            for i in 0..self.blocks.k {
                out[(i, j)] = displaced[self.row[i]];
            }
        }
        out
    }

    /// A frame of the curve's coordinates, in the span.
    fn lifted(&self, flow: &LinearFlow, frame: &[f64]) -> Mat<f64> {
        let (r, size) = (flow.frame.ncols(), self.blocks.m + self.blocks.k);
        &flow.frame * Mat::from_fn(r, r, |i, j| frame[i * size + j])
    }
}

/// Turns the signs of the coordinates of vectors of a size from one on.
fn turn_signs(vectors: &mut [f64], size: usize, unchanged: usize) {
    for vector in vectors.chunks_exact_mut(size.max(1)) {
        for x in &mut vector[unchanged..] {
            *x = -*x;
        }
    }
}

/// With rows of zeros, up to the size of blocks.
fn longer(mut x: Horizontal, blocks: Sized) -> Horizontal {
    x.normal.resize_with(blocks.m, blocks.k, |_, _| 0.0);
    x
}

/// What of four vectors is outside of the span, side by side; `None` where the span is all of `R^n`.
pub(super) fn rows_outside(flow: &LinearFlow, vectors: &[Mat<f64>; 4]) -> Option<Mat<f64>> {
    let views = vectors.each_ref().map(|x| x.as_ref());
    flow.has_rows().then(|| flow.off(side_by_side(&views)))
}
