//! Smoothing splines of the binding.

use super::piecewise::{Cubics, PyPiecewiseCurve, Spline, SplineData, outside};
use super::points::Points;
use super::prelude::*;
use super::state::check_finite;
use super::stored::{Form, form};
use crate::curve::{Curve, Quantity};
use crate::spline::{SmoothingOptions, SmoothingSpline, smoothing_spline};
use crate::stored::refusal;

/// Smoothing spline: a curve near data points that trades distance to the data against cost.
///
/// Makes ``sum_i weights[i] d(S(t[i]), S[i])^2 + lam J`` stationary, where ``d`` is the Riemannian distance and ``J``
/// the integral of the squared covariant acceleration.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     Nondecreasing times.
/// S : array_like, shape (N, n, k)
///     Data points with orthonormal columns.
/// weights : array_like, shape (N,), optional
///     Positive weights; by default 1.
/// lam : float, optional
///     Weight of the cost, at least 0, in units of squared distance times the cube of time: 0 gives the natural spline
///     through the data, ``inf`` geodesic regression. By default chosen by generalised cross-validation, which needs at
///     least three points.
/// extrapolate : bool, default False
///     If True, the first and the last piece are continued outside ``[t[0], t[-1]]``; by default such times raise.
/// tol : float, default 1e-11
///     Largest distance between the end of a piece and its knot, jump of the covariant acceleration, and imbalance of
///     the stationarity equations at a knot, with the duration of the piece as the unit of time.
/// max_iterations : int, default 200
///     Largest number of steps. More than 200 raise the work limit, about two seconds, in proportion.
/// num_threads : int, optional
///     Number of threads; by default the size of the global pool.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
///     start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
/// w : array_like, optional
///     Alias of `weights`, as in SciPy.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Raises
/// ------
/// InvalidInputError
///     Mismatched shapes or lengths, non-finite entries, decreasing times, weights that are not positive, points not
///     orthonormal (with the measured defect). Names the knot, counted by distinct times; carries ``knot``.
/// OutsideDomainError
///     No curve joins two consecutive points; carries ``knot``, the index of the first, and ``angle``.
/// ConvergenceError
///     No spline was found; carries ``report``.
/// TypeError
///     ``t`` is complex, or holds dates or durations.
///
/// See Also
/// --------
/// CubicSpline : curve through the points.
///
/// Notes
/// -----
/// The attribute ``t`` holds the distinct times, ``points`` the points of the curve at these times.
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
    /// Weight of the cost, as given or as found by cross-validation.
    lam: f64,
    /// Weighted sum of squared distances to the data, ``sum_i weights[i] d(S(t[i]), S[i])^2``.
    misfit: f64,
    /// Effective number of degrees of freedom, between 2 and the number of data.
    ///
    /// The trace of the influence matrix of the smoothing spline in flat space.
    degrees_of_freedom: f64,
}

/// Name of the three numbers in the stored form.
const SMOOTHING: &str = "smoothing";

/// Stands for an infinite `lam` in the stored form, whose numbers are finite: from `1e100` on (in units of the mean
/// step) the curve is the same to the last bit.
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
        let data = SplineData::read(t, S, &points, field)?;
        let quotient = points.quotient;
        if weights.is_some() && w.is_some() {
            let message = "weights: pass either weights or w, not both";
            return Err(PyTypeError::new_err(message));
        }
        let weights = weights
            .or(w)
            .map(|object| read_axes(object, "weights", "(N,)"))
            .transpose()?;
        let weights: Option<Vec<f64>> = weights.map(|([_], weights)| weights);
        check_finite("weights", weights.as_deref().unwrap_or(&[]))?;
        let call = data.call(t.py(), num_threads)?;
        let fit = call.run(move |interrupt| {
            let options = SmoothingOptions {
                lambda: lam,
                tolerance: tol,
                max_iterations,
                quotient,
                field,
            };
            let views = data.points.views();
            Fit::new(&data.t, &views, weights.as_deref(), &options, interrupt)
        })?;
        fit.wrap(t.py(), field, extrapolate)
    }

    /// All numbers of the curve, for files and pickles.
    fn _stored<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let (py, this) = (slf.py(), slf.get());
        let field = slf.as_super().as_super().get().field;
        let mut fields = slf.as_super().get().stored(py, field)?;
        let lam = this.lam.min(INFINITE);
        fields.put_flat(SMOOTHING, vec![lam, this.misfit, this.degrees_of_freedom]);
        form(py, Self::NAME, field, fields)
    }
}

/// A smoothing spline, and its points at the knots.
pub(super) struct Fit {
    pub(super) fitted: SmoothingSpline,
    /// Row by row.
    points: Vec<f64>,
}

impl Fit {
    /// # Errors
    /// As [`smoothing_spline`].
    pub(super) fn new(
        t: &[f64],
        data: &[MatRef<'_, f64>],
        weights: Option<&[f64]>,
        options: &SmoothingOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let fitted = smoothing_spline(t, data, weights, options, interrupt)?;
        let (knots, position) = (fitted.curve.knots(), Quantity::Derivative(0));
        let points = Curve::sample(&fitted.curve, knots, position, interrupt)?;
        let rows = points.iter().flat_map(|point| point.row_iter());
        let points = rows.flat_map(|row| row.iter()).copied().collect();
        Ok(Fit { fitted, points })
    }

    /// The object of a curve with points of a field.
    pub(super) fn wrap(
        self,
        py: Python<'_>,
        field: Field,
        extrapolate: bool,
    ) -> PyResult<PyClassInitializer<PySmoothingSpline>> {
        let Fit { fitted, points } = self;
        let (t, curve) = (fitted.curve.knots().to_vec(), &fitted.curve);
        let points = Batch::of([t.len(), curve.n(), curve.k()], points, field);
        let curve = fitted.curve.with_outside(outside(extrapolate));
        let spline = Spline {
            cubics: Cubics::Riemannian(Arc::new(curve)),
            data: SplineData { t, points },
            report: Some(fitted.report),
        };
        Ok(spline.wrap(py)?.add_subclass(PySmoothingSpline {
            lam: fitted.lambda,
            misfit: field.squared(fitted.misfit),
            degrees_of_freedom: fitted.degrees_of_freedom,
        }))
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
