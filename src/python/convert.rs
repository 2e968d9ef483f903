//! NumPy arrays in and out: conversion, reading, writing.

use faer::{Mat, MatMut, MatRef};
use numpy::{
    Complex64, Element, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyMemoryError, PyOverflowError, PyTypeError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{IntoPyDict, PyFloat, PyInt, PyList, PySlice, PyTuple};

use super::array_namespace::as_numpy;
use super::error::{ensure, invalid};
pub(crate) use crate::stored::Array;

/// Numbers copied between two checks for Ctrl-C (1 MB), a fraction of a millisecond. The first access to new memory is
/// slower: on a busy virtual machine 432 MB took 4 s, and so did the reaction to Ctrl-C.
const PIECE: usize = 1 << 17;

/// A Python object, such as an argument that has not been read yet.
pub type Any<'py> = Bound<'py, PyAny>;

/// An argument with its name in error messages.
pub type Named<'a, 'py> = (&'a Any<'py>, &'static str);

/// Arguments with their names: `named![S, V]` is `[(S, "S"), (V, "V")]`.
macro_rules! named {
    ($($argument:ident),+) => { [$(($argument, stringify!($argument))),+] };
}
pub(super) use named;

/// Loads NumPy's C interface, which otherwise happens in the first call of a function, where Ctrl-C would cause a
/// panic.
pub fn load_numpy(py: Python<'_>) -> PyResult<()> {
    numpy(py)?;
    PyArray1::<f64>::zeros(py, 0, false);
    Ok(())
}

/// The module `numpy`.
pub fn numpy(py: Python<'_>) -> PyResult<&Bound<'_, PyModule>> {
    static NUMPY: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module = NUMPY.get_or_try_init(py, || py.import("numpy").map(Bound::unbind))?;
    Ok(module.bind(py))
}

/// Types of NumPy numbers that the binding reads.
pub trait ArrayEntry: Element + Copy {
    /// Name of the dtype.
    const DTYPE: &str;
    /// Name in messages.
    const WORD: &str;
}

impl ArrayEntry for f64 {
    const DTYPE: &str = "float64";
    const WORD: &str = "real";
}

impl ArrayEntry for Complex64 {
    const DTYPE: &str = "complex128";
    const WORD: &str = "real or complex";
}

/// Converts an array-like object to float64 with same-kind casting: `TypeError` for complex numbers, text and objects.
///
/// # Errors
/// Also `InvalidInputError` if entries are masked.
pub fn real_array<'py>(object: &Any<'py>, name: &str) -> PyResult<Bound<'py, PyUntypedArray>> {
    array_of::<f64>(object, name)
}

/// The same for any numbers.
pub fn array_of<'py, T: ArrayEntry>(
    object: &Any<'py>,
    name: &str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    if !object.is_exact_instance_of::<PyUntypedArray>() {
        _check_unmasked(name, object)?;
    }
    if is_plain::<T>(object) {
        return Ok(object.clone().cast_into()?);
    }
    let py = object.py();
    let numpy = numpy(py)?;
    let array = as_numpy(object, name)?;
    let dtype = array.getattr(intern!(py, "dtype"))?;
    let casting = (&dtype, T::DTYPE, "same_kind");
    let castable = numpy.call_method1(intern!(py, "can_cast"), casting)?;
    if castable.extract()? {
        return Ok(array.cast_into()?);
    }
    let kind: char = dtype.getattr("kind")?.extract()?;
    let advice = match kind {
        'O' => "; convert an object array of numbers with astype(float)",
        _ => "",
    };
    let found = format!("an array of dtype {dtype}{advice}");
    let message = format!("{name}: expected {} numbers, found {found}", T::WORD);
    Err(PyTypeError::new_err(message))
}

/// Raise if an array, or an array in a list, has masked entries: NumPy would read the values under the mask.
///
/// Also called by functions written in Python.
#[pyfunction]
pub fn _check_unmasked(name: &str, object: &Any) -> PyResult<()> {
    let (masked, entries) = count_masked(object)?;
    if masked == 0 {
        return Ok(());
    }
    let verb = if masked == 1 { "is" } else { "are" };
    let found = format!("{masked} of {entries} entries {verb} masked");
    Err(invalid!("{name}: {found}; fill or remove them"))
}

