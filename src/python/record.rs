//! `__repr__` and `__reduce__` of classes that consist of their fields.

use pyo3::prelude::*;
use pyo3::types::{PyTuple, PyType};

/// `Name(field=value, ...)`.
pub fn repr(record: &Bound<'_, PyAny>, fields: &[&str]) -> PyResult<String> {
    let mut words = Vec::with_capacity(fields.len());
    for field in fields {
        words.push(format!("{field}={}", record.getattr(*field)?.repr()?));
    }
    let name = record.get_type().name()?;
    Ok(format!("{name}({})", words.join(", ")))
}

/// What `__reduce__` returns.
pub type Reduced<'py> = (Bound<'py, PyType>, Bound<'py, PyTuple>);

/// The class and its arguments, for pickle and copy.
pub fn reduce<'py>(record: &Bound<'py, PyAny>, fields: &[&str]) -> PyResult<Reduced<'py>> {
    let values = fields.iter().map(|field| record.getattr(*field));
    let values = PyTuple::new(record.py(), values.collect::<PyResult<Vec<_>>>()?)?;
    Ok((record.get_type(), values))
}
