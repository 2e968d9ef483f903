//! Riemannian cubics as curves: reference data, the equation, what is conserved, symmetries, special cases.

mod common;

use common::*;
use faer::{Mat, MatMut, MatRef, Scale};
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::linalg::jet::Jet;
use stiefel_rs::manifold::covariant::christoffel;
use stiefel_rs::{Curve, Geodesic, Interrupt, Quantity, Result, RiemannianCubic, Stiefel};

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

/// Point, velocity, acceleration and jerk of the given norms.
fn random_state((n, k): (usize, usize), norms: [f64; 3], rng: &mut Rng) -> [Mat<f64>; 4] {
    let s = random_point(n, k, rng);
    let [v, a, j] = norms.map(|norm| random_tangent(&s, norm, rng));
    [s, v, a, j]
}

fn until(t_end: f64) -> IntegrationOptions<'static> {
    IntegrationOptions {
        t_end,
        ..IntegrationOptions::default()
    }
}

fn mapped(state: &[Mat<f64>; 4], f: impl Fn(&Mat<f64>) -> Mat<f64>) -> [Mat<f64>; 4] {
    state.each_ref().map(f)
}

/// The largest distance of two states, relative to the derivatives that a vector is computed from.
///
/// Acceleration and jerk come from ambient derivatives, at least as large as the second and third power of the speed.
fn state_distance(a: &[Mat<f64>; 4], b: &[Mat<f64>; 4]) -> f64 {
    let speed = frobenius(b[1].as_ref()).max(1.0);
    let one = |i: usize| {
        let size = frobenius(b[i].as_ref()).max(speed.powi(i as i32));
        distance(&a[i], &b[i]) / size
    };
    // Not `f64::max`: it drops NaN.
    (0..4)
        .map(one)
        .fold(0.0, |worst, x| if x <= worst { worst } else { x })
}

