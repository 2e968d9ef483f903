//! Lines: points of a sphere up to their signs, so that two problems on the sphere lead to the last line.

use faer::MatRef;

use super::problem::check_data;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::error::Result;
use crate::space::{Kind, Quotient};

/// Whether the points are lines.
pub(crate) fn are_lines([s0, ..]: [MatRef<'_, f64>; 4], options: &BoundaryOptions<'_>) -> bool {
    options.kind() == Kind::real(Quotient::Subspaces) && s0.ncols() == 1
}

/// The options for the sphere.
pub(crate) fn of_vectors<'a>(options: &BoundaryOptions<'a>) -> BoundaryOptions<'a> {
    BoundaryOptions {
        quotient: Quotient::Frames,
        ..*options
    }
}

/// What solves the problem on the sphere to a unit vector of the last line, and to its negative.
///
/// # Errors
/// The errors of [`check_data`].
pub(crate) fn to_both_vectors<T>(
    data: [MatRef<'_, f64>; 4],
    solve: impl Fn([MatRef<'_, f64>; 4]) -> T,
) -> Result<[T; 2]> {
    check_data(Quotient::Subspaces, data)?;
    let [s0, v0, s1, v1] = data;
    let opposite = [s1, v1].map(|x| -x);
    Ok([[s1, v1], opposite.each_ref().map(|x| x.as_ref())].map(|[s1, v1]| solve([s0, v0, s1, v1])))
}
