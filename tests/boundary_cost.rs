//! Riemannian cubics from boundary data: the cost of the solution, compared with all others that are known.

mod common;
#[path = "common/boundary.rs"]
mod data;

use common::{Rng, random_point, random_tangent};
use data::*;
use faer::{Mat, Scale, mat};
use stiefel_rs::cubic::{BoundaryOptions, SearchOptions};
use stiefel_rs::{
    Curve, Error, GeodesicPolynomial, GeometricCubic, Interrupt, Result, RiemannianCubic, Stiefel,
};

/// Allowed ratio of the cost to that of another solution.
const SLACK: f64 = 1.01;

/// From rest to rest, at the given distance.
fn at_rest(shape: (usize, usize), distance: f64, rng: &mut Rng) -> Data {
    slow(shape, distance, 0.0, rng)
}

/// With end speeds up to `speed`.
fn slow((n, k): (usize, usize), distance: f64, speed: f64, rng: &mut Rng) -> Data {
    let s0 = random_point(n, k, rng);
    let way = random_tangent(&s0, distance, rng);
    let s1 = Stiefel::new(n, k)
        .unwrap()
        .exp(s0.as_ref(), way.as_ref())
        .unwrap();
    let mut velocity = |s: &Mat<f64>| random_tangent(s, 1.0, rng) * Scale(rng.between(0.0, speed));
    let (v0, v1) = (velocity(&s0), velocity(&s1));
    Data { s0, v0, s1, v1 }
}

/// Coordinate columns at the start, `image` of them with signs at the end, and the same coordinate velocity at both ends.
fn permuted(n: usize, image: &[(usize, f64)], speed: f64) -> Data {
    let k = image.len();
    let s0 = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
    let s1 = Mat::from_fn(n, k, |i, j| if i == image[j].0 { image[j].1 } else { 0.0 });
    // The first column moves towards a coordinate direction outside the frame.
    let velocity = |s: &Mat<f64>| {
        let free = (0..n)
            .rev()
            .find(|&i| (0..k).all(|j| s[(i, j)] == 0.0))
            .unwrap();
        Mat::from_fn(n, k, |i, j| if (i, j) == (free, 0) { speed } else { 0.0 })
    };
    Data {
        v0: velocity(&s0),
        v1: velocity(&s1),
        s0,
        s1,
    }
}

fn backwards(data: &Data) -> Data {
    Data {
        s0: data.s1.clone(),
        v0: -&data.v1,
        s1: data.s0.clone(),
        v1: -&data.v0,
    }
}

/// Costs of other solutions: of the reversed problem, near the geometric and the geodesic polynomial, and of the
/// geodesic traversed from rest to rest.
fn others(data: &Data) -> Vec<(&'static str, f64)> {
    let mut costs = Vec::new();
    let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
    let mut add = |name, cost: Result<f64>| costs.extend(cost.ok().map(|cost| (name, cost)));
    add(
        "reversed",
        backwards(data)
            .solve()
            .and_then(|curve| curve.cost(Interrupt::NEVER)),
    );
    let near = |ends: Result<[Mat<f64>; 2]>| {
        let [a, j] = ends?;
        let options = BoundaryOptions {
            guess: Some((a.as_ref(), j.as_ref())),
            max_iterations: 12,
            ..Default::default()
        };
        data.solve_with(&options, Interrupt::NEVER)?
            .cost(Interrupt::NEVER)
    };
    add(
        "geometric",
        near(
            GeometricCubic::from_boundary(s0, v0, s1, v1)
                .and_then(|curve| Ok([curve.acceleration(0.0)?, curve.jerk(0.0)?])),
        ),
    );
    add(
        "geodesic polynomial",
        near(
            GeodesicPolynomial::from_boundary(s0, v0, s1, v1)
                .and_then(|curve| Ok([curve.acceleration(0.0)?, curve.jerk(0.0)?])),
        ),
    );
    if data.v0.norm_max() == 0.0 && data.v1.norm_max() == 0.0 {
        let manifold = Stiefel::new(s0.nrows(), s0.ncols()).unwrap();
        add("geodesic", manifold.dist(s0, s1).map(|d| 12.0 * d.powi(2)));
    }
    costs
}

fn assert_cheap(data: &Data, what: &str) {
    let curve = data.solve().unwrap_or_else(|e| panic!("{what}: {e}"));
    let cost = curve.cost(Interrupt::NEVER).unwrap();
    for (name, other) in others(data) {
        assert!(
            cost <= SLACK * other,
            "{what}: costs {cost}, {name} {other}"
        );
    }
}

