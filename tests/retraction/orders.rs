//! Orders of the retractions, compared with geodesics.

use faer::Scale;
use stiefel_rs::{Metric, Retraction};

use crate::common::{Rng, assert_close, assert_within, distance, random_point, random_tangent};
use crate::vectors::{apply, exponential};

/// Slopes of `log |R(tV) - exp(tV)|` against `log t` over four halvings.
fn slopes(retraction: Retraction, (n, k): (usize, usize), weight: f64) -> Vec<f64> {
    let mut rng = Rng::new(73);
    let s = random_point(n, k, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let errors: Vec<f64> = (0..5)
        .map(|i| {
            let step = &v * Scale(0.1 * 0.5_f64.powi(i));
            distance(
                &apply(retraction, &s, &step),
                &exponential(&s, &step, weight),
            )
        })
        .collect();
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

#[test]
fn table_of_orders_in_the_module_documentation() {
    use Retraction::{Cayley, Polar, Qr, QuasiGeodesic};
    let (canonical, euclidean) = (Metric::CANONICAL.weight(), Metric::EUCLIDEAN.weight());
    let shapes = [(5, 2), (6, 3), (5, 4)];
    let mut table = Vec::new();
    for shape in shapes {
        for (retraction, first, second) in [
            (QuasiGeodesic, 2.0, 2.0),
            (Qr, 2.0, 2.0),
            (Polar, 2.0, 3.0),
            (Cayley, 3.0, 2.0),
        ] {
            table.push((retraction, shape, canonical, first));
            table.push((retraction, shape, euclidean, second));
        }
    }
    for weight in [canonical, euclidean] {
        for (retraction, sphere, rotations) in
            [(Qr, 3.0, 2.0), (Polar, 3.0, 3.0), (Cayley, 3.0, 3.0)]
        {
            table.push((retraction, (4, 1), weight, sphere));
            table.push((retraction, (4, 4), weight, rotations));
        }
    }
    for (retraction, shape, weight, order) in table {
        let measured = slopes(retraction, shape, weight);
        println!("{retraction:?} {shape:?} w = {weight}: {measured:.3?}");
        for slope in measured {
            assert_within(
                (slope - order).abs(),
                0.2,
                &format!("{retraction:?} {shape:?} w = {weight}: slope {slope} for {order}"),
            );
        }
    }
}

#[test]
fn quasi_geodesics_are_geodesics_on_spheres_and_rotations() {
    let mut rng = Rng::new(74);
    for (n, k) in [(4, 1), (4, 4), (2, 1), (3, 3)] {
        let s = random_point(n, k, &mut rng);
        let v = random_tangent(&s, 2.0, &mut rng);
        for weight in [0.5, 1.0] {
            let y = apply(Retraction::QuasiGeodesic, &s, &v);
            assert_close(
                &y,
                &exponential(&s, &v, weight),
                1e-14,
                &format!("({n}, {k})"),
            );
        }
    }
}
