//! Boundary values.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic};
use stiefel_rs::{Curve, Interrupt, Quotient};

use crate::common::{
    Rng, assert_close, assert_within, cubic_from, gaussian, random_orthogonal, random_point,
};
use crate::{SHAPES, boundary_options, horizontal, reflection, view};

#[test]
fn the_cubic_with_the_ends_of_another_is_that_one() {
    let mut rng = Rng::new(21);
    for (n, k) in [&SHAPES[..], &[(40, 4), (12, 5)]].concat() {
        let y = random_point(n, k, &mut rng);
        let mut vector = |size: f64| {
            let v = horizontal(view(&y), gaussian(n, k, &mut rng).as_ref());
            let norm = v.norm_l2();
            v * Scale(size / norm)
        };
        let [v, a, j] = [0.6, 0.9, 1.2].map(&mut vector);
        let options = IntegrationOptions {
            quotient: Quotient::Subspaces,
            ..IntegrationOptions::default()
        };
        let known = cubic_from([&y, &v, &a, &j], &options);
        let q = random_orthogonal(k, &mut rng);
        let [y1, v1] = [known.point(1.0), known.derivative(1.0, 1)].map(|x| x.unwrap() * &q);
        let v1 = horizontal(view(&y1), view(&v1));
        let found = RiemannianCubic::from_boundary(
            view(&y),
            view(&v),
            view(&y1),
            view(&v1),
            &boundary_options(),
            Interrupt::NEVER,
        )
        .unwrap();
        let what = format!("({n}, {k})");
        for t in [0.0, 0.3, 0.7, 1.0] {
            assert_close(
                &found.point(t).unwrap(),
                &known.point(t).unwrap(),
                1e-11,
                &what,
            );
        }
        assert!(found.report().unwrap().converged);
        assert_close(&found.initial().unwrap()[3], &j, 1e-9, &what);
        assert_within(
            (found.cost(Interrupt::NEVER).unwrap() / known.cost(Interrupt::NEVER).unwrap() - 1.0)
                .abs(),
            1e-11,
            &what,
        );
    }
}

#[test]
fn far_and_fast_ends_are_met() {
    let mut rng = Rng::new(22);
    for (n, k) in SHAPES {
        for _ in 0..4 {
            let [y0, y1] = [(); 2].map(|()| random_point(n, k, &mut rng));
            let [v0, v1] = [&y0, &y1].map(|y| {
                let v = horizontal(view(y), gaussian(n, k, &mut rng).as_ref());
                let norm = v.norm_l2();
                v * Scale(3.0 / norm)
            });
            let found = RiemannianCubic::from_boundary(
                view(&y0),
                view(&v0),
                view(&y1),
                view(&v1),
                &boundary_options(),
                Interrupt::NEVER,
            )
            .unwrap();
            let end = found.point(1.0).unwrap();
            assert_close(
                &reflection(view(&end)),
                &reflection(view(&y1)),
                1e-10,
                "end",
            );
            let q = y1.transpose() * &end;
            let velocity: Mat<f64> = &v1 * &q;
            assert_close(
                &found.derivative(1.0, 1).unwrap(),
                &velocity,
                1e-9,
                "end velocity",
            );
        }
    }
}

#[test]
#[ignore = "a table of what is solved"]
fn table() {
    let mut rng = Rng::new(22);
    for (n, k) in SHAPES {
        for speed in [0.0, 1.0, 2.0, 3.0] {
            let mut lost = Vec::new();
            for _ in 0..10 {
                let [y0, y1] = [(); 2].map(|()| random_point(n, k, &mut rng));
                let [v0, v1] = [&y0, &y1].map(|y| {
                    let v = horizontal(view(y), gaussian(n, k, &mut rng).as_ref());
                    let norm = v.norm_l2();
                    v * Scale(speed / norm)
                });
                let found = RiemannianCubic::from_boundary(
                    view(&y0),
                    view(&v0),
                    view(&y1),
                    view(&v1),
                    &boundary_options(),
                    Interrupt::NEVER,
                );
                if let Err(error) = found {
                    lost.push(error.to_string());
                }
            }
            println!(
                "({n}, {k}) speed {speed}: lost {} {:?}",
                lost.len(),
                lost.first()
            );
        }
    }
}
