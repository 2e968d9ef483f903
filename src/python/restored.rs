//! Curves from their stored forms.

use super::geodesic::PyGeodesic;
use super::geometric_cubic;
use super::prelude::*;
use super::quasi_geodesic::PyQuasiGeodesic;
use super::riemannian_cubic::PyRiemannianCubic;
use super::smoothing::PySmoothingSpline;
use super::spline::{PyCubicHermite, PyCubicSpline};
use super::stored::Form;
use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, GeometricPolynomial};
use crate::manifold::{Geodesic, QuasiGeodesic};
use crate::stored::{Stored, refusal};

/// Restore the curve of a stored form, for files and pickles.
#[pyfunction]
pub fn _restored(form: &Bound<'_, PyDict>) -> PyResult<Py<PyAny>> {
    let py = form.py();
    let curve = curve_of(py, Form::of(form)?)?;
    curve.bind(py).cast::<PyCurve>()?.get().check_complex(py)?;
    Ok(curve)
}

fn curve_of(py: Python<'_>, form: Form) -> PyResult<Py<PyAny>> {
    let field = form.field;
    match form.kind.as_str() {
        QuasiGeodesic::KIND => {
            let curve = form.read(py, QuasiGeodesic::restore)?;
            object(py, wrap(Arc::new(curve), field, PyQuasiGeodesic))
        }
        Geodesic::KIND => {
            let curve = form.read(py, Geodesic::restore)?;
            object(py, PyGeodesic::wrap(py, curve, field)?)
        }
        GeometricPolynomial::KIND | GeometricCubic::KIND => geometric_cubic::restored(py, form),
        RiemannianCubic::KIND => {
            let curve = form.read(py, RiemannianCubic::restore)?;
            PyRiemannianCubic::wrapped(py, curve, field)?.into_py_any(py)
        }
        PyCubicHermite::NAME => PyCubicHermite::restored(py, form),
        PyCubicSpline::NAME => PyCubicSpline::restored(py, form),
        PySmoothingSpline::NAME => PySmoothingSpline::restored(py, form),
        kind => Err(refusal(format!("unknown kind '{kind}'")).into()),
    }
}
