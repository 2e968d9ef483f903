//! Sweeps along a chain: `x'''` from the motion, and the step that would solve the equations at the ends of the legs in
//! flat space, with Anderson mixing. A sweep takes no derivatives, so it is cheap in spaces of high dimension.

use super::chain::{Chain, Group};
use crate::curve::nodes::Nodes;
use crate::error::{Error, Result};
use crate::legs::{Ends, Knots, Options, Progress};
use crate::linalg::field::Field;
use crate::report::StopReason;
use crate::solve::anderson::Anderson;
use crate::solve::tridiagonal::{Isometries, Row, Shape, Tridiagonal, Way};
use crate::space::Homogeneous;

/// Number of past sweeps used by Anderson mixing.
const DEPTH: usize = 8;

/// Number of consecutive sweeps that may leave more than half of the smallest residual so far.
const PATIENCE: usize = 12;

impl<T: Field, S: Homogeneous> Chain<'_, T, S> {
    /// Sweeps until the tolerance is reached.
    ///
    /// # Errors
    /// `Interrupted`, `Overflow` (the times of the knots).
    pub(super) fn sweep(
        &mut self,
        nodes: &Nodes,
        tolerance: f64,
        progress: &mut Progress,
        options: &Options<'_>,
    ) -> Result<StopReason> {
        let system = system(self.knots)?;
        let mut mixing = Anderson::new(DEPTH);
        let (mut least, mut failures) = (f64::INFINITY, 0);
        loop {
            self.sweep_once(nodes);
            let goal = progress.set(self.size, self.largest_bend(), tolerance);
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
            if let Some(reason) = progress.step(self.products_of_sweep(nodes), options)? {
                return Ok(reason);
            }
            let step = self.flat_step(&system)?;
            self.follow(&mixing.increment(step));
        }
    }

    /// Changes of the velocities, then of `x'`, `x''` and `x'''` of each leg; the change of `x'''` is already applied.
    fn flat_step(&self, system: &Tridiagonal<1>) -> Result<Vec<f64>> {
        let d = self.space.dim();
        let mut right: Vec<f64> = self.jumps.iter().map(|jump| -jump).collect();
        let mut turning = Turning::new(self);
        let mut arriving = vec![0.0; d];
        for (leg, h) in self.knots.lengths.iter().enumerate() {
            let (rate, [p, q]) = (h.powi(-2), self.missing(leg));
            let next = (leg + 1) % self.knots.count();
            if !self.knots.is_fixed(leg) {
                for i in 0..d {
                    right[leg * d + i] += rate * (6.0 * p[i] - 2.0 * q[i]);
                }
            }
            if !self.knots.is_fixed(next) {
                let bend: Vec<f64> = (0..d).map(|i| 4.0 * q[i] - 6.0 * p[i]).collect();
                turning.carry_into(leg, Way::Forward, &bend, &mut arriving)?;
                for i in 0..d {
                    right[next * d + i] -= rate * arriving[i];
                }
            }
        }
        system.solve(&mut turning, &mut right)?;
        if matches!(self.knots.ends, Ends::Periodic) {
            right.extend_from_within(..d);
        }
        let mut step = right.clone();
        for (leg, h) in self.knots.lengths.iter().enumerate() {
            let [p, q] = self.missing(leg);
            let next = &right[(leg + 1) * d..][..d];
            turning.carry_into(leg, Way::Backward, next, &mut arriving)?;
            let first = &right[leg * d..][..d];
            let p: Vec<f64> = (0..d).map(|i| p[i] - h * first[i]).collect();
            let q: Vec<f64> = (0..d)
                .map(|i| q[i] + h * (arriving[i] - first[i]))
                .collect();
            step.extend(p.iter().zip(&q).map(|(p, q)| 6.0 * p - 2.0 * q));
            step.extend(p.iter().zip(&q).map(|(p, q)| 6.0 * q - 12.0 * p));
            let (group, lane) = (&self.groups[leg / T::COUNT], leg % T::COUNT);
            let pairs = group.leg.f.iter().zip(&group.before);
            step.extend(pairs.map(|(now, before)| now.lane(lane) - before.lane(lane)));
        }
        Ok(step)
    }

    /// Point and velocity defects of a leg, at its end.
    fn missing(&self, leg: usize) -> [Vec<f64>; 2] {
        let (residual, lane) = (&self.groups[leg / T::COUNT].leg.residual, leg % T::COUNT);
        [&residual.point, &residual.velocity].map(|v| v.iter().map(|v| -v.lane(lane)).collect())
    }

    /// Applies an increment to the unknowns before the sweep.
    fn follow(&mut self, increment: &[f64]) {
        let (d, count) = (self.space.dim(), self.knots.lengths.len());
        let (velocities, bends) = increment.split_at(self.velocities.len());
        for (v, change) in self.velocities.iter_mut().zip(velocities) {
            *v += change;
        }
        let size = bends.len() / count;
        for (group, Group { leg, before }) in self.groups.iter_mut().enumerate() {
            let ends = [&mut leg.velocity, &mut leg.last_velocity].map(Vec::as_mut_slice);
            self.knots.write_velocities(&self.velocities, group, ends);
            for lane in 0..T::COUNT {
                let change = &bends[self.knots.leg_in::<T>(group, lane) * size..][..size];
                for p in 0..d {
                    let bend = leg.acceleration[p].lane(lane) + change[p];
                    leg.acceleration[p].set_lane(lane, bend);
                    let third = leg.third[p].lane(lane) + change[d + p];
                    leg.third[p].set_lane(lane, third);
                }
                let each = leg.f.iter_mut().zip(&*before).zip(&change[2 * d..]);
                for ((f, before), change) in each {
                    f.set_lane(lane, before.lane(lane) + change);
                }
            }
        }
    }
}

