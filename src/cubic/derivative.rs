//! Derivatives of the solution of a boundary value problem with respect to its data, by the implicit function theorem.
//!
//! With `E(x, y)` the end of the curve with initial `x` and `y = (x', x'')`, all exact derivatives from the Taylor recurrence on
//! dual numbers,
//!
//! ```math
//! E_y\,\delta y = \delta(S_1, V_1) - E_x\,\delta x
//! ```
//!
//! in a frame at `S0`. A variation of `S0` is first made by a rotation of everything, which carries the whole curve with it.
//! Variations that leave the span of the data are tall rows beside it, each of which obeys the same `2k` equations.

use faer::{Mat, MatRef, Scale};

use super::end_response::{
    Response, SpanResponse, VARIATION, blocks_of, outer_response, row_matrix, row_variations,
};
use super::initial::{Horizontal, InitialData};
use super::riemannian_cubic::RiemannianCubic;
use super::turning::turned;
use super::variation::vary;
use crate::curve::Curve;
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::{check_finite, check_range, norm};
use crate::manifold::stiefel::{Stiefel, TANGENT_TOLERANCE};

/// A variation of boundary data: ambient derivatives of `S0, V0, S1, V1` along a family of data, all of shape `(n, k)`.
///
/// Along such a family `S^T S = I` and `S^T V + V^T S = 0` stay true, so
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
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default())?;
/// // The end moves on, at unit speed.
/// let onwards = mat![[-sin], [cos]];
/// let variation = BoundaryVariation { s0: rest, v0: rest, s1: onwards.as_ref(), v1: rest };
/// let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
/// assert!((derivative.cost(&variation)? - 24.0).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct BoundaryVariation<'a> {
    /// Of the start.
    pub s0: MatRef<'a, f64>,
    /// Of the initial velocity.
    pub v0: MatRef<'a, f64>,
    /// Of the end.
    pub s1: MatRef<'a, f64>,
    /// Of the end velocity.
    pub v1: MatRef<'a, f64>,
}

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
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default())?;
/// let onwards = mat![[-sin], [cos]];
/// let variation = BoundaryVariation { s0: rest, v0: rest, s1: onwards.as_ref(), v1: rest };
/// let initial = curve.boundary_derivative(Interrupt::NEVER)?.initial(&variation, Interrupt::NEVER)?;
/// assert!((initial.acceleration - mat![[0.0], [6.0]]).norm_l2() < 1e-11);
/// assert!((initial.jerk - mat![[0.0], [-12.0]]).norm_l2() < 1e-11);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct InitialVariation {
    /// Of the point: that of the data.
    pub point: Mat<f64>,
    /// Of the velocity: that of the data.
    pub velocity: Mat<f64>,
    /// Of the covariant acceleration.
    pub acceleration: Mat<f64>,
    /// Of the covariant jerk.
    pub jerk: Mat<f64>,
}

/// Gradient of the cost `J` with respect to boundary data, as ambient matrices of shape `(n, k)`:
/// `dJ = sum tr(G^T d)` for every [variation](BoundaryVariation).
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
/// // From rest to rest along a circle: the cost is 12 angle^2, its derivative 24 angle.
/// let (sin, cos) = 1.0_f64.sin_cos();
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[cos], [sin]], mat![[0.0], [0.0]]);
/// let (s0, s1, rest) = (s0.as_ref(), s1.as_ref(), rest.as_ref());
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default())?;
/// let gradient = curve.cost_gradient()?;
/// let slope = (gradient.s1.transpose() * mat![[-sin], [cos]])[(0, 0)];
/// assert!((slope - 24.0).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CostGradient {
    /// With respect to the start.
    pub s0: Mat<f64>,
    /// With respect to the initial velocity.
    pub v0: Mat<f64>,
    /// With respect to the end.
    pub s1: Mat<f64>,
    /// With respect to the end velocity.
    pub v1: Mat<f64>,
}

/// How a Riemannian cubic depends on its boundary data, near a solution.
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
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default())?;
/// let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
/// // Where the end moves on at unit speed, the middle does at half of it.
/// let onwards = mat![[-sin], [cos]];
/// let variation = BoundaryVariation { s0: rest, v0: rest, s1: onwards.as_ref(), v1: rest };
/// let middle = &derivative.points(&curve, &variation, &[0.5], Interrupt::NEVER)?[0];
/// assert!((middle.norm_l2() - 0.5).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BoundaryDerivative {
    /// `(S, V, A, J)` at the start and at the end, shape `(n, k)`.
    pub(super) ends: [[Mat<f64>; 4]; 2],
    pub(super) span: (f64, f64),
    pub(super) data: InitialData,
    /// How the end answers in the frame of the span.
    inner: SpanResponse,
    /// The same for a row outside of the span.
    pub(super) outer: Option<Response>,
}

