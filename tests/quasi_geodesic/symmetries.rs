//! Symmetries of quasi-geodesics.

use stiefel_rs::Curve;

use crate::common::{Rng, SIZES, Worst, distance, random_orthogonal, random_point, random_tangent};
use crate::ends::{TIMES, between, shoot};

#[test]
fn is_equivariant_under_both_orthogonal_actions() {
    let mut rng = Rng::new(31);
    let mut worst = Worst::new("A beta(S0, S1) B - beta(A S0 B, A S1 B)");
    for (n, k) in SIZES {
        let s0 = random_point(n, k, &mut rng);
        let s1 = shoot(&s0, &random_tangent(&s0, 1.0, &mut rng))
            .point(1.0)
            .unwrap();
        let (a, b) = (
            random_orthogonal(n, &mut rng),
            random_orthogonal(k, &mut rng),
        );
        let (here, there) = (
            between(&s0, &s1),
            between(&(&a * &s0 * &b), &(&a * &s1 * &b)),
        );
        for t in TIMES {
            let error = distance(
                &(&a * here.point(t).unwrap() * &b),
                &there.point(t).unwrap(),
            );
            worst.see(error, || format!("({n}, {k}), t = {t}"));
        }
    }
    worst.assert_at_most(5e-14);
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
