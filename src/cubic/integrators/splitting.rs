//! Explicit symplectic integrators of Riemannian cubics on any `St(n, k)`.
//!
//! The cubics are the projections of the flow of `H = <mu, x> + |p|^2 / 2` on `T^*(SO(r) x m)`, left-trivialised:
//!
//! ```math
//! g' = g x,\qquad x' = p,\qquad p' = -\mu_m,\qquad \mu' = [\mu, x],\qquad \mu_h = [x, p]_h
//! ```
//!
//! with `p` the covariant acceleration and `mu_m = -(j - [x, p]_m / 2)` for the covariant jerk `j`. Both parts of `H`
//! have exact flows (an exponential and a sum), and a step is a symmetric composition of them: symplectic, reversible,
//! explicit. For a cubic in tension `H` has the additional term `- tau |x|^2 / 2`, whose flow is a kick, `p <- p + h
//! tau x`, and `mu_m = tau x - (j - [x, p]_m / 2)`; the kick is applied with the rotation, during which `x` is
//! constant, and steps of higher order are compositions of Strang's. The flows, and therefore the steps, preserve the
//! orthogonality of `g`, the spatial momentum `g mu g^T` and the constraint in `mu_h` up to round-off. Every flow adds
//! small increments in compensated sums, so the round-off of these three grows with the time covered and not with the
//! number of steps. Nothing is projected back.
//!
//! Cost per exponential: closed forms for `n = 3`, otherwise 8 to 14 products `(r, r) x (r, 2r)` with `r = min(n, 4k)`.
//! The `n` rows appear only in an orthonormal basis at the start and one product at the end.
//!
//! # Source
//! Splitting: Hairer, Lubich, Wanner (2006), "Geometric Numerical Integration", sections II.5 and VIII.5 (compensated
//! sums). The Hamiltonian form is that of the maximum principle, Crouch, Silva Leite (1995). Compositions: see
//! [`SplittingOrder`].

use faer::MatRef;

use super::composition::SplittingOrder;
use super::frame_flow::FrameState;
use super::space_flow::SpaceState;
use super::split_state::SplitState;
use super::trajectory::{CubicTrajectory, Observed, check_steps};
use crate::chart::Composition;
use crate::chart::composition::Stage;
use crate::cubic::riemannian_cubic::check_duration;
use crate::cubic::taylor::initial::InitialData;
use crate::cubic::tension::check_tension;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::space::Quotient;

/// Flows of small states between two polls of the interrupt.
const FLOWS_PER_CHECK: usize = 1024;

/// Options of [`integrate_cubic`].
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::cubic::{SplittingOptions, SplittingOrder, integrate_cubic};
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let options = SplittingOptions { order: SplittingOrder::Eight, ..Default::default() };
/// let there = integrate_cubic(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), 10, &options, Interrupt::NEVER)?;
/// // The method is reversible: the same steps lead back.
/// let [y, w, b, i] = [there.points()?, there.velocities()?, there.accelerations()?, there.jerks()?];
/// let [y, w, b, i] = [y.get(10), w.get(10), b.get(10), i.get(10)];
/// let back = integrate_cubic(y, w, b, i, 10, &SplittingOptions { t_end: -1.0, ..options }, Interrupt::NEVER)?;
/// assert!((back.points()?.get(10) - s).norm_l2() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct SplittingOptions {
    /// End of the time interval, finite and nonzero; negative to run backwards.
    pub t_end: f64,
    /// `tau >= 0` of a cubic in tension: the Hamiltonian has the additional term `- tau |x|^2 / 2`. Orders 4, 6 and 8
    /// then take 5, 9 and 17 exponentials per step.
    pub tension: f64,
    /// The meaning of the points: frames or subspaces.
    pub quotient: Quotient,
    /// Order of the composition.
    pub order: SplittingOrder,
}

impl Default for SplittingOptions {
    fn default() -> Self {
        SplittingOptions {
            t_end: 1.0,
            tension: 0.0,
            quotient: Quotient::Frames,
            order: SplittingOrder::default(),
        }
    }
}

/// Integrate the Riemannian cubic with given initial data, in equal steps of an explicit symplectic splitting.
///
/// # Arguments
/// * `s` - point, shape `(n, k)`; `v`, `a`, `j` - velocity, covariant acceleration and covariant jerk at `s`
/// * `steps` - at least 1; `options` - time, order
/// # Accuracy
/// The error is `C (stages / h)^-p`, with orders and constants measured in `tests/splitting.rs` and listed in
/// [`SplittingOrder`]; the energy error does not drift. Orthonormality, spatial momentum and constraint hold to
/// round-off that does not grow with the number of steps.
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` (`steps`, `tension`, or `t_end` zero),
/// `TooFewSteps` (an exponential by more than 100 radians, only for `n > 3`), `Overflow`, `Interrupted`.
/// # Source
/// See the module documentation.
pub fn integrate_cubic(
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
    a: MatRef<'_, f64>,
    j: MatRef<'_, f64>,
    steps: usize,
    options: &SplittingOptions,
    interrupt: Interrupt<'_>,
) -> Result<CubicTrajectory> {
    check_duration(options.t_end)?;
    check_steps(steps)?;
    check_tension(options.tension)?;
    let data = InitialData::new(s, v, a, j, options.quotient)?.in_tension(options.tension);
    let (r, k) = (data.g.nrows(), s.ncols());
    let mut trajectory = CubicTrajectory::with_room([r, k], steps, options.t_end)?;
    if r == 3 && (options.quotient == Quotient::Frames || k == 1) {
        march(
            &mut SpaceState::new(&data),
            &mut trajectory,
            steps,
            options,
            interrupt,
        )?;
    } else {
        march(
            &mut FrameState::new(&data),
            &mut trajectory,
            steps,
            options,
            interrupt,
        )?;
    }
    Ok(trajectory.in_frame(data.frame))
}

/// Takes the steps and stores every state.
fn march(
    state: &mut (impl SplitState + Observed),
    trajectory: &mut CubicTrajectory,
    steps: usize,
    options: &SplittingOptions,
    interrupt: Interrupt<'_>,
) -> Result<()> {
    let (flows_of_step, last) = flows(options)?;
    let h = options.t_end / steps as f64;
    let per_check = trajectory.per_check(FLOWS_PER_CHECK);
    let mut flows = 0;
    trajectory.record(state)?;
    for _ in 0..steps {
        for &(b, a) in &flows_of_step {
            if flows % per_check == 0 {
                interrupt.check("splitting of a cubic")?;
            }
            flows += 1;
            state.drift(h * b);
            state.rotate(h * a)?;
        }
        state.drift(h * last);
        trajectory.record(state)?;
    }
    Ok(())
}

/// Fractions of a step for the flows of `B` and `A` in turn, and for the final flow of `B`.
///
/// In tension, Strang's step is composed with itself: `[B, [B, A]]`, which the other compositions assume to vanish, is
/// then `-2 tau B`, and would reduce the orders 4, 6 and 8 to 2.
fn flows(options: &SplittingOptions) -> Result<(Vec<(f64, f64)>, f64)> {
    let composition = options.order.composition();
    if options.tension == 0.0 {
        return Ok((composition.pairs().collect(), composition.last()));
    }
    let strang = Composition::new(2, options.order.number())?;
    let (mut flows, mut half) = (Vec::new(), 0.0);
    for stage in strang.stages() {
        let (Stage::Method(a) | Stage::Adjoint(a)) = stage;
        flows.push((half + 0.5 * a, a));
        half = 0.5 * a;
    }
    Ok((flows, half))
}
