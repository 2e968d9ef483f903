//! Curves as named arrays of numbers, the form used by files, pickles and serde.
//!
//! Every number that a curve consists of is stored, so that it is restored bit for bit. On reading, all of them are
//! checked: names, counts, finiteness, and the ranges of those with a meaning of their own.

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason, Strategy};

/// Identifies stored curves of this crate.
pub(crate) const FORMAT: &str = "stiefel_rs curve";

/// The version that is written, and the only one that is read.
pub(crate) const VERSION: u64 = 1;

/// Operation named in `Interrupted` errors.
pub(crate) const READER: &str = "reading of a stored curve";

/// Largest magnitude up to which all integers are floating-point numbers.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// An array: its shape, and its entries with the last index varying fastest.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub(crate) struct Array {
    pub(crate) shape: Vec<usize>,
    pub(crate) entries: Vec<f64>,
}

/// Named arrays.
#[derive(Debug, Clone, Default)]
pub(crate) struct Fields(pub(crate) BTreeMap<String, Array>);

/// A curve that can be stored.
pub(crate) trait Stored: Sized {
    /// Its name in the stored form.
    const KIND: &'static str;

    /// Writes all numbers of the curve.
    fn store(&self, fields: &mut Fields);

    /// Builds the curve from the numbers, which are removed from the fields.
    ///
    /// # Errors
    /// `Stored` if the numbers do not form a curve; `Interrupted`.
    fn restore(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Self>;
}

/// A curve that can be stored as a piece of a spline: the pieces share one set of arrays.
pub(crate) trait StoredPiece: Sized {
    /// As [`Stored::KIND`], for a spline of such pieces.
    const SPLINE: &'static str;

    fn store_all(pieces: &[Self], fields: &mut Fields);

    /// # Errors
    /// As [`Stored::restore`].
    fn restore_all(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Vec<Self>>;
}

/// Returns the only piece.
///
/// # Errors
/// `Stored` unless there is exactly one.
pub(crate) fn only<C>(pieces: Vec<C>) -> Result<C> {
    let found = pieces.len();
    match <[C; 1]>::try_from(pieces) {
        Ok([piece]) => Ok(piece),
        Err(_) => Err(refusal(format!("expected one curve, found {found}"))),
    }
}

/// The error for data that is not a stored curve.
pub(crate) fn refusal(problem: String) -> Error {
    Error::Stored { problem }
}

/// Return an error unless format, version and kind can be read.
pub(crate) fn check_header(format: &str, version: u64) -> Result<()> {
    if format != FORMAT {
        return Err(refusal(format!(
            "expected format '{FORMAT}', found '{format}'"
        )));
    }
    if version > VERSION {
        let problem = format!(
            "written by a newer version of the package, form {version}; this version reads form {VERSION}"
        );
        return Err(refusal(problem));
    }
    if version < VERSION {
        return Err(refusal(format!("expected form {VERSION}, found {version}")));
    }
    Ok(())
}

/// A product of counts; `None` if it is too large for any array.
pub(crate) fn product(factors: &[usize]) -> Option<usize> {
    factors.iter().try_fold(1, |a: usize, b| a.checked_mul(*b))
}

impl Fields {
    /// Adds an array of any shape.
    pub(crate) fn put(&mut self, name: &str, shape: &[usize], entries: Vec<f64>) {
        debug_assert_eq!(product(shape), Some(entries.len()));
        let shape = shape.to_vec();
        let before = self.0.insert(name.to_owned(), Array { shape, entries });
        debug_assert!(before.is_none(), "{name} is stored twice");
    }

    /// Adds a one-dimensional array.
    pub(crate) fn put_flat(&mut self, name: &str, entries: Vec<f64>) {
        self.put(name, &[entries.len()], entries);
    }

    /// Adds integers, stored as floating-point numbers.
    pub(crate) fn put_whole(&mut self, name: &str, numbers: impl IntoIterator<Item = usize>) {
        self.put_flat(name, numbers.into_iter().map(|x| x as f64).collect());
    }

