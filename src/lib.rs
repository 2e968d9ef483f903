//! Smooth curves on Stiefel manifolds.
//!
//! `St(n, k)` is the set of `n x k` matrices with orthonormal columns, here with its canonical metric:
//!
//! ```math
//! St(n,k) = \{ S \in R^{n \times k} : S^T S = I_k \},\qquad
//! \langle V, W \rangle_S = \mathrm{tr}\, V^T (I - \tfrac12 S S^T) W
//! ```
//!
//! The crate implements the two methods that arXiv 2404.19407 (Anahory Simoes, Colombo, Silva Leite) compares for
//! Riemannian cubics, the critical curves of the squared covariant acceleration:
//!
//! * the adjusted de Casteljau algorithm, on any `St(n, k)`: [`GeometricCubic`], built from [`QuasiGeodesic`]s;
//! * symplectic integrators from discretization maps, in charts of `St(3,1)` and `St(3,2)` and across them: [`chart`].
//!
//! Riemannian cubics on any `St(n, k)`, without charts, by explicit symplectic splittings: [`cubic::integrate_cubic`]; on
//! the paper's phase space in the embedding: [`cubic::integrate_embedded`].
//!
//! Riemannian cubics themselves, on any `St(n, k)` and to round-off, from initial or from boundary data: [`RiemannianCubic`].
//!
//! The geometry of the manifold, for the whole alpha family of metrics with the canonical and the Euclidean one:
//! exponential, logarithm and [`Geodesic`]s, [`Retraction`]s with their inverses, [`ParallelTransport`], curvature,
//! Riemannian gradients and Hessians. The same of the subspaces of dimension `k`: [`Grassmann`]. De Casteljau curves of any
//! degree: [`GeometricPolynomial`], [`GeodesicPolynomial`], of subspaces [`SubspacePolynomial`].
//!
//! Below these are the exponential and logarithm of rotations ([`skew_exp()`], [`orthogonal_log()`]), the manifold
//! ([`Stiefel`]), and a damped Newton solver ([`newton`]).
//!
//! Curves through many points: [`spline`]. With the feature `serde` curves are serialised, all their numbers, in a form with
//! a version that is checked on the way back.
//!
//! Which algorithm each kernel uses, how accurate and how fast it is: [`guide`].
//!
//! Matrices are [`faer`]'s, states of a chart [`nalgebra`]'s. Input is checked once, at the public entry; every
//! failure is an [`Error`] with the measured number. No code of the crate is `unsafe`.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod chart;
mod collocation;
pub mod cubic;
pub mod curve;
pub mod error;
pub mod guide;
pub mod interrupt;
mod legs;
pub mod linalg;
pub mod manifold;
#[cfg(feature = "python")]
mod python;
pub mod report;
pub mod rotation;
#[cfg(feature = "serde")]
mod serialize;
mod shooting;
mod solve;
mod space;
pub mod spline;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;

pub use cubic::RiemannianCubic;
pub use curve::{
    Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Quantity, SubspacePolynomial,
};
pub use error::{Error, Result};
pub use interrupt::Interrupt;
pub use linalg::{orthogonal_log, skew_exp, unitary_log};
pub use manifold::{
    Geodesic, Grassmann, LogReport, Metric, ParallelTransport, QuasiGeodesic, Retraction, Stiefel,
};
pub use report::{SolverReport, StopReason};
pub use solve::newton;
pub use space::{Quotient, ScalarField};

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// And that of the guide.
#[cfg(doctest)]
#[doc = include_str!("../docs/guides/rust.md")]
struct RustGuide;
