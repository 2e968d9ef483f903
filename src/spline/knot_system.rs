//! The second derivative of half the cost of a spline by the velocities at its knots, factored.
//!
//! In the frame of each knot, with velocities measured so that the diagonal of flat space is one:
//!
//! ```math
//! \frac{1}{h_-}\begin{pmatrix} 4 & 2 \end{pmatrix},\quad \frac{1}{h_+}\begin{pmatrix} 4 & 2 \end{pmatrix}
//!     \quad\text{by}\quad \sqrt{4/h_- + 4/h_+}
//! ```
//!
//! What is outside of the span of the knots obeys, row by row, a system of blocks of size `k`.

use faer::{Mat, MatRef, Scale};
use rayon::prelude::*;

use super::knot_states::{KnotStates, SOLVER};
use crate::cubic::initial::{Horizontal, complete};
use crate::cubic::linear_piece::LinearPiece;
use crate::cubic::problem::{pack, unpack};
use crate::cubic::reduced::Sized;
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::solve::block_tridiagonal::{BlockTridiagonal, Factors};

/// A system whose smallest eigenvalue is below this share of the largest counts as singular, as for boundary problems.
const SINGULAR: f64 = 1e-11;

/// Numbers that the factors may have in one of their four parts: 0.2 gigabytes each.
const LARGEST: usize = 25_000_000;

/// Products with the inverse by which its norm is estimated.
const POWERS: usize = 4;

/// Which knots have a velocity of their own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Freedom {
    /// The last knot is the first one.
    pub(super) closed: bool,
    /// Whether the velocities at the first and at the last knot are given.
    pub(super) fixed: [bool; 2],
}

/// The factored system.
pub(super) struct KnotSystem {
    span: Span,
    /// Shape `(r, r)`, the first columns are the points.
    frames: Vec<Mat<f64>>,
    scales: Vec<f64>,
    inner: Option<Factors>,
    rows: Option<Factors>,
    k: usize,
}

/// Blocks of one piece: rows and columns of the velocity at its start and at its end.
type Blocks = [[Vec<f64>; 2]; 2];

/// Parts of the stiffness that belong to velocities.
const VELOCITIES: [usize; 2] = [1, 3];

/// Error where the factors of a system in a span would be too large.
///
/// # Errors
/// `InvalidArgument`.
pub(super) fn check_size(states: &KnotStates, span: &Span) -> Result<()> {
    let (n, k) = states.point(0).shape();
    let r = span.basis().map_or(n, |basis| basis.ncols());
    let d = r * k - k * (k + 1) / 2;
    let numbers = states.count() * d * d;
    if numbers <= LARGEST {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "points",
        requirement: "few and small enough for factors of 2.5e7 numbers: knots times the square of the dimension",
        found: numbers as f64,
    })
}

impl KnotSystem {
    /// # Errors
    /// `ConjugateEnds` where it is singular; `Overflow`, `Interrupted`.
    pub(super) fn new(
        states: &KnotStates,
        pieces: &[LinearPiece],
        span: Span,
        freedom: Freedom,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let count = states.count() - usize::from(freedom.closed);
        let k = states.point(0).ncols();
        let frames: Vec<Mat<f64>> = (0..count)
            .map(|knot| complete(span.down(states.point(knot)).as_ref()))
            .collect();
        let mut system = KnotSystem {
            scales: scales(states, freedom),
            span,
            frames,
            inner: None,
            rows: None,
            k,
        };
        let blocks: Vec<Blocks> = (0..pieces.len())
            .into_par_iter()
            .map(|piece| system.blocks(&pieces[piece], piece, interrupt))
            .collect::<Result<_>>()?;
        let d = system.dim();
        system.inner = system.factored(states, &blocks, d, freedom)?;
        if system.span.basis().is_some() {
            let blocks: Vec<Blocks> = pieces.iter().map(row_blocks).collect();
            system.rows = system.factored(states, &blocks, k, freedom)?;
        }
        Ok(system)
    }

