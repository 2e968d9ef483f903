//! Curves of rotations as unit quaternions, on which Python's splines of rotations and poses are built.

use pyo3::sync::PyOnceLock;

use super::knots::{BcType, GivenEnds, times};
use super::piecewise::{Cubics, PyPiecewiseCurve, Spline, SplineData};
use super::prelude::*;
use super::rotation_data::{ends, keyframes};
use super::spline::PyCubicSpline;
use crate::rotation::{RotationSpline, frame};
use crate::shooting::ROTATIONS_ON_ONE_THREAD;
use crate::spline::{Outside, SplineOptions};

/// Work to solve for a spline, for each of its keyframes.
const WORK_OF_SOLVED: f64 = 30.0;

/// Curve of rotations as unit quaternions: the form that :class:`RotationSpline` evaluates.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     At least two increasing times, in seconds.
/// quaternions : array_like, shape (N, 4)
///     Rotations as quaternions, scalar last, of any nonzero length.
/// bc_type : str or pair, default "natural"
///     ``"natural"``, ``"clamped"``, ``"periodic"`` or a pair of end conditions, each ``"natural"``, ``"clamped"``,
///     ``(1, w)`` with a body rate in rad/s or ``(2, a)`` with its derivative in rad/s^2, of shape (3,).
/// tol : float, default 1e-12
///     As for :class:`CubicSpline`.
/// max_iterations : int, default 200
///     As for :class:`CubicSpline`.
/// tension : float, default 0.0
///     As for :class:`CubicSpline`, in 1/s^2.
/// extrapolate : bool, default True
///     Whether ``curve`` continues its end pieces; this form always does.
/// num_threads : int, optional
///     Number of threads; by default the size of the global pool.
///
/// Raises
/// ------
/// InvalidInputError
///     Mismatched shapes, non-finite entries, a quaternion of length zero, times that do not increase.
/// OutsideDomainError
///     Two consecutive rotations are half a turn apart; carries ``knot``, the index of the first, and ``angle``.
/// ConvergenceError
///     No spline was found; carries ``report``, and ``knot`` if the interval after it explains why.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs._core import RotationCurve
/// >>> half = np.array([0.0, 0.5, 0.25])
/// >>> q = np.stack([0 * half, 0 * half, np.sin(half), np.cos(half)], axis=-1)
/// >>> curve = RotationCurve([0.0, 1.0, 2.0], q)
/// >>> bool(np.allclose(curve.quaternions([1.0]), q[1]))
/// True
#[pyclass(name = "RotationCurve", module = "stiefel_rs._core", frozen)]
pub struct PyRotationCurve {
    pub(super) spline: Arc<RotationSpline>,
    /// Times of the keyframes in seconds; read-only, shape (N,).
    #[pyo3(get)]
    t: Owned,
    /// Data that it was solved from; `None` if made from an existing curve.
    given: Option<SolveInput>,
    curve: PyOnceLock<Py<PyAny>>,
}

/// Data and options of a solve.
pub(super) struct SolveInput {
    quaternions: Owned,
    /// As given, and for matrices.
    bc_type: Py<PyAny>,
    bc_type_of_frames: Py<PyAny>,
    how: How,
}

/// Options of a solve.
#[derive(Clone, Copy)]
pub(super) struct How {
    tolerance: f64,
    max_iterations: usize,
    tension: f64,
    /// Whether the curve of matrices continues its end pieces.
    extrapolate: bool,
}

impl How {
    pub(super) fn new(
        tolerance: f64,
        max_iterations: i64,
        tension: f64,
        extrapolate: bool,
    ) -> PyResult<Self> {
        Ok(How {
            tolerance,
            max_iterations: count("max_iterations", max_iterations, 1)?,
            tension,
            extrapolate,
        })
    }

    pub(super) fn options(self) -> SplineOptions {
        SplineOptions {
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            tension: self.tension,
            ..SplineOptions::default()
        }
    }
}