#[test]
fn from_rest_to_rest_the_geodesic_is_the_solution() {
    // (e1, e2) and exp of [[0, -1.5], [1.5, 0], [1.5, 1.5]]: the flat start leads to a curve that costs 9228.
    let s0 = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    let way = mat![[0.0, -1.5], [1.5, 0.0], [1.5, 1.5]];
    let s1 = Stiefel::new(3, 2)
        .unwrap()
        .exp(s0.as_ref(), way.as_ref())
        .unwrap();
    let rest = Mat::zeros(3, 2);
    let data = Data {
        s0,
        v0: rest.clone(),
        s1,
        v1: rest,
    };
    let cost = data.solve().unwrap().cost(Interrupt::NEVER).unwrap();
    assert!(
        (cost / 81.0 - 1.0).abs() < 1e-10,
        "12 (2.598)^2 = 81, {cost}"
    );
}

#[test]
fn far_rest_to_rest_costs_no_more_than_the_geodesic() {
    for (shape, count) in [
        ((3, 1), 20),
        ((3, 2), 40),
        ((4, 3), 20),
        ((4, 2), 20),
        ((5, 2), 10),
        ((10, 3), 8),
    ] {
        let mut rng = Rng::new(51);
        for i in 0..count {
            let far = rng.between(2.0, 2.79);
            assert_cheap(&at_rest(shape, far, &mut rng), &format!("{shape:?}, {i}"));
        }
    }
}

#[test]
fn slow_ends_cost_no_more_than_other_solutions() {
    for (shape, count) in [((3, 1), 30), ((3, 2), 30), ((4, 3), 15), ((5, 2), 15)] {
        let mut rng = Rng::new(52);
        for i in 0..count {
            let far = rng.between(0.5, 2.79);
            assert_cheap(&slow(shape, far, 0.5, &mut rng), &format!("{shape:?}, {i}"));
        }
    }
}

#[test]
fn moderate_data_cost_no_more_than_other_solutions() {
    for (shape, count) in [((3, 1), 30), ((3, 2), 30), ((4, 2), 20), ((6, 3), 4)] {
        let mut rng = Rng::new(53);
        for i in 0..count {
            let data = Data::random(shape, 2.0, 2.0, &mut rng);
            assert_cheap(&data, &format!("{shape:?}, {i}"));
        }
    }
}

#[test]
fn coordinate_frames_and_permuted_ones_cost_no_more_backwards() {
    let frames: [(usize, &[(usize, f64)]); 7] = [
        (3, &[(1, 1.0), (2, 1.0)]),
        (3, &[(2, -1.0), (0, 1.0)]),
        (3, &[(1, 1.0), (0, -1.0)]),
        (4, &[(2, 1.0), (3, 1.0)]),
        (4, &[(1, 1.0), (2, 1.0), (3, 1.0)]),
        (4, &[(3, -1.0), (0, 1.0), (2, 1.0)]),
        (5, &[(0, 1.0), (4, 1.0), (1, -1.0)]),
    ];
    for (n, image) in frames {
        for speed in [0.0, 0.5, 1.0] {
            let data = permuted(n, image, speed);
            assert_cheap(&data, &format!("{image:?} at {speed}"));
        }
    }
}

#[test]
fn a_search_finds_nothing_cheaper() {
    for (shape, count) in [((3, 1), 4), ((3, 2), 4), ((4, 2), 2)] {
        let mut rng = Rng::new(54);
        for i in 0..count {
            let data = slow(shape, rng.between(1.5, 2.79), 0.5, &mut rng);
            let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
            let options = SearchOptions {
                starts: 4,
                ..Default::default()
            };
            let all =
                RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER)
                    .unwrap();
            let (least, cost) = (
                all[0].cost(Interrupt::NEVER).unwrap(),
                data.solve().unwrap().cost(Interrupt::NEVER).unwrap(),
            );
            assert!(
                cost <= SLACK * least,
                "{shape:?}, {i}: costs {cost}, the search finds {least}"
            );
        }
    }
}

#[test]
fn curves_that_are_exact_up_to_round_off_are_solutions() {
    // A reparametrised geodesic; its end is accurate only to 1e-12, since errors of the start grow along it.
    let mut rng = Rng::new(55);
    let mut solved = 0;
    for shape in [(5, 2), (8, 4)] {
        for _ in 0..6 {
            let far = rng.between(2.79, 3.1);
            match at_rest(shape, far, &mut rng).solve() {
                Ok(_) => solved += 1,
                Err(Error::NoConvergence { report, .. }) => println!("{shape:?}: {report}"),
                Err(error) => panic!("{error}"),
            }
        }
    }
    assert!(solved >= 11, "{solved} of 12");
}
