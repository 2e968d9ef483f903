//! Derivatives of splines of Riemannian cubics with respect to their data, in the binding.

use super::kept::Kept;
use super::knots::{BcType, pair};
use super::piecewise::Cubics;
use super::prelude::*;
use super::spline::PyCubicSpline;
use super::variation::Cotangents;
use crate::cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::space::Quotient;
use crate::spline::{
    EndCondition, EndConditions, Piecewise, SplineDerivative, SplineGradient, SplineVariation,
};

/// A spline of Riemannian cubics with its end conditions.
struct SplineWithEnds {
    curve: Arc<Piecewise<RiemannianCubic>>,
    ends: EndConditions,
    field: Field,
    derivative: Kept<SplineDerivative>,
}

/// `(GS, Gt, Gbc)`.
type Gradient = (Numbers, Numbers, (Option<Numbers>, Option<Numbers>));

impl SplineWithEnds {
    fn of(slf: &Bound<'_, PyCubicSpline>) -> PyResult<Self> {
        let py = slf.py();
        let Cubics::Riemannian(curve) = &slf.as_super().get().cubics else {
            let expected = "derivatives need kind='riemannian'";
            return Err(invalid!("kind: {expected}, found 'geometric'"));
        };
        let field = slf.as_super().as_super().get().field;
        let given: BcType<'_> = slf.get().bc_type.extract(py)?;
        let ends = given.read(py, field, (curve.n(), curve.k()))?.conditions;
        let curve = Arc::clone(curve);
        let ends = match Curve::quotient(&*curve) {
            Quotient::Frames => ends,
            Quotient::Subspaces => {
                let given = slf.as_super().get().points.bind(py);
                let points = field.batch(given, "S", "(N, n, k)")?;
                in_terms_of_curve(&curve, points.get(points.len() - 1), ends)?
            }
        };
        let derivative = slf.get().derivative.clone();
        Ok(SplineWithEnds {
            curve,
            ends,
            field,
            derivative,
        })
    }

    fn shape(&self) -> (usize, usize) {
        (self.curve.n(), self.curve.k())
    }

    fn derivative(&self, interrupt: Interrupt<'_>) -> Result<&SplineDerivative> {
        self.derivative
            .get(|| self.curve.data_derivative(&self.ends, interrupt))
    }

    /// Runs `work`: a linear system for all pieces, and points at some times.
    fn run<T: Send + 'static>(
        self,
        py: Python<'_>,
        times: usize,
        work: impl FnOnce(&Self, Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let ((n, k), matrices) = (self.shape(), self.curve.pieces().len() + times);
        let numbers = SOLVES * (matrices * n * k) as f64;
        run(py, self.field, numbers, move |interrupt| {
            work(&self, interrupt)
        })
    }
}

/// End conditions of a spline of subspaces whose vector at the last knot refers to the basis that the curve has there,
/// not to the given one.
fn in_terms_of_curve(
    curve: &Piecewise<RiemannianCubic>,
    last: MatRef<'_, f64>,
    ends: EndConditions,
) -> Result<EndConditions> {
    let EndConditions::Each(mut each) = ends else {
        return Ok(ends);
    };
    let turn = last.transpose() * curve.point(Curve::t_span(curve).1)?;
    let (EndCondition::Velocity(vector) | EndCondition::Acceleration(vector)) = &mut each[1];
    *vector = &*vector * turn;
    Ok(EndConditions::Each(each))
}

/// Variations of the vectors in the end conditions: the given ones, zero for others.
fn end_changes(spline: &SplineWithEnds, dbc: Option<&Any>) -> PyResult<[Option<Mat<f64>>; 2]> {
    let given = match dbc {
        None => [None, None],
        Some(items) => {
            let [first, last] = pair(items, "dbc", "changes of the vectors at both ends")?;
            let read = |item: Any<'_>| match item.is_none() {
                true => Ok(None),
                false => spline.field.matrix(&item, "dbc").map(Some),
            };
            [read(first)?, read(last)?]
        }
    };
    let (n, k) = spline.shape();
    // End conditions without a vector have no variation.
    let zero = matches!(spline.ends, EndConditions::Each(_)).then(|| Mat::zeros(n, k));
    Ok(given.map(|end| end.or_else(|| zero.clone())))
}

