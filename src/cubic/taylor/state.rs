//! The state of a Riemannian cubic at one time.

use faer::{Mat, MatMut, MatRef};

use super::blocks::{BlockSeries, BlockSizes, Sizes};
use super::initial::{Horizontal, add_bracket};
use crate::linalg::product::columns;

/// Frame and derivatives of a cubic at one time, blocks in column-major order.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) time: f64,
    pub(crate) blocks: Sizes,
    /// `s, e`, then `omega` and `b`, `omega'` and `b'`, `omega''` and `b''`.
    pub(crate) entries: Vec<f64>,
    /// `tau` of the additional term `tau x'` in `x'''` of a cubic in tension.
    pub(crate) tension: f64,
}

impl State {
    /// The state at time 0, from an orthogonal frame of shape `(r, r)` and `x, x', x''`.
    pub(crate) fn in_blocks(blocks: Sizes, g: &Mat<f64>, derivatives: [&Horizontal; 3]) -> Self {
        let Sizes { m, k, .. } = blocks;
        let r = m + k;
        let mut entries = Vec::with_capacity(r * (r + 3 * k));
        let matrices = derivatives.iter().flat_map(|x| [&x.omega, &x.normal]);
        for matrix in std::iter::once(g).chain(matrices) {
            for column in matrix.col_iter() {
                entries.extend(column.iter());
            }
        }
        State::of_entries(blocks, 0.0, entries)
    }

    /// The state at time 0, from initial data: `x'' = j - [v, a]_m / 2`.
    pub(crate) fn of_coordinates(blocks: Sizes, mut entries: Vec<f64>) -> Self {
        if blocks.are_subspaces() {
            // [m, m] is contained in h.
            return State::of_entries(blocks, 0.0, entries);
        }
        let Sizes { m, k, .. } = blocks;
        let r = m + k;
        let (_, vectors) = entries.split_at_mut(r * r);
        let (known, last) = vectors.split_at_mut(2 * r * k);
        let (x, a) = known.split_at(r * k);
        let [x, a] = [x, a].map(|x| {
            let (omega, normal) = x.split_at(k * k);
            [
                MatRef::from_column_major_slice(omega, k, k),
                MatRef::from_column_major_slice(normal, m, k),
            ]
        });
        let (omega, normal) = last.split_at_mut(k * k);
        let second = [
            MatMut::from_column_major_slice_mut(omega, k, k),
            MatMut::from_column_major_slice_mut(normal, m, k),
        ];
        add_bracket(second, -0.5, x, a);
        State::of_entries(blocks, 0.0, entries)
    }

    /// The state at a given time, from the blocks of the frame and of `x, x', x''`.
    pub(crate) fn of_entries(blocks: Sizes, time: f64, entries: Vec<f64>) -> Self {
        State {
            time,
            blocks,
            entries,
            tension: 0.0,
        }
    }

    /// The state of a curve in tension.
    pub(crate) fn in_tension(mut self, tension: f64) -> Self {
        self.tension = tension;
        self
    }

    /// The first `k` columns of the frame, shape `(r, k)`.
    pub(crate) fn s(&self) -> &[f64] {
        let Sizes { m, k, .. } = self.blocks;
        &self.entries[..(m + k) * k]
    }

    /// The other columns, shape `(r, m)`.
    pub(crate) fn e(&self) -> &[f64] {
        let Sizes { m, k, .. } = self.blocks;
        &self.entries[(m + k) * k..][..(m + k) * m]
    }

    /// `omega` or a derivative, shape `(k, k)`.
    pub(crate) fn omega(&self, derivative: usize) -> &[f64] {
        &self.entries[self.vector(derivative)..][..self.blocks.k * self.blocks.k]
    }

    /// `b` or a derivative, shape `(m, k)`.
    pub(crate) fn b(&self, derivative: usize) -> &[f64] {
        let Sizes { m, k, .. } = self.blocks;
        &self.entries[self.vector(derivative) + k * k..][..m * k]
    }

    /// `x, x', x''`.
    pub(crate) fn vectors(&self) -> [Horizontal; 3] {
        let Sizes { m, k, .. } = self.blocks;
        [0, 1, 2].map(|i| Horizontal::of_entries(&self.entries[self.vector(i)..][..(m + k) * k], k))
    }

    /// The frame, shape `(r, r)`.
    pub(crate) fn frame(&self) -> MatRef<'_, f64> {
        let r = self.blocks.m + self.blocks.k;
        columns(&self.entries[..r * r], r)
    }

    /// Index at which `x` or a derivative begins.
    fn vector(&self, derivative: usize) -> usize {
        let r = self.blocks.m + self.blocks.k;
        r * (r + derivative * self.blocks.k)
    }

    /// Loads the state as the start of a march.
    pub(crate) fn load(&self, blocks: impl BlockSizes, series: &mut BlockSeries<f64>) {
        let (k, m) = (blocks.k(), blocks.normals());
        let (rows, normals) = (blocks.r::<f64>(), blocks.m::<f64>());
        series.set_tension(self.tension);
        let parts = series.parts();
        copy_columns(parts.s, rows, self.s(), m + k, k);
        copy_columns(parts.e, rows, self.e(), m + k, m);
        for i in 0..3 {
            copy_columns(parts.omega[i], k, self.omega(i), k, k);
            copy_columns(parts.b[i], normals, self.b(i), m, k);
        }
    }

    /// Stores the state that a march has reached.
    pub(crate) fn store(&mut self, blocks: impl BlockSizes, series: &BlockSeries<f64>, time: f64) {
        let (k, m) = (blocks.k(), blocks.normals());
        let (rows, normals) = (blocks.r::<f64>(), blocks.m::<f64>());
        self.time = time;
        let (r, size) = (m + k, (m + k) * k);
        let (frame, vectors) = self.entries.split_at_mut(r * r);
        let (s, e) = frame.split_at_mut(size);
        copy_columns(s, r, series.s(), rows, k);
        copy_columns(e, r, series.e(), rows, m);
        for (i, vector) in vectors.chunks_exact_mut(size).enumerate() {
            let (omega, b) = vector.split_at_mut(k * k);
            if !blocks.are_subspaces() {
                copy_columns(omega, k, series.omega(i), k, k);
            }
            copy_columns(b, m, series.b(i), normals, k);
        }
    }
}

/// Copies `cols` columns between blocks with different numbers of rows; as many rows as both have.
fn copy_columns(to: &mut [f64], to_rows: usize, from: &[f64], from_rows: usize, cols: usize) {
    let rows = to_rows.min(from_rows);
    for col in 0..cols {
        to[to_rows * col..][..rows].copy_from_slice(&from[from_rows * col..][..rows]);
    }
}
