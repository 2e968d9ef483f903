//! Riemannian cubics by collocation: all legs of a chain, and all nodes of a leg, at once.
//!
//! On a leg, parametrised by `s` in `[0, 1]`, the unknowns are `f = x'''` at Gauss nodes, `x, x', x''` at `s = 0`, and
//! the frames `g` at the nodes. Integrals of the polynomials through the nodes turn the equations of cubics into
//!
//! ```math
//! f = [x'', x]_m - [[x, x']_h, x],\qquad g = g_0 + \int_0^s g\,x,\qquad x = x_0 + x_0' s + \tfrac12 x_0'' s^2 + \iiint f
//! ```
//!
//! an equation of the second kind with a smoothing kernel. For chains it is solved without derivatives by sweeps of the
//! fixed-point iteration `f <- [x'', x]_m - ...`, combined with a step at the ends as in flat space and with Anderson
//! mixing. The polynomials are the curve: nothing is integrated afterwards.
//!
//! Single cubics between given ends are solved at such nodes by Newton's method ([`solve_between_ends`]), and so are the
//! linearised equations along them ([`LinearBoundary`]).
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 4.1 (the Nystrom method); Walker, Ni
//! (2011), "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 1715-1735.

mod along;
mod boundary_leg;
mod boundary_linear;
mod boundary_value;
mod chain;
mod clamped;
mod clamped_leg;
mod embedded_equation;
mod expansion;
mod lane_frames;
mod lane_matrices;
mod lane_nodes;
mod leg_polynomials;
mod linear_boundary;
mod linear_nodes;
mod linear_operator;
mod linear_terms;

pub(crate) use boundary_leg::BoundaryData;
pub(crate) use boundary_value::{BoundaryLimits, Start, solve_between_ends};
pub(crate) use chain::{Chain, SolvedChain};
pub(crate) use linear_boundary::LinearBoundary;
pub(crate) use linear_nodes::{are_resolved, linear_nodes, more_nodes};
