//! De Casteljau curves of the binding: of any degree from control points, and the cubic from boundary data.

use std::sync::Arc;

use faer::{Mat, MatRef};
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::call::Call;
use super::convert::{float_array, matrix, to_array, tuple, write};
use super::curve::{AnyCurve, Operations, PyCurve, cube};
use super::error::invalid_input;
use crate::curve::{Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Quantity};

impl Operations for GeometricPolynomial {
    fn operations(&self, quantity: Quantity) -> f64 {
        let joins = 0.5 * (self.degree() * self.degree()) as f64;
        match quantity {
            Quantity::Derivative(0) => joins * (30.0 + 30.0 * cube(self.k())),
            _ => joins * (5e3 + 5e3 * cube(self.k())),
        }
    }
}

impl Operations for GeodesicPolynomial {
    fn operations(&self, quantity: Quantity) -> f64 {
        let joins = 0.5 * (self.degree() * self.degree()) as f64;
        match quantity {
            Quantity::Derivative(0) => joins * (2e4 + 2e3 * cube(self.k())),
            // A linear system of the dimension of the reduced manifold for each stage.
            _ => joins * (1e5 + 1e4 * cube(self.k()) * cube(self.k())),
        }
    }
}

/// What a polynomial is made of.
#[derive(Clone)]
enum Pieces {
    QuasiGeodesic(Arc<GeometricPolynomial>),
    Geodesic(Arc<GeodesicPolynomial>),
}

impl Pieces {
    fn curve(&self) -> Arc<dyn AnyCurve> {
        match self {
            Pieces::QuasiGeodesic(curve) => Arc::clone(curve) as Arc<dyn AnyCurve>,
            Pieces::Geodesic(curve) => Arc::clone(curve) as Arc<dyn AnyCurve>,
        }
    }

    fn control_points(&self) -> Vec<Mat<f64>> {
        match self {
            Pieces::QuasiGeodesic(curve) => curve.control_points(),
            Pieces::Geodesic(curve) => curve.control_points(),
        }
    }

    fn degree(&self) -> usize {
        match self {
            Pieces::QuasiGeodesic(curve) => curve.degree(),
            Pieces::Geodesic(curve) => curve.degree(),
        }
    }
}

/// Geometric polynomial of any degree: de Casteljau's algorithm with quasi-geodesics or geodesics.
///
/// Parameters
/// ----------
/// P : array_like, shape (degree + 1, n, k)
///     Control points with orthonormal columns, two or more. The curve starts in the first and ends in the last, with
///     ``degree`` times the velocities of the first and the last piece between them.
/// pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
///     Quasi-geodesics are in closed form; geodesics (canonical metric) take a logarithm for every stage of every
///     point, and derivatives a linear system.
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal (with the measured defect).
/// OutsideDomainError
///     Consecutive points that cannot be joined, or intermediate points that reach an angle of pi inside of the
///     interval, where the curve would jump; with geodesics, consecutive points that are not within the injectivity
///     radius. Carries ``angle``, or the distance.
///
/// Notes
/// -----
/// Krakowski, Machado, Silva Leite, Batista (2017); with geodesics Park, Ravani (1995). Work is done in ``min(n, (degree + 1) k)`` dimensions.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import GeometricPolynomial
/// >>> curve = GeometricPolynomial(np.eye(3)[:, :, None])
/// >>> curve.degree
/// 2
/// >>> bool(np.allclose(curve(1.0), np.eye(3)[:, 2:]))
/// True
#[pyclass(name = "GeometricPolynomial", module = "stiefel_rs", extends = PyCurve, subclass, frozen)]
pub struct PyGeometricPolynomial(Pieces);

#[pymethods]
#[allow(non_snake_case)]
impl PyGeometricPolynomial {
    #[new]
    #[pyo3(signature = (P, *, pieces="quasi_geodesic"))]
    fn new(
        py: Python<'_>,
        P: &Bound<'_, PyAny>,
        pieces: &str,
    ) -> PyResult<PyClassInitializer<Self>> {
        Ok(Self::wrap(polynomial(py, P, pieces)?))
    }

    /// What the curve is made of: "quasi_geodesic" or "geodesic".
    #[getter]
    fn pieces(&self) -> &'static str {
        match self.0 {
            Pieces::QuasiGeodesic(_) => QUASI_GEODESIC,
            Pieces::Geodesic(_) => GEODESIC,
        }
    }

    /// The control points, shape (degree + 1, n, k).
    #[getter]
    fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let points = self.0.control_points();
        let (n, k) = points[0].shape();
        let mut entries = vec![0.0; points.len() * n * k];
        for (point, target) in points.iter().zip(entries.chunks_mut(n * k)) {
            write(point.as_ref(), target);
        }
        to_array(py, entries, &[points.len(), n, k])
    }

    /// One less than the number of control points.
    #[getter]
    fn degree(&self) -> usize {
        self.0.degree()
    }
}

impl PyGeometricPolynomial {
    fn wrap(pieces: Pieces) -> PyClassInitializer<Self> {
        let base = PyCurve::of(pieces.curve());
        PyClassInitializer::from(base).add_subclass(PyGeometricPolynomial(pieces))
    }
}

