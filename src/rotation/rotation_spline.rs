//! Splines through rotations, as unit quaternions.

use std::fmt;
use std::sync::{Arc, LazyLock, OnceLock};

use faer::MatRef;
use nalgebra::{Quaternion as Coordinates, UnitQuaternion, Vector3};

use super::ends::{RotationEnds, check_closed, frame, in_body, tangent};
use super::half_turns::check_directions;
use super::pieces::{Pieces, of_matrix};
use super::reference_frame::ReferenceFrame;
use super::sampling::{self, Beyond, SamplePlace, check_request};
use super::series::{QuaternionEntries, VectorEntries, dot};
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::curve::{Curve, Quantity};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::legs::{Curves, Ends};
use crate::report::SolverReport;
use crate::space::Quotient;
use crate::spline::{
    EndConditions, Outside, Piecewise, SmoothingOptions, SolvedRotations, SplineOptions,
    check_times, cubic_hermite, cubic_spline_of_legs, near_rotations, smoothing_spline,
};

/// The curve of matrices, computed when it is first asked for.
type LazyCurve = LazyLock<
    Arc<Piecewise<RiemannianCubic>>,
    Box<dyn FnOnce() -> Arc<Piecewise<RiemannianCubic>> + Send>,
>;

/// A curve of rotations through keyframes: twice continuously differentiable, and stationary for the integral of the
/// squared angular acceleration among the curves through the keyframes with the same end conditions.
///
/// It is the [`cubic_spline`](crate::spline::cubic_spline) of the rotation matrices, as points of `St(3, 3)`, in unit
/// quaternions, from which it is also solved if neighbours are at most 1.4 rad apart. Their sign is continuous, and at
/// the first keyframe it is that of the given quaternion. Outside the keyframes' times the first and the last piece are
/// extrapolated.
///
/// A rotation takes vectors of the body frame to the world frame. Angles are in radians and times in any unit, called s
/// here: rates are in rad/s, accelerations in rad/s^2, jerks in rad/s^3.
///
/// The first evaluation builds the polynomials of all legs, two microseconds per leg of a spline through its keyframes
/// and more for other curves; later evaluations between the first and the last keyframe allocate nothing, unless one
/// call takes 4096 or more times (asserted in `tests/allocation.rs`).
///
/// # Accuracy
/// Quaternions have unit length to `2 eps` and are within 8e-13 rad of the keyframes; the curve differs from the curve
/// of matrices by at most 1e-12 (asserted in `tests/rotation_spline.rs`).
///
/// # Examples
/// ```
/// use nalgebra::{UnitQuaternion, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{ReferenceFrame, RotationEnds, RotationSpline};
/// let vectors = [[0.0, 0.0, 0.0], [0.3, -0.2, 0.5], [0.9, 0.1, 0.4], [0.5, 0.6, 0.1]];
/// let keyframes = vectors.map(|v| UnitQuaternion::from_scaled_axis(Vector3::from(v)));
/// let ends = RotationEnds::Natural;
/// let spline = RotationSpline::new(&[0.0, 1.0, 2.5, 3.0], &keyframes, &ends, &Default::default(), Interrupt::NEVER)?;
/// assert!(spline.rotation(2.5)?.angle_to(&keyframes[2]) < 1e-12);
/// // The rate is the derivative of the rotation: R(t + h) = R(t) exp(h w).
/// let (t, h) = (1.7, 1e-4);
/// let rate = spline.angular_velocity(t, ReferenceFrame::Body)?;
/// let moved = (spline.rotation(t - h)?.inverse() * spline.rotation(t + h)?).scaled_axis() / (2.0 * h);
/// assert!((moved - rate).norm() < 1e-7);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct RotationSpline {
    knots: Vec<f64>,
    curve: LazyCurve,
    /// The curves of the legs, if a solver produced them.
    legs: Option<Arc<dyn Curves>>,
    /// Quaternions at the knots; their signs are arbitrary except for the first one.
    rotations: Vec<QuaternionEntries>,
    report: Option<SolverReport>,
    pieces: OnceLock<Pieces>,
}

