//! Poses joined by a spline, sampled at 100 Hz with body twists: `cargo run --release --example interpolate_poses`.

use nalgebra::{Isometry3, Vector3};
use stiefel_rs::Interrupt;
use stiefel_rs::rotation::{PoseEnds, PoseSpline, ReferenceFrame};
use stiefel_rs::spline::SplineOptions;

fn main() -> stiefel_rs::Result<()> {
    let t = [0.0, 1.0, 2.5, 4.0];
    // Positions in m; rotation vectors in rad.
    let poses = [
        ([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]),
        ([0.5, 0.2, 1.1], [0.0, 0.3, 0.8]),
        ([1.2, 0.9, 1.0], [0.4, 0.3, 1.6]),
        ([1.0, 1.8, 0.8], [0.2, 0.0, 2.4]),
    ]
    .map(|(p, v)| Isometry3::new(Vector3::from(p), Vector3::from(v)));
    let spline = PoseSpline::new(
        &t,
        &poses,
        &PoseEnds::Natural,
        &SplineOptions::default(),
        Interrupt::NEVER,
    )?;
    println!("# t x y z qx qy qz qw wx wy wz vx vy vz");
    for i in 0..=400 {
        let time = 0.01 * f64::from(i);
        let (pose, twist) = (
            spline.pose(time)?,
            spline.twist(time, ReferenceFrame::Body)?,
        );
        let numbers = pose
            .translation
            .vector
            .iter()
            .chain(pose.rotation.coords.iter());
        let row: Vec<String> = numbers
            .chain(twist.iter())
            .map(|x| format!("{x:.9}"))
            .collect();
        println!("{time:.2} {}", row.join(" "));
    }
    Ok(())
}
