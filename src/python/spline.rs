//! Splines of the binding: curves through many points.

use super::kept::Kept;
use super::knots::{BcType, GivenEnds, restore_ends, store_ends};
use super::piecewise::{
    Cubics, KINDS, PIECES, PyPiecewiseCurve, Spline, SplineData, VELOCITIES, outside, put,
};
use super::points::Points;
use super::prelude::*;
use super::stored::{Form, form};
use super::velocities::Velocities;
use crate::cubic::BoundaryOptions;
use crate::linalg::simd::ON_ONE_THREAD;
use crate::space::Quotient;
use crate::spline::{
    SplineDerivative, SplineOptions, cubic_hermite, cubic_spline, geometric_hermite,
    geometric_spline, geometric_subspace_hermite, geometric_subspace_spline,
};

/// Curve through points with given velocities, continuously differentiable.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     At least two increasing times.
/// S : array_like, shape (N, n, k)
///     Points with orthonormal columns.
/// V : array_like, shape (N, n, k), or str
///     Tangent vectors at the points: velocities per unit of ``t``. A string names a method of
///     :func:`estimate_velocities`: ``"catmull-rom"``, ``"akima"`` or ``"natural"``.
/// kind : "riemannian" or "geometric", default "riemannian"
///     Pieces: Riemannian cubics, or geometric cubics, which other programs can evaluate from control points by de
///     Casteljau's algorithm. On small manifolds geometric cubics take longer to construct.
/// extrapolate : bool, default False
///     If True, the first and the last piece are continued outside ``[t[0], t[-1]]``; by default such times raise.
/// num_threads : int, optional
///     Number of threads; by default the size of the global pool.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
///     start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Raises
/// ------
/// InvalidInputError
///     Mismatched shapes or numbers of knots, non-finite entries, times that do not increase, points not orthonormal,
///     vectors not tangent (with the measured defect). Names the knot; carries ``knot``.
/// OutsideDomainError
///     No curve joins two consecutive points; carries ``knot``, the index of the first, and ``angle``.
/// ConvergenceError
///     No Riemannian cubic was found between two consecutive points; carries ``knot`` and ``report``.
/// TypeError
///     ``t`` is complex, or holds dates or durations.
///
/// See Also
/// --------
/// CubicSpline : twice continuously differentiable curve through points alone.
///
/// Notes
/// -----
/// The pieces are constructed independently of each other, in parallel.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import CubicHermite
/// >>> t = np.array([0.0, 1.0, 3.0])
/// >>> S = np.array([[[np.cos(a)], [np.sin(a)]] for a in t / 4])
/// >>> V = np.array([[[-np.sin(a)], [np.cos(a)]] for a in t / 4]) / 4
/// >>> curve = CubicHermite(t, S, V)
/// >>> bool(np.allclose(curve(2.0).ravel(), [np.cos(0.5), np.sin(0.5)]))
/// True
#[pyclass(name = "CubicHermite", module = "stiefel_rs", extends = PyPiecewiseCurve, frozen)]
pub struct PyCubicHermite {
    /// Velocities at the knots, as given or estimated, shape (N, n, k); read-only.
    #[pyo3(get)]
    velocities: Owned,
}

#[pymethods]
impl PyCubicHermite {
    #[new]
    #[pyo3(signature = (t, S, V, kind="riemannian", *, extrapolate=false, num_threads=None, manifold=None, project=false))]
    fn new(
        t: &Any,
        S: &Any,
        V: &Any,
        kind: &str,
        extrapolate: bool,
        num_threads: Option<i64>,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (py, points) = (t.py(), Points::read(manifold, project)?);
        let geometric = is_second("kind", kind, KINDS)?;
        let field = points.field([S, V])?;
        let data = SplineData::read(t, S, &points, field)?;
        let quotient = points.quotient;
        let velocities = Velocities::read(V, &points, &data.points)?;
        let call = data.call(py, num_threads)?;
        let (spline, velocities) = call.run(move |interrupt| {
            let (t, points) = (&data.t, data.points.views());
            let given = velocities.vectors(t, &points, quotient)?;
            let vectors: Vec<_> = given.iter().map(Mat::as_ref).collect();
            let outside = outside(extrapolate);
            let cubics = match (geometric, quotient) {
                (false, _) => {
                    let options = BoundaryOptions {
                        quotient,
                        field,
                        ..BoundaryOptions::default()
                    };
                    let curve = cubic_hermite(t, &points, &vectors, &options, interrupt)?;
                    Cubics::Riemannian(Arc::new(curve.with_outside(outside)))
                }
                (true, Quotient::Frames) => {
                    let curve = geometric_hermite(t, &points, &vectors)?;
                    Cubics::Geometric(Arc::new(curve.with_outside(outside)))
                }
                (true, Quotient::Subspaces) => {
                    let curve = geometric_subspace_hermite(t, &points, &vectors, interrupt)?;
                    Cubics::GeometricOfSubspaces(Arc::new(curve.with_outside(outside)))
                }
            };
            let given = Array::stacked(&[given.len()], &given, data.shape());
            let report = None;
            Ok((
                Spline {
                    cubics,
                    data,
                    report,
                },
                given,
            ))
        })?;
        let velocities = field.vectors(velocities)?.frozen(py)?;
        Ok(spline.wrap(py)?.add_subclass(PyCubicHermite { velocities }))
    }

