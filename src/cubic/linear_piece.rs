//! Variations of a cubic by those of points and velocities at its ends, forward and transposed, from one linear system.
//!
//! A variation of the ends is told by displacements `u` and by what is left of the velocities beside the rotations that make
//! them, `dV = A(u) V + w`; all are tangent vectors, shape `(n, k)`. In the span of the curve they obey one system, and every row
//! outside of it another one, of `4k` equations.

use faer::{Mat, MatRef, Scale};

use super::end_response::{blocks_of, row_matrix, row_variations};
use super::end_stiffness::{EndStiffness, product};
use super::initial::{Horizontal, InitialData};
use super::problem::{pack, unpack};
use super::pull_back::{collected_of, off, row_bars};
use super::variation::vary;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// A cubic, linearised.
#[derive(Debug, Clone)]
pub(crate) struct LinearPiece {
    data: InitialData,
    /// The frame at the end, in the coordinates of the frame at the start.
    turn: Mat<f64>,
    inner: EndStiffness,
    outer: Option<EndStiffness>,
}

/// A tangent vector: coordinates in the frame of the span, and the rows outside of it, shape `(n, k)`.
struct Split {
    inner: Vec<f64>,
    rows: Option<Mat<f64>>,
}

impl LinearPiece {
    /// From point, velocity, covariant acceleration and covariant jerk at the start, shape `(n, k)`, and the tension; on `[0, 1]`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`,
    /// `Interrupted`.
    pub(crate) fn new(
        [s, v, a, j]: [MatRef<'_, f64>; 4],
        tension: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let data = InitialData::new(s, v, a, j)?.in_tension(tension);
        let (inner, turn) = EndStiffness::in_span(&data, 1.0, interrupt)?;
        let outer = match data.frame {
            Some(_) => Some(EndStiffness::of_row(&data, 1.0, interrupt)?),
            None => None,
        };
        Ok(LinearPiece {
            data,
            turn,
            inner,
            outer,
        })
    }

    /// The change of `(x''_0, -x'_0, -x''_1, x'_1)`, the gradient of half the cost, by `(u_0, w_0, u_1, w_1)`: tangent vectors. In
    /// tension `x'' - tau x` takes the place of `x''`.
    pub(crate) fn stiffness(&self, z: &[Mat<f64>; 4]) -> [Mat<f64>; 4] {
        let found = self.split_stiffness(z);
        let mut part = 0;
        let mut lifted = found.map(|split| {
            let lifted = self.join(part / 2, &split);
            part += 1;
            lifted
        });
        if self.data.tension != 0.0 {
            lifted[0] -= &z[1] * Scale(self.data.tension);
            lifted[2] += &z[3] * Scale(self.data.tension);
        }
        lifted
    }

    /// The variations of the points at some times, for `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn points(
        &self,
        z: &[Mat<f64>; 4],
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let blocks = blocks_of(&self.data);
        let (k, start) = (blocks.k, [0, 1].map(|part| self.split(0, &z[part])));
        let ends = self.split_stiffness(z);
        let [u] = unpack(&start[0].inner, blocks);
        let [x] = unpack(&start[1].inner, blocks);
        let [second] = unpack(&ends[0].inner, blocks);
        let [minus_a] = unpack(&ends[1].inner, blocks);
        let a = Horizontal::zeros(blocks).plus(-1.0, &minus_a);
        let found = vary::<1>(&self.data, 0, &[[x, a, second]], times, interrupt)?;
        let turn = u.matrix();
        let mut out: Vec<Mat<f64>> = found
            .iter()
            .map(|slopes| self.up(&(&turn * slopes.frame.subcols(0, k) + &slopes.points[0])))
            .collect();
        if let (Some(u), Some(x)) = (&start[0].rows, &start[1].rows) {
            let rows = row_variations(blocks);
            let found = vary::<8>(&self.data, 1, &rows, times, interrupt)?;
            let [second, minus_a] = [0, 1].map(|part| ends[part].rows.as_ref().expect("as z"));
            for (out, slopes) in out.iter_mut().zip(&found) {
                let matrix = row_matrix(slopes);
                let block = |level: usize| matrix.submatrix(0, level * k, k, k).transpose();
                *out += u * slopes.frame.submatrix(0, 0, k, k) + x * block(0);
                *out += second * block(2) - minus_a * block(1);
            }
        }
        Ok(out)
    }

