//! A chain of legs between given points, with all their equations.

use crate::legs::Knots;
use crate::linalg::field::{Field, larger, largest};
use crate::linalg::simd::{Buffers, each};
use crate::shooting::taylor::condensed_leg::CondensedLeg;
use crate::shooting::taylor::durations::{micros_of_series, products_of_pair};
use crate::shooting::taylor::leg::{LegScratch, SeriesLeg};
use crate::shooting::taylor::orders::{MOST, Orders};
use crate::shooting::taylor::room::Room;
use crate::shooting::taylor::rotation_series::is_of_rotations;
use crate::shooting::taylor::variation::{
    MORE_TERMS, MOST_TERMS_OF_ROTATIONS, MiddleVariation, TERMS, terms_of_rotations,
};
use crate::solve::block_tridiagonal::{BlockTridiagonal, Factors};
use crate::space::Homogeneous;

/// Consecutive legs, in groups of eight, with the residuals of their equations.
pub(crate) struct SeriesChain<'k, T: Field, S> {
    pub(crate) space: S,
    pub(crate) knots: &'k Knots<'k>,
    pub(crate) groups: Vec<LegGroup<'k, T>>,
    pub(crate) buffers: Buffers<ChainBuffers<T>>,
    pub(crate) velocities: Vec<f64>,
    /// Jumps of the covariant acceleration at the knots: before minus after; at an end, minus the given one.
    pub(crate) jumps: Vec<f64>,
    /// Changes of the velocities by the step, and the linear system for them.
    pub(crate) step: Vec<f64>,
    pub(crate) system: BlockTridiagonal,
    pub(crate) factors: Option<Factors>,
    /// The largest residual.
    pub(crate) size: f64,
}

/// One leg, or eight of them, with a step of its middle and the linear equations.
pub(crate) struct LegGroup<'a, T> {
    pub(crate) leg: SeriesLeg<'a, T>,
    pub(crate) step: &'a mut [T],
    pub(crate) linear: CondensedLeg<'a, T>,
    pub(crate) progress: GroupProgress,
}

/// Progress of the iteration on the legs of a group: most legs of a long chain are solved in fewer steps than the worst
/// one.
pub(crate) struct GroupProgress {
    /// The largest residual of its legs and of the adjacent knots, now and before the last step.
    pub(crate) size: f64,
    pub(crate) before: f64,
    /// The largest entry of the step since its legs were evaluated.
    pub(crate) moved: f64,
    /// Allowed contribution of the last terms of its series in the last evaluation.
    pub(crate) accuracy: f64,
    /// Whether the linear equations must be set up anew, and whether the last linearisation did so.
    pub(crate) is_stale: bool,
    pub(crate) is_new: bool,
}

impl GroupProgress {
    fn new() -> Self {
        GroupProgress {
            size: f64::INFINITY,
            before: f64::INFINITY,
            moved: f64::INFINITY,
            accuracy: f64::INFINITY,
            is_stale: true,
            is_new: false,
        }
    }
}

impl<'a, T: Field> LegGroup<'a, T> {
    /// Number of floating-point numbers of a group.
    pub(crate) fn len(space: impl Homogeneous) -> usize {
        SeriesLeg::<T>::len(space) + 3 * space.dim() + CondensedLeg::<T>::len(space)
    }

    fn new(space: impl Homogeneous, room: &mut Room<'a, T>) -> Self {
        LegGroup {
            leg: SeriesLeg::new(space, room),
            step: room.take(3 * space.dim()),
            linear: CondensedLeg::new(space, room),
            progress: GroupProgress::new(),
        }
    }
}

/// Buffers of a thread.
#[derive(Clone)]
pub(crate) struct ChainBuffers<T: Field> {
    pub(crate) leg: LegScratch<T>,
    pub(crate) variation: MiddleVariation<T>,
}

