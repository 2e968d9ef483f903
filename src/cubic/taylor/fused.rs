//! The Taylor recurrence of [`super::recurrence`] for small blocks of known size: all Cauchy sums of one order in a
//! single loop.
//!
//! The sums stay in registers. Second factors are stored from the highest order down, so that both factors of a sum
//! `sum_i a_i b_{j-i}` are read forwards.

use super::block_products::{add_product, add_tension, integrate, write_scaled};
use super::blocks::{BlockSizes, SeriesParts, block};
use crate::linalg::dual::Number;

/// Largest number of entries of a sum.
const FEW: usize = 16;

/// Computes the coefficients of orders `1..=order` from those of order 0.
#[inline(always)]
pub(crate) fn expand<T: Number>(
    parts: &mut SeriesParts<'_, T>,
    blocks: impl BlockSizes,
    order: usize,
) {
    let (m, k) = (blocks.m::<T>(), blocks.k());
    let (mk, k2) = (m * k, k * k);
    let (b, b1) = (&parts.b[0][..mk], &parts.b[1][..mk]);
    let (mut square, mut n) = ([T::ZERO; FEW], [T::ZERO; FEW]);
    add_gram(&mut square, b, b, [m, k]);
    add_gram(&mut n, b1, b, [m, k]);
    fold_gram(&mut parts.p[block(order, k2)], &square, [m, k]);
    fold_gram(&mut parts.n[..k2], &n, [m, k]);
    parts.b_down[block(order, mk)].copy_from_slice(b);
    parts.omega_down[block(order, k2)].copy_from_slice(&parts.omega[0][..k2]);
    for j in 0..order {
        extend(parts, blocks, order, j);
    }
}

/// Computes the coefficients of order `j + 1` from those up to order `j`.
#[inline(always)]
fn extend<T: Number>(
    parts: &mut SeriesParts<'_, T>,
    blocks: impl BlockSizes,
    order: usize,
    j: usize,
) {
    let (r, m, k) = (blocks.r::<T>(), blocks.m::<T>(), blocks.k());
    let (rk, rm, mk, k2) = (r * k, r * m, m * k, k * k);
    let next = 1.0 / (j + 1) as f64;
    let [omega, omega1, omega2] = &mut parts.omega;
    let [b, b1, b2] = &mut parts.b;

    // Not read back from memory, which would wait for the stores.
    let vector = scaled(&b1[block(j, mk)], next);
    b[block(j + 1, mk)].copy_from_slice(&vector[..mk]);
    parts.b_down[block(order - j - 1, mk)].copy_from_slice(&vector[..mk]);
    let rate = scaled(&b2[block(j, mk)], next);
    b1[block(j + 1, mk)].copy_from_slice(&rate[..mk]);
    let n = &parts.n[block(j, k2)];
    for col in 0..k {
        for row in 0..k {
            let (i, transposed) = (row + k * col, col + k * row);
            parts.p[block(order - j - 1, k2)][i] = (n[i] + n[transposed]) * next;
            parts.q[block(order - j, k2)][i] = n[i] - omega2[block(j, k2)][i];
        }
    }

    let zero = [T::ZERO; FEW];
    let (mut plus, mut minus, mut point, mut normals) = (zero, zero, zero, zero);
    let (mut square, mut gram) = (zero, zero);
    // From order j, and from order j + 1, down to order 0.
    let down = |size: usize| (order - j) * size..(order + 1) * size;
    let above = (order - j - 1) * mk..(order + 1) * mk;
    let points = parts.s.chunks_exact(rk).zip(parts.e.chunks_exact(rm));
    let up = b[..].chunks_exact(mk).zip(b1[..].chunks_exact(mk));
    let turns = b2[..].chunks_exact(mk).zip(omega2[..].chunks_exact(k2));
    let squares = parts.p[down(k2)]
        .chunks_exact(k2)
        .zip(parts.q[down(k2)].chunks_exact(k2));
    let wide = parts.b_down[down(mk)]
        .chunks_exact(mk)
        .zip(parts.b_down[above].chunks_exact(mk));
    let narrow = parts.omega_down[down(k2)].chunks_exact(k2);
    let all = points.zip(up).zip(turns).zip(squares).zip(wide).zip(narrow);
    for ((((((s, e), (b, b1)), (b2, omega2)), (p, q)), (b_down, b_above)), omega) in all {
        add_product::<T, false>(&mut minus[..mk], b1, p, [m, k, k]);
        add_product::<T, false>(&mut plus[..mk], b, q, [m, k, k]);
        add_product::<T, false>(&mut point[..rk], e, b_down, [r, m, k]);
        add_product::<T, true>(&mut normals[..rm], s, b_down, [r, k, m]);
        add_gram(&mut gram, b1, b_above, [m, k]);
        if k > 1 {
            add_product::<T, false>(&mut plus[..mk], b2, omega, [m, k, k]);
            add_product::<T, false>(&mut point[..rk], s, omega, [r, k, k]);
            add_product::<T, false>(&mut square[..k2], omega2, omega, [k, k, k]);
        }
    }
    add_gram(&mut gram, &rate[..mk], &b[..mk], [m, k]);

    add_tension(&mut plus, parts.tension, &b1[block(j, mk)], 1.0);
    for (to, (plus, minus)) in b2[block(j + 1, mk)].iter_mut().zip(plus.iter().zip(&minus)) {
        *to = (*plus - *minus) * next;
    }
    write_scaled(&mut parts.s[block(j + 1, rk)], &point, next);
    write_scaled(&mut parts.e[block(j + 1, rm)], &normals, -next);
    let n = &mut parts.n[block(j + 1, k2)];
    fold_gram(n, &gram, [m, k]);
    if k > 1 {
        // Half of a skew matrix: its transpose is subtracted below.
        add_tension(&mut square, parts.tension, &omega1[block(j, k2)], 0.5);
        integrate(omega, omega1, j, k2, next);
        integrate(omega1, omega2, j, k2, next);
        parts.omega_down[block(order - j - 1, k2)].copy_from_slice(&omega[block(j + 1, k2)]);
        let target = &mut omega2[block(j + 1, k2)];
        for col in 0..k {
            for row in 0..k {
                let (i, transposed) = (row + k * col, col + k * row);
                let turning = (square[i] - square[transposed]) * next;
                target[i] = turning - (n[i] - n[transposed]);
            }
        }
    }
}

#[inline(always)]
fn scaled<T: Number>(a: &[T], factor: f64) -> [T; FEW] {
    let mut out = [T::ZERO; FEW];
    write_scaled(&mut out, a, factor);
    out
}

/// Adds the products that [`fold_gram`] combines to `a^T b`, for `a` and `b` of shape `(m, k)`.
#[inline(always)]
fn add_gram<T: Number>(sums: &mut [T], a: &[T], b: &[T], [m, k]: [usize; 2]) {
    for col in 0..k {
        for row in 0..k {
            for i in 0..m {
                sums[(row + k * col) * m + i] += a[m * row + i] * b[m * col + i];
            }
        }
    }
}

#[inline(always)]
fn fold_gram<T: Number>(out: &mut [T], sums: &[T], [m, k]: [usize; 2]) {
    for (i, out) in out[..k * k].iter_mut().enumerate() {
        let mut sum = sums[i * m];
        for term in &sums[i * m + 1..(i + 1) * m] {
            sum += *term;
        }
        *out = sum;
    }
}
