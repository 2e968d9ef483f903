//! Agreement with reference data, the equation, and conserved quantities.

use faer::{Mat, Scale};
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::manifold::covariant::christoffel;
use stiefel_rs::{Curve, Stiefel};

use crate::common::{EPS, Rng, SIZES, Worst, assert_within, distance, frobenius, orthonormality};
use crate::states::{
    from_state, in_tension, random_state, references, state_distance, state_of, until,
};

/// Central difference of order 6 of a matrix function.
fn difference(f: impl Fn(f64) -> Mat<f64>, t: f64, h: f64) -> Mat<f64> {
    let central = |h: f64| (f(t + h) - f(t - h)) * Scale(0.5 / h);
    let [d1, d2, d3] = [1.0, 2.0, 3.0].map(|i| central(i * h));
    d1 * Scale(1.5) - d2 * Scale(0.6) + d3 * Scale(0.1)
}

#[test]
fn forty_digit_data_is_met() {
    for reference in references() {
        let curve = from_state(&reference.states[0], &IntegrationOptions::default());
        for (t, expected) in [0.0, 0.5, 1.0].into_iter().zip(&reference.states) {
            for (found, expected) in state_of(&curve, t).iter().zip(expected) {
                let error = (found - expected).norm_l2() / expected.norm_l2().max(1.0);
                println!("{} t = {t}: {error:.2e}", reference.name);
                assert!(error < 1e-13, "{} at {t}: {error:.2e}", reference.name);
            }
        }
    }
}

#[test]
fn equation_of_riemannian_cubics_holds() {
    // Truncation h^6/140 of seventh derivatives up to a few hundred, and round-off 40 eps/h in the jerk; in tension
    // derivatives are up to ten times as large.
    for (tension, bound) in [(0.0, 2e-12), (3.0, 1e-11)] {
        let mut worst = Worst::new("D_t^3 S' + R(D_t S', S') S' - tau D_t S'");
        for (n, k) in SIZES {
            let mut rng = Rng::new((97 * n + k) as u64);
            let manifold = Stiefel::new(n, k).unwrap();
            let state = random_state((n, k), [1.0; 3], &mut rng);
            let curve = from_state(&state, &in_tension(tension, 1.2));
            for t in [0.1, 0.5, 1.0] {
                let [s, v, a, j] = state_of(&curve, t);
                let rate = difference(|t| curve.jerk(t).unwrap(), t, 5e-3);
                let third = rate + christoffel(s.as_ref(), v.as_ref(), j.as_ref());
                let turning = manifold.curvature(s.as_ref(), a.as_ref(), v.as_ref(), v.as_ref());
                let size = 1.0 + (tension + frobenius(v.as_ref()).powi(2)) * frobenius(a.as_ref());
                let defect = third + turning.unwrap() - a * Scale(tension);
                worst.see(frobenius(defect.as_ref()) / size, || {
                    format!("St({n},{k}) at {t}, tension {tension}")
                });
            }
        }
        worst.assert_at_most(bound);
    }
}

#[test]
fn energy_and_momentum_are_conserved() {
    for (tension, t_end) in [(0.0, 4.0), (2.0, 2.0)] {
        let (mut energies, mut momenta) = (Worst::new("energy"), Worst::new("momentum"));
        for (n, k) in SIZES {
            let mut rng = Rng::new((31 * n + k) as u64);
            let manifold = Stiefel::new(n, k).unwrap();
            let state = random_state((n, k), [1.0; 3], &mut rng);
            let curve = from_state(&state, &in_tension(tension, t_end));
            let (energy, momentum) = (curve.energy().unwrap(), curve.momentum().unwrap());
            assert_within(
                distance(&momentum, &(momentum.transpose() * Scale(-1.0))),
                100.0 * EPS * (1.0 + frobenius(momentum.as_ref())),
                "momentum is skew",
            );
            for t in [0.0, 0.7, 1.9, t_end] {
                let [s, v, a, j] = state_of(&curve, t);
                let (fast, bent) = (frobenius(v.as_ref()), frobenius(a.as_ref()));
                let square = |x: &Mat<f64>| manifold.norm(s.as_ref(), x.as_ref()).unwrap().powi(2);
                let product = manifold.inner(s.as_ref(), j.as_ref(), v.as_ref()).unwrap();
                let found = 0.5 * (square(&a) + tension * square(&v)) - product;
                let size = 1.0 + bent * bent + fast.powi(4) + tension * fast * fast;
                energies.see((found - energy).abs() / size, || {
                    format!("St({n},{k}) at {t}, tension {tension}")
                });
                let later = from_state(&[s, v, a, j], &in_tension(tension, 0.1));
                let size = 1.0 + fast.powi(3) + fast * bent + tension * fast;
                let defect = distance(&later.momentum().unwrap(), &momentum) / size;
                momenta.see(defect, || format!("St({n},{k}) at {t}, tension {tension}"));
            }
        }
        // 100 eps: about one per step, and the round-off of the derivatives from which the energy is computed.
        energies.assert_at_most(100.0 * EPS);
        momenta.assert_at_most(100.0 * EPS);
    }
}

#[test]
fn long_curves_stay_orthonormal() {
    for (n, k) in [(3, 1), (3, 2), (5, 2), (6, 6), (20, 4)] {
        let mut rng = Rng::new((7 * n + k) as u64);
        let state = random_state((n, k), [1.0, 0.1, 0.01], &mut rng);
        let curve = from_state(&state, &until(100.0));
        let mut worst = Worst::new(&format!("orthonormality on St({n},{k})"));
        for i in 0..=200 {
            let t = 0.5 * f64::from(i);
            worst.see(orthonormality(&curve.point(t).unwrap()), || format!("{t}"));
        }
        println!("{} steps", curve.steps());
        // The round-off of the steps adds up without growing.
        worst.assert_at_most(0.5 * EPS * curve.steps() as f64);
    }
}

#[test]
fn a_tolerance_is_kept() {
    let mut before = f64::INFINITY;
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let mut largest = 0.0_f64;
        let mut steps = 0;
        for reference in references() {
            let options = IntegrationOptions {
                tolerance,
                ..IntegrationOptions::default()
            };
            let curve = from_state(&reference.states[0], &options);
            assert_eq!(curve.tolerance(), tolerance);
            let defect = state_distance(&state_of(&curve, 1.0), &reference.states[2]);
            steps = steps.max(curve.steps());
            // The flow magnifies the error of one step by a factor of up to some tens.
            let bound = 50.0 * tolerance * curve.steps() as f64 + 1e-13;
            assert_within(
                defect,
                bound,
                &format!("{} at {tolerance:e}", reference.name),
            );
            largest = largest.max(defect);
        }
        println!("{tolerance:e}: error {largest:.2e}, at most {steps} steps");
        assert!(
            largest < before,
            "a smaller tolerance gives a smaller error"
        );
        before = largest;
    }
}
