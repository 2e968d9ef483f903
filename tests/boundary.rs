//! Riemannian cubics from boundary data: success rates, symmetries, bad data, several solutions.

mod common;
#[path = "common/boundary.rs"]
mod data;

use std::sync::atomic::{AtomicUsize, Ordering};

use common::{
    Rng, counted, distance, frobenius, random_orthogonal, random_point, random_rotation,
    random_tangent,
};
use data::*;
use faer::{Mat, mat};
use stiefel_rs::cubic::{BoundaryOptions, BoundaryStrategy, IntegrationOptions, SearchOptions};
use stiefel_rs::curve::Samples;
use stiefel_rs::{
    Curve, Error, Geodesic, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Interrupt,
    Quantity, Result, RiemannianCubic, StopReason,
};

const SHAPES: [(usize, usize); 6] = [(3, 1), (3, 2), (4, 2), (5, 2), (6, 3), (10, 3)];

#[test]
fn moderate_data_are_solved_from_the_flat_start() {
    for shape in SHAPES {
        let (mut rng, mut moderate) = (Rng::new(11), 0);
        let count = if shape.0 > 5 { 10 } else { 60 };
        for _ in 0..count {
            let data = Data::random(shape, 2.0, 2.0, &mut rng);
            let curve = data.solve().unwrap_or_else(|e| panic!("{shape:?}: {e}"));
            let report = curve.boundary_report().unwrap();
            assert!(report.solver.converged && report.solver.residual <= 1e-12);
            common::assert_within(data.defect(&curve), END, &format!("{shape:?}"));
            // Where the quasi-geodesic is longer than the distance, a curve of the other branch may cost less.
            if !data.is_moderate() {
                continue;
            }
            moderate += 1;
            assert_eq!(report.strategy, BoundaryStrategy::Direct, "{report}");
            // Newton's steps, up to 6; from 8 unknowns on Broyden's, up to 12.
            assert!(report.solver.iterations <= 12, "{shape:?}: {report}");
        }
        assert!(
            10 * moderate >= 9 * count,
            "{shape:?}: {moderate} of {count}"
        );
    }
}

#[test]
fn far_and_fast_data_are_solved() {
    for (shape, count) in [
        ((3, 1), 200),
        ((3, 2), 100),
        ((4, 2), 50),
        ((5, 2), 30),
        ((6, 3), 10),
    ] {
        let mut rng = Rng::new(12);
        let (mut failures, mut strategies) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let data = Data::random(shape, 3.0, 6.0, &mut rng);
            match data.solve() {
                Ok(curve) => {
                    common::assert_within(data.defect(&curve), END, &format!("{shape:?}"));
                    let report = curve.boundary_report().unwrap();
                    assert!(report.solver.converged && report.solver.residual <= 1e-12);
                    strategies.push(report.strategy);
                }
                Err(Error::NoConvergence { report, .. }) => failures.push(report),
                Err(error) => panic!("{shape:?}: {error}"),
            }
        }
        println!("{shape:?}: {} of {count} fail {failures:?}", failures.len());
        if shape == (3, 1) {
            // Moderate data are among them.
            for strategy in [BoundaryStrategy::Direct, BoundaryStrategy::Descent] {
                assert!(strategies.contains(&strategy), "{strategy:?}");
            }
        }
        // One in a hundred.
        assert!(100 * failures.len() <= count, "{shape:?}: {failures:?}");
    }
}

/// The curve of least cost goes round with its speed: where it would brake instead, costs were a hundred times as high.
#[test]
fn speeds_of_thirty_are_solved_from_both_ends() {
    let speed = 30.0;
    for (shape, count) in [((3, 1), 8), ((4, 1), 4), ((3, 2), 6), ((3, 3), 6)] {
        let mut rng = Rng::new(21);
        for _ in 0..count {
            let mut data = Data::random(shape, 3.0, 1.0, &mut rng);
            data.v0 = random_tangent(&data.s0, speed, &mut rng);
            data.v1 = random_tangent(&data.s1, speed, &mut rng);
            let there = data.solve().unwrap_or_else(|e| panic!("{shape:?}: {e}"));
            let cost = there.cost().unwrap();
            assert!(cost < 10.0 * speed * speed, "{shape:?}: {cost:.3e}");
            common::assert_within(data.defect(&there), speed * END, &format!("{shape:?}"));
            let back = data.reversed().solve().unwrap();
            let ratio = back.cost().unwrap() / cost;
            common::assert_within((ratio - 1.0).abs(), 1e-9, &format!("{shape:?}, reversed"));
        }
    }
}

