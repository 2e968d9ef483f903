//! The sphere `St(3,1)` in spherical coordinates `(theta, phi)`.

use super::chart::Chart;
use super::series::SeriesScalar;
use super::term::Term;

/// The paper's chart of `St(3,1)`: `q = (theta, phi)`, metric `diag(1, sin^2 theta)`.
///
/// ```math
/// x = (\sin\theta\cos\phi,\ \sin\theta\sin\phi,\ \cos\theta)
/// ```
/// ```math
/// H = p_\theta\dot\theta + p_\phi\dot\phi + \tfrac12 p_{\dot\theta}^2 + \frac{p_{\dot\phi}^2}{2\sin^2\theta}
///   + \sin\theta\cos\theta\,\dot\phi^2 p_{\dot\theta} - 2\cot\theta\,\dot\theta\dot\phi\,p_{\dot\phi}
/// ```
///
/// # Examples
/// ```
/// use faer::mat;
/// use nalgebra::SVector;
/// use stiefel_rs::chart::{Chart, Sphere};
/// let point = Sphere.embed(&[std::f64::consts::FRAC_PI_2, 0.0])?;
/// assert!((point - mat![[1.0], [0.0], [0.0]]).norm_l2() < 1e-14);
/// // With zero momenta the state moves along a great circle: theta'' = sin(theta) cos(theta) phi'^2.
/// let z = SVector::<f64, 8>::from([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
/// let free = Sphere.derivatives(&z);
/// assert!((free[4] - 1.0_f64.sin() * 1.0_f64.cos()).abs() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sphere;

impl Chart<4, 8> for Sphere {
    const K: usize = 1;

    fn terms<T: SeriesScalar>(&self, s: T, c: T) -> impl IntoIterator<Item = Term<T>> {
        let half_inverse_square = T::from(0.5) / (s * s);
        let cube = s * s * s;
        let two = T::from(2.0);
        [
            Term::constant(1.0, &[4, 2]),
            Term::constant(1.0, &[5, 3]),
            Term::constant(0.5, &[6, 6]),
            Term::new(
                [
                    half_inverse_square,
                    -c / cube,
                    (T::from(1.0) + two * c * c) / (cube * s),
                ],
                &[7, 7],
            ),
            Term::new([s * c, c * c - s * s, T::from(-4.0) * s * c], &[3, 3, 6]),
            Term::new(
                [-two * c / s, two / (s * s), T::from(-4.0) * c / cube],
                &[2, 3, 7],
            ),
        ]
    }

    fn columns<T: SeriesScalar>(&self, sin_cos: &[(T, T)]) -> impl IntoIterator<Item = [T; 3]> {
        let [(st, ct), (sp, cp)] = [sin_cos[0], sin_cos[1]];
        [[st * cp, st * sp, ct]]
    }
}
