//! Gradients of functions of points of Riemannian cubics, and derivatives by initial data, in the binding.

use std::sync::Arc;

use pyo3::prelude::*;

use super::batch::{Batch, matrix_batches};
use super::call::run;
use super::convert::{Any, Four, NewArray, four, matrices, named, parameters, tuple};
use super::error::invalid_input;
use super::riemannian_cubic::PyRiemannianCubic;
use super::work::EXPONENTIALS;
use crate::cubic::InitialVariation;
use crate::curve::Curve;

/// Times, and a cotangent of shape `(n, k)` for each of them.
pub(super) struct Cotangents {
    pub(super) times: Vec<f64>,
    pub(super) matrices: Batch,
}

impl Cotangents {
    pub(super) fn read(t: &Any<'_>, w: &Any<'_>, (n, k): (usize, usize)) -> PyResult<Self> {
        let (shape, times) = parameters(t, "t")?;
        let [matrices] = matrix_batches([(w, "W")])?;
        let mut expected = shape;
        expected.extend([n, k]);
        let mut found = matrices.shape.clone();
        found.extend([matrices.rows, matrices.cols]);
        if found == expected {
            return Ok(Cotangents { times, matrices });
        }
        let [expected, found] = [expected, found].map(|shape| tuple(&shape));
        let message =
            format!("W: expected shape {expected}, that of the points at t, found {found}");
        Err(invalid_input(message))
    }
}

impl PyRiemannianCubic {
    /// Estimated operations of derivatives by initial data at so many times.
    fn integrations(&self, times: usize) -> f64 {
        EXPONENTIALS * (self.0.n() * self.0.k() * (1 + times)) as f64
    }
}

#[pymethods]
#[allow(non_snake_case)]
impl PyRiemannianCubic {
    /// Gradient with respect to the boundary data of ``sum(W * curve(t))``: the transpose of :meth:`point_variation`.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// W : array_like, shape T + (n, k)
    ///     Derivatives of a function by the points of the curve there; any matrices.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     ``(GS0, GV0, GS1, GV1)``: ``sum(W * point_variation(t, dS0, dV0, dS1, dV1))`` is ``sum(GS0 * dS0) + sum(GV0 * dV0) +
    ///     sum(GS1 * dS1) + sum(GV1 * dV1)`` for every variation of the boundary data.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite.
    /// OutsideDomainError
    ///     The ends are conjugate along the curve, to 1e-11: the solution does not depend smoothly on them. ``angle`` is
    ///     None.
    ///
    /// Notes
    /// -----
    /// One solution of the linear equations, whatever the number of parameters.
    fn point_pullback(&self, py: Python<'_>, t: &Any<'_>, W: &Any<'_>) -> PyResult<Four> {
        let data = Cotangents::read(t, W, (self.0.n(), self.0.k()))?;
        let curve = Arc::clone(&self.0);
        let found = run(py, self.derivatives(), move |interrupt| {
            let derivative = curve.boundary_derivative(interrupt)?;
            derivative.pull_back(&data.times, &data.matrices.views(), interrupt)
        })?;
        Ok(four([found.s0, found.v0, found.s1, found.v1]))
    }

    /// How points of the curve change where its initial data do.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// dS, dV, dA, dJ : array_like, shape (n, k)
    ///     Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, along a
    ///     family of data. So ``S.T @ dS`` is skew, and ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` vanishes, for A and J too.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///     Ambient derivatives of the points.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, a variation that leaves the constraints (with the measured defect).
    fn initial_point_variation(
        &self,
        py: Python<'_>,
        t: &Any<'_>,
        dS: &Any<'_>,
        dV: &Any<'_>,
        dA: &Any<'_>,
        dJ: &Any<'_>,
    ) -> PyResult<NewArray> {
        let [point, velocity, acceleration, jerk] = matrices(named![dS, dV, dA, dJ])?;
        let variation = InitialVariation {
            point,
            velocity,
            acceleration,
            jerk,
        };
        let (shape, times) = parameters(t, "t")?;
        let curve = Arc::clone(&self.0);
        run(py, self.integrations(times.len()), move |interrupt| {
            let found = curve.initial_points(&variation, &times, interrupt)?;
            Ok(NewArray::stacked(&shape, &found, (curve.n(), curve.k())))
        })
    }

    /// Gradient with respect to the initial data of ``sum(W * curve(t))``: the transpose of :meth:`initial_point_variation`.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// W : array_like, shape T + (n, k)
    ///     Derivatives of a function by the points of the curve there; any matrices.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     ``(GS, GV, GA, GJ)``: ``sum(W * initial_point_variation(t, dS, dV, dA, dJ))`` is ``sum(GS * dS) + sum(GV * dV) +
    ///     sum(GA * dA) + sum(GJ * dJ)`` for every variation of the initial data.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite.
    fn initial_point_pullback(&self, py: Python<'_>, t: &Any<'_>, W: &Any<'_>) -> PyResult<Four> {
        let data = Cotangents::read(t, W, (self.0.n(), self.0.k()))?;
        let curve = Arc::clone(&self.0);
        let operations = self.integrations(data.times.len());
        let found = run(py, operations, move |interrupt| {
            curve.initial_pull_back(&data.times, &data.matrices.views(), interrupt)
        })?;
        Ok(four([
            found.point,
            found.velocity,
            found.acceleration,
            found.jerk,
        ]))
    }
}
