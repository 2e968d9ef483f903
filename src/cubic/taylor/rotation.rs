//! The Taylor recurrence of [`super::recurrence`] on `SO(3)`, for `St(3, 2)` and `St(3, 3)`.
//!
//! For `m <= 1` the terms of third degree cancel: with `x = [[omega, -b^T], [b, 0]]` and the frame `g = [s, e]`
//!
//! ```math
//! x''' = x''\,x - x\,x'',\qquad g' = g\,x,
//! ```
//!
//! and in three dimensions both are cross products: 24 multiplications per pair of coefficients instead of 48.

use super::blocks::{BlockSizes, SeriesParts, block};
use crate::linalg::dual::Number;

/// Entries of `x` below the diagonal, and columns of the frame.
const DIM: usize = 3;

/// Largest number of rows of the frame processed at once.
const ROWS: usize = 4;

/// Whether the blocks are those of rotations.
#[inline(always)]
pub(crate) fn fits<B: BlockSizes>(blocks: B) -> bool {
    B::UNROLLED && matches!((blocks.normals(), blocks.k()), (1, 2) | (0, 3))
}

/// Computes the coefficients of orders `1..=order` from those of order 0.
#[inline(always)]
pub(crate) fn expand<T: Number>(
    parts: &mut SeriesParts<'_, T>,
    blocks: impl BlockSizes,
    order: usize,
) {
    let (rows, k) = (blocks.r::<T>(), blocks.k());
    for j in 0..order {
        let next = 1.0 / (j + 1) as f64;
        let third = cross(parts, k, j).map(|x| x * next);
        for row in (0..rows).step_by(T::WIDTH) {
            turn(parts, [rows, k], row, j);
        }
        for derivative in [0, 1] {
            let above = vectors(parts, k, derivative + 1, j).next_back();
            let entries = above.expect("a coefficient").map(|x| x * next);
            write_vector(parts, k, derivative, j + 1, entries);
        }
        write_vector(parts, k, 2, j + 1, third);
    }
}

/// The coefficient of order `j` of `x'' x - x x''`, plus `tau x'` in tension.
#[inline(always)]
fn cross<T: Number>(parts: &SeriesParts<'_, T>, k: usize, j: usize) -> [T; DIM] {
    let mut sums = [T::ZERO; DIM];
    let pairs = vectors(parts, k, 2, j).zip(vectors(parts, k, 0, j).rev());
    for ([a2, b2, c2], [a, b, c]) in pairs {
        sums[0] += b2 * c;
        sums[1] += c2 * a;
        sums[2] += a2 * b;
        sums[0] -= c2 * b;
        sums[1] -= a2 * c;
        sums[2] -= b2 * a;
    }
    let rate = vectors(parts, k, 1, j).next_back();
    if let (Some(tension), Some(rate)) = (parts.tension, rate) {
        for (sum, x) in sums.iter_mut().zip(rate) {
            *sum += tension * x;
        }
    }
    sums
}

/// Computes the coefficient of order `j + 1` of a few rows of the frame.
#[inline(always)]
fn turn<T: Number>(parts: &mut SeriesParts<'_, T>, [rows, k]: [usize; 2], row: usize, j: usize) {
    let mut sums = [[T::ZERO; ROWS]; DIM];
    let first = parts.s[..k * rows * (j + 1)].chunks_exact(k * rows);
    let (last, stride) = match k {
        DIM => (&parts.s[2 * rows..k * rows * (j + 1)], k * rows),
        _ => (&parts.e[..rows * (j + 1)], rows),
    };
    let frames = first.zip(last.chunks(stride));
    for ((s, last), [a, b, c]) in frames.zip(vectors(parts, k, 0, j).rev()) {
        for w in 0..T::WIDTH {
            let (s0, s1, s2) = (s[row + w], s[rows + row + w], last[row + w]);
            sums[0][w] += s1 * a;
            sums[1][w] -= s0 * a;
            sums[2][w] += s0 * b;
            sums[0][w] += s2 * b;
            sums[1][w] += s2 * c;
            sums[2][w] += s1 * c;
        }
    }
    let next = 1.0 / (j + 1) as f64;
    let s = &mut parts.s[block(j + 1, k * rows)];
    for w in 0..T::WIDTH {
        s[row + w] = sums[0][w] * next;
        s[rows + row + w] = sums[1][w] * next;
    }
    let last = match k {
        DIM => &mut s[2 * rows..],
        _ => &mut parts.e[block(j + 1, rows)],
    };
    for w in 0..T::WIDTH {
        last[row + w] = sums[2][w] * -next;
    }
}

/// The coefficients of `x` or a derivative up to order `j`.
#[inline(always)]
fn vectors<'a, T: Number>(
    parts: &'a SeriesParts<'_, T>,
    k: usize,
    derivative: usize,
    j: usize,
) -> impl DoubleEndedIterator<Item = [T; DIM]> + ExactSizeIterator + 'a {
    let omega = &parts.omega[derivative][..k * k * (j + 1)];
    // The last row comes from b, or from the third row of omega.
    let (last, stride, next) = match k {
        DIM => (&omega[2..], k * k, DIM),
        _ => (&parts.b[derivative][..2 * (j + 1)], 2, 1),
    };
    let entries = omega.chunks_exact(k * k).zip(last.chunks(stride));
    entries.map(move |(omega, last)| [omega[1], last[0], last[next]])
}

#[inline(always)]
fn write_vector<T: Number>(
    parts: &mut SeriesParts<'_, T>,
    k: usize,
    derivative: usize,
    j: usize,
    [a, b, c]: [T; DIM],
) {
    let omega = &mut parts.omega[derivative][block(j, k * k)];
    if k == DIM {
        omega.copy_from_slice(&[T::ZERO, a, b, -a, T::ZERO, c, -b, -c, T::ZERO]);
    } else {
        omega.copy_from_slice(&[T::ZERO, a, -a, T::ZERO]);
        parts.b[derivative][block(j, 2)].copy_from_slice(&[b, c]);
    }
}
