//! Taylor polynomials of degree three in several variables, for exact derivatives of maps between charts.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::series::{Series, SeriesScalar};

/// A function of `N` variables at a point: value, gradient, Hessian and third derivatives.
///
/// Third derivatives are stored for indices in increasing order; read them with [`Jet::third`].
///
/// # Examples
/// ```
/// use stiefel_rs::chart::jet::Jet;
/// // x y^2 at (3, 5).
/// let (x, y) = (Jet::<2>::variable(3.0, 0, 1.0), Jet::variable(5.0, 1, 1.0));
/// let f = x * y * y;
/// assert_eq!((f.value(), f.first(0), f.first(1)), (75.0, 25.0, 30.0));
/// assert_eq!((f.second(0, 1), f.second(1, 1)), (10.0, 6.0));
/// assert_eq!((f.third(0, 1, 1), f.third(1, 1, 1)), (2.0, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const N: usize> {
    value: f64,
    gradient: [f64; N],
    hessian: [[f64; N]; N],
    third: [[[f64; N]; N]; N],
}

impl<const N: usize> Jet<N> {
    /// The function `value + slope * x`, where `x` is the variable with the given index, at 0.
    pub fn variable(value: f64, index: usize, slope: f64) -> Self {
        let mut out = Jet::from(value);
        out.gradient[index] = slope;
        out
    }

    /// The value.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// A first derivative.
    pub fn first(&self, a: usize) -> f64 {
        self.gradient[a]
    }

    /// A second derivative.
    pub fn second(&self, a: usize, b: usize) -> f64 {
        self.hessian[a][b]
    }

    /// A third derivative.
    pub fn third(&self, a: usize, b: usize, c: usize) -> f64 {
        let mut index = [a, b, c];
        index.sort_unstable();
        self.third[index[0]][index[1]][index[2]]
    }

    fn linear(self, other: Self, sign: f64) -> Self {
        let mut out = self;
        out.value += sign * other.value;
        for a in 0..N {
            out.gradient[a] += sign * other.gradient[a];
            for b in 0..N {
                out.hessian[a][b] += sign * other.hessian[a][b];
            }
            for b in a..N {
                for c in b..N {
                    out.third[a][b][c] += sign * other.third[a][b][c];
                }
            }
        }
        out
    }
}

/// Scalars to which a function of one variable can be applied, given its derivatives.
///
/// # Examples
/// ```
/// use stiefel_rs::chart::jet::{Analytic, Jet};
/// fn exp<T: Analytic>(x: T) -> T {
///     x.compose([x.number().exp(); 4])
/// }
/// assert_eq!(exp(0.0), 1.0);
/// // All derivatives of e^{2x} at 0.
/// let f = exp(Jet::<1>::variable(0.0, 0, 2.0));
/// assert_eq!([f.value(), f.first(0), f.second(0, 0), f.third(0, 0, 0)], [1.0, 2.0, 4.0, 8.0]);
/// ```
pub trait Analytic: SeriesScalar {
    /// The number without its derivatives.
    fn number(&self) -> f64;

    /// `f` applied to this scalar, from `f` and its first three derivatives at [`Analytic::number`].
    fn compose(self, f: [f64; 4]) -> Self;
}

impl Analytic for f64 {
    fn number(&self) -> f64 {
        *self
    }

    fn compose(self, f: [f64; 4]) -> Self {
        f[0]
    }
}

impl Analytic for Series<2> {
    fn number(&self) -> f64 {
        self.coefficients()[0]
    }

    fn compose(self, f: [f64; 4]) -> Self {
        Series::new([f[0], f[1] * self.coefficients()[1]])
    }
}

impl<const N: usize> Analytic for Jet<N> {
    fn number(&self) -> f64 {
        self.value
    }

    fn compose(self, f: [f64; 4]) -> Self {
        let (g, h) = (&self.gradient, &self.hessian);
        let mut out = Jet::from(f[0]);
        for a in 0..N {
            out.gradient[a] = f[1] * g[a];
            for b in 0..N {
                out.hessian[a][b] = f[1] * h[a][b] + f[2] * g[a] * g[b];
            }
            for b in a..N {
                for c in b..N {
                    let mixed = g[a] * h[b][c] + g[b] * h[a][c] + g[c] * h[a][b];
                    out.third[a][b][c] =
                        f[1] * self.third[a][b][c] + f[2] * mixed + f[3] * g[a] * g[b] * g[c];
                }
            }
        }
        out
    }
}

impl<const N: usize> SeriesScalar for Jet<N> {}

