//! Singular values and vectors of a small bidiagonal matrix, with the rotations applied directly to a basis.
//!
//! # Source
//! Golub, Reinsch (1970), "Singular value decomposition and least squares solutions", Numer. Math. 14, 403-420, with
//! deflation relative to the norm: the backward error is a small multiple of `eps |B|`.

use super::square::Square;
use crate::error::{Error, Result};

/// Maximal number of steps of the iteration per singular value; two or three are usual.
const STEPS: usize = 40;

/// Magnitude below which a sum of squares may underflow.
const TINY: f64 = 1e-140;

/// `c` and `s` with `(c y + s z, c z - s y) = (r, 0)`, and `r >= 0`.
#[inline(always)]
fn rotation(y: f64, z: f64) -> (f64, f64, f64) {
    let mut r = (y * y + z * z).sqrt();
    if r < TINY {
        r = y.hypot(z);
        if r < TINY {
            // Far below the round-off of a matrix of norm about 1.
            return (1.0, 0.0, y);
        }
    }
    (y / r, z / r, r)
}

/// Diagonalises the `d.len() x columns` matrix with diagonal `d` and superdiagonal `e`, where `columns` is `d.len()` or
/// one more. Rotations of column `i` of the matrix are applied to column `2i` of `basis`, rotations of row `i` to
/// column `2i + 1`, on `rows` entries, a multiple of `LANES`. On return, `d` is nonnegative and decreasing, and a
/// column without a row is the last one.
///
/// # Errors
/// `Decomposition` if the iteration does not converge.
#[inline(always)]
pub(super) fn diagonalise(
    d: &mut [f64],
    e: &mut [f64],
    columns: usize,
    rows: usize,
    basis: &mut Square,
) -> Result<()> {
    let p = d.len();
    let norm = d
        .iter()
        .chain(e.iter())
        .fold(0.0_f64, |s, x| s.max(x.abs()));
    if norm == 0.0 {
        return Ok(());
    }
    for x in d.iter_mut().chain(e.iter_mut()) {
        *x /= norm;
    }
    let mut work = SvdIteration { d, e, rows, basis };
    if columns > p {
        work.clear_column(p, 0);
    }
    let mut converged = false;
    let mut last = p - 1;
    for _ in 0..STEPS * p {
        while last > 0 && work.e[last - 1].abs() <= f64::EPSILON {
            work.e[last - 1] = 0.0;
            last -= 1;
        }
        if last == 0 {
            converged = true;
            break;
        }
        let mut first = last - 1;
        while first > 0 && work.e[first - 1].abs() > f64::EPSILON {
            first -= 1;
        }
        if first > 0 {
            work.e[first - 1] = 0.0;
        }
        if work.d[last].abs() <= f64::EPSILON {
            work.d[last] = 0.0;
            work.clear_column(last, first);
        } else if let Some(zero) = (first..last).find(|&i| work.d[i].abs() <= f64::EPSILON) {
            work.d[zero] = 0.0;
            work.clear_row(zero, last);
        } else {
            work.step(first, last);
        }
    }
    if !converged {
        return Err(Error::Decomposition {
            kind: "singular value decomposition",
        });
    }
    work.order();
    for x in d {
        *x *= norm;
    }
    Ok(())
}

struct SvdIteration<'a> {
    d: &'a mut [f64],
    e: &'a mut [f64],
    rows: usize,
    basis: &'a mut Square,
}

impl SvdIteration<'_> {
    /// Rotates columns `i < j` of the basis to `(c x + s y, c y - s x)`.
    #[inline(always)]
    fn turn(&mut self, i: usize, j: usize, (c, s): (f64, f64)) {
        let (x, y) = self.basis.two_mut(i, j, self.rows);
        for (x, y) in x.iter_mut().zip(y) {
            (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
        }
    }

    /// Chases the entry above position `k` of the diagonal, which is zero or absent, out to the left.
    #[inline(always)]
    fn clear_column(&mut self, k: usize, first: usize) {
        let mut bulge = self.e[k - 1];
        self.e[k - 1] = 0.0;
        for i in (first..k).rev() {
            let (c, s, r) = rotation(self.d[i], bulge);
            self.d[i] = r;
            self.turn(2 * i, 2 * k, (c, s));
            if i > first {
                bulge = -s * self.e[i - 1];
                self.e[i - 1] *= c;
            }
        }
    }

    /// Chases the entry to the right of the zero at position `k` of the diagonal out at the bottom.
    #[inline(always)]
    fn clear_row(&mut self, k: usize, last: usize) {
        let mut bulge = self.e[k];
        self.e[k] = 0.0;
        for i in k + 1..=last {
            let (c, s, r) = rotation(self.d[i], bulge);
            self.d[i] = r;
            // The row with the zero comes first, so its sine has the opposite sign.
            self.turn(2 * k + 1, 2 * i + 1, (c, -s));
            if i < last {
                bulge = -s * self.e[i];
                self.e[i] *= c;
            }
        }
    }

    /// One implicit step with Wilkinson's shift of `B^T B`.
    #[inline(always)]
    fn step(&mut self, first: usize, last: usize) {
        let (d, e) = (&mut self.d, &mut self.e);
        let above = if last >= first + 2 { e[last - 2] } else { 0.0 };
        let a = d[last - 1] * d[last - 1] + above * above;
        let b = d[last - 1] * e[last - 1];
        let c = d[last] * d[last] + e[last - 1] * e[last - 1];
        let half = 0.5 * (a - c);
        let root = (half * half + b * b).sqrt().copysign(half);
        let shift = if half + root == 0.0 {
            c
        } else {
            c - b * b / (half + root)
        };
        let (mut y, mut z) = (d[first] * d[first] - shift, d[first] * e[first]);
        for k in first..last {
            let (c, s, r) = rotation(y, z);
            if k > first {
                self.e[k - 1] = r;
            }
            y = c * self.d[k] + s * self.e[k];
            self.e[k] = c * self.e[k] - s * self.d[k];
            z = s * self.d[k + 1];
            self.d[k + 1] *= c;
            self.turn(2 * k, 2 * k + 2, (c, s));
            let (c, s, r) = rotation(y, z);
            self.d[k] = r;
            y = c * self.e[k] + s * self.d[k + 1];
            self.d[k + 1] = c * self.d[k + 1] - s * self.e[k];
            if k + 1 < last {
                z = s * self.e[k + 1];
                self.e[k + 1] *= c;
            }
            self.turn(2 * k + 1, 2 * k + 3, (c, s));
        }
        self.e[last - 1] = y;
    }

    /// Moves signs into the basis and sorts by decreasing singular value.
    #[inline(always)]
    fn order(&mut self) {
        for i in 0..self.d.len() {
            let mut largest = i;
            for j in i + 1..self.d.len() {
                if self.d[j].abs() > self.d[largest].abs() {
                    largest = j;
                }
            }
            if largest != i {
                self.d.swap(i, largest);
                for side in 0..2 {
                    let (x, y) = self
                        .basis
                        .two_mut(2 * i + side, 2 * largest + side, self.rows);
                    x.swap_with_slice(y);
                }
            }
            if self.d[i] < 0.0 {
                self.d[i] = -self.d[i];
                for x in self.basis.rows_mut(2 * i + 1, self.rows) {
                    *x = -*x;
                }
            }
        }
    }
}
