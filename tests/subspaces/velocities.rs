//! Velocities from subspaces alone: compared with spheres, and with logarithms and transports.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::spline::{
    VelocityEstimate, cubic_hermite, estimate_closed_velocities, estimate_velocities,
};
use stiefel_rs::{Curve, Error, Grassmann, Interrupt, Quotient, Result};

use crate::common::{
    Rng, assert_close, assert_within, gaussian, random_orthogonal, random_point, random_skew,
};
use crate::spline::{bases, views};
use crate::{SHAPES, boundary_options, horizontal, view};

const ESTIMATES: [VelocityEstimate; 3] = [
    VelocityEstimate::CatmullRom,
    VelocityEstimate::Akima,
    VelocityEstimate::Natural,
];

const T: [f64; 6] = [0.0, 1.0, 1.8, 3.0, 4.1, 4.6];

/// Slopes of size 2, tens of operations.
const ROUND_OFF: f64 = 400.0 * f64::EPSILON;

fn of_subspaces(t: &[f64], points: &[Mat<f64>], estimate: VelocityEstimate) -> Vec<Mat<f64>> {
    estimate_velocities(t, &views(points), estimate, Quotient::Subspaces).unwrap()
}

/// The same points, each with a different basis.
fn turned(points: &[Mat<f64>], rng: &mut Rng) -> [Vec<Mat<f64>>; 2] {
    let turns: Vec<Mat<f64>> = points
        .iter()
        .map(|y| random_orthogonal(y.ncols(), rng))
        .collect();
    let points = points.iter().zip(&turns).map(|(y, q)| y * q).collect();
    [points, turns]
}

#[test]
fn lines_are_points_of_the_sphere() {
    let mut rng = Rng::new(31);
    for n in [2, 3, 5, 40] {
        // Within a half sphere, where nearby lines are nearby points.
        let mut on_sphere = bases((n, 1), T.len(), 0.3, &mut rng);
        for i in 1..T.len() {
            let inner = (on_sphere[i - 1].transpose() * &on_sphere[i])[(0, 0)];
            on_sphere[i] = &on_sphere[i] * Scale(inner.signum());
        }
        let mut closed = on_sphere.clone();
        closed[4] = closed[0].clone();
        for estimate in ESTIMATES {
            for (points, is_closed) in [(&on_sphere[..], false), (&closed[..5], true)] {
                let call = if is_closed {
                    estimate_closed_velocities
                } else {
                    estimate_velocities
                };
                let t = &T[..points.len()];
                let [lines, signs] = turned(points, &mut rng);
                let expected = call(t, &views(points), estimate, Quotient::Frames).unwrap();
                let found = call(t, &views(&lines), estimate, Quotient::Subspaces).unwrap();
                for (knot, v) in found.iter().enumerate() {
                    let expected = &expected[knot] * &signs[knot];
                    let what = format!("{n} {estimate:?} {is_closed} {knot}");
                    assert_close(v, &expected, ROUND_OFF, &what);
                }
            }
        }
    }
}

#[test]
fn a_loop_of_lines_is_a_loop_on_the_circle_of_twice_the_angle() {
    // A full loop: the last line is the first one, with the opposite basis.
    let (t, turn) = ([0.0, 0.7, 1.8, 2.9, 3.5], std::f64::consts::PI);
    let angles = [0.2, 0.9, 1.5, 2.6, 0.2 + turn];
    let lines = angles.map(|a: f64| faer::mat![[a.cos()], [a.sin()]]);
    let circle = angles.map(|a: f64| faer::mat![[(2.0 * a).cos()], [(2.0 * a).sin()]]);
    for estimate in ESTIMATES {
        let [v, w] = [(&lines, Quotient::Subspaces), (&circle, Quotient::Frames)].map(
            |(points, quotient)| {
                let v = estimate_closed_velocities(&t, &views(points), estimate, quotient).unwrap();
                let rates = v.iter().zip(points);
                let rates = rates.map(|(v, y)| v[(1, 0)] * y[(0, 0)] - v[(0, 0)] * y[(1, 0)]);
                rates.collect::<Vec<f64>>()
            },
        );
        for (v, w) in v.iter().zip(&w) {
            assert_within((2.0 * v - w).abs(), ROUND_OFF, &format!("{estimate:?}"));
        }
        assert_within((v[0] - v[4]).abs(), ROUND_OFF, "where it closes");
    }
}