impl<const N: usize> From<f64> for Jet<N> {
    fn from(value: f64) -> Self {
        Jet {
            value,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
            third: [[[0.0; N]; N]; N],
        }
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.linear(other, 1.0)
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.linear(other, -1.0)
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self.compose([-self.value, -1.0, 0.0, 0.0])
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (f, g) = (&self, &other);
        let mut out = Jet::from(f.value * g.value);
        for a in 0..N {
            out.gradient[a] = f.value * g.gradient[a] + f.gradient[a] * g.value;
            for b in 0..N {
                out.hessian[a][b] = f.value * g.hessian[a][b]
                    + f.gradient[a] * g.gradient[b]
                    + f.gradient[b] * g.gradient[a]
                    + f.hessian[a][b] * g.value;
            }
            for b in a..N {
                for c in b..N {
                    out.third[a][b][c] = f.value * g.third[a][b][c]
                        + f.gradient[a] * g.hessian[b][c]
                        + f.gradient[b] * g.hessian[a][c]
                        + f.gradient[c] * g.hessian[a][b]
                        + f.hessian[a][b] * g.gradient[c]
                        + f.hessian[a][c] * g.gradient[b]
                        + f.hessian[b][c] * g.gradient[a]
                        + f.third[a][b][c] * g.value;
                }
            }
        }
        out
    }
}

impl<const N: usize> Div for Jet<N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let r = 1.0 / other.value;
        self * other.compose([r, -r * r, 2.0 * r * r * r, -6.0 * r * r * r * r])
    }
}

/// `sin(x)` and `cos(x)`.
pub fn sin_cos<T: Analytic>(x: T) -> (T, T) {
    let (s, c) = x.number().sin_cos();
    (x.compose([s, c, -s, -c]), x.compose([c, -s, -c, s]))
}

/// The square root of a positive number.
pub fn sqrt<T: Analytic>(x: T) -> T {
    let root = x.number().sqrt();
    let (r, r2) = (1.0 / root, 1.0 / x.number());
    x.compose([root, 0.5 * r, -0.25 * r * r2, 0.375 * r * r2 * r2])
}

/// The angle of the point `(x, y)` of the plane, in `[-pi, pi]`.
pub fn atan2<T: Analytic>(y: T, x: T) -> T {
    let (y0, x0) = (y.number(), x.number());
    // The tangent of the angle between (x, y) and (x0, y0) is 0 here, so only the derivatives of the arc tangent at 0
    // are needed.
    let (y0_t, x0_t) = (T::from(y0), T::from(x0));
    let tangent = (y * x0_t - x * y0_t) / (x * x0_t + y * y0_t);
    tangent.compose([y0.atan2(x0), 1.0, 0.0, -2.0])
}

/// `cos(sqrt(s))` and `sin(sqrt(s)) / sqrt(s)` for `s >= 0`, smooth at 0.
pub fn cos_sinc<T: Analytic>(s: T) -> (T, T) {
    let x = s.number();
    // d/ds cos(sqrt s) = -sinc / 2 everywhere.
    let sinc = if x < SERIES_BOUND {
        sinc_by_series(x)
    } else {
        sinc_by_recursion(x)
    };
    let cos = [
        x.sqrt().cos(),
        -0.5 * sinc[0],
        -0.5 * sinc[1],
        -0.5 * sinc[2],
    ];
    (s.compose(cos), s.compose(sinc))
}

/// Below this the recursion loses digits, and the series with [`SERIES_TERMS`] terms is used.
const SERIES_BOUND: f64 = 2.0;

/// The first omitted term of the third derivative is `2^12 12! / (9! 25!) < 1e-18` of the sum.
const SERIES_TERMS: i32 = 12;

/// `sum_j (-s)^j / (2j + 1)!` and three derivatives.
fn sinc_by_series(s: f64) -> [f64; 4] {
    let mut out = [0.0; 4];
    let mut inverse_factorial = 1.0;
    for j in 0..SERIES_TERMS + 3 {
        if j > 0 {
            inverse_factorial /= -f64::from(2 * j * (2 * j + 1));
        }
        let mut falling = 1.0;
        for (derivative, sum) in (0..).zip(&mut out) {
            if derivative <= j {
                *sum += falling * inverse_factorial * s.powi(j - derivative);
                falling *= f64::from(j - derivative);
            }
        }
    }
    out
}

/// Computed from `2 s f' = cos - f` and its derivatives.
fn sinc_by_recursion(s: f64) -> [f64; 4] {
    let root = s.sqrt();
    let f = root.sin() / root;
    let f1 = (root.cos() - f) / (2.0 * s);
    let f2 = (-0.5 * f - 3.0 * f1) / (2.0 * s);
    let f3 = (-0.5 * f1 - 5.0 * f2) / (2.0 * s);
    [f, f1, f2, f3]
}
