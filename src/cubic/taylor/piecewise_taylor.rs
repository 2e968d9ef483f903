//! A Riemannian cubic as a piecewise polynomial, in coordinates of its span: Taylor polynomials of the steps of an
//! integration, or the polynomials of solved legs.

use faer::{MatMut, MatRef};

use super::blocks::{BlockSeries, BlockSizes, FixedSizes, Sizes, block};
use super::horner::{shift_into, shift_small_into, sum_into};
use super::march::{Accuracy, MAX_STEPS, SOLVER, TaylorMarch};
use super::state::State;
use crate::curve::gauss_legendre::{PANEL, POINTS};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::space::Quotient;

/// Maximal number of coefficients of a curve: a gigabyte.
const MAX_COEFFICIENTS: usize = 1 << 27;

/// Number of pieces for which space is reserved.
const USUAL_STEPS: usize = 6;

/// Relative accuracy of times, as a fraction of the largest time.
const SLACK: f64 = 8.0 * f64::EPSILON;

/// One polynomial: the interval on which it is used, and its center of expansion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TaylorPiece {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    pub(crate) center: f64,
}

/// The pieces in order of time, and the states at both ends.
#[derive(Debug, Clone)]
pub(crate) struct PiecewiseTaylor {
    pub(crate) blocks: Sizes,
    pub(crate) accuracy: Accuracy,
    pub(crate) pieces: Vec<TaylorPiece>,
    /// Coefficients of the point, `(order + 1) rows k` per piece.
    pub(crate) points: Vec<f64>,
    /// Coefficients of `x`, `(order + 1) k (k + m)` per piece: order by order, `omega` before `b`.
    pub(crate) vectors: Vec<f64>,
    pub(crate) first: State,
    pub(crate) last: State,
}

impl PiecewiseTaylor {
    /// No pieces yet: the curve at the time of its state.
    pub(crate) fn at(state: State, accuracy: Accuracy) -> Self {
        PiecewiseTaylor {
            blocks: state.blocks,
            accuracy,
            pieces: Vec::new(),
            points: Vec::new(),
            vectors: Vec::new(),
            first: state.clone(),
            last: state,
        }
    }

    /// A single polynomial in `t - 1/2` on `[0, 1]`, with the states at its ends; coefficients of the point and of `x`
    /// in storage order.
    pub(crate) fn of_polynomial(
        [first, last]: [State; 2],
        order: usize,
        points: Vec<f64>,
        vectors: Vec<f64>,
    ) -> Self {
        let piece = TaylorPiece {
            lower: 0.0,
            upper: 1.0,
            center: 0.5,
        };
        PiecewiseTaylor {
            blocks: first.blocks,
            accuracy: Accuracy::FULL.with_order(order),
            pieces: vec![piece],
            points,
            vectors,
            first,
            last,
        }
    }

    /// The curve followed by another one of the same sizes and accuracy, which starts where it ends.
    pub(crate) fn followed_by(mut self, next: Self) -> Self {
        self.pieces.extend(next.pieces);
        self.points.extend(next.points);
        self.vectors.extend(next.vectors);
        self.last = next.last;
        self
    }

    /// The meaning of the points: frames or subspaces.
    pub(crate) fn quotient(&self) -> Quotient {
        self.blocks.quotient
    }

    /// The lines spanned by the vectors of a curve on a sphere.
    pub(crate) fn of_lines(&self) -> Self {
        let mut taylor = self.clone();
        taylor.blocks.quotient = Quotient::Subspaces;
        for state in [&mut taylor.first, &mut taylor.last] {
            state.blocks.quotient = Quotient::Subspaces;
        }
        taylor
    }

