//! Smoothing splines: curves that balance closeness to data against their cost.
//!
//! ```math
//! \min_S \sum_i w_i\, d(S(t_i), Y_i)^2 + \lambda \int |D_t S'|^2\, dt
//! ```
//!
//! Between knots the curve is a Riemannian cubic; velocity and covariant acceleration are continuous, and the covariant
//! jerk jumps at the data:
//!
//! ```math
//! D_t^2 S'(t_i^+) - D_t^2 S'(t_i^-) = \frac1\lambda \sum_{j : t_j = t_i} w_j \log_{S(t_i)} Y_j
//! ```
//!
//! # Source
//! Reinsch (1967), "Smoothing by spline functions", Numer. Math. 10, 177-183, in flat space; the equations on a manifold are
//! the first variation of the sum (Samir, Absil, Srivastava, Klassen (2012), Found. Comput. Math. 12, 49-73). Generalised
//! cross-validation: Craven, Wahba (1979), Numer. Math. 31, 377-403.

use faer::{Mat, MatRef};

use super::grouped::Grouped;
use super::smoothing_equations::SmoothingData;
use super::smoothing_options::SmoothingOptions;
use super::solve::solve;
use crate::cubic::{IntegrationOptions, RiemannianCubic};
use crate::curve::Curve as _;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::advised_curve;
use crate::manifold::{Grassmann, Stiefel};
use crate::report::{SolverReport, StopReason};
use crate::space::{Quotient, ScalarField};
use crate::spline::bases::joined;
use crate::spline::chains::ambient::Ambient;
use crate::spline::chains::framed::{Framed, frames};
use crate::spline::ends::EndConditions;
use crate::spline::knots;
use crate::spline::piecewise::Piecewise;
use crate::spline::reduced_knots::ReducedKnots;
use crate::spline::riemannian::cubic_spline;

const SOLVER: &str = "smoothing spline";

/// A smoothing spline and the figures of its fit.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt};
/// use stiefel_rs::spline::{SmoothingOptions, smoothing_spline};
/// let points = [0.0_f64, 0.5, 0.3, 0.9].map(|a| mat![[a.cos()], [a.sin()]]);
/// let (t, views) = ([0.0, 1.0, 2.0, 3.0], points.each_ref().map(|point| point.as_ref()));
/// let with = |lambda| SmoothingOptions { lambda: Some(lambda), ..Default::default() };
/// let close = smoothing_spline(&t, &views, None, &with(0.01), Interrupt::NEVER)?;
/// let smooth = smoothing_spline(&t, &views, None, &with(1.0), Interrupt::NEVER)?;
/// assert!(close.misfit < smooth.misfit && smooth.curve.cost(Interrupt::NEVER)? < close.curve.cost(Interrupt::NEVER)?);
/// assert!(2.0 < smooth.degrees_of_freedom && smooth.degrees_of_freedom < close.degrees_of_freedom);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SmoothingSpline {
    /// The curve.
    pub curve: Piecewise<RiemannianCubic>,
    /// The weight of the cost, as given or chosen.
    pub lambda: f64,
    /// `sum_i w_i d(S(t_i), Y_i)^2`.
    pub misfit: f64,
    /// Trace of the influence matrix of the spline in flat space: the effective number of data that the curve can
    /// follow, between 2 and the number of data.
    pub degrees_of_freedom: f64,
    /// The report of the solver.
    pub report: SolverReport,
}

