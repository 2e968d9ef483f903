//! The Stiefel manifold `St(n, k)` and the Grassmann manifold `Gr(n, k)`: points, tangent vectors, and the maps between them.

pub(crate) mod carrier;
pub mod covariant;
pub mod curvature;
pub mod differential;
pub mod exponential;
pub(crate) mod geodesic_jet;
pub mod gradient;
pub mod grassmann;
pub(crate) mod inverse_differential;
mod lane_angles;
pub(crate) mod lane_covariant;
pub(crate) mod lane_join;
pub(crate) mod lane_leg;
pub(crate) mod lane_margin;
pub(crate) mod lane_moving_join;
mod lane_principal;
mod lane_turn;
pub mod logarithm;
pub mod metric;
pub(crate) mod normal_frame;
pub(crate) mod only_bases;
mod principal_vectors;
pub mod quasi_geodesic;
pub(crate) mod quasi_geodesic_jet;
pub mod retraction;
pub(crate) mod retraction_differential;
pub mod stiefel;
#[cfg(any(feature = "python", feature = "serde"))]
pub(crate) mod stored;
pub(crate) mod tangent;
pub mod transport;

pub use differential::{ExponentialDifferential, LogarithmDifferential};
pub use exponential::Geodesic;
pub use grassmann::Grassmann;
pub use logarithm::LogReport;
pub use metric::Metric;
pub use quasi_geodesic::QuasiGeodesic;
pub use retraction::Retraction;
pub use stiefel::Stiefel;
pub use transport::ParallelTransport;