    /// All numbers of the curve, for files and pickles.
    fn _stored<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let (py, base) = (slf.py(), slf.as_super().get());
        let field = slf.as_super().as_super().get().field;
        let mut fields = base.stored(py, field)?;
        put(py, field, &mut fields, VELOCITIES, &slf.get().velocities)?;
        let form = form(py, Self::NAME, field, fields)?;
        form.set_item(PIECES, base.kind())?;
        Ok(form)
    }
}

impl PyCubicHermite {
    pub(super) fn with(velocities: Owned) -> Self {
        PyCubicHermite { velocities }
    }

    pub(super) fn restored(py: Python<'_>, mut form: Form) -> PyResult<Py<PyAny>> {
        let geometric = is_second("kind", &form.word(PIECES)?, KINDS)?;
        let field = form.field;
        let (spline, velocities) = form.read(py, move |fields, interrupt| {
            let velocities = fields.take(VELOCITIES)?;
            let spline = Spline::restored(fields, field, geometric, interrupt)?;
            let velocities = spline.velocities(velocities, interrupt)?;
            Ok((spline, velocities))
        })?;
        let velocities = field.vectors(velocities.into_array())?.frozen(py)?;
        let class = PyCubicHermite { velocities };
        object(py, spline.wrap(py)?.add_subclass(class))
    }
}

/// Spline of cubics through points, with continuous velocity and covariant acceleration.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     At least two increasing times.
/// S : array_like, shape (N, n, k)
///     Points with orthonormal columns.
/// bc_type : str or pair, default "natural"
///     End conditions: ``"natural"``, zero covariant acceleration; ``"clamped"``, zero velocity; ``"periodic"``, the
///     last point equals the first, and velocity and covariant acceleration agree there. Or a pair of conditions for
///     the first and the last point: each ``"natural"``, ``"clamped"``, ``(1, V)`` with a velocity or ``(2, A)`` with a
///     covariant acceleration, tangent vectors of shape (n, k).
/// kind : "riemannian" or "geometric", default "riemannian"
///     Pieces: Riemannian cubics, for which the cost is stationary, or geometric cubics (adjusted de Casteljau), whose
///     cost is close to it. A geometric spline is found in about a twentieth of the time on St(20, 4), but takes about
///     3, 6 and 10 times as long on the sphere, St(3, 2) and St(3, 3). Evaluation takes longer: 5 times on St(3, 3).
/// extrapolate : bool, default False
///     If True, the first and the last piece are continued outside ``[t[0], t[-1]]``; by default such times raise.
/// tol : float, default 1e-12
///     Largest distance between the end of a piece and its knot, and largest jump of the covariant acceleration, with
///     the duration of the piece as the unit of time; where a descent finds the spline, that of the parts of the piece.
/// max_iterations : int, default 200
///     Largest number of steps, not counting descents. More than 200 raise the work limit, about two seconds, in
///     proportion.
/// tension : float, default 0.0
///     Weight of the squared velocity, for Riemannian pieces: the integral of ``|A|^2 + tension |V|^2`` is stationary,
///     and for large values the curve is close to geodesics between the points. In units of ``1 / t^2``, at least 0,
///     and at most 64 divided by the square of the longest interval between knots, since an error at its start grows as
///     ``exp(sqrt(tension) t)``. If the columns of all points span more than ``max(12, 4 k)`` dimensions, the limit is
///     6.25 instead of 64.
/// num_threads : int, optional
///     Number of threads; by default the size of the global pool.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
///     start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Raises
/// ------
/// InvalidInputError
///     Mismatched shapes or numbers of knots, non-finite entries, times that do not increase, points not orthonormal,
///     vectors not tangent (with the measured defect), periodic data that do not close, ``tension`` out of range. Names
///     the knot; carries ``knot``.
/// OutsideDomainError
///     No curve, or no unique shortest one, joins two consecutive points; carries ``knot``, the index of the first, and
///     ``angle``.
/// ConvergenceError
///     No spline was found; carries ``report``, and ``knot`` if the interval after it is much longer than a neighbour
///     and the curve would be fast there.
/// TypeError
///     ``t`` is complex, or holds dates or durations.
///
/// See Also
/// --------
/// CubicHermite : curve through points with given velocities.
///
/// Notes
/// -----
/// With Riemannian pieces the integral of the squared covariant acceleration is stationary among the curves through the
/// points with these end conditions, as for cubic splines in flat space. All pieces are solved for at once, in time
/// linear in their number.
///
/// Noakes, Heinzinger, Paden (1989); Crouch, Silva Leite (1995).
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import CubicSpline
/// >>> from scipy.interpolate import CubicSpline as Flat
/// >>> t, angle = np.arange(5.0), np.array([0.0, 0.4, 1.0, 0.7, 0.2])
/// >>> curve = CubicSpline(t, np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None])
/// >>> flat = Flat(t, angle, bc_type="natural")
/// >>> bool(np.allclose(curve(2.5).ravel(), [np.cos(flat(2.5)), np.sin(flat(2.5))]))
/// True
#[pyclass(name = "CubicSpline", module = "stiefel_rs", extends = PyPiecewiseCurve, frozen)]
pub struct PyCubicSpline {
    /// End conditions as given: a string or a pair; arrays are read-only.
    #[pyo3(get)]
    pub(super) bc_type: Py<PyAny>,
    pub(super) derivative: Kept<SplineDerivative>,
}

