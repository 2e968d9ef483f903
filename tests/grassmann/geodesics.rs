//! Exponential and parallel transport.

use faer::{Mat, Scale};

use crate::common::{
    assert_close, assert_within, distance, frobenius, orthonormality, random_orthogonal,
};
use crate::{each_point, exp, horizontal, manifold, transport};

/// `(Y W cos S + Q sin S) W^T` by faer's decomposition.
fn formula(y: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    let svd = v.thin_svd().unwrap();
    let s = svd.S().column_vector();
    let k = y.ncols();
    let diagonal =
        |f: fn(f64) -> f64| Mat::from_fn(k, k, |i, j| if i == j { f(s[i]) } else { 0.0 });
    (y * svd.V() * diagonal(f64::cos) + svd.U() * diagonal(f64::sin)) * svd.V().transpose()
}

#[test]
fn exp_is_its_formula() {
    each_point(|m, y, rng| {
        for length in [0.0, 1e-9, 0.1, 1.0, 3.1, 3.2, 10.0] {
            let v = horizontal(&y, length, rng);
            let bound = 1e-15 * m.n() as f64 * (4.0 + length);
            assert_close(&exp(&y, &v), &formula(&y, &v), bound, &format!("{length}"));
        }
    });
}

#[test]
fn exp_is_orthonormal_for_any_length() {
    each_point(|m, y, rng| {
        for length in [1e-300, 1e-160, 1e-8, 1.0, 3.0, 100.0, 5e3, 1e9, 1e150] {
            let end = exp(&y, &horizontal(&y, length, rng));
            assert_within(
                orthonormality(&end),
                1e-14 * m.k() as f64,
                &format!("{length}"),
            );
        }
    });
}

#[test]
fn points_off_by_the_tolerance_stay_so() {
    each_point(|_, y, rng| {
        let off = &y * Scale(1.0 + 1e-10);
        let v = horizontal(&y, 1.0, rng) + &y * Scale(1e-10);
        assert_within(
            orthonormality(&exp(&off, &v)),
            1e-9,
            "exp of a point that is a little off",
        );
    });
}

#[test]
fn transport_is_isometric_and_horizontal() {
    each_point(|m, y, rng| {
        for length in [1e-200, 0.3, 2.0, 3.3, 50.0] {
            let (v, w) = (horizontal(&y, length, rng), horizontal(&y, 1.7, rng));
            let (end, moved) = (exp(&y, &v), transport(&y, &v, &w));
            let bound = 1e-14 * m.k() as f64;
            let size = (frobenius(moved.as_ref()) - frobenius(w.as_ref())).abs();
            assert_within(size, bound, "isometric");
            let along = end.transpose() * &moved;
            assert_within(frobenius(along.as_ref()), bound, "horizontal");
            let back = transport(&end, &(-transport(&y, &v, &v)), &moved);
            assert_close(&back, &w, bound * (2.0 + length), "there and back");
        }
    });
}

#[test]
fn transport_of_the_velocity_is_the_velocity() {
    each_point(|m, y, rng| {
        let v = horizontal(&y, 1.0, rng);
        let h = 1e-3;
        let at = |t: f64| exp(&y, &(&v * Scale(1.0 + t)));
        let difference =
            (at(-2.0 * h) - at(2.0 * h) + (at(h) - at(-h)) * Scale(8.0)) * Scale(1.0 / (12.0 * h));
        // h^4 / 30 and 2 eps / h.
        let bound = 2e-12 * m.k() as f64;
        assert_close(&transport(&y, &v, &v), &difference, bound, "velocity");
    });
}

#[test]
fn other_bases_give_the_same_in_them() {
    each_point(|m, y, rng| {
        let q = random_orthogonal(m.k(), rng);
        for length in [0.5, 20.0] {
            let (v, w) = (horizontal(&y, length, rng), horizontal(&y, 1.0, rng));
            let (yq, vq, wq) = (&y * &q, &v * &q, &w * &q);
            let bound = 1e-14 * m.n() as f64 * (1.0 + length);
            assert_close(&exp(&yq, &vq), &(exp(&y, &v) * &q), bound, "exp");
            assert_close(
                &transport(&yq, &vq, &wq),
                &(transport(&y, &v, &w) * &q),
                bound,
                "transport",
            );
        }
    });
}

#[test]
fn nothing_moves_without_velocity() {
    each_point(|_, y, rng| {
        let zero = Mat::zeros(y.nrows(), y.ncols());
        assert_eq!(exp(&y, &zero), y);
        let w = horizontal(&y, 1.0, rng);
        assert!(distance(&transport(&y, &zero, &w), &w) <= 1e-15);
        assert_eq!(transport(&y, &w, &zero), zero);
        assert!(
            manifold(&y)
                .check_point("Y", exp(&y, &w).as_ref(), 1e-13)
                .is_ok()
        );
    });
}
