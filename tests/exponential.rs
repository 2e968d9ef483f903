//! The Riemannian exponential of the alpha family, compared with n x n formulas and the variational principle.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, Geodesic, Metric, Quantity, Stiefel, skew_exp};

fn metrics() -> [Metric; 4] {
    [
        Metric::CANONICAL,
        Metric::EUCLIDEAN,
        Metric::new(0.7).unwrap(),
        Metric::new(-0.8).unwrap(),
    ]
}

/// `e^{2w S Omega S^T + K S^T - S K^T} S e^{(1 - 2w) Omega}` with `n x n` matrices.
fn full_formula(s: &Mat<f64>, v: &Mat<f64>, metric: Metric) -> Mat<f64> {
    let twice = 2.0 * metric.weight();
    let omega = s.transpose() * v;
    let omega = (&omega - omega.transpose()) * Scale(0.5);
    let k = v - s * &omega;
    let x = s * &omega * s.transpose() * Scale(twice) + &k * s.transpose() - s * k.transpose();
    let x = (&x - x.transpose()) * Scale(0.5);
    let right = skew_exp((&omega * Scale(1.0 - twice)).as_ref()).unwrap();
    skew_exp(x.as_ref()).unwrap() * s * right
}

#[test]
fn exponential_is_the_full_formula() {
    let mut rng = Rng::new(11);
    let mut worst = Worst::new("thin against full exponential");
    for (n, k) in SIZES {
        for metric in metrics() {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            for size in [1e-9, 0.3, 2.0, 9.0] {
                let s = random_point(n, k, &mut rng);
                let v = random_tangent(&s, size, &mut rng);
                let end = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
                let what = || format!("St({n},{k}), alpha {}, size {size}", metric.alpha());
                worst.see(distance(&end, &full_formula(&s, &v, metric)), what);
                worst.see(orthonormality(&end), what);
            }
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn normal_parts_of_deficient_rank() {
    let mut rng = Rng::new(12);
    let mut worst = Worst::new("normal part of small or graded rank");
    for (n, k) in [(12, 4), (6, 4), (9, 3)] {
        let manifold = Stiefel::new(n, k).unwrap();
        for scales in [
            [0.0, 0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
            [1.0, 1e-5, 1e-9, 1e-14],
        ] {
            let s = random_point(n, k, &mut rng);
            let g = project_off(&s, &gaussian(n, k, &mut rng));
            let graded = Mat::from_fn(n, k, |i, j| g[(i, j)] * scales[j]);
            let mixed = project_off(&s, &(graded * random_orthogonal(k, &mut rng)));
            let v = mixed + &s * random_skew(k, 0.5, &mut rng);
            let curve = Geodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
            let end = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
            let what = || format!("St({n},{k}) {scales:?}");
            worst.see(
                distance(&end, &full_formula(&s, &v, Metric::CANONICAL)),
                what,
            );
            worst.see(distance(&curve.initial_velocity(), &v), what);
            worst.see(orthonormality(&end), what);
        }
    }
    worst.assert_at_most(1e-13);
}

/// The exponential needs no basis of the normal directions where these are well-conditioned, and close to that limit
/// agrees with the geodesic, which has one.
#[test]
fn exponential_is_the_end_of_the_geodesic_at_any_condition() {
    let mut rng = Rng::new(14);
    let mut worst = Worst::new("exponential against the end of the geodesic");
    for (n, k) in [(12, 4), (50, 5), (60, 30)] {
        for metric in metrics() {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            for least in [1.0_f64, 0.5, 0.3, 0.2, 0.15, 0.1, 0.05, 0.01] {
                let (s, size) = (random_point(n, k, &mut rng), 4.0 * least);
                let q = project_off(&s, &gaussian(n, k, &mut rng));
                let q = q.qr().compute_thin_Q();
                let grade = |j: usize| size * least.powf(j as f64 / (k - 1) as f64);
                let graded = Mat::from_fn(n, k, |i, j| q[(i, j)] * grade(j));
                let along = &s * random_skew(k, 1.0, &mut rng);
                let v = graded * random_orthogonal(k, &mut rng) + along;
                let end = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
                let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
                let what = || format!("St({n},{k}), alpha {}, {least}", metric.alpha());
                worst.see(distance(&end, &curve.point(1.0).unwrap()), what);
                worst.see(orthonormality(&end), what);
            }
        }
    }
    worst.assert_at_most(2e-14);
}

/// Where the tangential part is much longer than a well-conditioned normal part, the Gram matrix of the latter would lose
/// its digits to cancellation; the largest error is 4.7e-16.
#[test]
fn long_tangential_parts_do_not_cost_digits() {
    let mut rng = Rng::new(15);
    let mut worst = Worst::new("short normal parts");
    for (n, k) in [(12, 4), (50, 5)] {
        let manifold = Stiefel::new(n, k).unwrap();
        for length in [5.0, 20.0, 1e3, 1e4] {
            let s = random_point(n, k, &mut rng);
            let q = project_off(&s, &gaussian(n, k, &mut rng));
            let v = q.qr().compute_thin_Q() + &s * random_skew(k, length, &mut rng);
            let end = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
            let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
            let what = || format!("St({n},{k}), {length}");
            let gap = distance(&end, &curve.point(1.0).unwrap()) / length;
            worst.see(gap, what);
            worst.see(orthonormality(&end) / length, what);
        }
    }
    worst.assert_at_most(1e-14);
}

/// The end of an exponential has at most the defect of its point, some 1e-10 (at most 0.995 times it), and successive
/// exponentials of long vectors, whose defects would otherwise grow by a factor each, stay on the manifold (2.9e-15 after
/// 200).
#[test]
fn defects_of_points_are_not_amplified() {
    let mut rng = Rng::new(16);
    let mut worst = Worst::new("defect of the end, as a multiple of that of the point");
    let mut last = Worst::new("defect after 200 exponentials");
    for (n, k) in [(6, 2), (12, 3), (30, 5), (5, 3)] {
        for metric in metrics() {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            for [normal, along] in [[3.0, 6.0], [1.5, 3.0], [0.5, 1.0], [1.0, 1.0]] {
                let mut tangent = |s: &Mat<f64>| {
                    let n = project_off(s, &gaussian(n, k, &mut rng));
                    let n = &n * Scale(normal / frobenius(n.as_ref()));
                    let raw = n + s * random_skew(k, along, &mut rng);
                    manifold.project_tangent(s.as_ref(), raw.as_ref()).unwrap()
                };
                let what = || format!("St({n},{k}), alpha {}, {normal} {along}", metric.alpha());
                let mut s = random_point(n, k, &mut Rng::new(17));
                let off = Mat::from_fn(n, k, |i, j| {
                    s[(i, j)] * (1.0 + 2e-10 * ((i + 2 * j) as f64).sin())
                });
                let v = tangent(&off);
                let end = manifold.exp(off.as_ref(), v.as_ref()).unwrap();
                worst.see(orthonormality(&end) / orthonormality(&off), what);
                let curve = manifold.geodesic(off.as_ref(), v.as_ref()).unwrap();
                let end = curve.point(1.0).unwrap();
                worst.see(orthonormality(&end) / orthonormality(&off), what);
                for _ in 0..200 {
                    let v = tangent(&s);
                    s = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
                }
                last.see(orthonormality(&s), what);
            }
        }
    }
    worst.assert_at_most(1.1);
    last.assert_at_most(1e-13);
}

/// Ambient geodesic equation of the Euclidean metric: `S'' + S S'^T S' = 0`.
#[test]
fn euclidean_geodesics_have_no_tangential_acceleration() {
    let mut rng = Rng::new(13);
    for (n, k) in SIZES {
        let manifold = Stiefel::new(n, k).unwrap().with_metric(Metric::EUCLIDEAN);
        let s = random_point(n, k, &mut rng);
        let v = random_tangent(&s, 1.5, &mut rng);
        let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
        let [p, d1, d2] = [0, 1, 2].map(|order| {
            let samples = curve.sample(&[0.8], Quantity::Derivative(order), Default::default());
            samples.unwrap().get(0).to_owned()
        });
        let defect = &d2 + &p * (d1.transpose() * &d1);
        assert_within(frobenius(defect.as_ref()), 1e-13, &format!("St({n},{k})"));
    }
}

/// Energy of a polygon through projected points, in the manifold's metric.
fn energy(manifold: &Stiefel, points: &[Mat<f64>]) -> f64 {
    let pieces = (points.len() - 1) as f64;
    points
        .windows(2)
        .map(|pair| {
            let middle = manifold
                .project(((&pair[0] + &pair[1]) * Scale(0.5)).as_ref())
                .unwrap();
            let chord = &pair[1] - &pair[0];
            let v = manifold
                .project_tangent(middle.as_ref(), chord.as_ref())
                .unwrap();
            pieces
                * manifold
                    .inner(middle.as_ref(), v.as_ref(), v.as_ref())
                    .unwrap()
        })
        .sum()
}

#[test]
fn geodesics_are_critical_for_the_energy_of_their_metric_only() {
    let mut rng = Rng::new(14);
    let pieces = 300;
    for (n, k) in [(4, 2), (5, 3), (20, 4)] {
        for metric in metrics() {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            let other = manifold.with_metric(Metric::new(metric.alpha() + 1.0).unwrap());
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, 1.5, &mut rng);
            let z = gaussian(n, k, &mut rng);
            let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
            let bent = |e: f64| -> Vec<Mat<f64>> {
                let t: Vec<f64> = (0..=pieces).map(|i| i as f64 / pieces as f64).collect();
                let samples = curve.sample(&t, Quantity::Derivative(0), Default::default());
                let samples = samples.unwrap();
                t.iter()
                    .zip(samples.iter())
                    .map(|(t, p)| {
                        let bump = e * (std::f64::consts::PI * t).sin();
                        manifold.project((p + &z * Scale(bump)).as_ref()).unwrap()
                    })
                    .collect()
            };
            let (plus, minus) = (bent(1e-3), bent(-1e-3));
            let rate = |m: &Stiefel| (energy(m, &plus) - energy(m, &minus)).abs() / 2e-3;
            let (own, wrong) = (rate(&manifold), rate(&other));
            let what = format!("St({n},{k}), alpha {}", metric.alpha());
            assert_within(own, 2e-3, &what);
            assert!(
                wrong > 10.0 * own,
                "{what}: {wrong} against {own}: the test sees nothing"
            );
        }
    }
}

#[test]
fn speed_is_constant_in_the_metric() {
    let mut rng = Rng::new(15);
    for (n, k) in SIZES {
        for metric in metrics() {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, 1.3, &mut rng);
            let speed = manifold.norm(s.as_ref(), v.as_ref()).unwrap();
            let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
            assert_within((curve.length() - speed).abs(), 1e-14, "length");
            for t in [-2.0, 0.4, 1.0, 7.0] {
                let p = curve.point(t).unwrap();
                let velocity = curve.sample(&[t], Quantity::Derivative(1), Default::default());
                let velocity = velocity.unwrap();
                let here = manifold.norm(p.as_ref(), velocity.get(0)).unwrap();
                let what = format!("St({n},{k}), alpha {}, t {t}", metric.alpha());
                assert_within((here - speed).abs(), 1e-12, &what);
            }
        }
    }
}

#[test]
fn degenerate_velocities() {
    for (n, k) in SIZES {
        for metric in metrics() {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            let s = random_point(n, k, &mut Rng::new(16));
            let end = manifold.exp(s.as_ref(), Mat::zeros(n, k).as_ref()).unwrap();
            assert_close(&end, &s, 1e-15, "zero velocity");
            let unit = random_tangent(&s, 1.0, &mut Rng::new(17));
            for size in [1e-300, 1e-160, 1e-20] {
                let end = manifold
                    .exp(s.as_ref(), (&unit * Scale(size)).as_ref())
                    .unwrap();
                assert_close(&end, &s, 1e-14, "tiny velocity");
            }
            for size in [1e20, 1e155, 1e300] {
                match manifold.exp(s.as_ref(), (&unit * Scale(size)).as_ref()) {
                    Ok(end) => assert_within(orthonormality(&end), 1e-12, "huge velocity"),
                    Err(Error::Overflow { .. } | Error::NotTangent { .. }) => {}
                    Err(error) => panic!("St({n},{k}), {size:e}: {error}"),
                }
            }
        }
    }
}

#[test]
fn bad_input_is_a_typed_error() {
    let manifold = Stiefel::new(4, 2).unwrap();
    let mut rng = Rng::new(18);
    let s = random_point(4, 2, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let exp = |s: &Mat<f64>, v: &Mat<f64>| manifold.exp(s.as_ref(), v.as_ref());
    assert!(matches!(
        exp(&s, &Mat::zeros(3, 2)),
        Err(Error::Shape { .. })
    ));
    assert!(matches!(
        exp(&Mat::zeros(4, 3), &v),
        Err(Error::Shape { .. })
    ));
    assert!(matches!(
        exp(&(&s * Scale(2.0)), &v),
        Err(Error::NotOrthonormal { .. })
    ));
    assert!(matches!(exp(&s, &s), Err(Error::NotTangent { .. })));
    for bad in [f64::NAN, f64::INFINITY] {
        let mut w = v.clone();
        w[(1, 1)] = bad;
        assert!(matches!(
            exp(&s, &w),
            Err(Error::NonFinite {
                name: "V",
                index: 5
            })
        ));
    }
}
