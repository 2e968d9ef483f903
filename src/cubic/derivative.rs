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

use super::initial::{Horizontal, InitialData};
use super::problem::{pack, unpack};
use super::reduced::Sized;
use super::riemannian_cubic::RiemannianCubic;
use super::variation::{Slopes, vary};
use crate::curve::{Curve, check_parameter};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::solve_square;
use crate::linalg::structure::{check_finite, norm};
use crate::manifold::stiefel::{Stiefel, TANGENT_TOLERANCE};

/// A variation of boundary data: ambient derivatives of `S0, V0, S1, V1` along a family of data, all of shape `(n, k)`.
///
/// Along such a family `S^T S = I` and `S^T V + V^T S = 0` stay true, so
///
/// ```math
/// S^T dS + dS^T S = 0,\qquad S^T dV + dV^T S + dS^T V + V^T dS = 0
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
#[derive(Debug, Clone)]
pub struct BoundaryDerivative {
    /// `(S, V, A, J)` at the start and at the end, shape `(n, k)`.
    ends: [[Mat<f64>; 4]; 2],
    span: (f64, f64),
    data: InitialData,
    /// Derivatives of the end in the frame of the span: with respect to `x`, and to `(x', x'')`.
    inner: [Mat<f64>; 2],
    /// The same for a row outside of the span.
    outer: Option<[Mat<f64>; 2]>,
    /// Frame at the end, in the coordinates of the frame at the start.
    turn: Mat<f64>,
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
        let at = |t: f64| -> Result<[Mat<f64>; 4]> {
            Ok([
                self.point(t)?,
                self.derivative(t, 1)?,
                self.acceleration(t)?,
                self.jerk(t)?,
            ])
        };
        let ends = [at(span.0)?, at(span.1)?];
        let data = {
            let [s, v, a, j] = ends[0].each_ref().map(|x| x.as_ref());
            InitialData::new(s, v, a, j)?
        };
        let duration = span.1 - span.0;
        let blocks = blocks_of(&data);
        let inside = vary(
            &data,
            0,
            &unit_variations(blocks, 0),
            &[duration],
            interrupt,
        )?;
        let inside = inside.into_iter().next().expect("one time");
        let outer = match data.frame {
            Some(_) => {
                let rows = unit_variations(blocks, 1);
                let outside = vary(&data, 1, &rows, &[duration], interrupt)?;
                Some(split(&row_matrix(&outside[0]), 1, 2))
            }
            None => None,
        };
        Ok(BoundaryDerivative {
            span,
            inner: split(&horizontal_matrix(&inside), 1, 2),
            turn: inside.frame,
            outer,
            ends,
            data,
        })
    }
}

