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
    fields: Fields,
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
            return Err(refused("does not say its format, version and kind"));
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
        word.ok_or_else(|| refused(&format!("has no word '{name}'")))
    }

    /// Takes an array out.
    pub(super) fn array(&mut self, name: &str) -> PyResult<Array> {
        Ok(self.fields.take(name)?)
    }

    /// What `take` makes of the numbers, of which it leaves none.
    pub(super) fn read<T: Send + 'static>(
        self,
        py: Python<'_>,
        take: impl FnOnce(&mut Fields, Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let Form { words, fields, .. } = self;
        if let Some(name) = words.keys().next() {
            return Err(refused(&format!("'{name}' is no part of such a curve")));
        }
        let numbers: usize = fields.0.values().map(|array| array.entries.len()).sum();
        run(py, numbers as f64, move |interrupt| {
            fields.read(|fields| take(fields, interrupt))
        })
    }

    /// The curve of its numbers, where the core knows how to read it.
    pub(super) fn curve<C: Stored + Send + 'static>(self, py: Python<'_>) -> PyResult<C> {
        self.read(py, C::restore)
    }
}

/// `InvalidInputError` for a stored form that is none.
fn refused(problem: &str) -> PyErr {
    refusal(problem.to_owned()).into()
}

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
