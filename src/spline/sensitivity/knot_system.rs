//! The second derivative of half the cost of a spline with respect to the velocities at its knots, factored.
//!
//! In the frame of each knot, with velocities scaled such that the diagonal is one in flat space:
//!
//! ```math
//! \frac{1}{h_-}\begin{pmatrix} 4 & 2 \end{pmatrix},\quad \frac{1}{h_+}\begin{pmatrix} 4 & 2 \end{pmatrix}
//!     \quad\text{by}\quad \sqrt{4/h_- + 4/h_+}
//! ```
//!
//! Each row outside the span of the knots satisfies a system with blocks of size `k`.
//!
//! A closed curve of subspaces returns to its first knot with the basis `Y_0 H`, at which a vector `w` at the basis
//! `Y_0` is `w H`; the blocks of the last piece, and the vectors at the last knot, are expressed in the first basis.

use faer::{Mat, MatRef};

use super::given::GivenEnd;
use super::knot_states::{KnotStates, SOLVER};
use crate::cubic::sensitivity::linear_piece::LinearPiece;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::complete;
use crate::cubic::taylor::packing::{read_vector, write_vector};
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::product::{columns, columns_mut, mul_add, mul_into};
use crate::linalg::structure::row_by_row;
use crate::shooting::DENSE;
use crate::solve::block_tridiagonal::{BlockTridiagonal, Factors};
use crate::solve::gmres::norm;
use crate::space::Quotient;
use crate::threads::{self, scaled};

/// Microseconds of the blocks of a piece between rotations.
const BLOCKS: f64 = 0.7;

/// A system counts as singular if its smallest eigenvalue is below this fraction of the largest, as for boundary
/// problems.
const SINGULAR: f64 = 1e-11;

/// Maximal number of floating-point numbers that a derivative may store: four gigabytes.
const LARGEST: f64 = 5e8;

/// Number of products with the inverse used to estimate its norm.
const POWERS: usize = 4;

/// The factored system.
pub(crate) struct KnotSystem {
    /// Shape `(n, r)`: the first columns are the point, and all columns span the knots.
    frames: Vec<Mat<f64>>,
    /// Shape of a point.
    shape: (usize, usize),
    /// Scales of the velocities: reciprocal square roots of the diagonal in flat space, and 0 for given velocities.
    units: Vec<f64>,
    inner: Option<Factors>,
    rows: Option<Factors>,
    closed: bool,
    /// Maps the first basis of a closed curve of subspaces to its last one.
    holonomy: Option<Mat<f64>>,
    quotient: Quotient,
}

/// Blocks of one piece: rows and columns of the velocity at its start and at its end.
type KnotBlocks = [[Vec<f64>; 2]; 2];

/// Return an error if the derivative would be too large. Every piece stores a matrix of shape `(4 d, 4 d)` in the `d`
/// dimensions of its own span, up to [`DENSE`] dimensions also matrices of shape `(d, 4 d)` and frames at some 20
/// points, and its part of the factors in the dimensions of the span of the knots.
///
/// # Errors
/// `InvalidArgument`.
pub(crate) fn check_size(states: &KnotStates, span: &Span) -> Result<()> {
    let (n, k) = states.shape;
    let dim = |r: usize| (r - k) * k + states.quotient.turns(k);
    let all = span.basis().map_or(n, |basis| basis.ncols());
    let own = all.min(4 * k);
    let at_points = match dim(own) <= DENSE {
        true => 80 * dim(own).pow(2) + 20 * own * own,
        false => 0,
    };
    let of_piece = at_points + 16 * dim(own).pow(2) + 4 * dim(all).pow(2) + 500;
    let numbers = states.count() as f64 * of_piece as f64;
    if numbers <= LARGEST {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "points",
        requirement: "few and small enough for the derivative to have at most 5e8 numbers",
        found: numbers,
    })
}