/// The isometries between the frames reached by legs and those of the next knots.
struct Turning<'c, 'k, T, S> {
    chain: &'c Chain<'k, T, S>,
    matrix: Vec<f64>,
}

impl<'c, 'k, T: Field, S: Homogeneous> Turning<'c, 'k, T, S> {
    fn new(chain: &'c Chain<'k, T, S>) -> Self {
        Turning {
            chain,
            matrix: vec![0.0; chain.space.size().pow(2)],
        }
    }
}

impl<T: Field, S: Homogeneous> Isometries for Turning<'_, '_, T, S> {
    fn size(&self) -> usize {
        self.chain.space.dim()
    }

    fn carry_into(&mut self, leg: usize, way: Way, from: &[f64], to: &mut [f64]) -> Result<()> {
        let group = &self.chain.groups[leg / T::COUNT].leg;
        for (entry, q) in self.matrix.iter_mut().zip(&group.holonomy) {
            *entry = q.lane(leg % T::COUNT);
        }
        match way {
            Way::Forward => self.chain.space.turn_into(&self.matrix, from, to),
            Way::Backward => self.chain.space.turn_back_into(&self.matrix, from, to),
        }
        Ok(())
    }
}

/// The system of cubic splines for the changes of the velocities: with the point and velocity defects `p` and `q` of a
/// leg,
///
/// ```math
/// \frac{2}{h_-} dv_{j-1} + \Bigl(\frac{4}{h_-} + \frac{4}{h_+}\Bigr) dv_j + \frac{2}{h_+} dv_{j+1}
///     = -[x'] - \frac{4 q_- - 6 p_-}{h_-^2} + \frac{6 p_+ - 2 q_+}{h_+^2}
/// ```
fn system(knots: &Knots<'_>) -> Result<Tridiagonal<1>> {
    let row = |knot: usize| {
        let mut row = Row::ZERO;
        if knots.is_fixed(knot) {
            row.diagonal = [[1.0]];
            return row;
        }
        let [before, after] = knots.legs_at(knot);
        if let Some(leg) = before {
            row.below[0][0] = 2.0 / knots.lengths[leg];
            row.diagonal[0][0] += 4.0 / knots.lengths[leg];
        }
        if let Some(leg) = after {
            row.above[0][0] = 2.0 / knots.lengths[leg];
            row.diagonal[0][0] += 4.0 / knots.lengths[leg];
        }
        row
    };
    let rows: Vec<Row<1>> = (0..knots.count()).map(row).collect();
    let shape = match knots.ends {
        Ends::Open(_) => Shape::Open,
        Ends::Periodic => Shape::Closed,
    };
    Tridiagonal::new(&rows, shape).ok_or(Error::Overflow {
        quantity: "system of a spline",
    })
}
