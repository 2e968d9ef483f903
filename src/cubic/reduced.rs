//! Taylor coefficients of Riemannian cubics, one order after the other.
//!
//! With `x = [[omega, -b^T], [b, 0]]` and the frame `g = [s, e]` the equations of the [module](super) are
//!
//! ```math
//! \begin{aligned}
//! s' &= s\,\omega + e\,b, & \omega''' &= (\omega''\omega - b''^T b) - (\omega''\omega - b''^T b)^T,\\
//! e' &= -s\,b^T, & b''' &= b''\omega - b\,\omega'' + b\,(b'^T b) - b'\,(b^T b),
//! \end{aligned}
//! ```
//!
//! products of blocks of at most `r x k`: no commutator of `r x r` matrices is formed. A coefficient of order `j + 1`
//! takes `j + 1` products of each kind, `O(r k (r + k))` each.

use crate::linalg::dual::Number;

/// Sizes of the blocks: `omega` is `(k, k)`, `b` is `(m, k)` with `m = r - k`.
pub(crate) trait Blocks: Copy + Send + Sync {
    fn m(self) -> usize;
    fn k(self) -> usize;
}

/// Sizes known to the compiler, which unrolls the loops over them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fixed<const M: usize, const K: usize>;

impl<const M: usize, const K: usize> Blocks for Fixed<M, K> {
    #[inline(always)]
    fn m(self) -> usize {
        M
    }
    #[inline(always)]
    fn k(self) -> usize {
        K
    }
}

/// Any sizes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sized {
    pub(crate) m: usize,
    pub(crate) k: usize,
}

impl Blocks for Sized {
    #[inline(always)]
    fn m(self) -> usize {
        self.m
    }
    #[inline(always)]
    fn k(self) -> usize {
        self.k
    }
}

/// Taylor coefficients of `(s, e)` and of `x, x', x''`; blocks of one quantity one after the other, column by column.
#[derive(Debug, Clone)]
pub(crate) struct Series<T> {
    pub(crate) s: Vec<T>,
    pub(crate) e: Vec<T>,
    /// Of `omega, omega', omega''`.
    pub(crate) omega: [Vec<T>; 3],
    /// Of `b, b', b''`.
    pub(crate) b: [Vec<T>; 3],
    /// Of `b^T b`.
    bb: Vec<T>,
    /// Of `b'^T b`.
    db: Vec<T>,
    square: Vec<T>,
    tall: Vec<T>,
    frame: Vec<T>,
}

impl<T: Number> Series<T> {
    /// Zero coefficients up to the given order.
    pub(crate) fn zeros(blocks: impl Blocks, order: usize) -> Self {
        let (m, k) = (blocks.m(), blocks.k());
        let r = m + k;
        let series = |block: usize| vec![T::ZERO; block * (order + 1)];
        Series {
            s: series(r * k),
            e: series(r * m),
            omega: [series(k * k), series(k * k), series(k * k)],
            b: [series(m * k), series(m * k), series(m * k)],
            bb: series(k * k),
            db: series(k * k),
            square: vec![T::ZERO; k * k],
            tall: vec![T::ZERO; m * k],
            frame: vec![T::ZERO; r * m.max(k)],
        }
    }

    /// Coefficients of orders `1..=order` from those of order 0.
    #[inline(always)]
    pub(crate) fn expand(&mut self, blocks: impl Blocks, order: usize) {
        for j in 0..order {
            self.extend(blocks, j);
        }
    }

