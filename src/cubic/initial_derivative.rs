//! Derivatives of a Riemannian cubic with respect to its initial data, forward and transposed: nothing has to be solved.

use faer::{Mat, MatRef, Scale};

use super::derivative::InitialVariation;
use super::end_response::{VARIATION, blocks_of, row_matrix, row_variations};
use super::initial::{Horizontal, InitialData};
use super::pull_back::{by_data, check_cotangents, collected_of, off, row_bars};
use super::riemannian_cubic::RiemannianCubic;
use super::turning::{lowered, turned};
use super::variation::vary;
use crate::curve::Curve;
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::{check_finite, check_range, check_shape, norm};
use crate::manifold::stiefel::{Stiefel, TANGENT_TOLERANCE};

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
/// let curve = RiemannianCubic::from_initial(s, v, v, v, &IntegrationOptions::default())?;
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
    /// The variation of the point of the curve at each of several times, shape `(n, k)` each, for a variation of point, velocity,
    /// covariant acceleration and covariant jerk at the start of [`t_span`](Curve::t_span).
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
        let start = self.t_span().0;
        let state = self.state(start)?;
        check(&state, variation)?;
        let data = initial_data(&state)?.in_tension(self.tension());
        let after: Vec<f64> = times.iter().map(|t| t - start).collect();
        let (inside, rows) = parts(&data, &state, variation);
        let found = vary::<1>(&data, 0, std::slice::from_ref(&inside), &after, interrupt)?;
        let lift = |low: Mat<f64>| match &data.frame {
            Some(frame) => frame * (&data.g * low),
            None => &data.g * low,
        };
        let mut out = Vec::with_capacity(times.len());
        let ds = variation.point.as_ref();
        for (slopes, &t) in found.iter().zip(times) {
            let point = self.point(t)?;
            out.push(
                turned(state[0].as_ref(), ds, point.as_ref()) + lift(slopes.points[0].clone()),
            );
        }
        if data.frame.is_some() {
            let k = ds.ncols();
            let units = row_variations(blocks_of(&data));
            let found = vary::<8>(&data, 1, &units, &after, interrupt)?;
            for (out, slopes) in out.iter_mut().zip(&found) {
                let matrix = row_matrix(slopes);
                for (level, rows) in rows.iter().enumerate() {
                    *out += rows * matrix.submatrix(0, level * k, k, k).transpose();
                }
            }
        }
        for point in &out {
            check_range(VARIATION, point.as_ref())?;
        }
        Ok(out)
    }

    /// The gradient, with respect to point, velocity, covariant acceleration and covariant jerk at the start of
    /// [`t_span`](Curve::t_span), of the sum of products of entries of cotangents with the points of the curve at some times.
    ///
    /// The transpose of [`RiemannianCubic::initial_points`]: one run back to the start, whatever the number of times.
    ///
    /// # Arguments
    /// * `cotangents` - one for each time, shape `(n, k)`, any matrices; `W` in errors
    /// # Errors
    /// `Shape`, `NonFinite`; `TooManySteps`, `Overflow`, `Interrupted`.
    pub fn initial_pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<InitialGradient> {
        let start = self.t_span().0;
        let state = self.state(start)?;
        check_cotangents(state[0].as_ref(), times, cotangents)?;
        let data = initial_data(&state)?.in_tension(self.tension());
        let after: Vec<f64> = times.iter().map(|t| t - start).collect();
        let [s, v, a, j] = &state;
        let bars = in_span(&data, collected_of(&data, &after, cotangents, interrupt)?);
        let [u, w, x, y] = bars.map(|bar| up(&data, &bar));
        let zero = Mat::zeros(s.nrows(), s.ncols());
        let mut point = lowered(s.as_ref(), u.as_ref());
        let mut vectors = [(w, v), (x, a), (y, j)].map(|(bar, vector)| {
            let [by_point, by_vector] = by_data(s, [zero.as_ref(), bar.as_ref()], vector);
            point += by_point;
            by_vector
        });
        if data.frame.is_some() {
            let [displaced, x, y, z] =
                outside(&data, row_bars(&data, &after, cotangents, interrupt)?);
            point += displaced;
            for ((total, rows), vector) in vectors.iter_mut().zip([x, y, z]).zip([v, a, j]) {
                point -= &rows * (vector.transpose() * s);
                *total += rows;
            }
        }
        let [velocity, acceleration, jerk] = vectors;
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
}

