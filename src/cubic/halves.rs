//! Blocks of embedded complex matrices: the second half of the columns follows from the first.

use super::reduced::Blocks;
use crate::linalg::dual::Number;

/// How many columns of blocks are computed, and the others of complex ones:
///
/// ```math
/// \begin{pmatrix} A \\ B \end{pmatrix} \mapsto \begin{pmatrix} -B \\ A \end{pmatrix}
/// ```
///
/// for the rows of the upper block, and for those of the lower one.
#[derive(Clone, Copy)]
pub(super) struct Halves {
    /// Of blocks with `k` columns.
    pub(super) wide: usize,
    /// Of blocks with a column for each normal, those that fill up among them.
    pub(super) tall: usize,
    /// Complex rows of the upper and the lower block; none where all columns are computed.
    rows: Option<[usize; 2]>,
}

impl Halves {
    #[inline(always)]
    pub(super) fn new<B: Blocks>(blocks: B, padded: usize) -> Self {
        let (k, m) = (blocks.k(), blocks.normals());
        match blocks.are_complex() {
            false => Halves {
                wide: k,
                tall: padded,
                rows: None,
            },
            true => Halves {
                wide: k / 2,
                tall: m / 2,
                rows: Some([k / 2, m / 2]),
            },
        }
    }

    /// Columns of `rows` numbers: those of the upper block before those of the lower one.
    #[inline(always)]
    pub(super) fn complete<T: Number>(self, first: &[T], second: &mut [T], rows: usize) {
        if let Some([upper, lower]) = self.rows {
            // Columns that fill up are zero.
            second.fill(T::ZERO);
            mirror(first, second, rows, 0, upper);
            mirror(first, second, rows, 2 * upper, lower);
        }
    }

    /// Of the upper block only.
    #[inline(always)]
    pub(super) fn complete_upper<T: Number>(self, first: &[T], second: &mut [T], rows: usize) {
        if let Some([upper, _]) = self.rows {
            mirror(first, second, rows, 0, upper);
        }
    }

    /// Of the lower block only.
    #[inline(always)]
    pub(super) fn complete_lower<T: Number>(self, first: &[T], second: &mut [T], rows: usize) {
        if let Some([_, lower]) = self.rows {
            mirror(first, second, rows, 0, lower);
        }
    }
}

/// Two parts of so many rows, from a row on.
#[inline(always)]
fn mirror<T: Number>(first: &[T], second: &mut [T], rows: usize, from: usize, size: usize) {
    if rows == 0 {
        return;
    }
    for (a, b) in first.chunks_exact(rows).zip(second.chunks_exact_mut(rows)) {
        for i in from..from + size {
            b[i] = -a[i + size];
            b[i + size] = a[i];
        }
    }
}
