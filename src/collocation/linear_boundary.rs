//! The linearised boundary value problem along a cubic on `[0, 1]`, and its transpose.
//!
//! Let `R` map `y = (p, w, a, b)` to the [terms](super::linear_terms) with brackets and tension, and let `G` solve `p' = w`,
//! `w' = a`, `a' = b`, `b' = 0` with such terms as sources, for `p` and `w` that vanish at both ends. If `y_0` is the cubic
//! polynomial with given `p` and `w` at the ends, then
//!
//! ```math
//! y = y_0 + G R\,y
//! ```
//!
//! an equation of the second kind with a smoothing kernel. At Gauss nodes it is solved by the minimal residual method,
//! which converges faster than linearly. Functions of `y` have gradients with respect to the data at the ends through
//! `lambda = gradient + R^T G^T lambda`, at the same cost.
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 3.1 (collocation); Kelley, Xue
//! (1996), "GMRES and integral operators", SIAM J. Sci. Comput. 17, 217-226.

use std::fmt::{Debug, Formatter};
use std::sync::Arc;

use super::linear_terms::{LEVELS, Terms, Way, in_row, in_span};
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::largest;
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::solve::gmres::{Gmres, norm};
use crate::space::Shape;

/// Solver named in errors.
const SOLVER: &str = "linearised boundary value problem";

/// Accuracy of a solution.
#[derive(Clone, Copy)]
struct Limits {
    /// Residual, relative to right-hand side and solution together, at which the iteration ends.
    wanted: f64,
    /// Largest residual of a solution, the same after the last pass.
    allowed: f64,
}

impl Limits {
    const FINE: Limits = Limits {
        wanted: 1e-15,
        allowed: 2e-14,
    };

    /// Shows solutions of size [`SUSPECT`]: at conjugate ends the residual stays above the part of the data that no
    /// variation reaches, which was 1e-4 and more in examples.
    const ROUGH: Limits = Limits {
        wanted: 1e-7,
        allowed: 1e-7,
    };
}

/// Reduction of the residual by one pass of the minimal residual method. Directions lose their meaning where the residual
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

/// Number of nodes with which to begin for curves at rest, and additional ones for every radian of the largest velocity:
/// enough for curves of constant speed.
const NODES: [f64; 2] = [12.0, 2.2];

/// Maximal number of nodes.
const MOST: usize = 48;

/// Largest Legendre coefficient of the last two degrees of the squared entries of frames, which turn about as fast as
/// variations do: with those below 3e-11, variations of points were as accurate as with 64 nodes, on rest-to-rest curves
/// and others whose speed varies on St(3,1), St(3,2), SO(3), St(4,2) and Gr(4,2). A bound on the velocity alone leaves errors up
/// to 7e-9 on such curves.
const TAIL: f64 = 1e-12;

/// The changes of `x'` and `x''` at the start that move the end of a curve of flat space by one unit in the point and
/// in the velocity.
const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// The linearised equations at Gauss nodes.
pub(crate) struct LinearBoundary {
    nodes: Arc<Nodes>,
    /// Integrals from 0 to the nodes of values at the nodes: rows for the values, and rows for the integrals.
    by_value: Vec<f64>,
    by_integral: Vec<f64>,
    terms: Box<dyn Terms>,
}

/// A variation for given data at the ends.
pub(crate) struct Variation {
    /// `p` at the nodes, one row of nodes per coordinate.
    pub(crate) displacements: Vec<f64>,
    /// `a` and `b` at the start.
    pub(crate) start: [Vec<f64>; 2],
}

/// The nodes with which to begin for a curve with the given largest velocity; `None` if it is too fast.
pub(crate) fn linear_nodes(speed: f64) -> Option<Arc<Nodes>> {
    let wanted = (NODES[0] + NODES[1] * speed).ceil();
    let count = (wanted <= MOST as f64).then_some(wanted as usize)?;
    Some(Nodes::of(count.next_multiple_of(LANES)))
}

/// More nodes; `None` beyond the maximal number.
pub(crate) fn more_nodes(nodes: &Nodes) -> Option<Arc<Nodes>> {
    let count = nodes.len() + LANES;
    (count <= MOST).then(|| Nodes::of(count))
}

