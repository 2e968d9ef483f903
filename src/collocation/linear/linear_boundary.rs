//! The linearised boundary value problem along a cubic on `[0, 1]`, and its transpose.
//!
//! At Gauss nodes it is an equation of the second kind with a smoothing kernel, the one of Newton's method for such
//! problems ([`Operator`]). GMRES converges faster than linearly; it is repeated for the residual that it has left,
//! unless that is round-off. Functions of the solution have gradients with respect to the data at the ends through the
//! transposed equation, at the same cost.
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 3.1 (collocation); Kelley,
//! Xue (1996), "GMRES and integral operators", SIAM J. Sci. Comput. 17, 217-226.

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
struct ResidualLimit {
    /// Residual at which the iteration ends.
    wanted: f64,
    /// Largest residual of a solution, the same after the last pass.
    allowed: f64,
    /// Whether these are relative to right-hand side and solution together, or to the right-hand side.
    with_solution: bool,
}

/// Round-off: a residual between the two is one that another pass has not reduced.
const FINE: ResidualLimit = ResidualLimit {
    wanted: 1e-15,
    allowed: 2e-14,
    with_solution: true,
};

/// Enough to detect solutions larger than [`SUSPECT`]: at conjugate ends the residual stays above the part of the data
/// that no variation reaches, which is far larger in the examples of `conjugate_ends_are_not_regular`. With 1e-7, seven
/// or eight products become ten to twelve.
const ROUGH: ResidualLimit = ResidualLimit {
    wanted: 1e-4,
    allowed: 1e-4,
    with_solution: false,
};

/// Reduction of the residual by one pass of GMRES. Two passes take 18, 20, 22 and 24 products on St(4,2), (5,2), (12,3)
/// and (20,5), at a distance and speeds of 0.8. A single pass to 1e-14 takes 13, 14, 17 and 20, but gradients between
/// complex lines are then off by 8e-14 instead of less than 2e-14.
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
/// dimensions, three passes then left 6e-8 and 3e-4, with four vectors per node as unknowns; not measured again.
const SLOW: f64 = 1e-4;

/// The linearised equations at Gauss nodes, for given data at the ends.
pub(crate) struct LinearBoundary {
    pub(super) terms: Box<dyn Terms>,
    pub(super) nodes: Arc<LaneNodes>,
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
        let found = solved(&mut operator, (right, Way::Forward), ROUGH, interrupt)?;
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
        let found = solved(&mut operator, (right, Way::Forward), FINE, interrupt)?;
        Ok(found.map(|y| BoundaryResponse {
            displacements: operator.displacements([ends[0], ends[1]], &y),
            start: [y[..d].to_vec(), y[d..2 * d].to_vec()],
        }))
    }

    /// The gradient with respect to displacement and change of the velocity at the start and at the end of a function
    /// of the variation, from its gradient with respect to displacements at the nodes, one node after another, and to
    /// the changes of `x'` and `x''` at the start; `None` as for [`LinearBoundary::solve`].
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
        let Some(y) = solved(&mut operator, (right, way), FINE, interrupt)? else {
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
    limit: ResidualLimit,
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
        gmres.try_solve(&mut rest, PASS.max(0.5 * limit.wanted), |y, image| {
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
        let scale = if limit.with_solution { found } else { 0.0 } + before;
        let left = norm(&rest) / scale;
        if last.is_infinite() && left > SLOW {
            return Ok(None);
        }
        let is_last = left <= limit.wanted || left > PROGRESS * last;
        last = left;
        if is_last {
            break;
        }
    }
    solution.iter_mut().for_each(|x| *x *= size);
    Ok((last <= limit.allowed).then_some(solution))
}
