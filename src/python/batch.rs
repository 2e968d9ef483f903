//! Batches: arrays whose last axes are one member each, and functions applied to every member.

use rayon::prelude::*;

use super::convert::{entries, real_array};
use super::prelude::*;

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

    /// Read an array of shape `(count, rows, cols)`; errors state `expected` as the shape.
    pub fn read(object: &Any, name: &str, expected: &str) -> PyResult<Self> {
        let (shape, entries) = read_axes(object, name, expected)?;
        Ok(Batch::of(shape, entries))
    }

    /// How many matrices.
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

    /// The `i`-th member as a slice.
    pub fn row(&self, i: usize) -> &[f64] {
        let size = self.rows * self.cols;
        &self.entries[i * size..(i + 1) * size]
    }

    /// The array of all matrices.
    pub fn into_array(self) -> Array {
        let shape = [&self.shape[..], &[self.rows, self.cols]].concat();
        let entries = self.entries;
        Array { shape, entries }
    }

    /// Return `InvalidInputError` unless the members have the given shape; an empty batch is checked too.
    pub fn check_shape(&self, name: &str, (n, k): (usize, usize)) -> PyResult<()> {
        let (rows, cols) = (self.rows, self.cols);
        let expected = format!("{name}: expected shape (..., {n}, {k})");
        ensure!(
            (rows, cols) == (n, k),
            "{expected}, found (..., {rows}, {cols})"
        );
        Ok(())
    }
}

/// Read arrays of matrices, shape `(..., rows, cols)`, and broadcast their leading axes.
pub fn matrix_batches<const N: usize>(objects: [Named<'_, '_>; N]) -> PyResult<[Batch; N]> {
    read_batches(objects, 2)
}

/// Reads arrays whose last axes, one or two, are one member each, and broadcasts the axes before.
pub fn read_batches<const N: usize>(
    objects: [Named<'_, '_>; N],
    core: usize,
) -> PyResult<[Batch; N]> {
    let py = objects[0].0.py();
    let mut arrays = collected(objects.map(|(object, name)| {
        let array = real_array(object, name)?;
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
        Ok(Batch {
            shape: shape.clone(),
            rows: own[0],
            cols: own.get(1).copied().unwrap_or(1),
            entries: entries(array)?,
        })
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

/// For functions that only check their arguments.
impl Value for () {
    fn put(&self, _: &mut [f64]) {}
}

/// Applies `member` to every member of a batch, in parallel where that pays; the results, of shape `core` each, on the
/// axes of the batch. The error reported is that of the first member that has one.
pub fn map_batch<const N: usize>(
    call: &Call<'_>,
    batches: [Batch; N],
    core: &[usize],
    member: impl Fn([&Batch; N], usize, &mut [f64], Interrupt<'_>) -> Result<()> + Shared,
) -> PyResult<Array> {
    let (len, lead) = (batches[0].len(), batches[0].shape.clone());
    let size = core
        .iter()
        .fold(1, |size: usize, axis| size.saturating_mul(*axis));
    let (long, block) = (call.is_long(), call.block(len));
    let mut out = Vec::new();
    let total = len.checked_mul(size);
    let Some(total) = total.filter(|total| out.try_reserve_exact(*total).is_ok()) else {
        let message = format!("cannot hold {len} results of {size} numbers");
        return Err(PyMemoryError::new_err(message));
    };
    let (failure, entries) = call.run_any(move |interrupt| {
        // Filled where it can be interrupted: the first touch of gigabytes takes seconds.
        out.resize(total, 0.0);
        let one = |i: usize, target: &mut [f64]| {
            interrupt.check("batch")?;
            member(batches.each_ref(), i, target, interrupt)?;
            match target.iter().all(|x| x.is_finite()) {
                true => Ok(()),
                false => Err(Error::Overflow { quantity: "result" }),
            }
        };
        let failure = |i: usize, target: &mut [f64]| Some((i, one(i, target).err()?));
        let block_of = |(b, targets): (usize, &mut [f64])| {
            let mut members = targets.chunks_mut(size).enumerate();
            members.find_map(|(i, target)| failure(b * block + i, target))
        };
        // An empty result still has members to visit.
        let failure = if size == 0 {
            (0..len).find_map(|i| failure(i, &mut []))
        } else if long && len > 1 {
            let blocks = out.par_chunks_mut(size * block).enumerate();
            blocks.filter_map(block_of).min_by_key(|(i, _)| *i)
        } else {
            block_of((0, &mut out))
        };
        (failure, out)
    })?;
    match failure {
        Some((i, error)) => Err(at_member(&error, i, &lead)),
        None => Ok(Array {
            shape: [&lead, core].concat(),
            entries,
        }),
    }
}
