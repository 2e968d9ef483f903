//! Riemannian cubics of the binding.

use std::sync::Arc;

use faer::Mat;
use numpy::PyArrayDyn;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::call::Call;
use super::chart::count;
use super::convert::{matrix, matrix_pair, to_array, whole, write};
use super::curve::{AnyCurve, Operations, PyCurve, cube};
use super::error::{PySolverReport, to_exception};
use super::stored::{Form, form};
use crate::cubic::{BoundaryOptions, IntegrationOptions, RiemannianCubic, SearchOptions};
use crate::curve::{Curve, Quantity};
use crate::linalg::structure::norm;
use crate::stored::Stored;

pub(super) type Array<'py> = Bound<'py, PyArrayDyn<f64>>;
pub(super) type Four<'py> = (Array<'py>, Array<'py>, Array<'py>, Array<'py>);

impl Operations for RiemannianCubic {
    fn operations(&self, quantity: Quantity) -> f64 {
        let (r, k) = (self.n().min(4 * self.k()) as f64, self.k() as f64);
        match quantity {
            Quantity::Derivative(order) => 40.0 * (1 + order) as f64 * r * k,
            _ => 160.0 * r * k + 40.0 * r * k * k + 20.0 * cube(self.k()),
        }
    }

    fn preparation(&self, t: &[f64]) -> f64 {
        self.steps_beyond(t) * step((self.n(), self.k()))
    }
}

/// Rough operations of one step: products in the Cauchy sums of 20 orders.
fn step((n, k): (usize, usize)) -> f64 {
    let (r, k) = (n.min(4 * k) as f64, k as f64);
    420.0 * r * k * (r + 4.0 * k)
}

/// Rough operations of the factorisation that reduces the dimension.
fn reduction((n, k): (usize, usize)) -> f64 {
    let (r, k) = (n.min(4 * k) as f64, k as f64);
    1e4 + 16.0 * n as f64 * k * r
}

/// Rough operations of an integration: a step for every unit of the length that the curve would have in flat space.
fn integration([s, v, a, j]: [&Mat<f64>; 4], t_end: f64) -> f64 {
    let t = t_end.abs();
    let [v, a, j] = [v, a, j].map(|x| norm(x.as_ref()));
    let length = t * (v + t * (a / 2.0 + t * j / 6.0));
    reduction(s.shape()) + step(s.shape()) * (1.0 + length.min(1e5))
}

/// Rough operations of four Newton steps, each with a derivative in all directions.
pub(super) fn shooting([s0, v0, _, v1]: [&Mat<f64>; 4]) -> f64 {
    let steps = 4.0 + norm(v0.as_ref()) + norm(v1.as_ref());
    reduction(s0.shape()) + newton(s0.shape()) * steps.min(1e5)
}

/// The same for one of many problems of a shape.
pub(super) fn shooting_each(shape: (usize, usize)) -> f64 {
    reduction(shape) + 4.0 * newton(shape)
}

/// For one step of the integration.
fn newton((n, k): (usize, usize)) -> f64 {
    // Shapes are not checked yet: there may be no dimension left.
    let unknowns = (2.0 * n.min(4 * k) as f64 - k as f64 - 1.0).max(0.0) * k as f64;
    4.0 * (1.0 + unknowns) * step((n, k))
}

/// Riemannian cubic: a critical curve of the integral of the squared covariant acceleration.
///
/// Made by :meth:`from_initial` or :meth:`from_boundary`; it cannot be constructed directly.
///
/// Notes
/// -----
/// Solves ``D_t^3 S' + R(D_t S', S') S' = 0`` (canonical metric) on any St(n, k), without charts, by a Taylor method of
/// order 20 in ``min(n, 4 k)`` dimensions, to round-off. Pieces of a :class:`CubicSpline` may instead be one polynomial
/// about the middle of the piece, of an order that depends on how fast it turns. Outside of ``t_span`` the curve is
/// integrated on, for each call anew: :meth:`restricted` gives a curve that keeps it.
///
/// Noakes, Heinzinger, Paden (1989); Crouch, Silva Leite (1995).
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
pub struct PyRiemannianCubic(pub(super) Arc<RiemannianCubic>);

