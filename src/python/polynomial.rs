//! De Casteljau curves of the binding, of any degree, from control points or boundary data.

use super::points::Points;
use super::prelude::*;
use super::projection::Projection;
use super::stored::{form, put_quotient};
use crate::curve::{GeodesicPolynomial, GeometricPolynomial, SubspacePolynomial};
use crate::linalg::complex_embedding::nearest_embedded;
use crate::space::Quotient;
use crate::stored::{REPORT, Stored};

/// A de Casteljau curve of quasi-geodesics or of geodesics.
pub(super) trait Polynomial: AnyCurve {
    /// Kind of the pieces.
    fn pieces(&self) -> &'static str;
    fn control_points(&self) -> Vec<Mat<f64>>;
    fn degree(&self) -> usize;
}

macro_rules! polynomial_of {
    ($curve:ty, $pieces:expr) => {
        impl Polynomial for $curve {
            fn pieces(&self) -> &'static str {
                $pieces
            }

            fn control_points(&self) -> Vec<Mat<f64>> {
                self.control_points()
            }

            fn degree(&self) -> usize {
                self.degree()
            }
        }
    };
}

polynomial_of!(GeometricPolynomial, WORDS[0]);
polynomial_of!(GeodesicPolynomial, WORDS[1]);
polynomial_of!(SubspacePolynomial, WORDS[1]);

/// Words for the kind of the pieces, and its name in the stored form.
pub(super) const WORDS: [&str; 2] = ["quasi_geodesic", "geodesic"];
pub(super) const PIECES: &str = "pieces";

/// The curve with control points `P`, shape (degree + 1, n, k).
pub(super) fn polynomial(
    P: &Any,
    geodesic: bool,
    points: &Points,
) -> PyResult<(Arc<dyn Polynomial>, Field)> {
    let (field, quotient) = (points.field([P])?, points.quotient);
    let batch = points.control_points(field, P)?;
    let work = batch.numbers() * bases(quotient);
    let curve = run(P.py(), field, work, move |interrupt| {
        let views = batch.views();
        Ok(match (quotient, geodesic) {
            (Quotient::Frames, false) => Arc::new(GeometricPolynomial::new(&views)?) as _,
            (Quotient::Frames, true) => Arc::new(GeodesicPolynomial::new(&views)?) as _,
            (Quotient::Subspaces, _) => Arc::new(SubspacePolynomial::new(&views, interrupt)?) as _,
        })
    })?;
    Ok((curve, field))
}

/// Work of making a curve, relative to its legs: for subspaces the bases have to be found.
pub(super) fn bases(quotient: Quotient) -> f64 {
    match quotient {
        Quotient::Frames => 1.0,
        Quotient::Subspaces => SOLVES,
    }
}

/// The polynomial of embedded control points nearest to those that a search in the real frames found, whose steps are
/// off by round-off over the curvature of the cost. At a minimum this changes the cost to second order only.
fn embedded(curve: &GeometricPolynomial) -> Result<GeometricPolynomial> {
    let points = curve.control_points();
    let points = points.iter().map(|point| nearest_embedded(point.as_ref()));
    let points = points.collect::<Result<Vec<_>>>()?;
    let views: Vec<_> = points.iter().map(Mat::as_ref).collect();
    GeometricPolynomial::new(&views)
}

/// Geometric polynomial of any degree: de Casteljau's algorithm with quasi-geodesics or geodesics.
///
/// Parameters
/// ----------
/// P : array_like, shape (degree + 1, n, k)
///     At least two control points with orthonormal columns. The curve starts at the first and ends at the last; its
///     end velocities are ``degree`` times the velocities of the first and the last piece between control points.
/// pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
///     Curves between control points. Quasi-geodesics have a closed form; geodesics (canonical metric) need a logarithm
///     for every stage of every evaluated point, and a linear system for derivatives. On a :class:`Grassmann` the two
///     are the same.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, and the curve consists of bases that start at the first given one and turn as
///     little as possible, ``Y^T Y' = 0``.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
/// OutsideDomainError
///     Consecutive points cannot be joined, or intermediate points reach an angle of pi inside the interval, where the
///     curve would jump; with geodesics, consecutive points are not within the injectivity radius; consecutive
///     subspaces have a principal angle of pi/2. Carries ``angle``, or the distance.
///
/// Notes
/// -----
/// Krakowski, Machado, Silva Leite, Batista (2017); with geodesics Park, Ravani (1995). Computations take place in
/// ``min(n, (degree + 1) k)`` dimensions.
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
pub struct PyGeometricPolynomial {
    curve: Arc<dyn Polynomial>,
    report: Option<SolverReport>,
}