/// The logarithm between given bases, and the transport of a vector from one given basis to another.
struct Oracle<'a> {
    manifold: Grassmann,
    points: &'a [Mat<f64>],
}

impl Oracle<'_> {
    fn log(&self, from: usize, to: usize) -> Mat<f64> {
        let [y0, y1] = [from, to].map(|i| view(&self.points[i]));
        self.manifold.log(y0, y1).unwrap()
    }

    fn carried(&self, from: usize, to: usize, v: &Mat<f64>) -> Mat<f64> {
        let [y0, y1] = [from, to].map(|i| view(&self.points[i]));
        let log = self.manifold.log(y0, y1).unwrap();
        let moved = self.manifold.transport(y0, view(&log), view(v)).unwrap();
        let reached = self.manifold.exp(y0, view(&log)).unwrap();
        moved * (reached.transpose() * y1)
    }
}

#[test]
fn parabolas_and_splines_of_logarithms() {
    let mut rng = Rng::new(32);
    for (n, k) in [&SHAPES[..], &[(40, 2), (9, 4), (4, 3)]].concat() {
        let points = bases((n, k), T.len(), 0.8, &mut rng);
        let manifold = Grassmann::new(n, k).unwrap();
        let oracle = Oracle {
            manifold,
            points: &points,
        };
        let h: Vec<f64> = T.windows(2).map(|t| t[1] - t[0]).collect();
        let [before, after] = [
            |o: &Oracle<'_>, i: usize| o.log(i, i - 1) * Scale(-1.0 / (T[i] - T[i - 1])),
            |o: &Oracle<'_>, i: usize| o.log(i, i + 1) * Scale(1.0 / (T[i + 1] - T[i])),
        ];
        let what = format!("({n}, {k})");
        let v = of_subspaces(&T, &points, VelocityEstimate::CatmullRom);
        for i in 1..5 {
            let mean = before(&oracle, i) * Scale(h[i]) + after(&oracle, i) * Scale(h[i - 1]);
            let mean = mean * Scale(1.0 / (h[i] + h[i - 1]));
            assert_close(&v[i], &mean, ROUND_OFF, &what);
        }
        let first = after(&oracle, 0) * Scale(2.0) - oracle.carried(1, 0, &v[1]);
        assert_close(&v[0], &first, ROUND_OFF, &what);
        let last = before(&oracle, 5) * Scale(2.0) - oracle.carried(4, 5, &v[4]);
        assert_close(&v[5], &last, ROUND_OFF, &what);
        let v = of_subspaces(&T, &points, VelocityEstimate::Natural);
        // Second derivatives of cubics in tangent spaces, at the start and at the end of a leg.
        let starts = |i: usize| {
            let next = oracle.carried(i + 1, i, &v[i + 1]);
            (after(&oracle, i) * Scale(6.0) - &v[i] * Scale(4.0) - next * Scale(2.0))
                * Scale(1.0 / h[i])
        };
        let ends = |i: usize| {
            let last = oracle.carried(i - 1, i, &v[i - 1]);
            (last * Scale(2.0) + &v[i] * Scale(4.0) - before(&oracle, i) * Scale(6.0))
                * Scale(1.0 / h[i - 1])
        };
        let zero = Mat::zeros(n, k);
        assert_close(&starts(0), &zero, 10.0 * ROUND_OFF, &what);
        assert_close(&ends(5), &zero, 10.0 * ROUND_OFF, &what);
        for i in 1..5 {
            assert_close(&starts(i), &ends(i), 10.0 * ROUND_OFF, &what);
        }
        for i in 0..6 {
            manifold
                .check_tangent("V", view(&points[i]), view(&v[i]), ROUND_OFF)
                .unwrap();
        }
    }
}

