//! Curves across charts: changes of chart, the reference through the poles, discrete flows, covariant data.

mod common;
#[path = "common/paper.rs"]
mod paper;

use std::f64::consts::PI;

use common::{Rng, assert_within, distance, random_orthogonal};
use faer::Mat;
use nalgebra::{SMatrix, SVector};
use stiefel_rs::chart::atlas::{
    MARGIN, step_across_with_tangent, transition, transition_with_tangent,
};
use stiefel_rs::chart::{
    AtlasState, Chart, Composition, CovariantData, DiscretizationMap, Frame, LinearMap,
    RetractionMap, SpaceRetraction, Sphere, covariant_from_state, integrate, integrate_across,
    reference_across, state_from_covariant,
};
use stiefel_rs::{Error, Interrupt};

fn json_matrix(value: &serde_json::Value) -> Mat<f64> {
    let rows = value.as_array().unwrap();
    Mat::from_fn(rows.len(), rows[0].as_array().unwrap().len(), |i, j| {
        rows[i][j].as_f64().unwrap()
    })
}

fn data_of(value: &serde_json::Value) -> CovariantData {
    let read = |key: &str| json_matrix(&value[key]);
    CovariantData {
        point: read("point"),
        velocity: read("velocity"),
        acceleration: read("acceleration"),
        jerk: read("jerk"),
    }
}

fn rotated(rotation: &Mat<f64>, data: &CovariantData) -> CovariantData {
    CovariantData {
        point: rotation * &data.point,
        velocity: rotation * &data.velocity,
        acceleration: rotation * &data.acceleration,
        jerk: rotation * &data.jerk,
    }
}

fn defect(a: &CovariantData, b: &CovariantData) -> f64 {
    [
        distance(&a.point, &b.point),
        distance(&a.velocity, &b.velocity),
        distance(&a.acceleration, &b.acceleration),
        distance(&a.jerk, &b.jerk),
    ]
    .into_iter()
    .fold(0.0, f64::max)
}

/// 40-digit curves on `St(3, k)`: the initial data, and the data at 0.5 and 1.
fn cubics(k: u64) -> Vec<[CovariantData; 3]> {
    let all: Vec<serde_json::Value> =
        serde_json::from_str(include_str!("data/cubics.json")).unwrap();
    all.iter()
        .filter(|case| case["n"] == 3 && case["k"] == k)
        .map(|case| {
            let at = &case["at"];
            [&case["initial"], &at["0.5"], &at["1.0"]].map(data_of)
        })
        .collect()
}

/// Rotations that map the point at time 0, 1/2 or 1 to a pole, and some random elements of `O(3)`.
fn rotations(cubic: &[CovariantData; 3], rng: &mut Rng) -> Vec<Mat<f64>> {
    let mut out: Vec<Mat<f64>> = cubic
        .iter()
        .map(|data| {
            // The rotation about the direction halfway, by pi, maps the first column to e_3.
            let axis: Vec<f64> = (0..3)
                .map(|i| data.point[(i, 0)] + f64::from(u8::from(i == 2)))
                .collect();
            let square: f64 = axis.iter().map(|x| x * x).sum();
            Mat::from_fn(3, 3, |i, j| {
                2.0 * axis[i] * axis[j] / square - f64::from(u8::from(i == j))
            })
        })
        .collect();
    out.extend((0..10).map(|_| random_orthogonal(3, rng)));
    out
}

fn check_reference<C: Chart<X, Z>, const X: usize, const Z: usize>(chart: &C) {
    let mut rng = Rng::new(3);
    let (mut changes, mut count) = (0, 0);
    for cubic in cubics(C::K as u64) {
        for rotation in rotations(&cubic, &mut rng) {
            let [initial, half, end] = cubic.each_ref().map(|data| rotated(&rotation, data));
            let start = AtlasState::from_covariant(chart, &initial).unwrap();
            let t = [1.0, 0.5, 0.0];
            let found = reference_across(chart, &start, &t, Interrupt::NEVER).unwrap();
            for (state, expected) in found.iter().zip([&end, &half, &initial]) {
                let data = state.covariant(chart).unwrap();
                assert_within(defect(&data, expected), 1e-12, "reference across the poles");
                // The rotation of the state maps the curve into its chart.
                let turn = state.rotation();
                let turn = Mat::from_fn(3, 3, |i, j| turn[(i, j)]);
                let embedded = chart.embed(&state.z.as_slice()[..X / 2]).unwrap();
                assert_within(
                    distance(&(turn * &data.point), &embedded),
                    1e-15,
                    "rotation",
                );
            }
            changes += usize::from(found[0].turns != found[2].turns);
            count += 1;
            let energy = |state: &AtlasState<Z>| chart.hamiltonian(&state.z);
            let drift = (energy(&found[0]) - energy(&found[2])).abs();
            assert_within(drift, 1e-12 * (1.0 + energy(&found[0]).abs()), "energy");
        }
    }
    assert!(
        count >= 26 && changes >= 3,
        "{changes} of {count} curves change the chart"
    );
}

