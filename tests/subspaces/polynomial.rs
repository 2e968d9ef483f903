//! De Casteljau curves of subspaces: compared with reflections, and the equation of horizontal bases.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, Scale};
use stiefel_rs::{
    Curve, Error, Geodesic, GeometricPolynomial, Grassmann, Interrupt, Quotient, SubspacePolynomial,
};

use crate::common::{
    Rng, Worst, assert_close, assert_within, cyclic_permutation, distance, frobenius,
    orthonormality, random_orthogonal,
};
use crate::{SHAPES, polynomial, reflected, reflection, view, walk};

fn line(angle: f64) -> Mat<f64> {
    Mat::from_fn(2, 1, |i, _| if i == 0 { angle.cos() } else { angle.sin() })
}

fn of_reflections(points: &[Mat<f64>]) -> GeometricPolynomial {
    let reflections: Vec<_> = points.iter().map(|y| reflection(view(y))).collect();
    GeometricPolynomial::try_from(&reflections[..]).unwrap()
}

/// The largest differences of point, velocity, acceleration and jerk, in terms of reflections, each relative to its
/// size.
fn from_reflections(curve: &impl Curve, oracle: &GeometricPolynomial, t: f64) -> [f64; 4] {
    let y = curve.point(t).unwrap();
    let vectors = [
        (curve.derivative(t, 1).unwrap(), oracle.derivative(t, 1)),
        (curve.acceleration(t).unwrap(), oracle.acceleration(t)),
        (curve.jerk(t).unwrap(), oracle.jerk(t)),
    ];
    let point = distance(&reflection(view(&y)), &oracle.point(t).unwrap());
    let [v, a, j] = vectors.map(|(low, high)| {
        let high = high.unwrap();
        distance(&reflected(view(&y), view(&low)), &high) / (1.0 + frobenius(high.as_ref()))
    });
    [point, v, a, j]
}

#[test]
fn spans_are_those_of_reflections() {
    let mut rng = Rng::new(31);
    let names = ["point", "velocity", "acceleration", "jerk"];
    let mut worst = names.map(Worst::new);
    for shape in SHAPES.into_iter().chain([(2, 1), (9, 2), (4, 3)]) {
        for degree in [1, 2, 3, 4] {
            for step in [1e-9, 0.4, 1.0] {
                let points = walk(shape, degree, step, &mut rng);
                let (curve, oracle) = (polynomial(&points), of_reflections(&points));
                for t in [0.0, 0.1, 0.35, 0.5, 0.9, 1.0] {
                    let found = from_reflections(&curve, &oracle, t);
                    let size = (shape.0 * degree) as f64;
                    for (worst, found) in worst.iter_mut().zip(found) {
                        worst.see(found / size, || {
                            format!("{shape:?}, degree {degree}, step {step}, t = {t}")
                        });
                    }
                }
            }
        }
    }
    // The distance of the oracle's points from the manifold, 32 eps n degree; each derivative multiplies it.
    for (worst, factor) in worst.iter().zip([32.0, 64.0, 128.0, 1024.0]) {
        worst.assert_at_most(factor * f64::EPSILON);
    }
}

/// In the metric of reflections lengths double.
#[test]
fn cost_and_length_are_those_of_reflections() {
    let mut rng = Rng::new(40);
    for shape in SHAPES {
        let points = walk(shape, 3, 0.7, &mut rng);
        let (curve, oracle) = (polynomial(&points), of_reflections(&points));
        let cost = 4.0 * curve.cost(Interrupt::NEVER).unwrap()
            / oracle.cost(Interrupt::NEVER).unwrap()
            - 1.0;
        let length = 2.0 * curve.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap()
            / oracle.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap()
            - 1.0;
        assert_within(cost.abs().max(length.abs()), 2e-12, &format!("{shape:?}"));
        let [found, expected] = [
            curve.derivative_bounds(Interrupt::NEVER),
            oracle.derivative_bounds(Interrupt::NEVER),
        ]
        .map(|bounds| bounds.unwrap().acceleration);
        assert_within(
            (2.0 * found / expected - 1.0).abs(),
            1e-9,
            "largest acceleration",
        );
    }
}

