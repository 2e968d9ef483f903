//! Variations of a cubic from the series of its legs: in the span of the curve, and in the rows outside it.
//!
//! A row outside the span is represented by one additional row of the blocks, in which the curve is zero; variations in
//! the span and in this row do not mix.
//!
//! Square matrices with more than one column are represented by all columns but the last, which is determined by the
//! others: the entries of `omega` in the last column become entries of `b`, with opposite sign.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::blocks::Sized;
use super::initial::Horizontal;
use super::linear_flow::{LinearFlow, side_by_side};
use super::packing::{pack, pack_gradient, unpack};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::shooting::LinearCurve;
use crate::space::{Homogeneous, Quotient, Shape, in_space};

/// The series of the legs of a curve on `[0, 1]`.
#[derive(Debug)]
pub(super) struct LinearSeries {
    curve: LinearCurve,
    layout: Arc<Layout>,
}

/// Position of variations among the coordinates of the space of the series.
#[derive(Debug)]
struct Layout {
    /// Includes the row outside the span, if there is one.
    blocks: Sized,
    /// The space of the series.
    shape: Shape,
    /// Indices of the coordinates of the four vectors in the span, and of those of the row.
    inside: Vec<usize>,
    row: Vec<usize>,
    /// Number of coordinates of a vector, and the index from which they change sign in the space of the series.
    size: usize,
    unchanged: usize,
}

impl Layout {
    fn of(flow: &LinearFlow) -> Arc<Self> {
        let inner = flow.blocks();
        let blocks = Sized {
            m: inner.m + usize::from(flow.has_rows()),
            ..inner
        };
        let (d, k) = (blocks.dim(), blocks.k);
        let is_square = blocks.m == 0 && k > 1 && blocks.quotient == Quotient::Frames;
        let (shape, unchanged) = match is_square {
            true => (Sized::frames(1, k - 1).shape(), d + 1 - k),
            false => (blocks.shape(), d),
        };
        let mut is_row = vec![false; d];
        in_space!(blocks.shape(), |space| space
            .each_entry(|p, i, _| is_row[p] = i >= inner.m + inner.k));
        let (row, inside) = (0..4 * d).partition(|i| is_row[i % d]);
        Arc::new(Layout {
            blocks,
            shape,
            inside,
            row,
            size: d,
            unchanged,
        })
    }

    /// `x, x', x''` at the start of a curve.
    fn start(&self, flow: &LinearFlow) -> [Vec<f64>; 3] {
        let data = &flow.data;
        [&data.velocity, &data.acceleration, &data.second()].map(|x| self.packed(x.clone()))
    }

    /// The coordinates of a vector in the space of the series.
    fn packed(&self, mut x: Horizontal) -> Vec<f64> {
        x.normal
            .resize_with(self.blocks.m, self.blocks.k, |_, _| 0.0);
        let mut packed = pack(self.blocks, &[x]);
        self.turn_signs(&mut packed);
        packed
    }

    /// Converts between coordinates of the blocks and of the space of the series.
    fn turn_signs(&self, vectors: &mut [f64]) {
        for vector in vectors.chunks_exact_mut(self.size.max(1)) {
            for x in &mut vector[self.unchanged..] {
                *x = -*x;
            }
        }
    }
}

impl LinearSeries {
    /// The series of one curve.
    ///
    /// # Errors
    /// `TooManySteps`, `Interrupted`.
    pub(super) fn new(flow: &LinearFlow, interrupt: Interrupt<'_>) -> Result<Self> {
        let layout = Layout::of(flow);
        let (start, tension) = (layout.start(flow), flow.data.tension);
        let curve = LinearCurve::new(layout.shape, start, tension, interrupt)?;
        Ok(LinearSeries { curve, layout })
    }

    /// The series of several curves whose spans have the same size.
    ///
    /// # Errors
    /// `TooManySteps`, `Interrupted`.
    pub(super) fn all(flows: &[LinearFlow], interrupt: Interrupt<'_>) -> Result<Vec<Self>> {
        let layout = Layout::of(&flows[0]);
        let starts = flows.iter().map(|flow| layout.start(flow)).collect();
        let tensions: Vec<f64> = flows.iter().map(|flow| flow.data.tension).collect();
        let curves = LinearCurve::abreast(layout.shape, starts, &tensions, interrupt)?;
        let with_layout = |curve| LinearSeries {
            curve,
            layout: layout.clone(),
        };
        Ok(curves.into_iter().map(with_layout).collect())
    }

    /// The matrices that map `(p, w, a, b)` at the start to those at the end, in the span and for a row outside it.
    pub(super) fn flows(&self) -> [Mat<f64>; 2] {
        let (flow, layout) = (&self.curve.flow, &self.layout);
        let sign = |i: usize| [1.0, -1.0][usize::from(i % layout.size >= layout.unchanged)];
        let entry = |i: usize, j: usize| flow[(i, j)] * sign(i) * sign(j);
        [&layout.inside, &layout.row]
            .map(|which| Mat::from_fn(which.len(), which.len(), |i, j| entry(which[i], which[j])))
    }

