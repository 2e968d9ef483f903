//! `St(n, k) = SO(n)/SO(n - k)`: `h` is the lower right block, `m` the rest.

use std::ops::Range;

use super::homogeneous::Homogeneous;
use crate::linalg::dual::Number;
use crate::linalg::field::Field;
use crate::linalg::simd::{Eight, Four};

/// Frames of `k` vectors in `R^r`, `k < r`, with sizes known at run time. `k = r - 1` is the group `SO(r)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frames {
    pub(crate) r: usize,
    pub(crate) k: usize,
}

/// The same with sizes known at compile time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixedFrames<const R: usize, const K: usize>;

macro_rules! homogeneous {
    () => {
        #[inline(always)]
        fn dim(self) -> usize {
            let [r, k] = self.shape();
            k * k.saturating_sub(1) / 2 + (r - k) * k
        }

        #[inline(always)]
        fn isotropy_dim(self) -> usize {
            let [r, k] = self.shape();
            (r - k) * (r - k).saturating_sub(1) / 2
        }

        #[inline(always)]
        fn size(self) -> usize {
            self.shape()[0]
        }

        #[inline(always)]
        fn each_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
            // The order of `cubic::packing::pack`: entries above the diagonal of omega, then b, in column-major order.
            // A single call site of `visit`: kernels are inlined into it.
            let [r, k] = self.shape();
            let first = k * k.saturating_sub(1) / 2;
            for i in 1..2 * k {
                let (p, row, column, count) = match i.checked_sub(k) {
                    None => (i * (i - 1) / 2, i, 0, i),
                    Some(j) => (first + j * (r - k), j, k, r - k),
                };
                visit(p, row, column, count);
            }
        }

        #[inline(always)]
        fn each_turned_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
            let [r, k] = self.shape();
            let first = k * k.saturating_sub(1) / 2;
            for j in 0..k {
                visit(first + j * (r - k), j, k, r - k);
            }
        }

        #[inline(always)]
        fn each_isotropy_run(self, mut visit: impl FnMut(usize, usize, usize, usize)) {
            let [r, k] = self.shape();
            let mut p = 0;
            for j in k..r.saturating_sub(1) {
                let count = r - 1 - j;
                visit(p, j, j + 1, count);
                p += count;
            }
        }

        #[inline(always)]
        fn is_symmetric(self) -> bool {
            self.shape()[1] == 1
        }

        #[inline(always)]
        fn isotropy_range(self) -> Range<usize> {
            let [r, k] = self.shape();
            k..r
        }

        #[inline(always)]
        fn turn_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]) {
            turn::<T, false>(self.shape(), q, x, out);
        }

        #[inline(always)]
        fn turn_back_into<T: Number>(self, q: &[T], x: &[T], out: &mut [T]) {
            turn::<T, true>(self.shape(), q, x, out);
        }

        #[inline(always)]
        fn row_len(self, row: usize) -> usize {
            let [r, k] = self.shape();
            if row < k { r } else { k }
        }

        #[inline(always)]
        fn subtract_action<T: Number>(self, z: &[T], x: &[T], out: &mut [T]) {
            // [z, x] has the lower left block `z b`.
            let [r, k] = self.shape();
            let b = &mut out[k * k.saturating_sub(1) / 2..];
            for (c, column) in b.chunks_exact_mut(r - k).take(k).enumerate() {
                let mut z = z.iter();
                for j in 0..r - k {
                    let (upper, lower) = column.split_at_mut(j + 1);
                    let x_j = x[(k + j) * r + c];
                    let mut sum = upper[j];
                    for ((i, b_i), z) in (j + 1..r - k).zip(lower).zip(&mut z) {
                        *b_i -= *z * x_j;
                        sum += *z * x[(k + i) * r + c];
                    }
                    upper[j] = sum;
                }
            }
        }

        #[inline(always)]
        fn isotropy_part_into<T: Field>(self, u: &[T], out: &mut [T]) {
            let [r, k] = self.shape();
            for i in 0..r {
                for j in 0..r {
                    out[i * r + j] = match (i >= k && j >= k, i == j) {
                        (true, true) if r == k + 1 => u[i * r + j].sign(),
                        (true, _) if r > k + 1 => u[i * r + j],
                        (_, true) => T::constant(1.0),
                        _ => T::ZERO,
                    };
                }
            }
        }
    };
}

impl Frames {
    #[inline(always)]
    fn shape(self) -> [usize; 2] {
        [self.r, self.k]
    }
}

impl<const R: usize, const K: usize> FixedFrames<R, K> {
    #[inline(always)]
    fn shape(self) -> [usize; 2] {
        [R, K]
    }
}

impl Homogeneous for Frames {
    type Width = Four;

    homogeneous!();
}

impl<const R: usize, const K: usize> Homogeneous for FixedFrames<R, K> {
    type Width = Eight;

    homogeneous!();
}

/// `Omega` is unchanged; `B` becomes `q B`, or `q^T B`, where `q` is the lower right block.
#[inline(always)]
fn turn<T: Number, const BACK: bool>([r, k]: [usize; 2], q: &[T], x: &[T], out: &mut [T]) {
    let (first, rows) = (k * k.saturating_sub(1) / 2, r - k);
    out[..first].copy_from_slice(&x[..first]);
    if rows == 0 {
        return;
    }
    let columns = out[first..][..rows * k].chunks_exact_mut(rows);
    for (out, x) in columns.zip(x[first..].chunks_exact(rows)) {
        for (i, out) in out.iter_mut().enumerate() {
            let mut sum = T::ZERO;
            for (l, x) in x.iter().enumerate() {
                let at = if BACK { [k + l, k + i] } else { [k + i, k + l] };
                sum += q[at[0] * r + at[1]] * *x;
            }
            *out = sum;
        }
    }
}
