//! Complex arrays in and out: their numbers as pairs of real ones.

use super::array_namespace::as_numpy;
use super::convert::_check_unmasked;
use super::prelude::*;

/// Converts an array-like object to a NumPy array, and tells whether its numbers are complex.
///
/// # Errors
/// `InvalidInputError` if entries are masked; errors of NumPy.
pub fn array_of<'py>(object: &Any<'py>, name: &str) -> PyResult<(Any<'py>, bool)> {
    _check_unmasked(name, object)?;
    let array = as_numpy(object, name)?;
    let kind: char = array.getattr("dtype")?.getattr("kind")?.extract()?;
    Ok((array, kind == 'c'))
}

/// Real and imaginary parts of a complex array as pairs: float64 in C order, with the last axis twice as long. Accepts
/// any strides, byte order and precision; the array must have at least one axis, and no axis of length 0.
pub fn pairs<'py>(array: &Any<'py>) -> PyResult<Any<'py>> {
    let requirements = ("C_CONTIGUOUS", "ALIGNED");
    let arguments = (array, "complex128", requirements);
    let plain = numpy(array.py())?.call_method1("require", arguments)?;
    plain.call_method1("view", ("float64",))
}

/// The complex array of pairs of real numbers.
pub fn of_pairs<'py>(array: &Any<'py>) -> PyResult<Any<'py>> {
    array.call_method1("view", ("complex128",))
}