impl KnotSystem {
    /// # Errors
    /// `ConjugateEnds` if the system is singular; `Overflow`, `Interrupted`.
    pub(crate) fn new(
        states: &KnotStates,
        pieces: &[LinearPiece],
        span: &Span,
        given: [GivenEnd; 2],
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let closed = given[0] == GivenEnd::OtherEnd;
        let count = states.count() - usize::from(closed);
        let frame = |knot| span.lift(complete(span.down(states.point(knot)).as_ref()).as_ref());
        let frames: Vec<Mat<f64>> = (0..count).map(frame).collect();
        let mut diagonal = vec![0.0; count];
        for (leg, h) in states.lengths.iter().enumerate() {
            diagonal[leg] += 4.0 / h;
            diagonal[(leg + 1) % count] += 4.0 / h;
        }
        let mut units: Vec<f64> = diagonal.into_iter().map(|x| x.sqrt().recip()).collect();
        for (knot, given) in [0, count - 1].into_iter().zip(given) {
            if given == GivenEnd::Velocity {
                units[knot] = 0.0;
            }
        }
        let mut system = KnotSystem {
            frames,
            units,
            inner: None,
            rows: None,
            closed,
            holonomy: states.holonomy(given)?,
            quotient: states.quotient,
            shape: states.shape,
        };
        let blocks = |(): &mut (), leg: usize| {
            interrupt.check(SOLVER)?;
            let frames = [leg, (leg + 1) % count].map(|knot| system.frames[knot].as_ref());
            Ok(pieces[leg].by_velocities(frames))
        };
        let each = scaled(BLOCKS, states.shape);
        let blocks: Vec<KnotBlocks> = threads::map(pieces.len(), each, || (), blocks)?;
        system.inner = system.factored(&states.lengths, &blocks)?;
        if span.basis().is_some() {
            let blocks: Option<Vec<KnotBlocks>> =
                pieces.iter().map(LinearPiece::by_velocity_rows).collect();
            system.rows = system.factored(&states.lengths, &blocks.unwrap_or_default())?;
        }
        Ok(system)
    }

    /// The change of the velocities at all knots that cancels the given residual of the equations, both tangent vectors
    /// of shape `(n, k)` by columns: zero where velocities are given, equal at both ends of a closed curve.
    pub(crate) fn solve(&self, rest: &[f64]) -> Vec<f64> {
        let ((n, k), r) = (self.shape, self.frames[0].ncols());
        let (count, size) = (self.frames.len(), n * k);
        let mut right = rest[..count * size].to_vec();
        if self.closed {
            let last = columns(&rest[count * size..], n);
            let mut first = columns_mut(&mut right[..size], n);
            match &self.holonomy {
                Some(holonomy) => mul_add(&mut first, 1.0, last, holonomy.transpose()),
                None => first += last,
            }
        }
        let scale = |all: &mut [f64]| {
            for (x, unit) in all.chunks_exact_mut(size).zip(&self.units) {
                x.iter_mut().for_each(|x| *x *= unit);
            }
        };
        scale(&mut right);
        let blocks = Sizes::new(r - k, k, self.quotient);
        let d = blocks.dim();
        let mut all = vec![0.0; count * d];
        let mut low = vec![0.0; r * k];
        for (knot, (frame, x)) in self.frames.iter().zip(right.chunks_exact(size)).enumerate() {
            mul_into(
                columns_mut(&mut low, r),
                1.0,
                frame.transpose(),
                columns(x, n),
            );
            read_vector(&low, &mut all[knot * d..], r, blocks);
        }
        if let Some(inner) = &self.inner {
            inner.solve(&mut all);
        }
        let mut out = vec![0.0; count * size];
        for (knot, (frame, out)) in self
            .frames
            .iter()
            .zip(out.chunks_exact_mut(size))
            .enumerate()
        {
            write_vector(&mut low, &all[knot * d..], r, blocks);
            mul_into(columns_mut(out, n), 1.0, frame, columns(&low, r));
        }
        if let Some(rows) = &self.rows {
            let basis = &self.frames[0];
            let all = columns(&right, n);
            let off = all - basis * (basis.transpose() * all);
            for row in 0..n {
                let mut b: Vec<f64> = off.row(row).iter().copied().collect();
                rows.solve(&mut b);
                for (column, x) in b.into_iter().enumerate() {
                    out[column * n + row] += x;
                }
            }
        }
        scale(&mut out);
        if self.closed {
            let mut last = out[..size].to_vec();
            if let Some(holonomy) = &self.holonomy {
                mul_into(
                    columns_mut(&mut last, n),
                    1.0,
                    columns(&out[..size], n),
                    holonomy,
                );
            }
            out.extend(last);
        }
        out
    }

