//! Rotations of space in the angles of the charts, on numbers or on jets.
//!
//! ```math
//! G(\theta,\phi,\psi) = R_z(\phi) R_y(\theta) R_z(\psi)
//! ```
//!
//! Its third column is the point of the sphere at `(theta, phi)`; its third and first column are the frame of `St(3,2)`
//! at `(theta, phi, psi)`. So in both charts a rotation of space, and a retraction that rotates the moving frame, act
//! by products of quaternions.

use super::jet::{Analytic, atan2, cos_sinc, sin_cos, sqrt};

/// A quaternion `w + x i + y j + z k` of any length: only ratios of its entries are used.
pub type Quaternion<T> = [T; 4];

/// The product of two quaternions.
pub fn product<T: Analytic>(a: Quaternion<T>, b: Quaternion<T>) -> Quaternion<T> {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The unit quaternion of `G(theta, phi, psi)`.
pub fn from_angles<T: Analytic>([theta, phi, psi]: [T; 3]) -> Quaternion<T> {
    let half = T::from(0.5);
    let (s, c) = sin_cos(half * theta);
    let (sum_sin, sum_cos) = sin_cos(half * (phi + psi));
    let (difference_sin, difference_cos) = sin_cos(half * (phi - psi));
    [
        c * sum_cos,
        -s * difference_sin,
        s * difference_cos,
        c * sum_sin,
    ]
}

/// The angles `(theta, phi, psi)` of a quaternion; their derivatives grow without bound towards the poles.
pub fn angles<T: Analytic>([w, x, y, z]: Quaternion<T>) -> [T; 3] {
    let (half_sum, half_difference) = (atan2(z, w), atan2(-x, y));
    let half_theta = atan2(sqrt(x * x + y * y), sqrt(w * w + z * z));
    [
        T::from(2.0) * half_theta,
        half_sum + half_difference,
        half_sum - half_difference,
    ]
}

/// The rotation about `m` by the angle `|m|`.
pub fn exponential<T: Analytic>(m: [T; 3]) -> Quaternion<T> {
    let (half, quarter) = (T::from(0.5), T::from(0.25));
    let (cos, sinc) = cos_sinc(quarter * square(m));
    [
        cos,
        half * sinc * m[0],
        half * sinc * m[1],
        half * sinc * m[2],
    ]
}

/// The rotation `(I - M/2)^{-1} (I + M/2)` with `M` the skew matrix of `m`: about `m` by the angle `2 atan(|m| / 2)`.
pub fn cayley<T: Analytic>(m: [T; 3]) -> Quaternion<T> {
    let half = T::from(0.5);
    [T::from(1.0), half * m[0], half * m[1], half * m[2]]
}

fn square<T: Analytic>(m: [T; 3]) -> T {
    m[0] * m[0] + m[1] * m[1] + m[2] * m[2]
}
