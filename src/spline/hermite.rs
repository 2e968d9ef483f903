//! Curves through points with given velocities: pieces that are made independently of each other.

use faer::{MatRef, Scale};
use rayon::prelude::*;

use super::knots;
use super::piecewise::Piecewise;
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::curve::GeometricCubic;
use crate::error::{Error, Result};
use crate::manifold::stiefel::TANGENT_TOLERANCE;

/// The curve of Riemannian cubics through points with given velocities, once continuously differentiable.
///
/// # Arguments
/// * `t` - times, increasing; `points` - one at each, shape `(n, k)`; `velocities` - tangent vectors there, per unit of `t`
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (times), and in `AtKnot` those of [`RiemannianCubic::from_boundary`]; `Interrupted`.
pub fn cubic_hermite(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
    options: &BoundaryOptions<'_>,
) -> Result<Piecewise<RiemannianCubic>> {
    pieces(t, points, velocities, |s0, v0, s1, v1| {
        RiemannianCubic::from_boundary(s0, v0, s1, v1, options)
    })
}

/// The curve of adjusted de Casteljau pieces through points with given velocities, once continuously differentiable.
///
/// # Arguments
/// As [`cubic_hermite`].
/// # Errors
/// As [`cubic_hermite`], with those of [`GeometricCubic::from_boundary`].
pub fn geometric_hermite(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
) -> Result<Piecewise<GeometricCubic>> {
    pieces(t, points, velocities, GeometricCubic::from_boundary)
}

fn pieces<C: crate::curve::Curve + Send>(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
    piece: impl Fn(MatRef<'_, f64>, MatRef<'_, f64>, MatRef<'_, f64>, MatRef<'_, f64>) -> Result<C>
    + Sync,
) -> Result<Piecewise<C>> {
    let manifold = knots::check(t, points)?;
    if velocities.len() != points.len() {
        return Err(Error::Shape {
            name: "V",
            expected: format!("one for each of the {} points", points.len()),
            found: format!("{} velocities", velocities.len()),
        });
    }
    for (knot, (s, v)) in points.iter().zip(velocities).enumerate() {
        manifold
            .check_tangent("V", *s, *v, TANGENT_TOLERANCE)
            .map_err(|error| error.at_knot(knot))?;
    }
    let pieces = (0..t.len() - 1)
        .into_par_iter()
        .map(|i| {
            let h = t[i + 1] - t[i];
            let [v0, v1] = [velocities[i], velocities[i + 1]].map(|v| v * Scale(h));
            piece(points[i], v0.as_ref(), points[i + 1], v1.as_ref())
                .map_err(|error| placed(error, i))
        })
        .collect::<Vec<Result<C>>>();
    // The error is that of the first leg that has one, on any number of threads.
    let pieces = pieces.into_iter().collect::<Result<_>>()?;
    Ok(Piecewise::new(t.to_vec(), pieces))
}

/// An error of a leg at the knot that it is about.
fn placed(error: Error, leg: usize) -> Error {
    match error {
        Error::InvalidArgument {
            name: end @ ("V0" | "V1"),
            requirement,
            found,
        } => {
            let error = Error::InvalidArgument {
                name: "V, times the length of its leg",
                requirement,
                found,
            };
            error.at_knot(leg + usize::from(end == "V1"))
        }
        error => error.at_knot(leg),
    }
}