impl BoundaryDerivative {
    /// The variation of the initial data of the curve.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent` (the variation breaks a constraint); `Decomposition` where the ends are conjugate:
    /// the solution does not depend smoothly on the data.
    pub fn initial(&self, variation: &BoundaryVariation<'_>) -> Result<InitialVariation> {
        let parts = self.parts(variation)?;
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
        Ok(InitialVariation {
            point: variation.s0.to_owned(),
            velocity: variation.v0.to_owned(),
            acceleration: self.turned(variation, &self.ends[0][2]) + self.up(a) + a_rows,
            jerk: self.turned(variation, &self.ends[0][3]) + self.up(&jerk) + jerk_rows,
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
        let parts = self.parts(variation)?;
        for &t in times {
            check_parameter(t)?;
        }
        let after: Vec<f64> = times.iter().map(|t| t - self.span.0).collect();
        let inside = vary(
            &self.data,
            0,
            std::slice::from_ref(&parts.inside),
            &after,
            interrupt,
        )?;
        let outside = match self.data.frame {
            Some(_) => {
                let rows = unit_variations(blocks_of(&self.data), 1);
                Some(vary(&self.data, 1, &rows, &after, interrupt)?)
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
            out.push(total);
        }
        Ok(out)
    }

    /// The variation of the cost `J`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`.
    pub fn cost(&self, variation: &BoundaryVariation<'_>) -> Result<f64> {
        self.check(variation)?;
        let gradient = self.cost_gradient();
        let product = |a: &Mat<f64>, b: MatRef<'_, f64>| {
            let columns = a.col_iter().zip(b.col_iter());
            columns.map(|(a, b)| a.transpose() * b).sum::<f64>()
        };
        Ok(product(&gradient.s0, variation.s0)
            + product(&gradient.v0, variation.v0)
            + product(&gradient.s1, variation.s1)
            + product(&gradient.v1, variation.v1))
    }

    /// The gradient of the cost `J` with respect to the boundary data.
    ///
    /// ```math
    /// \delta J = 2 \bigl[ \langle D_t S', D\,\delta V \rangle - \langle D_t D_t S', \delta S \rangle \bigr]_0^1,\qquad
    /// D\,\delta V = dV + \Gamma(V, dS)
    /// ```
    ///
    /// By the first variation of `J` at a critical curve: no equation has to be solved, and it exists at conjugate ends too.
    pub fn cost_gradient(&self) -> CostGradient {
        let [[s0, v0], [s1, v1]] = [(-2.0, &self.ends[0]), (2.0, &self.ends[1])].map(end_gradient);
        CostGradient { s0, v0, s1, v1 }
    }

    /// Variations of `x, x', x''` with the start held fixed, after the rotation of everything.
    fn parts(&self, variation: &BoundaryVariation<'_>) -> Result<Parts> {
        self.check(variation)?;
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
            Horizontal::of_tangent(self.turn.as_ref(), low.as_ref())
        });
        let right = difference(
            &pack(&wanted),
            &(&self.inner[0] * column(&pack(std::slice::from_ref(&x)))),
        );
        let y = solve(&self.inner[1], &right)?;
        let [a, second] = unpack(&y, blocks_of(&self.data));
        Ok(Parts {
            inside: [x, a, second],
            outside: self.outside(&dv0, &ends)?,
        })
    }

    /// The parts outside of the span, row by row.
    fn outside(&self, dv0: &Mat<f64>, ends: &[Mat<f64>; 2]) -> Result<[Mat<f64>; 3]> {
        let (n, k) = dv0.shape();
        let mut out = std::array::from_fn(|_| Mat::zeros(n, k));
        let (Some(frame), Some([known, unknown])) = (&self.data.frame, &self.outer) else {
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
            let right = difference(&wanted, &(known * column(&entry(&x))));
            let y = solve(unknown, &right)?;
            for j in 0..k {
                out[1][(row, j)] = y[j];
                out[2][(row, j)] = y[k + j];
            }
        }
        Ok(out)
    }

    /// Coordinates in the frame at the start of what lies in the span.
    fn down(&self, d: &Mat<f64>) -> Mat<f64> {
        let low = self
            .data
            .frame
            .as_ref()
            .map_or(d.clone(), |e| e.transpose() * d);
        self.data.g.transpose() * low
    }

    /// The tangent vector at the start with the given coordinates.
    fn up(&self, x: &Horizontal) -> Mat<f64> {
        let (k, m) = (x.omega.nrows(), x.normal.nrows());
        let low = Mat::from_fn(k + m, k, |i, j| match i.checked_sub(k) {
            None => x.omega[(i, j)],
            Some(i) => x.normal[(i, j)],
        });
        self.lift(&(&self.data.g * low))
    }

    fn lift(&self, low: &Mat<f64>) -> Mat<f64> {
        self.data.frame.as_ref().map_or(low.clone(), |e| e * low)
    }

