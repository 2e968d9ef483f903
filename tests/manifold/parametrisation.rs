//! The paper's parametrisation of tangent vectors, and the retraction.

use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, QuasiGeodesic};

use crate::common::{EPS, Rng, assert_close, assert_within, distance, frobenius, random_point};
use crate::shapes::{each_shape, manifold};

#[test]
fn compose_undoes_decompose() {
    each_shape(11, |manifold, s, v, _, place| {
        let (x, omega) = manifold.decompose(s.as_ref(), v.as_ref()).unwrap();
        let found = manifold
            .compose(s.as_ref(), x.as_ref(), omega.as_ref())
            .unwrap();
        assert_close(
            &found,
            v,
            16.0 * s.nrows() as f64 * EPS,
            &format!("X S + S Omega, {place}"),
        );
        assert_eq!(x, -x.transpose(), "X is exactly skew, {place}");
        assert_eq!(omega, -omega.transpose(), "Omega is exactly skew, {place}");
    });
}

#[test]
fn eq_new_param1_is_our_pair() {
    each_shape(12, |manifold, s, v, _, place| {
        let (x, omega) = manifold.decompose(s.as_ref(), v.as_ref()).unwrap();
        let paper = v * s.transpose() - s * v.transpose()
            + s * v.transpose() * s * s.transpose() * Scale(2.0);
        let bound = 16.0 * s.nrows() as f64 * EPS;
        assert_close(&x, &paper, bound, &format!("X, {place}"));
        assert_close(
            &omega,
            &(s.transpose() * v),
            bound,
            &format!("Omega, {place}"),
        );
    });
}

#[test]
fn split_is_normal_and_skew() {
    each_shape(13, |manifold, s, v, _, place| {
        let (normal, omega) = manifold.split(s.as_ref(), v.as_ref()).unwrap();
        let bound = 16.0 * s.nrows() as f64 * EPS;
        assert_within(
            frobenius((s.transpose() * &normal).as_ref()),
            bound,
            &format!("S^T K, {place}"),
        );
        assert_close(
            &(normal + s * omega),
            v,
            bound,
            &format!("K + S Omega, {place}"),
        );
    });
}

#[test]
fn compose_refuses_wrong_shapes() {
    let s = random_point(4, 2, &mut Rng::new(14));
    let (x, omega) = (Mat::zeros(4, 4), Mat::zeros(2, 2));
    let error = manifold(&s).compose(s.as_ref(), omega.as_ref(), omega.as_ref());
    assert!(
        matches!(error, Err(Error::Shape { name: "X", .. })),
        "{error:?}"
    );
    let error = manifold(&s).compose(s.as_ref(), x.as_ref(), x.as_ref());
    assert!(
        matches!(error, Err(Error::Shape { name: "Omega", .. })),
        "{error:?}"
    );
}

#[test]
fn retraction_is_right_to_first_order() {
    each_shape(15, |manifold, s, v, _, place| {
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let remainder = |h: f64| distance(&curve.point(h).unwrap(), &(s + v * Scale(h)));
        if manifold.dim() == 0 {
            return assert_within(remainder(1.0), EPS, "a manifold of isolated points");
        }
        for halving in 4..9 {
            let h = 0.5_f64.powi(halving);
            let order = (remainder(h) / remainder(0.5 * h)).log2();
            assert_within(
                (order - 2.0).abs(),
                0.2,
                &format!("order {order:.3} of R(hV) - S - hV, {place}, h = {h}"),
            );
        }
    });
}
