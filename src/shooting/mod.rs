//! Riemannian cubics by Newton's method for all legs of a chain at once, where each leg is a Taylor series about its
//! middle.
//!
//! On a leg, parametrised by `s` in `[-1/2, 1/2]`, the unknowns are `x, x', x''` at `s = 0`. The equations of cubics
//! determine their Taylor series and the series of the frame, without iteration:
//!
//! ```math
//! x''' = [x'', x]_m - [[x, x']_h, x],\qquad g' = g\,x,\qquad g(0) = 1
//! ```
//!
//! The conditions are the velocities at both ends of a leg, the point at its last end, and continuous accelerations at
//! the knots. The derivative is computed from the first few terms of the series: it costs less than the series itself,
//! and a step with it reduces the residual to a hundredth or less. For a chain the series is the curve; of a
//! single leg only the start is kept, and integrated.
//!
//! With free knots in between, the same legs form a single cubic, or the cubics between the knots of a spline. A
//! descent reduces the cost, as a function of the knots, by damped Newton steps ([`least_cost`]).
//!
//! # Source
//! Ascher, Mattheij, Russell (1995), "Numerical Solution of Boundary Value Problems for Ordinary Differential Equations", sec.
//! 4.3 (multiple shooting), 7.2 (condensation); Jorba, Zou (2005), Experimental Mathematics 14, 99-117 (Taylor series).

pub(crate) mod chains;
pub(crate) mod descents;
pub(crate) mod linear;
mod lone_leg;
mod solve;
pub(crate) mod taylor;

#[cfg(test)]
mod tests;

pub(crate) use descents::chain_knots::ChainKnots;
pub(crate) use descents::free_chain::products_of_step;
pub(crate) use descents::layout::{ChainLayout, Held};
pub(crate) use linear::linear_curve::{CurvePart, LinearCurve};
pub(crate) use linear::linearise::{DENSE, linearise, linearise_all};
pub(crate) use lone_leg::{EndData, LoneLeg, lone_leg, lone_legs};
pub(crate) use solve::{
    DescentProblem, LeastCost, least_cost, nearest_stationary, solve, stationary_end,
};
#[cfg(feature = "python")]
pub(crate) use taylor::durations::ROTATIONS_ON_ONE_THREAD;
