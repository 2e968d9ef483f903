//! Stored curves as dictionaries of arrays, the contents of files and pickles.

use std::collections::BTreeMap;

use super::prelude::*;
use crate::manifold::stored::quotient_of;
use crate::space::Quotient;
use crate::stored::{FORMAT, Fields, VERSION, check_header, refusal};

/// Marks the numbers as those of embedded complex matrices; absent for real curves.
const FIELD: &str = "field";

/// Marks de Casteljau curves of subspaces; absent for curves of frames.
const SUBSPACES: &str = "subspaces";

pub(super) fn put_quotient(fields: &mut Fields, quotient: Quotient) {
    if quotient == Quotient::Subspaces {
        fields.put_flat(SUBSPACES, vec![1.0]);
    }
}

pub(super) fn take_quotient(fields: &mut Fields) -> Result<Quotient> {
    let mut stored = fields.parts_or_zeros(SUBSPACES, 1)?;
    let quotient = quotient_of(stored.some()?)?;
    stored.end()?;
    Ok(quotient)
}

/// The stored form of a curve with the given numbers.
pub(super) fn form<'py>(
    py: Python<'py>,
    kind: &str,
    field: Field,
    fields: Fields,
) -> PyResult<Bound<'py, PyDict>> {
    let form = PyDict::new(py);
    form.set_item("format", FORMAT)?;
    form.set_item("kind", kind)?;
    form.set_item("version", VERSION)?;
    if field == Field::Complex {
        form.set_item(FIELD, field.word())?;
    }
    for (name, array) in fields.0 {
        form.set_item(name, array)?;
    }
    Ok(form)
}

/// A stored form while it is read.
pub(super) struct Form {
    pub(super) kind: String,
    pub(super) field: Field,
    words: BTreeMap<String, String>,
    pub(super) fields: Fields,
}

impl Form {
    /// # Errors
    /// `InvalidInputError` for another format or version; `TypeError` if an entry is neither a word nor an array.
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
        let field = words.remove(FIELD);
        let field = field.map_or(Ok(Field::Real), |word| Field::from_word(&word))?;
        Ok(Form {
            kind,
            field,
            words,
            fields,
        })
    }

    /// Takes a word out.
    pub(super) fn word(&mut self, name: &str) -> PyResult<String> {
        let word = self.words.remove(name);
        word.ok_or_else(|| refusal(format!("entry '{name}' is missing")).into())
    }

    /// Applies `take` to the numbers, and raises if it leaves any.
    pub(super) fn read<T: Send + 'static>(
        self,
        py: Python<'_>,
        take: impl FnOnce(&mut Fields, Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let Form { words, fields, .. } = self;
        if let Some(name) = words.keys().next() {
            return Err(refusal(format!("unexpected entry '{name}'")).into());
        }
        let numbers: usize = fields.0.values().map(|array| array.entries.len()).sum();
        run(py, Field::Real, numbers as f64, move |interrupt| {
            fields.read(|fields| take(fields, interrupt))
        })
    }
}
