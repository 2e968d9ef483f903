//! The equations of a spline of Riemannian cubics through given points: all legs at once, by Newton's method.
//!
//! Unknown are the velocities `v_j` at the knots and, for every leg, `(x', x'')` at its start. A leg of length `h` from
//! `(h v_j, x', x'')` must meet the next knot with the velocity `h v_{j+1}`; at a knot the covariant accelerations of both
//! legs must agree. A Newton step solves every leg for its `(x', x'')` in terms of the two velocities. What is left is block
//! tridiagonal in the velocities, cyclic for a closed curve, so a step takes time linear in the number of knots.

use faer::{Mat, MatRef, Scale};

use super::ends::Ends;
use crate::cubic::initial::Horizontal;
use crate::cubic::leg::{Arrival, Leg, leg};
use crate::cubic::problem::{entries, unpack};
use crate::cubic::reduced::Sized;
use crate::cubic::taylor::Accuracy;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::cyclic::BlockRows;
use crate::linalg::decomp::solve_matrix;
use crate::report::{SolverReport, StopReason};

pub(super) const SOLVER: &str = "spline of Riemannian cubics";

/// A step is accepted if it lowers the residual by this share of what the linear model predicts.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Halvings of a step before it is given up.
const MAX_HALVINGS: i32 = 8;

/// Residuals are integrated to this share of what the next step can leave.
const ACCURACY_SHARE: f64 = 1e-4;

/// Derivatives are integrated to this share of the residual.
const DERIVATIVE_SHARE: f64 = 1e-2;

/// Velocities at the knots, per unit of time, and `(x', x'')` at the start of each leg, in the time of the leg.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) velocities: Vec<Vec<f64>>,
    pub(super) bends: Vec<Vec<f64>>,
}

/// The equations of a spline.
pub(super) struct Joints<'a> {
    leg: Box<dyn Leg + 'a>,
    blocks: Sized,
    /// Of a tangent space.
    size: usize,
    /// The next knot's frame in that of the knot where a leg starts.
    next: Vec<Vec<f64>>,
    lengths: Vec<f64>,
    ends: Ends,
    interrupt: Interrupt<'a>,
}

/// What is left of the equations.
struct Residual {
    /// Of every leg: distance from the next knot, velocity there that is too much, covariant acceleration there.
    arrivals: Vec<Arrival>,
    /// Jumps of the covariant acceleration at the knots, in the time of the shorter leg.
    jumps: Vec<Vec<f64>>,
    /// The largest distance, in norm.
    size: f64,
    /// Root of the sum of squares.
    total: f64,
}

/// The change of a leg's `(x', x'')`: `rest + before dv_j + after dv_{j+1}`; of its last acceleration likewise.
struct Elimination {
    rest: Mat<f64>,
    before: Mat<f64>,
    after: Mat<f64>,
    arrival: [Mat<f64>; 3],
}

impl<'a> Joints<'a> {
    /// For knots with the given frames, shape `(r, r)` with the point as first `k` columns, and legs of the given lengths.
    pub(super) fn new(
        blocks: Sized,
        frames: &[Mat<f64>],
        lengths: &[f64],
        ends: Ends,
        interrupt: Interrupt<'a>,
    ) -> Self {
        let Sized { m, k } = blocks;
        let next = frames
            .windows(2)
            .map(|pair| entries(&(pair[0].transpose() * &pair[1])))
            .collect();
        Joints {
            leg: leg(blocks, interrupt),
            blocks,
            size: k * (k - 1) / 2 + m * k,
            next,
            lengths: lengths.to_vec(),
            ends,
            interrupt,
        }
    }

