//! Splines of the binding: their data, their pieces and their stored form.

use super::geometric_cubic::PyGeometricCubic;
use super::knots::times;
use super::points::Points;
use super::prelude::*;
use super::riemannian_cubic::PyRiemannianCubic;
use super::stored::{put_quotient, take_quotient};
use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, GeometricPolynomial, Quantity, Samples, SubspacePolynomial};
use crate::space::Quotient;
use crate::spline::stored_values::{check_points, check_velocities};
use crate::spline::{Outside, Piecewise};
use crate::stored::{Fields, REPORT, Stored, refusal};

/// The words for the kinds of pieces.
pub(super) const KINDS: [&str; 2] = ["riemannian", "geometric"];

/// Times and points of a spline.
pub(super) struct SplineData {
    pub(super) t: Vec<f64>,
    pub(super) points: Batch,
}

impl SplineData {
    pub(super) fn read(t: &Any, S: &Any, points: &Points, field: Field) -> PyResult<Self> {
        Ok(SplineData {
            t: times(t)?,
            points: points.at_knots(field, S)?,
        })
    }

    /// Shape of the points in the core.
    pub(super) fn shape(&self) -> (usize, usize) {
        (self.points.rows, self.points.cols)
    }

    /// The call that constructs the pieces.
    pub(super) fn call<'py>(&self, py: Python<'py>, threads: Option<i64>) -> PyResult<Call<'py>> {
        let call = Call::new(py, threads, SOLVES * self.points.numbers())?;
        Ok(call.over(self.points.field()).distributed(true))
    }
}

pub(super) fn outside(extrapolate: bool) -> Outside {
    match extrapolate {
        true => Outside::Continued,
        false => Outside::Refused,
    }
}

/// The pieces of a spline.
pub(super) enum Cubics {
    Riemannian(Arc<Piecewise<RiemannianCubic>>),
    Geometric(Arc<Piecewise<GeometricCubic>>),
    GeometricOfSubspaces(Arc<Piecewise<SubspacePolynomial>>),
}

/// Evaluate an expression for the curve of [`Cubics`]: `on_cubics!(cubics, curve => expression)`.
macro_rules! on_cubics {
    ($cubics:expr, $curve:ident => $value:expr) => {
        match $cubics {
            Cubics::Riemannian($curve) => $value,
            Cubics::Geometric($curve) => $value,
            Cubics::GeometricOfSubspaces($curve) => $value,
        }
    };
}

impl Cubics {
    pub(super) fn curve(&self) -> Arc<dyn AnyCurve> {
        on_cubics!(self, curve => Arc::clone(curve) as _)
    }

    pub(super) fn knots(&self) -> &[f64] {
        on_cubics!(self, curve => curve.knots())
    }
}

/// Piecewise curve through points, made of cubics: the base class of splines.
///
/// Constructed by :class:`CubicSpline`, :class:`CubicHermite` and :class:`SmoothingSpline`.
#[pyclass(name = "PiecewiseCurve", module = "stiefel_rs", extends = PyCurve, subclass, frozen)]
pub struct PyPiecewiseCurve {
    pub(super) cubics: Cubics,
    /// Times of the knots; read-only, shape (N,).
    #[pyo3(get)]
    t: Owned,
    /// Points of the curve at the knots, as given, projected or smoothed; read-only, shape (N, n, k).
    #[pyo3(get)]
    pub(super) points: Owned,
    pub(super) report: Option<SolverReport>,
}

#[pymethods]
impl PyPiecewiseCurve {
    /// Kind of the pieces: ``"riemannian"`` or ``"geometric"``.
    #[getter]
    pub(super) fn kind(&self) -> &'static str {
        match self.cubics {
            Cubics::Riemannian(_) => KINDS[0],
            Cubics::Geometric(_) | Cubics::GeometricOfSubspaces(_) => KINDS[1],
        }
    }

    /// Whether the first and the last piece are continued outside ``t_span`` by default.
    #[getter]
    fn extrapolate(&self) -> bool {
        on_cubics!(&self.cubics, curve => curve.outside()) == Outside::Continued
    }

    /// Outcome of the solver; None if the pieces were constructed independently.
    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.report.map(PySolverReport::from)
    }

    /// The ``N - 1`` pieces, each as a curve on ``[0, 1]``.
    #[getter]
    fn pieces(slf: &Bound<'_, Self>) -> PyResult<Vec<Py<PyAny>>> {
        let (py, field) = (slf.py(), slf.as_super().get().field);
        match &slf.get().cubics {
            Cubics::Riemannian(curve) => {
                let wrapped = |piece| PyRiemannianCubic::wrapped(py, piece, field)?.into_py_any(py);
                curve.pieces().iter().cloned().map(wrapped).collect()
            }
            Cubics::Geometric(curve) => {
                let wrapped = |piece| {
                    let curve = Arc::new(GeometricPolynomial::from(piece));
                    object(py, PyGeometricCubic::wrap(py, curve, field)?)
                };
                curve.pieces().iter().cloned().map(wrapped).collect()
            }
            Cubics::GeometricOfSubspaces(curve) => {
                let wrapped =
                    |piece| object(py, PyGeometricCubic::wrap(py, Arc::new(piece), field)?);
                curve.pieces().iter().cloned().map(wrapped).collect()
            }
        }
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let this = slf.get();
        let (name, knots) = (slf.get_type().name()?, this.cubics.knots());
        let manifold = slf.as_super().get().symbol();
        let (count, first, last) = (knots.len(), knots[0], knots[knots.len() - 1]);
        let (kind, knots) = (this.kind(), format!("{count} knots"));
        let span = format!("t_span ({first:?}, {last:?})");
        Ok(format!("<{name} on {manifold}, {kind}, {knots}, {span}>"))
    }
}