const QUASI_GEODESIC: &str = "quasi_geodesic";
const GEODESIC: &str = "geodesic";

/// Rough operations of a construction: the span, and the branch at some tens of parameters.
fn construction((n, k): (usize, usize), degree: usize) -> f64 {
    let (n, k, degree) = (n as f64, k as f64, degree as f64);
    let columns = (degree + 1.0) * k;
    1e4 + 4.0 * n * columns * columns.min(n) + 1e3 * degree * degree * (1.0 + k * k * k)
}

/// The curve with control points `P`, shape (degree + 1, n, k).
#[allow(non_snake_case)]
fn polynomial(py: Python<'_>, P: &Bound<'_, PyAny>, pieces: &str) -> PyResult<Pieces> {
    let geodesic = match pieces {
        QUASI_GEODESIC => false,
        GEODESIC => true,
        _ => {
            let message =
                format!("pieces: expected '{QUASI_GEODESIC}' or '{GEODESIC}', found {pieces:?}");
            return Err(invalid_input(py, message));
        }
    };
    let array = float_array(P, "P")?;
    let shape = array.shape().to_vec();
    let [points, n, k] = shape[..] else {
        let found = tuple(&shape);
        let message = format!("P: expected shape (degree + 1, n, k), found {found}");
        return Err(invalid_input(py, message));
    };
    let entries: Vec<f64> = array.as_array().iter().copied().collect();
    let call = Call::new(py, None, construction((n, k), points.saturating_sub(1)))?;
    call.run(py, move |_| {
        let points: Vec<_> = (0..points)
            .map(|i| {
                let entries = &entries[i * n * k..(i + 1) * n * k];
                MatRef::from_row_major_slice(entries, n, k)
            })
            .collect();
        Ok(if geodesic {
            Pieces::Geodesic(Arc::new(GeodesicPolynomial::new(&points)?))
        } else {
            Pieces::QuasiGeodesic(Arc::new(GeometricPolynomial::new(&points)?))
        })
    })
}

/// Geometric cubic polynomial by the adjusted de Casteljau algorithm, from boundary data.
///
/// Parameters
/// ----------
/// S0, V0 : array_like, shape (n, k)
///     Initial point and velocity.
/// S1, V1 : array_like, shape (n, k)
///     Final point and velocity, at ``t = 1``.
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal, not tangent (with the measured defect); an end velocity too long to be
///     met.
/// OutsideDomainError
///     Inner control points that cannot be joined, or intermediate points that reach an angle of pi inside of the
///     interval, where the curve would jump; carries ``angle``.
///
/// Notes
/// -----
/// Meets its boundary data to round-off and is close to the Riemannian cubic with the same data, not equal to it. A
/// third of each end velocity must be the velocity of the principal quasi-geodesic between its ends (on the sphere,
/// speeds below ``3 pi``); longer ones are refused.
///
/// arXiv 2404.19407 and Krakowski, Machado, Silva Leite, Batista (2017).
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import GeometricCubic
/// >>> S0, V0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
/// >>> S1, V1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
/// >>> curve = GeometricCubic(S0, V0, S1, V1)
/// >>> curve(np.linspace(0, 1, 5)).shape
/// (5, 3, 1)
/// >>> bool(np.allclose(curve.velocity(1.0), V1))
/// True
#[pyclass(name = "GeometricCubic", module = "stiefel_rs", extends = PyGeometricPolynomial, frozen)]
pub struct PyGeometricCubic;

#[pymethods]
#[allow(non_snake_case)]
impl PyGeometricCubic {
    #[new]
    fn new(
        py: Python<'_>,
        S0: &Bound<'_, PyAny>,
        V0: &Bound<'_, PyAny>,
        S1: &Bound<'_, PyAny>,
        V1: &Bound<'_, PyAny>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (s0, v0, s1, v1) = (
            matrix(S0, "S0")?,
            matrix(V0, "V0")?,
            matrix(S1, "S1")?,
            matrix(V1, "V1")?,
        );
        let call = Call::new(py, None, construction(s0.shape(), 3))?;
        let curve = call.run(py, move |_| {
            GeometricCubic::from_boundary(s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref())
        })?;
        Ok(Self::wrap(Pieces::QuasiGeodesic(Arc::new(curve.into()))))
    }

    /// The geometric cubic with control points ``P``, shape (4, n, k).
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     Consecutive points that cannot be joined; carries ``angle``.
    #[staticmethod]
    fn from_control_points(py: Python<'_>, P: &Bound<'_, PyAny>) -> PyResult<Py<Self>> {
        let curve = polynomial(py, P, QUASI_GEODESIC)?;
        let found = curve.degree() + 1;
        if found == 4 {
            return Py::new(py, Self::wrap(curve));
        }
        let message = format!("P: expected 4 control points, found {found}");
        Err(invalid_input(py, message))
    }
}

impl PyGeometricCubic {
    fn wrap(pieces: Pieces) -> PyClassInitializer<Self> {
        PyGeometricPolynomial::wrap(pieces).add_subclass(PyGeometricCubic)
    }
}