    /// Damped Newton from a motion, in place.
    ///
    /// # Errors
    /// `Interrupted`, and where the start cannot be integrated.
    pub(super) fn solve(
        &mut self,
        motion: &mut Motion,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<SolverReport> {
        let mut accuracy = Accuracy::of_tolerance(ACCURACY_SHARE);
        let mut found = self.residual(motion, accuracy)?;
        let mut iterations = 0;
        let reason = loop {
            if found.size <= tolerance {
                if accuracy.truncation <= Accuracy::FULL.truncation {
                    break StopReason::Converged;
                }
                accuracy = Accuracy::FULL;
                found = self.residual(motion, accuracy)?;
                continue;
            }
            if iterations == max_iterations {
                break StopReason::MaxIterations;
            }
            iterations += 1;
            let Some(step) = self.newton_step(motion, &found)? else {
                break StopReason::SingularJacobian;
            };
            let next = found.size.powi(4).min(1.0);
            accuracy = accuracy.finer(Accuracy::of_tolerance(ACCURACY_SHARE * next));
            let Some((moved, nearer)) = self.descend(motion, &step, accuracy, found.total)? else {
                break StopReason::Stagnated;
            };
            (*motion, found) = (moved, nearer);
        };
        Ok(SolverReport {
            converged: reason == StopReason::Converged,
            iterations,
            residual: found.size,
            tolerance,
            reason,
        })
    }

    fn descend(
        &mut self,
        motion: &Motion,
        step: &Motion,
        accuracy: Accuracy,
        total: f64,
    ) -> Result<Option<(Motion, Residual)>> {
        for halving in 0..MAX_HALVINGS {
            let share = 0.5_f64.powi(halving);
            let trial = motion.plus(share, step);
            match self.residual(&trial, accuracy) {
                Ok(found) if found.total <= (1.0 - SUFFICIENT_DECREASE * share) * total => {
                    return Ok(Some((trial, found)));
                }
                Err(error @ Error::Interrupted { .. }) => return Err(error),
                Ok(_) | Err(_) => {}
            }
        }
        Ok(None)
    }

    /// `(x, x', x'')` of a leg in its own time.
    fn start(&self, motion: &Motion, leg: usize) -> Vec<f64> {
        let h = self.lengths[leg];
        let velocity = motion.velocities[leg].iter().map(|v| h * v);
        velocity.chain(motion.bends[leg].iter().copied()).collect()
    }

    /// `x, x', x''` of a leg as vectors of `m`, in its own time.
    pub(super) fn vectors(&self, motion: &Motion, leg: usize) -> [Horizontal; 3] {
        let twice: Vec<f64> = [&motion.velocities[leg], &motion.velocities[leg]]
            .into_iter()
            .flatten()
            .map(|v| self.lengths[leg] * v)
            .collect();
        let [x, _] = unpack(&twice, self.blocks);
        let [first, second] = unpack(&motion.bends[leg], self.blocks);
        [x, first, second]
    }

    fn residual(&mut self, motion: &Motion, accuracy: Accuracy) -> Result<Residual> {
        let (d, legs) = (self.size, self.lengths.len());
        let mut arrivals = Vec::with_capacity(legs);
        let (mut size, mut total) = (0.0_f64, 0.0_f64);
        for i in 0..legs {
            self.interrupt.check(SOLVER)?;
            let start = self.start(motion, i);
            let mut arrival = self.leg.arrival(&start, &self.next[i], accuracy)?;
            for (w, v) in arrival.values[d..2 * d]
                .iter_mut()
                .zip(&motion.velocities[i + 1])
            {
                *w -= self.lengths[i] * v;
            }
            let lag = square(&arrival.values[d..2 * d]);
            let off = arrival.distance * arrival.distance + lag;
            size = size.max(off.sqrt());
            total += off;
            arrivals.push(arrival);
        }
        let jumps: Vec<Vec<f64>> = (0..self.unknown_knots())
            .map(|knot| self.jump(knot, motion, &arrivals))
            .collect();
        for jump in &jumps {
            size = size.max(square(jump).sqrt());
            total += square(jump);
        }
        Ok(Residual {
            arrivals,
            jumps,
            size,
            total: total.sqrt(),
        })
    }

    /// Knots with a velocity of their own: the last one of a closed curve is the first.
    fn unknown_knots(&self) -> usize {
        self.lengths.len() + usize::from(!matches!(self.ends, Ends::Periodic))
    }

    /// The leg before a knot and the leg after it.
    fn legs_at(&self, knot: usize) -> [Option<usize>; 2] {
        let legs = self.lengths.len();
        let before = match (knot, &self.ends) {
            (0, Ends::Periodic) => Some(legs - 1),
            (0, _) => None,
            _ => Some(knot - 1),
        };
        [before, (knot < legs).then_some(knot)]
    }

    /// Squares of the length of the shorter leg at a knot, over those of the legs before and after it.
    fn shares(&self, knot: usize) -> [f64; 2] {
        let lengths = self.legs_at(knot).map(|leg| leg.map(|i| self.lengths[i]));
        let shortest = lengths
            .iter()
            .flatten()
            .fold(f64::INFINITY, |a, b| a.min(*b));
        lengths.map(|h| h.map_or(0.0, |h| (shortest / h).powi(2)))
    }

    /// The acceleration before a knot less the one after it; at an end, less the wanted one.
    fn jump(&self, knot: usize, motion: &Motion, arrivals: &[Arrival]) -> Vec<f64> {
        let (d, [before, after]) = (self.size, self.legs_at(knot));
        let shares = self.shares(knot);
        let mut jump = vec![0.0; d];
        if let Ends::Open(ends) = &self.ends {
            let end = match [before, after] {
                [None, _] => Some((&ends[0], 1.0)),
                [_, None] => Some((&ends[1], -1.0)),
                _ => None,
            };
            if let Some((end, sign)) = end {
                let Some(wanted) = end.acceleration() else {
                    // The velocity is given, and never changes.
                    return jump;
                };
                let h = self.lengths[before.or(after).expect("a knot has a leg")];
                for (jump, wanted) in jump.iter_mut().zip(wanted) {
                    *jump = sign * h * h * wanted;
                }
            }
        }
        if let Some(leg) = before {
            for (jump, a) in jump.iter_mut().zip(&arrivals[leg].values[2 * d..]) {
                *jump += shares[0] * a;
            }
        }
        if let Some(leg) = after {
            for (jump, a) in jump.iter_mut().zip(&motion.bends[leg][..d]) {
                *jump -= shares[1] * a;
            }
        }
        jump
    }

    /// The Newton step; none where it is not unique.
    fn newton_step(&mut self, motion: &Motion, found: &Residual) -> Result<Option<Motion>> {
        let (d, count) = (self.size, self.unknown_knots());
        let Some(eliminations) = self.eliminations(motion, found)? else {
            return Ok(None);
        };
        let mut rows = BlockRows::zeros(count, d);
        let mut right = vec![Mat::zeros(d, 1); count];
        for knot in 0..count {
            let [before, after] = self.legs_at(knot);
            if self.is_fixed(knot) {
                rows.diagonal[knot] = Mat::identity(d, d);
                continue;
            }
            for (i, jump) in found.jumps[knot].iter().enumerate() {
                right[knot][(i, 0)] = -jump;
            }
            let shares = self.shares(knot).map(Scale);
            if let Some(leg) = before {
                let [rest, first, last] = &eliminations[leg].arrival;
                right[knot] -= rest * shares[0];
                rows.below[knot] += first * shares[0];
                rows.diagonal[knot] += last * shares[0];
            }
            if let Some(leg) = after {
                let e = &eliminations[leg];
                let top = |a: &Mat<f64>| a.as_ref().subrows(0, d) * shares[1];
                right[knot] += top(&e.rest);
                rows.diagonal[knot] -= top(&e.before);
                rows.above[knot] -= top(&e.after);
            }
        }
        let solved = match self.ends {
            Ends::Periodic => rows.solve_cyclic(&right),
            Ends::Open(_) => rows.solve(&right),
        };
        Ok(solved.map(|velocities| self.step_of(&eliminations, velocities)))
    }

    fn is_fixed(&self, knot: usize) -> bool {
        let Ends::Open(ends) = &self.ends else {
            return false;
        };
        let end = match self.legs_at(knot) {
            [None, _] => &ends[0],
            [_, None] => &ends[1],
            _ => return false,
        };
        end.acceleration().is_none()
    }

    /// The change of all unknowns from that of the velocities.
    fn step_of(&self, eliminations: &[Elimination], velocities: Vec<Mat<f64>>) -> Motion {
        let last = velocities.len();
        let bends = eliminations
            .iter()
            .enumerate()
            .map(|(leg, e)| {
                let (from, to) = (&velocities[leg], &velocities[(leg + 1) % last]);
                entries(&(&e.rest + &e.before * from + &e.after * to))
            })
            .collect();
        let mut velocities: Vec<Vec<f64>> = velocities.iter().map(entries).collect();
        if last == self.lengths.len() {
            velocities.push(velocities[0].clone());
        }
        Motion { velocities, bends }
    }

    /// Every leg solved for its `(x', x'')`; none where one of them cannot be.
    fn eliminations(
        &mut self,
        motion: &Motion,
        found: &Residual,
    ) -> Result<Option<Vec<Elimination>>> {
        let d = self.size;
        let accuracy = Accuracy::of_tolerance(DERIVATIVE_SHARE * found.size.min(1.0));
        let mut all = Vec::with_capacity(self.lengths.len());
        for (i, arrival) in found.arrivals.iter().enumerate() {
            self.interrupt.check(SOLVER)?;
            let h = self.lengths[i];
            let start = self.start(motion, i);
            let derivative = self.leg.derivative(&start, &self.next[i], accuracy)?;
            let (ends, acceleration) = derivative.as_ref().split_at_row(2 * d);
            let right = Mat::from_fn(2 * d, 1 + 2 * d, |row, col| match col {
                0 => -arrival.values[row],
                _ if col <= d => -h * ends[(row, col - 1)],
                _ => h * f64::from(u8::from(row == col - 1)),
            });
            let Some(solved) = solve_matrix(ends.subcols(d, 2 * d), right.as_ref()) else {
                return Ok(None);
            };
            let (by_velocity, by_bend) = acceleration.split_at_col(d);
            let moved = by_bend * &solved;
            let part =
                |a: MatRef<'_, f64>, first: usize, count: usize| a.subcols(first, count).to_owned();
            all.push(Elimination {
                arrival: [
                    part(moved.as_ref(), 0, 1),
                    part(moved.as_ref(), 1, d) + by_velocity * Scale(h),
                    part(moved.as_ref(), 1 + d, d),
                ],
                rest: part(solved.as_ref(), 0, 1),
                before: part(solved.as_ref(), 1, d),
                after: part(solved.as_ref(), 1 + d, d),
            });
        }
        Ok(Some(all))
    }
}

impl Motion {
    fn plus(&self, share: f64, step: &Motion) -> Motion {
        let sum = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<Vec<f64>> {
            a.iter()
                .zip(b)
                .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + share * b).collect())
                .collect()
        };
        Motion {
            velocities: sum(&self.velocities, &step.velocities),
            bends: sum(&self.bends, &step.bends),
        }
    }
}

fn square(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum()
}
