//! The geometric cubic of the binding, from boundary data or four control points.

use super::points::Points;
use super::polynomial::{PIECES, Polynomial, PyGeometricPolynomial, WORDS, bases, polynomial};
use super::prelude::*;
use super::stored::{Form, take_quotient};
use crate::curve::{GeodesicPolynomial, GeometricCubic, GeometricPolynomial, SubspacePolynomial};
use crate::space::Quotient;
use crate::stored::{Stored, refusal};

/// Geometric cubic polynomial by the adjusted de Casteljau algorithm, from boundary data.
///
/// Parameters
/// ----------
/// S0, V0 : array_like, shape (n, k)
///     Initial point and velocity.
/// S1, V1 : array_like, shape (n, k)
///     Final point and velocity, at ``t = 1``.
/// pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
///     Geodesics (canonical metric) come much nearer to the Riemannian cubic for ``k > 1``, where they differ from
///     quasi-geodesics, and take a logarithm for every stage of every point; not for ``k = n - 1``, where they are in
///     closed form as well. For ``k = 1`` the curve is the same, and a point takes many times as long. On a :class:`Grassmann`
///     the two are the same.
/// manifold : Stiefel or Grassmann, optional
///     What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
///     whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
///     first given one on.
/// project : bool, default False
///     Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
///     Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.
///
/// Raises
/// ------
/// InvalidInputError
///     Shape, not finite, not orthonormal, not tangent (with the measured defect); an end velocity too long to be
///     met.
/// OutsideDomainError
///     Inner control points that cannot be joined, or intermediate points that reach an angle of pi inside of the
///     interval, where the curve would jump; of subspaces a principal angle of pi/2 between consecutive control points, or
///     in a third of an end velocity. Carries ``angle``.
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
impl PyGeometricCubic {
    /// For files and pickles: all numbers of the curve.
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
                    let make = SubspacePolynomial::from_boundary_interruptible;
                    Arc::new(make(s0, v0, s1, v1, stop)?)
                }
            })
        })?;
        Self::wrap(py, curve, field)
    }

    /// The geometric cubic with control points ``P``, shape (4, n, k).
    ///
    /// Parameters
    /// ----------
    /// P : array_like, shape (4, n, k)
    ///     Control points with orthonormal columns.
    /// manifold : Stiefel or Grassmann, optional
    ///     What the points stand for, as for the class.
    /// project : bool, default False
    ///     Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
    ///     Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal (with the measured defect).
    /// OutsideDomainError
    ///     Consecutive points that cannot be joined; carries ``angle``.
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

/// A cubic, or a curve of another degree, of its stored numbers.
pub(super) fn restored(py: Python<'_>, mut form: Form) -> PyResult<Py<PyAny>> {
    let geodesic = is_second(PIECES, &form.word(PIECES)?, WORDS)?;
    let (cubic, field) = (form.kind == GeometricCubic::KIND, form.field);
    let (curve, report) = form.read(py, move |fields, interrupt| {
        let report = fields.reports("report", 1)?[0];
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
            true => Err(refusal(format!("a cubic of degree {degree}"))),
            false => Ok((curve, report)),
        }
    })?;
    let curve = PyGeometricPolynomial::wrap(py, curve, field, report)?;
    match cubic {
        true => object(py, curve.add_subclass(PyGeometricCubic)),
        false => object(py, curve),
    }
}
