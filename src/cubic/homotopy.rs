//! Families of boundary data that lead from a problem with a known solution to a given one.
//!
//! The end point goes along a quasi-geodesic, the end velocity is carried with it:
//!
//! ```math
//! S_1(\lambda) = e^{\lambda X} P\, e^{\lambda\Omega},\qquad
//! V_1(\lambda) = e^{\lambda X} \bigl( (1-\lambda) W_0 + \lambda\, e^{-X} V_1 e^{-\Omega} \bigr) e^{\lambda\Omega},\qquad
//! V_0(\lambda) = (1 - \lambda)\,c\,V_0 + \lambda V_0
//! ```

use faer::{Mat, MatRef, Scale};

use super::guess::{carry, identity_columns};
use super::initial::Horizontal;
use super::problem::Problem;
use super::shooting::Target;
use crate::curve::Curve;
use crate::error::Result;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// Boundary data that depend on a parameter; those at 1 are given, those at 0 have a known solution.
pub(super) struct Homotopy {
    velocity: Horizontal,
    /// Share of the initial velocity at parameter 0.
    initial_share: f64,
    curve: QuasiGeodesic,
    /// End velocities at parameters 0 and 1, carried back to the start of the curve.
    velocities: [Mat<f64>; 2],
}

impl Homotopy {
    /// From the curve that stands still: displacement and both velocities grow from zero.
    ///
    /// # Errors
    /// `DifferentComponents`, `NoJoiningCurve`, `OutsideLogDomain`.
    pub(super) fn growing(problem: &Problem) -> Result<Self> {
        let (r, k) = problem.end[0].shape();
        let start = identity_columns(r, k);
        Self::new(problem, 0.0, start.as_ref(), Mat::zeros(r, k))
    }

    /// From a curve with the right start and the given end.
    ///
    /// # Errors
    /// `DifferentComponents`, `NoJoiningCurve`, `OutsideLogDomain`.
    pub(super) fn moving(problem: &Problem, [s, v]: [Mat<f64>; 2]) -> Result<Self> {
        Self::new(problem, 1.0, s.as_ref(), v)
    }

    fn new(
        problem: &Problem,
        initial_share: f64,
        from: MatRef<'_, f64>,
        v: Mat<f64>,
    ) -> Result<Self> {
        let [s1, v1] = &problem.end;
        let (r, k) = s1.shape();
        let mut curve = QuasiGeodesic::zeros(r, k);
        curve.join(from, s1.as_ref(), &mut EndpointProblem::new(r, k))?;
        let back = carry(&curve, v1.as_ref(), -1.0)?;
        Ok(Homotopy {
            velocity: problem.velocity.clone(),
            initial_share,
            curve,
            velocities: [v, back],
        })
    }

    /// The boundary data at a parameter.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn target(&self, lambda: f64) -> Result<Target> {
        let share = Scale(lambda + (1.0 - lambda) * self.initial_share);
        let velocity = Horizontal {
            omega: &self.velocity.omega * share,
            normal: &self.velocity.normal * share,
        };
        let [v0, v1] = &self.velocities;
        let v = v0 * Scale(1.0 - lambda) + v1 * Scale(lambda);
        let end = [
            self.curve.point(lambda)?,
            carry(&self.curve, v.as_ref(), lambda)?,
        ];
        Ok(Target::new(&velocity, &end))
    }
}
