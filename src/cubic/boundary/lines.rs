//! Lines: points of a sphere up to their signs, so that two problems on the sphere lead to the last line.

use faer::MatRef;

use super::from_boundary::between;
use super::problem::check_data;
use super::search::{SearchOptions, all_between, ranked};
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::space::{Kind, Quotient};

/// Whether the points are lines.
pub(crate) fn are_lines([s0, ..]: [MatRef<'_, f64>; 4], options: &BoundaryOptions<'_>) -> bool {
    options.kind() == Kind::real(Quotient::Subspaces) && s0.ncols() == 1
}

/// The cheaper of the cubics on the sphere to a unit vector of the last line and to its negative.
///
/// # Errors
/// As [`RiemannianCubic::from_boundary`].
pub(crate) fn between_lines(
    data: [MatRef<'_, f64>; 4],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<RiemannianCubic> {
    let frames = of_vectors(options);
    let both = to_both_vectors(data, |data: [MatRef<'_, f64>; 4]| {
        between(data, &frames, interrupt)
    });
    let cheapest = match both? {
        [Ok(there), Ok(back)] if back.cost(interrupt)? < there.cost(interrupt)? => back,
        [Err(error), _] | [_, Err(error)] if error.is_interrupted() => return Err(error),
        [Ok(there), _] => there,
        [Err(error), back] => back.map_err(|_| error)?,
    };
    Ok(cheapest.of_lines())
}

/// All solutions on the sphere to both vectors, cheapest first.
///
/// # Errors
/// As [`RiemannianCubic::all_from_boundary`].
pub(crate) fn all_between_lines(
    data: [MatRef<'_, f64>; 4],
    options: &SearchOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<RiemannianCubic>> {
    let options = SearchOptions {
        boundary: of_vectors(&options.boundary),
        ..*options
    };
    let (mut curves, mut lost) = (Vec::new(), None);
    for found in to_both_vectors(data, |data| all_between(data, &options, interrupt))? {
        match found {
            Ok(found) => curves.extend(found),
            Err(error) if error.is_interrupted() => return Err(error),
            Err(error) => lost = Some(error),
        }
    }
    match lost {
        Some(error) if curves.is_empty() => Err(error),
        _ => ranked(
            curves.iter().map(RiemannianCubic::of_lines).collect(),
            interrupt,
        ),
    }
}

/// What solves the problem on the sphere to a unit vector of the last line, and to its negative.
fn to_both_vectors<T>(
    data: [MatRef<'_, f64>; 4],
    solve: impl Fn([MatRef<'_, f64>; 4]) -> T,
) -> Result<[T; 2]> {
    check_data(Quotient::Subspaces, data)?;
    let [s0, v0, s1, v1] = data;
    let opposite = [s1, v1].map(|x| -x);
    Ok([[s1, v1], opposite.each_ref().map(|x| x.as_ref())].map(|[s1, v1]| solve([s0, v0, s1, v1])))
}

/// The options for the sphere.
fn of_vectors<'a>(options: &BoundaryOptions<'a>) -> BoundaryOptions<'a> {
    BoundaryOptions {
        quotient: Quotient::Frames,
        ..*options
    }
}
