//! The geometric polynomial of degree five with given end points, end velocities and end accelerations, in closed form.
//!
//! # Derivation
//! Let the first leg of a geometric polynomial of degree `m` start at `S` with velocity `u`, and let the second leg
//! start at `P_1` with velocity `w`. Stage `j` of de Casteljau's algorithm is `R_x(t l(x, y))` of two curves of stage
//! `j - 1`, with the retraction `R` and its inverse `l`. At `t = 0` these have `x' = (j - 1) u` and `y' = (j - 1) w`,
//! so the second derivatives of consecutive stages differ by `2 (j - 1) (D_x l[u] + D_y l[w])` and that of the first
//! leg, and
//!
//! ```math
//! \gamma''(0) = m \beta''(0) + m (m - 1)\, (D_x l\,[u] + D_y l\,[w]),\qquad \beta(t) = R_S(t u).
//! ```
//!
//! If the second leg continues the first one, `w = beta'(1) = D R_u [u]`, the curve is `beta(m t)`, hence `D_x l [u] +
//! D_y l [beta'(1)] = beta''(0)`. A quasi-geodesic with velocity `V = K + S Omega` has the covariant acceleration `K
//! Omega`. So the covariant acceleration at `t = 0` is `A`, and the velocity is `V = m u`, if
//!
//! ```math
//! w = D R_{V/m} \Big[ \frac{V}{m} + \frac{A - K \Omega}{m (m - 1)} \Big].
//! ```

use faer::{Mat, MatRef, Scale};

use super::curve::Curve;
use super::de_casteljau::GeometricPolynomial;
use super::end_legs::{check_boundary, check_principal, outer_leg};
use super::span::Span;
use crate::error::{Error, Result};
use crate::linalg::structure::norm;
use crate::manifold::QuasiGeodesic;
use crate::manifold::retraction_differential::retraction_differential;
use crate::manifold::stiefel::{Stiefel, TANGENT_TOLERANCE};

const DEGREE: usize = 5;

/// A leg this long is never a principal quasi-geodesic, and its square does not overflow.
const LONG: f64 = 1e6;

/// The two legs at one end, and their end points.
struct EndLegs {
    legs: [QuasiGeodesic; 2],
    points: [Mat<f64>; 2],
}

impl GeometricPolynomial {
    /// The curve of degree five with end points `s0, s1`, end velocities `v0, v1` and covariant end accelerations
    /// `a0, a1`, all of shape `(n, k)`.
    ///
    /// It has a closed form. With the end accelerations of a Riemannian cubic it is close to that cubic (see
    /// [`GeometricPolynomial::minimal_cost`] for measured distances), and consecutive curves that share end
    /// accelerations join with continuous acceleration.
    ///
    /// # Accuracy
    /// End points, end velocities and end accelerations of size 1 are accurate to `2e-14 k`, `2e-13 k` and `2e-12 k`;
    /// asserted in `tests/quintic.rs`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` if an end velocity or an end
    /// acceleration is too long; `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents` if the inner control
    /// points cannot be joined; `BranchJump` if intermediate points cannot.
    /// # Source
    /// Our own derivation (see the module documentation). Popiel, Noakes (2007), "Bezier curves and C2 interpolation in
    /// Riemannian manifolds", treat pieces that are geodesics.
    ///
    /// # Examples
    /// ```
    /// use faer::{Mat, mat};
    /// use stiefel_rs::{Curve, GeometricPolynomial};
    /// let (s0, v0, a0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
    /// let (s1, v1, a1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [1.0]], Mat::zeros(3, 1));
    /// let [s0, v0, a0, s1, v1, a1] = [&s0, &v0, &a0, &s1, &v1, &a1].map(|a| a.as_ref());
    /// let curve = GeometricPolynomial::quintic(s0, v0, a0, s1, v1, a1)?;
    /// assert!((curve.acceleration(0.0)? - a0).norm_l2() < 1e-12);
    /// # Ok::<(), stiefel_rs::Error>(())
    /// ```
    pub fn quintic(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        a0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        a1: MatRef<'_, f64>,
    ) -> Result<Self> {
        let manifold = check_boundary([("S0", s0), ("V0", v0), ("S1", s1), ("V1", v1)])?;
        manifold.check_tangent("A0", s0, a0, TANGENT_TOLERANCE)?;
        manifold.check_tangent("A1", s1, a1, TANGENT_TOLERANCE)?;
        let span = Span::of(&[s0, v0, a0, s1, v1, a1]);
        let [s0, v0, a0, s1, v1, a1] = [s0, v0, a0, s1, v1, a1].map(|a| span.down(a));
        let first = EndLegs::new(["V0", "A0"], &s0, &v0, &a0)?;
        // Backwards from the other end: velocities change sign, accelerations do not.
        let last = EndLegs::new(["V1", "A1"], &s1, &-v1, &a1)?;
        let [p1, p2] = first.points;
        let [p4, p3] = last.points;
        let middle = QuasiGeodesic::joining(p2.as_ref(), p3.as_ref())?;
        let [leg0, leg1] = first.legs;
        let [leg4, leg3] = last.legs;
        let legs = vec![leg0, leg1, middle, leg3.reversed()?, leg4.reversed()?];
        Self::of_legs(vec![s0, p1, p2, p3, p4, s1], span, legs)
    }
}

impl EndLegs {
    /// Built from point, velocity and covariant acceleration; `names` are those of the last two.
    fn new(names: [&'static str; 2], s: &Mat<f64>, v: &Mat<f64>, a: &Mat<f64>) -> Result<Self> {
        let (leg, point) = outer_leg(names[0], s, v, DEGREE)?;
        let refusal = || Error::InvalidArgument {
            name: names[1],
            requirement: "small enough for the second leg to be a principal quasi-geodesic",
            found: norm(a.as_ref()),
        };
        let (normal, omega) = Stiefel::of("S", s.as_ref())?.split(s.as_ref(), v.as_ref())?;
        let degree = DEGREE as f64;
        let u = v * Scale(1.0 / degree);
        let bend = (a - normal * omega) * Scale(1.0 / (degree * (degree - 1.0)));
        let turned = &u + bend;
        // NaN if lengths overflow.
        let length = norm(turned.as_ref());
        if length.is_nan() || length > LONG {
            return Err(refusal());
        }
        // The derivative only needs the span of three matrices, which may be much smaller than that of all data.
        let span = Span::of(&[s.as_ref(), u.as_ref(), turned.as_ref()]);
        let [low, low_u, low_turned] = [s, &u, &turned].map(|x| span.down(x.as_ref()));
        let w = retraction_differential(low.as_ref(), low_u.as_ref(), low_turned.as_ref())?;
        let w = span.into_basis().map_or(w.clone(), |basis| basis * &w);
        let w = Stiefel::of("S", point.as_ref())?.project_tangent(point.as_ref(), w.as_ref())?;
        let second = QuasiGeodesic::from_velocity(point.as_ref(), w.as_ref())?;
        let end = second.point(1.0)?;
        check_principal(&second, &end, |_| refusal())?;
        Ok(EndLegs {
            legs: [leg, second],
            points: [point, end],
        })
    }
}