    /// Adds reports, four numbers each: the reason counted from 1, iterations, residual and tolerance; zeros for no
    /// report. If there are strategies, they follow in an array of their own, counted from 1 too.
    pub(crate) fn put_reports(
        &mut self,
        [name, strategies]: [&str; 2],
        reports: impl Iterator<Item = Option<SolverReport>> + Clone,
    ) {
        let row = |report: Option<SolverReport>| match report {
            None => [0.0; 4],
            Some(report) => [
                position(&StopReason::ALL, report.reason),
                report.iterations as f64,
                report.residual,
                report.tolerance,
            ],
        };
        self.put_flat(name, reports.clone().flat_map(row).collect());
        let strategy = |report: SolverReport| Some(position(&Strategy::ALL, report.strategy?));
        let found: Vec<_> = reports.map(|report| report.and_then(strategy)).collect();
        if found.iter().any(Option::is_some) {
            let found = found.into_iter().map(|strategy| strategy.unwrap_or(0.0));
            self.put_flat(strategies, found.collect());
        }
    }

    /// Removes and returns an array.
    ///
    /// # Errors
    /// `Stored` if it is missing, if its shape does not match its entries, or if an entry is not finite.
    pub(crate) fn take(&mut self, name: &str) -> Result<Array> {
        let Some(array) = self.0.remove(name) else {
            return Err(refusal(format!("array '{name}' is missing")));
        };
        let found = array.entries.len();
        if product(&array.shape) != Some(found) {
            let shape = array.shape;
            return Err(refusal(format!(
                "{name}: {found} entries do not make the shape {shape:?}"
            )));
        }
        match array.entries.iter().position(|x| !x.is_finite()) {
            None => Ok(array),
            Some(index) => Err(refusal(format!("{name}: entry {index} is not finite"))),
        }
    }

    /// Removes an array, to be read in parts.
    ///
    /// # Errors
    /// As [`Fields::take`].
    pub(crate) fn parts(&mut self, name: &'static str) -> Result<Parts> {
        let entries = self.take(name)?.entries;
        let next = 0;
        Ok(Parts {
            name,
            entries,
            next,
        })
    }

    /// As `parts`, but `count` zeros if there is no such array.
    ///
    /// # Errors
    /// As [`Fields::take`].
    pub(crate) fn parts_or_zeros(&mut self, name: &'static str, count: usize) -> Result<Parts> {
        if !self.0.contains_key(name) {
            self.put_flat(name, vec![0.0; count]);
        }
        self.parts(name)
    }

    /// Removes and returns an array of non-negative integers.
    ///
    /// # Errors
    /// As [`Fields::take`]; `Stored` if an entry is negative or not an integer.
    pub(crate) fn whole(&mut self, name: &str) -> Result<Vec<usize>> {
        let whole = |x: f64| match x {
            x if (0.0..=LARGEST_WHOLE).contains(&x) && x.fract() == 0.0 => Ok(x as usize),
            x => Err(refusal(format!("{name}: {x} is not a count"))),
        };
        self.take(name)?.entries.into_iter().map(whole).collect()
    }

    /// Removes and returns exactly `N` integers.
    ///
    /// # Errors
    /// As [`Fields::whole`]; `Stored` if there are more or fewer.
    pub(crate) fn some_whole<const N: usize>(&mut self, name: &str) -> Result<[usize; N]> {
        let numbers = self.whole(name)?;
        let found = numbers.len();
        <[usize; N]>::try_from(numbers)
            .map_err(|_| refusal(format!("{name}: expected {N} numbers, found {found}")))
    }

    /// Removes and returns `count` integers, one per curve.
    ///
    /// # Errors
    /// As [`Fields::some_whole`].
    pub(crate) fn whole_each(&mut self, name: &str, count: usize) -> Result<Vec<usize>> {
        let numbers = self.whole(name)?;
        let found = numbers.len();
        if found == count {
            return Ok(numbers);
        }
        Err(refusal(format!(
            "{name}: expected {count} numbers, found {found}"
        )))
    }

