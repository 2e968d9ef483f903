//! The geometric cubic of the binding, from boundary data or four control points.

use super::points::Points;
use super::polynomial::{PIECES, Polynomial, PyGeometricPolynomial, WORDS, bases, polynomial};
use super::prelude::*;
use super::stored::{Form, take_quotient};
use crate::curve::{GeodesicPolynomial, GeometricCubic, GeometricPolynomial, SubspacePolynomial};
use crate::space::Quotient;
use crate::stored::{REPORT, Stored, refusal};

/// Geometric cubic: the adjusted de Casteljau curve with given boundary data.
///
/// Parameters
/// ----------
/// S0, V0 : array_like, shape (n, k)
///     Initial point and velocity.
/// S1, V1 : array_like, shape (n, k)
///     Final point and velocity, at ``t = 1``.
/// pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
///     Curves between control points. Geodesics (canonical metric) come much closer to the Riemannian cubic for
///     ``k > 1``, where they differ from quasi-geodesics, but need a logarithm for every stage of every evaluated
///     point, except for ``k = n - 1``, where they have a closed form too. For ``k = 1`` both give the same curve, but
///     evaluating geodesics takes many times as long. On a :class:`Grassmann` the two are the same.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
///     start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect); an end
///     velocity too long for the construction.
/// OutsideDomainError
///     Inner control points cannot be joined, or intermediate points reach an angle of pi inside the interval, where
///     the curve would jump; for subspaces, a principal angle of pi/2 between the inner control points. Carries
///     ``angle``.
///
/// Notes
/// -----
/// The curve meets its boundary data to round-off. It is close to the Riemannian cubic with the same data, but not
/// equal to it. A third of each end velocity must be the initial velocity of a principal quasi-geodesic (on the sphere,
/// speeds below ``3 pi``); longer velocities are refused.
///
/// arXiv 2404.19407; Krakowski, Machado, Silva Leite, Batista (2017).
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
impl PyGeometricCubic {
    /// All numbers of the curve, for files and pickles.
    fn _stored<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        PyGeometricPolynomial::stored(slf.as_super(), GeometricCubic::KIND)
    }

    #[new]
    #[pyo3(signature = (S0, V0, S1, V1, *, pieces="quasi_geodesic", manifold=None, project=false))]
    fn new(
        S0: &Any,
        V0: &Any,
        S1: &Any,
        V1: &Any,
        pieces: &str,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (py, points) = (S0.py(), Points::read(manifold, project)?);
        let geodesic = is_second(PIECES, pieces, WORDS)?;
        let field = points.field([S0, V0, S1, V1])?;
        let data = points.matrices(field, named![S0, V0, S1, V1])?;
        let (quotient, weight) = (points.quotient, bases(points.quotient));
        let curve = run_on(py, field, data, weight, move |[s0, v0, s1, v1], stop| {
            Ok(match (quotient, geodesic) {
                (Quotient::Frames, false) => {
                    let curve = GeometricCubic::from_boundary(s0, v0, s1, v1)?;
                    Arc::new(GeometricPolynomial::from(curve)) as Arc<dyn Polynomial>
                }
                (Quotient::Frames, true) => {
                    Arc::new(GeodesicPolynomial::from_boundary(s0, v0, s1, v1)?)
                }
                (Quotient::Subspaces, _) => {
                    let make = SubspacePolynomial::from_boundary;
                    Arc::new(make(s0, v0, s1, v1, stop)?)
                }
            })
        })?;
        Self::wrap(py, curve, field)
    }

    /// Return the geometric cubic with control points ``P``, shape (4, n, k).
    ///
    /// Parameters
    /// ----------
    /// P : array_like, shape (4, n, k)
    ///     Control points with orthonormal columns.
    /// manifold : Stiefel or Grassmann, optional
    ///     Manifold of the points, as for the class.
    /// project : bool, default False
    ///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
    ///     by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
    ///     arrays in single precision are always projected.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     Consecutive points cannot be joined; carries ``angle``.
    #[staticmethod]
    #[pyo3(signature = (P, *, manifold=None, project=false))]
    fn from_control_points(P: &Any, manifold: Option<&Any>, project: bool) -> PyResult<Py<Self>> {
        let (curve, field) = polynomial(P, false, &Points::read(manifold, project)?)?;
        let found = curve.degree() + 1;
        match found {
            4 => Py::new(P.py(), Self::wrap(P.py(), curve, field)?),
            _ => Err(invalid!("P: expected 4 control points, found {found}")),
        }
    }
}

impl PyGeometricCubic {
    /// From a curve of degree three.
    pub(super) fn wrap(
        py: Python<'_>,
        curve: Arc<dyn Polynomial>,
        field: Field,
    ) -> PyResult<PyClassInitializer<Self>> {
        let base = PyGeometricPolynomial::wrap(py, curve, field, None)?;
        Ok(base.add_subclass(PyGeometricCubic))
    }
}

/// Reads a cubic, or a curve of another degree, from its stored numbers.
pub(super) fn restored(py: Python<'_>, mut form: Form) -> PyResult<Py<PyAny>> {
    let geodesic = is_second(PIECES, &form.word(PIECES)?, WORDS)?;
    let (cubic, field) = (form.kind == GeometricCubic::KIND, form.field);
    let (curve, report) = form.read(py, move |fields, interrupt| {
        let report = fields.reports(REPORT, 1)?[0];
        let quotient = take_quotient(fields)?;
        let curve: Arc<dyn Polynomial> = match (quotient, geodesic) {
            (Quotient::Frames, false) => Arc::new(GeometricPolynomial::restore(fields, interrupt)?),
            (Quotient::Frames, true) => Arc::new(GeodesicPolynomial::restore(fields, interrupt)?),
            (Quotient::Subspaces, true) => {
                Arc::new(SubspacePolynomial::restore(fields, interrupt)?)
            }
            (Quotient::Subspaces, false) => {
                return Err(refusal(
                    "pieces: subspaces are joined by geodesics".to_owned(),
                ));
            }
        };
        let degree = curve.degree();
        match cubic && degree != 3 {
            true => Err(refusal(format!("expected degree 3, found {degree}"))),
            false => Ok((curve, report)),
        }
    })?;
    let curve = PyGeometricPolynomial::wrap(py, curve, field, report)?;
    match cubic {
        true => object(py, curve.add_subclass(PyGeometricCubic)),
        false => object(py, curve),
    }
}
