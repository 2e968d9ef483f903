//! The adjusted de Casteljau algorithm: geometric cubic polynomials on `St(n, k)`.
//!
//! Three stages of quasi-geodesics take the place of the straight lines of the Euclidean algorithm:
//!
//! ```text
//! S0 --- S1 --- S2 --- S3      control points
//!    b01    b12    b23         quasi-geodesics, fixed
//!       b012   b123            quasi-geodesics at the same t
//!           gamma
//! ```
//!
//! # Source
//! Krakowski, Machado, Silva Leite, Batista (2017); arXiv 2404.19407, section on the adjusted algorithm (its
//! `X_0 .. X_5`, `Omega_0 .. Omega_5` are the six quasi-geodesics above). Deviation: work is done in the
//! `min(n, 4k)` dimensions that the control points span, which is exact.

use faer::{Mat, MatRef, Scale};

use super::{Curve, check_parameter};
use crate::error::{Error, Result};
use crate::linalg::decomp::thin_q;
use crate::linalg::jet::Jet;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::{EndpointProblem, Evaluation};
use crate::manifold::quasi_geodesic_jet::MovingQuasiGeodesic;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};

/// Two quasi-geodesics between the same points have the same velocity, to round-off times the conditioning of the
/// logarithm, or velocities that are about a turn apart.
const SAME_BRANCH: f64 = 1e-3;

/// A geometric cubic: the curve of the adjusted de Casteljau algorithm on `[0, 1]`.
///
/// ```math
/// \gamma(t) = e^{t X_5}\, b_{012}(t)\, e^{t \Omega_5},\qquad b_{012}(t) = e^{t X_3}\, b_{01}(t)\, e^{t \Omega_3}
/// ```
///
/// It meets its end points and end velocities to round-off; in between it is close to the Riemannian cubic with the
/// same data, not equal to it. Evaluation costs `O(k^3)` per parameter and one product to lift.
///
/// # Domain
/// The construction joins points by principal quasi-geodesics, so the curve is smooth where the relative rotations and
/// principal angles of all intermediate points stay below pi. For far or fast data (on `St(3,2)`: speeds of 6 and
/// more, or arbitrary control points) one of them may cross pi inside of the interval: there the curve jumps to
/// another branch, or, at the very parameter, cannot be evaluated. This is a limit of the algorithm, not of the
/// data; [`Curve::cost`] does not settle across a jump.
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
pub struct GeometricCubic {
    control_points: [Mat<f64>; 4],
    /// Orthonormal basis of the span of the control points, where that is smaller than `R^n`.
    frame: Option<Mat<f64>>,
    /// `b01, b12, b23` in the coordinates of the frame.
    legs: [QuasiGeodesic; 3],
}

impl GeometricCubic {
    /// The curve with end points `s0, s1` and end velocities `v0, v1`, all of shape `(n, k)`.
    ///
    /// The outer legs are the quasi-geodesics with velocities `v0 / 3` and `v1 / 3`. The end velocities are met
    /// where those are the principal ones between their end points (on the sphere: speeds below `3 pi`), because
    /// the later stages join points by principal quasi-geodesics.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` where an end velocity is too long
    /// to be met; `NoJoiningCurve`, `OutsideLogDomain`,
    /// `DifferentComponents` where the inner control points cannot be joined.
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
    ) -> Result<Self> {
        let manifold = Stiefel::of("S0", s0)?;
        manifold.check_point("S0", s0, POINT_TOLERANCE)?;
        manifold.check_tangent("V0", s0, v0, TANGENT_TOLERANCE)?;
        manifold.check_point("S1", s1, POINT_TOLERANCE)?;
        manifold.check_tangent("V1", s1, v1, TANGENT_TOLERANCE)?;
        let span = Span::of(&[s0, v0, s1, v1]);
        let first = QuasiGeodesic::from_velocity(
            span.down(s0).as_ref(),
            (span.down(v0) * Scale(1.0 / 3.0)).as_ref(),
        )?;
        let last = QuasiGeodesic::from_velocity(
            span.down(s1).as_ref(),
            (span.down(v1) * Scale(-1.0 / 3.0)).as_ref(),
        )?;
        let inner = [first.point(1.0)?, last.point(1.0)?];
        check_principal("V0", &first, &inner[0])?;
        check_principal("V1", &last, &inner[1])?;
        let middle = QuasiGeodesic::between(inner[0].as_ref(), inner[1].as_ref())?;
        Ok(GeometricCubic {
            control_points: [
                s0.to_owned(),
                span.up(&inner[0]),
                span.up(&inner[1]),
                s1.to_owned(),
            ],
            frame: span.basis,
            legs: [first, middle, last.reversed()?],
        })
    }

    /// The curve with the given control points, each of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents` where
    /// two consecutive points cannot be joined.
    pub fn from_control_points(points: [MatRef<'_, f64>; 4]) -> Result<Self> {
        let manifold = Stiefel::of("control points", points[0])?;
        for point in points {
            manifold.check_point("control points", point, POINT_TOLERANCE)?;
        }
        let span = Span::of(&points);
        let low = points.map(|point| span.down(point));
        let leg = |i: usize| QuasiGeodesic::between(low[i].as_ref(), low[i + 1].as_ref());
        Ok(GeometricCubic {
            control_points: points.map(|point| point.to_owned()),
            legs: [leg(0)?, leg(1)?, leg(2)?],
            frame: span.basis,
        })
    }

    /// The four control points, each of shape `(n, k)`.
    pub fn control_points(&self) -> &[Mat<f64>; 4] {
        &self.control_points
    }

    fn position_into(&self, t: f64, work: &mut Workspace, out: &mut Jet) -> Result<()> {
        let [a, b, c] = &mut work.stage;
        for (leg, target) in self.legs.iter().zip([&mut *a, &mut *b, &mut *c]) {
            leg.jet_into(t, 0, &mut work.evaluation, target)?;
        }
        let mut advance = |from: &mut Jet, to: &Jet| -> Result<()> {
            work.joining
                .join(from.c[0].as_ref(), to.c[0].as_ref(), &mut work.problem)?;
            work.joining.jet_into(t, 0, &mut work.evaluation, from)
        };
        advance(a, b)?;
        advance(b, c)?;
        advance(a, b)?;
        out.copy_from(a, 0);
        Ok(())
    }

    fn derivatives_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Workspace,
        out: &mut Jet,
    ) -> Result<()> {
        let Workspace {
            stage: [a, b, c],
            evaluation,
            moving,
            next,
            ..
        } = work;
        for (leg, target) in self.legs.iter().zip([&mut *a, &mut *b, &mut *c]) {
            leg.jet_into(t, order, evaluation, target)?;
        }
        let moving = moving.get_or_insert_with(|| {
            Box::new(MovingQuasiGeodesic::new(a.c[0].nrows(), a.c[0].ncols()))
        });
        moving.jet_into(a, b, t, order, next)?;
        std::mem::swap(a, next);
        moving.jet_into(b, c, t, order, next)?;
        std::mem::swap(b, next);
        moving.jet_into(a, b, t, order, out)
    }
}

