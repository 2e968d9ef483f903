//! Splines of the binding as curves of pieces.

use std::sync::Arc;

use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::batch::Batch;
use super::convert::{Any, NewArray, copy, frozen};
use super::curve::{AnyCurve, PyCurve, wrap};
use super::error::PySolverReport;
use super::polynomial::PyGeometricCubic;
use super::riemannian_cubic::PyRiemannianCubic;
use super::spline_data::{Data, GEOMETRIC, RIEMANNIAN};
use crate::cubic::RiemannianCubic;
use crate::curve::GeometricCubic;
use crate::report::SolverReport;
use crate::spline::{Outside, Piecewise};

pub(super) type Array = Py<PyArrayDyn<f64>>;

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
    #[pyo3(get)]
    t: Array,
    #[pyo3(get)]
    pub(super) points: Array,
    pub(super) report: Option<SolverReport>,
}

#[pymethods]
impl PyPiecewiseCurve {
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
    fn pieces<'py>(&self, py: Python<'py>) -> PyResult<Any<'py>> {
        match &self.cubics {
            Cubics::Riemannian(curve) => {
                let piece = |piece: &RiemannianCubic| PyRiemannianCubic::wrapped(py, piece.clone());
                let pieces = curve.pieces().iter().map(piece);
                pieces.collect::<PyResult<Vec<_>>>()?.into_pyobject(py)
            }
            Cubics::Geometric(curve) => {
                let piece = |piece: &GeometricCubic| PyGeometricCubic::of_piece(py, piece.clone());
                let pieces = curve.pieces().iter().map(piece);
                pieces.collect::<PyResult<Vec<_>>>()?.into_pyobject(py)
            }
        }
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
        let times = NewArray {
            shape: vec![data.t.len()],
            entries: copy(py, &data.t)?,
        };
        let this = PyPiecewiseCurve {
            t: frozen(py, times)?,
            points: frozen_batch(py, &data.points)?,
            report,
            cubics,
        };
        Ok(wrap(this.cubics.curve(), this))
    }
}

/// A read-only array of the matrices of a batch.
pub(super) fn frozen_batch(py: Python<'_>, batch: &Batch) -> PyResult<Array> {
    let (shape, entries) = (
        vec![batch.len(), batch.rows, batch.cols],
        copy(py, batch.entries())?,
    );
    frozen(py, NewArray { shape, entries })
}
