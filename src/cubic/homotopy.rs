//! Families of boundary data that lead from a problem with a known solution to a given one.
//!
//! The end point goes along a quasi-geodesic, the end velocity is carried with it:
//!
//! ```math
//! \begin{aligned}
//! S_1(\lambda) &= e^{\lambda X} P\, e^{\lambda\Omega},\\
//! V_1(\lambda) &= e^{\lambda X} \bigl( (1-\lambda) W_0 + \lambda\, e^{-X} V_1 e^{-\Omega}
//!     + 4\lambda(1-\lambda)\,U_1 \bigr) e^{\lambda\Omega},\\
//! V_0(\lambda) &= (1 - \lambda)\,c\,V_0 + \lambda V_0 + 4\lambda(1-\lambda)\,U_0
//! \end{aligned}
//! ```
//!
//! Velocities `U` that are not zero lead around a place where solutions of the straight family end.

use faer::{Mat, MatRef, Scale};

use super::end_equations::Target;
use super::guess::{carry, identity_columns};
use super::initial::Horizontal;
use super::problem::Problem;
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
    /// Initial and end velocity, carried back, that are added halfway.
    detour: Option<[Horizontal; 2]>,
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

    /// From the member of the growing family at a parameter on; velocities at the start are added halfway to the initial and,
    /// carried on, to the end velocity.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn around(&self, share: f64, detour: [Horizontal; 2]) -> Result<Self> {
        let (from, [_, v1]) = (self.curve.point(share)?, &self.velocities);
        let carried = carry(&self.curve, (v1 * Scale(share)).as_ref(), share)?;
        let curve = QuasiGeodesic::from_velocity(
            from.as_ref(),
            (self.curve.derivative(share, 1)? * Scale(1.0 - share)).as_ref(),
        )?;
        Ok(Homotopy {
            velocity: self.velocity.clone(),
            initial_share: share,
            velocities: [carried, carry(&self.curve, v1.as_ref(), share)?],
            curve,
            detour: Some(detour),
        })
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
            detour: None,
        })
    }

    /// Parameters that are worth following.
    ///
    /// A curve of solutions of the growing family that comes back to the data of a standing curve gets lost there: those data
    /// are symmetric, and other solutions with them come in families.
    pub(super) fn range(&self) -> std::ops::Range<f64> {
        if self.initial_share == 0.0 {
            0.02..2.5
        } else {
            -1.5..2.5
        }
    }

    /// The boundary data at a parameter.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn target(&self, lambda: f64) -> Result<Target> {
        let share = lambda + (1.0 - lambda) * self.initial_share;
        let bend = 4.0 * lambda * (1.0 - lambda);
        let mut velocity = Horizontal {
            omega: &self.velocity.omega * Scale(share),
            normal: &self.velocity.normal * Scale(share),
        };
        let [v0, v1] = &self.velocities;
        let mut v = v0 * Scale(1.0 - lambda) + v1 * Scale(lambda);
        if let Some([first, last]) = &self.detour {
            let k = v.ncols();
            velocity.omega += &first.omega * Scale(bend);
            velocity.normal += &first.normal * Scale(bend);
            let mut upper = v.as_mut().subrows_mut(0, k);
            upper += &last.omega * Scale(bend);
            let (m, _) = last.normal.shape();
            let mut lower = v.as_mut().subrows_mut(k, m);
            lower += &last.normal * Scale(bend);
        }
        let end = [
            self.curve.point(lambda)?,
            carry(&self.curve, v.as_ref(), lambda)?,
        ];
        Ok(Target::new(&velocity, &end))
    }
}
