//! NumPy arrays in and out: coercion, reading, writing.

use faer::{Mat, MatRef};
use numpy::{
    Element, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyMemoryError, PyOverflowError, PyTypeError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PySlice, PyTuple};

use super::error::invalid_input;
use super::masked::check_unmasked;

/// Numbers copied between two checks for Ctrl-C (1 MB), a fraction of a millisecond. The first touch of fresh memory is
/// slower: on a busy virtual machine 432 MB took 4 s, and Ctrl-C with them.
const PIECE: usize = 1 << 17;

/// A Python object, such as an argument that has not been read yet.
pub type Any<'py> = Bound<'py, PyAny>;

/// An argument with the name that messages give it.
pub type Named<'a, 'py> = (&'a Any<'py>, &'static str);

/// Arguments with their names: `named![S, V]` is `[(S, "S"), (V, "V")]`.
macro_rules! named {
    ($($argument:ident),+) => { [$(($argument, stringify!($argument))),+] };
}
pub(super) use named;

/// Loads NumPy's C interface, which otherwise happens in the first call of a function: there Ctrl-C would make it a panic.
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

/// A float64 array from anything array-like, by same-kind casting: `TypeError` for complex numbers, text and objects.
///
/// # Errors
/// Besides, `InvalidInputError` where entries are masked.
pub fn float_array<'py>(object: &Any<'py>, name: &str) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if !object.is_exact_instance_of::<PyUntypedArray>() {
        check_unmasked(object, name)?;
    }
    if let Ok(array) = object.cast::<PyArrayDyn<f64>>()
        && is_plain(array)
    {
        return Ok(array.readonly());
    }
    let py = object.py();
    let numpy = numpy(py)?;
    let float64 = numpy.getattr(intern!(py, "float64"))?;
    let array = numpy.call_method1(intern!(py, "asarray"), (object,))?;
    let dtype = array.getattr(intern!(py, "dtype"))?;
    let casting = (&dtype, &float64, "same_kind");
    let castable = numpy.call_method1(intern!(py, "can_cast"), casting)?;
    if !castable.extract::<bool>()? {
        let kind: char = dtype.getattr("kind")?.extract()?;
        let advice = match kind {
            'O' => "; numbers among objects become real ones by astype(float)",
            _ => "",
        };
        return Err(PyTypeError::new_err(format!(
            "{name}: expected real numbers, found an array of dtype {dtype}{advice}"
        )));
    }
    // Contiguous and aligned: a view may have strides that are no multiple of an entry's size.
    let plain = match converted_in_pieces(&array)? {
        Some(plain) => plain,
        None => numpy.call_method1("require", (array, float64, ("C_CONTIGUOUS", "ALIGNED")))?,
    };
    Ok(plain.cast_into::<PyArrayDyn<f64>>()?.readonly())
}

fn is_plain(array: &Bound<'_, PyArrayDyn<f64>>) -> bool {
    array.is_c_contiguous() && array.data().is_aligned()
}

/// A contiguous float64 copy of a large array, made in pieces of its first axis with checks for Ctrl-C in between; `None`
/// for a small array, and for one that needs no copy.
fn converted_in_pieces<'py>(array: &Any<'py>) -> PyResult<Option<Any<'py>>> {
    let py = array.py();
    if array.cast::<PyArrayDyn<f64>>().is_ok_and(is_plain) {
        return Ok(None);
    }
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let row: usize = shape.iter().skip(1).product();
    let rows = (PIECE / row.max(1)).max(1);
    if shape.first().is_none_or(|&count| count <= rows) {
        return Ok(None);
    }
    let out = numpy(py)?.call_method1("empty", (PyTuple::new(py, &shape)?,))?;
    for start in (0..shape[0]).step_by(rows) {
        let piece = PySlice::new(py, start as isize, (start + rows) as isize, 1);
        out.set_item(&piece, array.get_item(&piece)?)?;
        py.check_signals()?;
    }
    Ok(Some(out))
}

