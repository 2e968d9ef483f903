//! Derivatives of the solution of a boundary value problem with respect to its data, by the implicit function theorem.
//!
//! In a time in which the curve takes one unit, variations `dS` and `dV` of the data displace the ends by `u = dS` and
//! change the velocities there by `w = dV - A(u) V`, relative to the rotation that displaces the end. The [linearised
//! cubic](super::linear_cubic) maps these to the accelerations at the ends and to points in between; its transpose
//! yields gradients.

use faer::{Mat, MatRef, Scale};

use super::initial_derivative::InitialVariation;
use super::linear_cubic::LinearCubic;
use super::linear_flow::{VARIATION, check_cotangents};
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::cubic::turning::{bracket_of, by_data, check_variation, turned};
use crate::curve::sampling::check_parameter;
use crate::curve::{Curve, Quantity};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::{check_range, dot};
use crate::space::Quotient;

/// A variation of boundary data: ambient derivatives of `S0, V0, S1, V1` along a family of data, all of shape `(n, k)`.
///
/// Along such a family `S^T S = I` and `S^T V + V^T S = 0` are preserved, so
///
/// ```math
/// S^T dS + dS^T S = 0,\qquad S^T dV + dV^T S + dS^T V + V^T dS = 0
/// ```
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, BoundaryVariation, RiemannianCubic};
/// use stiefel_rs::{Curve, Interrupt};
/// // From rest to rest along a circle: the cost is 12 angle^2.
/// let (sin, cos) = 1.0_f64.sin_cos();
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[cos], [sin]], mat![[0.0], [0.0]]);
/// let (s0, s1, rest) = (s0.as_ref(), s1.as_ref(), rest.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// // The end moves on, at unit speed.
/// let onwards = mat![[-sin], [cos]];
/// let variation = BoundaryVariation { s0: rest, v0: rest, s1: onwards.as_ref(), v1: rest };
/// let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
/// assert!((derivative.cost(&variation)? - 24.0).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct BoundaryVariation<'a> {
    /// Variation of the start point.
    pub s0: MatRef<'a, f64>,
    /// Variation of the initial velocity.
    pub v0: MatRef<'a, f64>,
    /// Variation of the end point.
    pub s1: MatRef<'a, f64>,
    /// Variation of the end velocity.
    pub v1: MatRef<'a, f64>,
}

/// Gradient of a function of a cubic with respect to boundary data, as ambient matrices of shape `(n, k)`: the function changes
/// by `sum tr(G^T d)` for every [variation](BoundaryVariation).
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
/// use stiefel_rs::Interrupt;
/// // From rest to rest along a circle, by the angle 3 t^2 - 2 t^3.
/// let (sin, cos) = 1.0_f64.sin_cos();
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[cos], [sin]], mat![[0.0], [0.0]]);
/// let (s0, s1, rest) = (s0.as_ref(), s1.as_ref(), rest.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// // The angle at 1/2 is half that of the end, and the velocity at the start counts 1/8.
/// let along = mat![[-0.5_f64.sin()], [0.5_f64.cos()]];
/// let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
/// let gradient = derivative.pull_back(&[0.5], &[along.as_ref()], Interrupt::NEVER)?;
/// assert!(((gradient.s1.transpose() * mat![[-sin], [cos]])[(0, 0)] - 0.5).abs() < 1e-12);
/// assert!((gradient.v0[(1, 0)] - 0.125).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BoundaryGradient {
    /// With respect to the start point.
    pub s0: Mat<f64>,
    /// With respect to the initial velocity.
    pub v0: Mat<f64>,
    /// With respect to the end point.
    pub s1: Mat<f64>,
    /// With respect to the end velocity.
    pub v1: Mat<f64>,
}

/// Gradient of the cost `J` with respect to boundary data.
pub type CostGradient = BoundaryGradient;

/// The derivative of a Riemannian cubic with respect to its boundary data.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, BoundaryVariation, RiemannianCubic};
/// use stiefel_rs::Interrupt;
/// // From rest to rest along a circle, by the angle 3 t^2 - 2 t^3.
/// let (sin, cos) = 1.0_f64.sin_cos();
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[cos], [sin]], mat![[0.0], [0.0]]);
/// let (s0, s1, rest) = (s0.as_ref(), s1.as_ref(), rest.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
/// // Where the end moves on at unit speed, the middle does at half of it.
/// let onwards = mat![[-sin], [cos]];
/// let variation = BoundaryVariation { s0: rest, v0: rest, s1: onwards.as_ref(), v1: rest };
/// let middle = &derivative.points(&curve, &variation, &[0.5], Interrupt::NEVER)?[0];
/// assert!((middle.norm_l2() - 0.5).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug)]
pub struct BoundaryDerivative {
    span: (f64, f64),
    /// `(S, V, A, J)` at the start and at the end, shape `(n, k)`, in a time in which the curve takes one unit.
    ends: [[Mat<f64>; 4]; 2],
    cubic: LinearCubic,
    /// Tension in the same time.
    tension: f64,
    quotient: Quotient,
}

