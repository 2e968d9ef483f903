//! A cubic linearised: variations by those of points and velocities at its ends, forward and transposed.
//!
//! A variation of the ends is told by displacements `u` and by what is left of the velocities beside the rotations that make
//! them, `dV = A(u) V + w`; all are tangent vectors, shape `(n, k)`. In the span of the curve they obey one system, and every row
//! outside of it another one, of `4k` equations.

use std::sync::Arc;

use faer::{Mat, MatRef, Scale};

use super::end_stiffness::end_stiffness;
use super::initial::Horizontal;
use super::linear_flow::{LinearFlow, side_by_side};
use super::linear_series::{LinearSeries, rows_outside};
use super::packing::{pack, unpack};
use super::reduced::Sized;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::space::Quotient;

/// A cubic on `[0, 1]`, linearised.
#[derive(Debug, Clone)]
pub(crate) struct LinearPiece {
    flow: LinearFlow,
    series: Arc<LinearSeries>,
    /// The frame at the end, shape `(n, r)`.
    end: Mat<f64>,
    /// The second derivative of half the cost in the span, shape `(4 d, 4 d)`.
    inner: Mat<f64>,
    /// The same for a row outside of the span, shape `(4 k, 4 k)`; `None` where the span is all of `R^n`.
    outer: Option<Mat<f64>>,
}