impl fmt::Debug for RotationSpline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = f.debug_struct("RotationSpline");
        fields.field("knots", &self.knots());
        fields.field("report", &self.report).finish_non_exhaustive()
    }
}

impl RotationSpline {
    /// The spline through rotations at increasing times.
    ///
    /// # Errors
    /// As [`cubic_spline`](crate::spline::cubic_spline). If two neighbours are half a turn apart, two shortest
    /// rotations join them: `AtKnot` with `OutsideLogDomain`, which carries the angle.
    pub fn new(
        t: &[f64],
        rotations: &[UnitQuaternion<f64>],
        ends: &RotationEnds,
        options: &SplineOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let conditions = match rotations {
            [first, .., last] => ends.on_frames([first, last]),
            // Too few rotations: `cubic_spline` raises the error.
            _ => EndConditions::Natural,
        };
        Self::with_conditions(t, rotations, &conditions, options, interrupt)
    }

    /// [`RotationSpline::new`] with the end conditions of `St(3, 3)`.
    ///
    /// # Errors
    /// As [`RotationSpline::new`].
    pub(crate) fn with_conditions(
        t: &[f64],
        rotations: &[UnitQuaternion<f64>],
        ends: &EndConditions,
        options: &SplineOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        options.check()?;
        check_times(t, rotations.len())?;
        check_closed(rotations, ends)?;
        if let Some(body) = in_body(ends, rotations) {
            let mut rotations = rotations.to_vec();
            if let (Ends::Periodic, [first, .., last]) = (&body, &mut rotations[..]) {
                *last = *first;
            }
            if let Some(near) = near_rotations(t, &rotations, &body, options, interrupt)? {
                return Ok(Self::of_near(t, near, rotations));
            }
        }
        let frames: Vec<_> = rotations.iter().map(frame).collect();
        let points: Vec<MatRef<'_, f64>> = frames.iter().map(|frame| frame.as_ref()).collect();
        let (curve, report, legs) = cubic_spline_of_legs(t, &points, ends, options, interrupt)?;
        let curve = curve.with_outside(Outside::Continued);
        let rotations = rotations.iter().map(|q| q.coords.into()).collect();
        let curve = Arc::new(curve);
        Ok(Self::of_legs(curve, legs, rotations, Some(report)))
    }

    /// From the solution of the equations.
    fn of_near(t: &[f64], near: SolvedRotations, rotations: Vec<UnitQuaternion<f64>>) -> Self {
        let (knots, report) = (t.to_vec(), near.report);
        let (legs, entries) = (
            Arc::clone(&near.curves),
            rotations.iter().map(|q| q.coords.into()).collect(),
        );
        let curve = move || {
            let matrices = rotations.iter().map(frame).collect();
            let curve = near.curve(&knots, matrices);
            Arc::new(curve.with_outside(Outside::Continued))
        };
        RotationSpline {
            knots: t.to_vec(),
            curve: LazyLock::new(Box::new(curve)),
            legs: Some(legs),
            rotations: entries,
            report: Some(report),
            pieces: OnceLock::new(),
        }
    }