impl<'k, T: Field, S: Homogeneous> SeriesChain<'k, T, S> {
    /// Built from velocities at the knots, per unit of time; allocates all legs, and series up to an order.
    pub(crate) fn new(
        space: S,
        knots: &'k Knots<'k>,
        velocities: &[f64],
        room: &'k mut [T],
        order: usize,
    ) -> Self {
        let mut room = Room::new(room);
        let (r, count) = (space.size(), knots.lengths.len());
        let mut chain: Self = SeriesChain {
            space,
            knots,
            groups: (0..count.div_ceil(T::COUNT))
                .map(|_| LegGroup::new(space, &mut room))
                .collect(),
            buffers: Buffers::new(ChainBuffers {
                leg: LegScratch::new(space, order),
                variation: MiddleVariation::new(space, 2, most_terms(space, knots)),
            }),
            velocities: velocities.to_vec(),
            jumps: Vec::new(),
            step: vec![0.0; velocities.len()],
            system: system(space.dim(), knots),
            factors: None,
            size: f64::INFINITY,
        };
        for (group, LegGroup { leg, .. }) in chain.groups.iter_mut().enumerate() {
            knots.write_targets(r, group, leg.target);
            leg.tension = knots.tensions(group);
        }
        chain
    }

    /// Sets the middles of the legs from `x'` and `x''` at their starts, in the time of the leg, as in flat space.
    pub(crate) fn set_middles(&mut self, derivatives: &[f64]) {
        let (knots, d) = (self.knots, self.space.dim());
        self.set_velocities();
        for (group, LegGroup { leg, .. }) in self.groups.iter_mut().enumerate() {
            let middle = &mut leg.middle;
            for lane in 0..T::COUNT {
                let i = knots.leg_in::<T>(group, lane);
                for p in 0..d {
                    middle[1][p].set_lane(lane, derivatives[2 * i * d + p]);
                    middle[2][p].set_lane(lane, derivatives[(2 * i + 1) * d + p]);
                }
            }
            for p in 0..d {
                let [v, a, b] = [leg.velocity[p], middle[1][p], middle[2][p]];
                middle[0][p] = v + a * 0.5 + b * 0.125;
                middle[1][p] = a + b * 0.5;
            }
        }
    }

    /// Velocities at the ends of the legs, in their time.
    fn set_velocities(&mut self) {
        for (group, LegGroup { leg, .. }) in self.groups.iter_mut().enumerate() {
            let ends = [&mut *leg.velocity, &mut *leg.last_velocity];
            self.knots.write_velocities(&self.velocities, group, ends);
        }
    }

    /// Changes the unknowns by a fraction of the step.
    pub(crate) fn follow_step(&mut self, share: f64) {
        for (velocity, step) in self.velocities.iter_mut().zip(&self.step) {
            *velocity += share * step;
        }
        self.set_velocities();
        let d = self.space.dim();
        for LegGroup { leg, step, .. } in &mut self.groups {
            for (x, step) in leg.middle.iter_mut().zip(step.chunks_exact(d)) {
                for (x, step) in x.iter_mut().zip(step) {
                    *x += *step * share;
                }
            }
        }
    }

    /// Evaluates the residuals of the legs that have moved by more than `still`, or whose series are not accurate
    /// enough for their residual. The number of terms is that of the solution if `is_last`, otherwise that of the next
    /// step.
    pub(crate) fn evaluate(&mut self, still: f64, is_last: bool) {
        let space = self.space;
        each::<S::Width, _, _>(
            &mut self.groups,
            micros_of_series(space),
            &mut self.buffers,
            #[inline(always)]
            |ChainBuffers { leg: scratch, .. }, _, LegGroup { leg, progress, .. }| {
                let orders = match is_last {
                    true => Orders::last(),
                    false => Orders::after_in(space, progress.size),
                };
                if progress.moved <= still && progress.accuracy <= orders.accuracy {
                    return;
                }
                leg.order = orders.of_leg(leg.speed(), leg.more);
                leg.set_residual(space, scratch);
                leg.more = orders.more(leg.more, leg.largest_tail());
                progress.moved = 0.0;
                // Use more terms next time if the truncation error is too large.
                progress.accuracy = match leg.largest_tail() <= orders.accuracy {
                    true => orders.accuracy,
                    false => f64::INFINITY,
                };
            },
        );
        self.set_sizes();
    }

    /// Sets the jumps of the accelerations, and the residuals of the chain and of each group.
    fn set_sizes(&mut self) {
        let (d, groups) = (self.space.dim(), &self.groups);
        self.jumps = self.knots.jumps(d, |leg| {
            let accelerations = &groups[leg / T::COUNT].leg.accelerations;
            accelerations.each_ref().map(|x| &**x)
        });
        for LegGroup { leg, progress, .. } in &mut self.groups {
            progress.size = leg.residual.size;
        }
        for (knot, jump) in self.jumps.chunks_exact(d).enumerate() {
            let size = self.knots.shortest(knot).powi(2) * largest(jump);
            for leg in self.knots.legs_at(knot).into_iter().flatten() {
                let progress = &mut self.groups[leg / T::COUNT].progress;
                progress.size = larger(progress.size, size);
            }
        }
        let sizes = self.groups.iter().map(|group| group.progress.size);
        self.size = sizes.fold(0.0, larger);
    }

