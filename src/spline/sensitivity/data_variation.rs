//! Variations of the data of a spline, and gradients with respect to them.

use faer::{Mat, MatRef, Scale};

use super::given::GivenEnd;
use super::knot_states::KnotStates;
use crate::cubic::turning::check_variation;
use crate::error::{Error, Result};
use crate::linalg::structure::norm;
use crate::manifold::stiefel::TANGENT_TOLERANCE;

/// A variation of the data of a spline: derivatives of points, times and end conditions along a family of data.
///
/// Along such a family the points stay on the manifold, and the vectors at the ends stay tangent, so
///
/// ```math
/// S^T dS + dS^T S = 0,\qquad S^T dV + dV^T S + dS^T V + V^T dS = 0
/// ```
///
/// # Examples
/// ```
/// use faer::{Mat, MatRef, mat};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, SplineVariation, cubic_spline};
/// use stiefel_rs::{Curve, Interrupt};
/// // On the circle, through the angles 0, 1 and 0 at the times 0, 1 and 2: the top moves on.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let views: Vec<MatRef<'_, f64>> = points.iter().map(|point| point.as_ref()).collect();
/// let ends = EndConditions::Natural;
/// let (curve, _) = cubic_spline(&[0.0, 1.0, 2.0], &views, &ends, &SplineOptions::default(), Interrupt::NEVER)?;
/// let (rest, onwards) = (mat![[0.0], [0.0]], mat![[-1.0_f64.sin()], [1.0_f64.cos()]]);
/// let points = [rest.as_ref(), onwards.as_ref(), rest.as_ref()];
/// let variation = SplineVariation { points: &points, times: &[], ends: [None, None] };
/// let derivative = curve.data_derivative(&ends, Interrupt::NEVER)?;
/// // The spline of flat space through 0, 1, 0 is 11/16 at 1/2.
/// let found = &derivative.points(&variation, &[0.5], Interrupt::NEVER)?[0];
/// assert!((found.norm_l2() - 11.0 / 16.0).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct SplineVariation<'a> {
    /// Variations of the points, one per knot, shape `(n, k)`. At the two ends of a periodic spline they are equal. For
    /// subspaces they are horizontal at the curve's bases at the knots; at the last knot of a periodic spline it is the
    /// first variation times the holonomy `Y(t_0)^T Y(t_N)`.
    pub points: &'a [MatRef<'a, f64>],
    /// Variations of the times, one per knot; empty if the times are fixed.
    pub times: &'a [f64],
    /// Variations of the velocity or acceleration given at the first and at the last knot, shape `(n, k)`; `None` if
    /// none is given. Zero for a vector that stays zero.
    pub ends: [Option<MatRef<'a, f64>>; 2],
}

/// Gradient of a function of a spline with respect to the data: the function changes by the sum of entrywise products
/// with every [variation](SplineVariation).
///
/// # Examples
/// ```
/// use faer::{MatRef, mat};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
/// use stiefel_rs::{Curve, Interrupt};
/// // On the circle, through the angles 0, a and 0 at the times 0, 1 and 2: the cost is 6 a^2.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let views: Vec<MatRef<'_, f64>> = points.iter().map(|point| point.as_ref()).collect();
/// let ends = EndConditions::Natural;
/// let (curve, _) = cubic_spline(&[0.0, 1.0, 2.0], &views, &ends, &SplineOptions::default(), Interrupt::NEVER)?;
/// let gradient = curve.cost_gradient(&ends, Interrupt::NEVER)?;
/// let slope = gradient.points[1].transpose() * mat![[-1.0_f64.sin()], [1.0_f64.cos()]];
/// assert!((slope[(0, 0)] - 12.0).abs() < 1e-10);
/// // Twice the time: an eighth of the cost.
/// let slower: f64 = gradient.times.iter().zip([0.0, 1.0, 2.0]).map(|(g, t)| g * t).sum();
/// assert!((slower + 3.0 * 6.0).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SplineGradient {
    /// With respect to the points, shape `(n, k)` each. At the ends of a periodic spline the two contributions must be
    /// added; for subspaces, first express the last one in the first basis by the transpose of the holonomy `Y(t_0)^T
    /// Y(t_N)`.
    pub points: Vec<Mat<f64>>,
    /// With respect to the times.
    pub times: Vec<f64>,
    /// With respect to the velocity or acceleration given at the first and at the last knot.
    pub ends: [Option<Mat<f64>>; 2],
}

