//! Anderson mixing: a fixed-point iteration that learns from its latest steps. Knows no geometry.

use std::collections::VecDeque;

/// A direction of which less than this is left after those before it have been taken off is no direction.
const DEPENDENT: f64 = 1e-8;

/// The accelerated iteration for `f(x) = 0`, where `f` is the step of a fixed-point iteration `x -> x + f(x)`.
///
/// ```math
/// x_{j+1} = x_j + f_j - (\Delta X + \Delta F)\, \gamma,\qquad \gamma = \arg\min |f_j - \Delta F \gamma|
/// ```
///
/// with the latest differences of iterates and of steps as columns of `Delta X` and `Delta F`. On linear problems it is
/// as good as the minimal residual method of as many directions as differences are kept.
///
/// # Source
/// Walker, Ni (2011), "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 1715-1735.
pub(crate) struct Anderson {
    depth: usize,
    /// The latest increment of the iterate, and the step before it.
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// Differences `(Delta x, Delta f)`, newest first.
    differences: VecDeque<(Vec<f64>, Vec<f64>)>,
}

impl Anderson {
    /// At most `depth` differences are kept.
    pub(crate) fn new(depth: usize) -> Self {
        Anderson {
            depth,
            last: None,
            differences: VecDeque::new(),
        }
    }

    /// Whether there was no step yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.last.is_none()
    }

    /// The increment of the iterate after its step `f` was found: the iterate itself may be a point of a manifold.
    pub(crate) fn increment(&mut self, f: Vec<f64>) -> Vec<f64> {
        if let Some((moved, before)) = self.last.take() {
            let change = f.iter().zip(before).map(|(f, before)| f - before);
            self.differences.push_front((moved, change.collect()));
            self.differences.truncate(self.depth);
        }
        let mut increment = f.clone();
        let shares = self.shares(&f);
        for ((dx, df), share) in self.differences.iter().zip(shares) {
            for ((to, dx), df) in increment.iter_mut().zip(dx).zip(df) {
                *to -= share * (dx + df);
            }
        }
        self.last = Some((increment.clone(), f));
        increment
    }

    /// The least-squares solution `gamma`, by modified Gram-Schmidt; dependent directions get nothing.
    fn shares(&self, f: &[f64]) -> Vec<f64> {
        let count = self.differences.len();
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(count);
        let mut upper = vec![vec![0.0; count]; count];
        let (mut rest, mut projections) = (f.to_vec(), vec![0.0; count]);
        for (j, (_, df)) in self.differences.iter().enumerate() {
            let (mut direction, before) = (df.clone(), dot(df, df).sqrt());
            for (i, earlier) in basis.iter().enumerate() {
                upper[i][j] = take_off(&mut direction, earlier);
            }
            let length = dot(&direction, &direction).sqrt();
            if length > DEPENDENT * before {
                direction.iter_mut().for_each(|entry| *entry /= length);
                upper[j][j] = length;
                projections[j] = take_off(&mut rest, &direction);
            } else {
                direction.fill(0.0);
            }
            basis.push(direction);
        }
        for j in (0..count).rev() {
            let sum: f64 = (j + 1..count).map(|l| upper[j][l] * projections[l]).sum();
            projections[j] = if upper[j][j] > 0.0 {
                (projections[j] - sum) / upper[j][j]
            } else {
                0.0
            };
        }
        projections
    }
}

/// Takes the part along a unit vector off; returns its length.
fn take_off(vector: &mut [f64], unit: &[f64]) -> f64 {
    let part = dot(vector, unit);
    for (entry, unit) in vector.iter_mut().zip(unit) {
        *entry -= part * unit;
    }
    part
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The step of `x -> M x + b`, `M` with entries that make the plain iteration slow.
    fn step(x: &[f64]) -> Vec<f64> {
        let m = |i: usize, j: usize| {
            let diagonal = [0.9, -0.7, 0.5][i % 3];
            if i == j {
                diagonal
            } else {
                0.01 * ((3 * i + j) as f64).sin()
            }
        };
        (0..x.len())
            .map(|i| {
                let image: f64 = x.iter().enumerate().map(|(j, x)| m(i, j) * x).sum();
                image + 1.0 - x[i]
            })
            .collect()
    }

    fn size(f: &[f64]) -> f64 {
        dot(f, f).sqrt()
    }

    #[test]
    fn a_linear_problem_is_solved_in_as_many_steps_as_unknowns() {
        let mut x = vec![0.0; 3];
        let mut anderson = Anderson::new(5);
        for _ in 0..5 {
            let increment = anderson.increment(step(&x));
            x = x.iter().zip(increment).map(|(x, dx)| x + dx).collect();
        }
        let plain = (0..5).fold(vec![0.0; 3], |x, _| {
            x.iter().zip(step(&x)).map(|(x, f)| x + f).collect()
        });
        // Three directions, condition number about 20.
        assert!(size(&step(&x)) < 1e-12, "{:e}", size(&step(&x)));
        assert!(size(&step(&plain)) > 0.1);
    }

    #[test]
    fn repeated_steps_do_no_harm() {
        let mut anderson = Anderson::new(3);
        for _ in 0..4 {
            let increment = anderson.increment(vec![0.5, 0.5]);
            assert_eq!(increment, [0.5, 0.5]);
        }
    }
}