#[pymethods]
impl PyRotationCurve {
    #[new]
    #[pyo3(signature = (
        t, quaternions, bc_type=BcType::default(), *, tol=1e-12, max_iterations=200, tension=0.0, extrapolate=true, num_threads=None
    ), text_signature = "(t, quaternions, bc_type='natural', *, tol=1e-12, max_iterations=200, tension=0.0, \
        extrapolate=True, num_threads=None)")]
    fn new(
        t: &Any,
        quaternions: &Any,
        bc_type: BcType<'_>,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        tension: f64,
        extrapolate: bool,
        num_threads: Option<i64>,
    ) -> PyResult<Self> {
        let how = How::new(tol, max_iterations, tension, extrapolate)?;
        Self::solved(t, quaternions, &bc_type, how, num_threads)
    }

    /// Convert a curve of Riemannian cubics on ``St(3, 3)`` to quaternion form.
    ///
    /// Parameters
    /// ----------
    /// curve : CubicSpline, CubicHermite or SmoothingSpline
    ///     A curve of rotation matrices with ``kind="riemannian"``.
    /// start : array_like, shape (4,), optional
    ///     Quaternion near the rotation at the first knot, scalar last: fixes the sign of the quaternions.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     The curve is of another kind or on another manifold, or its matrices have determinant -1.
    ///
    /// Returns
    /// -------
    /// RotationCurve
    ///     The end pieces are continued beyond the first and the last knot, even if ``curve`` raises for such times.
    #[staticmethod]
    #[pyo3(signature = (curve, start=None))]
    fn of_curve(curve: &Bound<'_, PyPiecewiseCurve>, start: Option<&Any>) -> PyResult<Self> {
        let (py, this) = (curve.py(), curve.get());
        if curve.as_super().get().field == Field::Complex {
            return Err(invalid!("curve: expected rotations, found complex frames"));
        }
        let Cubics::Riemannian(cubics) = &this.cubics else {
            return Err(invalid!(
                "curve: expected kind 'riemannian', found 'geometric'"
            ));
        };
        let continued = (**cubics).clone().with_outside(Outside::Continued);
        let start = start.map(|start| {
            let (shape, entries) = read_axes::<1>(start, "start", "(4,)")?;
            Ok::<_, PyErr>(keyframes(&shape, &entries)?[0])
        });
        let start = start.transpose()?;
        let spline = RotationSpline::of_curve(Arc::new(continued), start.as_ref(), this.report)?;
        Self::of(py, spline, None, Some(curve.clone().into_any().unbind()))
    }

    /// Evaluate unit quaternions at times.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape (T,)
    ///     Times in seconds; the end pieces are continued beyond the keyframes.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (T, 4)
    ///     Scalar last, continuous in `t`; at the first keyframe equal to the given one, normalised.
    fn quaternions<'py>(&self, t: &Any<'py>) -> PyResult<Any<'py>> {
        self.sampled::<4>(t, |spline, t, out| spline.quaternions_into(t, out))
    }

    /// Evaluate body rates at times, or their derivatives.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape (T,)
    ///     Times in seconds; the end pieces are continued beyond the keyframes.
    /// order : int
    ///     1, 2 or 3: body rate in rad/s, its first derivative in rad/s^2, its second derivative in rad/s^3.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (T, 3)
    fn rates<'py>(&self, t: &Any<'py>, order: usize) -> PyResult<Any<'py>> {
        ensure!(
            (1..=3).contains(&order),
            "order: expected 1, 2 or 3, found {order}"
        );
        self.sampled::<3>(t, move |spline, t, out| {
            spline.rates_into(t, order - 1, out)
        })
    }

    /// For pickle: the data that the spline was solved from, or the curve and the quaternion at its start.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Any<'py>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let class = slf.get_type();
        let Some(given) = &this.given else {
            let first = this.spline.keyframes().next().unwrap_or_default();
            let start = Array::flat(first.coords.as_slice().to_vec());
            let arguments = (this.curve(py)?, start).into_pyobject(py)?;
            return Ok((class.getattr("of_curve")?, arguments));
        };
        let How {
            tolerance,
            max_iterations,
            tension,
            extrapolate,
        } = given.how;
        let (t, quaternions, bc_type) = (&this.t, &given.quaternions, &given.bc_type);
        let arguments = (
            t,
            quaternions,
            bc_type,
            tolerance,
            max_iterations,
            tension,
            extrapolate,
        );
        let arguments = arguments.into_pyobject(py)?;
        Ok((class.getattr("_solved")?, arguments))
    }

    /// Restores a pickled curve by solving again.
    #[staticmethod]
    #[pyo3(signature = (t, quaternions, bc_type, tol, max_iterations, tension, extrapolate=true))]
    fn _solved(
        t: &Any,
        quaternions: &Any,
        bc_type: BcType<'_>,
        tol: f64,
        max_iterations: i64,
        tension: f64,
        extrapolate: bool,
    ) -> PyResult<Self> {
        let how = How::new(tol, max_iterations, tension, extrapolate)?;
        Self::solved(t, quaternions, &bc_type, how, None)
    }

    /// Immutable: a copy is the object itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Any) -> Py<Self> {
        slf
    }

    /// Outcome of the solver.
    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.spline.report().copied().map(PySolverReport::from)
    }

    /// The same curve on ``St(3, 3)``.
    #[getter]
    fn curve(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let curve = self.curve.get_or_try_init(py, || self.on_frames(py))?;
        Ok(curve.clone_ref(py))
    }
}

