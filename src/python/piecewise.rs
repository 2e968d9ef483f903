//! Splines of the binding as curves of pieces.

use std::sync::Arc;

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyList;

use super::convert::{Batch, copy, freeze, to_array};
use super::curve::{AnyCurve, Operations, PyCurve};
use super::error::PySolverReport;
use super::polynomial::PyGeometricCubic;
use super::riemannian_cubic::PyRiemannianCubic;
use super::spline_data::{Data, GEOMETRIC, RIEMANNIAN};
use crate::cubic::RiemannianCubic;
use crate::curve::{Curve, GeometricCubic, Quantity};
use crate::report::SolverReport;
use crate::spline::{Outside, Piecewise};

pub(super) type Array = Py<PyArrayDyn<f64>>;

impl<C: Curve + Operations> Operations for Piecewise<C> {
    fn operations(&self, quantity: Quantity) -> f64 {
        self.pieces()[0].operations(quantity)
    }

    fn preparation(&self, t: &[f64]) -> f64 {
        let (knots, last) = (self.knots(), self.pieces().len() - 1);
        // Of a piece at an end what is beyond that end; times on its other side are other pieces'.
        let farther: [fn(f64, f64) -> f64; 2] = [f64::min, f64::max];
        let ends = [(0, farther[0], 0.0), (last, farther[1], 1.0)];
        let beyond = ends.map(|(piece, farther, end)| {
            let length = knots[piece + 1] - knots[piece];
            let local = |t: &f64| (t - knots[piece]) / length;
            let farthest = t.iter().map(local).fold(end, farther);
            self.pieces()[piece].preparation(&[farthest])
        });
        beyond[0] + beyond[1]
    }
}

/// The pieces of a spline.
#[derive(Clone)]
pub(super) enum Cubics {
    Riemannian(Arc<Piecewise<RiemannianCubic>>),
    Geometric(Arc<Piecewise<GeometricCubic>>),
}

impl Cubics {
    pub(super) fn curve(&self) -> Arc<dyn AnyCurve> {
        match self {
            Cubics::Riemannian(curve) => Arc::clone(curve) as Arc<dyn AnyCurve>,
            Cubics::Geometric(curve) => Arc::clone(curve) as Arc<dyn AnyCurve>,
        }
    }

    pub(super) fn knots(&self) -> &[f64] {
        match self {
            Cubics::Riemannian(curve) => curve.knots(),
            Cubics::Geometric(curve) => curve.knots(),
        }
    }

    fn outside(&self) -> Outside {
        match self {
            Cubics::Riemannian(curve) => curve.outside(),
            Cubics::Geometric(curve) => curve.outside(),
        }
    }
}

/// A curve through points, made of cubics that follow one another.
///
/// Made by :class:`CubicSpline` and :class:`CubicHermite`.
///
/// Attributes
/// ----------
/// t : ndarray, shape (N,)
///     The times between which the pieces run; read-only.
/// points : ndarray, shape (N, n, k)
///     The points at these times, as given; read-only.
/// kind : str
///     ``"riemannian"`` or ``"geometric"``: what the pieces are.
/// extrapolate : bool
///     Whether the first and the last piece go on outside of ``t_span``.
/// report : SolverReport or None
///     How the spline was solved for; None where nothing had to be solved for all pieces together.
/// pieces : list of RiemannianCubic or GeometricCubic
///     The ``N - 1`` pieces, each on ``[0, 1]``.
#[pyclass(name = "PiecewiseCurve", module = "stiefel_rs", extends = PyCurve, subclass, frozen)]
pub struct PyPiecewiseCurve {
    pub(super) cubics: Cubics,
    t: Array,
    pub(super) points: Array,
    pub(super) report: Option<SolverReport>,
}

#[pymethods]
impl PyPiecewiseCurve {
    #[getter]
    fn t(&self, py: Python<'_>) -> Array {
        self.t.clone_ref(py)
    }

    #[getter]
    fn points(&self, py: Python<'_>) -> Array {
        self.points.clone_ref(py)
    }

    #[getter]
    pub(super) fn kind(&self) -> &'static str {
        match self.cubics {
            Cubics::Riemannian(_) => RIEMANNIAN,
            Cubics::Geometric(_) => GEOMETRIC,
        }
    }

    #[getter]
    fn extrapolate(&self) -> bool {
        self.cubics.outside() == Outside::Continued
    }

    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.report.map(PySolverReport)
    }

    #[getter]
    fn pieces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        match &self.cubics {
            Cubics::Riemannian(curve) => {
                for piece in curve.pieces() {
                    list.append(PyRiemannianCubic::wrapped(py, piece.clone())?)?;
                }
            }
            Cubics::Geometric(curve) => {
                for piece in curve.pieces() {
                    list.append(PyGeometricCubic::of_piece(py, piece.clone())?)?;
                }
            }
        }
        Ok(list)
    }

    /// Curves do not change: a copy is the curve itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let this = slf.get();
        let (name, knots) = (slf.get_type().name()?, this.cubics.knots());
        let (n, k) = this.cubics.curve().shape();
        let (count, first, last) = (knots.len(), knots[0], knots[knots.len() - 1]);
        Ok(format!(
            "<{name} on St({n}, {k}), {count} knots, t_span ({first:?}, {last:?})>"
        ))
    }
}

impl PyPiecewiseCurve {
    pub(super) fn wrap(
        py: Python<'_>,
        cubics: Cubics,
        data: &Data,
        report: Option<SolverReport>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let this = PyPiecewiseCurve {
            t: frozen(py, &data.t, &[data.t.len()])?,
            points: frozen_batch(py, &data.points)?,
            report,
            cubics,
        };
        Ok(PyClassInitializer::from(PyCurve::of(this.cubics.curve())).add_subclass(this))
    }
}

/// A read-only array with the given entries.
pub(super) fn frozen(py: Python<'_>, entries: &[f64], shape: &[usize]) -> PyResult<Array> {
    let array = to_array(py, copy(py, entries)?, shape)?;
    freeze(&array)?;
    Ok(array.unbind())
}

pub(super) fn frozen_batch(py: Python<'_>, batch: &Batch) -> PyResult<Array> {
    frozen(py, batch.entries(), &[batch.len(), batch.rows, batch.cols])
}