#[test]
fn a_basis_turns_its_own_velocity_only() {
    let mut rng = Rng::new(33);
    for (n, k) in [&SHAPES[..], &[(60, 3)]].concat() {
        let mut points = bases((n, k), T.len(), 0.7, &mut rng);
        points[5] = &points[0] * random_orthogonal(k, &mut rng);
        let [others, turns] = turned(&points, &mut rng);
        for estimate in ESTIMATES {
            for call in [estimate_velocities, estimate_closed_velocities] {
                let [v, w] = [&points, &others]
                    .map(|y| call(&T, &views(y), estimate, Quotient::Subspaces).unwrap());
                for knot in 0..6 {
                    let what = format!("({n}, {k}) {estimate:?} {knot}");
                    assert_close(&w[knot], &(&v[knot] * &turns[knot]), ROUND_OFF, &what);
                }
            }
            let call = estimate_closed_velocities;
            let v = call(&T, &views(&points), estimate, Quotient::Subspaces).unwrap();
            let turn = points[0].transpose() * &points[5];
            assert_close(&v[5], &(&v[0] * turn), ROUND_OFF, "where it closes");
            let options = boundary_options();
            cubic_hermite(&T, &views(&points), &views(&v), &options, Interrupt::NEVER).unwrap();
        }
    }
}

#[test]
fn closed_curves_have_no_first_knot() {
    let mut rng = Rng::new(34);
    for (n, k) in SHAPES {
        let mut points = bases((n, k), 5, 0.6, &mut rng);
        points.push(&points[0] * random_orthogonal(k, &mut rng));
        let mut later = points[1..5].to_vec();
        later.extend([0, 1].map(|knot: usize| points[knot].clone()));
        let mut times = T[1..].to_vec();
        times.push(T[5] + 1.0);
        for estimate in ESTIMATES {
            let call = estimate_closed_velocities;
            let v = call(&T, &views(&points), estimate, Quotient::Subspaces).unwrap();
            let w = call(&times, &views(&later), estimate, Quotient::Subspaces).unwrap();
            for knot in 0..4 {
                assert_close(&w[knot], &v[knot + 1], ROUND_OFF, "later");
            }
            assert_close(&w[4], &v[0], ROUND_OFF, "later");
        }
    }
}

#[test]
fn geodesics_have_their_velocity() {
    let mut rng = Rng::new(35);
    for (n, k) in [&SHAPES[..], &[(40, 2)]].concat() {
        let y = random_point(n, k, &mut rng);
        let v = horizontal(view(&y), gaussian(n, k, &mut rng).as_ref());
        let v = &v * Scale(0.4 / v.norm_l2());
        let curve = Grassmann::new(n, k)
            .unwrap()
            .geodesic(view(&y), view(&v))
            .unwrap();
        let [points, turns] = turned(&T.map(|t| curve.point(t).unwrap()), &mut rng);
        for estimate in ESTIMATES {
            let found = of_subspaces(&T, &points, estimate);
            for (knot, t) in T.iter().enumerate() {
                let expected = curve.derivative(*t, 1).unwrap() * &turns[knot];
                assert_close(
                    &found[knot],
                    &expected,
                    ROUND_OFF,
                    &format!("({n}, {k}) {t}"),
                );
            }
        }
    }
}

/// Slope of the errors at interior samples of a fixed smooth curve, for 16 to 256 legs of unequal length.
fn order((n, k): (usize, usize), estimate: VelocityEstimate) -> f64 {
    let mut rng = Rng::new(36);
    let y = random_point(n, k, &mut rng);
    let [a, b] = [0.6, 0.4].map(|size| random_skew(n, size, &mut rng));
    let exact = |t: f64| {
        let turn = |a: &Mat<f64>, t: f64| stiefel_rs::skew_exp((a * Scale(t)).as_ref()).unwrap();
        turn(&a, t) * turn(&b, (2.0 * t).sin()) * &y
    };
    // In closed form: the derivative of the second factor commutes with it.
    let velocity = |t: f64| {
        let turn = |a: &Mat<f64>, t: f64| stiefel_rs::skew_exp((a * Scale(t)).as_ref()).unwrap();
        let inner = turn(&b, (2.0 * t).sin()) * &y;
        let change = &a * &inner + &b * &inner * Scale(2.0 * (2.0 * t).cos());
        let all = turn(&a, t) * change;
        horizontal(view(&exact(t)), view(&all))
    };
    let error = |legs: usize| {
        let time = |i: usize| (4.0 * i as f64 + (i % 2) as f64) / legs as f64;
        let t: Vec<f64> = (0..=legs).map(time).collect();
        let points: Vec<Mat<f64>> = t.iter().map(|t| exact(*t)).collect();
        let v = of_subspaces(&t, &points, estimate);
        let inside = (legs / 4..3 * legs / 4).map(|i| (&v[i] - velocity(t[i])).norm_l2());
        inside.fold(0.0, f64::max)
    };
    let errors: Vec<f64> = [16, 32, 64, 128, 256].into_iter().map(error).collect();
    println!("({n}, {k}) {estimate:?}: {errors:?}");
    (errors[0] / errors[4]).log2() / 4.0
}