#[test]
fn reference_meets_40_digit_data_turned_across_the_poles() {
    check_reference(&Sphere);
    check_reference(&Frame);
}

fn random_state<const Z: usize>(rng: &mut Rng) -> SVector<f64, Z> {
    let mut z = SVector::from_fn(|_, _| rng.normal());
    z[0] = rng.between(0.3, PI - 0.3);
    z
}

#[test]
fn covariant_data_and_states_are_inverse() {
    fn check<const X: usize, const Z: usize>(chart: &impl Chart<X, Z>) {
        let mut rng = Rng::new(17);
        for _ in 0..100 {
            let z = random_state::<Z>(&mut rng);
            let data = covariant_from_state(chart, &z).unwrap();
            let mut back = state_from_covariant(chart, &data).unwrap();
            for i in 1..X / 2 {
                back[i] += 2.0 * PI * ((z[i] - back[i]) / (2.0 * PI)).round();
            }
            // The inverse metric grows as sin(theta)^-2 <= 12, the numbers as 10.
            assert_within((back - z).amax(), 1e-12, "state, data, state");
        }
    }
    check(&Sphere);
    check(&Frame);
}

#[test]
fn states_of_covariant_data_are_the_papers_momenta() {
    let [initial, ..] = &cubics(1)[0];
    let z = state_from_covariant(&Sphere, initial).unwrap();
    assert_within((z - paper::sphere()).amax(), 1e-14, "the paper's sphere");
    let [initial, ..] = &cubics(2)[0];
    let mut z = state_from_covariant(&Frame, initial).unwrap();
    for i in 1..3 {
        z[i] += 2.0 * PI * ((PI - z[i]) / (2.0 * PI)).round();
    }
    assert_within((z - paper::frame()).amax(), 1e-14, "the paper's frame");
}

fn symplectic_defect<const Z: usize>(jacobian: &SMatrix<f64, Z, Z>) -> f64 {
    let half = Z / 2;
    let omega = SMatrix::<f64, Z, Z>::from_fn(|i, j| {
        f64::from(i8::from(j == i + half) - i8::from(i == j + half))
    });
    (jacobian.transpose() * omega * jacobian - omega).amax()
}

fn check_transition<C: Chart<X, Z>, const X: usize, const Z: usize>(chart: &C) {
    let mut rng = Rng::new(23);
    let mut checked = 0;
    while checked < 40 {
        let z = random_state::<Z>(&mut rng);
        let turns = 1 + checked % 2;
        let moved = transition(chart, &z, turns).unwrap();
        // Next to a pole of either chart the derivatives are large, and so is their round-off.
        if z[0].sin().min(moved[0].sin()) < 0.4 {
            continue;
        }
        checked += 1;
        let (same, jacobian) = transition_with_tangent(chart, &z, turns).unwrap();
        assert_eq!(same, moved);
        let size = jacobian.amax().max(1.0);
        let defect = symplectic_defect(&jacobian);
        assert_within(defect, 1e-13, "J^T Omega J - Omega");
        let energy = chart.hamiltonian(&z);
        let change = (chart.hamiltonian(&moved) - energy).abs();
        assert_within(change, 64.0 * f64::EPSILON * (1.0 + size * size), "energy");
        // Rotating the data and transforming the state agree, and a full turn is the identity.
        let [here, there] = [&z, &moved].map(|z| covariant_from_state(chart, z).unwrap());
        let turned = |m: &Mat<f64>| Mat::from_fn(3, C::K, |i, j| m[((i + 3 - turns) % 3, j)]);
        assert_within(distance(&turned(&here.point), &there.point), 1e-14, "point");
        assert_within(distance(&turned(&here.jerk), &there.jerk), 1e-12, "jerk");
        let back = transition(chart, &moved, 3 - turns).unwrap();
        assert_within(
            (back.rows(X / 2, Z - X / 2) - z.rows(X / 2, Z - X / 2)).amax(),
            1e-12,
            "full turn",
        );
        let h = 1e-3;
        for i in 0..Z {
            let at = |s: f64| {
                let mut near = z;
                near[i] += s * h;
                let mut out = transition(chart, &near, turns).unwrap();
                for j in 1..X / 2 {
                    out[j] += 2.0 * PI * ((moved[j] - out[j]) / (2.0 * PI)).round();
                }
                out
            };
            let column = ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h);
            // Truncation: h^4 times fifth derivatives.
            assert_within(
                (column - jacobian.column(i)).amax(),
                1e-8 * size,
                "column of the tangent",
            );
        }
    }
}