impl RiemannianCubic {
    /// How the curve depends on its boundary data: ends of [`t_span`](Curve::t_span), velocities there.
    ///
    /// Any Riemannian cubic is the solution of the boundary value problem of its own ends; this is the derivative of that
    /// solution.
    ///
    /// # Errors
    /// `Overflow`, `TooManySteps` and `Interrupted` of the integration of the derivative.
    pub fn boundary_derivative(&self, interrupt: Interrupt<'_>) -> Result<BoundaryDerivative> {
        let span = self.t_span();
        let ends = [self.state(span.0)?, self.state(span.1)?];
        let data = {
            let [s, v, a, j] = ends[0].each_ref().map(|x| x.as_ref());
            InitialData::new(s, v, a, j)?.in_tension(self.tension())
        };
        let duration = span.1 - span.0;
        let inner = SpanResponse::new(&data, duration, interrupt)?;
        let outer = match data.frame {
            Some(_) => {
                let rows = row_variations(blocks_of(&data));
                let slopes = vary::<8>(&data, 1, &rows, &[duration], interrupt)?;
                Some(outer_response(&slopes[0], duration)?)
            }
            None => None,
        };
        Ok(BoundaryDerivative {
            span,
            inner,
            outer,
            ends,
            data,
        })
    }

    /// The gradient of the cost `J` with respect to the boundary data, from the curve at both ends.
    ///
    /// ```math
    /// \delta J = 2 \bigl[ \langle D_t S', D\,\delta V \rangle - \langle D_t D_t S' - \tau S', \delta S \rangle \bigr]_0^1,\qquad
    /// D\,\delta V = dV + \Gamma(V, dS)
    /// ```
    ///
    /// By the first variation of `J` at a critical curve: no equation has to be solved, and it exists at conjugate ends too.
    ///
    /// # Errors
    /// `Overflow` where a derivative at an end is too large for a number.
    pub fn cost_gradient(&self) -> Result<CostGradient> {
        let span = self.t_span();
        let ends = [self.state(span.0)?, self.state(span.1)?];
        Ok(cost_gradient(&ends, self.tension()))
    }

    /// Point, velocity, covariant acceleration and covariant jerk at a time.
    pub(super) fn state(&self, t: f64) -> Result<[Mat<f64>; 4]> {
        Ok([
            self.point(t)?,
            self.derivative(t, 1)?,
            self.acceleration(t)?,
            self.jerk(t)?,
        ])
    }
}

