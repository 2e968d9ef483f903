//! Splines as chains of legs in the embedding: the unknowns are velocities at the knots and the fourth derivatives of
//! the legs.
//!
//! Along a leg the fourth derivative is replaced by that of the equation, a fixed-point iteration with a smoothing
//! kernel. At a knot the covariant acceleration is continuous if `S''` is, and the change of the velocities that makes
//! it so in flat space solves the tridiagonal system of cubic splines. A step is two sweeps along each leg and that
//! change, tangential and with Anderson mixing: no derivatives, no frames, and work linear in the number of rows.

use faer::{Mat, MatRef};

use super::clamped::{Clamped, LEVELS};
use super::clamped_leg::{ClampedLeg, ClampedScratch};
use super::solved_chain::{SolvedChain, complete, lift};
use crate::collocation::lane_nodes::nodes;
use crate::error::Result;
use crate::legs::{End, Ends, Knots, Options, Progress};
use crate::linalg::field::larger;
use crate::linalg::product::{columns, columns_mut};
use crate::linalg::simd::{Buffers, Four, each};
use crate::manifold::grassmann::alignment::alignment;
use crate::manifold::tangent::tangent_part;
use crate::report::{SolverReport, StopReason};
use crate::solve::anderson::Anderson;
use crate::solve::tridiagonal::{Tridiagonal, Unturned};
use crate::space::{Kind, Quotient};

/// Number of past steps used by Anderson mixing. With 5, the splines below take as many steps, and one through 50
/// points on St(12,11) takes 20 for 19.
const DEPTH: usize = 8;

/// Sweeps along the legs for each change of the velocities. For splines through 100 points, 0.5 and 1.2 apart on
/// St(20,5) and St(1000,5), one takes 1.4 to 1.6 times as long, three 1.1 to 1.3 times.
const SWEEPS: usize = 2;

/// Number of consecutive steps that may leave more than half of the smallest residual so far. With 4 or 8, one more of
/// 60 splines 0.6 to 2.2 apart on St(12,4) to St(200,5) is not solved; with 24, none less, and times are the same.
const PATIENCE: usize = 12;

/// Microseconds of a multiplication in a sweep, of a jump for each of its entries, and of Gram matrices for each
/// product: on St(20,5) and St(200,5) two sweeps take 37 to 49, a jump 0.7 to 5, Gram matrices 2 to 5.
const MULTIPLICATION: f64 = 1e-4;
const JUMP: f64 = 5e-3;
const GRAM: f64 = 1e-3;

/// Number of nodes for legs without rotation, and additional ones per radian: at first, and afterwards. Counts are
/// rounded up to multiples of eight, and too few are found by the last coefficients.
const COARSE: [f64; 2] = [3.0, 1.5];
const FINE: [f64; 2] = [9.0, 2.5];

/// Number of nodes added if the truncation error of the polynomials is too large.
const MORE: usize = 8;

/// Largest size of the last Legendre coefficients of the fourth derivative. Lower derivatives are integrals and far
/// more accurate: beside integrated cubics, accelerations are off by up to 1e-13 and jerks by 1e-12.
pub(crate) const TAIL: f64 = 1e-8;

/// Largest number of nodes.
const MOST: usize = 48;

/// Largest distance from the manifold. Without this bound, a solution between subspaces in
/// `tests/subspaces/several_solutions.rs` is 2e-3 away.
const ON_MANIFOLD: f64 = 1e-10;

/// Residual below which the second phase begins.
const ROUGH: f64 = 1e-3;

/// Points of shape `(n, k)` with times and end conditions, whose vectors are matrices, one column after another. The
/// last point of a closed chain is the first one.
pub(crate) struct EmbeddedChain<'a> {
    pub(crate) kind: Kind,
    pub(crate) points: &'a [Mat<f64>],
    pub(crate) knots: &'a Knots<'a>,
}

impl EmbeddedChain<'_> {
    /// Solves the equations from the spline of flat space.
    ///
    /// # Errors
    /// `Interrupted`, `Overflow` (the times of the knots), `Decomposition`, and the errors of the start.
    pub(crate) fn solve(&self, options: &Options<'_>) -> Result<(SolverReport, SolvedChain)> {
        let mut iteration = EmbeddedIteration::new(self)?;
        let mut progress = Progress::new(options.tolerance);
        let reason = match iteration.start_flat()? {
            true => iteration.solve(&mut progress, options)?,
            false => StopReason::Diverged,
        };
        let solved = SolvedChain {
            legs: iteration.legs.into_iter().map(|swept| swept.leg).collect(),
            lengths: self.knots.lengths.to_vec(),
            velocities: iteration.velocities,
            pairs: iteration.pairs,
        };
        Ok((progress.report(reason), solved))
    }

    fn shape(&self) -> (usize, usize) {
        self.points[0].shape()
    }

    /// Whether the coordinates of a leg are those of the points. Otherwise they are factors of the data at its ends.
    fn is_direct(&self) -> bool {
        let (n, k) = self.shape();
        n <= LEVELS * k
    }
}

