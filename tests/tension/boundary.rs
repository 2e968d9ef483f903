//! Boundary problems in tension: solutions, stationarity, derivatives, and limits for large tension.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{BoundaryOptions, BoundaryVariation};
use stiefel_rs::{Curve, Geodesic, Interrupt, RiemannianCubic};

use crate::boundary_data::{Data, END};
use crate::circle::{Angle, point};
use crate::common::{Rng, assert_within, distance, frobenius, random_tangent};

const SHAPES: [(usize, usize); 9] = [
    (3, 1),
    (3, 2),
    (3, 3),
    (4, 1),
    (4, 2),
    (5, 2),
    (4, 3),
    (4, 4),
    (7, 2),
];

fn in_tension(tension: f64) -> BoundaryOptions<'static> {
    BoundaryOptions {
        tension,
        ..BoundaryOptions::default()
    }
}

/// The angle on a circle with given ends, by two linear equations.
fn angle_between(theta: f64, [a0, v0, a1, v1]: [f64; 4]) -> Angle {
    // a'' = p cosh + q sinh / theta.
    let (sinh, cosh) = (theta.sinh(), theta.cosh());
    let [s1, c2, s3] = [
        sinh / theta,
        (cosh - 1.0) / theta.powi(2),
        (sinh - theta) / theta.powi(3),
    ];
    let (delta, change) = (a1 - a0 - v0, v1 - v0);
    let determinant = c2 * c2 - s1 * s3;
    let p = (c2 * delta - s3 * change) / determinant;
    let q = (c2 * change - s1 * delta) / determinant;
    let [c2, c3] = [p / theta.powi(2), q / theta.powi(3)];
    Angle {
        theta,
        c: [a0 - c2, v0 - theta * c3, c2, c3],
    }
}

#[test]
fn angles_on_a_circle_are_hyperbolic() {
    for theta in [0.5, 2.0, 5.0, 8.0] {
        for ends in [
            [0.1, 0.0, 2.2, 0.0],
            [0.1, 1.0, 1.3, -0.7],
            [0.0, 2.0, -0.4, 1.0],
        ] {
            let angle = angle_between(theta, ends);
            let [[s0, w0], [s1, w1]] = [ends[0], ends[2]].map(point);
            let (v0, v1) = (w0 * Scale(ends[1]), w1 * Scale(ends[3]));
            let curve = RiemannianCubic::from_boundary(
                s0.as_ref(),
                v0.as_ref(),
                s1.as_ref(),
                v1.as_ref(),
                &in_tension(theta * theta),
                Interrupt::NEVER,
            )
            .unwrap();
            for t in [0.1, 0.5, 0.9] {
                let [s, _] = point(angle.at(t, 0));
                assert_within(
                    distance(&curve.point(t).unwrap(), &s),
                    1e-11,
                    &format!("{theta} {ends:?}"),
                );
            }
            let (found, wanted) = (curve.cost(Interrupt::NEVER).unwrap(), angle.cost());
            assert_within(
                (found / wanted - 1.0).abs(),
                1e-10,
                &format!("{theta} {ends:?}: cost"),
            );
        }
    }
}

#[test]
fn random_problems_are_solved() {
    for shape in SHAPES {
        for tension in [0.1, 4.0, 30.0, 64.0] {
            let mut rng = Rng::new(7 + (10.0 * tension) as u64);
            for i in 0..12 {
                let data = Data::random(shape, 2.5, 4.0, &mut rng);
                let curve = data.solve_with(&in_tension(tension), Interrupt::NEVER);
                let curve =
                    curve.unwrap_or_else(|error| panic!("{shape:?} {tension} {i}: {error}"));
                assert_eq!(curve.tension(), tension);
                assert_within(
                    data.defect(&curve),
                    END,
                    &format!("{shape:?} {tension} {i}"),
                );
            }
        }
    }
}

