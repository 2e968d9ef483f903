//! The linearised boundary value problem along a cubic on `[0, 1]`, and its transpose.
//!
//! At Gauss nodes it is an equation of the second kind with a smoothing kernel, the one of Newton's method for such problems
//! ([`Operator`]). GMRES converges faster than linearly; it is repeated for the residual that it has left, until that is
//! round-off. Functions of the solution have gradients with respect to the data at the ends through the transposed equation,
//! at the same cost.
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 3.1 (collocation); Kelley, Xue
//! (1996), "GMRES and integral operators", SIAM J. Sci. Comput. 17, 217-226.

use std::fmt::{Debug, Formatter};
use std::sync::Arc;

use super::linear_operator::{Operator, Way};
use super::linear_row::in_row;
use super::linear_terms::{CurveAtNodes, Terms, in_span};
use crate::collocation::lane_nodes::LaneNodes;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::{add, largest};
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
        wanted: 1e-5,
        allowed: 1e-5,
    };
}

/// Reduction of the residual by one pass of GMRES. Directions lose their meaning where the residual
/// is round-off: a single pass to 1e-15 takes up to forty products instead of about twelve.
const PASS: f64 = 1e-8;

/// A pass that leaves a larger fraction of the residual is the last one: the rest is round-off.
const PROGRESS: f64 = 0.1;

/// Maximal number of passes, each for the residual that the previous one has left.
const MAX_PASSES: usize = 4;

/// Largest solution, relative to the right-hand side: beyond it the ends may be conjugate, which this method cannot
/// show. In more than [`MANY`] dimensions the series that can show it are expensive, and the limit is larger.
const SUSPECT: [f64; 2] = [1e2, 1e4];
const MANY: usize = 64;

/// Largest residual that the first pass may leave: beyond it the curve is too fast for this method. In 13 and 21
/// dimensions, three passes then leave 6e-8 and 3e-4.
const SLOW: f64 = 1e-4;

/// The linearised equations at Gauss nodes, for given data at the ends.
pub(crate) struct LinearBoundary {
    terms: Box<dyn Terms>,
    nodes: Arc<LaneNodes>,
    tension: f64,
}

/// A variation for given data at the ends.
pub(crate) struct BoundaryResponse {
    /// Displacements at the nodes, one node after another.
    pub(crate) displacements: Vec<f64>,
    /// Changes of `x'` and `x''` at the start.
    pub(crate) start: [Vec<f64>; 2],
}

impl Debug for LinearBoundary {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        let mut fields = formatter.debug_struct("LinearBoundary");
        fields.field("nodes", &self.nodes.count());
        fields.finish_non_exhaustive()
    }
}

impl LinearBoundary {
    /// The equations in the span of a curve, from coordinates of its vectors.
    pub(crate) fn in_span(
        shape: Shape,
        nodes: &Arc<LaneNodes>,
        curve: CurveAtNodes<'_>,
        tension: f64,
    ) -> Self {
        Self::new(in_span(shape, curve), nodes, tension)
    }

    /// The equations of a row outside the span, from the blocks of vectors, `omega` before `b`.
    pub(crate) fn in_row(
        shape: Shape,
        nodes: &Arc<LaneNodes>,
        curve: CurveAtNodes<'_>,
        tension: f64,
    ) -> Self {
        Self::new(in_row(shape, curve), nodes, tension)
    }

    fn new(terms: Box<dyn Terms>, nodes: &Arc<LaneNodes>, tension: f64) -> Self {
        LinearBoundary {
            terms,
            nodes: Arc::clone(nodes),
            tension,
        }
    }