impl BoundaryDerivative {
    /// The variation of the initial data of the curve.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent` (the variation breaks a constraint); `ConjugateEnds` where the solution does not
    /// depend smoothly on the data; `Overflow`, `NoConvergence` and `Interrupted` of products with the derivative, by
    /// which equations with more than 64 unknowns are solved.
    pub fn initial(
        &self,
        variation: &BoundaryVariation<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<InitialVariation> {
        let parts = self.parts(variation, interrupt)?;
        let [a, second] = &parts.inside[1..] else {
            unreachable!("three vectors");
        };
        let data = &self.data;
        let half = Scale(0.5);
        let (one, two) = (
            parts.inside[0].bracket(&data.acceleration),
            data.velocity.bracket(a),
        );
        let jerk = Horizontal {
            omega: &second.omega + (one.omega + two.omega) * half,
            normal: &second.normal + (one.normal + two.normal) * half,
        };
        let [x_rows, a_rows, second_rows] = &parts.outside;
        let jerk_rows = second_rows
            + (x_rows * &data.acceleration.omega - a_rows * &data.velocity.omega) * half;
        let acceleration = self.turned(variation, &self.ends[0][2]) + self.up(a) + a_rows;
        let jerk = self.turned(variation, &self.ends[0][3]) + self.up(&jerk) + jerk_rows;
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

    /// The variation of the point of the curve at each of several times, shape `(n, k)` each.
    ///
    /// # Arguments
    /// * `curve` - the curve that this is the derivative of
    /// # Errors
    /// Those of [`initial`](Self::initial), `NonFinite` for a time, and those of integrating to it.
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
        let parts = self.parts(variation, interrupt)?;
        let after: Vec<f64> = times.iter().map(|t| t - self.span.0).collect();
        let inside = vary::<1>(
            &self.data,
            0,
            std::slice::from_ref(&parts.inside),
            &after,
            interrupt,
        )?;
        let outside = match self.data.frame {
            Some(_) => {
                let rows = row_variations(blocks_of(&self.data));
                Some(vary::<8>(&self.data, 1, &rows, &after, interrupt)?)
            }
            None => None,
        };
        let mut out = Vec::with_capacity(times.len());
        for (i, &t) in times.iter().enumerate() {
            let mut total = self.turned(variation, &curve.point(t)?);
            total += self.lift(&(&self.data.g * &inside[i].points[0]));
            if let Some(outside) = &outside {
                let k = total.ncols();
                let matrix = row_matrix(&outside[i]);
                for (level, rows) in parts.outside.iter().enumerate() {
                    let block = matrix.submatrix(0, level * k, k, k);
                    total += rows * block.transpose();
                }
            }
            check_range(VARIATION, total.as_ref())?;
            out.push(total);
        }
        Ok(out)
    }

    /// The variation of the cost `J`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`, `Overflow`.
    pub fn cost(&self, variation: &BoundaryVariation<'_>) -> Result<f64> {
        self.check(variation)?;
        let gradient = self.cost_gradient();
        let product = |a: &Mat<f64>, b: MatRef<'_, f64>| {
            let columns = a.col_iter().zip(b.col_iter());
            columns.map(|(a, b)| a.transpose() * b).sum::<f64>()
        };
        let total = product(&gradient.s0, variation.s0)
            + product(&gradient.v0, variation.v0)
            + product(&gradient.s1, variation.s1)
            + product(&gradient.v1, variation.v1);
        if total.is_finite() {
            return Ok(total);
        }
        Err(Error::Overflow {
            quantity: VARIATION,
        })
    }

    /// The gradient of the cost `J`: [`RiemannianCubic::cost_gradient`].
    pub fn cost_gradient(&self) -> CostGradient {
        cost_gradient(&self.ends, self.data.tension)
    }

    /// Variations of `x, x', x''` with the start held fixed, after the rotation of everything.
    fn parts(&self, variation: &BoundaryVariation<'_>, interrupt: Interrupt<'_>) -> Result<Parts> {
        self.check(variation)?;
        let (inside, dv0, ends) = self.inside(variation, interrupt)?;
        Ok(Parts {
            inside,
            outside: self.outside(&dv0, &ends)?,
        })
    }

