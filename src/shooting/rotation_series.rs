//! Series in three dimensions, where skew matrices are vectors and brackets are cross products.

use std::ops::Range;

use crate::linalg::field::{Field, largest_each};
use crate::space::{Homogeneous, axis};

/// Whether points are rotations in space.
pub(super) fn is_of_rotations(space: impl Homogeneous) -> bool {
    space.size() == 3 && space.isotropy_dim() == 0
}

/// Computes the coefficients `k + 1` of the frames, matrices, for `k` in `powers`: the rows of `g x` are cross products. The sums
/// are those for matrices of any size without the zeros, in the same order.
#[inline(always)]
pub(super) fn extend_matrices<T: Field>(matrices: &[T], frames: &mut [T], powers: Range<usize>) {
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
pub(super) fn extend_quaternions<T: Field>(matrices: &[T], frames: &mut [T], powers: Range<usize>) {
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
/// which takes a quarter of the products of [`extend_quaternions`]. `spans` is a buffer for `2 order + 8` numbers.
#[inline(always)]
pub(super) fn rotation_reached_into<T: Field>(
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
    // A quaternion turns at twice its rate; the last power of `v` is `2 count - 1`.
    let weight = 0.25_f64.powi(count as i32 - 1) * (2 * count - 1) as f64;
    largest_each(&spans[(count - 1) * 4..]) * weight
}

/// The coefficient `2 pair` of `w`, after all before it.
#[inline(always)]
fn set_scalar<T: Field>(matrices: &[T], pair: usize, spans: &mut [T]) {
    let (known, next) = spans.split_at_mut(4 * pair);
    let late = matrices[..18 * pair].chunks_exact(18).rev();
    let mut sums = [T::ZERO; 3];
    for (span, even) in known.chunks_exact(4).zip(late) {
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
    let late = matrices[9..][..18 * pair].chunks_exact(18).rev();
    for (span, x) in known.chunks_exact(4).zip(late) {
        let ([a, b, c], [x, y, z]) = (axis(x), axis(&x[9..]));
        sums[0] += span[0] * x;
        sums[1] += span[0] * y;
        sums[2] += span[0] * z;
        sums[0] += span[2] * c;
        sums[1] += span[3] * a;
        sums[2] += span[1] * b;
        sums[0] -= span[3] * b;
        sums[1] -= span[1] * c;
        sums[2] -= span[2] * a;
    }
    let factor = 1.0 / (2 * pair + 1) as f64;
    for (v, sum) in next[1..4].iter_mut().zip(sums) {
        *v = sum * factor;
    }
}

/// The axial vector of the sum of `(j - i) [x_i, x_j]` over `i < j` with the given `i + j`.
#[inline(always)]
pub(super) fn sum_of_brackets<T: Field>(x: &[T], sum: usize) -> [T; 3] {
    let late = x[..(sum + 1) * 9].chunks_exact(9).rev();
    let pairs = x.chunks_exact(9).zip(late).take(sum.div_ceil(2));
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

/// The rotation of a unit quaternion.
#[inline(always)]
pub(super) fn write_rotation<T: Field>([w, x, y, z]: [T; 4], out: &mut [T]) {
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

#[cfg(test)]
mod tests {
    use super::super::brackets::minus_bracket_into;
    use super::super::series::{Series, at_ends};
    use super::*;
    use crate::linalg::field::{largest, transposed_multiply};
    use crate::space::{FixedFrames, Subspaces};

    const ORDER: usize = 40;

    /// `x, x', x''` at a middle: general, at rest, turning about one axis, and with zeros.
    fn middles(d: usize) -> Vec<[Vec<f64>; 3]> {
        let entry = |seed: f64| (0..d).map(|p| (seed + 1.9 * p as f64).sin()).collect();
        let one = |value: f64| (0..d).map(|p| if p == 0 { value } else { 0.0 }).collect();
        vec![
            [1.0, 2.3, 5.7].map(entry),
            [0.0, 0.0, 0.0].map(one),
            [3.0, 1.0, -2.0].map(one),
            [one(1.5), entry(0.4), one(0.0)],
            [one(0.0), one(0.0), entry(1.1)],
        ]
    }

    /// The rotation between the ends is that of the frames there, for every parity of the order.
    #[test]
    fn rotations_between_the_ends_are_those_of_the_frames() {
        fn compare(space: impl Homogeneous) {
            for middle in middles(space.dim()) {
                for order in [ORDER, ORDER + 1] {
                    let mut series = Series::new(space, order);
                    let middle = middle.each_ref().map(Vec::as_slice);
                    series.set_curve(space, middle, None, order);
                    let [mut found, mut expected, mut first, mut last] = [[0.0; 9]; 4];
                    let tail = series.reached_into(space, order, &mut found);
                    series.set_frames(space, order);
                    let frames = &series.frames[..(order + 1) * 9];
                    at_ends(frames, 9, 0, [&mut first, &mut last]);
                    transposed_multiply(3, &first, &last, &mut expected);
                    for (x, y) in found.iter_mut().zip(expected) {
                        *x -= y;
                    }
                    assert!(largest(&found) < 4e-15, "{:e}", largest(&found));
                    assert!(tail < 1e-14, "{tail:e}");
                }
            }
        }
        compare(FixedFrames::<3, 2>);
        compare(FixedFrames::<3, 1>);
        compare(Subspaces { r: 3, k: 1 });
    }

    /// A constant rate turns by itself, also beyond half turns and by whole ones.
    #[test]
    fn constant_rates_are_exact() {
        for angle in [0.0, 1e-8, 1.0, std::f64::consts::PI, 6.5] {
            let mut matrices = vec![0.0; (ORDER + 3) * 9];
            (matrices[2], matrices[6]) = (angle, -angle);
            let (mut spans, mut found) = (vec![0.0; 2 * ORDER + 8], [0.0; 9]);
            rotation_reached_into(&matrices, ORDER, &mut spans, &mut found);
            let (sin, cos) = angle.sin_cos();
            for (x, y) in found
                .iter_mut()
                .zip([cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos])
            {
                *x -= y;
            }
            assert!(largest(&found) < 4e-15, "{angle}: {:e}", largest(&found));
        }
    }

    /// The last terms tell how far a short series is from the rotation.
    #[test]
    fn last_terms_measure_the_truncation() {
        let space = FixedFrames::<3, 2>;
        let middle = [1.0, 2.3, 5.7].map(|seed: f64| [seed.sin(), seed.cos(), 0.4 * seed]);
        let middle = middle.each_ref().map(<[f64; 3]>::as_slice);
        let [mut exact, mut found] = [[0.0; 9]; 2];
        let mut series = Series::new(space, ORDER);
        series.set_curve(space, middle, None, ORDER);
        series.reached_into(space, ORDER, &mut exact);
        for order in [6, 9, 12, 15] {
            let tail = series.reached_into(space, order, &mut found);
            let errors = exact.iter().zip(found).map(|(x, y)| (x - y).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(
                error < tail && tail < 1e4 * error,
                "{order}: {error:e} {tail:e}"
            );
        }
    }

    /// Small integers are exact in any order of summation.
    #[test]
    fn sums_of_brackets_are_those_of_all_matrices() {
        let space = FixedFrames::<3, 2>;
        let mut matrices = vec![0.0; 9 * 9 + 8];
        for (i, matrix) in matrices.chunks_exact_mut(9).enumerate() {
            let entry = |j: usize| ((5 * i + 3 * j) % 7) as f64 - 3.0;
            matrix.copy_from_slice(&crate::space::skew([entry(0), entry(1), entry(2)]));
        }
        for sum in 1..8_usize {
            let pairs = (0..sum.div_ceil(2)).map(|i| {
                let weight = (sum - 2 * i) as f64;
                (weight, &matrices[i * 9..], &matrices[(sum - i) * 9..])
            });
            let mut expected = [0.0; 3];
            minus_bracket_into(space, pairs, &mut expected);
            let product = crate::space::skew(sum_of_brackets(&matrices, sum));
            let mut found = [0.0; 3];
            space.each_entry(|p, i, j| found[p] = -product[i * 3 + j]);
            assert_eq!(found, expected, "{sum}");
        }
    }
}
