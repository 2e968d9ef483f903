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
//! takes `j + 1` products of each kind, together `k (4 m k + r k + 2 r m)` multiplications each. Cubics in tension have
//! the additional terms `tau omega'` in `kappa'` and `tau b'` in `b'''`.
//!
//! On the Grassmann manifold `omega = kappa = 0`. The upper left block belongs to `h` too, and the equation `b''' =
//! -[[x, x']_h, x]` is the one of frames with `n^T - n` in place of `omega''`.

use super::block_products::{add_product, add_tension, integrate, write_scaled};
use super::blocks::{BlockSeries, BlockSizes, SeriesParts, are_few, block};
use super::fused;
use super::halves::Halves;
use super::rotation;
use crate::linalg::dual::Number;

/// Computes the coefficients of orders `1..=order` from those of order 0.
#[inline(always)]
pub(crate) fn expand<T: Number>(
    series: &mut BlockSeries<T>,
    blocks: impl BlockSizes,
    order: usize,
) {
    let (m, k) = (blocks.m::<T>(), blocks.k());
    let mut parts = series.parts();
    if rotation::fits(blocks) {
        return rotation::expand(&mut parts, blocks, order);
    }
    if are_few::<T, _>(blocks) {
        return fused::expand(&mut parts, blocks, order);
    }
    let b = &parts.b[0][..m * k];
    gram(&mut parts.p[..k * k], b, b, [m, k, k]);
    gram(&mut parts.n[..k * k], &parts.b[1][..m * k], b, [m, k, k]);
    if blocks.are_subspaces() {
        hold(&mut parts.omega[2][..k * k], &parts.n[..k * k], k);
    }
    for j in 0..order {
        extend(&mut parts, blocks, j);
    }
}

