//! The curve of a stored form, of any kind.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::curve::PyQuasiGeodesic;
use super::geodesic::PyGeodesic;
use super::polynomial::PyGeometricPolynomial;
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
        QuasiGeodesic::KIND => PyQuasiGeodesic::restored(py, form),
        Geodesic::KIND => PyGeodesic::restored(py, form),
        GeometricPolynomial::KIND | GeometricCubic::KIND => {
            PyGeometricPolynomial::restored(py, form)
        }
        RiemannianCubic::KIND => PyRiemannianCubic::restored(py, form),
        PyCubicHermite::KIND => PyCubicHermite::restored(py, form),
        PyCubicSpline::KIND => PyCubicSpline::restored(py, form),
        PySmoothingSpline::KIND => PySmoothingSpline::restored(py, form),
        kind => Err(refused(py, &format!("of an unknown kind, '{kind}'"))),
    }
}
