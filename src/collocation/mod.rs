//! Riemannian cubics by collocation: all legs of a chain, and all nodes of a leg, at once.
//!
//! On a leg, run through for `s` in `[0, 1]`, the unknown is `f = x'''` at Gauss nodes, beside `x, x', x''` at `s = 0` and the
//! frames `g` at the nodes. Integrals of polynomials through the nodes turn the equations of cubics into
//!
//! ```math
//! f = [x'', x]_m - [[x, x']_h, x],\qquad g = g_0 + \int_0^s g\,x,\qquad x = x_0 + x_0' s + \tfrac12 x_0'' s^2 + \iiint f
//! ```
//!
//! an equation of the second kind with a smoothing kernel: Newton's method needs its derivative on a few coarse nodes only,
//! and what coarse nodes do not see dies out in a sweep or two of the fixed-point iteration `f <- [x'', x]_m - ...`.
//! The polynomials are the curve: nothing is integrated afterwards.
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 6.2 (two-grid iteration for the
//! Nystrom method); Ascher, Mattheij, Russell (1995), "Numerical Solution of Boundary Value Problems for Ordinary Differential
//! Equations", sec. 5.6 (Gauss collocation), 7.2 (condensation).

mod chain;
mod dense;
mod knots;
mod leg;
mod linear_leg;
mod linearisation;
mod newton;
mod nodes;

mod tests;
