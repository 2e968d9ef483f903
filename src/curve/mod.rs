//! Curves on the manifold: a common trait for evaluation, derivatives, covariant quantities and cost.
//!
//! A curve lies in the span of a few columns (its frame). Points are computed in this span and lifted to `n` rows by
//! one product for a whole block of parameters. Blocks have a fixed size, so results do not depend on the number of
//! threads.

mod acceleration_residual;
#[cfg(feature = "python")]
pub(crate) mod any_curve;
pub mod arc_length;
pub(crate) mod barycentric;
mod branch;
mod collocation;
mod cost;
#[expect(clippy::module_inception, reason = "the trait")]
pub(crate) mod curve;
pub mod de_casteljau;
pub mod derivative_bounds;
mod end_legs;
pub(crate) mod gauss_legendre;
mod geodesic;
pub mod geodesic_polynomial;
pub mod geometric_cubic;
mod horizontal_lift;
mod length;
mod length_inverse;
pub mod minimal_cost;
pub(crate) mod nodes;
mod norms;
mod quantity;
mod quasi_geodesic;
pub mod quintic;
pub(crate) mod sampling;
pub(crate) mod span;
mod stages;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;
pub mod subspace_polynomial;

pub use arc_length::ArcLength;
pub use curve::Curve;
pub use de_casteljau::GeometricPolynomial;
pub use derivative_bounds::{DerivativeBounds, Guarantee};
pub use geodesic_polynomial::GeodesicPolynomial;
pub use geometric_cubic::GeometricCubic;
pub use quantity::Quantity;
pub use sampling::{Samples, lift_into};
pub use subspace_polynomial::SubspacePolynomial;
