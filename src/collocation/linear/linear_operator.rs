//! The operator `1 - G R` of the [linearised boundary value problem](super::linear_boundary) and its transpose, and their
//! equations by GMRES.
//!
//! In the units `1, 2, 6, 12` for `p, w, a, b` (and their reciprocals for the transpose) the parts of a solution are about
//! equally large, so that a small residual means a small error of each. The method is repeated for the residual that it has
//! left, until that is round-off.
//!
//! # Source
//! Saad, Schultz (1986), "GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear systems",
//! SIAM J. Sci. Stat. Comput. 7, 856-869; Kelley, Xue (1996), "GMRES and integral operators", SIAM J. Sci. Comput. 17,
//! 217-226.

use std::sync::Arc;

use super::linear_nodes::MOST;
use super::linear_terms::{LEVELS, Terms, Way};
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::{add, largest};
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::solve::gmres::{Gmres, dot, norm};

/// Solver named in errors.
const SOLVER: &str = "linearised boundary value problem";

/// Accuracy of a solution.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    /// Residual, relative to right-hand side and solution together, at which the iteration ends.
    wanted: f64,
    /// Largest residual of a solution, the same after the last pass.
    allowed: f64,
}

impl Limits {
    pub(crate) const FINE: Limits = Limits {
        wanted: 1e-15,
        allowed: 2e-14,
    };

    /// Shows solutions of size [`SUSPECT`]: at conjugate ends the residual stays above the part of the data that no
    /// variation reaches, which was 1e-4 and more in examples.
    pub(crate) const ROUGH: Limits = Limits {
        wanted: 1e-7,
        allowed: 1e-7,
    };
}

/// Reduction of the residual by one pass of GMRES. Directions lose their meaning where the residual
/// is round-off: a single pass to 1e-15 takes up to forty products instead of about twelve.
const PASS: f64 = 1e-8;

/// A pass that leaves a larger fraction of the residual is the last one: the rest is round-off.
const PROGRESS: f64 = 0.1;

/// Units of `p, w, a, b` in which residuals are measured: the derivatives of cubic polynomials are that much larger.
const UNITS: [f64; LEVELS] = [1.0, 2.0, 6.0, 12.0];

/// Maximal number of passes, each for the residual that the previous one has left.
const MAX_PASSES: usize = 4;

/// Largest solution, relative to the right-hand side: beyond it the ends may be conjugate, which this method cannot
/// show. In more than [`MANY`] dimensions the series that can show it are expensive, and the limit is larger.
const SUSPECT: [f64; 2] = [1e2, 1e4];
const MANY: usize = 64;

/// Largest residual that the first pass may leave: beyond it the curve is too fast for this method. In 13 and 21
/// dimensions, three passes then leave 6e-8 and 3e-4.
const SLOW: f64 = 1e-4;

/// The changes of `x'` and `x''` at the start that move the end of a curve of flat space by one unit in the point and
/// in the velocity.
pub(crate) const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// The gradient with respect to the missing point and velocity, from the one with respect to the changes of `x'` and
/// `x''` at the start that supply them.
pub(crate) fn by_missing(by_derivatives: &[f64; 2]) -> [f64; 2] {
    [0, 1].map(|part| FLAT[0][part] * by_derivatives[0] + FLAT[1][part] * by_derivatives[1])
}

/// The terms and the integrals from which the operator is built.
pub(crate) struct Equations {
    pub(crate) nodes: Arc<Nodes>,
    /// Integrals from 0 to the nodes of values at the nodes: rows for the values, and rows for the integrals.
    by_value: Vec<f64>,
    by_integral: Vec<f64>,
    terms: Box<dyn Terms>,
}

impl Equations {
    pub(crate) fn new(nodes: &Arc<Nodes>, terms: Box<dyn Terms>) -> Self {
        let count = nodes.len();
        let by_integral = nodes.at[1][..count * count].to_vec();
        let by_value = (0..count * count).map(|i| by_integral[i % count * count + i / count]);
        Equations {
            by_value: by_value.collect(),
            by_integral,
            nodes: Arc::clone(nodes),
            terms,
        }
    }

    /// Number of coordinates of each of `p, w, a, b`.
    pub(crate) fn dim(&self) -> usize {
        self.terms.dim()
    }
}

