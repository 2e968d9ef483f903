//! Newton steps without derivatives: GMRES with difference quotients.
//!
//! # Source
//! Knoll, Keyes (2004), "Jacobian-free Newton-Krylov methods", J. Comput. Phys. 193, 357-397, sec. 2 and 3.

use super::gmres::Gmres;
use crate::error::{Result, unless_interrupted};

/// Step of difference quotients, relative to the unknowns.
const DIFFERENCE: f64 = 1e-7;

/// The Newton step for `f = 0`, where `f` is the step of a fixed-point iteration, so that its derivative is near minus
/// the identity.
///
/// `size` is the norm of the unknowns, `tolerance` the relative residual to which the linear equations are solved, and
/// `beside` returns `f` at a multiple of a unit vector from the unknowns, or `None` to stop: then the derivative counts as
/// minus the identity. No step if `beside` fails.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn newton_step(
    f: &[f64],
    size: f64,
    tolerance: f64,
    mut beside: impl FnMut(f64, &[f64]) -> Result<Option<Vec<f64>>>,
) -> Result<Option<Vec<f64>>> {
    let width = DIFFERENCE * size.max(1.0);
    let mut step = f.to_vec();
    let solved = Gmres::new(f.len()).try_solve(&mut step, tolerance, |direction, image| {
        match beside(width, direction)? {
            Some(there) => {
                for ((image, here), there) in image.iter_mut().zip(f).zip(there) {
                    *image = (here - there) / width;
                }
            }
            None => image.copy_from_slice(direction),
        }
        Result::Ok(())
    });
    Ok(unless_interrupted(solved)?.map(|()| step))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::solve::gmres::norm;

    /// `f(x) = b - x - 0.3 (x_1 x_2, x_2 x_3, x_3 x_1)`.
    fn f(x: &[f64]) -> Vec<f64> {
        let b = [0.9, -0.7, 0.5];
        (0..3)
            .map(|i| b[i] - x[i] - 0.3 * x[i] * x[(i + 1) % 3])
            .collect()
    }

    fn plus(x: &[f64], share: f64, direction: &[f64]) -> Vec<f64> {
        x.iter()
            .zip(direction)
            .map(|(x, d)| x + share * d)
            .collect()
    }

    #[test]
    fn steps_converge_quadratically() {
        let mut x = vec![0.0; 3];
        let mut sizes = Vec::new();
        for _ in 0..5 {
            let here = f(&x);
            sizes.push(norm(&here));
            let step = newton_step(&here, norm(&x), 1e-10, |share, direction| {
                Ok(Some(f(&plus(&x, share, direction))))
            });
            x = plus(&x, 1.0, &step.unwrap().unwrap());
        }
        for pair in sizes.windows(2) {
            assert!(pair[1] < 0.5 * pair[0] * pair[0], "{sizes:?}");
        }
        assert!(norm(&f(&x)) < 1e-12, "{sizes:?}");
    }

    #[test]
    fn a_failure_is_no_step() {
        let here = f(&[0.0; 3]);
        let failure = || Error::Overflow { quantity: "test" };
        let step = newton_step(&here, 0.0, 1e-10, |_, _| Err(failure()));
        assert!(step.unwrap().is_none());
        let interrupted = || Error::Interrupted { solver: "test" };
        let step = newton_step(&here, 0.0, 1e-10, |_, _| Err(interrupted()));
        assert!(matches!(step, Err(Error::Interrupted { .. })));
        // Whoever stops takes the step of the fixed-point iteration.
        let step = newton_step(&here, 0.0, 1e-10, |_, _| Ok(None));
        let gap = norm(&plus(&step.unwrap().unwrap(), -1.0, &here));
        assert!(gap < 1e-15, "{gap:e}");
    }
}
