//! Discretization maps from retractions: they are the lifted retractions of the manifold, and commute with its
//! isometries.

mod common;

use common::{Rng, assert_within, distance, random_rotation};
use faer::Mat;
use nalgebra::SVector;
use stiefel_rs::Interrupt;
use stiefel_rs::chart::{
    AtlasState, Chart, Composition, CovariantData, DiscretizationMap, Frame, RetractionMap,
    SpaceRetraction, Sphere, covariant_from_state, integrate_across,
};
use stiefel_rs::manifold::{Retraction, Stiefel};

const RETRACTIONS: [SpaceRetraction; 3] = [
    SpaceRetraction::Exponential,
    SpaceRetraction::Cayley,
    SpaceRetraction::QuasiGeodesic,
];

fn random_pair<const X: usize>(speed: f64, rng: &mut Rng) -> [SVector<f64, X>; 2] {
    let mut x = SVector::from_fn(|_, _| rng.normal());
    x[0] = rng.between(0.6, 2.5);
    [x, SVector::from_fn(|_, _| speed * rng.normal())]
}

/// The retraction of the manifold, by the crate's own functions of matrices.
fn on_the_manifold(retraction: SpaceRetraction, s: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    let (s, v) = (s.as_ref(), v.as_ref());
    match retraction {
        SpaceRetraction::Exponential => Stiefel::of("S", s).unwrap().exp(s, v).unwrap(),
        SpaceRetraction::Cayley => Retraction::Cayley.retract(s, v).unwrap(),
        SpaceRetraction::QuasiGeodesic => Retraction::QuasiGeodesic.retract(s, v).unwrap(),
    }
}

fn check_points<C: Chart<X, Z>, const X: usize, const Z: usize>(chart: &C)
where
    RetractionMap: DiscretizationMap<X>,
{
    let (d, mut rng) = (X / 2, Rng::new(7));
    for retraction in RETRACTIONS {
        for _ in 0..50 {
            let [x, v] = random_pair::<X>(0.4, &mut rng);
            let point = |x: &SVector<f64, X>| chart.embed(&x.as_slice()[..d]).unwrap();
            let velocity = |scale: f64| {
                let u: Vec<f64> = v.as_slice()[..d].iter().map(|u| scale * u).collect();
                chart.embed_velocity(&x.as_slice()[..d], &u).unwrap()
            };
            let expected =
                [-0.5, 0.5, 1.0].map(|c| on_the_manifold(retraction, &point(&x), &velocity(c)));
            let middle = RetractionMap::midpoint(retraction).map(&x, &v);
            let first = RetractionMap::initial_point(retraction).map(&x, &v);
            assert_eq!(first[0], x, "the first point is the initial one");
            // Angles near a pole lose accuracy as 1 / sin(theta); none is closer than 0.05.
            let found = [point(&middle[0]), point(&middle[1]), point(&first[1])];
            for (found, expected) in found.iter().zip(&expected) {
                let what = format!("{retraction:?}");
                assert_within(distance(found, expected), 1e-13, &what);
            }
        }
    }
}

#[test]
fn points_are_those_of_the_manifolds_retractions() {
    check_points::<_, 4, 8>(&Sphere);
    check_points::<_, 6, 12>(&Frame);
}

fn check_lift<const X: usize>()
where
    RetractionMap: DiscretizationMap<X>,
{
    // The velocities change by the derivative of the map of points: compared with differences of order 4.
    let (d, h, mut rng) = (X / 2, 1e-3, Rng::new(11));
    for retraction in RETRACTIONS {
        let map = RetractionMap::midpoint(retraction);
        let [x, v] = random_pair::<X>(0.2, &mut rng);
        let moved = |s: f64| {
            let step = |y: &SVector<f64, X>| {
                SVector::<f64, X>::from_fn(
                    |i, _| if i < d { y[i] + s * h * y[d + i] } else { y[i] },
                )
            };
            map.map(&step(&x), &step(&v))
        };
        let [two, one, minus_one, minus_two] = [2.0, 1.0, -1.0, -2.0].map(moved);
        let exact = map.map(&x, &v);
        for point in 0..2 {
            for i in 0..d {
                let near = one[point][i] - minus_one[point][i];
                let far = two[point][i] - minus_two[point][i];
                let rate = (8.0 * near - far) / (12.0 * h);
                assert_within(
                    (rate - exact[point][d + i]).abs(),
                    1e-10,
                    &format!("{retraction:?}, velocity {i} of point {point}"),
                );
            }
        }
    }
}

#[test]
fn velocities_are_lifted() {
    check_lift::<4>();
    check_lift::<6>();
}

