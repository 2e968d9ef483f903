//! Checks that stored numbers form a curve: points on the manifold, consistent velocities, steps and ends that join.
//!
//! A curve consists, for each step, of a power series of the point and one of `x`, and of a state at both ends. With
//! `S' = S Omega + K` the series are consistent if
//!
//! ```math
//! S^T S = I,\qquad S^T S' = \Omega,\qquad K^T K = B^T B
//! ```
//!
//! at the ends and in the middle of every step, and if neighbouring steps agree at their common time.

use faer::{Mat, MatRef, Scale};

use super::taylor::piecewise_taylor::PiecewiseTaylor;
use super::taylor::state::State;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::{distance, norm, orthonormality_defect};
use crate::manifold::stored::MEMBERSHIP;
use crate::space::Quotient;
use crate::stored::{READER, refusal};

/// Allowed defect of points and, in the natural unit of time, of derivatives, in tolerances per step. The largest
/// defect of points found was 0.15, in 756 random cubics on nine shapes with tolerances from 1e-17 to 0.1, and of
/// derivatives 0.31, when series had four terms less.
const ROOM: f64 = 10.0;

/// Relative difference allowed between the common times of two steps, as a fraction of the largest time.
const SLACK: f64 = 8.0 * f64::EPSILON;

/// # Errors
/// `Stored` with the measured defect; `Interrupted`.
pub(super) fn check_taylor(taylor: &PiecewiseTaylor, interrupt: Interrupt<'_>) -> Result<()> {
    let checker = Checker {
        taylor,
        allowed: MEMBERSHIP.max(ROOM * taylor.accuracy.truncation * taylor.len() as f64),
    };
    let mut before: Option<Mat<f64>> = None;
    for (i, piece) in taylor.pieces.iter().enumerate() {
        interrupt.check(READER)?;
        let middle = 0.5 * (piece.lower + piece.upper);
        let first = checker.point(i, piece.lower)?;
        checker.point(i, middle)?;
        if let Some(before) = before {
            let gap = distance(before.as_ref(), first.as_ref());
            checker.expect(i, "does not join the step before it", gap, checker.allowed)?;
        }
        before = Some(checker.point(i, piece.upper)?);
    }
    let last = taylor.len() - 1;
    checker.times()?;
    checker.state(0, &taylor.first)?;
    checker.state(last, &taylor.last)
}

struct Checker<'a> {
    taylor: &'a PiecewiseTaylor,
    allowed: f64,
}

/// `omega`, shape `(k, k)`, and `b`, shape `(m, k)`.
struct StoredVector {
    omega: Mat<f64>,
    b: Mat<f64>,
}

impl Checker<'_> {
    fn expect(&self, step: usize, what: &str, found: f64, allowed: f64) -> Result<()> {
        // False for NaN too.
        if found <= allowed {
            return Ok(());
        }
        Err(refusal(format!(
            "step {step}: {what} by {found:.3e}, more than {allowed:.3e}"
        )))
    }

    /// The point of a step at a time, after checking the series.
    fn point(&self, step: usize, t: f64) -> Result<Mat<f64>> {
        let (r, rows, k) = (self.taylor.r(), self.taylor.rows(), self.taylor.blocks.k);
        let (mut s, mut rate) = (vec![0.0; rows * k], vec![0.0; rows * k]);
        self.taylor
            .points_of_piece(step, t, &mut [&mut s, &mut rate]);
        let [s, rate] = [&s, &rate].map(|entries| {
            let all = MatRef::from_column_major_slice(entries, rows, k);
            all.subrows(0, r).to_owned()
        });
        let [x, ..] = self.vectors(step, t);
        let defect = orthonormality_defect(s.as_ref());
        self.expect(step, "points are off the manifold", defect, self.allowed)?;
        if self.taylor.quotient() == Quotient::Subspaces {
            let turned = norm(x.omega.as_ref());
            self.expect(step, "bases turn", turned, 0.0)?;
        }
        let omega = s.transpose() * &rate;
        let normal = &rate - &s * &omega;
        let speed = norm(rate.as_ref());
        let allowed = self.allowed * (1.0 + speed);
        let gap = distance(omega.as_ref(), x.omega.as_ref());
        self.expect(step, "points do not move with their velocity", gap, allowed)?;
        let square = |a: &Mat<f64>| a.transpose() * a;
        let gap = distance(square(&normal).as_ref(), square(&x.b).as_ref());
        let allowed = allowed * (1.0 + speed);
        self.expect(step, "points do not move with their velocity", gap, allowed)?;
        Ok(s)
    }

    /// `x, x', x''` of a step at a time.
    fn vectors(&self, step: usize, t: f64) -> [StoredVector; 3] {
        let (r, k) = (self.taylor.r(), self.taylor.blocks.k);
        let mut entries: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; r * k]);
        let mut targets = entries.each_mut().map(Vec::as_mut_slice);
        self.taylor.vectors_of_piece(step, t, &mut targets);
        let factors = [1.0, 1.0, 2.0];
        std::array::from_fn(|i| self.vector(&entries[i], factors[i]))
    }

    fn vector(&self, entries: &[f64], factor: f64) -> StoredVector {
        let (m, k) = (self.taylor.blocks.m, self.taylor.blocks.k);
        let (omega, b) = entries.split_at(k * k);
        StoredVector {
            omega: MatRef::from_column_major_slice(omega, k, k) * Scale(factor),
            b: MatRef::from_column_major_slice(b, m, k) * Scale(factor),
        }
    }

    /// Check that steps are contiguous and that the states are at their ends.
    fn times(&self) -> Result<()> {
        let pieces = &self.taylor.pieces;
        let (first, last) = (&self.taylor.first, &self.taylor.last);
        let size = first.time.abs().max(last.time.abs());
        let close = |a: f64, b: f64| (a - b).abs() <= SLACK * size;
        let joined = pieces
            .windows(2)
            .all(|pair| close(pair[0].upper, pair[1].lower));
        let ends =
            close(pieces[0].lower, first.time) && close(pieces[pieces.len() - 1].upper, last.time);
        if joined && ends {
            return Ok(());
        }
        Err(refusal(
            "intervals: steps do not join each other and the ends".to_owned(),
        ))
    }

    /// Check that a state agrees with a step.
    fn state(&self, step: usize, state: &State) -> Result<()> {
        let (r, k) = (self.taylor.r(), self.taylor.blocks.k);
        let frame = MatRef::from_column_major_slice(&state.entries[..r * r], r, r);
        let defect = orthonormality_defect(frame);
        self.expect(step, "the frame is not orthonormal", defect, self.allowed)?;
        let point = self.point(step, state.time)?;
        let gap = distance(frame.subcols(0, k), point.as_ref());
        self.expect(step, "the end is off the curve", gap, self.allowed)?;
        let vectors = self.vectors(step, state.time);
        let size =
            |vector: &StoredVector| norm(vector.omega.as_ref()).hypot(norm(vector.b.as_ref()));
        let unit = [0, 1, 2]
            .map(|i| size(&vectors[i]).powf(1.0 / (i as f64 + 1.0)))
            .into_iter()
            .fold(1.0, f64::max);
        for (i, vector) in vectors.iter().enumerate() {
            let stored = self.vector(&[state.omega(i), state.b(i)].concat(), 1.0);
            let gap = distance(stored.omega.as_ref(), vector.omega.as_ref())
                .hypot(distance(stored.b.as_ref(), vector.b.as_ref()));
            let allowed = self.allowed * unit.powi(i as i32 + 1);
            self.expect(step, "the end moves differently", gap, allowed)?;
        }
        Ok(())
    }
}
