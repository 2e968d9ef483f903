//! The linear equations of a variation of boundary data: how the end of a curve answers to its initial data.
//!
//! ```math
//! E_y\,\delta y = \delta E - E_x\,\delta x,\qquad y = (x', x'')
//! ```
//!
//! Unknowns are measured by the change of point and velocity that they make in flat space, where
//! `s = a t^2 / 2 + x'' t^3 / 6` and `t v = a t^2 + x'' t^3 / 2`: then the matrix has no units, and is near the identity for
//! slow curves. Its singular values tell how far the ends are from conjugate ones.

use faer::Mat;

use super::initial::{Horizontal, InitialData};
use super::problem::{pack, unpack};
use super::reduced::Sized;
use super::variation::{Slopes, vary};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::{singular_range, solve_matrix, solve_square};
use crate::linalg::gmres::{Gmres, norm};

/// Unknowns up to which the matrix is formed; above, products with it are cheaper (as for shooting).
const DENSE: usize = 64;

/// Ends whose smallest singular value is below this share of the largest count as conjugate.
///
/// Ten times what boundary problems are solved to by default: ends that are no nearer cannot be told from conjugate ones.
const CONJUGATE: f64 = 1e-11;

/// Share of a right-hand side that one pass of the minimal residual method leaves.
const PASS: f64 = 1e-8;

/// Passes; each starts from what the last one left, so that errors of the products do not add up.
const MAX_PASSES: usize = 4;

/// What is left in the end, relative to right-hand side and solution together: the matrix is of size one.
const RESIDUAL: f64 = 1e-13;

/// A solution that is so many times its right-hand side is left to the matrix, which shows whether the ends are conjugate.
const SUSPECT: f64 = 1e4;

/// What an `Overflow` is about.
pub(super) const VARIATION: &str = "variation of a Riemannian cubic";

/// The equations of one block of coordinates, as a matrix.
#[derive(Debug, Clone)]
pub(super) struct Response {
    /// Derivative of the end with respect to `x`, rows of the velocity times the duration.
    known: Mat<f64>,
    /// With respect to the unknowns in the measure of flat space.
    unknown: Mat<f64>,
    /// The smallest and the largest singular value of it.
    singular: [f64; 2],
    duration: f64,
}

impl Response {
    /// From the derivative of point and velocity with respect to `(x, x', x'')`, shape `(2d, 3d)`.
    ///
    /// # Errors
    /// `Overflow`, `Decomposition`.
    pub(super) fn new(matrix: &Mat<f64>, duration: f64) -> Result<Self> {
        let d = matrix.nrows() / 2;
        let row = |i: usize, entry: f64| if i < d { entry } else { duration * entry };
        let known = Mat::from_fn(2 * d, d, |i, j| row(i, matrix[(i, j)]));
        let unknown = Mat::from_fn(2 * d, 2 * d, |i, j| {
            let [a, second] = flat(usize::from(j >= d), duration);
            row(
                i,
                a * matrix[(i, d + j % d)] + second * matrix[(i, 2 * d + j % d)],
            )
        });
        Ok(Response {
            singular: singular_range(unknown.as_ref())?,
            known,
            unknown,
            duration,
        })
    }

    /// The `(x', x'')` that, with the variation of `x`, move the end as wanted.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`.
    pub(super) fn solve(&self, x: &[f64], wanted: &[f64]) -> Result<Vec<f64>> {
        if wanted.is_empty() {
            return Ok(Vec::new());
        }
        let mut right = measured(wanted, self.duration);
        for (i, right) in right.iter_mut().enumerate() {
            for (j, x) in x.iter().enumerate() {
                *right -= self.known[(i, j)] * x;
            }
        }
        if !right.iter().all(|entry| entry.is_finite()) {
            return Err(Error::Overflow {
                quantity: VARIATION,
            });
        }
        self.check_singular()?;
        let [smallest, largest] = self.singular;
        let solution = solve_square(self.unknown.as_ref(), &right)
            .ok_or(Error::ConjugateEnds { smallest, largest })?;
        Ok(unmeasured(&solution, self.duration))
    }

    /// The `(x', x'')` that move the end by each column, with the start where it is.
    ///
    /// # Errors
    /// `ConjugateEnds`.
    pub(super) fn solve_all(&self, wanted: &Mat<f64>) -> Result<Mat<f64>> {
        self.check_singular()?;
        let d = wanted.nrows() / 2;
        let right = Mat::from_fn(2 * d, wanted.ncols(), |i, j| match i < d {
            true => wanted[(i, j)],
            false => self.duration * wanted[(i, j)],
        });
        let [smallest, largest] = self.singular;
        let solution = solve_matrix(self.unknown.as_ref(), right.as_ref())
            .ok_or(Error::ConjugateEnds { smallest, largest })?;
        let factors = [0, 1].map(|which| flat(which, self.duration));
        Ok(Mat::from_fn(2 * d, wanted.ncols(), |i, j| {
            let (level, row) = (i / d, i % d);
            factors[0][level] * solution[(row, j)] + factors[1][level] * solution[(d + row, j)]
        }))
    }

