//! Bases along a curve of subspaces that rotate as little as possible, as consecutive polynomials.
//!
//! From any smooth orthonormal bases `F` of the points, such bases are
//!
//! ```math
//! Y = F R,\qquad R' = -F^T F' R,
//! ```
//!
//! since then `Y^T Y' = 0`. On a piece the equation is solved by collocation at Gauss nodes, which keeps `R`
//! orthogonal, and `Y` is the polynomial through its values at the nodes and the ends. A piece is halved until its last
//! Legendre coefficients are round-off and the values at the ends agree with the polynomial through the nodes.
//!
//! # Source
//! Hairer, Lubich, Wanner (2006), "Geometric Numerical Integration", 2nd ed., theorem IV.2.1 (Gauss methods preserve
//! quadratic invariants).

use std::sync::Arc;

use faer::prelude::*;
use faer::{ColRef, Mat, MatMut, MatRef};

use super::barycentric::Barycentric;
use super::nodes::Nodes;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::MatrixJet;
use crate::linalg::product::{axpy, mul_into};
use crate::report::{SolverReport, StopReason};

const SOLVER: &str = "bases along a curve of subspaces";

/// Number of nodes of a piece.
pub(super) const NODES: usize = 20;

/// Number of values of a piece, including both ends.
const VALUES: usize = NODES + 2;

/// Last coefficients of a resolved piece, times the least cosine of the principal angles, by which round-off is
/// divided.
const RESOLVED: f64 = 32.0 * f64::EPSILON;

/// Allowed deviation of the polynomial through the nodes from the values at the ends, times that cosine; round-off
/// there is magnified by the Lebesgue constant, about 10. Only this deviation reveals a jump between an end and the
/// next node, where a principal angle passes pi/2.
const MET: f64 = 1e3 * RESOLVED;

/// Upper limit of both allowances, however near a principal angle is to pi/2: the cosine is small also where bases
/// jump.
const COARSEST: f64 = 1e-5;

/// A shorter unresolved piece marks the end of the bases: at a principal angle of pi/2 if a cosine is small.
const SHORTEST: f64 = 1e-9;
const RIGHT: f64 = 1e-3;

/// Maximal number of iterations for `R` on a piece: with `|F^T F'|` at most 1 over its length, the j-th one changes `R`
/// by `1 / j!`.
const MAX_ITERATIONS: usize = 30;

/// Maximal number of pieces, and of units of the parameter, of a continued curve.
const MAX_PIECES: usize = 1 << 12;

/// Bases along a curve, from a parameter on in one direction.
#[derive(Debug, Clone)]
pub(super) struct Lift {
    shape: [usize; 2],
    through: Arc<Barycentric>,
    pieces: Vec<LiftPiece>,
    /// The end of the last piece, and `R` at the end.
    reached: f64,
    turn: Mat<f64>,
    /// The reason why it ends there.
    obstacle: Option<Error>,
}

/// `Y` at the start, the nodes and the end, side by side; backwards in time if `to < from`.
#[derive(Debug, Clone)]
struct LiftPiece {
    from: f64,
    to: f64,
    values: Vec<f64>,
}

impl Lift {
    /// A lift without pieces: the basis `F R` at `start`, for points of shape `(r, k)`.
    pub(super) fn at(start: f64, shape: [usize; 2], turn: Mat<f64>) -> Self {
        Lift {
            shape,
            through: Barycentric::of(&Nodes::of(NODES)),
            pieces: Vec::new(),
            reached: start,
            turn,
            obstacle: None,
        }
    }

    /// A lift that continues from the end of this one.
    pub(super) fn beyond(&self) -> Self {
        Lift::at(self.reached, self.shape, self.turn.clone())
    }

    /// Appends pieces in the direction of `t`, one unit after another, until they reach it.
    ///
    /// `bases` writes Taylor coefficients of `F` up to order 1 and returns the least cosine of a principal angle that
    /// occurred.
    ///
    /// # Errors
    /// `RightAngle` if the curve ends before `t`; `NoConvergence` if round-off is too large; `TooManySteps`,
    /// `Interrupted`.
    pub(super) fn extend_to(
        &mut self,
        t: f64,
        mut bases: impl FnMut(f64, &mut MatrixJet) -> Result<f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let direction = (t - self.reached).signum();
        let mut work = LiftEquations::new(self.shape);
        while direction * (t - self.reached) > 0.0 {
            if let Some(error) = &self.obstacle {
                return Err(error.clone());
            }
            let left = (t - self.reached).abs();
            if left + self.pieces.len() as f64 > MAX_PIECES as f64 {
                return Err(too_long(self.pieces.len(), left));
            }
            let to = self.reached + direction;
            match self.add(to, &mut bases, &mut work, interrupt) {
                Err(error @ (Error::RightAngle { .. } | Error::NoConvergence { .. })) => {
                    self.obstacle = Some(error);
                }
                added => added?,
            }
        }
        Ok(())
    }

