//! Parallel transport: its equation, closed forms, and invariants.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Error, Metric, ParallelTransport, Stiefel, skew_exp};

/// Canonical, Euclidean, and one on each side of these.
fn metrics() -> [Metric; 4] {
    [
        Metric::CANONICAL,
        Metric::EUCLIDEAN,
        Metric::new(1.5).unwrap(),
        Metric::new(-0.8).unwrap(),
    ]
}

fn along(metric: Metric, s: &Mat<f64>, v: &Mat<f64>) -> ParallelTransport {
    let manifold = Stiefel::of("S", s.as_ref()).unwrap().with_metric(metric);
    ParallelTransport::new(manifold, s.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{:?} {metric:?}: {e}", s.shape()))
}

fn moved(transport: &ParallelTransport, w: &Mat<f64>) -> Mat<f64> {
    transport.transport(w.as_ref()).unwrap()
}

/// `(manifold, S, V, W, place)` in each shape and metric; `V` has the given norm.
fn each_case(norm: f64, mut check: impl FnMut(Stiefel, &Mat<f64>, &Mat<f64>, &Mat<f64>, &str)) {
    let mut rng = Rng::new(81);
    for (n, k) in SIZES {
        for metric in metrics() {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, norm, &mut rng);
            let w = random_tangent(&s, 1.0, &mut rng);
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            let place = format!("({n}, {k}), {metric:?}, |V| = {norm}");
            check(manifold, &s, &v, &w, &place);
        }
    }
}

/// The Christoffel term of the metric of weight `w` in the embedding.
fn christoffel(s: &Mat<f64>, v: &Mat<f64>, x: &Mat<f64>, w: f64) -> Mat<f64> {
    let (a, c) = (s.transpose() * v, s.transpose() * x);
    let (b, d) = (project_off(s, v), project_off(s, x));
    let along = b.transpose() * &d + d.transpose() * &b - &a * &c - &c * &a;
    s * along * Scale(0.5) + (b * c + d * a) * Scale(w - 1.0)
}

/// Geodesic and parallel field by the classical Runge-Kutta method on `S'' = -Gamma(S', S')`, `W' = -Gamma(S', W)`.
fn integrated(
    s: &Mat<f64>,
    v: &Mat<f64>,
    w: &Mat<f64>,
    weight: f64,
    steps: usize,
) -> (Mat<f64>, Mat<f64>) {
    let h = 1.0 / steps as f64;
    let rate = |y: &[Mat<f64>; 3]| {
        [
            y[1].clone(),
            christoffel(&y[0], &y[1], &y[1], weight) * Scale(-1.0),
            christoffel(&y[0], &y[1], &y[2], weight) * Scale(-1.0),
        ]
    };
    let step = |y: &[Mat<f64>; 3], f: f64, r: &[Mat<f64>; 3]| -> [Mat<f64>; 3] {
        std::array::from_fn(|i| &y[i] + &r[i] * Scale(f))
    };
    let mut y = [s.clone(), v.clone(), w.clone()];
    for _ in 0..steps {
        let k1 = rate(&y);
        let k2 = rate(&step(&y, 0.5 * h, &k1));
        let k3 = rate(&step(&y, 0.5 * h, &k2));
        let k4 = rate(&step(&y, h, &k3));
        for (f, k) in [(h / 6.0, k1), (h / 3.0, k2), (h / 3.0, k3), (h / 6.0, k4)] {
            y = step(&y, f, &k);
        }
    }
    let [end, _, field] = y;
    (end, field)
}

