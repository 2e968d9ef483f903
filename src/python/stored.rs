//! Stored curves as dictionaries of arrays, what files and pickles hold, and the curves of these.

use std::collections::BTreeMap;

use super::curve::PyQuasiGeodesic;
use super::geodesic::PyGeodesic;
use super::polynomial::PyGeometricPolynomial;
use super::prelude::*;
use super::riemannian_cubic::PyRiemannianCubic;
use super::smoothing::PySmoothingSpline;
use super::spline::{PyCubicHermite, PyCubicSpline};
use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, GeometricPolynomial};
use crate::manifold::{Geodesic, QuasiGeodesic};
use crate::stored::{FORMAT, Fields, Stored, VERSION, check_header, refusal};

/// The stored form of a curve of the given numbers.
pub(super) fn form<'py>(
    py: Python<'py>,
    kind: &str,
    fields: Fields,
) -> PyResult<Bound<'py, PyDict>> {
    let form = PyDict::new(py);
    form.set_item("format", FORMAT)?;
    form.set_item("kind", kind)?;
    form.set_item("version", VERSION)?;
    for (name, array) in fields.0 {
        form.set_item(name, array)?;
    }
    Ok(form)
}

/// A stored form that is read.
pub(super) struct Form {
    pub(super) kind: String,
    words: BTreeMap<String, String>,
    pub(super) fields: Fields,
}

impl Form {
    /// # Errors
    /// `InvalidInputError` where it is not of this format and version; `TypeError` where something is neither a word nor an
    /// array.
    pub(super) fn of(form: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut words: BTreeMap<String, String> = BTreeMap::new();
        let mut fields = Fields::default();
        let mut version = None;
        for (name, value) in form {
            let name: String = name.extract()?;
            if name == "version" {
                version = value.extract::<u64>().ok();
            } else if value.is_instance_of::<PyString>() {
                words.insert(name, value.extract()?);
            } else {
                let array = read(&value, &name)?;
                fields.0.insert(name, array);
            }
        }
        let [format, kind] = ["format", "kind"].map(|name| words.remove(name));
        let (Some(format), Some(version), Some(kind)) = (format, version, kind) else {
            let problem = "does not say its format, version and kind";
            return Err(refusal(problem.to_owned()).into());
        };
        check_header(&format, version)?;
        Ok(Form {
            kind,
            words,
            fields,
        })
    }

    /// Takes a word out.
    pub(super) fn word(&mut self, name: &str) -> PyResult<String> {
        let word = self.words.remove(name);
        word.ok_or_else(|| refusal(format!("has no word '{name}'")).into())
    }

    /// What `take` makes of the numbers, of which it leaves none.
    pub(super) fn read<T: Send + 'static>(
        self,
        py: Python<'_>,
        take: impl FnOnce(&mut Fields, Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let Form { words, fields, .. } = self;
        if let Some(name) = words.keys().next() {
            return Err(refusal(format!("'{name}' is no part of such a curve")).into());
        }
        let numbers: usize = fields.0.values().map(|array| array.entries.len()).sum();
        run(py, numbers as f64, move |interrupt| {
            fields.read(|fields| take(fields, interrupt))
        })
    }
}

/// The curve of a stored form: for files and pickles.
#[pyfunction]
pub fn _restored(form: &Bound<'_, PyDict>) -> PyResult<Py<PyAny>> {
    let py = form.py();
    let form = Form::of(form)?;
    match form.kind.as_str() {
        QuasiGeodesic::KIND => {
            let curve = form.read(py, QuasiGeodesic::restore)?;
            object(py, wrap(Arc::new(curve), PyQuasiGeodesic))
        }
        Geodesic::KIND => object(py, PyGeodesic::wrap(form.read(py, Geodesic::restore)?)),
        GeometricPolynomial::KIND | GeometricCubic::KIND => {
            PyGeometricPolynomial::restored(py, form)
        }
        RiemannianCubic::KIND => {
            let curve = form.read(py, RiemannianCubic::restore)?;
            PyRiemannianCubic::wrapped(py, curve)?.into_py_any(py)
        }
        PyCubicHermite::NAME => PyCubicHermite::restored(py, form),
        PyCubicSpline::NAME => PyCubicSpline::restored(py, form),
        PySmoothingSpline::NAME => PySmoothingSpline::restored(py, form),
        kind => Err(refusal(format!("of an unknown kind, '{kind}'")).into()),
    }
}
