//! Series in three dimensions, where skew matrices are vectors and brackets are cross products.

use std::ops::{Mul, Range};

use crate::linalg::dual::Number;
use crate::linalg::field::{Field, largest_each};
use crate::space::{Homogeneous, axis, skew};

/// Whether points are rotations in space.
pub(crate) fn is_of_rotations(space: impl Homogeneous) -> bool {
    space.size() == 3 && space.isotropy_dim() == 0
}

/// Computes the coefficients `k + 1` of the frames, matrices, for `k` in `powers`: the rows of `g x` are cross
/// products. The sums are those for matrices of any size without the zeros, in the same order.
#[inline(always)]
pub(crate) fn extend_matrices<T: Field>(matrices: &[T], frames: &mut [T], powers: Range<usize>) {
    for k in powers {
        let (known, next) = frames.split_at_mut((k + 1) * 9);
        let late = matrices[..(k + 1) * 9].chunks_exact(9).rev();
        let mut sums = [T::ZERO; 9];
        for (g, x) in known.chunks_exact(9).zip(late) {
            let [x, y, z] = axis(x);
            for (sum, g) in sums.chunks_exact_mut(3).zip(g.chunks_exact(3)) {
                sum[0] += g[1] * z;
                sum[0] -= g[2] * y;
                sum[1] -= g[0] * z;
                sum[1] += g[2] * x;
                sum[2] += g[0] * y;
                sum[2] -= g[1] * x;
            }
        }
        let factor = 1.0 / (k + 1) as f64;
        for (next, sum) in next.iter_mut().zip(sums) {
            *next = sum * factor;
        }
    }
}

/// The same for unit quaternions: `p' = p x / 2`.
#[inline(always)]
pub(crate) fn extend_quaternions<T: Field>(matrices: &[T], frames: &mut [T], powers: Range<usize>) {
    for k in powers {
        let mut sums = [T::ZERO; 4];
        let known = frames[..(k + 1) * 4].chunks_exact(4);
        let late = matrices[..(k + 1) * 9].chunks_exact(9).rev();
        for (p, x) in known.zip(late) {
            let [x, y, z] = axis(x);
            sums[0] -= p[1] * x;
            sums[1] += p[0] * x;
            sums[2] += p[0] * y;
            sums[3] += p[0] * z;
            sums[0] -= p[2] * y;
            sums[1] += p[2] * z;
            sums[2] += p[3] * x;
            sums[3] += p[1] * y;
            sums[0] -= p[3] * z;
            sums[1] -= p[3] * y;
            sums[2] -= p[1] * z;
            sums[3] -= p[2] * x;
        }
        let factor = 0.5 / (k + 1) as f64;
        for (p, sum) in frames[(k + 1) * 4..].iter_mut().zip(sums) {
            *p = sum * factor;
        }
    }
}

/// Writes the rotation from the first end to the last one, from a series of `x` of the given order; returns the contribution of
/// the last terms to the rate of rotation.
///
/// From `-s` to `s` it is the unit quaternion `(w, v)` of `g(-s)^{-1} g(s)`, where `w` is even and `v` is odd. With the even
/// part `e` of `x` and the odd part `o`,
///
/// ```math
/// w' = -\langle e, v\rangle,\qquad v' = w\,e + v \times o
/// ```
///
/// which takes a quarter of the products of [`extend_quaternions`]. Round-off grows with the angle `a` of a leg as
/// `e^{a/2}`: the rotation is off by 1.3e-14 at 12 radians. `spans` is a buffer for `2 order + 8` numbers.
#[inline(always)]
pub(crate) fn rotation_reached_into<T: Field>(
    matrices: &[T],
    order: usize,
    spans: &mut [T],
    out: &mut [T],
) -> T {
    // Coefficients of `w` and of `v`: a pair of powers in four numbers.
    let count = order / 2 + 2;
    let spans = &mut spans[..count * 4];
    spans[0] = T::constant(1.0);
    set_span(matrices, 0, spans);
    for pair in 1..count {
        set_scalar(matrices, pair, spans);
        set_span(matrices, pair, spans);
    }
    let (mut sums, mut power) = ([T::ZERO; 4], 1.0);
    for span in spans.chunks_exact(4) {
        sums[0] += span[0] * power;
        for (sum, v) in sums[1..].iter_mut().zip(&span[1..]) {
            *sum += *v * (0.5 * power);
        }
        power *= 0.25;
    }
    write_rotation(sums, out);
    // A rotation turns at twice the rate of its quaternion, and each end contributes half of it. The last power of `v` is
    // `2 count - 1`.
    let weight = 0.25_f64.powi(count as i32 - 1) * (2 * count - 1) as f64;
    largest_each(&spans[(count - 1) * 4..]) * weight
}

