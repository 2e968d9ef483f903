//! Cubics in tension: limits of the parameter, and the curve of flat space.

use crate::error::{Error, Result};

/// Return an error unless a tension is finite and not negative.
pub(crate) fn check_tension(tension: f64) -> Result<()> {
    if tension.is_finite() && tension >= 0.0 {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "tension",
        requirement: "finite and not negative",
        found: tension,
    })
}

/// Largest tension of a leg, in its own time: errors at its start grow along it as `e^sqrt(tau)`, here by a factor
/// of 3000.
const LARGEST: f64 = 64.0;

/// Largest tension if points have so many rows that splines are solved by steps of flat space without tension: with 40,
/// 7 knots on St(40,2) are not solved.
const LARGEST_WITHOUT_FRAMES: f64 = 6.25;

/// Return an error if the tension of a leg, in the time in which the leg takes one unit, is too large for its start to
/// determine the leg, or for the solver that works without frames at the knots.
pub(crate) fn check_leg_tension(tension: f64, has_frames: bool) -> Result<()> {
    let (largest, requirement) = match has_frames {
        true => (
            LARGEST,
            "at most 64 when multiplied by the square of the longest interval between knots (add knots for more)",
        ),
        false => (
            LARGEST_WITHOUT_FRAMES,
            "at most 6.25 when multiplied by the square of the longest interval between knots, for so many rows (add knots for more)",
        ),
    };
    if tension <= largest {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "tension",
        requirement,
        found: tension,
    })
}

/// The curve of flat space between given points and velocities on `[0, 1]`, `c'''' = tau c''`: `c''` and `c'''` at the
/// start in terms of the ends.
///
/// With `theta^2 = tau` and the functions `S_1 = sinh(theta) / theta`, `C_2 = (cosh(theta) - 1) / theta^2`,
/// `S_3 = (sinh(theta) - theta) / theta^3`
///
/// ```math
/// c(1) - c(0) - c'(0) = C_2\,c''(0) + S_3\,c'''(0),\qquad c'(1) - c'(0) = S_1\,c''(0) + C_2\,c'''(0)
/// ```
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlatCoefficients {
    /// Coefficients of `c(1) - c(0) - c'(0)` and of `c'(1) - c'(0)` in `c''(0)` and `c'''(0)`.
    pub(crate) second: [f64; 2],
    pub(crate) third: [f64; 2],
}

/// Tension up to which the functions are Taylor polynomials: above it, cancellation costs at most one digit.
const SERIES: f64 = 4.0;

/// Number of terms: the first omitted one is below 1e-18.
const TERMS: usize = 14;

impl FlatCoefficients {
    pub(crate) fn new(tension: f64) -> Self {
        let (s1, c2, s3, determinant);
        if tension <= SERIES {
            [s1, c2, s3] = [1, 2, 3].map(|first| series(tension, first));
            determinant = c2 * c2 - s1 * s3;
        } else {
            let theta = tension.sqrt();
            let (sinh, cosh) = (theta.sinh(), theta.cosh());
            s1 = sinh / theta;
            c2 = (cosh - 1.0) / tension;
            s3 = (sinh - theta) / (tension * theta);
            determinant = (2.0 - 2.0 * cosh + theta * sinh) / (tension * tension);
        }
        FlatCoefficients {
            second: [c2 / determinant, -s3 / determinant],
            third: [-s1 / determinant, c2 / determinant],
        }
    }
}

/// `sum_j tau^j / (2 j + first)!`.
fn series(tension: f64, first: usize) -> f64 {
    let mut term = (1..=first).map(|i| 1.0 / i as f64).product::<f64>();
    let mut sum = 0.0;
    for j in 0..TERMS {
        sum += term;
        term *= tension / ((2 * j + first + 1) * (2 * j + first + 2)) as f64;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_tension_they_are_those_of_a_cubic() {
        let flat = FlatCoefficients::new(0.0);
        for (found, wanted) in [(flat.second, [6.0, -2.0]), (flat.third, [-12.0, 6.0])] {
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-13, "{found} {wanted}");
            }
        }
    }

    /// Checked on both sides of the limit of the series: `c'' = a cosh + b sinh / theta`, integrated by Simpson's rule.
    #[test]
    fn ends_are_met() {
        for tension in [0.1, 3.999, 4.001, 30.0] {
            let flat = FlatCoefficients::new(tension);
            let theta = f64::sqrt(tension);
            for ends in [[1.0, 0.0], [0.0, 1.0]] {
                let by = |row: [f64; 2]| row[0] * ends[0] + row[1] * ends[1];
                let (a, b) = (by(flat.second), by(flat.third));
                let second = |t: f64| a * (theta * t).cosh() + b / theta * (theta * t).sinh();
                let count = 2000;
                let mut found = [0.0; 2];
                for i in 0..=count {
                    let t = i as f64 / count as f64;
                    let weight = match i {
                        0 => 1.0,
                        i if i == count => 1.0,
                        i if i % 2 == 1 => 4.0,
                        _ => 2.0,
                    };
                    let weight = weight / (3.0 * count as f64);
                    found[0] += weight * (1.0 - t) * second(t);
                    found[1] += weight * second(t);
                }
                // Error of Simpson's rule with steps of 1/2000, and round-off of its terms.
                for (found, wanted) in found.into_iter().zip(ends) {
                    assert!(
                        (found - wanted).abs() < 1e-10,
                        "{tension}: {found} {wanted}"
                    );
                }
            }
        }
    }
}
