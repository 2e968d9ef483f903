//! Explicit symplectic integrators of Riemannian cubics on any `St(n, k)`.
//!
//! The cubics are the projections of the flow of `H = <mu, x> + |p|^2 / 2` on `T^*(SO(r) x m)`, left-trivialised:
//!
//! ```math
//! g' = g x,\qquad x' = p,\qquad p' = -\mu_m,\qquad \mu' = [\mu, x],\qquad \mu_h = [x, p]_h
//! ```
//!
//! with `p` the covariant acceleration and `mu_m = -(j - [x, p]_m / 2)` for the covariant jerk `j`. Both parts of `H`
//! have exact flows (one exponential; a sum), and a symmetric composition of them is a step: symplectic, reversible,
//! explicit. A cubic in tension has `- tau |x|^2 / 2` more in `H`, whose flow is a kick, `p <- p + h tau x`, and
//! `mu_m = tau x - (j - [x, p]_m / 2)`; the kick goes with the rotation, during which `x` stands still, and steps of higher order
//! are compositions of Strang's. The flows keep `g` orthogonal, the spatial momentum `g mu g^T` and the constraint in `mu_h`; so do the
//! steps, up to round-off. Every flow adds small increments in compensated sums, so the round-off of these three grows
//! with the time covered and not with the number of steps. Nothing is projected back.
//!
//! Cost: per exponential, closed forms for `n = 3`, else 8 to 14 products `(r, r) x (r, 2r)` with `r = min(n, 4k)`; the
//! rows of `n` enter with one orthonormal basis at the start and one product at the end.
//!
//! # Source
//! Splitting: Hairer, Lubich, Wanner (2006), "Geometric Numerical Integration", sections II.5 and VIII.5 (compensated
//! sums). The Hamiltonian form is that of the maximum principle, Crouch, Silva Leite (1995). Compositions: see
//! [`SplittingOrder`].

use faer::{Mat, MatMut, MatRef};

use super::composition::SplittingOrder;
use super::frame_flow::FrameState;
use super::initial::InitialData;
use super::riemannian_cubic::check_duration;
use super::space_flow::SpaceState;
use super::split_state::SplitState;
use super::tension::check_tension;
use crate::chart::Composition;
use crate::chart::composition::Stage;
use crate::curve::{Samples, lift_into};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::check_range;

/// Flows of small states between two questions whether to stop.
const FLOWS_PER_CHECK: usize = 1024;

/// From this dimension on the question is asked before every flow.
const LARGE: usize = 48;

const TRAJECTORY: &str = "trajectory of a cubic";

/// How [`integrate_cubic`] takes its steps.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{SplittingOptions, SplittingOrder, integrate_cubic};
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let options = SplittingOptions { order: SplittingOrder::Eight, ..Default::default() };
/// let there = integrate_cubic(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), 10, &options)?;
/// // The method is reversible: the same steps lead back.
/// let [y, w, b, i] = [there.points()?, there.velocities()?, there.accelerations()?, there.jerks()?];
/// let [y, w, b, i] = [y.get(10), w.get(10), b.get(10), i.get(10)];
/// let back = integrate_cubic(y, w, b, i, 10, &SplittingOptions { t_end: -1.0, ..options })?;
/// assert!((back.points()?.get(10) - s).norm_l2() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct SplittingOptions<'a> {
    /// End of the time interval, finite and not zero; negative to run backwards.
    pub t_end: f64,
    /// `tau >= 0` of a cubic in tension: the Hamiltonian has `- tau |x|^2 / 2` more. Orders 4, 6 and 8 then take 5, 9 and 17
    /// exponentials a step.
    pub tension: f64,
    /// Order of the composition.
    pub order: SplittingOrder,
    /// Asked between steps.
    pub interrupt: Interrupt<'a>,
}

impl Default for SplittingOptions<'_> {
    fn default() -> Self {
        SplittingOptions {
            t_end: 1.0,
            tension: 0.0,
            order: SplittingOrder::default(),
            interrupt: Interrupt::NEVER,
        }
    }
}

