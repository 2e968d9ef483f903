//! Block tridiagonal systems whose blocks are numbers times isometries between the tangent spaces of neighbouring
//! knots.
//!
//! If all vectors are carried along the chain to one tangent space, the blocks are numbers, and the Thomas algorithm
//! needs no matrix larger than the few fields at a knot. A closed chain, around which carrying a vector once is not the
//! identity, is unrolled: if the diagonal is at least twice the sum of its neighbours, the influence of a distant knot
//! decays by at least one half per knot.
//!
//! # Source
//! Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 4.5.1; de Boor (2001), "A Practical Guide to Splines",
//! ch. IV, for the system of cubic splines.

use super::direction::Direction;
use crate::error::Result;

/// The isometries between vectors at neighbouring knots, which have the same number of coordinates.
pub(crate) trait Isometries {
    /// Number of coordinates of a vector.
    fn size(&self) -> usize;

    /// Writes `from`, carried to the other end of the leg, to `to`; leg `i` follows knot `i`.
    ///
    /// # Errors
    /// An error if carrying fails.
    fn carry_into(
        &mut self,
        leg: usize,
        way: Direction,
        from: &[f64],
        to: &mut [f64],
    ) -> Result<()>;
}

/// Vectors with the given number of coordinates that are not turned between knots.
pub(crate) struct Unturned(pub(crate) usize);

impl Isometries for Unturned {
    fn size(&self) -> usize {
        self.0
    }

    fn carry_into(&mut self, _: usize, _: Direction, from: &[f64], to: &mut [f64]) -> Result<()> {
        to.copy_from_slice(from);
        Ok(())
    }
}

/// Number of knots by which a closed chain is unrolled at both ends: their influence decays as `2^-j` at worst, to
/// 6e-14, and as `(2 - 3^(1/2))^j` for equal legs.
const UNROLLED: usize = 44;

/// Numbers of a block, indexed by the fields of a knot.
pub(crate) type Block<const C: usize> = [[f64; C]; C];

/// One block row: the blocks for the knot before, the knot itself and the knot after.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<const C: usize> {
    pub(crate) below: Block<C>,
    pub(crate) diagonal: Block<C>,
    pub(crate) above: Block<C>,
}

impl<const C: usize> Row<C> {
    pub(crate) const ZERO: Row<C> = Row {
        below: [[0.0; C]; C],
        diagonal: [[0.0; C]; C],
        above: [[0.0; C]; C],
    };
}

/// Whether the last knot is the first one again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ChainShape {
    Open,
    Closed,
}

/// A factored system.
#[derive(Debug, Clone)]
pub(crate) struct Tridiagonal<const C: usize> {
    shape: ChainShape,
    rows: usize,
    /// The knots in the order of elimination.
    order: Vec<usize>,
    /// In the same order, inverse pivots, and inverse pivots times the block above.
    steps: Vec<(Block<C>, Block<C>)>,
    below: Vec<Block<C>>,
}

impl<const C: usize> Tridiagonal<C> {
    /// Built from one row per knot with unknowns; for a closed chain, these are as many as legs. `None` if a pivot is
    /// singular.
    pub(crate) fn new(rows: &[Row<C>], shape: ChainShape) -> Option<Self> {
        let count = rows.len();
        let order: Vec<usize> = match shape {
            ChainShape::Open => (0..count).collect(),
            ChainShape::Closed => {
                let first = count * UNROLLED.div_ceil(count) - UNROLLED;
                (first..first + count + 2 * UNROLLED)
                    .map(|i| i % count)
                    .collect()
            }
        };
        let mut steps: Vec<(Block<C>, Block<C>)> = Vec::with_capacity(order.len());
        for &knot in &order {
            let mut pivot = rows[knot].diagonal;
            if let Some((_, share)) = steps.last() {
                subtract(&mut pivot, &product(&rows[knot].below, share));
            }
            let inverse = inverse(pivot)?;
            steps.push((inverse, product(&inverse, &rows[knot].above)));
        }
        Some(Tridiagonal {
            shape,
            rows: count,
            order,
            steps,
            below: rows.iter().map(|row| row.below).collect(),
        })
    }

