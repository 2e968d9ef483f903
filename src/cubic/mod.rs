//! Riemannian cubics on any `St(n, k)`, without charts.
//!
//! `St(n,k) = SO(n)/SO(n-k)`, `so(n) = m + h` with `h` the lower right block of size `n - k`. A curve `S` consists of
//! the first `k` columns of a frame `g` with `g' = g x` and `x` in `m`, so its other columns do not rotate among
//! themselves. The vector `x` determines velocity, covariant acceleration and covariant jerk:
//!
//! ```math
//! S' = g x,\qquad D_t S' = g x',\qquad D_t D_t S' = g\,(x'' + \tfrac12 [x, x']_m),\qquad
//! x''' = [x'', x]_m - [[x, x']_h, x]
//! ```
//!
//! (`g v` stands for its first `k` columns.) The last equation is the equation of Riemannian cubics, `D_t^3 S' + R(D_t
//! S', S') S' = 0`. Cubics in tension make `int |D_t S'|^2 + tau |S'|^2` stationary and have the additional term `tau
//! x'` in `x'''`: `D_t^3 S' + R(D_t S', S') S' = tau D_t S'`.
//!
//! # Source
//! Crouch, Silva Leite (1995), "The dynamic interpolation problem: on Riemannian manifolds, Lie groups, and symmetric
//! spaces", J. Dynamical and Control Systems 1, 177-202; Noakes, Heinzinger, Paden (1989), "Cubic splines on curved
//! spaces", IMA J. Math. Control Inform. 6, 465-473.

mod at_nodes;
mod batch;
mod block_products;
pub(crate) mod blocks;
mod boundary;
mod broyden;
mod collocated;
mod composition;
mod continuation;
mod derivative;
mod derivative_bounds;
pub(crate) mod descent_start;
mod embedded;
mod embedded_field;
mod embedded_state;
mod embedding;
mod end_equations;
mod end_map;
mod few_dimensions;
mod frame_flow;
mod from_boundary;
mod fused;
pub(crate) mod guess;
mod halves;
mod homotopy;
pub(crate) mod initial;
mod initial_derivative;
mod integration_options;
mod interval;
mod invariants;
pub(crate) mod lazy_taylor;
pub(crate) mod leg;
pub(crate) mod leg_of_blocks;
pub(crate) mod leg_taylor;
pub(crate) mod linear_cubic;
pub(crate) mod linear_flow;
mod linear_layout;
pub(crate) mod linear_piece;
#[cfg(test)]
mod linear_piece_tests;
pub(crate) mod linear_start;
mod linear_velocities;
mod low_cost;
pub(crate) mod marches;
pub(crate) mod packing;
pub(crate) mod piecewise_taylor;
mod polynomials;
pub(crate) mod problem;
pub(crate) mod random;
mod recurrence;
pub(crate) mod relative_ends;
pub mod riemannian_cubic;
mod rotation;
pub(crate) mod search;
mod shooting;
mod solution;
pub(crate) mod solver;
mod space_flow;
mod split_state;
mod splitting;
pub(crate) mod state;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored_check;
pub(crate) mod taylor;
pub(crate) mod tension;
mod time_map;
mod trajectory;
pub(crate) mod turning;
mod variation;
pub(crate) mod work;

pub use batch::{BoundarySolution, solve_boundary};
pub use boundary::{BoundaryOptions, BoundaryReport, BoundaryStrategy};
pub use composition::SplittingOrder;
pub use derivative::{BoundaryDerivative, BoundaryGradient, BoundaryVariation, CostGradient};
pub use embedded::{EmbeddedOptions, integrate_embedded};
pub use initial_derivative::{InitialGradient, InitialVariation};
pub use integration_options::IntegrationOptions;
pub use riemannian_cubic::RiemannianCubic;
pub use search::SearchOptions;
pub use splitting::{SplittingOptions, integrate_cubic};
pub use trajectory::CubicTrajectory;