/// Names of the variations of points and of the end conditions, for errors.
const POINTS: &str = "dS";
const TIMES: &str = "dt";
const ENDS: &str = "dbc";

/// Checks a variation; vectors of `states` are in units of the mean leg.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`, `InvalidArgument` (ends of a periodic spline that move apart); wrapped in
/// `AtKnot` if they concern one knot.
pub(crate) fn check(
    states: &KnotStates,
    given: [GivenEnd; 2],
    variation: &SplineVariation<'_>,
) -> Result<()> {
    let count = states.count();
    let sizes = [
        (POINTS, "a matrix", variation.points.len()),
        (TIMES, "one", variation.times.len()),
    ];
    for (name, what, found) in sizes {
        if found != count && !(name == TIMES && found == 0) {
            return Err(Error::Shape {
                name,
                expected: format!("{what} for each of {count} knots"),
                found: found.to_string(),
            });
        }
    }
    if let Some(index) = variation.times.iter().position(|t| !t.is_finite()) {
        return Err(Error::NonFinite { name: TIMES, index });
    }
    for knot in 0..count {
        check_knot(states, given, variation, knot).map_err(|error| error.at_knot(knot))?;
    }
    if given[0] == GivenEnd::OtherEnd {
        check_closed(variation, states.holonomy(given)?.as_ref())?;
    }
    Ok(())
}

fn check_closed(variation: &SplineVariation<'_>, holonomy: Option<&Mat<f64>>) -> Result<()> {
    let end = variation.points.len() - 1;
    let [first, last] = [0, end].map(|knot| variation.points[knot]);
    let gap = match holonomy {
        Some(holonomy) => norm((first * holonomy - last).as_ref()),
        None => norm((first - last).as_ref()),
    };
    if gap <= TANGENT_TOLERANCE * (1.0 + norm(first)) {
        return Ok(());
    }
    let error = Error::InvalidArgument {
        name: POINTS,
        requirement: "at the last knot at distance 0 from its value at the first (periodic ends; for subspaces multiplied by \
                      Y(t_0)^T Y(t_N) of the curve)",
        found: gap,
    };
    Err(error.at_knot(end))
}

fn check_knot(
    states: &KnotStates,
    given: [GivenEnd; 2],
    variation: &SplineVariation<'_>,
    knot: usize,
) -> Result<()> {
    let end = [0, states.count() - 1]
        .into_iter()
        .position(|end| end == knot);
    let vector = match end.map(|end| (given[end].order(), variation.ends[end])) {
        None | Some((None, None)) => None,
        Some((Some(order), Some(change))) => {
            // In the time of the mean leg, in which round-off of a vector that vanishes is small.
            let unit = Scale(states.unit);
            let faster = (0..order).fold(change.to_owned(), |change, _| change * unit);
            Some((states.matrix(&states.at(knot)[order]), faster))
        }
        Some((order, _)) => {
            let (expected, found) = match order {
                Some(_) => ("a matrix: a vector is given at this end", "none"),
                None => ("none: no vector is given at this end", "a matrix"),
            };
            return Err(Error::Shape {
                name: ENDS,
                expected: expected.to_owned(),
                found: found.to_owned(),
            });
        }
    };
    let vector = vector
        .as_ref()
        .map(|(y, dy)| (ENDS, y.as_ref(), dy.as_ref()));
    let point = (POINTS, states.point(knot), variation.points[knot]);
    check_variation(states.quotient, point, vector.as_slice())
}