/// The entries in C order, copied in pieces with checks for Ctrl-C in between.
pub fn entries_of(array: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<Vec<f64>> {
    let py = array.py();
    if let Ok(entries) = array.as_slice() {
        return copy(py, entries);
    }
    let array = array.as_array();
    let mut out = reserved(array.len())?;
    let mut entries = array.iter();
    while out.len() < array.len() {
        out.extend(entries.by_ref().take(PIECE));
        py.check_signals()?;
    }
    Ok(out)
}

/// A copy, made in pieces with checks for Ctrl-C in between.
pub fn copy(py: Python<'_>, entries: &[f64]) -> PyResult<Vec<f64>> {
    let mut out = reserved(entries.len())?;
    for (i, piece) in entries.chunks(PIECE).enumerate() {
        if i > 0 {
            py.check_signals()?;
        }
        out.extend_from_slice(piece);
    }
    Ok(out)
}

fn reserved(len: usize) -> PyResult<Vec<f64>> {
    let mut out = Vec::new();
    match out.try_reserve_exact(len) {
        Ok(()) => Ok(out),
        Err(_) => Err(PyMemoryError::new_err(format!("cannot hold {len} numbers"))),
    }
}

/// Read an array with `D` axes: its shape and its entries in C order. Errors state `expected` as the shape.
pub fn read<const D: usize>(
    (object, name): Named<'_, '_>,
    expected: &str,
) -> PyResult<([usize; D], Vec<f64>)> {
    let array = float_array(object, name)?;
    if let Ok(shape) = <[usize; D]>::try_from(array.shape()) {
        return Ok((shape, entries_of(&array)?));
    }
    let found = tuple(array.shape());
    let message = format!("{name}: expected shape {expected}, found {found}");
    Err(invalid_input(message))
}

/// One matrix, shape `(n, k)`.
pub fn matrix(object: &Any<'_>, name: &'static str) -> PyResult<Mat<f64>> {
    let ([rows, cols], entries) = read((object, name), "(n, k)")?;
    Ok(MatRef::from_row_major_slice(&entries, rows, cols).to_owned())
}

/// Read several matrices.
pub fn matrices<const N: usize>(objects: [Named<'_, '_>; N]) -> PyResult<[Mat<f64>; N]> {
    collected(objects.map(|(object, name)| matrix(object, name)))
}

/// The number of entries of all matrices.
pub fn numbers<const N: usize>(matrices: &[Mat<f64>; N]) -> f64 {
    let entries = |matrix: &Mat<f64>| matrix.nrows() * matrix.ncols();
    matrices.iter().map(entries).sum::<usize>() as f64
}

/// Collect all values, or return the first error.
pub fn collected<T, const N: usize>(results: [PyResult<T>; N]) -> PyResult<[T; N]> {
    let values: Vec<T> = results.into_iter().collect::<PyResult<_>>()?;
    match values.try_into() {
        Ok(values) => Ok(values),
        Err(_) => unreachable!("one value per result"),
    }
}

/// Parameters of any shape: the shape and the values.
pub fn parameters(object: &Any<'_>, name: &'static str) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let array = float_array(object, name)?;
    Ok((array.shape().to_vec(), entries_of(&array)?))
}

/// Two matrices from any pair: a tuple, a list, an array of shape (2, n, k).
pub fn matrix_pair(
    object: &Any<'_>,
    name: &'static str,
    parts: [&'static str; 2],
) -> PyResult<[Mat<f64>; 2]> {
    let items = object.try_iter()?.take(3).collect::<PyResult<Vec<_>>>()?;
    let [first, second] = &items[..] else {
        let (expected, count) = (parts.join(", "), items.len());
        let found = if count == 3 {
            "more".to_owned()
        } else {
            count.to_string()
        };
        let message = format!("{name}: expected two items ({expected}), found {found}");
        return Err(invalid_input(message));
    };
    matrices([(first, parts[0]), (second, parts[1])])
}

/// A whole number of any size; what is too large for the core counts as its largest number.
pub fn whole(object: &Any<'_>) -> PyResult<i64> {
    match object.extract::<i64>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
            Ok(if object.lt(0)? { i64::MIN } else { i64::MAX })
        }
        other => other,
    }
}

/// Makes an array read-only: results belong to frozen objects.
pub fn freeze(array: &Any<'_>) -> PyResult<()> {
    let write = PyDict::new(array.py());
    write.set_item("write", false)?;
    array.call_method("setflags", (), Some(&write)).map(drop)
}

/// Check that a whole number is at least `least`.
pub fn count(name: &str, value: i64, least: i64) -> PyResult<usize> {
    match usize::try_from(value) {
        Ok(count) if value >= least => Ok(count),
        _ => {
            let message = format!("{name}: must be at least {least}, found {value}");
            Err(invalid_input(message))
        }
    }
}

/// Entries and shape of a result; converted to a NumPy array when a method returns it.
pub struct NewArray {
    pub shape: Vec<usize>,
    pub entries: Vec<f64>,
}

impl<'py> IntoPyObject<'py> for NewArray {
    type Target = PyArrayDyn<f64>;
    type Output = Bound<'py, Self::Target>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        to_array(py, self.entries, &self.shape)
    }
}

impl NewArray {
    /// An array of matrices of shape `(n, k)` with the leading axes `lead`.
    pub fn stacked(lead: &[usize], matrices: &[Mat<f64>], (n, k): (usize, usize)) -> Self {
        let mut entries = vec![0.0; matrices.len() * n * k];
        for (matrix, out) in matrices.iter().zip(entries.chunks_mut((n * k).max(1))) {
            write(matrix.as_ref(), out);
        }
        let shape = [lead, &[n, k]].concat();
        NewArray { shape, entries }
    }
}

impl From<Mat<f64>> for NewArray {
    fn from(matrix: Mat<f64>) -> Self {
        let shape = matrix.shape();
        NewArray::stacked(&[], &[matrix], shape)
    }
}

/// Four arrays as a Python tuple.
pub type Four = (NewArray, NewArray, NewArray, NewArray);

pub fn four(matrices: [Mat<f64>; 4]) -> Four {
    let [first, second, third, fourth] = matrices.map(NewArray::from);
    (first, second, third, fourth)
}

/// Make a read-only array.
pub fn frozen(py: Python<'_>, array: NewArray) -> PyResult<Py<PyArrayDyn<f64>>> {
    let array = array.into_pyobject(py)?;
    freeze(&array)?;
    Ok(array.unbind())
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
    match shape {
        [one] => format!("({one},)"),
        _ => format!(
            "({})",
            shape
                .iter()
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

/// Writes a matrix row by row.
pub fn write(matrix: MatRef<'_, f64>, out: &mut [f64]) {
    let cols = matrix.ncols();
    for i in 0..matrix.nrows() {
        for j in 0..cols {
            out[i * cols + j] = matrix[(i, j)];
        }
    }
}