/// Variations of the times, shape (N,).
fn moves(dt: &Any) -> PyResult<Vec<f64>> {
    let Array { shape, entries } = read(dt, "dt")?;
    match shape.len() == 1 && !entries.is_empty() {
        true => Ok(entries),
        false => Err(unexpected("dt", "(N,)", &shape)),
    }
}

/// Converts a gradient of a function linear in the squared lengths of the core. Gradients by matrices are unchanged,
/// since their products with variations double too.
fn gradient<const N: usize>(
    field: Field,
    shape: (usize, usize),
    found: SplineGradient,
    arguments: [Named<'_, '_>; N],
) -> PyResult<Gradient> {
    let points = Array::stacked(&[found.points.len()], &found.points, shape);
    let ends = found.ends.map(|end| {
        let end = end.map(|end| field.vectors(Array::from(end))?.like(arguments));
        end.transpose()
    });
    let [first, last] = collected(ends)?;
    let times = found.times.into_iter().map(|time| field.squared(time));
    let times = Numbers::from(Array::flat(times.collect())).like(arguments)?;
    let points = field.vectors(points)?.like(arguments)?;
    Ok((points, times, (first, last)))
}

#[pymethods]
impl PyCubicSpline {
    /// Differentiate points of the spline with respect to its data, by the implicit function theorem.
    ///
    /// On a :class:`Grassmann` variations belong to the bases of the curve at its knots, ``curve(t)``, which differ
    /// from ``S`` by orthogonal matrices; those of points are horizontal, those of vectors satisfy
    /// ``S^H dV = -dS^H V``. At the end of a periodic curve the first basis returns multiplied by
    /// ``Q = curve(t[0])^H curve(t[-1])``.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Times.
    /// dS : array_like, shape (N, n, k)
    ///     Ambient derivatives of the points along a family of data: ``S.T @ dS`` is skew for each. With periodic ends
    ///     the last equals the first; on a :class:`Grassmann` ``dS[-1] = dS[0] @ Q``.
    /// dt : array_like, shape (N,), optional
    ///     Derivatives of the times of the knots; by default zero.
    /// dbc : pair of array_like, shape (n, k), or None, optional
    ///     Ambient derivatives of the vectors in ``bc_type`` at the first and at the last knot:
    ///     ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` is zero. By default, and for None, zero; this is valid for
    ///     vectors that remain zero, as with ``"clamped"``.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///     Ambient derivatives of the points at the fixed times ``t``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, or a variation that violates the constraints (with the measured defect); a
    ///     spline with ``kind="geometric"``, or one solved with so large a tolerance that its error exceeds 1e-6.
    /// OutsideDomainError
    ///     The spline does not depend smoothly on its data, to 1e-11; ``angle`` is None.
    ///
    /// Notes
    /// -----
    /// Derivatives are exact, not finite differences: they combine the derivatives of the accelerations at the ends of
    /// the pieces with respect to points and velocities there, and a linear system for the velocities, in time linear
    /// in the number of knots.
    #[pyo3(signature = (t, dS, dt=None, dbc=None))]
    fn point_variation(
        slf: &Bound<'_, Self>,
        t: &Any,
        dS: &Any,
        dt: Option<&Any>,
        dbc: Option<&Any>,
    ) -> PyResult<Numbers> {
        let spline = SplineWithEnds::of(slf)?;
        let times = read(t, "t")?;
        let field = spline.field;
        let points = field.batch(dS, "dS", "(N, n, k)")?;
        let moves = dt.map_or(Ok(Vec::new()), moves)?;
        let ends = end_changes(&spline, dbc)?;
        let found = spline.run(slf.py(), times.entries.len(), move |spline, interrupt| {
            let variation = SplineVariation {
                points: &points.views(),
                times: &moves,
                ends: ends.each_ref().map(|end| end.as_ref().map(Mat::as_ref)),
            };
            let derivative = spline.derivative(interrupt)?;
            let found = derivative.points(&variation, &times.entries, interrupt)?;
            Ok(Array::stacked(&times.shape, &found, spline.shape()))
        })?;
        field.vectors(found)?.like(named![t, dS])
    }

