//! Truncated Taylor series of one variable, and the arithmetic that numbers and series share.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The numbers on which the terms of a Hamiltonian are evaluated: floating-point numbers or series.
///
/// # Examples
/// ```
/// use stiefel_rs::chart::series::{SeriesScalar, Series};
/// fn cube<T: SeriesScalar>(x: T) -> T {
///     x * x * x
/// }
/// assert_eq!(cube(2.0), 8.0);
/// // (2 + t)^3, by the binomial theorem.
/// assert_eq!(cube(Series::new([2.0, 1.0, 0.0, 0.0])).coefficients(), &[8.0, 12.0, 6.0, 1.0]);
/// ```
pub trait SeriesScalar:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

impl SeriesScalar for f64 {}

/// `c_0 + c_1 t + ... + c_{N-1} t^{N-1}`; operations only use the first `active` coefficients.
///
/// # Examples
/// ```
/// use stiefel_rs::chart::series::Series;
/// let t = Series::<8>::new([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let (sin, cos) = t.sin_cos();
/// assert_eq!(sin.coefficients()[3], -1.0 / 6.0);
/// // cos^2 + sin^2 = 1 holds coefficient by coefficient.
/// let one = sin * sin + cos * cos - Series::from(1.0);
/// assert!(one.coefficients().iter().all(|c| c.abs() < 1e-14));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series<const N: usize> {
    coefficients: [f64; N],
    active: usize,
}

impl<const N: usize> Series<N> {
    /// The series with the given coefficients.
    pub fn new(coefficients: [f64; N]) -> Self {
        Series {
            coefficients,
            active: N,
        }
    }

    /// All coefficients.
    pub fn coefficients(&self) -> &[f64; N] {
        &self.coefficients
    }

    /// Limits operations to the first `active` coefficients.
    pub fn set_active(&mut self, active: usize) {
        self.active = active.min(N);
    }

    /// Sets the `j`-th coefficient.
    pub fn set(&mut self, j: usize, value: f64) {
        self.coefficients[j] = value;
    }

    /// The value at `t`, by Horner's rule.
    pub fn value(&self, t: f64) -> f64 {
        self.coefficients
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * t + c)
    }

    /// Sine and cosine, from `s' = c x'` and `c' = -s x'`.
    pub fn sin_cos(&self) -> (Self, Self) {
        let (mut s, mut c) = (Self::from(0.0), Self::from(0.0));
        (s.active, c.active) = (self.active, self.active);
        (s.coefficients[0], c.coefficients[0]) = self.coefficients[0].sin_cos();
        for j in 1..self.active {
            let (mut ds, mut dc) = (0.0, 0.0);
            for i in 1..=j {
                let dx = i as f64 * self.coefficients[i];
                ds += dx * c.coefficients[j - i];
                dc -= dx * s.coefficients[j - i];
            }
            s.coefficients[j] = ds / j as f64;
            c.coefficients[j] = dc / j as f64;
        }
        (s, c)
    }

    fn combine(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        out.active = self.active.min(other.active);
        for j in 0..out.active {
            out.coefficients[j] = f(self.coefficients[j], other.coefficients[j]);
        }
        out
    }
}

impl<const N: usize> SeriesScalar for Series<N> {}

impl<const N: usize> From<f64> for Series<N> {
    fn from(value: f64) -> Self {
        let mut coefficients = [0.0; N];
        coefficients[0] = value;
        Series {
            coefficients,
            active: N,
        }
    }
}

impl<const N: usize> Add for Series<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.combine(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Series<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.combine(other, |a, b| a - b)
    }
}

impl<const N: usize> Neg for Series<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self.combine(self, |a, _| -a)
    }
}

impl<const N: usize> Mul for Series<N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut out = Self::from(0.0);
        out.active = self.active.min(other.active);
        for i in 0..out.active {
            for j in 0..out.active - i {
                out.coefficients[i + j] += self.coefficients[i] * other.coefficients[j];
            }
        }
        out
    }
}

impl<const N: usize> Div for Series<N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let mut out = Self::from(0.0);
        out.active = self.active.min(other.active);
        for j in 0..out.active {
            let known: f64 = (0..j)
                .map(|i| out.coefficients[i] * other.coefficients[j - i])
                .sum();
            out.coefficients[j] = (self.coefficients[j] - known) / other.coefficients[0];
        }
        out
    }
}