/// Round a circle and back to the start with the same velocity: `12 (2 pi m - v)^2` for `m` turns.
#[test]
fn whole_turns_are_made_as_often_as_the_speed_says() {
    let turn = std::f64::consts::TAU;
    for speed in [turn, turn + 1e-12, 9.0, 10.0, 12.0, 2.0 * turn, 14.0, 15.5] {
        for n in [2, 3] {
            let unit =
                |row: usize, x: f64| Mat::from_fn(n, 1, |i, _| if i == row { x } else { 0.0 });
            let (s, v) = (unit(0, 1.0), unit(1, speed));
            let data = Data {
                s0: s.clone(),
                v0: v.clone(),
                s1: s,
                v1: v,
            };
            let cost = data.solve().unwrap().cost().unwrap();
            let turns = (speed / turn).round();
            let least = 12.0 * (turns * turn - speed).powi(2);
            assert!(
                cost <= 1.01 * least + 1e-12,
                "speed {speed}: {cost:.3e}, least {least:.3e}"
            );
        }
    }
}

#[test]
fn the_equation_is_satisfied() {
    // D_t^3 S' + R(D_t S', S') S' = 0, as constancy of energy and momentum along the curve.
    let mut rng = Rng::new(13);
    for shape in [(3, 1), (4, 2), (5, 3), (9, 2)] {
        let curve = Data::random(shape, 2.0, 2.0, &mut rng).solve().unwrap();
        let options = IntegrationOptions::default();
        let state = |t: f64| {
            let (s, v) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
            let (a, j) = (curve.acceleration(t).unwrap(), curve.jerk(t).unwrap());
            RiemannianCubic::from_initial(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), &options)
                .unwrap()
        };
        let size = 1.0 + frobenius(curve.momentum().unwrap().as_ref());
        for t in [0.3, 0.8] {
            let later = state(t);
            let drift = distance(&later.momentum().unwrap(), &curve.momentum().unwrap());
            common::assert_within(drift, 1e-11 * size, &format!("{shape:?} momentum"));
            common::assert_within(
                (later.energy().unwrap() - curve.energy().unwrap()).abs(),
                1e-10 * size * size,
                "energy",
            );
        }
    }
}

#[test]
fn symmetries_carry_solutions_to_solutions() {
    let mut rng = Rng::new(14);
    for shape in [(3, 1), (3, 2), (5, 2), (6, 3), (4, 4)] {
        let data = Data::random(shape, 1.5, 1.5, &mut rng);
        let curve = data.solve().unwrap();
        let (q, p) = (
            random_orthogonal(shape.0, &mut rng),
            random_orthogonal(shape.1, &mut rng),
        );
        let turned = data.map(|x| &q * x * &p).solve().unwrap();
        let back = data.reversed().solve().unwrap();
        // The residual times the growth of an error over the interval.
        for t in [0.0, 0.25, 0.6, 1.0] {
            let point = curve.point(t).unwrap();
            common::assert_close(
                &turned.point(t).unwrap(),
                &(&q * &point * &p),
                1e-10,
                "O(n) and O(k)",
            );
            common::assert_close(
                &back.point(1.0 - t).unwrap(),
                &point,
                1e-10,
                "time reversal",
            );
        }
    }
}

#[test]
fn the_reduction_loses_nothing() {
    let mut rng = Rng::new(15);
    let small = Data::random((8, 2), 1.5, 1.5, &mut rng);
    let frame = random_point(30, 8, &mut rng);
    let large = small.map(|x| &frame * x);
    let (small, large) = (small.solve().unwrap(), large.solve().unwrap());
    for t in [0.2, 0.7] {
        let lifted = &frame * small.point(t).unwrap();
        common::assert_close(&large.point(t).unwrap(), &lifted, 1e-11, "reduction");
    }
}

