//! Values at many parameters, in parallel: blocks of fixed size, each lifted from coordinates in a frame by one
//! product.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::ORDER;
use crate::linalg::product::mul_into;
use crate::linalg::structure::{check_finite_scalar, check_range};
use crate::threads::{self, ALWAYS};

/// Parameters per block: enough for an efficient product, few enough to balance the load.
const BLOCK: usize = 64;

/// Rows of one piece of a lift: with some tens of frame columns it fits into the L2 cache.
const LIFT_ROWS: usize = 512;

/// Coordinates below this can be lifted without overflow.
const HUGE: f64 = 1e300;

/// Values of a curve at many parameters.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt, Quantity, QuasiGeodesic};
/// let circle = QuasiGeodesic::from_velocity(mat![[1.0], [0.0]].as_ref(), mat![[0.0], [1.0]].as_ref())?;
/// let t = [0.0, 0.1, 0.2, 0.3];
/// let points = circle.sample(&t, Quantity::Derivative(0), Interrupt::NEVER)?;
/// assert_eq!((points.len(), points.get(2).shape()), (4, (2, 1)));
/// for (t, point) in t.iter().zip(points.iter()) {
///     assert!((point - mat![[t.cos()], [t.sin()]]).norm_l2() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    n: usize,
    k: usize,
    entries: Vec<f64>,
}

impl Samples {
    /// Built from the entries of all values, each in column-major order.
    pub(crate) fn from_entries(n: usize, k: usize, entries: Vec<f64>) -> Self {
        debug_assert_eq!(entries.len() % (n * k), 0);
        Samples { n, k, entries }
    }

    fn zeros(n: usize, k: usize, len: usize) -> Result<Self> {
        let entries = zeros(n * k, len)?;
        Ok(Samples { n, k, entries })
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.entries.len() / (self.n * self.k)
    }

    /// Whether there are no parameters.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The value at the `i`-th parameter, shape `(n, k)`.
    ///
    /// # Panics
    /// If `i >= len()`, as for a slice.
    pub fn get(&self, i: usize) -> MatRef<'_, f64> {
        let size = self.n * self.k;
        MatRef::from_column_major_slice(&self.entries[i * size..(i + 1) * size], self.n, self.k)
    }

    /// All values in parameter order.
    pub fn iter(&self) -> impl Iterator<Item = MatRef<'_, f64>> {
        (0..self.len()).map(|i| self.get(i))
    }

    /// The entries, value by value, each in column-major order.
    pub fn into_entries(self) -> Vec<f64> {
        self.entries
    }
}

/// Where to sample, the required derivative order, and the interrupt.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub(super) t: &'a [f64],
    pub(super) order: usize,
    pub(super) interrupt: Interrupt<'a>,
}

/// Values of shape `(n, k)`, lifted from coordinates if there is a frame.
///
/// `reader` creates, for one thread, the closure that writes the coordinates at the parameters of a block side by side.
pub(super) fn values<R>(
    [n, k]: [usize; 2],
    frame: Option<MatRef<'_, f64>>,
    request: Request<'_>,
    reader: impl Fn() -> R + Sync,
) -> Result<Samples>
where
    R: FnMut(&[f64], MatMut<'_, f64>) -> Result<()>,
{
    let mut out = Samples::zeros(n, k, request.t.len())?;
    let (columns, rows) = (
        k * request.t.len().min(BLOCK),
        frame.map_or(0, |frame| frame.ncols()),
    );
    for_blocks([n, k], request, &mut out.entries, || {
        let (mut read, mut coordinates) = (reader(), Mat::zeros(rows, columns));
        move |t: &[f64], out: MatMut<'_, f64>| match frame {
            Some(frame) => {
                let low = coordinates.as_mut().subcols_mut(0, k * t.len());
                read_lifted(&mut read, frame, t, low, out)
            }
            None => read_checked(&mut read, t, out),
        }
    })?;
    Ok(out)
}