#[pymethods]
#[allow(non_snake_case)]
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
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), ``t_end`` zero, ``tol`` out of
    ///     range.
    /// ConvergenceError
    ///     More steps than 100000, or than fit into a gigabyte: ``t_end`` is too large for the speed. Carries
    ///     ``report``; its residual is the time that was left.
    #[staticmethod]
    #[pyo3(signature = (S, V, A, J, t_end=1.0, *, tol=1e-17))]
    fn from_initial(
        py: Python<'_>,
        S: &Bound<'_, PyAny>,
        V: &Bound<'_, PyAny>,
        A: &Bound<'_, PyAny>,
        J: &Bound<'_, PyAny>,
        t_end: f64,
        tol: f64,
    ) -> PyResult<Py<Self>> {
        let data = Data::read([(S, "S"), (V, "V"), (A, "A"), (J, "J")])?;
        Self::wrapped(py, data.integrate(py, t_end, tol)?)
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
    ///     cubic of flat space.
    /// all_found : bool, default False
    ///     Look for more solutions and return all that are found: by Newton's method from the cubic of flat space (or the
    ///     guess), by descents from there and from cubics of flat space that make one or two full turns more, and along
    ///     families of boundary data from curves that make a full turn more.
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
    ///     ``max_iterations`` less than 1.
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
    /// more than one quasi-geodesic joins the points. The cheapest is returned. Compare solutions by :meth:`Curve.cost`.
    ///
    /// Opposite points, or nearly so, with end speeds below 1e-5 may be refused: their solutions are nearly a whole family
    /// (seen on St(3,1), St(4,1) and most on St(6,3), not on St(3,2) and St(4,2)).
    ///
    /// A problem is given up after the work of about two seconds. Ctrl-C ends the search at once.
    #[staticmethod]
    #[pyo3(signature = (S0, V0, S1, V1, *, tol=1e-12, max_iterations=50, guess=None, all_found=false))]
    #[allow(clippy::too_many_arguments)]
    fn from_boundary(
        py: Python<'_>,
        S0: &Bound<'_, PyAny>,
        V0: &Bound<'_, PyAny>,
        S1: &Bound<'_, PyAny>,
        V1: &Bound<'_, PyAny>,
        tol: f64,
        #[pyo3(from_py_with = whole)] max_iterations: i64,
        guess: Option<&Bound<'_, PyAny>>,
        all_found: bool,
    ) -> PyResult<Py<PyAny>> {
        let Data(ends) = Data::read([(S0, "S0"), (V0, "V0"), (S1, "S1"), (V1, "V1")])?;
        let guess = guess
            .map(|pair| matrix_pair(pair, "guess", ["A", "J"]))
            .transpose()?;
        let max_iterations = count(py, "max_iterations", max_iterations, 1)?;
        let call = Call::new(py, None, shooting(ends.each_ref()))?;
        let curves = call.run(py, move |interrupt| {
            let [s0, v0, s1, v1] = ends.each_ref().map(|x| x.as_ref());
            let boundary = BoundaryOptions {
                tolerance: tol,
                max_iterations,
                guess: guess.as_ref().map(|[a, j]| (a.as_ref(), j.as_ref())),
                interrupt,
            };
            if all_found {
                let options = SearchOptions {
                    boundary,
                    ..SearchOptions::default()
                };
                return RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &options);
            }
            Ok(vec![RiemannianCubic::from_boundary(
                s0, v0, s1, v1, &boundary,
            )?])
        })?;
        let mut curves = curves
            .into_iter()
            .map(|curve| Self::wrapped(py, curve))
            .collect::<PyResult<Vec<_>>>()?;
        if all_found {
            return Ok(PyList::new(py, curves)?.into_any().unbind());
        }
        Ok(curves.swap_remove(0).into_any())
    }

    /// For files and pickles: all numbers of the curve, so that it comes back the same to the last bit.
    fn _stored<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        form(py, RiemannianCubic::KIND, &*self.0)
    }

    /// Curves do not change: a copy is the curve itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// How the boundary value problem was solved; None for a curve from initial data.
    #[getter]
    fn report(&self) -> Option<PySolverReport> {
        self.0.report().copied().map(PySolverReport)
    }

    /// Point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, each of shape (n, k).
    #[getter]
    fn initial<'py>(&self, py: Python<'py>) -> PyResult<Four<'py>> {
        let curve = Arc::clone(&self.0);
        let call = Call::new(py, None, reduction((self.0.n(), self.0.k())))?;
        let [s, v, a, j] = call.run(py, move |_| curve.initial())?;
        let array = |x: Mat<f64>| array(py, &x);
        Ok((array(s)?, array(v)?, array(a)?, array(j)?))
    }

    /// The conserved energy ``|D_t S'|^2 / 2 - <D_t D_t S', S'>``.
    #[getter]
    fn energy(&self, py: Python<'_>) -> PyResult<f64> {
        let energy = self.0.energy();
        energy.map_err(|error| to_exception(py, &error, ""))
    }

    /// The conserved spatial momentum, a skew matrix of shape (n, n); for ``n`` up to 16384.
    #[getter]
    fn momentum<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let n = self.0.n() as f64;
        let call = Call::new(py, None, 2.0 * n * n * n.min(4.0 * self.0.k() as f64))?;
        let curve = Arc::clone(&self.0);
        let momentum = call.run(py, move |_| curve.momentum())?;
        array(py, &momentum)
    }

    /// Number of polynomials that the curve consists of: the steps of its integration, or 1 for a piece of a spline that
    /// was solved without integration.
    #[getter]
    fn steps(&self) -> usize {
        self.0.steps()
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
        let curve = Arc::clone(&self.0);
        let call = Call::new(py, None, Operations::preparation(&*self.0, &[start, end]))?;
        let work = move |interrupt: crate::Interrupt<'_>| curve.restricted(start, end, interrupt);
        Self::wrapped(py, call.run(py, work)?)
    }

    /// The same points at other times: ``t_span`` becomes ``[start, end]``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``start >= end``, not finite, or so near or far that speeds leave the range of numbers.
    fn reparametrised(&self, py: Python<'_>, start: f64, end: f64) -> PyResult<Py<Self>> {
        let curve = self.0.reparametrised(start, end);
        Self::wrapped(py, curve.map_err(|error| to_exception(py, &error, ""))?)
    }

    /// The curve run backwards over the same interval.
    fn reversed(&self, py: Python<'_>) -> PyResult<Py<Self>> {
        Self::wrapped(py, self.0.reversed())
    }

    fn __repr__(&self) -> String {
        let (start, end) = Curve::t_span(&*self.0);
        let (n, k, steps) = (self.0.n(), self.0.k(), self.0.steps());
        format!("<RiemannianCubic on St({n}, {k}), t_span ({start:?}, {end:?}), {steps} steps>")
    }
}

