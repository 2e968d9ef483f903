//! The durations of the legs of a chain, and the conditions on its knots.

use crate::linalg::field::larger;
use crate::solve::block_cholesky::SymmetricBlocks;

/// The fixed part of a knot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    /// Point and velocity are fixed.
    All,
    /// The point is fixed.
    Point,
    Nothing,
}

/// A chain of legs. The movable knots are unknowns, each a block `(p, v)` of a displacement and a velocity.
#[derive(Debug, Clone)]
pub(crate) struct ChainLayout {
    /// Durations of the legs.
    pub(crate) lengths: Vec<f64>,
    /// The fixed part of each knot; `All` is only allowed at the first and the last one.
    pub(crate) held: Vec<Held>,
    /// Whether the last knot is the first one, whose point is then fixed.
    pub(crate) is_closed: bool,
    /// Covariant accelerations at the first and the last knot if the velocity there is free; zero if none are given.
    pub(crate) accelerations: [Vec<f64>; 2],
}

impl ChainLayout {
    /// Legs of unit duration, whose inner knots are free.
    pub(crate) fn between_ends(legs: usize) -> Self {
        let mut held = vec![Held::Nothing; legs + 1];
        (held[0], held[legs]) = (Held::All, Held::All);
        ChainLayout {
            lengths: vec![1.0; legs],
            held,
            is_closed: false,
            accelerations: [Vec::new(), Vec::new()],
        }
    }

    pub(crate) fn legs(&self) -> usize {
        self.lengths.len()
    }

    /// The first movable knot.
    fn first(&self) -> usize {
        usize::from(self.held[0] == Held::All)
    }

    /// Number of movable knots.
    pub(crate) fn count(&self) -> usize {
        match self.is_closed {
            true => self.legs(),
            false => {
                self.legs() + 1 - self.first() - usize::from(self.held[self.legs()] == Held::All)
            }
        }
    }

    /// The block of a knot; `None` if the knot is fixed.
    pub(crate) fn block(&self, knot: usize) -> Option<usize> {
        let knot = match self.is_closed && knot == self.legs() {
            true => 0,
            false => knot,
        };
        let block = knot.checked_sub(self.first())?;
        (block < self.count()).then_some(block)
    }

    /// The knot of a block.
    pub(crate) fn knot(&self, block: usize) -> usize {
        self.first() + block
    }

    /// The shorter and the longer leg at a knot.
    fn around(&self, knot: usize) -> [f64; 2] {
        let before = match (knot, self.is_closed) {
            (0, true) => self.lengths.last(),
            (0, false) => None,
            _ => self.lengths.get(knot - 1),
        };
        let after = self.lengths.get(knot);
        let legs = || before.into_iter().chain(after);
        [
            legs().fold(f64::INFINITY, |h, leg| h.min(*leg)),
            legs().fold(0.0, |h, leg| h.max(*leg)),
        ]
    }

    /// The larger of `other` and the largest entry of a gradient, in the time of the shorter leg at each knot.
    pub(crate) fn largest_gradient(&self, gradient: &[f64], other: f64) -> f64 {
        self.largest(gradient, other, |[h, _]| [h.powi(3), h.powi(2)])
    }

    /// The largest displacement of a step, or change of a velocity in the time of the longer leg at its knot.
    pub(crate) fn largest_change(&self, step: &[f64]) -> f64 {
        self.largest(step, 0.0, |[_, h]| [1.0, h])
    }

    fn largest(&self, entries: &[f64], other: f64, units: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
        let d = entries.len() / (2 * self.count());
        let mut size = other;
        for (block, entries) in entries.chunks_exact(2 * d).enumerate() {
            let units = units(self.around(self.knot(block)));
            for (entries, unit) in entries.chunks_exact(d).zip(units) {
                for x in entries {
                    size = larger(size, (unit * x).abs());
                }
            }
        }
        size
    }

    /// The contribution of the accelerations at the ends to the cost: `<a_0, v_0> - <a_1, v_1>`.
    pub(crate) fn pull(&self, velocities: &[f64]) -> f64 {
        let [first, last] = &self.accelerations;
        let dot = |a: &[f64], v: &[f64]| -> f64 { a.iter().zip(v).map(|(a, v)| a * v).sum() };
        dot(first, velocities) - dot(last, &velocities[velocities.len() - last.len()..])
    }

    /// Adds its derivative to the gradient, and zeroes the entries for displacements of fixed points.
    pub(crate) fn constrain_gradient(&self, gradient: &mut [f64]) {
        let d = gradient.len() / (2 * self.count());
        let [first, last] = &self.accelerations;
        let at = gradient.len() - d;
        for (a, out) in first.iter().zip(&mut gradient[d..]) {
            *out += a;
        }
        for (a, out) in last.iter().zip(&mut gradient[at..]) {
            *out -= a;
        }
        for (block, out) in gradient.chunks_exact_mut(2 * d).enumerate() {
            if self.held[self.knot(block)] == Held::Point {
                out[..d].fill(0.0);
            }
        }
    }

    /// Replaces rows and columns of displacements of fixed points by those of the identity.
    pub(crate) fn constrain(&self, blocks: &mut SymmetricBlocks) {
        for block in 0..self.count() {
            if self.held[self.knot(block)] == Held::Point {
                blocks.hold(block, blocks.size / 2);
            }
        }
    }
}
