//! A leg of a spline: the end of the cubic that starts at a knot, in the frame of the next knot, with exact
//! derivatives.
//!
//! From `(x, x', x'')` at the identity the frame reaches `g`. With the next knot's frame `P` and `M = P^T g`,
//!
//! ```math
//! \mathrm{hor}(M I_k),\qquad \mathrm{hor}(M x),\qquad \mathrm{hor}(M x')\qquad\text{at } t = 1
//! ```
//!
//! are the distance from the next knot, and velocity and covariant acceleration there; `hor(M x'')` is the third
//! vector.

use faer::Mat;

use crate::cubic::taylor::march::Accuracy;
use crate::error::Result;
use crate::linalg::lanes::LANES;

/// Legs of splines of one shape; block sizes are hidden.
pub(crate) trait LegMap: Send {
    /// Integrates from `start = (x, x', x'')`, `3d` numbers, to a knot with the frame `next`, shape `(r, r)`, by
    /// columns. Writes distance, velocity, acceleration and third vector, as far as `values` has room for them. Returns
    /// `|S(1) - S_1|`. The tension is in the time of the leg.
    ///
    /// # Errors
    /// An error if the cubic cannot be integrated; `Interrupted`.
    fn ends_into(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64>;

    /// The same for as many legs as there are lanes, in the time that two legs take: one start, frame and set of values
    /// per leg. All legs use the shortest step.
    ///
    /// # Errors
    /// As [`LegMap::ends_into`], if one of the legs cannot be integrated.
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
    /// As [`LegMap::ends_into`].
    fn derivative(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
    ) -> Result<Mat<f64>>;

    /// From now on, limits integrations to the number of Taylor steps allowed for the given speed at one end.
    fn allow(&mut self, speed: f64);

    /// The work of the last integration.
    fn work(&self) -> f64;
}