impl PyRotationCurve {
    fn solved(
        t: &Any,
        quaternions: &Any,
        bc_type: &BcType<'_>,
        how: How,
        num_threads: Option<i64>,
    ) -> PyResult<Self> {
        let py = t.py();
        let t = times(t)?;
        let (shape, entries) = read_axes::<2>(quaternions, "quaternions", "(N, 4)")?;
        let rotations = keyframes(&shape, &entries)?;
        let GivenEnds { given, conditions } = ends(py, bc_type, &rotations)?;
        let call = Call::new(py, num_threads, WORK_OF_SOLVED * rotations.len() as f64)?
            .uncertain()
            .distributed(rotations.len() > ROTATIONS_ON_ONE_THREAD);
        let given = SolveInput::new(py, entries, bc_type, given, how)?;
        let spline = call.run(move |interrupt| {
            let options = how.options();
            RotationSpline::with_conditions(&t, &rotations, &conditions, &options, interrupt)
        })?;
        Self::of(py, spline, Some(given), None)
    }

    pub(super) fn of(
        py: Python<'_>,
        spline: RotationSpline,
        given: Option<SolveInput>,
        known: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let curve = PyOnceLock::new();
        if let Some(known) = known {
            // The cell was just made and is empty.
            let _ = curve.set(py, known);
        }
        Ok(PyRotationCurve {
            t: Array::flat(spline.knots().to_vec()).frozen(py)?,
            spline: Arc::new(spline),
            given,
            curve,
        })
    }

    /// The spline on `St(3, 3)` as a Python object.
    fn on_frames(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let spline = &self.spline;
        let frames: Vec<_> = spline.keyframes().map(|q| frame(&q)).collect();
        let entries = Array::stacked(&[frames.len()], &frames, (3, 3)).entries;
        let data = SplineData {
            t: spline.knots().to_vec(),
            points: Batch::of([frames.len(), 3, 3], entries, Field::Real),
        };
        let (bc_type, extrapolate) = match &self.given {
            Some(given) => (given.bc_type_of_frames.clone_ref(py), given.how.extrapolate),
            None => (py.None(), true),
        };
        let curve = match extrapolate {
            true => Arc::clone(spline.curve()),
            false => Arc::new((**spline.curve()).clone().with_outside(Outside::Refused)),
        };
        let spline = Spline {
            cubics: Cubics::Riemannian(curve),
            data,
            report: spline.report().copied(),
        };
        let class = PyCubicSpline::of_ends(bc_type);
        object(py, spline.wrap(py)?.add_subclass(class))
    }

    fn sampled<'py, const N: usize>(
        &self,
        t: &Any<'py>,
        write: impl FnOnce(&RotationSpline, &[f64], &mut [[f64; N]]) -> Result<()> + Send + 'static,
    ) -> PyResult<Any<'py>> {
        let ([count], t_) = read_axes(t, "t", "(T,)")?;
        let spline = Arc::clone(&self.spline);
        let entries = Call::new(t.py(), None, 0.0)?.run_here(move || {
            let mut out = vec![[0.0; N]; count];
            write(&spline, &t_, &mut out)?;
            Result::Ok(out.into_flattened())
        })??;
        let shape = vec![count, N];
        Array { shape, entries }.into_bound_py_any(t.py())
    }
}

impl SolveInput {
    pub(super) fn new(
        py: Python<'_>,
        quaternions: Vec<f64>,
        bc_type: &BcType<'_>,
        bc_type_of_frames: Py<PyAny>,
        how: How,
    ) -> PyResult<Self> {
        let bc_type = match bc_type {
            BcType::Word(word) => word.into_py_any(py)?,
            BcType::Pair(pair) => pair.clone().unbind(),
        };
        let shape = vec![quaternions.len() / 4, 4];
        let array = Array {
            shape,
            entries: quaternions,
        };
        Ok(SolveInput {
            quaternions: array.frozen(py)?,
            bc_type,
            bc_type_of_frames,
            how,
        })
    }
}