/// A leg, and the change of its last sweep.
#[derive(Clone)]
struct SweptLeg {
    leg: ClampedLeg,
    change: f64,
}

/// The state of the iteration.
struct EmbeddedIteration<'c> {
    chain: &'c EmbeddedChain<'c>,
    legs: Vec<SweptLeg>,
    /// Point and velocity at each knot, shape `(n, 2k)`.
    pairs: Vec<Mat<f64>>,
    velocities: Vec<f64>,
    /// Jumps of the covariant acceleration at the knots: before minus after; at an end, minus the given one.
    jumps: Vec<f64>,
    /// The largest residual.
    size: f64,
    /// Whether the fourth derivatives are mixed with the velocities.
    mixes_legs: bool,
    scratch: Buffers<ClampedScratch>,
}

impl<'c> EmbeddedIteration<'c> {
    /// At rest, except for given velocities.
    fn new(chain: &'c EmbeddedChain<'c>) -> Result<Self> {
        let ((n, k), EmbeddedChain { kind, knots, .. }) = (chain.shape(), chain);
        let r = if chain.is_direct() { n } else { LEVELS * k };
        let few = Clamped::few();
        let swept = |h: &f64| SweptLeg {
            leg: ClampedLeg::new([r, k], *kind, knots.tension * h * h, &few),
            change: f64::INFINITY,
        };
        let pair = |point: &Mat<f64>| {
            let mut pair = Mat::zeros(n, 2 * k);
            pair.as_mut().subcols_mut(0, k).copy_from(point);
            pair
        };
        let mut iteration = EmbeddedIteration {
            legs: knots.lengths.iter().map(swept).collect(),
            pairs: chain.points.iter().map(pair).collect(),
            velocities: at_rest(chain),
            jumps: vec![0.0; knots.count() * n * k],
            size: f64::INFINITY,
            mixes_legs: false,
            scratch: Buffers::new(ClampedScratch::default()),
            chain,
        };
        if chain.kind.quotient == Quotient::Subspaces {
            for (SweptLeg { leg, .. }, points) in
                iteration.legs.iter_mut().zip(chain.points.windows(2))
            {
                leg.set_turn(alignment(points[0].as_ref(), points[1].as_ref())?.as_ref());
            }
        }
        iteration.set_data();
        Ok(iteration)
    }

    /// Starts from the spline of flat space, to which the first step leads from rest without fourth derivatives;
    /// `false` if it is too fast.
    fn start_flat(&mut self) -> Result<bool> {
        self.set_jumps();
        let step = self.flat_step(&self.chain.knots.flat_system()?)?;
        self.follow(&step);
        Ok(self.refine(|leg| nodes(COARSE, leg.largest_speed(), MOST + 1)))
    }

    /// Solves on a few nodes, then on more until the truncation error is negligible.
    fn solve(&mut self, progress: &mut Progress, options: &Options<'_>) -> Result<StopReason> {
        let reason = self.run(ROUGH, progress, options)?;
        if reason != StopReason::Converged {
            return Ok(reason);
        }
        let mut is_fine = self.refine(|leg| nodes(FINE, leg.largest_speed(), MOST + 1));
        while is_fine {
            let reason = self.run(options.tolerance, progress, options)?;
            if reason != StopReason::Converged {
                return Ok(reason);
            }
            if !self.is_on_manifold() {
                return Ok(StopReason::Diverged);
            }
            let more = |leg: &ClampedLeg| if leg.tail() <= TAIL { 0 } else { MORE };
            if self.legs.iter().all(|swept| more(&swept.leg) == 0) {
                return Ok(reason);
            }
            is_fine = self.refine(|leg| leg.nodes.count() + more(leg));
        }
        Ok(StopReason::Stagnated)
    }

    /// Whether the legs lie on the manifold.
    fn is_on_manifold(&mut self) -> bool {
        let scratch = &mut self.scratch.own;
        let mut legs = self.legs.iter();
        legs.all(|swept| swept.leg.defect(scratch) <= ON_MANIFOLD)
    }

    /// Takes legs to more nodes; `false` if there are not so many.
    fn refine(&mut self, count: impl Fn(&ClampedLeg) -> usize + Sync) -> bool {
        for SweptLeg { leg, .. } in &mut self.legs {
            match Clamped::at_least(count(leg)) {
                Some(finer) if finer.count() > leg.nodes.count() => *leg = leg.on_nodes(&finer),
                Some(_) => {}
                None => return false,
            }
        }
        true
    }

