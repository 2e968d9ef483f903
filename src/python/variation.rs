//! Derivatives of Riemannian cubics with respect to their boundary data, in the binding.

use std::sync::Arc;

use faer::Mat;
use pyo3::prelude::*;

use super::call::Call;
use super::convert::{parameters, to_array};
use super::riemannian_cubic::{Array, Data, Four, PyRiemannianCubic, array, shooting};
use super::velocities::rows;
use crate::cubic::{BoundaryVariation, RiemannianCubic};
use crate::curve::Curve;

fn variation([s0, v0, s1, v1]: &[Mat<f64>; 4]) -> BoundaryVariation<'_> {
    BoundaryVariation {
        s0: s0.as_ref(),
        v0: v0.as_ref(),
        s1: s1.as_ref(),
        v1: v1.as_ref(),
    }
}

/// For the rough operations of a derivative: those of a boundary value problem of the same size.
fn call(py: Python<'_>, curve: &RiemannianCubic) -> PyResult<Call> {
    let size = Mat::zeros(curve.n(), curve.k());
    Call::new(py, None, shooting([&size; 4]))
}

#[pymethods]
#[allow(non_snake_case)]
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
    fn initial_variation<'py>(
        &self,
        py: Python<'py>,
        dS0: &Bound<'py, PyAny>,
        dV0: &Bound<'py, PyAny>,
        dS1: &Bound<'py, PyAny>,
        dV1: &Bound<'py, PyAny>,
    ) -> PyResult<Four<'py>> {
        let Data(data) = Data::read([(dS0, "dS0"), (dV0, "dV0"), (dS1, "dS1"), (dV1, "dV1")])?;
        let curve = Arc::clone(&self.0);
        let found = call(py, &self.0)?.run(py, move |interrupt| {
            curve
                .boundary_derivative(interrupt)?
                .initial(&variation(&data), interrupt)
        })?;
        let array = |x: &Mat<f64>| array(py, x);
        Ok((
            array(&found.point)?,
            array(&found.velocity)?,
            array(&found.acceleration)?,
            array(&found.jerk)?,
        ))
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
    fn point_variation<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        dS0: &Bound<'py, PyAny>,
        dV0: &Bound<'py, PyAny>,
        dS1: &Bound<'py, PyAny>,
        dV1: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let Data(data) = Data::read([(dS0, "dS0"), (dV0, "dV0"), (dS1, "dS1"), (dV1, "dV1")])?;
        let (mut shape, times) = parameters(t, "t")?;
        let curve = Arc::clone(&self.0);
        let entries = call(py, &self.0)?.run(py, move |interrupt| {
            let derivative = curve.boundary_derivative(interrupt)?;
            let found = derivative.points(&curve, &variation(&data), &times, interrupt)?;
            Ok(rows(&found, curve.n() * curve.k()))
        })?;
        shape.extend([self.0.n(), self.0.k()]);
        to_array(py, entries, &shape)
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
    fn cost_gradient<'py>(&self, py: Python<'py>) -> PyResult<Four<'py>> {
        let curve = Arc::clone(&self.0);
        let (n, k) = (self.0.n() as f64, self.0.k() as f64);
        let operations = 1e4 + 1e3 * n * k * k;
        let found = Call::new(py, None, operations)?.run(py, move |_| curve.cost_gradient())?;
        let array = |x: &Mat<f64>| array(py, x);
        Ok((
            array(&found.s0)?,
            array(&found.v0)?,
            array(&found.s1)?,
            array(&found.v1)?,
        ))
    }
}
