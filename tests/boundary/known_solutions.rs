//! Boundary data of known curves.

use faer::Mat;
use stiefel_rs::cubic::BoundaryOptions;
use stiefel_rs::{Curve, Interrupt, Strategy};

use crate::common::assert_close;
use crate::data::Data;

/// Name, initial state and end state.
type Reference = (String, [Mat<f64>; 4], [Mat<f64>; 4]);

/// The 40-digit data.
fn references() -> Vec<Reference> {
    let all: serde_json::Value = serde_json::from_str(include_str!("../data/cubics.json")).unwrap();
    let read = |entry: &serde_json::Value, value: &serde_json::Value| {
        let size = |key: &str| entry[key].as_u64().unwrap() as usize;
        ["point", "velocity", "acceleration", "jerk"].map(|key| {
            Mat::from_fn(size("n"), size("k"), |i, j| {
                let x = &value[key][i][j];
                x.as_f64()
                    .unwrap_or_else(|| x.as_str().unwrap().parse().unwrap())
            })
        })
    };
    let entries = all.as_array().unwrap().iter();
    entries
        .map(|e| {
            let name = e["name"].as_str().unwrap_or_default().to_owned();
            (name, read(e, &e["initial"]), read(e, &e["at"]["1.0"]))
        })
        .collect()
}

#[test]
fn the_papers_problems_give_their_initial_data() {
    for (name, first, last) in references() {
        if !name.starts_with("paper") {
            continue;
        }
        let [s0, v0, a, j] = first;
        let [s1, v1, ..] = last;
        let curve = Data { s0, v0, s1, v1 }.solve().unwrap();
        assert_close(&curve.acceleration(0.0).unwrap(), &a, 1e-11, &name);
        assert_close(&curve.jerk(0.0).unwrap(), &j, 1e-11, &name);
        println!("{name}: {}", curve.report().unwrap());
    }
}

#[test]
fn a_guess_chooses_the_solution() {
    for (name, first, last) in references() {
        let [s0, v0, a, j] = first;
        let [s1, v1, ..] = last;
        let data = Data { s0, v0, s1, v1 };
        let options = BoundaryOptions {
            guess: Some((a.as_ref(), j.as_ref())),
            ..Default::default()
        };
        let curve = data.solve_with(&options, Interrupt::NEVER).unwrap();
        let report = curve.report().unwrap();
        assert_eq!(report.strategy, Some(Strategy::Direct));
        // The first nodes are few, so even an exact guess takes steps.
        assert!(report.iterations <= 4, "{name}: {report}");
        // The residual times the inverse of the derivative of the end.
        assert_close(&curve.acceleration(0.0).unwrap(), &a, 1e-9, &name);
    }
}