    fn operator(&self) -> Operator<'_> {
        Operator::new(&*self.terms, &self.nodes, self.tension)
    }

    /// Whether variations are bounded for all data at the ends: otherwise the ends may be conjugate.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn is_regular(&self, interrupt: Interrupt<'_>) -> Result<bool> {
        // Irregular data, which no variation that vanishes at the ends leaves out.
        let d = self.terms.dim();
        let ends: Vec<f64> = (0..4 * d).map(|i| (1.0 + 1.7 * i as f64).sin()).collect();
        let mut operator = self.operator();
        let right = operator.right_hand_side(std::array::from_fn(|end| &ends[end * d..][..d]));
        let found = solved(
            &mut operator,
            (right, Way::Forward),
            Limits::ROUGH,
            interrupt,
        )?;
        Ok(found.is_some())
    }

    /// The variation with the given displacement and change of the velocity at the start and at the end, in the frames
    /// there; `None` if the equations are not solved to round-off.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn solve(
        &self,
        ends: [&[f64]; 4],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<BoundaryResponse>> {
        let d = self.terms.dim();
        let mut operator = self.operator();
        let right = operator.right_hand_side(ends);
        let found = solved(
            &mut operator,
            (right, Way::Forward),
            Limits::FINE,
            interrupt,
        )?;
        Ok(found.map(|y| BoundaryResponse {
            displacements: operator.displacements([ends[0], ends[1]], &y),
            start: [y[..d].to_vec(), y[d..2 * d].to_vec()],
        }))
    }

    /// The gradient with respect to displacement and change of the velocity at the start and at the end of a function of the
    /// variation, from its gradient with respect to displacements at the nodes, one node after another, and to the changes of
    /// `x'` and `x''` at the start; `None` as for [`LinearBoundary::solve`].
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn pull_back(
        &self,
        by_displacements: &[f64],
        by_derivatives: [&[f64]; 2],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<[Vec<f64>; 4]>> {
        let d = self.terms.dim();
        let mut operator = self.operator();
        let (direct, mut right) = operator.displacements_transposed(by_displacements);
        for (right, by_derivative) in right.chunks_exact_mut(d).zip(by_derivatives) {
            add(right, 1.0, by_derivative);
        }
        let way = Way::Transposed;
        let Some(y) = solved(&mut operator, (right, way), Limits::FINE, interrupt)? else {
            return Ok(None);
        };
        let mut out = operator.right_hand_side_transposed(&y);
        for (out, direct) in out.iter_mut().zip(&direct) {
            add(out, 1.0, direct);
        }
        Ok(Some(out))
    }
}

