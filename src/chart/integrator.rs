//! The symplectic one-step method of a discretization map, with its exact derivative.
//!
//! One step from `(x_0, p_0)` finds the point `(x, p)` whose Hamiltonian vector, scaled by the step and mapped by the
//! cotangent lift, starts at `(x_0, p_0)`; the end of the lift is the new state:
//!
//! ```math
//! R_d^{T^*}\bigl(h\, X_H(x, p)\bigr) = (x_0, p_0;\ x_1, p_1)
//! ```
//!
//! As a composition of symplectic maps the method is symplectic for every discretization map. The equations are solved
//! by Newton's method with exact Jacobians; the derivative of the step follows from the same factorisation.
//!
//! # Source
//! arXiv 2404.19407, the proposition on symplectic integrators from discretization maps; Barbero-Liñán, Martín de
//! Diego (2023), proposition 5.1.

use nalgebra::{SMatrix, SVector};

use super::chart::{Chart, check_reached};
use super::composition::{Adjoint, Composition, Stage};
use super::discretization::{Blocks, DiscretizationMap, Expansion};
use super::elimination::solve_in_place;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Newton's method stops after a correction this small, relative to the state: by quadratic convergence the remaining
/// error is below round-off.
const LAST_CORRECTION: f64 = 1e-10;

/// Maximal number of Newton corrections per step; three or four are usual.
const MAX_CORRECTIONS: usize = 40;

/// The iteration ends if the correction grows by this factor: the step is too long.
const DIVERGENCE: f64 = 1e3;

const SINGULAR_TANGENT: Error = Error::Decomposition {
    kind: "elimination for the derivative of a step",
};

/// Steps between two polls of the interrupt.
const STEPS_PER_CHECK: usize = 256;

/// The discrete trajectory of `steps` equal steps over `[0, t_end]`: `steps + 1` states, starting with `z0`.
///
/// # Arguments
/// * `z0` - state `(q, qdot, p_q, p_qdot)`; `steps >= 1`; `t_end` finite, negative to run backwards
/// # Accuracy
/// Every step is solved to round-off; orders 1 and 2 for the initial-point and the midpoint map (measured in
/// `tests/integrator.rs`).
/// # Errors
/// `NonFinite`, `InvalidArgument`, `OutsideChart` (a state left `0 < theta < pi`), `NoConvergence` (a step too long),
/// `Overflow`, `Interrupted`.
/// # Source
/// See the module documentation.
pub fn integrate<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<Vec<SVector<f64, Z>>> {
    let composition = Composition::default();
    integrate_composed(chart, map, &composition, z0, steps, t_end, interrupt)
}

/// As [`integrate`], with each step composed to order 4, 6 or 8.
///
/// # Accuracy
/// Orders measured in `tests/composition.rs`.
/// # Errors
/// As [`integrate`].
pub fn integrate_composed<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    composition: &Composition,
    z0: &SVector<f64, Z>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<Vec<SVector<f64, Z>>> {
    let h = check_arguments(chart, z0, steps, t_end)?;
    let mut out = trajectory_buffer(steps)?;
    let mut z = *z0;
    out.push(z);
    for step in 0..steps {
        check_interrupt(interrupt, step)?;
        z = advance(chart, map, composition, &z, h, None)?;
        out.push(z);
    }
    Ok(out)
}

/// The final state of [`integrate_composed`].
///
/// # Errors
/// As [`integrate`].
pub fn last_state<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    composition: &Composition,
    z0: &SVector<f64, Z>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<SVector<f64, Z>> {
    let h = check_arguments(chart, z0, steps, t_end)?;
    let mut z = *z0;
    for step in 0..steps {
        check_interrupt(interrupt, step)?;
        z = advance(chart, map, composition, &z, h, None)?;
    }
    Ok(z)
}

