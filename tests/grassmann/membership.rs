//! Sizes, checks with their measured defects, projections and the metric.

use faer::{Mat, Scale, mat};
use stiefel_rs::{Error, Grassmann};

use crate::common::{
    EPS, assert_close, assert_within, frobenius, gaussian, identity, project_off, random_orthogonal,
};
use crate::{each_point, horizontal};

#[test]
fn sizes() {
    let m = Grassmann::new(7, 3).unwrap();
    assert_eq!((m.n(), m.k(), m.dim()), (7, 3, 12));
    assert_eq!(Grassmann::new(4, 4).unwrap().dim(), 0);
    for (n, k) in [(3, 0), (2, 3), (0, 0), (usize::MAX, 2)] {
        assert!(matches!(
            Grassmann::new(n, k),
            Err(Error::Shape {
                name: "Gr(n, k)",
                ..
            })
        ));
    }
    assert!(matches!(
        Grassmann::of("Y", Mat::<f64>::zeros(2, 3).as_ref()),
        Err(Error::Shape { name: "Y", .. })
    ));
}

#[test]
fn checks_measure_the_defect() {
    each_point(|m, y, rng| {
        m.check_point("Y", y.as_ref(), 1e-14).unwrap();
        let v = horizontal(&y, 2.0, rng);
        m.check_tangent("V", y.as_ref(), v.as_ref(), 1e-14).unwrap();
        let off = &v + &y * Scale(1e-3);
        let expected = 1e-3 * (m.k() as f64).sqrt();
        match m.check_tangent("V", y.as_ref(), off.as_ref(), 1e-9) {
            Err(Error::NotHorizontal {
                name: "V", defect, ..
            }) => {
                assert_within((defect - expected).abs(), 1e-14, "defect");
            }
            other => panic!("{other:?}"),
        }
        assert!(m.exp(y.as_ref(), off.as_ref()).is_err());
    });
}

#[test]
fn entries_that_are_not_finite_are_named() {
    let m = Grassmann::new(3, 1).unwrap();
    let (y, bad) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [f64::NAN], [0.0]]);
    let zero = Mat::zeros(3, 1);
    let (y, bad) = (y.as_ref(), bad.as_ref());
    let refused = |result: Result<(), Error>, expected: &str| match result {
        Err(Error::NonFinite { name, index: 1 }) => assert_eq!(name, expected),
        other => panic!("{expected}: {other:?}"),
    };
    refused(m.log(bad, y).map(drop), "Y0");
    refused(m.log(y, bad).map(drop), "Y1");
    refused(m.align(y, bad).map(drop), "Y1");
    refused(m.exp(y, bad).map(drop), "V");
    refused(m.transport(y, zero.as_ref(), bad).map(drop), "W");
    refused(m.project_tangent(y, bad).map(drop), "Z");
    refused(m.euclidean_to_riemannian_gradient(y, bad).map(drop), "G");
    refused(m.projector(bad).map(drop), "Y");
}

#[test]
fn projections_and_metric() {
    each_point(|m, y, rng| {
        let (n, k) = y.shape();
        let z = gaussian(n, k, rng);
        let p = m.project_tangent(y.as_ref(), z.as_ref()).unwrap();
        assert_close(&p, &project_off(&y, &z), 1e-14 * n as f64, "projection");
        let q = random_orthogonal(k, rng);
        let projector = m.projector(y.as_ref()).unwrap();
        let other = m.projector((&y * &q).as_ref()).unwrap();
        assert_close(&projector, &other, 1e-14 * k as f64, "projector");
        assert_eq!(projector, projector.transpose().to_owned());
        let squared = &projector * &projector;
        assert_close(&squared, &projector, 1e-14 * k as f64, "idempotent");
        let v = horizontal(&y, 1.5, rng);
        let inner = m.inner(y.as_ref(), v.as_ref(), v.as_ref()).unwrap();
        let norm = m.norm(y.as_ref(), v.as_ref()).unwrap();
        assert_within((inner - norm * norm).abs(), 10.0 * EPS, "norm");
        if n == k {
            assert_within(
                frobenius(p.as_ref()),
                1e-14 * n as f64,
                "nothing is horizontal",
            );
            assert_close(&projector, &identity(n), 1e-14 * n as f64, "all of space");
        }
    });
}