    /// Solves for right-hand sides of `C` vectors per knot, in place.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn solve(&self, isometries: &mut impl Isometries, right: &mut [f64]) -> Result<()> {
        let size = C * isometries.size();
        let mut carried = vec![0.0; size];
        let mut all = vec![0.0; size * self.order.len()];
        for (i, &knot) in self.order.iter().enumerate() {
            let (before, at) = all.split_at_mut(size * i);
            let at = &mut at[..size];
            at.copy_from_slice(&right[size * knot..][..size]);
            if i > 0 {
                let leg = self.leg_before(knot);
                let from = &before[size * (i - 1)..];
                self.carry(isometries, leg, Direction::Forward, from, &mut carried)?;
                subtract_product::<C>(&self.below[knot], &carried, at);
            }
            multiply::<C>(&self.steps[i].0, at);
        }
        for i in (0..self.order.len() - 1).rev() {
            let (at, after) = all.split_at_mut(size * (i + 1));
            let leg = self.order[i];
            self.carry(
                isometries,
                leg,
                Direction::Backward,
                &after[..size],
                &mut carried,
            )?;
            subtract_product::<C>(&self.steps[i].1, &carried, &mut at[size * i..]);
        }
        let first = match self.shape {
            ChainShape::Open => 0,
            ChainShape::Closed => UNROLLED,
        };
        for (&knot, value) in self.order[first..]
            .iter()
            .zip(all[size * first..].chunks_exact(size))
            .take(self.rows)
        {
            right[size * knot..][..size].copy_from_slice(value);
        }
        Ok(())
    }

    fn leg_before(&self, knot: usize) -> usize {
        (knot + self.rows - 1) % self.rows
    }

    fn carry(
        &self,
        isometries: &mut impl Isometries,
        leg: usize,
        way: Direction,
        from: &[f64],
        to: &mut [f64],
    ) -> Result<()> {
        let size = isometries.size();
        for (from, to) in from.chunks_exact(size).zip(to.chunks_exact_mut(size)) {
            isometries.carry_into(leg, way, from, to)?;
        }
        Ok(())
    }
}

/// The diagonal blocks of the inverse of the matrix of numbers, by elimination from both ends: `(D + E - A)^{-1}` with
/// the pivots `D` and `E` of the two eliminations. `None` if one is singular.
pub(crate) fn diagonal_of_inverse<const C: usize>(rows: &[Row<C>]) -> Option<Vec<Block<C>>> {
    let pivots = |order: &mut dyn Iterator<Item = usize>, forward: bool| -> Option<Vec<Block<C>>> {
        let mut out = vec![[[0.0; C]; C]; rows.len()];
        let mut before: Option<usize> = None;
        for i in order {
            let mut pivot = rows[i].diagonal;
            if let Some(before) = before {
                let (towards, back) = if forward {
                    (&rows[i].below, &rows[before].above)
                } else {
                    (&rows[i].above, &rows[before].below)
                };
                let share = product(&inverse(out[before])?, back);
                subtract(&mut pivot, &product(towards, &share));
            }
            out[i] = pivot;
            before = Some(i);
        }
        Some(out)
    };
    let down = pivots(&mut (0..rows.len()), true)?;
    let up = pivots(&mut (0..rows.len()).rev(), false)?;
    (0..rows.len())
        .map(|i| {
            let mut sum = down[i];
            for (sum, up) in sum.iter_mut().flatten().zip(up[i].iter().flatten()) {
                *sum += up;
            }
            subtract(&mut sum, &rows[i].diagonal);
            inverse(sum)
        })
        .collect()
}

fn subtract<const C: usize>(a: &mut Block<C>, b: &Block<C>) {
    for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        *a -= b;
    }
}

fn product<const C: usize>(a: &Block<C>, b: &Block<C>) -> Block<C> {
    let mut out = [[0.0; C]; C];
    for (out, a) in out.iter_mut().zip(a) {
        for (a, b) in a.iter().zip(b) {
            for (out, b) in out.iter_mut().zip(b) {
                *out += a * b;
            }
        }
    }
    out
}

/// The inverse by Gauss-Jordan elimination with row pivoting.
fn inverse<const C: usize>(mut a: Block<C>) -> Option<Block<C>> {
    let mut out = [[0.0; C]; C];
    for (i, row) in out.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for col in 0..C {
        let pivot = (col..C).max_by(|&i, &j| a[i][col].abs().total_cmp(&a[j][col].abs()))?;
        a.swap(col, pivot);
        out.swap(col, pivot);
        let factor = 1.0 / a[col][col];
        if !factor.is_finite() {
            return None;
        }
        for j in 0..C {
            a[col][j] *= factor;
            out[col][j] *= factor;
        }
        for row in (0..C).filter(|&row| row != col) {
            let factor = a[row][col];
            for j in 0..C {
                a[row][j] -= factor * a[col][j];
                out[row][j] -= factor * out[col][j];
            }
        }
    }
    Some(out)
}

/// `at -= block * fields of from`.
fn subtract_product<const C: usize>(block: &Block<C>, from: &[f64], at: &mut [f64]) {
    let size = from.len() / C;
    for (row, at) in block.iter().zip(at.chunks_exact_mut(size)) {
        for (factor, from) in row.iter().zip(from.chunks_exact(size)) {
            for (at, from) in at.iter_mut().zip(from) {
                *at -= factor * from;
            }
        }
    }
}

/// `at = block * fields of at`.
fn multiply<const C: usize>(block: &Block<C>, at: &mut [f64]) {
    let size = at.len() / C;
    for i in 0..size {
        let old: [f64; C] = std::array::from_fn(|field| at[field * size + i]);
        for (field, row) in block.iter().enumerate() {
            at[field * size + i] = row.iter().zip(old).map(|(factor, x)| factor * x).sum();
        }
    }
}
