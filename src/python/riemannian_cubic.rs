//! Riemannian cubics of the binding.

use super::kept::Kept;
use super::points::{Points, symbol};
use super::prelude::*;
use crate::cubic::{
    BoundaryDerivative, BoundaryOptions, IntegrationOptions, RiemannianCubic, SearchOptions,
};
use crate::curve::Curve;

/// Riemannian cubic: a critical curve of the integral of the squared covariant acceleration.
///
/// Constructed by :meth:`from_initial` or :meth:`from_boundary`; the class cannot be called.
///
/// Notes
/// -----
/// Solves ``D_t^3 S' + R(D_t S', S') S' = tension D_t S'`` (canonical metric) on any St(n, k), without charts, by a
/// Taylor method of order 20 in ``min(n, 4 k)`` dimensions, to round-off. The solution of a boundary problem and a
/// piece of a :class:`CubicSpline` may instead be a single polynomial about its midpoint, whose order depends on how
/// fast it turns. Outside ``t_span`` each call integrates the curve anew; :meth:`restricted` returns a curve that
/// stores the longer integration.
///
/// Noakes, Heinzinger, Paden (1989); Crouch, Silva Leite (1995); Silva Leite, Camarinha, Crouch (2000) for tension.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import RiemannianCubic
/// >>> S, V, A, J = np.eye(3)[:, :1], np.eye(3)[:, 1:2], 2 * np.eye(3)[:, 2:], np.zeros((3, 1))
/// >>> curve = RiemannianCubic.from_initial(S, V, A, J)
/// >>> curve(np.linspace(0, 1, 5)).shape
/// (5, 3, 1)
/// >>> bool(np.allclose(curve.acceleration(0.0), A))
/// True
/// >>> other = RiemannianCubic.from_boundary(S, V, curve(1.0), curve.velocity(1.0))
/// >>> bool(np.allclose(other(0.5), curve(0.5))), other.report.converged
/// (True, True)
#[pyclass(name = "RiemannianCubic", module = "stiefel_rs", extends = PyCurve, frozen)]
pub struct PyRiemannianCubic {
    pub(super) curve: Arc<RiemannianCubic>,
    pub(super) field: Field,
    pub(super) derivative: Kept<BoundaryDerivative>,
}

#[pymethods]
impl PyRiemannianCubic {
    #[new]
    #[pyo3(signature = (*_args, **_kwargs))]
    fn new(
        _args: &Bound<'_, PyTuple>,
        _kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        Err(PyTypeError::new_err(
            "RiemannianCubic cannot be constructed directly; use RiemannianCubic.from_initial(S, V, A, J) or \
             RiemannianCubic.from_boundary(S0, V0, S1, V1)",
        ))
    }

