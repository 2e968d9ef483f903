//! Symmetries, and curves with closed forms.

use faer::{Mat, Scale};
use stiefel_rs::{Curve, Geodesic, Interrupt};

use crate::common::{
    EPS, Rng, SIZES, assert_close, assert_within, conjugated, orthonormality, random_orthogonal,
    random_point,
};
use crate::states::{from_state, mapped, random_state, state_distance, state_of, until};

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
        assert_within(
            curve.cost(Interrupt::NEVER).unwrap(),
            1e-28,
            "cost of a geodesic",
        );
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
            assert_eq!(curve.cost(Interrupt::NEVER).unwrap(), 0.0);
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
                // A reflection of the space, which also acts on the vectors.
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
/// If a single one of its coefficients is nonzero, only every second or third Taylor coefficient does not vanish.
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
