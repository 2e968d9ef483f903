//! Terms of a Hamiltonian: monomials in the state with coefficients that depend on the polar angle.

use super::series::SeriesScalar;

/// One term `f(theta) * product of state components` of a Hamiltonian.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::chart::{Chart, Sphere, Term};
/// let z = SVector::<f64, 8>::from([1.2, 0.0, 0.5, 1.0, 0.3, -0.2, 0.4, 0.6]);
/// let (sin, cos) = z[0].sin_cos();
/// let value = |term: Term<f64>| term.factors.iter().map(|&i| z[i]).product::<f64>() * term.coefficient[0];
/// let sum: f64 = Sphere.terms(sin, cos).into_iter().map(value).sum();
/// assert!((sum - Sphere.hamiltonian(&z)).abs() < 1e-14);
/// ```
pub struct Term<T> {
    /// `f(theta)`, `f'(theta)`, `f''(theta)`.
    pub coefficient: [T; 3],
    /// Indices of the factors in the state, with repetition; none of them is `theta` (index 0).
    pub factors: &'static [usize],
}

impl<T: SeriesScalar> Term<T> {
    /// A term whose coefficient does not depend on `theta`.
    pub fn constant(value: f64, factors: &'static [usize]) -> Self {
        Term {
            coefficient: [T::from(value), T::from(0.0), T::from(0.0)],
            factors,
        }
    }

    /// A term from its coefficient and the coefficient's first two derivatives.
    pub fn new(coefficient: [T; 3], factors: &'static [usize]) -> Self {
        Term {
            coefficient,
            factors,
        }
    }
}

/// Product of the factors, except for those at the skipped positions.
pub(super) fn product<T: SeriesScalar>(z: &[T], factors: &[usize], skipped: &[usize]) -> T {
    let mut out = T::from(1.0);
    for (position, &factor) in factors.iter().enumerate() {
        if !skipped.contains(&position) {
            out = out * z[factor];
        }
    }
    out
}

/// `out += grad H`, on numbers or on series.
pub(super) fn accumulate_gradient<T: SeriesScalar>(
    terms: impl IntoIterator<Item = Term<T>>,
    z: &[T],
    out: &mut [T],
) {
    for term in terms {
        let [f, df, _] = term.coefficient;
        out[0] = out[0] + df * product(z, term.factors, &[]);
        for i in 0..term.factors.len() {
            let factor = term.factors[i];
            out[factor] = out[factor] + f * product(z, term.factors, &[i]);
        }
    }
}
