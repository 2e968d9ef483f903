//! Geometric polynomials of minimal cost: inner control points chosen to minimise the squared acceleration.
//!
//! End points and end velocities determine the first two and the last two control points; the other `degree - 3` points
//! are free. Riemannian cubics are the critical curves of the cost, so the polynomial of least cost is the Ritz
//! approximation of the cubic with the same boundary data, and its distance to the cubic decreases by about a factor of
//! ten per degree.
//!
//! The cost is a sum of squares, of the accelerations at Gauss-Legendre nodes, and in flat space the accelerations are
//! linear in the control points. So the Gauss-Newton method needs few steps: two on the paper's sphere and three on its
//! St(3,2).

use faer::{Mat, MatRef};

use super::acceleration_residual::{AccelerationResidual, Differences, SOLVER};
use super::curve::Curve;
use super::de_casteljau::GeometricPolynomial;
use super::end_legs::{check_boundary, outer_leg};
use super::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::{solve_upper, thin_qr};
use crate::linalg::structure::norm;
use crate::manifold::{QuasiGeodesic, Stiefel};
use crate::report::{SolverReport, StopReason};

/// Fraction of the acceleration that moving the control points may still reduce; the relative error of the minimal cost
/// is the square of this.
const TOLERANCE: f64 = 1e-6;

/// Maximal number of steps; up to six are usual, more if the curve turns by a right angle or more.
const MAX_STEPS: usize = 50;

/// Number of times a step is halved before the direction is given up.
const MAX_HALVINGS: i32 = 20;

/// A step is accepted if it reduces the cost by this fraction of the reduction that the linear model predicts.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Reducible fraction of the acceleration below which derivatives must be accurate.
const NEAR: f64 = 1e-3;

/// Numbers of nodes; each is tried if the previous one does not resolve the curve.
const NODES: [usize; 7] = [16, 24, 32, 48, 64, 96, 128];

/// Highest Legendre coefficients of a curve that counts as resolved, at the start and at the end.
const RESOLVED: [f64; 2] = [1e-9, 1e-8];

/// Above this degree, the minimum differs from the cubic only by round-off.
const MAX_DEGREE: usize = 10;

/// Maximal work, in multiplications of a difference quotient at one time for all unknowns. At distance and speeds of 1,
/// St(12,10) takes 6.4 s in degree 7 (6.6e6) and 10.5 s in degree 8 (1.09e7), St(14,12) 35 s in degree 10 (5.7e7); with
/// harder data, which take more steps, more than 100 s.
const MAX_WORK: f64 = 1.1e7;

impl GeometricPolynomial {
    /// The curve of the given degree, 3 to 10, of least cost among those with end points `s0, s1` and end velocities
    /// `v0, v1`, all of shape `(n, k)`.
    ///
    /// ```math
    /// \min_{P_2, \dots, P_{m-2}} \int_0^1 |D_t \gamma'|^2\, dt
    /// ```
    ///
    /// This is a local minimum, found from the degree-elevated control points of the geometric cubic. Degree 3 has no
    /// free point and is the geometric cubic itself.
    ///
    /// The search may take longer than computing the exact cubic, [`RiemannianCubic::from_boundary`], whose points are
    /// also quick to evaluate. Use this method if you need a curve in closed form.
    ///
    /// [`RiemannianCubic::from_boundary`]: crate::cubic::RiemannianCubic::from_boundary
    ///
    /// Searches that would take minutes are refused by their work for degree `m`, which is at most `1.1e7`: with `r =
    /// min(n, 4k)`
    ///
    /// ```math
    /// \tfrac12 (m - 3)\, m\, (m - 1)\, r\, k^2 \dim \mathrm{St}(r, k)
    /// ```
    ///
    /// Returns the curve and a report. Its residual is the norm of the part of the acceleration that moving the control
    /// points changes to first order; it is at most `1e-6` of the square root of the cost.
    ///
    /// The mean distance to the Riemannian cubic with the same data is smaller than that of the geometric cubic by
    /// factors of 39, 217, 2450 and 65000 for degrees 4 to 7 on the sphere with the data of arXiv 2404.19407, and by
    /// 11, 133, 1420 and 15000 on its St(3,2). Over 200 random problems on each of five shapes (distance up to 1.5,
    /// speeds up to 2) the factors are 5 to 6, 18 to 32, 160 to 220, and 900 to 1900 for degrees 4 to 7 in the
    /// geometric mean. The whole table is in [`crate::guide::control_points`].
    ///
    /// # Accuracy
    /// The cost is minimal to `1e-12` relative, asserted in `tests/minimal_cost.rs`; end points and end velocities are
    /// exact to round-off.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` if the degree is not between 3 and 10,
    /// an end velocity is too long, or the work is above its limit; `NoJoiningCurve`, `OutsideLogDomain`,
    /// `DifferentComponents` if control points cannot be joined; `BranchJump` if intermediate points cannot;
    /// `NoConvergence`, `Interrupted`.
    /// # Source
    /// arXiv 2404.19407 suggests "an alternative choice of control points". Dennis, Schnabel (1996), "Numerical Methods
    /// for Unconstrained Optimization and Nonlinear Equations", ch. 10 (the Gauss-Newton method and when it has
    /// converged).
    pub fn minimal_cost(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        degree: usize,
        interrupt: Interrupt<'_>,
    ) -> Result<(Self, SolverReport)> {
        check_boundary([("S0", s0), ("V0", v0), ("S1", s1), ("V1", v1)])?;
        let span = Span::of(&[s0, v0, s1, v1]);
        let [s0, v0, s1, v1] = [s0, v0, s1, v1].map(|a| span.down(a));
        check_size(degree, &Stiefel::of("S0", s0.as_ref())?)?;
        let start = elevated_cubic(&s0, &v0, &s1, &v1, degree)?;
        let (curve, report) = minimise(start, interrupt)?;
        let curve = curve.lifted_by(span);
        curve.check_branch()?;
        Ok((curve, report))
    }
}