    /// Return the Riemannian cubic with given initial data.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (n, k)
    ///     Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
    /// t_end : float, default 1.0
    ///     End of ``t_span``, which starts at 0; may be negative.
    /// tol : float, default 1e-17
    ///     Local error of a step, relative to the state, between 1e-17 (round-off) and 0.1. The orthonormality defect
    ///     of points is about ``tol`` too.
    /// tension : float, default 0.0
    ///     Weight of the squared velocity: the integral of ``|A|^2 + tension |V|^2`` is stationary. At least 0, in
    ///     units of ``1 / t^2``.
    /// manifold : Stiefel or Grassmann, optional
    ///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the
    ///     points are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of
    ///     bases that start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    /// project : bool, default False
    ///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
    ///     by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
    ///     arrays in single precision are always projected.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect),
    ///     ``t_end`` zero, ``tol`` or ``tension`` out of range.
    /// ConvergenceError
    ///     The integration needs more than 100000 steps, or more than fit into one gigabyte: ``t_end`` is too large for
    ///     the speed. Carries ``report``, whose residual is the remaining time.
    #[staticmethod]
    #[pyo3(signature = (S, V, A, J, t_end=1.0, *, tol=1e-17, tension=0.0, manifold=None, project=false))]
    fn from_initial(
        S: &Any,
        V: &Any,
        A: &Any,
        J: &Any,
        t_end: f64,
        tol: f64,
        tension: f64,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<Py<Self>> {
        let (arguments, points) = (named![S, V, A, J], Points::read(manifold, project)?);
        let field = points.field(arguments.map(|(object, _)| object))?;
        let data = points.single(field, arguments)?;
        let (quotient, numbers) = (points.quotient, data.iter().map(Batch::numbers).sum());
        let curve = run(S.py(), field, numbers, move |interrupt| {
            let [s, v, a, j] = data.each_ref().map(|x| x.get(0));
            let options = IntegrationOptions {
                t_end,
                tolerance: tol,
                tension,
                quotient,
            };
            RiemannianCubic::from_initial(s, v, a, j, &options, interrupt)
        })?;
        Self::wrapped(S.py(), curve, field)
    }

    /// Return a Riemannian cubic on ``[0, 1]`` with given end points and end velocities.
    ///
    /// Parameters
    /// ----------
    /// S0, V0 : array_like, shape (n, k)
    ///     Initial point and velocity.
    /// S1, V1 : array_like, shape (n, k)
    ///     Final point and velocity. Data with defects up to 1e-9, such as rounded decimals, are replaced by the
    ///     nearest exact ones.
    /// tol : float, default 1e-12
    ///     Largest error of end point and end velocity, as the Frobenius norm of both together. If an end speed exceeds
    ///     10, the velocity error is relative to the larger end speed. The tolerance is at least ``32 eps`` times that
    ///     speed (about 1e-12 at speed 140), but this bound never exceeds 1e-9; ``report.tolerance`` is the tolerance
    ///     used.
    /// max_iterations : int, default 50
    ///     Largest number of Newton steps from each starting point. Descent steps, up to 300 per descent, are bounded
    ///     by the work limit only. If this is 12 or less, only Newton's method from the first start is tried. More than
    ///     50 raise the work limit, about two seconds, in proportion.
    /// guess : pair (A, J) of array_like, optional
    ///     Covariant acceleration and covariant jerk at ``S0``, shape (n, k) each, from which Newton's method starts;
    ///     by default those of the cubic in flat space. On a :class:`Grassmann` they are horizontal at ``S0``.
    /// tension : float, default 0.0
    ///     Weight of the squared velocity: the integral of ``|A|^2 + tension |V|^2``, which is :meth:`Curve.cost`, is
    ///     stationary. 0 gives a cubic; for large values the curve is close to a geodesic except near its ends. Between
    ///     0 and 64: an error at the start grows along the curve as ``exp(sqrt(tension) t)``.
    /// all_found : bool, default False
    ///     If True, search for further solutions and return all that are found: by Newton's method from the cubic in
    ///     flat space (or the guess), by descents from it and from cubics in flat space with one or two extra full
    ///     turns, and by continuation in the boundary data from curves with an extra full turn. On a
    ///     :class:`Grassmann`, by the same descents, where the cubics in flat space turn a principal direction by an
    ///     extra pi or 2 pi, and by Newton's method from random initial data; for real lines (``k = 1``) on the sphere,
    ///     with both unit vectors of the last line as end points.
    /// manifold : Stiefel or Grassmann, optional
    ///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the
    ///     points are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of
    ///     bases that start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    /// project : bool, default False
    ///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
    ///     by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
    ///     arrays in single precision are always projected.
    ///
    /// Returns
    /// -------
    /// RiemannianCubic, or list of RiemannianCubic
    ///     With ``all_found`` a list, sorted by increasing :meth:`Curve.cost`. It need not be complete: on the sphere
    ///     there are infinitely many solutions.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect),
    ///     ``tol`` not between 1e-15 and 0.1, ``max_iterations`` less than 1, ``tension`` not between 0 and 64.
    /// OutsideDomainError
    ///     The points lie in different components of O(n), or a principal angle between subspaces is pi/2; carries
    ///     ``angle``.
    /// ConvergenceError
    ///     No solution to ``tol`` was found, or the curve needs more Taylor steps than are allowed because the data or
    ///     the guess are too fast. Carries ``report``, whose residual is the error at the end, or the remaining time.
    ///
    /// Notes
    /// -----
    /// Cubics with given ends are stationary, not unique. If displacement and speeds are at most 2, Newton's method
    /// starts from the cubic in flat space; from a guess it starts at any distance. If it fails, and for other data,
    /// chains of cubics descend to local minima of the cost: from a curve that rolls evenly from one velocity to the
    /// other; for end speeds up to 16 also from the cubic in flat space; and from the de Casteljau curve if several
    /// quasi-geodesics join the points. The solution of least cost is returned. If the descents would exceed the work
    /// limit (dimension 57 or more, as for St(15,5), SO(12) and complex St(10,4)), the solution from the cubic in flat
    /// space is preferred, which need not have the least cost. ``report.strategy`` says how the solution was found, and
    /// :meth:`Curve.cost` compares solutions.
    ///
    /// Of subspaces, several solutions are compared if they are more than 1.4 apart or speeds exceed 2, complex ones if
    /// they are more than 1.2 apart or speeds exceed 1.4.
    ///
    /// Between opposite points with slow ends, solutions nearly form a continuous family: some are refused with end
    /// speeds below 1e-5 on St(6,3), below 1e-3 on St(10,3), and none on spheres.
    ///
    /// The search stops at a work limit of about two seconds. Ctrl-C stops it at once.
    #[staticmethod]
    #[pyo3(signature = (
        S0, V0, S1, V1, *, tol=1e-12, max_iterations=50, guess=None, tension=0.0, all_found=false, manifold=None,
        project=false
    ))]
    fn from_boundary(
        S0: &Any,
        V0: &Any,
        S1: &Any,
        V1: &Any,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        guess: Option<&Any>,
        tension: f64,
        all_found: bool,
        manifold: Option<&Any>,
        project: bool,
    ) -> PyResult<Py<PyAny>> {
        let (py, arguments) = (S0.py(), named![S0, V0, S1, V1]);
        let points = Points::read(manifold, project)?;
        let guess = guess.map(pair_of_guess).transpose()?;
        let objects = arguments.iter().map(|(object, _)| *object);
        let field = points.field(objects.chain(guess.iter().flatten()))?;
        let (ends, guess) = match &guess {
            None => (points.matrices(field, arguments)?, None),
            Some([A, J]) => {
                // The guess consists of tangent vectors at the first point.
                let data = points.matrices(field, named![S1, V1, S0, V0, A, J])?;
                let [s1, v1, s0, v0, a, j] = data;
                ([s0, v0, s1, v1], Some([a, j]))
            }
        };
        let max_iterations = count("max_iterations", max_iterations, 1)?;
        let curves = run_on(
            py,
            field,
            ends,
            SOLVES,
            move |[s0, v0, s1, v1], interrupt| {
                let boundary = BoundaryOptions {
                    tolerance: tol,
                    max_iterations,
                    guess: guess.as_ref().map(|[a, j]| (a.as_ref(), j.as_ref())),
                    tension,
                    quotient: points.quotient,
                    field,
                };
                if all_found {
                    let options = SearchOptions {
                        boundary,
                        ..SearchOptions::default()
                    };
                    return RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &options, interrupt);
                }
                RiemannianCubic::from_boundary(s0, v0, s1, v1, &boundary, interrupt)
                    .map(|curve| vec![curve])
            },
        )?;
        let curves = curves
            .into_iter()
            .map(|curve| Self::wrapped(py, curve, field));
        let mut curves = curves.collect::<PyResult<Vec<_>>>()?;
        match all_found {
            true => curves.into_py_any(py),
            false => curves.swap_remove(0).into_py_any(py),
        }
    }

    /// Outcome of the boundary value solver; None for a curve from initial data.
    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.curve.report().copied().map(PySolverReport::from)
    }

    /// Point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, shape (n, k) each.
    #[getter]
    fn initial(&self, py: Python<'_>) -> PyResult<FourNumbers> {
        let initial = self.run(py, 1.0, |curve, _| curve.initial())?;
        self.field.four(initial, [])
    }

    /// Weight of the squared velocity; 0 for a cubic.
    #[getter]
    fn tension(&self) -> f64 {
        self.curve.tension()
    }

    /// Conserved energy ``|D_t S'|^2 / 2 - <D_t D_t S', S'> + tension |S'|^2 / 2``.
    #[getter]
    fn energy(&self) -> PyResult<f64> {
        Ok(self.field.squared(self.curve.energy()?))
    }

    /// Conserved spatial momentum, a skew-symmetric matrix of shape (n, n); for ``n`` up to 16384.
    #[getter]
    fn momentum(&self, py: Python<'_>) -> PyResult<Numbers> {
        let rows = self.curve.n() as f64;
        let momentum = self.run(py, rows, |curve, _| curve.momentum())?;
        self.field.vectors(Array::from(momentum))
    }

    /// Number of polynomials in the curve.
    ///
    /// The number of integration steps, or 1 for a solution of a boundary problem or a piece of a spline that was found
    /// without integration.
    #[getter]
    fn steps(&self) -> usize {
        self.curve.steps()
    }

    /// Return the same curve on ``[start, end]``, which may extend beyond ``t_span``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``start >= end``, or not finite.
    /// ConvergenceError
    ///     The curve cannot be integrated that far; carries ``report``.
    fn restricted(&self, py: Python<'_>, start: f64, end: f64) -> PyResult<Py<Self>> {
        let part = self.run(py, SOLVES, move |curve, stop| {
            curve.restricted(start, end, stop)
        })?;
        Self::wrapped(py, part, self.field)
    }

    /// Return the curve with its parameter transformed linearly so that ``t_span`` becomes ``[start, end]``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``start >= end``, not finite, or so close or far apart that speeds overflow or underflow.
    fn reparametrised(&self, py: Python<'_>, start: f64, end: f64) -> PyResult<Py<Self>> {
        Self::wrapped(py, self.curve.reparametrised(start, end)?, self.field)
    }

    /// Return the curve run backwards over the same interval.
    fn reversed(&self, py: Python<'_>) -> PyResult<Py<Self>> {
        Self::wrapped(py, self.curve.reversed(), self.field)
    }

    fn __repr__(&self) -> String {
        let (start, end) = Curve::t_span(&*self.curve);
        let shape = (self.curve.n(), self.curve.k());
        let manifold = symbol(Curve::quotient(&*self.curve), self.field, shape);
        let steps = self.curve.steps();
        format!("<RiemannianCubic on {manifold}, t_span ({start:?}, {end:?}), {steps} steps>")
    }
}

impl PyRiemannianCubic {
    pub(super) fn wrapped(
        py: Python<'_>,
        curve: RiemannianCubic,
        field: Field,
    ) -> PyResult<Py<Self>> {
        let curve = Arc::new(curve);
        let inner = Arc::clone(&curve) as _;
        let class = PyRiemannianCubic {
            curve,
            field,
            derivative: Kept::default(),
        };
        Py::new(py, wrap_checked(py, inner, field, class)?)
    }

    /// Runs `work` on the curve; each number of a point costs `weight` times the work of an exponential.
    pub(super) fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        weight: f64,
        work: impl FnOnce(&RiemannianCubic, Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let (curve, field) = (Arc::clone(&self.curve), self.field);
        let numbers = weight * (curve.n() * curve.k()) as f64;
        run(py, field, numbers, move |interrupt| work(&curve, interrupt))
    }
}

/// Reads a pair of matrices to start from.
fn pair_of_guess<'py>(pair: &Any<'py>) -> PyResult<[Any<'py>; 2]> {
    match two(pair)? {
        Ok(pair) => Ok(pair),
        Err(3) => Err(invalid!("guess: expected two items (A, J), found more")),
        Err(few) => Err(invalid!("guess: expected two items (A, J), found {few}")),
    }
}