impl RiemannianCubic {
    /// The derivative of the curve with respect to its boundary data: points and velocities at the ends of
    /// [`t_span`](Curve::t_span).
    ///
    /// Any Riemannian cubic solves the boundary value problem of its own ends; this is the derivative of that solution.
    ///
    /// # Errors
    /// `ConjugateEnds` if the solution does not depend smoothly on the data; `InvalidArgument` if this can only be told from
    /// a matrix that would take more than four gigabytes; `Overflow`, `TooManySteps`,
    /// `Decomposition` and `Interrupted` from integrating the linearised equations.
    pub fn boundary_derivative(&self, interrupt: Interrupt<'_>) -> Result<BoundaryDerivative> {
        let unit = self.reparametrised(0.0, 1.0)?;
        let ends = [unit.state(0.0)?, unit.state(1.0)?];
        Ok(BoundaryDerivative {
            span: self.t_span(),
            cubic: LinearCubic::new(&unit, interrupt)?,
            tension: unit.tension(),
            quotient: self.quotient(),
            ends,
        })
    }

    /// The gradient of the cost `J` with respect to the boundary data, computed from the curve at both ends.
    ///
    /// ```math
    /// \delta J = 2 \bigl[ \langle D_t S', w \rangle - \langle x'' - \tau x, \delta S \rangle \bigr]_0^1,\qquad
    /// w = \delta V - A(\delta S)\, V
    /// ```
    ///
    /// with the skew matrix `A` of least rank for which `A S = dS`, and tangent vectors for `x` and `x''`. This is the
    /// first variation of `J` at a critical curve: no equation has to be solved, and the gradient exists at conjugate
    /// ends too.
    ///
    /// # Errors
    /// `Overflow` if a derivative at an end is too large for a floating-point number.
    pub fn cost_gradient(&self) -> Result<CostGradient> {
        let span = self.t_span();
        let ends = [self.state(span.0)?, self.state(span.1)?];
        Ok(cost_gradient(&ends, self.tension(), self.quotient()))
    }
}

