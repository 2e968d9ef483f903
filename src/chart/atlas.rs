//! Three charts that cover the manifold, and curves that pass from one to another.
//!
//! A chart breaks down at its poles, where the first column is `e_3` or `-e_3`. The rotation `P` of space that maps
//! `e_1` to `e_2`, `e_2` to `e_3` and `e_3` to `e_1` is an isometry; the chart of `P S` has its poles on the second
//! axis, the chart of `P^2 S` on the first. A point near a pole of one chart is in the middle of another one: at least
//! one of the three has `sin(theta) >= sqrt(2/3)`.
//!
//! A change of chart carries the state by the cotangent lift of the change of coordinates `tau`, lifted to velocities:
//!
//! ```math
//! q' = \tau(q),\quad v' = D\tau\, v,\quad p'_v = D\tau^{-T} p_v,\quad
//! p'_q = D\tau^{-T}\bigl(p_q - (D^2\tau\, v)^T p'_v\bigr)
//! ```
//!
//! The transformed state is the same point of the phase space in other coordinates, so a discrete trajectory across
//! charts is a trajectory of a symplectic method: one of three, selected by the initial state. Because the three
//! rotations are fixed and not fitted to the state, the selection is constant near almost every state, and the map
//! stays symplectic.
//!
//! # Source
//! The isometry group of `St(n, k)` and the cotangent lift of a point transformation are standard; the choice of the
//! three rotations, and the result on symplecticity, are our own.

use nalgebra::{SMatrix, SVector};

use super::chart::{Chart, check_reached};
use super::composition::Composition;
use super::covariant::{CovariantData, covariant_from_state, state_from_covariant};
use super::discretization::DiscretizationMap;
use super::elimination::solve_in_place;
use super::integrator::{advance, check_arguments, check_interrupt, trajectory_buffer};
use super::jet::Jet;
use super::rotation::{Quaternion, angles, from_angles, product};
use super::tangent_lift::TangentLift;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

/// Value of `sin(theta)` below which a state moves to another chart. It is well below `sqrt(2/3)`, the value on
/// arrival, so a curve does not switch back and forth.
pub const MARGIN: f64 = 0.5;

/// A state in one of the three charts.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::chart::{AtlasState, CovariantData, Sphere};
/// // The pole of the chart, which has no coordinates there.
/// let data = CovariantData {
///     point: mat![[0.0], [0.0], [1.0]],
///     velocity: mat![[1.0], [0.0], [0.0]],
///     acceleration: Mat::zeros(3, 1),
///     jerk: Mat::zeros(3, 1),
/// };
/// let state = AtlasState::<8>::from_covariant(&Sphere, &data)?;
/// assert_eq!(state.turns, 1);
/// assert!((state.covariant(&Sphere)?.point - data.point).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtlasState<const Z: usize> {
    /// Number of rotations, 0, 1 or 2: the state belongs to `P^turns S`.
    pub turns: usize,
    /// `(q, qdot, p_q, p_qdot)` in that chart.
    pub z: SVector<f64, Z>,
}

impl<const Z: usize> AtlasState<Z> {
    /// The state of a cubic with the given data: in the given chart or, near its poles, in the next best one. All
    /// points are admissible, including the poles.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Overflow`.
    pub fn from_covariant<C: Chart<X, Z>, const X: usize>(
        chart: &C,
        data: &CovariantData,
    ) -> Result<Self> {
        data.check(C::K)?;
        let s = &data.point;
        let turns = if s[(0, 0)].hypot(s[(1, 0)]) >= MARGIN {
            0
        } else {
            turns_to_the_middle(s[(0, 0)], s[(1, 0)])
        };
        let z = state_from_covariant(chart, &data.turned(turns))?;
        Ok(AtlasState { turns, z })
    }

    /// Point, velocity, covariant acceleration and jerk.
    ///
    /// # Errors
    /// `NonFinite`, `OutsideChart`, `Overflow`.
    pub fn covariant<C: Chart<X, Z>, const X: usize>(&self, chart: &C) -> Result<CovariantData> {
        Ok(covariant_from_state(chart, &self.z)?.turned(3 - self.turns % 3))
    }