/// Numbers of masked entries and of all entries in the masked arrays of an object.
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
    static MASKED_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let class = MASKED_ARRAY.import(py, "numpy.ma", "MaskedArray")?;
    if !object.is_instance(class)? {
        return Ok((0, 0));
    }
    let module = py.import("numpy.ma")?;
    let masked = module.call_method1("count_masked", (object,))?;
    Ok((masked.extract()?, object.getattr("size")?.extract()?))
}

/// Whether an object is an array of such numbers that can be read as a slice: strides of a view need not be multiples
/// of the entry size.
pub fn is_plain<T: ArrayEntry>(object: &Any) -> bool {
    as_plain::<T>(object).is_some()
}

/// An object as such an array.
fn as_plain<'a, 'py, T: ArrayEntry>(object: &'a Any<'py>) -> Option<&'a Bound<'py, PyArrayDyn<T>>> {
    let array = object.cast::<PyArrayDyn<T>>().ok()?;
    (array.is_c_contiguous() && array.data().is_aligned()).then_some(array)
}

/// The same numbers as a slice: the array itself, or a copy.
fn plain<'py, T: ArrayEntry>(array: Any<'py>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let plain = if is_plain::<T>(&array) {
        array
    } else {
        let requirements = ("C_CONTIGUOUS", "ALIGNED");
        numpy(array.py())?.call_method1("require", (array, T::DTYPE, requirements))?
    };
    Ok(plain.cast_into::<PyArrayDyn<T>>()?.readonly())
}

/// The entries in C order, read in pieces with checks for Ctrl-C between them.
pub fn entries<T: ArrayEntry>(array: &Bound<'_, PyUntypedArray>) -> PyResult<Vec<T>> {
    let (py, len) = (array.py(), array.len());
    // A guard against writers takes longer than copying a few numbers, which nothing can interrupt.
    if len <= PIECE
        && let Some(array) = as_plain::<T>(array)
    {
        return Ok(array.to_vec()?);
    }
    let mut out: Vec<T> = Vec::new();
    if out.try_reserve_exact(len).is_err() {
        return Err(PyMemoryError::new_err(format!("cannot hold {len} numbers")));
    }
    let mut append = |part: Any| {
        for piece in plain::<T>(part)?.as_slice()?.chunks(PIECE) {
            if !out.is_empty() {
                py.check_signals()?;
            }
            out.extend_from_slice(piece);
        }
        PyResult::Ok(())
    };
    // Other arrays are converted one piece at a time.
    let step = match array.shape() {
        [_, row @ ..] if !is_plain::<T>(array) => PIECE / row.iter().product::<usize>().max(1),
        _ => usize::MAX,
    };
    let rows = array.shape().first().copied().unwrap_or(0);
    if step >= rows {
        append(array.as_any().clone())?;
        return Ok(out);
    }
    let step = step.max(1);
    for start in (0..rows).step_by(step) {
        let part = PySlice::new(py, start as isize, (start + step) as isize, 1);
        append(array.get_item(part)?)?;
    }
    Ok(out)
}

/// Read an array of any shape.
pub fn read(object: &Any, name: &str) -> PyResult<Array> {
    let array = real_array(object, name)?;
    let (shape, entries) = (array.shape().to_vec(), entries(&array)?);
    Ok(Array { shape, entries })
}

/// Read an array with `D` axes: its shape and its entries in C order. Errors state `expected` as the shape.
pub fn read_axes<const D: usize>(
    object: &Any,
    name: &str,
    expected: &str,
) -> PyResult<([usize; D], Vec<f64>)> {
    let array = real_array(object, name)?;
    match <[usize; D]>::try_from(array.shape()) {
        Ok(shape) => Ok((shape, entries(&array)?)),
        Err(_) => Err(unexpected(name, expected, array.shape())),
    }
}

/// `InvalidInputError` for an array of a wrong shape.
pub fn unexpected(name: &str, expected: &str, found: &[usize]) -> PyErr {
    let found = tuple(found);
    invalid!("{name}: expected shape {expected}, found {found}")
}

