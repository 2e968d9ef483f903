//! Sectional curvature: its bounds, and vectors that span no plane.

use faer::{Mat, Scale};
use stiefel_rs::{Error, Metric, Stiefel};

use crate::common::{
    Rng, Worst, assert_within, distance, frobenius, identity, random_point, random_tangent,
};
use crate::metrics::{each_shape, inner, manifold, metrics, r, sectional};

#[test]
fn canonical_sectional_curvature_is_between_zero_and_five_quarters() {
    let mut rng = Rng::new(123);
    for (n, k) in [(3, 2), (4, 2), (5, 3), (6, 6), (6, 2), (8, 4)] {
        let m = Stiefel::new(n, k).unwrap();
        for i in 0..300 {
            let s = random_point(n, k, &mut rng);
            let [u, v] = std::array::from_fn(|_| {
                let a = random_tangent(&s, 1.0, &mut rng);
                // Every third pair has low rank, for which the curvature is large.
                let thin = Mat::from_fn(n, k, |p, q| {
                    if q < 2 && i % 3 == 0 {
                        30.0 * a[(p, q)]
                    } else {
                        a[(p, q)]
                    }
                });
                m.project_tangent(s.as_ref(), thin.as_ref()).unwrap()
            });
            let value = sectional(m, &s, &u, &v);
            assert!(
                (-1e-14..=1.25 + 1e-14).contains(&value),
                "({n}, {k}): {value}"
            );
        }
    }
}

#[test]
fn five_quarters_are_attained() {
    for (n, k) in [(4, 2), (6, 3), (20, 4)] {
        let s = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
        let block = |entries: [[f64; 2]; 2]| {
            Mat::from_fn(n, k, |i, j| {
                if (k..k + 2).contains(&i) && j < 2 {
                    entries[i - k][j]
                } else {
                    0.0
                }
            })
        };
        let (u, v) = (
            block([[1.0, 0.0], [0.0, 1.0]]),
            block([[0.0, -1.0], [1.0, 0.0]]),
        );
        let value = sectional(Stiefel::new(n, k).unwrap(), &s, &u, &v);
        assert_within((value - 1.25).abs(), 1e-15, &format!("({n}, {k})"));
    }
}

#[test]
fn sectional_curvature_depends_on_the_plane_alone() {
    let mut worst = Worst::new("another basis");
    each_shape(124, |s, [u, v, ..], place| {
        for metric in metrics() {
            let m = manifold(s, metric);
            let value = sectional(m, s, u, v);
            for (a, b) in [
                (u * Scale(3.0) - v, u + v * Scale(0.2)),
                (u * Scale(1e-200), v * Scale(1e150)),
                (v.clone(), u.clone()),
            ] {
                worst.see((sectional(m, s, &a, &b) - value).abs(), || {
                    format!("{place}, {metric:?}")
                });
            }
            // A thin plane: eps / 1e-4.
            let thin = sectional(m, s, u, &(u + v * Scale(1e-4)));
            assert_within(
                (thin - value).abs(),
                1e-10,
                &format!("thin, {place}, {metric:?}"),
            );
        }
    });
    worst.assert_at_most(1e-14);
}

#[test]
fn vectors_that_span_no_plane_are_refused_with_their_area() {
    let mut rng = Rng::new(125);
    let s = random_point(5, 2, &mut rng);
    let m = manifold(&s, Metric::CANONICAL);
    let [u, v] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
    let zero = Mat::zeros(5, 2);
    for (a, b) in [
        (&u, &u * Scale(-2.0)),
        (&zero, u.clone()),
        (&u, zero.clone()),
    ] {
        match m.sectional_curvature(s.as_ref(), a.as_ref(), b.as_ref()) {
            Err(Error::LinearlyDependent { area, .. }) => assert_within(area, 1e-15, "area"),
            other => panic!("{other:?}"),
        }
    }
    match m.sectional_curvature(s.as_ref(), u.as_ref(), (&u + &v * Scale(1e-9)).as_ref()) {
        Err(Error::LinearlyDependent { area, .. }) => {
            let exact = 1e-9 * (1.0 - inner(m, &s, &u, &v).powi(2)).sqrt();
            assert_within((area - exact).abs(), 1e-15, "area");
        }
        other => panic!("{other:?}"),
    }
    // The circle has no planes.
    let s = random_point(2, 1, &mut rng);
    let (u, v) = (
        random_tangent(&s, 1.0, &mut rng),
        random_tangent(&s, 3.0, &mut rng),
    );
    let error =
        manifold(&s, Metric::CANONICAL).sectional_curvature(s.as_ref(), u.as_ref(), v.as_ref());
    assert!(
        matches!(error, Err(Error::LinearlyDependent { .. })),
        "{error:?}"
    );
}

