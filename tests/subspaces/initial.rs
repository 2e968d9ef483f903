//! Initial values: the Taylor method and the splittings, compared with reflections.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{
    IntegrationOptions, RiemannianCubic, SplittingOptions, SplittingOrder, integrate_cubic,
};
use stiefel_rs::{Curve, Error, Interrupt, Quotient};

use crate::common::{
    Rng, assert_close, assert_within, cubic_from, distance, gaussian, orthonormality,
    random_orthogonal, random_point,
};
use crate::{SHAPES, horizontal, reflected, reflection, view};

const SUBSPACES: IntegrationOptions = IntegrationOptions {
    t_end: 1.5,
    tolerance: 1e-17,
    tension: 0.0,
    quotient: Quotient::Subspaces,
};

/// A point, and velocity, acceleration and jerk at it.
fn data((n, k): (usize, usize), rng: &mut Rng) -> [Mat<f64>; 4] {
    let y = random_point(n, k, rng);
    let mut vector = |size: f64| {
        let v = horizontal(view(&y), gaussian(n, k, rng).as_ref());
        let norm = v.norm_l2();
        v * Scale(size / norm)
    };
    let [v, a, j] = [1.3, 2.0, 4.0].map(&mut vector);
    [y, v, a, j]
}

fn cubic([y, v, a, j]: &[Mat<f64>; 4], options: &IntegrationOptions) -> RiemannianCubic {
    cubic_from([y, v, a, j], options)
}

/// The curve of reflections with the same initial data.
fn of_reflections([y, v, a, j]: &[Mat<f64>; 4], tension: f64) -> RiemannianCubic {
    let p = reflection(view(y));
    let [v, a, j] = [v, a, j].map(|x| reflected(view(y), view(x)));
    let options = IntegrationOptions {
        quotient: Quotient::Frames,
        tension,
        ..SUBSPACES
    };
    cubic(&[p, v, a, j], &options)
}

#[test]
fn cubics_are_those_of_reflections() {
    let mut rng = Rng::new(1);
    for shape in SHAPES {
        for tension in [0.0, 3.0] {
            let data = data(shape, &mut rng);
            let options = IntegrationOptions {
                tension,
                ..SUBSPACES
            };
            let (curve, oracle) = (cubic(&data, &options), of_reflections(&data, tension));
            for t in [0.0, 0.4, 1.0, 1.5] {
                let y = curve.point(t).unwrap();
                let what = format!("{shape:?}, tension {tension}, t = {t}");
                assert_close(
                    &reflection(view(&y)),
                    &oracle.point(t).unwrap(),
                    1e-12,
                    &what,
                );
                for (quantity, expected) in [
                    (curve.derivative(t, 1), oracle.derivative(t, 1)),
                    (curve.acceleration(t), oracle.acceleration(t)),
                    (curve.jerk(t), oracle.jerk(t)),
                ] {
                    let found = reflected(view(&y), view(&quantity.unwrap()));
                    assert_close(&found, &expected.unwrap(), 1e-10, &what);
                }
                assert_within(orthonormality(&y), 1e-14, &what);
                let turned = y.transpose() * curve.derivative(t, 1).unwrap();
                assert_within(turned.norm_l2(), 1e-13, &what);
            }
            // The canonical length of reflections is twice that of subspaces.
            let costs = [
                curve.cost(Interrupt::NEVER).unwrap(),
                oracle.cost(Interrupt::NEVER).unwrap(),
            ];
            assert_within((4.0 * costs[0] - costs[1]).abs() / costs[1], 1e-12, "cost");
            let lengths = [&curve, &oracle]
                .map(|curve| curve.arc_length(0.0, 1.5, Interrupt::NEVER).unwrap());
            assert_within(
                (2.0 * lengths[0] - lengths[1]).abs() / lengths[1],
                1e-12,
                "length",
            );
            let energies = [&curve, &oracle].map(|curve| curve.energy().unwrap());
            assert_within((4.0 * energies[0] - energies[1]).abs(), 1e-10, "energy");
        }
    }
}

