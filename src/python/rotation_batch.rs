//! Batches of splines of rotations, whose members are distributed among threads.

use nalgebra::{UnitQuaternion, Vector3};

use super::knots::BcType;
use super::piecewise::{Cubics, Spline, SplineData, outside};
use super::prelude::*;
use super::rotation_curve::{How, PyRotationCurve, SolveInput};
use super::rotation_data::{ends, keyframes, times_of_members};
use super::smoothing::Fit;
use super::spline::PyCubicHermite;
use super::state::check_finite;
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::rotation::{RotationSpline, frame, tangent};
use crate::spline::{Outside, Piecewise, SmoothingOptions};
use crate::threads;

/// Microseconds for each keyframe of a spline, of a curve with given rates, and of a smoothing spline.
const SOLVED: f64 = 3.0;
const JOINED: f64 = 45.0;
const SMOOTHED: f64 = 50.0;

/// Microseconds to build the polynomial of a leg, and to evaluate it once.
const BUILT: f64 = 2.0;
const SAMPLED: f64 = 0.1;

/// Work of a microsecond.
const WORK: f64 = 10.0;

/// Arguments that all members share, and those that they also share if they share times, which set a limit to them:
/// errors about them name no member.
const SHARED: [&str; 2] = ["weights", "tolerance"];
const SHARED_WITH_TIMES: [&str; 3] = ["t", "lam", "tension"];

/// Times and rotations of the members of a batch.
struct RotationMembers {
    /// One row for all members, or one each.
    t: Vec<f64>,
    is_shared: bool,
    rotations: Vec<UnitQuaternion<f64>>,
    quaternions: Vec<f64>,
    knots: usize,
    /// Number of members; if it is zero, there is one with equal rotations, which validates the options.
    count: usize,
    /// Whether errors name the member.
    is_named: bool,
}

/// One of them.
#[derive(Clone, Copy)]
struct RotationMember<'a> {
    index: usize,
    t: &'a [f64],
    rotations: &'a [UnitQuaternion<f64>],
}

impl RotationMembers {
    /// Reads times, shape `(N,)` or `(M, N)`, and quaternions, shape `(M, N, 4)`.
    fn read(t: &Any, quaternions: &Any, is_named: bool) -> PyResult<Self> {
        let (shape, mut quaternions) = read_axes::<3>(quaternions, "quaternions", "(M, N, 4)")?;
        let [count, knots, _] = shape;
        let mut rotations = keyframes(&shape, &quaternions)?;
        let (mut t, mut is_shared) = times_of_members(t, [count, knots])?;
        if count == 0 {
            rotations = vec![UnitQuaternion::identity(); knots];
            quaternions = [0.0, 0.0, 0.0, 1.0].repeat(knots);
            if !is_shared {
                (t, is_shared) = ((0..knots).map(|i| i as f64).collect(), true);
            }
        }
        Ok(RotationMembers {
            t,
            is_shared,
            rotations,
            quaternions,
            knots,
            count,
            is_named,
        })
    }

    fn of(&self, index: usize) -> RotationMember<'_> {
        let rows = index * self.knots..(index + 1) * self.knots;
        RotationMember {
            index,
            t: if self.is_shared {
                &self.t
            } else {
                &self.t[rows.clone()]
            },
            rotations: &self.rotations[rows],
        }
    }

    /// Number of members to solve for.
    fn solved(&self) -> usize {
        self.count.max(1)
    }

    /// What each member gives, in about so many microseconds for each of its keyframes.
    fn each<T: Send + 'static>(
        self,
        py: Python<'_>,
        num_threads: Option<i64>,
        micros: f64,
        one: impl Fn(RotationMember<'_>, Interrupt<'_>) -> Result<T> + Send + Sync + 'static,
    ) -> PyResult<Vec<T>> {
        let (count, solved, is_named) = (self.count, self.solved(), self.is_named);
        let is_shared = self.is_shared;
        let all = (solved * self.knots) as f64 * micros;
        let call = Call::new(py, num_threads, WORK * all)?
            .uncertain()
            .distributed(all > threads::ALONE);
        let found = call.run_any(move |interrupt| {
            let each = micros * self.knots as f64;
            let one =
                |(): &mut (), i: usize| one(self.of(i), interrupt).map_err(|error| (i, error));
            threads::map(solved, each, || (), one)
        })?;
        let found = found.map_err(|(i, error)| match argument(&error) {
            // Without members there is no problem that could be too hard.
            None if count == 0 => None,
            Some(name) if SHARED.contains(&name) => Some(error.into()),
            Some(name) if is_shared && SHARED_WITH_TIMES.contains(&name) => Some(error.into()),
            _ if !is_named => Some(error.into()),
            _ => Some(at_member(&error, i, &[count])),
        });
        let mut found = match found {
            Err(Some(error)) => return Err(error),
            found => found.unwrap_or_default(),
        };
        found.truncate(count);
        Ok(found)
    }
}