/// Central difference of order 6 of a matrix function.
fn difference(f: impl Fn(f64) -> Mat<f64>, t: f64, h: f64) -> Mat<f64> {
    let central = |h: f64| (f(t + h) - f(t - h)) * Scale(0.5 / h);
    let [d1, d2, d3] = [1.0, 2.0, 3.0].map(|i| central(i * h));
    d1 * Scale(1.5) - d2 * Scale(0.6) + d3 * Scale(0.1)
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

#[test]
fn equation_of_riemannian_cubics_holds() {
    let mut worst = Worst::new("D_t^3 S' + R(D_t S', S') S'");
    for (n, k) in SIZES {
        let mut rng = Rng::new((97 * n + k) as u64);
        let manifold = Stiefel::new(n, k).unwrap();
        let state = random_state((n, k), [1.0; 3], &mut rng);
        let curve = from_state(&state, &until(1.2));
        for t in [0.1, 0.5, 1.0] {
            let [s, v, a, j] = state_of(&curve, t);
            let rate = difference(|t| curve.jerk(t).unwrap(), t, 5e-3);
            let third = rate + christoffel(s.as_ref(), v.as_ref(), j.as_ref());
            let turning = manifold.curvature(s.as_ref(), a.as_ref(), v.as_ref(), v.as_ref());
            let size = 1.0 + frobenius(v.as_ref()).powi(2) * frobenius(a.as_ref());
            let defect = frobenius((&third + turning.unwrap()).as_ref()) / size;
            worst.see(defect, || format!("St({n},{k}) at {t}"));
        }
    }
    // Truncation h^6/140 of seventh derivatives up to a few hundred, and 40 eps/h of round-off in the jerk.
    worst.assert_at_most(2e-12);
}

#[test]
fn energy_and_momentum_are_conserved() {
    let (mut energies, mut momenta) = (Worst::new("energy"), Worst::new("momentum"));
    for (n, k) in SIZES {
        let mut rng = Rng::new((31 * n + k) as u64);
        let manifold = Stiefel::new(n, k).unwrap();
        let curve = from_state(&random_state((n, k), [1.0; 3], &mut rng), &until(4.0));
        let (energy, momentum) = (curve.energy().unwrap(), curve.momentum().unwrap());
        assert_within(
            distance(&momentum, &(momentum.transpose() * Scale(-1.0))),
            100.0 * EPS * (1.0 + frobenius(momentum.as_ref())),
            "momentum is skew",
        );
        for t in [0.0, 0.7, 1.9, 4.0] {
            let [s, v, a, j] = state_of(&curve, t);
            let (fast, bent) = (frobenius(v.as_ref()), frobenius(a.as_ref()));
            let square = manifold.norm(s.as_ref(), a.as_ref()).unwrap().powi(2);
            let product = manifold.inner(s.as_ref(), j.as_ref(), v.as_ref()).unwrap();
            let size = 1.0 + bent * bent + fast.powi(4);
            let found = 0.5 * square - product;
            energies.see((found - energy).abs() / size, || {
                format!("St({n},{k}) at {t}")
            });
            let later = from_state(&[s, v, a, j], &until(0.1));
            let size = 1.0 + fast.powi(3) + fast * bent;
            let defect = distance(&later.momentum().unwrap(), &momentum) / size;
            momenta.see(defect, || format!("St({n},{k}) at {t}"));
        }
    }
    // 100 eps: about one a step, and the round-off of the derivatives that it is computed from.
    energies.assert_at_most(100.0 * EPS);
    momenta.assert_at_most(100.0 * EPS);
}

#[test]
fn long_curves_stay_orthonormal() {
    for (n, k) in [(3, 1), (3, 2), (5, 2), (6, 6), (20, 4)] {
        let mut rng = Rng::new((7 * n + k) as u64);
        let state = random_state((n, k), [1.0, 0.1, 0.01], &mut rng);
        let curve = from_state(&state, &until(100.0));
        let mut worst = Worst::new(&format!("orthonormality on St({n},{k})"));
        for i in 0..=200 {
            let t = 0.5 * f64::from(i);
            worst.see(orthonormality(&curve.point(t).unwrap()), || format!("{t}"));
        }
        println!("{} steps", curve.steps());
        // Round-off of each step adds up; it does not grow.
        worst.assert_at_most(0.5 * EPS * curve.steps() as f64);
    }
}

#[test]
fn parts_reversals_and_other_parameters_are_the_same_points() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((13 * n + k) as u64);
        let curve = from_state(&random_state((n, k), [1.0; 3], &mut rng), &until(2.0));
        let part = curve.restricted(0.3, 1.7, Interrupt::NEVER).unwrap();
        let more = curve.restricted(-1.0, 3.0, Interrupt::NEVER).unwrap();
        let (back, other) = (curve.reversed(), curve.reparametrised(-3.0, 7.0).unwrap());
        assert_eq!(part.t_span(), (0.3, 1.7));
        assert_eq!(more.t_span(), (-1.0, 3.0));
        assert_eq!(back.t_span(), curve.t_span());
        assert_eq!(other.t_span(), (-3.0, 7.0));
        let bound = 200.0 * EPS * n as f64;
        for t in [0.3, 1.0, 1.7] {
            let state = state_of(&curve, t);
            let [s, v, a, j] = state.clone();
            assert_eq!(state_of(&part, t), state, "part");
            assert_eq!(state_of(&more, t), state, "more");
            let expected = [
                s.clone(),
                v.clone() * Scale(-1.0),
                a.clone(),
                j.clone() * Scale(-1.0),
            ];
            let found = state_of(&back, 2.0 - t);
            assert_within(state_distance(&found, &expected), bound, "reversed");
            let expected = [s, v * Scale(0.2), a * Scale(0.04), j * Scale(0.008)];
            let found = state_of(&other, -3.0 + 5.0 * t);
            assert_within(state_distance(&found, &expected), bound, "other times");
        }
        let cost = curve.cost().unwrap();
        assert_within(
            (back.cost().unwrap() - cost).abs(),
            1e-13 * cost,
            "reversed",
        );
        // Squares of second derivatives over a length: the third power of the speed.
        assert_within(
            (125.0 * other.cost().unwrap() - cost).abs(),
            1e-13 * cost,
            "other times",
        );
        let pieces = [(0.0, 0.3), (0.3, 1.7), (1.7, 2.0)];
        let sum: f64 = pieces
            .map(|(a, b)| curve.restricted(a, b, Interrupt::NEVER).unwrap())
            .iter()
            .map(|c| c.cost().unwrap())
            .sum();
        assert_within((sum - cost).abs(), 1e-13 * cost, "sum of parts");
        // Twice reversed, and back to the first times, it is the same curve.
        let again = other
            .reversed()
            .reparametrised(0.0, 2.0)
            .unwrap()
            .reversed();
        assert_within(
            state_distance(&state_of(&again, 0.9), &state_of(&curve, 0.9)),
            bound,
            "there and back",
        );
    }
}

