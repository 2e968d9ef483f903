//! Two-point boundary value problems in a chart, by shooting with the discrete flow of any discretization map.

use faer::MatMut;
use nalgebra::SVector;

use super::chart::Chart;
use super::composition::Composition;
use super::discretization::DiscretizationMap;
use super::integrator::{
    integrate_composed, integrate_composed_with_tangent, last_state, trajectory_buffer,
};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::SolverReport;
use crate::solve::newton::{self, NewtonOptions, Problem};

/// Options of [`shoot`].
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::chart::{Composition, LinearMap, ShootingOptions, Sphere, shoot};
/// // From rest to rest along the equator by 1: p = (-jerk, acceleration) = (12, 6) in longitude.
/// let x0 = SVector::from([std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0]);
/// let x1 = SVector::from([std::f64::consts::FRAC_PI_2, 1.0, 0.0, 0.0]);
/// let error = |composition| -> stiefel_rs::Result<f64> {
///     let options = ShootingOptions { composition, ..Default::default() };
///     let found = shoot(&Sphere, &LinearMap::MIDPOINT, &x0, &x1, 10, &options, Interrupt::NEVER)?;
///     Ok((found.momenta - SVector::from([0.0, 12.0, 0.0, 6.0])).norm())
/// };
/// // The method of order 4 is exact on a cubic polynomial.
/// assert!(error(Composition::default())? > 1e-2);
/// assert!(error(Composition::new(2, 4)?)? < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct ShootingOptions<const X: usize> {
    /// Time interval `[0, t_end]`.
    pub t_end: f64,
    /// The composition of a step; by default one step of the method itself.
    pub composition: Composition,
    /// Stopping criteria of Newton's method.
    pub newton: NewtonOptions,
    /// Initial guess of the initial momenta; `None` for those of the cubic polynomial in coordinates with the same
    /// ends.
    pub guess: Option<SVector<f64, X>>,
}

impl<const X: usize> Default for ShootingOptions<X> {
    fn default() -> Self {
        ShootingOptions {
            t_end: 1.0,
            composition: Composition::default(),
            newton: NewtonOptions::default(),
            guess: None,
        }
    }
}

/// A discrete trajectory that satisfies its boundary data.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::chart::{LinearMap, ShootingOptions, Sphere, shoot};
/// let x0 = SVector::from([1.2, 0.0, 0.5, 1.0]);
/// let x1 = SVector::from([1.5, 0.9, 0.0, 0.4]);
/// let found = shoot(&Sphere, &LinearMap::MIDPOINT, &x0, &x1, 20, &ShootingOptions::default(), Interrupt::NEVER)?;
/// assert!(found.report.converged);
/// assert_eq!(found.trajectory.len(), 21);
/// assert!((found.trajectory[20].fixed_rows::<4>(0) - x1).norm() < 1e-11);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Shooting<const X: usize, const Z: usize> {
    /// The `steps + 1` states.
    pub trajectory: Vec<SVector<f64, Z>>,
    /// The initial momenta `(p_q, p_qdot)`.
    pub momenta: SVector<f64, X>,
    /// The report of Newton's method.
    pub report: SolverReport,
}

/// Find the trajectory of the discrete flow with given ends `x0 = (q, qdot)` at time 0 and `x1` at `t_end`.
///
/// The unknowns are the initial momenta; the Jacobian is the exact derivative of the discrete flow, by tangent
/// propagation through the implicit steps. Angles are not wrapped: give `x1` on the intended branch.
///
/// # Errors
/// `NonFinite`, `OutsideChart`, `InvalidArgument`; `NoConvergence` with the report if no trajectory was found;
/// `Interrupted`.
pub fn shoot<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    x0: &SVector<f64, X>,
    x1: &SVector<f64, X>,
    steps: usize,
    options: &ShootingOptions<X>,
    interrupt: Interrupt<'_>,
) -> Result<Shooting<X, Z>> {
    chart.check("x0", x0.as_slice())?;
    chart.check("x1", x1.as_slice())?;
    check_options(options)?;
    // Fail before the first of many flows, not after the last.
    drop(trajectory_buffer::<SVector<f64, Z>>(steps)?);
    let momenta = match options.guess {
        Some(guess) => guess,
        None => cubic_guess(chart, x0, x1, options.t_end)?,
    };
    let t_end = options.t_end;
    let composition = options.composition;
    let mut unknowns = momenta.as_slice().to_vec();
    let z0 = SVector::from_fn(|i, _| if i < X { x0[i] } else { 0.0 });
    let mut problem = EndPoint {
        chart,
        map,
        composition,
        z0,
        x1,
        steps,
        t_end,
        interrupt,
    };
    let report = newton::solve(&mut problem, &mut unknowns, &options.newton, interrupt)?;
    if !report.converged {
        return Err(Error::NoConvergence {
            solver: "shooting",
            report,
        });
    }
    let momenta = SVector::from_column_slice(&unknowns);
    problem.z0.as_mut_slice()[X..].copy_from_slice(&unknowns);
    let trajectory = integrate_composed(
        chart,
        map,
        &composition,
        &problem.z0,
        steps,
        t_end,
        interrupt,
    )?;
    Ok(Shooting {
        trajectory,
        momenta,
        report,
    })
}

