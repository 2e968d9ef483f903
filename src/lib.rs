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
//! * symplectic integrators built from discretization maps, in charts of `St(3,1)` and `St(3,2)` and across several
//!   charts: [`chart`].
//!
//! Chart-free integrators work on any `St(n, k)`: explicit symplectic splittings ([`cubic::integrate_cubic`]), and a
//! symplectic method with constraints on the paper's phase space in the embedding ([`cubic::integrate_embedded`]).
//!
//! [`RiemannianCubic`] computes Riemannian cubics themselves, on any `St(n, k)` and to round-off, from initial or from
//! boundary data.
//!
//! The geometry of the manifold covers the whole alpha family of metrics, which contains the canonical and the
//! Euclidean one: exponential, logarithm and [`Geodesic`]s, [`Retraction`]s with their inverses, [`ParallelTransport`],
//! curvature, Riemannian gradients and Hessians. [`Grassmann`] offers the same for subspaces of dimension `k`. De
//! Casteljau curves of any degree are [`GeometricPolynomial`] and [`GeodesicPolynomial`], and [`SubspacePolynomial`]
//! for subspaces.
//!
//! The building blocks are public too: exponential and logarithm of rotations ([`skew_exp()`], [`orthogonal_log()`]),
//! the manifold ([`Stiefel`]), and a damped Newton solver ([`newton`]).
//!
//! Curves through many points are in [`spline`], splines of rotations and poses in [`rotation`]. With the feature
//! `serde`, curves are serialised exactly, in a versioned form that is checked when it is read. With
//! [`ScalarField::Complex`], curves consist of complex frames or subspaces.
//!
//! [`guide`] says which algorithm each kernel uses, how accurate it is and how fast.
//!
//! Matrices are [`faer`] types, chart states [`nalgebra`] types. Input is checked once, at the public entry; every
//! failure is an [`Error`] that carries the measured value. The crate contains no `unsafe` code.

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
mod threads;

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
pub use report::{SolverReport, StopReason, Strategy};
pub use solve::newton;
pub use space::{Quotient, ScalarField};

/// Runs the README's example as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Runs the examples of the guide as tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/guides/rust.md")]
struct RustGuide;
