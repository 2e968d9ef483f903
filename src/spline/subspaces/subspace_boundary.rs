//! Riemannian cubics of subspaces from boundary data.

use faer::MatRef;

use super::subspace_problem::{SubspaceData, SubspaceProblem, check};
use crate::cubic::{BoundaryOptions, RiemannianCubic};
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

impl RiemannianCubic {
    /// The Riemannian cubic on the Grassmann manifold from the span of `y0` to the span of `y1`, with given velocities,
    /// on `[0, 1]`.
    ///
    /// The curve starts with the basis `y0`, and its bases rotate as little as possible; it ends with a basis `Y1 Q` of
    /// the last subspace and the velocity `V1 Q`, for some orthogonal `Q`.
    ///
    /// # Arguments
    /// * `y0`, `y1` - arbitrary orthonormal bases of the subspaces, shape `(n, k)`; `v0`, `v1` - horizontal vectors at
    ///   them, `Y^T V = 0`
    /// * `options` - a guess must be horizontal at `y0`
    /// # Accuracy
    /// The end conditions are satisfied to `options.tolerance`. Of subspaces more than 1.4 apart, the cheapest of the cubics
    /// found from several starts is returned. Nearer ones may have cheaper ones too, if speeds are above 1: of 60 problems on
    /// Gr(4,2) at distance 0.8, [`all_between_subspaces`](Self::all_between_subspaces) finds a cheaper one in 1 at speeds of 1,
    /// in 4 at 1.3 and in 9 at 1.5. For lines, it is the cheaper of the two cubics on the sphere that end in opposite
    /// vectors. With a guess, it is the solution that Newton's method finds from the guess; if it finds none, the solution
    /// without a guess.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `InvalidArgument` (options); `RightAngle` if a
    /// principal angle between the subspaces is pi/2; `NoConvergence`, `Interrupted`.
    ///
    /// # Examples
    /// ```
    /// use faer::mat;
    /// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
    /// use stiefel_rs::{Curve, Interrupt};
    /// // From rest to rest between two lines in the plane, whichever way their bases point.
    /// let (y0, rest) = (mat![[1.0], [0.0]], mat![[0.0], [0.0]]);
    /// let y1 = mat![[-1.0_f64.cos()], [-1.0_f64.sin()]];
    /// let [y0, y1, rest] = [&y0, &y1, &rest].map(|a| a.as_ref());
    /// let curve =
    ///     RiemannianCubic::between_subspaces(y0, rest, y1, rest, &BoundaryOptions::default(), Interrupt::NEVER)?;
    /// assert!((curve.point(1.0)? + y1).norm_l2() < 1e-12);
    /// assert!((curve.cost(Interrupt::NEVER)? - 12.0).abs() < 1e-10);
    /// # Ok::<(), stiefel_rs::Error>(())
    /// ```
    pub fn between_subspaces(
        y0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        y1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        options.check()?;
        let data = [y0, v0, y1, v1];
        let Some(guess) = options.guess else {
            if y0.ncols() == 1 {
                return between_lines(data, options, interrupt);
            }
            let problem = SubspaceProblem::new(data, options, interrupt)?;
            return problem.curve(&problem.solve()?);
        };
        let problem = match SubspaceProblem::new(data, options, interrupt) {
            // Between these lines no geodesic is the unique shortest one, but on the sphere it exists.
            Err(Error::RightAngle { .. }) if y0.ncols() == 1 => {
                return between_lines(data, options, interrupt);
            }
            problem => problem?,
        };
        problem.curve(&problem.near(guess)?)
    }
}

/// The cheaper of the cubics on the sphere to a unit vector of the last line and to its negative.
fn between_lines(
    data: SubspaceData<'_>,
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<RiemannianCubic> {
    check(data)?;
    let [y0, v0, y1, v1] = data;
    let opposite = [y1, v1].map(|x| -x);
    let [there, back] = [[y1, v1], opposite.each_ref().map(|x| x.as_ref())]
        .map(|[y1, v1]| RiemannianCubic::between_frames([y0, v0, y1, v1], options, interrupt));
    let cheapest = match (there, back) {
        (Ok(there), Ok(back)) if back.cost(interrupt)? < there.cost(interrupt)? => back,
        (Err(error), _) | (_, Err(error)) if error.is_interrupted() => return Err(error),
        (Ok(there), _) => there,
        (Err(error), back) => back.map_err(|_| error)?,
    };
    Ok(cheapest.of_lines())
}
