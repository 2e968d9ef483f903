//! `M X + X^T M^T = F` for symmetric and triangular `X`.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::linalg::lyapunov::{TriangularSolver, solve_symmetric};

fn residual(m: &Mat<f64>, x: &Mat<f64>, f: &Mat<f64>) -> f64 {
    let product = m * x;
    frobenius((&product + product.transpose() - f).as_ref())
}

fn symmetric(k: usize, rng: &mut Rng) -> Mat<f64> {
    let g = gaussian(k, k, rng);
    &g + g.transpose()
}

/// A matrix whose symmetric part has the given eigenvalues, plus a skew part: its spectrum is to the right of zero if
/// they are positive.
fn stable(low: f64, high: f64, k: usize, rng: &mut Rng) -> Mat<f64> {
    let q = random_orthogonal(k, rng);
    let d = Mat::from_fn(k, k, |i, j| {
        let t = i as f64 / (k.max(2) - 1) as f64;
        if i == j {
            low.powf(1.0 - t) * high.powf(t)
        } else {
            0.0
        }
    });
    conjugated(&q, &d) + random_skew(k, high, rng)
}

#[test]
fn symmetric_solution_has_a_small_residual() {
    let mut rng = Rng::new(101);
    let mut worst = Worst::new("residual");
    for k in [1, 2, 3, 6, 15, 30] {
        for low in [1.0, 1e-2, 1e-5] {
            let (m, f) = (stable(low, 1.0, k, &mut rng), symmetric(k, &mut rng));
            let p = solve_symmetric(m.as_ref(), f.as_ref()).unwrap();
            assert_close(
                &p,
                &p.transpose().to_owned(),
                0.0,
                "symmetric to the last digit",
            );
            let size = frobenius(p.as_ref()) * k as f64;
            worst.see(residual(&m, &p, &f) / size, || format!("k = {k}, {low}"));
        }
    }
    worst.assert_at_most(1e-15);
}

#[test]
fn spectra_that_are_not_to_the_right_are_refused() {
    let mut rng = Rng::new(102);
    for k in [1, 2, 3, 3, 3, 5, 6, 7, 15] {
        let f = identity(k);
        for m in [
            stable(0.1, 1.0, k, &mut rng) * Scale(-1.0),
            // On the imaginary axis, where the iteration does not converge.
            random_skew(k, 1.0, &mut rng),
            // Regression: a skew matrix of odd size is singular as well, and the iteration may escape by round-off.
            random_skew(k, 1.0, &mut rng),
            random_skew(k, 1e-3, &mut rng),
            Mat::zeros(k, k),
            Mat::from_fn(k, k, |i, j| {
                if i != j {
                    0.0
                } else if i == 0 {
                    -1e-3
                } else {
                    1.0
                }
            }),
            Mat::from_fn(k, k, |_, _| f64::NAN),
            Mat::from_fn(k, k, |_, _| 1e300),
        ] {
            assert!(
                solve_symmetric(m.as_ref(), f.as_ref()).is_none(),
                "k = {k}: {m:?}"
            );
        }
    }
}

#[test]
fn triangular_solution_has_a_small_residual() {
    let mut rng = Rng::new(103);
    let mut worst = Worst::new("residual");
    for k in [1, 2, 3, 6, 15, 30] {
        for low in [1.0, 1e-2, 1e-5] {
            // A definite symmetric part makes all leading minors positive.
            let (m, f) = (stable(low, 1.0, k, &mut rng), symmetric(k, &mut rng));
            let r = TriangularSolver::new(m.as_ref(), 0.0)
                .unwrap_or_else(|p| panic!("pivot {p}"))
                .solve(f.as_ref());
            for j in 0..k {
                for i in j + 1..k {
                    assert_eq!(r[(i, j)], 0.0, "below the diagonal");
                }
            }
            let size = frobenius(r.as_ref()) * k as f64;
            worst.see(residual(&m, &r, &f) / size, || format!("k = {k}, {low}"));
        }
    }
    worst.assert_at_most(1e-15);
}

#[test]
fn the_first_pivot_that_is_too_small_is_reported() {
    let m = Mat::from_fn(3, 3, |i, j| {
        [[2.0, 1.0, 0.0], [2.0, 0.5, 1.0], [0.0, 0.0, 1.0]][i][j]
    });
    assert_eq!(TriangularSolver::new(m.as_ref(), 0.0).err(), Some(-0.5));
    assert_eq!(TriangularSolver::new(m.as_ref(), 2.0).err(), Some(2.0));
    let nan = Mat::from_fn(2, 2, |_, _| f64::NAN);
    assert!(TriangularSolver::new(nan.as_ref(), 0.0).is_err_and(f64::is_nan));
}
