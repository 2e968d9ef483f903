//! A chain of legs with free knots: the curve of least cost for given conditions on the knots.

use super::chain_knots::ChainKnots;
use super::layout::{ChainLayout, Held};
use super::stiffness::{Stiffness, StiffnessScratch};
use crate::linalg::field::{Field, larger, multiply, multiply_transposed, transposed_multiply};
use crate::linalg::simd::{Buffers, each};
use crate::shooting::taylor::durations::{micros_of_derivative, micros_of_series, micros_of_step};
use crate::shooting::taylor::leg::{LegScratch, SeriesLeg};
use crate::shooting::taylor::orders::{MOST, Orders};
use crate::shooting::taylor::room::Room;
use crate::shooting::taylor::variation::{MORE_TERMS, TERMS};
use crate::space::{Homogeneous, orthonormalise};

/// The knots, and the middles of the legs.
#[derive(Clone)]
pub(crate) struct FreeChainState<T> {
    pub(crate) knots: ChainKnots,
    middles: Vec<T>,
}

/// Consecutive legs, in groups of eight.
pub(crate) struct FreeChain<'a, T: Field, S> {
    pub(crate) space: S,
    pub(crate) layout: ChainLayout,
    pub(crate) state: FreeChainState<T>,
    pub(crate) groups: Vec<FreeLegGroup<'a, T>>,
    buffers: Buffers<FreeChainBuffers<T>>,
    /// The largest residual of the equations of the legs.
    pub(crate) defect: f64,
    /// `int |x'|^2 + tau |x|^2 dt / 2` of the cubics between the knots, up to second order in the defect.
    pub(crate) own_cost: f64,
    /// The cost including the contribution of accelerations at the ends.
    pub(crate) cost: f64,
    orders: Orders,
}

/// One leg, or eight of them, with its linear equations.
pub(crate) struct FreeLegGroup<'a, T> {
    pub(crate) leg: SeriesLeg<'a, T>,
    pub(crate) stiffness: Stiffness<T>,
    /// What the gradient of the cost consists of: `x''_0, x'_0, x''_1, x'_1` of the cubics between the knots; in tension
    /// with `x'' - tau x` in place of `x''`.
    forces: Vec<T>,
    cost: T,
}

#[derive(Clone)]
struct FreeChainBuffers<T: Field> {
    leg: LegScratch<T>,
    stiffness: StiffnessScratch<T>,
}

fn buffers<T: Field>(space: impl Homogeneous, terms: usize) -> Buffers<FreeChainBuffers<T>> {
    Buffers::new(FreeChainBuffers {
        leg: LegScratch::new(space, MOST),
        stiffness: StiffnessScratch::new(space, terms),
    })
}

/// Cost of the more accurate second derivative, as a multiple of the usual one. Without it, three of ten problems
/// between opposite points on St(3,1) with speeds of 1e-4 are not solved, and none of those with 1e-6 is.
const FINE_WORK: f64 = 3.0;

/// Number of products of a step for one leg, as multiples of the square and the cube of the dimension; calibrated by
/// times on St(3,1) to St(16,4).
const SQUARES: f64 = 1000.0;
const CUBES: f64 = 30.0;
const TRIAL_CUBES: f64 = 10.0;

/// Gauss nodes on `[-1/2, 1/2]`, the nonnegative ones, and weights.
const NODES: [(f64, f64); 5] = [
    (0.074_437_169_490_815_6, 0.147_762_112_357_376_4),
    (0.216_697_697_064_623_6, 0.134_633_359_654_998_2),
    (0.339_704_784_149_512_2, 0.109_543_181_257_991_1),
    (0.432_531_683_344_492_3, 0.074_725_674_575_290_3),
    (0.486_953_264_258_585_9, 0.033_335_672_154_344_1),
];

impl<'a, T: Field, S: Homogeneous> FreeChain<'a, T, S> {
    pub(crate) fn len(space: S, legs: usize) -> usize {
        legs.div_ceil(T::COUNT) * SeriesLeg::<T>::len(space)
    }

