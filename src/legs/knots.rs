//! A chain of knots: frames, times, and the conditions at the ends.

use crate::error::{Error, Result};
use crate::linalg::field::{Field, larger, largest};
use crate::solve::tridiagonal::{ChainShape, Row, Tridiagonal};
use crate::space::Homogeneous;

/// The condition at an end of a chain, in coordinates, per unit of time.
#[derive(Debug, Clone)]
pub(crate) enum End {
    Velocity(Vec<f64>),
    Acceleration(Vec<f64>),
}

/// The conditions at the ends of a chain.
#[derive(Debug, Clone)]
pub(crate) enum Ends {
    Open([End; 2]),
    Periodic,
}

/// A chain of knots.
pub(crate) struct Knots<'a> {
    /// Durations of the legs.
    pub(crate) lengths: &'a [f64],
    /// The frame of the next knot relative to the frame of the knot where the leg starts, shape `(r, r)`, in
    /// column-major order.
    pub(crate) targets: Vec<&'a [f64]>,
    pub(crate) ends: &'a Ends,
    /// Tension of the curves.
    pub(crate) tension: f64,
}

impl<'a> Knots<'a> {
    /// Knots whose legs need no targets, without tension.
    pub(crate) fn of_points(lengths: &'a [f64], ends: &'a Ends) -> Self {
        Knots {
            lengths,
            targets: Vec::new(),
            ends,
            tension: 0.0,
        }
    }

    /// Number of knots with a separate velocity: the last knot of a closed chain is the first one.
    pub(crate) fn count(&self) -> usize {
        self.lengths.len() + usize::from(matches!(self.ends, Ends::Open(_)))
    }

    /// The leg before a knot and the leg after it.
    pub(crate) fn legs_at(&self, knot: usize) -> [Option<usize>; 2] {
        let legs = self.lengths.len();
        let before = match (knot, self.ends) {
            (0, Ends::Periodic) => Some(legs - 1),
            (0, Ends::Open(_)) => None,
            _ => Some(knot - 1),
        };
        [before, (knot < legs).then_some(knot)]
    }

    /// The condition at a knot that is an end, and the sign of its acceleration in a jump.
    pub(crate) fn end_at(&self, knot: usize) -> Option<(&'a End, f64)> {
        match self.ends {
            Ends::Open([first, _]) if knot == 0 => Some((first, 1.0)),
            Ends::Open([_, last]) if knot == self.lengths.len() => Some((last, -1.0)),
            _ => None,
        }
    }

    /// Length of the shorter leg at a knot.
    pub(crate) fn shortest(&self, knot: usize) -> f64 {
        let legs = self.legs_at(knot).into_iter().flatten();
        legs.fold(f64::INFINITY, |h, leg| h.min(self.lengths[leg]))
    }

    /// Whether the velocity at a knot is given.
    pub(crate) fn is_fixed(&self, knot: usize) -> bool {
        matches!(self.end_at(knot), Some((End::Velocity(_), _)))
    }

    /// The scalar tridiagonal system of cubic splines in flat space, for the changes `dv` of the velocities that make up for
    /// jumps of the acceleration,
    ///
    /// ```math
    /// \frac{2}{h_-} dv_{j-1} + \Bigl(\frac{4}{h_-} + \frac{4}{h_+}\Bigr) dv_j + \frac{2}{h_+} dv_{j+1} = -[x']
    /// ```
    ///
    /// # Errors
    /// `Overflow` (times that differ too much).
    ///
    /// # Source
    /// de Boor (2001), "A Practical Guide to Splines", ch. IV.
    pub(crate) fn flat_system(&self) -> Result<Tridiagonal<1>> {
        let row = |knot: usize| {
            let mut row = Row::ZERO;
            if self.is_fixed(knot) {
                row.diagonal = [[1.0]];
                return row;
            }
            let [before, after] = self.legs_at(knot);
            if let Some(leg) = before {
                row.below[0][0] = 2.0 / self.lengths[leg];
                row.diagonal[0][0] += 4.0 / self.lengths[leg];
            }
            if let Some(leg) = after {
                row.above[0][0] = 2.0 / self.lengths[leg];
                row.diagonal[0][0] += 4.0 / self.lengths[leg];
            }
            row
        };
        let rows: Vec<Row<1>> = (0..self.count()).map(row).collect();
        let shape = match self.ends {
            Ends::Open(_) => ChainShape::Open,
            Ends::Periodic => ChainShape::Closed,
        };
        Tridiagonal::new(&rows, shape).ok_or(Error::Overflow {
            quantity: "system of a spline",
        })
    }

