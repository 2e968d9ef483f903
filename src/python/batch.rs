//! Batches: arrays whose last axes hold one member each, and functions applied to every member.

use numpy::{Complex64, PyArrayDescrMethods};

use super::convert::entries;
use super::prelude::*;
use crate::linalg::complex_embedding::embed_into;
use crate::threads::{self, ALWAYS};

/// A batch of matrices (or of rows, with `cols = 1`): leading axes and entries, each matrix row by row. Complex
/// matrices are embedded.
#[derive(Clone)]
pub struct Batch {
    /// The leading axes.
    pub shape: Vec<usize>,
    pub rows: usize,
    pub cols: usize,
    /// Whether the numbers have single precision or less.
    pub single: bool,
    field: Field,
    entries: Vec<f64>,
}

impl Batch {
    /// Matrices one after the other, of shape `(count, rows, cols)`; complex matrices are already embedded.
    pub fn of([count, rows, cols]: [usize; 3], entries: Vec<f64>, field: Field) -> Self {
        debug_assert_eq!(entries.len(), count * rows * cols);
        Batch {
            shape: vec![count],
            rows,
            cols,
            single: false,
            field,
            entries,
        }
    }

    /// Matrices of shape `own` from an array of real or complex numbers with the given leading axes.
    pub fn read_of(
        field: Field,
        lead: &[usize],
        own: [usize; 2],
        array: &Bound<'_, PyUntypedArray>,
    ) -> PyResult<Self> {
        let [rows, cols] = own;
        let entries = match field {
            Field::Real => entries(array)?,
            Field::Complex => embedded(&entries(array)?, own),
        };
        Ok(Batch {
            shape: lead.to_vec(),
            rows: field.embedded(rows),
            cols: field.embedded(cols),
            single: is_single(array),
            field,
            entries,
        })
    }

    /// One member as a batch without axes.
    pub fn member(&self, i: usize) -> Self {
        Batch {
            shape: Vec::new(),
            entries: self.row(i).to_vec(),
            ..*self
        }
    }

    /// Replaces one member.
    pub fn repeat(&mut self, from: usize, to: usize) {
        let size = self.rows * self.cols;
        self.entries
            .copy_within(from * size..(from + 1) * size, to * size);
    }

    /// The number of matrices.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// The number of entries.
    pub fn numbers(&self) -> f64 {
        self.entries.len() as f64
    }

    /// The `i`-th matrix.
    pub fn get(&self, i: usize) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(self.row(i), self.rows, self.cols)
    }

    /// All matrices.
    pub fn views(&self) -> Vec<MatRef<'_, f64>> {
        (0..self.len()).map(|i| self.get(i)).collect()
    }

    /// Changes every member by `one`, in blocks of at least so many members, unless there are fewer.
    pub fn change(
        &mut self,
        least: usize,
        one: impl Fn(usize, &mut [f64]) -> Result<()> + Sync,
    ) -> std::result::Result<(), Failure> {
        let blocks = (self.len() / least).max(1);
        let (size, block) = (self.rows * self.cols, self.len().div_ceil(blocks));
        in_blocks(&mut self.entries, [size, block], &one)
    }

    /// The `i`-th member as a slice.
    pub fn row(&self, i: usize) -> &[f64] {
        let size = self.rows * self.cols;
        &self.entries[i * size..(i + 1) * size]
    }

    /// The shape of a matrix as given, before any embedding.
    pub fn own_shape(&self) -> (usize, usize) {
        self.field.own((self.rows, self.cols))
    }

    /// The field of the matrices as given.
    pub fn field(&self) -> Field {
        self.field
    }

    /// All matrices, in the layout of the core.
    pub(crate) fn into_array(self) -> Array {
        let shape = [&self.shape[..], &[self.rows, self.cols]].concat();
        let entries = self.entries;
        Array { shape, entries }
    }

    /// Return `InvalidInputError` unless the members have the given shape; also checks an empty batch.
    pub fn check_shape(&self, name: &str, (n, k): (usize, usize)) -> PyResult<()> {
        let (rows, cols) = self.own_shape();
        ensure!(
            (rows, cols) == (n, k),
            "{name}: expected shape (..., {n}, {k}), found (..., {rows}, {cols})"
        );
        Ok(())
    }
}

/// Read arrays of real matrices, shape `(..., rows, cols)`, and broadcast their leading axes.
pub fn matrix_batches<const N: usize>(objects: [Named<'_, '_>; N]) -> PyResult<[Batch; N]> {
    Field::Real.batches(objects)
}

/// Whether the numbers of an array have single precision or less.
fn is_single(array: &Bound<'_, PyUntypedArray>) -> bool {
    let dtype = array.dtype();
    match dtype.kind() {
        b'f' => dtype.itemsize() <= size_of::<f32>(),
        b'c' => dtype.itemsize() <= 2 * size_of::<f32>(),
        _ => false,
    }
}

/// Embeds complex matrices of the given shape, one after the other, row by row.
fn embedded(entries: &[Complex64], [rows, cols]: [usize; 2]) -> Vec<f64> {
    let size = (rows * cols).max(1);
    let mut out = vec![0.0; 4 * entries.len()];
    for (matrix, out) in entries.chunks(size).zip(out.chunks_mut(4 * size)) {
        let matrix = MatRef::from_row_major_slice(matrix, rows, cols);
        let out = MatMut::from_row_major_slice_mut(out, 2 * rows, 2 * cols);
        embed_into(out, matrix);
    }
    out
}

