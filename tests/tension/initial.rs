//! From initial data: closed forms, bounds, units of time; and by splittings.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{IntegrationOptions, SplittingOptions, SplittingOrder, integrate_cubic};
use stiefel_rs::{Curve, Interrupt, RiemannianCubic, Stiefel};

use crate::circle::{Angle, point};
use crate::common::{
    EPS, Rng, assert_close, assert_within, cubic_from, distance, random_point, random_tangent,
};

fn random_state((n, k): (usize, usize), rng: &mut Rng) -> [Mat<f64>; 4] {
    let s = random_point(n, k, rng);
    let [v, a, j] = [1.0; 3].map(|size| random_tangent(&s, size, rng));
    [s, v, a, j]
}

fn curve([s, v, a, j]: &[Mat<f64>; 4], tension: f64, t_end: f64) -> RiemannianCubic {
    let options = IntegrationOptions {
        tension,
        t_end,
        ..IntegrationOptions::default()
    };
    cubic_from([s, v, a, j], &options)
}

fn state(curve: &RiemannianCubic, t: f64) -> [Mat<f64>; 4] {
    [
        curve.point(t).unwrap(),
        curve.derivative(t, 1).unwrap(),
        curve.acceleration(t).unwrap(),
        curve.jerk(t).unwrap(),
    ]
}

#[test]
fn angles_on_a_circle_are_hyperbolic() {
    for theta in [0.3, 1.0, 6.0, 40.0] {
        let angle = Angle {
            theta,
            c: [0.3, 0.5, 0.2 / theta.powi(2), -0.4 / theta.powi(3)],
        };
        let [s, along] = point(angle.at(0.0, 0));
        let [v, a, j] = [1, 2, 3].map(|order| &along * Scale(angle.at(0.0, order)));
        let t_end = 1.0_f64.min(6.0 / theta);
        let curve = curve(&[s, v, a, j], theta * theta, t_end);
        for t in [0.5 * t_end, t_end] {
            let [s, along] = point(angle.at(t, 0));
            // Round-off of the start grows as the angle does, by at most e^6.
            let bound = 1e3 * EPS * (1.0 + angle.at(t, 1).abs());
            let what = format!("{theta} at {t}");
            assert_close(&curve.point(t).unwrap(), &s, bound, &what);
            let bound = bound * (1.0 + theta);
            let rate = &along * Scale(angle.at(t, 1));
            assert_close(&curve.derivative(t, 1).unwrap(), &rate, bound, &what);
        }
    }
}

#[test]
fn tension_has_the_unit_of_a_rate_squared() {
    let mut rng = Rng::new(5);
    let data = random_state((5, 2), &mut rng);
    let slow = curve(&data, 4.0, 1.0);
    // A hundred times as fast.
    let [s, v, a, j] = &data;
    let fast = [s.clone(), v * Scale(1e2), a * Scale(1e4), j * Scale(1e6)];
    let fast = curve(&fast, 4e4, 0.01);
    assert_close(
        &fast.point(0.01).unwrap(),
        &slow.point(1.0).unwrap(),
        100.0 * EPS,
        "end",
    );
    for other in [slow.reparametrised(2.0, 2.01).unwrap(), fast.clone()] {
        assert_within((other.tension() / 4e4 - 1.0).abs(), 1e-13, "tension");
    }
    assert_eq!(slow.reversed().tension(), 4.0);
    let cost = [
        fast.cost(Interrupt::NEVER).unwrap() * 1e-6,
        slow.cost(Interrupt::NEVER).unwrap(),
    ];
    assert_within((cost[0] / cost[1] - 1.0).abs(), 1e-12, "cost");
}

#[test]
fn bounds_of_derivatives_hold() {
    for (n, k) in [(3, 1), (3, 2), (5, 2), (4, 4)] {
        let mut rng = Rng::new((3 * n + k) as u64);
        let manifold = Stiefel::new(n, k).unwrap();
        let curve = curve(&random_state((n, k), &mut rng), 9.0, 2.0);
        let bounds = curve.derivative_bounds(Interrupt::NEVER).unwrap();
        let mut largest = [0.0_f64; 3];
        for i in 0..=2000 {
            let [s, v, a, j] = state(&curve, f64::from(i) / 1000.0);
            for (largest, x) in largest.iter_mut().zip([v, a, j]) {
                *largest = largest.max(manifold.norm(s.as_ref(), x.as_ref()).unwrap());
            }
        }
        for (bound, largest) in [bounds.velocity, bounds.acceleration, bounds.jerk]
            .into_iter()
            .zip(largest)
        {
            // The enclosure is at most 1e-3 above, and samples miss a little.
            assert!(
                largest <= bound && bound <= 1.0011 * largest,
                "St({n},{k}): {largest} {bound}"
            );
        }
    }
}

#[test]
fn splittings_have_their_orders_and_keep_momentum() {
    for (seed, shape) in [(3, 1), (3, 2), (3, 3), (5, 2), (4, 4), (9, 2)]
        .into_iter()
        .enumerate()
    {
        let data = random_state(shape, &mut Rng::new(seed as u64 + 11));
        let tension = 5.0;
        let exact = state(&curve(&data, tension, 1.0), 1.0);
        let [s, v, a, j] = data.each_ref().map(|x| x.as_ref());
        let run = |order, steps| {
            let options = SplittingOptions {
                order,
                tension,
                ..SplittingOptions::default()
            };
            integrate_cubic(s, v, a, j, steps, &options, Interrupt::NEVER).unwrap()
        };
        let error = |order, steps: usize| {
            let found = run(order, steps);
            let ends = [
                found.points().unwrap(),
                found.velocities().unwrap(),
                found.accelerations().unwrap(),
                found.jerks().unwrap(),
            ];
            let pairs = ends.iter().zip(&exact);
            pairs
                .map(|(end, exact)| distance(&end.get(steps).to_owned(), exact))
                .fold(0.0, f64::max)
        };
        for (order, wanted, steps) in [
            (SplittingOrder::Two, 2.0, 200),
            (SplittingOrder::Four, 4.0, 60),
        ] {
            let slope = (error(order, steps) / error(order, 2 * steps)).log2();
            assert!(
                (slope - wanted).abs() < 0.1,
                "{shape:?}: {slope} for {wanted}"
            );
        }
        assert!(error(SplittingOrder::Eight, 60) < 1e-11, "{shape:?}");
        let found = run(SplittingOrder::Eight, 60);
        assert!(
            found.momentum_drift() < 1e-13,
            "{shape:?}: {:e}",
            found.momentum_drift()
        );
        assert!(found.constraint_drift() < 1e-13, "{shape:?}");
        let energy = found.energy();
        let own = curve(&data, tension, 1.0).energy().unwrap();
        assert!(
            energy
                .iter()
                .all(|e| (e - own).abs() < 1e-9 * (1.0 + own.abs())),
            "{shape:?}"
        );
    }
}
