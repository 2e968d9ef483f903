//! Riemannian cubics from initial data.

mod common;

use common::{EPS, Rng, random_point, random_rotation, random_tangent};
use faer::{Mat, Scale};
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::{Curve, Error, Interrupt, RiemannianCubic, Stiefel};

/// One entry of the 40-digit data: names, sizes, and `(S, V, A, J)` at 0, 0.5 and 1.
struct Reference {
    name: String,
    states: [[Mat<f64>; 4]; 3],
}

fn references() -> Vec<Reference> {
    let text = include_str!("data/cubics.json");
    let all: serde_json::Value = serde_json::from_str(text).unwrap();
    let read = |entry: &serde_json::Value, value: &serde_json::Value| -> [Mat<f64>; 4] {
        let (n, k) = (
            entry["n"].as_u64().unwrap() as usize,
            entry["k"].as_u64().unwrap() as usize,
        );
        ["point", "velocity", "acceleration", "jerk"].map(|key| {
            Mat::from_fn(n, k, |i, j| {
                let x = &value[key][i][j];
                x.as_f64()
                    .unwrap_or_else(|| x.as_str().unwrap().parse().unwrap())
            })
        })
    };
    let one = |entry: &serde_json::Value| Reference {
        name: format!("St({},{})", entry["n"], entry["k"]),
        states: [
            read(entry, &entry["initial"]),
            read(entry, &entry["at"]["0.5"]),
            read(entry, &entry["at"]["1.0"]),
        ],
    };
    all.as_array().unwrap().iter().map(one).collect()
}

fn from_state(state: &[Mat<f64>; 4], options: &IntegrationOptions<'_>) -> RiemannianCubic {
    let [s, v, a, j] = state;
    RiemannianCubic::from_initial(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), options).unwrap()
}

fn state_of(curve: &RiemannianCubic, t: f64) -> [Mat<f64>; 4] {
    [
        curve.point(t).unwrap(),
        curve.derivative(t, 1).unwrap(),
        curve.acceleration(t).unwrap(),
        curve.jerk(t).unwrap(),
    ]
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
