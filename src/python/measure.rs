//! Lengths of curves and bounds of their derivatives, in Python.

use super::prelude::*;
use super::record::record;
use crate::curve::Guarantee;

/// Largest norms of the derivatives of a curve, canonical metric.
///
/// Returned by :meth:`Curve.derivative_bounds`.
#[pyclass(name = "DerivativeBounds", module = "stiefel_rs", frozen, get_all)]
pub struct PyDerivativeBounds {
    /// Largest norm of the velocity.
    velocity: f64,
    /// Largest norm of the covariant acceleration.
    acceleration: f64,
    /// Largest norm of the covariant jerk.
    jerk: f64,
    /// How the numbers were found: ``"enclosure"`` or ``"sampling"``.
    ///
    /// ``"enclosure"``: upper bounds (up to round-off) that exceed the largest norms by at most 1e-3 relative, or by at
    /// most 1e-4 of a derivative of lower order if that is more than ten times as large, with the duration of a piece
    /// as the unit of time. ``"sampling"``: largest norms of a dense sample, refined around the maximum.
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
    /// Return the length of the curve between two parameters, canonical metric.
    ///
    /// The relative error is 1e-12, or the round-off of the velocity or of the times if that is larger: 1e-6 for
    /// pieces of 0.01 s at Unix times.
    ///
    /// Parameters
    /// ----------
    /// t0, t1 : float, optional
    ///     The ends, ``t0 <= t1``; by default the ends of ``t_span``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``t0`` or ``t1`` not finite, ``t1 < t0``.
    /// ConvergenceError
    ///     The quadrature did not converge.
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

    /// Return parameters at which points of the curve are equally spaced in arc length.
    ///
    /// ``curve(curve.resample(count))`` samples the curve at constant speed.
    ///
    /// Parameters
    /// ----------
    /// count : int
    ///     Number of parameters, at least two; the first and the last are the ends of ``t_span``.
    /// num_threads : int, optional
    ///     Number of threads; by default the size of the global pool.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (count,)
    ///     Increasing; the lengths between neighbours agree to 1e-12 of the total length. Equally spaced for a constant
    ///     curve.
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

    /// Bound the norms of velocity, covariant acceleration and covariant jerk over ``t_span``, canonical metric.
    ///
    /// For Riemannian cubics and their splines these are upper bounds, at most 1e-3 relative above the largest norms,
    /// or 1e-4 of a derivative of lower order if that is more than ten times as large, with the duration of a piece as
    /// the unit of time. For other curves they are the largest norms of a dense, refined sample. See
    /// :class:`DerivativeBounds`.
    ///
    /// Raises
    /// ------
    /// ConvergenceError
    ///     The cubic is so long and fast that bounds would need too many samples.
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

    /// Draw the curve with ``stiefel_rs.plotting.plot``; needs matplotlib (extra ``plot``).
    ///
    /// Curves with more than 60 matrix entries are drawn as an overview: angles of the columns to the start, speed,
    /// length of the covariant acceleration, and an image of all entries.
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib.axes.Axes, optional
    ///     Axes to draw into; by default those of a new figure.
    /// num : int, optional
    ///     Number of points.
    /// **style
    ///     Keyword arguments for the lines.
    ///
    /// Returns
    /// -------
    /// matplotlib.axes.Axes
    ///     The axes with the curve.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     matplotlib is not installed.
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