    /// Return the gradient of ``sum(W * curve(t))`` with respect to the data.
    ///
    /// The transpose of :meth:`point_variation`.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Times.
    /// W : array_like, shape T + (n, k)
    ///     Derivatives of a function with respect to the points ``curve(t)``; need not be tangent.
    ///
    /// Returns
    /// -------
    /// GS : ndarray, shape (N, n, k)
    ///     With respect to the points. With periodic ends the gradient by the common end point is the sum of the first
    ///     and the last entry; on a :class:`Grassmann`, ``GS[0] + GS[-1] Q^H`` with the ``Q`` of
    ///     :meth:`point_variation`.
    /// Gt : ndarray, shape (N,)
    ///     With respect to the times.
    /// Gbc : tuple
    ///     With respect to the vectors in ``bc_type`` at the first and at the last knot, shape (n, k); None if there is
    ///     none.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries; a spline with ``kind="geometric"``, or one solved with so large a tolerance
    ///     that its error exceeds 1e-6.
    /// OutsideDomainError
    ///     The spline does not depend smoothly on its data, to 1e-11; ``angle`` is None.
    ///
    /// Notes
    /// -----
    /// ``sum(W * point_variation(t, dS, dt, dbc))`` equals the sum of the products of the gradients with the
    /// variations. Solves one linear system, whatever the number of times.
    fn point_pullback(slf: &Bound<'_, Self>, t: &Any, W: &Any) -> PyResult<Gradient> {
        let spline = SplineWithEnds::of(slf)?;
        let (field, shape) = (spline.field, spline.shape());
        let data = Cotangents::read(t, W, shape, field)?;
        let found = spline.run(slf.py(), data.times.len(), move |spline, interrupt| {
            let derivative = spline.derivative(interrupt)?;
            derivative.pull_back(&data.times, &data.matrices.views(), interrupt)
        })?;
        gradient(field, shape, found, named![t, W])
    }

    /// Return the gradient of the cost with respect to points, times and end conditions.
    ///
    /// Returns
    /// -------
    /// GS : ndarray, shape (N, n, k)
    ///     With respect to the points. With periodic ends the gradient by the common end point is the sum of the first
    ///     and the last entry; on a :class:`Grassmann`, ``GS[0] + GS[-1] Q^H`` with the ``Q`` of
    ///     :meth:`point_variation`.
    /// Gt : ndarray, shape (N,)
    ///     With respect to the times.
    /// Gbc : tuple
    ///     With respect to the vectors in ``bc_type`` at the first and at the last knot, shape (n, k); None if there is
    ///     none.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     A spline with ``kind="geometric"``, or one solved with so large a tolerance that its error exceeds 1e-6.
    /// OutsideDomainError
    ///     ``bc_type`` gives an acceleration, and the spline does not depend smoothly on its data, to 1e-11; ``angle``
    ///     is None.
    ///
    /// Notes
    /// -----
    /// Uses the first variation of the cost; an equation has to be solved only if ``bc_type`` gives an acceleration.
    fn cost_gradient(slf: &Bound<'_, Self>) -> PyResult<Gradient> {
        let spline = SplineWithEnds::of(slf)?;
        let (field, shape) = (spline.field, spline.shape());
        let found = spline.run(slf.py(), 0, |spline, interrupt| {
            spline.curve.cost_gradient(&spline.ends, interrupt)
        })?;
        gradient(field, shape, found, [])
    }
}