/// Error `InvalidArgument` unless a leg, which ends at `end`, is the principal quasi-geodesic between its ends.
fn check_principal(name: &'static str, leg: &QuasiGeodesic, end: &Mat<f64>) -> Result<()> {
    let principal = QuasiGeodesic::between(leg.point(0.0)?.as_ref(), end.as_ref())?;
    let velocity = leg.initial_velocity();
    let (size, gap) = (
        velocity.norm_l2(),
        (&velocity - principal.initial_velocity()).norm_l2(),
    );
    if gap <= SAME_BRANCH * size.max(1.0) {
        return Ok(());
    }
    let requirement = "short enough for its third to be the velocity of a principal quasi-geodesic";
    Err(Error::InvalidArgument {
        name,
        requirement,
        found: 3.0 * size,
    })
}

impl Curve for GeometricCubic {
    type Workspace = Workspace;

    fn n(&self) -> usize {
        self.control_points[0].nrows()
    }

    fn k(&self) -> usize {
        self.control_points[0].ncols()
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.frame.as_ref().map(|frame| frame.as_ref())
    }

    fn workspace(&self) -> Workspace {
        Workspace::new(self.legs[0].n(), self.legs[0].k())
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Workspace,
        out: &mut Jet,
    ) -> Result<()> {
        check_parameter(t)?;
        if order == 0 {
            self.position_into(t, work, out)
        } else {
            self.derivatives_into(t, order, work, out)
        }
    }
}

/// Buffers for evaluating geometric cubics of one shape.
pub struct Workspace {
    stage: [Jet; 3],
    next: Jet,
    evaluation: Evaluation,
    joining: QuasiGeodesic,
    problem: EndpointProblem,
    moving: Option<Box<MovingQuasiGeodesic>>,
}

impl Workspace {
    fn new(r: usize, k: usize) -> Self {
        Workspace {
            stage: std::array::from_fn(|_| Jet::zeros(r, k)),
            next: Jet::zeros(r, k),
            evaluation: Evaluation::new(k),
            joining: QuasiGeodesic::zeros(r, k),
            problem: EndpointProblem::new(r, k),
            moving: None,
        }
    }
}

/// The span of a few `n x k` matrices. The isometries that fix it pointwise fix every curve built from them, so
/// the curve stays in it.
struct Span {
    basis: Option<Mat<f64>>,
}

impl Span {
    fn of(matrices: &[MatRef<'_, f64>; 4]) -> Self {
        let (n, k) = (matrices[0].nrows(), matrices[0].ncols());
        if n <= 4 * k {
            return Span { basis: None };
        }
        let stacked = Mat::from_fn(n, 4 * k, |i, j| matrices[j / k][(i, j % k)]);
        Span {
            basis: Some(thin_q(stacked.as_ref())),
        }
    }

    fn down(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        self.basis
            .as_ref()
            .map_or_else(|| a.to_owned(), |e| e.transpose() * a)
    }

    fn up(&self, a: &Mat<f64>) -> Mat<f64> {
        self.basis.as_ref().map_or_else(|| a.clone(), |e| e * a)
    }
}

/// Convenience for a whole array of control points.
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
