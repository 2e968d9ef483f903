//! `__repr__` and `__reduce__` of classes that only consist of fields.

use pyo3::prelude::*;
use pyo3::types::{PyTuple, PyType};

/// Defines both methods for a class with the given fields: `record! { PyReport, converged, residual }`.
macro_rules! record {
    ($class:ty, $($field:ident),+) => {
        #[pymethods]
        impl $class {
            /// For pickle and copy.
            fn __reduce__<'py>(
                slf: &Bound<'py, Self>,
            ) -> PyResult<$crate::python::record::Reduced<'py>> {
                $crate::python::record::reduce(slf, &[$(stringify!($field)),+])
            }

            fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
                $crate::python::record::repr(slf, &[$(stringify!($field)),+])
            }
        }
    };
}
pub(super) use record;

/// `Name(field=value, ...)`.
pub fn repr(record: &Bound<'_, PyAny>, fields: &[&str]) -> PyResult<String> {
    let word = |field: &&str| Ok(format!("{field}={}", record.getattr(*field)?.repr()?));
    let words = fields.iter().map(word).collect::<PyResult<Vec<_>>>()?;
    let name = record.get_type().name()?;
    Ok(format!("{name}({})", words.join(", ")))
}

/// Return value of `__reduce__`.
pub type Reduced<'py> = (Bound<'py, PyType>, Bound<'py, PyTuple>);

/// The class and its arguments, for pickle and copy.
pub fn reduce<'py>(record: &Bound<'py, PyAny>, fields: &[&str]) -> PyResult<Reduced<'py>> {
    let values = fields.iter().map(|field| record.getattr(*field));
    let values = PyTuple::new(record.py(), values.collect::<PyResult<Vec<_>>>()?)?;
    Ok((record.get_type(), values))
}
