//! A leg of a spline: where the cubic from a knot arrives, in the frame of the next knot, with exact derivatives.
//!
//! From `(x, x', x'')` at the identity the frame comes to `g`. With the next knot's frame `P` and `M = P^T g`,
//!
//! ```math
//! \mathrm{hor}(M I_k),\qquad \mathrm{hor}(M x),\qquad \mathrm{hor}(M x')\qquad\text{at } t = 1
//! ```
//!
//! are the distance from the knot, and velocity and covariant acceleration there; `hor(M x'')` is the third vector.

use faer::Mat;

use super::taylor::Accuracy;
use crate::error::Result;
use crate::linalg::lanes::LANES;

/// Legs of splines of one shape; sizes of blocks hidden.
pub(crate) trait Leg: Send {
    /// From `start = (x, x', x'')`, `3d` numbers, to a knot with the frame `next`, shape `(r, r)`, column by column: distance,
    /// then as many of velocity, acceleration and third vector as there is room for. Returns `|S(1) - S_1|`. The tension is that
    /// in the time of the leg.
    ///
    /// # Errors
    /// Where the cubic cannot be integrated; `Interrupted`.
    fn arrive_into(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64>;

    /// The same for as many legs as there are lanes, which takes as long as for two of them: a start, a frame and values for each.
    /// The steps of all are as short as the shortest.
    ///
    /// # Errors
    /// As [`Leg::arrive_into`], where one of the legs cannot be integrated.
    fn arrive_abreast_into(
        &mut self,
        start: &[Vec<f64>; LANES],
        next: [&[f64]; LANES],
        tension: [f64; LANES],
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<[f64; LANES]>;

    /// The derivative of distance, velocity and acceleration with respect to the start, shape `(3d, 3d)`.
    ///
    /// # Errors
    /// As [`Leg::arrive_into`].
    fn derivative(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
    ) -> Result<Mat<f64>>;

    /// Allows arrivals the Taylor steps of curves with the given speed at one of their ends, and no more, from now on.
    fn allow(&mut self, speed: f64);

    /// How much work the last arrival was.
    fn work(&self) -> f64;
}