    /// Factors the system from the blocks of all pieces in their own time.
    fn factored(&self, lengths: &[f64], blocks: &[KnotBlocks]) -> Result<Option<Factors>> {
        let count = self.units.len();
        let square = blocks.first().map_or(0, |blocks| blocks[0][0].len());
        let d = square.isqrt();
        if d == 0 {
            return Ok(None);
        }
        let mut matrix = BlockTridiagonal::zeros(count, d);
        let last = match &self.holonomy {
            Some(holonomy) => blocks.last().map(|blocks| at_first_basis(blocks, holonomy)),
            None => None,
        };
        let blocks = blocks.iter().enumerate().map(|(leg, own)| match &last {
            Some(last) if leg + 1 == blocks.len() => last,
            _ => own,
        });
        for (leg, (blocks, length)) in blocks.zip(lengths).enumerate() {
            let knots = [leg, (leg + 1) % count];
            let add = |to: &mut [f64], row: usize, column: usize| {
                let factor = self.units[knots[row]] * self.units[knots[column]] / length;
                for (to, x) in to[knots[row] * square..]
                    .iter_mut()
                    .zip(&blocks[row][column])
                {
                    *to += factor * x;
                }
            };
            add(&mut matrix.diagonal, 0, 0);
            add(&mut matrix.diagonal, 1, 1);
            add(&mut matrix.above, 0, 1);
            add(&mut matrix.below, 1, 0);
        }
        for (knot, unit) in self.units.iter().enumerate() {
            if *unit == 0.0 {
                (0..d).for_each(|i| matrix.diagonal[knot * square + i * d + i] = 1.0);
            }
        }
        let largest = largest_row(&matrix, d);
        let singular = |smallest: f64| Error::ConjugateEnds { smallest, largest };
        let factors = match self.closed {
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

/// Blocks of a piece that ends with the basis `Y_0 H`, in terms of the velocity `b` there at the basis `Y_0`: at its
/// own basis the velocity is `b H`, in column-major order.
fn at_first_basis(blocks: &KnotBlocks, holonomy: &Mat<f64>) -> KnotBlocks {
    let (d, k) = (blocks[0][0].len().isqrt(), holonomy.nrows());
    let rows = d / k;
    let turn = Mat::from_fn(d, d, |i, j| match i % rows == j % rows {
        true => holonomy[(j / rows, i / rows)],
        false => 0.0,
    });
    let block =
        |row: usize, column: usize| MatRef::from_row_major_slice(&blocks[row][column], d, d);
    let entries = |matrix: Mat<f64>| row_by_row(matrix.as_ref()).collect();
    [
        [blocks[0][0].clone(), entries(block(0, 1) * &turn)],
        [
            entries(turn.transpose() * block(1, 0)),
            entries(turn.transpose() * block(1, 1) * &turn),
        ],
    ]
}

/// The largest sum of absolute values in a row.
fn largest_row(matrix: &BlockTridiagonal, d: usize) -> f64 {
    let parts = [&matrix.below, &matrix.diagonal, &matrix.above];
    let entries = |row: usize| {
        parts
            .into_iter()
            .flat_map(move |part| &part[row * d..][..d])
    };
    let sums = (0..matrix.diagonal.len() / d).map(|row| entries(row).map(|x| x.abs()).sum());
    sums.fold(0.0, f64::max)
}

/// The smallest absolute value of an eigenvalue, by inverse power iteration; 0 if it is not finite.
fn smallest_eigenvalue(factors: &Factors, size: usize) -> f64 {
    // Irregular entries, so that no eigenvector is orthogonal to them.
    let mut x: Vec<f64> = (0..size).map(|i| (1.0 + 1.7 * i as f64).sin()).collect();
    let mut smallest = 0.0;
    for _ in 0..POWERS {
        let before = norm(&x);
        x.iter_mut().for_each(|x| *x /= before);
        factors.solve(&mut x);
        smallest = norm(&x).recip();
        if !smallest.is_normal() {
            return 0.0;
        }
    }
    smallest
}