#[test]
fn changes_of_chart_are_symplectic_and_change_nothing() {
    check_transition(&Sphere);
    check_transition(&Frame);
}

#[test]
fn steps_with_a_change_of_chart_are_symplectic() {
    fn check<const X: usize, const Z: usize>(chart: &impl Chart<X, Z>)
    where
        RetractionMap: DiscretizationMap<X>,
    {
        let mut z = SVector::<f64, Z>::from_fn(|i, _| 0.3 * (1.0 + i as f64).sin());
        z[0] = MARGIN.asin() - 0.05;
        let start = AtlasState { turns: 0, z };
        let test = |name: &str, step: (AtlasState<Z>, SMatrix<f64, Z, Z>)| {
            assert!(step.0.turns != 0, "{name}: the chart changes");
            assert_within(symplectic_defect(&step.1), 1e-12, name);
        };
        let one = Composition::default();
        test(
            "mid-point",
            step_across_with_tangent(chart, &LinearMap::MIDPOINT, &one, &start, 0.05).unwrap(),
        );
        test(
            "initial point",
            step_across_with_tangent(chart, &LinearMap::INITIAL_POINT, &one, &start, 0.05).unwrap(),
        );
        let map = RetractionMap::midpoint(SpaceRetraction::Exponential);
        test(
            "exponential",
            step_across_with_tangent(chart, &map, &one, &start, 0.05).unwrap(),
        );
        let six = Composition::new(2, 6).unwrap();
        test(
            "order 6",
            step_across_with_tangent(chart, &map, &six, &start, 0.05).unwrap(),
        );
    }
    check(&Sphere);
    check(&Frame);
}

/// Error at the end, compared with the 40-digit curve rotated so that it passes through a pole at half time.
fn error<C: Chart<X, Z>, const X: usize, const Z: usize>(
    chart: &C,
    map: &impl DiscretizationMap<X>,
    order: usize,
    steps: usize,
) -> f64 {
    let cubic = &cubics(C::K as u64)[0];
    let rotation = &rotations(cubic, &mut Rng::new(1))[1];
    let [initial, half, end] = cubic.each_ref().map(|data| rotated(rotation, data));
    assert!((half.point[(2, 0)] - 1.0).abs() < 1e-14, "through the pole");
    let start = AtlasState::from_covariant(chart, &initial).unwrap();
    let composition = Composition::new(map.order(), order).unwrap();
    let path = integrate_across(
        chart,
        map,
        &composition,
        &start,
        steps,
        1.0,
        Interrupt::NEVER,
    );
    defect(&path.unwrap()[steps].covariant(chart).unwrap(), &end)
}

fn check_orders<C: Chart<X, Z>, const X: usize, const Z: usize>(chart: &C)
where
    RetractionMap: DiscretizationMap<X>,
{
    let exponential = RetractionMap::midpoint(SpaceRetraction::Exponential);
    for (order, steps) in [(2, [50, 400]), (4, [20, 80]), (6, [8, 20])] {
        let slope = |errors: [f64; 2]| {
            (errors[0] / errors[1]).ln() / (steps[1] as f64 / steps[0] as f64).ln()
        };
        let invariant = slope(steps.map(|n| error(chart, &exponential, order, n)));
        assert!(
            (invariant - order as f64).abs() < 0.2,
            "exponential: {invariant:.3} for {order}"
        );
        let linear = slope(steps.map(|n| error(chart, &LinearMap::MIDPOINT, order, n)));
        assert!(
            (linear - order as f64).abs() < 0.6,
            "mid-point: {linear:.3} for {order}"
        );
    }
    let best = error(chart, &exponential, 8, 40);
    assert_within(best, 1e-12, "order 8, 40 steps, through the pole");
    let best = error(chart, &LinearMap::MIDPOINT, 8, 60);
    assert_within(
        best,
        1e-12,
        "mid-point of order 8, 60 steps, through the pole",
    );
}

#[test]
fn discrete_flows_run_through_the_poles() {
    check_orders(&Sphere);
    check_orders(&Frame);
}