    /// The subspaces with bases `Y Q` for an orthogonal `Q`, shape `(k, k)`: `b` becomes `b Q`.
    pub(crate) fn in_terms_of(&self, q: MatRef<'_, f64>) -> Self {
        let (k, r, rows) = (self.blocks.k, self.r(), self.rows());
        let turn = |entries: &mut [f64], rows: usize| {
            if rows == 0 {
                return;
            }
            for block in entries.chunks_exact_mut(rows * k) {
                let turned = MatRef::from_column_major_slice(block, rows, k) * q;
                MatMut::from_column_major_slice_mut(block, rows, k).copy_from(&turned);
            }
        };
        // `omega` is zero.
        let turn_vectors = |entries: &mut [f64]| {
            for vector in entries.chunks_exact_mut(r * k) {
                turn(&mut vector[k * k..], r - k);
            }
        };
        let mut taylor = self.clone();
        turn(&mut taylor.points, rows);
        turn_vectors(&mut taylor.vectors);
        for state in [&mut taylor.first, &mut taylor.last] {
            let (frame, vectors) = state.entries.split_at_mut(r * r);
            turn(&mut frame[..r * k], r);
            turn_vectors(vectors);
        }
        taylor
    }

    /// Rows of a point in the coordinates of the span.
    pub(crate) fn r(&self) -> usize {
        self.blocks.m + self.blocks.k
    }

    /// Rows of a stored point, including padding.
    pub(crate) fn rows(&self) -> usize {
        self.blocks.r::<f64>()
    }

    /// The interval that the pieces cover.
    pub(crate) fn covered(&self) -> (f64, f64) {
        (self.first.time, self.last.time)
    }

    /// Whether the pieces cover a time, up to round-off.
    pub(crate) fn covers(&self, t: f64) -> bool {
        let (start, end) = self.covered();
        let slack = SLACK * start.abs().max(end.abs());
        t >= start - slack && t <= end + slack
    }

    /// Appends pieces at an end until they reach `t`.
    ///
    /// # Errors
    /// `TooManySteps` (too many for the limit or for memory), `Overflow`, `Interrupted`.
    pub(crate) fn extend_to(&mut self, t: f64, interrupt: Interrupt<'_>) -> Result<()> {
        self.extend_within(MAX_STEPS, t, interrupt)
    }

    /// The same within a number of steps.
    ///
    /// # Errors
    /// As [`PiecewiseTaylor::extend_to`].
    pub(crate) fn extend_within(
        &mut self,
        most: usize,
        t: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        if self.covers(t) {
            return Ok(());
        }
        let Sizes { m, k, quotient, .. } = self.blocks;
        // With sizes known only at run time, initial value problems of these shapes take 2.6 to 4.4 times as long.
        match (m, k) {
            // Lines are treated as points of the sphere.
            _ if quotient == Quotient::Subspaces && k > 1 => {
                self.march(self.blocks, (most, t), interrupt)
            }
            (0, 2) => self.march(FixedSizes::<0, 2>, (most, t), interrupt),
            (0, 3) => self.march(FixedSizes::<0, 3>, (most, t), interrupt),
            (1, 1) => self.march(FixedSizes::<1, 1>, (most, t), interrupt),
            (2, 1) => self.march(FixedSizes::<2, 1>, (most, t), interrupt),
            (3, 1) => self.march(FixedSizes::<3, 1>, (most, t), interrupt),
            (1, 2) => self.march(FixedSizes::<1, 2>, (most, t), interrupt),
            (2, 2) => self.march(FixedSizes::<2, 2>, (most, t), interrupt),
            (3, 2) => self.march(FixedSizes::<3, 2>, (most, t), interrupt),
            _ => self.march(self.blocks, (most, t), interrupt),
        }
    }

