//! The guide: pages that accompany the reference. The same files are in the folder `docs` of the repository.

#[doc = include_str!("../docs/algorithms.md")]
pub mod algorithms {}

#[doc = include_str!("../docs/accuracy.md")]
pub mod accuracy {}

#[doc = include_str!("../docs/benchmarks.md")]
pub mod benchmarks {}

#[doc = include_str!("../docs/control_points.md")]
pub mod control_points {}

#[doc = include_str!("../docs/integrators.md")]
pub mod integrators {}
