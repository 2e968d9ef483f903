//! The tangent lift of a map between coordinates, with the derivatives needed for its cotangent lift.
//!
//! A map `w -> y(w)` lifts to velocities as `(w, wdot) -> (y, Dy wdot)`. Second derivatives of the lift take third
//! derivatives of the map, which are stored as [`Jet`]s.

use super::jet::Jet;

/// A map of `N` variables into three coordinates, at a point with a velocity.
pub struct TangentLift<const N: usize> {
    jets: [Jet<N>; 3],
    velocity: [f64; N],
}

impl<const N: usize> TangentLift<N> {
    /// The lift of the map with the given jets at the given velocity of its variables.
    pub fn new(jets: [Jet<N>; 3], velocity: [f64; N]) -> Self {
        TangentLift { jets, velocity }
    }

    /// A coordinate of the image.
    pub fn coordinate(&self, i: usize) -> f64 {
        self.jets[i].value()
    }

    /// The velocity of a coordinate of the image.
    pub fn rate(&self, i: usize) -> f64 {
        (0..N)
            .map(|a| self.jets[i].first(a) * self.velocity[a])
            .sum()
    }

    /// `d y_i / d w_a`, which is `d ydot_i / d wdot_a` too.
    pub fn slope(&self, i: usize, a: usize) -> f64 {
        self.jets[i].first(a)
    }

    /// `d ydot_i / d w_a`.
    pub fn rate_slope(&self, i: usize, a: usize) -> f64 {
        (0..N)
            .map(|b| self.jets[i].second(a, b) * self.velocity[b])
            .sum()
    }

    /// The second derivative of `lambda . y + mu . ydot` with respect to `w_a` and `w_b`.
    pub fn bend(&self, lambda: &[f64], mu: &[f64], a: usize, b: usize) -> f64 {
        let one = |i: usize| {
            let rate: f64 = (0..N)
                .map(|c| self.jets[i].third(a, b, c) * self.velocity[c])
                .sum();
            lambda[i] * self.jets[i].second(a, b) + mu[i] * rate
        };
        (0..lambda.len()).map(one).sum()
    }

    /// The second derivative of `mu . ydot` with respect to `w_a` and `wdot_b`.
    pub fn mixed_bend(&self, mu: &[f64], a: usize, b: usize) -> f64 {
        (0..mu.len())
            .map(|i| mu[i] * self.jets[i].second(a, b))
            .sum()
    }
}