/// `Y^T Y' = 0`, orthonormal, and the first basis is the given one.
#[test]
fn bases_turn_as_little_as_possible() {
    let mut rng = Rng::new(32);
    let mut worst = ["orthonormal", "horizontal", "first basis"].map(Worst::new);
    for shape in SHAPES {
        for (degree, step) in [(2, 1.4), (3, 0.9), (5, 0.5)] {
            let points = walk(shape, degree, step, &mut rng);
            let curve = polynomial(&points);
            assert_eq!(curve.quotient(), Quotient::Subspaces);
            let place = || format!("{shape:?}, degree {degree}");
            worst[2].see(distance(&curve.point(0.0).unwrap(), &points[0]), place);
            for i in 0..=40 {
                let t = f64::from(i) / 40.0;
                let (y, v) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
                worst[0].see(orthonormality(&y) / shape.1 as f64, place);
                worst[1].see((y.transpose() * &v).norm_l2() / v.norm_l2(), place);
            }
        }
    }
    for (worst, bound) in worst.iter().zip([8e-15, 1e-14, 2e-14]) {
        worst.assert_at_most(bound);
    }
}

/// `Y' = P' Y` with the derivative of the projector from reflections, by the classical Runge-Kutta method.
#[test]
fn bases_are_those_of_the_equation() {
    const STEPS: u32 = 2000;
    let mut rng = Rng::new(33);
    let mut worst = Worst::new("bases against Runge-Kutta");
    for shape in [(3, 2), (4, 2), (6, 3)] {
        let points = walk(shape, 3, 1.0, &mut rng);
        let (curve, oracle) = (polynomial(&points), of_reflections(&points));
        let rate = |t: f64| oracle.derivative(t, 1).unwrap() * Scale(0.5);
        let h = 1.0 / f64::from(STEPS);
        let mut y = points[0].clone();
        let mut start = rate(0.0);
        for i in 0..STEPS {
            let t = f64::from(i) * h;
            let [middle, end] = [rate(t + 0.5 * h), rate(t + h)];
            let k1 = &start * &y;
            let k2 = &middle * (&y + &k1 * Scale(0.5 * h));
            let k3 = &middle * (&y + &k2 * Scale(0.5 * h));
            let k4 = &end * (&y + &k3 * Scale(h));
            y += (k1 + (k2 + k3) * Scale(2.0) + k4) * Scale(h / 6.0);
            start = end;
            if (i + 1) % 200 == 0 {
                worst.see(distance(&curve.point(t + h).unwrap(), &y), || {
                    format!("{shape:?}")
                });
            }
        }
    }
    // The error of the method with this step; with half the step it is a sixteenth.
    worst.assert_at_most(2e-12);
}

#[test]
fn other_bases_give_the_same_subspaces() {
    let mut rng = Rng::new(34);
    let mut worst = Worst::new("other representatives");
    for (step, outside) in [(1.2, 0.0), (0.4, 0.2)] {
        for shape in SHAPES {
            let points = walk(shape, 3, step, &mut rng);
            let turns: Vec<_> = points
                .iter()
                .map(|_| random_orthogonal(shape.1, &mut rng))
                .collect();
            let turned: Vec<_> = points.iter().zip(&turns).map(|(y, q)| y * q).collect();
            let (curve, other) = (polynomial(&points), polynomial(&turned));
            for t in [-outside, 0.2, 0.5, 0.9, 1.0 + outside] {
                for nu in 0..=3 {
                    let expected = curve.derivative(t, nu).unwrap() * &turns[0];
                    let error = distance(&other.derivative(t, nu).unwrap(), &expected);
                    worst.see(error / (1.0 + frobenius(expected.as_ref())), || {
                        format!("{shape:?}, t = {t}, derivative {nu}")
                    });
                }
            }
        }
    }
    worst.assert_at_most(1e-12);
}

/// Each derivative compared with an eighth-order difference of the previous one, also outside the interval.
#[test]
fn derivatives_are_those_of_the_position() {
    let mut rng = Rng::new(36);
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut worst = Worst::new("derivatives against differences, relative");
    for shape in SHAPES {
        let curve = polynomial(&walk(shape, 3, 0.4, &mut rng));
        for t in [-0.2, 0.04, 0.5, 0.96, 1.2] {
            for nu in 0..3 {
                let h = 0.01;
                let mut difference = Mat::<f64>::zeros(shape.0, shape.1);
                for (i, weight) in weights.iter().enumerate() {
                    let step = (i + 1) as f64 * h;
                    let [after, before] =
                        [t + step, t - step].map(|t| curve.derivative(t, nu).unwrap());
                    difference += (after - before) * Scale(weight / h);
                }
                let exact = curve.derivative(t, nu + 1).unwrap();
                let error = distance(&difference, &exact) / (1.0 + frobenius(exact.as_ref()));
                worst.see(error, || format!("{shape:?}, t = {t}, order {}", nu + 1));
            }
        }
    }
    worst.assert_at_most(1e-10);
}