    /// Steps until the tolerance is reached.
    ///
    /// # Errors
    /// `Interrupted`, `Overflow` (the times of the knots).
    fn run(
        &mut self,
        tolerance: f64,
        progress: &mut Progress,
        options: &Options<'_>,
    ) -> Result<StopReason> {
        let system = self.chain.knots.flat_system()?;
        let mut mixing = Anderson::new(DEPTH);
        let (mut least, mut failures) = (f64::INFINITY, 0);
        loop {
            let before = self.mixes_legs.then(|| self.fourth_derivatives());
            self.size = self.sweep(SWEEPS);
            self.set_jumps();
            let jump = self.chain.knots.largest_jump(&self.jumps, self.vector());
            self.size = larger(self.size, jump);
            let derivative = self.legs.iter().map(|swept| swept.leg.largest());
            let goal = progress.set(self.size, derivative.fold(0.0, larger), tolerance);
            if self.size <= goal {
                return Ok(StopReason::Converged);
            }
            if self.size <= 0.5 * least {
                (least, failures) = (self.size, 0);
            } else {
                failures += 1;
            }
            if failures == PATIENCE || !self.size.is_finite() {
                return Ok(StopReason::Diverged);
            }
            if let Some(reason) = progress.step(self.products(), options)? {
                return Ok(reason);
            }
            self.advance(before, &system, &mut mixing)?;
            if failures > 0 && !self.mixes_legs {
                self.mixes_legs = true;
                mixing = Anderson::new(DEPTH);
            }
        }
    }

    /// One step from the present jumps and, if they are mixed, from the fourth derivatives before the sweeps.
    fn advance(
        &mut self,
        before: Option<Vec<f64>>,
        system: &Tridiagonal<1>,
        mixing: &mut Anderson,
    ) -> Result<()> {
        let mut step = self.flat_step(system)?;
        let count = step.len();
        if let Some(before) = &before {
            let now = self.fourth_derivatives();
            step.extend(now.iter().zip(before).map(|(now, before)| now - before));
        }
        let increment = mixing.increment(step);
        if let Some(before) = &before {
            let changes = before.iter().zip(&increment[count..]);
            self.set_fourth_derivatives(changes.map(|(f, change)| f + change));
        }
        self.follow(&increment[..count]);
        Ok(())
    }

    /// The fourth derivatives of all legs.
    fn fourth_derivatives(&self) -> Vec<f64> {
        let legs = self.legs.iter().flat_map(|swept| &swept.leg.f);
        legs.flat_map(|f| f.0).collect()
    }

    fn set_fourth_derivatives(&mut self, values: impl Iterator<Item = f64>) {
        let legs = self.legs.iter_mut().flat_map(|swept| &mut swept.leg.f);
        for (f, value) in legs.flat_map(|f| &mut f.0).zip(values) {
            *f = value;
        }
    }

    /// Number of entries of a vector at a knot.
    fn vector(&self) -> usize {
        let (n, k) = self.chain.shape();
        n * k
    }

    /// Number of products of a sweep.
    fn products_of_sweep(&self) -> f64 {
        let legs = self.legs.iter().map(|swept| swept.leg.multiplications());
        legs.sum()
    }

    /// Number of products of a step.
    fn products(&self) -> f64 {
        let [knots, vector, k] =
            [self.pairs.len(), self.vector(), self.chain.shape().1].map(|count| count as f64);
        SWEEPS as f64 * self.products_of_sweep() + knots * vector * (4.0 * DEPTH as f64 + 16.0 * k)
    }

    /// Gives the legs the present velocities.
    fn set_data(&mut self) {
        let (vector, (n, k), chain) = (self.vector(), self.chain.shape(), self.chain);
        for (knot, pair) in self.pairs.iter_mut().enumerate() {
            let v = columns(&self.velocities[knot * vector..][..vector], n);
            pair.as_mut().subcols_mut(k, k).copy_from(v);
        }
        let (pairs, lengths) = (&self.pairs, chain.knots.lengths);
        if chain.is_direct() {
            for (i, SweptLeg { leg, .. }) in self.legs.iter_mut().enumerate() {
                let data = [(i, 0), (i, k), (i + 1, 0), (i + 1, k)].map(|(knot, first)| {
                    let factor = if first == 0 { 1.0 } else { lengths[i] };
                    let columns = pairs[knot].as_ref().subcols(first, leg.equation.stored());
                    let entries = columns.col_iter().flat_map(|column| column.iter());
                    entries.map(|x| factor * x).collect::<Vec<f64>>()
                });
                leg.set_data(data.each_ref().map(Vec::as_slice));
            }
            return;
        }
        let (micros, none) = (GRAM * (n * k * k) as f64, &mut Buffers::new(()));
        each::<Four, _, _>(&mut self.legs, micros, none, |(), i, swept| {
            swept.leg.set_gram([&pairs[i], &pairs[i + 1]], lengths[i]);
        });
    }

