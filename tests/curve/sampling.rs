//! Evaluation at many parameters at once.

use stiefel_rs::{Curve, Interrupt, Quantity};

use crate::common::{Boundary, EPS, Rng, assert_close, frobenius};

const QUANTITIES: [Quantity; 6] = [
    Quantity::Derivative(0),
    Quantity::Derivative(1),
    Quantity::Derivative(2),
    Quantity::Derivative(3),
    Quantity::Acceleration,
    Quantity::Jerk,
];

fn many_times(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 / count as f64).collect()
}

#[test]
fn sampling_does_not_depend_on_the_number_of_threads() {
    let mut rng = Rng::new(41);
    let t = many_times(64 * 2 + 17);
    for size in [(3, 1), (4, 2), (20, 2), (3, 3)] {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        for quantity in QUANTITIES {
            let [one, many] = [1, 7].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| curve.sample(&t, quantity, Interrupt::NEVER))
                    .unwrap()
            });
            let bits = |x: stiefel_rs::curve::Samples| {
                x.into_entries()
                    .into_iter()
                    .map(f64::to_bits)
                    .collect::<Vec<_>>()
            };
            assert_eq!(bits(one), bits(many), "{size:?}, {quantity:?}");
        }
    }
}

#[test]
fn sampling_is_evaluation_at_each_parameter() {
    let mut rng = Rng::new(42);
    let t = many_times(80);
    for size in [(3, 1), (4, 2), (20, 2), (3, 3)] {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        for nu in 0..=3 {
            let samples = curve
                .sample(&t, Quantity::Derivative(nu), Interrupt::NEVER)
                .unwrap();
            assert_eq!(samples.len(), t.len());
            for (t, sample) in t.iter().zip(samples.iter()) {
                let alone = curve.derivative(*t, nu).unwrap();
                // The lift of a block may round differently from the lift of a single point.
                let bound = if curve.frame().is_none() {
                    0.0
                } else {
                    16.0 * EPS * (1.0 + frobenius(alone.as_ref()))
                };
                assert_close(
                    &sample.to_owned(),
                    &alone,
                    bound,
                    &format!("{size:?}, t = {t}, nu = {nu}"),
                );
            }
        }
    }
}

#[test]
fn no_parameters_give_no_samples() {
    let curve = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(43)).curve();
    let samples = curve.sample(&[], Quantity::Jerk, Interrupt::NEVER).unwrap();
    assert!(samples.is_empty() && samples.iter().count() == 0);
}
