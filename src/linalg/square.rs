//! Square buffers in column-major order, and all loops over them except products.
//!
//! Rows and columns are padded with zeros to a multiple of [`LANES`], so that every loop over a whole buffer is a
//! single pass over a slice, and every tile is full; [`vectorised`] compiles it for the vector unit detected at run
//! time.

use faer::linalg::matmul::{matmul, triangular};
use faer::prelude::*;
use faer::{Accum, MatMut, MatRef, Par};
use triangular::BlockStructure::{Rectangular, TriangularLower};

use super::simd::vectorised;

/// Sizes are padded to a multiple of this, the width of a tile.
pub(crate) const LANES: usize = 8;

/// Size from which half of a symmetric product and its reflection cost less than the whole product.
const TRIANGULAR: usize = 80;

/// An `m x m` matrix in columns of padded length; the padding stays zero.
pub struct Square {
    m: usize,
    stride: usize,
    entries: Vec<f64>,
}

/// The symmetry of a product under transposition.
#[derive(Clone, Copy, PartialEq)]
pub enum Symmetry {
    Symmetric,
    Skew,
}

/// Columns of a tile.
pub(super) type Tile = [[f64; LANES]; LANES];

#[inline(always)]
pub(super) fn transposed(tile: &Tile) -> Tile {
    std::array::from_fn(|j| std::array::from_fn(|i| tile[i][j]))
}

impl Square {
    pub(crate) fn new(m: usize) -> Self {
        let stride = m.next_multiple_of(LANES);
        Square {
            m,
            stride,
            entries: vec![0.0; stride * stride],
        }
    }

