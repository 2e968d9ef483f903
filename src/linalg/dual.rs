//! Numbers with derivatives in a few directions: `x + dx_1 e_1 + ... + dx_N e_N` with `e_i e_j = 0`.
//!
//! A kernel that only adds and multiplies computes exact directional derivatives when called with these numbers.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use faer::Mat;

use super::lanes::Lanes;

/// The numbers of a polynomial kernel.
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
    + SubAssign
    + 'static
{
    const ZERO: Self;

    /// Number of entries per vector instruction: columns of blocks are padded to a multiple of it.
    const WIDTH: usize;

    /// Number of sums that fit into registers together with the factors.
    const REGISTERS: usize;

    /// [`tiles`], with a tile size chosen to fit into registers.
    fn accumulate<'a, const TRANSPOSED: bool>(
        out: &mut [Self],
        pairs: impl Iterator<Item = (&'a [Self], &'a [Self])> + Clone,
        shape: [usize; 3],
    );

    /// A constant.
    fn constant(x: f64) -> Self;

    /// The number without its derivatives, or a number of the same magnitude.
    fn value(self) -> f64;
}

impl Number for f64 {
    const ZERO: f64 = 0.0;
    const WIDTH: usize = 4;
    const REGISTERS: usize = 16;

    #[inline(always)]
    fn accumulate<'a, const TRANSPOSED: bool>(
        out: &mut [Self],
        pairs: impl Iterator<Item = (&'a [Self], &'a [Self])> + Clone,
        shape: [usize; 3],
    ) {
        tiles::<Self, TRANSPOSED, 4, 4>(out, pairs, shape);
    }

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
    const WIDTH: usize = 1;
    const REGISTERS: usize = 3;

    #[inline(always)]
    fn accumulate<'a, const TRANSPOSED: bool>(
        out: &mut [Self],
        pairs: impl Iterator<Item = (&'a [Self], &'a [Self])> + Clone,
        shape: [usize; 3],
    ) {
        tiles::<Self, TRANSPOSED, 1, 2>(out, pairs, shape);
    }

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

/// Eight independent numbers, which all use the shortest step.
impl Number for Lanes {
    const ZERO: Self = Lanes::ZERO;
    const WIDTH: usize = 1;
    const REGISTERS: usize = 4;

    #[inline(always)]
    fn accumulate<'a, const TRANSPOSED: bool>(
        out: &mut [Self],
        pairs: impl Iterator<Item = (&'a [Self], &'a [Self])> + Clone,
        shape: [usize; 3],
    ) {
        tiles::<Self, TRANSPOSED, 1, 2>(out, pairs, shape);
    }

    #[inline(always)]
    fn constant(x: f64) -> Self {
        Lanes::splat(x)
    }

    /// The largest absolute value; NaN if one of them is NaN.
    #[inline(always)]
    fn value(self) -> f64 {
        self.0.iter().fold(0.0, |largest, x| {
            let x = x.abs();
            if x <= largest { largest } else { x }
        })
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

impl<const N: usize> SubAssign for Dual<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
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

/// `out += a b` for all pairs of factors of shapes `(rows, inner)` and `(inner, cols)`, or `out += a b^T` with `b` of
/// shape `(cols, inner)`, in column-major order.
///
/// Sums of `W` rows and `C` columns stay in registers for all pairs; `rows` is a multiple of `W`. As many leading
/// columns are computed as `out` has.
#[inline(always)]
fn tiles<'a, T: Number, const TRANSPOSED: bool, const W: usize, const C: usize>(
    out: &mut [T],
    pairs: impl Iterator<Item = (&'a [T], &'a [T])> + Clone,
    shape: [usize; 3],
) {
    let cols = out.len() / shape[0];
    let whole = cols - cols % C;
    for col in (0..whole).step_by(C) {
        columns::<T, TRANSPOSED, W, C>(out, pairs.clone(), shape, col);
    }
    match cols - whole {
        3 => columns::<T, TRANSPOSED, W, 3>(out, pairs, shape, whole),
        2 => columns::<T, TRANSPOSED, W, 2>(out, pairs, shape, whole),
        1 => columns::<T, TRANSPOSED, W, 1>(out, pairs, shape, whole),
        _ => {}
    }
}

/// Columns `col..col + C` of [`tiles`].
#[inline(always)]
fn columns<'a, T: Number, const TRANSPOSED: bool, const W: usize, const C: usize>(
    out: &mut [T],
    pairs: impl Iterator<Item = (&'a [T], &'a [T])> + Clone,
    [rows, inner, cols]: [usize; 3],
    col: usize,
) {
    for row in (0..rows).step_by(W) {
        let mut sums = [[T::ZERO; W]; C];
        for (a, b) in pairs.clone() {
            if TRANSPOSED {
                for (a, b) in a.chunks_exact(rows).zip(b.chunks_exact(cols)) {
                    add_outer(&mut sums, entries(a, row), entries(b, col));
                }
            } else {
                let b: [&[T]; C] = std::array::from_fn(|c| &b[inner * (col + c)..][..inner]);
                for (l, a) in a.chunks_exact(rows).enumerate().take(inner) {
                    add_outer(&mut sums, entries(a, row), b.map(|b| b[l]));
                }
            }
        }
        for (c, sums) in sums.iter().enumerate() {
            let target = &mut out[rows * (col + c) + row..][..W];
            for (target, sum) in target.iter_mut().zip(sums) {
                *target += *sum;
            }
        }
    }
}

#[inline(always)]
fn entries<T: Copy, const N: usize>(a: &[T], first: usize) -> [T; N] {
    a[first..][..N].try_into().expect("N entries")
}

#[inline(always)]
fn add_outer<T: Number, const W: usize, const C: usize>(
    sums: &mut [[T; W]; C],
    a: [T; W],
    b: [T; C],
) {
    for c in 0..C {
        for w in 0..W {
            sums[c][w] += a[w] * b[c];
        }
    }
}

/// The derivative of a map from `R^n` to itself, shape `(n, n)`, and its value; each pass handles `N` variables.
///
/// # Errors
/// The errors of the map.
pub(crate) fn jacobian<const N: usize, E>(
    x: &[f64],
    mut map: impl FnMut(&[Dual<N>]) -> Result<Vec<Dual<N>>, E>,
) -> Result<(Mat<f64>, Vec<f64>), E> {
    let mut jacobian = Mat::zeros(x.len(), x.len());
    let mut value = Vec::new();
    for first in (0..x.len()).step_by(N) {
        let last = (first + N).min(x.len());
        let mut varied: Vec<Dual<N>> = x.iter().map(|x| Dual::constant(*x)).collect();
        for column in first..last {
            varied[column].slope[column - first] = 1.0;
        }
        let found = map(&varied)?;
        for (row, found) in found.iter().enumerate() {
            for column in first..last {
                jacobian[(row, column)] = found.slope[column - first];
            }
        }
        value = found.iter().map(|found| found.value).collect();
    }
    Ok((jacobian, value))
}