/// Whether functions with the given values at the nodes, one row of values per node, are resolved as far as variations
/// need.
pub(crate) fn are_resolved(nodes: &Nodes, values: &[f64]) -> bool {
    let count = nodes.len();
    let width = values.len() / count;
    let mut tail = vec![0.0; 2 * width];
    for (node, row) in values.chunks_exact(width).enumerate() {
        for (degree, sums) in tail.chunks_exact_mut(width).enumerate() {
            add(sums, nodes.tail[degree * count + node], row);
        }
    }
    tail.iter().all(|x| x.abs() <= TAIL)
}

impl Debug for LinearBoundary {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        let mut fields = formatter.debug_struct("LinearBoundary");
        fields.field("nodes", &self.nodes.len());
        fields.finish_non_exhaustive()
    }
}

impl LinearBoundary {
    /// The equations in the span of a curve, from coordinates of `x, x', x''` at the nodes, one node after another.
    pub(crate) fn in_span(shape: Shape, nodes: &Arc<Nodes>, x: [&[f64]; 3], tension: f64) -> Self {
        Self::new(nodes, in_span(shape, x, tension))
    }

    /// The equations of a row outside the span, from the blocks of `x, x', x''` at the nodes, `omega` before `b`.
    pub(crate) fn in_row(shape: Shape, nodes: &Arc<Nodes>, x: [&[f64]; 3], tension: f64) -> Self {
        Self::new(nodes, in_row(shape, x, tension))
    }

    fn new(nodes: &Arc<Nodes>, terms: Box<dyn Terms>) -> Self {
        let count = nodes.len();
        let by_integral = nodes.at[1][..count * count].to_vec();
        let by_value = (0..count * count).map(|i| by_integral[i % count * count + i / count]);
        LinearBoundary {
            by_value: by_value.collect(),
            by_integral,
            nodes: Arc::clone(nodes),
            terms,
        }
    }

