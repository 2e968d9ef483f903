//! Derivatives of Riemannian cubics with respect to their boundary data and initial data, and their transposes, in the binding.

use super::prelude::*;
use super::riemannian_cubic::PyRiemannianCubic;
use crate::cubic::{BoundaryVariation, InitialVariation};
use crate::curve::Curve;

/// Work of the derivatives of a boundary problem per number of a point: one boundary problem, with four matrices.
const DERIVATIVES: f64 = 4.0 * SOLVES;

fn variation([s0, v0, s1, v1]: &[Mat<f64>; 4]) -> BoundaryVariation<'_> {
    BoundaryVariation {
        s0: s0.as_ref(),
        v0: v0.as_ref(),
        s1: s1.as_ref(),
        v1: v1.as_ref(),
    }
}

/// Times, and a cotangent of shape `(n, k)` for each.
pub(super) struct Cotangents {
    pub(super) times: Vec<f64>,
    pub(super) matrices: Batch,
}

impl Cotangents {
    /// `shape` is the shape of the points in the core.
    pub(super) fn read(t: &Any, w: &Any, shape: (usize, usize), field: Field) -> PyResult<Self> {
        let (n, k) = field.own(shape);
        let Array {
            shape,
            entries: times,
        } = read(t, "t")?;
        let [matrices] = field.batches([(w, "W")])?;
        let (rows, cols) = matrices.own_shape();
        let expected = [&shape[..], &[n, k]].concat();
        let found = [&matrices.shape[..], &[rows, cols]].concat();
        if found != expected {
            let expected = format!("{}, the shape of curve(t)", tuple(&expected));
            return Err(unexpected("W", &expected, &found));
        }
        Ok(Cotangents { times, matrices })
    }
}

#[pymethods]
impl PyRiemannianCubic {
    /// Differentiate the initial data with respect to the boundary data, by the implicit function theorem.
    ///
    /// On a :class:`Grassmann` data and results belong to the bases of the curve, ``curve(t)``; at the end this basis
    /// differs from the given one by an orthogonal matrix. Derivatives of points are horizontal, ``S^H dS = 0``: the
    /// rotation of the bases themselves is left out. Vectors stay horizontal along the family, so that their
    /// derivatives satisfy ``S^H dV = -dS^H V`` and are horizontal if the point is fixed.
    ///
    /// Parameters
    /// ----------
    /// dS0, dV0, dS1, dV1 : array_like, shape (n, k)
    ///     Ambient derivatives of the boundary data along a family of data: at both ends ``S.T @ dS`` is skew, and
    ///     ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` is zero.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of
    ///     ``t_span``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, or a variation that violates the constraints (with the measured defect).
    /// OutsideDomainError
    ///     The ends are conjugate along the curve, to 1e-11, so that the solution does not depend smoothly on them;
    ///     ``angle`` is None.
    ///
    /// Notes
    /// -----
    /// Derivatives are exact, not finite differences. Any Riemannian cubic solves the boundary value problem of its own
    /// ends; this is the derivative of that solution.
    fn initial_variation(
        &self,
        dS0: &Any,
        dV0: &Any,
        dS1: &Any,
        dV1: &Any,
    ) -> PyResult<FourNumbers> {
        let data = self.field.matrices(named![dS0, dV0, dS1, dV1])?;
        let kept = self.derivative.clone();
        let d = self.run(dS0.py(), DERIVATIVES, move |curve, interrupt| {
            let derivative = kept.get(|| curve.boundary_derivative(interrupt))?;
            derivative.initial(&variation(&data), interrupt)
        })?;
        self.field.four(
            [d.point, d.velocity, d.acceleration, d.jerk],
            named![dS0, dV0, dS1, dV1],
        )
    }

    /// Differentiate points of the curve with respect to the boundary data.
    ///
    /// On a :class:`Grassmann` data and results belong to the bases of the curve, ``curve(t)``; at the end this basis
    /// differs from the given one by an orthogonal matrix. Derivatives of points are horizontal, ``S^H dS = 0``: the
    /// rotation of the bases themselves is left out. Vectors stay horizontal along the family, so that their
    /// derivatives satisfy ``S^H dV = -dS^H V`` and are horizontal if the point is fixed.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// dS0, dV0, dS1, dV1 : array_like, shape (n, k)
    ///     As for :meth:`initial_variation`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///     Ambient derivatives of the points.
    ///
    /// Raises
    /// ------
    /// InvalidInputError, OutsideDomainError
    ///     As for :meth:`initial_variation`.
    fn point_variation(
        &self,
        t: &Any,
        dS0: &Any,
        dV0: &Any,
        dS1: &Any,
        dV1: &Any,
    ) -> PyResult<Numbers> {
        let data = self.field.matrices(named![dS0, dV0, dS1, dV1])?;
        let times = read(t, "t")?;
        let kept = self.derivative.clone();
        let found = self.run(dS0.py(), DERIVATIVES, move |curve, interrupt| {
            let derivative = kept.get(|| curve.boundary_derivative(interrupt))?;
            let found = derivative.points(curve, &variation(&data), &times.entries, interrupt)?;
            Ok(Array::stacked(&times.shape, &found, (curve.n(), curve.k())))
        })?;
        self.field
            .vectors(found)?
            .like(named![t, dS0, dV0, dS1, dV1])
    }