impl LinearPiece {
    /// From point, velocity, covariant acceleration and covariant jerk at the start, shape `(n, k)`, and the tension.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`,
    /// `Interrupted`.
    pub(crate) fn new(
        state: [MatRef<'_, f64>; 4],
        tension: f64,
        quotient: Quotient,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let flow = LinearFlow::new(state, tension, quotient)?;
        let series = LinearSeries::new(&flow, 1.0, interrupt)?;
        Self::of_series(flow, series)
    }

    /// Of several cubics on one manifold, linearised eight abreast where that is quicker.
    ///
    /// # Errors
    /// As [`LinearPiece::new`].
    pub(crate) fn all(
        states: &[[MatRef<'_, f64>; 4]],
        tensions: &[f64],
        quotient: Quotient,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Self>> {
        let flows = states.iter().zip(tensions);
        let flows = flows.map(|(state, tension)| LinearFlow::new(*state, *tension, quotient));
        let flows: Vec<LinearFlow> = flows.collect::<Result<_>>()?;
        let series = LinearSeries::all(&flows, interrupt)?;
        let pieces = flows.into_iter().zip(series);
        pieces
            .map(|(flow, series)| Self::of_series(flow, series))
            .collect()
    }

    fn of_series(flow: LinearFlow, series: LinearSeries) -> Result<Self> {
        let [inside, row] = series.flows();
        let outer = || end_stiffness(&row);
        Ok(LinearPiece {
            inner: end_stiffness(&inside)?,
            outer: flow.has_rows().then(outer).transpose()?,
            end: series.end(&flow),
            series: Arc::new(series),
            flow,
        })
    }

    /// The change of the gradient of half the cost, `(x''_0, -x'_0, -x''_1, x'_1)` with `x'' - tau x` for `x''` in tension, by
    /// `(u_0, w_0, u_1, w_1)`: tangent vectors.
    pub(crate) fn stiffness(&self, z: &[Mat<f64>; 4]) -> [Mat<f64>; 4] {
        let mut out = self.product(
            z,
            [&self.inner, self.outer.as_ref().unwrap_or(&self.inner)].map(|x| x.as_ref()),
        );
        out[0] -= &z[1] * self.tension();
        out[2] += &z[3] * self.tension();
        out
    }

    /// The product of matrices in the span and for a row outside of it with tangent vectors at the start, twice, and at the end,
    /// twice.
    fn product(&self, z: &[Mat<f64>; 4], [inner, outer]: [MatRef<'_, f64>; 2]) -> [Mat<f64>; 4] {
        let z = z.each_ref().map(|x| x.as_ref());
        let (frames, blocks) = (self.frames(), self.flow.blocks());
        let inside: [Horizontal; 4] =
            std::array::from_fn(|i| Horizontal::of_tangent(frames[i].as_ref(), z[i]));
        let packed = pack(blocks, &inside);
        let found = inner * MatRef::from_column_major_slice(&packed, packed.len(), 1);
        let found: [Horizontal; 4] = unpack(found.col_as_slice(0), blocks);
        let mut out: [Mat<f64>; 4] = std::array::from_fn(|i| frames[i] * found[i].tangent());
        if self.outer.is_some() {
            let rows = self.flow.off(side_by_side(&z)) * outer.transpose();
            let k = blocks.k;
            for (part, out) in out.iter_mut().enumerate() {
                *out += rows.subcols(part * k, k);
            }
        }
        out
    }

    fn frames(&self) -> [&Mat<f64>; 4] {
        [&self.flow.frame, &self.flow.frame, &self.end, &self.end]
    }

    /// The changes of `x'` and `x''` at the start, by `(u_0, w_0, u_1, w_1)`.
    pub(crate) fn at_start(&self, z: &[Mat<f64>; 4]) -> [Mat<f64>; 2] {
        let [pull, minus_a, ..] = self.stiffness(z);
        [-minus_a, pull + &z[1] * self.tension()]
    }

    fn tension(&self) -> Scale<f64> {
        Scale(self.flow.data.tension)
    }

    /// The variations of the points at some times, for `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// For times outside of `[0, 1]` `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn points(
        &self,
        z: &[Mat<f64>; 4],
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let [a, b] = self.at_start(z);
        let start = [z[0].clone(), z[1].clone(), a, b];
        let (beyond, rows) = (
            self.beyond(times, interrupt)?,
            rows_outside(&self.flow, &start),
        );
        let start = start
            .each_ref()
            .map(|x| Horizontal::of_tangent(self.flow.frame.as_ref(), x.as_ref()));
        let start = pack(self.flow.blocks(), &start);
        let point = |t: &f64| {
            let series = self.series_at(*t, &beyond);
            series.point(&self.flow, *t, &start, rows.as_ref())
        };
        Ok(times.iter().map(point).collect())
    }

    /// The gradient by `(u_0, w_0, u_1, w_1)`, tangent vectors, of a sum of products of entries of cotangents with the points at
    /// some times.
    ///
    /// # Errors
    /// As [`LinearPiece::points`].
    pub(crate) fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let beyond = self.beyond(times, interrupt)?;
        let mut loads: Vec<(f64, MatRef<'_, f64>)> = times
            .iter()
            .copied()
            .zip(cotangents.iter().copied())
            .collect();
        loads.sort_by(|one, other| one.0.total_cmp(&other.0));
        let side = |t: f64| (t >= 0.0, t > 1.0);
        let (n, k) = (self.flow.frame.nrows(), self.flow.blocks().k);
        let mut by_start: [Mat<f64>; 4] = std::array::from_fn(|_| Mat::zeros(n, k));
        for loads in loads.chunk_by(|one, other| side(one.0) == side(other.0)) {
            let found = self
                .series_at(loads[0].0, &beyond)
                .pull_back(&self.flow, loads);
            for (sum, part) in by_start.iter_mut().zip(found) {
                *sum += part;
            }
        }
        let [by_p, by_w, by_a, by_b] = by_start;
        // The changes `(a, b)` at the start follow from those of the ends: `at_start`.
        let zero = Mat::zeros(n, k);
        let forces = [by_b, -by_a, zero.clone(), zero];
        let outer = self.outer.as_ref().unwrap_or(&self.inner);
        let mut out = self.product(&forces, [self.inner.transpose(), outer.transpose()]);
        out[0] += by_p;
        out[1] += by_w;
        Ok(out)
    }

    /// Series that go on beyond the ends, before the start and after the end.
    fn beyond(&self, times: &[f64], interrupt: Interrupt<'_>) -> Result<[Option<LinearSeries>; 2]> {
        let first = times.iter().copied().fold(0.0, f64::min);
        let last = times.iter().copied().fold(1.0, f64::max);
        let series = |until: f64| LinearSeries::new(&self.flow, until, interrupt);
        Ok([
            (first < 0.0).then(|| series(first)).transpose()?,
            (last > 1.0).then(|| series(last)).transpose()?,
        ])
    }

    fn series_at<'a>(
        &'a self,
        t: f64,
        [before, after]: &'a [Option<LinearSeries>; 2],
    ) -> &'a LinearSeries {
        let beyond = match (t < 0.0, t > 1.0) {
            (true, _) => before.as_ref(),
            (_, true) => after.as_ref(),
            _ => None,
        };
        beyond.unwrap_or(&self.series)
    }

    /// The second derivative of half the cost by the velocities at both ends, rows and columns, in frames there of shape `(n, r)`
    /// that span the curve and more; shape `(d, d)` each, row by row.
    pub(crate) fn by_velocities(&self, frames: [&Mat<f64>; 2]) -> [[Vec<f64>; 2]; 2] {
        let Sized { m, k, quotient, .. } = self.flow.blocks();
        let (wide, half) = (frames[0].ncols() - k, quotient.turns(k));
        let (own, given) = (half + m * k, half + wide * k);
        let normals = frames.map(|frame| frame.subcols(k, wide));
        let carried: [Mat<f64>; 2] = std::array::from_fn(|end| {
            let frame = [&self.flow.frame, &self.end][end];
            let low = frame.subcols(k, m).transpose() * normals[end];
            Mat::from_fn(own, given, |i, j| {
                match (i.checked_sub(half), j.checked_sub(half)) {
                    (None, None) if i == j => 1.0,
                    (Some(i), Some(j)) if i / m == j / wide => low[(i % m, j % wide)],
                    _ => 0.0,
                }
            })
        });
        by_ends(|row, column| {
            let inner = block(&self.inner, row, column) * &carried[column];
            let mut out = carried[row].transpose() * inner;
            if let Some(outer) = &self.outer {
                let off = normals[row].transpose() * self.flow.off(normals[column].to_owned());
                let outer = block(outer, row, column);
                for (i, j) in (0..wide * k).flat_map(|i| (0..wide * k).map(move |j| (i, j))) {
                    out[(half + i, half + j)] +=
                        off[(i % wide, j % wide)] * outer[(i / wide, j / wide)];
                }
            }
            entries(out.as_ref())
        })
    }

    /// The same for a row outside of the span of both frames, shape `(k, k)` each; `None` where the span is all of `R^n`.
    pub(crate) fn by_velocity_rows(&self) -> Option<[[Vec<f64>; 2]; 2]> {
        let outer = self.outer.as_ref()?;
        Some(by_ends(|row, column| entries(block(outer, row, column))))
    }
}

fn by_ends<T>(part: impl Fn(usize, usize) -> T) -> [[T; 2]; 2] {
    [[part(0, 0), part(0, 1)], [part(1, 0), part(1, 1)]]
}

/// The block of the velocities at two ends.
fn block(matrix: &Mat<f64>, row: usize, column: usize) -> MatRef<'_, f64> {
    let d = matrix.nrows() / 4;
    matrix.submatrix((2 * row + 1) * d, (2 * column + 1) * d, d, d)
}

/// Row by row.
fn entries(matrix: MatRef<'_, f64>) -> Vec<f64> {
    let rows = matrix.row_iter();
    rows.flat_map(|row| row.iter()).copied().collect()
}