#[test]
fn transport_solves_the_equation_of_parallel_fields() {
    let mut worst = [
        Worst::new("end of the geodesic"),
        Worst::new("parallel field"),
    ];
    let mut rng = Rng::new(82);
    for (n, k) in [(3, 1), (4, 2), (5, 3), (4, 4), (5, 4), (7, 2), (2, 1)] {
        for metric in metrics() {
            let s = random_point(n, k, &mut rng);
            let (v, w) = (
                random_tangent(&s, 2.0, &mut rng),
                random_tangent(&s, 1.0, &mut rng),
            );
            // Richardson extrapolation cancels the error of order 4.
            let coarse = integrated(&s, &v, &w, metric.weight(), 800);
            let fine = integrated(&s, &v, &w, metric.weight(), 1600);
            let better =
                |fine: Mat<f64>, coarse: Mat<f64>| &fine + (&fine - coarse) * Scale(1.0 / 15.0);
            let (end, field) = (better(fine.0, coarse.0), better(fine.1, coarse.1));
            let transport = along(metric, &s, &v);
            let place = || format!("({n}, {k}), {metric:?}");
            worst[0].see(distance(&transport.end(), &end), place);
            worst[1].see(distance(&moved(&transport, &w), &field), place);
        }
    }
    // Round-off of 1600 steps, and their truncation: (1/1600)^5 = 1e-16 times the sixth derivatives.
    for worst in worst {
        worst.assert_at_most(1e-13);
    }
}

#[test]
fn transport_is_isometric() {
    let mut worst = Worst::new("inner product kept");
    for norm in [1e-300, 1e-9, 0.5, 3.0, 10.0] {
        each_case(norm, |manifold, s, v, w, place| {
            let transport = along(manifold.metric(), s, v);
            let end = transport.end();
            let (a, b) = (moved(&transport, w), moved(&transport, v));
            let size = manifold.norm(s.as_ref(), w.as_ref()).unwrap()
                * manifold.norm(s.as_ref(), v.as_ref()).unwrap();
            let inner = |x: &Mat<f64>, y: &Mat<f64>, z: &Mat<f64>| {
                manifold.inner(x.as_ref(), y.as_ref(), z.as_ref()).unwrap()
            };
            let ww = inner(s, w, w);
            if ww > 0.0 {
                worst.see((inner(&end, &a, &a) - ww).abs() / ww, || {
                    format!("W, W, {place}")
                });
            }
            if size > 1e-200 {
                worst.see((inner(&end, &a, &b) - inner(s, w, v)).abs() / size, || {
                    format!("V, W, {place}")
                });
            }
        });
    }
    worst.assert_at_most(2e-14);
}

#[test]
fn transported_vectors_are_tangent_at_the_end() {
    each_case(3.0, |manifold, s, v, w, place| {
        let transport = along(manifold.metric(), s, v);
        let end = transport.end();
        assert_within(orthonormality(&end), 2e-14, place);
        let a = moved(&transport, w);
        manifold
            .check_tangent("W", end.as_ref(), a.as_ref(), 3e-14)
            .unwrap_or_else(|e| panic!("{place}: {e}"));
    });
}

#[test]
fn transport_there_and_back_is_the_identity() {
    let mut worst = Worst::new("there and back");
    for norm in [0.5, 3.0, 10.0] {
        each_case(norm, |manifold, s, v, w, place| {
            let there = along(manifold.metric(), s, v);
            // The velocity is parallel along its geodesic.
            let arrived = moved(&there, v);
            let back = along(manifold.metric(), &there.end(), &(arrived * Scale(-1.0)));
            worst.see(distance(&back.end(), s), || format!("point, {place}"));
            worst.see(distance(&moved(&back, &moved(&there, w)), w), || {
                format!("vector, {place}")
            });
        });
    }
    // Angles of 10 / sqrt(w), where w is at most 1/0.4, are accurate to 10 eps in each direction.
    worst.assert_at_most(1e-13);
}

#[test]
fn two_halves_make_a_whole() {
    let mut worst = Worst::new("two halves");
    each_case(4.0, |manifold, s, v, w, place| {
        let metric = manifold.metric();
        let whole = along(metric, s, v);
        let first = along(metric, s, &(v * Scale(0.5)));
        let half = moved(&first, &(v * Scale(0.5)));
        let second = along(metric, &first.end(), &half);
        worst.see(distance(&second.end(), &whole.end()), || {
            format!("point, {place}")
        });
        let (split, once) = (moved(&second, &moved(&first, w)), moved(&whole, w));
        worst.see(distance(&split, &once), || format!("vector, {place}"));
    });
    worst.assert_at_most(2e-14);
}