/// Computes the coefficients of order `j + 1` from those up to order `j`.
#[inline(always)]
fn extend<T: Number, B: BlockSizes>(parts: &mut SeriesParts<'_, T>, blocks: B, j: usize) {
    let (r, m, k) = (blocks.r::<T>(), blocks.m::<T>(), blocks.k());
    let [omega, omega1, omega2] = &mut parts.omega;
    let [b, b1, b2] = &mut parts.b;
    let next = 1.0 / (j + 1) as f64;
    let (wide, narrow) = (up_to(j, m * k), up_to(j, k * k));

    let n = &parts.n[block(j, k * k)];
    let p = &mut parts.p[block(j + 1, k * k)];
    let q = &mut parts.q[block(j, k * k)];
    for col in 0..k {
        for row in 0..k {
            let (i, transposed) = (row + k * col, col + k * row);
            p[i] = (n[i] + n[transposed]) * next;
            q[i] = n[i] - omega2[block(j, k * k)][i];
        }
    }

    let halves = Halves::new(blocks, m);
    let (tall, rest) = parts.tall[..m * k].split_at_mut(m * halves.wide);
    tall.fill(T::ZERO);
    product::<T, B>(tall, &b1[wide.clone()], &parts.p[narrow.clone()], [m, k, k]);
    for entry in tall.iter_mut() {
        *entry = -*entry;
    }
    product::<T, B>(tall, &b[wide.clone()], &parts.q[narrow.clone()], [m, k, k]);
    let turns = k > 1 && !blocks.are_subspaces();
    if turns {
        product::<T, B>(tall, &b2[wide.clone()], &omega[narrow.clone()], [m, k, k]);
    }
    halves.complete_lower(tall, rest, m);
    let tall = &mut parts.tall[..m * k];
    add_tension(tall, parts.tension, &b1[block(j, m * k)], 1.0);
    write_scaled(&mut b2[block(j + 1, m * k)], tall, next);

    let (point, rest) = parts.frame[..r * k].split_at_mut(r * halves.wide);
    point.fill(T::ZERO);
    let points = up_to(j, r * k);
    if turns {
        product::<T, B>(
            point,
            &parts.s[points.clone()],
            &omega[narrow.clone()],
            [r, k, k],
        );
    }
    product::<T, B>(
        point,
        &parts.e[up_to(j, r * m)],
        &b[wide.clone()],
        [r, m, k],
    );
    halves.complete(point, rest, r);
    write_scaled(
        &mut parts.s[block(j + 1, r * k)],
        &parts.frame[..r * k],
        next,
    );
    let (normals, rest) = parts.frame[..r * m].split_at_mut(r * halves.tall);
    normals.fill(T::ZERO);
    product_transposed::<T, B>(normals, &parts.s[points], &b[wide.clone()], [r, k, m]);
    halves.complete(normals, rest, r);
    write_scaled(
        &mut parts.e[block(j + 1, r * m)],
        &parts.frame[..r * m],
        -next,
    );

    integrate(b, b1, j, m * k, next);
    integrate(b1, b2, j, m * k, next);
    // The factors of the next n are already known.
    let next_wide = up_to(j + 1, m * k);
    let n = &mut parts.n[block(j + 1, k * k)];
    let (columns, rest) = n.split_at_mut(k * halves.wide);
    gram(
        columns,
        &b1[next_wide.clone()],
        &b[next_wide],
        [m, k, halves.wide],
    );
    halves.complete_upper(columns, rest, k);
    if blocks.are_subspaces() {
        hold(&mut omega2[block(j + 1, k * k)], n, k);
    } else if turns {
        let (square, rest) = parts.square[..k * k].split_at_mut(k * halves.wide);
        square.fill(T::ZERO);
        product::<T, B>(square, &omega2[narrow.clone()], &omega[narrow], [k, k, k]);
        halves.complete_upper(square, rest, k);
        let square = &mut parts.square[..k * k];
        // Half of a skew matrix: its transpose is subtracted below.
        add_tension(square, parts.tension, &omega1[block(j, k * k)], 0.5);
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

/// `omega'' = n^T - n`, which keeps the columns of a basis from rotating among themselves.
#[inline(always)]
fn hold<T: Number>(omega2: &mut [T], n: &[T], k: usize) {
    for col in 0..k {
        for row in 0..k {
            omega2[row + k * col] = n[col + k * row] - n[row + k * col];
        }
    }
}

/// Range of the blocks of orders up to `j`.
#[inline(always)]
fn up_to(j: usize, size: usize) -> std::ops::Range<usize> {
    0..(j + 1) * size
}

/// `out += sum_i a_i b_{j-i}` with factors of shapes `(rows, inner)` and `(inner, cols)`, for as many leading columns
/// as `out` has.
#[inline(always)]
fn product<T: Number, B: BlockSizes>(out: &mut [T], a: &[T], b: &[T], shape: [usize; 3]) {
    convolve::<T, B, false>(out, a, b, shape);
}

/// `out += sum_i a_i b_{j-i}^T` with factors of shapes `(rows, inner)` and `(cols, inner)`.
#[inline(always)]
fn product_transposed<T: Number, B: BlockSizes>(
    out: &mut [T],
    a: &[T],
    b: &[T],
    shape: [usize; 3],
) {
    convolve::<T, B, true>(out, a, b, shape);
}

/// Largest number of sums kept in registers.
const FEW: usize = 16;

/// `out += sum_i a_i b_{j-i}`, with the second factors optionally transposed.
#[inline(always)]
fn convolve<T: Number, B: BlockSizes, const TRANSPOSED: bool>(
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

/// `out = sum_i a_i^T b_{j-i}` with factors of shape `(m, k)`, for the given number of leading columns.
#[inline(always)]
fn gram<T: Number>(out: &mut [T], a: &[T], b: &[T], [m, k, columns]: [usize; 3]) {
    if m == 0 {
        return out.fill(T::ZERO);
    }
    for row in 0..k {
        let whole = columns - columns % 4;
        for col in (0..whole).step_by(4) {
            gram_entries::<T, 4>(out, a, b, [m, k], row, col);
        }
        match columns - whole {
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