/// The coefficient `2 pair` of `w`, after all before it.
#[inline(always)]
fn set_scalar<T: Field>(matrices: &[T], pair: usize, spans: &mut [T]) {
    let (known, next) = spans.split_at_mut(4 * pair);
    let late = matrices[..18 * pair].as_chunks::<18>().0.iter().rev();
    let mut sums = [T::ZERO; 3];
    for (span, even) in known.as_chunks::<4>().0.iter().zip(late) {
        let [x, y, z] = axis(even);
        sums[0] += span[1] * x;
        sums[1] += span[2] * y;
        sums[2] += span[3] * z;
    }
    let [x, y, z] = sums;
    next[0] = (x + y + z) * (-0.5 / pair as f64);
}

/// The coefficient `2 pair + 1` of `v`, after that of `w`.
#[inline(always)]
fn set_span<T: Field>(matrices: &[T], pair: usize, spans: &mut [T]) {
    let (known, next) = spans.split_at_mut(4 * pair);
    let mut sums = axis(matrices).map(|x| next[0] * x);
    // Coefficients of odd powers, followed by those of the next even ones.
    let late = matrices[9..][..18 * pair].as_chunks::<18>().0.iter().rev();
    for (span, x) in known.as_chunks::<4>().0.iter().zip(late) {
        let ([a, b, c], [x, y, z]) = (axis(x), axis(&x[9..]));
        sums[0] += span[0] * x;
        sums[1] += span[0] * y;
        sums[2] += span[0] * z;
        add_cross_product([span[1], span[2], span[3]], [a, b, c], &mut sums);
    }
    let factor = 1.0 / (2 * pair + 1) as f64;
    for (v, sum) in next[1..4].iter_mut().zip(sums) {
        *v = sum * factor;
    }
}

/// The axial vector of the sum of `(j - i) [x_i, x_j]` over `i < j` with the given `i + j`.
#[inline(always)]
pub(crate) fn sum_of_brackets<T: Field>(x: &[T], sum: usize) -> [T; 3] {
    let (x, _) = x[..(sum + 1) * 9].as_chunks::<9>();
    let (early, late) = x.split_at(sum.div_ceil(2));
    let pairs = early.iter().zip(late.iter().rev());
    let (mut sums, mut weight) = ([T::ZERO; 3], sum as f64);
    for (a, b) in pairs {
        let ([ax, ay, az], [bx, by, bz]) = (axis(a), axis(b));
        sums[0] += (ay * bz - az * by) * weight;
        sums[1] += (az * bx - ax * bz) * weight;
        sums[2] += (ax * by - ay * bx) * weight;
        weight -= 2.0;
    }
    sums
}

/// Coefficients `i` of `x`, by which changes of coefficients `j` are multiplied where `i + j` is one less than their
/// number: axial vectors times `i - j`, by `j`.
#[inline(always)]
pub(crate) fn weigh<T: Field>(matrices: &[T], weighted: &mut [T]) {
    let count = weighted.len() / 3;
    let late = matrices[..count * 9].as_chunks::<9>().0.iter().rev();
    let mut weight = count as f64 - 1.0;
    for (x, out) in late.zip(weighted.as_chunks_mut::<3>().0) {
        for (out, x) in out.iter_mut().zip(axis(x)) {
            *out = x * weight;
        }
        weight -= 2.0;
    }
}

/// Adds the cross products of pairs of axial vectors.
#[inline(always)]
pub(crate) fn add_cross_products<X, Y>(a: &[X], b: &[Y], sums: &mut [X; 3])
where
    X: Number + Mul<Y, Output = X>,
    Y: Number,
{
    for (a, b) in a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0) {
        add_cross_product(*a, *b, sums);
    }
}

/// `sums += a x b`.
#[inline(always)]
fn add_cross_product<X, Y>(a: [X; 3], b: [Y; 3], sums: &mut [X; 3])
where
    X: Number + Mul<Y, Output = X>,
    Y: Number,
{
    sums[0] += a[1] * b[2];
    sums[1] += a[2] * b[0];
    sums[2] += a[0] * b[1];
    sums[0] -= a[2] * b[1];
    sums[1] -= a[0] * b[2];
    sums[2] -= a[1] * b[0];
}

/// Replaces an axial vector by the coordinates of its skew matrix.
#[inline(always)]
pub(crate) fn set_coordinates<T: Number>(space: impl Homogeneous, v: &mut [T]) {
    let matrix = skew([v[0], v[1], v[2]]);
    space.each_entry(
        #[inline(always)]
        |p, i, j| v[p] = matrix[i * 3 + j],
    );
}

/// The rotation of a unit quaternion.
#[inline(always)]
pub(crate) fn write_rotation<T: Field>([w, x, y, z]: [T; 4], out: &mut [T]) {
    let one = T::constant(1.0);
    out[0] = one - (y * y + z * z) * 2.0;
    out[1] = (x * y - w * z) * 2.0;
    out[2] = (x * z + w * y) * 2.0;
    out[3] = (x * y + w * z) * 2.0;
    out[4] = one - (x * x + z * z) * 2.0;
    out[5] = (y * z - w * x) * 2.0;
    out[6] = (x * z - w * y) * 2.0;
    out[7] = (y * z + w * x) * 2.0;
    out[8] = one - (x * x + y * y) * 2.0;
}