#[test]
fn initial_data_are_those_of_the_start() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((17 * n + k) as u64);
        let state = random_state((n, k), [1.0, 2.0, 3.0], &mut rng);
        let bound = 20.0 * EPS * n as f64;
        let curve = from_state(&state, &until(1.5));
        let found = curve.initial().unwrap();
        assert_within(state_distance(&found, &state), bound, "initial data");
        let shifted = curve.reparametrised(5.0, 6.5).unwrap().initial().unwrap();
        assert_within(state_distance(&shifted, &state), bound, "at other times");
        let bound = 200.0 * EPS * n as f64;
        let end = curve.reversed().initial().unwrap();
        let expected = state_of(&curve.reversed(), 0.0);
        assert_within(state_distance(&end, &expected), bound, "reversed");
        let part = curve.restricted(0.4, 1.0, Interrupt::NEVER).unwrap();
        let expected = state_of(&curve, 0.4);
        assert_within(
            state_distance(&part.initial().unwrap(), &expected),
            bound,
            "part",
        );
        let before = from_state(&state, &until(-1.5)).initial().unwrap();
        let expected = state_of(&from_state(&state, &until(-1.5)), -1.5);
        assert_within(state_distance(&before, &expected), bound, "backwards");
    }
}

#[test]
fn curves_continue_outside_of_their_interval() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((19 * n + k) as u64);
        let state = random_state((n, k), [1.0; 3], &mut rng);
        let curve = from_state(&state, &until(1.0));
        for t in [2.5, -1.5, 1.0 + 1e-12, -1e-300] {
            let made = from_state(&state, &until(t));
            assert_eq!(made.t_span(), (t.min(0.0), t.max(0.0)));
            let defect = state_distance(&state_of(&curve, t), &state_of(&made, t));
            assert_within(
                defect,
                200.0 * EPS * n as f64,
                &format!("St({n},{k}) at {t}"),
            );
        }
        // What a call integrates does not depend on how its parameters are shared out.
        let t: Vec<f64> = (0..300).map(|i| -2.0 + 0.017 * f64::from(i)).collect();
        let all = curve
            .sample(&t, Quantity::Derivative(1), Interrupt::NEVER)
            .unwrap();
        let ends = [t[0], t[299], t[1]];
        let few = curve
            .sample(&ends, Quantity::Derivative(1), Interrupt::NEVER)
            .unwrap();
        assert_eq!(all.get(1), few.get(2));
    }
}

#[test]
fn curves_run_backwards_in_time() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((23 * n + k) as u64);
        let state = random_state((n, k), [1.0; 3], &mut rng);
        let [s, v, a, j] = state.clone();
        let forward = from_state(&[s, v * Scale(-1.0), a, j * Scale(-1.0)], &until(1.5));
        let backward = from_state(&state, &until(-1.5));
        for t in [0.0, 0.6, 1.5] {
            let (found, expected) = (backward.point(-t).unwrap(), forward.point(t).unwrap());
            assert_close(&found, &expected, 50.0 * EPS * n as f64, "time reversal");
        }
    }
}

#[test]
fn isometries_carry_cubics_to_cubics() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((29 * n + k) as u64);
        let state = random_state((n, k), [1.0; 3], &mut rng);
        let (g, q) = (
            random_orthogonal(n, &mut rng),
            random_orthogonal(k, &mut rng),
        );
        let move_by = |x: &Mat<f64>| &g * x * &q;
        let (curve, moved) = (
            from_state(&state, &until(1.0)),
            from_state(&mapped(&state, move_by), &until(1.0)),
        );
        for t in [0.5, 1.0] {
            let expected = mapped(&state_of(&curve, t), move_by);
            let defect = state_distance(&state_of(&moved, t), &expected);
            assert_within(
                defect,
                200.0 * EPS * n as f64,
                &format!("St({n},{k}) at {t}"),
            );
        }
        let (momentum, turned) = (curve.momentum().unwrap(), moved.momentum().unwrap());
        let bound = 100.0 * EPS * n as f64;
        assert_close(&turned, &conjugated(&g, &momentum), bound, "momentum");
        let change = (moved.energy().unwrap() - curve.energy().unwrap()).abs();
        assert_within(change, bound, "energy");
    }
}