    fn march(
        &mut self,
        blocks: impl BlockSizes,
        (most, t): (usize, f64),
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let forward = t > self.last.time;
        // Steps with more terms than usual would be longer, with terms that cancel.
        let usual = self.accuracy.order.min(Accuracy::FULL.order);
        let accuracy = self.accuracy.with_order(usual);
        let mut march = TaylorMarch::new(blocks, accuracy);
        march.max_steps = most;
        let from = if forward { &self.last } else { &self.first };
        from.load(blocks, &mut march.series);
        march.time = from.time;
        let PiecewiseTaylor {
            pieces,
            points,
            vectors,
            ..
        } = self;
        let (pieces_before, size) = (pieces.len(), self.accuracy.order + 1);
        let k = blocks.k();
        let (rk, vector) = (blocks.r::<f64>() * k, k * (k + blocks.normals()));
        pieces.reserve(USUAL_STEPS);
        points.reserve(USUAL_STEPS * size * rk);
        vectors.reserve(USUAL_STEPS * size * vector);
        let outcome = march.run(t, interrupt, &mut |series, start, length| {
            if points.len() + vectors.len() + 2 * size * rk > MAX_COEFFICIENTS {
                let (count, left) = ([pieces.len(); 2], (t - start).abs());
                return Err(Error::too_many_steps(SOLVER, count, left, length.abs()));
            }
            let end = start + length;
            pieces.push(TaylorPiece {
                lower: start.min(end),
                upper: start.max(end),
                center: start,
            });
            points.extend_from_slice(&series.s()[..(usual + 1) * rk]);
            push_vectors(blocks, series, usual + 1, vectors);
            // As many terms as all other pieces have.
            points.resize(pieces.len() * size * rk, 0.0);
            vectors.resize(pieces.len() * size * vector, 0.0);
            Ok(())
        });
        if let Err(error) = outcome {
            pieces.truncate(pieces_before);
            points.truncate(pieces_before * size * rk);
            vectors.truncate(pieces_before * size * vector);
            return Err(error);
        }
        if forward {
            pieces.last_mut().expect("a step was made").upper = t;
            self.last.store(blocks, &march.series, t);
        } else {
            // Backward steps were appended in reverse order.
            pieces.last_mut().expect("a step was made").lower = t;
            self.first.store(blocks, &march.series, t);
            self.sort();
        }
        Ok(())
    }

    /// Sorts the pieces by time.
    fn sort(&mut self) {
        let order_of = self.accuracy.order + 1;
        let mut order: Vec<usize> = (0..self.pieces.len()).collect();
        order.sort_by(|&i, &j| self.pieces[i].lower.total_cmp(&self.pieces[j].lower));
        let gather = |from: &[f64], size: usize| -> Vec<f64> {
            let stride = order_of * size;
            let pieces = order.iter().flat_map(|&i| &from[block(i, stride)]);
            pieces.copied().collect()
        };
        let k = self.blocks.k;
        self.points = gather(&self.points, self.rows() * k);
        self.vectors = gather(&self.vectors, self.r() * k);
        self.pieces = order.iter().map(|&i| self.pieces[i]).collect();
    }

    /// Index of the piece that contains a time; the nearest piece for a time outside.
    fn find(&self, t: f64) -> usize {
        let after = self.pieces.partition_point(|piece| piece.upper < t);
        after.min(self.pieces.len() - 1)
    }

    /// Taylor coefficients of the point at `t`, up to the order of `out.len() - 1`, each `(rows, k)` column by column.
    #[inline(always)]
    pub(crate) fn points_into(&self, t: f64, out: &mut [&mut [f64]]) {
        let (coefficients, t) = self.piece_at(t);
        match self.rows() * self.blocks.k {
            4 => shift_small_into::<4>(coefficients, t, out),
            8 => shift_small_into::<8>(coefficients, t, out),
            12 => shift_small_into::<12>(coefficients, t, out),
            16 => shift_small_into::<16>(coefficients, t, out),
            size => shift_into(coefficients, size, t, out),
        }
    }

    /// The point at `t`, `(rows, k)` column by column.
    #[inline(always)]
    pub(crate) fn point_into(&self, t: f64, out: &mut [f64]) {
        let (coefficients, t) = self.piece_at(t);
        match out.len() {
            4 => sum_into::<4>(coefficients, t, out),
            8 => sum_into::<8>(coefficients, t, out),
            12 => sum_into::<12>(coefficients, t, out),
            16 => sum_into::<16>(coefficients, t, out),
            size => shift_into(coefficients, size, t, &mut [out]),
        }
    }

    /// Taylor coefficients of `x` at `t`, up to the order of `out.len() - 1`, each `omega` before `b`, column by
    /// column.
    pub(crate) fn vectors_into(&self, t: f64, out: &mut [&mut [f64]]) {
        self.vectors_of_piece(self.find(t), t, out);
    }

