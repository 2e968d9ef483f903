//! Taylor coefficients of Riemannian cubics, one order after the other.
//!
//! With `x = [[omega, -b^T], [b, 0]]` and the frame `g = [s, e]` the equations of the [module](super) are
//!
//! ```math
//! \begin{aligned}
//! s' &= s\,\omega + e\,b, & e' &= -s\,b^T,\\
//! \omega'' &= \kappa - (n - n^T), & \kappa' &= \omega''\omega - (\omega''\omega)^T,\\
//! b''' &= b''\omega + b\,(n - \omega'') - b'\,p, & n &= b'^T b,\quad p = b^T b,\quad p' = n + n^T,
//! \end{aligned}
//! ```
//!
//! products of blocks of at most `r x k`: no commutator of `r x r` matrices is formed. A coefficient of order `j + 1`
//! takes `j + 1` products of each kind, `k (4 m k + r k + 2 r m)` multiplications together.

use super::{fused, rotation};
use crate::linalg::dual::Number;

/// Sizes of the blocks: `omega` is `(k, k)`, `b` is `(m, k)`, `s` is `(r, k)`, `e` is `(r, m)`.
///
/// Rows of zeros at the end of `b`, `s` and `e` and columns of zeros of `e` do no harm: they fill up vector registers.
pub(crate) trait Blocks: Copy + Send + Sync {
    /// The compiler knows the sizes and unrolls the loops over them.
    const UNROLLED: bool;

    fn k(self) -> usize;

    /// Rows of `b` with those that fill up.
    fn m<T: Number>(self) -> usize;

    /// Rows of `s` and `e` with those that fill up.
    fn r<T: Number>(self) -> usize;

    /// Rows of `b`.
    fn normals(self) -> usize;
}

/// Sizes known to the compiler.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fixed<const M: usize, const K: usize>;

impl<const M: usize, const K: usize> Blocks for Fixed<M, K> {
    const UNROLLED: bool = true;

    #[inline(always)]
    fn k(self) -> usize {
        K
    }
    #[inline(always)]
    fn m<T: Number>(self) -> usize {
        M
    }
    #[inline(always)]
    fn r<T: Number>(self) -> usize {
        (M + K).next_multiple_of(T::WIDTH)
    }
    #[inline(always)]
    fn normals(self) -> usize {
        M
    }
}

/// Any sizes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sized {
    /// Rows of `b`.
    pub(crate) m: usize,
    pub(crate) k: usize,
}

impl Blocks for Sized {
    const UNROLLED: bool = false;

    #[inline(always)]
    fn k(self) -> usize {
        self.k
    }
    #[inline(always)]
    fn m<T: Number>(self) -> usize {
        self.m.next_multiple_of(T::WIDTH)
    }
    #[inline(always)]
    fn r<T: Number>(self) -> usize {
        (self.m + self.k).next_multiple_of(T::WIDTH)
    }
    #[inline(always)]
    fn normals(self) -> usize {
        self.m
    }
}

/// Taylor coefficients of `(s, e)` and of `x, x', x''`; blocks of one quantity one after the other, column by column.
#[derive(Debug, Clone)]
pub(crate) struct Series<T> {
    /// All quantities one after the other, in the order of [`Parts`]: one allocation.
    entries: Vec<T>,
    lengths: [usize; PARTS],
}

const PARTS: usize = 16;