#[test]
fn eight_dimensions_hold_what_twenty_do() {
    let mut rng = Rng::new(37);
    let state = random_state((8, 2), [1.0, 2.0, 2.0], &mut rng);
    let frame = random_point(20, 8, &mut rng);
    let lift = |x: &Mat<f64>| &frame * x;
    let (low, high) = (
        from_state(&state, &until(1.0)),
        from_state(&mapped(&state, lift), &until(1.0)),
    );
    for t in [0.0, 0.4, 1.0, 1.5] {
        let expected = mapped(&state_of(&low, t), lift);
        let defect = state_distance(&state_of(&high, t), &expected);
        assert_within(defect, 1000.0 * EPS, &format!("at {t}"));
    }
    let found = high.momentum().unwrap();
    let expected = conjugated(&frame, &low.momentum().unwrap());
    assert_close(&found, &expected, 1000.0 * EPS, "momentum");
}

#[test]
fn geodesics_are_cubics_without_acceleration() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((41 * n + k) as u64);
        let state = random_state((n, k), [2.0, 0.0, 0.0], &mut rng);
        let curve = from_state(&state, &until(1.0));
        let geodesic = Geodesic::from_velocity(state[0].as_ref(), state[1].as_ref()).unwrap();
        for t in [0.3, 1.0, 2.0] {
            let (found, expected) = (curve.point(t).unwrap(), geodesic.point(t).unwrap());
            assert_close(&found, &expected, 100.0 * EPS * n as f64, "geodesic");
        }
        assert_within(curve.cost().unwrap(), 1e-28, "cost of a geodesic");
        assert_within(curve.energy().unwrap().abs(), 1e-28, "energy of a geodesic");
    }
}

#[test]
fn what_does_not_move_stays() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((43 * n + k) as u64);
        let state = random_state((n, k), [0.0; 3], &mut rng);
        for t_end in [1.0, -1.0, 1e300, 1e-300] {
            let curve = from_state(&state, &until(t_end));
            for t in [0.0, 0.5 * t_end, -1e200] {
                assert_within(
                    state_distance(&state_of(&curve, t), &state),
                    4.0 * EPS,
                    "still",
                );
            }
            assert_eq!(curve.cost().unwrap(), 0.0);
            assert_eq!(curve.energy().unwrap(), 0.0);
        }
    }
}

#[test]
fn both_components_of_the_orthogonal_group() {
    for n in [1, 2, 3, 4, 6] {
        let mut rng = Rng::new(n as u64);
        for turned in [false, true] {
            let mut state = random_state((n, n), [1.0; 3], &mut rng);
            if (state[0].determinant() < 0.0) != turned {
                // A reflection of the space, which moves the vectors too.
                state = mapped(&state, |x| {
                    Mat::from_fn(n, n, |i, j| if i == 0 { -x[(i, j)] } else { x[(i, j)] })
                });
            }
            let sign = if turned { -1.0 } else { 1.0 };
            let curve = from_state(&state, &until(3.0));
            for t in [0.0, 1.1, 3.0, 4.0] {
                let s = curve.point(t).unwrap();
                assert_within((s.determinant() - sign).abs(), 1e-13, "determinant");
                assert_within(orthonormality(&s), 1e-13, "orthonormality");
            }
        }
    }
}