    /// The rotation `R`, shape `(3, 3)`, such that the state belongs to the point `R S`.
    pub fn rotation(&self) -> SMatrix<f64, 3, 3> {
        SMatrix::from_fn(|i, j| f64::from(u8::from((j + self.turns) % 3 == i)))
    }

    /// The same state in the chart in which it is nearest to the middle, if it is near a pole of its own chart;
    /// otherwise unchanged.
    ///
    /// # Errors
    /// `OutsideChart`, `Overflow`.
    pub fn recentred<C: Chart<X, Z>, const X: usize>(&self, chart: &C) -> Result<Self> {
        check_reached(chart, &self.z)?;
        let (sin, _) = self.z[0].sin_cos();
        if sin >= MARGIN {
            return Ok(*self);
        }
        let (sin_phi, cos_phi) = self.z[1].sin_cos();
        let turns = turns_to_the_middle(sin * cos_phi, sin * sin_phi);
        Ok(AtlasState {
            turns: (self.turns + turns) % 3,
            z: transition(chart, &self.z, turns)?,
        })
    }
}

/// Number of rotations for a point with small first and second entry: one of the two becomes the third entry, which is
/// the cosine.
fn turns_to_the_middle(x: f64, y: f64) -> usize {
    if y.abs() <= x.abs() { 1 } else { 2 }
}

/// The state after the rotation `P^turns` of space, by the cotangent lift of the change of coordinates.
///
/// Coordinates are those of [`super::rotation`]: `(theta, phi)` on the sphere, `(theta, phi, psi)` for frames.
///
/// # Errors
/// `OutsideChart` or `Overflow` if the state ends up at a pole.
pub fn transition<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
    turns: usize,
) -> Result<SVector<f64, Z>> {
    Ok(Change::new(chart, z, turns)?.z)
}

/// The result of [`transition`] and its exact derivative with respect to the state, shape `(4d, 4d)`.
///
/// # Errors
/// As [`transition`].
pub fn transition_with_tangent<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
    turns: usize,
) -> Result<(SVector<f64, Z>, SMatrix<f64, Z, Z>)> {
    let change: Change<X, Z> = Change::new(chart, z, turns)?;
    Ok((change.z, change.tangent()?))
}

/// A change of chart at a state.
struct Change<const X: usize, const Z: usize> {
    lift: TangentLift<3>,
    /// The derivative of `(tau(q), Dtau v)`.
    slope: SMatrix<f64, X, X>,
    z: SVector<f64, Z>,
}

impl<const X: usize, const Z: usize> Change<X, Z> {
    fn new(chart: &impl Chart<X, Z>, z: &SVector<f64, Z>, turns: usize) -> Result<Self> {
        chart.check("state", z.as_slice())?;
        let d = X / 2;
        // On the sphere the third angle is the constant 0, and its image is not used.
        let angle = |i: usize| {
            if i < d {
                Jet::variable(z[i], i, 1.0)
            } else {
                Jet::from(0.0)
            }
        };
        let turn: Quaternion<f64> = match turns % 3 {
            0 => [1.0, 0.0, 0.0, 0.0],
            1 => [1.0, 1.0, 1.0, 1.0],
            _ => [-1.0, 1.0, 1.0, 1.0],
        };
        let turned = product(turn.map(Jet::from), from_angles(std::array::from_fn(angle)));
        let velocity = std::array::from_fn(|i| if i < d { z[d + i] } else { 0.0 });
        let lift = TangentLift::<3>::new(angles(turned), velocity);
        let mut slope = SMatrix::<f64, X, X>::zeros();
        let mut out = SVector::<f64, Z>::zeros();
        for i in 0..d {
            (out[i], out[d + i]) = (lift.coordinate(i), lift.rate(i));
            for a in 0..d {
                slope[(i, a)] = lift.slope(i, a);
                slope[(d + i, d + a)] = lift.slope(i, a);
                slope[(d + i, a)] = lift.rate_slope(i, a);
            }
        }
        let mut p = SMatrix::<f64, X, 1>::from_fn(|i, _| z[X + i]);
        if !solve_in_place(slope.transpose(), &mut p) {
            return Err(Error::Overflow { quantity: "state" });
        }
        out.as_mut_slice()[X..].copy_from_slice(p.as_slice());
        check_reached(chart, &out)?;
        Ok(Change {
            lift,
            slope,
            z: out,
        })
    }

