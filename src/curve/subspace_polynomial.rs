//! De Casteljau's algorithm with geodesics of the Grassmann manifold.
//!
//! Stages are computed with bases: each geodesic `e^{tX} Y` starts from the given basis, and its Taylor coefficients
//! are computed as for quasi-geodesics of frames, which have the same spans. The resulting bases `F` rotate within the
//! subspaces; `horizontal_lift.rs` removes this rotation.
//!
//! # Source
//! Park, Ravani (1995), "Bezier curves on Riemannian manifolds and Lie groups with kinematics applications"; Popiel, Noakes
//! (2007), "Bezier curves and C2 interpolation in Riemannian manifolds".

use std::f64::consts::FRAC_PI_2;

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef, Scale};

use super::curve::Curve;
use super::horizontal_lift::Lift;
use super::sampling::check_parameter;
use super::span::{self, Span};
use super::stages::Stages;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::MatrixJet;
use crate::linalg::product::{mul_add, mul_into};
use crate::manifold::grassmann::joining::{join_spans, leave_span};
use crate::manifold::quasi_geodesic::EndpointProblem;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::manifold::{Grassmann, QuasiGeodesic};
use crate::space::Quotient;

/// A Bezier curve of subspaces on `[0, 1]`: de Casteljau's algorithm whose pieces are the shortest geodesics of `Gr(n, k)`.
///
/// It starts with the basis given as the first control point and continues with bases that rotate as little as
/// possible; it ends in the last subspace. The end velocities are `degree` times those of the first and the last
/// geodesic:
///
/// ```math
/// Y^T Y' = 0,\qquad Y'(0) = m \log(P_0, P_1),\qquad Y'(1) = -m \log(P_m, P_{m-1})\, Q,\quad Y(1) = P_m Q.
/// ```
///
/// Other bases of the control points yield the same curve of subspaces, expressed in terms of the first basis.
///
/// # Domain
/// The principal angles between consecutive control points must be below `pi/2`. Then so are those between all
/// intermediate points in `[0, 1]`, since the largest principal angle is a distance in which geodesics are shortest,
/// and the curve is analytic. Outside `[0, 1]` it is defined until a principal angle reaches `pi/2`.
///
/// # Accuracy
/// Orthonormal to `8e-15 k`, and independent of the given bases to 1e-12, asserted in `tests/subspaces/polynomial.rs`.
/// Near principal angles of `pi/2` these errors are divided by the least cosine, which must be above 1e-10.
/// # Cost
/// The bases are computed when the curve is built; afterwards, evaluating a point means evaluating a polynomial of
/// degree 21.
/// # Source
/// Park, Ravani (1995); Qiu, Zhang, Li (2005), "Unitarily invariant metrics on the Grassmann space", SIAM J. Matrix
/// Anal. Appl. 27, 507-531 (the largest principal angle as a distance).
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::{Curve, Interrupt, SubspacePolynomial};
/// // Lines of the plane: the angle is the polynomial with the control points 0, 1, 1.5, whichever way the bases point.
/// let points: [Mat<f64>; 3] = [0.0_f64, 1.0, 1.5].map(|a| mat![[a.cos()], [a.sin()]]);
/// let opposite = -&points[1];
/// let views = [points[0].as_ref(), opposite.as_ref(), points[2].as_ref()];
/// let curve = SubspacePolynomial::new(&views, Interrupt::NEVER)?;
/// let angle = 2.0 * 0.5 * 0.5 * 1.0 + 0.25 * 1.5_f64;
/// assert!((curve.point(0.5)? - mat![[angle.cos()], [angle.sin()]]).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SubspacePolynomial {
    /// The control points in the coordinates of the frame.
    points: Vec<Mat<f64>>,
    frame: Option<Mat<f64>>,
    /// The geodesics between consecutive control points, each in terms of the basis at its start.
    legs: Vec<QuasiGeodesic>,
    lift: Lift,
}

