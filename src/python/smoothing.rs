//! Smoothing splines of the binding.

use super::piecewise::{Cubics, Data, PyPiecewiseCurve, Spline, outside};
use super::points::Points;
use super::prelude::*;
use super::state::check_finite;
use super::stored::{Form, form};
use crate::curve::{Curve, Quantity};
use crate::spline::{SmoothingOptions, smoothing_spline};
use crate::stored::refusal;

/// Spline near points rather than through them: closeness to data against cost.
///
/// Makes ``sum_i weights[i] d(S(t[i]), S[i])^2 + lam J`` stationary, with the Riemannian distance ``d`` and the integral ``J`` of the
/// squared covariant acceleration.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     Times in order; they may repeat.
/// S : array_like, shape (N, n, k)
///     Data: points with orthonormal columns.
/// weights : array_like, shape (N,), optional
///     Positive; all 1 by default.
/// lam : float, optional
///     Weight of the cost, 0 or more, in units of squared distance times the cube of a time; 0 is the natural spline through the
///     data, ``inf`` geodesic regression. By default the one that generalised cross-validation finds, for three points or more.
/// extrapolate : bool, default False
///     Whether the first and the last piece go on outside of ``[t[0], t[-1]]``; by default times there are errors.
/// tol : float, default 1e-11
///     The largest distance by which a piece may miss its knot, jump of the covariant acceleration, and lack of balance at a
///     knot, in the time of the piece.
/// max_iterations : int, default 200
///     Steps at the most. More than 200 raise the limit of work, about two seconds, in proportion.
/// num_threads : int, optional
///     Threads; by default those of the global pool.
/// manifold : Stiefel or Grassmann, optional
///     What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
///     whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
///     first given one on.
/// w : array_like, optional
///     Another name of `weights`, which SciPy's functions have.
/// project : bool, default False
///     Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
///     Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.
///
/// Raises
/// ------
/// InvalidInputError
///     Shapes or numbers that do not match, not finite, times that fall, weights that are not positive, not orthonormal (with the
///     measured defect). Names the knot, counted by distinct times, and carries it as ``knot``.
/// OutsideDomainError
///     Neighbours that no curve joins; carries ``knot``, the first of the two, and ``angle``.
/// ConvergenceError
///     No spline is found; carries ``report``.
/// TypeError
///     Complex times, dates and durations.
///
/// See Also
/// --------
/// CubicSpline : through the points.
///
/// Notes
/// -----
/// ``t`` are the distinct times, ``points`` the points of the curve there.
///
/// Reinsch (1967) in flat space; Samir, Absil, Srivastava, Klassen (2012) on manifolds; Craven, Wahba (1979) for
/// cross-validation.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import SmoothingSpline
/// >>> t = np.linspace(0, 1, 20)
/// >>> angle = t**2 + 0.01 * np.random.default_rng(0).standard_normal(20)
/// >>> curve = SmoothingSpline(t, np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None])
/// >>> bool(abs(np.arctan2(*curve(0.5)[::-1, 0]) - 0.25) < 0.01), curve.degrees_of_freedom < 10
/// (True, True)
#[pyclass(name = "SmoothingSpline", module = "stiefel_rs", extends = PyPiecewiseCurve, frozen, get_all)]
pub struct PySmoothingSpline {
    /// The weight of the cost, given or found.
    lam: f64,
    /// ``sum_i weights[i] d(S(t[i]), S[i])^2``.
    misfit: f64,
    /// How many data the curve could follow, between 2 and their number: the trace of the influence matrix of the smoothing
    /// spline in flat space.
    degrees_of_freedom: f64,
}

/// The name of its three numbers in the stored form.
const SMOOTHING: &str = "smoothing";

/// What stands for an infinite `lam` there: stored numbers are finite, and from `1e100` on (in units of the mean step) the curve is
/// the same to the last bit.
const INFINITE: f64 = f64::MAX;