/// Name, initial state and end state.
type Reference = (String, [Mat<f64>; 4], [Mat<f64>; 4]);

/// The forty-digit data.
fn references() -> Vec<Reference> {
    let all: serde_json::Value = serde_json::from_str(include_str!("data/cubics.json")).unwrap();
    let read = |entry: &serde_json::Value, value: &serde_json::Value| {
        let size = |key: &str| entry[key].as_u64().unwrap() as usize;
        ["point", "velocity", "acceleration", "jerk"].map(|key| {
            Mat::from_fn(size("n"), size("k"), |i, j| {
                let x = &value[key][i][j];
                x.as_f64()
                    .unwrap_or_else(|| x.as_str().unwrap().parse().unwrap())
            })
        })
    };
    let entries = all.as_array().unwrap().iter();
    entries
        .map(|e| {
            let name = e["name"].as_str().unwrap_or_default().to_owned();
            (name, read(e, &e["initial"]), read(e, &e["at"]["1.0"]))
        })
        .collect()
}

#[test]
fn the_papers_problems_give_their_initial_data() {
    for (name, first, last) in references() {
        if !name.starts_with("paper") {
            continue;
        }
        let [s0, v0, a, j] = first;
        let [s1, v1, ..] = last;
        let curve = Data { s0, v0, s1, v1 }.solve().unwrap();
        common::assert_close(&curve.acceleration(0.0).unwrap(), &a, 1e-11, &name);
        common::assert_close(&curve.jerk(0.0).unwrap(), &j, 1e-11, &name);
        println!("{name}: {}", curve.boundary_report().unwrap());
    }
}

#[test]
fn a_guess_chooses_the_solution() {
    for (name, first, last) in references() {
        let [s0, v0, a, j] = first;
        let [s1, v1, ..] = last;
        let data = Data { s0, v0, s1, v1 };
        let options = BoundaryOptions {
            guess: Some((a.as_ref(), j.as_ref())),
            ..Default::default()
        };
        let curve = data.solve_with(&options).unwrap();
        let report = curve.boundary_report().unwrap();
        assert_eq!(report.strategy, BoundaryStrategy::Direct);
        // The first residual is integrated roughly, so even an exact guess takes steps: two of Newton's, four of Broyden's.
        assert!(report.solver.iterations <= 4, "{name}: {report}");
        // The residual times the inverse of the derivative of the end.
        common::assert_close(&curve.acceleration(0.0).unwrap(), &a, 1e-9, &name);
    }
}

#[test]
fn equal_points_and_no_velocities_give_the_constant_curve() {
    let mut rng = Rng::new(16);
    for (n, k) in [(3, 1), (4, 2), (3, 3), (20, 2), (1, 1)] {
        let s = random_point(n, k, &mut rng);
        let zero = Mat::zeros(n, k);
        let data = Data {
            s0: s.clone(),
            v0: zero.clone(),
            s1: s.clone(),
            v1: zero,
        };
        let curve = data.solve().unwrap();
        common::assert_close(&curve.point(0.4).unwrap(), &s, 1e-14, "constant");
        assert!(curve.cost().unwrap() < 1e-25);
    }
}

#[test]
fn points_without_a_quasi_geodesic_are_joined() {
    let mut rng = Rng::new(17);
    // Antipodal points; a relative rotation by pi.
    let pole = random_point(3, 1, &mut rng);
    let half_turn = {
        let s = random_point(4, 2, &mut rng);
        let minus = -&s;
        (s, minus)
    };
    for (s0, s1) in [(pole.clone(), -&pole), half_turn] {
        let (v0, v1) = (
            random_tangent(&s0, 1.0, &mut rng),
            random_tangent(&s1, 1.0, &mut rng),
        );
        let data = Data { s0, v0, s1, v1 };
        let curve = data.solve().unwrap();
        common::assert_within(data.defect(&curve), END, "antipodal");
    }
}