#[pymethods]
impl PyGeometricPolynomial {
    #[new]
    #[pyo3(signature = (P, *, pieces="quasi_geodesic", manifold=None, project=false))]
    fn new(
        P: &Any,
        pieces: &str,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<PyClassInitializer<Self>> {
        let geodesic = is_second(PIECES, pieces, WORDS)?;
        let points = Points::read(manifold, project)?;
        let (curve, field) = polynomial(P, geodesic, &points)?;
        Self::wrap(P.py(), curve, field, None)
    }

    /// Kind of the pieces: "quasi_geodesic" or "geodesic".
    #[getter]
    fn pieces(&self) -> &'static str {
        self.curve.pieces()
    }

    /// Control points, shape (degree + 1, n, k).
    #[getter]
    fn control_points(slf: &Bound<'_, Self>) -> PyResult<Numbers> {
        let points = slf.get().curve.control_points();
        let field = slf.as_super().get().field;
        field.numbers(Array::stacked(&[points.len()], &points, points[0].shape()))
    }

    /// Degree: the number of control points minus one.
    #[getter]
    fn degree(&self) -> usize {
        self.curve.degree()
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let (name, manifold) = (slf.get_type().name()?, slf.as_super().get().symbol());
        let (degree, pieces) = (slf.get().degree(), slf.get().pieces());
        Ok(format!(
            "<{name} on {manifold}, degree {degree} of {pieces} pieces, t_span (0.0, 1.0)>"
        ))
    }

