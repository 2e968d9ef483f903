//! Splines in tension: closed forms on a circle, twice differentiable, stationary.

use faer::{Mat, MatRef, Scale};
use nalgebra::{DMatrix, DVector};
use stiefel_rs::spline::{EndCondition, EndConditions, SplineOptions, cubic_spline};
use stiefel_rs::{Curve, Error, Interrupt};

use crate::circle::point;
use crate::common::{
    Rng, assert_within, distance, frobenius, random_point, random_tangent, retract,
};

fn in_tension(tension: f64) -> SplineOptions {
    SplineOptions {
        tension,
        ..SplineOptions::default()
    }
}

fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(|x| x.as_ref()).collect()
}

/// Coefficients of `1, t, cosh(theta t), sinh(theta t)` on every leg, from all conditions at once; with second or first
/// derivatives given at the ends.
fn flat(t: &[f64], angles: &[f64], theta: f64, ends: (usize, [f64; 2])) -> DVector<f64> {
    let legs = t.len() - 1;
    let mut matrix = DMatrix::zeros(4 * legs, 4 * legs);
    let mut right = DVector::zeros(4 * legs);
    let mut row = 0;
    let basis = |s: f64, order: usize| row_of(theta, s, order);
    for leg in 0..legs {
        let h = t[leg + 1] - t[leg];
        for (s, value) in [(0.0, angles[leg]), (h, angles[leg + 1])] {
            for (i, b) in basis(s, 0).into_iter().enumerate() {
                matrix[(row, 4 * leg + i)] = b;
            }
            right[row] = value;
            row += 1;
        }
        if leg + 1 < legs {
            for order in [1, 2] {
                for (i, (b, c)) in basis(h, order)
                    .into_iter()
                    .zip(basis(0.0, order))
                    .enumerate()
                {
                    matrix[(row, 4 * leg + i)] = b;
                    matrix[(row, 4 * leg + 4 + i)] = -c;
                }
                row += 1;
            }
        }
    }
    let h = t[legs] - t[legs - 1];
    for (leg, s, value) in [(0, 0.0, ends.1[0]), (legs - 1, h, ends.1[1])] {
        for (i, b) in basis(s, ends.0).into_iter().enumerate() {
            matrix[(row, 4 * leg + i)] = b;
        }
        right[row] = value;
        row += 1;
    }
    matrix.lu().solve(&right).unwrap()
}

fn row_of(theta: f64, s: f64, order: usize) -> [f64; 4] {
    let (sinh, cosh) = ((theta * s).sinh(), (theta * s).cosh());
    match order {
        0 => [1.0, s, cosh, sinh],
        1 => [0.0, 1.0, theta * sinh, theta * cosh],
        _ => [0.0, 0.0, theta * theta * cosh, theta * theta * sinh],
    }
}

#[test]
fn angles_on_a_circle_are_splines_of_flat_space() {
    let t = [0.0, 0.5, 1.7, 2.2, 3.0];
    let angles = [0.2, 0.9, 0.1, -0.8, 0.4];
    for theta in [0.7, 2.5, 6.0] {
        for end in [2, 1] {
            let given = [0.3, -0.2];
            let points: Vec<Mat<f64>> = angles.iter().map(|a| point(*a)[0].clone()).collect();
            let vector = |i: usize, value: f64| point(angles[i])[1].clone() * Scale(value);
            let [first, last] = [vector(0, given[0]), vector(4, given[1])];
            let ends = match end {
                1 => [EndCondition::Velocity(first), EndCondition::Velocity(last)],
                _ => [
                    EndCondition::Acceleration(first),
                    EndCondition::Acceleration(last),
                ],
            };
            let ends = EndConditions::Each(Box::new(ends));
            let (curve, report) = cubic_spline(
                &t,
                &views(&points),
                &ends,
                &in_tension(theta * theta),
                Interrupt::NEVER,
            )
            .unwrap();
            assert!(report.converged);
            let c = flat(&t, &angles, theta, (end, given));
            for leg in 0..4 {
                for share in [0.2, 0.5, 0.9] {
                    let s = share * (t[leg + 1] - t[leg]);
                    let angle: f64 = (0..4)
                        .map(|i| c[4 * leg + i] * row_of(theta, s, 0)[i])
                        .sum();
                    let found = curve.point(t[leg] + s).unwrap();
                    let what = format!("{theta} {end} on leg {leg}");
                    assert_within(distance(&found, &point(angle)[0]), 1e-10, &what);
                }
            }
        }
    }
}