impl PyRiemannianCubic {
    pub(super) fn restored(py: Python<'_>, form: Form) -> PyResult<Py<PyAny>> {
        Ok(Self::wrapped(py, form.curve(py)?)?.into_any())
    }

    pub(super) fn wrapped(py: Python<'_>, curve: RiemannianCubic) -> PyResult<Py<Self>> {
        let curve = Arc::new(curve);
        let base = PyCurve::of(Arc::clone(&curve) as Arc<dyn AnyCurve>);
        let class = PyClassInitializer::from(base).add_subclass(PyRiemannianCubic(curve));
        Py::new(py, class)
    }
}

/// Point, velocity, acceleration and jerk.
pub(super) struct Data(pub(super) [Mat<f64>; 4]);

impl Data {
    pub(super) fn read([s, v, a, j]: [(&Bound<'_, PyAny>, &'static str); 4]) -> PyResult<Self> {
        let read = |(object, name)| matrix(object, name);
        Ok(Data([read(s)?, read(v)?, read(a)?, read(j)?]))
    }

    fn integrate(self, py: Python<'_>, t_end: f64, tolerance: f64) -> PyResult<RiemannianCubic> {
        let Data(data) = self;
        let call = Call::new(py, None, integration(data.each_ref(), t_end))?;
        call.run(py, move |interrupt| {
            let [s, v, a, j] = data.each_ref().map(|x| x.as_ref());
            let options = IntegrationOptions {
                t_end,
                tolerance,
                interrupt,
            };
            RiemannianCubic::from_initial(s, v, a, j, &options)
        })
    }
}

/// A new array with the entries of a matrix.
pub(super) fn array<'py>(py: Python<'py>, x: &Mat<f64>) -> PyResult<Array<'py>> {
    let (n, k) = x.shape();
    let mut entries = vec![0.0; n * k];
    write(x.as_ref(), &mut entries);
    to_array(py, entries, &[n, k])
}
