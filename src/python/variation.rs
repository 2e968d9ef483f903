//! Derivatives of Riemannian cubics with respect to their boundary data, in the binding.

use super::prelude::*;
use super::riemannian_cubic::PyRiemannianCubic;
use crate::cubic::BoundaryVariation;
use crate::curve::Curve;

/// The work of derivatives of the ends by each other, for a number of a point: that of a boundary problem, with four matrices.
pub(super) const DERIVATIVES: f64 = 4.0 * SOLVES;

fn variation([s0, v0, s1, v1]: &[Mat<f64>; 4]) -> BoundaryVariation<'_> {
    BoundaryVariation {
        s0: s0.as_ref(),
        v0: v0.as_ref(),
        s1: s1.as_ref(),
        v1: v1.as_ref(),
    }
}

#[pymethods]
impl PyRiemannianCubic {
    /// How the initial data change where the boundary data do: implicit function theorem.
    ///
    /// Parameters
    /// ----------
    /// dS0, dV0, dS1, dV1 : array_like, shape (n, k)
    ///     Ambient derivatives of the boundary data along a family of data. So ``S.T @ dS`` is skew, and
    ///     ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` vanishes, at both ends.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, a variation that leaves the constraints (with the measured defect).
    /// OutsideDomainError
    ///     The ends are conjugate along the curve, to 1e-11: the solution does not depend smoothly on them. ``angle`` is
    ///     None.
    ///
    /// Notes
    /// -----
    /// Exact derivatives of the flow, no differences. Any Riemannian cubic is the solution of the boundary value problem
    /// of its own ends; this is the derivative of that solution.
    fn initial_variation(&self, dS0: &Any, dV0: &Any, dS1: &Any, dV1: &Any) -> PyResult<Four> {
        let data = matrices(named![dS0, dV0, dS1, dV1])?;
        let d = self.run(dS0.py(), DERIVATIVES, move |curve, interrupt| {
            let derivative = curve.boundary_derivative(interrupt)?;
            derivative.initial(&variation(&data), interrupt)
        })?;
        Ok(four([d.point, d.velocity, d.acceleration, d.jerk]))
    }

    /// How points of the curve change where the boundary data do.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters.
    /// dS0, dV0, dS1, dV1 : array_like, shape (n, k)
    ///     As in :meth:`initial_variation`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///     Ambient derivatives of the points.
    ///
    /// Raises
    /// ------
    /// InvalidInputError, OutsideDomainError
    ///     As :meth:`initial_variation`.
    fn point_variation(
        &self,
        t: &Any,
        dS0: &Any,
        dV0: &Any,
        dS1: &Any,
        dV1: &Any,
    ) -> PyResult<Array> {
        let data = matrices(named![dS0, dV0, dS1, dV1])?;
        let t = read(t, "t")?;
        self.run(dS0.py(), DERIVATIVES, move |curve, interrupt| {
            let derivative = curve.boundary_derivative(interrupt)?;
            let found = derivative.points(curve, &variation(&data), &t.entries, interrupt)?;
            Ok(Array::stacked(&t.shape, &found, (curve.n(), curve.k())))
        })
    }

    /// Gradient of the cost with respect to the boundary data.
    ///
    /// Returns
    /// -------
    /// tuple of ndarray, each of shape (n, k)
    ///     ``(GS0, GV0, GS1, GV1)``: the cost changes by ``sum(GS0 * dS0) + sum(GV0 * dV0) + sum(GS1 * dS1) +
    ///     sum(GV1 * dV1)`` for every variation of the boundary data as in :meth:`initial_variation`.
    ///
    /// Notes
    /// -----
    /// By the first variation of the cost at a critical curve: no equation has to be solved.
    fn cost_gradient(&self, py: Python<'_>) -> PyResult<Four> {
        let d = self.run(py, 1.0, |curve, _| curve.cost_gradient())?;
        Ok(four([d.s0, d.v0, d.s1, d.v1]))
    }
}