    /// The spline through rotations with given rates in the body frame, in radians per unit of time (rad/s); once
    /// continuously differentiable.
    ///
    /// Between rotations half a turn apart the rates decide the direction.
    ///
    /// # Errors
    /// As [`cubic_hermite`]; `UndecidedTurn` in `AtKnot` if they do not: add a rotation in between.
    pub fn hermite(
        t: &[f64],
        rotations: &[UnitQuaternion<f64>],
        rates: &[Vector3<f64>],
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        if rates.len() != rotations.len() {
            return Err(Error::Shape {
                name: "rates",
                expected: format!(
                    "({0}, 3), one for each of the {0} rotations",
                    rotations.len()
                ),
                found: format!("({}, 3)", rates.len()),
            });
        }
        let frames: Vec<_> = rotations.iter().map(frame).collect();
        let pairs = rotations.iter().zip(rates);
        let vectors: Vec<_> = pairs.map(|(q, w)| tangent(q, w)).collect();
        let [points, vectors] = [&frames, &vectors].map(|all| {
            let views = all.iter().map(|matrix| matrix.as_ref());
            views.collect::<Vec<MatRef<'_, f64>>>()
        });
        let options = BoundaryOptions {
            quotient: Quotient::Frames,
            ..*options
        };
        let curve = cubic_hermite(t, &points, &vectors, &options, interrupt)?;
        check_directions(t, rotations, rates)?;
        let rotations = rotations.iter().map(|q| q.coords.into()).collect();
        let curve = Arc::new(curve.with_outside(Outside::Continued));
        Ok(Self::of_legs(curve, None, rotations, None))
    }

    /// The smoothing spline near rotations, computed from their matrices: it balances closeness to the rotations
    /// against cost.
    ///
    /// It makes the sum of weight times squared angle between rotation and curve, in rad^2, plus `lambda` times the
    /// [cost](RotationSpline::cost) stationary. `lambda` is in units of time cubed (s^3) if weights are dimensionless,
    /// and in s^3/rad^2 if they are in rad^-2.
    ///
    /// # Errors
    /// As [`smoothing_spline`].
    pub fn smoothing(
        t: &[f64],
        rotations: &[UnitQuaternion<f64>],
        weights: Option<&[f64]>,
        options: &SmoothingOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let frames: Vec<_> = rotations.iter().map(frame).collect();
        let points: Vec<MatRef<'_, f64>> = frames.iter().map(|frame| frame.as_ref()).collect();
        let smooth = smoothing_spline(t, &points, weights, options, interrupt)?;
        let curve = smooth.curve.with_outside(Outside::Continued);
        Self::of_curve(Arc::new(curve), rotations.first(), Some(smooth.report))
    }

    /// The quaternions of a given curve of rotation matrices; the sign at the first knot is that of `start`, if given.
    ///
    /// # Errors
    /// `Shape` unless the curve is on `St(3, 3)`; `InvalidArgument` for reflections; the errors of evaluating the
    /// curve.
    pub fn of_curve(
        curve: Arc<Piecewise<RiemannianCubic>>,
        start: Option<&UnitQuaternion<f64>>,
        report: Option<SolverReport>,
    ) -> Result<Self> {
        let [n, k] = [curve.n(), curve.k()];
        if [n, k] != [3, 3] {
            return Err(Error::Shape {
                name: "curve",
                expected: "a curve on St(3, 3)".to_owned(),
                found: format!("one on St({n}, {k})"),
            });
        }
        let position = Quantity::Derivative(0);
        let points = curve.sample(curve.knots(), position, Interrupt::NEVER)?;
        let at = |knot: usize| points.get(knot);
        let determinant = at(0).determinant();
        if determinant < 0.0 {
            return Err(Error::InvalidArgument {
                name: "curve",
                requirement: "a curve of rotations, of determinant 1",
                found: determinant,
            });
        }
        let rotation = |knot: usize| of_matrix(|i, j| at(knot)[(i, j)]);
        let mut rotations: Vec<QuaternionEntries> =
            (0..curve.knots().len()).map(rotation).collect();
        if let Some(start) = start
            && dot(start.coords.into(), rotations[0]) < 0.0
        {
            rotations[0] = rotations[0].map(|x| -x);
        }
        Ok(Self::of_legs(curve, None, rotations, report))
    }

    fn of_legs(
        curve: Arc<Piecewise<RiemannianCubic>>,
        legs: Option<Arc<dyn Curves>>,
        rotations: Vec<QuaternionEntries>,
        report: Option<SolverReport>,
    ) -> Self {
        let knots = curve.knots().to_vec();
        let curve: LazyCurve = LazyLock::new(Box::new(|| curve));
        RotationSpline {
            knots,
            curve,
            legs,
            rotations,
            report,
            pieces: OnceLock::new(),
        }
    }

