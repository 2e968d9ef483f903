//! Sizes, dimension, and checks of points and tangent vectors.

use faer::{Mat, Scale};
use stiefel_rs::{Error, Stiefel};

use crate::common::{Rng, SIZES, assert_within, frobenius, random_point};
use crate::shapes::{each_shape, manifold};

#[test]
fn sizes_outside_of_one_to_n_are_refused() {
    for (n, k) in [(3, 0), (0, 0), (2, 3)] {
        let error = Stiefel::new(n, k);
        assert!(
            matches!(error, Err(Error::Shape { .. })),
            "St({n}, {k}): {error:?}"
        );
        let error = Stiefel::of("S", Mat::zeros(n, k).as_ref());
        assert!(
            matches!(error, Err(Error::Shape { name: "S", .. })),
            "({n}, {k}): {error:?}"
        );
    }
}

/// Overflowing products of both signs sum to NaN; the defect must be infinite, not NaN.
#[test]
fn defects_of_huge_matrices_are_infinite() {
    let signs = [[1.0, 1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
    for scale in [1e160, 1e200, 1e308] {
        let y = Mat::from_fn(4, 2, |i, j| scale * signs[i][j]);
        match Stiefel::new(4, 2)
            .unwrap()
            .check_point("y", y.as_ref(), 1e-9)
        {
            Err(Error::NotOrthonormal { defect, .. }) => assert_eq!(defect, f64::INFINITY),
            other => panic!("{scale:e}: {other:?}"),
        }
    }
}

#[test]
fn dimension_counts_a_basis_of_the_tangent_space() {
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut Rng::new(1));
        let columns: Vec<Mat<f64>> = (0..n * k)
            .map(|e| {
                let unit = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i + j * n == e)));
                manifold(&s)
                    .project_tangent(s.as_ref(), unit.as_ref())
                    .unwrap()
            })
            .collect();
        let projector = Mat::from_fn(n * k, n * k, |i, j| columns[j][(i % n, i / n)]);
        let trace: f64 = (0..n * k).map(|i| projector[(i, i)]).sum();
        let dim = manifold(&s).dim();
        assert_within(
            (trace - dim as f64).abs(),
            1e-12 * (n * k) as f64,
            &format!("trace - dim, ({n}, {k})"),
        );
    }
}

#[test]
fn check_point_reports_the_measured_defect() {
    each_shape(2, |manifold, s, _, _, place| {
        manifold.check_point("S", s.as_ref(), 1e-13).unwrap();
        let stretched = s * Scale(1.0 + 1e-3);
        match manifold.check_point("S", stretched.as_ref(), 1e-9) {
            Err(Error::NotOrthonormal {
                name: "S",
                defect,
                tolerance,
            }) => {
                let expected = (2e-3 + 1e-6) * (s.ncols() as f64).sqrt();
                assert_within(
                    (defect - expected).abs(),
                    1e-14,
                    &format!("reported defect, {place}"),
                );
                assert_eq!(tolerance, 1e-9);
            }
            other => panic!("expected NotOrthonormal, found {other:?}"),
        }
    });
}

#[test]
fn check_tangent_reports_the_measured_defect() {
    each_shape(3, |manifold, s, v, _, place| {
        manifold
            .check_tangent("V", s.as_ref(), v.as_ref(), 1e-13)
            .unwrap();
        let tilted = v + s * Scale(1e-3);
        match manifold.check_tangent("V", s.as_ref(), tilted.as_ref(), 1e-9) {
            Err(Error::NotTangent {
                name: "V",
                defect,
                tolerance,
            }) => {
                let expected = 1e-3 * (s.ncols() as f64).sqrt();
                assert_within(
                    (defect - expected).abs(),
                    1e-14,
                    &format!("reported defect, {place}"),
                );
                let expected = 1e-9 * frobenius(tilted.as_ref()).max(1.0);
                assert_within(
                    (tolerance - expected).abs(),
                    1e-12 * expected,
                    &format!("tolerance, {place}"),
                );
            }
            other => panic!("expected NotTangent, found {other:?}"),
        }
    });
}

#[test]
fn checks_look_at_shape_and_finiteness_first() {
    let s = random_point(4, 2, &mut Rng::new(4));
    let manifold = manifold(&s);
    let tall = Mat::zeros(5, 2);
    let error = manifold.check_point("S", tall.as_ref(), 1e-9);
    assert!(
        matches!(error, Err(Error::Shape { name: "S", .. })),
        "{error:?}"
    );
    let error = manifold.check_tangent("V", s.as_ref(), tall.as_ref(), 1e-9);
    assert!(
        matches!(error, Err(Error::Shape { name: "V", .. })),
        "{error:?}"
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let mut a = s.clone();
        a[(2, 1)] = bad;
        let error = manifold.check_point("S", a.as_ref(), 1e-9);
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "S",
                    index: 6
                })
            ),
            "{error:?}"
        );
        let error = manifold.check_tangent("V", s.as_ref(), a.as_ref(), 1e-9);
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "V",
                    index: 6
                })
            ),
            "{error:?}"
        );
        let error = manifold.project(a.as_ref());
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "Y",
                    index: 6
                })
            ),
            "{error:?}"
        );
    }
    let error = manifold.check_point("S", (&s * Scale(1e200)).as_ref(), 1e-9);
    assert!(
        matches!(error, Err(Error::NotOrthonormal { .. })),
        "overflow in S^T S: {error:?}"
    );
}

#[test]
fn every_method_refuses_wrong_shapes_and_numbers() {
    let m = Stiefel::new(5, 2).unwrap();
    let s = random_point(5, 2, &mut Rng::new(1));
    let wrong = Mat::<f64>::zeros(4, 2);
    let nan = Mat::from_fn(5, 2, |i, _| if i == 3 { f64::NAN } else { 0.0 });
    for bad in [wrong.as_ref(), nan.as_ref()] {
        for (x, y) in [(s.as_ref(), bad), (bad, s.as_ref())] {
            assert_bad(m.project_tangent(x, y), "project_tangent");
            assert_bad(m.inner(x, y, s.as_ref()), "inner");
            assert_bad(m.inner(s.as_ref(), x, y), "inner");
            assert_bad(m.norm(x, y), "norm");
            assert_bad(m.split(x, y), "split");
            assert_bad(m.decompose(x, y), "decompose");
            assert_bad(m.check_tangent("V", x, y, 1.0), "check_tangent");
        }
    }
}

fn assert_bad<T: std::fmt::Debug>(result: stiefel_rs::Result<T>, what: &str) {
    let refused = matches!(result, Err(Error::Shape { .. } | Error::NonFinite { .. }));
    assert!(refused, "{what}: {result:?}");
}
