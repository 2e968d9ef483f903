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

pub(crate) mod boundary;
mod boundary_options;
mod derivative_bounds;
mod integration_options;
pub(crate) mod integrators;
mod interval;
mod invariants;
mod polynomials;
pub mod riemannian_cubic;
pub(crate) mod sensitivity;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored_check;
pub(crate) mod taylor;
pub(crate) mod tension;
mod time_map;
pub(crate) mod turning;

pub use boundary::batch::{BoundarySolution, solve_boundary};
pub use boundary::search::SearchOptions;
pub use boundary_options::BoundaryOptions;
pub use integration_options::IntegrationOptions;
pub use integrators::composition::SplittingOrder;
pub use integrators::embedded::integrate_embedded;
pub use integrators::splitting::{SplittingOptions, integrate_cubic};
pub use integrators::trajectory::CubicTrajectory;
pub use riemannian_cubic::RiemannianCubic;
pub use sensitivity::derivative::{
    BoundaryDerivative, BoundaryGradient, BoundaryVariation, CostGradient,
};
pub use sensitivity::initial_derivative::{InitialGradient, InitialVariation};
