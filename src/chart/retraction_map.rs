//! Discretization maps from retractions of the manifold: exponential, Cayley transform, quasi-geodesics.
//!
//! A retraction `rho(q, u)` of the manifold, expressed in the chart, lifts to the tangent bundle: with `x = (q, qdot)`
//! and `v = (dq, dqdot)`,
//!
//! ```math
//! \hat\rho(x, v) = \bigl(\rho(q, dq),\ D_q\rho\,\dot q + D_u\rho\, d\dot q\bigr),\qquad
//! R_d(x, v) = \bigl(\hat\rho(x, -a v),\ \hat\rho(x, (1 - a) v)\bigr)
//! ```
//!
//! The retractions are rotations of the moving frame, so they and the resulting methods commute with the isometries of
//! the manifold: the discrete curve is the same in every chart, and the whole spatial momentum is conserved.
//!
//! # Source
//! Barbero-Liñán, Martín de Diego (2023), sections 3 (discretization maps from retractions) and 4 (tangent lift). The
//! formulas in angles are our own, from `R_z(phi) R_y(theta) R_z(psi)`.

use nalgebra::{SMatrix, SVector};

use super::discretization::{Blocks, DiscretizationMap, Expansion};
use super::jet::{Analytic, Jet, sin_cos};
use super::rotation::{Quaternion, angles, cayley, exponential, product};
use super::series::Series;
use super::tangent_lift::TangentLift;

/// A retraction of `St(3,1)` and `St(3,2)` that commutes with the rotations of space.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::chart::{DiscretizationMap, RetractionMap, SpaceRetraction};
/// // Along the equator by 1: to the longitude 1, or by the Cayley transform to 2 atan(1/2).
/// let x = SVector::from([std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0]);
/// let v = SVector::from([0.0, 1.0, 0.0, 0.0]);
/// let longitude = |retraction| RetractionMap::initial_point(retraction).map(&x, &v)[1][1];
/// assert!((longitude(SpaceRetraction::Exponential) - 1.0).abs() < 1e-14);
/// assert!((longitude(SpaceRetraction::QuasiGeodesic) - 1.0).abs() < 1e-14);
/// assert!((longitude(SpaceRetraction::Cayley) - 2.0 * 0.5_f64.atan()).abs() < 1e-14);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SpaceRetraction {
    /// The Riemannian exponential of the canonical metric.
    Exponential,
    /// The Cayley transform: the geodesic in the same direction, traversed to the length `2 atan(|v| / 2)`.
    Cayley,
    /// The paper's quasi-geodesics `e^X S e^Omega`, which are the geodesics on the sphere.
    QuasiGeodesic,
}

/// The discretization map `R_d(x, v) = (rho(x, -a v), rho(x, (1 - a) v))` of a retraction, lifted to velocities.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::chart::{RetractionMap, SpaceRetraction, Sphere, covariant_from_state, integrate};
/// let z0 = SVector::<f64, 8>::from([1.2, 0.0, 0.5, 1.0, 0.3, -0.2, 0.4, 0.6]);
/// let map = RetractionMap::midpoint(SpaceRetraction::Exponential);
/// let z1 = integrate(&Sphere, &map, &z0, 10, 1.0, Interrupt::NEVER)?[10];
/// // Long steps, and yet all three components of the spatial momentum are conserved.
/// let momentum = |z| covariant_from_state(&Sphere, z).map(|data| data.spatial_momentum());
/// for (before, after) in momentum(&z0)?.iter().zip(momentum(&z1)?) {
///     assert!((before - after).abs() < 1e-12);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetractionMap {
    retraction: SpaceRetraction,
    back: f64,
}

impl RetractionMap {
    /// `R_d(x, v) = (x, rho(x, v))`: order 1.
    pub fn initial_point(retraction: SpaceRetraction) -> Self {
        RetractionMap {
            retraction,
            back: 0.0,
        }
    }

    /// `R_d(x, v) = (rho(x, -v/2), rho(x, v/2))`: symmetric, order 2.
    pub fn midpoint(retraction: SpaceRetraction) -> Self {
        RetractionMap {
            retraction,
            back: 0.5,
        }
    }