/// The operator `1 - G R` and its transpose, with buffers.
pub(crate) struct Operator<'a> {
    of: &'a Equations,
    /// Terms as sources, one row of nodes per coordinate, `p` before `w, a, b`.
    pub(crate) sources: Vec<f64>,
    /// The same at eight nodes, before and after.
    here: [Vec<Lanes>; 2],
    buffer: Vec<Lanes>,
    rows: [Vec<f64>; LEVELS],
}

impl<'a> Operator<'a> {
    pub(crate) fn new(of: &'a Equations) -> Self {
        let (size, count) = (LEVELS * of.dim(), of.nodes.len());
        Operator {
            of,
            sources: vec![0.0; size * count],
            here: std::array::from_fn(|_| vec![Lanes::ZERO; size]),
            buffer: vec![Lanes::ZERO; of.terms.buffer()],
            rows: std::array::from_fn(|_| vec![0.0; count]),
        }
    }

    /// The solution for a right-hand side; `None` if the residual stays above round-off, or if the solution is
    /// suspiciously large.
    pub(crate) fn solve(
        &mut self,
        right: &[f64],
        way: Way,
        limits: Limits,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Vec<f64>>> {
        let size = largest(right);
        if size == 0.0 {
            return Ok(Some(right.to_vec()));
        }
        if !size.is_finite() {
            return Ok(None);
        }
        // Squares must neither overflow nor vanish.
        let mut right: Vec<f64> = right.iter().map(|x| x / size).collect();
        self.rescale(&mut right, way.inverse());
        let suspect = SUSPECT[usize::from(self.of.dim() > MANY)];
        let (mut solution, mut rest) = (vec![0.0; right.len()], right.clone());
        let mut image = vec![0.0; right.len()];
        let mut gmres = Gmres::new(right.len());
        let (before, mut last) = (norm(&right), f64::INFINITY);
        for _ in 0..MAX_PASSES {
            gmres.try_solve(&mut rest, limits.wanted.max(PASS), |y, image| {
                interrupt.check(SOLVER)?;
                self.apply(y, image, way);
                Result::Ok(())
            })?;
            add(&mut solution, 1.0, &rest);
            self.apply(&solution, &mut image, way);
            rest.copy_from_slice(&right);
            add(&mut rest, -1.0, &image);
            let found = norm(&solution);
            if found.is_nan() || found > suspect * before {
                return Ok(None);
            }
            let left = norm(&rest) / (found + before);
            if last.is_infinite() && left > SLOW {
                return Ok(None);
            }
            if left <= limits.wanted || left > PROGRESS * last {
                last = left;
                break;
            }
            last = left;
        }
        self.rescale(&mut solution, way);
        solution.iter_mut().for_each(|x| *x *= size);
        Ok((last <= limits.allowed).then_some(solution))
    }

    /// The operator on vectors in their [`UNITS`].
    fn apply(&mut self, y: &[f64], image: &mut [f64], way: Way) {
        image.copy_from_slice(y);
        self.rescale(image, way);
        match way {
            Way::Forward => {
                self.set_terms(image, way);
                self.set_flat();
            }
            Way::Transposed => {
                self.set_flat_transposed(image, &[]);
                self.set_terms_of_sources();
            }
        }
        image.copy_from_slice(&self.sources);
        self.rescale(image, way.inverse());
        for (image, y) in image.iter_mut().zip(y) {
            *image = y - *image;
        }
    }

    /// Converts from units: `p, w, a, b` forward, their duals transposed.
    fn rescale(&self, y: &mut [f64], way: Way) {
        let size = self.of.dim() * self.of.nodes.len();
        for (level, unit) in y.chunks_exact_mut(size).zip(UNITS) {
            let factor = match way {
                Way::Forward => unit,
                Way::Transposed => unit.recip(),
            };
            level.iter_mut().for_each(|x| *x *= factor);
        }
    }

    /// Sets the sources to `R y` or `R^T y`.
    pub(crate) fn set_terms(&mut self, y: &[f64], way: Way) {
        let Operator {
            of,
            sources,
            here: [before, after],
            buffer,
            ..
        } = self;
        let count = of.nodes.len();
        for group in 0..count / LANES {
            let at = group * LANES;
            for (x, row) in before.iter_mut().zip(y.chunks_exact(count)) {
                x.0.copy_from_slice(&row[at..][..LANES]);
            }
            of.terms.set(group, way, before, buffer, after);
            for (x, row) in after.iter().zip(sources.chunks_exact_mut(count)) {
                row[at..][..LANES].copy_from_slice(&x.0);
            }
        }
    }

    /// Replaces the sources by `R^T` of them.
    pub(crate) fn set_terms_of_sources(&mut self) {
        // Every group reads its nodes before it writes them.
        let sources = self.sources.clone();
        self.set_terms(&sources, Way::Transposed);
    }

    /// Replaces the sources by `G` of them; returns `a` and `b` at the start, for every coordinate.
    pub(crate) fn set_flat(&mut self) -> Vec<[f64; 2]> {
        let Operator {
            of, sources, rows, ..
        } = self;
        let (s, weights, count) = (&of.nodes.s, &of.nodes.weights, of.nodes.len());
        let d = of.dim();
        let mut all = vec![[0.0; 2]; d];
        vectorised(
            #[inline(always)]
            || {
                for (coordinate, derivatives) in all.iter_mut().enumerate() {
                    let at = |level: usize| (level * d + coordinate) * count;
                    // From `b` to `p`: integrals of a source and of the integral before.
                    let mut at_end = [0.0; LEVELS];
                    for level in (0..LEVELS).rev() {
                        let (lower, upper) = rows.split_at_mut(level + 1);
                        let row = &mut lower[level];
                        row.copy_from_slice(&sources[at(level)..][..count]);
                        if let Some(upper) = upper.first() {
                            add(row, 1.0, upper);
                        }
                        at_end[level] = dot(row, weights);
                        integrate(&of.by_value, row);
                    }
                    *derivatives =
                        FLAT.map(|[point, velocity]| -point * at_end[0] - velocity * at_end[1]);
                    let [a, b] = *derivatives;
                    for (i, s) in s.iter().enumerate() {
                        sources[at(0) + i] = rows[0][i] + (0.5 * a + s * b / 6.0) * s * s;
                        sources[at(1) + i] = rows[1][i] + (a + 0.5 * s * b) * s;
                        sources[at(2) + i] = rows[2][i] + a + s * b;
                        sources[at(3) + i] = rows[3][i] + b;
                    }
                }
            },
        );
        all
    }

    /// Sets the sources to `G^T y`, plus the transpose of the map to `a` and `b` at the start, if gradients with respect
    /// to these are given.
    pub(crate) fn set_flat_transposed(&mut self, y: &[f64], by_start: &[[f64; 2]]) {
        let Operator {
            of, sources, rows, ..
        } = self;
        let (s, weights, count) = (&of.nodes.s, &of.nodes.weights, of.nodes.len());
        let d = of.dim();
        vectorised(
            #[inline(always)]
            || {
                for coordinate in 0..d {
                    let at = |level: usize| (level * d + coordinate) * count;
                    let [p, w, a, b] = [0, 1, 2, 3].map(|level| &y[at(level)..][..count]);
                    let mut by_derivatives = by_start.get(coordinate).copied().unwrap_or_default();
                    for (i, s) in s.iter().enumerate() {
                        by_derivatives[0] += a[i] + s * (w[i] + 0.5 * s * p[i]);
                        by_derivatives[1] += b[i] + s * (a[i] + 0.5 * s * (w[i] + s * p[i] / 3.0));
                    }
                    let [by_point, by_velocity] = by_missing(&by_derivatives);
                    let by_end = [-by_point, -by_velocity, 0.0, 0.0];
                    let row = &mut rows[0];
                    row.fill(0.0);
                    for (level, by_level) in [p, w, a, b].into_iter().enumerate() {
                        add(row, 1.0, by_level);
                        integrate(&of.by_integral, row);
                        add(row, by_end[level], weights);
                        sources[at(level)..][..count].copy_from_slice(row);
                    }
                }
            },
        );
    }
}

/// Replaces a row by the sum of the rows of a matrix times its entries.
#[inline(always)]
fn integrate(matrix: &[f64], row: &mut [f64]) {
    let mut sums = [0.0; MOST];
    for (x, integrals) in row.iter().zip(matrix.chunks_exact(row.len())) {
        add(&mut sums, *x, integrals);
    }
    row.copy_from_slice(&sums[..row.len()]);
}