    /// Outcome of the search for control points of minimal cost; None for other curves.
    ///
    /// The residual is the norm of the part of the acceleration that changes to first order with the control points.
    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.report.map(PySolverReport::from)
    }

    /// Return a curve of minimal cost among those of a given degree with given end points and end velocities.
    ///
    /// Parameters
    /// ----------
    /// S0, V0 : array_like, shape (n, k)
    ///     Initial point and velocity.
    /// S1, V1 : array_like, shape (n, k)
    ///     Final point and velocity, at ``t = 1``.
    /// degree : int, default 5
    ///     From 3 (the geometric cubic, which has no free control point) to 10. Each additional degree reduces the
    ///     distance to the Riemannian cubic about tenfold, and increases the time to construct and evaluate the curve.
    /// project : bool, default False
    ///     As for the class.
    ///
    /// Returns
    /// -------
    /// GeometricPolynomial
    ///     Its cost is a local minimum, to 1e-12 relative; ``report`` has the outcome of the search.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect); a
    ///     degree out of range; an end velocity too long for the construction; or
    ///     ``(degree - 3) * degree * (degree - 1) / 2 * r * k**2 * dim St(r, k)`` with ``r = min(n, 4 k)`` above 1.1e7,
    ///     which would take minutes.
    /// OutsideDomainError
    ///     Control points cannot be joined, or the curve would jump; carries ``angle``.
    /// ConvergenceError
    ///     The search found no minimum; carries ``report``.
    ///
    /// Notes
    /// -----
    /// Gauss-Newton iteration on the inner control points, started from those of the geometric cubic. The result is a
    /// local minimum: other starting points may lead to other curves.
    ///
    /// The search may take longer than ``RiemannianCubic.from_boundary``, which solves for the exact cubic and is fast
    /// to evaluate too. Use this if a curve in closed form is needed.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> from stiefel_rs import GeometricCubic, GeometricPolynomial
    /// >>> S0, V0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
    /// >>> S1, V1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
    /// >>> cubic = GeometricCubic(S0, V0, S1, V1)
    /// >>> better = GeometricPolynomial.minimal_cost(S0, V0, S1, V1, degree=6)
    /// >>> bool(better.cost() < cubic.cost())
    /// True
    #[staticmethod]
    #[pyo3(signature = (S0, V0, S1, V1, *, degree=5, project=false))]
    fn minimal_cost(
        S0: &Any,
        V0: &Any,
        S1: &Any,
        V1: &Any,
        degree: i64,
        project: bool,
    ) -> PyResult<Py<Self>> {
        let arguments = named![S0, V0, S1, V1];
        let field = Field::of_named(&arguments)?;
        let data = Points::frames(Projection::of(project)).matrices(field, arguments)?;
        let Ok(degree) = usize::try_from(degree) else {
            return Err(invalid!("degree: must be from 3 to 10, found {degree}"));
        };
        let found = run_on(
            S0.py(),
            field,
            data,
            SOLVES,
            move |[s0, v0, s1, v1], interrupt| {
                let (curve, report) =
                    GeometricPolynomial::minimal_cost(s0, v0, s1, v1, degree, interrupt)?;
                match field {
                    Field::Real => Ok((curve, report)),
                    Field::Complex => Ok((embedded(&curve)?, report)),
                }
            },
        );
        let (curve, report) = found?;
        let curve = Self::wrap(S0.py(), Arc::new(curve), field, Some(report))?;
        Py::new(S0.py(), curve)
    }

    /// Return the curve of degree five with given end points, velocities and covariant accelerations.
    ///
    /// The construction is in closed form.
    ///
    /// Parameters
    /// ----------
    /// S0, V0, A0 : array_like, shape (n, k)
    ///     Initial point, velocity and covariant acceleration.
    /// S1, V1, A1 : array_like, shape (n, k)
    ///     Final point, velocity and covariant acceleration, at ``t = 1``.
    /// project : bool, default False
    ///     As for the class.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect); an
    ///     end velocity or acceleration too long for the construction.
    /// OutsideDomainError
    ///     Inner control points cannot be joined, or the curve would jump; carries ``angle``.
    ///
    /// Notes
    /// -----
    /// The curve meets its data to round-off. With the end accelerations of a Riemannian cubic it is close to that
    /// cubic. Curves that share an end point, velocity and acceleration join with continuous acceleration.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> from stiefel_rs import GeometricPolynomial
    /// >>> S0, V0, A0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
    /// >>> S1, V1, A1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:], np.zeros((3, 1))
    /// >>> curve = GeometricPolynomial.quintic(S0, V0, A0, S1, V1, A1)
    /// >>> bool(np.allclose(curve.acceleration(0.0), A0))
    /// True
    #[staticmethod]
    #[pyo3(signature = (S0, V0, A0, S1, V1, A1, *, project=false))]
    fn quintic(
        S0: &Any,
        V0: &Any,
        A0: &Any,
        S1: &Any,
        V1: &Any,
        A1: &Any,
        project: bool,
    ) -> PyResult<Py<Self>> {
        let arguments = named![S0, V0, A0, S1, V1, A1];
        let field = Field::of_named(&arguments)?;
        let data = Points::frames(Projection::of(project)).matrices(field, arguments)?;
        let curve = run_on(S0.py(), field, data, 1.0, |[s0, v0, a0, s1, v1, a1], _| {
            GeometricPolynomial::quintic(s0, v0, a0, s1, v1, a1)
        })?;
        Py::new(S0.py(), Self::wrap(S0.py(), Arc::new(curve), field, None)?)
    }

    /// All numbers of the curve, for files and pickles.
    fn _stored<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        Self::stored(slf, GeometricPolynomial::KIND)
    }
}

impl PyGeometricPolynomial {
    pub(super) fn wrap(
        py: Python<'_>,
        curve: Arc<dyn Polynomial>,
        field: Field,
        report: Option<SolverReport>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let inner = Arc::clone(&curve) as _;
        wrap_checked(py, inner, field, PyGeometricPolynomial { curve, report })
    }

    /// The stored form of a kind of curve.
    pub(super) fn stored<'py>(
        slf: &Bound<'py, Self>,
        kind: &'static str,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (py, this) = (slf.py(), slf.get());
        let (_, mut fields) = this.curve.stored();
        fields.put_reports(REPORT, [this.report].into_iter());
        put_quotient(&mut fields, this.curve.quotient());
        let form = form(py, kind, slf.as_super().get().field, fields)?;
        form.set_item(PIECES, this.pieces())?;
        Ok(form)
    }
}
