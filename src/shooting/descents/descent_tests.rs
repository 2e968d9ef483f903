//! The cost as a function of the knots: derivatives compared with differences, and results of descents.

use super::chain_knots::ChainKnots;
use super::free_chain::FreeChain;
use super::layout::{ChainLayout, Held};
use crate::interrupt::Interrupt;
use crate::legs::{Options, Progress};
use crate::linalg::field::{Field, multiply};
use crate::linalg::lanes::Lanes;
use crate::report::StopReason;
use crate::space::{ComplexSpace, FixedFrames, Homogeneous, Quotient, RealSpace, orthonormalise};

const LEGS: usize = 5;

/// Pseudorandom numbers between -1 and 1.
fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64) / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn room<T: Field, S: Homogeneous>(space: S) -> Vec<T> {
    vec![T::ZERO; FreeChain::<T, S>::len(space, LEGS)]
}

/// The layout of a spline: legs of different lengths, fixed points, a given acceleration and a given velocity.
fn of_spline(d: usize) -> ChainLayout {
    ChainLayout {
        lengths: vec![1.0, 0.7, 1.3, 1.1, 0.9],
        held: vec![
            Held::Point,
            Held::Nothing,
            Held::Point,
            Held::Nothing,
            Held::Nothing,
            Held::All,
        ],
        is_closed: false,
        accelerations: [numbers(d, 17), Vec::new()],
    }
}

/// The layout of a closed spline.
fn closed() -> ChainLayout {
    let mut held = vec![Held::Nothing; LEGS + 1];
    (held[0], held[2], held[LEGS]) = (Held::Point, Held::Point, Held::Point);
    ChainLayout {
        lengths: vec![1.0, 0.7, 1.3, 1.1, 0.9],
        held,
        is_closed: true,
        accelerations: [Vec::new(), Vec::new()],
    }
}

/// A random walk of knots, starting at the identity.
fn chain<'a, T: Field, S: Homogeneous>(
    space: S,
    layout: ChainLayout,
    tension: f64,
    room: &'a mut [T],
) -> FreeChain<'a, T, S> {
    let (d, r) = (space.dim(), space.size());
    let mut frames: Vec<f64> = (0..LEGS + 1)
        .flat_map(|_| (0..r * r).map(|i| f64::from(u8::from(i % (r + 1) == 0))))
        .collect();
    let steps = numbers(LEGS * d, 3);
    let mut shift = vec![0.0; d];
    for (knot, step) in steps.chunks_exact(d).enumerate() {
        for (shift, step) in shift.iter_mut().zip(step) {
            *shift += 0.4 * step;
        }
        super::free_chain::move_frame(space, &mut frames[(knot + 1) * r * r..][..r * r], &shift);
    }
    let mut velocities: Vec<f64> = numbers((LEGS + 1) * d, 5).iter().map(|v| 0.3 * v).collect();
    if layout.is_closed {
        frames.copy_within(..r * r, LEGS * r * r);
        velocities.copy_within(..d, LEGS * d);
    }
    let knots = ChainKnots { frames, velocities };
    FreeChain::new(space, knots, layout, tension, room)
}

/// Corrects legs until they meet their ends to round-off.
fn meet<T: Field, S: Homogeneous>(chain: &mut FreeChain<'_, T, S>) {
    for _ in 0..8 {
        chain.evaluate();
        chain.linearise();
        chain.correct();
    }
    chain.evaluate();
    assert!(chain.defect < 1e-13, "{:e}", chain.defect);
}

/// Cost and gradient after moving the knots.
fn moved<T: Field, S: Homogeneous>(
    chain: &mut FreeChain<'_, T, S>,
    direction: &[f64],
    t: f64,
) -> (f64, Vec<f64>) {
    let before = chain.state.clone();
    let step: Vec<f64> = direction.iter().map(|x| t * x).collect();
    chain.follow(&step);
    meet(chain);
    chain.set_forces();
    let found = (chain.cost, chain.gradient());
    chain.state = before;
    chain.set_knots();
    found
}