    /// The curve of matrices on `St(3, 3)`, for cost, arc length, bounds on rates and covariant derivatives; it may be
    /// computed in the first call.
    pub fn curve(&self) -> &Arc<Piecewise<RiemannianCubic>> {
        &self.curve
    }

    /// The times of the keyframes, in units of time (s).
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The rotations at the knots, from the body frame to the world frame.
    pub fn keyframes(&self) -> impl Iterator<Item = UnitQuaternion<f64>> {
        self.rotations.iter().map(|q| unit(*q))
    }

    /// The integral of the squared angular acceleration between the first and the last keyframe, in radians squared per
    /// unit of time cubed (rad^2/s^3); for a curve in tension, the integral of `|w'|^2 + tau |w|^2`, with `tau` in
    /// 1/s^2. It is the same in the body frame and in the world frame.
    ///
    /// # Errors
    /// `Overflow`, `Interrupted`, and the errors of evaluating the curve.
    pub fn cost(&self, interrupt: Interrupt<'_>) -> Result<f64> {
        self.curve().cost(interrupt)
    }

    /// The report of the spline's solver; `None` if every leg was computed separately.
    pub fn report(&self) -> Option<&SolverReport> {
        self.report.as_ref()
    }

    /// The rotation at a time, from the body frame to the world frame; a unit quaternion, dimensionless.
    ///
    /// # Errors
    /// `NonFinite`; outside the keyframes, the errors of extending the curve.
    pub fn rotation(&self, t: f64) -> Result<UnitQuaternion<f64>> {
        let mut out = [[0.0; 4]];
        self.quaternions_into(&[t], &mut out)?;
        Ok(unit(out[0]))
    }