/// The quantities of a [`Series`].
pub(crate) struct Parts<'a, T> {
    pub(crate) s: &'a mut [T],
    pub(crate) e: &'a mut [T],
    /// Of `omega, omega', omega''`.
    pub(crate) omega: [&'a mut [T]; 3],
    /// Of `b, b', b''`.
    pub(crate) b: [&'a mut [T]; 3],
    /// Of `b^T b`.
    pub(super) p: &'a mut [T],
    /// Of `b'^T b`.
    pub(super) n: &'a mut [T],
    /// Of `n - omega''`.
    pub(super) q: &'a mut [T],
    /// Of `b` and `omega`, from the highest order down, where [`fused`] wants them.
    pub(super) b_down: &'a mut [T],
    pub(super) omega_down: &'a mut [T],
    square: &'a mut [T],
    tall: &'a mut [T],
    frame: &'a mut [T],
}

impl<T: Number> Series<T> {
    /// Zero coefficients up to the given order.
    pub(crate) fn zeros(blocks: impl Blocks, order: usize) -> Self {
        let (r, m, k) = (blocks.r::<T>(), blocks.m::<T>(), blocks.k());
        let series = |block: usize| block * (order + 1);
        let (square, tall) = (series(k * k), series(m * k));
        let fused = fused::fits::<T, _>(blocks);
        let lengths = [
            series(r * k),
            series(r * m),
            square,
            square,
            square,
            tall,
            tall,
            tall,
            square,
            square,
            square,
            if fused { tall } else { 0 },
            if fused { square } else { 0 },
            k * k,
            m * k,
            r * m.max(k),
        ];
        Series {
            entries: vec![T::ZERO; lengths.iter().sum()],
            lengths,
        }
    }

    #[inline(always)]
    pub(crate) fn parts(&mut self) -> Parts<'_, T> {
        let mut rest = self.entries.as_mut_slice();
        let [
            s,
            e,
            o0,
            o1,
            o2,
            b0,
            b1,
            b2,
            p,
            n,
            q,
            b_down,
            omega_down,
            square,
            tall,
            frame,
        ] = self
            .lengths
            .map(|length| rest.split_off_mut(..length).expect("lengths add up"));
        Parts {
            s,
            e,
            omega: [o0, o1, o2],
            b: [b0, b1, b2],
            p,
            n,
            q,
            b_down,
            omega_down,
            square,
            tall,
            frame,
        }
    }

    pub(crate) fn s(&self) -> &[T] {
        self.part(0)
    }

    pub(crate) fn e(&self) -> &[T] {
        self.part(1)
    }

    /// Of `omega` or a derivative.
    pub(crate) fn omega(&self, derivative: usize) -> &[T] {
        self.part(2 + derivative)
    }

    /// Of `b` or a derivative.
    pub(crate) fn b(&self, derivative: usize) -> &[T] {
        self.part(5 + derivative)
    }

    #[inline(always)]
    fn part(&self, which: usize) -> &[T] {
        let start = self.lengths[..which].iter().sum();
        &self.entries[start..][..self.lengths[which]]
    }

    /// Coefficients of orders `1..=order` from those of order 0.
    #[inline(always)]
    pub(crate) fn expand(&mut self, blocks: impl Blocks, order: usize) {
        let (m, k) = (blocks.m::<T>(), blocks.k());
        let mut parts = self.parts();
        if rotation::fits(blocks) {
            return rotation::expand(&mut parts, blocks, order);
        }
        if fused::fits::<T, _>(blocks) {
            return fused::expand(&mut parts, blocks, order);
        }
        let b = &parts.b[0][..m * k];
        gram(&mut parts.p[..k * k], b, b, [m, k]);
        gram(&mut parts.n[..k * k], &parts.b[1][..m * k], b, [m, k]);
        for j in 0..order {
            parts.extend(blocks, j);
        }
    }
}

