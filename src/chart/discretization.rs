//! Discretization maps and their cotangent lifts.
//!
//! A discretization map on a configuration space `Q` maps a tangent vector to two nearby points, `R_d(x, v) = (R_1(x,
//! v), R_2(x, v))`, with `R_d(x, 0) = (x, x)` and `D_v (R_2 - R_1)(x, 0) = I`. Here `Q` is the chart of the tangent
//! bundle: `x = (q, qdot)`.
//!
//! Its cotangent lift is the symplectic map `(x, p, v, pdot) -> (x_0, p_0, x_1, p_1)` with
//!
//! ```math
//! (x_0, x_1) = R_d(x, v),\qquad DR_d(x,v)^T (-p_0, p_1) = (\dot p, p)
//! ```
//!
//! # Source
//! Barbero-Liñán, Martín de Diego (2023), "Retraction maps: a seed of geometric integrators", Found. Comput. Math.
//! 23, 1335-1380, section 4; arXiv 2404.19407.

use nalgebra::{SMatrix, SVector};

use super::elimination::solve_in_place;

/// Blocks with respect to `(x, v)`: `[[.x, .v] of the first row, [.x, .v] of the second]`.
pub type Blocks<const X: usize> = [[SMatrix<f64, X, X>; 2]; 2];

/// A discretization map on `R^X`. Implementing this trait for a new map provides its symplectic integrator and
/// shooting.
///
/// # Examples
/// ```
/// use nalgebra::{SMatrix, SVector};
/// use stiefel_rs::chart::{DiscretizationMap, LinearMap, RetractionMap, SpaceRetraction};
/// /// `R_d(x, 0) = (x, x)`, and `D_v (R_2 - R_1)(x, 0) = I`.
/// fn check(map: &impl DiscretizationMap<4>) {
///     let (x, zero) = (SVector::from([1.0, 2.0, 3.0, 4.0]), SVector::zeros());
///     let ([first, second], [[_, back], [_, forth]]) = (map.map(&x, &zero), map.jacobian(&x, &zero));
///     assert!((first - x).norm() + (second - x).norm() < 1e-14);
///     assert!((forth - back - SMatrix::identity()).norm() < 1e-13);
/// }
/// check(&LinearMap::INITIAL_POINT);
/// check(&RetractionMap::midpoint(SpaceRetraction::Exponential));
/// ```
pub trait DiscretizationMap<const X: usize>: Sync {
    /// `(R_1(x, v), R_2(x, v))`.
    fn map(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> [SVector<f64, X>; 2];

    /// `[[D_x R_1, D_v R_1], [D_x R_2, D_v R_2]]`.
    fn jacobian(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> Blocks<X>;

    /// The derivative of `DR_d(x, v)^T lambda` with respect to `(x, v)` for fixed `lambda`: the second derivatives of
    /// `lambda_1 . R_1 + lambda_2 . R_2`, `[[xx, xv], [vx, vv]]`. Zero for a linear map.
    fn second_derivative(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &[SVector<f64, X>; 2],
    ) -> Blocks<X>;

    /// All of these at once; override it if they share work.
    fn expansion(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &[SVector<f64, X>; 2],
    ) -> Expansion<X> {
        Expansion {
            points: self.map(x, v),
            jacobian: self.jacobian(x, v),
            second_derivative: self.second_derivative(x, v, lambda),
        }
    }

    /// Order of the method: 2 for a symmetric map, `R_d(x, -v) = (R_2(x, v), R_1(x, v))`, otherwise 1.
    ///
    /// A symmetric map that does not declare order 2 can still be composed, but only with its adjoint, which is the map
    /// itself.
    fn order(&self) -> usize {
        1
    }
}

/// A discretization map at one point with its derivatives.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::chart::{DiscretizationMap, LinearMap};
/// let (x, v) = (SVector::from([1.0, 2.0, 3.0, 4.0]), SVector::from([0.5, 0.0, -1.0, 0.25]));
/// let expansion = LinearMap::MIDPOINT.expansion(&x, &v, &[x, v]);
/// assert_eq!(expansion.points, [x - v * 0.5, x + v * 0.5]);
/// // D_v of both points is a multiple of the identity: -1/2 and 1/2.
/// assert!((expansion.jacobian[0][1] + expansion.jacobian[1][1]).norm() == 0.0);
/// assert!(expansion.second_derivative.iter().flatten().all(|block| block.norm() == 0.0));
/// ```
#[derive(Debug, Clone)]
pub struct Expansion<const X: usize> {
    /// As [`DiscretizationMap::map`].
    pub points: [SVector<f64, X>; 2],
    /// As [`DiscretizationMap::jacobian`].
    pub jacobian: Blocks<X>,
    /// As [`DiscretizationMap::second_derivative`].
    pub second_derivative: Blocks<X>,
}

/// The linear maps `R_d(x, v) = (x - a v, x + (1 - a) v)`.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::chart::{LinearMap, Sphere, integrate, reference};
/// let z0 = SVector::<f64, 8>::from([1.2, 0.0, 0.5, 1.0, 0.3, -0.2, 0.4, 0.6]);
/// let exact = reference(&Sphere, &z0, &[1.0], Interrupt::NEVER)?[0];
/// let error = |map: LinearMap, steps| -> stiefel_rs::Result<f64> {
///     Ok((integrate(&Sphere, &map, &z0, steps, 1.0, Interrupt::NEVER)?[steps] - exact).norm())
/// };
/// // Half the step: half of the error of order 1, a quarter of that of order 2.
/// let ratio = |map| -> stiefel_rs::Result<f64> { Ok(error(map, 100)? / error(map, 200)?) };
/// assert!((ratio(LinearMap::INITIAL_POINT)? - 2.0).abs() < 0.1);
/// assert!((ratio(LinearMap::MIDPOINT)? - 4.0).abs() < 0.1);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearMap {
    back: f64,
}

impl LinearMap {
    /// `R_d(x, v) = (x, x + v)`: the initial-point map, a symplectic Euler method of order 1.
    pub const INITIAL_POINT: LinearMap = LinearMap { back: 0.0 };
    /// `R_d(x, v) = (x - v/2, x + v/2)`: the midpoint map, the implicit midpoint rule of order 2.
    pub const MIDPOINT: LinearMap = LinearMap { back: 0.5 };
}

impl<const X: usize> DiscretizationMap<X> for LinearMap {
    fn map(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> [SVector<f64, X>; 2] {
        [x - v * self.back, x + v * (1.0 - self.back)]
    }

    fn jacobian(&self, _x: &SVector<f64, X>, _v: &SVector<f64, X>) -> Blocks<X> {
        let identity = SMatrix::identity();
        [
            [identity, identity * -self.back],
            [identity, identity * (1.0 - self.back)],
        ]
    }

    fn second_derivative(
        &self,
        _: &SVector<f64, X>,
        _: &SVector<f64, X>,
        _: &[SVector<f64, X>; 2],
    ) -> Blocks<X> {
        [[SMatrix::zeros(); 2]; 2]
    }

    fn order(&self) -> usize {
        if self.back == 0.5 { 2 } else { 1 }
    }
}

/// The cotangent lift of a discretization map at `(x, p, v, pdot)`: the pairs `(x_0, p_0)` and `(x_1, p_1)`.
///
/// `None` if `DR_d` is singular (far from the zero section).
pub fn cotangent_lift<const X: usize>(
    map: &impl DiscretizationMap<X>,
    x: &SVector<f64, X>,
    p: &SVector<f64, X>,
    v: &SVector<f64, X>,
    pdot: &SVector<f64, X>,
) -> Option<[(SVector<f64, X>, SVector<f64, X>); 2]> {
    let [[r1x, r1v], [r2x, r2v]] = map.jacobian(x, v);
    // The first row gives p_1 = R_2x^{-T} (pdot + R_1x^T p_0); the second row is then a system for p_0 alone.
    let mut from_rate = *pdot;
    let mut from_start = r1x.transpose();
    if !(solve_in_place(r2x.transpose(), &mut from_rate)
        && solve_in_place(r2x.transpose(), &mut from_start))
    {
        return None;
    }
    let mut p0 = p - r2v.transpose() * from_rate;
    if !solve_in_place(r2v.transpose() * from_start - r1v.transpose(), &mut p0) {
        return None;
    }
    let p1 = from_rate + from_start * p0;
    let [x0, x1] = map.map(x, v);
    Some([(x0, p0), (x1, p1)])
}
