//! The Python module `stiefel_rs._core`: names only. No mathematics lives below this point.

mod boundary_batch;
mod call;
mod chart;
mod convert;
mod cubic_trajectory;
mod curve;
mod discretization;
mod error;
mod flow;
mod geodesic;
mod geometry;
mod knots;
mod linalg;
mod masked;
mod measure;
mod piecewise;
mod polynomial;
mod polynomial_pieces;
mod restored;
mod retraction;
mod riemannian_cubic;
mod shooting;
mod smoothing;
mod spline;
mod spline_data;
mod spline_options;
mod spline_stored;
mod state;
mod stiefel;
mod stored;
mod trajectory;
mod variation;
mod velocities;

use pyo3::prelude::*;

/// Compiled part of `stiefel_rs`.
#[pymodule(gil_used = false)]
pub mod _core {
    #[pymodule_export]
    use super::boundary_batch::solve_boundary;
    #[pymodule_export]
    use super::call::{num_threads, simd_features};
    #[pymodule_export]
    use super::chart::PyChart;
    #[pymodule_export]
    use super::cubic_trajectory::{PyCubicTrajectory, integrate_cubic};
    #[pymodule_export]
    use super::curve::{PyCurve, PyQuasiGeodesic};
    #[pymodule_export]
    use super::error::PySolverReport;
    #[pymodule_export]
    use super::geodesic::{PyGeodesic, PyLogReport};
    #[pymodule_export]
    use super::linalg::{orthogonal_log, skew_exp};
    #[pymodule_export]
    use super::masked::_check_unmasked;
    #[pymodule_export]
    use super::measure::PyDerivativeBounds;
    #[pymodule_export]
    use super::piecewise::PyPiecewiseCurve;
    #[pymodule_export]
    use super::polynomial::{PyGeometricCubic, PyGeometricPolynomial};
    #[pymodule_export]
    use super::restored::_restored;
    #[pymodule_export]
    use super::riemannian_cubic::PyRiemannianCubic;
    #[pymodule_export]
    use super::shooting::PyShootingResult;
    #[pymodule_export]
    use super::smoothing::PySmoothingSpline;
    #[pymodule_export]
    use super::spline::{PyCubicHermite, PyCubicSpline};
    #[pymodule_export]
    use super::stiefel::PyStiefel;
    #[pymodule_export]
    use super::trajectory::PyChartTrajectory;
    #[pymodule_export]
    use super::velocities::estimate_velocities;

    #[pymodule_init]
    fn init(module: &super::Bound<'_, super::PyModule>) -> super::PyResult<()> {
        super::convert::load_numpy(module.py())
    }

    #[pymodule_export]
    const __VERSION__: &str = env!("CARGO_PKG_VERSION");
}
