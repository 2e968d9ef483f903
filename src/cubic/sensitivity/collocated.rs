//! A cubic on `[0, 1]` at Gauss nodes, with its linearised equations.
//!
//! Variations of points are polynomials in time through their values at the nodes and at both ends.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::linear_flow::{LinearFlow, side_by_side};
use crate::collocation::{
    CurveAtNodes, LaneNodes, LinearBoundary, are_resolved, linear_nodes, more_nodes,
};
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::packing::{pack, pack_blocks, pack_gradient, unpack};
use crate::cubic::taylor::piecewise_taylor::{PiecewiseTaylor, square};
use crate::cubic::taylor::state::State;
use crate::curve::barycentric::Barycentric;
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::{accumulate, larger};
use crate::linalg::simd::vectorised;

/// Four tangent vectors: displacement and change of the velocity, at the start and at the end.
type EndVariation = [Mat<f64>; 4];

/// The linearised equations, in the span of the curve and outside it.
#[derive(Debug)]
pub(crate) struct Collocated {
    through: Barycentric,
    /// Frames relative to the one at the start, shape `(r, r)`, at the nodes.
    frames: Vec<Mat<f64>>,
    /// The frame at the end, shape `(n, r)`.
    end: Mat<f64>,
    inside: LinearBoundary,
    rows: Option<RowResponse>,
}

/// The response of a row outside the span to `(u_0, w_0, u_1, w_1)` in this row.
#[derive(Debug)]
struct RowResponse {
    /// Displacements at the nodes, shape `(k, 4 k)` each.
    displacements: Vec<Mat<f64>>,
    /// `a` and `b` at the start, shape `(k, 4 k)` each.
    start: [Mat<f64>; 2],
}

/// A variation of the curve.
pub(crate) struct Varied {
    /// Displacements at the nodes relative to the frame at the start, one column of length `r k` per node.
    inside: Mat<f64>,
    /// `(u_0, w_0, u_1, w_1)` outside the span, side by side.
    rows: Option<Mat<f64>>,
    /// `a` and `b` at the start.
    pub(crate) start: [Mat<f64>; 2],
}

impl Collocated {
    /// Built along the given polynomials, whose frame at the start is that of the data of the flow, or along integrated
    /// ones; `None` for curves that are too fast, whose points cannot move, or whose ends may be conjugate.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn new(
        flow: &LinearFlow,
        taylor: Option<&PiecewiseTaylor>,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Self>> {
        let blocks = flow.blocks();
        if blocks.dim() == 0 {
            return Ok(None);
        }
        let integrated;
        let taylor = match taylor {
            Some(taylor) => taylor,
            None => {
                integrated = integrate(flow, interrupt)?;
                &integrated
            }
        };
        let Some((nodes, x, frames)) = resolved(taylor) else {
            return Ok(None);
        };
        let end = taylor.first.frame().transpose() * taylor.last.frame();
        let size = taylor.r() * blocks.k;
        let packed = |vectors: &[f64]| {
            let mut all = vec![0.0; vectors.len() / size * blocks.dim()];
            let each = vectors.chunks_exact(size);
            for (x, out) in each.zip(all.chunks_exact_mut(blocks.dim())) {
                pack_blocks(blocks, x, out);
            }
            all
        };
        let [last, ..] = vectors_at(taylor, &[1.0]);
        let (coordinates, last_coordinates) = (x.each_ref().map(|x| packed(x)), packed(&last));
        let (at_nodes, at_end) = (by_rows(&frames), by_rows(std::slice::from_ref(&end)));
        let in_span = CurveAtNodes {
            x: coordinates.each_ref().map(Vec::as_slice),
            last: &last_coordinates,
            frames: &at_nodes,
            end: &at_end,
        };
        let (shape, tension) = (blocks.shape(), flow.data.tension);
        let inside = LinearBoundary::in_span(shape, &nodes, in_span, tension);
        if !inside.is_regular(interrupt)? {
            return Ok(None);
        }
        let rows = match flow.has_rows() {
            true => {
                let in_blocks = CurveAtNodes {
                    x: x.each_ref().map(Vec::as_slice),
                    last: &last,
                    ..in_span
                };
                let equations = LinearBoundary::in_row(shape, &nodes, in_blocks, tension);
                match RowResponse::of(&equations, blocks.k, interrupt)? {
                    None => return Ok(None),
                    found => found,
                }
            }
            false => None,
        };
        Ok(Some(Collocated {
            through: Barycentric::new(&nodes.nodes),
            frames,
            end: &flow.frame * end,
            inside,
            rows,
        }))
    }