/// Lines in the plane: a polynomial of the angle, until an intermediate angle is a right angle.
#[test]
fn lines_of_the_plane_have_a_polynomial_as_their_angle() {
    let points = [line(0.0), line(1.2), -line(0.3), line(1.8)];
    let curve = polynomial(&points);
    for i in -40..=80 {
        let t = f64::from(i) / 40.0;
        let u = 1.0 - t;
        let angle = 3.0 * u * u * t * 1.2 + 3.0 * u * t * t * 0.3 + t * t * t * 1.8;
        let slope = 3.6 * (u * u - 2.0 * u * t) + 0.9 * (2.0 * u * t - t * t) + 5.4 * t * t;
        // The last stage, whose two points are the first to become orthogonal: at -0.0812 and 1.0145.
        let last = 1.2 - 4.2 * t + 4.5 * t * t;
        let found = curve.point(t);
        if last.abs() < FRAC_PI_2 && (-0.1..=1.1).contains(&t) {
            let (sin, cos) = angle.sin_cos();
            let velocity = Mat::from_fn(2, 1, |i, _| if i == 0 { -sin } else { cos });
            let place = format!("t = {t}");
            assert_close(&found.unwrap(), &line(angle), 2e-14, &place);
            let exact = velocity * Scale(slope);
            assert_close(&curve.derivative(t, 1).unwrap(), &exact, 1e-13, &place);
        } else {
            let error = found.map(|_| t).unwrap_err();
            assert!(matches!(error, Error::RightAngle { .. }), "{error}");
            assert_within((error.angle().unwrap() - FRAC_PI_2).abs(), 1e-8, "angle");
        }
    }
}

#[test]
fn degree_one_is_the_geodesic() {
    let mut rng = Rng::new(37);
    for shape in SHAPES {
        let points = walk(shape, 1, 1.5, &mut rng);
        let manifold = Grassmann::new(shape.0, shape.1).unwrap();
        let line: Geodesic = manifold
            .geodesic_between(view(&points[0]), view(&points[1]))
            .unwrap();
        let curve = polynomial(&points);
        for t in [-2.0, 0.0, 0.4, 1.0, 3.0, -400.0, 2000.0] {
            let (found, expected) = (curve.point(t).unwrap(), line.point(t).unwrap());
            assert_close(
                &found,
                &expected,
                1e-13_f64.max(1e-14 * t.abs()),
                &format!("{shape:?}, t = {t}"),
            );
        }
    }
}

/// Coordinate columns, repeated angles, equal points, the whole space.
#[test]
fn degenerate_points() {
    let mut rng = Rng::new(38);
    let columns = |n: usize, which: &[usize]| {
        let identity = Mat::<f64>::identity(n, n);
        Mat::from_fn(n, which.len(), |i, j| identity[(i, which[j])])
    };
    // The same plane three times, with its columns exchanged.
    let same = [
        columns(5, &[1, 3]),
        columns(5, &[3, 1]),
        -columns(5, &[1, 3]),
        columns(5, &[3, 1]),
    ];
    let curve = polynomial(&same);
    for t in [0.0, 0.3, 1.0, 7.0] {
        assert_close(&curve.point(t).unwrap(), &same[0], 1e-14, "constant");
        assert_within(curve.derivative(t, 3).unwrap().norm_l2(), 1e-15, "constant");
    }
    // The weights of the two ends are 1000 there.
    assert_close(
        &curve.point(-1000.0).unwrap(),
        &same[0],
        1e-11,
        "constant, far away",
    );
    assert_within(curve.cost(Interrupt::NEVER).unwrap(), 1e-25, "constant");
    // The manifold is a single point.
    let whole = [
        cyclic_permutation(4),
        Mat::identity(4, 4),
        random_orthogonal(4, &mut rng),
    ];
    let curve = polynomial(&whole);
    assert_close(&curve.point(0.7).unwrap(), &whole[0], 1e-14, "k = n");
    assert_within(
        curve.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap(),
        1e-13,
        "k = n",
    );
    // Equal principal angles: coordinate planes that rotate into one another.
    let (a, b) = (columns(6, &[0, 1]), columns(6, &[2, 3]));
    let c = columns(6, &[4, 5]);
    let between = |x: &Mat<f64>, y: &Mat<f64>, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        x * Scale(cos) + y * Scale(sin)
    };
    let points = [
        a.clone(),
        between(&a, &b, 0.9) * cyclic_permutation(2),
        between(&a, &c, 0.9),
        between(&b, &c, 0.9),
    ];
    let (curve, oracle) = (polynomial(&points), of_reflections(&points));
    for t in [0.0, 0.25, 0.5, 1.0] {
        let found = from_reflections(&curve, &oracle, t);
        for (found, bound) in found.into_iter().zip([4e-14, 1e-13, 1e-12, 1e-11]) {
            assert_within(found, bound, &format!("repeated angles, t = {t}"));
        }
    }
}