    /// As `vectors_into`, for one piece.
    pub(crate) fn vectors_of_piece(&self, piece: usize, t: f64, out: &mut [&mut [f64]]) {
        let size = self.r() * self.blocks.k;
        let coefficients = &self.vectors[block(piece, (self.accuracy.order + 1) * size)];
        shift_into(coefficients, size, t - self.pieces[piece].center, out);
    }

    /// As [`PiecewiseTaylor::points_into`], for one piece.
    #[cfg(any(feature = "python", feature = "serde"))]
    pub(crate) fn points_of_piece(&self, piece: usize, t: f64, out: &mut [&mut [f64]]) {
        let size = self.rows() * self.blocks.k;
        let coefficients = &self.points[block(piece, (self.accuracy.order + 1) * size)];
        shift_into(coefficients, size, t - self.pieces[piece].center, out);
    }

    /// Coefficients of the piece at `t`, and the time since its center.
    #[inline(always)]
    fn piece_at(&self, t: f64) -> (&[f64], f64) {
        let piece = self.find(t);
        let stride = (self.accuracy.order + 1) * self.rows() * self.blocks.k;
        let coefficients = &self.points[block(piece, stride)];
        (coefficients, t - self.pieces[piece].center)
    }

    /// `tau` of the additional term `tau x'` in `x'''` of a cubic in tension.
    pub(crate) fn tension(&self) -> f64 {
        self.first.tension
    }

    /// `int |D_t S'|^2 + tau |S'|^2 dt` over an interval that the pieces cover.
    pub(crate) fn cost(&self, lower: f64, upper: f64) -> f64 {
        let (k2, mk) = (self.blocks.k * self.blocks.k, self.blocks.m * self.blocks.k);
        let (size, (nodes, weights)) = (k2 + mk, &*PANEL);
        let stride = (self.accuracy.order + 1) * size;
        let (mut x, mut rate) = (vec![0.0; size], vec![0.0; size]);
        // With one panel each, costs of hard boundary problems solved at nodes are off by up to 5e-10 instead of 8e-14.
        let panels = self.accuracy.order.div_ceil(2 * POINTS);
        let mut sum = 0.0;
        for (i, piece) in self.pieces.iter().enumerate() {
            let (from, to) = (piece.lower.max(lower), piece.upper.min(upper));
            if from >= to {
                continue;
            }
            let half = 0.5 * (to - from) / panels as f64;
            for q in 0..panels * POINTS {
                let (panel, q) = (q / POINTS, q % POINTS);
                let middle = from + (2 * panel + 1) as f64 * half;
                let t = middle + half * nodes[q] - piece.center;
                let coefficients = &self.vectors[block(i, stride)];
                shift_into(coefficients, size, t, &mut [&mut x, &mut rate]);
                let mut integrand = square(&rate, k2);
                if self.tension() != 0.0 {
                    integrand += self.tension() * square(&x, k2);
                }
                sum += half * weights[q] * integrand;
            }
        }
        sum
    }

    pub(crate) fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    /// Number of pieces.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }

    /// The states at both ends of the covered interval.
    pub(crate) fn ends(&self) -> [&State; 2] {
        [&self.first, &self.last]
    }
}

/// `|x|^2` of a vector, given as `k2` entries of `omega`, then `b`.
pub(crate) fn square(x: &[f64], k2: usize) -> f64 {
    let (omega, b) = x.split_at(k2);
    let square = |a: &[f64]| a.iter().map(|a| a * a).sum::<f64>();
    0.5 * square(omega) + square(b)
}

/// Appends the coefficients of `omega` and of `b` without its padding. All sizes come from the blocks, so that they are
/// constants where the blocks are: with captured ones, a curve on the sphere takes 0.5 us more.
fn push_vectors(
    blocks: impl BlockSizes,
    series: &BlockSeries<f64>,
    count: usize,
    out: &mut Vec<f64>,
) {
    let (k, m, padded) = (blocks.k(), blocks.normals(), blocks.m::<f64>());
    let (omega, b) = (series.omega(0), series.b(0));
    for j in 0..count {
        out.extend_from_slice(&omega[block(j, k * k)]);
        let b = &b[block(j, padded * k)];
        for col in 0..k {
            out.extend_from_slice(&b[padded * col..][..m]);
        }
    }
}
