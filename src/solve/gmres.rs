//! Linear equations with an operator close to the identity that is given only by its action.

use std::convert::Infallible;

use crate::linalg::lanes::LANES;
use crate::linalg::simd::vectorised;

/// Maximal number of directions. The operators of chains need three to ten; those of linearised cubics needed 3 at
/// rest, 9 at a speed of 1, 15 to 23 from 3 to 8, with four vectors per node as unknowns.
const MAX_DIRECTIONS: usize = 40;

/// GMRES, the generalised minimal residual method, with buffers allocated once per size.
///
/// # Source
/// Saad, Schultz (1986), "GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear systems",
/// SIAM J. Sci. Stat. Comput. 7, 856-869.
pub(crate) struct Gmres {
    basis: Vec<Vec<f64>>,
    /// Columns of the triangular factor.
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    rhs: Vec<f64>,
    image: Vec<f64>,
}

impl Gmres {
    pub(crate) fn new(size: usize) -> Self {
        Gmres {
            basis: Vec::new(),
            columns: Vec::new(),
            rotations: Vec::new(),
            rhs: Vec::new(),
            image: vec![0.0; size],
        }
    }

    /// Solves `A x = b` from `x = 0` until the residual is at most `tolerance |b|`; on entry `x` contains `b`.
    ///
    /// Stops after `MAX_DIRECTIONS` products with the best `x` so far; the caller judges the resulting step.
    pub(crate) fn solve(
        &mut self,
        x: &mut [f64],
        tolerance: f64,
        mut apply: impl FnMut(&[f64], &mut [f64]),
    ) {
        let Ok(()) = self.try_solve(x, tolerance, |x, image| {
            apply(x, image);
            Ok::<(), Infallible>(())
        });
    }

    /// [`Gmres::solve`] with products that can fail.
    ///
    /// # Errors
    /// The error of the first product that fails; `x` is then the best iterate so far.
    pub(crate) fn try_solve<E>(
        &mut self,
        x: &mut [f64],
        tolerance: f64,
        mut apply: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<(), E> {
        let size = norm(x);
        if size == 0.0 {
            return Ok(());
        }
        self.rotations.clear();
        self.rhs.clear();
        self.rhs.push(size);
        self.direction(0, x, 1.0 / size);
        let mut used = 0;
        while used < MAX_DIRECTIONS {
            if let Err(error) = apply(&self.basis[used], &mut self.image) {
                self.combine(used, x);
                return Err(error);
            }
            let residual = self.extend(used);
            used += 1;
            if residual <= tolerance * size {
                break;
            }
            let length = self.columns[used - 1][used];
            if length == 0.0 {
                break;
            }
            let image = std::mem::take(&mut self.image);
            self.direction(used, &image, 1.0 / length);
            self.image = image;
        }
        self.combine(used, x);
        Ok(())
    }

    /// `basis[index] = factor source`.
    fn direction(&mut self, index: usize, source: &[f64], factor: f64) {
        if index == self.basis.len() {
            self.basis.push(vec![0.0; source.len()]);
        }
        for (to, from) in self.basis[index].iter_mut().zip(source) {
            *to = factor * from;
        }
    }

    /// Orthogonalises the image and extends the triangular factor by its coefficients; returns the residual.
    fn extend(&mut self, index: usize) -> f64 {
        vectorised(
            #[inline(always)]
            || self.orthogonalise(index),
        )
    }

    #[inline(always)]
    fn orthogonalise(&mut self, index: usize) -> f64 {
        if index == self.columns.len() {
            self.columns.push(vec![0.0; MAX_DIRECTIONS + 1]);
        }
        let column = &mut self.columns[index];
        let before = norm(&self.image);
        for (i, direction) in self.basis[..=index].iter().enumerate() {
            let share = dot(direction, &self.image);
            column[i] = share;
            for (to, from) in self.image.iter_mut().zip(direction) {
                *to -= share * from;
            }
        }
        let mut length = norm(&self.image);
        // A remainder of the size of round-off after cancellation is no direction.
        if length <= 16.0 * f64::EPSILON * before {
            length = 0.0;
        }
        for (i, (cos, sin)) in self.rotations.iter().enumerate() {
            let (x, y) = (column[i], column[i + 1]);
            column[i] = cos * x + sin * y;
            column[i + 1] = cos * y - sin * x;
        }
        let radius = column[index].hypot(length);
        let (cos, sin) = if radius > 0.0 {
            (column[index] / radius, length / radius)
        } else {
            (1.0, 0.0)
        };
        column[index] = radius;
        // The place below the diagonal holds the length of the new direction.
        column[index + 1] = length;
        self.rotations.push((cos, sin));
        let last = self.rhs[index];
        self.rhs[index] = cos * last;
        self.rhs.push(-sin * last);
        (sin * last).abs()
    }

    fn combine(&mut self, used: usize, x: &mut [f64]) {
        for i in (0..used).rev() {
            let mut sum = self.rhs[i];
            for j in i + 1..used {
                sum -= self.columns[j][i] * self.rhs[j];
            }
            let pivot = self.columns[i][i];
            self.rhs[i] = if pivot > 0.0 { sum / pivot } else { 0.0 };
        }
        x.fill(0.0);
        for i in 0..used {
            for (to, from) in x.iter_mut().zip(&self.basis[i]) {
                *to += self.rhs[i] * from;
            }
        }
    }
}

#[inline(always)]
pub(crate) fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// The sum of products of the entries that both have, in eight parts: a single sum would wait for each addition.
#[inline(always)]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let count = x.len().min(y.len());
    let (x, y) = (
        x[..count].chunks_exact(LANES),
        y[..count].chunks_exact(LANES),
    );
    let rest = x.remainder().iter().zip(y.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    let mut sums = [0.0; LANES];
    for (x, y) in x.zip(y) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small integers, exact in any order of summation.
    #[test]
    fn products_of_any_length_are_summed() {
        for count in 0..30_usize {
            let x: Vec<f64> = (0..count).map(|i| i as f64 - 7.0).collect();
            for more in [0, 1, 9] {
                let y: Vec<f64> = (0..count + more).map(|i| 3.0 - i as f64).collect();
                let exact: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
                assert_eq!(dot(&x, &y), exact, "{count} {more}");
                assert_eq!(dot(&y, &x), exact, "{count} {more}");
            }
        }
        assert_eq!(norm(&[3.0, 4.0]), 5.0);
    }
}