/// The discrete trajectory of a Riemannian cubic, `steps + 1` states, kept by coordinates in the span of its data.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{SplittingOptions, integrate_cubic};
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let [s, v, a, j] = [&s, &v, &a, &j].map(|a| a.as_ref());
/// let trajectory = integrate_cubic(s, v, a, j, 50, &SplittingOptions::default())?;
/// assert_eq!((trajectory.points()?.len(), trajectory.time(25)), (51, 0.5));
/// // |A|^2 / 2 - <J, V>, kept up to the error of the method; momentum up to round-off.
/// assert!(trajectory.energy().iter().all(|energy| (energy + 1.0).abs() < 1e-8));
/// assert!(trajectory.momentum_drift() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CubicTrajectory {
    /// Orthonormal basis of the span, shape `(n, r)`; none where coordinates are entries.
    frame: Option<Mat<f64>>,
    r: usize,
    k: usize,
    t_end: f64,
    /// Point, velocity, acceleration, jerk: states side by side, each column by column.
    coordinates: [Vec<f64>; 4],
    energy: Vec<f64>,
    momentum_drift: f64,
    constraint_drift: f64,
}

impl CubicTrajectory {
    /// Rows of a point.
    pub fn n(&self) -> usize {
        self.frame.as_ref().map_or(self.r, Mat::nrows)
    }

    /// Columns of a point.
    pub fn k(&self) -> usize {
        self.k
    }

    /// Number of steps; there is one state more.
    pub fn steps(&self) -> usize {
        self.energy.len() - 1
    }

    /// Time of the `i`-th state.
    pub fn time(&self, i: usize) -> f64 {
        self.t_end * (i as f64 / self.steps() as f64)
    }

    /// The points, `steps + 1` values of shape `(n, k)`.
    ///
    /// # Errors
    /// `InvalidArgument` (no memory for so many steps), `Overflow`.
    pub fn points(&self) -> Result<Samples> {
        self.lifted(0)
    }

    /// The velocities, as [`CubicTrajectory::points`].
    ///
    /// # Errors
    /// As [`CubicTrajectory::points`].
    pub fn velocities(&self) -> Result<Samples> {
        self.lifted(1)
    }

    /// The covariant accelerations, as [`CubicTrajectory::points`].
    ///
    /// # Errors
    /// As [`CubicTrajectory::points`].
    pub fn accelerations(&self) -> Result<Samples> {
        self.lifted(2)
    }

    /// The covariant jerks, as [`CubicTrajectory::points`].
    ///
    /// # Errors
    /// As [`CubicTrajectory::points`].
    pub fn jerks(&self) -> Result<Samples> {
        self.lifted(3)
    }

    /// The Hamiltonian `|D_t S'|^2 / 2 - <D_t D_t S', S'> + tau |S'|^2 / 2` in the canonical metric, at each state.
    pub fn energy(&self) -> &[f64] {
        &self.energy
    }

    /// The largest `|g mu g^T - M|` of all states, `M` its value at the start, `|A|^2 = tr(A^T A) / 2`.
    pub fn momentum_drift(&self) -> f64 {
        self.momentum_drift
    }

    /// The largest `|mu_h - [x, p]_h|` of all states, in the same norm.
    pub fn constraint_drift(&self) -> f64 {
        self.constraint_drift
    }

    fn lifted(&self, quantity: usize) -> Result<Samples> {
        let (n, k) = (self.n(), self.k);
        let coordinates = &self.coordinates[quantity];
        let Some(frame) = &self.frame else {
            let mut entries = reserved(self.steps(), n * k)?;
            entries.extend_from_slice(coordinates);
            return Ok(Samples::from_entries(n, k, entries));
        };
        let columns = k * (self.steps() + 1);
        let mut entries = reserved(self.steps(), n * k)?;
        entries.resize(n * columns, 0.0);
        let low = MatRef::from_column_major_slice(coordinates, self.r, columns);
        let mut all = MatMut::from_column_major_slice_mut(&mut entries, n, columns);
        lift_into(frame.as_ref(), low, all.as_mut());
        check_range(TRAJECTORY, all.as_ref())?;
        Ok(Samples::from_entries(n, k, entries))
    }
}