#[test]
fn vectors_that_are_nothing_but_round_off() {
    // Short enough to pass the check of tangent vectors, although no part of them is tangent.
    let mut rng = Rng::new(127);
    for s in [
        identity(4).subcols(0, 2).to_owned(),
        random_point(4, 2, &mut rng),
    ] {
        for metric in metrics() {
            let m = manifold(&s, metric);
            let v = random_tangent(&s, 1.0, &mut rng);
            let noise = &s * Scale(1e-12);
            for (a, b, c) in [(&noise, &v, &v), (&v, &noise, &v), (&v, &v, &noise)] {
                // Round-off of the noise.
                assert_within(frobenius(r(m, &s, a, b, c).as_ref()), 1e-26, "nothing");
            }
            for (a, b) in [(&noise, &v), (&v, &noise)] {
                match m.sectional_curvature(s.as_ref(), a.as_ref(), b.as_ref()) {
                    Err(Error::LinearlyDependent { area, .. }) => {
                        assert_within(area, 1e-14, "area")
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }
}

#[test]
fn bad_and_extreme_arguments() {
    let mut rng = Rng::new(126);
    let s = random_point(4, 2, &mut rng);
    let m = manifold(&s, Metric::CANONICAL);
    let u = random_tangent(&s, 1.0, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let nan = Mat::from_fn(4, 2, |i, j| if (i, j) == (0, 1) { f64::NAN } else { 0.0 });
    let tensor = |s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>| {
        m.curvature(s.as_ref(), u.as_ref(), v.as_ref(), w.as_ref())
    };
    let plane = |s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>| {
        m.sectional_curvature(s.as_ref(), u.as_ref(), v.as_ref())
    };
    for bad in [nan, Mat::zeros(3, 2), &u + &s] {
        for (i, name) in ["S", "U", "V", "W"].into_iter().enumerate() {
            let mut arguments = [&s, &u, &v, &u];
            arguments[i] = &bad;
            let [a, b, c, d] = arguments;
            let error = tensor(a, b, c, d).unwrap_err();
            assert!(error.to_string().starts_with(name), "{name}: {error}");
            if i < 3 {
                let error = plane(a, b, c).unwrap_err();
                assert!(error.to_string().starts_with(name), "{name}: {error}");
            }
        }
    }
    // Multilinear: extreme lengths may cancel.
    let exact = tensor(&s, &u, &v, &u).unwrap();
    for (a, b, c) in [
        (1e140, 1e-140, 1.0),
        (1e-300, 1e150, 1e150),
        (1e-200, 1e-100, 1.0),
        (1e-300, 1.0, 1.0),
    ] {
        let value = tensor(&s, &(&u * Scale(a)), &(&v * Scale(b)), &(&u * Scale(c))).unwrap();
        let scaled = &exact * Scale(a) * Scale(c) * Scale(b);
        let size = frobenius(scaled.as_ref());
        assert_within(
            distance(&value, &scaled),
            1e-14 * size.max(1e-290),
            &format!("{a:e} {b:e} {c:e}"),
        );
    }
    let huge = &u * Scale(1e140);
    let error = tensor(&s, &huge, &(&v * Scale(1e140)), &huge);
    assert!(matches!(error, Err(Error::Overflow { .. })), "{error:?}");
    let error = tensor(&s, &(&u * Scale(1e300)), &v, &u);
    assert!(
        error.is_ok()
            || matches!(
                error,
                Err(Error::NotTangent { .. } | Error::Overflow { .. })
            ),
        "{error:?}"
    );
}
