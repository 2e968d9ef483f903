//! Riemannian cubics at Gauss nodes: integrals of the polynomials through the nodes turn their equations into integral
//! equations of the second kind, with a smoothing kernel.
//!
//! Chains of legs between knots ([`EmbeddedChain`]) are solved in the embedding: the unknowns are the fourth
//! derivatives of the matrices `S` at the nodes of every leg and the velocities at the knots, and nothing is
//! differentiated.
//!
//! Single cubics between given ends are solved in frames by Newton's method ([`solve_between_ends`]), whose linear
//! equations are those of their derivatives too ([`LinearBoundary`]); `x'''` at the nodes, `x'` and `x''` at the start
//! are the unknowns:
//!
//! ```math
//! x''' = [x'', x]_m - [[x, x']_h, x],\qquad g = g_0 + \int_0^s g\,x,\qquad x = x_0 + x_0' s + \tfrac12 x_0'' s^2 + \iiint x'''
//! ```
//!
//! The polynomials through the nodes are the curve, except for legs with more than 32 nodes, which are integrated.
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 4.1 (the Nystrom method);
//! Walker, Ni (2011), "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 1715-1735.

mod along;
pub(crate) mod boundary;
pub(crate) mod embedded;
mod expansion;
mod lane_matrices;
mod lane_nodes;
pub(crate) mod linear;
mod motion;

pub(crate) use boundary::boundary_leg::BoundaryData;
pub(crate) use boundary::boundary_value::{
    BoundaryLimits, BoundaryStart, SolvedLeg, solve_between_ends,
};
pub(crate) use embedded::chain::EmbeddedChain;
pub(crate) use embedded::solved_chain::SolvedChain;
pub(crate) use lane_nodes::LaneNodes;
pub(crate) use linear::linear_boundary::LinearBoundary;
pub(crate) use linear::linear_nodes::{are_resolved, linear_nodes, more_nodes};
pub(crate) use linear::linear_terms::CurveAtNodes;
