//! Stored curves as dictionaries of arrays: what files and pickles hold.

use std::collections::BTreeMap;

use pyo3::types::{PyDict, PyString};

use super::prelude::*;
use crate::stored::{FORMAT, Fields, Stored, VERSION, check_header, refusal};

const WORDS: [&str; 2] = ["format", "kind"];
const VERSION_KEY: &str = "version";

/// The stored form of a curve of the given numbers.
pub(super) fn form<'py>(
    py: Python<'py>,
    kind: &str,
    fields: Fields,
) -> PyResult<Bound<'py, PyDict>> {
    let form = PyDict::new(py);
    for (key, word) in WORDS.into_iter().zip([FORMAT, kind]) {
        form.set_item(key, word)?;
    }
    form.set_item(VERSION_KEY, VERSION)?;
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
            if name == VERSION_KEY {
                version = value.extract::<u64>().ok();
            } else if value.is_instance_of::<PyString>() {
                words.insert(name, value.extract()?);
            } else {
                let array = read(&value, &name)?;
                fields.0.insert(name, array);
            }
        }
        let [format, kind] = WORDS.map(|name| words.remove(name));
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
pub(super) fn refused(problem: &str) -> PyErr {
    refusal(problem.to_owned()).into()
}
