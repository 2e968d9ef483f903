//! Orthonormal 2-frames in space, `St(3,2)`, in the angles `(theta, phi, psi)`.

use super::chart::Chart;
use super::series::SeriesScalar;
use super::term::Term;

/// The paper's chart of `St(3,2)`: `q = (theta, phi, psi)`, metric
/// `dtheta^2 + dphi^2 + dpsi^2 + 2 cos(theta) dphi dpsi` (the canonical metric).
///
/// The first column is the point of the sphere at `(theta, phi)`, the second the unit tangent vector at angle `psi`
/// from the meridian:
///
/// ```math
/// S = (e_r,\ \cos\psi\, e_\theta + \sin\psi\, e_\phi)
/// ```
/// ```math
/// H = p\cdot\dot q + \tfrac12 p_{\dot\theta}^2
///   + \frac{p_{\dot\phi}^2 - 2\cos\theta\, p_{\dot\phi}p_{\dot\psi} + p_{\dot\psi}^2}{2\sin^2\theta}
///   - \sin\theta\,\dot\phi\dot\psi\, p_{\dot\theta}
///   - \dot\theta\dot\phi\Bigl(\cot\theta\, p_{\dot\phi} - \frac{p_{\dot\psi}}{\sin\theta}\Bigr)
///   - \dot\theta\dot\psi\Bigl(\cot\theta\, p_{\dot\psi} - \frac{p_{\dot\phi}}{\sin\theta}\Bigr)
/// ```
///
/// It follows from the metric and its Christoffel symbols. The paper writes it in a longer form that divides by
/// `cos(theta)`; this form is singular only at the poles of the chart.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::chart::{Chart, Frame};
/// let q = [std::f64::consts::FRAC_PI_2, 0.0, 0.0];
/// let s = Frame.embed(&q)?;
/// assert!((&s - mat![[1.0, 0.0], [0.0, 0.0], [0.0, -1.0]]).norm_l2() < 1e-14);
/// // To turn psi is to turn the second column about the first.
/// let v = Frame.embed_velocity(&q, &[0.0, 0.0, 1.0])?;
/// assert!((v - mat![[0.0, 0.0], [0.0, 1.0], [0.0, 0.0]]).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Frame;

impl Chart<6, 12> for Frame {
    const K: usize = 2;

    fn terms<T: SeriesScalar>(&self, s: T, c: T) -> impl IntoIterator<Item = Term<T>> {
        let (one, two) = (T::from(1.0), T::from(2.0));
        let (square, cube) = (s * s, s * s * s);
        let fourth = square * square;
        let half_inverse_square = [
            T::from(0.5) / square,
            -c / cube,
            (one + two * c * c) / fourth,
        ];
        let mixed = [
            -c / square,
            (one + c * c) / cube,
            -c * (T::from(5.0) + c * c) / fourth,
        ];
        let minus_cotangent = [-c / s, one / square, -two * c / cube];
        let cosecant = [one / s, -c / square, (one + c * c) / cube];
        [
            Term::constant(1.0, &[6, 3]),
            Term::constant(1.0, &[7, 4]),
            Term::constant(1.0, &[8, 5]),
            Term::constant(0.5, &[9, 9]),
            Term::new(half_inverse_square, &[10, 10]),
            Term::new(half_inverse_square, &[11, 11]),
            Term::new(mixed, &[10, 11]),
            Term::new([-s, -c, s], &[4, 5, 9]),
            Term::new(minus_cotangent, &[3, 4, 10]),
            Term::new(cosecant, &[3, 4, 11]),
            Term::new(minus_cotangent, &[3, 5, 11]),
            Term::new(cosecant, &[3, 5, 10]),
        ]
    }

    fn columns<T: SeriesScalar>(&self, sin_cos: &[(T, T)]) -> impl IntoIterator<Item = [T; 3]> {
        let [(st, ct), (sf, cf), (sp, cp)] = [sin_cos[0], sin_cos[1], sin_cos[2]];
        [
            [st * cf, st * sf, ct],
            [cp * ct * cf - sp * sf, cp * ct * sf + sp * cf, -cp * st],
        ]
    }
}
