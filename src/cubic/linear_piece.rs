//! A cubic linearised: variations by those of points and velocities at its ends, forward and transposed.
//!
//! A variation of the ends is told by displacements `u` and by what is left of the velocities beside the rotations that make
//! them, `dV = A(u) V + w`; all are tangent vectors, shape `(n, k)`. In the span of the curve they obey one system, and every row
//! outside of it another one, of `4k` equations.

use std::borrow::Cow;

use faer::{Mat, MatRef, Scale};

use super::end_stiffness::{end_forces, end_stiffness};
use super::initial::Horizontal;
use super::linear_flow::{LinearFlow, Part, side_by_side};
use super::packing::{pack, unpack};
use super::reduced::Sized;
use super::variation::vary;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::space::Quotient;

/// Unknowns up to which the matrix in the span is formed; above, products with it are cheaper (as for shooting).
const DENSE: usize = 64;

/// A cubic on `[0, 1]`, linearised.
#[derive(Debug, Clone)]
pub(crate) struct LinearPiece {
    flow: LinearFlow,
    /// The frame at the end, shape `(n, r)`.
    end: Mat<f64>,
    /// The second derivative of half the cost in the span, shape `(4 d, 4 d)`; `None` where products are cheaper.
    inner: Option<Mat<f64>>,
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
        let unknowns = 2 * flow.blocks().dim();
        let (turn, inner) = if unknowns <= DENSE {
            let (turn, matrix) = flow.unit_flows(Part::Span, &[1.0], interrupt)?.remove(0);
            (turn, Some(end_stiffness(&matrix)?))
        } else {
            let reached = vary::<1>(&flow.data, 0, &[], &[1.0], interrupt)?.remove(0);
            (reached.frame, None)
        };
        let row = || end_stiffness(&flow.unit_flows(Part::Row, &[1.0], interrupt)?[0].1);
        let outer = flow.has_rows().then(row).transpose()?;
        Ok(LinearPiece {
            end: &flow.frame * turn,
            flow,
            inner,
            outer,
        })
    }

    /// The same with the matrix in the span stored, for many products.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub(crate) fn with_matrix(mut self, interrupt: Interrupt<'_>) -> Result<Self> {
        self.inner = Some(self.matrix(interrupt)?.into_owned());
        Ok(self)
    }

    fn matrix(&self, interrupt: Interrupt<'_>) -> Result<Cow<'_, Mat<f64>>> {
        if let Some(matrix) = &self.inner {
            return Ok(Cow::Borrowed(matrix));
        }
        let flows = self.flow.unit_flows(Part::Span, &[1.0], interrupt)?;
        Ok(Cow::Owned(end_stiffness(&flows[0].1)?))
    }

    /// The change of the gradient of half the cost, `(x''_0, -x'_0, -x''_1, x'_1)` with `x'' - tau x` for `x''` in tension, by
    /// `(u_0, w_0, u_1, w_1)`: tangent vectors.
    ///
    /// # Errors
    /// Without the matrix in the span, those of [`LinearPiece::with_matrix`].
    pub(crate) fn stiffness(
        &self,
        z: &[Mat<f64>; 4],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let z = z.each_ref().map(|x| x.as_ref());
        let frames = [&self.flow.frame, &self.flow.frame, &self.end, &self.end];
        let inside: [Horizontal; 4] =
            std::array::from_fn(|i| Horizontal::of_tangent(frames[i].as_ref(), z[i]));
        let by_products = match &self.inner {
            Some(_) => None,
            None => end_forces(&self.flow, inside.clone(), interrupt)?,
        };
        let found: [Horizontal; 4] = match by_products {
            Some(found) => found,
            None => {
                let z = pack(self.flow.blocks(), &inside);
                let z = MatRef::from_column_major_slice(&z, z.len(), 1);
                let found = &*self.matrix(interrupt)? * z;
                unpack(found.col_as_slice(0), self.flow.blocks())
            }
        };
        let mut out: [Mat<f64>; 4] = std::array::from_fn(|i| frames[i] * found[i].tangent());
        if let Some(outer) = &self.outer {
            let rows = self.flow.off(side_by_side(&z)) * outer.transpose();
            let k = outer.nrows() / 4;
            for (part, out) in out.iter_mut().enumerate() {
                *out += rows.subcols(part * k, k);
            }
        }
        out[0] -= z[1] * self.tension();
        out[2] += z[3] * self.tension();
        Ok(out)
    }

    /// The changes of `x'` and `x''` at the start, by `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// As [`LinearPiece::stiffness`].
    pub(crate) fn at_start(
        &self,
        z: &[Mat<f64>; 4],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 2]> {
        let [pull, minus_a, ..] = self.stiffness(z, interrupt)?;
        Ok([-minus_a, pull + &z[1] * self.tension()])
    }

    fn tension(&self) -> Scale<f64> {
        Scale(self.flow.data.tension)
    }

    /// The variations of the points at some times, for `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`, and as [`LinearPiece::stiffness`].
    pub(crate) fn points(
        &self,
        z: &[Mat<f64>; 4],
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let [a, b] = self.at_start(z, interrupt)?;
        let start = [z[0].clone(), z[1].clone(), a, b];
        self.flow.points(&start, times, interrupt)
    }

    /// The gradient by `(u_0, w_0, u_1, w_1)`, tangent vectors, of a sum of products of entries of cotangents with the points at
    /// some times.
    ///
    /// The variation that collects the cotangents is made to vanish at the end by one more, of the ends: the accelerations of both
    /// are the gradient.
    ///
    /// # Errors
    /// As [`LinearPiece::points`].
    pub(crate) fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let [p, w, a, b] = self.flow.collected(times, cotangents, interrupt)?;
        let zero = Mat::zeros(p.nrows(), p.ncols());
        let pull = b - &w * self.tension();
        let [f, g, h, i] = self.stiffness(&[p, w, zero.clone(), zero], interrupt)?;
        Ok([pull - f, -a - g, -h, -i])
    }

    /// The second derivative of half the cost by the velocities at both ends, rows and columns, in frames there of shape `(n, r)`
    /// that span the curve and more; shape `(d, d)` each, row by row.
    ///
    /// # Errors
    /// Those of [`LinearPiece::with_matrix`].
    pub(crate) fn by_velocities(
        &self,
        frames: [&Mat<f64>; 2],
        interrupt: Interrupt<'_>,
    ) -> Result<[[Vec<f64>; 2]; 2]> {
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
        let matrix = self.matrix(interrupt)?;
        Ok(by_ends(|row, column| {
            let inner = block(&matrix, row, column) * &carried[column];
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
        }))
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
