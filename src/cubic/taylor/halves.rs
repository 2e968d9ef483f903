//! Blocks of embedded complex matrices: the second half of the columns follows from the first half.

use super::blocks::BlockSizes;
use crate::linalg::dual::Number;

/// Number of columns of blocks to compute; the others follow for complex blocks:
///
/// ```math
/// \begin{pmatrix} A \\ B \end{pmatrix} \mapsto \begin{pmatrix} -B \\ A \end{pmatrix}
/// ```
///
/// for the rows of the upper block and of the lower block.
#[derive(Clone, Copy)]
pub(crate) struct Halves {
    /// For blocks with `k` columns.
    pub(crate) wide: usize,
    /// For blocks with one column per normal, including padding.
    pub(crate) tall: usize,
    /// Complex rows of the upper and the lower block; `None` if all columns are computed.
    rows: Option<[usize; 2]>,
}

impl Halves {
    #[inline(always)]
    pub(crate) fn new<B: BlockSizes>(blocks: B, padded: usize) -> Self {
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

    /// Completes columns of `rows` numbers, in which the upper block precedes the lower one.
    #[inline(always)]
    pub(crate) fn complete<T: Number>(self, first: &[T], second: &mut [T], rows: usize) {
        if let Some([upper, lower]) = self.rows {
            // Padding columns are zero.
            second.fill(T::ZERO);
            mirror(first, second, rows, 0, upper);
            mirror(first, second, rows, 2 * upper, lower);
        }
    }

    /// Completes columns of the upper block only.
    #[inline(always)]
    pub(crate) fn complete_upper<T: Number>(self, first: &[T], second: &mut [T], rows: usize) {
        if let Some([upper, _]) = self.rows {
            mirror(first, second, rows, 0, upper);
        }
    }

    /// Completes columns of the lower block only.
    #[inline(always)]
    pub(crate) fn complete_lower<T: Number>(self, first: &[T], second: &mut [T], rows: usize) {
        if let Some([_, lower]) = self.rows {
            mirror(first, second, rows, 0, lower);
        }
    }
}

/// Completes two parts of `size` rows, starting at row `from`.
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