    /// Appends one piece from the current end, or its two halves, recursively.
    fn add(
        &mut self,
        to: f64,
        bases: &mut impl FnMut(f64, &mut MatrixJet) -> Result<f64>,
        work: &mut LiftEquations,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let from = self.reached;
        if self.pieces.len() >= MAX_PIECES {
            return Err(too_long(MAX_PIECES, (to - from).abs()));
        }
        let problem = match work.solve([from, to], self.turn.as_ref(), bases, interrupt) {
            Ok(None) => {
                work.end_turn(&mut self.turn);
                self.reached = to;
                self.pieces.push(LiftPiece {
                    from,
                    to,
                    values: work.bases.clone(),
                });
                return Ok(());
            }
            Ok(Some(cosine)) if cosine < RIGHT => Error::RightAngle {
                angle: cosine.acos(),
            },
            Ok(Some(_)) => unresolved(self.pieces.len(), to - from),
            Err(error @ Error::RightAngle { .. }) => error,
            Err(error) => return Err(error),
        };
        if (to - from).abs() < SHORTEST {
            return Err(problem);
        }
        self.add(0.5 * (from + to), bases, work, interrupt)?;
        self.add(to, bases, work, interrupt)
    }

    /// Writes the basis at a parameter that the pieces cover to `out`.
    pub(super) fn basis_into(&self, t: f64, out: MatMut<'_, f64>) {
        let passed = |piece: &LiftPiece| (piece.to - piece.from) * (t - piece.to) > 0.0;
        let which = self.pieces.partition_point(passed);
        let piece = &self.pieces[which.min(self.pieces.len() - 1)];
        let mut factors = [0.0; VALUES];
        let s = (t - piece.from) / (piece.to - piece.from);
        self.through.factors_into(s, &mut factors);
        let [r, k] = self.shape;
        let mut out = out;
        out.fill(0.0);
        for (i, factor) in factors.into_iter().enumerate() {
            axpy(out.rb_mut(), factor, matrix(&piece.values, i, r, k));
        }
    }

    /// Number of pieces.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.pieces.len()
    }
}

/// The error if round-off prevents a continuation.
fn unresolved(pieces: usize, length: f64) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport::new(StopReason::Stagnated, pieces, length.abs(), SHORTEST),
    }
}

fn too_long(pieces: usize, left: f64) -> Error {
    Error::TooManySteps {
        solver: SOLVER,
        limit: MAX_PIECES,
        forecast: left.ceil(),
        report: SolverReport::new(StopReason::MaxIterations, pieces, left, 0.0),
    }
}

/// The equation on one piece, with buffers for one shape.
struct LiftEquations {
    shape: [usize; 2],
    nodes: Arc<Nodes>,
    jet: MatrixJet,
    /// `F` at the start, the nodes and the end, side by side; then `Y`.
    bases: Vec<f64>,
    /// `F^T F'` at the nodes, times the length of the piece.
    rates: Vec<f64>,
    /// `R` at the nodes and at the end, and its derivative at the nodes.
    turns: Vec<f64>,
    slopes: Vec<f64>,
    next: Vec<f64>,
}

impl LiftEquations {
    fn new([r, k]: [usize; 2]) -> Self {
        LiftEquations {
            shape: [r, k],
            nodes: Nodes::of(NODES),
            jet: MatrixJet::zeros(r, k),
            bases: vec![0.0; r * k * VALUES],
            rates: vec![0.0; k * k * NODES],
            turns: vec![0.0; k * k * (NODES + 1)],
            slopes: vec![0.0; k * k * NODES],
            next: vec![0.0; k * k * (NODES + 1)],
        }
    }

