//! The paper's two experiments: every figure of its comparison, recomputed, compared with independent values.

#[path = "common/paper.rs"]
mod experiment;

use faer::Mat;
use nalgebra::SVector;
use stiefel_rs::chart::{
    Chart, Frame, LinearMap, ShootingOptions, Sphere, integrate, reference, shoot,
};
use stiefel_rs::{Curve, GeometricCubic, Interrupt, Quantity};

/// Columns: N, GCP, initial-point IVP and BVP, midpoint IVP and BVP; mean Frobenius errors, computed independently in
/// NumPy and mpmath.
const SPHERE_TABLE: [(usize, [f64; 5]); 4] = [
    (10, [9.8759e-5, 2.9143e-2, 5.4414e-3, 3.9581e-4, 4.5591e-4]),
    (20, [1.0347e-4, 1.4644e-2, 2.8290e-3, 9.4350e-5, 1.2061e-4]),
    (50, [1.0651e-4, 5.8764e-3, 1.1856e-3, 1.4640e-5, 1.9921e-5]),
    (100, [1.0757e-4, 2.9414e-3, 6.0440e-4, 3.6215e-6, 5.0316e-6]),
];
const FRAME_TABLE: [(usize, [f64; 5]); 4] = [
    (10, [4.1506e-3, 4.0638e-2, 6.2603e-3, 3.3569e-4, 2.5034e-4]),
    (20, [4.3486e-3, 2.0380e-2, 3.1081e-3, 8.1022e-5, 6.6040e-5]),
    (50, [4.4766e-3, 8.1680e-3, 1.2745e-3, 1.2682e-5, 1.0899e-5]),
    (100, [4.5209e-3, 4.0867e-3, 6.4583e-4, 3.1470e-6, 2.7527e-6]),
];

fn mean_distance(a: &[Mat<f64>], b: &[Mat<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_l2()).sum::<f64>() / a.len() as f64
}

/// Mean errors in the order of the table.
fn errors<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: SVector<f64, Z>,
    steps: usize,
) -> [f64; 5] {
    let d = X / 2;
    let t: Vec<f64> = (0..=steps).map(|i| i as f64 / steps as f64).collect();
    let exact = reference(chart, &z0, &t, Interrupt::NEVER).unwrap();
    let embed = |states: &[SVector<f64, Z>]| -> Vec<Mat<f64>> {
        states
            .iter()
            .map(|z| chart.embed(&z.as_slice()[..d]).unwrap())
            .collect()
    };
    let curve = embed(&exact);
    let velocity = |z: &SVector<f64, Z>| {
        chart
            .embed_velocity(&z.as_slice()[..d], &z.as_slice()[d..X])
            .unwrap()
    };
    let (v0, v1) = (velocity(&z0), velocity(&exact[steps]));
    let cubic = GeometricCubic::from_boundary(
        curve[0].as_ref(),
        v0.as_ref(),
        curve[steps].as_ref(),
        v1.as_ref(),
    )
    .unwrap();
    let gcp = cubic
        .sample(&t, Quantity::Derivative(0), Interrupt::NEVER)
        .unwrap();
    let gcp: Vec<Mat<f64>> = gcp.iter().map(|s| s.to_owned()).collect();
    let mut out = [mean_distance(&gcp, &curve), 0.0, 0.0, 0.0, 0.0];
    for (i, map) in [LinearMap::INITIAL_POINT, LinearMap::MIDPOINT]
        .into_iter()
        .enumerate()
    {
        let ivp = integrate(chart, &map, &z0, steps, 1.0, Interrupt::NEVER).unwrap();
        out[1 + 2 * i] = mean_distance(&embed(&ivp), &curve);
        let (x0, x1) = (
            z0.fixed_rows::<X>(0).into_owned(),
            exact[steps].fixed_rows::<X>(0).into_owned(),
        );
        let bvp = shoot(
            chart,
            &map,
            &x0,
            &x1,
            steps,
            &ShootingOptions::default(),
            Interrupt::NEVER,
        )
        .unwrap();
        assert!(bvp.report.iterations <= 5, "{} Newton steps", bvp.report);
        out[2 + 2 * i] = mean_distance(&embed(&bvp.trajectory), &curve);
    }
    out
}

fn assert_table(name: &str, table: &[(usize, [f64; 5])], measure: impl Fn(usize) -> [f64; 5]) {
    for (steps, expected) in table {
        let measured = measure(*steps);
        for (column, (m, e)) in measured.iter().zip(expected).enumerate() {
            // Four significant digits: half a unit of the fifth printed digit, plus its rounding.
            let relative = (m / e - 1.0).abs();
            assert!(
                relative < 1e-4,
                "{name}, N = {steps}, column {column}: {m:.6e} against {e:.4e}"
            );
        }
    }
}

#[test]
fn sphere_table_agrees_to_four_digits() {
    assert_table("sphere", &SPHERE_TABLE, |steps| {
        errors(&Sphere, experiment::sphere(), steps)
    });
}

#[test]
fn stiefel_3_2_table_agrees_to_four_digits() {
    assert_table("St(3,2)", &FRAME_TABLE, |steps| {
        errors(&Frame, experiment::frame(), steps)
    });
}
