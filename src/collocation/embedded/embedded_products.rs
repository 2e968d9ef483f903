//! Products of matrices at eight nodes: tall ones with each other and with a Gram matrix, and small ones.

use crate::linalg::field::multiply_rows;
use crate::linalg::lanes::Lanes;

/// Products of `S, S', S'', S'''`: the matrices, the same times `i` if they are complex, and times the Gram matrix.
#[derive(Clone, Copy)]
pub(crate) struct NodeProducts<'s> {
    pub(crate) s: [&'s [Lanes]; 4],
    pub(crate) turned: [&'s [Lanes]; 4],
    pub(crate) moved: [&'s [Lanes]; 4],
    pub(crate) r: usize,
    pub(crate) m: Small,
}

impl NodeProducts<'_> {
    /// The product of the derivatives of the given orders, the first one transposed.
    #[inline(always)]
    pub(crate) fn write(self, [i, j]: [usize; 2], out: &mut [Lanes]) {
        let columns = [self.s[i], self.turned[i]];
        self.m.write_product(columns, self.moved[j], self.r, out);
    }
}

/// Products of matrices of size `k`, in row-major order.
#[derive(Clone, Copy)]
pub(crate) struct Small {
    pub(crate) k: usize,
    /// Number of columns that are computed; the others are `i` times these.
    pub(crate) stored: usize,
}

impl Small {
    /// `out = s^T v` for matrices with columns of length `r`; of `s`, the stored columns and the others.
    #[inline(always)]
    pub(crate) fn write_product(self, s: [&[Lanes]; 2], v: &[Lanes], r: usize, out: &mut [Lanes]) {
        let Small { k, stored } = self;
        for (s, out) in s.into_iter().zip(out.chunks_exact_mut(stored * stored)) {
            multiply_rows(
                s,
                v,
                r,
                #[inline(always)]
                |_| r,
                out,
            );
        }
        if stored < k {
            for row in (1..k).rev() {
                out.copy_within(row * stored..(row + 1) * stored, row * k);
            }
        }
        self.complete(out);
    }

    /// Writes the columns that are not computed.
    #[inline(always)]
    fn complete(self, out: &mut [Lanes]) {
        let Small { k, stored } = self;
        if stored == k {
            return;
        }
        let (upper, lower) = out.split_at_mut(stored * k);
        for (upper, lower) in upper.chunks_exact_mut(k).zip(lower.chunks_exact_mut(k)) {
            for j in 0..stored {
                upper[stored + j] = -lower[j];
                lower[stored + j] = upper[j];
            }
        }
    }

    /// `out += factor a b`.
    #[inline(always)]
    pub(crate) fn add(self, factor: f64, a: &[Lanes], b: &[Lanes], out: &mut [Lanes]) {
        let k = self.k;
        self.each(
            out,
            factor,
            #[inline(always)]
            |i, j, l| a[i * k + l] * b[l * k + j],
        );
    }

    /// `out += factor a^T b`.
    #[inline(always)]
    pub(crate) fn add_left_transposed(
        self,
        factor: f64,
        a: &[Lanes],
        b: &[Lanes],
        out: &mut [Lanes],
    ) {
        let k = self.k;
        self.each(
            out,
            factor,
            #[inline(always)]
            |i, j, l| a[l * k + i] * b[l * k + j],
        );
    }

    /// `out += factor a b^T`.
    #[inline(always)]
    pub(crate) fn add_right_transposed(
        self,
        factor: f64,
        a: &[Lanes],
        b: &[Lanes],
        out: &mut [Lanes],
    ) {
        let k = self.k;
        self.each(
            out,
            factor,
            #[inline(always)]
            |i, j, l| a[i * k + l] * b[j * k + l],
        );
    }

    /// `out += factor a^T`.
    #[inline(always)]
    pub(crate) fn add_transposed(self, factor: f64, a: &[Lanes], out: &mut [Lanes]) {
        for i in 0..self.k {
            for j in 0..self.k {
                out[i * self.k + j] += a[j * self.k + i] * factor;
            }
        }
    }

    #[inline(always)]
    fn each(self, out: &mut [Lanes], factor: f64, term: impl Fn(usize, usize, usize) -> Lanes) {
        let Small { k, stored } = self;
        for (i, row) in out.chunks_exact_mut(k).enumerate() {
            for (j, entry) in row[..stored].iter_mut().enumerate() {
                let mut sum = Lanes::ZERO;
                for l in 0..k {
                    sum += term(i, j, l);
                }
                *entry += sum * factor;
            }
        }
        self.complete(out);
    }
}

/// Number of sums at once.
const ABREAST: usize = 4;

/// `out = x m` for rows of length `r` and a symmetric matrix.
#[inline(always)]
pub(crate) fn times_symmetric(x: &[Lanes], m: &[f64], r: usize, out: &mut [Lanes]) {
    for (x, out) in x.chunks_exact(r).zip(out.chunks_exact_mut(r)) {
        let mut rows = m.chunks_exact(ABREAST * r);
        let mut outs = out.chunks_exact_mut(ABREAST);
        for (rows, out) in rows.by_ref().zip(outs.by_ref()) {
            let mut sums = [Lanes::ZERO; ABREAST];
            for (l, x) in x.iter().enumerate() {
                for (t, sum) in sums.iter_mut().enumerate() {
                    *sum += *x * rows[t * r + l];
                }
            }
            out.copy_from_slice(&sums);
        }
        for (row, out) in rows.remainder().chunks_exact(r).zip(outs.into_remainder()) {
            let mut sum = Lanes::ZERO;
            for (x, m) in x.iter().zip(row) {
                sum += *x * *m;
            }
            *out = sum;
        }
    }
}
