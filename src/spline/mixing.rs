//! Anderson mixing of a fixed-point iteration.
//!
//! # Source
//! Walker, Ni (2011), "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 1715-1735, (2.1)-(2.3),
//! in the increments of the iteration alone, so that it may move on a manifold.

use std::collections::VecDeque;

/// Past iterations that are mixed in.
const DEPTH: usize = 6;

/// Past changes that are this nearly dependent, relative to their length, are left out.
const DEPENDENT: f64 = 1e-8;

/// The last few steps of a fixed-point iteration `x <- x + f(x)`.
#[derive(Debug, Default)]
pub(super) struct Mixing {
    /// Changes of `x` and of `f` from one iteration to the next, the latest first.
    past: VecDeque<(Vec<f64>, Vec<f64>)>,
    last: Option<(Vec<f64>, Vec<f64>)>,
}

impl Mixing {
    /// Whether there was no step yet.
    pub(super) fn is_empty(&self) -> bool {
        self.last.is_none()
    }

    /// The increment of `x` after `f` was found there.
    ///
    /// ```math
    /// \Delta x = f - \sum_j \gamma_j (\Delta x_j + \Delta f_j),\qquad \gamma = \arg\min |f - \sum_j \gamma_j \Delta f_j|
    /// ```
    pub(super) fn increment(&mut self, f: Vec<f64>) -> Vec<f64> {
        if let Some((moved, before)) = self.last.take() {
            let change = f.iter().zip(before).map(|(f, before)| f - before).collect();
            self.past.truncate(DEPTH - 1);
            self.past.push_front((moved, change));
        }
        let weights = self.weights(&f);
        let mut increment = f.clone();
        for (weight, (moved, change)) in weights.iter().zip(&self.past) {
            for ((to, moved), change) in increment.iter_mut().zip(moved).zip(change) {
                *to -= weight * (moved + change);
            }
        }
        self.last = Some((increment.clone(), f));
        increment
    }

    /// The solution of the least-squares problem, by Gram-Schmidt: the changes are few.
    fn weights(&self, f: &[f64]) -> Vec<f64> {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut upper: Vec<Vec<f64>> = Vec::new();
        let mut right = Vec::new();
        let mut rest = f.to_vec();
        for (_, change) in &self.past {
            let (mut direction, mut column) = (change.clone(), Vec::new());
            for q in &basis {
                column.push(remove(q, &mut direction));
            }
            let length = dot(&direction, &direction).sqrt();
            if length <= DEPENDENT * dot(change, change).sqrt() {
                break;
            }
            direction.iter_mut().for_each(|x| *x /= length);
            right.push(remove(&direction, &mut rest));
            column.push(length);
            basis.push(direction);
            upper.push(column);
        }
        for j in (0..right.len()).rev() {
            right[j] /= upper[j][j];
            for i in 0..j {
                right[i] -= upper[j][i] * right[j];
            }
        }
        right
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes the part along a unit vector out of `a`, and returns how much it was.
fn remove(unit: &[f64], a: &mut [f64]) -> f64 {
    let part = dot(unit, a);
    for (a, unit) in a.iter_mut().zip(unit) {
        *a -= part * unit;
    }
    part
}
