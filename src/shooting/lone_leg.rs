//! Boundary value problems whose solution is a single leg, solved one at a time or eight at once.

use std::f64::consts::SQRT_2;

use super::taylor::leg::{LegScratch, SeriesLeg};
use super::taylor::leg_equations::{residual_into, set_equations};
use super::taylor::orders::{FINEST, MOST, Orders};
use super::taylor::room::Room;
use super::taylor::variation::MiddleVariation;
use crate::linalg::field::{Field, factor, substitute};
use crate::linalg::lanes::Lanes;
use crate::solve::broyden::Updates;
use crate::solve::gmres::norm;
use crate::space::{Homogeneous, Shape, in_space};

/// Lanes with a larger residual are given up.
const HOPELESS: f64 = 10.0;

/// Residual below which the linear equations of the previous step are kept, and corrected by Broyden's updates. With
/// 0.03, 19 instead of 2 of 189 moderate problems on St(6,3), which are solved at nodes today, are not solved, and no
/// solution is found faster.
const KEEP: f64 = 1e-2;

/// Number of terms of the series of the linear equations. With twelve, problems on St(10,3), which are solved at
/// nodes today, take 1.3 times as long, with the same number of steps.
const TERMS: usize = 8;

/// Number of steps that Broyden's method stores.
const MOST_UPDATES: usize = 8;

/// End data relative to the frame at the start: the frame at the end, shape `(r, r)` in row-major order, and the
/// velocities in the frames at both ends; and the initial guess, `x, x', x''` at the middle.
pub(crate) struct EndData {
    pub(crate) target: Vec<f64>,
    pub(crate) velocities: [Vec<f64>; 2],
    pub(crate) middle: [Vec<f64>; 3],
}

impl EndData {
    /// A bound on the velocity of the initial guess, as [`SeriesLeg::speed`].
    pub(crate) fn speed(&self) -> f64 {
        let [v, a, b] = self.middle.each_ref().map(|x| norm(x));
        v + 0.5 * a + 0.125 * b
    }
}

/// A cubic on `[0, 1]` that satisfies its end data to the tolerance.
pub(crate) struct LoneLeg {
    /// `x'` and `x''` at the start.
    pub(crate) start: Vec<f64>,
    /// `int |x'|^2`.
    pub(crate) cost: f64,
    /// A bound on the residual of the end data, in the Frobenius norm.
    pub(crate) residual: f64,
    /// Number of Newton steps.
    pub(crate) steps: usize,
}

/// Solves up to eight problems to a tolerance, with a maximal number of steps.
pub(crate) type Solve = dyn FnMut(&[EndData], f64, usize) -> Vec<Option<LoneLeg>>;

/// A solver for problems in a space, eight at once.
pub(crate) fn lone_legs(shape: Shape) -> Box<Solve> {
    in_space!(shape, |space| solver::<Lanes>(space))
}

/// A solver for one problem at a time.
pub(crate) fn lone_leg(shape: Shape) -> Box<Solve> {
    in_space!(shape, |space| solver::<f64>(space))
}

fn solver<T: Field>(space: impl Homogeneous + 'static) -> Box<Solve> {
    let mut legs = LoneLegs::<T, _>::new(space);
    Box::new(move |problems, tolerance, steps| legs.solve(problems, tolerance, steps))
}

/// Buffers of a group.
struct LoneLegs<T: Field, S> {
    space: S,
    room: Vec<T>,
    scratch: LegScratch<T>,
    variation: MiddleVariation<T>,
    matrix: Vec<T>,
    right: Vec<T>,
    updates: Updates<T>,
}

impl<T: Field, S: Homogeneous> LoneLegs<T, S> {
    fn new(space: S) -> Self {
        let wide = 3 * space.dim();
        LoneLegs {
            space,
            room: vec![T::ZERO; SeriesLeg::<T>::len(space)],
            scratch: LegScratch::new(space, MOST),
            variation: MiddleVariation::new(space, 1, TERMS),
            matrix: vec![T::ZERO; wide * wide],
            right: vec![T::ZERO; wide],
            updates: Updates::new(MOST_UPDATES),
        }
    }

    /// One solution per problem, for at most as many problems as lanes; `None` if Newton's method does not converge
    /// within the given number of steps, or if one series is not enough.
    fn solve(
        &mut self,
        problems: &[EndData],
        tolerance: f64,
        steps: usize,
    ) -> Vec<Option<LoneLeg>> {
        self.space.vectorised(
            #[inline(always)]
            || self.solve_lanes(problems, tolerance, steps),
        )
    }

