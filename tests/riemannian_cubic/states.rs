//! States of Riemannian cubics: reference data, random ones, and those of a curve.

use faer::Mat;
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::{Curve, RiemannianCubic};

use crate::common::{Rng, cubic_from, distance, frobenius, random_point, random_tangent};

/// One entry of the 40-digit data: names, sizes, and `(S, V, A, J)` at 0, 0.5 and 1.
pub struct Reference {
    pub name: String,
    pub states: [[Mat<f64>; 4]; 3],
}

pub fn references() -> Vec<Reference> {
    let text = include_str!("../data/cubics.json");
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

pub fn from_state(state: &[Mat<f64>; 4], options: &IntegrationOptions) -> RiemannianCubic {
    cubic_from(state.each_ref(), options)
}

pub fn state_of(curve: &RiemannianCubic, t: f64) -> [Mat<f64>; 4] {
    [
        curve.point(t).unwrap(),
        curve.derivative(t, 1).unwrap(),
        curve.acceleration(t).unwrap(),
        curve.jerk(t).unwrap(),
    ]
}

/// Point, velocity, acceleration and jerk of the given norms.
pub fn random_state((n, k): (usize, usize), norms: [f64; 3], rng: &mut Rng) -> [Mat<f64>; 4] {
    let s = random_point(n, k, rng);
    let [v, a, j] = norms.map(|norm| random_tangent(&s, norm, rng));
    [s, v, a, j]
}

pub fn until(t_end: f64) -> IntegrationOptions {
    in_tension(0.0, t_end)
}

pub fn in_tension(tension: f64, t_end: f64) -> IntegrationOptions {
    IntegrationOptions {
        tension,
        t_end,
        ..IntegrationOptions::default()
    }
}

pub fn mapped(state: &[Mat<f64>; 4], f: impl Fn(&Mat<f64>) -> Mat<f64>) -> [Mat<f64>; 4] {
    state.each_ref().map(f)
}

/// The largest distance of two states, relative to the derivatives from which a vector is computed.
///
/// Acceleration and jerk are computed from ambient derivatives, which are at least as large as the second and third
/// power of the speed.
pub fn state_distance(a: &[Mat<f64>; 4], b: &[Mat<f64>; 4]) -> f64 {
    let speed = frobenius(b[1].as_ref()).max(1.0);
    let one = |i: usize| {
        let size = frobenius(b[i].as_ref()).max(speed.powi(i as i32));
        distance(&a[i], &b[i]) / size
    };
    // Not `f64::max`, which drops NaN.
    (0..4)
        .map(one)
        .fold(0.0, |worst, x| if x <= worst { worst } else { x })
}
