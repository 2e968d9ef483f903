//! The factors of the linear equations of a leg, or of eight.

use faer::MatMut;

use crate::linalg::decomp::Lu;
use crate::linalg::field::{Field, factor, substitute, substitute_rows};

/// Unknowns from which on every lane is factored by itself. Eight matrices abreast do not fit into the nearest cache then: on
/// St(10,3), with 72 unknowns, factors and solutions abreast take three times as long.
const MANY: usize = 48;

/// The matrix `C` of the equations `C x = b`, shape `(size, size)` row by row, and its factors.
#[derive(Clone)]
pub(super) struct LegFactors<T> {
    size: usize,
    /// What is to be factored, then the factors where these are abreast.
    pub(super) matrix: Vec<T>,
    /// Of the transposed matrices, lane by lane, where there are many unknowns.
    lanes: Vec<Lu>,
}

impl<T: Field> LegFactors<T> {
    pub(super) fn new(size: usize) -> Self {
        LegFactors {
            size,
            matrix: vec![T::ZERO; size * size],
            lanes: Vec::new(),
        }
    }

    /// Factors the matrix.
    #[inline(always)]
    pub(super) fn factor(&mut self) {
        if self.size < MANY {
            return factor(self.size, &mut self.matrix);
        }
        self.lanes.clear();
        let mut lane_entries = vec![0.0; self.matrix.len()];
        for lane in 0..T::COUNT {
            read_lane(&self.matrix, lane, &mut lane_entries);
            // Rows in place of columns: the transposed matrix.
            let transposed =
                MatMut::from_column_major_slice_mut(&mut lane_entries, self.size, self.size);
            self.lanes.push(Lu::new(transposed.as_ref()));
        }
    }

    /// Solves `C x = b` in place.
    #[inline(always)]
    pub(super) fn substitute(&self, b: &mut [T]) {
        match self.size < MANY {
            true => substitute(self.size, &self.matrix, 1, b),
            false => self.lane_by_lane(b, Lu::solve_transposed),
        }
    }

    /// Solves `x C = b` in place for every row of `b`.
    #[inline(always)]
    pub(super) fn substitute_rows(&self, b: &mut [T]) {
        match self.size < MANY {
            true => substitute_rows(self.size, &self.matrix, b),
            false => self.lane_by_lane(b, Lu::solve),
        }
    }

    fn lane_by_lane(&self, b: &mut [T], solve: impl Fn(&Lu, MatMut<'_, f64>)) {
        let mut right = vec![0.0; b.len()];
        let count = b.len() / self.size;
        for (lane, lu) in self.lanes.iter().enumerate() {
            read_lane(b, lane, &mut right);
            solve(
                lu,
                MatMut::from_column_major_slice_mut(&mut right, self.size, count),
            );
            for (b, x) in b.iter_mut().zip(&right) {
                b.set_lane(lane, *x);
            }
        }
    }
}

fn read_lane<T: Field>(from: &[T], lane: usize, out: &mut [f64]) {
    for (out, x) in out.iter_mut().zip(from) {
        *out = x.lane(lane);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dual::Number;
    use crate::linalg::lanes::Lanes;

    fn entry(i: usize, lane: usize) -> f64 {
        ((7 * i + 3 * lane + 1) as f64).sin()
    }

    fn numbers(count: usize) -> Vec<Lanes> {
        let mut all = vec![Lanes::ZERO; count];
        for (i, x) in all.iter_mut().enumerate() {
            for lane in 0..Lanes::COUNT {
                x.set_lane(lane, entry(i, lane));
            }
        }
        all
    }

    /// Abreast and lane by lane: the products of the solutions are the right-hand sides.
    #[test]
    fn solutions_solve_the_equations() {
        for size in [MANY - 1, MANY, MANY + 12] {
            let mut factors = LegFactors::<Lanes>::new(size);
            factors.matrix = numbers(size * size);
            for i in 0..size {
                factors.matrix[i * size + i] += Lanes::constant(size as f64);
            }
            let matrix = factors.matrix.clone();
            factors.factor();
            let right = numbers(3 * size);
            let (mut x, mut rows) = (right[..size].to_vec(), right.clone());
            factors.substitute(&mut x);
            factors.substitute_rows(&mut rows);
            // Entries of up to one, `size` products each, condition numbers of at most ten.
            let bound = 10.0 * size as f64 * f64::EPSILON;
            for lane in 0..Lanes::COUNT {
                let a = |i: usize, j: usize| matrix[i * size + j].lane(lane);
                for i in 0..size {
                    let product: f64 = (0..size).map(|j| a(i, j) * x[j].lane(lane)).sum();
                    assert!((product - right[i].lane(lane)).abs() < bound, "{size}");
                    for row in 0..3 {
                        let terms = (0..size).map(|j| rows[row * size + j].lane(lane) * a(j, i));
                        let product: f64 = terms.sum();
                        assert!(
                            (product - right[row * size + i].lane(lane)).abs() < bound,
                            "{size}"
                        );
                    }
                }
            }
        }
    }
}