impl BoundaryDerivative {
    /// The variation of the curve's initial data.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent` (the variation breaks a constraint), `Overflow`; `Interrupted`, and, where the
    /// iteration does not converge, `ConjugateEnds`, `TooManySteps` and `Decomposition`.
    pub fn initial(
        &self,
        variation: &BoundaryVariation<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<InitialVariation> {
        let z = self.end_changes(variation)?;
        let [da, second] = self.cubic.at_start(&z, interrupt)?;
        let [s, v, a, j] = self.ends[0].each_ref().map(|x| x.as_ref());
        let turned = |y| turned(s, variation.s0, y);
        let bracket = |x, y| bracket_of(self.quotient, s, x, y);
        let dj = second + (bracket(z[1].as_ref(), a) + bracket(v, da.as_ref())) * Scale(0.5);
        let acceleration = self.slowed(turned(a) + da, 2);
        let jerk = self.slowed(turned(j) + dj, 3);
        for result in [&acceleration, &jerk] {
            check_range(VARIATION, result.as_ref())?;
        }
        Ok(InitialVariation {
            point: variation.s0.to_owned(),
            velocity: variation.v0.to_owned(),
            acceleration,
            jerk,
        })
    }

    /// The variations of the points of the curve at several times, shape `(n, k)` each.
    ///
    /// # Arguments
    /// * `curve` - the curve whose derivative this is; `times` refer to its interval
    /// # Errors
    /// The errors of [`initial`](Self::initial), `NonFinite` for a time, and the errors of integrating to it.
    pub fn points(
        &self,
        curve: &RiemannianCubic,
        variation: &BoundaryVariation<'_>,
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        for &t in times {
            check_parameter(t)?;
        }
        let z = self.end_changes(variation)?;
        let here = local(curve.t_span(), times);
        let found = self.cubic.points(&z, &here, interrupt)?;
        if self.quotient == Quotient::Frames {
            return Ok(found);
        }
        // Interpolated in time, they are horizontal at the points of the curve only to the accuracy of these, up to which
        // `pull_back` is the transpose.
        let points = curve.sample(times, Quantity::Derivative(0), interrupt)?;
        let each = found.iter().zip(points.iter());
        let each = each.map(|(v, y)| {
            let horizontal = v - y * (y.transpose() * v);
            check_range(VARIATION, horizontal.as_ref())?;
            Ok(horizontal)
        });
        each.collect()
    }

    /// The gradient with respect to the boundary data of `sum tr(W^T S(t))` over cotangents `W` at given times `t`.
    ///
    /// This is the transpose of [`BoundaryDerivative::points`]; it solves the linear equations once for any number of
    /// times.
    ///
    /// # Arguments
    /// * `cotangents` - one per time, shape `(n, k)`, any matrices; named `W` in errors
    /// # Errors
    /// `Shape`, `NonFinite`; `Overflow`, `TooManySteps`, `Interrupted` from integrating; the errors of
    /// [`initial`](Self::initial) from solving.
    pub fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<BoundaryGradient> {
        let [[s0, v0, ..], [s1, v1, ..]] = self
            .ends
            .each_ref()
            .map(|end| end.each_ref().map(|x| x.as_ref()));
        check_cotangents(s0, times, cotangents)?;
        let bars = self
            .cubic
            .pull_back(&local(self.span, times), cotangents, interrupt)?;
        let [u0, w0, u1, w1] = bars.each_ref().map(|x| x.as_ref());
        let duration = Scale(self.span.1 - self.span.0);
        let ([s0, v0], [s1, v1]) = (by_data(s0, [u0, w0], v0), by_data(s1, [u1, w1], v1));
        let gradient = BoundaryGradient {
            s0,
            v0: v0 * duration,
            s1,
            v1: v1 * duration,
        };
        for part in [&gradient.s0, &gradient.v0, &gradient.s1, &gradient.v1] {
            check_range(VARIATION, part.as_ref())?;
        }
        Ok(gradient)
    }

    /// The variation of the cost `J`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`, `Overflow`.
    pub fn cost(&self, variation: &BoundaryVariation<'_>) -> Result<f64> {
        self.check(variation)?;
        let CostGradient { s0, v0, s1, v1 } = self.cost_gradient();
        let total = dot(s0.as_ref(), variation.s0)
            + dot(v0.as_ref(), variation.v0)
            + dot(s1.as_ref(), variation.s1)
            + dot(v1.as_ref(), variation.v1);
        if total.is_finite() {
            return Ok(total);
        }
        Err(Error::Overflow {
            quantity: VARIATION,
        })
    }

    /// The gradient of the cost `J`: [`RiemannianCubic::cost_gradient`].
    pub fn cost_gradient(&self) -> CostGradient {
        let CostGradient { s0, v0, s1, v1 } =
            cost_gradient(&self.ends, self.tension, self.quotient);
        let [s0, s1] = [s0, s1].map(|by_point| self.slowed(by_point, 3));
        let [v0, v1] = [v0, v1].map(|by_velocity| self.slowed(by_velocity, 2));
        CostGradient { s0, v0, s1, v1 }
    }

    /// `(u_0, w_0, u_1, w_1)` in a time in which the curve takes one unit.
    fn end_changes(&self, variation: &BoundaryVariation<'_>) -> Result<[Mat<f64>; 4]> {
        self.check(variation)?;
        let duration = Scale(self.span.1 - self.span.0);
        let beside = |[s, v, ..]: &[Mat<f64>; 4], ds, dv: MatRef<'_, f64>| {
            dv * duration - turned(s.as_ref(), ds, v.as_ref())
        };
        let BoundaryVariation { s0, v0, s1, v1 } = *variation;
        let [w0, w1] = [beside(&self.ends[0], s0, v0), beside(&self.ends[1], s1, v1)];
        Ok([s0.to_owned(), w0, s1.to_owned(), w1])
    }

    /// Converts a derivative of the given order to the time of the curve, one factor at a time: a power may overflow.
    fn slowed(&self, vector: Mat<f64>, order: usize) -> Mat<f64> {
        let rate = Scale((self.span.1 - self.span.0).recip());
        (0..order).fold(vector, |vector, _| vector * rate)
    }

    fn check(&self, variation: &BoundaryVariation<'_>) -> Result<()> {
        let BoundaryVariation { s0, v0, s1, v1 } = *variation;
        for (names, [s, v, ..], ds, dv) in [
            (["dS0", "dV0"], &self.ends[0], s0, v0),
            (["dS1", "dV1"], &self.ends[1], s1, v1),
        ] {
            // In the time of the derivative, in which round-off of a velocity that vanishes is small.
            let dv = dv * Scale(self.span.1 - self.span.0);
            let vectors = [(names[1], v.as_ref(), dv.as_ref())];
            check_variation(self.quotient, (names[0], s.as_ref(), ds), &vectors)?;
        }
        Ok(())
    }
}

/// Computed from point, velocity, covariant acceleration and covariant jerk at both ends.
fn cost_gradient(ends: &[[Mat<f64>; 4]; 2], tension: f64, quotient: Quotient) -> CostGradient {
    let [[s0, v0], [s1, v1]] = [(&ends[0], -2.0), (&ends[1], 2.0)].map(|(state, factor)| {
        let [s, v, a, j] = state.each_ref().map(|x| x.as_ref());
        let pull = j - bracket_of(quotient, s, v, a) * Scale(0.5) - v * Scale(tension);
        let bars = [pull * Scale(-factor), a * Scale(factor)];
        by_data(s, bars.each_ref().map(|x| x.as_ref()), v)
    });
    CostGradient { s0, v0, s1, v1 }
}

/// Times relative to an interval, in units of its length.
fn local((start, end): (f64, f64), times: &[f64]) -> Vec<f64> {
    times.iter().map(|t| (t - start) / (end - start)).collect()
}