/// `int |A|^2 + tau |V|^2` by the curve's own cost, and from its parts.
#[test]
fn cost_is_what_is_minimised() {
    let mut rng = Rng::new(3);
    let data = Data::random((5, 2), 1.5, 2.0, &mut rng);
    let [tension, other] = [6.0, 6.5];
    let cost = |curve: &RiemannianCubic| curve.cost(Interrupt::NEVER).unwrap();
    let mine = data
        .solve_with(&in_tension(tension), Interrupt::NEVER)
        .unwrap();
    let theirs = data
        .solve_with(&in_tension(other), Interrupt::NEVER)
        .unwrap();
    let square = |curve: &RiemannianCubic| {
        let count = 400;
        let manifold = stiefel_rs::Stiefel::new(5, 2).unwrap();
        let speed = |i: i32| {
            let t = f64::from(i) / f64::from(count);
            let (s, v) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
            manifold.norm(s.as_ref(), v.as_ref()).unwrap().powi(2)
        };
        let weight = |i: i32| match i {
            0 => 1.0,
            i if i == count => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (0..=count).map(|i| weight(i) * speed(i)).sum::<f64>() / (3.0 * f64::from(count))
    };
    // Each is cheaper by its own measure, and the slope of the least cost is int |V|^2.
    let theirs_by_mine = cost(&theirs) - (other - tension) * square(&theirs);
    assert!(
        cost(&mine) < theirs_by_mine,
        "{} {theirs_by_mine}",
        cost(&mine)
    );
    let step = 1e-3;
    let [up, down] = [tension + step, tension - step]
        .map(|t| cost(&data.solve_with(&in_tension(t), Interrupt::NEVER).unwrap()));
    let slope = (up - down) / (2.0 * step);
    assert_within((slope / square(&mine) - 1.0).abs(), 1e-6, "slope");
}

#[test]
fn derivatives_are_those_of_the_solutions() {
    for shape in [(3, 1), (3, 2), (5, 2), (4, 4), (9, 2)] {
        let mut rng = Rng::new(21);
        let data = Data::random(shape, 1.2, 1.5, &mut rng);
        let options = in_tension(7.0);
        let curve = data.solve_with(&options, Interrupt::NEVER).unwrap();
        // The end moves along a geodesic that carries its velocity.
        let w = random_tangent(&data.s1, 1.0, &mut rng);
        let moved = |h: f64| {
            let way = Geodesic::from_velocity(data.s1.as_ref(), (&w * Scale(h)).as_ref()).unwrap();
            let s1 = way.point(1.0).unwrap();
            let v1 = stiefel_rs::Stiefel::new(shape.0, shape.1)
                .unwrap()
                .project_tangent(s1.as_ref(), data.v1.as_ref())
                .unwrap();
            Data {
                s1,
                v1,
                ..data.clone()
            }
        };
        let h = 1e-4;
        let (up, down) = (moved(h), moved(-h));
        let rate = |a: &Mat<f64>, b: &Mat<f64>| (a - b) * Scale(0.5 / h);
        let rest = Mat::zeros(shape.0, shape.1);
        let [ds1, dv1] = [rate(&up.s1, &down.s1), rate(&up.v1, &down.v1)];
        // Tangent to round-off; a difference quotient is tangent only up to h^2.
        let manifold = stiefel_rs::Stiefel::new(shape.0, shape.1).unwrap();
        let ds1 = manifold
            .project_tangent(data.s1.as_ref(), ds1.as_ref())
            .unwrap();
        let along = data.s1.transpose() * &dv1 + ds1.transpose() * &data.v1;
        let dv1 = &dv1 - &data.s1 * ((&along + along.transpose()) * Scale(0.5));
        let variation = BoundaryVariation {
            s0: rest.as_ref(),
            v0: rest.as_ref(),
            s1: ds1.as_ref(),
            v1: dv1.as_ref(),
        };
        let derivative = curve.boundary_derivative(Interrupt::NEVER).unwrap();
        let ends = [up, down].map(|data| data.solve_with(&options, Interrupt::NEVER).unwrap());
        let [a, b] = ends.each_ref().map(|curve| curve.point(0.6).unwrap());
        let found = derivative
            .points(&curve, &variation, &[0.6], Interrupt::NEVER)
            .unwrap();
        let error = distance(&found[0], &rate(&a, &b));
        assert!(
            error < 1e-6 * (1.0 + frobenius(found[0].as_ref())),
            "{shape:?}: {error:e}"
        );
        let [a, b] = ends
            .each_ref()
            .map(|curve| curve.cost(Interrupt::NEVER).unwrap());
        let (slope, wanted) = (derivative.cost(&variation).unwrap(), (a - b) / (2.0 * h));
        assert!(
            (slope - wanted).abs() < 1e-5 * (1.0 + wanted.abs()),
            "{shape:?}: {slope} {wanted}"
        );
    }
}

#[test]
fn large_tensions_tend_to_geodesics() {
    for shape in [(3, 1), (4, 2)] {
        let mut rng = Rng::new(2);
        let data = Data::random(shape, 1.0, 0.0, &mut rng);
        let geodesic = Geodesic::between(data.s0.as_ref(), data.s1.as_ref()).unwrap();
        let gap = |tension: f64| {
            let curve = data
                .solve_with(&in_tension(tension), Interrupt::NEVER)
                .unwrap();
            let exact = geodesic.derivative(0.5, 1).unwrap();
            distance(&curve.derivative(0.5, 1).unwrap(), &exact) / frobenius(exact.as_ref())
        };
        // From rest to rest along a line, the velocity in the middle is (1 - sech(theta/2)) / (1 - 2 tanh(theta/2) /
        // theta).
        let speed = |theta: f64| {
            let half = 0.5 * theta;
            (1.0 - half.cosh().recip()) / (1.0 - half.tanh() / half) - 1.0
        };
        for tension in [1.0, 64.0] {
            let wanted = speed(f64::sqrt(tension));
            assert_within(
                (gap(tension) / wanted - 1.0).abs(),
                1e-9,
                &format!("{shape:?} {tension}"),
            );
        }
    }
}

#[test]
fn reversed_problems_have_the_same_curve() {
    let mut rng = Rng::new(9);
    for shape in [(3, 2), (5, 2)] {
        let data = Data::random(shape, 2.5, 3.0, &mut rng);
        let there = data
            .solve_with(&in_tension(20.0), Interrupt::NEVER)
            .unwrap();
        let back = data
            .reversed()
            .solve_with(&in_tension(20.0), Interrupt::NEVER)
            .unwrap();
        assert_within(
            distance(&there.point(0.3).unwrap(), &back.point(0.7).unwrap()),
            1e-10,
            &format!("{shape:?}"),
        );
    }
}
