//! Functions of `ad_L` on skew matrices by Chebyshev polynomials, using only matrix products.

use std::f64::consts::PI;

use faer::{Mat, MatRef};

use crate::linalg::product::{mul_into, scale};

/// Maximal degree in `ad_L^2`; 8 suffices for 1e-4 on the whole range of a principal logarithm.
const MAX_DEGREE: usize = 10;

/// Number of interpolation points from which the coefficients are computed.
const NODES: usize = 24;

/// The factor is truncated at this value: it has a pole at `2 pi`, and a Newton step only needs its sign there.
const LOWEST: f64 = -1.5;

/// `f(ad_L)` with `f(x) = x / (1 - e^{-x})`, the derivative of the logarithm at `e^L`.
///
/// ```math
/// f(x) = \frac{x}{2} + g(-x^2),\qquad g(t^2) = \frac{t}{2} \cot \frac{t}{2}
/// ```
///
/// `ad_L` has eigenvalues `i t` with `|t|` at most twice the largest angle of `L`. `g` is analytic below `t = 2 pi`, so
/// a Chebyshev polynomial in `ad_L^2` of degree 2 to 6 is accurate enough for a Newton step.
pub(super) struct AdjointFunction {
    generator: Mat<f64>,
    /// Largest `|t|`.
    radius: f64,
    coefficients: [f64; MAX_DEGREE + 1],
    degree: usize,
    product: Mat<f64>,
    first: Mat<f64>,
    inner: Mat<f64>,
    previous: Mat<f64>,
    current: Mat<f64>,
}

impl AdjointFunction {
    pub(super) fn new(m: usize) -> Self {
        let zeros = || Mat::zeros(m, m);
        AdjointFunction {
            generator: zeros(),
            radius: 0.0,
            coefficients: [0.0; MAX_DEGREE + 1],
            degree: 0,
            product: zeros(),
            first: zeros(),
            inner: zeros(),
            previous: zeros(),
            current: zeros(),
        }
    }

    /// Sets `L`, and a polynomial with an error of at most `tolerance`.
    pub(super) fn set(&mut self, generator: MatRef<'_, f64>, tolerance: f64) {
        self.generator.copy_from(generator);
        // |L|_F^2 = 2 sum theta^2 and |L^2|_F^2 = 2 sum theta^4 bound the sum of two angles.
        let second = frobenius(&self.generator);
        mul_into(&mut self.product, 1.0, generator, generator);
        let fourth = (2.0 * frobenius(&self.product)).sqrt();
        self.radius = second.min(fourth).clamp(1e-8, 2.0 * PI);
        self.coefficients = [0.0; MAX_DEGREE + 1];
        for i in 0..NODES {
            let x = (PI * (i as f64 + 0.5) / NODES as f64).cos();
            let value = half_cotangent(self.radius * (0.5 * (x + 1.0)).sqrt()) / NODES as f64;
            let (mut previous, mut polynomial) = (x, 1.0);
            for (j, coefficient) in self.coefficients.iter_mut().enumerate() {
                *coefficient += value * if j == 0 { 1.0 } else { 2.0 * polynomial };
                (previous, polynomial) = (polynomial, 2.0 * x * polynomial - previous);
            }
        }
        let mut tail = 0.0;
        self.degree = MAX_DEGREE;
        while self.degree > 1 && tail + self.coefficients[self.degree].abs() <= tolerance {
            tail += self.coefficients[self.degree].abs();
            self.degree -= 1;
        }
    }

    /// `out = [L, e]` for skew `e`.
    pub(super) fn bracket_into(&mut self, out: &mut Mat<f64>, e: &Mat<f64>) {
        bracket(out, &self.generator, e, &mut self.product);
    }

    /// `out = f(ad_L) e`.
    pub(super) fn apply(&mut self, out: &mut Mat<f64>, e: &Mat<f64>) {
        self.apply_even(out, e);
        combine(out, 1.0, &self.first, 0.5);
    }

    /// `out = g(-ad_L^2) e`, the symmetric part of `f`, by Clenshaw's recurrence.
    pub(super) fn apply_even(&mut self, out: &mut Mat<f64>, e: &Mat<f64>) {
        let (c, leading) = (self.coefficients, self.coefficients[self.degree]);
        // ad_L^2 maps [-radius^2, 0] to the argument y = factor ad_L^2 - 1 in [-1, 1].
        let factor = -2.0 / (self.radius * self.radius);
        self.previous.fill(0.0);
        self.current.copy_from(e);
        combine(&mut self.current, leading, e, 0.0);
        for j in (0..self.degree).rev() {
            if j + 1 == self.degree {
                // The first one starts from [L, e], which the odd part of f needs as well.
                bracket(&mut self.first, &self.generator, e, &mut self.product);
                bracket(out, &self.generator, &self.first, &mut self.product);
                scale(&mut *out, leading);
            } else {
                let current = &self.current;
                bracket(&mut self.inner, &self.generator, current, &mut self.product);
                bracket(out, &self.generator, &self.inner, &mut self.product);
            }
            let twice = if j == 0 { 1.0 } else { 2.0 };
            for col in 0..out.ncols() {
                let entries = out.col_as_slice_mut(col).iter_mut();
                let current = self.current.col_as_slice(col).iter();
                let others = self
                    .previous
                    .col_as_slice(col)
                    .iter()
                    .zip(e.col_as_slice(col));
                for ((x, current), (previous, e)) in entries.zip(current).zip(others) {
                    *x = twice * (factor * *x - current) - previous + c[j] * e;
                }
            }
            if j > 0 {
                std::mem::swap(&mut self.previous, &mut self.current);
                std::mem::swap(out, &mut self.current);
            }
        }
    }
}

/// Frobenius norm of a matrix whose squared entries neither overflow nor underflow.
pub(super) fn frobenius(a: &Mat<f64>) -> f64 {
    let mut lanes = [0.0; 8];
    for j in 0..a.ncols() {
        let chunks = a.col_as_slice(j).chunks_exact(lanes.len());
        for x in chunks.remainder() {
            lanes[0] += x * x;
        }
        for chunk in chunks {
            for (lane, x) in lanes.iter_mut().zip(chunk) {
                *lane += x * x;
            }
        }
    }
    lanes.iter().sum::<f64>().sqrt()
}

/// `out = [a, b]` of skew matrices: one product, since `b a = (a b)^T`.
pub(super) fn bracket(out: &mut Mat<f64>, a: &Mat<f64>, b: &Mat<f64>, product: &mut Mat<f64>) {
    mul_into(&mut *product, 1.0, a, b);
    for j in 0..product.ncols() {
        out[(j, j)] = 0.0;
        for i in 0..j {
            let entry = product[(i, j)] - product[(j, i)];
            out[(i, j)] = entry;
            out[(j, i)] = -entry;
        }
    }
}

/// `out = alpha out + beta other`.
fn combine(out: &mut Mat<f64>, alpha: f64, other: &Mat<f64>, beta: f64) {
    for j in 0..out.ncols() {
        for (x, y) in out
            .col_as_slice_mut(j)
            .iter_mut()
            .zip(other.col_as_slice(j))
        {
            *x = alpha * *x + beta * y;
        }
    }
}

/// `(t/2) cot(t/2)`, truncated from below.
fn half_cotangent(t: f64) -> f64 {
    if t < 1e-4 {
        1.0 - t * t / 12.0
    } else {
        (0.5 * t / (0.5 * t).tan()).max(LOWEST)
    }
}
