//! Anderson mixing: acceleration of a fixed-point iteration from its latest steps. Independent of geometry.

use std::collections::VecDeque;

use super::gmres::dot;

/// A direction counts as dependent if less than this fraction of its square remains after orthogonalisation against the
/// previous ones: products are only accurate to round-off.
const DEPENDENT: f64 = 1e-13;

/// The accelerated iteration for `f(x) = 0`, where `f` is the step of a fixed-point iteration `x -> x + f(x)`.
///
/// ```math
/// x_{j+1} = x_j + f_j - (\Delta X + \Delta F)\, \gamma,\qquad \gamma = \arg\min |f_j - \Delta F \gamma|
/// ```
///
/// with the latest differences of iterates and of steps as columns of `Delta X` and `Delta F`. For linear problems it
/// is as good as GMRES with as many directions as stored differences.
///
/// # Source
/// Walker, Ni (2011), "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 1715-1735.
pub(crate) struct Anderson {
    depth: usize,
    /// The latest increment of the iterate, and the step before it.
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// Newest first.
    differences: VecDeque<Difference>,
}

/// A difference of steps, and its sum with the difference of iterates.
struct Difference {
    df: Vec<f64>,
    sum: Vec<f64>,
    /// Products of `df` with itself and with those of the older differences, newest first.
    products: Vec<f64>,
}

impl Anderson {
    /// Stores at most `depth` differences.
    pub(crate) fn new(depth: usize) -> Self {
        Anderson {
            depth,
            last: None,
            differences: VecDeque::new(),
        }
    }

    /// The increment of the iterate after computing its step `f`; the iterate itself may be a point of a manifold.
    pub(crate) fn increment(&mut self, f: Vec<f64>) -> Vec<f64> {
        if let Some((dx, last)) = self.last.take() {
            self.add_difference(dx, last, &f);
        }
        let mut increment = f.clone();
        for (difference, share) in self.differences.iter().zip(self.shares(&f)) {
            for (to, sum) in increment.iter_mut().zip(&difference.sum) {
                *to -= share * sum;
            }
        }
        self.last = Some((increment.clone(), f));
        increment
    }

    /// Stores the difference from the last step, given that step and the increment after it.
    fn add_difference(&mut self, mut sum: Vec<f64>, mut df: Vec<f64>, f: &[f64]) {
        for ((df, sum), f) in df.iter_mut().zip(&mut sum).zip(f) {
            *df = f - *df;
            *sum += *df;
        }
        self.differences.truncate(self.depth - 1);
        let older = self.differences.iter().map(|older| dot(&df, &older.df));
        let products = std::iter::once(dot(&df, &df)).chain(older).collect();
        self.differences
            .push_front(Difference { df, sum, products });
    }

    /// The least-squares solution `gamma`, by a Cholesky factorisation of the products of the differences, which are
    /// kept between steps; dependent directions get zero. A few digits are enough.
    fn shares(&self, f: &[f64]) -> Vec<f64> {
        let count = self.differences.len();
        let mut lower = vec![vec![0.0; count]; count];
        let mut shares = vec![0.0; count];
        for i in 0..count {
            let square = self.differences[i].products[0];
            for j in 0..=i {
                let known: f64 = (0..j).map(|l| lower[i][l] * lower[j][l]).sum();
                let rest = self.differences[j].products[i - j] - known;
                lower[i][j] = match i == j {
                    true if rest > DEPENDENT * square => rest.sqrt(),
                    false if lower[j][j] > 0.0 => rest / lower[j][j],
                    _ => 0.0,
                };
            }
            if lower[i][i] > 0.0 {
                let known: f64 = (0..i).map(|l| lower[i][l] * shares[l]).sum();
                shares[i] = (dot(f, &self.differences[i].df) - known) / lower[i][i];
            }
        }
        for i in (0..count).rev() {
            if lower[i][i] > 0.0 {
                let known: f64 = (i + 1..count).map(|l| lower[l][i] * shares[l]).sum();
                shares[i] = (shares[i] - known) / lower[i][i];
            }
        }
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The step of `x -> M x + b`, where `M` makes the plain iteration slow.
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
        // Three directions, with a condition number of about 20.
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