    /// From `x' = F(x)` and `DF^T p' = p`: `DF^T dp' = dp - D^2(p' . F) dx`.
    fn tangent(&self) -> Result<SMatrix<f64, Z, Z>> {
        let d = X / 2;
        let p = &self.z.as_slice()[X..];
        let (position, rate) = p.split_at(d);
        let mut momentum = SMatrix::<f64, X, Z>::zeros();
        for a in 0..X {
            momentum[(a, X + a)] = 1.0;
        }
        for a in 0..d {
            for b in 0..d {
                let mixed = self.lift.mixed_bend(rate, a, b);
                momentum[(a, b)] = -self.lift.bend(position, rate, a, b);
                momentum[(a, d + b)] = -mixed;
                momentum[(d + a, b)] = -mixed;
            }
        }
        if !solve_in_place(self.slope.transpose(), &mut momentum) {
            return Err(Error::Overflow { quantity: "state" });
        }
        let mut out = SMatrix::<f64, Z, Z>::zeros();
        out.fixed_view_mut::<X, X>(0, 0).copy_from(&self.slope);
        out.fixed_rows_mut::<X>(X).copy_from(&momentum);
        Ok(out)
    }
}

/// The discrete trajectory of `steps` equal steps over `[0, t_end]`, across charts: `steps + 1` states.
///
/// Before a step, a state near a pole changes its chart. With a map that commutes with the isometries (`RetractionMap`)
/// the trajectory does not depend on the charts; a linear map defines a different method in each chart.
///
/// # Accuracy
/// As `integrate_composed`; a change of chart adds round-off.
/// # Errors
/// `NonFinite`, `InvalidArgument`; `OutsideChart`, `NoConvergence` if a step is too long for a chart; `Interrupted`.
pub fn integrate_across<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    composition: &Composition,
    start: &AtlasState<Z>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<Vec<AtlasState<Z>>> {
    let h = check_arguments(chart, &start.z, steps, t_end)?;
    let mut out = trajectory_buffer(steps)?;
    let mut state = start.recentred(chart)?;
    out.push(state);
    for step in 0..steps {
        check_interrupt(interrupt, step)?;
        state.z = advance(chart, map, composition, &state.z, h, None)?;
        state = state.recentred(chart)?;
        out.push(state);
    }
    Ok(out)
}

/// One step across charts, as taken by [`integrate_across`], with its derivative from the coordinates of the start to
/// those of the end.
///
/// # Errors
/// As [`integrate_across`].
pub fn step_across_with_tangent<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    composition: &Composition,
    start: &AtlasState<Z>,
    h: f64,
) -> Result<(AtlasState<Z>, SMatrix<f64, Z, Z>)> {
    check_arguments(chart, &start.z, 1, h)?;
    let (mut state, mut tangent) = recentred_with_tangent(chart, start)?;
    state.z = advance(chart, map, composition, &state.z, h, Some(&mut tangent))?;
    let (end, last) = recentred_with_tangent(chart, &state)?;
    Ok((end, last * tangent))
}

fn recentred_with_tangent<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    state: &AtlasState<Z>,
) -> Result<(AtlasState<Z>, SMatrix<f64, Z, Z>)> {
    let moved = state.recentred(chart)?;
    let turns = (moved.turns + 3 - state.turns) % 3;
    if turns == 0 {
        return Ok((moved, SMatrix::identity()));
    }
    let (_, tangent) = transition_with_tangent(chart, &state.z, turns)?;
    Ok((moved, tangent))
}
