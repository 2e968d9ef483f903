//! Masked arrays of NumPy, which are refused where entries are masked.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

use super::convert::Any;
use super::error::invalid;

static MASKED_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static COUNT_MASKED: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// Error where an array, or one in a list, has masked entries: NumPy would read the numbers under the mask. Readers in Python
/// call it too.
#[pyfunction]
pub fn _check_unmasked(name: &str, object: &Any) -> PyResult<()> {
    let (masked, entries) = count_masked(object)?;
    if masked == 0 {
        return Ok(());
    }
    let verb = if masked == 1 { "is" } else { "are" };
    Err(invalid!(
        "{name}: {masked} of {entries} entries {verb} masked; fill or remove them"
    ))
}

/// Masked entries of all masked arrays in an object, and all entries of these.
fn count_masked(object: &Any) -> PyResult<(usize, usize)> {
    if object.is_exact_instance_of::<PyFloat>() || object.is_exact_instance_of::<PyInt>() {
        return Ok((0, 0));
    }
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        return object.try_iter()?.try_fold((0, 0), |sum, item| {
            let (masked, entries) = count_masked(&item?)?;
            Ok((sum.0 + masked, sum.1 + entries))
        });
    }
    let py = object.py();
    let class = MASKED_ARRAY.import(py, "numpy.ma", "MaskedArray")?;
    if !object.is_instance(class)? {
        return Ok((0, 0));
    }
    let masked = COUNT_MASKED.import(py, "numpy.ma", "count_masked")?;
    let masked = masked.call1((object,))?.extract()?;
    Ok((masked, object.getattr("size")?.extract()?))
}