impl PyCubicSpline {
    /// With end conditions as given.
    pub(super) fn of_ends(bc_type: Py<PyAny>) -> Self {
        PyCubicSpline {
            bc_type,
            derivative: Kept::default(),
        }
    }
}

#[pymethods]
impl PyCubicSpline {
    #[new]
    #[pyo3(signature = (
        t, S, bc_type=BcType::default(), kind="riemannian", *, extrapolate=false, tol=1e-12, max_iterations=200,
        tension=0.0, num_threads=None, manifold=None, project=false
    ), text_signature = "(t, S, bc_type='natural', kind='riemannian', *, extrapolate=False, tol=1e-12, \
        max_iterations=200, tension=0.0, num_threads=None, manifold=None, project=False)")]
    fn new(
        t: &Any,
        S: &Any,
        bc_type: BcType<'_>,
        kind: &str,
        extrapolate: bool,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        tension: f64,
        num_threads: Option<i64>,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (py, points) = (t.py(), Points::read(manifold, project)?);
        let geometric = is_second("kind", kind, KINDS)?;
        let max_iterations = count("max_iterations", max_iterations, 1)?;
        let vectors = bc_type.vectors()?;
        let field = points.field(std::iter::once(S).chain(&vectors))?;
        let mut data = SplineData::read(t, S, &points, field)?;
        if bc_type.is_periodic() {
            points.close(&mut data.points);
        }
        let quotient = points.quotient;
        let GivenEnds {
            given: bc_type,
            conditions,
        } = bc_type.read_at(py, &data.points, &points)?;
        let is_distributed = geometric || data.points.len() > ON_ONE_THREAD;
        let call = data.call(py, num_threads)?.distributed(is_distributed);
        let spline = call.run(move |interrupt| {
            let options = SplineOptions {
                tolerance: tol,
                max_iterations,
                tension,
                quotient,
                field,
            };
            let (t, points) = (&data.t, data.points.views());
            let outside = outside(extrapolate);
            let (cubics, report) = match (geometric, quotient) {
                (false, _) => {
                    let (curve, report) =
                        cubic_spline(t, &points, &conditions, &options, interrupt)?;
                    let curve = Arc::new(curve.with_outside(outside));
                    (Cubics::Riemannian(curve), report)
                }
                (true, Quotient::Frames) => {
                    let (curve, report) =
                        geometric_spline(t, &points, &conditions, &options, interrupt)?;
                    let curve = Arc::new(curve.with_outside(outside));
                    (Cubics::Geometric(curve), report)
                }
                (true, Quotient::Subspaces) => {
                    let solve = geometric_subspace_spline;
                    let (curve, report) = solve(t, &points, &conditions, &options, interrupt)?;
                    let curve = Arc::new(curve.with_outside(outside));
                    (Cubics::GeometricOfSubspaces(curve), report)
                }
            };
            let report = Some(report);
            Ok(Spline {
                cubics,
                data,
                report,
            })
        })?;
        Ok(spline
            .wrap(py)?
            .add_subclass(PyCubicSpline::of_ends(bc_type)))
    }

    /// All numbers of the curve, for files and pickles.
    fn _stored<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let (py, base) = (slf.py(), slf.as_super().get());
        let field = slf.as_super().as_super().get().field;
        let form = form(py, Self::NAME, field, base.stored(py, field)?)?;
        form.set_item(PIECES, base.kind())?;
        store_ends(slf.get().bc_type.bind(py), field, &form)?;
        Ok(form)
    }
}

impl PyCubicSpline {
    pub(super) fn restored(py: Python<'_>, mut form: Form) -> PyResult<Py<PyAny>> {
        let geometric = is_second("kind", &form.word(PIECES)?, KINDS)?;
        let (field, ends) = (form.field, restore_ends(py, &mut form)?);
        let spline = form.read(py, move |fields, stop| {
            Spline::restored(fields, field, geometric, stop)
        })?;
        let bc_type = ends.read(py, field, spline.data.shape())?.given;
        let class = PyCubicSpline::of_ends(bc_type);
        object(py, spline.wrap(py)?.add_subclass(class))
    }
}