/// Reads arrays whose last one or two axes hold one member each, and broadcasts the other axes. Complex members have
/// two.
pub fn read_batches<const N: usize>(
    field: Field,
    objects: [Named<'_, '_>; N],
    core: usize,
) -> PyResult<[Batch; N]> {
    debug_assert!(core == 2 || field == Field::Real);
    let py = objects[0].0.py();
    let mut arrays = collected(objects.map(|(object, name)| {
        let array = field.array(object, name)?;
        let expected = if core == 2 { "(..., n, k)" } else { "(..., d)" };
        match array.ndim() < core {
            true => Err(unexpected(name, expected, array.shape())),
            false => Ok(array),
        }
    }))?;
    let lead = |array: &Bound<'_, PyUntypedArray>| array.shape()[..array.ndim() - core].to_vec();
    let mut shape = lead(&arrays[0]);
    if arrays.iter().any(|array| lead(array) != shape) {
        let shapes = arrays.each_ref().map(|array| PyTuple::new(py, lead(array)));
        let shapes = PyTuple::new(py, collected(shapes)?)?;
        let common = numpy(py)?.call_method1("broadcast_shapes", shapes);
        let common = common.map_err(|error| invalid!("{}", error.value(py)))?;
        shape = common.extract()?;
        for array in &mut arrays {
            let full = [&shape, &array.shape()[array.ndim() - core..]].concat();
            let arguments = (array.as_any(), PyTuple::new(py, full)?);
            let broadcast = numpy(py)?.call_method1("broadcast_to", arguments)?;
            *array = broadcast.cast_into()?;
        }
    }
    collected(arrays.each_ref().map(|array| {
        let own = &array.shape()[array.ndim() - core..];
        let own = [own[0], own.get(1).copied().unwrap_or(1)];
        Batch::read_of(field, &shape, own, array)
    }))
}

/// The value of a function for one member of a batch.
pub trait Value {
    /// Write its entries row by row.
    fn put(&self, out: &mut [f64]);
}

impl Value for Mat<f64> {
    fn put(&self, out: &mut [f64]) {
        write(self.as_ref(), out);
    }
}

impl Value for f64 {
    fn put(&self, out: &mut [f64]) {
        out[0] = *self;
    }
}

/// The index of a member and its error.
pub type Failure = (usize, Error);

/// A function of one member of several batches, which writes its value.
type Member = dyn Fn(&[Batch], usize, &mut [f64], Interrupt<'_>) -> Result<()> + Send + Sync;

/// Applies `member` to every member of a batch, in parallel if worthwhile; the results, of shape `core` each, have the
/// leading axes of the batch. If several members fail, the error of the first is returned.
pub fn map_batch<const N: usize>(
    call: &Call<'_>,
    batches: [Batch; N],
    core: &[usize],
    member: impl Fn([&Batch; N], usize, &mut [f64], Interrupt<'_>) -> Result<()> + Shared,
) -> PyResult<Array> {
    let member = move |batches: &[Batch], i: usize, out: &mut [f64], interrupt: Interrupt<'_>| {
        member(std::array::from_fn(|b| &batches[b]), i, out, interrupt)
    };
    map_members(call, batches.into(), core, Box::new(member))
}

/// [`map_batch`], compiled once for all functions.
fn map_members(
    call: &Call<'_>,
    batches: Vec<Batch>,
    core: &[usize],
    member: Box<Member>,
) -> PyResult<Array> {
    let (len, lead) = (batches[0].len(), batches[0].shape.clone());
    let size = core
        .iter()
        .fold(1, |size: usize, axis| size.saturating_mul(*axis));
    let (distributed, block) = (len > 1 && call.is_long(), call.block(len));
    let mut out = Vec::new();
    let total = len.checked_mul(size);
    let Some(total) = total.filter(|total| out.try_reserve_exact(*total).is_ok()) else {
        let message = format!("cannot hold {len} results of {size} numbers");
        return Err(PyMemoryError::new_err(message));
    };
    let call = call.distributed(distributed);
    let (done, entries) = call.run_any(move |interrupt| {
        // Filled where it can be interrupted: the first access to gigabytes takes seconds.
        out.resize(total, 0.0);
        let one = |i: usize, target: &mut [f64]| {
            interrupt.check("batch")?;
            member(&batches, i, target, interrupt)?;
            // Free of branches in the loop over the entries.
            match target.iter().fold(true, |all, x| all & x.is_finite()) {
                true => Ok(()),
                false => Err(Error::Overflow { quantity: "result" }),
            }
        };
        // Visits every member even if the result is empty.
        let done = match size {
            0 => (0..len).try_for_each(|i| one(i, &mut []).map_err(|error| (i, error))),
            _ if distributed => in_blocks(&mut out, [size, block], &one),
            _ => in_blocks(&mut out, [size, len], &one),
        };
        (done, out)
    })?;
    match done {
        Err((i, error)) => Err(at_member(&call.explained(error), i, &lead)),
        Ok(()) => Ok(Array {
            shape: [&lead, core].concat(),
            entries,
        }),
    }
}

/// Calls `one` for every member of a size, in blocks of so many members, which are distributed among threads.
fn in_blocks(
    entries: &mut [f64],
    [size, block]: [usize; 2],
    one: &(dyn Fn(usize, &mut [f64]) -> Result<()> + Sync),
) -> std::result::Result<(), Failure> {
    if entries.is_empty() {
        return Ok(());
    }
    let blocks = entries.chunks_mut(size * block);
    let of_block = |(): &mut (), b: usize, members: &mut &mut [f64]| {
        for (i, member) in members.chunks_mut(size).enumerate() {
            let i = b * block + i;
            one(i, member).map_err(|error| (i, error))?;
        }
        Ok(())
    };
    threads::map_parts(blocks, ALWAYS, || (), of_block)?;
    Ok(())
}