    /// Computes the values and `R` on the piece between two parameters; returns the least cosine of a principal angle
    /// if the piece is too long.
    fn solve(
        &mut self,
        ends: [f64; 2],
        start: MatRef<'_, f64>,
        bases: &mut impl FnMut(f64, &mut MatrixJet) -> Result<f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<f64>> {
        let least = self.read(ends, bases, interrupt)?;
        let resolved = self.turn(start) && {
            self.apply_turns(start);
            // Outside [0, 1] the weights of the two ends, and with them round-off, grow with the parameter.
            let growth = ends.iter().fold(1.0, |m: f64, t| m.max(t.abs()));
            let within = |value: f64, bound: f64| value <= (growth * bound / least).min(COARSEST);
            within(self.unresolved(), RESOLVED) && within(self.missed(), MET)
        };
        Ok((!resolved).then_some(least))
    }

    /// Reads `F` at the nodes and the ends, and `F^T F'` at the nodes.
    fn read(
        &mut self,
        [from, to]: [f64; 2],
        bases: &mut impl FnMut(f64, &mut MatrixJet) -> Result<f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<f64> {
        let ([r, k], mut least) = (self.shape, 1.0_f64);
        let nodes = Arc::clone(&self.nodes);
        let inner = nodes.s.iter().map(|s| from + (to - from) * s);
        for (i, t) in std::iter::once(from).chain(inner).chain([to]).enumerate() {
            interrupt.check(SOLVER)?;
            least = least.min(bases(t, &mut self.jet)?);
            let [f, slope, ..] = &self.jet.c;
            matrix_mut(&mut self.bases, i, r, k).copy_from(f);
            let Some(node) = i.checked_sub(1).filter(|node| *node < NODES) else {
                continue;
            };
            let mut rate = matrix_mut(&mut self.rates, node, k, k);
            mul_into(rate.rb_mut(), to - from, f.transpose(), slope);
            for b in 0..k {
                rate[(b, b)] = 0.0;
                for a in 0..b {
                    let entry = 0.5 * (rate[(a, b)] - rate[(b, a)]);
                    (rate[(a, b)], rate[(b, a)]) = (entry, -entry);
                }
            }
        }
        Ok(least)
    }

    /// Computes `R` at the nodes and at the end; `false` if the iteration does not converge.
    fn turn(&mut self, start: MatRef<'_, f64>) -> bool {
        let k = self.shape[1];
        for i in 0..=NODES {
            matrix_mut(&mut self.turns, i, k, k).copy_from(start);
        }
        if self.rates.iter().all(|rate| *rate == 0.0) {
            self.slopes.fill(0.0);
            return true;
        }
        for _ in 0..MAX_ITERATIONS {
            for i in 0..NODES {
                let slope = matrix_mut(&mut self.slopes, i, k, k);
                let [rate, turn] = [&self.rates, &self.turns].map(|all| matrix(all, i, k, k));
                mul_into(slope, -1.0, rate, turn);
            }
            let integrals = MatRef::from_row_major_slice(&self.nodes.at[1], NODES + 1, NODES);
            let next = MatMut::from_column_major_slice_mut(&mut self.next, k * k, NODES + 1);
            let slopes = MatRef::from_column_major_slice(&self.slopes, k * k, NODES);
            mul_into(next, 1.0, slopes, integrals.transpose());
            for i in 0..=NODES {
                let mut next = matrix_mut(&mut self.next, i, k, k);
                next += start;
            }
            let changes = self.next.iter().zip(&self.turns);
            let change = changes.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            std::mem::swap(&mut self.next, &mut self.turns);
            if change <= f64::EPSILON {
                return true;
            }
        }
        false
    }

    /// `Y = F R`.
    fn apply_turns(&mut self, start: MatRef<'_, f64>) {
        let [r, k] = self.shape;
        for i in 0..VALUES {
            let turn = match i.checked_sub(1) {
                None => start,
                Some(node) => matrix(&self.turns, node, k, k),
            };
            let value = matrix(&self.bases, i, r, k) * turn;
            matrix_mut(&mut self.bases, i, r, k).copy_from(value);
        }
    }

    /// `Y` at the nodes, one column each.
    fn values(&self) -> MatRef<'_, f64> {
        let size = self.shape[0] * self.shape[1];
        MatRef::from_column_major_slice(&self.bases, size, VALUES).subcols(1, NODES)
    }

    /// The largest of the last two Legendre coefficients of `Y` and of `R'`.
    fn unresolved(&self) -> f64 {
        let k = self.shape[1];
        let tail = MatRef::from_row_major_slice(&self.nodes.tail, 2, NODES);
        let slopes = MatRef::from_column_major_slice(&self.slopes, k * k, NODES);
        let [of_basis, of_turn] =
            [self.values(), slopes].map(|values| (values * tail.transpose()).norm_max());
        of_basis.max(of_turn)
    }

    /// Deviation of the polynomial through the nodes from `Y` at the ends.
    fn missed(&self) -> f64 {
        // The nodes are symmetric, so the factors for the end, in reverse order, are those for the start.
        let at_end = ColRef::from_slice(&self.nodes.at[0][NODES * NODES..]);
        let [start, end] = [0, VALUES - 1].map(|i| self.values_of(i));
        let [to_start, to_end] = [at_end.reverse_rows(), at_end].map(|row| self.values() * row);
        let misses = [(start, to_start), (end, to_end)];
        misses.iter().fold(0.0, |m: f64, (exact, found)| {
            m.max((found - exact).norm_max())
        })
    }

    fn values_of(&self, i: usize) -> ColRef<'_, f64> {
        let size = self.shape[0] * self.shape[1];
        ColRef::from_slice(&self.bases[i * size..][..size])
    }

    /// `R` at the end of the piece.
    fn end_turn(&self, out: &mut Mat<f64>) {
        let k = self.shape[1];
        out.copy_from(matrix(&self.turns, NODES, k, k));
    }
}

/// The matrix at a node, from an array of consecutive matrices.
fn matrix(all: &[f64], node: usize, rows: usize, cols: usize) -> MatRef<'_, f64> {
    let size = rows * cols;
    MatRef::from_column_major_slice(&all[node * size..][..size], rows, cols)
}

fn matrix_mut(all: &mut [f64], node: usize, rows: usize, cols: usize) -> MatMut<'_, f64> {
    let size = rows * cols;
    MatMut::from_column_major_slice_mut(&mut all[node * size..][..size], rows, cols)
}