impl<T: Number> Parts<'_, T> {
    /// The coefficients of order `j + 1` from those up to order `j`.
    #[inline(always)]
    fn extend<B: Blocks>(&mut self, blocks: B, j: usize) {
        let (r, m, k) = (blocks.r::<T>(), blocks.m::<T>(), blocks.k());
        let [omega, omega1, omega2] = &mut self.omega;
        let [b, b1, b2] = &mut self.b;
        let next = 1.0 / (j + 1) as f64;
        let (wide, narrow) = (up_to(j, m * k), up_to(j, k * k));

        let n = &self.n[block(j, k * k)];
        let p = &mut self.p[block(j + 1, k * k)];
        let q = &mut self.q[block(j, k * k)];
        for col in 0..k {
            for row in 0..k {
                let (i, transposed) = (row + k * col, col + k * row);
                p[i] = (n[i] + n[transposed]) * next;
                q[i] = n[i] - omega2[block(j, k * k)][i];
            }
        }

        let tall = &mut self.tall[..m * k];
        tall.fill(T::ZERO);
        product::<T, B>(tall, &b1[wide.clone()], &self.p[narrow.clone()], [m, k, k]);
        for entry in tall.iter_mut() {
            *entry = -*entry;
        }
        product::<T, B>(tall, &b[wide.clone()], &self.q[narrow.clone()], [m, k, k]);
        if k > 1 {
            product::<T, B>(tall, &b2[wide.clone()], &omega[narrow.clone()], [m, k, k]);
        }
        write_scaled(&mut b2[block(j + 1, m * k)], tall, next);

        let point = &mut self.frame[..r * k];
        point.fill(T::ZERO);
        let points = up_to(j, r * k);
        if k > 1 {
            product::<T, B>(
                point,
                &self.s[points.clone()],
                &omega[narrow.clone()],
                [r, k, k],
            );
        }
        product::<T, B>(point, &self.e[up_to(j, r * m)], &b[wide.clone()], [r, m, k]);
        write_scaled(&mut self.s[block(j + 1, r * k)], point, next);
        let normals = &mut self.frame[..r * m];
        normals.fill(T::ZERO);
        product_transposed::<T, B>(normals, &self.s[points], &b[wide.clone()], [r, k, m]);
        write_scaled(&mut self.e[block(j + 1, r * m)], normals, -next);

        integrate(b, b1, j, m * k, next);
        integrate(b1, b2, j, m * k, next);
        // The factors of the next n are known by now.
        let next_wide = up_to(j + 1, m * k);
        let n = &mut self.n[block(j + 1, k * k)];
        gram(n, &b1[next_wide.clone()], &b[next_wide], [m, k]);
        if k > 1 {
            let square = &mut self.square[..k * k];
            square.fill(T::ZERO);
            product::<T, B>(square, &omega2[narrow.clone()], &omega[narrow], [k, k, k]);
            integrate(omega, omega1, j, k * k, next);
            integrate(omega1, omega2, j, k * k, next);
            let target = &mut omega2[block(j + 1, k * k)];
            for col in 0..k {
                for row in 0..k {
                    let (i, transposed) = (row + k * col, col + k * row);
                    let turning = (square[i] - square[transposed]) * next;
                    target[i] = turning - (n[i] - n[transposed]);
                }
            }
        }
    }
}

/// Where the block of order `j` is.
#[inline(always)]
pub(crate) fn block(j: usize, size: usize) -> std::ops::Range<usize> {
    j * size..(j + 1) * size
}

/// Where the blocks of orders up to `j` are.
#[inline(always)]
fn up_to(j: usize, size: usize) -> std::ops::Range<usize> {
    0..(j + 1) * size
}

#[inline(always)]
pub(super) fn write_scaled<T: Number>(out: &mut [T], a: &[T], factor: f64) {
    for (out, a) in out.iter_mut().zip(a) {
        *out = *a * factor;
    }
}

/// The coefficient of order `j + 1` of a function from that of its derivative of order `j`.
#[inline(always)]
pub(super) fn integrate<T: Number>(
    f: &mut [T],
    derivative: &[T],
    j: usize,
    size: usize,
    next: f64,
) {
    write_scaled(
        &mut f[block(j + 1, size)],
        &derivative[block(j, size)],
        next,
    );
}

/// `out += sum_i a_i b_{j-i}` with factors of shapes `(rows, inner)` and `(inner, cols)`.
#[inline(always)]
fn product<T: Number, B: Blocks>(out: &mut [T], a: &[T], b: &[T], shape: [usize; 3]) {
    convolve::<T, B, false>(out, a, b, shape);
}

/// `out += sum_i a_i b_{j-i}^T` with factors of shapes `(rows, inner)` and `(cols, inner)`.
#[inline(always)]
fn product_transposed<T: Number, B: Blocks>(out: &mut [T], a: &[T], b: &[T], shape: [usize; 3]) {
    convolve::<T, B, true>(out, a, b, shape);
}