/// The final state of [`integrate`] and its exact derivative with respect to `z0`, shape `(4d, 4d)`.
///
/// # Errors
/// As [`integrate`].
pub fn integrate_with_tangent<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<(SVector<f64, Z>, SMatrix<f64, Z, Z>)> {
    let composition = Composition::default();
    integrate_composed_with_tangent(chart, map, &composition, z0, steps, t_end, interrupt)
}

/// The final state of [`integrate_composed`] and its exact derivative with respect to `z0`, shape `(4d, 4d)`.
///
/// # Errors
/// As [`integrate`].
pub fn integrate_composed_with_tangent<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    composition: &Composition,
    z0: &SVector<f64, Z>,
    steps: usize,
    t_end: f64,
    interrupt: Interrupt<'_>,
) -> Result<(SVector<f64, Z>, SMatrix<f64, Z, Z>)> {
    let h = check_arguments(chart, z0, steps, t_end)?;
    let (mut z, mut tangent) = (*z0, SMatrix::<f64, Z, Z>::identity());
    for step in 0..steps {
        check_interrupt(interrupt, step)?;
        z = advance(chart, map, composition, &z, h, Some(&mut tangent))?;
    }
    Ok((z, tangent))
}

/// Takes one step of length `h`, with all stages of the composition; multiplies the tangent by the step's derivative.
pub(super) fn advance<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    composition: &Composition,
    z: &SVector<f64, Z>,
    h: f64,
    mut tangent: Option<&mut SMatrix<f64, Z, Z>>,
) -> Result<SVector<f64, Z>> {
    let mut z = *z;
    for stage in composition.stages() {
        let product = tangent.as_deref_mut();
        z = match stage {
            Stage::Method(part) => advance_stage(chart, map, &z, part * h, product)?,
            Stage::Adjoint(part) => advance_stage(chart, &Adjoint(map), &z, part * h, product)?,
        };
    }
    Ok(z)
}

fn advance_stage<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z: &SVector<f64, Z>,
    h: f64,
    tangent: Option<&mut SMatrix<f64, Z, Z>>,
) -> Result<SVector<f64, Z>> {
    let solved = solve_step(chart, map, z, h)?;
    check_reached(chart, &solved.end)?;
    if let Some(product) = tangent {
        *product = solved.tangent(chart, map, h)? * *product;
    }
    Ok(solved.end)
}

/// An empty trajectory with space for all states.
pub(super) fn trajectory_buffer<T>(steps: usize) -> Result<Vec<T>> {
    let mut out = Vec::new();
    if out.try_reserve_exact(steps.saturating_add(1)).is_err() {
        let requirement = "few enough for the trajectory to fit in memory";
        return Err(Error::InvalidArgument {
            name: "steps",
            requirement,
            found: steps as f64,
        });
    }
    Ok(out)
}

pub(super) fn check_interrupt(interrupt: Interrupt<'_>, step: usize) -> Result<()> {
    if step.is_multiple_of(STEPS_PER_CHECK) {
        interrupt.check("chart integrator")?;
    }
    Ok(())
}

/// Check the arguments of an integration; return the length of a step.
pub(super) fn check_arguments<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
    steps: usize,
    t_end: f64,
) -> Result<f64> {
    chart.check("z0", z0.as_slice())?;
    crate::linalg::structure::check_finite_scalar("t_end", t_end)?;
    if steps == 0 {
        return Err(Error::InvalidArgument {
            name: "steps",
            requirement: "at least 1",
            found: 0.0,
        });
    }
    Ok(t_end / steps as f64)
}

/// One solved step: its start, the point at which the Hamiltonian vector is evaluated, and its end.
struct IntegratorStep<const X: usize, const Z: usize> {
    p0: SVector<f64, X>,
    middle: SVector<f64, Z>,
    end: SVector<f64, Z>,
}

