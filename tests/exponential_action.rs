//! The action of the exponential of a skew operator, compared with the exponential itself.

mod common;

use common::*;
use faer::Mat;
use stiefel_rs::Error;
use stiefel_rs::linalg::exponential_action::skew_exponential_action;
use stiefel_rs::linalg::product::mul_into;
use stiefel_rs::skew_exp;

fn act(a: &Mat<f64>, v: &Mat<f64>, radius: f64) -> (Mat<f64>, usize) {
    let mut products = 0;
    let out = skew_exponential_action(v.clone(), radius, |out, x| {
        products += 1;
        mul_into(out, 1.0, a, x);
    });
    (out.unwrap(), products)
}

#[test]
fn action_agrees_with_the_exponential() {
    let mut rng = Rng::new(91);
    for m in [2, 3, 8, 20] {
        for size in [1e-300, 1e-9, 0.1, 1.0, 3.0, 10.0, 100.0, 1e3, 1e4] {
            let a = random_skew(m, size, &mut rng);
            let v = gaussian(m, 3, &mut rng);
            let exact = skew_exp(a.as_ref()).unwrap() * &v;
            let radius = spectral(a.as_ref());
            // The bound may be too large by a factor of two.
            for radius in [radius, 2.0 * radius] {
                let (action, products) = act(&a, &v, radius);
                let bound = 1e-14 * (1.0 + 0.1 * radius) * frobenius(v.as_ref());
                assert_close(&action, &exact, bound, &format!("m = {m}, norm {size:e}"));
                let expected = radius + 14.0 * radius.cbrt().max(1.0) + 4.0;
                assert!(
                    products as f64 <= expected,
                    "{products} products for the radius {radius}"
                );
            }
        }
    }
}

#[test]
fn action_keeps_lengths() {
    let mut rng = Rng::new(92);
    let mut worst = Worst::new("length kept");
    for size in [1e-3, 0.3, 1.0, 5.0, 30.0] {
        for _ in 0..20 {
            let (a, v) = (random_skew(9, size, &mut rng), gaussian(9, 2, &mut rng));
            let (action, _) = act(&a, &v, size);
            let before = frobenius(v.as_ref());
            worst.see((frobenius(action.as_ref()) / before - 1.0).abs(), || {
                format!("norm {size}")
            });
        }
    }
    worst.assert_at_most(5e-15);
}

#[test]
fn zero_is_the_identity_exactly() {
    let v = gaussian(4, 2, &mut Rng::new(93));
    assert_close(&act(&Mat::zeros(4, 4), &v, 0.0).0, &v, 0.0, "radius 0");
    assert_close(
        &(act(&Mat::zeros(4, 4), &v, 3.0).0),
        &v,
        1e-15 * frobenius(v.as_ref()),
        "zero",
    );
}

#[test]
fn a_radius_out_of_range_is_refused() {
    for radius in [1.1e5, f64::INFINITY, f64::NAN, -1.0] {
        let v = Mat::zeros(2, 1);
        let error = skew_exponential_action(v, radius, |_, _| panic!("not to be called"));
        assert!(
            matches!(error, Err(Error::InvalidArgument { .. })),
            "{error:?}"
        );
    }
}