/// The smoothing spline of the given data.
///
/// Generalised cross-validation chooses the `lambda` that minimises
///
/// ```math
/// \frac{N \sum_i w_i |r_i|^2}{(N - \mathrm{tr} A)^2}
/// ```
///
/// with residuals `r` and influence matrix `A` of the smoothing spline in flat space, to which the data are unrolled
/// along quasi-geodesics between neighbours; on the circle this is exact.
///
/// If `lambda` exceeds about the fourth power of the number of data, in units of the mean step, the curve is the
/// regression geodesic; for infinite `lambda` exactly so. Between two points it is the geodesic for every `lambda`.
///
/// # Arguments
/// * `t` - times in non-decreasing order; `data` - one point per time, shape `(n, k)`
/// * `weights` - one per datum, positive; all 1 if `None`
/// # Errors
/// `Shape` (also two points without `lambda`), `NonFinite`, `InvalidArgument` (decreasing times, weights, `lambda`);
/// `NoConvergence` (with `NotMinimal` if a geodesic near the data or the spline through them is better than the curve
/// found), which is in `OnlyBases` at a knot if most data look like mere bases; `Interrupted`;
/// wrapped in `AtKnot`, with the index of the distinct time: `NotOrthonormal`, the errors of joining neighbours, and
/// `LogNotFound` and similar errors if a datum is too far from the curve.
pub fn smoothing_spline(
    t: &[f64],
    data: &[MatRef<'_, f64>],
    weights: Option<&[f64]>,
    options: &SmoothingOptions,
    interrupt: Interrupt<'_>,
) -> Result<SmoothingSpline> {
    knots::check_tolerance(options.tolerance)?;
    let manifold = check(t, data, weights, options.lambda)?;
    options.field.check(data.iter().copied())?;
    let grouped = Grouped::new(t, weights);
    let firsts: Vec<MatRef<'_, f64>> = grouped.first.iter().map(|&i| data[i]).collect();
    let found = smoothed(&manifold, data, grouped, &firsts, options, interrupt);
    found.map_err(|error| advised_curve(error, options.quotient, &firsts))
}

/// The spline of checked data, whose first points at each time are `firsts`.
fn smoothed(
    manifold: &Stiefel,
    data: &[MatRef<'_, f64>],
    grouped: Grouped,
    firsts: &[MatRef<'_, f64>],
    options: &SmoothingOptions,
    interrupt: Interrupt<'_>,
) -> Result<SmoothingSpline> {
    // St(1, 1) has dimension zero.
    if dim(manifold, options.quotient) == 0 {
        return interpolated(manifold, data, &grouped, firsts, options, interrupt);
    }
    if let [first, last] = data {
        return between(manifold, [*first, *last], grouped.t, options, interrupt);
    }
    if options.lambda == Some(0.0) {
        return interpolated(manifold, data, &grouped, firsts, options, interrupt);
    }
    let kind = options.spline().kind();
    let knots = ReducedKnots::new(kind, &grouped.t, firsts, data)?;
    let low = data.iter().map(|point| knots.point(*point)).collect();
    let heaviest = grouped
        .weights
        .iter()
        .fold(0.0, |most: f64, w| most.max(*w));
    let weights = grouped.weights.iter().map(|w| w / heaviest).collect();
    let data = SmoothingData::new(low, grouped.knots.clone(), weights);
    // Multiply one factor at a time: the product of the factors may overflow.
    let given = options
        .lambda
        .map(|lambda| lambda / knots.unit / knots.unit / knots.unit / heaviest);
    let solved = if knots.is_small() {
        let through = |points: &[Mat<f64>]| {
            let frames = frames(kind, points)?.into();
            let (columns, lengths) = (points[0].ncols(), knots.lengths.clone());
            Framed::new(kind, frames, columns, lengths, interrupt)
        };
        solve(through, &knots, &data, given, options, interrupt)?
    } else {
        let through = |points: &[Mat<f64>]| {
            let (points, lengths) = (points.to_vec(), knots.lengths.clone());
            Ambient::new(kind, points, lengths, interrupt)
        };
        solve(through, &knots, &data, given, options, interrupt)?
    };
    let report = solved.report;
    if !report.converged {
        return Err(Error::NoConvergence {
            solver: SOLVER,
            report,
        });
    }
    check_complex(options.field, &solved.pieces)?;
    let found = solved.lambda * heaviest * knots.unit * knots.unit * knots.unit;
    let lambda = options.lambda.unwrap_or(found);
    if options.lambda.is_none() && !lambda.is_normal() {
        return Err(Error::InvalidArgument {
            name: "t",
            requirement: "in a unit of time in which the chosen lambda neither overflows nor underflows",
            found: knots.unit,
        });
    }
    Ok(SmoothingSpline {
        curve: Piecewise::new(
            grouped.t,
            joined(options.quotient, knots.first_turn(), solved.pieces, None)?,
        ),
        lambda,
        misfit: solved.misfit * heaviest,
        degrees_of_freedom: solved.degrees_of_freedom,
        report,
    })
}

fn check(
    t: &[f64],
    data: &[MatRef<'_, f64>],
    weights: Option<&[f64]>,
    lambda: Option<f64>,
) -> Result<Stiefel> {
    let manifold = knots::check_data(t, data)?;
    if let Some(weights) = weights {
        if weights.len() != t.len() {
            return Err(Error::Shape {
                name: "weights",
                expected: format!("({0},), one for each of the {0} points", t.len()),
                found: format!("({},)", weights.len()),
            });
        }
        if let Some((i, found)) = weights
            .iter()
            .enumerate()
            .find(|(_, w)| !(**w > 0.0 && w.is_finite()))
        {
            let error = Error::InvalidArgument {
                name: "weights",
                requirement: "positive and finite",
                found: *found,
            };
            return Err(error.at_knot(i));
        }
    }
    match lambda {
        Some(found) if found.is_nan() || found < 0.0 => Err(Error::InvalidArgument {
            name: "lam",
            requirement: "at least 0, or infinite",
            found,
        }),
        _ => Ok(manifold),
    }
}

/// For two points: the geodesic between them has neither misfit nor cost.
fn between(
    manifold: &Stiefel,
    data: [MatRef<'_, f64>; 2],
    t: Vec<f64>,
    options: &SmoothingOptions,
    interrupt: Interrupt<'_>,
) -> Result<SmoothingSpline> {
    let Some(lambda) = options.lambda else {
        return Err(Error::Shape {
            name: "t",
            expected: "(N,) with N >= 3 for cross-validation, or lam given".to_owned(),
            found: "(2,)".to_owned(),
        });
    };
    let [s0, s1] = data;
    let found = match options.quotient {
        Quotient::Frames => {
            let found = manifold.log_with_report(s0, s1, interrupt);
            found.map(|(velocity, log)| (velocity, (log.iterations, log.residual)))
        }
        Quotient::Subspaces => Grassmann::new(manifold.n(), manifold.k())?
            .log(s0, s1)
            .map(|velocity| (velocity, (0, 0.0))),
    };
    let (velocity, (iterations, residual)) = found.map_err(|error| error.at_knot(0))?;
    let zero = Mat::zeros(s0.nrows(), s0.ncols());
    let integration = IntegrationOptions {
        quotient: options.quotient,
        ..IntegrationOptions::default()
    };
    let [v, zero] = [&velocity, &zero].map(|vector| vector.as_ref());
    let piece = RiemannianCubic::from_initial(s0, v, zero, zero, &integration, interrupt)?;
    Ok(SmoothingSpline {
        curve: Piecewise::new(t, vec![piece]),
        lambda,
        misfit: 0.0,
        degrees_of_freedom: 2.0,
        report: SolverReport::new(
            StopReason::Converged,
            iterations,
            residual,
            options.tolerance.max(residual),
        ),
    })
}

/// For a zero weight of the cost: the natural spline through the data.
fn interpolated(
    manifold: &Stiefel,
    data: &[MatRef<'_, f64>],
    grouped: &Grouped,
    points: &[MatRef<'_, f64>],
    options: &SmoothingOptions,
    interrupt: Interrupt<'_>,
) -> Result<SmoothingSpline> {
    if grouped.t.len() < data.len() && dim(manifold, options.quotient) > 0 {
        return Err(Error::InvalidArgument {
            name: "lam",
            requirement: "positive if times repeat",
            found: 0.0,
        });
    }
    let natural = EndConditions::Natural;
    let (curve, report) = cubic_spline(&grouped.t, points, &natural, &options.spline(), interrupt)?;
    Ok(SmoothingSpline {
        curve,
        lambda: options.lambda.unwrap_or(0.0),
        misfit: 0.0,
        degrees_of_freedom: points.len() as f64,
        report,
    })
}

/// Dimension of the manifold of the points.
fn dim(manifold: &Stiefel, quotient: Quotient) -> usize {
    match quotient {
        Quotient::Frames => manifold.dim(),
        Quotient::Subspaces => (manifold.n() - manifold.k()) * manifold.k(),
    }
}

/// Returns an error if integrated pieces between complex points have left the complex frames, which real unknowns permit.
///
/// # Errors
/// `NotComplex`, wrapped in `AtKnot`; the errors of evaluating the pieces.
fn check_complex(field: ScalarField, pieces: &[RiemannianCubic]) -> Result<()> {
    if field == ScalarField::Real {
        return Ok(());
    }
    for (knot, piece) in pieces.iter().enumerate() {
        for order in [0, 1] {
            let middle = piece.derivative(0.5, order)?;
            let checked = field.check([middle.as_ref()]);
            checked.map_err(|error| error.at_knot(knot))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::cubic::IntegrationOptions;
    use crate::linalg::complex_embedding::embed;

    /// The curve on complex St(2, 1) with a given velocity at the first unit vector, embedded; and one that leaves
    /// these frames.
    #[test]
    fn pieces_that_leave_the_complex_frames_are_refused() {
        let complex =
            |entries: [faer::c64; 2]| embed(Mat::from_fn(2, 1, |i, _| entries[i]).as_ref());
        let number = faer::c64::new;
        let s = complex([number(1.0, 0.0), number(0.0, 0.0)]);
        let inside = complex([number(0.0, 0.3), number(0.5, -0.7)]);
        let mut outside = inside.clone();
        // Tangent, but the second column is no longer `i` times the first.
        outside[(1, 1)] += 0.1;
        let curve = |v: &Mat<f64>| {
            let (zero, options) = (Mat::zeros(4, 2), IntegrationOptions::default());
            let [s, v, zero] = [&s, v, &zero].map(|x| x.as_ref());
            RiemannianCubic::from_initial(s, v, zero, zero, &options, Interrupt::NEVER).unwrap()
        };
        let pieces = [curve(&inside), curve(&outside)];
        assert!(check_complex(ScalarField::Complex, &pieces[..1]).is_ok());
        let error = check_complex(ScalarField::Complex, &pieces).unwrap_err();
        assert!(matches!(&error, Error::AtKnot { knot: 1, .. }), "{error}");
        assert!(matches!(error.cause(), Error::NotComplex { .. }), "{error}");
        assert!(check_complex(ScalarField::Real, &pieces).is_ok());
    }
}
