//! The Stiefel manifold `St(n, k)`: points, tangent vectors, and the maps between them.

pub mod covariant;
pub mod curvature;
pub mod gradient;
pub mod metric;
pub mod quasi_geodesic;
pub(crate) mod quasi_geodesic_jet;
pub mod retraction;
pub mod stiefel;
pub mod transport;

pub use metric::Metric;
pub use quasi_geodesic::QuasiGeodesic;
pub use retraction::Retraction;
pub use stiefel::Stiefel;
pub use transport::ParallelTransport;
