//! The discrete trajectory of a Riemannian cubic, common to all integrators.

use faer::{Mat, MatMut, MatRef};

use crate::curve::{Samples, lift_into};
use crate::error::{Error, Result};
use crate::linalg::structure::check_range;

const TRAJECTORY: &str = "trajectory of a cubic";

/// Number of rows from which the interrupt is polled at every step.
const LARGE: usize = 48;

/// What a trajectory records of an integrator's state.
pub(crate) trait Observed {
    /// Point, velocity, covariant acceleration and covariant jerk, each of shape `(r, k)`, column by column.
    fn observe(&mut self, out: [&mut [f64]; 4]);

    /// The Hamiltonian.
    fn energy(&mut self) -> f64;

    /// The deviation of the spatial momentum from its initial value, in the norm `|A|^2 = tr(A^T A) / 2`.
    fn momentum_defect(&mut self) -> f64;

    /// The largest violation of the constraints.
    fn constraint_defect(&mut self) -> f64;
}

/// The discrete trajectory of a Riemannian cubic: `steps + 1` states, stored in coordinates of the span of the data.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::cubic::{SplittingOptions, integrate_cubic};
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let [s, v, a, j] = [&s, &v, &a, &j].map(|a| a.as_ref());
/// let trajectory = integrate_cubic(s, v, a, j, 50, &SplittingOptions::default(), Interrupt::NEVER)?;
/// assert_eq!((trajectory.points()?.len(), trajectory.time(25)), (51, 0.5));
/// // |A|^2 / 2 - <J, V>, kept up to the error of the method; momentum up to round-off.
/// assert!(trajectory.energy().iter().all(|energy| (energy + 1.0).abs() < 1e-8));
/// assert!(trajectory.momentum_drift() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CubicTrajectory {
    /// Orthonormal basis of the span, shape `(n, r)`; `None` if the coordinates are the entries themselves.
    frame: Option<Mat<f64>>,
    r: usize,
    k: usize,
    t_end: f64,
    /// Point, velocity, acceleration, jerk: for each, the states one after another, in column-major order.
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

    /// Number of steps; the number of states is one more.
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
    /// `InvalidArgument` (not enough memory), `Overflow`.
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

    /// The largest deviation of the spatial momentum from its initial value over all states, in the norm `|A|^2 =
    /// tr(A^T A) / 2`.
    ///
    /// For [`integrate_cubic`](crate::cubic::integrate_cubic) the momentum is `g mu g^T`, for
    /// [`integrate_embedded`](crate::cubic::integrate_embedded) the equal matrix `p_S S^T - S p_S^T + p_V V^T - V
    /// p_V^T`.
    pub fn momentum_drift(&self) -> f64 {
        self.momentum_drift
    }

    /// The largest violation of the constraints over all states.
    ///
    /// For [`integrate_cubic`](crate::cubic::integrate_cubic) it is `|mu_h - [x, p]_h|` in the same norm; for
    /// [`integrate_embedded`](crate::cubic::integrate_embedded) the largest Frobenius norm of `S^T S - I`, `S^T V + V^T
    /// S`, `S^T p_V + p_V^T S` and `S^T p_S + p_S^T S`.
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

impl CubicTrajectory {
    /// A trajectory without states, with space reserved for those of `steps` steps.
    ///
    /// # Errors
    /// `InvalidArgument` (the states do not fit in memory).
    pub(crate) fn with_room([r, k]: [usize; 2], steps: usize, t_end: f64) -> Result<Self> {
        let mut coordinates: [Vec<f64>; 4] = Default::default();
        for entries in &mut coordinates {
            *entries = reserved(steps, r * k)?;
        }
        Ok(CubicTrajectory {
            frame: None,
            r,
            k,
            t_end,
            coordinates,
            energy: reserved(steps, 1)?,
            momentum_drift: 0.0,
            constraint_drift: 0.0,
        })
    }

    /// Sets the basis to which the coordinates refer.
    pub(crate) fn in_frame(mut self, frame: Option<Mat<f64>>) -> Self {
        self.frame = frame;
        self
    }

    /// Number of steps between two polls of the interrupt: the given one for small states, 1 for large states.
    pub(crate) fn per_check(&self, of_small_states: usize) -> usize {
        match self.r >= LARGE {
            true => 1,
            false => of_small_states,
        }
    }

    /// Appends a state; space is reserved.
    pub(crate) fn record(&mut self, state: &mut impl Observed) -> Result<()> {
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

/// Return an error if `steps` is zero.
pub(crate) fn check_steps(steps: usize) -> Result<()> {
    if steps > 0 {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "steps",
        requirement: "at least 1",
        found: 0.0,
    })
}

/// An empty vector with space reserved for `size` numbers per state.
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
