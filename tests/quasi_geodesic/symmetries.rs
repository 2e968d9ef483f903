//! Symmetries of quasi-geodesics.

use faer::Mat;
use stiefel_rs::Curve;

use crate::common::{
    Actions, Rng, SIZES, Worst, assert_equivariant, distance, random_point, random_tangent,
};
use crate::ends::{TIMES, between, shoot};

#[test]
fn is_equivariant_under_both_orthogonal_actions() {
    let mut rng = Rng::new(31);
    for (n, k) in SIZES {
        let s0 = random_point(n, k, &mut rng);
        let s1 = shoot(&s0, &random_tangent(&s0, 1.0, &mut rng))
            .point(1.0)
            .unwrap();
        let points = |a: &[Mat<f64>]| {
            TIMES
                .map(|t| between(&a[0], &a[1]).point(t).unwrap())
                .to_vec()
        };
        let what = format!("({n}, {k})");
        assert_equivariant(Actions::Both, &[&s0, &s1], points, 5e-14, &what, &mut rng);
    }
}

#[test]
fn between_exchanged_points_runs_backwards() {
    let mut rng = Rng::new(32);
    let mut worst = Worst::new("beta(S0, S1; t) - beta(S1, S0; 1 - t)");
    for (n, k) in SIZES {
        let s0 = random_point(n, k, &mut rng);
        let s1 = shoot(&s0, &random_tangent(&s0, 1.5, &mut rng))
            .point(1.0)
            .unwrap();
        let (there, back) = (between(&s0, &s1), between(&s1, &s0));
        for t in TIMES {
            let error = distance(&there.point(t).unwrap(), &back.point(1.0 - t).unwrap());
            worst.see(error, || format!("({n}, {k}), t = {t}"));
        }
    }
    worst.assert_at_most(5e-14);
}