/// The most that is kept in registers.
const FEW: usize = 16;

/// `out += sum_i a_i b_{j-i}`, the second factors transposed or not.
#[inline(always)]
fn convolve<T: Number, B: Blocks, const TRANSPOSED: bool>(
    out: &mut [T],
    a: &[T],
    b: &[T],
    shape: [usize; 3],
) {
    let [rows, inner, cols] = shape;
    if rows * inner * cols == 0 {
        return;
    }
    let pairs = a
        .chunks_exact(rows * inner)
        .zip(b.chunks_exact(inner * cols).rev());
    let few = B::UNROLLED && rows * cols <= T::REGISTERS;
    if !few && rows.is_multiple_of(T::WIDTH) {
        return T::accumulate::<TRANSPOSED>(out, pairs, shape);
    }
    if few {
        let mut sums = [T::ZERO; FEW];
        for (a, b) in pairs {
            add_product::<T, TRANSPOSED>(&mut sums[..rows * cols], a, b, shape);
        }
        for (out, sum) in out.iter_mut().zip(&sums[..rows * cols]) {
            *out += *sum;
        }
    } else {
        for (a, b) in pairs {
            add_product::<T, TRANSPOSED>(out, a, b, shape);
        }
    }
}

/// `out += a b`, the second factor transposed or not.
#[inline(always)]
pub(super) fn add_product<T: Number, const TRANSPOSED: bool>(
    out: &mut [T],
    a: &[T],
    b: &[T],
    [rows, inner, cols]: [usize; 3],
) {
    for (col, out) in out.chunks_exact_mut(rows).enumerate() {
        for (l, a) in a.chunks_exact(rows).enumerate() {
            let factor = if TRANSPOSED {
                b[col + cols * l]
            } else {
                b[l + inner * col]
            };
            for (out, a) in out.iter_mut().zip(a) {
                *out += *a * factor;
            }
        }
    }
}

/// `out = sum_i a_i^T b_{j-i}` with factors of shape `(m, k)`.
#[inline(always)]
fn gram<T: Number>(out: &mut [T], a: &[T], b: &[T], [m, k]: [usize; 2]) {
    if m == 0 {
        return out.fill(T::ZERO);
    }
    for row in 0..k {
        let whole = k - k % 4;
        for col in (0..whole).step_by(4) {
            gram_entries::<T, 4>(out, a, b, [m, k], row, col);
        }
        match k - whole {
            3 => gram_entries::<T, 3>(out, a, b, [m, k], row, whole),
            2 => gram_entries::<T, 2>(out, a, b, [m, k], row, whole),
            1 => gram_entries::<T, 1>(out, a, b, [m, k], row, whole),
            _ => {}
        }
    }
}

/// Entries `(row, col)` to `(row, col + C)` of [`gram`], their sums in registers.
#[inline(always)]
fn gram_entries<T: Number, const C: usize>(
    out: &mut [T],
    a: &[T],
    b: &[T],
    [m, k]: [usize; 2],
    row: usize,
    col: usize,
) {
    const WIDTH: usize = 4;
    let mut sums = [[T::ZERO; WIDTH]; C];
    for (a, b) in a.chunks_exact(m * k).zip(b.chunks_exact(m * k).rev()) {
        let a = &a[m * row..][..m];
        let b: [&[T]; C] = std::array::from_fn(|c| &b[m * (col + c)..][..m]);
        let heads = m - m % WIDTH;
        for first in (0..heads).step_by(WIDTH) {
            for c in 0..C {
                for i in 0..WIDTH {
                    sums[c][i] += a[first + i] * b[c][first + i];
                }
            }
        }
        for i in heads..m {
            for c in 0..C {
                sums[c][i - heads] += a[i] * b[c][i];
            }
        }
    }
    for (c, sums) in sums.iter().enumerate() {
        out[row + k * (col + c)] = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }
}