#[pymethods]
impl PySmoothingSpline {
    #[new]
    #[pyo3(signature = (
        t, S, weights=None, lam=None, *, extrapolate=false, tol=1e-11, max_iterations=200, num_threads=None, manifold=None,
        project=false, w=None
    ))]
    fn new(
        t: &Any,
        S: &Any,
        weights: Option<&Any>,
        lam: Option<f64>,
        extrapolate: bool,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        num_threads: Option<i64>,
        manifold: Option<&Any>,
        project: bool,
        w: Option<&Any>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let points = Points::read(manifold, project)?;
        let max_iterations = count("max_iterations", max_iterations, 1)?;
        let field = points.field([S])?;
        let data = Data::read(t, S, &points, field)?;
        let quotient = points.quotient;
        if weights.is_some() && w.is_some() {
            let message = "weights: give them once, as weights or as w";
            return Err(PyTypeError::new_err(message));
        }
        let weights = weights
            .or(w)
            .map(|object| read_axes(object, "weights", "(N,)"))
            .transpose()?;
        let weights: Option<Vec<f64>> = weights.map(|([_], weights)| weights);
        check_finite("weights", weights.as_deref().unwrap_or(&[]))?;
        let call = data.call(t.py(), num_threads)?;
        let (fitted, spline) = call.run(move |interrupt| {
            let options = SmoothingOptions {
                lambda: lam,
                tolerance: tol,
                max_iterations,
                quotient,
                field,
                interrupt,
            };
            let views = data.points.views();
            let fitted = smoothing_spline(&data.t, &views, weights.as_deref(), &options)?;
            let curve = fitted.curve.clone().with_outside(outside(extrapolate));
            let (t, (n, k)) = (curve.knots().to_vec(), data.shape());
            let found = Curve::sample(&curve, &t, Quantity::Derivative(0), interrupt)?;
            let mut points = Vec::with_capacity(t.len() * n * k);
            for point in found.iter() {
                points.extend(point.row_iter().flat_map(|row| row.iter()));
            }
            let points = Batch::of([t.len(), n, k], points, field);
            let spline = Spline {
                cubics: Cubics::Riemannian(Arc::new(curve)),
                data: Data { t, points },
                report: Some(fitted.report),
            };
            Ok((fitted, spline))
        })?;
        Ok(spline.wrap(t.py())?.add_subclass(PySmoothingSpline {
            lam: fitted.lambda,
            misfit: field.squared(fitted.misfit),
            degrees_of_freedom: fitted.degrees_of_freedom,
        }))
    }

    /// For files and pickles: all numbers of the curve.
    fn _stored<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let (py, this) = (slf.py(), slf.get());
        let field = slf.as_super().as_super().get().field;
        let mut fields = slf.as_super().get().stored(py, field)?;
        let lam = this.lam.min(INFINITE);
        fields.put_flat(SMOOTHING, vec![lam, this.misfit, this.degrees_of_freedom]);
        form(py, Self::NAME, field, fields)
    }
}

impl PySmoothingSpline {
    pub(super) fn restored(py: Python<'_>, form: Form) -> PyResult<Py<PyAny>> {
        let field = form.field;
        let (spline, [lam, misfit, degrees_of_freedom]) =
            form.read(py, move |fields, interrupt| {
                let numbers = fields.take(SMOOTHING)?.entries;
                let found = numbers.len();
                let numbers = <[f64; 3]>::try_from(numbers).map_err(|_| {
                    refusal(format!("{SMOOTHING}: expected 3 numbers, found {found}"))
                })?;
                if let Some(negative) = numbers.iter().find(|x| **x < 0.0) {
                    return Err(refusal(format!("{SMOOTHING}: {negative} is negative")));
                }
                let spline = Spline::restored(fields, field, false, interrupt)?;
                Ok((spline, numbers))
            })?;
        let curve = spline.wrap(py)?.add_subclass(PySmoothingSpline {
            lam: if lam == INFINITE { f64::INFINITY } else { lam },
            misfit,
            degrees_of_freedom,
        });
        object(py, curve)
    }
}