/// The solution for a right-hand side; `None` if the residual stays above round-off, or if the solution is suspiciously
/// large.
///
/// # Errors
/// `Interrupted`.
fn solved(
    operator: &mut Operator<'_>,
    (mut right, way): (Vec<f64>, Way),
    limits: Limits,
    interrupt: Interrupt<'_>,
) -> Result<Option<Vec<f64>>> {
    let size = largest(&right);
    if size == 0.0 {
        return Ok(Some(right));
    }
    if !size.is_finite() {
        return Ok(None);
    }
    // Squares must neither overflow nor vanish.
    right.iter_mut().for_each(|x| *x /= size);
    let suspect = SUSPECT[usize::from(operator.dim() > MANY)];
    let (mut solution, mut rest) = (vec![0.0; right.len()], right.clone());
    let mut image = vec![0.0; right.len()];
    let mut gmres = Gmres::new(right.len());
    let (before, mut last) = (norm(&right), f64::INFINITY);
    for _ in 0..MAX_PASSES {
        gmres.try_solve(&mut rest, limits.wanted.max(PASS), |y, image| {
            interrupt.check(SOLVER)?;
            operator.apply(y, image, way);
            Result::Ok(())
        })?;
        add(&mut solution, 1.0, &rest);
        operator.apply(&solution, &mut image, way);
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
        let is_last = left <= limits.wanted || left > PROGRESS * last;
        last = left;
        if is_last {
            break;
        }
    }
    solution.iter_mut().for_each(|x| *x *= size);
    Ok((last <= limits.allowed).then_some(solution))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collocation::linear_nodes;
    use crate::solve::gmres::dot;
    use crate::space::{Homogeneous, Kind, Quotient, in_space};

    /// A curve that is no cubic, with frames that are not its own: the equations are linear for any.
    struct Curve {
        x: [Vec<f64>; 3],
        last: Vec<f64>,
        frames: Vec<f64>,
        end: Vec<f64>,
    }

    impl Curve {
        /// Coordinates or blocks of a given size; `zero` entries vanish.
        fn new(nodes: &LaneNodes, size: usize, r: usize, zero: impl Fn(usize) -> bool) -> Self {
            let at = |derivative: usize, s: f64| -> Vec<f64> {
                let entry = |p: usize| match zero(p) {
                    true => 0.0,
                    false => ((p + 1) as f64 * 0.9 + s + 1.1 * derivative as f64).sin(),
                };
                (0..size).map(entry).collect()
            };
            let s = &nodes.nodes.s;
            Curve {
                x: std::array::from_fn(|i| s.iter().flat_map(|s| at(i, *s)).collect()),
                last: at(0, 1.0),
                frames: s.iter().flat_map(|s| frame(r, *s)).collect(),
                end: frame(r, 1.0),
            }
        }

        fn view(&self) -> CurveAtNodes<'_> {
            CurveAtNodes {
                x: self.x.each_ref().map(Vec::as_slice),
                last: &self.last,
                frames: &self.frames,
                end: &self.end,
            }
        }
    }

    /// A product of plane rotations, by rows, that is the identity at 0.
    fn frame(r: usize, s: f64) -> Vec<f64> {
        let mut g: Vec<f64> = (0..r * r)
            .map(|at| f64::from(u8::from(at % (r + 1) == 0)))
            .collect();
        for i in 1..r {
            let (sin, cos) = (s * (0.4 + i as f64).cos()).sin_cos();
            for row in g.chunks_exact_mut(r) {
                (row[i - 1], row[i]) = (
                    cos * row[i - 1] - sin * row[i],
                    sin * row[i - 1] + cos * row[i],
                );
            }
        }
        g
    }

    fn numbers(count: usize, seed: f64) -> Vec<f64> {
        let number = |i: usize| (seed + 1.7 * i as f64).sin();
        (0..count).map(number).collect()
    }

    /// Solves forward and transposed with unrelated numbers; the two must agree.
    fn assert_transposed(equations: &LinearBoundary) {
        let (d, count) = (equations.terms.dim(), equations.nodes.count());
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
                    let curve = Curve::new(&nodes, d, shape.r, |p| zero > 0 && p % zero == 0);
                    let equations = LinearBoundary::in_span(shape, &nodes, curve.view(), tension);
                    assert_transposed(&equations);
                }
                let curve = Curve::new(&nodes, shape.r * shape.k, shape.r, |_| false);
                let equations = LinearBoundary::in_row(shape, &nodes, curve.view(), tension);
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
            let mut short = Curve::new(&nodes, r * k, r, |_| false);
            let Curve { x, last, .. } = &mut short;
            let vectors = x.iter_mut().chain([last]);
            for x in vectors.flat_map(|x| x.chunks_exact_mut(r * k)) {
                let b = x.to_vec();
                for at in 0..k * k {
                    let (i, j) = (at % k, at / k);
                    x[at] = match kind.quotient {
                        Quotient::Frames => b[i + k * j] - b[j + k * i],
                        Quotient::Subspaces => 0.0,
                    };
                }
            }
            let row = LinearBoundary::in_row(shape, &nodes, short.view(), 0.5);
            let d = in_space!(larger, |space| space.dim());
            let mut places = vec![0; k];
            let mut coordinates = |blocks: &[f64]| -> Vec<f64> {
                let each = blocks.chunks_exact(r * k).flat_map(|x| {
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
                    coordinates
                });
                each.collect()
            };
            let larger_frame = |frame: &[f64]| -> Vec<f64> {
                let rows = frame.chunks_exact(r);
                let rows = rows.flat_map(|row| row.iter().copied().chain([0.0]));
                rows.chain((0..=r).map(|i| f64::from(u8::from(i == r))))
                    .collect()
            };
            let long = Curve {
                x: short.x.each_ref().map(|x| coordinates(x)),
                last: coordinates(&short.last),
                frames: short
                    .frames
                    .chunks_exact(r * r)
                    .flat_map(larger_frame)
                    .collect(),
                end: larger_frame(&short.end),
            };
            let whole = LinearBoundary::in_span(larger, &nodes, long.view(), 0.5);
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
            let expected = expected.displacements.chunks_exact(d);
            for (found, expected) in found.displacements.chunks_exact(k).zip(expected) {
                for (found, place) in found.iter().zip(&places) {
                    let expected = expected[*place];
                    assert!(
                        (found - expected).abs() < 1e-12,
                        "{shape:?}: {found} {expected}"
                    );
                }
            }
        }
    }
}