/// The Riemannian cubic with the given initial data, by equal steps of an explicit symplectic splitting.
///
/// # Arguments
/// * `s` - point, shape `(n, k)`; `v`, `a`, `j` - velocity, covariant acceleration and covariant jerk at it
/// * `steps` - at least 1; `options` - time, order
/// # Accuracy
/// Error `C (stages / h)^-p`, orders and constants measured in `tests/splitting.rs` and given with
/// [`SplittingOrder`]; energy without drift. Orthonormality, spatial momentum and constraint to round-off that does
/// not grow with the number of steps.
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` (`steps`, `t_end` zero, `tension`), `TooFewSteps` (an
/// exponential by more than 100 radians where `n > 3`), `Overflow`, `Interrupted`.
/// # Source
/// See the module page.
pub fn integrate_cubic(
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
    a: MatRef<'_, f64>,
    j: MatRef<'_, f64>,
    steps: usize,
    options: &SplittingOptions<'_>,
) -> Result<CubicTrajectory> {
    check_duration(options.t_end)?;
    if steps == 0 {
        return Err(Error::InvalidArgument {
            name: "steps",
            requirement: "at least 1",
            found: 0.0,
        });
    }
    check_tension(options.tension)?;
    let data = InitialData::new(s, v, a, j)?.in_tension(options.tension);
    let (r, k) = (data.g.nrows(), s.ncols());
    let mut trajectory = CubicTrajectory {
        frame: None,
        r,
        k,
        t_end: options.t_end,
        coordinates: Default::default(),
        energy: reserved(steps, 1)?,
        momentum_drift: 0.0,
        constraint_drift: 0.0,
    };
    for entries in &mut trajectory.coordinates {
        *entries = reserved(steps, r * k)?;
    }
    if r == 3 {
        trajectory.march(&mut SpaceState::new(&data), steps, options)?;
    } else {
        trajectory.march(&mut FrameState::new(&data), steps, options)?;
    }
    trajectory.frame = data.frame;
    Ok(trajectory)
}

impl CubicTrajectory {
    /// Takes the steps and keeps every state.
    fn march(
        &mut self,
        state: &mut impl SplitState,
        steps: usize,
        options: &SplittingOptions<'_>,
    ) -> Result<()> {
        let (flows_of_step, last) = flows(options)?;
        let h = options.t_end / steps as f64;
        let per_check = if self.r < LARGE { FLOWS_PER_CHECK } else { 1 };
        let mut flows = 0;
        self.record(state)?;
        for _ in 0..steps {
            for &(b, a) in &flows_of_step {
                if flows % per_check == 0 {
                    options.interrupt.check("splitting of a cubic")?;
                }
                flows += 1;
                state.drift(h * b);
                state.rotate(h * a)?;
            }
            state.drift(h * last);
            self.record(state)?;
        }
        Ok(())
    }

    /// Appends a state; there is room for it.
    fn record(&mut self, state: &mut impl SplitState) -> Result<()> {
        let (size, done) = (self.r * self.k, self.coordinates[0].len());
        let new = self.coordinates.each_mut().map(|entries| {
            entries.resize(done + size, 0.0);
            &mut entries[done..]
        });
        state.observe(new);
        let energy = state.energy();
        let momentum = state.momentum_defect();
        let constraint = state.constraint_defect();
        let mut all = self.coordinates.iter();
        let finite = all.all(|entries| {
            entries[done..]
                .iter()
                .fold(true, |all, x| all & x.is_finite())
        });
        if !(finite && energy.is_finite() && momentum.is_finite() && constraint.is_finite()) {
            return Err(Error::Overflow {
                quantity: TRAJECTORY,
            });
        }
        self.energy.push(energy);
        self.momentum_drift = self.momentum_drift.max(momentum);
        self.constraint_drift = self.constraint_drift.max(constraint);
        Ok(())
    }
}

/// Fractions of a step for the flows of `B` and `A` in turn, and for the last one of `B`.
///
/// In tension Strang's step is composed with itself: `[B, [B, A]]`, which the other compositions suppose to vanish, is then
/// `-2 tau B`. With them the orders 4, 6 and 8 fall to 2.
fn flows(options: &SplittingOptions<'_>) -> Result<(Vec<(f64, f64)>, f64)> {
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

/// An empty vector with room for `size` numbers of each state.
fn reserved(steps: usize, size: usize) -> Result<Vec<f64>> {
    let mut out = Vec::new();
    let total = steps
        .checked_add(1)
        .and_then(|states| states.checked_mul(size));
    match total {
        Some(total) if out.try_reserve_exact(total).is_ok() => Ok(out),
        _ => Err(Error::InvalidArgument {
            name: "steps",
            requirement: "few enough for the trajectory to fit in memory",
            found: steps as f64,
        }),
    }
}