    /// The angular velocity at a time, in radians per unit of time (rad/s): `w` in the body frame, `R w` in the world
    /// frame.
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`].
    pub fn angular_velocity(&self, t: f64, frame: ReferenceFrame) -> Result<Vector3<f64>> {
        self.vector(t, 0, frame)
    }

    /// The angular acceleration at a time, in radians per unit of time squared (rad/s^2): the derivative of the angular
    /// velocity in the given frame, `w'` in the body frame and `R w'` in the world frame.
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`].
    pub fn angular_acceleration(&self, t: f64, frame: ReferenceFrame) -> Result<Vector3<f64>> {
        self.vector(t, 1, frame)
    }

    /// The angular jerk at a time, in radians per unit of time cubed (rad/s^3): the second derivative `w''` of the body
    /// rate. In the world frame it is `R w''`, whereas the derivative of the angular acceleration there is
    /// `R (w'' + w x w')`. At a knot, where the jerk jumps, it is the value of the following piece.
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`].
    pub fn angular_jerk(&self, t: f64, frame: ReferenceFrame) -> Result<Vector3<f64>> {
        self.vector(t, 2, frame)
    }

    fn vector(&self, t: f64, order: usize, frame: ReferenceFrame) -> Result<Vector3<f64>> {
        let mut out = [[0.0; 3]];
        self.rates_into(&[t], order, &mut out)?;
        let body = Vector3::from(out[0]);
        match frame {
            ReferenceFrame::Body => Ok(body),
            // The rate and its derivative in the world frame: R (w' + w x w) = R w'.
            ReferenceFrame::World => Ok(self.rotation(t)? * body),
        }
    }

    /// Unit quaternions at many times, scalar last, dimensionless; rotations from the body frame to the world frame.
    ///
    /// From 4096 times on, the thread pool shares the work, and memory is allocated.
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`]; `NonFinite` with the index of the time.
    pub fn quaternions_into(&self, t: &[f64], out: &mut [[f64; 4]]) -> Result<()> {
        let pieces = self.pieces();
        self.values_into(t, out, |leg, s| match leg {
            SamplePlace::Leg(leg) => pieces.quaternion(leg, s),
            SamplePlace::Beyond(beyond) => beyond.pieces.quaternion(0, s),
        })
    }

    /// Rates in the body frame, or their derivatives, at many times: `w` in rad/s (order 0), `w'` in rad/s^2 (order 1)
    /// or `w''` in rad/s^3 (order 2), radians per unit of time to the power `order + 1`.
    ///
    /// From 4096 times on, the thread pool shares the work, and memory is allocated.
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`]; `InvalidArgument` (order), `NonFinite` with the index of the time, `Overflow`.
    pub fn rates_into(&self, t: &[f64], order: usize, out: &mut [[f64; 3]]) -> Result<()> {
        if order > 2 {
            return Err(Error::InvalidArgument {
                name: "order",
                requirement: "0, 1 or 2",
                found: order as f64,
            });
        }
        let (pieces, knots) = (self.pieces(), self.knots());
        let length = |leg: usize| knots[leg + 1] - knots[leg];
        let rate = |place: SamplePlace<'_>, s: f64| -> VectorEntries {
            match place {
                SamplePlace::Leg(leg) => pieces.rate(leg, s, length(leg), order),
                SamplePlace::Beyond(beyond) => beyond.pieces.rate(0, s, length(beyond.leg), order),
            }
        };
        self.values_into(t, out, rate)?;
        if out.iter().flatten().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(Error::Overflow {
            quantity: "rate of a spline of rotations",
        })
    }

    fn values_into<const N: usize>(
        &self,
        t: &[f64],
        out: &mut [[f64; N]],
        value: impl Fn(SamplePlace<'_>, f64) -> [f64; N] + Sync,
    ) -> Result<()> {
        check_request(t, out)?;
        sampling::values_into(self.knots(), &self.beyond(t)?, t, out, value)
    }

    /// The first and the last piece, extended to the requested times outside the keyframes.
    fn beyond(&self, t: &[f64]) -> Result<[Option<Beyond>; 2]> {
        let knots = self.knots();
        let legs = knots.len() - 1;
        let [mut earliest, mut latest] = [knots[0], knots[legs]];
        for t in t {
            earliest = earliest.min(*t);
            latest = latest.max(*t);
        }
        let local = |leg: usize, t: f64| (t - knots[leg]) / (knots[leg + 1] - knots[leg]);
        let side = |leg: usize, t: f64, is_needed: bool| -> Result<Option<Beyond>> {
            if !is_needed {
                return Ok(None);
            }
            let (s, piece) = (local(leg, t), &self.curve().pieces()[leg]);
            let longer = piece.restricted(s.min(0.0), s.max(1.0), Interrupt::NEVER)?;
            let mut pieces = Pieces::of_cubic(&longer, self.rotations[leg]);
            // Choose the sign of the leg's quaternion.
            let here = self.pieces().quaternion(leg, 0.5);
            if dot(pieces.quaternion(0, 0.5), here) < 0.0 {
                pieces.change_sign();
            }
            Ok(Some(Beyond { leg, pieces }))
        };
        Ok([
            side(0, earliest, earliest < knots[0])?,
            side(legs - 1, latest, latest > knots[legs])?,
        ])
    }

    /// Whether the polynomials of the legs are known already.
    #[cfg(feature = "python")]
    pub(crate) fn is_built(&self) -> bool {
        self.pieces.get().is_some()
    }

    fn pieces(&self) -> &Pieces {
        self.pieces.get_or_init(|| {
            let series = self.legs.as_ref().and_then(|legs| legs.rotations());
            match series {
                Some(series) => Pieces::of_series(&series, &self.rotations),
                None => Pieces::new(self.curve().pieces(), &self.rotations),
            }
        })
    }
}

/// The rotation of a unit quaternion, scalar last.
fn unit([x, y, z, w]: QuaternionEntries) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Coordinates::new(w, x, y, z))
}
