//! Parts of curves, and extrapolation outside their interval.

use faer::{MatMut, MatRef, Scale};
use stiefel_rs::linalg::jet::MatrixJet;
use stiefel_rs::{Curve, Interrupt, Quantity, Result, RiemannianCubic};

use crate::common::{EPS, Rng, SIZES, assert_close, assert_within};
use crate::states::{from_state, random_state, state_distance, state_of, until};

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
        let cost = curve.cost(Interrupt::NEVER).unwrap();
        assert_within(
            (back.cost(Interrupt::NEVER).unwrap() - cost).abs(),
            1e-13 * cost,
            "reversed",
        );
        // Squares of second derivatives, integrated over time: the third power of the speed.
        assert_within(
            (125.0 * other.cost(Interrupt::NEVER).unwrap() - cost).abs(),
            1e-13 * cost,
            "other times",
        );
        let pieces = [(0.0, 0.3), (0.3, 1.7), (1.7, 2.0)];
        let sum: f64 = pieces
            .map(|(a, b)| curve.restricted(a, b, Interrupt::NEVER).unwrap())
            .iter()
            .map(|c| c.cost(Interrupt::NEVER).unwrap())
            .sum();
        assert_within((sum - cost).abs(), 1e-13 * cost, "sum of parts");
        // Reversed twice and mapped back to the original times, it is the same curve.
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
        // The result of a call does not depend on how its parameters are distributed to threads.
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

/// A cubic that only implements evaluation.
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
        out: &mut MatrixJet,
    ) -> Result<()> {
        self.0.coordinates_into(t, order, work, out)
    }
    fn positions_into(
        &self,
        t: &[f64],
        work: &mut Self::Workspace,
        scratch: &mut Option<MatrixJet>,
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
            let exact = Plain(curve.clone()).cost(Interrupt::NEVER).unwrap();
            let error = (curve.cost(Interrupt::NEVER).unwrap() - exact).abs();
            // The tolerance of the quadrature.
            assert_within(
                error,
                2e-12 * exact,
                &format!("St({n},{k}), [{start}, {end}]"),
            );
        }
    }
}

/// Outside the interval, every single evaluation extends the curve itself, unless it has been extended before.
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
