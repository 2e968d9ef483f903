//! Singular values of a matrix whose columns differ in length by many orders of magnitude, each to high relative
//! accuracy.
//!
//! # Source
//! Demmel, Veselic (1992), "Jacobi's method is more accurate than QR", SIAM J. Matrix Anal. Appl. 13, 1204-1245.

use faer::{Mat, MatRef};

use super::decomp::{Svd, thin_qr};
use super::structure::norm;
use crate::error::{Error, Result};

/// Ratio of the smallest to the largest singular value from which the general method is accurate to 12 digits.
const WELL_CONDITIONED: f64 = 1e-4;

/// Columns count as orthogonal if the cosine of their angle is below this, per row.
const ORTHOGONAL: f64 = f64::EPSILON;

/// Maximal number of sweeps of plane rotations; fewer than ten are usual.
const MAX_SWEEPS: usize = 60;

/// A column with the size of its round-off.
struct Column {
    entries: Vec<f64>,
    length: f64,
    round_off: f64,
}

impl Column {
    fn new(entries: Vec<f64>) -> Self {
        let mut column = Column {
            entries,
            length: 0.0,
            round_off: 0.0,
        };
        column.measure();
        column
    }

    /// Sets the length; round-off becomes zero, since otherwise it would be rotated until it underflows.
    fn measure(&mut self) {
        let rows = self.entries.len();
        self.length = norm(MatRef::from_column_major_slice(&self.entries, rows, 1));
        if self.length <= self.round_off {
            self.entries.fill(0.0);
            self.length = 0.0;
        }
    }
}

/// The `k` singular values of `a`, shape `(n, k)` with `n >= k`, in decreasing order. Entries must be finite.
///
/// If `a = B D` with diagonal `D` and well-conditioned `B`, all have high relative accuracy, whatever `D` is.
///
/// # Errors
/// `Overflow` if an entry is not finite; `Decomposition` if the iteration does not converge.
pub(crate) fn graded_singular_values(a: MatRef<'_, f64>) -> Result<Vec<f64>> {
    let k = a.ncols();
    let mut svd = Svd::new(a.nrows(), k);
    svd.compute(a)?;
    if svd.s(k - 1) >= WELL_CONDITIONED * svd.s(0) {
        return Ok((0..k).map(|i| svd.s(i)).collect());
    }
    let (mut columns, scale) = triangular_columns(a);
    for _ in 0..MAX_SWEEPS {
        let mut settled = true;
        for j in 1..k {
            let (before, rest) = columns.split_at_mut(j);
            for column in before {
                settled &= !rotate(column, &mut rest[0]);
            }
        }
        if settled {
            let mut values: Vec<f64> = columns.iter().map(|column| column.length / scale).collect();
            values.sort_by(|x, y| y.total_cmp(x));
            return Ok(values);
        }
    }
    Err(Error::Decomposition {
        kind: "singular value decomposition",
    })
}

/// Binary logarithm of the size of the longest column during the iteration, so that short ones are not subnormal, whose
/// digits are fewer.
const LONG: f64 = 900.0;

/// The columns of the factor `R` of `A = Q R` times a power of two, and this factor: they have fewer rows and the same
/// singular values. Columns are scaled first by powers of two, which is exact.
fn triangular_columns(a: MatRef<'_, f64>) -> (Vec<Column>, f64) {
    let scales: Vec<f64> = a
        .col_iter()
        .map(|column| match column.norm_max() {
            0.0 => 1.0,
            // Subnormal numbers have no inverse.
            largest => largest.log2().floor().max(-1000.0).exp2(),
        })
        .collect();
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / scales[j]);
    let (_, r) = thin_qr(scaled.as_ref());
    let longest = scales.iter().fold(0.0_f64, |most, scale| most.max(*scale));
    let scale = (LONG - longest.log2()).clamp(0.0, 1000.0).exp2();
    let column = |j: usize| {
        let factor = scales[j] * scale;
        (0..r.nrows()).map(|i| r[(i, j)] * factor).collect()
    };
    let columns = (0..a.ncols()).map(|j| Column::new(column(j))).collect();
    (columns, scale)
}