    /// The leg in a lane of a group. The last leg fills the unused lanes of the last group.
    #[inline(always)]
    pub(crate) fn leg_in<T: Field>(&self, group: usize, lane: usize) -> usize {
        (group * T::COUNT + lane).min(self.lengths.len() - 1)
    }

    /// The tensions of a group of legs, in their time; `None` for cubics.
    pub(crate) fn tensions<T: Field>(&self, group: usize) -> Option<T> {
        if self.tension == 0.0 {
            return None;
        }
        let mut tensions = T::ZERO;
        for lane in 0..T::COUNT {
            let h = self.lengths[self.leg_in::<T>(group, lane)];
            tensions.set_lane(lane, self.tension * h * h);
        }
        Some(tensions)
    }

    /// Writes the targets of a group of legs, shape `(r, r)`, in row-major order.
    pub(crate) fn write_targets<T: Field>(&self, r: usize, group: usize, out: &mut [T]) {
        for lane in 0..T::COUNT {
            let target = self.targets[self.leg_in::<T>(group, lane)];
            for (row, out) in out.chunks_exact_mut(r).enumerate() {
                for (col, out) in out.iter_mut().enumerate() {
                    out.set_lane(lane, target[row + r * col]);
                }
            }
        }
    }

    /// Writes the velocities at both ends of a group of legs, in the time of the legs, from the velocities at the
    /// knots.
    #[inline(always)]
    pub(crate) fn write_velocities<T: Field>(
        &self,
        velocities: &[f64],
        group: usize,
        [first, last]: [&mut [T]; 2],
    ) {
        let d = first.len();
        for lane in 0..T::COUNT {
            let leg = self.leg_in::<T>(group, lane);
            let h = self.lengths[leg];
            for p in 0..d {
                first[p].set_lane(lane, h * velocities[leg * d + p]);
                last[p].set_lane(lane, h * velocities[(leg + 1) * d + p]);
            }
        }
    }

    /// Jumps of the covariant acceleration at the knots, before minus after; at an end, minus the given acceleration.
    ///
    /// `accelerations` returns the accelerations at the start and the end of a leg's group, in the time of the legs.
    pub(crate) fn jumps<'l, T: Field + 'l>(
        &self,
        d: usize,
        accelerations: impl Fn(usize) -> [&'l [T]; 2],
    ) -> Vec<f64> {
        let mut jumps = vec![0.0; self.count() * d];
        for (knot, jump) in jumps.chunks_exact_mut(d).enumerate() {
            match self.end_at(knot) {
                Some((End::Velocity(_), _)) => continue,
                Some((End::Acceleration(wanted), sign)) => {
                    for (jump, wanted) in jump.iter_mut().zip(wanted) {
                        *jump = sign * wanted;
                    }
                }
                None => {}
            }
            let [before, after] = self.legs_at(knot);
            for (leg, end, sign) in [(before, 1, 1.0), (after, 0, -1.0)] {
                let Some(leg) = leg else { continue };
                let rate = sign * self.lengths[leg].powi(-2);
                for (jump, x) in jump.iter_mut().zip(accelerations(leg)[end]) {
                    *jump += rate * x.lane(leg % T::COUNT);
                }
            }
        }
        jumps
    }

    /// The largest entry of the jumps, in the time of the shorter leg at each knot.
    pub(crate) fn largest_jump(&self, jumps: &[f64], d: usize) -> f64 {
        let mut most = 0.0;
        for (knot, jump) in jumps.chunks_exact(d).enumerate() {
            most = larger(most, self.shortest(knot).powi(2) * largest(jump));
        }
        most
    }

    /// The largest velocity at a knot, in the time of a leg, or the largest distance between neighbouring knots,
    /// whichever is larger.
    pub(crate) fn speed(&self, space: impl Homogeneous, velocities: &[f64]) -> f64 {
        let (d, r) = (space.dim(), space.size());
        let speed = |knot: usize| {
            let squares = velocities[knot * d..][..d].iter().map(|v| v * v);
            squares.sum::<f64>().sqrt()
        };
        let mut most = 0.0;
        for (leg, (h, target)) in self.lengths.iter().zip(&self.targets).enumerate() {
            most = larger(most, h * larger(speed(leg), speed(leg + 1)));
            // |g - 1|^2 = 2 (r - tr g).
            let trace: f64 = (0..r).map(|i| target[i * r + i]).sum();
            most = larger(most, (2.0 * (r as f64 - trace)).max(0.0).sqrt());
        }
        most
    }
}