/// The linearised equations of a step in `(dx, dp)`, with the end momentum eliminated.
struct LinearisedStep<const X: usize, const Z: usize> {
    system: SMatrix<f64, Z, Z>,
    /// The derivative of `v`.
    dv: SMatrix<f64, X, Z>,
    /// The equation for the end momentum: `R_2x^T dp_1 + end_rows (dx, dp) = ...`.
    end_rows: SMatrix<f64, X, Z>,
    /// `R_2v^T R_2x^{-T}`.
    elimination: SMatrix<f64, X, X>,
    /// The two points of the map.
    points: [SVector<f64, X>; 2],
    jacobian: Blocks<X>,
    gradient: SVector<f64, Z>,
}

impl<const X: usize, const Z: usize> LinearisedStep<X, Z> {
    fn new(
        chart: &impl Chart<X, Z>,
        map: &impl DiscretizationMap<X>,
        middle: &SVector<f64, Z>,
        lambda: &[SVector<f64, X>; 2],
        h: f64,
    ) -> Option<Self> {
        let (gradient, hessian) = (chart.gradient(middle), chart.hessian(middle));
        let x = middle.fixed_rows::<X>(0).into_owned();
        let v = gradient.fixed_rows::<X>(X) * h;
        let dv = hessian.fixed_rows::<X>(X) * h;
        let minus_dpdot = hessian.fixed_rows::<X>(0) * h;
        let Expansion {
            points,
            jacobian,
            second_derivative,
        } = map.expansion(&x, &v, lambda);
        let [[r1x, r1v], [r2x, r2v]] = &jacobian;
        let [[cxx, cxv], [cvx, cvv]] = second_derivative;
        let mut end_rows = cxv * dv + minus_dpdot;
        add_columns(&mut end_rows, 0, &cxx);
        let mut elimination = *r2v;
        if !solve_in_place(*r2x, &mut elimination) {
            return None;
        }
        let elimination = elimination.transpose();
        let mut top = r1v * dv;
        add_columns(&mut top, 0, r1x);
        let mut bottom = cvv * dv - elimination * end_rows;
        add_columns(&mut bottom, 0, &cvx);
        add_columns(&mut bottom, X, &(-SMatrix::<f64, X, X>::identity()));
        let mut system = SMatrix::<f64, Z, Z>::zeros();
        system.fixed_rows_mut::<X>(0).copy_from(&top);
        system.fixed_rows_mut::<X>(X).copy_from(&bottom);
        Some(LinearisedStep {
            system,
            dv,
            end_rows,
            elimination,
            points,
            jacobian,
            gradient,
        })
    }
}

