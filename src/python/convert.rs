//! NumPy arrays in and out: coercion, batches, broadcasting.

use faer::{Mat, MatRef};
use numpy::{
    Element, PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyMemoryError, PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PySlice, PyTuple};
use rayon::prelude::*;

use super::call::Call;
use super::error::{invalid_input, to_exception};
use super::masked::check_unmasked;
use crate::error::Error;
use crate::interrupt::Interrupt;

static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static REQUIRE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static CAN_CAST: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static FLOAT64: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static BROADCAST_TO: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static BROADCAST_SHAPES: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// Numbers copied between two checks for Ctrl-C (1 MB), a fraction of a millisecond. The first touch of fresh memory is
/// slower: on a busy virtual machine 432 MB took 4 s, and Ctrl-C with them.
const PIECE: usize = 1 << 17;

/// Loads NumPy's C interface, which otherwise happens in the first call of a function: there Ctrl-C would make it a panic.
pub fn load_numpy(py: Python<'_>) -> PyResult<()> {
    py.import("numpy")?;
    PyArray1::<f64>::zeros(py, 0, false);
    Ok(())
}

/// A float64 array from anything array-like, by same-kind casting: `TypeError` for complex numbers, text and objects.
///
/// # Errors
/// Besides, `InvalidInputError` where entries are masked.
pub fn float_array<'py>(
    object: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if !object.is_exact_instance_of::<PyUntypedArray>() {
        check_unmasked(object, name)?;
    }
    if let Ok(array) = object.cast::<PyArrayDyn<f64>>()
        && is_plain(array)
    {
        return Ok(array.readonly());
    }
    let py = object.py();
    let asarray = ASARRAY.import(py, "numpy", "asarray")?;
    let float64 = FLOAT64.import(py, "numpy", "float64")?;
    let array = asarray.call1((object,))?;
    let dtype = array.getattr("dtype")?;
    let castable =
        CAN_CAST
            .import(py, "numpy", "can_cast")?
            .call1((&dtype, float64, "same_kind"))?;
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
        None => {
            let require = REQUIRE.import(py, "numpy", "require")?;
            require.call1((array, float64, ("C_CONTIGUOUS", "ALIGNED")))?
        }
    };
    Ok(plain.cast_into::<PyArrayDyn<f64>>()?.readonly())
}

fn is_plain(array: &Bound<'_, PyArrayDyn<f64>>) -> bool {
    array.is_c_contiguous() && array.data().is_aligned()
}

/// A contiguous float64 copy of a large array, made in pieces of its first axis with checks for Ctrl-C in between; `None`
/// for a small array, and for one that needs no copy.
fn converted_in_pieces<'py>(array: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyAny>>> {
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
    let empty = EMPTY.import(py, "numpy", "empty")?;
    let out = empty.call1((PyTuple::new(py, &shape)?,))?;
    for start in (0..shape[0]).step_by(rows) {
        let piece = PySlice::new(py, start as isize, (start + rows) as isize, 1);
        out.set_item(&piece, array.get_item(&piece)?)?;
        py.check_signals()?;
    }
    Ok(Some(out))
}

/// A batch of matrices (or of rows, with `cols = 1`): leading axes and entries, each matrix row by row.
pub struct Batch {
    /// The leading axes.
    pub shape: Vec<usize>,
    pub rows: usize,
    pub cols: usize,
    entries: Vec<f64>,
}

impl Batch {
    /// Matrices one after the other, of shape `(count, rows, cols)`.
    pub fn of([count, rows, cols]: [usize; 3], entries: Vec<f64>) -> Self {
        debug_assert_eq!(entries.len(), count * rows * cols);
        Batch {
            shape: vec![count],
            rows,
            cols,
            entries,
        }
    }

    /// How many matrices.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// The `i`-th matrix.
    pub fn get(&self, i: usize) -> MatRef<'_, f64> {
        let size = self.rows * self.cols;
        MatRef::from_row_major_slice(
            &self.entries[i * size..(i + 1) * size],
            self.rows,
            self.cols,
        )
    }

    /// All matrices.
    pub fn views(&self) -> Vec<MatRef<'_, f64>> {
        (0..self.len()).map(|i| self.get(i)).collect()
    }

    /// All entries, matrix after matrix, row by row.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// The `i`-th member as a slice.
    pub fn row(&self, i: usize) -> &[f64] {
        let size = self.rows * self.cols;
        &self.entries[i * size..(i + 1) * size]
    }
}

