//! Structured dense linear algebra: symmetric and skew parts, exponentials and logarithms of rotations and unitary
//! matrices.
//!
//! All functions work on matrices sized at run time, real except in `skew_exp` and `unitary_log`. Kernels called in
//! loops are workspaces (`SkewExp`, `OrthogonalLog`, `UnitaryLog`, `SkewSchur`): they are created once per size and
//! then allocate nothing.

mod asinh_series;
mod bidiagonal;
pub mod complex_embedding;
mod complex_square;
pub mod decomp;
mod differential;
pub(crate) mod dual;
mod exp_polynomials;
pub mod exponential_action;
pub(crate) mod field;
pub(crate) mod graded_singular_values;
pub(crate) mod gram_factors;
pub mod jet;
pub(crate) mod jet_exp;
pub(crate) mod lane_jet;
pub(crate) mod lane_matrix;
pub(crate) mod lane_square;
pub(crate) mod lanes;
pub mod lyapunov;
pub(crate) mod one_sided_jacobi;
pub mod orthogonal_log;
pub mod product;
mod scalar;
pub(crate) mod simd;
pub mod skew_exp;
mod skew_hermitian_exp;
pub mod skew_schur;
mod square;
pub mod structure;
mod unitary_differential;
pub mod unitary_log;

pub(crate) use differential::dexp;
pub use differential::{OrthogonalLogDifferential, SkewExpDifferential};
pub use orthogonal_log::{OrthogonalLog, orthogonal_log};
pub use scalar::Scalar;
pub use skew_exp::{SkewExp, skew_exp};
pub use skew_schur::SkewSchur;
pub use unitary_differential::UnitaryLogDifferential;
pub use unitary_log::{UnitaryLog, unitary_log};
