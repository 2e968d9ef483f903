//! Knots: increasing times, with a point at each.

use faer::MatRef;

use crate::error::{Error, Result};
use crate::manifold::Stiefel;
use crate::manifold::stiefel::POINT_TOLERANCE;

/// Check knots; return the manifold of the points.
///
/// # Errors
/// `Shape` (fewer than two knots, numbers that do not match, points of different shapes), `NonFinite`,
/// `InvalidArgument` (times not increasing), `NotOrthonormal`; wrapped in `AtKnot` if they concern one knot.
pub(super) fn check(t: &[f64], points: &[MatRef<'_, f64>]) -> Result<Stiefel> {
    check_times(t, points.len())?;
    check_points(points)
}

/// Check the times of a number of points.
///
/// # Errors
/// As [`check`].
pub(crate) fn check_times(t: &[f64], points: usize) -> Result<()> {
    let requirement = "greater than the time before it";
    check_in_order(t, points, |step| step > 0.0, requirement)
}

/// As [`check`], for times that may repeat but are not all equal.
///
/// # Errors
/// As [`check`].
pub(super) fn check_data(t: &[f64], points: &[MatRef<'_, f64>]) -> Result<Stiefel> {
    let requirement = "at least the time before it";
    check_in_order(t, points.len(), |step| step >= 0.0, requirement)?;
    let manifold = check_points(points)?;
    if t[0] == t[t.len() - 1] {
        return Err(wrong_time(t, t.len() - 1, "different from the first time"));
    }
    Ok(manifold)
}

fn check_in_order(
    t: &[f64],
    points: usize,
    allowed: impl Fn(f64) -> bool,
    requirement: &'static str,
) -> Result<()> {
    if t.len() != points {
        return Err(Error::Shape {
            name: "t",
            expected: format!("({points},), one time for each of the {points} points"),
            found: format!("({},)", t.len()),
        });
    }
    if t.len() < 2 {
        return Err(Error::Shape {
            name: "t",
            expected: "(N,) with N >= 2, one time for each point".to_owned(),
            found: format!("({},)", t.len()),
        });
    }
    if let Some(index) = t.iter().position(|t| !t.is_finite()) {
        return Err(Error::NonFinite { name: "t", index }.at_knot(index));
    }
    let last = t.len() - 1;
    if !(t[last] - t[0]).is_finite() {
        return Err(wrong_time(
            t,
            last,
            "less than 1.797e308 after the first time",
        ));
    }
    for (knot, pair) in t.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        if !(allowed(step) && step.is_finite()) {
            return Err(wrong_time(t, knot + 1, requirement));
        }
    }
    Ok(())
}

fn check_points(points: &[MatRef<'_, f64>]) -> Result<Stiefel> {
    let manifold = Stiefel::of("S", points[0])?;
    for (knot, point) in points.iter().enumerate() {
        manifold
            .check_point("S", *point, POINT_TOLERANCE)
            .map_err(|error| error.at_knot(knot))?;
    }
    Ok(manifold)
}

fn wrong_time(t: &[f64], knot: usize, requirement: &'static str) -> Error {
    let error = Error::InvalidArgument {
        name: "t",
        requirement,
        found: t[knot],
    };
    error.at_knot(knot)
}

/// Check that a tolerance is achievable and meaningful.
///
/// # Errors
/// `InvalidArgument`.
pub(super) fn check_tolerance(found: f64) -> Result<()> {
    if (1e-15..=0.1).contains(&found) {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "tolerance",
        requirement: "between 1e-15 and 0.1",
        found,
    })
}
