//! Numbers with derivatives in a few directions: `x + dx_1 e_1 + ... + dx_N e_N` with `e_i e_j = 0`.
//!
//! A kernel that only adds and multiplies computes exact directional derivatives when it runs on these.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// What a polynomial kernel computes with.
pub(crate) trait Number:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + 'static
{
    const ZERO: Self;

    /// A constant.
    fn constant(x: f64) -> Self;

    /// The number without its derivatives.
    fn value(self) -> f64;
}

impl Number for f64 {
    const ZERO: f64 = 0.0;

    #[inline(always)]
    fn constant(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
}

/// A number and its derivatives in `N` directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual<const N: usize> {
    pub(crate) value: f64,
    pub(crate) slope: [f64; N],
}

impl<const N: usize> Dual<N> {
    #[inline(always)]
    fn combine(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        out.value = f(self.value, other.value);
        for i in 0..N {
            out.slope[i] = f(self.slope[i], other.slope[i]);
        }
        out
    }
}

impl<const N: usize> Number for Dual<N> {
    const ZERO: Self = Dual {
        value: 0.0,
        slope: [0.0; N],
    };

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Dual {
            value,
            slope: [0.0; N],
        }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.combine(other, |a, b| a + b)
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.combine(other, |a, b| a - b)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.combine(self, |a, _| a * factor)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut out = self;
        out.value = self.value * other.value;
        for i in 0..N {
            out.slope[i] = self.slope[i] * other.value + self.value * other.slope[i];
        }
        out
    }
}
