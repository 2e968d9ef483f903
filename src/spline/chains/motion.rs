//! The unknowns of a chain of legs.

use std::ops::Range;

use crate::solve::gmres::norm;

/// The unknowns: velocities at the knots, per unit of time; acceleration and third vector at the start of each leg, in
/// the time of the leg.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    size: usize,
    knots: usize,
    /// Velocities, then accelerations and third vectors.
    pub(crate) entries: Vec<f64>,
}

impl Motion {
    /// A motion at rest.
    pub(crate) fn zeros(size: usize, knots: usize) -> Self {
        Motion {
            size,
            knots,
            entries: vec![0.0; size * (3 * knots - 2)],
        }
    }

    pub(crate) fn velocity(&self, knot: usize) -> &[f64] {
        &self.entries[self.size * knot..][..self.size]
    }

    pub(crate) fn velocity_mut(&mut self, knot: usize) -> &mut [f64] {
        &mut self.entries[self.size * knot..][..self.size]
    }

    /// The largest speed at some knots, in the time of the adjacent legs.
    pub(crate) fn speed(&self, knots: Range<usize>, lengths: &[f64]) -> f64 {
        let longest = |knot: usize| {
            let beside = [knot.checked_sub(1), Some(knot)].into_iter().flatten();
            beside
                .filter_map(|leg| lengths.get(leg))
                .fold(0.0_f64, |h, x| h.max(*x))
        };
        let speed = |knot: usize| longest(knot) * norm(self.velocity(knot));
        knots.map(speed).fold(0.0, f64::max)
    }

    /// Acceleration and third vector at the start of a leg.
    pub(crate) fn derivatives(&self, leg: usize) -> &[f64] {
        &self.entries[self.size * (self.knots + 2 * leg)..][..2 * self.size]
    }

    pub(crate) fn derivatives_mut(&mut self, leg: usize) -> &mut [f64] {
        &mut self.entries[self.size * (self.knots + 2 * leg)..][..2 * self.size]
    }

    /// Velocity, acceleration and third vector at the start of a leg of length `h`, in the time of the leg.
    pub(crate) fn start(&self, leg: usize, h: f64) -> Vec<f64> {
        let velocity = self.velocity(leg).iter().map(|v| h * v);
        velocity
            .chain(self.derivatives(leg).iter().copied())
            .collect()
    }

    pub(crate) fn add(&mut self, share: f64, step: &[f64]) {
        for (entry, step) in self.entries.iter_mut().zip(step) {
            *entry += share * step;
        }
    }

    /// Adds a fraction of a step to the accelerations and third vectors only.
    pub(crate) fn add_derivatives(&mut self, share: f64, step: &[f64]) {
        let derivatives = &mut self.entries[self.size * self.knots..];
        for (entry, step) in derivatives.iter_mut().zip(step) {
            *entry += share * step;
        }
    }
}