    /// The coefficients of order `j + 1` from those up to order `j`.
    #[inline(always)]
    fn extend(&mut self, blocks: impl Blocks, j: usize) {
        let (m, k) = (blocks.m(), blocks.k());
        let r = m + k;
        let [omega, omega1, omega2] = &mut self.omega;
        let [b, b1, b2] = &mut self.b;
        let (square, tall, frame) = (
            &mut self.square[..k * k],
            &mut self.tall[..m * k],
            &mut self.frame,
        );
        let next = 1.0 / (j + 1) as f64;
        let (wide, narrow) = (up_to(j, m * k), up_to(j, k * k));

        gram(
            &mut self.bb[block(j, k * k)],
            &b[wide.clone()],
            &b[wide.clone()],
            m,
            k,
        );
        gram(
            &mut self.db[block(j, k * k)],
            &b1[wide.clone()],
            &b[wide.clone()],
            m,
            k,
        );

        gram(square, &b2[wide.clone()], &b[wide.clone()], m, k);
        for entry in square.iter_mut() {
            *entry = -*entry;
        }
        product(
            square,
            &omega2[narrow.clone()],
            &omega[narrow.clone()],
            [k, k, k],
        );
        let target = &mut omega2[block(j + 1, k * k)];
        for col in 0..k {
            for row in 0..k {
                target[row + k * col] = (square[row + k * col] - square[col + k * row]) * next;
            }
        }

        tall.fill(T::ZERO);
        product(tall, &b[wide.clone()], &omega2[narrow.clone()], [m, k, k]);
        product(tall, &b1[wide.clone()], &self.bb[narrow.clone()], [m, k, k]);
        for entry in tall.iter_mut() {
            *entry = -*entry;
        }
        product(tall, &b2[wide.clone()], &omega[narrow.clone()], [m, k, k]);
        product(tall, &b[wide.clone()], &self.db[narrow.clone()], [m, k, k]);
        write_scaled(&mut b2[block(j + 1, m * k)], tall, next);

        let points = up_to(j, r * k);
        let point = &mut frame[..r * k];
        point.fill(T::ZERO);
        product(
            point,
            &self.s[points.clone()],
            &omega[narrow.clone()],
            [r, k, k],
        );
        product(point, &self.e[up_to(j, r * m)], &b[wide.clone()], [r, m, k]);
        write_scaled(&mut self.s[block(j + 1, r * k)], point, next);
        let normals = &mut frame[..r * m];
        normals.fill(T::ZERO);
        product_transposed(normals, &self.s[points], &b[wide], [r, k, m]);
        write_scaled(&mut self.e[block(j + 1, r * m)], normals, -next);

        integrate(omega, omega1, j, k * k, next);
        integrate(omega1, omega2, j, k * k, next);
        integrate(b, b1, j, m * k, next);
        integrate(b1, b2, j, m * k, next);
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
fn write_scaled<T: Number>(out: &mut [T], a: &[T], factor: f64) {
    for (out, a) in out.iter_mut().zip(a) {
        *out = *a * factor;
    }
}

/// The coefficient of order `j + 1` of a function from that of its derivative of order `j`.
#[inline(always)]
fn integrate<T: Number>(f: &mut [T], derivative: &[T], j: usize, size: usize, next: f64) {
    write_scaled(
        &mut f[block(j + 1, size)],
        &derivative[block(j, size)],
        next,
    );
}

/// `out += sum_i a_i b_{j-i}` with factors of shapes `(rows, inner)` and `(inner, cols)`.
#[inline(always)]
fn product<T: Number>(out: &mut [T], a: &[T], b: &[T], [rows, inner, cols]: [usize; 3]) {
    if rows * inner * cols == 0 {
        return;
    }
    let pairs = a
        .chunks_exact(rows * inner)
        .zip(b.chunks_exact(inner * cols).rev());
    for (a, b) in pairs {
        for (out, b) in out.chunks_exact_mut(rows).zip(b.chunks_exact(inner)) {
            for (a, b) in a.chunks_exact(rows).zip(b) {
                axpy(out, *b, a);
            }
        }
    }
}

/// `out += sum_i a_i b_{j-i}^T` with factors of shapes `(rows, inner)` and `(cols, inner)`.
#[inline(always)]
fn product_transposed<T: Number>(out: &mut [T], a: &[T], b: &[T], [rows, inner, cols]: [usize; 3]) {
    if rows * inner * cols == 0 {
        return;
    }
    let pairs = a
        .chunks_exact(rows * inner)
        .zip(b.chunks_exact(cols * inner).rev());
    for (a, b) in pairs {
        for (a, b) in a.chunks_exact(rows).zip(b.chunks_exact(cols)) {
            for (out, b) in out.chunks_exact_mut(rows).zip(b) {
                axpy(out, *b, a);
            }
        }
    }
}

/// `out = sum_i a_i^T b_{j-i}` with factors of shape `(m, k)`.
#[inline(always)]
fn gram<T: Number>(out: &mut [T], a: &[T], b: &[T], m: usize, k: usize) {
    out.fill(T::ZERO);
    if m * k == 0 {
        return;
    }
    for (a, b) in a.chunks_exact(m * k).zip(b.chunks_exact(m * k).rev()) {
        for (out, b) in out.chunks_exact_mut(k).zip(b.chunks_exact(m)) {
            for (out, a) in out.iter_mut().zip(a.chunks_exact(m)) {
                *out += dot(a, b);
            }
        }
    }
}

#[inline(always)]
fn axpy<T: Number>(out: &mut [T], factor: T, a: &[T]) {
    for (out, a) in out.iter_mut().zip(a) {
        *out += *a * factor;
    }
}

/// Four sums at once, which vector instructions can add.
#[inline(always)]
fn dot<T: Number>(a: &[T], b: &[T]) -> T {
    const WIDTH: usize = 4;
    let (heads_a, heads_b) = (a.chunks_exact(WIDTH), b.chunks_exact(WIDTH));
    let (rest_a, rest_b) = (heads_a.remainder(), heads_b.remainder());
    let mut sums = [T::ZERO; WIDTH];
    for (a, b) in heads_a.zip(heads_b) {
        for i in 0..WIDTH {
            sums[i] += a[i] * b[i];
        }
    }
    let mut sum = if a.len() < WIDTH {
        T::ZERO
    } else {
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    };
    for (a, b) in rest_a.iter().zip(rest_b) {
        sum += *a * *b;
    }
    sum
}