    /// Built from the knots, for curves with a tension.
    pub(crate) fn new(
        space: S,
        knots: ChainKnots,
        layout: ChainLayout,
        tension: f64,
        room: &'a mut [T],
    ) -> Self {
        let mut room = Room::new(room);
        let d = space.dim();
        let groups = layout.legs().div_ceil(T::COUNT);
        let mut chain = FreeChain {
            space,
            layout,
            state: FreeChainState {
                knots,
                middles: vec![T::ZERO; groups * 3 * d],
            },
            groups: (0..groups)
                .map(|_| FreeLegGroup {
                    leg: SeriesLeg::new(space, &mut room),
                    stiffness: Stiffness::new(space),
                    forces: vec![T::ZERO; 4 * d],
                    cost: T::ZERO,
                })
                .collect(),
            buffers: buffers(space, TERMS),
            defect: f64::INFINITY,
            own_cost: f64::INFINITY,
            cost: f64::INFINITY,
            orders: Orders::last(),
        };
        if tension != 0.0 {
            chain.set_tension(tension);
        }
        chain.set_knots();
        chain.set_flat_middles();
        chain
    }

    /// Sets the tension in the time of the legs.
    fn set_tension(&mut self, tension: f64) {
        for group in 0..self.groups.len() {
            let mut tensions = T::ZERO;
            for lane in 0..T::COUNT {
                let h = self.layout.lengths[self.leg_in(group, lane)];
                tensions.set_lane(lane, tension * h * h);
            }
            self.groups[group].leg.tension = Some(tensions);
        }
    }

    /// Whether the second derivative uses more terms, with an error of 1e-10 instead of a percent.
    pub(crate) fn is_fine(&self) -> bool {
        self.buffers.own.stiffness.terms == MORE_TERMS
    }

    /// Switches to that second derivative, and to series with as many terms as the curves need.
    pub(crate) fn refine(&mut self) {
        self.orders = Orders::last();
        self.buffers = buffers(self.space, MORE_TERMS);
    }

    /// Chooses series for a gradient of the given tolerance. With all terms, evaluating legs takes 1.5 times as long.
    pub(crate) fn set_tolerance(&mut self, tolerance: f64) {
        self.orders = Orders::after(tolerance);
    }

    fn leg_in(&self, group: usize, lane: usize) -> usize {
        (group * T::COUNT + lane).min(self.layout.legs() - 1)
    }

    /// Sets targets and velocities of the legs from the state.
    pub(crate) fn set_knots(&mut self) {
        let (d, r) = (self.space.dim(), self.space.size());
        let square = r * r;
        let mut target = vec![0.0; square];
        for group in 0..self.groups.len() {
            for lane in 0..T::COUNT {
                let i = self.leg_in(group, lane);
                let frames = &self.state.knots.frames[i * square..];
                transposed_multiply(
                    r,
                    &frames[..square],
                    &frames[square..2 * square],
                    &mut target,
                );
                let leg = &mut self.groups[group].leg;
                for (to, x) in leg.target.iter_mut().zip(&target) {
                    to.set_lane(lane, *x);
                }
                let (h, velocities) = (
                    self.layout.lengths[i],
                    &self.state.knots.velocities[i * d..],
                );
                for p in 0..d {
                    leg.velocity[p].set_lane(lane, h * velocities[p]);
                    leg.last_velocity[p].set_lane(lane, h * velocities[d + p]);
                }
            }
        }
    }