#[test]
fn orders_of_the_estimates() {
    for (shape, estimate, expected) in [
        ((5, 2), VelocityEstimate::CatmullRom, 2.0),
        ((5, 2), VelocityEstimate::Natural, 3.0),
        ((6, 3), VelocityEstimate::Natural, 3.0),
    ] {
        let slope = order(shape, estimate);
        assert!(
            (slope - expected).abs() < 0.2,
            "{shape:?} {estimate:?}: {slope}"
        );
    }
}

#[test]
fn coordinate_columns_permutations_and_the_whole_space() {
    // Planes of the first two axes, each in another order, and one rotated by 0.3 towards the third axis.
    let e = Mat::<f64>::identity(4, 4);
    let (sin, cos) = 0.3_f64.sin_cos();
    let moved = e.as_ref().col(0) * Scale(cos) + e.as_ref().col(2) * Scale(sin);
    let plane = |a: faer::ColRef<'_, f64>, b: faer::ColRef<'_, f64>| {
        Mat::from_fn(4, 2, |i, j| [a[i], b[i]][j])
    };
    let points = [
        plane(e.as_ref().col(0), e.as_ref().col(1)),
        plane(e.as_ref().col(1), moved.as_ref()),
        plane(e.as_ref().col(1), e.as_ref().col(0)),
    ];
    let v = of_subspaces(&[0.0, 1.0, 2.0], &points, VelocityEstimate::CatmullRom);
    let up = Mat::from_fn(4, 2, |i, j| if (i, j) == (2, 0) { 0.6 } else { 0.0 });
    assert_close(&v[0], &up, ROUND_OFF, "first");
    assert_within(v[1].norm_l2(), ROUND_OFF, "middle");
    let down = Mat::from_fn(4, 2, |i, j| if (i, j) == (2, 1) { -0.6 } else { 0.0 });
    assert_close(&v[2], &down, ROUND_OFF, "last");
    for n in [1, 3] {
        let mut rng = Rng::new(37);
        let points: Vec<Mat<f64>> = (0..3).map(|_| random_orthogonal(n, &mut rng)).collect();
        for estimate in ESTIMATES {
            for v in of_subspaces(&[0.0, 1.0, 3.0], &points, estimate) {
                assert_eq!(v.norm_l2(), 0.0, "{n} {estimate:?}");
            }
        }
    }
}

#[test]
fn right_angles_and_open_ends_are_refused() {
    let e = Mat::<f64>::identity(4, 4);
    let pair = |i: usize, j: usize| Mat::from_fn(4, 2, |row, col| e[(row, [i, j][col])]);
    let points = [pair(0, 1), pair(1, 0), pair(1, 2)];
    let call = |points: &[Mat<f64>], closed: bool| -> Result<Vec<Mat<f64>>> {
        let views: Vec<MatRef<'_, f64>> = views(points);
        let (t, estimate) = ([0.0, 1.0, 2.0], VelocityEstimate::Akima);
        match closed {
            true => estimate_closed_velocities(&t, &views, estimate, Quotient::Subspaces),
            false => estimate_velocities(&t, &views, estimate, Quotient::Subspaces),
        }
    };
    let error = call(&points, false).unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 1, .. }), "{error}");
    assert!((error.angle().unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
    let error = call(&points, true).unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 2, .. }), "{error}");
}
