//! Conversion between coordinates of complex vectors and of their real embeddings: each real coordinate is a multiple
//! of a complex one.

use crate::linalg::dual::Number;
use crate::space::{Homogeneous, Kind, Shape, in_space};

/// For each real coordinate, the complex one of which it is a multiple, and the factor.
#[derive(Debug, Clone)]
pub(crate) struct Embedding {
    real: Vec<(usize, f64)>,
    complex: Vec<(usize, f64)>,
}

impl Embedding {
    /// The embedding of a complex space.
    pub(crate) fn new(shape: Shape) -> Self {
        let r = shape.r;
        let real = Shape {
            kind: Kind::real(shape.kind.quotient),
            ..shape
        };
        // The real coordinate of an entry, and its sign.
        let mut of_entry = vec![None; r * r];
        in_space!(real, |space| space.each_entry(|p, i, j| {
            of_entry[i * r + j] = Some((p, 1.0));
            of_entry[j * r + i] = Some((p, -1.0));
        }));
        let mut embedding = Embedding {
            real: vec![(0, 0.0); in_space!(real, |space| space.dim())],
            complex: vec![(0, 0.0); in_space!(shape, |space| space.dim())],
        };
        in_space!(shape, |space| space.each_entry(|q, i, j| {
            let factor = space.scale(i, j).recip();
            let copies = [Some(([i, j], 1.0)), space.copy_of(i, j)];
            for ([i, j], sign) in copies.into_iter().flatten() {
                if let Some((p, turned)) = of_entry[i * r + j] {
                    embedding.real[p] = (q, sign * turned * factor);
                    embedding.complex[q] = (p, sign * turned / factor);
                }
            }
        }));
        embedding
    }

    /// Converts vectors, one after another, to real coordinates.
    pub(crate) fn to_real<T: Number>(&self, y: &[T]) -> Vec<T> {
        mapped(y, self.complex.len(), &self.real)
    }

    /// The inverse, for vectors that are complex.
    pub(crate) fn of_real<T: Number>(&self, y: &[T]) -> Vec<T> {
        mapped(y, self.real.len(), &self.complex)
    }
}

fn mapped<T: Number>(y: &[T], size: usize, table: &[(usize, f64)]) -> Vec<T> {
    let vectors = y.chunks_exact(size.max(1));
    vectors
        .flat_map(|y| table.iter().map(|(p, factor)| y[*p] * *factor))
        .collect()
}