#[test]
fn components_of_the_orthogonal_group_are_not_joined() {
    let mut rng = Rng::new(18);
    let s0 = random_rotation(3, &mut rng);
    let mirror = mat![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let zero = Mat::zeros(3, 3);
    let data = Data {
        s1: &s0 * mirror,
        s0,
        v0: zero.clone(),
        v1: zero,
    };
    assert!(matches!(
        data.solve(),
        Err(Error::DifferentComponents { n: 3 })
    ));
}

#[test]
fn rounded_data_are_solved() {
    for shape in SHAPES {
        let mut rng = Rng::new(25);
        for digits in [10, 11, 13] {
            let unit = 10.0_f64.powi(-digits);
            let data = Data::random(shape, 1.5, 1.5, &mut rng).map(|x| {
                Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
                    (x[(i, j)] / unit).round() * unit
                })
            });
            let what = format!("{shape:?}, {digits} digits");
            let curve = data.solve().unwrap_or_else(|e| panic!("{what}: {e}"));
            assert!(curve.boundary_report().unwrap().solver.residual <= 1e-12);
            // Half a unit in each entry, doubled by the projection.
            let rounding = unit * ((shape.0 * shape.1) as f64).sqrt();
            common::assert_within(data.defect(&curve), END + rounding, &what);
        }
    }
}

#[test]
fn fast_great_circles_meet_round_off() {
    let mut rng = Rng::new(26);
    for n in [2, 3, 5] {
        for speed in [20.0, 50.0, 100.0, 300.0] {
            let s0 = random_point(n, 1, &mut rng);
            let v0 = random_tangent(&s0, speed, &mut rng);
            let circle = Geodesic::from_velocity(s0.as_ref(), v0.as_ref()).unwrap();
            let (s1, v1) = (
                circle.point(1.0).unwrap(),
                circle.derivative(1.0, 1).unwrap(),
            );
            let zero = Mat::zeros(n, 1);
            let options = BoundaryOptions {
                guess: Some((zero.as_ref(), zero.as_ref())),
                ..Default::default()
            };
            let data = Data { s0, v0, s1, v1 };
            let curve = data.solve_with(&options);
            let curve = curve.unwrap_or_else(|e| panic!("n = {n}, speed {speed}: {e}"));
            let report = curve.boundary_report().unwrap();
            assert_eq!(report.strategy, BoundaryStrategy::Direct, "{report}");
            // The options' tolerance, but for round-off at the largest speed.
            let tolerance = 1e-12_f64.max(32.0 * f64::EPSILON * speed);
            assert!(
                report.solver.residual <= tolerance * (1.0 + 1e-9),
                "{report}"
            );
            let velocity = distance(&curve.derivative(1.0, 1).unwrap(), &data.v1);
            common::assert_within(velocity, 2.0 * tolerance * speed, "velocity");
        }
    }
}

#[test]
fn a_hopeless_guess_is_not_the_end() {
    let mut rng = Rng::new(27);
    for shape in [(3, 1), (3, 2), (4, 2)] {
        let data = Data::random(shape, 1.5, 1.5, &mut rng);
        let a = random_tangent(&data.s0, 1e6, &mut rng);
        let j = random_tangent(&data.s0, 1e6, &mut rng);
        let (checks, curve) = counted(|interrupt| {
            data.solve_with(&BoundaryOptions {
                guess: Some((a.as_ref(), j.as_ref())),
                interrupt,
                ..Default::default()
            })
        });
        let curve = curve.unwrap_or_else(|e| panic!("{shape:?}: {e}"));
        common::assert_within(data.defect(&curve), END, &format!("{shape:?}"));
        // 141 to 216.
        assert!(checks < 1_000, "{shape:?}: {checks} checks");
    }
}