    /// Sets the middles to those of cubics of flat space.
    fn set_flat_middles(&mut self) {
        let (space, d, r) = (self.space, self.space.dim(), self.space.size());
        for (FreeLegGroup { leg, .. }, middle) in self
            .groups
            .iter_mut()
            .zip(self.state.middles.chunks_exact_mut(3 * d))
        {
            // u = target q^T is close to the exponential of the displacement.
            let mut work = vec![T::ZERO; 2 * r * r];
            space.isotropy_part_into(leg.target, leg.holonomy);
            if space.isotropy_dim() > 0 {
                orthonormalise(r, leg.holonomy, &mut work);
            }
            let u = &mut work[..r * r];
            multiply_transposed(r, leg.target, leg.holonomy, u);
            let mut arriving = vec![T::ZERO; d];
            // Here q maps coordinates at the start to coordinates at the end, backwards.
            space.turn_into(leg.holonomy, leg.last_velocity, &mut arriving);
            space.each_entry(|p, i, j| {
                let delta = space.skew_coordinate(u, [i, j]);
                let (v, w) = (leg.velocity[p], arriving[p]);
                let [a, b] = [
                    delta * 6.0 - v * 4.0 - w * 2.0,
                    v * 6.0 + w * 6.0 - delta * 12.0,
                ];
                middle[p] = v + a * 0.5 + b * 0.125;
                middle[d + p] = a + b * 0.5;
                middle[2 * d + p] = b;
            });
        }
    }

    /// Evaluates all legs.
    pub(crate) fn evaluate(&mut self) {
        let (space, d, orders) = (self.space, self.space.dim(), self.orders);
        let middles = &self.state.middles;
        each::<S::Width, _, _>(
            &mut self.groups,
            micros_of_series(space),
            &mut self.buffers,
            #[inline(always)]
            |FreeChainBuffers { leg: scratch, .. }, group, FreeLegGroup { leg, cost, .. }| {
                let state = middles[group * 3 * d..][..3 * d].chunks_exact(d);
                for (x, from) in leg.middle.iter_mut().zip(state) {
                    x.copy_from_slice(from);
                }
                leg.order = orders.of_leg(leg.speed(), leg.more);
                leg.set_residual(space, scratch);
                leg.more = orders.more(leg.more, leg.largest_tail());
                *cost = leg_cost(leg, &scratch.series.x[..(leg.order + 3) * d]);
            },
        );
        self.defect = 0.0;
        for FreeLegGroup { leg, .. } in &self.groups {
            self.defect = larger(self.defect, leg.residual.size);
        }
        let lengths = self.layout.lengths.iter().enumerate();
        let costs = lengths.map(|(leg, h)| {
            let group = &self.groups[leg / T::COUNT];
            group.cost.lane(leg % T::COUNT) * h.powi(-3)
        });
        self.own_cost = costs.sum();
        self.cost = self.own_cost + self.layout.pull(&self.state.knots.velocities);
    }

    /// `x'` and `x''` at the start of a leg, per unit of time.
    pub(crate) fn derivatives(&self, leg: usize) -> Vec<f64> {
        let (d, rate) = (self.space.dim(), self.layout.lengths[leg].recip());
        let (group, lane) = (&self.groups[leg / T::COUNT], leg % T::COUNT);
        let tension = group.leg.tension.map_or(0.0, |tension| tension.lane(lane));
        let [third, acceleration] = [&group.forces[..d], &group.forces[d..2 * d]];
        let first = acceleration.iter().map(|x| x.lane(lane) * rate.powi(2));
        let thirds = third.iter().zip(&*group.leg.velocity);
        let second = thirds.map(|(x, v)| (x.lane(lane) + tension * v.lane(lane)) * rate.powi(3));
        first.chain(second).collect()
    }

    /// Number of products for setting up the linear equations.
    pub(crate) fn products_of_equations(&self) -> f64 {
        match self.is_fine() {
            true => FINE_WORK * products_of_step(self.space, self.layout.legs()),
            false => products_of_step(self.space, self.layout.legs()),
        }
    }

    /// Number of products for trying a step.
    pub(crate) fn products_of_trial(&self) -> f64 {
        let d = self.space.dim() as f64;
        self.layout.legs() as f64 * (0.5 * SQUARES * d.powi(2) + TRIAL_CUBES * d.powi(3))
    }

