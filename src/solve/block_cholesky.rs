//! Symmetric block tridiagonal systems by Cholesky factors, which exist only for positive definite matrices.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.2.5 and 4.5.1.

/// Square blocks of one size, row by row: the diagonal ones, and those below them from the second row on.
#[derive(Clone)]
pub(crate) struct SymmetricBlocks {
    pub(crate) size: usize,
    pub(crate) diagonal: Vec<f64>,
    pub(crate) below: Vec<f64>,
}

impl SymmetricBlocks {
    /// The zero matrix of `count` by `count` blocks.
    pub(crate) fn zeros(count: usize, size: usize) -> Self {
        let square = size * size;
        SymmetricBlocks {
            size,
            diagonal: vec![0.0; count * square],
            below: vec![0.0; (count - 1) * square],
        }
    }

    /// `self + factor other`.
    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + factor * b).collect();
        SymmetricBlocks {
            size: self.size,
            diagonal: sum(&self.diagonal, &other.diagonal),
            below: sum(&self.below, &other.below),
        }
    }

    /// `x^T A x`.
    pub(crate) fn form(&self, x: &[f64]) -> f64 {
        let (d, square) = (self.size, self.size * self.size);
        let product = |a: &[f64], x: &[f64], y: &[f64]| -> f64 {
            let rows = a.chunks_exact(d).zip(y);
            rows.map(|(row, y)| y * dot(row, x)).sum()
        };
        let blocks = x.chunks_exact(d);
        let diagonal = self.diagonal.chunks_exact(square).zip(blocks.clone());
        let below = self
            .below
            .chunks_exact(square)
            .zip(blocks.clone().zip(blocks.skip(1)));
        diagonal.map(|(a, x)| product(a, x, x)).sum::<f64>()
            + 2.0 * below.map(|(a, (x, y))| product(a, x, y)).sum::<f64>()
    }

    /// The Cholesky factor; `None` where the matrix is not positive definite.
    pub(crate) fn factored(mut self) -> Option<CholeskyFactor> {
        let (d, square) = (self.size, self.size * self.size);
        let count = self.diagonal.len() / square;
        for block in 0..count {
            let diagonal = &mut self.diagonal[block * square..][..square];
            if block > 0 {
                let below = &self.below[(block - 1) * square..][..square];
                for i in 0..d {
                    for j in 0..=i {
                        diagonal[i * d + j] -= dot(&below[i * d..][..d], &below[j * d..][..d]);
                    }
                }
            }
            cholesky(d, diagonal)?;
            if block + 1 < count {
                // The block below times the inverse of the transposed factor, row by row.
                for row in self.below[block * square..][..square].chunks_exact_mut(d) {
                    forward(d, diagonal, row);
                }
            }
        }
        Some(CholeskyFactor(self))
    }
}

/// The factor of a positive definite matrix.
pub(crate) struct CholeskyFactor(SymmetricBlocks);

impl CholeskyFactor {
    /// Solves the system in place.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let SymmetricBlocks {
            size: d,
            diagonal,
            below,
        } = &self.0;
        let (d, square) = (*d, d * d);
        let count = diagonal.len() / square;
        for block in 0..count {
            let (before, here) = b.split_at_mut(block * d);
            let here = &mut here[..d];
            if block > 0 {
                let before = &before[(block - 1) * d..];
                let rows = below[(block - 1) * square..][..square].chunks_exact(d);
                for (x, row) in here.iter_mut().zip(rows) {
                    *x -= dot(row, before);
                }
            }
            forward(d, &diagonal[block * square..], here);
        }
        for block in (0..count).rev() {
            let (here, after) = b.split_at_mut((block + 1) * d);
            let here = &mut here[block * d..];
            if block + 1 < count {
                let rows = below[block * square..][..square].chunks_exact(d);
                for (row, x) in rows.zip(&*after) {
                    for (here, entry) in here.iter_mut().zip(row) {
                        *here -= entry * x;
                    }
                }
            }
            let factor = &diagonal[block * square..];
            for i in (0..d).rev() {
                let x = here[i] / factor[i * d + i];
                here[i] = x;
                for (here, entry) in here[..i].iter_mut().zip(&factor[i * d..]) {
                    *here -= entry * x;
                }
            }
        }
    }
}

/// The lower factor in place; `None` where a pivot is not positive.
fn cholesky(d: usize, a: &mut [f64]) -> Option<()> {
    for i in 0..d {
        let (above, row) = a.split_at_mut(i * d);
        let (known, pivot) = row.split_at_mut(i);
        forward(d, above, known);
        let square = pivot[0] - dot(known, known);
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        pivot[0] = square.sqrt();
    }
    Some(())
}

/// Solves `l x = b` in place for the first rows of a lower factor of size `d`.
fn forward(d: usize, factor: &[f64], b: &mut [f64]) {
    for i in 0..b.len() {
        let row = &factor[i * d..];
        let (known, rest) = b.split_at_mut(i);
        rest[0] = (rest[0] - dot(&row[..i], known)) / row[i];
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three blocks of size two, `A = B B^T + shift`.
    fn matrix(shift: f64) -> SymmetricBlocks {
        let mut a = SymmetricBlocks::zeros(3, 2);
        for (i, x) in a.below.iter_mut().enumerate() {
            *x = 0.3 * (1.0 + i as f64).sin();
        }
        for block in 0..3 {
            let at = 4 * block;
            a.diagonal[at..at + 4].copy_from_slice(&[2.0 + shift, 0.5, 0.5, 1.5 + shift]);
        }
        a
    }

    /// `A x`.
    fn product(a: &SymmetricBlocks, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; 6];
        for i in 0..6 {
            let mut unit = vec![0.0; 6];
            unit[i] = 1.0;
            let sum: Vec<f64> = unit.iter().zip(x).map(|(u, x)| u + x).collect();
            // The form is quadratic: its polar form gives the entry.
            out[i] = 0.5 * (a.form(&sum) - a.form(&unit) - a.form(x));
        }
        out
    }

    #[test]
    fn the_factor_solves_the_system() {
        let a = matrix(0.0);
        let x: Vec<f64> = (0..6).map(|i| (0.7 * i as f64).cos()).collect();
        let mut b = product(&a, &x);
        a.factored().expect("positive definite").solve(&mut b);
        for (found, x) in b.iter().zip(&x) {
            assert!((found - x).abs() < 1e-14, "{found} {x}");
        }
    }

    #[test]
    fn an_indefinite_matrix_has_no_factor() {
        assert!(matrix(-1.5).factored().is_none());
        assert!(matrix(f64::NAN).factored().is_none());
    }

    #[test]
    fn a_multiple_is_added() {
        let (a, x) = (matrix(0.0), [0.3, -1.0, 0.2, 0.9, -0.4, 1.1]);
        let sum = a.plus(2.0, &matrix(1.0));
        let expected = a.form(&x) + 2.0 * matrix(1.0).form(&x);
        assert!((sum.form(&x) - expected).abs() < 1e-13);
    }
}
