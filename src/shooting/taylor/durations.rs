//! How long the parts of a step take, on one thread of 2.6 GHz with AVX-512, to tell whether others are worth waking:
//! waking them for any work, splines through 200 rotations take 1.8 times as long on two threads.

use super::rotation_series::is_of_rotations;
#[cfg(feature = "python")]
use crate::linalg::lanes::LANES;
use crate::space::Homogeneous;
#[cfg(feature = "python")]
use crate::threads::ALONE;

/// Microseconds of the derivative of eight legs of rotations, their longest part.
const ROTATIONS: f64 = 2.5;

/// Most keyframes of a spline of rotations of which no part is worth another thread, if they are near.
#[cfg(feature = "python")]
pub(crate) const ROTATIONS_ON_ONE_THREAD: usize = LANES * (ALONE / ROTATIONS) as usize;

/// Microseconds of an evaluation of a group of eight legs by series: 0.8 for rotations, 3 on St(3,1), 25 on St(4,2), 80
/// on St(6,3) and 150 on St(8,3), for neighbours 0.3 to 1 apart; within a factor of three.
pub(crate) fn micros_of_series(space: impl Homogeneous) -> f64 {
    match is_of_rotations(space) {
        true => 0.8,
        false => 0.15 * products_of_pair(space),
    }
}

/// The same for its derivative with a few terms: 2.5, 5, 25, 130 and 420.
pub(crate) fn micros_of_derivative(space: impl Homogeneous) -> f64 {
    match is_of_rotations(space) {
        true => ROTATIONS,
        false => 0.3 * products_of_pair(space),
    }
}

/// The same for its right-hand side and its step, of which the second takes 0.15 for rotations, 0.4 on St(4,2), and 1.5
/// on St(6,3).
pub(crate) fn micros_of_step(space: impl Homogeneous) -> f64 {
    0.012 * (space.dim() as f64).powi(2)
}

/// Number of products for a pair of terms of the series.
pub(crate) fn products_of_pair(space: impl Homogeneous) -> f64 {
    let [d, r] = [space.dim(), space.size()].map(|size| size as f64);
    4.0 * r * d + r * r * r
}