    /// Whether variations are bounded for all data at the ends: otherwise the ends may be conjugate.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn is_regular(&self, interrupt: Interrupt<'_>) -> Result<bool> {
        // Irregular data, which no variation that vanishes at the ends leaves out.
        let d = self.terms.dim();
        let ends: Vec<f64> = (0..4 * d).map(|i| (1.0 + 1.7 * i as f64).sin()).collect();
        let right = self.polynomials(std::array::from_fn(|end| &ends[end * d..][..d]));
        let limits = Limits::ROUGH;
        let found = Operator::new(self).solve(&right, Way::Forward, limits, interrupt)?;
        Ok(found.is_some())
    }

    /// The variation with the given `p` and `w` at the start and at the end, in the frames there; `None` if the
    /// equations are not solved to round-off.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn solve(
        &self,
        ends: [&[f64]; 4],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Variation>> {
        let (d, count) = (self.terms.dim(), self.nodes.len());
        let mut operator = Operator::new(self);
        let right = self.polynomials(ends);
        let Some(mut y) = operator.solve(&right, Way::Forward, Limits::FINE, interrupt)? else {
            return Ok(None);
        };
        operator.set_terms(&y, Way::Forward);
        let mut bends = operator.set_flat();
        for (p, bends) in bends.iter_mut().enumerate() {
            let [u0, w0, u1, w1] = ends.map(|end| end[p]);
            for (bend, [point, velocity]) in bends.iter_mut().zip(FLAT) {
                *bend += point * (u1 - u0 - w0) + velocity * (w1 - w0);
            }
        }
        y.truncate(d * count);
        Ok(Some(Variation {
            displacements: y,
            start: [0, 1].map(|i| bends.iter().map(|bend| bend[i]).collect()),
        }))
    }

    /// The gradient with respect to `p` and `w` at the start and at the end of a function of the variation, from its
    /// gradient with respect to `p` at the nodes, one row per coordinate, and to `a` and `b` at the start; `None` as for
    /// [`LinearBoundary::solve`].
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn pull_back(
        &self,
        by_displacements: &[f64],
        [by_a, by_b]: [&[f64]; 2],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<[Vec<f64>; 4]>> {
        let (d, count) = (self.terms.dim(), self.nodes.len());
        let mut operator = Operator::new(self);
        let by_bends: Vec<[f64; 2]> = by_a.iter().zip(by_b).map(|(a, b)| [*a, *b]).collect();
        let mut right = vec![0.0; LEVELS * d * count];
        if by_bends.iter().flatten().any(|x| *x != 0.0) {
            operator.set_flat_transposed(&right, &by_bends);
            operator.set_terms_of_sources();
            right.copy_from_slice(&operator.sources);
        }
        add(&mut right, 1.0, by_displacements);
        let Some(lambda) = operator.solve(&right, Way::Transposed, Limits::FINE, interrupt)? else {
            return Ok(None);
        };
        let basis = self.end_basis();
        let mut out: [Vec<f64>; 4] = std::array::from_fn(|end| {
            let by_end = |p: usize| {
                let levels = basis[end].iter().enumerate();
                levels
                    .map(|(level, basis)| dot(&lambda[(level * d + p) * count..], basis))
                    .sum()
            };
            (0..d).map(by_end).collect()
        });
        for (p, by_bends) in by_bends.iter().enumerate() {
            let [point, velocity] = by_missing(by_bends);
            out[0][p] -= point;
            out[1][p] -= point + velocity;
            out[2][p] += point;
            out[3][p] += velocity;
        }
        Ok(Some(out))
    }

    /// `y_0`.
    fn polynomials(&self, ends: [&[f64]; 4]) -> Vec<f64> {
        let (d, count, basis) = (self.terms.dim(), self.nodes.len(), self.end_basis());
        let mut y = vec![0.0; LEVELS * d * count];
        for (i, row) in y.chunks_exact_mut(count).enumerate() {
            for (end, basis) in ends.iter().zip(&basis) {
                add(row, end[i % d], &basis[i / d]);
            }
        }
        y
    }

    /// For each of `p` and `w` at the start and at the end, the cubic polynomial that is one there and zero for the
    /// others, and its derivatives, at the nodes.
    fn end_basis(&self) -> [[Vec<f64>; LEVELS]; 4] {
        // Coefficients from the constant on.
        const CUBICS: [[f64; 4]; 4] = [
            [1.0, 0.0, -3.0, 2.0],
            [0.0, 1.0, -2.0, 1.0],
            [0.0, 0.0, 3.0, -2.0],
            [0.0, 0.0, -1.0, 1.0],
        ];
        CUBICS.map(|[c0, c1, c2, c3]| {
            let at = |value: &dyn Fn(f64) -> f64| self.nodes.s.iter().map(|s| value(*s)).collect();
            [
                at(&|s| c0 + s * (c1 + s * (c2 + s * c3))),
                at(&|s| c1 + s * (2.0 * c2 + s * 3.0 * c3)),
                at(&|s| 2.0 * c2 + s * 6.0 * c3),
                at(&|_| 6.0 * c3),
            ]
        })
    }
}

/// The gradient with respect to the missing point and velocity, from the one with respect to the changes of `x'` and
/// `x''` at the start that supply them.
fn by_missing(by_bends: &[f64; 2]) -> [f64; 2] {
    [0, 1].map(|part| FLAT[0][part] * by_bends[0] + FLAT[1][part] * by_bends[1])
}

/// The operator `1 - G R` and its transpose, with buffers.
struct Operator<'a> {
    of: &'a LinearBoundary,
    /// Terms as sources, one row of nodes per coordinate, `p` before `w, a, b`.
    sources: Vec<f64>,
    /// The same at eight nodes, before and after.
    here: [Vec<Lanes>; 2],
    buffer: Vec<Lanes>,
    rows: [Vec<f64>; LEVELS],
}

