//! Curves through points with given velocities: pieces that are computed independently of each other.

use faer::{MatRef, Scale};

use super::bases::joined;
use super::knots;
use super::piecewise::Piecewise;
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::curve::{Curve, GeometricCubic};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::tangent::check_vector;
use crate::space::Quotient;
use crate::threads::{self, scaled};

/// Microseconds of a piece between rotations.
const PIECE: f64 = 45.0;

/// The once continuously differentiable curve of Riemannian cubics through points with given velocities.
///
/// # Arguments
/// * `t` - increasing times; `points` - one per time, shape `(n, k)`; `velocities` - tangent vectors there, per unit of
///   `t`
/// * `options` - also whether the points are frames or subspaces; the bases of a curve of subspaces start with the first
///   given one
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (times), the errors of [`RiemannianCubic::from_boundary`] wrapped in
/// `AtKnot`; `Interrupted`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt, Quotient};
/// use stiefel_rs::cubic::BoundaryOptions;
/// use stiefel_rs::spline::cubic_hermite;
/// // Lines in the plane at the angles 0, 1 and 0, at rest at each.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[-a.cos()], [-a.sin()]]);
/// let rest = mat![[0.0], [0.0]];
/// let views = points.each_ref().map(|point| point.as_ref());
/// let options = BoundaryOptions { quotient: Quotient::Subspaces, ..Default::default() };
/// let curve = cubic_hermite(&[0.0, 1.0, 3.0], &views, &[rest.as_ref(); 3], &options, Interrupt::NEVER)?;
/// assert!((curve.cost(Interrupt::NEVER)? - (12.0 + 12.0 / 8.0)).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn cubic_hermite(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Piecewise<RiemannianCubic>> {
    let quotient = options.quotient;
    let curve = pieces(quotient, t, points, velocities, |s0, v0, s1, v1| {
        RiemannianCubic::from_boundary(s0, v0, s1, v1, options, interrupt)
    })?;
    match quotient {
        Quotient::Frames => Ok(curve),
        Quotient::Subspaces => {
            let pieces = joined(quotient, None, curve.pieces().to_vec(), None)?;
            Ok(Piecewise::new(t.to_vec(), pieces))
        }
    }
}

/// The once continuously differentiable curve of adjusted de Casteljau pieces through points with given velocities.
///
/// # Arguments
/// As [`cubic_hermite`].
/// # Errors
/// As [`cubic_hermite`], with the errors of [`GeometricCubic::from_boundary`].
pub fn geometric_hermite(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
) -> Result<Piecewise<GeometricCubic>> {
    let piece = GeometricCubic::from_boundary;
    pieces(Quotient::Frames, t, points, velocities, piece)
}

/// Return an error unless there is a tangent vector at each knot.
pub(super) fn check(
    quotient: Quotient,
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
) -> Result<()> {
    knots::check(t, points)?;
    if velocities.len() != points.len() {
        return Err(Error::Shape {
            name: "V",
            expected: format!("({0}, n, k), one for each of the {0} points", points.len()),
            found: format!("({}, n, k)", velocities.len()),
        });
    }
    for (knot, (s, v)) in points.iter().zip(velocities).enumerate() {
        check_vector(quotient, "V", *s, *v).map_err(|error| error.at_knot(knot))?;
    }
    Ok(())
}

fn pieces<C: Curve + Send>(
    quotient: Quotient,
    t: &[f64],
    points: &[MatRef<'_, f64>],
    velocities: &[MatRef<'_, f64>],
    piece: impl Fn(MatRef<'_, f64>, MatRef<'_, f64>, MatRef<'_, f64>, MatRef<'_, f64>) -> Result<C>
    + Sync,
) -> Result<Piecewise<C>> {
    check(quotient, t, points, velocities)?;
    let of_leg = |(): &mut (), i: usize| {
        let h = t[i + 1] - t[i];
        let [v0, v1] = [velocities[i], velocities[i + 1]].map(|v| v * Scale(h));
        piece(points[i], v0.as_ref(), points[i + 1], v1.as_ref()).map_err(|error| placed(error, i))
    };
    let each = scaled(PIECE, points[0].shape());
    let pieces = threads::map(t.len() - 1, each, || (), of_leg)?;
    Ok(Piecewise::new(t.to_vec(), pieces))
}

/// Wraps an error of a leg in `AtKnot` with the knot that it concerns.
fn placed(error: Error, leg: usize) -> Error {
    match error {
        Error::InvalidArgument {
            name: end @ ("V0" | "V1"),
            requirement,
            found,
        } => {
            let error = Error::InvalidArgument {
                name: "V, times the duration of its piece",
                requirement,
                found,
            };
            error.at_knot(leg + usize::from(end == "V1"))
        }
        error => error.at_knot(leg),
    }
}