/// Reads arrays whose last `core` axes are one member each, and broadcasts the axes before.
fn read_batches<const N: usize>(
    objects: [(&Bound<'_, PyAny>, &'static str); N],
    core: usize,
) -> PyResult<[Batch; N]> {
    let py = objects[0].0.py();
    let mut arrays = Vec::with_capacity(N);
    for (object, name) in objects {
        let array = float_array(object, name)?;
        if array.ndim() < core {
            let expected = if core == 2 { "(..., n, k)" } else { "(..., d)" };
            let found = array.shape();
            return Err(invalid_input(
                py,
                format!("{name}: expected shape {expected}, found {}", tuple(found)),
            ));
        }
        arrays.push(array);
    }
    let lead = |array: &PyReadonlyArrayDyn<'_, f64>| array.shape()[..array.ndim() - core].to_vec();
    let mut shape = lead(&arrays[0]);
    if arrays.iter().any(|array| lead(array) != shape) {
        let shapes = arrays
            .iter()
            .map(|array| PyTuple::new(py, lead(array)))
            .collect::<PyResult<Vec<_>>>()?;
        let common = BROADCAST_SHAPES
            .import(py, "numpy", "broadcast_shapes")?
            .call1(PyTuple::new(py, shapes)?);
        shape = common
            .map_err(|error| invalid_input(py, error.value(py).to_string()))?
            .extract()?;
        for array in &mut arrays {
            let full: Vec<usize> = shape
                .iter()
                .chain(&array.shape()[array.ndim() - core..])
                .copied()
                .collect();
            let broadcast = BROADCAST_TO.import(py, "numpy", "broadcast_to")?;
            *array = broadcast
                .call1((array.as_any(), PyTuple::new(py, full)?))?
                .cast_into::<PyArrayDyn<f64>>()?
                .readonly();
        }
    }
    let read = |array: &PyReadonlyArrayDyn<'_, f64>| {
        let own = &array.shape()[array.ndim() - core..];
        let (rows, cols) = (own[0], if core == 2 { own[1] } else { 1 });
        Ok(Batch {
            shape: shape.clone(),
            rows,
            cols,
            entries: entries_of(array)?,
        })
    };
    let batches: Vec<_> = arrays.iter().map(read).collect::<PyResult<_>>()?;
    match batches.try_into() {
        Ok(batches) => Ok(batches),
        Err(_) => unreachable!("one batch per object"),
    }
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

/// Arrays of matrices, shape `(..., rows, cols)`.
pub fn matrices<const N: usize>(
    objects: [(&Bound<'_, PyAny>, &'static str); N],
) -> PyResult<[Batch; N]> {
    read_batches(objects, 2)
}

/// Arrays of vectors, shape `(..., d)`.
pub fn vectors<const N: usize>(
    objects: [(&Bound<'_, PyAny>, &'static str); N],
) -> PyResult<[Batch; N]> {
    read_batches(objects, 1)
}

/// One matrix, shape `(rows, cols)`.
pub fn matrix(object: &Bound<'_, PyAny>, name: &'static str) -> PyResult<Mat<f64>> {
    let array = float_array(object, name)?;
    if let [rows, cols] = *array.shape() {
        return Ok(MatRef::from_row_major_slice(&entries_of(&array)?, rows, cols).to_owned());
    }
    let found = tuple(array.shape());
    Err(invalid_input(
        object.py(),
        format!("{name}: expected shape (n, k), found {found}"),
    ))
}

/// Matrices one after the other, shape `(count, rows, cols)`, which `expected` says in words.
pub fn stack(object: &Bound<'_, PyAny>, name: &'static str, expected: &str) -> PyResult<Batch> {
    let array = float_array(object, name)?;
    if let [count, rows, cols] = *array.shape() {
        return Ok(Batch::of([count, rows, cols], entries_of(&array)?));
    }
    let found = tuple(array.shape());
    Err(invalid_input(
        object.py(),
        format!("{name}: expected shape {expected}, found {found}"),
    ))
}

/// Two matrices from any pair: a tuple, a list, an array of shape (2, n, k).
pub fn matrix_pair(
    object: &Bound<'_, PyAny>,
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
        return Err(invalid_input(object.py(), message));
    };
    Ok([matrix(first, parts[0])?, matrix(second, parts[1])?])
}