#[test]
fn bounds_of_derivatives_hold_and_are_near() {
    let mut rng = Rng::new(2);
    for shape in SHAPES {
        let curve = cubic(&data(shape, &mut rng), &SUBSPACES);
        let bounds = curve.derivative_bounds(Interrupt::NEVER).unwrap();
        let mut largest = [0.0_f64; 3];
        for i in 0..=300 {
            let t = 1.5 * f64::from(i) / 300.0;
            let values = [curve.derivative(t, 1), curve.acceleration(t), curve.jerk(t)];
            for (largest, value) in largest.iter_mut().zip(values) {
                *largest = largest.max(value.unwrap().norm_l2());
            }
        }
        let found = [bounds.velocity, bounds.acceleration, bounds.jerk];
        for (bound, largest) in found.into_iter().zip(largest) {
            assert!(
                largest <= bound && bound <= 1.05 * largest,
                "{shape:?}: {bound}, {largest}"
            );
        }
    }
}

#[test]
fn momentum_is_conserved() {
    let mut rng = Rng::new(3);
    for shape in SHAPES {
        let curve = cubic(&data(shape, &mut rng), &SUBSPACES);
        let [y, v, a, j] = [
            curve.point(1.0),
            curve.derivative(1.0, 1),
            curve.acceleration(1.0),
            curve.jerk(1.0),
        ]
        .map(|x| x.unwrap());
        // The round-off of the point is a defect of the tangent vectors.
        let [v, a, j] = [v, a, j].map(|x| horizontal(view(&y), view(&x)));
        let later = cubic(&[y, v, a, j], &SUBSPACES);
        assert_close(
            &curve.momentum().unwrap(),
            &later.momentum().unwrap(),
            1e-10,
            "momentum",
        );
    }
}

#[test]
fn other_bases_make_the_same_curve() {
    let mut rng = Rng::new(4);
    for (n, k) in SHAPES {
        let data = data((n, k), &mut rng);
        let (q, g) = (
            random_orthogonal(k, &mut rng),
            random_orthogonal(n, &mut rng),
        );
        let moved = data.each_ref().map(|x| &g * x * &q);
        let (curve, other) = (cubic(&data, &SUBSPACES), cubic(&moved, &SUBSPACES));
        let expected = &g * curve.point(1.2).unwrap() * &q;
        assert_close(&other.point(1.2).unwrap(), &expected, 1e-12, "bases");
    }
}

#[test]
fn splittings_of_all_orders_converge_to_the_curve_and_keep_their_integrals() {
    let mut rng = Rng::new(5);
    for shape in SHAPES {
        for tension in [0.0, 2.0] {
            let data = data(shape, &mut rng);
            let options = IntegrationOptions {
                tension,
                t_end: 1.0,
                ..SUBSPACES
            };
            let exact = cubic(&data, &options).point(1.0).unwrap();
            for (order, power) in [
                (SplittingOrder::Two, 2),
                (SplittingOrder::Four, 4),
                (SplittingOrder::Six, 6),
                (SplittingOrder::Eight, 8),
            ] {
                let errors = [10, 20].map(|steps| {
                    let options = SplittingOptions {
                        order,
                        tension,
                        quotient: Quotient::Subspaces,
                        ..SplittingOptions::default()
                    };
                    let [y, v, a, j] = data.each_ref().map(view);
                    let found =
                        integrate_cubic(y, v, a, j, steps, &options, Interrupt::NEVER).unwrap();
                    assert_within(found.momentum_drift(), 1e-12, "momentum");
                    assert_within(found.constraint_drift(), 1e-12, "constraint");
                    let velocity = found.velocities().unwrap().get(steps).to_owned();
                    let end = found.points().unwrap().get(steps).to_owned();
                    assert_within((end.transpose() * velocity).norm_l2(), 1e-12, "horizontal");
                    distance(&end, &exact)
                });
                // A factor of 2.5 below the order, or round-off.
                let wanted = 2.0_f64.powi(power) / 2.5;
                let is_met = errors[1] < 1e-12 || errors[0] / errors[1] > wanted;
                assert!(
                    is_met,
                    "{shape:?}, order {power}, tension {tension}: {errors:?}"
                );
            }
        }
    }
}

#[test]
fn vectors_that_turn_the_basis_are_refused() {
    let y = Mat::<f64>::identity(3, 2);
    let turning = Mat::from_fn(3, 2, |i, j| [[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]][i][j]);
    let zero = Mat::zeros(3, 2);
    let found = RiemannianCubic::from_initial(
        view(&y),
        view(&turning),
        view(&zero),
        view(&zero),
        &SUBSPACES,
        Interrupt::NEVER,
    );
    let error = found.unwrap_err();
    assert!(
        matches!(error, Error::NotHorizontal { name: "V", .. }),
        "{error}"
    );
}