    fn leg(&self, leg: usize) -> &SeriesLeg<'k, T> {
        &self.groups[leg / T::COUNT].leg
    }

    /// Whether a series with a too large truncation error already has the maximal number of terms.
    pub(crate) fn is_longest(&self) -> bool {
        let accuracy = Orders::last().accuracy;
        let mut groups = self.groups.iter();
        groups.any(|LegGroup { leg, .. }| {
            let is_accurate = leg.largest_tail() <= accuracy;
            leg.order == MOST && !is_accurate
        })
    }

    /// The largest entry of an acceleration or a third vector.
    pub(crate) fn largest_derivative(&self) -> f64 {
        let derivatives = self
            .groups
            .iter()
            .map(|group| group.leg.largest_derivative());
        derivatives.fold(0.0, larger)
    }

    /// Truncation error of the current series, estimated from their last terms.
    pub(crate) fn tail(&self) -> f64 {
        let groups = self.groups.iter();
        groups.fold(0.0, |tail, group| larger(tail, group.leg.largest_tail()))
    }

    /// Writes the velocities, and `x'` and `x''` at the starts of the legs.
    pub(crate) fn write(&self, velocities: &mut [f64], derivatives: &mut [f64]) {
        let d = self.space.dim();
        velocities.copy_from_slice(&self.velocities);
        for (i, derivative) in derivatives.chunks_exact_mut(2 * d).enumerate() {
            let (leg, lane) = (self.leg(i), i % T::COUNT);
            let vectors = leg.accelerations[0].iter().chain(&*leg.thirds[0]);
            for (derivative, x) in derivative.iter_mut().zip(vectors) {
                *derivative = x.lane(lane);
            }
        }
    }

    /// Number of products for evaluating the equations of the legs with their current series.
    pub(crate) fn products_of_series(&self) -> f64 {
        let pair = products_of_pair(self.space);
        let orders = self.groups.iter().map(|group| group.leg.order as f64);
        orders
            .map(|order| 0.5 * T::COUNT as f64 * order * order * pair)
            .sum()
    }

    /// Number of products for setting up the derivative of the equations.
    pub(crate) fn products_of_derivative(&self) -> f64 {
        let [d, r] = [self.space.dim(), self.space.size()].map(|size| size as f64);
        let columns = 3.0 * d;
        let stale = self.groups.iter().filter(|group| group.progress.is_stale);
        let products = stale.map(|LegGroup { leg, .. }| {
            let terms = terms(self.space, leg) as f64;
            let series = columns * 0.5 * terms * terms * 8.0 * r * d;
            T::COUNT as f64 * (series + columns.powi(3))
        });
        products.sum()
    }
}

/// The system for the changes of the velocities, with the rows of given velocities.
fn system(d: usize, knots: &Knots<'_>) -> BlockTridiagonal {
    let mut system = BlockTridiagonal::zeros(knots.count(), d);
    for knot in (0..knots.count()).filter(|knot| knots.is_fixed(*knot)) {
        let [_, diagonal, _] = system.row_mut(knot);
        for p in 0..d {
            diagonal[p * d + p] = 1.0;
        }
    }
    system
}

/// Number of terms of the derivatives of a leg or a group of legs. If tension lets velocities grow as `e^7` along a
/// leg, four terms are meaningless.
#[inline(always)]
pub(crate) fn terms<T: Field>(space: impl Homogeneous, leg: &SeriesLeg<'_, T>) -> usize {
    match leg.tension {
        Some(_) => MORE_TERMS,
        None if is_of_rotations(space) => terms_of_rotations(leg.speed()),
        None => TERMS,
    }
}

/// The largest number of [`terms`] in a chain.
fn most_terms(space: impl Homogeneous, knots: &Knots<'_>) -> usize {
    match knots.tension == 0.0 {
        false => MORE_TERMS,
        true if is_of_rotations(space) => MOST_TERMS_OF_ROTATIONS,
        true => TERMS,
    }
}