/// A whole number of any size; what is too large for the core counts as its largest number.
pub fn whole(object: &Bound<'_, PyAny>) -> PyResult<i64> {
    match object.extract::<i64>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(object.py()) => {
            Ok(if object.lt(0)? { i64::MIN } else { i64::MAX })
        }
        other => other,
    }
}

/// Makes an array read-only: results belong to frozen objects.
pub fn freeze<'py>(array: &Bound<'py, PyAny>) -> PyResult<()> {
    let write = PyDict::new(array.py());
    write.set_item("write", false)?;
    array.call_method("setflags", (), Some(&write)).map(drop)
}

/// Parameters of any shape: the shape and the values.
pub fn parameters(
    object: &Bound<'_, PyAny>,
    name: &'static str,
) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let array = float_array(object, name)?;
    Ok((array.shape().to_vec(), entries_of(&array)?))
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

/// Applies `member` to every member of a batch, in parallel where that pays, and writes its result, `size` numbers
/// each. The error reported is that of the first member that has one.
pub fn map_batch<const N: usize>(
    py: Python<'_>,
    call: &Call,
    batches: [Batch; N],
    size: usize,
    member: impl Fn([&Batch; N], usize, &mut [f64], Interrupt<'_>) -> Result<(), Error>
    + Sync
    + Send
    + 'static,
) -> PyResult<Vec<f64>> {
    let one = move |_: &mut (),
                    batches: [&Batch; N],
                    i: usize,
                    out: &mut [f64],
                    interrupt: Interrupt<'_>| { member(batches, i, out, interrupt) };
    map_batch_with(py, call, batches, size, || (), one)
}

/// As [`map_batch`], with buffers made by `make` for a block of members; what they hold must not change a result.
pub fn map_batch_with<W, const N: usize>(
    py: Python<'_>,
    call: &Call,
    batches: [Batch; N],
    size: usize,
    make: impl Fn() -> W + Sync + Send + 'static,
    member: impl Fn(&mut W, [&Batch; N], usize, &mut [f64], Interrupt<'_>) -> Result<(), Error>
    + Sync
    + Send
    + 'static,
) -> PyResult<Vec<f64>> {
    let (len, single) = (batches[0].len(), batches[0].shape.is_empty());
    let long = call.is_long();
    let block = call.block(len);
    let mut out = Vec::new();
    let total = len
        .checked_mul(size)
        .filter(|total| out.try_reserve_exact(*total).is_ok());
    let Some(total) = total else {
        return Err(PyMemoryError::new_err(format!(
            "cannot hold {len} results of {size} numbers"
        )));
    };
    let (failure, out) = call.run_any(py, move |interrupt| {
        // Filled where it can be interrupted: the first touch of gigabytes takes seconds.
        out.resize(total, 0.0);
        let views = batches.each_ref();
        let one = |work: &mut W, i: usize, target: &mut [f64]| {
            let mut result = interrupt
                .check("batch")
                .and_then(|()| member(work, views, i, target, interrupt));
            if result.is_ok() && !target.iter().all(|x| x.is_finite()) {
                result = Err(Error::Overflow { quantity: "result" });
            }
            result.err().map(|error| (i, error))
        };
        let block_of = |(b, targets): (usize, &mut [f64])| {
            let work = &mut make();
            let mut members = targets.chunks_mut(size).enumerate();
            members.find_map(|(i, target)| one(work, b * block + i, target))
        };
        // An empty result (checks only) still has members to visit.
        let failure = if size == 0 {
            let work = &mut make();
            (0..len).find_map(|i| one(work, i, &mut []))
        } else if long && len > 1 {
            let blocks = out.par_chunks_mut(size * block).enumerate();
            blocks.filter_map(block_of).min_by_key(|(i, _)| *i)
        } else {
            let work = &mut make();
            let mut members = out.chunks_mut(size).enumerate();
            members.find_map(|(i, target)| one(work, i, target))
        };
        (failure, out)
    })?;
    match failure {
        None => Ok(out),
        Some((_, error)) if single => Err(to_exception(py, &error, "")),
        Some((i, error)) => Err(to_exception(py, &error, &format!(" (batch member {i})"))),
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