fn check_options<const X: usize>(options: &ShootingOptions<X>) -> Result<()> {
    crate::linalg::structure::check_finite_scalar("t_end", options.t_end)?;
    if options.t_end == 0.0 {
        return Err(Error::InvalidArgument {
            name: "t_end",
            requirement: "different from zero",
            found: 0.0,
        });
    }
    if !(options.newton.tolerance >= 0.0 && options.newton.tolerance.is_finite()) {
        let found = options.newton.tolerance;
        return Err(Error::InvalidArgument {
            name: "tolerance",
            requirement: "finite and at least 0",
            found,
        });
    }
    match options
        .guess
        .and_then(|guess| guess.iter().position(|x| !x.is_finite()))
    {
        Some(index) => Err(Error::NonFinite {
            name: "guess",
            index,
        }),
        None => Ok(()),
    }
}

/// Momenta of the cubic polynomial in coordinates with the same end points and velocities.
fn cubic_guess<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    x0: &SVector<f64, X>,
    x1: &SVector<f64, X>,
    t: f64,
) -> Result<SVector<f64, X>> {
    let d = X / 2;
    let slope = |i: usize| (x1[i] - x0[i]) / t;
    let second = |i: usize| (6.0 * slope(i) - 4.0 * x0[d + i] - 2.0 * x1[d + i]) / t;
    let third = |i: usize| (-12.0 * slope(i) + 6.0 * x0[d + i] + 6.0 * x1[d + i]) / (t * t);
    let (qddot, qdddot): (Vec<f64>, Vec<f64>) = (0..d).map(|i| (second(i), third(i))).unzip();
    if !qddot.iter().chain(&qdddot).all(|x| x.is_finite()) {
        return Err(Error::Overflow {
            quantity: "starting point of the shooting",
        });
    }
    chart.momenta(&x0.as_slice()[..d], &x0.as_slice()[d..], &qddot, &qdddot)
}

/// The end of the discrete flow as a function of the initial momenta, minus the target.
struct EndPoint<'a, C, R, const X: usize, const Z: usize> {
    chart: &'a C,
    map: &'a R,
    composition: Composition,
    /// The initial state; its momenta are overwritten.
    z0: SVector<f64, Z>,
    x1: &'a SVector<f64, X>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'a>,
}

impl<C, R, const X: usize, const Z: usize> Problem for EndPoint<'_, C, R, X, Z>
where
    C: Chart<X, Z>,
    R: DiscretizationMap<X>,
{
    fn dim(&self) -> usize {
        X
    }

    fn evaluate(
        &mut self,
        p: &[f64],
        residual: &mut [f64],
        jacobian: Option<MatMut<'_, f64>>,
    ) -> Result<()> {
        self.z0.as_mut_slice()[X..].copy_from_slice(p);
        let EndPoint {
            chart,
            map,
            ref composition,
            ref z0,
            x1,
            steps,
            t_end,
            interrupt,
        } = *self;
        let end = match jacobian {
            None => last_state(chart, map, composition, z0, steps, t_end, interrupt)?,
            Some(mut jacobian) => {
                let (end, tangent) = integrate_composed_with_tangent(
                    chart,
                    map,
                    composition,
                    z0,
                    steps,
                    t_end,
                    interrupt,
                )?;
                for j in 0..X {
                    for i in 0..X {
                        jacobian[(i, j)] = tangent[(i, X + j)];
                    }
                }
                end
            }
        };
        for i in 0..X {
            residual[i] = end[i] - x1[i];
        }
        Ok(())
    }
}