    /// The change of the velocities that makes up for the given rest of the equations, tangent vectors of shape `(n, k)` both.
    pub(super) fn solve(&self, right: &[Mat<f64>]) -> Vec<Mat<f64>> {
        let mut all = Vec::new();
        for (knot, right) in right.iter().enumerate() {
            let scale = self.scales[knot].recip();
            all.extend(self.down(knot, right).iter().map(|x| scale * x));
        }
        if let Some(inner) = &self.inner {
            inner.solve(&mut all);
        }
        let d = self.dim();
        let mut out: Vec<Mat<f64>> = (0..right.len())
            .map(|knot| self.up(knot, &all[knot * d..][..d]) * Scale(self.scales[knot].recip()))
            .collect();
        self.solve_rows(right, &mut out);
        out
    }

    fn solve_rows(&self, right: &[Mat<f64>], out: &mut [Mat<f64>]) {
        let (Some(basis), Some(rows)) = (self.span.basis(), &self.rows) else {
            return;
        };
        let off: Vec<Mat<f64>> = right
            .iter()
            .map(|right| right - basis * (basis.transpose() * right))
            .collect();
        for row in 0..basis.nrows() {
            let entry = |(knot, off): (usize, &Mat<f64>)| {
                let scale = self.scales[knot].recip();
                (0..self.k)
                    .map(move |j| scale * off[(row, j)])
                    .collect::<Vec<_>>()
            };
            let mut b: Vec<f64> = off.iter().enumerate().flat_map(entry).collect();
            rows.solve(&mut b);
            for (knot, out) in out.iter_mut().enumerate() {
                for j in 0..self.k {
                    out[(row, j)] += b[knot * self.k + j] / self.scales[knot];
                }
            }
        }
    }

    fn shape(&self) -> Sized {
        Sized {
            m: self.frames[0].nrows() - self.k,
            k: self.k,
        }
    }

    fn dim(&self) -> usize {
        let Sized { m, k } = self.shape();
        k * (k - 1) / 2 + m * k
    }

    /// Coordinates in the frame of a knot.
    fn down(&self, knot: usize, v: &Mat<f64>) -> Vec<f64> {
        let low = self.span.down(v.as_ref());
        pack(&[Horizontal::of_tangent(
            self.frames[knot].as_ref(),
            low.as_ref(),
        )])
    }

    fn up(&self, knot: usize, x: &[f64]) -> Mat<f64> {
        let [vector] = unpack(x, self.shape());
        self.span
            .lift((&self.frames[knot] * vector.tangent()).as_ref())
    }

    /// The blocks of a piece in its own time.
    fn blocks(
        &self,
        piece: &LinearPiece,
        index: usize,
        interrupt: Interrupt<'_>,
    ) -> Result<Blocks> {
        let (d, count) = (self.dim(), self.frames.len());
        let knots = [index, (index + 1) % count];
        let (n, k) = (self.span.lift(self.frames[0].as_ref()).nrows(), self.k);
        let mut blocks: Blocks = std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; d * d]));
        for column in 0..2 * d {
            interrupt.check(SOLVER)?;
            let (end, q) = (column / d, column % d);
            let mut unit = vec![0.0; d];
            unit[q] = 1.0;
            let mut z: [Mat<f64>; 4] = std::array::from_fn(|_| Mat::zeros(n, k));
            z[VELOCITIES[end]] = self.up(knots[end], &unit);
            let found = piece.stiffness(&z);
            for (row, &knot) in knots.iter().enumerate() {
                let entries = self.down(knot, &found[VELOCITIES[row]]);
                for (p, x) in entries.into_iter().enumerate() {
                    blocks[row][end][p * d + q] = x;
                }
            }
        }
        Ok(blocks)
    }

    fn factored(
        &self,
        states: &KnotStates,
        blocks: &[Blocks],
        d: usize,
        freedom: Freedom,
    ) -> Result<Option<Factors>> {
        if d == 0 {
            return Ok(None);
        }
        let count = self.frames.len();
        let matrix = assembled(states, &self.scales, |leg| &blocks[leg], d, freedom);
        let largest = largest_row(&matrix, d);
        let singular = |smallest: f64| Error::ConjugateEnds { smallest, largest };
        let factors = match freedom.closed {
            true => matrix.factored_cyclic(),
            false => matrix.factored(),
        };
        let factors = factors.ok_or(singular(0.0))?;
        let smallest = smallest_eigenvalue(&factors, count * d);
        if smallest > SINGULAR * largest {
            return Ok(Some(factors));
        }
        Err(singular(smallest))
    }
}