    /// The gradients of a linear function of `(x', x'')` with respect to the variation of `x` and to that of the end, through
    /// the equations: `y` such that the function changes by `<y_x, x> + <y_end, wanted>`.
    ///
    /// # Errors
    /// `ConjugateEnds`.
    pub(super) fn solve_transposed(&self, bar: &[f64]) -> Result<[Vec<f64>; 2]> {
        if bar.is_empty() {
            return Ok([Vec::new(), Vec::new()]);
        }
        self.check_singular()?;
        let d = bar.len() / 2;
        let factors = [0, 1].map(|which| flat(which, self.duration));
        let right: Vec<f64> = (0..2 * d)
            .map(|i| factors[i / d][0] * bar[i % d] + factors[i / d][1] * bar[d + i % d])
            .collect();
        let [smallest, largest] = self.singular;
        let multiplier = solve_square(self.unknown.transpose(), &right)
            .ok_or(Error::ConjugateEnds { smallest, largest })?;
        let row = |j: usize| {
            (0..2 * d)
                .map(|i| self.known[(i, j)] * multiplier[i])
                .sum::<f64>()
        };
        let by_known = (0..d).map(|j| -row(j)).collect();
        Ok([by_known, measured(&multiplier, self.duration)])
    }

    fn check_singular(&self) -> Result<()> {
        let [smallest, largest] = self.singular;
        if smallest > CONJUGATE * largest {
            return Ok(());
        }
        Err(Error::ConjugateEnds { smallest, largest })
    }
}

/// The equations in the span of the data, as a matrix where that is small.
#[derive(Debug, Clone)]
pub(super) struct SpanResponse {
    matrix: Option<Response>,
    /// The frame at the end, in the coordinates of the frame at the start.
    pub(super) turn: Mat<f64>,
    duration: f64,
}

impl SpanResponse {
    /// # Errors
    /// `Overflow`, `NoConvergence`, `Interrupted`; `Decomposition`.
    pub(super) fn new(data: &InitialData, duration: f64, interrupt: Interrupt<'_>) -> Result<Self> {
        let blocks = blocks_of(data);
        let Sized { m, k } = blocks;
        if k * (k - 1) + 2 * m * k <= DENSE {
            let slopes = matrix_slopes(data, duration, interrupt)?;
            let matrix = Response::new(&horizontal_matrix(&slopes), duration)?;
            return Ok(SpanResponse {
                matrix: Some(matrix),
                turn: slopes.frame,
                duration,
            });
        }
        let slopes = at_end(vary::<1>(data, 0, &[], &[duration], interrupt)?);
        Ok(SpanResponse {
            matrix: None,
            turn: slopes.frame,
            duration,
        })
    }

    /// The `(x', x'')` that, with the variation of `x`, move point and velocity at the end as wanted.
    ///
    /// # Errors
    /// `ConjugateEnds`; without a matrix `Overflow`, `NoConvergence`, `Interrupted`, `Decomposition` too.
    pub(super) fn solve(
        &self,
        data: &InitialData,
        x: &Horizontal,
        wanted: &[Horizontal; 2],
        interrupt: Interrupt<'_>,
    ) -> Result<[Horizontal; 2]> {
        let (known, wanted) = (pack(std::slice::from_ref(x)), pack(wanted));
        let solution = match &self.matrix {
            Some(matrix) => matrix.solve(&known, &wanted)?,
            None => match self.solve_by_products(data, x, &wanted, interrupt)? {
                Some(solution) => solution,
                None => {
                    let slopes = matrix_slopes(data, self.duration, interrupt)?;
                    Response::new(&horizontal_matrix(&slopes), self.duration)?
                        .solve(&known, &wanted)?
                }
            },
        };
        Ok(unpack(&solution, blocks_of(data)))
    }

