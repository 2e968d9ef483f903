//! A linearised cubic: variations in terms of those of points and velocities at its ends, forward and transposed.
//!
//! A variation of the ends is described by displacements `u` and by the rest of the velocities' variation, relative to
//! the rotations that cause the displacements: `dV = A(u) V + w`. All are tangent vectors, shape `(n, k)`. In the span
//! of the curve they satisfy one linear system, and every row outside it satisfies another one, of `4k` equations.

use faer::{Mat, MatRef, Scale};

use super::blocks::Sized;
use super::end_stiffness::end_stiffness;
use super::initial::Horizontal;
use super::linear_flow::{LinearFlow, VARIATION, side_by_side};
use super::linear_series::{LinearSeries, rows_outside};
use super::packing::{pack, unpack};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::{check_range, row_by_row};
use crate::space::Quotient;

/// Dimension up to which the series are kept, for variations of points. Above it they would take more memory than
/// everything else, and variations of points are integrated.
pub(crate) const DENSE: usize = 64;

/// A cubic on `[0, 1]`, linearised.
#[derive(Debug)]
pub(crate) struct LinearPiece {
    flow: LinearFlow,
    /// The frame at the end, shape `(n, r)`.
    end: Mat<f64>,
    series: Option<LinearSeries>,
    /// The second derivative of half the cost in the span, shape `(4 d, 4 d)`.
    inner: Mat<f64>,
    /// The second derivative of half the cost for a row outside the span, shape `(4 k, 4 k)`; `None` if the span is all
    /// of `R^n`.
    outer: Option<Mat<f64>>,
}

