//! Complex arrays in and out: their numbers as pairs of real ones.

use super::array_namespace::as_numpy;
use super::convert::_check_unmasked;
use super::prelude::*;

/// The array that NumPy makes of something array-like, and whether its numbers are complex.
///
/// # Errors
/// `InvalidInputError` where entries are masked; what NumPy raises.
pub fn array_of<'py>(object: &Any<'py>, name: &str) -> PyResult<(Any<'py>, bool)> {
    _check_unmasked(name, object)?;
    let array = as_numpy(object, name)?;
    let kind: char = array.getattr("dtype")?.getattr("kind")?.extract()?;
    Ok((array, kind == 'c'))
}

/// Real and imaginary part of each number of a complex array, one after the other: float64 in C order, the last axis twice
/// as long. Any strides, byte order and precision; the array itself has at least one axis, and no axis of length 0.
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
