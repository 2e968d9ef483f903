//! Square buffers in columns, and the loops over them that are not products.
//!
//! Columns are padded with zeros to a multiple of [`LANES`], so that every loop over a whole buffer is one run over a
//! slice; [`vectorised`] compiles it for the vector unit found at run time.

use std::ops::Range;

use faer::linalg::matmul::{matmul, triangular};
use faer::prelude::*;
use faer::{Accum, MatMut, MatRef, Par};
use triangular::BlockStructure::{Rectangular, TriangularLower};

/// Columns are padded to a multiple of this.
pub(crate) const LANES: usize = 8;

/// Edge of the tiles in which a matrix is transposed: two of them fit in the first cache.
const TILE: usize = 16;

/// From this size on, half of a symmetric product and its reflection cost less than the whole product.
const TRIANGULAR: usize = 128;

/// Runs a loop compiled for the vector unit that this processor has.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// `m x m` in columns of padded length; the padding stays zero.
#[derive(Clone)]
pub(crate) struct Square {
    m: usize,
    stride: usize,
    entries: Vec<f64>,
}

/// What is the same across the diagonal of a product.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Symmetry {
    Symmetric,
    Skew,
}

impl Square {
    pub(crate) fn new(m: usize) -> Self {
        let stride = m.next_multiple_of(LANES);
        Square {
            m,
            stride,
            entries: vec![0.0; stride * m],
        }
    }

    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    pub(crate) fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice_with_stride(&self.entries, self.m, self.m, self.stride)
    }

    pub(crate) fn view_mut(&mut self) -> MatMut<'_, f64> {
        let (m, stride) = (self.m, self.stride);
        MatMut::from_column_major_slice_with_stride_mut(&mut self.entries, m, m, stride)
    }

    /// All entries, padding included, in groups.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &[[f64; LANES]] {
        self.entries.as_chunks().0
    }

    /// All entries, padding included, in groups.
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

    /// `alpha (A - A^T) / 2`; halves first, so that nothing overflows on the way.
    pub(crate) fn set_skew_part(&mut self, alpha: f64, a: MatRef<'_, f64>) {
        let (a, alpha) = if a.row_stride() == 1 || a.col_stride() != 1 {
            (a, alpha)
        } else {
            (a.transpose(), -alpha)
        };
        let (m, stride) = (self.m, self.stride);
        let columns_are_slices = a.row_stride() == 1;
        for_tiles(m, |rows, cols| {
            if columns_are_slices {
                let mut left: [&[f64]; TILE] = [&[]; TILE];
                for (slot, i) in left.iter_mut().zip(rows.clone()) {
                    *slot = column(a, i);
                }
                for j in cols {
                    let own = column(a, j);
                    for i in rows.start.max(j)..rows.end {
                        let x = alpha * (0.5 * own[i] - 0.5 * left[i - rows.start][j]);
                        self.entries[i * stride + j] = -x;
                        self.entries[j * stride + i] = x;
                    }
                }
            } else {
                for j in cols {
                    for i in rows.start.max(j)..rows.end {
                        let x = alpha * (0.5 * a[(i, j)] - 0.5 * a[(j, i)]);
                        self.entries[i * stride + j] = -x;
                        self.entries[j * stride + i] = x;
                    }
                }
            }
        });
    }

    /// `alpha A B` (added or not), known to be symmetric or skew. Above the diagonal the result is only defined where
    /// `reflect` is called after.
    pub(crate) fn set_product(
        &mut self,
        beta: Accum,
        alpha: f64,
        a: MatRef<'_, f64>,
        b: MatRef<'_, f64>,
    ) {
        if self.m < TRIANGULAR {
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

    /// The part above the diagonal from that below, after a product of which only half was formed.
    pub(crate) fn reflect_product(&mut self, symmetry: Symmetry) {
        if self.m >= TRIANGULAR {
            self.reflect(symmetry);
        }
    }

    /// The part above the diagonal from that below.
    pub(crate) fn reflect(&mut self, symmetry: Symmetry) {
        let (m, stride) = (self.m, self.stride);
        let sign = if symmetry == Symmetry::Skew { -1.0 } else { 1.0 };
        for_tiles(m, |rows, cols| {
            for j in cols {
                for i in rows.start.max(j + 1)..rows.end {
                    self.entries[i * stride + j] = sign * self.entries[j * stride + i];
                }
            }
        });
    }

    /// `self = E + T` from the lower triangles of the symmetric `E` (in `self`) and the skew `T`.
    pub(crate) fn add_skew(&mut self, skew: &Square) {
        let (m, stride) = (self.m, self.stride);
        let skew = &skew.entries[..self.entries.len()];
        for_tiles(m, |rows, cols| {
            for j in cols {
                for i in rows.start.max(j + 1)..rows.end {
                    let (even, odd) = (self.entries[j * stride + i], skew[j * stride + i]);
                    self.entries[j * stride + i] = even + odd;
                    self.entries[i * stride + j] = even - odd;
                }
            }
        });
    }

    /// Largest column sum of moduli and Frobenius norm, of a symmetric or skew matrix given in full.
    pub(crate) fn norms(&self) -> (f64, f64) {
        let (mut largest_sum, mut squares) = (0.0_f64, [0.0; LANES]);
        vectorised(
            #[inline(always)]
            || {
                for column in self.entries.chunks_exact(self.stride) {
                    let mut sums = [0.0; LANES];
                    for chunk in column.chunks_exact(LANES) {
                        for l in 0..LANES {
                            sums[l] += chunk[l].abs();
                            squares[l] += chunk[l] * chunk[l];
                        }
                    }
                    largest_sum = largest_sum.max(sums.iter().sum());
                }
            },
        );
        let square: f64 = squares.iter().sum();
        // Squares that overflow or vanish: the slow, scaled sum.
        let frobenius = if square > 1e-280 && square < 1e280 {
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

    /// Columns `j` and `j + 1`.
    #[inline(always)]
    pub(crate) fn pair_mut(&mut self, j: usize) -> (&mut [f64], &mut [f64]) {
        let (left, right) = self.entries.split_at_mut((j + 1) * self.stride);
        (
            &mut left[j * self.stride..][..self.m],
            &mut right[..self.m],
        )
    }

    /// Copies into `out`, of the same size.
    pub(crate) fn write(&self, mut out: MatMut<'_, f64>) {
        if out.row_stride() != 1 {
            return out.copy_from(self.view());
        }
        for j in 0..self.m {
            for (target, source) in out.rb_mut().col_mut(j).iter_mut().zip(self.col(j)) {
                *target = *source;
            }
        }
    }
}

/// A column of a matrix whose columns are contiguous.
#[inline(always)]
fn column(a: MatRef<'_, f64>, j: usize) -> &[f64] {
    a.col(j)
        .try_as_col_major()
        .map_or(&[], |column| column.as_slice())
}

/// Calls `work(rows, cols)` for the tiles on and below the diagonal.
#[inline(always)]
fn for_tiles(
    m: usize,
    mut work: impl FnMut(Range<usize>, Range<usize>),
) {
    for j in (0..m).step_by(TILE) {
        for i in (j..m).step_by(TILE) {
            work(i..(i + TILE).min(m), j..(j + TILE).min(m));
        }
    }
}
