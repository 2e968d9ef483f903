//! Transposed derivatives of Riemannian cubics: gradients by boundary data and by initial data of functions of their points.

use faer::{Mat, MatRef};

use super::derivative::{BoundaryDerivative, BoundaryVariation};
use super::end_response::{VARIATION, blocks_of, row_matrix, row_variations};
use super::initial::{Horizontal, InitialData};
use super::loads::{Load, collected};
use super::turning::{lowered, turned, turned_transposed};
use super::variation::vary;
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::{check_finite, check_range};

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
/// let curve = RiemannianCubic::from_boundary(s0, rest, s1, rest, &BoundaryOptions::default())?;
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
    /// With respect to the start.
    pub s0: Mat<f64>,
    /// With respect to the initial velocity.
    pub v0: Mat<f64>,
    /// With respect to the end.
    pub s1: Mat<f64>,
    /// With respect to the end velocity.
    pub v1: Mat<f64>,
}

impl BoundaryDerivative {
    /// The gradient, with respect to the boundary data, of the sum of products of entries of cotangents with the points of the
    /// curve at some times.
    ///
    /// The transpose of [`BoundaryDerivative::points`]: one solution of the linear equations, whatever the number of times.
    ///
    /// # Arguments
    /// * `cotangents` - one for each time, shape `(n, k)`, any matrices; `W` in errors
    /// # Errors
    /// `Shape`, `NonFinite`; `ConjugateEnds` where the solution does not depend smoothly on the data; `Overflow`,
    /// `TooManySteps`, `NoConvergence`, `Decomposition` and `Interrupted` of integrating and solving.
    pub fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<BoundaryGradient> {
        check_cotangents(self.ends[0][0].as_ref(), times, cotangents)?;
        let after: Vec<f64> = times.iter().map(|t| t - self.span.0).collect();
        let mut total = self.pull_back_in_span(&after, cotangents, interrupt)?;
        if let Some(rows) = self.pull_back_rows(&after, cotangents, interrupt)? {
            for (total, rows) in total.iter_mut().zip(rows) {
                *total += rows;
            }
        }
        for gradient in &total {
            check_range(VARIATION, gradient.as_ref())?;
        }
        let [s0, v0, s1, v1] = total;
        Ok(BoundaryGradient { s0, v0, s1, v1 })
    }

    /// The part of the cotangents in the span of the curve.
    ///
    /// The variation that collects them is made to vanish at the end by one more, of the boundary data at the start: the accelerations
    /// of both at the ends are the gradient.
    fn pull_back_in_span(
        &self,
        after: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let [p, w, a, b] = collected_of(&self.data, after, cotangents, interrupt)?;
        let [[s0, v0, ..], [s1, v1, ..]] = &self.ends;
        let ds0 = self.up(&p);
        let dv0 = self.up(&w) + turned(s0.as_ref(), ds0.as_ref(), v0.as_ref());
        let rest = Mat::zeros(s0.nrows(), s0.ncols());
        let variation = BoundaryVariation {
            s0: ds0.as_ref(),
            v0: dv0.as_ref(),
            s1: rest.as_ref(),
            v1: rest.as_ref(),
        };
        let (inside, ..) = self.inside(&variation, interrupt)?;
        let duration = self.span.1 - self.span.0;
        let slopes = vary::<1>(
            &self.data,
            0,
            std::slice::from_ref(&inside),
            &[duration],
            interrupt,
        )?;
        let (slopes, turn) = (&slopes[0], p.matrix());
        let at_end = |vector: &Horizontal, slope: &Mat<f64>| {
            self.lift(&(&self.data.g * (&turn * &slopes.frame * vector.tangent() + slope)))
        };
        let a1 = at_end(&slopes.state[1], &slopes.accelerations[0]);
        let b1 = at_end(&slopes.state[2], &slopes.seconds[0]);
        let [_, a0, b0] = &inside;
        let starts = [b.plus(-1.0, b0), a0.clone().plus(-1.0, &a)].map(|x| self.up(&x));
        let [s0_bar, v0_bar] = by_data(s0, [starts[0].as_ref(), starts[1].as_ref()], v0);
        let [s1_bar, v1_bar] = by_data(s1, [b1.as_ref(), (-a1).as_ref()], v1);
        Ok([s0_bar, v0_bar, s1_bar, v1_bar])
    }

