//! The canonical metric and its connection.

use faer::{Mat, Scale};
use stiefel_rs::manifold::covariant::{acceleration, christoffel};
use stiefel_rs::{Curve, QuasiGeodesic};

use crate::common::{EPS, Rng, assert_close, assert_within, frobenius, gaussian, identity};
use crate::projections::trace_of_product;
use crate::shapes::each_shape;

#[test]
fn inner_is_the_canonical_metric() {
    each_shape(8, |manifold, s, v, w, place| {
        let n = s.nrows();
        let weight = identity(n) - s * s.transpose() * Scale(0.5);
        let expected = trace_of_product(v.as_ref(), (&weight * w).as_ref());
        let found = manifold.inner(s.as_ref(), v.as_ref(), w.as_ref()).unwrap();
        assert_within(
            (found - expected).abs(),
            32.0 * n as f64 * EPS,
            &format!("<V, W>, {place}"),
        );
    });
}

#[test]
fn norm_squared_is_inner_of_a_vector_with_itself() {
    each_shape(9, |manifold, s, v, _, place| {
        let (norm, inner) = (
            manifold.norm(s.as_ref(), v.as_ref()).unwrap(),
            manifold.inner(s.as_ref(), v.as_ref(), v.as_ref()).unwrap(),
        );
        let bound = 32.0 * s.nrows() as f64 * EPS;
        assert_within(
            (norm * norm - inner).abs(),
            bound,
            &format!("|V|^2 - <V, V>, {place}"),
        );
        if manifold.dim() > 0 {
            assert_within(
                (norm - 2.0).abs(),
                bound,
                &format!("norm that was asked for, {place}"),
            );
        }
    });
}

#[test]
fn norm_is_homogeneous_at_extreme_scales() {
    each_shape(10, |manifold, s, v, _, place| {
        for scale in [1e-300, 1e-160, 1e160, 1e300] {
            let found = manifold
                .norm(s.as_ref(), (v * Scale(scale)).as_ref())
                .unwrap()
                / scale;
            let bound = 32.0 * s.nrows() as f64 * EPS;
            let expected = manifold.norm(s.as_ref(), v.as_ref()).unwrap();
            assert_within(
                (found - expected).abs(),
                bound,
                &format!("{place}, scale {scale:e}"),
            );
        }
    });
}

/// The connection preserves the canonical metric: `d<V, W>/dt = <D V, W> + <V, D W>` along a curve.
#[test]
fn christoffel_term_is_metric() {
    each_shape(16, |manifold, s, v, w, place| {
        let u = manifold
            .project_tangent(
                s.as_ref(),
                gaussian(s.nrows(), s.ncols(), &mut Rng::new(17)).as_ref(),
            )
            .unwrap();
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), u.as_ref()).unwrap();
        // Fields along the curve: constant matrices projected to the tangent spaces.
        let field = |z: &Mat<f64>, t: f64| {
            manifold
                .project_tangent(curve.point(t).unwrap().as_ref(), z.as_ref())
                .unwrap()
        };
        let product = |t: f64| {
            let x = curve.point(t).unwrap();
            manifold
                .inner(x.as_ref(), field(v, t).as_ref(), field(w, t).as_ref())
                .unwrap()
        };
        let h = 1e-3;
        let derivative = |f: &dyn Fn(f64) -> Mat<f64>| {
            (f(h) - f(-h)) * Scale(2.0 / (3.0 * h))
                - (f(2.0 * h) - f(-2.0 * h)) * Scale(1.0 / (12.0 * h))
        };
        let covariant = |z: &Mat<f64>| {
            let rate = derivative(&|t| field(z, t));
            rate + christoffel(s.as_ref(), u.as_ref(), field(z, 0.0).as_ref())
        };
        let left = derivative(&|t| Mat::full(1, 1, product(t)))[(0, 0)];
        let right = manifold
            .inner(s.as_ref(), covariant(v).as_ref(), field(w, 0.0).as_ref())
            .unwrap()
            + manifold
                .inner(s.as_ref(), field(v, 0.0).as_ref(), covariant(w).as_ref())
                .unwrap();
        // Fourth-order differences: h^4 |u|^4 / 30, and eps / h.
        let size = frobenius(u.as_ref()).max(1.0);
        let bound = h.powi(4) * size.powi(5) + 64.0 * s.nrows() as f64 * EPS / h;
        assert_within(
            (left - right).abs(),
            bound,
            &format!("d<V, W> - <DV, W> - <V, DW>, {place}"),
        );
    });
}

/// `Gamma(V, W) = Gamma(W, V)`: the connection has no torsion.
#[test]
fn christoffel_term_is_symmetric() {
    each_shape(18, |_, s, v, w, place| {
        let (vw, wv) = (
            christoffel(s.as_ref(), v.as_ref(), w.as_ref()),
            christoffel(s.as_ref(), w.as_ref(), v.as_ref()),
        );
        assert_close(
            &vw,
            &wv,
            16.0 * s.nrows() as f64 * EPS,
            &format!("Gamma(V, W) - Gamma(W, V), {place}"),
        );
    });
}

/// Geodesics of the canonical metric start with `S'' = -Gamma(S', S')`; the quasi-geodesic is a geodesic for pure
/// rotations and for purely normal velocities.
#[test]
fn quasi_geodesics_of_one_part_are_geodesics() {
    each_shape(19, |manifold, s, v, _, place| {
        let (normal, omega) = manifold.split(s.as_ref(), v.as_ref()).unwrap();
        for part in [normal, s * omega] {
            let curve = QuasiGeodesic::from_velocity(s.as_ref(), part.as_ref()).unwrap();
            let [x, d1, d2] = [0, 1, 2].map(|nu| curve.derivative(0.7, nu).unwrap());
            let size = frobenius(acceleration(x.as_ref(), d1.as_ref(), d2.as_ref()).as_ref());
            assert_within(
                size,
                64.0 * s.nrows() as f64 * EPS,
                &format!("covariant acceleration, {place}"),
            );
        }
    });
}
