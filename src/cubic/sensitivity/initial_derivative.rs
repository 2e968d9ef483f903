//! Derivatives of a Riemannian cubic with respect to its initial data, forward and transposed. No equations are solved.

use faer::{Mat, MatRef, Scale};

use super::linear_flow::{LinearFlow, VARIATION, check_cotangents};
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::cubic::turning::{bracket_of, by_data, check_variation, turned};
use crate::curve::Curve;
use crate::curve::sampling::check_parameter;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::check_range;

/// Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start, shape `(n, k)` each.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, BoundaryVariation, RiemannianCubic};
/// use stiefel_rs::Interrupt;
/// // From rest to rest along a circle: acceleration 6 angle, jerk -12 angle at the start.
/// let (sin, cos) = 1.0_f64.sin_cos();
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[cos], [sin]], mat![[0.0], [0.0]]);
/// let (s0, s1, rest) = (s0.as_ref(), s1.as_ref(), rest.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// let onwards = mat![[-sin], [cos]];
/// let variation = BoundaryVariation { s0: rest, v0: rest, s1: onwards.as_ref(), v1: rest };
/// let initial = curve.boundary_derivative(Interrupt::NEVER)?.initial(&variation, Interrupt::NEVER)?;
/// assert!((initial.acceleration - mat![[0.0], [6.0]]).norm_l2() < 1e-11);
/// assert!((initial.jerk - mat![[0.0], [-12.0]]).norm_l2() < 1e-11);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct InitialVariation {
    /// Variation of the point, as given.
    pub point: Mat<f64>,
    /// Variation of the velocity, as given.
    pub velocity: Mat<f64>,
    /// Variation of the covariant acceleration.
    pub acceleration: Mat<f64>,
    /// Variation of the covariant jerk.
    pub jerk: Mat<f64>,
}

/// Gradient of a function of a cubic with respect to its initial data, as ambient matrices of shape `(n, k)`: the function
/// changes by `sum tr(G^T d)` for every [variation](InitialVariation) along a family of data.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic};
/// use stiefel_rs::Interrupt;
/// // On the circle the angle is t + t^2 / 2 + t^3 / 6 by velocity, acceleration and jerk 1.
/// let (s, v) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
/// let (s, v) = (s.as_ref(), v.as_ref());
/// let curve = RiemannianCubic::from_initial(s, v, v, v, &IntegrationOptions::default(), Interrupt::NEVER)?;
/// let angle = 1.0_f64 + 0.5 + 1.0 / 6.0;
/// let along = mat![[-angle.sin()], [angle.cos()]];
/// let gradient = curve.initial_pull_back(&[1.0], &[along.as_ref()], Interrupt::NEVER)?;
/// assert!((gradient.velocity[(1, 0)] - 1.0).abs() < 1e-12);
/// assert!((gradient.jerk[(1, 0)] - 1.0 / 6.0).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct InitialGradient {
    /// With respect to the point.
    pub point: Mat<f64>,
    /// With respect to the velocity.
    pub velocity: Mat<f64>,
    /// With respect to the covariant acceleration.
    pub acceleration: Mat<f64>,
    /// With respect to the covariant jerk.
    pub jerk: Mat<f64>,
}

impl RiemannianCubic {
    /// The variations of the points of the curve at several times, shape `(n, k)` each, for a variation of point,
    /// velocity, covariant acceleration and covariant jerk at the start of [`t_span`](Curve::t_span).
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent` (the variation breaks a constraint); `TooManySteps`, `Overflow`, `Interrupted`.
    pub fn initial_points(
        &self,
        variation: &InitialVariation,
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        for &t in times {
            check_parameter(t)?;
        }
        let state = self.state(self.t_span().0)?;
        let [s, v, a, j] = state.each_ref().map(|x| x.as_ref());
        let p = variation.point.as_ref();
        let vectors = [
            ("dV", v, variation.velocity.as_ref()),
            ("dA", a, variation.acceleration.as_ref()),
            ("dJ", j, variation.jerk.as_ref()),
        ];
        check_variation(self.quotient(), ("dS", s, p), &vectors)?;
        let beside = |dy: &Mat<f64>, y| dy - turned(s, p, y);
        let [dw, da] = [
            beside(&variation.velocity, v),
            beside(&variation.acceleration, a),
        ];
        let second = beside(&variation.jerk, j)
            - (self.bracket(s, dw.as_ref(), a) + self.bracket(s, v, da.as_ref())) * Scale(0.5);
        let start = [p.to_owned(), dw, da, second];
        let flow = LinearFlow::new([s, v, a, j], self.tension(), self.quotient())?;
        flow.points(&start, &self.after(times), interrupt)
    }

    /// The gradient of `sum tr(W^T S(t))`, over cotangents `W` at given times `t`, with respect to point, velocity,
    /// covariant acceleration and covariant jerk at the start of [`t_span`](Curve::t_span).
    ///
    /// This is the transpose of [`RiemannianCubic::initial_points`]; it takes one integration back to the start for any
    /// number of times.
    ///
    /// # Arguments
    /// * `cotangents` - one per time, shape `(n, k)`, any matrices; named `W` in errors
    /// # Errors
    /// `Shape`, `NonFinite`; `TooManySteps`, `Overflow`, `Interrupted`.
    pub fn initial_pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<InitialGradient> {
        let state = self.state(self.t_span().0)?;
        let [s, v, a, j] = state.each_ref().map(|x| x.as_ref());
        check_cotangents(s, times, cotangents)?;
        let flow = LinearFlow::new([s, v, a, j], self.tension(), self.quotient())?;
        let eta = flow.collected(&self.after(times), cotangents, interrupt)?;
        let [by_p, mut by_w, mut by_a, by_b] = flow.gradient(&eta);
        by_w -= self.bracket(s, a, by_b.as_ref()) * Scale(0.5);
        by_a -= self.bracket(s, by_b.as_ref(), v) * Scale(0.5);
        let zero = Mat::zeros(s.nrows(), s.ncols());
        let [mut point, velocity] = by_data(s, [by_p.as_ref(), by_w.as_ref()], v);
        let [acceleration, jerk] = [(by_a, a), (by_b, j)].map(|(bar, y)| {
            let [by_point, by_vector] = by_data(s, [zero.as_ref(), bar.as_ref()], y);
            point += by_point;
            by_vector
        });
        for gradient in [&point, &velocity, &acceleration, &jerk] {
            check_range(VARIATION, gradient.as_ref())?;
        }
        Ok(InitialGradient {
            point,
            velocity,
            acceleration,
            jerk,
        })
    }

    fn bracket(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
        bracket_of(self.quotient(), s, v, w)
    }

    /// Times relative to the start.
    fn after(&self, times: &[f64]) -> Vec<f64> {
        let start = self.t_span().0;
        times.iter().map(|t| t - start).collect()
    }
}
