//! The Taylor series of a unit quaternion that turns with a body rate, and values of polynomials.

/// A vector in space.
pub(super) type VectorEntries = [f64; 3];

/// A quaternion, scalar last.
pub(super) type QuaternionEntries = [f64; 4];

/// Taylor coefficients of the quaternion, as many as of the rate, from its value at the center: `q' = q (w, 0) / 2`.
#[inline(always)]
pub(super) fn quaternion_series(
    w: &[VectorEntries],
    center: QuaternionEntries,
) -> Vec<QuaternionEntries> {
    let mut q = Vec::with_capacity(w.len());
    // Products with a rate are combinations of the products with the three unit vectors, computed four numbers at a
    // time.
    let mut units = Vec::with_capacity(w.len());
    q.push(center);
    units.push(by_units(center));
    for k in 0..w.len() - 1 {
        let mut sum = [0.0; 4];
        for (w, unit) in w[..=k].iter().zip(units.iter().rev()) {
            for i in 0..4 {
                sum[i] += w[0] * unit[0][i] + w[1] * unit[1][i] + w[2] * unit[2][i];
            }
        }
        let factor = 0.5 / (k + 1) as f64;
        let next = sum.map(|x| factor * x);
        q.push(next);
        units.push(by_units(next));
    }
    q
}

/// `q` times the unit vectors.
#[inline(always)]
fn by_units([x, y, z, s]: QuaternionEntries) -> [QuaternionEntries; 3] {
    [[s, z, -y, -x], [-z, s, x, -y], [y, -x, s, -z]]
}

/// The value of a polynomial. Every fourth power is summed separately: four short chains of additions instead of a long
/// one.
#[inline(always)]
pub(super) fn value<const N: usize>(coefficients: &[[f64; N]], u: f64) -> [f64; N] {
    let square = u * u;
    let fourth = square * square;
    if fourth.is_infinite() {
        // Zero times infinity: a curve at rest may be evaluated at any time.
        return coefficients.iter().rev().fold([0.0; N], |sum, c| {
            std::array::from_fn(|i| sum[i] * u + c[i])
        });
    }
    let mut sums = [[0.0; N]; 4];
    let mut fours = coefficients.chunks_exact(4);
    for (sum, last) in sums.iter_mut().zip(fours.remainder()) {
        *sum = *last;
    }
    while let Some(four) = fours.next_back() {
        let sums = sums.as_flattened_mut().iter_mut();
        for (sum, c) in sums.zip(four.as_flattened()) {
            *sum = *sum * fourth + c;
        }
    }
    let [a, b, c, d] = sums;
    std::array::from_fn(|i| (a[i] + square * c[i]) + u * (b[i] + square * d[i]))
}

/// The derivative of a polynomial, of order 0, 1 or 2.
#[inline(always)]
pub(super) fn derivative(coefficients: &[VectorEntries], u: f64, order: usize) -> VectorEntries {
    let mut sum = [0.0; 3];
    for (k, c) in coefficients.iter().enumerate().skip(order).rev() {
        let factor = (k + 1 - order..=k).map(|i| i as f64).product::<f64>();
        for (sum, c) in sum.iter_mut().zip(c) {
            *sum = *sum * u + factor * c;
        }
    }
    sum
}

/// `a b`: rotation by `b` first, then by `a`.
#[inline(always)]
pub(super) fn product(a: QuaternionEntries, b: QuaternionEntries) -> QuaternionEntries {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// The inverse of a unit quaternion.
pub(super) fn conjugate([x, y, z, w]: QuaternionEntries) -> QuaternionEntries {
    [-x, -y, -z, w]
}

pub(super) fn dot(a: QuaternionEntries, b: QuaternionEntries) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The quaternion scaled to unit length.
#[inline(always)]
pub(super) fn normalised(q: QuaternionEntries) -> QuaternionEntries {
    let factor = 1.0 / dot(q, q).sqrt();
    q.map(|x| factor * x)
}
