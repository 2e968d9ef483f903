//! A symplectic integrator of Riemannian cubics in the embedding: `T^*(TSt(n, k))` as a submanifold of `R^{4nk}`.
//!
//! The optimal control problem of cubics has the state `(S, V)` and the covariant acceleration as control. Its
//! Hamiltonian, in ambient variables and with multipliers of
//!
//! ```math
//! H = \langle p_S S^T + p_V V^T, X \rangle_F + \tfrac14 |p_V S^T - S p_V^T|_F^2,\qquad
//! X = V S^T - S V^T - \tfrac12 S (S^T V - V^T S) S^T
//! ```
//!
//! with the constraints `S^T S = I`, `S^T V + V^T S = 0` yields the cubics; on them `H = |A|^2 / 2 - <J, V>`. Momenta
//! that differ by a combination of the gradients of the constraints represent the same covector of `TSt(n, k)`; the
//! representative used here satisfies `S^T p_S + p_S^T S = 0` and `S^T p_V + p_V^T S = 0`.
//!
//! A step is a RATTLE step: a multiple of the gradients, a step of a discretization map of the ambient space, and a
//! second multiple of the gradients, chosen so that the end satisfies all four constraints. The map is the midpoint
//! one, `R_d(q, v) = (q - v/2, q + v/2)`, whose cotangent lift is the implicit midpoint rule:
//!
//! ```math
//! z_1 = z_0 + h\, X_H\Bigl(\frac{z_0 + z_1}{2}\Bigr),\qquad z = (S, V, p_S, p_V)
//! ```
//!
//! where `X_H` is the Hamiltonian vector field. This `H` is constant along the gradients of the constraints in the
//! whole ambient space, not only on the manifold, so the constraints are quadratic first integrals of its flow. The
//! midpoint rule preserves them, so the multipliers before the step vanish. It also commutes with the linear maps `p_S
//! += S M_S + V M_V`, `p_V += S M_V`, so the multipliers after the step change nothing else. Hence the method is
//! symplectic on the manifold, symmetric, of order 2, and preserves the spatial momentum `p_S S^T - S p_S^T + p_V V^T -
//! V p_V^T`.
//!
//! The implicit equations are solved to round-off by fixed-point iteration: 5 to 20 evaluations of the field, each of
//! cost `O(r k^2)` with `r = min(n, 4k)`. Increments are accumulated in compensated sums; points and velocities are not
//! projected back.
//!
//! # Source
//! arXiv 2404.19407 mentions it as future work. Discretization maps: Barbero-Liñán, Martín de Diego (2023).
//! Constraints: Jay (1996), "Symplectic partitioned Runge-Kutta methods for constrained Hamiltonian systems", SIAM J.
//! Numer. Anal. 33; Hairer, Lubich, Wanner (2006), sections IV.2 (quadratic invariants), VII.1.4 (RATTLE), VIII.6
//! (fixed-point iteration). The Hamiltonian, and the proof that its multipliers vanish, are our own.

use faer::MatRef;

use super::embedded_state::EmbeddedState;
use super::trajectory::{CubicTrajectory, check_steps};
use crate::cubic::riemannian_cubic::check_duration;
use crate::cubic::taylor::initial::InitialData;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::space::Quotient;

/// Steps of small states between two polls of the interrupt.
const STEPS_PER_CHECK: usize = 64;

/// Integrate the Riemannian cubic with given initial data, in equal steps of a symplectic method in the embedding.
///
/// ```math
/// z_1 = z_0 + h\, X_H\Bigl(\frac{z_0 + z_1}{2}\Bigr),\qquad z = (S, V, p_S, p_V),\qquad
/// H = \langle p_S S^T + p_V V^T, X \rangle_F + \tfrac14 |p_V S^T - S p_V^T|_F^2
/// ```
///
/// with `X = V S^T - S V^T - S (S^T V - V^T S) S^T / 2`, on `S^T S = I`, `S^T V + V^T S = 0`.
///
/// # Arguments
/// * `s` - point, shape `(n, k)`; `v`, `a`, `j` - velocity, covariant acceleration and covariant jerk at `s`
/// * `steps` - at least 1
/// * `t_end` - end of the time interval, finite and nonzero; negative to run backwards
/// # Accuracy
/// Order 2; the energy error does not drift; orthonormality, tangency, both momentum constraints and the spatial
/// momentum hold to round-off for any number of steps (`tests/embedded.rs`).
/// [`integrate_cubic`](crate::cubic::integrate_cubic) solves no equation and has smaller errors for the same time; this
/// method works on the paper's own phase space.
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` (`steps`, or `t_end` zero), `NoConvergence`
/// (a step too long for the fixed-point iteration), `Overflow`, `Interrupted`.
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::cubic::integrate_embedded;
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let [y, w, b, i] = [&s, &v, &a, &j].map(|a| a.as_ref());
/// let there = integrate_embedded(y, w, b, i, 50, 1.0, Interrupt::NEVER)?;
/// assert!(there.energy().iter().all(|energy| (energy + 1.0).abs() < 1e-2));
/// assert!(there.constraint_drift() < 1e-14 && there.momentum_drift() < 1e-14);
/// // The method is symmetric: the same steps lead back.
/// let [y, w, b, i] = [there.points()?, there.velocities()?, there.accelerations()?, there.jerks()?];
/// let [y, w, b, i] = [y.get(50), w.get(50), b.get(50), i.get(50)];
/// let back = integrate_embedded(y, w, b, i, 50, -1.0, Interrupt::NEVER)?;
/// assert!((back.points()?.get(50) - s).norm_l2() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
/// # Source
/// The future work of arXiv 2404.19407. Barbero-Liñán, Martín de Diego (2023) for discretization maps; Jay (1996),
/// Hairer, Lubich, Wanner (2006), sections IV.2 and VII.1.4, for constraints. The Hamiltonian, which is constant along
/// the gradients of the constraints off the manifold too, is our own.
pub fn integrate_embedded(
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
    a: MatRef<'_, f64>,
    j: MatRef<'_, f64>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<CubicTrajectory> {
    check_duration(t_end)?;
    check_steps(steps)?;
    let data = InitialData::new(s, v, a, j, Quotient::Frames)?;
    let size = [data.g.nrows(), s.ncols()];
    let mut trajectory = CubicTrajectory::with_room(size, steps, t_end)?;
    let mut state = EmbeddedState::new(&data);
    let h = t_end / steps as f64;
    let per_check = trajectory.per_check(STEPS_PER_CHECK);
    trajectory.record(&mut state)?;
    for step in 0..steps {
        if step % per_check == 0 {
            interrupt.check("cubic in the embedding")?;
        }
        state.step(h)?;
        trajectory.record(&mut state)?;
    }
    Ok(trajectory.in_frame(data.frame))
}