/// Acceleration and jerk at the start of the curves that are known for the data, and the cost of the adjusted de Casteljau
/// curve.
fn known_starts(data: &Data) -> (Vec<[Mat<f64>; 2]>, Option<f64>) {
    let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
    let mut starts = Vec::new();
    let geometric = GeometricCubic::from_boundary(s0, v0, s1, v1);
    let at_start = |curve: &dyn Fn(Quantity) -> Result<Samples>| -> Result<[Mat<f64>; 2]> {
        let value = |quantity| Ok(curve(quantity)?.get(0).to_owned());
        Ok([value(Quantity::Acceleration)?, value(Quantity::Jerk)?])
    };
    if let Ok(curve) = &geometric {
        starts.extend(at_start(&|q| curve.sample(&[0.0], q, Interrupt::NEVER)));
    }
    if let Ok(curve) = GeodesicPolynomial::from_boundary(s0, v0, s1, v1) {
        starts.extend(at_start(&|q| curve.sample(&[0.0], q, Interrupt::NEVER)));
    }
    if let Ok(curve) = GeometricPolynomial::minimal_cost(s0, v0, s1, v1, 6) {
        starts.extend(at_start(&|q| curve.sample(&[0.0], q, Interrupt::NEVER)));
    }
    (starts, geometric.and_then(|curve| curve.cost()).ok())
}

#[test]
fn solutions_are_no_dearer_than_the_de_casteljau_curve() {
    for (shape, count) in [((3, 1), 100), ((3, 2), 100), ((4, 4), 10), ((4, 2), 25)] {
        let mut rng = Rng::new(28);
        let (mut dearer, mut compared) = (0, 0);
        for _ in 0..count {
            let data = Data::random(shape, 3.0, 6.0, &mut rng);
            let (Ok(curve), (_, Some(bound))) = (data.solve(), known_starts(&data)) else {
                continue;
            };
            compared += 1;
            // The solver knows the bound to a percent.
            dearer += usize::from(curve.cost().unwrap() > bound * 1.02);
        }
        println!("{shape:?}: {dearer} of {compared} dearer");
        assert!(2 * compared > count, "{shape:?}: {compared} have both");
        // One in a hundred.
        assert!(
            100 * dearer <= compared,
            "{shape:?}: {dearer} of {compared}"
        );
    }
}

#[test]
fn a_search_finds_what_known_curves_lead_to() {
    for (shape, count) in [((3, 1), 5), ((3, 2), 10), ((4, 4), 2), ((4, 2), 3)] {
        let mut rng = Rng::new(29);
        for i in 0..count {
            let data = Data::random(shape, 3.0, 6.0, &mut rng);
            let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
            let all = RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &SearchOptions::default());
            let cheapest = all.unwrap_or_else(|e| panic!("{shape:?}, {i}: {e}"))[0]
                .cost()
                .unwrap();
            for [a, j] in &known_starts(&data).0 {
                let options = BoundaryOptions {
                    guess: Some((a.as_ref(), j.as_ref())),
                    ..Default::default()
                };
                if let Ok(curve) = data.solve_with(&options) {
                    let cost = curve.cost().unwrap();
                    assert!(
                        cheapest <= cost * (1.0 + 1e-6),
                        "{shape:?}, {i}: {cheapest} > {cost}"
                    );
                }
            }
        }
    }
}

#[test]
fn huge_velocities_end_soon() {
    let mut rng = Rng::new(19);
    for shape in [(3, 1), (4, 2)] {
        for speed in [1e2, 1e3, 1e6, 1e150, 1e300] {
            let mut data = Data::random(shape, 1.0, 1.0, &mut rng);
            if speed == 1e150 {
                data.v1 = random_tangent(&data.s1, speed, &mut rng);
            } else {
                data.v0 = random_tangent(&data.s0, speed, &mut rng);
            }
            let (checks, outcome) = counted(|interrupt| {
                data.solve_with(&BoundaryOptions {
                    interrupt,
                    ..Default::default()
                })
            });
            println!(
                "{shape:?} speed {speed:e}: {checks} checks {:?}",
                outcome.as_ref().err()
            );
            match outcome {
                Ok(curve) => {
                    common::assert_within(data.defect(&curve), END * speed, "fast curve");
                    // Speed excuses no more than round-off of the point.
                    let off = distance(&curve.point(1.0).unwrap(), &data.s1);
                    common::assert_within(off, 1e-8, "end of a fast curve");
                    assert!(curve.report().unwrap().tolerance <= 1e-9);
                }
                Err(Error::NoConvergence { solver, report }) => {
                    assert!(solver.starts_with("shooting"), "{solver}");
                    assert!(report.residual > report.tolerance, "{report}");
                }
                Err(error) => panic!("{shape:?} {speed:e}: {error}"),
            }
            // The most are 427 000, for St(3,1) at speed 1000.
            assert!(checks < 1_000_000, "{shape:?} {speed:e}: {checks} checks");
        }
    }
}