#[test]
fn transport_on_the_rotations_is_two_half_turns() {
    // On a group with a bi-invariant metric: W(1) = S e^{A/2} C e^{A/2}.
    let mut rng = Rng::new(83);
    for m in [2, 3, 4, 7] {
        let s = random_point(m, m, &mut rng);
        let (a, c) = (random_skew(m, 3.0, &mut rng), random_skew(m, 1.0, &mut rng));
        for metric in metrics() {
            let transport = along(metric, &s, &(&s * &a));
            let half = skew_exp((&a * Scale(0.5)).as_ref()).unwrap();
            let exact = &s * &half * &c * &half;
            assert_close(
                &moved(&transport, &(&s * &c)),
                &exact,
                2e-14,
                &format!("SO({m}), {metric:?}"),
            );
        }
    }
}

#[test]
fn transport_on_the_sphere_turns_in_the_plane_of_the_circle() {
    let mut rng = Rng::new(84);
    for n in [2, 3, 10] {
        let s = random_point(n, 1, &mut rng);
        for angle in [1e-8, 0.3, 3.0, 50.0] {
            let v = random_tangent(&s, angle, &mut rng);
            let w = random_tangent(&s, 1.0, &mut rng);
            let u = &v * Scale(1.0 / frobenius(v.as_ref()));
            let along_u = (u.transpose() * &w)[(0, 0)];
            let turned = (&u * Scale(angle.cos() - 1.0) - &s * Scale(angle.sin())) * Scale(along_u);
            let exact = &w + turned;
            for metric in metrics() {
                let transported = moved(&along(metric, &s, &v), &w);
                assert_close(
                    &transported,
                    &exact,
                    1e-14 * angle.max(1.0),
                    &format!("S^{}, {angle}", n - 1),
                );
            }
        }
    }
}

#[test]
fn transport_is_linear_and_equivariant() {
    let mut rng = Rng::new(85);
    each_case(2.0, |manifold, s, v, w, place| {
        let transport = along(manifold.metric(), s, v);
        let combined = moved(&transport, &(v * Scale(3.0) - w));
        let expected = moved(&transport, v) * Scale(3.0) - moved(&transport, w);
        assert_close(&combined, &expected, 1e-13, &format!("linear, {place}"));
        let transported =
            |a: &[Mat<f64>]| vec![moved(&along(manifold.metric(), &a[0], &a[1]), &a[2])];
        assert_equivariant(
            Actions::Both,
            &[s, v, w],
            transported,
            1e-13,
            place,
            &mut rng,
        );
    });
}

#[test]
fn no_way_no_change() {
    each_case(0.0, |manifold, s, v, w, place| {
        for v in [v.clone(), v + random_tangent(s, 1e-300, &mut Rng::new(86))] {
            let transport = along(manifold.metric(), s, &v);
            assert_close(&transport.end(), s, 3e-15, place);
            assert_close(&moved(&transport, w), w, 1e-14, place);
        }
        let nothing = Mat::zeros(s.nrows(), s.ncols());
        assert_close(
            &moved(&along(manifold.metric(), s, w), &nothing),
            &nothing,
            0.0,
            place,
        );
    });
}

