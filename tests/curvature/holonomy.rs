//! Curvature from parallel transport and covariant derivatives.

use faer::{Mat, Scale};
use stiefel_rs::manifold::covariant::christoffel;
use stiefel_rs::{Metric, ParallelTransport, Stiefel};

use crate::common::{
    Rng, assert_close, assert_within, distance, random_point, random_tangent, retract,
};
use crate::metrics::{each_shape, manifold, metrics, r};
use crate::quotient::Quotient;

#[test]
fn curvature_is_the_holonomy_of_small_loops() {
    // Around a square of side h: W changes by -h^2 R(U, V) W + O(h^3), reduced to O(h^4) by the loop around the
    // opposite square.
    let mut rng = Rng::new(119);
    for (n, k) in [(3, 1), (4, 2), (5, 3), (4, 4), (8, 2)] {
        for metric in metrics() {
            let s = random_point(n, k, &mut rng);
            let [u, v, w] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
            let m = manifold(&s, metric);
            let exact = r(m, &s, &u, &v, &w);
            let error = |h: f64| {
                let sum = holonomy(m, &s, &(&u * Scale(h)), &(&v * Scale(h)), &w)
                    + holonomy(m, &s, &(&u * Scale(-h)), &(&v * Scale(-h)), &w);
                distance(&(sum * Scale(-0.5 / (h * h))), &exact)
            };
            let errors = [error(0.04), error(0.02), error(0.01)];
            for pair in errors.windows(2) {
                let slope = (pair[0] / pair[1]).log2();
                assert!(
                    (slope - 2.0).abs() < 0.2 || pair[1] < 1e-8,
                    "({n}, {k}), {metric:?}: errors {errors:?}, slope {slope}"
                );
            }
            assert_within(errors[2], 5e-3, &format!("({n}, {k}), {metric:?}"));
        }
    }
}

/// `P W - W` for the transport around the quadrangle with the sides `U`, `V`, `-U` (each parallel along the previous
/// one), closed by the geodesic back to `S`.
fn holonomy(m: Stiefel, s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    let mut point = s.clone();
    let mut frame = [u.clone(), v.clone(), w.clone()];
    for side in [0, 1, 2] {
        let velocity = if side == 2 {
            &frame[0] * Scale(-1.0)
        } else {
            frame[side].clone()
        };
        let step = ParallelTransport::new(m, point.as_ref(), velocity.as_ref()).unwrap();
        frame = frame
            .each_ref()
            .map(|x| step.transport(x.as_ref()).unwrap());
        point = step.end();
    }
    // The closing side: the velocity is corrected until the geodesic reaches the start.
    let mut home = m
        .project_tangent(point.as_ref(), (s - &point).as_ref())
        .unwrap();
    for _ in 0..60 {
        let end = ParallelTransport::new(m, point.as_ref(), home.as_ref())
            .unwrap()
            .end();
        home += m
            .project_tangent(point.as_ref(), (s - end).as_ref())
            .unwrap();
    }
    let last = ParallelTransport::new(m, point.as_ref(), home.as_ref()).unwrap();
    assert_within(distance(&last.end(), s), 1e-14, "the loop is closed");
    last.transport(frame[2].as_ref()).unwrap() - w
}

#[test]
fn curvature_is_the_commutator_of_covariant_derivatives() {
    // Fields P_X Z for fixed Z, canonical metric, by differences of fourth order in the embedding.
    let mut rng = Rng::new(120);
    for (n, k) in [(3, 1), (4, 2), (5, 3), (3, 3)] {
        let s = random_point(n, k, &mut rng);
        let [u, v, w] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
        let m = manifold(&s, Metric::CANONICAL);
        let field = |z: &Mat<f64>| {
            let z = z.clone();
            move |x: &Mat<f64>| {
                let sym = x.transpose() * &z;
                &z - x * (&sym + sym.transpose()) * Scale(0.5)
            }
        };
        let (fu, fv, fw) = (field(&u), field(&v), field(&w));
        let derivative = |f: &dyn Fn(&Mat<f64>) -> Mat<f64>, x: &Mat<f64>, z: &Mat<f64>| {
            let h = 2e-3;
            let at = |t: f64| f(&retract(x, &(z * Scale(t))));
            ((at(h) - at(-h)) * Scale(8.0) - (at(2.0 * h) - at(-2.0 * h))) * Scale(1.0 / (12.0 * h))
        };
        let covariant =
            |f: &dyn Fn(&Mat<f64>) -> Mat<f64>, g: &dyn Fn(&Mat<f64>) -> Mat<f64>, x: &Mat<f64>| {
                let (z, y) = (f(x), g(x));
                derivative(g, x, &z) + christoffel(x.as_ref(), z.as_ref(), y.as_ref())
            };
        let vw = |x: &Mat<f64>| covariant(&fv, &fw, x);
        let uw = |x: &Mat<f64>| covariant(&fu, &fw, x);
        let bracket = |x: &Mat<f64>| derivative(&fv, x, &fu(x)) - derivative(&fu, x, &fv(x));
        let exact =
            covariant(&fu, &vw, &s) - covariant(&fv, &uw, &s) - covariant(&bracket, &fw, &s);
        // h^4 = 1.6e-11 times fifth derivatives.
        assert_close(&r(m, &s, &u, &v, &w), &exact, 2e-9, &format!("({n}, {k})"));
    }
}

#[test]
fn sign_is_that_of_the_equation_of_riemannian_cubics() {
    // x''' = [x'', x]_m - [[x, x']_h, x] is D_t^3 S' + R(D_t S', S') S' = 0, so R(a, x) x is
    // [[x, a]_h, x] - [x, [x, a]_m]_m / 4.
    let mut rng = Rng::new(121);
    each_shape(122, |s, [a, x, ..], place| {
        let quotient = Quotient::at(s, &mut rng);
        let (la, lx) = (quotient.lift(a), quotient.lift(x));
        let (along, turned) = quotient.bracket(&lx, &la);
        let exact = &turned * &lx - &lx * &turned - quotient.bracket(&lx, &along).0 * Scale(0.25);
        let measured = r(manifold(s, Metric::CANONICAL), s, a, x, x);
        assert_close(
            &measured,
            &quotient.push(&exact),
            1e-14 * s.ncols() as f64,
            place,
        );
    });
}