/// Consecutive points at the given distance.
fn walk((n, k): (usize, usize), count: usize, far: f64, rng: &mut Rng) -> Vec<Mat<f64>> {
    let mut points = vec![random_point(n, k, rng)];
    for i in 1..count {
        let v = random_tangent(&points[i - 1], far, rng);
        points.push(retract(&points[i - 1], &v));
    }
    points
}

/// By series, in the embedding with few and with many rows, and by descents.
#[test]
fn splines_are_twice_differentiable_and_pieces_know_their_tension() {
    for (shape, far) in [
        ((3, 1), 0.9),
        ((3, 2), 0.9),
        ((5, 2), 0.8),
        ((6, 3), 0.8),
        ((4, 4), 0.6),
        ((40, 2), 0.7),
    ] {
        for tension in [0.5, 6.0, if shape.0 > 12 { 6.2 } else { 40.0 }] {
            let mut rng = Rng::new(shape.0 as u64);
            let points = walk(shape, 7, far, &mut rng);
            let t = [0.0, 0.4, 1.4, 2.0, 2.9, 3.5, 4.0];
            for ends in [
                EndConditions::Natural,
                EndConditions::Each(Box::new(
                    [0, 6]
                        .map(|i| EndCondition::Velocity(random_tangent(&points[i], 0.5, &mut rng))),
                )),
            ] {
                let solved = cubic_spline(
                    &t,
                    &views(&points),
                    &ends,
                    &in_tension(tension),
                    Interrupt::NEVER,
                );
                let (curve, _) =
                    solved.unwrap_or_else(|error| panic!("{shape:?} {tension}: {error}"));
                for knot in 1..6 {
                    let lengths = [t[knot] - t[knot - 1], t[knot + 1] - t[knot]];
                    let pieces = &curve.pieces()[knot - 1..=knot];
                    let own = pieces[1].tension() / lengths[1].powi(2);
                    assert_within((own / tension - 1.0).abs(), 1e-13, "tension");
                    // Each piece is parametrised by [0, 1].
                    let at = |which: usize| [1.0, 0.0][which];
                    for order in [0, 1] {
                        let [a, b] = [0, 1].map(|which| {
                            let x = pieces[which].derivative(at(which), order).unwrap();
                            x * Scale(lengths[which].powi(-(order as i32)))
                        });
                        let jump = distance(&a, &b);
                        assert!(
                            jump < 2e-11,
                            "{shape:?} {tension}: {order} at {knot}: {jump:e}"
                        );
                    }
                    let [a, b] = [0, 1].map(|which| {
                        let x = pieces[which].acceleration(at(which)).unwrap();
                        x * Scale(lengths[which].powi(-2))
                    });
                    let jump = distance(&a, &b) / (1.0 + frobenius(a.as_ref()));
                    assert!(
                        jump < 1e-10,
                        "{shape:?} {tension}: acceleration at {knot}: {jump:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn closed_splines_close() {
    let mut rng = Rng::new(8);
    let mut points = walk((3, 2), 6, 0.8, &mut rng);
    points.push(points[0].clone());
    let t = [0.0, 0.5, 1.0, 1.7, 2.2, 3.0, 3.4];
    let solved = cubic_spline(
        &t,
        &views(&points),
        &EndConditions::Periodic,
        &in_tension(10.0),
        Interrupt::NEVER,
    );
    let (curve, _) = solved.unwrap();
    for order in [0, 1] {
        let [a, b] = [0.0, 3.4].map(|t| curve.derivative(t, order).unwrap());
        assert_within(distance(&a, &b), 1e-11, "closed");
    }
    let [a, b] = [0.0, 3.4].map(|t| curve.acceleration(t).unwrap());
    assert_within(distance(&a, &b), 1e-10, "acceleration");
}

/// Changing a knot's velocity, with cubics in the same tension in between, increases the cost by the square of the
/// change.
#[test]
fn costs_are_stationary() {
    let mut rng = Rng::new(4);
    let points = walk((4, 2), 5, 0.7, &mut rng);
    let t = [0.0, 1.0, 1.6, 2.5, 3.0];
    let cost = |tension: f64, with: f64| {
        let (curve, _) = cubic_spline(
            &t,
            &views(&points),
            &EndConditions::Natural,
            &in_tension(with),
            Interrupt::NEVER,
        )
        .unwrap();
        // The curve's own cost, minus the part due to the other tension.
        let own = curve.cost(Interrupt::NEVER).unwrap();
        let square: f64 = (0..3000)
            .map(|i| {
                let at = 3.0 * (f64::from(i) + 0.5) / 3000.0;
                let (s, v) = (curve.point(at).unwrap(), curve.derivative(at, 1).unwrap());
                let manifold = stiefel_rs::Stiefel::new(4, 2).unwrap();
                manifold.norm(s.as_ref(), v.as_ref()).unwrap().powi(2)
            })
            .sum::<f64>()
            / 1000.0;
        own + (tension - with) * square
    };
    let least = cost(5.0, 5.0);
    let near = [4.9, 5.1].map(|with| cost(5.0, with) - least);
    let far = [4.8, 5.2].map(|with| cost(5.0, with) - least);
    for (near, far) in near.into_iter().zip(far) {
        assert!(near > 0.0, "{near}");
        // Four times as much at twice the distance, up to third order.
        assert!((far / near - 4.0).abs() < 0.3, "{}", far / near);
    }
}

#[test]
fn without_time_for_it_tension_is_refused() {
    let points = walk((3, 1), 3, 0.5, &mut Rng::new(1));
    let refused = cubic_spline(
        &[0.0, 1.0, 3.0],
        &views(&points),
        &EndConditions::Natural,
        &in_tension(17.0),
        Interrupt::NEVER,
    );
    match refused {
        Err(Error::InvalidArgument {
            name: "tension",
            found,
            ..
        }) => {
            assert_within(
                (found - 68.0).abs(),
                1e-12,
                "by the square of the longest leg",
            );
        }
        other => panic!("{:?}", other.map(|(_, report)| report)),
    }
}

/// Up to the largest tension of a leg, for knots 0.6 to 0.9 apart at uneven times.
#[test]
fn splines_are_found_up_to_the_largest_tension() {
    let mut lost = Vec::new();
    for shape in [(2, 1), (3, 1), (3, 2), (3, 3), (5, 2), (6, 3)] {
        for seed in 0..4 {
            let mut rng = Rng::new(60 + seed);
            let mut points = vec![random_point(shape.0, shape.1, &mut rng)];
            let mut t = vec![0.0];
            for i in 0..6 {
                let step = random_tangent(&points[i], 0.6 + 0.05 * i as f64, &mut rng);
                points.push(retract(&points[i], &step));
                t.push(t[i] + 1.0 - 0.1 * (i % 3) as f64);
            }
            for tension in [9.0, 11.0, 20.0, 35.0, 50.0, 63.0] {
                let found = cubic_spline(
                    &t,
                    &views(&points),
                    &EndConditions::Natural,
                    &in_tension(tension),
                    Interrupt::NEVER,
                );
                match found {
                    Ok((_, report)) if report.iterations <= 12 => (),
                    Ok((_, report)) => lost.push(format!("{shape:?} {seed} {tension}: {report}")),
                    Err(error) => lost.push(format!("{shape:?} {seed} {tension}: {error}")),
                }
            }
        }
    }
    assert!(lost.is_empty(), "{} of 144: {lost:#?}", lost.len());
}