/// The coordinates themselves, side by side, shape `(rows, k len)`.
pub(super) fn coordinates<R>(
    [rows, k]: [usize; 2],
    request: Request<'_>,
    reader: impl Fn() -> R + Sync,
) -> Result<Mat<f64>>
where
    R: FnMut(&[f64], MatMut<'_, f64>) -> Result<()>,
{
    let mut out = zeros(rows * k, request.t.len())?;
    for_blocks([rows, k], request, &mut out, || {
        let mut read = reader();
        move |t: &[f64], out: MatMut<'_, f64>| read_checked(&mut read, t, out)
    })?;
    let all = MatRef::from_column_major_slice(&out, rows, k * request.t.len());
    Ok(all.to_owned())
}

/// Zeros for values of `size` entries at `len` parameters, or an error if there is not enough memory.
fn zeros(size: usize, len: usize) -> Result<Vec<f64>> {
    let mut out = Vec::new();
    match size.checked_mul(len) {
        Some(total) if out.try_reserve_exact(total).is_ok() => {
            out.resize(total, 0.0);
            Ok(out)
        }
        _ => Err(Error::InvalidArgument {
            name: "t",
            requirement: "few enough parameters for the values to fit in memory",
            found: len as f64,
        }),
    }
}

/// Values from coordinates: `out = frame * coordinates`, rows in parallel.
///
/// Pieces of rows stay in the cache for all columns; each entry is computed in the same way on any number of threads.
pub fn lift_into(frame: MatRef<'_, f64>, coordinates: MatRef<'_, f64>, out: MatMut<'_, f64>) {
    let n = frame.nrows();
    if n <= LIFT_ROWS {
        return mul_into(out, 1.0, frame, coordinates);
    }
    let middle = (n / 2).next_multiple_of(LIFT_ROWS);
    let (upper, lower) = out.split_at_row_mut(middle);
    let (frame_upper, frame_lower) = frame.split_at_row(middle);
    threads::join(
        || lift_into(frame_upper, coordinates, upper),
        || lift_into(frame_lower, coordinates, lower),
    );
}

/// Calls a closure, created by `make` as often as needed, for each block of parameters and the columns of `rows` entries
/// that belong to it.
fn for_blocks<W>(
    [rows, k]: [usize; 2],
    request: Request<'_>,
    out: &mut [f64],
    make: impl Fn() -> W + Sync,
) -> Result<()>
where
    W: FnMut(&[f64], MatMut<'_, f64>) -> Result<()>,
{
    let Request {
        t,
        order,
        interrupt,
    } = request;
    if order > ORDER {
        let found = order as f64;
        return Err(Error::InvalidArgument {
            name: "nu",
            requirement: "0, 1, 2 or 3",
            found,
        });
    }
    if let Some(index) = t.iter().position(|t| !t.is_finite()) {
        return Err(Error::NonFinite { name: "t", index });
    }
    let block = |write: &mut W, (out, t): (&mut [f64], &[f64])| {
        interrupt.check("curve sampling")?;
        let columns = MatMut::from_column_major_slice_mut(out, rows, k * t.len());
        write(t, columns)
    };
    // A single block is not worth waking the thread pool.
    if t.len() <= BLOCK {
        return block(&mut make(), (out, t));
    }
    let blocks = out.chunks_mut(rows * k * BLOCK).zip(t.chunks(BLOCK));
    threads::map_parts(blocks, ALWAYS, make, |write, _, (out, t)| {
        block(write, (out, t))
    })?;
    Ok(())
}

/// Writes the values of a block: coordinates, via `low`, and their lift.
fn read_lifted(
    read: impl FnMut(&[f64], MatMut<'_, f64>) -> Result<()>,
    frame: MatRef<'_, f64>,
    t: &[f64],
    mut low: MatMut<'_, f64>,
    mut columns: MatMut<'_, f64>,
) -> Result<()> {
    read_checked(read, t, low.rb_mut())?;
    lift_into(frame, low.rb(), columns.rb_mut());
    // The frame's columns have length one, so only sums of huge numbers can overflow.
    if low.norm_max() > HUGE {
        return check_range("curve", columns.rb());
    }
    Ok(())
}

/// Writes the coordinates of a block, checked to be finite.
fn read_checked(
    mut read: impl FnMut(&[f64], MatMut<'_, f64>) -> Result<()>,
    t: &[f64],
    mut out: MatMut<'_, f64>,
) -> Result<()> {
    read(t, out.rb_mut())?;
    check_range("curve", out.rb())
}

/// Number of units in the last place of the larger end by which a parameter may miss an end and still count as that
/// end: rounding of a parameter computed by summation.
const ROUNDING: f64 = 4.0;

/// The parameter, or the end of an interval that it misses by rounding only.
pub(crate) fn rounded_to_end(t: f64, (first, last): (f64, f64)) -> f64 {
    let slack = ROUNDING * f64::EPSILON * first.abs().max(last.abs());
    match (first - slack..=last + slack).contains(&t) {
        true => t.clamp(first, last),
        false => t,
    }
}

/// Return `NonFinite` if a curve parameter is NaN or infinite.
pub(crate) fn check_parameter(t: f64) -> Result<()> {
    check_finite_scalar("t", t)
}