fn check_derivatives<T: Field, S: Homogeneous>(space: S) {
    // Legs with a stiffness of e^1.8, and without tension.
    for tension in [0.0, 2.0] {
        let layouts = [
            ChainLayout::between_ends(LEGS),
            of_spline(space.dim()),
            closed(),
        ];
        for layout in layouts {
            check_derivatives_of::<T, S>(space, layout, tension);
        }
    }
}

/// A direction in which the knots may move.
fn direction(layout: &ChainLayout, d: usize) -> Vec<f64> {
    let mut direction = numbers(layout.count() * 2 * d, 11);
    for (block, x) in direction.chunks_exact_mut(2 * d).enumerate() {
        if layout.held[layout.knot(block)] == Held::Point {
            x[..d].fill(0.0);
        }
    }
    direction
}

fn check_derivatives_of<T: Field, S: Homogeneous>(space: S, layout: ChainLayout, tension: f64) {
    let d = space.dim();
    let direction = direction(&layout, d);
    let mut room = room::<T, S>(space);
    let mut chain = chain::<T, S>(space, layout, tension, &mut room);
    meet(&mut chain);
    chain.set_forces();
    let gradient = chain.gradient();
    let step = 1e-4;
    let [up, down] = [step, -step].map(|t| moved(&mut chain, &direction, t).0);
    let slope: f64 = gradient.iter().zip(&direction).map(|(g, x)| g * x).sum();
    let difference = (up - down) / (2.0 * step);
    // Third derivatives of a cost of about 1, times 1e-8.
    let error = (slope - difference).abs();
    assert!(
        error < 1e-6,
        "({}, {d}): {slope} {difference}",
        space.size()
    );

    assert_eq!(descend(&mut chain), StopReason::Converged);
    meet(&mut chain);
    let [exact, _] = chain.second_derivatives();
    let product = exact.form(&direction);
    let [up, down] = [step, -step].map(|t| moved(&mut chain, &direction, t).1);
    let pairs = up.iter().zip(&down).zip(&direction);
    let difference: f64 = pairs.map(|((a, b), x)| (a - b) * x).sum::<f64>() / (2.0 * step);
    // The derivative of nine terms of the series.
    let error = (product - difference).abs();
    assert!(
        error < 1e-2 * product.abs(),
        "({}, {d}): {product} {difference}",
        space.size()
    );
}

fn descend<T: Field, S: Homogeneous>(chain: &mut FreeChain<'_, T, S>) -> StopReason {
    descend_beside(chain, &[])
}

fn descend_beside<T: Field, S: Homogeneous>(
    chain: &mut FreeChain<'_, T, S>,
    known: &[&ChainKnots],
) -> StopReason {
    chain
        .descend(
            &mut Progress::new(1e-12),
            (f64::INFINITY, known),
            &options(),
        )
        .expect("nobody interrupts")
}

fn options<'a>() -> Options<'a> {
    Options {
        tolerance: 1e-12,
        max_iterations: 60,
        may_go_on: &|_| true,
        interrupt: Interrupt::NEVER,
    }
}

#[test]
fn gradient_and_second_derivative_are_those_of_the_cost() {
    check_derivatives::<Lanes, _>(FixedFrames::<3, 1>);
    check_derivatives::<Lanes, _>(FixedFrames::<3, 2>);
    check_derivatives::<f64, _>(RealSpace::frames(3, 3));
    check_derivatives::<Lanes, _>(RealSpace::frames(4, 2));
    check_derivatives::<f64, _>(RealSpace::frames(5, 2));
    check_derivatives::<Lanes, _>(RealSpace::frames(4, 4));
    for (r, k, quotient) in [
        (2, 2, Quotient::Frames),
        (4, 2, Quotient::Frames),
        (4, 2, Quotient::Subspaces),
        (6, 2, Quotient::Frames),
        (8, 4, Quotient::Subspaces),
    ] {
        check_derivatives::<Lanes, _>(ComplexSpace { r, k, quotient });
    }
}

