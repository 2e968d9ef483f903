//! Boundary value problems of subspaces.

pub(crate) mod subspace_batch;
pub(crate) mod subspace_boundary;
pub(crate) mod subspace_problem;
pub(crate) mod subspace_search;