#[test]
fn right_angles_are_errors_with_the_angle() {
    let e = Mat::<f64>::identity(4, 4);
    let plane = |i: usize, j: usize| Mat::from_fn(4, 2, |row, col| e[(row, [i, j][col])]);
    let points = [plane(0, 1), plane(0, 2), plane(1, 2)];
    let error = SubspacePolynomial::try_from(&points[..]).unwrap_err();
    assert!(matches!(error, Error::RightAngle { .. }), "{error}");
    assert_within((error.angle().unwrap() - FRAC_PI_2).abs(), 1e-15, "angle");
    // A third of the velocity is 1.8 rad.
    let (y, rest) = (plane(0, 1), Mat::<f64>::zeros(4, 2));
    let v = Mat::from_fn(4, 2, |i, j| if (i, j) == (2, 1) { 5.4 } else { 0.0 });
    for (wrong, [v0, v1]) in [("V0", [&v, &rest]), ("V1", [&rest, &v])] {
        let error = SubspacePolynomial::from_boundary(
            view(&y),
            view(v0),
            view(&y),
            view(v1),
            Interrupt::NEVER,
        )
        .unwrap_err();
        let Error::InvalidArgument { name, found, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(name, wrong);
        assert_within((found - 5.4).abs(), 1e-14, "speed");
    }
    let tilted = Mat::from_fn(4, 2, |i, j| if i == j { 0.1 } else { 0.0 });
    let error = SubspacePolynomial::from_boundary(
        view(&y),
        view(&tilted),
        view(&y),
        view(&rest),
        Interrupt::NEVER,
    )
    .unwrap_err();
    assert!(
        matches!(error, Error::NotHorizontal { name: "V0", .. }),
        "{error}"
    );
}

/// Up to angles near pi/2, with the accuracy that the least cosine allows.
#[test]
fn angles_next_to_a_right_one() {
    let mut rng = Rng::new(39);
    for gap in [1e-2, 1e-4] {
        let mut worst = Worst::new(&format!("{gap} below pi/2"));
        for shape in [(3, 1), (4, 2), (6, 3)] {
            let points = walk(shape, 3, FRAC_PI_2 - gap, &mut rng);
            let (curve, oracle) = (polynomial(&points), of_reflections(&points));
            for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let y = curve.point(t).unwrap();
                let off = distance(&reflection(view(&y)), &oracle.point(t).unwrap());
                let v = curve.derivative(t, 1).unwrap();
                let turned = (y.transpose() * &v).norm_l2() / v.norm_l2();
                worst.see(off.max(turned), || format!("{shape:?}, t = {t}"));
            }
        }
        worst.assert_at_most(1e-14 / gap);
    }
    // Closer than frames allow: lines in the plane, whose angle is linear.
    for gap in [1e-7, 1e-10] {
        let step = FRAC_PI_2 - gap;
        let points = [0.0, step, 2.0 * step, 3.0 * step].map(line);
        let curve = polynomial(&points);
        for t in [0.0, 0.3, 0.5, 1.0] {
            let found = curve.point(t).unwrap();
            assert_close(
                &found,
                &line(3.0 * step * t),
                1e-15 / gap,
                &format!("{gap}, t = {t}"),
            );
        }
    }
}

/// Many columns and high degrees: pieces are still resolved to round-off.
#[test]
fn large_subspaces_and_high_degrees() {
    let mut rng = Rng::new(42);
    let mut worst = Worst::new("large: horizontal, last subspace");
    for (shape, degree) in [((60, 20), 3), ((200, 8), 4), ((12, 4), 10), ((3, 1), 10)] {
        let points = walk(shape, degree, 0.9, &mut rng);
        let curve = polynomial(&points);
        let end = curve.point(1.0).unwrap();
        let last = &points[degree];
        worst.see(distance(&end, &(last * (last.transpose() * &end))), || {
            format!("{shape:?}, last")
        });
        for t in [0.13, 0.77] {
            let (y, v) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
            let turned = (y.transpose() * &v).norm_l2() / v.norm_l2();
            worst.see(turned.max(orthonormality(&y)), || {
                format!("{shape:?}, t = {t}")
            });
        }
    }
    worst.assert_at_most(4e-13);
}
