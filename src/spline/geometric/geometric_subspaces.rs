//! Geometric cubics through subspaces, with bases that continue from piece to piece.

use faer::{Mat, MatRef, Scale};

use super::geometric_spline::solved;
use crate::curve::{Curve, SubspacePolynomial};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::grassmann::alignment::alignment;
use crate::report::SolverReport;
use crate::space::Quotient;
use crate::spline::ends::EndConditions;
use crate::spline::hermite::check;
use crate::spline::options::SplineOptions;
use crate::spline::piecewise::Piecewise;

/// The once continuously differentiable curve of geometric cubics through subspaces with given velocities.
///
/// Points are arbitrary bases of the subspaces, velocities are horizontal vectors at them; the bases of the curve start
/// with the first given one.
///
/// # Arguments
/// As [`cubic_hermite`](crate::spline::cubic_hermite).
/// # Errors
/// As [`cubic_hermite`](crate::spline::cubic_hermite), and the errors of [`SubspacePolynomial::from_boundary`].
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::spline::geometric_subspace_hermite;
/// use stiefel_rs::{Curve, Interrupt};
/// // Lines in the plane at the angles 0, 1 and 0, at rest at each.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[-a.cos()], [-a.sin()]]);
/// let rest = mat![[0.0], [0.0]];
/// let views = points.each_ref().map(|point| point.as_ref());
/// let t = [0.0, 1.0, 3.0];
/// let curve = geometric_subspace_hermite(&t, &views, &[rest.as_ref(); 3], Interrupt::NEVER)?;
/// assert!((curve.cost(Interrupt::NEVER)? - (12.0 + 12.0 / 8.0)).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn geometric_subspace_hermite(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
    interrupt: Interrupt<'_>,
) -> Result<Piecewise<SubspacePolynomial>> {
    check(Quotient::Subspaces, t, points, velocities)?;
    chained(t, points, velocities, interrupt)
}

/// The spline of geometric cubics through subspaces, given by arbitrary bases, with continuous velocity and covariant
/// acceleration.
///
/// It is solved like [`geometric_spline`](crate::spline::geometric_spline), with geodesics in place of quasi-geodesics.
/// The bases of the curve start with the first given one. For lines in the plane it is the cubic spline of the angle.
///
/// # Arguments
/// * `t` - increasing times; `points` - one orthonormal basis per time, shape `(n, k)`
/// * `ends` - vectors are horizontal at the given bases; periodic splines close as subspaces
/// * `options` - used for subspaces, whatever their `quotient` is
/// # Accuracy
/// As [`geometric_spline`](crate::spline::geometric_spline).
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (tolerance, tension, times, ends that do not close); `Overflow` (times that
/// differ too much), `NoConvergence`, `Interrupted`; wrapped in `AtKnot`: `NotOrthonormal`, `NotHorizontal`, and
/// `RightAngle` if a principal angle between neighbours, or between control points, is pi/2.
///
/// # Examples
/// ```
/// use faer::{Mat, MatRef, mat};
/// use stiefel_rs::{Curve, Interrupt};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, geometric_subspace_spline};
/// // Lines in the plane at the angles 0, 1 and 0, whichever way their bases point.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[-a.cos()], [-a.sin()]]);
/// let views = points.each_ref().map(|point| point.as_ref());
/// let options = SplineOptions::default();
/// let (curve, report) =
///     geometric_subspace_spline(&[0.0, 1.0, 2.0], &views, &EndConditions::Natural, &options, Interrupt::NEVER)?;
/// assert!(report.converged);
/// // The natural spline of 0, 1, 0 is (3 t - t^3) / 2 on [0, 1].
/// let angle: f64 = (3.0 * 0.5 - 0.125) / 2.0;
/// assert!((curve.point(0.5)? + mat![[angle.cos()], [angle.sin()]]).norm_l2() < 1e-11);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn geometric_subspace_spline(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<(Piecewise<SubspacePolynomial>, SolverReport)> {
    let (problem, velocities, report) =
        solved(Quotient::Subspaces, t, points, ends, options, interrupt)?;
    let velocities: Vec<Mat<f64>> = points
        .iter()
        .enumerate()
        .map(|(knot, point)| problem.velocity_at(knot, *point, &velocities))
        .collect();
    let velocities: Vec<_> = velocities.iter().map(Mat::as_ref).collect();
    let curve = chained(t, points, &velocities, interrupt)?;
    Ok((curve, report))
}

/// Computes the pieces in order, each in terms of the basis that the previous one reaches.
fn chained(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
    interrupt: Interrupt<'_>,
) -> Result<Piecewise<SubspacePolynomial>> {
    let mut pieces: Vec<SubspacePolynomial> = Vec::with_capacity(t.len() - 1);
    let (mut start, mut velocity) = (points[0].to_owned(), velocities[0].to_owned());
    for i in 1..t.len() {
        let (h, end) = (Scale(t[i] - t[i - 1]), points[i]);
        let [v0, v1] = [velocity.as_ref(), velocities[i]].map(|v| v * h);
        let make = SubspacePolynomial::from_boundary;
        let piece = make(start.as_ref(), v0.as_ref(), end, v1.as_ref(), interrupt)
            .map_err(|error| error.at_knot(i - 1))?;
        let turn = alignment(piece.point(1.0)?.as_ref(), end)?;
        start = end * &turn;
        velocity = velocities[i] * &turn;
        pieces.push(piece);
    }
    Ok(Piecewise::new(t.to_vec(), pieces))
}
