//! The Python module `stiefel_rs._core`: names only. No mathematics lives below this point.

// Arguments have the same names and number as in Python, where they follow the formulas.
#![allow(non_snake_case, clippy::too_many_arguments)]

mod array_namespace;
mod batch;
mod boundary_batch;
mod call;
mod chart;
mod complex_array;
mod convert;
mod cubic_trajectory;
mod curve;
mod differential;
mod embedded;
mod error;
mod field;
mod flow;
mod geodesic;
mod geometric_cubic;
mod geometry;
mod grassmann;
mod grassmann_geometry;
mod kept;
mod knots;
mod linalg;
mod measure;
mod membership;
mod piecewise;
mod points;
mod polynomial;
mod prelude;
mod projection;
mod quasi_geodesic;
mod record;
mod restored;
mod riemannian_cubic;
mod rotation_batch;
mod rotation_curve;
mod rotation_data;
mod smoothing;
mod space;
mod spline;
mod spline_variation;
mod state;
mod stiefel;
mod stored;
mod trajectory;
mod variation;
mod velocities;

use prelude::*;

/// Memory that a call frees stays for the next call: glibc returns it to the system, which clears it page by page.
/// `docs/development/measurements.md`, "Memory of the module", has the times of both.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Compiled part of `stiefel_rs`.
#[pymodule(gil_used = false)]
pub mod _core {
    #[pymodule_export]
    use super::{
        array_namespace::{_as_numpy, _in_library_of},
        boundary_batch::solve_boundary,
        call::{num_threads, simd_features},
        chart::PyChart,
        convert::_check_unmasked,
        cubic_trajectory::{PyCubicTrajectory, integrate_cubic},
        curve::PyCurve,
        differential::{
            exp_pullback, exp_variation, log_pullback, log_variation, orthogonal_log_pullback,
            orthogonal_log_variation, skew_exp_pullback, skew_exp_variation,
        },
        embedded::integrate_embedded,
        error::PySolverReport,
        flow::PyShootingResult,
        geodesic::{PyGeodesic, PyLogReport},
        geometric_cubic::PyGeometricCubic,
        grassmann::PyGrassmann,
        linalg::{orthogonal_log, skew_exp},
        measure::PyDerivativeBounds,
        piecewise::PyPiecewiseCurve,
        polynomial::PyGeometricPolynomial,
        quasi_geodesic::PyQuasiGeodesic,
        restored::_restored,
        riemannian_cubic::PyRiemannianCubic,
        rotation_batch::{
            interpolated_rotations, rotations_with_rates, sampled_rotations, smoothed_rotations,
        },
        rotation_curve::PyRotationCurve,
        smoothing::PySmoothingSpline,
        spline::{PyCubicHermite, PyCubicSpline},
        stiefel::PyStiefel,
        trajectory::PyChartTrajectory,
        velocities::estimate_velocities,
    };

    #[pymodule_init]
    fn init(module: &super::Bound<'_, super::PyModule>) -> super::PyResult<()> {
        super::convert::load_numpy(module.py())?;
        super::curve::make_callable(module.py())
    }

    #[pymodule_export]
    const __VERSION__: &str = env!("CARGO_PKG_VERSION");
}