/// Collect all values, or return the first error.
pub fn collected<T, const N: usize>(results: [PyResult<T>; N]) -> PyResult<[T; N]> {
    let values: Vec<T> = results.into_iter().collect::<PyResult<_>>()?;
    match values.try_into() {
        Ok(values) => Ok(values),
        Err(_) => unreachable!("one value per result"),
    }
}

/// The two items of an iterable: a tuple, a list, an array; or else the number of its items, 3 if there are more than
/// two.
pub fn two<'py>(object: &Any<'py>) -> PyResult<Result<[Any<'py>; 2], usize>> {
    let items = object.try_iter()?.take(3).collect::<PyResult<Vec<_>>>()?;
    let found = items.len();
    Ok(items.try_into().map_err(|_| found))
}

/// Whether a word is the second of two permitted words.
pub fn is_second(name: &str, word: &str, [first, second]: [&str; 2]) -> PyResult<bool> {
    let known = [first, second].contains(&word);
    ensure!(
        known,
        "{name}: expected '{first}' or '{second}', found {word:?}"
    );
    Ok(word == second)
}

/// An integer of any size; one too large for the core is replaced by the largest integer of the core.
pub fn whole(object: &Any) -> PyResult<i64> {
    match object.extract::<i64>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
            Ok(if object.lt(0)? { i64::MIN } else { i64::MAX })
        }
        other => other,
    }
}

/// Check that an integer is at least `least`.
pub fn count(name: &str, value: i64, least: i64) -> PyResult<usize> {
    match usize::try_from(value) {
        Ok(count) if value >= least => Ok(count),
        _ => Err(invalid!("{name}: must be at least {least}, found {value}")),
    }
}

impl<'py> IntoPyObject<'py> for Array {
    type Target = PyArrayDyn<f64>;
    type Output = Bound<'py, Self::Target>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        to_array(py, self.entries, &self.shape)
    }
}

impl Array {
    /// Numbers one after the other.
    pub fn flat(entries: Vec<f64>) -> Self {
        let shape = vec![entries.len()];
        Array { shape, entries }
    }

    /// An array of matrices of shape `(n, k)` with the leading axes `lead`.
    pub fn stacked(lead: &[usize], matrices: &[Mat<f64>], (n, k): (usize, usize)) -> Self {
        let mut entries = vec![0.0; matrices.len() * n * k];
        for (matrix, out) in matrices.iter().zip(entries.chunks_mut((n * k).max(1))) {
            write(matrix.as_ref(), out);
        }
        let shape = [lead, &[n, k]].concat();
        Array { shape, entries }
    }

    /// A read-only NumPy array.
    pub fn frozen(self, py: Python<'_>) -> PyResult<Owned> {
        let array = self.into_pyobject(py)?.into_any();
        freeze(&array)?;
        Ok(array.unbind())
    }
}

impl From<Mat<f64>> for Array {
    fn from(matrix: Mat<f64>) -> Self {
        let shape = matrix.shape();
        Array::stacked(&[], &[matrix], shape)
    }
}

/// An array that belongs to an object, with real or complex numbers.
pub type Owned = Py<PyAny>;

/// Makes an array read-only, as results in frozen objects are.
pub fn freeze(array: &Any) -> PyResult<()> {
    let write = [("write", false)].into_py_dict(array.py())?;
    array.call_method("setflags", (), Some(&write)).map(drop)
}

/// A new array of the given shape.
pub fn to_array<'py, T: Element>(
    py: Python<'py>,
    entries: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, entries).reshape(shape.to_vec())
}

/// A shape as Python writes it.
pub fn tuple(shape: &[usize]) -> String {
    let words: Vec<_> = shape.iter().map(usize::to_string).collect();
    let last = if shape.len() == 1 { "," } else { "" };
    format!("({}{last})", words.join(", "))
}

/// Writes a matrix row by row.
pub fn write(matrix: MatRef<'_, f64>, out: &mut [f64]) {
    let (rows, cols) = matrix.shape();
    let out = &mut out[..rows * cols];
    MatMut::from_row_major_slice_mut(out, rows, cols).copy_from(matrix);
}
