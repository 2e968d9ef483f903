//! Linear and nonlinear solvers, independent of geometry.

pub(crate) mod anderson;
pub(crate) mod block_cholesky;
pub(crate) mod block_tridiagonal;
pub(crate) mod broyden;
pub(crate) mod direction;
pub(crate) mod gmres;
pub(crate) mod line_search;
pub mod newton;
pub(crate) mod newton_krylov;
pub(crate) mod tridiagonal;
