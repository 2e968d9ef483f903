//! The reference solution in a chart, against 40-digit data.

#[path = "common/paper.rs"]
mod paper;

use faer::Mat;
use nalgebra::SVector;
use stiefel_rs::Interrupt;
use stiefel_rs::chart::{Chart, Frame, Sphere, reference};
use stiefel_rs::manifold::covariant;

/// Covariant acceleration and jerk of a chart curve, from the flow of its momenta.
fn covariant_derivatives<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
) -> [Mat<f64>; 4] {
    let d = X / 2;
    let h = 2e-3;
    let t: Vec<f64> = (-4..=4).map(|i| f64::from(i) * h).collect();
    let states = reference(chart, z, &t, Interrupt::NEVER).unwrap();
    let points: Vec<Mat<f64>> = states
        .iter()
        .map(|z| chart.embed(&z.as_slice()[..d]).unwrap())
        .collect();
    let combine = |weights: [f64; 4], sign: f64, centre: f64, scale: f64| {
        let mut sum = &points[4] * faer::Scale(centre);
        for (j, w) in weights.iter().enumerate() {
            sum += (&points[5 + j] + &points[3 - j] * faer::Scale(sign)) * faer::Scale(*w);
        }
        sum * faer::Scale(scale)
    };
    // Central differences of orders 8, 8 and 6.
    let d1 = combine(
        [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0],
        -1.0,
        0.0,
        1.0 / h,
    );
    let d2 = combine(
        [8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0],
        1.0,
        -205.0 / 72.0,
        1.0 / (h * h),
    );
    let d3 = combine(
        [-61.0 / 30.0, 169.0 / 120.0, -3.0 / 10.0, 7.0 / 240.0],
        -1.0,
        0.0,
        1.0 / (h * h * h),
    );
    let s = points[4].clone();
    let a = covariant::acceleration(s.as_ref(), d1.as_ref(), d2.as_ref());
    let j = covariant::jerk(s.as_ref(), d1.as_ref(), d2.as_ref(), d3.as_ref());
    [s, d1, a, j]
}

fn json_matrix(value: &serde_json::Value) -> Mat<f64> {
    let rows = value.as_array().unwrap();
    Mat::from_fn(rows.len(), rows[0].as_array().unwrap().len(), |i, j| {
        rows[i][j].as_f64().unwrap()
    })
}

fn cubics() -> Vec<serde_json::Value> {
    serde_json::from_str(include_str!("data/cubics.json")).unwrap()
}

fn check_reference<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
    name: &str,
) {
    let d = X / 2;
    let data = cubics()
        .into_iter()
        .find(|case| case["name"] == name)
        .unwrap();
    let exact = reference(chart, z0, &[0.5, 1.0, 0.0], Interrupt::NEVER).unwrap();
    for (z, time) in exact.iter().zip([Some("0.5"), Some("1.0"), None]) {
        let values = time.map_or(&data["initial"], |t| &data["at"][t]);
        let expected = |key: &str| json_matrix(&values[key]);
        let (q, qdot) = (&z.as_slice()[..d], &z.as_slice()[d..X]);
        let position = (chart.embed(q).unwrap() - expected("point")).norm_l2();
        let velocity = (chart.embed_velocity(q, qdot).unwrap() - expected("velocity")).norm_l2();
        assert!(
            position < 1e-14 && velocity < 1e-14,
            "{name} at {time:?}: {position:e}, {velocity:e}"
        );
        // The differences lose digits, but still distinguish covariant from coordinate derivatives.
        let [_, _, a, j] = covariant_derivatives(chart, z);
        let acceleration = (a - expected("acceleration")).norm_l2();
        let jerk = (j - expected("jerk")).norm_l2();
        assert!(
            acceleration < 1e-8 && jerk < 1e-5,
            "{name} at {time:?}: {acceleration:e}, {jerk:e}"
        );
    }
}

#[test]
fn reference_meets_40_digit_data() {
    check_reference(&Sphere, &paper::sphere(), "paper-sphere");
    check_reference(&Frame, &paper::frame(), "paper-stiefel-3-2");
}

#[test]
fn reference_runs_backwards_and_in_any_order() {
    let z0 = paper::frame();
    let there = reference(&Frame, &z0, &[1.0, 0.25, -0.5, 0.75], Interrupt::NEVER).unwrap();
    let back = reference(&Frame, &there[0], &[-1.0, -0.75], Interrupt::NEVER).unwrap();
    assert!((back[0] - z0).amax() < 1e-13, "{:e}", (back[0] - z0).amax());
    assert!(
        (back[1] - there[1]).amax() < 1e-13,
        "{:e}",
        (back[1] - there[1]).amax()
    );
    let forward = reference(&Frame, &there[2], &[0.5], Interrupt::NEVER).unwrap();
    assert!(
        (forward[0] - z0).amax() < 1e-13,
        "{:e}",
        (forward[0] - z0).amax()
    );
}