#[test]
fn rank_deficient_velocities_have_a_basis_too() {
    let mut rng = Rng::new(87);
    for (n, k) in [(5, 3), (8, 2), (20, 4), (7, 6)] {
        let s = random_point(n, k, &mut rng);
        // With one normal direction, and with none.
        let g = project_off(&s, &gaussian(n, 1, &mut rng)) * gaussian(1, k, &mut rng);
        let omega = random_skew(k, 1.0, &mut rng);
        let w = random_tangent(&s, 1.0, &mut rng);
        for v in [
            project_off(&s, &g),
            &s * &omega,
            project_off(&s, &g) + &s * &omega,
        ] {
            let v = &v * Scale(1.0 / frobenius(v.as_ref()));
            let transport = along(Metric::CANONICAL, &s, &v);
            let (end, field) = integrated(&s, &v, &w, 0.5, 1000);
            // (1/1000)^4 = 1e-12.
            assert_close(&transport.end(), &end, 1e-12, &format!("({n}, {k})"));
            assert_close(
                &moved(&transport, &w),
                &field,
                1e-12,
                &format!("({n}, {k})"),
            );
        }
    }
}

#[test]
fn bad_arguments_are_typed_errors() {
    let mut rng = Rng::new(88);
    let s = random_point(4, 2, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let manifold = Stiefel::new(4, 2).unwrap();
    let start =
        |s: &Mat<f64>, v: &Mat<f64>| ParallelTransport::new(manifold, s.as_ref(), v.as_ref());
    let nan = Mat::from_fn(4, 2, |i, j| if (i, j) == (3, 0) { f64::NAN } else { 0.0 });
    assert!(matches!(
        start(&Mat::zeros(5, 2), &v),
        Err(Error::Shape { name: "S", .. })
    ));
    assert!(matches!(
        start(&s, &Mat::zeros(4, 1)),
        Err(Error::Shape { name: "V", .. })
    ));
    assert!(matches!(
        start(&nan, &v),
        Err(Error::NonFinite { name: "S", .. })
    ));
    assert!(matches!(
        start(&s, &nan),
        Err(Error::NonFinite { name: "V", .. })
    ));
    assert!(matches!(
        start(&(&s * Scale(2.0)), &v),
        Err(Error::NotOrthonormal { .. })
    ));
    assert!(matches!(
        start(&s, &(&v + &s)),
        Err(Error::NotTangent { name: "V", .. })
    ));
    let transport = start(&s, &v).unwrap();
    for (w, name) in [
        (nan, "W"),
        (&v + &s * Scale(0.1), "W"),
        (Mat::zeros(3, 2), "W"),
    ] {
        let error = transport.transport(w.as_ref()).unwrap_err();
        assert!(error.to_string().starts_with(name), "{error}");
    }
}

#[test]
fn extreme_lengths_give_a_vector_or_a_typed_error() {
    let mut rng = Rng::new(89);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let unit = random_tangent(&s, 1.0, &mut rng);
        for metric in [
            Metric::CANONICAL,
            Metric::EUCLIDEAN,
            Metric::new(1e300).unwrap(),
            Metric::new(-1.0 + 1e-15).unwrap(),
        ] {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            for scale in [1e-320, 1e-160, 1e3, 1e6, 1e20, 1e155, 1e300, 1.7e308] {
                match ParallelTransport::new(manifold, s.as_ref(), (&unit * Scale(scale)).as_ref())
                {
                    Ok(transport) => {
                        let end = transport.end();
                        assert_within(
                            orthonormality(&end),
                            1e-13,
                            &format!("({n}, {k}) at {scale:e}"),
                        );
                        for size in [1e-320, 1e-160, 1.0, 1e160, 1e300] {
                            let a = transport.transport((&unit * Scale(size)).as_ref());
                            assert!(
                                a.as_ref().map_or_else(
                                    |e| size > 1e150 && matches!(e, Error::NotTangent { .. }),
                                    |a| frobenius(a.as_ref()).is_finite()
                                ),
                                "({n}, {k}) at {scale:e}, {size:e}: {a:?}"
                            );
                        }
                    }
                    Err(error) => assert!(
                        matches!(
                            error,
                            Error::InvalidArgument { .. }
                                | Error::Overflow { .. }
                                | Error::NotTangent { .. }
                        ) && (scale > 1e3 || metric.weight() > 1e3),
                        "({n}, {k}) at {scale:e}: {error}"
                    ),
                }
            }
        }
    }
}