    /// Return the gradient of the cost with respect to the boundary data.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     ``(GS0, GV0, GS1, GV1)``: the cost changes by ``sum(GS0 * dS0) + sum(GV0 * dV0) + sum(GS1 * dS1) +
    ///     sum(GV1 * dV1)`` for every variation of the boundary data as in :meth:`initial_variation`.
    ///
    /// Notes
    /// -----
    /// Uses the first variation of the cost at a critical curve, so no equation has to be solved.
    fn cost_gradient(&self, py: Python<'_>) -> PyResult<FourNumbers> {
        let d = self.run(py, 1.0, |curve, _| curve.cost_gradient())?;
        self.field.four([d.s0, d.v0, d.s1, d.v1], [])
    }

    /// Return the gradient of ``sum(W * curve(t))`` with respect to the boundary data.
    ///
    /// The transpose of :meth:`point_variation`.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// W : array_like, shape T + (n, k)
    ///     Derivatives of a function with respect to the points ``curve(t)``; need not be tangent.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     ``(GS0, GV0, GS1, GV1)``: ``sum(W * point_variation(t, dS0, dV0, dS1, dV1))`` equals ``sum(GS0 * dS0) +
    ///     sum(GV0 * dV0) + sum(GS1 * dS1) + sum(GV1 * dV1)`` for every variation of the boundary data.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries.
    /// OutsideDomainError
    ///     The ends are conjugate along the curve, to 1e-11, so that the solution does not depend smoothly on them;
    ///     ``angle`` is None.
    ///
    /// Notes
    /// -----
    /// Solves one linear system, whatever the number of parameters.
    fn point_pullback(&self, t: &Any, W: &Any) -> PyResult<FourNumbers> {
        let data = Cotangents::read(t, W, (self.curve.n(), self.curve.k()), self.field)?;
        let kept = self.derivative.clone();
        let d = self.run(t.py(), DERIVATIVES, move |curve, interrupt| {
            let derivative = kept.get(|| curve.boundary_derivative(interrupt))?;
            derivative.pull_back(&data.times, &data.matrices.views(), interrupt)
        })?;
        self.field.four([d.s0, d.v0, d.s1, d.v1], named![t, W])
    }

    /// Differentiate points of the curve with respect to its initial data.
    ///
    /// On a :class:`Grassmann` data and results belong to the bases of the curve, ``curve(t)``; at the end this basis
    /// differs from the given one by an orthogonal matrix. Derivatives of points are horizontal, ``S^H dS = 0``: the
    /// rotation of the bases themselves is left out. Vectors stay horizontal along the family, so that their
    /// derivatives satisfy ``S^H dV = -dS^H V`` and are horizontal if the point is fixed.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// dS, dV, dA, dJ : array_like, shape (n, k)
    ///     Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of
    ///     ``t_span``, along a family of data: ``S.T @ dS`` is skew, and ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS``
    ///     is zero, likewise for A and J.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///     Ambient derivatives of the points.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, or a variation that violates the constraints (with the measured defect).
    fn initial_point_variation(
        &self,
        t: &Any,
        dS: &Any,
        dV: &Any,
        dA: &Any,
        dJ: &Any,
    ) -> PyResult<Numbers> {
        let [point, velocity, acceleration, jerk] = self.field.matrices(named![dS, dV, dA, dJ])?;
        let variation = InitialVariation {
            point,
            velocity,
            acceleration,
            jerk,
        };
        let times = read(t, "t")?;
        let weight = 1.0 + times.entries.len() as f64;
        let found = self.run(dS.py(), weight, move |curve, interrupt| {
            let found = curve.initial_points(&variation, &times.entries, interrupt)?;
            Ok(Array::stacked(&times.shape, &found, (curve.n(), curve.k())))
        })?;
        self.field.vectors(found)?.like(named![t, dS, dV, dA, dJ])
    }

    /// Return the gradient of ``sum(W * curve(t))`` with respect to the initial data.
    ///
    /// The transpose of :meth:`initial_point_variation`.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// W : array_like, shape T + (n, k)
    ///     Derivatives of a function with respect to the points ``curve(t)``; need not be tangent.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     ``(GS, GV, GA, GJ)``: ``sum(W * initial_point_variation(t, dS, dV, dA, dJ))`` equals
    ///     ``sum(GS * dS) + sum(GV * dV) + sum(GA * dA) + sum(GJ * dJ)`` for every variation of the initial data.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries.
    fn initial_point_pullback(&self, t: &Any, W: &Any) -> PyResult<FourNumbers> {
        let data = Cotangents::read(t, W, (self.curve.n(), self.curve.k()), self.field)?;
        let times = data.times.len() as f64;
        let d = self.run(t.py(), 1.0 + times, move |curve, interrupt| {
            curve.initial_pull_back(&data.times, &data.matrices.views(), interrupt)
        })?;
        self.field
            .four([d.point, d.velocity, d.acceleration, d.jerk], named![t, W])
    }
}