/// On the circle the angle is a cubic polynomial of time.
///
/// With one of its coefficients alone, only every second or third Taylor coefficient does not vanish.
#[test]
fn the_circle_in_closed_form() {
    let data = [
        [0.7, -1.3, 2.9],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 1e-3],
        [1e-9, 0.0, 1.0],
    ];
    for (n, k) in [(2, 1), (2, 2)] {
        let s = Mat::<f64>::identity(n, k);
        let turn = Mat::from_fn(n, n, |i, j| [[0.0, -1.0], [1.0, 0.0]][i][j]);
        let along = |x: f64| (&turn * &s) * Scale(x);
        for [v, a, j] in data {
            let state = [s.clone(), along(v), along(a), along(j)];
            let curve = from_state(&state, &until(2.0));
            for t in [0.0, 0.9, 2.0, 3.0_f64] {
                let angle = t * (v + t * (a / 2.0 + t * j / 6.0));
                let (sin, cos) = angle.sin_cos();
                let expected = Mat::from_fn(n, n, |i, j| [[cos, -sin], [sin, cos]][i][j]) * &s;
                let bound = 20.0 * EPS * (1.0 + angle.abs());
                let what = format!("V {v:e}, A {a:e}, J {j:e} at {t}");
                assert_close(&curve.point(t).unwrap(), &expected, bound, &what);
            }
        }
    }
    let one = Mat::<f64>::identity(1, 1);
    let zero = Mat::<f64>::zeros(1, 1);
    let curve = from_state(
        &[one.clone(), zero.clone(), zero.clone(), zero],
        &until(1.0),
    );
    assert_eq!(curve.point(0.5).unwrap(), one);
}

#[test]
fn a_tolerance_is_kept() {
    let mut before = f64::INFINITY;
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let mut largest = 0.0_f64;
        let mut steps = 0;
        for reference in references() {
            let options = IntegrationOptions {
                tolerance,
                ..IntegrationOptions::default()
            };
            let curve = from_state(&reference.states[0], &options);
            assert_eq!(curve.tolerance(), tolerance);
            let defect = state_distance(&state_of(&curve, 1.0), &reference.states[2]);
            steps = steps.max(curve.steps());
            // An error of one step is handed on by the flow, which magnifies it by up to some tens.
            let bound = 50.0 * tolerance * curve.steps() as f64 + 1e-13;
            assert_within(
                defect,
                bound,
                &format!("{} at {tolerance:e}", reference.name),
            );
            largest = largest.max(defect);
        }
        println!("{tolerance:e}: error {largest:.2e}, at most {steps} steps");
        assert!(
            largest < before,
            "a smaller tolerance gives a smaller error"
        );
        before = largest;
    }
}

/// A cubic that keeps nothing but its evaluation.
struct Plain(RiemannianCubic);

impl Curve for Plain {
    type Workspace = <RiemannianCubic as Curve>::Workspace;

    fn n(&self) -> usize {
        self.0.n()
    }
    fn k(&self) -> usize {
        self.0.k()
    }
    fn t_span(&self) -> (f64, f64) {
        self.0.t_span()
    }
    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.0.frame()
    }
    fn workspace(&self) -> Self::Workspace {
        self.0.workspace()
    }
    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Self::Workspace,
        out: &mut Jet,
    ) -> Result<()> {
        self.0.coordinates_into(t, order, work, out)
    }
    fn positions_into(
        &self,
        t: &[f64],
        work: &mut Self::Workspace,
        scratch: &mut Option<Jet>,
        out: MatMut<'_, f64>,
    ) -> Result<()> {
        self.0.positions_into(t, work, scratch, out)
    }
}

#[test]
fn cost_is_that_of_quadrature() {
    for (n, k) in SIZES {
        let mut rng = Rng::new((47 * n + k) as u64);
        let curve = from_state(&random_state((n, k), [1.0; 3], &mut rng), &until(3.0));
        for (start, end) in [(0.0, 3.0), (0.2, 0.9), (-1.0, 4.0)] {
            let curve = curve.restricted(start, end, Interrupt::NEVER).unwrap();
            let exact = Plain(curve.clone()).cost().unwrap();
            let error = (curve.cost().unwrap() - exact).abs();
            // The quadrature's own tolerance.
            assert_within(
                error,
                2e-12 * exact,
                &format!("St({n},{k}), [{start}, {end}]"),
            );
        }
    }
}

/// Outside of the interval every single evaluation integrates on by itself where nobody does it before.
#[test]
fn coordinates_are_right_outside_of_the_interval() {
    let mut rng = Rng::new(53);
    let curve = from_state(&random_state((20, 3), [1.0; 3], &mut rng), &until(1.0));
    let plain = Plain(curve.clone());
    for t in [-2.0, 2.5, 0.5] {
        assert_close(
            &plain.point(t).unwrap(),
            &curve.point(t).unwrap(),
            1e-14,
            "point",
        );
        let (found, expected) = (plain.jerk(t).unwrap(), curve.jerk(t).unwrap());
        assert_close(&found, &expected, 1e-12, "jerk");
    }
}
