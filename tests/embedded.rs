//! The symplectic integrator in the embedding: order, constraints, symplectic form, symmetry, energy, equivariance.

mod common;
#[path = "common/embedded.rs"]
mod embedding;
#[path = "common/splitting.rs"]
mod trajectories;

use common::*;
use embedding::*;
use faer::{Mat, Scale};
use stiefel_rs::{Curve, Geodesic};
use trajectories::{Data, difference, random_data, size, state};

fn mapped(data: &Data, f: impl Fn(&Mat<f64>) -> Mat<f64>) -> Data {
    data.each_ref().map(f)
}

/// Four halvings of the step, for all four quantities.
#[test]
fn order_is_two() {
    for shape in [(3, 1), (3, 2), (5, 2), (4, 4), (20, 2)] {
        let data = random_data(shape, 1.0, 50);
        let exact = exact(&data, 1.0);
        let errors = [20, 40, 80, 160, 320]
            .map(|steps| difference(&embedded_end(&data, steps, 1.0), &exact));
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        println!("{shape:?}: errors {errors:?}, orders {orders:?}");
        for order in orders {
            assert_within(
                (order - 2.0).abs(),
                0.2,
                &format!("{shape:?}: order {order:.3}"),
            );
        }
    }
}

/// The constants are three times the largest measured ones.
#[test]
fn constraints_and_momentum_hold_to_round_off_for_any_number_of_steps() {
    for shape in SHAPES {
        let data = random_data(shape, 1.0, 51);
        for steps in [10, 100, 1000, 10_000] {
            let trajectory = embedded(&data, steps, 2.0);
            let largest = (0..=steps)
                .step_by(steps / 10)
                .map(|i| size(&state(&trajectory, i)))
                .fold(0.0, f64::max);
            let points = trajectory.points().unwrap();
            let velocities = trajectory.velocities().unwrap();
            let (mut orthonormal, mut tangent) = (0.0_f64, 0.0_f64);
            for (s, v) in points.iter().zip(velocities.iter()) {
                orthonormal = orthonormal.max(orthonormality(&s.to_owned()));
                let inner = s.transpose() * v;
                tangent = tangent.max(frobenius((&inner + inner.transpose()).as_ref()));
            }
            let (moved, off) = (trajectory.momentum_drift(), trajectory.constraint_drift());
            println!(
                "{shape:?} {steps}: S {orthonormal:.1e}, V {tangent:.1e}, constraints {off:.1e}, momentum {moved:.1e}, size {largest:.1e}"
            );
            let r = shape.0.min(4 * shape.1) as f64;
            let what = |name: &str| format!("{shape:?} {steps}: {name}");
            assert_within(orthonormal, 3.0 * r * EPS, &what("orthonormality"));
            assert_within(tangent, 1.5 * r * EPS * largest, &what("tangency"));
            assert_within(off, 1.5 * r * EPS * largest, &what("constraints"));
            assert_within(moved, r * EPS * largest, &what("momentum"));
        }
    }
}

/// The momenta `(p_S, p_V)` of point, velocity, covariant acceleration and jerk, from generators in `so(n)`.
fn momenta([s, v, a, j]: &Data) -> [Mat<f64>; 2] {
    let skew = |w: &Mat<f64>| {
        w * s.transpose() - s * w.transpose() - s * (s.transpose() * w) * s.transpose()
    };
    let (x, y, z) = (skew(v), skew(a), skew(j));
    let off = identity(s.nrows()) - s * s.transpose();
    let bracket = &x * &y - &y * &x;
    let spatial = (&bracket + &off * &bracket * &off) * Scale(0.5) - z;
    let p_v = a - s * (s.transpose() * a) * Scale(0.5);
    let rest = spatial - (&p_v * v.transpose() - v * p_v.transpose());
    let p_s = &rest * s - s * (s.transpose() * &rest * s) * Scale(0.5);
    [p_s, p_v]
}

/// `(S, V, p_S, p_V)`.
fn ambient(data: &Data) -> Data {
    let [p_s, p_v] = momenta(data);
    [data[0].clone(), data[1].clone(), p_s, p_v]
}

fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (a.transpose() * b).diagonal().column_vector().iter().sum()
}

/// `dq ^ dp` of two tangent vectors.
fn form(a: &Data, b: &Data) -> f64 {
    let half = |q: &Data, p: &Data| inner(&q[0], &p[2]) + inner(&q[1], &p[3]);
    half(a, b) - half(b, a)
}

/// The state moved along the constrained manifold: all four matrices multiplied by a Cayley transform, or a tangent
/// vector added to one of the last three.
fn moved(data: &Data, direction: &Direction, step: f64) -> Data {
    match direction {
        Direction::Turn(generator) => {
            let half = generator * Scale(0.5 * step);
            let one = identity(generator.nrows());
            let inverse = (&one - &half).partial_piv_lu();
            let turn = faer::linalg::solvers::Solve::solve(&inverse, &one + &half);
            mapped(data, |m| &turn * m)
        }
        Direction::Add(which, tangent) => {
            let mut out = data.clone();
            out[*which] += tangent * Scale(step);
            out
        }
    }
}

enum Direction {
    Turn(Mat<f64>),
    Add(usize, Mat<f64>),
}

/// Differences of order 4: truncation about `1e-12`, round-off `eps / step`.
fn derivative(f: impl Fn(f64) -> Data) -> Data {
    const STEP: f64 = 1e-3;
    let [near, far] = [1.0, 2.0].map(|i| (f(i * STEP), f(-i * STEP)));
    std::array::from_fn(|i| {
        let near = (&near.0[i] - &near.1[i]) * Scale(8.0);
        (near - (&far.0[i] - &far.1[i])) * Scale(1.0 / (12.0 * STEP))
    })
}

/// The form of the ambient space on tangent vectors of the constrained manifold, before and after one long step.
#[test]
fn steps_are_symplectic_on_the_constrained_manifold() {
    for shape in [(2, 1), (3, 1), (3, 2), (5, 2), (4, 4)] {
        let data = random_data(shape, 1.0, 52);
        let mut rng = Rng::new(53);
        let directions: Vec<Direction> = (0..12)
            .map(|i| match i % 4 {
                0 => Direction::Turn(random_skew(shape.0, 1.0, &mut rng)),
                which => Direction::Add(which, random_tangent(&data[0], 1.0, &mut rng)),
            })
            .collect();
        let h = 0.4;
        let along = |step: &dyn Fn(&Data) -> Data| -> Vec<Data> {
            let one = |direction| derivative(|t| ambient(&step(&moved(&data, direction, t))));
            directions.iter().map(one).collect()
        };
        let before = along(&|data| data.clone());
        let after = along(&|data| embedded_end(data, 1, h));
        let (mut largest, mut defect) = (0.0_f64, 0.0_f64);
        for i in 0..directions.len() {
            for j in 0..i {
                let forms = [&before, &after].map(|vectors| form(&vectors[i], &vectors[j]));
                largest = largest.max(forms[0].abs());
                defect = defect.max((forms[1] - forms[0]).abs());
            }
        }
        println!("{shape:?}: form up to {largest:.2}, changed by {defect:.1e}");
        assert!(largest > 0.1, "{shape:?}: the directions say nothing");
        // Measured: 4e-13, round-off of the differences.
        assert_within(defect, 1e-11, &format!("{shape:?}: symplectic form"));
    }
}

#[test]
fn steps_are_symmetric() {
    for shape in SHAPES {
        let data = random_data(shape, 1.0, 54);
        let there = embedded_end(&data, 15, 1.0);
        let back = embedded_end(&there, 15, -1.0);
        let bound = 200.0 * shape.0 as f64 * EPS * size(&there);
        assert_within(difference(&back, &data), bound, &format!("{shape:?}"));
    }
}