    /// The same by the minimal residual method; none where it does not converge, or to a suspiciously large solution.
    fn solve_by_products(
        &self,
        data: &InitialData,
        x: &Horizontal,
        wanted: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Vec<f64>>> {
        let t = self.duration;
        let answer = |direction: [Horizontal; 3]| -> Result<Vec<f64>> {
            let slopes = at_end(vary::<1>(data, 0, &[direction], &[t], interrupt)?);
            let [s, v] = [&slopes.points[0], &slopes.velocities[0]]
                .map(|d| Horizontal::of_tangent(slopes.frame.as_ref(), d.as_ref()));
            Ok(measured(&pack(&[s, v]), t))
        };
        let blocks = blocks_of(data);
        let product = |w: &[f64]| -> Result<Vec<f64>> {
            let [a, second] = unpack(&unmeasured(w, t), blocks);
            answer([Horizontal::zeros(blocks), a, second])
        };
        let still = Horizontal::zeros(blocks);
        let known = answer([x.clone(), still.clone(), still])?;
        let right = difference(&measured(wanted, t), &known);
        let (mut solution, mut rest) = (vec![0.0; right.len()], right.clone());
        for _ in 0..MAX_PASSES {
            let mut failure = None;
            let mut step = rest;
            Gmres::new(right.len()).solve(&mut step, PASS, |w, image| match product(w) {
                Ok(found) => image.copy_from_slice(&found),
                Err(error) => {
                    image.fill(0.0);
                    failure = Some(error);
                }
            });
            if let Some(error) = failure {
                return Err(error);
            }
            for (x, step) in solution.iter_mut().zip(&step) {
                *x += step;
            }
            rest = difference(&right, &product(&solution)?);
            let size = norm(&solution);
            if !size.is_finite() || size > SUSPECT * norm(&right) {
                return Ok(None);
            }
            if norm(&rest) <= RESIDUAL * (norm(&right) + size) {
                return Ok(Some(unmeasured(&solution, t)));
            }
        }
        Ok(None)
    }
}

/// Rows of the block outside of the span, from variations by the unit vectors of one such row.
///
/// # Errors
/// `Overflow`, `Decomposition`.
pub(super) fn outer_response(slopes: &Slopes, duration: f64) -> Result<Response> {
    Response::new(&row_matrix(slopes), duration)
}

/// Rows and columns of the blocks of initial data.
pub(super) fn blocks_of(data: &InitialData) -> Sized {
    let k = data.velocity.omega.nrows();
    Sized {
        m: data.g.nrows() - k,
        k,
    }
}

/// Changes `(x', x'')` that move the end of a curve of flat space by a unit in the point (0), or in velocity times
/// duration (1).
fn flat(which: usize, t: f64) -> [f64; 2] {
    let [a, second] = [[6.0, -12.0], [-2.0, 6.0]][which];
    [a / t / t, second / t / t / t]
}

/// Velocities times the duration.
fn measured(ends: &[f64], duration: f64) -> Vec<f64> {
    let half = ends.len() / 2;
    let scaled = |(i, x): (usize, &f64)| if i < half { *x } else { duration * x };
    ends.iter().enumerate().map(scaled).collect()
}

/// `(x', x'')` of unknowns in the measure of flat space.
fn unmeasured(w: &[f64], duration: f64) -> Vec<f64> {
    let (points, velocities) = w.split_at(w.len() / 2);
    let factors = [0, 1].map(|which| flat(which, duration));
    let level = |i: usize| {
        let pairs = points.iter().zip(velocities);
        pairs.map(move |(s, v)| factors[0][i] * s + factors[1][i] * v)
    };
    level(0).chain(level(1)).collect()
}

/// Variations of the end by every entry of `(x, x', x'')`.
fn matrix_slopes(data: &InitialData, t: f64, interrupt: Interrupt<'_>) -> Result<Slopes> {
    let directions = unit_variations(blocks_of(data));
    Ok(at_end(vary::<8>(data, 0, &directions, &[t], interrupt)?))
}

fn at_end(slopes: Vec<Slopes>) -> Slopes {
    slopes.into_iter().next().expect("one time")
}

/// Variations of `(x, x', x'')` by one independent entry each.
pub(super) fn unit_variations(blocks: Sized) -> Vec<[Horizontal; 3]> {
    let Sized { m, k } = blocks;
    let mut all = Vec::new();
    for level in 0..3 {
        let mut push = |change: &dyn Fn(&mut Horizontal)| {
            let mut unit = std::array::from_fn(|_| Horizontal::zeros(blocks));
            change(&mut unit[level]);
            all.push(unit);
        };
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

/// Variations of `(x, x', x'')` by one entry each of a row beside the span.
pub(super) fn row_variations(blocks: Sized) -> Vec<[Horizontal; 3]> {
    let Sized { m, k } = blocks;
    let mut all = Vec::new();
    for level in 0..3 {
        for col in 0..k {
            let longer = Sized { m: m + 1, k };
            let mut unit = std::array::from_fn(|_| Horizontal::zeros(longer));
            unit[level].normal[(m, col)] = 1.0;
            all.push(unit);
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
pub(super) fn row_matrix(slopes: &Slopes) -> Mat<f64> {
    let (last, k) = (slopes.points[0].nrows() - 1, slopes.points[0].ncols());
    Mat::from_fn(2 * k, slopes.points.len(), |i, j| match i.checked_sub(k) {
        None => slopes.points[j][(last, i)],
        Some(i) => slopes.velocities[j][(last, i)],
    })
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
