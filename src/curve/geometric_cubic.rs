//! The geometric cubic: de Casteljau's algorithm of degree three from boundary data.
//!
//! # Source
//! Krakowski, Machado, Silva Leite, Batista (2017); arXiv 2404.19407, section on the adjusted algorithm (its `X_0 ..
//! X_5`, `Omega_0 .. Omega_5` belong to the six quasi-geodesics of the three stages).

use faer::{Mat, MatMut, MatRef};

use super::curve::Curve;
use super::de_casteljau::{DeCasteljauWorkspace, GeometricPolynomial};
use super::end_legs::{check_boundary, outer_leg};
use super::span::Span;
use crate::error::{Error, Result};
use crate::linalg::jet::MatrixJet;
use crate::manifold::QuasiGeodesic;
use crate::manifold::only_bases::advised;

/// A geometric cubic: the curve of the adjusted de Casteljau algorithm on `[0, 1]`.
///
/// ```math
/// \gamma(t) = e^{t X_5}\, b_{012}(t)\, e^{t \Omega_5},\qquad b_{012}(t) = e^{t X_3}\, b_{01}(t)\, e^{t \Omega_3}
/// ```
///
/// It satisfies its end points and end velocities to round-off; in between it is close to the Riemannian cubic with the
/// same data, but not equal to it. Evaluation costs `O(k^3)` per parameter, and one product to lift the points to `n`
/// rows.
///
/// # Domain
/// As for [`GeometricPolynomial`]: distant or fast data (on `St(3,2)`: speeds of 6 and more, or arbitrary control
/// points) are refused if intermediate points reach an angle of pi inside `[0, 1]`.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::{Curve, GeometricCubic};
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let curve = GeometricCubic::from_boundary(s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref())?;
/// let end_velocity: Mat<f64> = curve.derivative(1.0, 1)?;
/// assert!((end_velocity - v1).norm_l2() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct GeometricCubic(GeometricPolynomial);

impl GeometricCubic {
    /// The curve with end points `s0, s1` and end velocities `v0, v1`, all of shape `(n, k)`.
    ///
    /// The outer legs are the quasi-geodesics with velocities `v0 / 3` and `v1 / 3`. They must be the principal ones
    /// between their end points (on the sphere: speeds below `3 pi`), because the later stages join points by principal
    /// quasi-geodesics.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` if an end velocity is too long;
    /// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents` if the inner control points cannot be joined, in
    /// `OnlyBases` if the end points look like mere bases;
    /// `BranchJump` if intermediate points cannot.
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
    ) -> Result<Self> {
        check_boundary([("S0", s0), ("V0", v0), ("S1", s1), ("V1", v1)])?;
        let span = Span::of(&[s0, v0, s1, v1]);
        let [low0, low1] = [s0, s1].map(|s| span.down(s));
        let (first, inner0) = outer_leg("V0", &low0, &span.down(v0), 3)?;
        let (last, inner1) = outer_leg("V1", &low1, &-span.down(v1), 3)?;
        let middle = QuasiGeodesic::joining(inner0.as_ref(), inner1.as_ref());
        let middle = middle.map_err(|error| advised(error, s0, s1))?;
        let points = vec![low0, inner0, inner1, low1];
        let legs = vec![first, middle, last.reversed()?];
        GeometricPolynomial::of_legs(points, span, legs).map(GeometricCubic)
    }

    /// The curve with the given control points, each of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents` if two
    /// consecutive points cannot be joined; `BranchJump` if intermediate points cannot.
    pub fn from_control_points(points: [MatRef<'_, f64>; 4]) -> Result<Self> {
        GeometricPolynomial::new(&points).map(GeometricCubic)
    }

    #[cfg(any(feature = "python", feature = "serde"))]
    pub(super) fn as_polynomial(&self) -> &GeometricPolynomial {
        &self.0
    }

    /// Built from a polynomial of degree three.
    #[cfg(any(feature = "python", feature = "serde"))]
    pub(super) fn of_polynomial(curve: GeometricPolynomial) -> Self {
        debug_assert_eq!(curve.degree(), 3);
        GeometricCubic(curve)
    }

    /// The four control points, each of shape `(n, k)`; they are lifted from the frame, so they equal the given ones up
    /// to round-off.
    pub fn control_points(&self) -> [Mat<f64>; 4] {
        match <[Mat<f64>; 4]>::try_from(self.0.control_points()) {
            Ok(points) => points,
            Err(_) => unreachable!("a cubic has four"),
        }
    }
}

/// The same curve, as a polynomial of any degree.
impl From<GeometricCubic> for GeometricPolynomial {
    fn from(curve: GeometricCubic) -> Self {
        curve.0
    }
}

impl Curve for GeometricCubic {
    type Workspace = DeCasteljauWorkspace;

    fn n(&self) -> usize {
        self.0.n()
    }

    fn k(&self) -> usize {
        self.0.k()
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.0.frame()
    }

    fn workspace(&self) -> DeCasteljauWorkspace {
        self.0.workspace()
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut DeCasteljauWorkspace,
        out: &mut MatrixJet,
    ) -> Result<()> {
        self.0.coordinates_into(t, order, work, out)
    }

    fn jets_into(
        &self,
        t: &[f64],
        order: usize,
        work: &mut DeCasteljauWorkspace,
        out: &mut [MatrixJet],
    ) -> Result<()> {
        self.0.jets_into(t, order, work, out)
    }

    fn positions_into(
        &self,
        t: &[f64],
        work: &mut DeCasteljauWorkspace,
        scratch: &mut Option<MatrixJet>,
        out: MatMut<'_, f64>,
    ) -> Result<()> {
        self.0.positions_into(t, work, scratch, out)
    }
}

/// For an array of control points.
impl TryFrom<&[Mat<f64>]> for GeometricCubic {
    type Error = Error;

    fn try_from(points: &[Mat<f64>]) -> Result<Self> {
        match points {
            [a, b, c, d] => {
                Self::from_control_points([a.as_ref(), b.as_ref(), c.as_ref(), d.as_ref()])
            }
            _ => Err(Error::Shape {
                name: "control points",
                expected: "(4, n, k)".to_owned(),
                found: format!("({}, n, k)", points.len()),
            }),
        }
    }
}