    /// The variation with the given data at the ends; `None` if the equations are not solved to round-off.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn vary(
        &self,
        flow: &LinearFlow,
        z: &EndVariation,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Varied>> {
        let (blocks, frames) = (flow.blocks(), self.end_frames(flow));
        let ends: [Vec<f64>; 4] = std::array::from_fn(|i| {
            pack(blocks, &[Horizontal::of_tangent(frames[i], z[i].as_ref())])
        });
        let views = ends.each_ref().map(Vec::as_slice);
        let Some(found) = self.inside.solve(views, interrupt)? else {
            return Ok(None);
        };
        let (count, size) = (self.frames.len(), (blocks.m + blocks.k) * blocks.k);
        let mut inside = Mat::zeros(size, count);
        let displacements = found.displacements.chunks_exact(blocks.dim());
        for (node, (frame, p)) in self.frames.iter().zip(displacements).enumerate() {
            let [p] = unpack(p, blocks);
            let displaced = frame * p.tangent();
            let entries = displaced.col_iter().flat_map(|column| column.iter());
            for (to, x) in inside.col_mut(node).iter_mut().zip(entries) {
                *to = *x;
            }
        }
        let mut start = found.start.map(|x| {
            let [x] = unpack(&x, blocks);
            &flow.frame * x.tangent()
        });
        let rows = self.rows.as_ref().map(|response| {
            let rows = flow.off(side_by_side(&z.each_ref().map(|x| x.as_ref())));
            for (start, by_ends) in start.iter_mut().zip(&response.start) {
                *start += &rows * by_ends.transpose();
            }
            rows
        });
        Ok(Some(Varied {
            inside,
            rows,
            start,
        }))
    }

    /// The displacements at times in `[0, 1]`, shape `(n, k)` each, of the variation with the given data at the ends.
    pub(crate) fn points(
        &self,
        flow: &LinearFlow,
        varied: &Varied,
        z: &EndVariation,
        times: &[f64],
    ) -> Vec<Mat<f64>> {
        let factors = self.factors(times);
        let count = self.frames.len();
        let inside = &varied.inside * factors.subrows(1, count);
        let (k, r) = (z[0].ncols(), flow.frame.ncols());
        let point = |i: usize| {
            let low = MatRef::from_column_major_slice(inside.col_as_slice(i), r, k);
            let (first, last) = (factors[(0, i)], factors[(count + 1, i)]);
            let mut point = &flow.frame * low;
            point += &z[0] * faer::Scale(first) + &z[2] * faer::Scale(last);
            if let (Some(rows), Some(response)) = (&varied.rows, &self.rows) {
                let mut flow = Mat::zeros(k, 4 * k);
                for (node, at_node) in response.displacements.iter().enumerate() {
                    flow += at_node * faer::Scale(factors[(node + 1, i)]);
                }
                point += rows * flow.transpose();
            }
            point
        };
        (0..times.len()).map(point).collect()
    }

