//! The action `e^L v` of the exponential of a skew operator that is given only by its products with vectors.
//!
//! # Source
//! Tal-Ezer, Kosloff (1984), "An accurate and efficient scheme for propagating the time dependent Schroedinger equation",
//! J. Chem. Phys. 81, 3967 (the expansion); Gautschi (1967), SIAM Review 9, 24-82 (Bessel functions by backward recurrence).

use std::mem::swap;

use faer::Mat;

use super::product::axpy;
use crate::error::{Error, Result};

/// Beyond this radius the phases of the exponential have lost five digits, and the work grows with the radius.
pub const MAX_RADIUS: f64 = 1e5;

/// A smaller radius would introduce terms divided by nearly zero without saving work.
const MIN_RADIUS: f64 = 0.25;

/// Terms below this, a tenth of the unit round-off, are dropped.
const NEGLIGIBLE: f64 = 1e-17;

/// `e^L v` for an operator `L` that is skew in some inner product, by Chebyshev polynomials.
///
/// ```math
/// e^{L} v = J_0(\rho) v + 2 \sum_{j \ge 1} J_j(\rho) \varphi_j,\qquad
/// \varphi_0 = v,\quad \varphi_1 = \tfrac1\rho L v,\quad \varphi_{j+1} = \tfrac2\rho L \varphi_j + \varphi_{j-1}
/// ```
///
/// # Arguments
/// * `apply(out, x)` - sets `out = L x`; both of the shape of `v`
/// * `radius` - `rho`, a bound on the spectral norm of `L`; the number of products is about `rho + 15`
/// # Accuracy
/// `1e-14 (1 + rho / 10)` relative to `|v|`, asserted in `tests/exponential_action.rs`.
/// # Errors
/// `InvalidArgument` if the radius is NaN or above [`MAX_RADIUS`].
pub fn skew_exponential_action(
    v: Mat<f64>,
    radius: f64,
    mut apply: impl FnMut(&mut Mat<f64>, &Mat<f64>),
) -> Result<Mat<f64>> {
    // Not `radius > MAX_RADIUS`, which NaN would pass.
    if !(0.0..=MAX_RADIUS).contains(&radius) {
        return Err(Error::InvalidArgument {
            name: "norm of the generator",
            requirement: "at most 1e5",
            found: radius,
        });
    }
    if radius == 0.0 {
        return Ok(v);
    }
    let radius = radius.max(MIN_RADIUS);
    let bessel = bessel_functions(radius);
    let shape = v.shape();
    let mut sum = &v * faer::Scale(bessel[0]);
    let (mut previous, mut product) = (v, Mat::zeros(shape.0, shape.1));
    apply(&mut product, &previous);
    let mut current = &product * faer::Scale(1.0 / radius);
    axpy(&mut sum, 2.0 * bessel[1], &current);
    for weight in &bessel[2..] {
        apply(&mut product, &current);
        axpy(&mut previous, 2.0 / radius, &product);
        swap(&mut previous, &mut current);
        axpy(&mut sum, 2.0 * weight, &current);
    }
    Ok(sum)
}

/// `J_0(x), J_1(x), ...` for `x > 0`: all that are not negligible, at least two.
///
/// Backward recurrence `J_{j-1} = (2 j / x) J_j - J_{j+1}` from an index where they are negligible, scaled by `J_0 + 2
/// (J_2 + J_4 + ...) = 1`.
fn bessel_functions(x: f64) -> Vec<f64> {
    // Beyond x the functions decay like Airy functions, on the scale x^(1/3): to 1e-30 at the start index.
    let start = (x + 18.0 * x.cbrt() + 40.0) as usize;
    let mut values = vec![0.0; start + 1];
    let (mut above, mut here) = (0.0_f64, 1e-300_f64);
    let mut sum = 0.0;
    for j in (0..=start).rev() {
        values[j] = here;
        if j % 2 == 0 {
            sum += if j == 0 { here } else { 2.0 * here };
        }
        let below = 2.0 * j as f64 / x * here - above;
        (above, here) = (here, below);
        if here.abs() > 1e200 {
            // The earlier values are below 1e-200 of the following ones, and underflow.
            for value in &mut values[j..] {
                *value *= 1e-300;
            }
            (above, here, sum) = (above * 1e-300, here * 1e-300, sum * 1e-300);
        }
    }
    for value in &mut values {
        *value /= sum;
    }
    let used = values.iter().rposition(|v| v.abs() > NEGLIGIBLE);
    values.truncate(used.map_or(2, |last| (last + 1).max(2)));
    values
}