/// Solves one step for `(x, p, p_1)`:
/// `R_1(x, v) = x_0`, `-R_1x^T p_0 + R_2x^T p_1 = pdot`, `-R_1v^T p_0 + R_2v^T p_1 = p`, `(v, pdot) = h X_H(x, p)`.
fn solve_step<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
    h: f64,
) -> Result<IntegratorStep<X, Z>> {
    let x0 = z0.fixed_rows::<X>(0).into_owned();
    let p0 = z0.fixed_rows::<X>(X).into_owned();
    let (mut middle, mut p1) = (*z0, p0);
    // The initial guess is off by about the length of the step.
    let scale = 1.0 + z0.amax();
    let mut correction = h.abs() * chart.gradient(z0).amax() / scale;
    if !correction.is_finite() {
        return Err(Error::Overflow {
            quantity: "Hamiltonian vector field",
        });
    }
    for iteration in 0..MAX_CORRECTIONS {
        let failed = |reason| Err(step_failed(iteration, correction, reason));
        let Some(linear) = LinearisedStep::new(chart, map, &middle, &[-p0, p1], h) else {
            return failed(StopReason::SingularJacobian);
        };
        let [[r1x, r1v], [r2x, r2v]] = &linear.jacobian;
        let p = middle.fixed_rows::<X>(X).into_owned();
        let start = linear.points[0] - x0;
        let rate =
            r2x.transpose() * p1 - r1x.transpose() * p0 + linear.gradient.fixed_rows::<X>(0) * h;
        let momentum = r2v.transpose() * p1 - r1v.transpose() * p0 - p;
        let mut update = SMatrix::<f64, Z, 1>::zeros();
        update.fixed_rows_mut::<X>(0).copy_from(&(-start));
        update
            .fixed_rows_mut::<X>(X)
            .copy_from(&(linear.elimination * rate - momentum));
        let mut end_update = SMatrix::<f64, X, 1>::zeros();
        let solved = solve_in_place(linear.system, &mut update) && {
            end_update = -rate - linear.end_rows * update;
            solve_in_place(r2x.transpose(), &mut end_update)
        };
        if !solved {
            return failed(StopReason::SingularJacobian);
        }
        let next = update.amax().max(end_update.amax()) / scale;
        if !next.is_finite() || (next > 1.0 && next > DIVERGENCE * correction) {
            return failed(StopReason::Diverged);
        }
        middle += update;
        p1 += end_update;
        correction = next;
        if correction <= LAST_CORRECTION {
            let x = middle.fixed_rows::<X>(0).into_owned();
            let v = chart.gradient(&middle).fixed_rows::<X>(X) * h;
            let mut end = SVector::<f64, Z>::zeros();
            end.fixed_rows_mut::<X>(0).copy_from(&map.map(&x, &v)[1]);
            end.fixed_rows_mut::<X>(X).copy_from(&p1);
            return Ok(IntegratorStep { p0, middle, end });
        }
    }
    Err(step_failed(
        MAX_CORRECTIONS,
        correction,
        StopReason::MaxIterations,
    ))
}

impl<const X: usize, const Z: usize> IntegratorStep<X, Z> {
    /// The derivative of the end with respect to the start, from the linearised equations at the solution.
    fn tangent(
        &self,
        chart: &impl Chart<X, Z>,
        map: &impl DiscretizationMap<X>,
        h: f64,
    ) -> Result<SMatrix<f64, Z, Z>> {
        let p1 = self.end.fixed_rows::<X>(X).into_owned();
        let linear = LinearisedStep::new(chart, map, &self.middle, &[-self.p0, p1], h)
            .ok_or(SINGULAR_TANGENT)?;
        let [[r1x, r1v], [r2x, r2v]] = &linear.jacobian;
        let mut middle = SMatrix::<f64, Z, Z>::zeros();
        for i in 0..X {
            middle[(i, i)] = 1.0;
        }
        middle
            .fixed_view_mut::<X, X>(X, X)
            .copy_from(&(r1v.transpose() - linear.elimination * r1x.transpose()));
        if !solve_in_place(linear.system, &mut middle) {
            return Err(SINGULAR_TANGENT);
        }
        let mut momentum = -linear.end_rows * middle;
        add_columns(&mut momentum, X, &r1x.transpose());
        if !solve_in_place(r2x.transpose(), &mut momentum) {
            return Err(SINGULAR_TANGENT);
        }
        let mut out = SMatrix::<f64, Z, Z>::zeros();
        out.fixed_rows_mut::<X>(0)
            .copy_from(&(r2x * middle.fixed_rows::<X>(0) + r2v * (linear.dv * middle)));
        out.fixed_rows_mut::<X>(X).copy_from(&momentum);
        Ok(out)
    }
}

fn add_columns<const X: usize, const Z: usize>(
    target: &mut SMatrix<f64, X, Z>,
    first: usize,
    block: &SMatrix<f64, X, X>,
) {
    let mut view = target.fixed_columns_mut::<X>(first);
    view += block;
}

fn step_failed(iterations: usize, residual: f64, reason: StopReason) -> Error {
    let report = SolverReport::new(reason, iterations, residual, LAST_CORRECTION);
    Error::NoConvergence {
        solver: "implicit step",
        report,
    }
}