    /// The gradient with respect to the data at the ends, as tangent vectors, of `sum tr(W^T S(t))` over cotangents `W`
    /// at times in `[0, 1]`, plus a function of `a` and `b` at the start with the given gradient; `None` if the
    /// equations are not solved to round-off.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn pull_back(
        &self,
        flow: &LinearFlow,
        (times, cotangents): (&[f64], &[MatRef<'_, f64>]),
        by_start: Option<[&Mat<f64>; 2]>,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<EndVariation>> {
        let (blocks, count) = (flow.blocks(), self.frames.len());
        let loads = self.loads(flow, times, cotangents);
        let mut by_displacements = Vec::with_capacity(blocks.dim() * count);
        for (frame, load) in self.frames.iter().zip(&loads[1..]) {
            let low = frame.transpose() * (flow.frame.transpose() * load);
            by_displacements.extend(pack_gradient(blocks, |i, j| low[(i, j)]));
        }
        let by_derivatives = [0, 1].map(|i| match by_start {
            Some(by_start) => {
                let vector = Horizontal::of_tangent(flow.frame.as_ref(), by_start[i].as_ref());
                pack(blocks, &[vector])
            }
            None => vec![0.0; blocks.dim()],
        });
        let views = by_derivatives.each_ref().map(Vec::as_slice);
        let found = self.inside.pull_back(&by_displacements, views, interrupt)?;
        let Some(mut by_ends) = found else {
            return Ok(None);
        };
        let frames = self.end_frames(flow);
        for (end, load) in [(0, &loads[0]), (2, &loads[count + 1])] {
            let low = frames[end].transpose() * load;
            let direct = pack_gradient(blocks, |i, j| low[(i, j)]);
            by_ends[end]
                .iter_mut()
                .zip(direct)
                .for_each(|(sum, x)| *sum += x);
        }
        let mut out: EndVariation = std::array::from_fn(|i| {
            let [x] = unpack(&by_ends[i], blocks);
            frames[i] * x.tangent()
        });
        if let Some(response) = &self.rows {
            let by_rows = response.pull_back(flow, &loads, by_start);
            for (end, out) in out.iter_mut().enumerate() {
                *out += by_rows.subcols(end * blocks.k, blocks.k);
            }
        }
        Ok(Some(out))
    }

    /// The frames at the ends, for displacement and velocity each.
    fn end_frames<'a>(&'a self, flow: &'a LinearFlow) -> [MatRef<'a, f64>; 4] {
        let (first, last) = (flow.frame.as_ref(), self.end.as_ref());
        [first, first, last, last]
    }

    /// Factors of the values at the start, at the nodes and at the end, one column per time.
    fn factors(&self, times: &[f64]) -> Mat<f64> {
        let mut factors = Mat::zeros(self.frames.len() + 2, times.len());
        for (i, t) in times.iter().enumerate() {
            self.through.factors_into(*t, factors.col_as_slice_mut(i));
        }
        factors
    }

    /// The sums of cotangents that act on the values at the start, at the nodes and at the end.
    fn loads(
        &self,
        flow: &LinearFlow,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
    ) -> Vec<Mat<f64>> {
        let (n, k) = (flow.frame.nrows(), flow.blocks().k);
        let all = Mat::from_fn(n * k, times.len(), |i, j| cotangents[j][(i % n, i / n)]);
        let sums = all * self.factors(times).transpose();
        let matrix = |i: usize| MatRef::from_column_major_slice(sums.col_as_slice(i), n, k);
        (0..sums.ncols()).map(|i| matrix(i).to_owned()).collect()
    }
}

impl RowResponse {
    /// # Errors
    /// `Interrupted`.
    fn of(equations: &LinearBoundary, k: usize, interrupt: Interrupt<'_>) -> Result<Option<Self>> {
        let mut columns = Vec::new();
        for column in 0..4 * k {
            let mut ends = vec![0.0; 4 * k];
            ends[column] = 1.0;
            let views = std::array::from_fn(|end| &ends[end * k..][..k]);
            match equations.solve(views, interrupt)? {
                Some(found) => columns.push(found),
                None => return Ok(None),
            }
        }
        let count = columns[0].displacements.len() / k;
        let at_node = |node: usize| {
            let entry = |i: usize, j: usize| columns[j].displacements[node * k + i];
            Mat::from_fn(k, 4 * k, entry)
        };
        Ok(Some(RowResponse {
            displacements: (0..count).map(at_node).collect(),
            start: [0, 1].map(|part| Mat::from_fn(k, 4 * k, |i, j| columns[j].start[part][i])),
        }))
    }