    /// The largest entry of an acceleration or a third vector.
    pub(crate) fn largest_derivative(&self) -> f64 {
        let derivatives = self
            .groups
            .iter()
            .map(|group| group.leg.largest_derivative());
        derivatives.fold(0.0, larger)
    }

    /// Takes a step that solves the equations of the legs for fixed knots, with the existing linear equations.
    pub(crate) fn correct(&mut self) {
        let z = vec![0.0; self.layout.count() * 2 * self.space.dim()];
        self.step_middles(&z);
    }

    /// Sets up the linear equations of the legs, and the forces.
    pub(crate) fn linearise(&mut self) {
        let space = self.space;
        let micros = match self.is_fine() {
            true => FINE_WORK * micros_of_derivative(space),
            false => micros_of_derivative(space),
        };
        each::<S::Width, _, _>(
            &mut self.groups,
            micros,
            &mut self.buffers,
            #[inline(always)]
            |buffers, _, group| {
                let FreeLegGroup { leg, stiffness, .. } = group;
                stiffness.set(space, leg, &mut buffers.leg, &mut buffers.stiffness);
            },
        );
    }

    /// Computes the forces from the existing linear equations.
    pub(crate) fn set_forces(&mut self) {
        let space = self.space;
        each::<S::Width, _, _>(
            &mut self.groups,
            micros_of_step(space),
            &mut Buffers::new(()),
            #[inline(always)]
            |(), _, group| {
                let FreeLegGroup {
                    leg,
                    stiffness,
                    forces,
                    ..
                } = group;
                stiffness.corrected_into(space, leg, forces);
            },
        );
    }

    /// The derivative of the cost with respect to `(p, v)` of the movable knots.
    pub(crate) fn gradient(&self) -> Vec<f64> {
        let d = self.space.dim();
        let mut gradient = vec![0.0; self.layout.count() * 2 * d];
        for (leg, h) in self.layout.lengths.iter().enumerate() {
            let (forces, lane) = (&self.groups[leg / T::COUNT].forces, leg % T::COUNT);
            for (end, knot) in [(0, leg), (1, leg + 1)] {
                let Some(block) = self.layout.block(knot) else {
                    continue;
                };
                let out = &mut gradient[block * 2 * d..][..2 * d];
                for (i, rate) in [h.powi(-3), h.powi(-2)].into_iter().enumerate() {
                    let rate = if end == i { rate } else { -rate };
                    for p in 0..d {
                        out[i * d + p] += rate * forces[(2 * end + i) * d + p].lane(lane);
                    }
                }
            }
        }
        self.layout.constrain_gradient(&mut gradient);
        gradient
    }

    /// Moves the knots by `(p, v)`, and the middles accordingly.
    pub(crate) fn follow(&mut self, step: &[f64]) {
        let (d, r) = (self.space.dim(), self.space.size());
        let square = r * r;
        self.step_middles(step);
        for (block, step) in step.chunks_exact(2 * d).enumerate() {
            let knot = self.layout.knot(block);
            let (p, v) = step.split_at(d);
            let velocity = &mut self.state.knots.velocities[knot * d..][..d];
            for (velocity, v) in velocity.iter_mut().zip(v) {
                *velocity += v;
            }
            if self.layout.held[knot] == Held::Nothing {
                let frame = &mut self.state.knots.frames[knot * square..][..square];
                move_frame(self.space, frame, p);
            }
        }
        if self.layout.is_closed {
            let last = self.layout.legs() * d;
            self.state.knots.velocities.copy_within(..d, last);
        }
        self.set_knots();
    }

