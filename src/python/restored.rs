//! The curve of a stored form, of any kind.

use std::sync::Arc;

use pyo3::types::PyDict;

use super::curve::{PyQuasiGeodesic, object, wrap};
use super::geodesic::PyGeodesic;
use super::polynomial::PyGeometricPolynomial;
use super::prelude::*;
use super::riemannian_cubic::PyRiemannianCubic;
use super::smoothing::PySmoothingSpline;
use super::spline::{PyCubicHermite, PyCubicSpline};
use super::stored::{Form, refused};
use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, GeometricPolynomial};
use crate::manifold::{Geodesic, QuasiGeodesic};
use crate::stored::Stored;

/// The curve of a stored form: for files and pickles.
#[pyfunction]
pub fn _restored(form: &Bound<'_, PyDict>) -> PyResult<Py<PyAny>> {
    let py = form.py();
    let form = Form::of(form)?;
    match form.kind.as_str() {
        QuasiGeodesic::KIND => {
            let curve: QuasiGeodesic = form.curve(py)?;
            object(py, wrap(Arc::new(curve), PyQuasiGeodesic))
        }
        Geodesic::KIND => object(py, PyGeodesic::wrap(form.curve(py)?)),
        GeometricPolynomial::KIND | GeometricCubic::KIND => {
            PyGeometricPolynomial::restored(py, form)
        }
        RiemannianCubic::KIND => Ok(PyRiemannianCubic::wrapped(py, form.curve(py)?)?.into_any()),
        PyCubicHermite::KIND => PyCubicHermite::restored(py, form),
        PyCubicSpline::KIND => PyCubicSpline::restored(py, form),
        PySmoothingSpline::KIND => PySmoothingSpline::restored(py, form),
        kind => Err(refused(&format!("of an unknown kind, '{kind}'"))),
    }
}