    /// Removes and returns reports.
    ///
    /// # Errors
    /// As [`Fields::take`]; `Stored` for a wrong number of reports or an unknown reason.
    pub(crate) fn reports(
        &mut self,
        [name, strategies]: [&'static str; 2],
        count: usize,
    ) -> Result<Vec<Option<SolverReport>>> {
        let mut parts = self.parts(name)?;
        let mut strategies = self.parts_or_zeros(strategies, count)?;
        let reports = (0..count)
            .map(|_| {
                let (report, [strategy]) = (parts.some()?, strategies.some()?);
                report_of(report, strategy)
            })
            .collect::<Result<_>>()?;
        parts.end()?;
        strategies.end()?;
        Ok(reports)
    }

    /// Passes all fields to `take`, which must use every one of them.
    ///
    /// # Errors
    /// `Stored` with the problem, also if `take` left arrays unused; `Interrupted`.
    pub(crate) fn read<T>(mut self, take: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let taken = take(&mut self).map_err(|error| match error {
            error @ (Error::Stored { .. } | Error::Interrupted { .. }) => error,
            // Numbers that do not form a curve, for example because it is not smooth or not a rotation.
            error => refusal(error.to_string()),
        })?;
        match self.0.keys().next() {
            None => Ok(taken),
            Some(name) => Err(refusal(format!("unexpected entry '{name}'"))),
        }
    }
}

/// Names of the arrays of reports and of strategies, for a single report and for many.
#[cfg(feature = "python")]
pub(crate) const REPORT: [&str; 2] = ["report", "strategy"];
pub(crate) const REPORTS: [&str; 2] = ["reports", "strategies"];

/// The position of a word among all, from 1 on.
fn position<T: PartialEq>(all: &[T], word: T) -> f64 {
    1.0 + all.iter().take_while(|other| **other != word).count() as f64
}

/// The word at a position.
fn at_position<T: Copy + PartialEq>(all: &[T], at: f64) -> Option<T> {
    all.iter().copied().find(|word| position(all, *word) == at)
}

fn report_of(
    [reason, iterations, residual, tolerance]: [f64; 4],
    strategy: f64,
) -> Result<Option<SolverReport>> {
    if reason == 0.0 && strategy == 0.0 {
        return Ok(None);
    }
    let Some(reason) = at_position(&StopReason::ALL, reason) else {
        return Err(refusal(format!("{reason} is not a reason for stopping")));
    };
    let strategy = match (strategy, at_position(&Strategy::ALL, strategy)) {
        (0.0, _) => None,
        (_, Some(known)) if reason == StopReason::Converged => Some(known),
        _ => {
            return Err(refusal(format!(
                "{strategy} is not a strategy of a solution"
            )));
        }
    };
    if !(0.0..=LARGEST_WHOLE).contains(&iterations) || iterations.fract() != 0.0 {
        return Err(refusal(format!(
            "{iterations} is not a number of iterations"
        )));
    }
    if residual < 0.0 || tolerance < 0.0 {
        return Err(refusal(format!(
            "a report of residual {residual} and tolerance {tolerance}"
        )));
    }
    Ok(Some(SolverReport {
        converged: reason == StopReason::Converged,
        iterations: iterations as usize,
        residual,
        tolerance,
        reason,
        strategy,
    }))
}

/// An array that is read in parts.
pub(crate) struct Parts {
    name: &'static str,
    entries: Vec<f64>,
    next: usize,
}

impl Parts {
    /// The next `count` numbers; `count` is `None` if it is too large for any array.
    ///
    /// # Errors
    /// `Stored` if there are fewer.
    pub(crate) fn next(&mut self, count: Option<usize>) -> Result<&[f64]> {
        let start = self.next;
        match count.and_then(|count| start.checked_add(count)) {
            Some(end) if end <= self.entries.len() => {
                self.next = end;
                Ok(&self.entries[start..end])
            }
            _ => Err(refusal(format!(
                "{}: too few numbers, {}",
                self.name,
                self.entries.len()
            ))),
        }
    }

    /// The next `N` numbers.
    ///
    /// # Errors
    /// As [`Parts::next`].
    pub(crate) fn some<const N: usize>(&mut self) -> Result<[f64; N]> {
        let mut out = [0.0; N];
        out.copy_from_slice(self.next(Some(N))?);
        Ok(out)
    }

    /// The next matrix, in column-major order.
    ///
    /// # Errors
    /// As [`Parts::next`].
    pub(crate) fn matrix(&mut self, rows: usize, cols: usize) -> Result<faer::Mat<f64>> {
        let entries = self.next(product(&[rows, cols]))?;
        Ok(faer::MatRef::from_column_major_slice(entries, rows, cols).to_owned())
    }

    /// Return an error if numbers are left.
    ///
    /// # Errors
    /// `Stored`.
    pub(crate) fn end(self) -> Result<()> {
        let left = self.entries.len() - self.next;
        if left == 0 {
            return Ok(());
        }
        Err(refusal(format!("{}: {left} numbers too many", self.name)))
    }
}

/// Appends the entries of a matrix, in column-major order.
pub(crate) fn extend(out: &mut Vec<f64>, matrix: faer::MatRef<'_, f64>) {
    for column in matrix.col_iter() {
        out.extend(column.iter());
    }
}
