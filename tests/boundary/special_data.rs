//! Opposite and equal points, great circles, data with round-off, and guesses that do not converge.

use faer::{Mat, mat};
use stiefel_rs::cubic::{BoundaryOptions, SearchOptions};
use stiefel_rs::{Curve, Error, Geodesic, Interrupt, RiemannianCubic, Strategy};

use crate::common::{
    Rng, assert_close, assert_within, counted, distance, random_point, random_rotation,
    random_tangent,
};
use crate::data::{Data, END};
use crate::random_data::SHAPES;

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
        let guess = Some((data.v0.as_ref(), data.v0.as_ref()));
        let guessed = BoundaryOptions {
            guess,
            ..Default::default()
        };
        for curve in [
            data.solve().unwrap(),
            data.solve_with(&guessed, Interrupt::NEVER).unwrap(),
        ] {
            assert_close(&curve.point(0.4).unwrap(), &s, 1e-14, "constant");
            assert!(curve.cost(Interrupt::NEVER).unwrap() < 1e-25);
        }
        let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(Mat::as_ref);
        let all = RiemannianCubic::all_from_boundary(
            s0,
            v0,
            s1,
            v1,
            &SearchOptions::default(),
            Interrupt::NEVER,
        );
        assert!(all.unwrap()[0].cost(Interrupt::NEVER).unwrap() < 1e-25);
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
        assert_within(data.defect(&curve), END, "antipodal");
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
            assert!(curve.report().unwrap().residual <= 1e-12);
            // Half a unit in each entry, doubled by the projection.
            let rounding = unit * ((shape.0 * shape.1) as f64).sqrt();
            assert_within(data.defect(&curve), END + rounding, &what);
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
            let curve = data.solve_with(&options, Interrupt::NEVER);
            let curve = curve.unwrap_or_else(|e| panic!("n = {n}, speed {speed}: {e}"));
            let report = curve.report().unwrap();
            assert_eq!(report.strategy, Some(Strategy::Direct), "{report}");
            // The options' tolerance, or the round-off at the largest speed.
            let tolerance = 1e-12_f64.max(32.0 * f64::EPSILON * speed);
            assert!(report.residual <= tolerance * (1.0 + 1e-9), "{report}");
            let velocity = distance(&curve.derivative(1.0, 1).unwrap(), &data.v1);
            assert_within(velocity, 2.0 * tolerance * speed, "velocity");
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
            let options = BoundaryOptions {
                guess: Some((a.as_ref(), j.as_ref())),
                ..Default::default()
            };
            data.solve_with(&options, interrupt)
        });
        let curve = curve.unwrap_or_else(|e| panic!("{shape:?}: {e}"));
        assert_within(data.defect(&curve), END, &format!("{shape:?}"));
        // Between 141 and 216.
        assert!(checks < 1_000, "{shape:?}: {checks} checks");
    }
}

#[test]
fn opposite_points_with_slow_ends_are_joined() {
    // The solutions nearly form a continuous family: rotating one about the axis through the points almost gives
    // another one.
    let mut rng = Rng::new(74);
    for (n, k) in [(3, 1), (4, 1), (5, 1), (3, 2), (4, 2)] {
        for speed in [1e-2, 1e-4, 1e-6, 1e-8] {
            let s0 = random_point(n, k, &mut rng);
            let s1 = -&s0;
            let data = Data {
                v0: random_tangent(&s0, speed, &mut rng),
                v1: random_tangent(&s1, speed, &mut rng),
                s0,
                s1,
            };
            let curve = data.solve().unwrap();
            assert_close(&curve.point(1.0).unwrap(), &data.s1, END, "end point");
            // From rest to rest, half a great circle costs 12 pi^2, which speeds change by at most 24 pi times their
            // sum.
            let cost = curve.cost(Interrupt::NEVER).unwrap();
            let rest = 12.0 * std::f64::consts::PI.powi(2);
            let most = rest * (1.0 + 1e-9) + 48.0 * std::f64::consts::PI * speed;
            assert!(cost <= most, "St({n}, {k}), {speed}: {cost} > {most}");
        }
    }
}