    pub(crate) fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice_with_stride(&self.entries, self.m, self.m, self.stride)
    }

    pub(crate) fn view_mut(&mut self) -> MatMut<'_, f64> {
        let (m, stride) = (self.m, self.stride);
        MatMut::from_column_major_slice_with_stride_mut(&mut self.entries, m, m, stride)
    }

    /// All entries, including padding, in groups.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &[[f64; LANES]] {
        self.entries.as_chunks().0
    }

    /// All entries, including padding, in groups.
    #[inline(always)]
    pub(crate) fn lanes_mut(&mut self) -> &mut [[f64; LANES]] {
        self.entries.as_chunks_mut().0
    }

    #[inline(always)]
    pub(crate) fn col(&self, j: usize) -> &[f64] {
        &self.entries[j * self.stride..][..self.m]
    }

    #[inline(always)]
    pub(crate) fn col_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.entries[j * self.stride..][..self.m]
    }

    /// The first `rows` entries of a column, including padding.
    #[inline(always)]
    pub(crate) fn rows(&self, j: usize, rows: usize) -> &[f64] {
        &self.entries[j * self.stride..][..rows]
    }

    /// The first `rows` entries of a column, including padding.
    #[inline(always)]
    pub(crate) fn rows_mut(&mut self, j: usize, rows: usize) -> &mut [f64] {
        &mut self.entries[j * self.stride..][..rows]
    }

    /// Zeroes the leading `m x m` part and its padding.
    pub(crate) fn clear(&mut self, m: usize) {
        let rows = m.next_multiple_of(LANES);
        for j in 0..m {
            self.rows_mut(j, rows).fill(0.0);
        }
    }

    /// The first `rows` entries of columns `i < j`.
    #[inline(always)]
    pub(crate) fn two_mut(&mut self, i: usize, j: usize, rows: usize) -> (&mut [f64], &mut [f64]) {
        let (left, right) = self.entries.split_at_mut(j * self.stride);
        (&mut left[i * self.stride..][..rows], &mut right[..rows])
    }

    /// `count` columns, every second one starting at `first`.
    pub(crate) fn every_other(&self, first: usize, count: usize) -> MatRef<'_, f64> {
        let entries = &self.entries[first * self.stride..];
        MatRef::from_column_major_slice_with_stride(entries, self.m, count, 2 * self.stride)
    }

    /// `count` columns, every second one starting at `first`.
    pub(crate) fn every_other_mut(&mut self, first: usize, count: usize) -> MatMut<'_, f64> {
        let (m, stride) = (self.m, 2 * self.stride);
        let entries = &mut self.entries[first * self.stride..];
        MatMut::from_column_major_slice_with_stride_mut(entries, m, count, stride)
    }

    /// Number of tiles per side.
    #[inline(always)]
    pub(super) fn tiles(&self) -> usize {
        self.stride / LANES
    }

    #[inline(always)]
    pub(super) fn tile(&self, i: usize, j: usize) -> Tile {
        let groups = self.lanes();
        let count = self.tiles();
        std::array::from_fn(|c| groups[(j * LANES + c) * count + i])
    }

    #[inline(always)]
    pub(super) fn set_tile(&mut self, i: usize, j: usize, tile: &Tile) {
        let count = self.tiles();
        let groups = self.lanes_mut();
        for c in 0..LANES {
            groups[(j * LANES + c) * count + i] = tile[c];
        }
    }

    /// `alpha (A - A^T) / 2`, halved first, so that no intermediate result overflows; returns the sum of squares of
    /// `(A + A^T) / 2`.
    pub(crate) fn set_skew_part(&mut self, alpha: f64, a: MatRef<'_, f64>) -> f64 {
        let (a, alpha) = if a.row_stride() == 1 || a.col_stride() != 1 {
            (a, alpha)
        } else {
            (a.transpose(), -alpha)
        };
        let mut squares = [0.0; LANES];
        vectorised(
            #[inline(always)]
            || {
                for j in 0..self.tiles() {
                    for i in j..self.tiles() {
                        let below = tile_of(a, i, j);
                        let above = transposed(&tile_of(a, j, i));
                        // An off-diagonal tile counts twice.
                        let weight = if i == j { 1.0 } else { 2.0 };
                        let mut skew = [[0.0; LANES]; LANES];
                        for c in 0..LANES {
                            for l in 0..LANES {
                                let (x, y) = (0.5 * below[c][l], 0.5 * above[c][l]);
                                skew[c][l] = alpha * (x - y);
                                squares[l] += weight * ((x + y) * (x + y));
                            }
                        }
                        self.set_tile(i, j, &skew);
                        if i > j {
                            let opposite = transposed(&skew).map(|column| column.map(|x| -x));
                            self.set_tile(j, i, &opposite);
                        }
                    }
                }
            },
        );
        squares.iter().sum()
    }

    /// `(A + A^T) / 2`.
    pub(crate) fn set_symmetric_part(&mut self, a: &Square) {
        for j in 0..self.tiles() {
            for i in j..self.tiles() {
                let (below, above) = (a.tile(i, j), transposed(&a.tile(j, i)));
                let mut mean = below;
                for c in 0..LANES {
                    for l in 0..LANES {
                        mean[c][l] = 0.5 * (below[c][l] + above[c][l]);
                    }
                }
                self.set_tile(i, j, &mean);
                self.set_tile(j, i, &transposed(&mean));
            }
        }
    }

    /// `alpha A B` (optionally added), known to be symmetric or skew. The part above the diagonal is only defined after
    /// calling `reflect_product`.
    pub(crate) fn set_product(
        &mut self,
        beta: Accum,
        alpha: f64,
        a: MatRef<'_, f64>,
        b: MatRef<'_, f64>,
    ) {
        if !self.halves_products() {
            return matmul(self.view_mut(), beta, a, b, alpha, Par::Seq);
        }
        triangular::matmul(
            self.view_mut(),
            TriangularLower,
            beta,
            a,
            Rectangular,
            b,
            Rectangular,
            alpha,
            Par::Seq,
        );
    }

    /// `alpha A B`.
    pub(crate) fn multiply(&mut self, alpha: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
        matmul(self.view_mut(), Accum::Replace, a, b, alpha, Par::Seq);
    }

    /// Whether `set_product` computes only one half.
    pub(crate) fn halves_products(&self) -> bool {
        self.m >= TRIANGULAR
    }

    /// Fills the part above the diagonal from the part below, after a product of which only half was computed.
    pub(crate) fn reflect_product(&mut self, symmetry: Symmetry) {
        if self.halves_products() {
            self.reflect(symmetry);
        }
    }

    /// Fills the part above the diagonal from the part below; a skew matrix has a zero diagonal.
    pub(crate) fn reflect(&mut self, symmetry: Symmetry) {
        let sign = if symmetry == Symmetry::Skew {
            -1.0
        } else {
            1.0
        };
        vectorised(
            #[inline(always)]
            || {
                for j in 0..self.tiles() {
                    let mut diagonal = self.tile(j, j);
                    for c in 0..LANES {
                        if symmetry == Symmetry::Skew {
                            diagonal[c][c] = 0.0;
                        }
                        for l in c + 1..LANES {
                            diagonal[l][c] = sign * diagonal[c][l];
                        }
                    }
                    self.set_tile(j, j, &diagonal);
                    for i in j + 1..self.tiles() {
                        let tile =
                            transposed(&self.tile(i, j)).map(|column| column.map(|x| sign * x));
                        self.set_tile(j, i, &tile);
                    }
                }
            },
        );
    }

    /// `self = E + T` from the lower triangles of the symmetric `E` (in `self`) and the skew `T`.
    pub(crate) fn add_skew(&mut self, skew: &Square) {
        vectorised(
            #[inline(always)]
            || {
                for j in 0..self.tiles() {
                    for i in j..self.tiles() {
                        let (even, odd) = (self.tile(i, j), skew.tile(i, j));
                        let (mut sum, mut difference) = (even, even);
                        for c in 0..LANES {
                            for l in 0..LANES {
                                sum[c][l] = even[c][l] + odd[c][l];
                                difference[c][l] = even[c][l] - odd[c][l];
                            }
                        }
                        if i > j {
                            self.set_tile(i, j, &sum);
                            self.set_tile(j, i, &transposed(&difference));
                            continue;
                        }
                        for c in 0..LANES {
                            sum[c][c] = even[c][c];
                            for l in c + 1..LANES {
                                sum[l][c] = difference[c][l];
                            }
                        }
                        self.set_tile(j, j, &sum);
                    }
                }
            },
        );
    }

    /// Largest column sum of moduli and Frobenius norm.
    pub(crate) fn norms(&self) -> (f64, f64) {
        let (mut largest_sum, mut squares) = (0.0_f64, [0.0; LANES]);
        vectorised(
            #[inline(always)]
            || {
                for column in self.lanes().chunks_exact(self.tiles()) {
                    let mut sums = [0.0; LANES];
                    for group in column {
                        for l in 0..LANES {
                            sums[l] += group[l].abs();
                            squares[l] += group[l] * group[l];
                        }
                    }
                    largest_sum = largest_sum.max(sums.iter().sum());
                }
            },
        );
        let square: f64 = squares.iter().sum();
        // If squares overflow or underflow, use the slow, scaled sum.
        let frobenius = if super::structure::SAFE_SQUARES.contains(&square) {
            square.sqrt()
        } else {
            super::structure::norm(self.view())
        };
        (largest_sum, frobenius)
    }

    /// `self += alpha I`.
    pub(crate) fn add_to_diagonal(&mut self, alpha: f64) {
        for j in 0..self.m {
            self.entries[j * self.stride + j] += alpha;
        }
    }

    /// Copies into `out`, of the same size.
    pub(crate) fn write(&self, mut out: MatMut<'_, f64>) {
        for j in 0..self.m {
            let source = &self.entries[j * self.stride..][..self.m];
            match out.rb_mut().col_mut(j).try_as_col_major_mut() {
                Some(target) => target.as_slice_mut().copy_from_slice(source),
                None => {
                    for (i, x) in source.iter().enumerate() {
                        out[(i, j)] = *x;
                    }
                }
            }
        }
    }
}

/// A tile of a matrix, padded with zeros.
#[inline(always)]
fn tile_of(a: MatRef<'_, f64>, i: usize, j: usize) -> Tile {
    let (rows, cols) = (a.nrows(), a.ncols());
    let mut tile = [[0.0; LANES]; LANES];
    let (top, left) = (i * LANES, j * LANES);
    let (height, width) = (LANES.min(rows - top), LANES.min(cols - left));
    for (c, target) in tile.iter_mut().enumerate().take(width) {
        match a.col(left + c).try_as_col_major() {
            Some(column) => {
                let source = &column.as_slice()[top..top + height];
                match source.first_chunk::<LANES>() {
                    Some(full) => *target = *full,
                    None => target[..height].copy_from_slice(source),
                }
            }
            None => {
                for l in 0..height {
                    target[l] = a[(top + l, left + c)];
                }
            }
        }
    }
    tile
}