#[test]
fn jumps_of_the_third_vector_vanish_where_a_descent_ends() {
    let space = RealSpace::frames(5, 2);
    let mut room = room::<f64, _>(space);
    let mut chain = chain::<f64, _>(space, ChainLayout::between_ends(LEGS), 0.0, &mut room);
    assert_eq!(descend(&mut chain), StopReason::Converged);
    chain.set_forces();
    let most = chain.gradient().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(most < 1e-12, "{most:e}");
    let cost = chain.cost;
    meet(&mut chain);
    let again = chain.cost;
    assert!((cost - again).abs() < 1e-12 * cost, "{cost} {again}");
}

/// Newton's method leads back to a stationary chain in few steps, and to round-off.
#[test]
fn a_chain_settles_at_the_nearest_stationary_one() {
    for layout in [of_spline as fn(usize) -> ChainLayout, |_| closed()] {
        let space = RealSpace::frames(5, 2);
        let mut room = room::<Lanes, _>(space);
        let mut chain = chain::<Lanes, _>(space, layout(space.dim()), 0.0, &mut room);
        assert_eq!(descend(&mut chain), StopReason::Converged);
        let known = chain.state.knots.clone();
        let size = chain.gradient().len();
        let step: Vec<f64> = numbers(size, 11).iter().map(|x| 0.02 * x).collect();
        let held: Vec<f64> = {
            let d = space.dim();
            let is_held = |i: usize| {
                chain.layout.held[chain.layout.knot(i / (2 * d))] == Held::Point && i % (2 * d) < d
            };
            let moved = step.iter().enumerate();
            moved
                .map(|(i, x)| if is_held(i) { 0.0 } else { *x })
                .collect()
        };
        chain.follow(&held);
        assert!(chain.state.knots.difference(space, &known)[0] > 0.01);
        let mut progress = Progress::new(1e-12);
        let reason = chain
            .settle(&mut progress, &options())
            .expect("nobody interrupts");
        assert_eq!(reason, StopReason::Converged);
        let report = progress.report(reason);
        assert!(
            report.iterations <= 6 && report.residual < 1e-13,
            "{report:?}"
        );
        let [away, _] = chain.state.knots.difference(space, &known);
        assert!(away < 1e-11, "{away:e}");
    }
}

#[test]
fn the_last_lanes_of_a_group_count_once() {
    // Five legs: in one group of eight, and in five groups of one.
    let space = FixedFrames::<3, 2>;
    let (mut wide, mut narrow) = (room::<Lanes, _>(space), room::<f64, _>(space));
    let mut chains = (
        chain::<Lanes, _>(space, of_spline(space.dim()), 0.0, &mut wide),
        chain::<f64, _>(space, of_spline(space.dim()), 0.0, &mut narrow),
    );
    assert_eq!(descend(&mut chains.0), StopReason::Converged);
    assert_eq!(descend(&mut chains.1), StopReason::Converged);
    let (cost, other) = (chains.0.cost, chains.1.cost);
    assert!((cost - other).abs() < 1e-12 * cost.abs(), "{cost} {other}");
    for leg in 0..LEGS {
        for (a, b) in chains
            .0
            .derivatives(leg)
            .iter()
            .zip(&chains.1.derivatives(leg))
        {
            assert!((a - b).abs() < 1e-9 * cost.abs().sqrt(), "{a} {b}");
        }
    }
}

