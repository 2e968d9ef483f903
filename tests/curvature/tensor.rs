//! The curvature tensor: brackets of full size, Gauss's equation, symmetries, spheres and rotations.

use faer::{Mat, Scale};
use stiefel_rs::Metric;

use crate::common::{
    Actions, Rng, Worst, assert_close, assert_equivariant, assert_within, distance, frobenius,
    random_point, random_tangent,
};
use crate::metrics::{each_shape, inner, manifold, metrics, r, sectional};
use crate::quotient::Quotient;

#[test]
fn canonical_curvature_is_that_of_the_naturally_reductive_quotient() {
    let mut worst = Worst::new("tensor");
    let mut worst_sectional = Worst::new("sectional");
    let mut rng = Rng::new(111);
    each_shape(112, |s, [u, v, w, _], place| {
        let quotient = Quotient::at(s, &mut rng);
        let [x, y, z] = [u, v, w].map(|a| quotient.lift(a));
        let m = |a: &Mat<f64>, b: &Mat<f64>| quotient.bracket(a, b).0;
        let h = |a: &Mat<f64>, b: &Mat<f64>| quotient.bracket(a, b).1;
        // Kobayashi and Nomizu, volume II, theorem X.3.3.
        let turned = h(&x, &y);
        let exact = m(&x, &m(&y, &z)) * Scale(0.25)
            - m(&y, &m(&x, &z)) * Scale(0.25)
            - m(&m(&x, &y), &z) * Scale(0.5)
            - (&turned * &z - &z * &turned);
        let canonical = manifold(s, Metric::CANONICAL);
        let k = s.ncols() as f64;
        worst.see(
            distance(&r(canonical, s, u, v, w), &quotient.push(&exact)) / k,
            || place.to_owned(),
        );
        // O'Neill: a quarter of the part in m, and the part in h, each in the norm tr(A^T A) / 2.
        let size = |a: &Mat<f64>| 0.5 * frobenius(a.as_ref()).powi(2);
        let area = inner(canonical, s, u, u) * inner(canonical, s, v, v)
            - inner(canonical, s, u, v).powi(2);
        let exact = (0.25 * size(&m(&x, &y)) + size(&h(&x, &y))) / area;
        let measured = sectional(canonical, s, u, v);
        worst_sectional.see((measured - exact).abs() * area.sqrt() / k, || {
            place.to_owned()
        });
    });
    worst.assert_at_most(5e-15);
    worst_sectional.assert_at_most(5e-15);
}

#[test]
fn euclidean_curvature_is_gauss_equation() {
    let mut worst = Worst::new("Gauss");
    each_shape(113, |s, [u, v, w, z], place| {
        let second = |a: &Mat<f64>, b: &Mat<f64>| {
            let product = a.transpose() * b;
            s * (&product + product.transpose()) * Scale(-0.5)
        };
        let dot = |a: Mat<f64>, b: Mat<f64>| {
            (0..a.ncols())
                .map(|j| a.col(j).transpose() * b.col(j))
                .sum::<f64>()
        };
        let exact = dot(second(u, z), second(v, w)) - dot(second(u, w), second(v, z));
        let euclidean = manifold(s, Metric::EUCLIDEAN);
        let measured = inner(euclidean, s, &r(euclidean, s, u, v, w), z);
        worst.see((measured - exact).abs() / s.ncols() as f64, || {
            place.to_owned()
        });
    });
    worst.assert_at_most(5e-15);
}

#[test]
fn curvature_has_its_symmetries_and_the_bianchi_identity() {
    let mut worst = Worst::new("symmetry");
    each_shape(114, |s, [u, v, w, z], place| {
        for metric in metrics() {
            let m = manifold(s, metric);
            let t = |a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>, d: &Mat<f64>| {
                inner(m, s, &r(m, s, a, b, c), d)
            };
            let place = |what: &str| format!("{what}, {place}, {metric:?}");
            worst.see((t(u, v, w, z) + t(v, u, w, z)).abs(), || {
                place("first pair")
            });
            worst.see((t(u, v, w, z) + t(u, v, z, w)).abs(), || {
                place("second pair")
            });
            worst.see((t(u, v, w, z) - t(w, z, u, v)).abs(), || {
                place("pairs exchanged")
            });
            let cycle = r(m, s, u, v, w) + r(m, s, v, w, u) + r(m, s, w, u, v);
            worst.see(frobenius(cycle.as_ref()), || place("Bianchi"));
        }
    });
    worst.assert_at_most(1e-14);
}

#[test]
fn curvature_is_tangent_and_equivariant() {
    let mut rng = Rng::new(115);
    each_shape(116, |s, [u, v, w, _], place| {
        for metric in metrics() {
            let m = manifold(s, metric);
            let value = r(m, s, u, v, w);
            m.check_tangent("R", s.as_ref(), value.as_ref(), 1e-14)
                .unwrap();
            let tensor = |a: &[Mat<f64>]| vec![r(m, &a[0], &a[1], &a[2], &a[3])];
            let what = format!("{place}, {metric:?}");
            assert_equivariant(Actions::Both, &[s, u, v, w], tensor, 3e-14, &what, &mut rng);
        }
    });
}

#[test]
fn sphere_has_curvature_one_in_every_metric() {
    let mut rng = Rng::new(117);
    for n in [3, 4, 10, 100] {
        let s = random_point(n, 1, &mut rng);
        let [u, v, w] = std::array::from_fn(|_| random_tangent(&s, 2.0, &mut rng));
        for metric in metrics() {
            let m = manifold(&s, metric);
            let exact = &u * Scale(inner(m, &s, &v, &w)) - &v * Scale(inner(m, &s, &u, &w));
            assert_close(
                &r(m, &s, &u, &v, &w),
                &exact,
                1e-14,
                &format!("R(U,V)W = <V,W>U - <U,W>V, S^{}", n - 1),
            );
            assert_within((sectional(m, &s, &u, &v) - 1.0).abs(), 1e-14, "curvature 1");
        }
    }
}

#[test]
fn rotations_have_a_quarter_of_the_bracket() {
    let mut rng = Rng::new(118);
    // St(n, n-1) is SO(n) as well, but only in the canonical metric.
    for (n, k) in [(3, 3), (5, 5), (3, 2), (6, 5)] {
        let s = random_point(n, k, &mut rng);
        let quotient = Quotient::at(&s, &mut rng);
        let [u, v] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
        let (x, y) = (quotient.lift(&u), quotient.lift(&v));
        let bracket = &x * &y - &y * &x;
        for metric in metrics() {
            if k < n && metric != Metric::CANONICAL {
                continue;
            }
            let m = manifold(&s, metric);
            let double = &x * &bracket - &bracket * &x;
            // R(x, y) x = -[[x, y], x] / 4.
            assert_close(
                &r(m, &s, &u, &v, &u),
                &(quotient.push(&double) * Scale(0.25)),
                1e-14,
                "a quarter of [[x,y],x]",
            );
            let area = inner(m, &s, &u, &u) * inner(m, &s, &v, &v) - inner(m, &s, &u, &v).powi(2);
            let exact = 0.25 * metric.weight() * frobenius(bracket.as_ref()).powi(2) / area;
            assert_within(
                (sectional(m, &s, &u, &v) - exact).abs(),
                1e-14,
                &format!("({n}, {k}), {metric:?}"),
            );
        }
    }
}