#[test]
fn bad_options_and_data_are_errors() {
    let mut rng = Rng::new(20);
    let data = Data::random((4, 2), 1.0, 1.0, &mut rng);
    for tolerance in [0.0, -1.0, f64::NAN, 1.0] {
        let options = BoundaryOptions {
            tolerance,
            ..Default::default()
        };
        let error = data.solve_with(&options).unwrap_err();
        assert!(
            matches!(
                error,
                Error::InvalidArgument {
                    name: "tolerance",
                    ..
                }
            ),
            "{error}"
        );
    }
    let none = BoundaryOptions {
        max_iterations: 0,
        ..Default::default()
    };
    let error = data.solve_with(&none).unwrap_err();
    assert!(matches!(
        error,
        Error::InvalidArgument {
            name: "max_iterations",
            ..
        }
    ));
    let one = BoundaryOptions {
        max_iterations: 1,
        ..Default::default()
    };
    match data.solve_with(&one) {
        Err(Error::NoConvergence { report, .. }) => {
            assert_eq!(
                (report.reason, report.iterations),
                (StopReason::MaxIterations, 1)
            );
            assert!(!report.converged && report.residual > report.tolerance);
        }
        other => panic!("{other:?}"),
    }
    let normal = (data.s0.clone(), Mat::<f64>::zeros(4, 2));
    let guessed = BoundaryOptions {
        guess: Some((normal.0.as_ref(), normal.1.as_ref())),
        ..Default::default()
    };
    assert!(matches!(
        data.solve_with(&guessed),
        Err(Error::NotTangent { name: "A", .. })
    ));
    let mut broken = data.map(Mat::clone);
    broken.v1[(0, 0)] = f64::NAN;
    assert!(matches!(broken.solve(), Err(Error::NonFinite { .. })));
}

#[test]
fn an_interrupt_stops_a_solve() {
    let mut rng = Rng::new(21);
    let data = Data::random((4, 2), 2.0, 2.0, &mut rng);
    let asked = AtomicUsize::new(0);
    let question = || asked.fetch_add(1, Ordering::Relaxed) >= 2;
    let options = BoundaryOptions {
        interrupt: Interrupt::new(&question),
        ..Default::default()
    };
    assert!(matches!(
        data.solve_with(&options),
        Err(Error::Interrupted { .. })
    ));
}

#[test]
fn several_solutions_are_distinct_and_ranked() {
    let mut rng = Rng::new(22);
    let options = SearchOptions {
        starts: 4,
        ..Default::default()
    };
    let data = Data::random((3, 1), 1.5, 1.0, &mut rng);
    let search = || {
        let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
        RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &options).unwrap()
    };
    let all = search();
    println!("{} solutions", all.len());
    assert!(
        all.len() >= 3,
        "full turns around the sphere: {}",
        all.len()
    );
    let costs: Vec<f64> = all.iter().map(|c| c.cost().unwrap()).collect();
    assert!(costs.is_sorted(), "{costs:?}");
    assert!(costs[0] <= data.solve().unwrap().cost().unwrap() * (1.0 + 1e-9));
    for (i, curve) in all.iter().enumerate() {
        common::assert_within(data.defect(curve), END, "one of several");
        for other in &all[..i] {
            let apart = distance(&curve.jerk(0.0).unwrap(), &other.jerk(0.0).unwrap())
                + distance(
                    &curve.acceleration(0.0).unwrap(),
                    &other.acceleration(0.0).unwrap(),
                );
            assert!(apart > 1e-7, "{apart:e}");
        }
    }
    let again = search();
    assert_eq!(again.len(), all.len(), "the same seed");
    for (a, b) in all.iter().zip(&again) {
        assert_eq!(a.point(0.5).unwrap(), b.point(0.5).unwrap());
    }
}
