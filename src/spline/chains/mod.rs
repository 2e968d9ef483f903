//! Chains of Riemannian cubics through knots, and how they are solved.

pub(crate) mod ambient;
pub(crate) mod chain;
pub(crate) mod descent;
pub(crate) mod descent_end;
pub(crate) mod embedded;
pub(crate) mod flat_spline;
pub(crate) mod framed;
pub(crate) mod framed_solver;
pub(crate) mod integrated_legs;
pub(crate) mod low_cost;
pub(crate) mod motion;
pub(crate) mod neighbours;
pub(crate) mod solution;
pub(crate) mod solve;
pub(crate) mod uneven;