/// Turns the frame of a knot by an element of `H`.
fn turned(space: impl Homogeneous, knots: &ChainKnots, knot: usize) -> ChainKnots {
    let (d, r) = (space.dim(), space.size());
    let mut knots = knots.clone();
    let frame = &mut knots.frames[knot * r * r..][..r * r];
    let mut q = vec![0.0; r * r];
    space.isotropy_part_into(frame, &mut q);
    if space.isotropy_dim() > 0 {
        // The part of a distant frame is far from orthogonal.
        for _ in 0..4 {
            orthonormalise(r, &mut q, &mut vec![0.0; 2 * r * r]);
        }
    }
    let before = frame.to_vec();
    multiply(r, &before, &q, frame);
    let velocity = &mut knots.velocities[knot * d..][..d];
    let before = velocity.to_vec();
    space.turn_back_into(&q, &before, velocity);
    knots
}

fn check_nearness<S: Homogeneous>(space: S) {
    let (d, r) = (space.dim(), space.size());
    let mut room = room::<f64, _>(space);
    let chain = chain::<f64, _>(space, ChainLayout::between_ends(LEGS), 0.0, &mut room);
    let knots = &chain.state.knots;
    // The frame of a point is not unique.
    let [largest, energy] = knots.difference(space, &turned(space, knots, 2));
    assert!(largest < 1e-13 && energy < 1e-24, "{largest:e} {energy:e}");
    for size in [1e-3, 0.3, 0.45, 0.55, 1.0] {
        let mut moved = knots.clone();
        let mut p = vec![0.0; d];
        p[d - 1] = size;
        super::free_chain::move_frame(space, &mut moved.frames[2 * r * r..][..r * r], &p);
        assert_eq!(knots.is_near(space, &moved), size < 0.5);
        if size > 0.5 {
            continue;
        }
        let [largest, energy] = knots.difference(space, &turned(space, &moved, 2));
        let sine = size.sin();
        assert!((largest - sine).abs() < 1e-12, "{largest} {sine}");
        // Of two beams that meet in the knot.
        assert!(
            (energy / (12.0 * sine * sine) - 1.0).abs() < 1e-11,
            "{energy}"
        );
        let mut faster = knots.clone();
        faster.velocities[3 * d - 1] += size;
        let [largest, energy] = knots.difference(space, &faster);
        assert!((largest - size).abs() < 1e-12, "{largest}");
        assert!(
            (energy / (4.0 * size * size) - 1.0).abs() < 1e-11,
            "{energy}"
        );
    }
    // Three knots move by less than half a radian, in turns: stiff.
    let mut bent = knots.clone();
    for (knot, size) in [(1, 0.4), (2, -0.4), (3, 0.4)] {
        let mut p = vec![0.0; d];
        p[0] = size;
        super::free_chain::move_frame(space, &mut bent.frames[knot * r * r..][..r * r], &p);
    }
    assert!(!knots.is_near(space, &bent));
    // Another number of legs.
    bent.velocities.truncate(LEGS * d);
    assert!(!knots.is_near(space, &bent));
}

#[test]
fn chains_are_near_if_points_and_velocities_are() {
    check_nearness(FixedFrames::<3, 1>);
    check_nearness(FixedFrames::<3, 2>);
    check_nearness(RealSpace::frames(5, 2));
    check_nearness(RealSpace::frames(4, 4));
    let complex = ComplexSpace {
        r: 6,
        k: 4,
        quotient: Quotient::Frames,
    };
    check_nearness(complex);
}

#[test]
fn a_descent_stops_near_a_known_end() {
    let space = RealSpace::frames(5, 2);
    let rooms = [(); 2].map(|()| room::<f64, _>(space));
    let [mut first, mut second] = rooms;
    let mut first = chain::<f64, _>(space, ChainLayout::between_ends(LEGS), 0.0, &mut first);
    assert_eq!(descend(&mut first), StopReason::Converged);
    let mut second = chain::<f64, _>(space, ChainLayout::between_ends(LEGS), 0.0, &mut second);
    let known = &first.state.knots;
    assert!(!known.is_near(space, &second.state.knots));
    assert_eq!(descend_beside(&mut second, &[known]), StopReason::Stagnated);
    assert!(known.is_near(space, &second.state.knots));
}