    /// Sweeps along all legs; returns the largest change of the last sweep.
    fn sweep(&mut self, times: usize) -> f64 {
        let micros =
            MULTIPLICATION * times as f64 * self.products_of_sweep() / self.legs.len() as f64;
        each::<Four, _, _>(
            &mut self.legs,
            micros,
            &mut self.scratch,
            |scratch, _, swept| {
                for _ in 0..times {
                    swept.change = swept.leg.sweep(scratch);
                }
            },
        );
        (self.legs.iter()).fold(0.0, |most, swept| larger(most, swept.change))
    }

    fn set_jumps(&mut self) {
        let vector = self.vector();
        let mut jumps = std::mem::take(&mut self.jumps);
        let mut each_knot: Vec<&mut [f64]> = jumps.chunks_exact_mut(vector).collect();
        let (micros, none) = (JUMP * vector as f64, &mut Buffers::new(()));
        each::<Four, _, _>(&mut each_knot, micros, none, |(), knot, jump| {
            self.jump_into(knot, jump)
        });
        self.jumps = jumps;
    }

    /// With continuous points and velocities, the covariant acceleration jumps by as much as `S''`.
    fn jump_into(&self, knot: usize, jump: &mut [f64]) {
        jump.fill(0.0);
        let (chain, knots) = (self.chain, self.chain.knots);
        let end = knots.end_at(knot);
        if let Some((End::Velocity(_), _)) = end {
            return;
        }
        let stored = self.legs[0].leg.equation.stored();
        let (first, _) = jump.split_at_mut(chain.shape().0 * stored);
        for (leg, (end, sign)) in knots.legs_at(knot).into_iter().zip([(1, 1.0), (0, -1.0)]) {
            let Some(leg) = leg else { continue };
            let mut x = vec![0.0; self.legs[leg].leg.data[0].len()];
            let this = &self.legs[leg].leg;
            this.at_end(end, 0, &mut x);
            if end == 1 {
                this.turn_back(&mut x);
            }
            let h = knots.lengths[leg];
            let pairs = &self.pairs[leg..][..2];
            lift(pairs, h, sign * h.powi(-2), &mut x, first);
        }
        complete(jump, chain.shape().0, stored);
        if let Some((End::Acceleration(wanted), sign)) = end {
            let (s, v) = self.at_knot(knot);
            let omega = s.transpose() * v;
            let square = v.transpose() * v + &omega * &omega;
            // S'' - A.
            let normal = v * &omega - s * &square;
            let entries = normal.col_iter().flat_map(|column| column.iter());
            for ((jump, wanted), normal) in jump.iter_mut().zip(wanted).zip(entries) {
                *jump += sign * (wanted + normal);
            }
        }
    }

    fn at_knot(&self, knot: usize) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
        self.pairs[knot].as_ref().split_at_col(self.chain.shape().1)
    }

    /// The change of the velocities that would make the acceleration continuous in flat space, made tangential.
    fn flat_step(&self, system: &Tridiagonal<1>) -> Result<Vec<f64>> {
        let (chain, vector) = (self.chain, self.vector());
        let mut step: Vec<f64> = self.jumps.iter().map(|jump| -jump).collect();
        system.solve(&mut Unturned(vector), &mut step)?;
        for (point, step) in chain.points.iter().zip(step.chunks_exact_mut(vector)) {
            let (quotient, n) = (chain.kind.quotient, point.nrows());
            let tangent = tangent_part(quotient, point.as_ref(), columns(step, n));
            columns_mut(step, n).copy_from(&tangent);
        }
        Ok(step)
    }

    fn follow(&mut self, increment: &[f64]) {
        for (v, change) in self.velocities.iter_mut().zip(increment) {
            *v += change;
        }
        if matches!(self.chain.knots.ends, Ends::Periodic) {
            let (all, last) = self.velocities.split_at_mut(increment.len());
            last.copy_from_slice(&all[..last.len()]);
        }
        self.set_data();
    }
}

/// Velocities that vanish except where they are given.
fn at_rest(chain: &EmbeddedChain<'_>) -> Vec<f64> {
    let (n, k) = chain.shape();
    let mut velocities = vec![0.0; n * k * chain.points.len()];
    if let Ends::Open([first, last]) = chain.knots.ends {
        let at = velocities.len() - n * k;
        for (end, at) in [(first, 0), (last, at)] {
            if let End::Velocity(v) = end {
                velocities[at..][..n * k].copy_from_slice(v);
            }
        }
    }
    velocities
}