    /// The frame at the end, shape `(n, r)`.
    pub(super) fn end(&self, flow: &LinearFlow) -> Mat<f64> {
        self.lifted(flow, &self.curve.frame)
    }

    /// The variation of the point at a time, for the coordinates of `(p, w, a, b)` at the start and for all rows
    /// outside the span, side by side.
    pub(super) fn point(
        &self,
        flow: &LinearFlow,
        t: f64,
        start: &[f64],
        rows: Option<&Mat<f64>>,
    ) -> Mat<f64> {
        let mut all = vec![0.0; 4 * self.layout.blocks.dim()];
        for (i, x) in self.layout.inside.iter().zip(start) {
            all[*i] = *x;
        }
        self.layout.turn_signs(&mut all);
        let (mut displaced, frame) = self.curve.displacement(t, &all);
        self.layout.turn_signs(&mut displaced);
        let inside = self
            .layout
            .inside
            .iter()
            .map_while(|i| displaced.get(*i).copied());
        let [p] = unpack(&inside.collect::<Vec<f64>>(), flow.blocks());
        let mut out = self.lifted(flow, &frame) * p.tangent();
        if let Some(rows) = rows {
            out += rows * self.row_flow(t).transpose();
        }
        out
    }

    /// The gradient with respect to `(p, w, a, b)` at the start, as tangent vectors, of `sum tr(W^T S(t))` over
    /// cotangents `W` at increasing times `t`.
    pub(super) fn pull_back(
        &self,
        flow: &LinearFlow,
        loads: &[(f64, MatRef<'_, f64>)],
    ) -> [Mat<f64>; 4] {
        let packed = |&(t, cotangent): &(f64, MatRef<'_, f64>)| {
            let low = flow.frame.transpose() * cotangent;
            (t, self.load(&self.curve.frame_at(t), low.as_ref()))
        };
        let packed: Vec<(f64, Vec<f64>)> = loads.iter().map(packed).collect();
        let mut all = self.curve.pull_back(&packed);
        self.layout.turn_signs(&mut all);
        let inside: Vec<f64> = self.layout.inside.iter().map(|i| all[*i]).collect();
        let found: [Horizontal; 4] = unpack(&inside, flow.blocks());
        let mut out = found.each_ref().map(|x| &flow.frame * x.tangent());
        if flow.has_rows() {
            let k = self.layout.blocks.k;
            for (t, cotangent) in loads {
                let bars = flow.off(cotangent.to_owned()) * self.row_flow(*t);
                for (part, out) in out.iter_mut().enumerate() {
                    *out += bars.subcols(part * k, k);
                }
            }
        }
        out
    }

    /// A cotangent in the coordinates of the span, shape `(r, k)`, as a vector in the space of the series.
    fn load(&self, frame: &[f64], cotangent: MatRef<'_, f64>) -> Vec<f64> {
        let Sized { m, k, .. } = self.layout.blocks;
        let entry = |i: usize, j: usize| -> f64 {
            let column = cotangent.col(j).iter().enumerate();
            column.map(|(l, x)| frame[l * (m + k) + i] * x).sum()
        };
        let mut load = pack_gradient(self.layout.blocks, entry);
        self.layout.turn_signs(&mut load);
        load
    }

    /// The matrix, shape `(k, 4 k)`, from `(p, w, a, b)` of a row outside the span at the start to its displacement.
    fn row_flow(&self, t: f64) -> Mat<f64> {
        let mut unit = vec![0.0; 4 * self.layout.blocks.dim()];
        let mut out = Mat::zeros(self.layout.blocks.k, self.layout.row.len());
        for (j, at) in self.layout.row.iter().enumerate() {
            unit[*at] = 1.0;
            let (displaced, _) = self.curve.displacement(t, &unit);
            unit[*at] = 0.0;
            for i in 0..self.layout.blocks.k {
                out[(i, j)] = displaced[self.layout.row[i]];
            }
        }
        out
    }

    /// A frame of the series' coordinates, as a frame of the span.
    fn lifted(&self, flow: &LinearFlow, frame: &[f64]) -> Mat<f64> {
        let (r, size) = (
            flow.frame.ncols(),
            self.layout.blocks.m + self.layout.blocks.k,
        );
        &flow.frame * Mat::from_fn(r, r, |i, j| frame[i * size + j])
    }
}

/// The parts of four vectors outside the span, side by side; `None` if the span is all of `R^n`.
pub(super) fn rows_outside(flow: &LinearFlow, vectors: &[Mat<f64>; 4]) -> Option<Mat<f64>> {
    let views = vectors.each_ref().map(|x| x.as_ref());
    flow.has_rows().then(|| flow.off(side_by_side(&views)))
}

#[cfg(test)]
pub(super) mod tests {
    use faer::Scale;

    use super::*;
    use crate::cubic::variation::vary;
    use crate::{Stiefel, linalg::structure::norm};

    /// Pseudorandom numbers between -1 and 1.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 11) as f64) / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// The tangent part of a matrix at a point.
    pub(in crate::cubic) fn tangent(
        quotient: Quotient,
        s: MatRef<'_, f64>,
        x: &Mat<f64>,
    ) -> Mat<f64> {
        let inner = s.transpose() * x;
        match quotient {
            Quotient::Frames => x - s * (&inner + inner.transpose()) * Scale(0.5),
            Quotient::Subspaces => x - s * inner,
        }
    }

    /// The flow of a curve from a random point, whose velocity has the given size.
    pub(in crate::cubic) fn flow(
        [n, k]: [usize; 2],
        tension: f64,
        speed: f64,
        quotient: Quotient,
    ) -> LinearFlow {
        let mut next = numbers(7 + n as u64);
        let manifold = Stiefel::new(n, k).unwrap();
        let raw = Mat::from_fn(n, k, |_, _| next());
        let s = manifold.project(raw.as_ref()).unwrap();
        let vectors = [1.0, 2.0, 3.0].map(|size: f64| {
            let raw = Mat::from_fn(n, k, |_, _| next());
            let v = tangent(quotient, s.as_ref(), &raw);
            let unit = norm(v.as_ref());
            // A curve without degrees of freedom has none.
            let factor = if unit == 0.0 {
                0.0
            } else {
                size * speed.powf(size) / unit
            };
            v * Scale(factor)
        });
        let [v, a, j] = vectors.each_ref().map(|x| x.as_ref());
        LinearFlow::new([s.as_ref(), v, a, j], tension, quotient).unwrap()
    }

    /// Compares with directional derivatives by dual numbers.
    fn check(flow: &LinearFlow, series: &LinearSeries, bound: f64) {
        let blocks = flow.blocks();
        let d = blocks.dim();
        let [inside, _] = series.flows();
        let units = |levels: usize| {
            (0..levels * d).map(move |i| {
                let mut entries = vec![0.0; levels * d];
                entries[i] = 1.0;
                entries
            })
        };
        let directions: Vec<[Horizontal; 3]> =
            units(3).map(|entries| unpack(&entries, blocks)).collect();
        let reached = vary::<8>(&flow.data, 0, &directions, &[1.0], Interrupt::NEVER)
            .unwrap()
            .remove(0);
        let displaced = units(1).map(|entries| {
            let [u] = unpack(&entries, blocks);
            pack(blocks, &reached.displaced(&u))
        });
        let others = reached.variations.iter().map(|column| pack(blocks, column));
        for (column, expected) in displaced.chain(others).enumerate() {
            let size = 1.0 + expected.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for (row, x) in expected.iter().enumerate() {
                let error = (inside[(row, column)] - x).abs() / size;
                assert!(error < bound, "({row}, {column}) of {d}: {error:.1e}");
            }
        }
        let end = series.end(flow);
        let error = norm((end - &flow.frame * &reached.frame).as_ref());
        assert!(error < 1e-13, "frame: {error:.1e}");
    }

    const SHAPES: [[usize; 2]; 9] = [
        [1, 1],
        [2, 1],
        [2, 2],
        [3, 1],
        [3, 2],
        [3, 3],
        [4, 4],
        [5, 2],
        [7, 3],
    ];

    #[test]
    fn flows_are_those_of_dual_numbers() {
        for shape in SHAPES {
            for quotient in [Quotient::Frames, Quotient::Subspaces] {
                if quotient == Quotient::Subspaces && shape[0] == shape[1] {
                    continue;
                }
                for (tension, speed) in [(0.0, 0.5), (4.0, 0.5), (0.0, 3.0)] {
                    let flow = flow(shape, tension, speed, quotient);
                    let series = LinearSeries::new(&flow, Interrupt::NEVER).unwrap();
                    println!("{shape:?} {quotient:?} {tension} {speed}");
                    check(&flow, &series, 1e-11);
                }
            }
        }
    }

    #[test]
    fn eight_abreast_are_what_each_is_alone() {
        for shape in SHAPES {
            let flows = [0.1, 0.3, 0.5, 0.7, 0.2].map(|s| flow(shape, 0.5, s, Quotient::Frames));
            let all = LinearSeries::all(&flows, Interrupt::NEVER).unwrap();
            for (flow, series) in flows.iter().zip(&all) {
                check(flow, series, 1e-12);
            }
        }
    }
}