    /// The part outside of it, row by row.
    fn pull_back_rows(
        &self,
        after: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<[Mat<f64>; 4]>> {
        let Some(outer) = &self.outer else {
            return Ok(None);
        };
        let [displaced, mut x, a, second] = row_bars(&self.data, after, cotangents, interrupt)?;
        let (n, k) = x.shape();
        let mut ends = [Mat::<f64>::zeros(n, k), Mat::zeros(n, k)];
        for row in 0..n {
            let entries = |m: &Mat<f64>| (0..k).map(|j| m[(row, j)]).collect::<Vec<_>>();
            let [by_x, by_end] =
                outer.solve_transposed(&[entries(&a), entries(&second)].concat())?;
            for j in 0..k {
                x[(row, j)] += by_x[j];
                ends[0][(row, j)] = by_end[j];
                ends[1][(row, j)] = by_end[k + j];
            }
        }
        let [[s0, v0, ..], [s1, v1, ..]] = &self.ends;
        let turned = |bar: &Mat<f64>, y: &Mat<f64>| bar * (y.transpose() * s0);
        let start = displaced - turned(&x, v0) - turned(&ends[0], s1) - turned(&ends[1], v1);
        let [s1_bar, v1_bar] = ends;
        Ok(Some([start, x, s1_bar, v1_bar]))
    }
}

/// Gradients by `dS` and `dV` of `<u, dS> + <w, dV - A V>` for tangent vectors `u` and `w`.
pub(super) fn by_data(s: &Mat<f64>, [u, w]: [MatRef<'_, f64>; 2], v: &Mat<f64>) -> [Mat<f64>; 2] {
    let low = lowered(s.as_ref(), w);
    let point = lowered(s.as_ref(), u) - turned_transposed(s.as_ref(), low.as_ref(), v.as_ref());
    [point, low]
}

/// [`collected`] for ambient cotangents, of which the part in the span counts.
pub(super) fn collected_of(
    data: &InitialData,
    after: &[f64],
    cotangents: &[MatRef<'_, f64>],
    interrupt: Interrupt<'_>,
) -> Result<[Horizontal; 4]> {
    let mut loads: Vec<Load> = after
        .iter()
        .zip(cotangents)
        .map(|(&time, cotangent)| Load {
            time,
            cotangent: match &data.frame {
                Some(frame) => data.g.transpose() * (frame.transpose() * cotangent),
                None => data.g.transpose() * cotangent,
            },
        })
        .collect();
    collected(data, &mut loads, interrupt)
}

/// Of what of the cotangents is outside of the span: gradients by the rows of the displacement of the start, and of
/// `x, x', x''`; shape `(n, k)` each.
pub(super) fn row_bars(
    data: &InitialData,
    after: &[f64],
    cotangents: &[MatRef<'_, f64>],
    interrupt: Interrupt<'_>,
) -> Result<[Mat<f64>; 4]> {
    let blocks = blocks_of(data);
    let (k, n) = (blocks.k, data.frame.as_ref().map_or(0, Mat::nrows));
    let found = vary::<8>(data, 1, &row_variations(blocks), after, interrupt)?;
    let mut bars: [Mat<f64>; 4] = std::array::from_fn(|_| Mat::zeros(n, k));
    for (slopes, cotangent) in found.iter().zip(cotangents) {
        let off = off(data, *cotangent);
        let matrix = row_matrix(slopes);
        bars[0] += &off * slopes.frame.submatrix(0, 0, k, k).transpose();
        for level in 0..3 {
            bars[level + 1] += &off * matrix.submatrix(0, level * k, k, k);
        }
    }
    Ok(bars)
}

/// What is outside of the span of the data.
pub(super) fn off(data: &InitialData, d: MatRef<'_, f64>) -> Mat<f64> {
    let Some(frame) = &data.frame else {
        return Mat::zeros(d.nrows(), d.ncols());
    };
    let once = d - frame * (frame.transpose() * d);
    &once - frame * (frame.transpose() * &once)
}

/// # Errors
/// `Shape`, `NonFinite`.
pub(crate) fn check_cotangents(
    s: MatRef<'_, f64>,
    times: &[f64],
    cotangents: &[MatRef<'_, f64>],
) -> Result<()> {
    const NAME: &str = "W";
    for &t in times {
        check_parameter(t)?;
    }
    if times.len() != cotangents.len() {
        return Err(Error::Shape {
            name: NAME,
            expected: format!("one for each of {} times", times.len()),
            found: cotangents.len().to_string(),
        });
    }
    for cotangent in cotangents {
        if cotangent.shape() != s.shape() {
            return Err(Error::Shape {
                name: NAME,
                expected: format!("{:?}", s.shape()),
                found: format!("{:?}", cotangent.shape()),
            });
        }
        check_finite(NAME, *cotangent)?;
    }
    Ok(())
}
