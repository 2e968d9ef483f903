//! Riemannian cubics of subspaces from boundary data: splines of one leg.

use faer::MatRef;

use super::ends::{EndCondition, EndConditions};
use super::options::{MAX_ITERATIONS, SplineOptions};
use super::riemannian::cubic_spline;
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::manifold::Grassmann;
use crate::manifold::stiefel::TANGENT_TOLERANCE;
use crate::space::Quotient;

impl RiemannianCubic {
    /// The Riemannian cubic on the Grassmann manifold from the span of `y0` to that of `y1`, with given velocities, on `[0, 1]`.
    ///
    /// The curve starts with the basis `y0`, and its bases turn as little as possible; it ends with a basis `Y1 Q` of the last
    /// subspace, and with the velocity `V1 Q`, for an orthogonal `Q`.
    ///
    /// # Arguments
    /// * `y0`, `y1` - orthonormal bases, shape `(n, k)`, any of their subspaces; `v0`, `v1` - horizontal vectors at them,
    ///   `Y^T V = 0`
    /// * `options` - of the guess only with lines, `k = 1`
    /// # Accuracy
    /// The end is met to `options.tolerance`. Subspaces more than 1.4 apart have more than one cubic, and the cheapest of those that
    /// several starts lead to is returned; of lines, the cheaper one of the two on the sphere that end in opposite vectors.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `InvalidArgument` (options); `RightAngle` where a principal angle
    /// between the subspaces is pi/2; `NoConvergence`, `Interrupted`.
    ///
    /// # Examples
    /// ```
    /// use faer::mat;
    /// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
    /// use stiefel_rs::Curve;
    /// // From rest to rest between two lines in the plane, whichever way their bases point.
    /// let (y0, rest) = (mat![[1.0], [0.0]], mat![[0.0], [0.0]]);
    /// let y1 = mat![[-1.0_f64.cos()], [-1.0_f64.sin()]];
    /// let [y0, y1, rest] = [&y0, &y1, &rest].map(|a| a.as_ref());
    /// let curve = RiemannianCubic::between_subspaces(y0, rest, y1, rest, &BoundaryOptions::default())?;
    /// assert!((curve.point(1.0)? + y1).norm_l2() < 1e-12);
    /// assert!((curve.cost()? - 12.0).abs() < 1e-10);
    /// # Ok::<(), stiefel_rs::Error>(())
    /// ```
    pub fn between_subspaces(
        y0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        y1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
    ) -> Result<Self> {
        options.check()?;
        if y0.ncols() == 1 {
            return between_lines([y0, v0, y1, v1], options);
        }
        let velocity = |v: MatRef<'_, f64>| EndCondition::Velocity(v.to_owned());
        let ends = EndConditions::Each(Box::new([velocity(v0), velocity(v1)]));
        let defaults = BoundaryOptions::default().max_iterations;
        let spline = SplineOptions {
            tolerance: options.tolerance,
            max_iterations: (options.max_iterations * MAX_ITERATIONS).div_ceil(defaults),
            tension: options.tension,
            quotient: Quotient::Subspaces,
            field: options.field,
            interrupt: options.interrupt,
        };
        let solved = cubic_spline(&[0.0, 1.0], &[y0, y1], &ends, &spline);
        let (curve, report) = solved.map_err(of_ends)?;
        Ok(curve.pieces()[0].clone().with_report(report))
    }
}

/// The cheaper of the cubics on the sphere to a vector of the last line and to the opposite one.
fn between_lines(
    data: [MatRef<'_, f64>; 4],
    options: &BoundaryOptions<'_>,
) -> Result<RiemannianCubic> {
    let [y0, v0, y1, v1] = data;
    for (name, y, v) in [("V0", y0, v0), ("V1", y1, v1)] {
        Grassmann::of("S", y)?.check_tangent(name, y, v, TANGENT_TOLERANCE)?;
    }
    let opposite = [y1, v1].map(|x| -x);
    let [there, back] = [[y1, v1], opposite.each_ref().map(|x| x.as_ref())]
        .map(|[y1, v1]| RiemannianCubic::from_boundary(y0, v0, y1, v1, options));
    let cheapest = match (there, back) {
        (Ok(there), Ok(back)) if back.cost()? < there.cost()? => back,
        (Ok(there), _) => there,
        (Err(error), _) if error.is_interrupted() => return Err(error),
        (Err(error), back) => back.map_err(|_| error)?,
    };
    Ok(cheapest.of_lines())
}

/// An error of a spline of one leg as one of its ends.
fn of_ends(error: Error) -> Error {
    let Error::AtKnot { knot, source } = error else {
        return error;
    };
    let names = [["S0", "V0"], ["S1", "V1"]][knot.min(1)];
    match *source {
        Error::NotOrthonormal {
            defect, tolerance, ..
        } => Error::NotOrthonormal {
            name: names[0],
            defect,
            tolerance,
        },
        Error::NotHorizontal {
            defect, tolerance, ..
        } => Error::NotHorizontal {
            name: names[1],
            defect,
            tolerance,
        },
        Error::NonFinite { name, index } => Error::NonFinite {
            name: names[usize::from(name != "S")],
            index,
        },
        Error::Shape {
            name,
            expected,
            found,
        } => Error::Shape {
            name: names[usize::from(name != "S")],
            expected,
            found,
        },
        other => other,
    }
}
