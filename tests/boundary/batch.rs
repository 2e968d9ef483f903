//! Batches of problems: each solution is the one found alone, with bad problems among good ones, for any number of
//! threads.

use faer::{Mat, MatRef};
use stiefel_rs::cubic::{BoundaryOptions, BoundarySolution, solve_boundary};
use stiefel_rs::{Curve, Error, Interrupt, Result};

use crate::common::{Rng, assert_within, random_point};
use crate::data::Data;

fn views(data: &Data) -> [MatRef<'_, f64>; 4] {
    [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref())
}

fn solved(data: &[Data]) -> Vec<Result<BoundarySolution>> {
    let problems: Vec<_> = data.iter().map(views).collect();
    solve_boundary(&problems, &BoundaryOptions::default(), Interrupt::NEVER)
        .expect("the options are good")
}

#[test]
fn a_batch_has_the_solutions_of_single_problems() {
    let mut rng = Rng::new(71);
    // Incomplete groups; distant problems among near ones; k = n; more dimensions than the data span.
    for (n, k) in [
        (2, 1),
        (3, 1),
        (3, 2),
        (3, 3),
        (4, 2),
        (5, 2),
        (6, 3),
        (30, 2),
    ] {
        let far = |i: usize| if i % 5 == 4 { (2.8, 5.0) } else { (2.0, 2.0) };
        let data: Vec<Data> = (0..21)
            .map(|i| Data::random((n, k), far(i).0, far(i).1, &mut rng))
            .collect();
        for (data, solution) in data.iter().zip(solved(&data)) {
            let (curve, solution) = (data.solve().unwrap(), solution.unwrap());
            // Residuals of 1e-12, carried to the start.
            for (name, found, exact) in [
                (
                    "acceleration",
                    &solution.acceleration,
                    curve.acceleration(0.0),
                ),
                ("jerk", &solution.jerk, curve.jerk(0.0)),
            ] {
                let exact = exact.unwrap();
                let error = (found - &exact).norm_l2() / (1.0 + exact.norm_l2());
                assert_within(error, 1e-10, &format!("{name} on St({n}, {k})"));
            }
            let cost = curve.cost(Interrupt::NEVER).unwrap();
            let error = (solution.cost - cost).abs() / (1.0 + cost);
            assert_within(error, 1e-10, &format!("cost on St({n}, {k})"));
            assert!(solution.residual <= 1e-12, "{:e}", solution.residual);
        }
    }
}

#[test]
fn special_data_in_a_batch() {
    // Equal points at rest, a quarter turn at rest, opposite points; coordinate columns.
    let axes = |i: usize, sign: f64| Mat::from_fn(3, 1, |row, _| if row == i { sign } else { 0.0 });
    let rest = Mat::zeros(3, 1);
    let data: Vec<Data> = [axes(0, 1.0), axes(1, 1.0), axes(0, -1.0)]
        .map(|s1| Data {
            s0: axes(0, 1.0),
            v0: rest.clone(),
            s1,
            v1: rest.clone(),
        })
        .into();
    let quarter = std::f64::consts::FRAC_PI_2;
    for (solution, angle) in solved(&data).into_iter().zip([0.0, quarter, 2.0 * quarter]) {
        let solution = solution.unwrap();
        let error = (solution.cost - 12.0 * angle * angle).abs();
        assert_within(error, 1e-10, &format!("cost of a turn by {angle}"));
    }
    assert!(solved(&[]).is_empty());
}

#[test]
fn shapes_may_differ() {
    let mut rng = Rng::new(75);
    let data: Vec<Data> = [(3, 1), (4, 2), (3, 1), (5, 5), (4, 2)]
        .map(|shape| Data::random(shape, 1.5, 1.5, &mut rng))
        .into();
    for (data, solution) in data.iter().zip(solved(&data)) {
        let cost = data.solve().unwrap().cost(Interrupt::NEVER).unwrap();
        assert_within((solution.unwrap().cost / cost - 1.0).abs(), 1e-10, "cost");
    }
}

#[test]
fn a_bad_problem_does_not_harm_the_others() {
    let mut rng = Rng::new(72);
    let mut data: Vec<Data> = (0..9)
        .map(|_| Data::random((4, 2), 1.0, 1.0, &mut rng))
        .collect();
    let good: Vec<f64> = solved(&data).into_iter().map(|s| s.unwrap().cost).collect();
    data[3].s1[(0, 0)] = f64::NAN;
    data[5].s0 = 2.0 * random_point(4, 2, &mut rng);
    data[7].v1 = data[7].s1.clone();
    for (i, (solution, good)) in solved(&data).into_iter().zip(good).enumerate() {
        match (i, solution) {
            (3, Err(Error::NonFinite { .. }))
            | (5, Err(Error::NotOrthonormal { .. }))
            | (7, Err(Error::NotTangent { .. })) => (),
            (3 | 5 | 7, other) => panic!("problem {i}: {:?}", other.map(|s| s.cost)),
            (_, solution) => {
                let error = (solution.unwrap().cost / good - 1.0).abs();
                assert_within(error, 1e-11, &format!("cost of problem {i}"));
            }
        }
    }
    let options = BoundaryOptions {
        tolerance: 0.5,
        ..BoundaryOptions::default()
    };
    let refused = solve_boundary(&[views(&data[0])], &options, Interrupt::NEVER);
    assert!(matches!(
        refused,
        Err(Error::InvalidArgument {
            name: "tolerance",
            ..
        })
    ));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut rng = Rng::new(73);
    let data: Vec<Data> = (0..300)
        .map(|_| Data::random((3, 1), 2.5, 2.0, &mut rng))
        .collect();
    let bits = |threads: usize| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let found = pool.install(|| solved(&data));
        found
            .into_iter()
            .map(|s| s.unwrap().cost.to_bits())
            .collect()
    };
    assert_eq!(bits(1), bits(3));
}