#[test]
fn energy_is_that_of_the_state() {
    for shape in SHAPES {
        let data = random_data(shape, 1.0, 55);
        let manifold = stiefel_rs::Stiefel::new(shape.0, shape.1).unwrap();
        let trajectory = embedded(&data, 50, 1.0);
        for i in [0, 10, 50] {
            let [s, v, a, j] = state(&trajectory, i);
            let product = |x: &Mat<f64>, y: &Mat<f64>| {
                manifold.inner(s.as_ref(), x.as_ref(), y.as_ref()).unwrap()
            };
            let expected = 0.5 * product(&a, &a) - product(&j, &v);
            let magnitude = product(&a, &a) + (product(&j, &j) * product(&v, &v)).sqrt();
            let error = (trajectory.energy()[i] - expected).abs();
            let bound = 32.0 * shape.0 as f64 * EPS * (1.0 + magnitude);
            assert_within(error, bound, &format!("{shape:?}: energy of state {i}"));
        }
    }
}

/// A curve on the sphere whose speed stays between 1 and 1.61, 10 000 steps.
#[test]
fn energy_does_not_drift() {
    let column = |x: [f64; 3]| Mat::from_fn(3, 1, |i, _| x[i]);
    let data = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.2], [0.0; 3]].map(column);
    let trajectory = embedded(&data, 10_000, 500.0);
    let energy = trajectory.energy();
    let largest = |part: &[f64]| {
        let errors = part.iter().map(|e| (e / energy[0] - 1.0).abs());
        errors.fold(0.0_f64, f64::max)
    };
    let (early, late) = (largest(&energy[..1000]), largest(&energy[9000..]));
    println!("relative energy error {early:.2e} in the first tenth, {late:.2e} in the last");
    assert_within(late, 1.1 * early, "drift of the energy");
    assert_within(early, 2e-3, "energy");
}

#[test]
fn isometries_map_trajectories_to_trajectories() {
    for shape in SHAPES {
        let mut rng = Rng::new(56);
        let left = random_orthogonal(shape.0, &mut rng);
        let right = random_orthogonal(shape.1, &mut rng);
        let data = random_data(shape, 1.0, 57);
        let plain = embedded_end(&data, 12, 1.0);
        let turned = embedded_end(&mapped(&data, |m| &left * m * &right), 12, 1.0);
        let expected = mapped(&plain, |m| &left * m * &right);
        let bound = 200.0 * shape.0 as f64 * EPS * size(&plain);
        assert_within(difference(&turned, &expected), bound, &format!("{shape:?}"));
    }
}

/// The result does not depend on the dimension of the space that contains the span.
#[test]
fn results_do_not_depend_on_the_dimension_around() {
    for (n, k, larger) in [(3, 1, 9), (3, 2, 9), (8, 2, 100), (4, 4, 6)] {
        let mut rng = Rng::new(58);
        let embedding = random_point(larger, n, &mut rng);
        let data = random_data((n, k), 1.0, 59);
        let expected = mapped(&embedded_end(&data, 12, 1.0), |m| &embedding * m);
        let outside = embedded_end(&mapped(&data, |m| &embedding * m), 12, 1.0);
        let bound = 100.0 * larger as f64 * EPS * size(&expected);
        let what = format!("({n}, {k}) in R^{larger}");
        assert_within(difference(&outside, &expected), bound, &what);
    }
}

/// Without acceleration and jerk a step is a Cayley transform: acceleration and jerk stay zero, and the error is of
/// order 2.
#[test]
fn without_acceleration_it_is_near_the_geodesic() {
    for shape in SHAPES {
        let [s, v, _, _] = random_data(shape, 1.0, 60);
        let zero = Mat::zeros(shape.0, shape.1);
        let geodesic = Geodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let point = geodesic.point(1.0).unwrap();
        let data = [s, v, zero.clone(), zero.clone()];
        let ends = [50, 100].map(|steps| embedded_end(&data, steps, 1.0));
        for end in &ends {
            assert_close(&end[2], &zero, 4.0 * EPS, "acceleration");
            assert_close(&end[3], &zero, 16.0 * EPS, "jerk");
        }
        let [rough, fine] = ends.map(|end| distance(&end[0], &point));
        println!("{shape:?}: {rough:.1e}, {fine:.1e}");
        assert_within(rough, 5e-4, &format!("{shape:?}: geodesic"));
        // St(1, 1) consists of two points.
        if shape != (1, 1) {
            assert_within(
                (rough / fine).log2() - 2.0,
                0.2,
                &format!("{shape:?}: order"),
            );
        }
    }
}