    /// The fractions of the velocity that lead to the first and to the second point.
    fn fractions(&self) -> [f64; 2] {
        [-self.back, 1.0 - self.back]
    }
}

/// The rotation of the moving frame `(e_theta, e_phi, e_r)` that describes the motion, and the new angles relative to
/// `phi` and `psi`, from `theta`, `psi` and the velocity.
fn moved<T: Analytic>(retraction: SpaceRetraction, theta: T, psi: Option<T>, u: [T; 3]) -> [T; 3] {
    let (sin, cos) = sin_cos(theta);
    // The sphere's rotations have no component about the point.
    let spin = if psi.is_some() {
        cos * u[1] + u[2]
    } else {
        T::from(0.0)
    };
    let m = [-sin * u[1], u[0], spin];
    let turn: Quaternion<T> = match (retraction, psi) {
        (SpaceRetraction::Cayley, _) => cayley(m),
        (SpaceRetraction::QuasiGeodesic, Some(psi)) => {
            // e^Omega rotates in the plane of the two columns, about the third direction of the frame.
            let (sp, cp) = sin_cos(psi);
            let within = cp * m[1] - sp * m[0];
            let axis = [-sp * within, cp * within, T::from(0.0)];
            let normal = [m[0] - axis[0], m[1] - axis[1], m[2]];
            product(exponential(normal), exponential(axis))
        }
        _ => exponential(m),
    };
    let (s, c) = sin_cos(T::from(0.5) * theta);
    angles(product([c, T::from(0.0), s, T::from(0.0)], turn))
}

/// The lifted retraction of a fraction of the velocity, on numbers with one derivative.
fn lifted<const X: usize>(
    retraction: SpaceRetraction,
    fraction: f64,
    x: &SVector<f64, X>,
    v: &SVector<f64, X>,
) -> SVector<f64, X> {
    let d = X / 2;
    if fraction == 0.0 {
        return *x;
    }
    let dual = |y: &SVector<f64, X>, i: usize, scale: f64| {
        if i < d {
            Series::<2>::new([scale * y[i], scale * y[d + i]])
        } else {
            Series::from(0.0)
        }
    };
    let psi = (d == 3).then(|| dual(x, 2, 1.0));
    let u = std::array::from_fn(|i| dual(v, i, fraction));
    let image = moved(retraction, dual(x, 0, 1.0), psi, u);
    let mut out = SVector::zeros();
    for i in 0..d {
        // phi and psi only enter as shifts.
        let (shift, shift_rate) = if i > 0 { (x[i], x[d + i]) } else { (0.0, 0.0) };
        let [value, rate] = *image[i].coefficients();
        (out[i], out[d + i]) = (value + shift, rate + shift_rate);
    }
    out
}

/// One point of the discretization map, its derivatives `[D_x, D_v]`, and the second derivatives of `lambda . point`.
struct MappedPoint<const X: usize> {
    value: SVector<f64, X>,
    slope: [SMatrix<f64, X, X>; 2],
    bend: Blocks<X>,
}