/// The argument that an error is about.
fn argument(error: &Error) -> Option<&'static str> {
    match error.cause() {
        Error::Shape { name, .. }
        | Error::NonFinite { name, .. }
        | Error::InvalidArgument { name, .. } => Some(name),
        _ => None,
    }
}

/// Splines through the rotations of many members, as :class:`RotationCurve` makes one.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,) or (M, N)
///     Times in seconds, shared by all curves or one row per curve.
/// quaternions : array_like, shape (M, N, 4)
///     Rotations as quaternions, scalar last, of any nonzero length.
/// bc_type : str or pair, default "natural"
///     End conditions of all curves, as for :class:`RotationCurve`.
/// tol, max_iterations, tension, extrapolate, num_threads
///     As for :class:`RotationCurve`.
///
/// Returns
/// -------
/// list of RotationCurve
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError, ConvergenceError
///     As for :class:`RotationCurve`, for the first curve that fails; the message names it.
#[pyfunction]
#[pyo3(signature = (
    t, quaternions, bc_type=BcType::default(), *, tol=1e-12, max_iterations=200, tension=0.0, extrapolate=true, num_threads=None
), text_signature = "(t, quaternions, bc_type='natural', *, tol=1e-12, max_iterations=200, tension=0.0, \
    extrapolate=True, num_threads=None)")]
pub fn interpolated_rotations(
    t: &Any,
    quaternions: &Any,
    bc_type: BcType<'_>,
    tol: f64,
    #[pyo3(from_py_with = whole)] max_iterations: i64,
    tension: f64,
    extrapolate: bool,
    num_threads: Option<i64>,
) -> PyResult<Vec<PyRotationCurve>> {
    let py = t.py();
    let how = How::new(tol, max_iterations, tension, extrapolate)?;
    let members = RotationMembers::read(t, quaternions, true)?;
    let (solved, knots) = (members.solved(), members.knots);
    let mut conditions = Vec::with_capacity(solved);
    let mut given = Vec::with_capacity(solved);
    for member in 0..solved {
        let ends = ends(py, &bc_type, members.of(member).rotations)?;
        let quaternions = members.quaternions[4 * knots * member..][..4 * knots].to_vec();
        given.push(SolveInput::new(py, quaternions, &bc_type, ends.given, how)?);
        conditions.push(ends.conditions);
    }
    let splines = members.each(py, num_threads, SOLVED, move |member, interrupt| {
        let RotationMember {
            index,
            t,
            rotations,
        } = member;
        let options = how.options();
        RotationSpline::with_conditions(t, rotations, &conditions[index], &options, interrupt)
    })?;
    let wrap = |(spline, given)| PyRotationCurve::of(py, spline, Some(given), None);
    splines.into_iter().zip(given).map(wrap).collect()
}

