//! Many boundary problems at once.

use std::sync::atomic::{AtomicUsize, Ordering};

use faer::{Mat, MatRef};
use stiefel_rs::cubic::{
    BoundaryOptions, BoundarySolution, RiemannianCubic, SearchOptions, solve_boundary,
};
use stiefel_rs::{Curve, Error, Interrupt};

use crate::common::{Rng, random_point};
use crate::derivative::vector;
use crate::{SHAPES, boundary_options, search_options, view};

fn problems((n, k): (usize, usize), count: usize, rng: &mut Rng) -> Vec<[Mat<f64>; 4]> {
    let one = |_| {
        let [y0, y1] = [(); 2].map(|()| random_point(n, k, rng));
        let [v0, v1] = [&y0, &y1].map(|y| vector(y, 1.0, rng));
        [y0, v0, y1, v1]
    };
    (0..count).map(one).collect()
}

fn views(problems: &[[Mat<f64>; 4]]) -> Vec<[MatRef<'_, f64>; 4]> {
    problems
        .iter()
        .map(|data| data.each_ref().map(view))
        .collect()
}

/// Bit patterns.
fn bits(solution: &BoundarySolution) -> Vec<u64> {
    let matrices = [&solution.acceleration, &solution.jerk];
    let entries = matrices
        .into_iter()
        .flat_map(|a| a.col_iter())
        .flat_map(|c| c.iter());
    let numbers = [solution.cost, solution.residual];
    entries.chain(&numbers).map(|x| x.to_bits()).collect()
}

#[test]
fn each_is_the_one_that_is_solved_alone_on_any_number_of_threads() {
    let mut rng = Rng::new(71);
    let options = boundary_options();
    for shape in SHAPES {
        let problems = problems(shape, 12, &mut rng);
        let found: Vec<Vec<Vec<u64>>> = [1, 2, 3]
            .map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let found = pool.build().unwrap().install(|| {
                    solve_boundary(&views(&problems), &options, Interrupt::NEVER).unwrap()
                });
                found
                    .iter()
                    .map(|one| bits(one.as_ref().unwrap()))
                    .collect()
            })
            .to_vec();
        assert_eq!(found[0], found[1], "{shape:?}");
        assert_eq!(found[0], found[2], "{shape:?}");
        for (found, data) in found[0].iter().zip(views(&problems)) {
            let [y0, v0, y1, v1] = data;
            let curve =
                RiemannianCubic::from_boundary(y0, v0, y1, v1, &options, Interrupt::NEVER).unwrap();
            let [_, _, acceleration, jerk] = curve.initial().unwrap();
            let alone = BoundarySolution {
                acceleration,
                jerk,
                cost: curve.cost(Interrupt::NEVER).unwrap(),
                residual: curve.report().unwrap().residual,
            };
            assert_eq!(*found, bits(&alone), "{shape:?}");
            assert!(alone.residual <= 1e-12);
        }
    }
}

#[test]
fn errors_are_those_of_their_problems() {
    let mut rng = Rng::new(72);
    let mut problems = problems((4, 2), 4, &mut rng);
    let e = Mat::<f64>::identity(4, 4);
    let rest = Mat::zeros(4, 2);
    let [first, last] = [0, 2].map(|j| e.as_ref().subcols(j, 2).to_owned());
    problems[1] = [first.clone(), rest.clone(), last, rest];
    problems[2][1] = first;
    let found = solve_boundary(&views(&problems), &boundary_options(), Interrupt::NEVER).unwrap();
    assert!(found[0].is_ok() && found[3].is_ok());
    assert!(matches!(found[1], Err(Error::RightAngle { .. })));
    assert!(matches!(
        found[2],
        Err(Error::NotHorizontal { name: "V0", .. })
    ));
    assert!(
        solve_boundary(&[], &boundary_options(), Interrupt::NEVER)
            .unwrap()
            .is_empty()
    );
    let options = BoundaryOptions {
        tolerance: 1.0,
        ..boundary_options()
    };
    let error = solve_boundary(&views(&problems), &options, Interrupt::NEVER);
    assert!(matches!(
        error,
        Err(Error::InvalidArgument {
            name: "tolerance",
            ..
        })
    ));
}