    /// The gradient by `(u_0, w_0, u_1, w_1)`, tangent vectors, of a sum of products of entries of cotangents with the points at
    /// some times.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let [p, w, a, b] = collected_of(&self.data, times, cotangents, interrupt)?;
        let d = self.inner.matrix.nrows() / 4;
        let mut z = pack(&[p, w]);
        z.resize(4 * d, 0.0);
        let forces = product(self.inner.matrix.as_ref(), &z);
        let mut inner: Vec<f64> = forces.iter().map(|x| -x).collect();
        for (out, x) in inner.iter_mut().zip(pack(&[b])) {
            *out += x;
        }
        for (out, x) in inner[d..].iter_mut().zip(pack(&[a])) {
            *out -= x;
        }
        let rows = self.pull_back_rows(times, cotangents, interrupt)?;
        let mut rows = rows.map_or([const { None }; 4], |rows| rows.map(Some));
        Ok(std::array::from_fn(|part| {
            let split = Split {
                inner: inner[part * d..][..d].to_vec(),
                rows: rows[part].take(),
            };
            self.join(part / 2, &split)
        }))
    }

    fn pull_back_rows(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<[Mat<f64>; 4]>> {
        let Some(outer) = &self.outer else {
            return Ok(None);
        };
        let k = blocks_of(&self.data).k;
        let bars = row_bars(&self.data, times, cotangents, interrupt)?;
        let block = |row: usize, column: usize| outer.matrix.submatrix(row * k, column * k, k, k);
        Ok(Some(std::array::from_fn(|part| {
            let mut out = &bars[3] * block(0, part) - &bars[2] * block(1, part);
            if part < 2 {
                out += &bars[part];
            }
            out
        })))
    }

    /// One of four times four blocks of the same matrix for a row outside of the span, shape `(k, k)`; it multiplies columns.
    /// `None` where the span is all of `R^n`.
    pub(crate) fn row_block(&self, row: usize, column: usize) -> Option<MatRef<'_, f64>> {
        let outer = self.outer.as_ref()?;
        let k = outer.matrix.nrows() / 4;
        Some(outer.matrix.submatrix(row * k, column * k, k, k))
    }

    fn split_stiffness(&self, z: &[Mat<f64>; 4]) -> [Split; 4] {
        let parts: [Split; 4] = std::array::from_fn(|part| self.split(part / 2, &z[part]));
        let packed = parts.each_ref().map(|part| part.inner.as_slice()).concat();
        let found = product(self.inner.matrix.as_ref(), &packed);
        let d = packed.len() / 4;
        std::array::from_fn(|row| Split {
            inner: found[row * d..][..d].to_vec(),
            rows: self.outer.as_ref().map(|outer| {
                let k = outer.matrix.nrows() / 4;
                let mut sum = Mat::zeros(z[0].nrows(), k);
                for (column, part) in parts.iter().enumerate() {
                    let block = outer.matrix.submatrix(row * k, column * k, k, k);
                    sum += part.rows.as_ref().expect("outer") * block.transpose();
                }
                sum
            }),
        })
    }

    fn split(&self, end: usize, v: &Mat<f64>) -> Split {
        let low = self.down(v.as_ref());
        let vector = match end {
            0 => Horizontal::of_tangent(
                Mat::identity(low.nrows(), low.nrows()).as_ref(),
                low.as_ref(),
            ),
            _ => Horizontal::of_tangent(self.turn.as_ref(), low.as_ref()),
        };
        Split {
            inner: pack(&[vector]),
            rows: self.outer.as_ref().map(|_| off(&self.data, v.as_ref())),
        }
    }

    fn join(&self, end: usize, split: &Split) -> Mat<f64> {
        let [vector] = unpack(&split.inner, blocks_of(&self.data));
        let low = match end {
            0 => vector.tangent(),
            _ => &self.turn * vector.tangent(),
        };
        let inside = self.up(&low);
        match &split.rows {
            Some(rows) => inside + rows,
            None => inside,
        }
    }

    /// Coordinates in the frame at the start.
    fn down(&self, d: MatRef<'_, f64>) -> Mat<f64> {
        match &self.data.frame {
            Some(e) => self.data.g.transpose() * (e.transpose() * d),
            None => self.data.g.transpose() * d,
        }
    }

    fn up(&self, low: &Mat<f64>) -> Mat<f64> {
        let inner = &self.data.g * low;
        match &self.data.frame {
            Some(e) => e * inner,
            None => inner,
        }
    }
}