fn check_derivatives<const X: usize>()
where
    RetractionMap: DiscretizationMap<X>,
{
    // Differences of order 4: truncation h^4 times fifth derivatives, round-off eps / h.
    let (h, mut rng) = (4e-4, Rng::new(13));
    for retraction in RETRACTIONS {
        for map in [
            RetractionMap::initial_point(retraction),
            RetractionMap::midpoint(retraction),
        ] {
            let [x, v] = random_pair::<X>(0.2, &mut rng);
            let lambda = [
                random_pair::<X>(1.0, &mut rng)[1],
                random_pair::<X>(1.0, &mut rng)[1],
            ];
            let expansion = map.expansion(&x, &v, &lambda);
            assert!((expansion.points[0] - map.map(&x, &v)[0]).amax() < 1e-15);
            assert!((expansion.points[1] - map.map(&x, &v)[1]).amax() < 1e-15);
            // The derivative of DR^T lambda as a function of (x, v) is the second derivative.
            let weighted = |x: &SVector<f64, X>, v: &SVector<f64, X>| {
                let [[ax, av], [bx, bv]] = map.jacobian(x, v);
                [
                    ax.transpose() * lambda[0] + bx.transpose() * lambda[1],
                    av.transpose() * lambda[0] + bv.transpose() * lambda[1],
                ]
            };
            for direction in 0..2 * X {
                let at = |s: f64| {
                    let (mut x, mut v) = (x, v);
                    if direction < X {
                        x[direction] += s * h;
                    } else {
                        v[direction - X] += s * h;
                    }
                    (map.map(&x, &v), weighted(&x, &v))
                };
                let [two, one, minus_one, minus_two] = [2.0, 1.0, -1.0, -2.0].map(at);
                let slope =
                    |f: [&SVector<f64, X>; 4]| ((f[1] - f[2]) * 8.0 - (f[0] - f[3])) / (12.0 * h);
                let (block, column) = (direction / X, direction % X);
                for row in 0..2 {
                    let points = [
                        &two.0[row],
                        &one.0[row],
                        &minus_one.0[row],
                        &minus_two.0[row],
                    ];
                    let exact = expansion.jacobian[row][block].column(column);
                    let defect = (slope(points) - exact).amax();
                    assert_within(defect, 1e-9, &format!("{map:?}: Jacobian"));
                    let rows = [
                        &two.1[row],
                        &one.1[row],
                        &minus_one.1[row],
                        &minus_two.1[row],
                    ];
                    let exact = expansion.second_derivative[row][block].column(column);
                    let defect = (slope(rows) - exact).amax();
                    assert_within(defect, 1e-9, &format!("{map:?}: second derivative"));
                }
            }
        }
    }
}

#[test]
fn derivatives_are_exact() {
    check_derivatives::<4>();
    check_derivatives::<6>();
}

/// A cubic in the middle of the chart.
fn start<const X: usize, const Z: usize>(chart: &impl Chart<X, Z>) -> CovariantData {
    let mut z = SVector::<f64, Z>::from_fn(|i, _| 0.3 * (1.0 + i as f64).sin());
    z[0] = 1.4;
    covariant_from_state(chart, &z).unwrap()
}

fn check_equivariance<C: Chart<X, Z>, const X: usize, const Z: usize>(chart: &C)
where
    RetractionMap: DiscretizationMap<X>,
{
    let mut rng = Rng::new(5);
    let data = start(chart);
    let rotation = random_rotation(3, &mut rng);
    let rotated = CovariantData {
        point: &rotation * &data.point,
        velocity: &rotation * &data.velocity,
        acceleration: &rotation * &data.acceleration,
        jerk: &rotation * &data.jerk,
    };
    for retraction in RETRACTIONS {
        for map in [
            RetractionMap::initial_point(retraction),
            RetractionMap::midpoint(retraction),
        ] {
            let path = |data: &CovariantData| -> Vec<CovariantData> {
                let start = AtlasState::from_covariant(chart, data).unwrap();
                let one = Composition::default();
                integrate_across(chart, &map, &one, &start, 60, 3.0, Interrupt::NEVER)
                    .unwrap()
                    .iter()
                    .map(|state| state.covariant(chart).unwrap())
                    .collect()
            };
            let (plain, turned) = (path(&data), path(&rotated));
            let momentum = plain[0].spatial_momentum();
            for (a, b) in plain.iter().zip(&turned) {
                // 60 implicit steps, solved to round-off, some of them at sin(theta) = 1/2.
                let what = format!("{map:?}");
                assert_within(distance(&(&rotation * &a.point), &b.point), 1e-11, &what);
                assert_within(distance(&(&rotation * &a.jerk), &b.jerk), 1e-10, &what);
                for (axis, value) in a.spatial_momentum().into_iter().enumerate() {
                    assert_within((value - momentum[axis]).abs(), 1e-11, &what);
                }
            }
        }
    }
}

#[test]
fn methods_commute_with_rotations_and_keep_the_spatial_momentum() {
    check_equivariance(&Sphere);
    check_equivariance(&Frame);
}