    /// The gradient with respect to `(u_0, w_0, u_1, w_1)` outside the span, side by side.
    fn pull_back(
        &self,
        flow: &LinearFlow,
        loads: &[Mat<f64>],
        by_start: Option<[&Mat<f64>; 2]>,
    ) -> Mat<f64> {
        let (n, k) = loads[0].shape();
        let off = |x: &Mat<f64>| flow.off(x.clone());
        let (first, last) = (off(&loads[0]), off(&loads[loads.len() - 1]));
        let mut sum = Mat::zeros(n, 4 * k);
        for (load, by_ends) in loads[1..].iter().zip(&self.displacements) {
            sum += off(load) * by_ends;
        }
        for (by_start, by_ends) in by_start.iter().flatten().zip(&self.start) {
            sum += off(by_start) * by_ends;
        }
        let mut by_first = sum.subcols_mut(0, k);
        by_first += first;
        let mut by_last = sum.subcols_mut(2 * k, k);
        by_last += last;
        sum
    }
}

/// The curve, in coordinates in which its frame at the start is that of the data.
///
/// # Errors
/// `TooManySteps`, `Overflow`, `Interrupted`.
fn integrate(flow: &LinearFlow, interrupt: Interrupt<'_>) -> Result<PiecewiseTaylor> {
    let data = &flow.data;
    let vectors = [&data.velocity, &data.acceleration, &data.second()];
    let start = State::in_blocks(flow.blocks(), &data.g, vectors);
    let mut taylor = PiecewiseTaylor::at(start.in_tension(data.tension), Accuracy::FULL);
    taylor.extend_to(1.0, interrupt)?;
    Ok(taylor)
}

/// A curve at nodes: blocks of `x, x', x''`, one node after another, and frames.
type AtNodes = (Arc<LaneNodes>, [Vec<f64>; 3], Vec<Mat<f64>>);

/// The curve at as many nodes as its variations need; `None` for a fast curve. Tension `tau` lets variations grow as
/// `exp(sqrt(tau) t)`.
fn resolved(taylor: &PiecewiseTaylor) -> Option<AtNodes> {
    let growth = taylor.tension().sqrt();
    let mut nodes = linear_nodes(growth)?;
    loop {
        let x = vectors_at(taylor, &nodes.nodes.s);
        let size = taylor.r() * taylor.blocks.k;
        let squares = x[0]
            .chunks_exact(size)
            .map(|x| square(x, taylor.blocks.k.pow(2)));
        let speed = squares.fold(0.0, larger).sqrt();
        let needed = linear_nodes(larger(speed, growth))?;
        if needed.count() > nodes.count() {
            nodes = needed;
            continue;
        }
        let frames = frames(taylor, &nodes.nodes, &x[0]);
        let columns = frames.iter().flat_map(|frame| frame.col_iter());
        let squares = columns.flat_map(|column| column.iter().map(|x| x * x));
        if are_resolved(&nodes, &squares.collect::<Vec<f64>>()) {
            return Some((nodes, x, frames));
        }
        nodes = more_nodes(&nodes)?;
    }
}

/// Frames by rows, one after another.
fn by_rows(frames: &[Mat<f64>]) -> Vec<f64> {
    let rows = frames.iter().flat_map(|frame| frame.row_iter());
    rows.flat_map(|row| row.iter().copied()).collect()
}

fn vectors_at(taylor: &PiecewiseTaylor, times: &[f64]) -> [Vec<f64>; 3] {
    let size = taylor.r() * taylor.blocks.k;
    let mut x = [(); 3].map(|()| vec![0.0; size * times.len()]);
    let [values, first, second] = &mut x;
    let parts = values
        .chunks_exact_mut(size)
        .zip(first.chunks_exact_mut(size));
    for ((t, (x, x1)), x2) in times.iter().zip(parts).zip(second.chunks_exact_mut(size)) {
        taylor.vectors_into(*t, &mut [x, x1, &mut *x2]);
        x2.iter_mut().for_each(|x| *x *= 2.0);
    }
    x
}

/// Frames at the nodes relative to the one at the start: the points, and normals with `N' = -S b^T`.
fn frames(taylor: &PiecewiseTaylor, nodes: &Nodes, x: &[f64]) -> Vec<Mat<f64>> {
    let Sizes { m, k, .. } = taylor.blocks;
    let start = taylor.first.frame();
    let (r, rows, size) = (taylor.r(), taylor.rows(), taylor.r() * m);
    let mut points: Vec<Mat<f64>> = Vec::with_capacity(nodes.len());
    let mut rates = Vec::with_capacity(nodes.len() * size);
    let mut padded = vec![0.0; rows * k];
    for (t, x) in nodes.s.iter().zip(x.chunks_exact(r * k)) {
        taylor.point_into(*t, &mut padded);
        let point = MatRef::from_column_major_slice(&padded, rows, k).subrows(0, r);
        let point = start.transpose() * point;
        let b = MatRef::from_column_major_slice(&x[k * k..], m, k);
        let rate = &point * b.transpose();
        rates.extend(rate.col_iter().flat_map(|column| column.iter().map(|x| -x)));
        points.push(point);
    }
    let mut normals = vec![0.0; (nodes.len() + 1) * size];
    if m > 0 {
        for normals in normals.chunks_exact_mut(size) {
            (0..m).for_each(|j| normals[k + j + r * j] = 1.0);
        }
        vectorised(
            #[inline(always)]
            || accumulate(&nodes.at[1], nodes.len(), &rates, size, &mut normals),
        );
    }
    let all = points.iter().enumerate();
    all.map(|(node, point)| {
        let normals = &normals[node * size..][..size];
        Mat::from_fn(r, r, |i, j| match j.checked_sub(k) {
            None => point[(i, j)],
            Some(j) => normals[i + r * j],
        })
    })
    .collect()
}
