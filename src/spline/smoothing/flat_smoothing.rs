//! The smoothing spline in flat space: its linear system, and the step that would solve the equations there.
//!
//! The unknowns at a knot are the change `p` of its position and `y = s a` with the new acceleration `a` and `s =
//! max(1, lambda)`. With the matrix `D` of jumps of divided differences and the mass matrix `M` of linear elements,
//!
//! ```math
//! \frac s\lambda W p + D y = \frac s\lambda W e,\qquad D p - \frac1s M y = 0
//! ```
//!
//! for data `e`. The matrix is symmetric and quasi-definite, with entries of moderate size for every `lambda`, from
//! interpolation (`s = 1`, `W / lambda` large) to the regression line (`1 / s = 0`), where `y` are the multipliers of
//! `D p = 0`.
//!
//! # Source
//! Reinsch (1967), "Smoothing by spline functions", Numer. Math. 10, 177-183. Elimination without pivoting: Vanderbei (1995),
//! "Symmetric quasidefinite matrices", SIAM J. Optim. 5, 100-113.

use crate::spline::chains::chain::{Carrying, Chain, LegEnds};
use crate::spline::chains::motion::Motion;

use crate::error::{Error, Result};
use crate::linalg::field::add;
use crate::solve::direction::Direction;
use crate::solve::tridiagonal::{ChainShape, Row, Tridiagonal, diagonal_of_inverse};

/// Range of the weight of the cost, in units of the mean leg and of the largest weight, outside which it makes no
/// difference: above `1e100` no acceleration bends the curve by as much as round-off, below `1e-100` the curve passes
/// through every datum.
const LAMBDAS: [f64; 2] = [1e-100, 1e100];

/// The matrix for given times, weights and `lambda`.
#[derive(Clone)]
pub(crate) struct FlatSmoothing {
    rows: Vec<Row<2>>,
    system: Tridiagonal<2>,
    weights: Vec<f64>,
    /// `s / lambda` and `1 / s`.
    pull: f64,
    pliancy: f64,
}

impl FlatSmoothing {
    /// Built for the sums of the weights at the knots.
    ///
    /// # Errors
    /// `InvalidArgument` (times so unequal that the arithmetic overflows or underflows).
    pub(crate) fn new(lengths: &[f64], weights: Vec<f64>, lambda: f64) -> Result<Self> {
        let lambda = lambda.clamp(LAMBDAS[0], LAMBDAS[1]);
        let s = lambda.max(1.0);
        let (pull, pliancy) = (s / lambda, 1.0 / s);
        let rows = rows(lengths, &weights, pull, pliancy);
        let system =
            Tridiagonal::new(&rows, ChainShape::Open).ok_or_else(|| too_unequal(lengths))?;
        Ok(FlatSmoothing {
            rows,
            system,
            weights,
            pull,
            pliancy,
        })
    }

    /// `s / lambda`.
    pub(crate) fn pull(&self) -> f64 {
        self.pull
    }

    /// `s`, the factor that makes accelerations comparable to the forces of the data.
    pub(crate) fn stretch(&self) -> f64 {
        1.0 / self.pliancy
    }

    /// `lambda`, limited to the range in which it makes a difference.
    pub(crate) fn lambda(&self) -> f64 {
        self.stretch() / self.pull
    }

    /// Trace of the influence matrix.
    ///
    /// # Errors
    /// `InvalidArgument` (times so unequal that the arithmetic overflows or underflows).
    pub(crate) fn degrees_of_freedom(&self, lengths: &[f64]) -> Result<f64> {
        let diagonal = diagonal_of_inverse(&self.rows).ok_or_else(|| too_unequal(lengths))?;
        let each = diagonal.iter().zip(&self.weights);
        let trace: f64 = each.map(|(block, w)| block[0][0] * self.pull * w).sum();
        // Limits round-off.
        Ok(trace.clamp(2.0, self.weights.len() as f64))
    }