impl<'a> Operator<'a> {
    fn new(of: &'a LinearBoundary) -> Self {
        let (size, count) = (LEVELS * of.terms.dim(), of.nodes.len());
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
    fn solve(
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
        let suspect = SUSPECT[usize::from(self.of.terms.dim() > MANY)];
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
        let size = self.of.terms.dim() * self.of.nodes.len();
        for (level, unit) in y.chunks_exact_mut(size).zip(UNITS) {
            let factor = match way {
                Way::Forward => unit,
                Way::Transposed => unit.recip(),
            };
            level.iter_mut().for_each(|x| *x *= factor);
        }
    }

    /// Sets the sources to `R y` or `R^T y`.
    fn set_terms(&mut self, y: &[f64], way: Way) {
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
    fn set_terms_of_sources(&mut self) {
        // Every group reads its nodes before it writes them.
        let sources = self.sources.clone();
        self.set_terms(&sources, Way::Transposed);
    }

    /// Replaces the sources by `G` of them; returns `a` and `b` at the start, for every coordinate.
    fn set_flat(&mut self) -> Vec<[f64; 2]> {
        let Operator {
            of, sources, rows, ..
        } = self;
        let (s, weights, count) = (&of.nodes.s, &of.nodes.weights, of.nodes.len());
        let d = of.terms.dim();
        let mut all = vec![[0.0; 2]; d];
        vectorised(
            #[inline(always)]
            || {
                for (coordinate, bends) in all.iter_mut().enumerate() {
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
                    *bends =
                        FLAT.map(|[point, velocity]| -point * at_end[0] - velocity * at_end[1]);
                    let [a, b] = *bends;
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
    fn set_flat_transposed(&mut self, y: &[f64], by_start: &[[f64; 2]]) {
        let Operator {
            of, sources, rows, ..
        } = self;
        let (s, weights, count) = (&of.nodes.s, &of.nodes.weights, of.nodes.len());
        let d = of.terms.dim();
        vectorised(
            #[inline(always)]
            || {
                for coordinate in 0..d {
                    let at = |level: usize| (level * d + coordinate) * count;
                    let [p, w, a, b] = [0, 1, 2, 3].map(|level| &y[at(level)..][..count]);
                    let mut by_bends = by_start.get(coordinate).copied().unwrap_or_default();
                    for (i, s) in s.iter().enumerate() {
                        by_bends[0] += a[i] + s * (w[i] + 0.5 * s * p[i]);
                        by_bends[1] += b[i] + s * (a[i] + 0.5 * s * (w[i] + s * p[i] / 3.0));
                    }
                    let [by_point, by_velocity] = by_missing(&by_bends);
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

#[inline(always)]
fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[inline(always)]
fn add(sum: &mut [f64], factor: f64, other: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(other) {
        *sum += factor * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Homogeneous, Kind, Quotient, in_space};

    /// Coordinates of a curve that is no cubic: the equations are linear along any curve. `zero` entries vanish.
    fn curve(nodes: &Nodes, size: usize, zero: impl Fn(usize) -> bool) -> [Vec<f64>; 3] {
        std::array::from_fn(|derivative| {
            let at = |s: &f64| -> Vec<f64> {
                let entry = |p: usize| match zero(p) {
                    true => 0.0,
                    false => ((p + 1) as f64 * 0.9 + s + 1.1 * derivative as f64).sin(),
                };
                (0..size).map(entry).collect()
            };
            nodes.s.iter().flat_map(at).collect()
        })
    }

    fn views(x: &[Vec<f64>; 3]) -> [&[f64]; 3] {
        x.each_ref().map(Vec::as_slice)
    }

    fn numbers(count: usize, seed: f64) -> Vec<f64> {
        let number = |i: usize| (seed + 1.7 * i as f64).sin();
        (0..count).map(number).collect()
    }

    /// Solves forward and transposed with unrelated numbers; the two must agree.
    fn assert_transposed(equations: &LinearBoundary) {
        let (d, count) = (equations.terms.dim(), equations.nodes.len());
        let ends = numbers(4 * d, 0.3);
        let parts: [&[f64]; 4] = std::array::from_fn(|end| &ends[end * d..][..d]);
        let found = equations.solve(parts, Interrupt::NEVER).unwrap().unwrap();
        let by_displacements = numbers(d * count, 0.7);
        let by_start = [numbers(d, 1.1), numbers(d, 1.9)];
        let [by_a, by_b] = by_start.each_ref().map(Vec::as_slice);
        let [a, b] = &found.start;
        let value = dot(&by_displacements, &found.displacements) + dot(by_a, a) + dot(by_b, b);
        let gradient = equations.pull_back(&by_displacements, [by_a, by_b], Interrupt::NEVER);
        let gradient = gradient.unwrap().unwrap().concat();
        let size = norm(&gradient) * norm(&ends);
        let error = (dot(&gradient, &ends) - value).abs() / size;
        assert!(error < 1e-13, "{d}: {error:.1e}");
    }

    fn shapes() -> impl Iterator<Item = Shape> {
        let sizes = [(2, 1), (3, 1), (3, 2), (3, 3), (5, 2), (7, 3)];
        sizes.into_iter().flat_map(|(r, k)| {
            let kinds = [Quotient::Frames, Quotient::Subspaces].map(Kind::real);
            let kinds = kinds
                .into_iter()
                .filter(move |kind| r > k || *kind == Kind::REAL_FRAMES);
            kinds.map(move |kind| Shape { r, k, kind })
        })
    }

    #[test]
    fn the_transpose_is_one() {
        for shape in shapes() {
            let d = in_space!(shape, |space| space.dim());
            let nodes = linear_nodes(1.0).unwrap();
            for tension in [0.0, 3.0] {
                for zero in [0, 2] {
                    let x = curve(&nodes, d, |p| zero > 0 && p % zero == 0);
                    let equations = LinearBoundary::in_span(shape, &nodes, views(&x), tension);
                    assert_transposed(&equations);
                }
                let x = curve(&nodes, shape.r * shape.k, |_| false);
                let equations = LinearBoundary::in_row(shape, &nodes, views(&x), tension);
                assert_transposed(&equations);
            }
        }
    }

    /// A row outside the span is one more row of the space, in which the curve is zero.
    #[test]
    fn rows_are_those_of_a_larger_space() {
        for shape in shapes() {
            let Shape { r, k, kind } = shape;
            let larger = Shape { r: r + 1, ..shape };
            let nodes = linear_nodes(2.0).unwrap();
            // The blocks, with a skew `omega` that is zero for subspaces.
            let mut blocks = curve(&nodes, r * k, |_| false);
            for x in blocks.iter_mut().flat_map(|x| x.chunks_exact_mut(r * k)) {
                let b = x.to_vec();
                for at in 0..k * k {
                    let (i, j) = (at % k, at / k);
                    x[at] = match kind.quotient {
                        Quotient::Frames => b[i + k * j] - b[j + k * i],
                        Quotient::Subspaces => 0.0,
                    };
                }
            }
            let row = LinearBoundary::in_row(shape, &nodes, views(&blocks), 0.5);
            let d = in_space!(larger, |space| space.dim());
            let mut places = vec![0; k];
            let x = blocks.each_ref().map(|x| {
                let mut all = Vec::new();
                for x in x.chunks_exact(r * k) {
                    let mut coordinates = vec![0.0; d];
                    in_space!(larger, |space| space.each_entry(|p, i, j| {
                        match i.checked_sub(k) {
                            None => coordinates[p] = x[i + k * j],
                            Some(i) if i < r - k => {
                                coordinates[p] = x[k * k + i + (r - k) * j];
                            }
                            Some(_) => places[j] = p,
                        }
                    }));
                    all.extend(coordinates);
                }
                all
            });
            let whole = LinearBoundary::in_span(larger, &nodes, views(&x), 0.5);
            let ends = numbers(4 * k, 0.9);
            let short: [&[f64]; 4] = std::array::from_fn(|end| &ends[end * k..][..k]);
            let long = short.map(|end| {
                let mut long = vec![0.0; d];
                for (place, x) in places.iter().zip(end) {
                    long[*place] = *x;
                }
                long
            });
            let found = row.solve(short, Interrupt::NEVER).unwrap().unwrap();
            let long = long.each_ref().map(Vec::as_slice);
            let expected = whole.solve(long, Interrupt::NEVER).unwrap().unwrap();
            let count = nodes.len();
            for (j, place) in places.iter().enumerate() {
                let [found, expected] = [
                    &found.displacements[j * count..][..count],
                    &expected.displacements[place * count..][..count],
                ];
                for (x, y) in found.iter().zip(expected) {
                    assert!((x - y).abs() < 1e-12, "{shape:?}: {x} {y}");
                }
            }
        }
    }

    #[test]
    fn fast_curves_have_no_nodes() {
        assert!(linear_nodes(40.0).is_none());
        assert!(linear_nodes(f64::NAN).is_none());
    }
}