/// Names of a spline's numbers and words in its stored form.
const POINTS: &str = "S";
pub(super) const VELOCITIES: &str = "V";
pub(super) const PIECES: &str = "pieces";

impl PyPiecewiseCurve {
    /// The stored form without the subclass's entries.
    pub(super) fn stored(&self, py: Python<'_>, field: Field) -> PyResult<Fields> {
        let (_, mut fields) = self.cubics.curve().stored();
        put(py, field, &mut fields, POINTS, &self.points)?;
        fields.put_reports(REPORT, [self.report].into_iter());
        if let Cubics::GeometricOfSubspaces(curve) = &self.cubics {
            put_quotient(&mut fields, curve.quotient());
        }
        Ok(fields)
    }
}

/// Stores an array of matrices.
pub(super) fn put(
    py: Python<'_>,
    field: Field,
    fields: &mut Fields,
    name: &'static str,
    array: &Owned,
) -> PyResult<()> {
    let [batch] = field.batches([(array.bind(py), name)])?;
    let Array { shape, entries } = batch.into_array();
    fields.put(name, &shape, entries);
    Ok(())
}

/// The parts of a spline.
pub(super) struct Spline {
    pub(super) cubics: Cubics,
    pub(super) data: SplineData,
    pub(super) report: Option<SolverReport>,
}

impl Spline {
    /// The base of the object, to which the class adds its fields.
    pub(super) fn wrap(self, py: Python<'_>) -> PyResult<PyClassInitializer<PyPiecewiseCurve>> {
        let field = self.data.points.field();
        let this = PyPiecewiseCurve {
            t: Array::flat(self.data.t).frozen(py)?,
            points: field.numbers(self.data.points.into_array())?.frozen(py)?,
            report: self.report,
            cubics: self.cubics,
        };
        let curve = this.cubics.curve();
        match this.cubics {
            Cubics::Riemannian(_) => Ok(wrap(curve, field, this)),
            _ => wrap_checked(py, curve, field, this),
        }
    }

    /// The positions or the velocities at its knots.
    fn sample(cubics: &Cubics, order: usize, interrupt: Interrupt<'_>) -> Result<Samples> {
        let (curve, quantity) = (cubics.curve(), Quantity::Derivative(order));
        curve.sample(cubics.knots(), quantity, interrupt)
    }

    /// Reads it from its stored numbers.
    pub(super) fn restored(
        fields: &mut Fields,
        field: Field,
        geometric: bool,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let report = fields.reports(REPORT, 1)?[0];
        let points = fields.take(POINTS)?;
        let cubics = match geometric {
            false => Cubics::Riemannian(Arc::new(Stored::restore(fields, interrupt)?)),
            true => match take_quotient(fields)? {
                Quotient::Frames => {
                    Cubics::Geometric(Arc::new(Stored::restore(fields, interrupt)?))
                }
                Quotient::Subspaces => {
                    let curve = Stored::restore(fields, interrupt)?;
                    Cubics::GeometricOfSubspaces(Arc::new(curve))
                }
            },
        };
        let points = Self::batch(&cubics, field, POINTS, points)?;
        let tolerance = report.map_or(0.0, |report| 10.0 * report.tolerance);
        let found = Self::sample(&cubics, 0, interrupt)?;
        let quotient = cubics.curve().quotient();
        check_points(POINTS, &points.views(), &found, quotient, tolerance)?;
        let t = cubics.knots().to_vec();
        let data = SplineData { t, points };
        Ok(Spline {
            cubics,
            data,
            report,
        })
    }

    /// Reads the velocities at the knots and checks that they are those of the curve.
    pub(super) fn velocities(&self, array: Array, interrupt: Interrupt<'_>) -> Result<Batch> {
        let field = self.data.points.field();
        let velocities = Self::batch(&self.cubics, field, VELOCITIES, array)?;
        let found = Self::sample(&self.cubics, 1, interrupt)?;
        let turns = self.turns(interrupt)?;
        let views = velocities.views();
        check_velocities(&self.data.t, turns.as_deref(), &views, &found)?;
        Ok(velocities)
    }

    /// Rotations from the given bases of subspaces to the bases of the curve at its knots.
    fn turns(&self, interrupt: Interrupt<'_>) -> Result<Option<Vec<Mat<f64>>>> {
        if self.cubics.curve().quotient() == Quotient::Frames {
            return Ok(None);
        }
        let found = Self::sample(&self.cubics, 0, interrupt)?;
        let pairs = self.data.points.views().into_iter().zip(found.iter());
        Ok(Some(
            pairs.map(|(given, own)| given.transpose() * own).collect(),
        ))
    }

    /// An array with one matrix per knot.
    fn batch(cubics: &Cubics, field: Field, name: &str, array: Array) -> Result<Batch> {
        let (n, k) = cubics.curve().shape();
        let expected = [cubics.knots().len(), n, k];
        let Array { shape, entries } = array;
        if shape == expected {
            return Ok(Batch::of(expected, entries, field));
        }
        let problem = format!("{name}: expected shape {expected:?}, found {shape:?}");
        Err(refusal(problem))
    }
}