/// Return `InvalidArgument` unless the degree is allowed and the work takes seconds.
fn check_size(degree: usize, reduced: &Stiefel) -> Result<()> {
    if !(3..=MAX_DEGREE).contains(&degree) {
        return Err(Error::InvalidArgument {
            name: "degree",
            requirement: "from 3 to 10",
            found: degree as f64,
        });
    }
    let unknowns = (degree - 3) * reduced.dim();
    let joins = degree * (degree - 1) / 2;
    let [r, k] = [reduced.n(), reduced.k()].map(|size| size as f64);
    let work = (unknowns * joins) as f64 * r * k * k;
    if work > MAX_WORK {
        return Err(Error::InvalidArgument {
            name: "work of the search, (degree - 3) degree (degree - 1) / 2 r k^2 dim St(r, k) with r = min(n, 4k)",
            requirement: "at most 1.1e7 (choose a lower degree, or the exact cubic of RiemannianCubic.from_boundary)",
            found: work,
        });
    }
    Ok(())
}

/// The polynomial whose inner control points are the degree-elevated ones of the geometric cubic, with quasi-geodesics
/// in place of straight lines; the outer legs are exact.
fn elevated_cubic(
    s0: &Mat<f64>,
    v0: &Mat<f64>,
    s1: &Mat<f64>,
    v1: &Mat<f64>,
    degree: usize,
) -> Result<GeometricPolynomial> {
    let back = -v1;
    let (first, p1) = outer_leg("V0", s0, v0, degree)?;
    let (last, p_last) = outer_leg("V1", s1, &back, degree)?;
    let third = |s: &Mat<f64>, v: &Mat<f64>| {
        let third = v * faer::Scale(1.0 / 3.0);
        QuasiGeodesic::from_velocity(s.as_ref(), third.as_ref())?.point(1.0)
    };
    let mut points = vec![s0.clone(), third(s0, v0)?, third(s1, &back)?, s1.clone()];
    for current in 3..degree {
        points = elevated(&points, current)?;
    }
    points[1] = p1;
    points[degree - 1] = p_last;
    let mut legs = vec![first];
    for i in 1..degree - 1 {
        legs.push(QuasiGeodesic::joining(
            points[i].as_ref(),
            points[i + 1].as_ref(),
        )?);
    }
    legs.push(last.reversed()?);
    GeometricPolynomial::unchecked(points, None, legs)
}

/// Degree elevation: `P_i` moves towards `P_{i-1}` by the fraction `i / (degree + 1)`.
fn elevated(points: &[Mat<f64>], degree: usize) -> Result<Vec<Mat<f64>>> {
    let mut out = vec![points[0].clone()];
    for i in 1..=degree {
        let back = QuasiGeodesic::joining(points[i].as_ref(), points[i - 1].as_ref())?;
        out.push(back.point(i as f64 / (degree + 1) as f64)?);
    }
    out.push(points[degree].clone());
    Ok(out)
}