    /// Solves for `(p, y)` in place, from the right-hand sides of their rows.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn solve<C: Chain>(
        &self,
        chain: &C,
        worker: &mut C::Worker,
        right: &mut [f64],
    ) -> Result<()> {
        self.system.solve(&mut Carrying { chain, worker }, right)
    }

    /// Changes of the positions and of the motion that would solve the equations in flat space, from the ends of the
    /// legs and the sums of weights times tangent vectors to the data.
    ///
    /// # Errors
    /// The errors of carrying.
    pub(crate) fn step<C: Chain>(
        &self,
        chain: &C,
        motion: &Motion,
        leg_ends: &LegEnds,
        pulls: &[f64],
    ) -> Result<(Vec<f64>, Motion)> {
        let (d, lengths) = (chain.size(), chain.lengths());
        let mut worker = chain.worker();
        let legs = (0..lengths.len())
            .map(|leg| Carried::of(chain, &mut worker, motion, leg_ends, leg))
            .collect::<Result<Vec<_>>>()?;
        let mut fields = self.right(chain, motion, leg_ends, pulls, &legs);
        self.solve(chain, &mut worker, &mut fields)?;
        let mut change = Motion::zeros(d, lengths.len() + 1);
        let mut ends = [vec![0.0; 2 * d], vec![0.0; 2 * d]];
        for (leg, &h) in lengths.iter().enumerate() {
            let (from, to) = fields[2 * d * leg..].split_at(2 * d);
            let [ahead, back] = &mut ends;
            carry_fields(chain, &mut worker, leg, Direction::Forward, from, ahead)?;
            carry_fields(
                chain,
                &mut worker,
                leg,
                Direction::Backward,
                &to[..2 * d],
                back,
            )?;
            let (b, e) = (&motion.derivatives(leg)[..d], &legs[leg].acceleration_back);
            let (r, w) = (leg_ends.vector(leg, 0), leg_ends.vector(leg, 1));
            let per_y = h * h * self.pliancy;
            // Of two legs at a knot, the longer one determines its velocity: the shorter one divides round-off by a
            // smaller time.
            if leg == 0 || h > lengths[leg - 1] {
                let (r, velocity) = (leg_ends.point_defect_back(leg), change.velocity_mut(leg));
                for i in 0..d {
                    let bent = per_y * (2.0 * from[d + i] + back[d + i]) / 6.0;
                    velocity[i] = (back[i] - from[i] - r[i] - bent + b[i] / 3.0 + e[i] / 6.0) / h;
                }
            }
            let (e_here, b_there) = (leg_ends.vector(leg, 2), &legs[leg].first_ahead);
            let velocity = change.velocity_mut(leg + 1);
            for i in 0..d {
                let bent = per_y * (ahead[d + i] + 2.0 * to[d + i]) / 6.0;
                let known = w[i] - r[i] - b_there[i] / 6.0 - e_here[i] / 3.0;
                velocity[i] = (to[i] - ahead[i] + known + bent) / h;
            }
            let (first, third) = change.derivatives_mut(leg).split_at_mut(d);
            for i in 0..d {
                first[i] = per_y * from[d + i] - b[i];
                third[i] = per_y * (back[d + i] - from[d + i]) - (e[i] - b[i]);
            }
        }
        let positions = fields.chunks_exact(2 * d).flat_map(|at| at[..d].to_vec());
        Ok((positions.collect(), change))
    }

    fn right<C: Chain>(
        &self,
        chain: &C,
        motion: &Motion,
        leg_ends: &LegEnds,
        pulls: &[f64],
        legs: &[Carried],
    ) -> Vec<f64> {
        let (d, lengths) = (chain.size(), chain.lengths());
        let mut right = vec![0.0; 2 * d * (lengths.len() + 1)];
        for (right, pulls) in right.chunks_exact_mut(2 * d).zip(pulls.chunks_exact(d)) {
            add(right, self.pull, pulls);
        }
        let last = lengths.len() - 1;
        for (leg, &h) in lengths.iter().enumerate() {
            let (r1, force) = (1.0 / h, h.powi(-3) / self.pliancy);
            let (b, c) = motion.derivatives(leg).split_at(d);
            let [r, w, e, f] = [0, 1, 2, 3].map(|which| leg_ends.vector(leg, which));
            let (r_back, e_back) = (
                leg_ends.point_defect_back(leg),
                &legs[leg].acceleration_back,
            );
            let b_ahead = &legs[leg].first_ahead;
            let (before, after) = right[2 * d * leg..].split_at_mut(2 * d);
            for i in 0..d {
                before[i] -= force * (c[i] - (e_back[i] - b[i]));
                after[i] += force * (f[i] - (e[i] - b_ahead[i]));
            }
            // At the ends the acceleration is zero.
            if leg > 0 {
                for i in 0..d {
                    before[d + i] += r1 * (r_back[i] - b[i] / 3.0 - e_back[i] / 6.0);
                }
            }
            if leg < last {
                for i in 0..d {
                    after[d + i] += r1 * (w[i] - r[i] - b_ahead[i] / 6.0 - e[i] / 3.0);
                }
            }
        }
        right
    }
}

