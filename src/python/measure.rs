//! Lengths of curves and bounds of their derivatives, in Python.

use super::prelude::*;
use super::record::record;
use crate::curve::Guarantee;

/// The largest norms of the derivatives of a curve, canonical metric.
///
/// Made by :meth:`Curve.derivative_bounds`.
#[pyclass(name = "DerivativeBounds", module = "stiefel_rs", frozen, get_all)]
pub struct PyDerivativeBounds {
    /// The largest norm of the velocity.
    velocity: f64,
    /// The largest norm of the covariant acceleration.
    acceleration: f64,
    /// The largest norm of the covariant jerk.
    jerk: f64,
    /// ``"enclosure"``: the norms are nowhere larger (but for round-off), and the numbers at most 1e-3 of themselves above
    /// the largest norms (1e-4 of a derivative of lower order where that is more than ten times as large, in the length of a
    /// piece as unit of time). ``"sampling"``: the largest norms of a dense sample, refined around the largest.
    guarantee: &'static str,
}

#[pymethods]
impl PyDerivativeBounds {
    #[new]
    fn new(velocity: f64, acceleration: f64, jerk: f64, guarantee: &str) -> PyResult<Self> {
        let Some(guarantee) = Guarantee::from_word(guarantee) else {
            return Err(invalid!("guarantee: expected 'enclosure' or 'sampling'"));
        };
        Ok(PyDerivativeBounds {
            velocity,
            acceleration,
            jerk,
            guarantee: guarantee.as_str(),
        })
    }
}

record! { PyDerivativeBounds, velocity, acceleration, jerk, guarantee }

#[pymethods]
impl PyCurve {
    /// Length of the curve between two parameters, canonical metric.
    ///
    /// Relative error 1e-12, or round-off of the velocity where that is more.
    ///
    /// Parameters
    /// ----------
    /// t0, t1 : float, optional
    ///     The ends, ``t0 <= t1``; by default those of ``t_span``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Not finite, ``t1`` before ``t0``.
    /// ConvergenceError
    ///     The quadrature does not settle.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import QuasiGeodesic
    /// >>> QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).arc_length(0.0, 0.5)  # doctest: +ELLIPSIS
    /// 0.78539816339...
    #[pyo3(signature = (t0=None, t1=None))]
    fn arc_length(&self, py: Python<'_>, t0: Option<f64>, t1: Option<f64>) -> PyResult<f64> {
        let (start, end) = self.inner.t_span();
        let (t0, t1) = (t0.unwrap_or(start.min(end)), t1.unwrap_or(start.max(end)));
        let length = self.run(py, None, move |curve, stop| curve.arc_length(t0, t1, stop))?;
        Ok(self.field.length(length))
    }

    /// Parameters at which the curve is to be evaluated for points at equal distances along it.
    ///
    /// ``curve(curve.resample(count))`` is the curve at constant speed.
    ///
    /// Parameters
    /// ----------
    /// count : int
    ///     Number of points, two or more; the first and the last one are the ends of ``t_span``.
    /// num_threads : int, optional
    ///     Threads; by default those of the global pool.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (count,)
    ///     Increasing; lengths between neighbours agree to 1e-12 of the whole. Equal steps for a curve that rests.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import QuasiGeodesic
    /// >>> QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).resample(3).round(12).tolist()
    /// [0.0, 0.5, 1.0]
    #[pyo3(signature = (count, *, num_threads=None))]
    fn resample(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = whole)] count: i64,
        num_threads: Option<i64>,
    ) -> PyResult<Array> {
        let points = super::convert::count("count", count, 2)?;
        let found = self.run(py, num_threads, move |curve, stop| {
            curve.resample(points, stop)
        });
        Ok(Array::flat(found?))
    }

    /// The largest norms of velocity, covariant acceleration and covariant jerk over ``t_span``, canonical metric.
    ///
    /// True bounds for Riemannian cubics and their splines, at most 1e-3 above the largest norms, or 1e-4 of those of lower
    /// order where these are more than ten times as large in the length of a piece as unit of time; the largest norms of
    /// a dense and refined sample for other curves. See :class:`DerivativeBounds`.
    ///
    /// Raises
    /// ------
    /// ConvergenceError
    ///     A cubic so long and fast that bounds would need too many samples.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import QuasiGeodesic
    /// >>> curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
    /// >>> round(curve.derivative_bounds().velocity, 6)
    /// 1.570796
    fn derivative_bounds(&self, py: Python<'_>) -> PyResult<PyDerivativeBounds> {
        let bounds = self.run(py, None, |curve, stop| curve.derivative_bounds(stop))?;
        Ok(PyDerivativeBounds {
            velocity: self.field.length(bounds.velocity),
            acceleration: self.field.length(bounds.acceleration),
            jerk: self.field.length(bounds.jerk),
            guarantee: bounds.guarantee.as_str(),
        })
    }

    /// Draw the curve, as ``stiefel_rs.plotting.plot`` does; needs matplotlib (extra ``plot``).
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib.axes.Axes, optional
    ///     Where to draw; a figure of its own if not given.
    /// num : int, optional
    ///     Number of points.
    /// **style
    ///     Passed on to the lines.
    ///
    /// Returns
    /// -------
    /// matplotlib.axes.Axes
    ///     Where it was drawn.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     There is no matplotlib.
    #[pyo3(signature = (*, ax=None, num=200, **style), text_signature = "($self, *, ax=None, num=200, **style)")]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        ax: Option<Any<'py>>,
        num: i64,
        style: Option<Bound<'py, PyDict>>,
    ) -> PyResult<Any<'py>> {
        let py = slf.py();
        let options = style.unwrap_or_else(|| PyDict::new(py));
        options.set_item("ax", ax)?;
        options.set_item("num", num)?;
        let plotting = py.import("stiefel_rs.plotting")?;
        plotting.call_method("plot", (slf,), Some(&options))
    }
}