    #[inline(always)]
    fn solve_lanes(
        &mut self,
        problems: &[EndData],
        tolerance: f64,
        steps: usize,
    ) -> Vec<Option<LoneLeg>> {
        let LoneLegs {
            space,
            room,
            scratch,
            variation,
            matrix,
            right,
            updates,
        } = self;
        let (space, mut orders) = (*space, Orders::first());
        let mut leg = SeriesLeg::new(space, &mut Room::new(room));
        set_data(&mut leg, problems);
        let mut residuals = vec![0.0; T::COUNT];
        let mut is_lost = vec![false; T::COUNT];
        let (mut has_equations, mut taken) = (false, 0);
        for step in 0..=steps {
            taken = step;
            leg.order = orders.of_leg(leg.speed(), leg.more);
            leg.set_residual(space, scratch);
            leg.more = orders.more(leg.more, leg.largest_tail());
            let mut left = 0.0_f64;
            for lane in 0..T::COUNT {
                residuals[lane] = SQRT_2 * leg.residual.norm(lane);
                if is_lost[lane] {
                    continue;
                }
                if residuals[lane] > HOPELESS || residuals[lane].is_nan() {
                    is_lost[lane] = true;
                } else if residuals[lane] > tolerance || leg.residual.tail.lane(lane) > FINEST {
                    left = left.max(residuals[lane]).max(f64::MIN_POSITIVE);
                }
            }
            if left == 0.0 || step == steps {
                break;
            }
            if !has_equations || left > KEEP {
                let terms = TERMS.min(leg.order);
                set_equations(space, &leg, terms, scratch, variation, matrix);
                factor(3 * space.dim(), matrix);
                has_equations = true;
                updates.clear();
            }
            residual_into(&leg, right);
            substitute(3 * space.dim(), matrix, 1, right);
            for x in &mut *right {
                *x = -*x;
            }
            updates.correct(right);
            let changes = right.chunks_exact(space.dim());
            for (x, change) in leg.middle.iter_mut().zip(changes) {
                for (x, change) in x.iter_mut().zip(change) {
                    *x += *change;
                }
            }
            // Lost lanes have steps that are not finite.
            for lane in (0..T::COUNT).filter(|&lane| is_lost[lane]) {
                stop(&mut leg, lane);
            }
            orders = match left > tolerance {
                true => Orders::after(left),
                false => Orders::finest(),
            };
        }
        let cost = integral_of_square(
            space.dim(),
            &scratch.series.x[..(leg.order + 3) * space.dim()],
        );
        let solution = |lane: usize| {
            let is_found = !is_lost[lane]
                && residuals[lane] <= tolerance
                && leg.residual.tail.lane(lane) <= FINEST;
            let start = [&leg.accelerations[0], &leg.thirds[0]];
            is_found.then(|| LoneLeg {
                start: start
                    .iter()
                    .flat_map(|x| x.iter().map(|x| x.lane(lane)))
                    .collect(),
                cost: cost.lane(lane),
                residual: residuals[lane],
                steps: taken,
            })
        };
        (0..problems.len()).map(solution).collect()
    }
}

/// Assigns one problem to each lane, and the last one to unused lanes.
#[inline(always)]
fn set_data<T: Field>(leg: &mut SeriesLeg<'_, T>, problems: &[EndData]) {
    for lane in 0..T::COUNT {
        let EndData {
            target,
            velocities: [first, last],
            middle,
        } = &problems[lane.min(problems.len() - 1)];
        let set = |to: &mut [T], from: &[f64]| {
            for (to, from) in to.iter_mut().zip(from) {
                to.set_lane(lane, *from);
            }
        };
        set(leg.target, target);
        set(leg.velocity, first);
        set(leg.last_velocity, last);
        for (to, from) in leg.middle.iter_mut().zip(middle) {
            set(to, from);
        }
    }
}

/// Makes a lane rest, so that it does not require more terms.
#[inline(always)]
fn stop<T: Field>(leg: &mut SeriesLeg<'_, T>, lane: usize) {
    for x in leg.middle.iter_mut().flat_map(|x| x.iter_mut()) {
        x.set_lane(lane, 0.0);
    }
}

/// `int |x'|^2` over `[-1/2, 1/2]` for a series with vectors of size `d`.
#[inline(always)]
fn integral_of_square<T: Field>(d: usize, x: &[T]) -> T {
    let count = x.len() / d;
    let mut sum = T::ZERO;
    for i in 1..count {
        for j in (2 - i % 2..i).step_by(2).chain([i]) {
            let twice = if i == j { 1.0 } else { 2.0 };
            let power = (i + j - 2) as i32;
            let factor = twice * (i * j) as f64 * 0.5_f64.powi(power) / f64::from(power + 1);
            for p in 0..d {
                sum += x[i * d + p] * x[j * d + p] * factor;
            }
        }
    }
    sum
}