/// The Gauss-Newton method, with increasing numbers of nodes until they resolve the curve.
fn minimise(
    mut curve: GeometricPolynomial,
    interrupt: Interrupt<'_>,
) -> Result<(GeometricPolynomial, SolverReport)> {
    let [at_start, at_end] = RESOLVED;
    let mut steps = 0;
    let mut unresolved = f64::NAN;
    for (i, nodes) in NODES.into_iter().enumerate() {
        let mut problem = AccelerationResidual::new(curve, nodes);
        let mut residual = vec![0.0; problem.len()];
        problem.residual_into(&mut residual)?;
        if problem.unresolved() > at_start && i + 1 < NODES.len() {
            curve = problem.into_curve();
            continue;
        }
        let report = gauss_newton(&mut problem, residual, steps, interrupt)?;
        unresolved = problem.unresolved();
        curve = problem.into_curve();
        if unresolved <= at_end {
            return Ok((curve, report));
        }
        steps = report.iterations;
    }
    Err(failed(steps, unresolved, at_end, StopReason::Stagnated))
}

/// Reduces the cost from the current control points, those of `residual`, until it is stationary; `taken` steps are
/// already counted.
fn gauss_newton(
    problem: &mut AccelerationResidual,
    mut residual: Vec<f64>,
    taken: usize,
    interrupt: Interrupt<'_>,
) -> Result<SolverReport> {
    let mut trial = residual.clone();
    let mut jacobian = Mat::zeros(problem.len(), problem.unknowns());
    let mut differences = Differences::Forward;
    let mut iterations = taken;
    loop {
        let size = length(&residual);
        let tolerance = TOLERANCE * size + problem.noise();
        if problem.unknowns() == 0 || size <= problem.noise() {
            return Ok(converged(iterations, 0.0, tolerance));
        }
        problem.jacobian_into(&mut jacobian, &residual, differences, interrupt)?;
        let (q, r) = thin_qr(jacobian.as_ref());
        let mut step = q.transpose() * column(&residual);
        let slope = step.norm_l2();
        let done = slope <= tolerance;
        if done && differences == Differences::Forward {
            differences = Differences::Central;
            continue;
        }
        if slope <= NEAR * size {
            differences = Differences::Central;
        }
        if iterations >= MAX_STEPS && !done {
            let reason = StopReason::MaxIterations;
            return Err(failed(iterations, slope, tolerance, reason));
        }
        solve_upper(r.as_ref(), step.as_mut());
        let step: Vec<f64> = (0..step.nrows()).map(|i| -step[(i, 0)]).collect();
        if done {
            polish(problem, &step, size, &mut trial)?;
            return Ok(converged(iterations, slope, tolerance));
        }
        if !length(&step).is_finite() {
            let reason = StopReason::SingularJacobian;
            return Err(failed(iterations, slope, tolerance, reason));
        }
        if !descend(problem, &step, &residual, slope, &mut trial)? {
            return Err(failed(iterations, slope, tolerance, StopReason::Stagnated));
        }
        std::mem::swap(&mut residual, &mut trial);
        iterations += 1;
    }
}

/// The last step, whose gain is below the round-off of the cost. It is already computed, and makes the control points
/// accurate to some more digits. Rejected if the cost, with square root `size`, increases.
fn polish(
    problem: &mut AccelerationResidual,
    step: &[f64],
    size: f64,
    trial: &mut [f64],
) -> Result<()> {
    let centre = problem.inner();
    let found = problem
        .moved(step, 1.0)
        .and_then(|points| problem.set_inner(&points))
        .and_then(|()| problem.residual_into(trial));
    if found.is_ok() && length(trial) <= size * (1.0 + TOLERANCE * TOLERANCE) {
        return Ok(());
    }
    problem.set_inner(&centre)
}

/// Moves along the step, halved until the cost decreases enough, and stores the new residual in `trial`; returns
/// whether it decreases.
fn descend(
    problem: &mut AccelerationResidual,
    step: &[f64],
    residual: &[f64],
    slope: f64,
    trial: &mut [f64],
) -> Result<bool> {
    let cost = length(residual).powi(2);
    let centre = problem.inner();
    for halving in 0..=MAX_HALVINGS {
        let scale = 0.5_f64.powi(halving);
        let enough = cost - 2.0 * SUFFICIENT_DECREASE * scale * slope * slope;
        // A step to points that no curve joins counts as one that does not reduce the cost.
        let there = problem.moved(step, scale);
        let found = there
            .and_then(|points| problem.set_inner(&points))
            .and_then(|()| problem.residual_into(trial));
        if found.is_ok() && length(trial).powi(2) <= enough {
            return Ok(true);
        }
        problem.set_inner(&centre)?;
    }
    Ok(false)
}

fn column(x: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(x, x.len(), 1)
}

fn length(x: &[f64]) -> f64 {
    norm(column(x))
}

fn converged(iterations: usize, residual: f64, tolerance: f64) -> SolverReport {
    SolverReport::new(StopReason::Converged, iterations, residual, tolerance)
}

fn failed(iterations: usize, residual: f64, tolerance: f64, reason: StopReason) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport::new(reason, iterations, residual, tolerance),
    }
}