#[test]
fn the_whole_space_and_permuted_coordinate_columns() {
    let mut rng = Rng::new(73);
    let rest = Mat::zeros(4, 4);
    let [first, last] = [(); 2].map(|()| random_point(4, 4, &mut rng));
    let whole = [[first, rest.clone(), last, rest]];
    let y0 = Mat::<f64>::identity(4, 4).subcols(0, 2).to_owned();
    let swapped = Mat::from_fn(4, 2, |i, j| y0[(i, 1 - j)]);
    let rest = Mat::zeros(4, 2);
    let still = [[y0, rest.clone(), swapped, rest]];
    for problems in [whole, still] {
        let found = solve_boundary(&views(&problems), &boundary_options(), Interrupt::NEVER);
        let solution = found.unwrap().remove(0).unwrap();
        assert!(solution.cost <= 1e-20 && solution.acceleration.norm_l2() <= 1e-10);
    }
}

/// At every poll: batches, guesses and searches stop.
#[test]
fn interrupts_end_everything() {
    let mut rng = Rng::new(74);
    let problems = problems((4, 2), 3, &mut rng);
    let guess = Mat::zeros(4, 2);
    for last in [0, 1, 5, 20] {
        let count = AtomicUsize::new(0);
        let stop = || count.fetch_add(1, Ordering::Relaxed) >= last;
        let (boundary, interrupt) = (boundary_options(), Interrupt::new(&stop));
        let near = BoundaryOptions {
            guess: Some((view(&guess), view(&guess))),
            ..boundary
        };
        let search = SearchOptions {
            boundary,
            ..search_options()
        };
        let [y0, v0, y1, v1] = views(&problems)[0];
        let is_stopped = |error: Option<Error>, what: &str| {
            let asked = count.swap(0, Ordering::Relaxed);
            assert!(matches!(error, Some(Error::Interrupted { .. })), "{what}");
            // After the poll that is answered with yes, only other threads may still poll.
            assert!(asked <= last + 4, "{what}: {asked} questions");
        };
        is_stopped(
            solve_boundary(&views(&problems), &boundary, interrupt).err(),
            "batch",
        );
        // This one is solved within 20 polls.
        if last < 20 {
            is_stopped(
                RiemannianCubic::from_boundary(y0, v0, y1, v1, &near, interrupt).err(),
                "guess",
            );
        }
        is_stopped(
            RiemannianCubic::all_from_boundary(y0, v0, y1, v1, &search, interrupt).err(),
            "search",
        );
    }
}

/// Between lines the problem is solved to a unit vector of the last line and to its negative: a stop in either half is
/// not answered with the curve of the other.
#[test]
fn interrupts_end_both_halves_between_lines() {
    let mut rng = Rng::new(75);
    let problems = problems((4, 1), 1, &mut rng);
    let [y0, v0, y1, v1] = views(&problems)[0];
    let polls_until = |last: usize| {
        let count = AtomicUsize::new(0);
        let stop = || count.fetch_add(1, Ordering::Relaxed) >= last;
        let options = boundary_options();
        let interrupt = Interrupt::new(&stop);
        let found = RiemannianCubic::from_boundary(y0, v0, y1, v1, &options, interrupt);
        (found.err(), count.into_inner())
    };
    let (error, all) = polls_until(usize::MAX);
    assert!(error.is_none() && all >= 4, "{all} polls");
    for last in 0..all {
        let (error, _) = polls_until(last);
        assert!(
            matches!(error, Some(Error::Interrupted { .. })),
            "poll {last} of {all}"
        );
    }
}