#[test]
fn far_from_the_poles_nothing_changes() {
    let z0 = paper::sphere();
    let plain = integrate(
        &Sphere,
        &LinearMap::MIDPOINT,
        &z0,
        50,
        1.0,
        Interrupt::NEVER,
    )
    .unwrap();
    let start = AtlasState { turns: 0, z: z0 };
    let one = Composition::default();
    let across = integrate_across(
        &Sphere,
        &LinearMap::MIDPOINT,
        &one,
        &start,
        50,
        1.0,
        Interrupt::NEVER,
    )
    .unwrap();
    for (z, state) in plain.iter().zip(&across) {
        assert_eq!((0, z), (state.turns, &state.z));
    }
}

#[test]
fn charts_do_not_change_to_and_fro() {
    let mut rng = Rng::new(31);
    let mut total = 0;
    for _ in 0..20 {
        // A great circle over ten radians.
        let mut z = SVector::<f64, 8>::zeros();
        (z[0], z[2]) = (rng.between(0.1, PI - 0.1), rng.between(-1.0, 1.0));
        z[3] = (1.0 - z[2] * z[2]).sqrt() / z[0].sin();
        let (start, one) = (AtlasState { turns: 0, z }, Composition::default());
        let map = RetractionMap::midpoint(SpaceRetraction::Exponential);
        let never = Interrupt::NEVER;
        let path = integrate_across(&Sphere, &map, &one, &start, 1000, 10.0, never).unwrap();
        let mut changes = 0;
        for pair in path
            .windows(2)
            .filter(|pair| pair[0].turns != pair[1].turns)
        {
            changes += 1;
            let sin = pair[1].z[0].sin();
            assert!(
                sin > (2.0_f64 / 3.0).sqrt(),
                "arrives at sin(theta) = {sin}"
            );
        }
        // From sin(theta) = sqrt(2/3) to 1/2 the angle changes by 0.43.
        assert!(changes <= 1 + (10.0 / 0.43) as usize, "{changes} changes");
        total += changes;
    }
    // Half of the circles come closer than the margin to the third axis.
    assert!(total >= 10, "{total} changes on all of the circles");
}

#[test]
fn bad_input_is_a_typed_error() {
    let [good, ..] = &cubics(2)[0];
    let with = |change: &dyn Fn(&mut CovariantData)| {
        let mut data = good.clone();
        change(&mut data);
        AtlasState::from_covariant(&Frame, &data).map(|_| ())
    };
    assert!(matches!(
        with(&|data| data.point[(0, 0)] = f64::NAN),
        Err(Error::NonFinite { name: "S", .. })
    ));
    assert!(matches!(
        with(&|data| data.point[(0, 0)] += 0.1),
        Err(Error::NotOrthonormal { name: "S", .. })
    ));
    assert!(matches!(
        with(&|data| data.acceleration = &data.acceleration + &data.point),
        Err(Error::NotTangent { name: "A", .. })
    ));
    assert!(matches!(
        with(&|data| data.jerk = Mat::zeros(3, 1)),
        Err(Error::Shape { name: "J", .. })
    ));
    let huge = with(&|data| data.jerk = &data.jerk * faer::Scale(1e308));
    assert!(huge.is_ok() || matches!(huge, Err(Error::Overflow { .. } | Error::NotTangent { .. })));
    let pole = CovariantData {
        point: Mat::from_fn(3, 1, |i, _| f64::from(u8::from(i == 2))),
        velocity: Mat::zeros(3, 1),
        acceleration: Mat::zeros(3, 1),
        jerk: Mat::zeros(3, 1),
    };
    assert!(matches!(
        state_from_covariant(&Sphere, &pole),
        Err(Error::OutsideChart { value: 0.0, .. })
    ));
    let start = AtlasState::from_covariant(&Sphere, &pole).unwrap();
    let one = Composition::default();
    let run = |steps, t_end| {
        let map = LinearMap::MIDPOINT;
        integrate_across(&Sphere, &map, &one, &start, steps, t_end, Interrupt::NEVER)
    };
    assert!(matches!(
        run(0, 1.0),
        Err(Error::InvalidArgument { name: "steps", .. })
    ));
    assert!(matches!(
        run(3, f64::NAN),
        Err(Error::NonFinite { name: "t_end", .. })
    ));
    assert!(run(3, 0.0).is_ok());
    let stop = || true;
    let out = reference_across(&Sphere, &start, &[1.0], Interrupt::new(&stop));
    assert!(matches!(out, Err(Error::Interrupted { .. })));
    let far = reference_across(&Sphere, &start, &[f64::INFINITY], Interrupt::NEVER);
    assert!(matches!(far, Err(Error::NonFinite { name: "t", .. })));
}
