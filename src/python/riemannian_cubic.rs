//! Riemannian cubics of the binding.

use super::kept::Kept;
use super::points::{Points, symbol};
use super::prelude::*;
use crate::cubic::{
    BoundaryDerivative, BoundaryOptions, IntegrationOptions, RiemannianCubic, SearchOptions,
};
use crate::curve::Curve;
use crate::space::Quotient;

/// Riemannian cubic: a critical curve of the integral of the squared covariant acceleration.
///
/// Made by :meth:`from_initial` or :meth:`from_boundary`; it cannot be constructed directly.
///
/// Notes
/// -----
/// Solves ``D_t^3 S' + R(D_t S', S') S' = tension D_t S'`` (canonical metric) on any St(n, k), without charts, by a Taylor method of
/// order 20 in ``min(n, 4 k)`` dimensions, to round-off. Pieces of a :class:`CubicSpline` may instead be one polynomial
/// about the middle of the piece, of an order that depends on how fast it turns. Outside of ``t_span`` the curve is
/// integrated on, for each call anew: :meth:`restricted` gives a curve that keeps it.
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
            "RiemannianCubic is made by RiemannianCubic.from_initial(S, V, A, J) or \
             RiemannianCubic.from_boundary(S0, V0, S1, V1)",
        ))
    }

    /// The Riemannian cubic with given initial data.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (n, k)
    ///     Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
    /// t_end : float, default 1.0
    ///     The curve is made for the times between 0 and this one, which may be negative.
    /// tol : float, default 1e-17
    ///     What a step leaves out, relative to the state, between 1e-17 (round-off) and 0.1. Points are orthonormal to
    ///     about ``tol`` too, and no better.
    /// tension : float, default 0.0
    ///     The curve makes the integral of ``|A|^2 + tension |V|^2`` stationary; not negative, in units of ``1 / t^2``.
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
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), ``t_end`` zero, ``tol`` or
    ///     ``tension`` out of range.
    /// ConvergenceError
    ///     More steps than 100000, or than fit into a gigabyte: ``t_end`` is too large for the speed. Carries
    ///     ``report``; its residual is the time that was left.
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
        let data = points.matrices(field, arguments)?;
        let quotient = points.quotient;
        let curve = run_on(S.py(), field, data, 1.0, move |[s, v, a, j], interrupt| {
            let options = IntegrationOptions {
                t_end,
                tolerance: tol,
                tension,
                quotient,
                interrupt,
            };
            RiemannianCubic::from_initial(s, v, a, j, &options)
        })?;
        Self::wrapped(S.py(), curve, field)
    }

    /// A Riemannian cubic on ``[0, 1]`` with given end points and end velocities.
    ///
    /// Parameters
    /// ----------
    /// S0, V0 : array_like, shape (n, k)
    ///     Initial point and velocity.
    /// S1, V1 : array_like, shape (n, k)
    ///     Final point and velocity. Data with defects up to 1e-9, rounded decimals for example, stand for the nearest exact
    ///     ones.
    /// tol : float, default 1e-12
    ///     The largest distance of the end point and end velocity from ``S1`` and ``V1``, Frobenius norm of both
    ///     together. Where an end speed exceeds 10 the velocity counts relative to the larger end speed; ``32 eps`` times that
    ///     speed, about 1e-12 for 140 and never more than 1e-9, is the least tolerance (``report.tolerance``).
    /// max_iterations : int, default 50
    ///     Newton steps from the first start, and from any other, at most; steps of descents, up to 300 of each, have the
    ///     limit of work only. With 12 or fewer a first start that runs out of them ends the search. More than 50 raise the
    ///     limit of work, about two seconds, in proportion.
    /// guess : pair (A, J) of array_like, optional
    ///     Covariant acceleration and covariant jerk at ``S0`` to start from, shape (n, k) each; by default those of the
    ///     cubic of flat space. On a :class:`Grassmann` they are horizontal at ``S0``.
    /// tension : float, default 0.0
    ///     The curve makes the integral of ``|A|^2 + tension |V|^2`` stationary, its :meth:`Curve.cost`: a cubic for 0, near a
    ///     geodesic but for both ends where it is large. At most 64: what is off at the start grows along the curve as
    ///     ``exp(sqrt(tension) t)``.
    /// all_found : bool, default False
    ///     Look for more solutions and return all that are found: by Newton's method from the cubic of flat space (or the
    ///     guess), by descents from there and from cubics of flat space that make one or two full turns more, and along
    ///     families of boundary data from curves that make a full turn more. On a :class:`Grassmann` by the same
    ///     descents, whose cubics of flat space turn a principal direction by pi or 2 pi more, and by Newton's method from random
    ///     initial data; with real lines (``k = 1``) on the sphere, to both unit vectors of the last line.
    /// manifold : Stiefel or Grassmann, optional
    ///     What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
    ///     whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
    ///     first given one on.
    /// project : bool, default False
    ///     Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
    ///     Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.
    ///
    /// Returns
    /// -------
    /// RiemannianCubic, or list of RiemannianCubic
    ///     With ``all_found`` a list, the cheapest first (:meth:`Curve.cost`). There may be others: on the sphere there
    ///     are infinitely many.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), ``tol`` not between 1e-15 and 0.1,
    ///     ``max_iterations`` less than 1, ``tension`` not between 0 and 64.
    /// OutsideDomainError
    ///     Points in different components of O(n); carries ``angle``.
    /// ConvergenceError
    ///     No solution to ``tol`` is found, or the curve takes more Taylor steps than are allowed: the data, or a guess,
    ///     are too fast. Carries ``report``; its residual is what the end is off, or the time that was left.
    ///
    /// Notes
    /// -----
    /// Cubics with given ends are stationary, not unique. Newton's method, with exact derivatives of the flow, starts from the
    /// cubic of flat space, or from the guess. If displacement and speeds are at most 2, its solution is returned. Otherwise
    /// (and without a guess) a chain of cubics descends to a curve of least cost: from a curve that rolls evenly from one
    /// velocity to the other, for end speeds up to 16 also from the cubic of flat space, and from the de Casteljau curve where
    /// more than one quasi-geodesic joins the points. The cheapest is returned. Where that would take more work than a problem
    /// may (dimensions from 57 on, as of St(15,5), SO(12) and complex St(10,4)) it is the solution from the cubic of flat space,
    /// and not known to be the cheapest. Compare solutions by :meth:`Curve.cost`.
    ///
    /// Opposite points, or nearly so, with end speeds below 1e-5 may be refused: their solutions are nearly a whole family
    /// (seen on St(3,1), St(4,1) and most on St(6,3), not on St(3,2) and St(4,2)).
    ///
    /// A problem is given up after the work of about two seconds. Ctrl-C ends the search at once.
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
                // The guess is made of vectors at the first point.
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
                    field,
                    interrupt,
                };
                if all_found {
                    let options = SearchOptions {
                        boundary,
                        ..SearchOptions::default()
                    };
                    return match points.quotient {
                        Quotient::Frames => {
                            RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &options)
                        }
                        Quotient::Subspaces => {
                            RiemannianCubic::all_between_subspaces(s0, v0, s1, v1, &options)
                        }
                    };
                }
                let curve = match points.quotient {
                    Quotient::Frames => RiemannianCubic::from_boundary(s0, v0, s1, v1, &boundary),
                    Quotient::Subspaces => {
                        RiemannianCubic::between_subspaces(s0, v0, s1, v1, &boundary)
                    }
                }?;
                Ok(vec![curve])
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

    /// How the boundary value problem was solved; None for a curve from initial data.
    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.curve.report().copied().map(PySolverReport::from)
    }

    /// Point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, each of shape (n, k).
    #[getter]
    fn initial(&self, py: Python<'_>) -> PyResult<Four> {
        let initial = self.run(py, 1.0, |curve, _| curve.initial())?;
        self.field.four(initial, [])
    }

    /// The tension: 0 for a cubic.
    #[getter]
    fn tension(&self) -> f64 {
        self.curve.tension()
    }

    /// The conserved energy ``|D_t S'|^2 / 2 - <D_t D_t S', S'> + tension |S'|^2 / 2``.
    #[getter]
    fn energy(&self) -> PyResult<f64> {
        Ok(self.field.squared(self.curve.energy()?))
    }

    /// The conserved spatial momentum, a skew matrix of shape (n, n); for ``n`` up to 16384.
    #[getter]
    fn momentum(&self, py: Python<'_>) -> PyResult<Numbers> {
        let rows = self.curve.n() as f64;
        let momentum = self.run(py, rows, |curve, _| curve.momentum())?;
        self.field.number_matrix(momentum)
    }

    /// Number of polynomials that the curve consists of: the steps of its integration, or 1 for a piece of a spline that
    /// was solved without integration.
    #[getter]
    fn steps(&self) -> usize {
        self.curve.steps()
    }

    /// The same curve made for ``[start, end]``: a part of ``t_span``, or more.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``start >= end``, not finite.
    /// ConvergenceError
    ///     The curve cannot be integrated on so far; carries ``report``.
    fn restricted(&self, py: Python<'_>, start: f64, end: f64) -> PyResult<Py<Self>> {
        let part = self.run(py, SOLVES, move |curve, stop| {
            curve.restricted(start, end, stop)
        })?;
        Self::wrapped(py, part, self.field)
    }

    /// The same points at other times: ``t_span`` becomes ``[start, end]``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``start >= end``, not finite, or so near or far that speeds leave the range of numbers.
    fn reparametrised(&self, py: Python<'_>, start: f64, end: f64) -> PyResult<Py<Self>> {
        Self::wrapped(py, self.curve.reparametrised(start, end)?, self.field)
    }

    /// The curve run backwards over the same interval.
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
        Py::new(py, wrap(py, inner, field, class)?)
    }

    /// Runs `work` on the curve; each number of a point is `weight` times the work of an exponential.
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

/// A pair of matrices to start from.
fn pair_of_guess<'py>(pair: &Any<'py>) -> PyResult<[Any<'py>; 2]> {
    match two(pair)? {
        Ok(pair) => Ok(pair),
        Err(3) => Err(invalid!("guess: expected two items (A, J), found more")),
        Err(few) => Err(invalid!("guess: expected two items (A, J), found {few}")),
    }
}