/// The matrix of all pieces.
fn assembled<'b>(
    states: &KnotStates,
    scales: &[f64],
    block: impl Fn(usize) -> &'b Blocks,
    d: usize,
    freedom: Freedom,
) -> BlockTridiagonal {
    let (count, square) = (scales.len(), d * d);
    let mut matrix = BlockTridiagonal::zeros(count, d);
    for (leg, length) in states.lengths.iter().enumerate() {
        let (first, last) = (leg, (leg + 1) % count);
        let add = |to: &mut [f64], [row, column]: [usize; 2], knots: [usize; 2]| {
            let factor = length.recip() / (scales[knots[0]] * scales[knots[1]]);
            for (to, x) in to.iter_mut().zip(&block(leg)[row][column]) {
                *to += factor * x;
            }
        };
        let at = |knot: usize| knot * square..(knot + 1) * square;
        add(&mut matrix.diagonal[at(first)], [0, 0], [first, first]);
        add(&mut matrix.diagonal[at(last)], [1, 1], [last, last]);
        add(&mut matrix.above[at(first)], [0, 1], [first, last]);
        add(&mut matrix.below[at(last)], [1, 0], [last, first]);
    }
    fix(&mut matrix, count, d, freedom);
    matrix
}

/// Roots of the diagonal of flat space.
fn scales(states: &KnotStates, freedom: Freedom) -> Vec<f64> {
    let count = states.count() - usize::from(freedom.closed);
    let mut diagonal = vec![0.0; count];
    for (leg, h) in states.lengths.iter().enumerate() {
        diagonal[leg] += 4.0 / h;
        diagonal[(leg + 1) % count] += 4.0 / h;
    }
    diagonal.into_iter().map(f64::sqrt).collect()
}

/// Those of the velocities for a row outside of the span of a piece, in its own time.
fn row_blocks(piece: &LinearPiece) -> Blocks {
    VELOCITIES.map(|row| {
        VELOCITIES.map(|column| {
            let block: MatRef<'_, f64> = piece.row_block(row, column).expect("a span of its own");
            let k = block.ncols();
            (0..k * k).map(|at| block[(at / k, at % k)]).collect()
        })
    })
}

/// Velocities that are given do not change.
fn fix(matrix: &mut BlockTridiagonal, count: usize, d: usize, freedom: Freedom) {
    let square = d * d;
    let at = |knot: usize| knot * square..(knot + 1) * square;
    for (knot, fixed) in [0, count - 1].into_iter().zip(freedom.fixed) {
        if !fixed {
            continue;
        }
        for blocks in [&mut matrix.diagonal, &mut matrix.above, &mut matrix.below] {
            blocks[at(knot)].fill(0.0);
        }
        for i in 0..d {
            matrix.diagonal[knot * square + i * d + i] = 1.0;
        }
        if knot > 0 {
            matrix.above[at(knot - 1)].fill(0.0);
        }
        if knot + 1 < count {
            matrix.below[at(knot + 1)].fill(0.0);
        }
    }
}

/// The largest sum of absolute values of a row.
fn largest_row(matrix: &BlockTridiagonal, d: usize) -> f64 {
    let rows = |blocks: &[f64]| -> Vec<f64> {
        let sum = |row: &[f64]| row.iter().map(|x| x.abs()).sum::<f64>();
        blocks.chunks_exact(d).map(sum).collect()
    };
    let parts = [&matrix.below, &matrix.diagonal, &matrix.above].map(|blocks| rows(blocks));
    (0..parts[0].len())
        .map(|row| parts.iter().map(|part| part[row]).sum::<f64>())
        .fold(0.0, f64::max)
}

/// The smallest absolute value of an eigenvalue, by powers of the inverse; 0 where that is not finite.
fn smallest_eigenvalue(factors: &Factors, size: usize) -> f64 {
    // Entries without a pattern that an eigenvector could be orthogonal to.
    let mut x: Vec<f64> = (0..size).map(|i| (1.0 + 1.7 * i as f64).sin()).collect();
    let mut smallest = 0.0;
    for _ in 0..POWERS {
        let before = length(&x);
        x.iter_mut().for_each(|x| *x /= before);
        factors.solve(&mut x);
        smallest = length(&x).recip();
        if !smallest.is_normal() {
            return 0.0;
        }
    }
    smallest
}

fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