/// Curves through rotations with given rates; once continuously differentiable.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,) or (M, N)
///     Times in seconds, shared by all curves or one row per curve.
/// quaternions : array_like, shape (M, N, 4)
///     Rotations as quaternions, scalar last, of any nonzero length.
/// rates : array_like, shape (M, N, 3)
///     Rates in the body frame, in rad/s.
/// named : bool
///     Whether errors name the curve that fails.
/// extrapolate, num_threads
///     As for :class:`RotationCurve`.
///
/// Returns
/// -------
/// list of RotationCurve
///     With :class:`CubicHermite` as ``curve``.
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError, ConvergenceError
///     As for :class:`RotationCurve`. For half turns whose direction the rates do not decide, ``OutsideDomainError``.
#[pyfunction]
#[pyo3(signature = (t, quaternions, rates, *, named, extrapolate, num_threads))]
pub fn rotations_with_rates(
    t: &Any,
    quaternions: &Any,
    rates: &Any,
    named: bool,
    extrapolate: bool,
    num_threads: Option<i64>,
) -> PyResult<Vec<PyRotationCurve>> {
    let py = t.py();
    let members = RotationMembers::read(t, quaternions, named)?;
    let ([count, knots, size], rates) = read_axes::<3>(rates, "rates", "(M, N, 3)")?;
    if [count, knots, size] != [members.count, members.knots, 3] {
        let expected = tuple(&[members.count, members.knots, 3]);
        return Err(unexpected("rates", &expected, &[count, knots, size]));
    }
    let mut rates: Vec<Vector3<f64>> = rates
        .chunks_exact(3)
        .map(Vector3::from_column_slice)
        .collect();
    rates.resize(members.solved() * knots, Vector3::zeros());
    let curves = members.each(py, num_threads, JOINED, move |member, interrupt| {
        let RotationMember {
            index,
            t,
            rotations,
        } = member;
        let rates = &rates[index * knots..][..knots];
        let options = BoundaryOptions::default();
        let spline = RotationSpline::hermite(t, rotations, rates, &options, interrupt)?;
        let frames: Vec<_> = rotations.iter().map(frame).collect();
        let vectors: Vec<_> = rotations
            .iter()
            .zip(rates)
            .map(|(q, w)| tangent(q, w))
            .collect();
        let [points, velocities] =
            [frames, vectors].map(|all| Array::stacked(&[knots], &all, (3, 3)));
        Ok((spline, points, velocities))
    })?;
    let wrap = |(spline, points, velocities): (RotationSpline, Array, Array)| {
        let curve = Spline {
            cubics: Cubics::Riemannian(Arc::new(continued(&spline, extrapolate))),
            data: SplineData {
                t: spline.knots().to_vec(),
                points: Batch::of([knots, 3, 3], points.entries, Field::Real),
            },
            report: None,
        };
        let class = PyCubicHermite::with(velocities.frozen(py)?);
        let curve = object(py, curve.wrap(py)?.add_subclass(class))?;
        PyRotationCurve::of(py, spline, None, Some(curve))
    };
    curves.into_iter().map(wrap).collect()
}

/// Smoothing splines near rotations.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,) or (M, N)
///     Times in seconds, not decreasing, shared by all curves or one row per curve.
/// quaternions : array_like, shape (M, N, 4)
///     Rotations as quaternions, scalar last, of any nonzero length.
/// weights : array_like, shape (N,), optional
///     As for :class:`SmoothingSpline`; the same for all curves.
/// lam, tol, max_iterations, extrapolate, num_threads
///     As for :class:`SmoothingSpline`.
/// named : bool
///     Whether errors name the curve that fails.
///
/// Returns
/// -------
/// list of RotationCurve
///     With :class:`SmoothingSpline` as ``curve``.
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError, ConvergenceError
///     As for :class:`SmoothingSpline`.
#[pyfunction]
#[pyo3(signature = (t, quaternions, weights, lam, *, named, tol, max_iterations, extrapolate, num_threads))]
pub fn smoothed_rotations(
    t: &Any,
    quaternions: &Any,
    weights: Option<&Any>,
    lam: Option<f64>,
    named: bool,
    tol: f64,
    #[pyo3(from_py_with = whole)] max_iterations: i64,
    extrapolate: bool,
    num_threads: Option<i64>,
) -> PyResult<Vec<PyRotationCurve>> {
    let py = t.py();
    let max_iterations = count("max_iterations", max_iterations, 1)?;
    let members = RotationMembers::read(t, quaternions, named)?;
    let weights = weights
        .map(|object| read_axes(object, "weights", "(N,)"))
        .transpose()?;
    let weights: Option<Vec<f64>> = weights.map(|([_], weights)| weights);
    check_finite("weights", weights.as_deref().unwrap_or(&[]))?;
    let curves = members.each(py, num_threads, SMOOTHED, move |member, interrupt| {
        let options = SmoothingOptions {
            lambda: lam,
            tolerance: tol,
            max_iterations,
            ..SmoothingOptions::default()
        };
        let frames: Vec<_> = member.rotations.iter().map(frame).collect();
        let points: Vec<_> = frames.iter().map(Mat::as_ref).collect();
        let fit = Fit::new(member.t, &points, weights.as_deref(), &options, interrupt)?;
        let curve = fit.fitted.curve.clone().with_outside(Outside::Continued);
        let (start, report) = (member.rotations.first(), fit.fitted.report);
        let spline = RotationSpline::of_curve(Arc::new(curve), start, Some(report))?;
        Ok((spline, fit))
    })?;
    let wrap = |(spline, fit): (RotationSpline, Fit)| {
        let curve = object(py, fit.wrap(py, Field::Real, extrapolate)?)?;
        PyRotationCurve::of(py, spline, None, Some(curve))
    };
    curves.into_iter().map(wrap).collect()
}