fn initial_data(state: &[Mat<f64>; 4]) -> Result<InitialData> {
    let [s, v, a, j] = state.each_ref().map(|x| x.as_ref());
    InitialData::new(s, v, a, j)
}

/// The tangent vector at the start with the given coordinates.
fn up(data: &InitialData, x: &Horizontal) -> Mat<f64> {
    let low = &data.g * x.tangent();
    match &data.frame {
        Some(frame) => frame * low,
        None => low,
    }
}

/// Variations of `x, x', x''`, after the rotation that displaces the start: in the span, and outside of it in `n` rows.
fn parts(
    data: &InitialData,
    state: &[Mat<f64>; 4],
    variation: &InitialVariation,
) -> ([Horizontal; 3], [Mat<f64>; 3]) {
    let ds = variation.point.as_ref();
    let given = [
        &variation.velocity,
        &variation.acceleration,
        &variation.jerk,
    ];
    let rest: [Mat<f64>; 3] =
        std::array::from_fn(|i| given[i] - turned(state[0].as_ref(), ds, state[i + 1].as_ref()));
    let [w, a, j] = rest.each_ref().map(|rest| {
        let low = match &data.frame {
            Some(frame) => frame.transpose() * rest,
            None => rest.clone(),
        };
        Horizontal::of_tangent(data.g.as_ref(), low.as_ref())
    });
    let second =
        j.plus_bracket(-0.5, &w, &data.acceleration)
            .plus_bracket(-0.5, &data.velocity, &a);
    let [x_rows, a_rows, j_rows] = rest.map(|rest| off(data, rest.as_ref()));
    let second_rows =
        j_rows - (&x_rows * &data.acceleration.omega - &a_rows * &data.velocity.omega) * Scale(0.5);
    ([w, a, second], [x_rows, a_rows, second_rows])
}

/// Gradients by displacement, velocity, covariant acceleration and covariant jerk at the start, from the variation there that
/// collects the cotangents.
///
/// The displacements of two variations do not commute, which adds their bracket to the first of them.
fn in_span(data: &InitialData, [p, w, a, b]: [Horizontal; 4]) -> [Horizontal; 4] {
    let (x, y) = (&data.velocity, &data.acceleration);
    let turning = &y.normal * x.normal.transpose() - &x.normal * y.normal.transpose();
    // In tension x'' - tau x is what goes with displacements, and the velocity has a part in it.
    let pull = data.second().plus(-data.tension, x);
    let (a, b) = (a.plus(-data.tension, &p), b.plus(-data.tension, &w));
    let mut point = b.plus_bracket(-1.0, &pull, &p);
    point.normal += turning * &p.normal;
    let zero = Horizontal::zeros(blocks_of(data));
    let jerk = zero.clone().plus(-1.0, &p);
    let velocity = zero.plus(-1.0, &a).plus_bracket(-0.5, y, &jerk);
    let acceleration = w.plus_bracket(-0.5, &jerk, x);
    [point, velocity, acceleration, jerk]
}

/// The same for rows outside of the span, from the gradients by displacement and `x, x', x''`.
fn outside(data: &InitialData, [displaced, x, a, second]: [Mat<f64>; 4]) -> [Mat<f64>; 4] {
    let half = Scale(0.5);
    let velocity = x - &second * data.acceleration.omega.transpose() * half;
    let acceleration = a + &second * data.velocity.omega.transpose() * half;
    [displaced, velocity, acceleration, second]
}

fn check(state: &[Mat<f64>; 4], variation: &InitialVariation) -> Result<()> {
    let s = state[0].as_ref();
    let ds = variation.point.as_ref();
    Stiefel::of("S", s)?.check_tangent("dS", s, ds, TANGENT_TOLERANCE)?;
    for (name, v, dv) in [
        ("dV", &state[1], &variation.velocity),
        ("dA", &state[2], &variation.acceleration),
        ("dJ", &state[3], &variation.jerk),
    ] {
        check_shape(name, dv.as_ref(), s.nrows(), s.ncols())?;
        check_finite(name, dv.as_ref())?;
        let half = s.transpose() * dv + ds.transpose() * v;
        let defect = norm((&half + half.transpose()).as_ref()) * 0.5;
        let size = 1.0 + norm(dv.as_ref()) + norm(ds) * norm(v.as_ref());
        let tolerance = TANGENT_TOLERANCE * size;
        if defect.is_nan() || defect > tolerance {
            return Err(Error::NotTangent {
                name,
                defect,
                tolerance,
            });
        }
    }
    Ok(())
}