/// Accelerations at both ends of a leg, each carried to the other end.
struct Carried {
    first_ahead: Vec<f64>,
    acceleration_back: Vec<f64>,
}

impl Carried {
    fn of<C: Chain>(
        chain: &C,
        worker: &mut C::Worker,
        motion: &Motion,
        leg_ends: &LegEnds,
        leg: usize,
    ) -> Result<Self> {
        let d = chain.size();
        let (mut first_ahead, mut acceleration_back) = (vec![0.0; d], vec![0.0; d]);
        let (first, arrived) = (&motion.derivatives(leg)[..d], leg_ends.vector(leg, 2));
        chain.carry_into(worker, leg, Direction::Forward, first, &mut first_ahead)?;
        chain.carry_into(
            worker,
            leg,
            Direction::Backward,
            arrived,
            &mut acceleration_back,
        )?;
        Ok(Carried {
            first_ahead,
            acceleration_back,
        })
    }
}

fn carry_fields<C: Chain>(
    chain: &C,
    worker: &mut C::Worker,
    leg: usize,
    way: Direction,
    from: &[f64],
    to: &mut [f64],
) -> Result<()> {
    let d = chain.size();
    for (from, to) in from.chunks_exact(d).zip(to.chunks_exact_mut(d)) {
        chain.carry_into(worker, leg, way, from, to)?;
    }
    Ok(())
}

/// Block rows of the system.
fn rows(lengths: &[f64], weights: &[f64], pull: f64, pliancy: f64) -> Vec<Row<2>> {
    let last = lengths.len();
    let mut rows = vec![Row::ZERO; last + 1];
    for (row, weight) in rows.iter_mut().zip(weights) {
        row.diagonal[0][0] = pull * weight;
    }
    for (leg, h) in lengths.iter().enumerate() {
        let (r1, mass) = (1.0 / h, pliancy * h / 6.0);
        let (starts, ends) = (leg > 0, leg + 1 < last);
        // `y` is zero at both ends, so it has neither column nor row there.
        let [at_start, at_end] = [starts, ends].map(|inner| if inner { r1 } else { 0.0 });
        let between = if starts && ends { mass } else { 0.0 };
        let before = &mut rows[leg];
        before.diagonal[0][1] -= at_start;
        before.diagonal[1][0] -= at_start;
        before.above = [[0.0, at_end], [at_start, -between]];
        if starts {
            before.diagonal[1][1] -= 2.0 * mass;
        }
        let after = &mut rows[leg + 1];
        after.diagonal[0][1] -= at_end;
        after.diagonal[1][0] -= at_end;
        after.below = [[0.0, at_start], [at_end, -between]];
        if ends {
            after.diagonal[1][1] -= 2.0 * mass;
        }
    }
    for end in [0, last] {
        rows[end].diagonal[1][1] = -1.0;
    }
    rows
}

fn too_unequal(lengths: &[f64]) -> Error {
    Error::InvalidArgument {
        name: "t",
        requirement: "more evenly spaced; ratio of longest to mean interval",
        found: lengths.iter().fold(0.0, |h, x| h.max(*x)),
    }
}