    /// The part in the span, and what the variations of the velocity at the start and of the end are after the rotation.
    #[allow(clippy::type_complexity)]
    pub(super) fn inside(
        &self,
        variation: &BoundaryVariation<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<([Horizontal; 3], Mat<f64>, [Mat<f64>; 2])> {
        let rest = |d: MatRef<'_, f64>, of: &Mat<f64>| d.to_owned() - self.turned(variation, of);
        let [[_, v0, ..], [s1, v1, ..]] = &self.ends;
        let (dv0, ends) = (
            rest(variation.v0, v0),
            [rest(variation.s1, s1), rest(variation.v1, v1)],
        );
        let identity = Mat::identity(self.data.g.nrows(), self.data.g.nrows());
        let x = Horizontal::of_tangent(identity.as_ref(), self.down(&dv0).as_ref());
        let wanted = ends.each_ref().map(|d| {
            let low = self.down(d);
            Horizontal::of_tangent(self.inner.turn.as_ref(), low.as_ref())
        });
        let [a, second] = self.inner.solve(&self.data, &x, &wanted, interrupt)?;
        Ok(([x, a, second], dv0, ends))
    }

    /// The parts outside of the span, row by row.
    fn outside(&self, dv0: &Mat<f64>, ends: &[Mat<f64>; 2]) -> Result<[Mat<f64>; 3]> {
        let (n, k) = dv0.shape();
        let mut out = std::array::from_fn(|_| Mat::zeros(n, k));
        let (Some(frame), Some(response)) = (&self.data.frame, &self.outer) else {
            return Ok(out);
        };
        let off = |d: &Mat<f64>| {
            let once = d - frame * (frame.transpose() * d);
            &once - frame * (frame.transpose() * &once)
        };
        let (x, s1, v1) = (off(dv0), off(&ends[0]), off(&ends[1]));
        out[0] = x.clone();
        for row in 0..n {
            let entry = |a: &Mat<f64>| (0..k).map(|j| a[(row, j)]).collect::<Vec<_>>();
            let wanted = [entry(&s1), entry(&v1)].concat();
            let y = response.solve(&entry(&x), &wanted)?;
            for j in 0..k {
                out[1][(row, j)] = y[j];
                out[2][(row, j)] = y[k + j];
            }
        }
        Ok(out)
    }

    /// Coordinates in the frame at the start of what lies in the span.
    pub(super) fn down(&self, d: &Mat<f64>) -> Mat<f64> {
        let low = self
            .data
            .frame
            .as_ref()
            .map_or(d.clone(), |e| e.transpose() * d);
        self.data.g.transpose() * low
    }

    /// The tangent vector at the start with the given coordinates.
    pub(super) fn up(&self, x: &Horizontal) -> Mat<f64> {
        let (k, m) = (x.omega.nrows(), x.normal.nrows());
        let low = Mat::from_fn(k + m, k, |i, j| match i.checked_sub(k) {
            None => x.omega[(i, j)],
            Some(i) => x.normal[(i, j)],
        });
        self.lift(&(&self.data.g * low))
    }

    pub(super) fn lift(&self, low: &Mat<f64>) -> Mat<f64> {
        self.data.frame.as_ref().map_or(low.clone(), |e| e * low)
    }

    /// `A Y` for the skew matrix `A` of least rank with `A S0 = dS0`.
    fn turned(&self, variation: &BoundaryVariation<'_>, y: &Mat<f64>) -> Mat<f64> {
        turned(self.ends[0][0].as_ref(), variation.s0, y.as_ref())
    }

    fn check(&self, variation: &BoundaryVariation<'_>) -> Result<()> {
        let manifold = Stiefel::of("S0", self.ends[0][0].as_ref())?;
        let [[s0, v0, ..], [s1, v1, ..]] = &self.ends;
        for (names, s, v, ds, dv) in [
            (["dS0", "dV0"], s0, v0, variation.s0, variation.v0),
            (["dS1", "dV1"], s1, v1, variation.s1, variation.v1),
        ] {
            check_shape(names[1], s, dv)?;
            check_finite(names[1], dv)?;
            manifold.check_tangent(names[0], s.as_ref(), ds, TANGENT_TOLERANCE)?;
            let half = s.transpose() * dv + ds.transpose() * v;
            let defect = norm((&half + half.transpose()).as_ref()) * 0.5;
            let size = 1.0 + norm(dv) + norm(ds) * norm(v.as_ref());
            let tolerance = TANGENT_TOLERANCE * size;
            if defect.is_nan() || defect > tolerance {
                return Err(Error::NotTangent {
                    name: names[1],
                    defect,
                    tolerance,
                });
            }
        }
        Ok(())
    }
}

/// Variations of `x, x', x''`: in the span, and outside of it in `n` rows.
struct Parts {
    inside: [Horizontal; 3],
    outside: [Mat<f64>; 3],
}

fn check_shape(name: &'static str, s: &Mat<f64>, d: MatRef<'_, f64>) -> Result<()> {
    if s.shape() == d.shape() {
        return Ok(());
    }
    Err(Error::Shape {
        name,
        expected: format!("{:?}", s.shape()),
        found: format!("{:?}", d.shape()),
    })
}

/// From point, velocity, covariant acceleration and covariant jerk at both ends.
fn cost_gradient([start, end]: &[[Mat<f64>; 4]; 2], tension: f64) -> CostGradient {
    let [[s0, v0], [s1, v1]] =
        [(-2.0, start), (2.0, end)].map(|(factor, end)| end_gradient(factor, end, tension));
    CostGradient { s0, v0, s1, v1 }
}

/// `factor` times the gradients of `<a, dV + Gamma(V, dS)> - <j - tau v, dS>` with respect to `dS` and `dV`.
fn end_gradient(factor: f64, [s, v, a, j]: &[Mat<f64>; 4], tension: f64) -> [Mat<f64>; 2] {
    let j = j - v * Scale(tension);
    let metric = |w: &Mat<f64>| w - s * (s.transpose() * w) * Scale(0.5);
    let b = metric(a);
    // The transpose of W -> Gamma(V, W).
    let inner = b.transpose() * s;
    let normal = v - s * (s.transpose() * v);
    let transposed = (s * (b.transpose() * v)
        + &b * (s.transpose() * v)
        + normal * (&inner + inner.transpose()))
        * Scale(0.5);
    [(transposed - metric(&j)) * Scale(factor), b * Scale(factor)]
}