impl<const X: usize> MappedPoint<X> {
    /// The `N` variables are `theta`, with `PSI` also `psi`, and the velocity.
    fn expand<const N: usize>(
        retraction: SpaceRetraction,
        fraction: f64,
        variables: [usize; N],
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &SVector<f64, X>,
    ) -> Self {
        let d = X / 2;
        let number = |i: usize| if i < d { x[i] } else { v[i - d] };
        let jet = |i: usize| -> Jet<N> {
            let scale = if i < d { 1.0 } else { fraction };
            match variables.iter().position(|&variable| variable == i) {
                Some(index) => Jet::variable(scale * number(i), index, scale),
                None => Jet::from(scale * number(i)),
            }
        };
        let psi = (d == 3).then(|| jet(2));
        let u = std::array::from_fn(|i| if i < d { jet(d + i) } else { Jet::from(0.0) });
        let image = moved(retraction, jet(0), psi, u);
        let rates = variables.map(|i| if i < d { x[d + i] } else { v[i] });
        let lift = TangentLift::new(image, rates);
        // Position of a variable and its rate in (x, v): block and index.
        let place = variables.map(|i| if i < d { (0, i) } else { (1, i - d) });
        let mut out = MappedPoint {
            value: SVector::zeros(),
            slope: [SMatrix::zeros(); 2],
            bend: [[SMatrix::zeros(); 2]; 2],
        };
        let [position, rate] = [0, d].map(|first| &lambda.as_slice()[first..first + d]);
        for i in 0..d {
            let (shift, shift_rate) = if i > 0 { (x[i], x[d + i]) } else { (0.0, 0.0) };
            out.value[i] = lift.coordinate(i) + shift;
            out.value[d + i] = lift.rate(i) + shift_rate;
            if i > 0 {
                out.slope[0][(i, i)] = 1.0;
                out.slope[0][(d + i, d + i)] = 1.0;
            }
        }
        for (a, (block, j)) in place.into_iter().enumerate() {
            for i in 0..d {
                out.slope[block][(i, j)] += lift.slope(i, a);
                out.slope[block][(d + i, d + j)] += lift.slope(i, a);
                out.slope[block][(d + i, j)] += lift.rate_slope(i, a);
            }
            for (b, (other, l)) in place.into_iter().enumerate() {
                out.bend[block][other][(j, l)] = lift.bend(position, rate, a, b);
                let mixed = lift.mixed_bend(rate, a, b);
                out.bend[block][other][(j, d + l)] = mixed;
                out.bend[block][other][(d + j, l)] = mixed;
            }
        }
        out
    }

    fn new(
        retraction: SpaceRetraction,
        fraction: f64,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &SVector<f64, X>,
    ) -> Self {
        if fraction == 0.0 {
            return MappedPoint {
                value: *x,
                slope: [SMatrix::identity(), SMatrix::zeros()],
                bend: [[SMatrix::zeros(); 2]; 2],
            };
        }
        let quasi_geodesic = retraction == SpaceRetraction::QuasiGeodesic;
        match (X / 2, quasi_geodesic) {
            (2, _) => Self::expand(retraction, fraction, [0, 2, 3], x, v, lambda),
            (_, false) => Self::expand(retraction, fraction, [0, 3, 4, 5], x, v, lambda),
            (_, true) => Self::expand(retraction, fraction, [0, 2, 3, 4, 5], x, v, lambda),
        }
    }
}

/// The map for one chart; `X / 2` is its dimension.
macro_rules! discretization_map {
    ($x:literal) => {
        impl DiscretizationMap<$x> for RetractionMap {
            fn map(&self, x: &SVector<f64, $x>, v: &SVector<f64, $x>) -> [SVector<f64, $x>; 2] {
                self.fractions()
                    .map(|fraction| lifted(self.retraction, fraction, x, v))
            }

            fn jacobian(&self, x: &SVector<f64, $x>, v: &SVector<f64, $x>) -> Blocks<$x> {
                self.expansion(x, v, &[SVector::zeros(); 2]).jacobian
            }

            fn second_derivative(
                &self,
                x: &SVector<f64, $x>,
                v: &SVector<f64, $x>,
                lambda: &[SVector<f64, $x>; 2],
            ) -> Blocks<$x> {
                self.expansion(x, v, lambda).second_derivative
            }

            fn expansion(
                &self,
                x: &SVector<f64, $x>,
                v: &SVector<f64, $x>,
                lambda: &[SVector<f64, $x>; 2],
            ) -> Expansion<$x> {
                let [first, second] = self.fractions();
                let start = MappedPoint::new(self.retraction, first, x, v, &lambda[0]);
                let end = MappedPoint::new(self.retraction, second, x, v, &lambda[1]);
                let block = |i: usize, j: usize| start.bend[i][j] + end.bend[i][j];
                Expansion {
                    points: [start.value, end.value],
                    jacobian: [start.slope, end.slope],
                    second_derivative: [[block(0, 0), block(0, 1)], [block(1, 0), block(1, 1)]],
                }
            }

            fn order(&self) -> usize {
                if self.back == 0.5 { 2 } else { 1 }
            }
        }
    };
}

discretization_map!(4);
discretization_map!(6);