    fn step_middles(&mut self, step: &[f64]) {
        let d = self.space.dim();
        let mut z = vec![T::ZERO; 4 * d];
        let mut change = vec![T::ZERO; 3 * d];
        for group in 0..self.groups.len() {
            for lane in 0..T::COUNT {
                let leg = self.leg_in(group, lane);
                let h = self.layout.lengths[leg];
                for (end, knot) in [leg, leg + 1].into_iter().enumerate() {
                    let block = self.layout.block(knot);
                    for (i, unit) in [1.0, h].into_iter().enumerate() {
                        for p in i * d..(i + 1) * d {
                            let value = block.map_or(0.0, |block| unit * step[block * 2 * d + p]);
                            z[2 * end * d + p].set_lane(lane, value);
                        }
                    }
                }
            }
            let FreeLegGroup { leg, stiffness, .. } = &self.groups[group];
            let space = self.space;
            space.vectorised(
                #[inline(always)]
                || stiffness.step_into(space, leg, &z, &mut change),
            );
            let state = &mut self.state.middles[group * 3 * d..][..3 * d];
            for (x, change) in state.iter_mut().zip(&change) {
                *x += *change;
            }
        }
    }
}

/// Number of products for the linear equations of a step with the given number of legs.
pub(crate) fn products_of_step(space: impl Homogeneous, legs: usize) -> f64 {
    let d = space.dim() as f64;
    legs as f64 * (SQUARES * d.powi(2) + CUBES * d.powi(3))
}

/// Half the integral of `|x'|^2 + tau |x|^2`, for a leg that meets its ends.
#[inline(always)]
fn leg_cost<T: Field>(leg: &SeriesLeg<'_, T>, x: &[T]) -> T {
    let d = leg.velocity.len();
    let mut cost = half_square(d, x, 1);
    if let Some(tension) = leg.tension {
        cost += half_square(d, x, 0) * tension;
    }
    let [first, last] = &leg.residual.velocities;
    for p in 0..d {
        cost += leg.accelerations[0][p] * first[p];
        cost -= leg.reached[1][p] * last[p];
        cost += leg.reached[2][p] * leg.residual.point[p];
        if let Some(tension) = leg.tension {
            cost -= tension * leg.reached[0][p] * leg.residual.point[p];
        }
    }
    cost
}

/// Half the integral of the square of `x` or `x'` over `[-1/2, 1/2]`.
#[inline(always)]
fn half_square<T: Field>(d: usize, x: &[T], derivative: usize) -> T {
    let mut sum = T::ZERO;
    for (node, weight) in NODES {
        for p in 0..d {
            let mut parts = [T::ZERO; 2];
            let mut power = 1.0;
            for (k, c) in x.chunks_exact(d).enumerate().skip(derivative) {
                let factor = if derivative == 0 {
                    power
                } else {
                    k as f64 * power
                };
                parts[(k - derivative) % 2] += c[p] * factor;
                power *= node;
            }
            let [even, odd] = parts;
            // (even - odd)^2 + (even + odd)^2, halved.
            sum += (even * even + odd * odd) * weight;
        }
    }
    sum
}

/// Maximal number of terms of the exponential series, since steps are at most one radian long; and the size of a term
/// at which it is truncated.
const EXPONENTIAL_TERMS: usize = 24;
const SMALLEST: f64 = 1e-17;

/// `frame <- frame exp(p)`.
pub(crate) fn move_frame(space: impl Homogeneous, frame: &mut [f64], p: &[f64]) {
    let r = space.size();
    let square = r * r;
    let mut scratch = vec![0.0; 5 * square];
    let (matrix, rest) = scratch.split_at_mut(square);
    let (term, rest) = rest.split_at_mut(square);
    let (product, rest) = rest.split_at_mut(square);
    space.matrix_into(p, matrix);
    term.copy_from_slice(frame);
    for k in 1..=EXPONENTIAL_TERMS {
        multiply(r, term, matrix, product);
        let mut size = 0.0_f64;
        for (term, product) in term.iter_mut().zip(&*product) {
            *term = product / k as f64;
            size = size.max(term.abs());
        }
        for (frame, term) in frame.iter_mut().zip(&*term) {
            *frame += term;
        }
        if size < SMALLEST {
            break;
        }
    }
    orthonormalise(r, frame, rest);
}