/// Orthogonalises two columns; returns whether a rotation was necessary.
fn rotate(a: &mut Column, b: &mut Column) -> bool {
    if a.length == 0.0 || b.length == 0.0 {
        return false;
    }
    // Lengths first: the product of two tiny entries may underflow.
    let pairs = a.entries.iter().zip(&b.entries);
    let overlap: f64 = pairs.map(|(x, y)| (x / a.length) * (y / b.length)).sum();
    if overlap.abs() <= ORTHOGONAL * a.entries.len().max(4) as f64 {
        return false;
    }
    let cotangent = 0.5 * (b.length / a.length - a.length / b.length) / overlap;
    let tangent = 1.0_f64.copysign(cotangent) / (cotangent.abs() + 1.0_f64.hypot(cotangent));
    if tangent == 0.0 {
        return false;
    }
    let cos = 1.0 / 1.0_f64.hypot(tangent);
    let sin = tangent * cos;
    for (x, y) in a.entries.iter_mut().zip(&mut b.entries) {
        (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
    }
    let (sin, lengths) = (sin.abs(), [a.length, b.length]);
    let round_off = [a.round_off, b.round_off];
    let carried = |c: f64, s: f64| {
        let new = f64::EPSILON * (c * lengths[0]).max(s * lengths[1]);
        (c * round_off[0]).max(s * round_off[1]).max(new)
    };
    (a.round_off, b.round_off) = (carried(cos, sin), carried(sin, cos));
    a.measure();
    b.measure();
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(i: usize, j: usize) -> f64 {
        ((7 * i + 3 * j * i + j + 1) as f64).sin()
    }

    #[test]
    fn columns_of_any_length_keep_their_digits() {
        // Columns of very different lengths: the singular values agree with those of Gram-Schmidt's method up to the
        // ratios of the lengths.
        for lengths in [
            [1.0, 1e-30, 1e-90],
            [1e-300, 1.0, 1e-150],
            [1e250, 1e-50, 1e100],
        ] {
            let a = Mat::from_fn(6, 3, |i, j| lengths[j] * entry(i, j));
            let mut sorted = lengths;
            sorted.sort_by(|x, y| y.total_cmp(x));
            let order = sorted.map(|x| lengths.iter().position(|y| *y == x).unwrap_or(0));
            let ordered = Mat::from_fn(6, 3, |i, j| entry(i, order[j]));
            let (_, r) = thin_qr(ordered.as_ref());
            let values = graded_singular_values(a.as_ref()).unwrap();
            for j in 0..3 {
                let exact = r[(j, j)] * sorted[j];
                assert!((values[j] / exact - 1.0).abs() < 1e-14, "{values:?}");
            }
        }
    }

    #[test]
    fn columns_near_the_smallest_numbers_are_orthogonalised() {
        for length in [1e-290, 1e-300, 1e-305, 1e-310] {
            // Parallel columns, 0.6 and 0.8 times one: the other singular value is round-off or zero.
            let a = Mat::from_fn(4, 2, |i, j| length * entry(i, 0) * (0.6 + 0.2 * j as f64));
            let values = graded_singular_values(a.as_ref()).unwrap();
            let column: f64 = (0..4).map(|i| entry(i, 0).powi(2)).sum();
            let expected = length * column.sqrt();
            // Numbers below 2e-308 have fewer digits.
            assert!(
                (values[0] - expected).abs() <= 1e-14 * expected + 1e-322,
                "{values:?}"
            );
            assert!(values[1] <= 1e-15 * expected + 1e-322, "{values:?}");
        }
    }

    #[test]
    fn dependent_columns_have_zeros() {
        for rank in 0..5 {
            let left = Mat::from_fn(9, rank, entry);
            let right = Mat::from_fn(rank, 5, |i, j| entry(j + 2, i));
            let a = left * right;
            let values = graded_singular_values(a.as_ref()).unwrap();
            let mut svd = Svd::new(9, 5);
            svd.compute(a.as_ref()).unwrap();
            for (j, value) in values.iter().enumerate() {
                let bound = 1e-15 * 10.0 * svd.s(0);
                assert!((value - svd.s(j)).abs() <= bound, "rank {rank}: {values:?}");
            }
        }
    }
}
