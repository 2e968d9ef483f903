//! The equation `M X + X^T M^T = F` with symmetric `F`, for symmetric and for triangular `X`.

use faer::{Mat, MatRef};

use super::decomp::{solve_lower, solve_matrix, solve_upper};
use super::structure::{norm, symmetric_part};

/// Maximal number of steps of the sign iteration; if more than 20 are needed, an eigenvalue is on the imaginary axis to
/// working precision.
const MAX_STEPS: usize = 60;

/// Distance from the identity below which one more step is exact to round-off, since convergence is quadratic.
const ALMOST: f64 = 1e-8;

/// If the round-off of the solution exceeds this fraction of `F`, an eigenvalue is on the imaginary axis, from which
/// the iteration escaped only by round-off.
const MEANINGFUL: f64 = 1e-6;

/// Distance below which steps are not scaled: scaling accelerates the first steps but spoils the last ones.
const UNSCALED: f64 = 0.1;

/// The symmetric solution of `M P + P M^T = F` if every eigenvalue of `M` has a positive real part; otherwise `None`.
///
/// Computed by Newton's iteration for the matrix sign of the block triangular matrix of the equation,
///
/// ```math
/// A \gets \tfrac12 (c A + \tfrac1c A^{-1}),\quad G \gets \tfrac12 (c G + \tfrac1c A^{-1} G A^{-T}),\qquad A \to I,\quad G \to 2 P
/// ```
///
/// from `A = M`, `G = F`, with `c = (|A^{-1}| / |A|)^{1/2}`, and one step of iterative refinement if the residual is
/// above round-off.
///
/// # Accuracy
/// The residual is at most `1e-15 k |P|`, asserted in `tests/lyapunov.rs`.
/// # Source
/// Roberts (1980), "Linear model reduction and solution of the algebraic Riccati equation by use of the sign function", Int.
/// J. Control 32, 677-687; the scaling: Higham (2008), "Functions of Matrices", section 5.5.
pub fn solve_symmetric(m: MatRef<'_, f64>, f: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let first = sign_iteration(m, f)?;
    let product = m * &first;
    let residual = f - &product - product.transpose();
    let round_off = f64::EPSILON * m.nrows() as f64 * norm(m) * norm(first.as_ref());
    if round_off > MEANINGFUL * norm(f) {
        return None;
    }
    if norm(residual.as_ref()) <= round_off {
        return Some(first);
    }
    let correction = sign_iteration(m, symmetric_part(residual.as_ref()).as_ref())?;
    Some(first + correction)
}

fn sign_iteration(m: MatRef<'_, f64>, f: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let k = m.nrows();
    let identity = Mat::<f64>::identity(k, k);
    let (mut a, mut g) = (m.to_owned(), f.to_owned());
    for _ in 0..MAX_STEPS {
        let distance = norm((&a - &identity).as_ref());
        let inverse = solve_matrix(a.as_ref(), identity.as_ref())?;
        let c = if distance < UNSCALED {
            1.0
        } else {
            (norm(inverse.as_ref()) / norm(a.as_ref())).sqrt()
        };
        let turned = &inverse * &g * inverse.transpose();
        a = average(&a, &inverse, c);
        g = average(&g, &symmetric_part(turned.as_ref()), c);
        if distance < ALMOST {
            return Some(g * faer::Scale(0.5));
        }
        // NaN and overflow also end here.
        if !norm(a.as_ref()).is_finite() || !norm(g.as_ref()).is_finite() {
            return None;
        }
    }
    None
}

/// `(c X + Y / c) / 2`.
fn average(x: &Mat<f64>, y: &Mat<f64>, c: f64) -> Mat<f64> {
    Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
        0.5 * (c * x[(i, j)] + y[(i, j)] / c)
    })
}

/// The elimination `M = L U` without row exchanges, for the upper triangular solution of `M R + R^T M^T = F`.
///
/// With `H` the strictly upper part of `L^{-1} F L^{-T}` plus half of its diagonal,
///
/// ```math
/// R = U^{-1} H L^T
/// ```
///
/// since `L (U R) + (U R)^T L^T = F` and `U R L^{-T}` is upper triangular. For positive definite `F`, the diagonal of
/// `R` has the signs of the pivots. A small pivot reflects the ill-conditioning of the equation itself: a leading block
/// of `M` is nearly singular.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::lyapunov::TriangularSolver;
/// let m = mat![[2.0, 1.0], [0.5, 3.0]];
/// let f = mat![[4.0, 1.0], [1.0, 6.0]];
/// let solver = TriangularSolver::new(m.as_ref(), 0.0).expect("leading minors are positive");
/// let r = solver.solve(f.as_ref());
/// assert_eq!(r[(1, 0)], 0.0);
/// assert!((&m * &r + r.transpose() * m.transpose() - f).norm_l2() < 1e-14);
/// ```
pub struct TriangularSolver<'m> {
    m: MatRef<'m, f64>,
    lower: Mat<f64>,
    upper: Mat<f64>,
}

impl<'m> TriangularSolver<'m> {
    /// Eliminates; stops at the first pivot that is not above `floor`, and returns it as the error.
    pub fn new(m: MatRef<'m, f64>, floor: f64) -> Result<Self, f64> {
        let k = m.nrows();
        let (mut lower, mut upper) = (Mat::<f64>::identity(k, k), m.to_owned());
        for j in 0..k {
            let pivot = upper[(j, j)];
            if pivot.is_nan() || pivot <= floor {
                return Err(pivot);
            }
            for i in j + 1..k {
                lower[(i, j)] = upper[(i, j)] / pivot;
                upper[(i, j)] = 0.0;
            }
            for l in j + 1..k {
                let factor = upper[(j, l)];
                for i in j + 1..k {
                    upper[(i, l)] -= lower[(i, j)] * factor;
                }
            }
        }
        Ok(TriangularSolver { m, lower, upper })
    }

    /// The upper triangular solution, with one step of iterative refinement.
    pub fn solve(&self, f: MatRef<'_, f64>) -> Mat<f64> {
        let first = self.solve_once(f);
        let product = self.m * &first;
        let residual = f - &product - product.transpose();
        first + self.solve_once(symmetric_part(residual.as_ref()).as_ref())
    }

    fn solve_once(&self, f: MatRef<'_, f64>) -> Mat<f64> {
        let mut half = f.to_owned();
        solve_lower(self.lower.as_ref(), half.as_mut());
        solve_lower(self.lower.as_ref(), half.as_mut().transpose_mut());
        for j in 0..half.ncols() {
            half[(j, j)] *= 0.5;
            for i in j + 1..half.nrows() {
                half[(i, j)] = 0.0;
            }
        }
        let mut r = &half * self.lower.transpose();
        solve_upper(self.upper.as_ref(), r.as_mut());
        r
    }
}