    /// `A Y` for the skew matrix `A` of least rank with `A S0 = dS0`.
    fn turned(&self, variation: &BoundaryVariation<'_>, y: &Mat<f64>) -> Mat<f64> {
        let s = &self.ends[0][0];
        let inner = s.transpose() * variation.s0;
        let omega = (&inner - inner.transpose()) * Scale(0.5);
        let normal = variation.s0.to_owned() - s * &inner;
        let along = s.transpose() * y;
        &normal * &along - s * (normal.transpose() * y) + s * (omega * along)
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

fn blocks_of(data: &InitialData) -> Sized {
    let k = data.velocity.omega.nrows();
    Sized {
        m: data.g.nrows() - k,
        k,
    }
}

/// Variations of `(x, x', x'')` by one entry each: all of the span, or those of `extra` rows beside it.
fn unit_variations(blocks: Sized, extra: usize) -> Vec<[Horizontal; 3]> {
    let Sized { m, k } = blocks;
    let zero = || Horizontal {
        omega: Mat::zeros(k, k),
        normal: Mat::zeros(m + extra, k),
    };
    let mut all = Vec::new();
    for level in 0..3 {
        let mut push = |change: &dyn Fn(&mut Horizontal)| {
            let mut unit = [zero(), zero(), zero()];
            change(&mut unit[level]);
            all.push(unit);
        };
        if extra > 0 {
            for col in 0..k {
                push(&|x| x.normal[(m, col)] = 1.0);
            }
            continue;
        }
        for col in 0..k {
            for row in 0..col {
                push(&|x| {
                    x.omega[(row, col)] = 1.0;
                    x.omega[(col, row)] = -1.0;
                });
            }
        }
        for col in 0..k {
            for row in 0..m {
                push(&|x| x.normal[(row, col)] = 1.0);
            }
        }
    }
    all
}

/// Horizontal parts of the variations of the end, one column for each direction.
fn horizontal_matrix(slopes: &Slopes) -> Mat<f64> {
    let columns: Vec<Vec<f64>> = slopes
        .points
        .iter()
        .zip(&slopes.velocities)
        .map(|(s, v)| {
            pack(&[s, v].map(|d| Horizontal::of_tangent(slopes.frame.as_ref(), d.as_ref())))
        })
        .collect();
    let rows = columns.first().map_or(0, Vec::len);
    Mat::from_fn(rows, columns.len(), |i, j| columns[j][i])
}

/// Last rows of the variations of point and velocity, one column for each direction.
fn row_matrix(slopes: &Slopes) -> Mat<f64> {
    let (last, k) = (slopes.points[0].nrows() - 1, slopes.points[0].ncols());
    Mat::from_fn(2 * k, slopes.points.len(), |i, j| match i.checked_sub(k) {
        None => slopes.points[j][(last, i)],
        Some(i) => slopes.velocities[j][(last, i)],
    })
}

/// The columns in two parts, in proportion.
fn split(matrix: &Mat<f64>, first: usize, second: usize) -> [Mat<f64>; 2] {
    let (left, right) = matrix
        .as_ref()
        .split_at_col(matrix.ncols() * first / (first + second));
    [left.to_owned(), right.to_owned()]
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

fn column(entries: &[f64]) -> Mat<f64> {
    Mat::from_fn(entries.len(), 1, |i, _| entries[i])
}

fn difference(a: &[f64], b: &Mat<f64>) -> Vec<f64> {
    a.iter().enumerate().map(|(i, a)| a - b[(i, 0)]).collect()
}

fn solve(matrix: &Mat<f64>, right: &[f64]) -> Result<Vec<f64>> {
    if right.is_empty() {
        return Ok(Vec::new());
    }
    solve_square(matrix.as_ref(), right).ok_or(Error::Decomposition {
        kind: "derivative of the boundary value problem (its ends are conjugate) as a linear system",
    })
}

/// `sign * 2` times the gradients of `<a, dV + Gamma(V, dS)> - <j, dS>` with respect to `dS` and `dV`.
fn end_gradient((factor, [s, v, a, j]): (f64, &[Mat<f64>; 4])) -> [Mat<f64>; 2] {
    let metric = |w: &Mat<f64>| w - s * (s.transpose() * w) * Scale(0.5);
    let b = metric(a);
    // The transpose of W -> Gamma(V, W).
    let inner = b.transpose() * s;
    let normal = v - s * (s.transpose() * v);
    let transposed = (s * (b.transpose() * v)
        + &b * (s.transpose() * v)
        + normal * (&inner + inner.transpose()))
        * Scale(0.5);
    [(transposed - metric(j)) * Scale(factor), b * Scale(factor)]
}