impl SubspacePolynomial {
    /// The curve with the given control points, at least two orthonormal bases of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `RightAngle` if a principal angle between consecutive points is `pi/2`;
    /// `Interrupted`.
    pub fn new(points: &[MatRef<'_, f64>], interrupt: Interrupt<'_>) -> Result<Self> {
        let (_, span, low) = span::control_points(points)?;
        let mut problem = EndpointProblem::new(low[0].nrows(), low[0].ncols());
        let legs = low
            .windows(2)
            .map(|pair| Ok(join_spans(pair[0].as_ref(), pair[1].as_ref(), &mut problem)?.0))
            .collect::<Result<_>>()?;
        Self::of_legs(low, span.into_basis(), legs, interrupt)
    }

    /// The cubic from the subspace of `y0` with velocity `v0` to the subspace of `y1` with velocity `v1`, all of shape
    /// `(n, k)`.
    ///
    /// ```math
    /// P_0 = Y_0,\quad P_1 = \exp(Y_0, V_0 / 3),\quad P_2 = \exp(Y_1, -V_1 / 3),\quad P_3 = Y_1
    /// ```
    ///
    /// # Arguments
    /// * `y0`, `y1` - arbitrary orthonormal bases of the subspaces; `v0`, `v1` - horizontal vectors at them, `Y^T V =
    ///   0`
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`; `InvalidArgument` if a third of a velocity turns a direction
    /// by a right angle or more; `RightAngle` if a principal angle between the inner control points is `pi/2`;
    /// `Interrupted`.
    pub fn from_boundary(
        y0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        y1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let manifold = Grassmann::of("S0", y0)?;
        for [(point, y), (vector, v)] in [[("S0", y0), ("V0", v0)], [("S1", y1), ("V1", v1)]] {
            manifold.check_point(point, y, POINT_TOLERANCE)?;
            manifold.check_tangent(vector, y, v, TANGENT_TOLERANCE)?;
        }
        let span = Span::of(&[y0, v0, y1, v1]);
        let [low0, low1] = [y0, y1].map(|y| span.down(y));
        let (first, inner0) = outer_leg("V0", &low0, &span.down(v0))?;
        let (last, inner1) = outer_leg("V1", &low1, &-span.down(v1))?;
        let mut problem = EndpointProblem::new(low0.nrows(), low0.ncols());
        let (middle, _) = join_spans(inner0.as_ref(), inner1.as_ref(), &mut problem)?;
        let points = vec![low0, inner0, inner1, low1];
        let legs = vec![first, middle, last.reversed()?];
        Self::of_legs(points, span.into_basis(), legs, interrupt)
    }

    /// Built from control points and legs in the coordinates of a frame.
    pub(super) fn of_legs(
        points: Vec<Mat<f64>>,
        frame: Option<Mat<f64>>,
        legs: Vec<QuasiGeodesic>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let (r, k) = points[0].shape();
        let lift = Lift::at(0.0, [r, k], Mat::identity(k, k));
        let mut curve = SubspacePolynomial {
            points,
            frame,
            legs,
            lift,
        };
        let mut lift = curve.lift.clone();
        lift.extend_to(1.0, curve.bases(&mut curve.stages()), interrupt)?;
        curve.lift = lift;
        Ok(curve)
    }

    /// The control points, each of shape `(n, k)`; they are lifted from the frame, so they equal the given ones up to
    /// round-off.
    pub fn control_points(&self) -> Vec<Mat<f64>> {
        span::lifted(self.frame.as_ref(), &self.points)
    }

    /// One less than the number of control points.
    pub fn degree(&self) -> usize {
        self.legs.len()
    }

    #[cfg(any(feature = "python", feature = "serde"))]
    pub(super) fn legs(&self) -> &[QuasiGeodesic] {
        &self.legs
    }

    /// The control points in the coordinates of the frame.
    #[cfg(any(feature = "python", feature = "serde"))]
    pub(super) fn reduced(&self) -> (Option<MatRef<'_, f64>>, &[Mat<f64>]) {
        (self.frame(), &self.points)
    }

    fn shape(&self) -> [usize; 2] {
        self.points[0].shape().into()
    }

    fn stages(&self) -> Stages {
        Stages::new(Quotient::Subspaces, self.shape(), self.degree())
    }

    /// Smooth bases of the points, with the first derivative.
    fn bases<'a>(
        &'a self,
        stages: &'a mut Stages,
    ) -> impl FnMut(f64, &mut MatrixJet) -> Result<f64> + 'a {
        move |t, out| {
            stages.compute(&self.legs, t, 1)?;
            out.copy_from(stages.value(), 1);
            Ok(stages.least_cosine())
        }
    }

    /// Writes the basis at any parameter.
    fn basis_into(&self, t: f64, work: &mut SubspaceWorkspace, out: MatMut<'_, f64>) -> Result<()> {
        check_parameter(t)?;
        if (0.0..=1.0).contains(&t) {
            self.lift.basis_into(t, out);
            return Ok(());
        }
        let SubspaceWorkspace {
            stages, outside, ..
        } = work;
        let lift = outside[usize::from(t > 1.0)].get_or_insert_with(|| match t > 1.0 {
            true => self.lift.beyond(),
            false => Lift::at(0.0, self.shape(), Mat::identity(self.k(), self.k())),
        });
        lift.extend_to(t, self.bases(stages), Interrupt::NEVER)?;
        lift.basis_into(t, out);
        Ok(())
    }
}

/// The geodesic from `y` with velocity `v / 3`, and its end.
///
/// # Errors
/// `InvalidArgument` unless it is the shortest geodesic to its end.
fn outer_leg(name: &'static str, y: &Mat<f64>, v: &Mat<f64>) -> Result<(QuasiGeodesic, Mat<f64>)> {
    let leg = leave_span(y.as_ref(), (v * Scale(1.0 / 3.0)).as_ref())?;
    let angle = leg.angles().iter().fold(0.0, |a: f64, b| a.max(*b));
    if angle >= FRAC_PI_2 {
        return Err(Error::InvalidArgument {
            name,
            requirement: "short enough that a third of it turns every direction by less than a right angle",
            found: 3.0 * angle,
        });
    }
    let end = leg.point(1.0)?;
    Ok((leg, end))
}

impl Curve for SubspacePolynomial {
    type Workspace = SubspaceWorkspace;

    fn n(&self) -> usize {
        span::rows(self.frame.as_ref(), &self.points)
    }

    fn k(&self) -> usize {
        self.points[0].ncols()
    }

    fn quotient(&self) -> Quotient {
        Quotient::Subspaces
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.frame.as_ref().map(|frame| frame.as_ref())
    }

    fn workspace(&self) -> SubspaceWorkspace {
        let ([r, k], square) = (self.shape(), || MatrixJet::zeros(self.k(), self.k()));
        SubspaceWorkspace {
            stages: self.stages(),
            outside: [None, None],
            basis: Mat::zeros(r, k),
            rates: square(),
            turn: square(),
        }
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut SubspaceWorkspace,
        out: &mut MatrixJet,
    ) -> Result<()> {
        if order == 0 {
            return self.basis_into(t, work, out.c[0].as_mut());
        }
        let mut basis = std::mem::replace(&mut work.basis, Mat::new());
        let found = self.basis_into(t, work, basis.as_mut());
        work.basis = basis;
        found?;
        work.stages.compute(&self.legs, t, order)?;
        work.turn(order);
        out.set_product(work.stages.value(), &work.turn, order);
        Ok(())
    }

    fn positions_into(
        &self,
        t: &[f64],
        work: &mut SubspaceWorkspace,
        _: &mut Option<MatrixJet>,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let k = self.k();
        for (i, &t) in t.iter().enumerate() {
            self.basis_into(t, work, out.rb_mut().subcols_mut(i * k, k))?;
        }
        Ok(())
    }
}

/// Buffers for evaluating a curve of subspaces, and its continuation on both sides.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::{Curve, SubspacePolynomial, curve::subspace_polynomial::SubspaceWorkspace};
/// use stiefel_rs::linalg::jet::MatrixJet;
/// let points: [Mat<f64>; 2] = [0.0_f64, 0.5].map(|a| mat![[a.cos()], [a.sin()]]);
/// let curve = SubspacePolynomial::try_from(&points[..])?;
/// let (mut work, mut jet): (SubspaceWorkspace, MatrixJet) = (curve.workspace(), MatrixJet::zeros(2, 1));
/// for t in [-1.0, 0.5, 2.0_f64] {
///     curve.coordinates_into(t, 1, &mut work, &mut jet)?;
///     assert!((&jet.c[0] - mat![[(0.5 * t).cos()], [(0.5 * t).sin()]]).norm_l2() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct SubspaceWorkspace {
    stages: Stages,
    /// Continuations backwards from 0, and forwards from 1.
    outside: [Option<Lift>; 2],
    basis: Mat<f64>,
    /// `F^T F'`.
    rates: MatrixJet,
    /// `R` of the horizontal basis `F R`.
    turn: MatrixJet,
}

impl SubspaceWorkspace {
    /// `R` from the basis at the parameter, and its Taylor coefficients from `R' = -F^T F' R`.
    fn turn(&mut self, order: usize) {
        let f = self.stages.value();
        mul_into(&mut self.turn.c[0], 1.0, f.c[0].transpose(), &self.basis);
        for j in 0..order {
            let rate = &mut self.rates.c[j];
            rate.fill(0.0);
            for i in 0..=j {
                let slope = &f.c[j - i + 1];
                mul_add(&mut *rate, (j - i + 1) as f64, f.c[i].transpose(), slope);
            }
            let (known, next) = self.turn.c.split_at_mut(j + 1);
            next[0].fill(0.0);
            for i in 0..=j {
                let factor = -1.0 / (j + 1) as f64;
                mul_add(&mut next[0], factor, &self.rates.c[i], &known[j - i]);
            }
        }
    }
}

/// For an array of control points.
impl TryFrom<&[Mat<f64>]> for SubspacePolynomial {
    type Error = Error;

    fn try_from(points: &[Mat<f64>]) -> Result<Self> {
        let points: Vec<_> = points.iter().map(|point| point.as_ref()).collect();
        Self::new(&points, Interrupt::NEVER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(angle: f64) -> Mat<f64> {
        Mat::from_fn(2, 1, |i, _| if i == 0 { angle.cos() } else { angle.sin() })
    }

    /// Near pi/2 the bases have a singularity at that distance from the interval.
    #[test]
    fn few_pieces_are_needed() {
        for (step, bound) in [(0.5, 1), (1.0, 2), (1.5, 8), (1.57, 24)] {
            let points: Vec<_> = (0..4).map(|i| line(step * f64::from(i))).collect();
            let curve = SubspacePolynomial::try_from(&points[..]).unwrap();
            let found = curve.lift.len();
            assert!(found <= bound, "{found} pieces for legs of {step}");
        }
    }
}
