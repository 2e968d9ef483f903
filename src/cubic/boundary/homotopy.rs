//! Families of boundary data that connect a problem with a known solution to the given one.
//!
//! The initial data are fixed, the end point moves along a quasi-geodesic, and the end velocity is carried with it:
//!
//! ```math
//! S_1(\lambda) = e^{\lambda X} P\, e^{\lambda\Omega},\qquad
//! V_1(\lambda) = e^{\lambda X} \bigl( (1-\lambda) W_0 + \lambda\, e^{-X} V_1 e^{-\Omega} \bigr) e^{\lambda\Omega}
//! ```

use faer::{Mat, Scale};

use super::problem::BoundaryProblem;
use crate::cubic::boundary::end_equations::Target;
use crate::cubic::taylor::initial::Horizontal;
use crate::curve::Curve;
use crate::error::Result;
use crate::manifold::QuasiGeodesic;
use crate::manifold::carrier::carried;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// Boundary data that depend on a parameter: given data at 1, data with a known solution at 0.
pub(crate) struct Homotopy {
    velocity: Horizontal,
    curve: QuasiGeodesic,
    /// End velocities at parameters 0 and 1, carried back to the start of the quasi-geodesic.
    velocities: [Mat<f64>; 2],
    tension: f64,
}

impl Homotopy {
    /// Starts at the end point and end velocity of a curve with the initial data of the problem.
    ///
    /// # Errors
    /// `DifferentComponents`, `NoJoiningCurve`, `OutsideLogDomain`.
    pub(crate) fn new(problem: &BoundaryProblem, [s, v]: [Mat<f64>; 2]) -> Result<Self> {
        let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
        let (r, k) = s1.shape();
        let mut curve = QuasiGeodesic::zeros(r, k);
        curve.join(s.as_ref(), s1, &mut EndpointProblem::new(r, k))?;
        let back = carried(&curve, v1, -1.0)?;
        Ok(Homotopy {
            velocity: problem.velocity.clone(),
            curve,
            velocities: [v, back],
            tension: problem.tension,
        })
    }

    /// The boundary data at a parameter.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(crate) fn target(&self, lambda: f64) -> Result<Target> {
        let [v0, v1] = &self.velocities;
        let v = v0 * Scale(1.0 - lambda) + v1 * Scale(lambda);
        let end = [
            self.curve.point(lambda)?,
            carried(&self.curve, v.as_ref(), lambda)?,
        ];
        Ok(Target::new(&self.velocity, &end, self.tension))
    }
}