/// The curve of matrices of a spline, which continues its end pieces or raises beyond them.
fn continued(spline: &RotationSpline, extrapolate: bool) -> Piecewise<RiemannianCubic> {
    (**spline.curve())
        .clone()
        .with_outside(outside(extrapolate))
}

/// Evaluate many curves at the same times or at times of their own.
///
/// Parameters
/// ----------
/// curves : list of RotationCurve, length M
/// t : array_like, shape (T,) or (M, T)
///     Times in seconds; the end pieces are continued beyond the keyframes.
/// order : {0, 1, 2, 3}
///     0 for unit quaternions, scalar last; 1, 2 and 3 for body rates in rad/s^order.
///
/// Returns
/// -------
/// ndarray, shape (M, T, 4) or (M, T, 3)
#[pyfunction]
pub fn sampled_rotations<'py>(
    curves: Vec<PyRef<'py, PyRotationCurve>>,
    t: &Any<'py>,
    order: usize,
) -> PyResult<Any<'py>> {
    ensure!(order <= 3, "order: expected 0, 1, 2 or 3, found {order}");
    let splines: Vec<_> = curves
        .iter()
        .map(|curve| Arc::clone(&curve.spline))
        .collect();
    let Array { shape, entries: t_ } = read(t, "t")?;
    let (members, count) = (splines.len(), shape.last().copied().unwrap_or(0));
    if shape.len() != 1 && shape != [members, count] {
        return Err(unexpected("t", "(T,) or (M, T)", &shape));
    }
    let sampled = SampledRotations {
        splines,
        t: t_,
        count,
    };
    let width = if order == 0 { 4 } else { 3 };
    let micros = sampled.micros();
    let all = micros * members as f64;
    let call = Call::new(t.py(), None, WORK * all)?.distributed(all > threads::ALONE);
    let found = call.run_any(move |_| match order {
        0 => sampled.values(micros, |spline, t, out: &mut [[f64; 4]]| {
            spline.quaternions_into(t, out)
        }),
        order => sampled.values(micros, |spline, t, out: &mut [[f64; 3]]| {
            spline.rates_into(t, order - 1, out)
        }),
    })?;
    let entries = found.map_err(|(i, error)| at_member(&error, i, &[members]))?;
    let shape = vec![members, count, width];
    Array { shape, entries }.into_bound_py_any(t.py())
}

/// Curves and the times at which they are evaluated.
struct SampledRotations {
    splines: Vec<Arc<RotationSpline>>,
    /// One row for all curves, or one each.
    t: Vec<f64>,
    count: usize,
}

impl SampledRotations {
    /// Microseconds for a curve, on average.
    fn micros(&self) -> f64 {
        let unbuilt = self.splines.iter().filter(|spline| !spline.is_built());
        let legs: usize = unbuilt.map(|spline| spline.knots().len()).sum();
        BUILT * legs as f64 / self.splines.len().max(1) as f64 + SAMPLED * self.count as f64
    }

    /// Values of all curves, or the index of the first that fails.
    fn values<const N: usize>(
        &self,
        micros: f64,
        write: impl Fn(&RotationSpline, &[f64], &mut [[f64; N]]) -> Result<()> + Sync,
    ) -> std::result::Result<Vec<f64>, (usize, Error)> {
        let (members, count) = (self.splines.len(), self.count);
        let mut values = vec![[0.0; N]; members * count];
        let is_shared = self.t.len() == count;
        let one = |(): &mut (), i: usize, out: &mut &mut [[f64; N]]| {
            let t = if is_shared {
                &self.t
            } else {
                &self.t[i * count..][..count]
            };
            write(&self.splines[i], t, out).map_err(|error| (i, error))
        };
        let parts = values.chunks_mut(count.max(1));
        threads::map_parts(parts, micros, || (), one)?;
        Ok(values.into_flattened())
    }
}