impl LinearPiece {
    /// Linearises one cubic.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub(super) fn new(flow: LinearFlow, interrupt: Interrupt<'_>) -> Result<Self> {
        let series = LinearSeries::new(&flow, interrupt)?;
        Self::of_series(flow, series)
    }

    /// Linearises several cubics on one manifold, eight at once if that is quicker, from point, velocity, covariant
    /// acceleration and covariant jerk at their starts, shape `(n, k)`, and their tensions.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, and the errors of [`LinearPiece::new`].
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
            outer: flow.has_rows().then(outer).transpose()?,
            end: series.end(&flow),
            inner: end_stiffness(&inside)?,
            series: (flow.blocks().dim() <= DENSE).then_some(series),
            flow,
        })
    }

    /// The change of the gradient of half the cost, `(x''_0, -x'_0, -x''_1, x'_1)`, for `(u_0, w_0, u_1, w_1)`, as
    /// tangent vectors; in tension with `x'' - tau x` in place of `x''`.
    pub(crate) fn stiffness(&self, z: &[Mat<f64>; 4]) -> [Mat<f64>; 4] {
        let mut out = self.product(z, |matrix| matrix.as_ref());
        out[0] -= &z[1] * self.tension();
        out[2] += &z[3] * self.tension();
        out
    }

    /// The product of the second derivative, optionally transposed, with two tangent vectors at the start and two at
    /// the end.
    fn product(
        &self,
        z: &[Mat<f64>; 4],
        view: impl Fn(&Mat<f64>) -> MatRef<'_, f64>,
    ) -> [Mat<f64>; 4] {
        self.lifted(&self.multiplied(&view(&self.inner), z), z, view)
    }

    /// The components in the span of two tangent vectors at the start and two at the end.
    fn inside(&self, z: &[Mat<f64>; 4]) -> [Horizontal; 4] {
        let frames = self.frames();
        std::array::from_fn(|i| Horizontal::of_tangent(frames[i].as_ref(), z[i].as_ref()))
    }

    /// The product of a matrix in the span with these components.
    fn multiplied(&self, matrix: &MatRef<'_, f64>, z: &[Mat<f64>; 4]) -> [Horizontal; 4] {
        let blocks = self.flow.blocks();
        let packed = pack(blocks, &self.inside(z));
        let found = matrix * MatRef::from_column_major_slice(&packed, packed.len(), 1);
        unpack(found.col_as_slice(0), blocks)
    }

    /// Tangent vectors from their components in the span and the rows outside it.
    fn lifted(
        &self,
        found: &[Horizontal; 4],
        z: &[Mat<f64>; 4],
        view: impl Fn(&Mat<f64>) -> MatRef<'_, f64>,
    ) -> [Mat<f64>; 4] {
        let frames = self.frames();
        let mut out: [Mat<f64>; 4] = std::array::from_fn(|i| frames[i] * found[i].tangent());
        if let Some(outer) = &self.outer {
            let z = z.each_ref().map(|x| x.as_ref());
            let rows = self.flow.off(side_by_side(&z)) * view(outer).transpose();
            let k = self.flow.blocks().k;
            for (part, out) in out.iter_mut().enumerate() {
                *out += rows.subcols(part * k, k);
            }
        }
        out
    }

    /// The frame at the end, shape `(n, r)`.
    #[cfg(test)]
    pub(super) fn end(&self) -> &Mat<f64> {
        &self.end
    }

    fn frames(&self) -> [&Mat<f64>; 4] {
        [&self.flow.frame, &self.flow.frame, &self.end, &self.end]
    }

    /// The changes of `x'` and `x''` at the start for `(u_0, w_0, u_1, w_1)`.
    pub(crate) fn at_start(&self, z: &[Mat<f64>; 4]) -> [Mat<f64>; 2] {
        let [pull, minus_a, ..] = self.stiffness(z);
        [-minus_a, pull + &z[1] * self.tension()]
    }

    fn tension(&self) -> Scale<f64> {
        Scale(self.flow.data.tension)
    }

    /// The variations of the points at given times for `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// `Overflow`; for times outside `[0, 1]`, and above [`DENSE`] dimensions, also `TooManySteps`, `Interrupted`.
    pub(crate) fn points(
        &self,
        z: &[Mat<f64>; 4],
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let [a, b] = self.at_start(z);
        let start = [z[0].clone(), z[1].clone(), a, b];
        let Some(series) = &self.series else {
            return self.flow.points(&start, times, interrupt);
        };
        let beyond: Vec<f64> = times.iter().copied().filter(|t| !is_on(*t)).collect();
        let mut beyond = self.flow.points(&start, &beyond, interrupt)?.into_iter();
        let rows = rows_outside(&self.flow, &start);
        let start = start
            .each_ref()
            .map(|x| Horizontal::of_tangent(self.flow.frame.as_ref(), x.as_ref()));
        let start = pack(self.flow.blocks(), &start);
        let point = |t: &f64| {
            let point = match is_on(*t) {
                true => series.point(&self.flow, *t, &start, rows.as_ref()),
                false => beyond.next().expect("a point for every time beyond"),
            };
            check_range(VARIATION, point.as_ref())?;
            Ok(point)
        };
        times.iter().map(point).collect()
    }

    /// The gradient with respect to `(u_0, w_0, u_1, w_1)`, as tangent vectors, of `sum tr(W^T S(t))` over cotangents
    /// `W` at given times `t`.
    ///
    /// # Errors
    /// As [`LinearPiece::points`].
    pub(crate) fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let Some(series) = &self.series else {
            return self.pull_back_by_products(times, cotangents, interrupt);
        };
        let loads = times.iter().copied().zip(cotangents.iter().copied());
        let (mut on, beyond): (Vec<Load<'_>>, Vec<Load<'_>>) =
            loads.partition(|load| is_on(load.0));
        on.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut by_start = series.pull_back(&self.flow, &on);
        if !beyond.is_empty() {
            let (times, cotangents): (Vec<f64>, Vec<MatRef<'_, f64>>) = beyond.into_iter().unzip();
            let eta = self.flow.collected(&times, &cotangents, interrupt)?;
            for (sum, part) in by_start.iter_mut().zip(self.flow.gradient(&eta)) {
                *sum += part;
            }
        }
        // The changes `(a, b)` at the start follow from the changes of the ends, as in `at_start`.
        let [by_p, by_w, by_a, by_b] = by_start;
        let zero = Mat::zeros(by_p.nrows(), by_p.ncols());
        let forces = [by_b, -by_a, zero.clone(), zero];
        let mut out = self.product(&forces, |matrix| matrix.transpose());
        out[0] += by_p;
        out[1] += by_w;
        Ok(out)
    }

    /// The same without series: a second variation, of the ends, is added to the variation that collects the cotangents
    /// so that the sum vanishes at the end; the accelerations of the sum are the gradient.
    fn pull_back_by_products(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let [p, w, a, b] = self.flow.collected(times, cotangents, interrupt)?;
        let zero = Mat::zeros(p.nrows(), p.ncols());
        let pull = b - &w * self.tension();
        let [f, g, h, i] = self.stiffness(&[p, w, zero.clone(), zero]);
        Ok([pull - f, -a - g, -h, -i])
    }

    /// The second derivative of half the cost with respect to the velocities at both ends (rows and columns), in frames
    /// of shape `(n, r)` whose span contains the curve; shape `(d, d)` each, in row-major order.
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
            row_by_row(out.as_ref()).collect()
        })
    }

    /// The same for a row outside the span of both frames, shape `(k, k)` each; `None` if the span is all of `R^n`.
    pub(crate) fn by_velocity_rows(&self) -> Option<[[Vec<f64>; 2]; 2]> {
        let outer = self.outer.as_ref()?;
        Some(by_ends(|row, column| {
            row_by_row(block(outer, row, column)).collect()
        }))
    }
}

/// A time and a cotangent there.
pub(super) type Load<'a> = (f64, MatRef<'a, f64>);

pub(super) fn is_on(t: f64) -> bool {
    (0.0..=1.0).contains(&t)
}

fn by_ends<T>(part: impl Fn(usize, usize) -> T) -> [[T; 2]; 2] {
    [[part(0, 0), part(0, 1)], [part(1, 0), part(1, 1)]]
}

/// The block belonging to the velocities at two ends.
fn block(matrix: &Mat<f64>, row: usize, column: usize) -> MatRef<'_, f64> {
    let d = matrix.nrows() / 4;
    matrix.submatrix((2 * row + 1) * d, (2 * column + 1) * d, d, d)
}
