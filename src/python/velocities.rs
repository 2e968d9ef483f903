//! Velocities from points, in Python.

use super::piecewise::SplineData;
use super::points::Points;
use super::prelude::*;
use crate::space::Quotient;
use crate::spline::{
    VelocityEstimate, estimate_closed_velocities, estimate_velocities as estimated,
};

/// The estimate with a given name; `name` is the argument.
fn read_method(name: &str, method: &str) -> PyResult<VelocityEstimate> {
    let expected = "'catmull-rom', 'akima' or 'natural'";
    VelocityEstimate::from_word(method)
        .ok_or_else(|| invalid!("{name}: expected {expected}, found {method:?}"))
}

/// Velocities at knots, given or to be estimated.
pub(super) enum Velocities {
    Given(Batch),
    Estimated(VelocityEstimate),
}

impl Velocities {
    pub(super) fn read(object: &Any, manifold: &Points, points: &Batch) -> PyResult<Self> {
        if let Ok(word) = object.cast::<PyString>() {
            let method = read_method("V", word.to_str()?);
            return method.map(Velocities::Estimated);
        }
        let vectors = manifold.vectors_at_knots(points, (object, "V"))?;
        Ok(Velocities::Given(vectors))
    }

    /// The vectors, each of shape `(n, k)`.
    pub(super) fn vectors(
        &self,
        t: &[f64],
        points: &[MatRef<'_, f64>],
        quotient: Quotient,
    ) -> Result<Vec<Mat<f64>>> {
        match self {
            Velocities::Given(batch) => Ok(batch.views().iter().map(|v| v.to_owned()).collect()),
            Velocities::Estimated(estimate) => estimated(t, points, *estimate, quotient),
        }
    }
}

/// Estimate the velocities of a smooth curve at its knots, from the points alone.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     At least two increasing times.
/// S : array_like, shape (N, n, k)
///     Points with orthonormal columns.
/// method : "catmull-rom", "akima" or "natural", default "catmull-rom"
///     ``"catmull-rom"``, the parabola through three neighbours. ``"akima"``, a weighted mean of the slopes on both
///     sides that does not overshoot next to jumps and rests (weights of SciPy's ``method="makima"``). ``"natural"``,
///     the velocities of the natural cubic spline in tangent spaces.
/// closed : bool, default False
///     Whether the curve is closed: the last point and velocity equal the first.
/// num_threads : int, optional
///     Number of threads; by default the size of the global pool.
/// manifold : Stiefel or Grassmann, optional
///     Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
///     are arbitrary bases of subspaces, and the last point of a closed curve is any basis of the first subspace.
/// project : bool, default False
///     If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
///     their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
///     single precision are always projected.
///
/// Returns
/// -------
/// ndarray, shape (N, n, k)
///     Tangent vectors at the points, per unit of ``t``. On a :class:`Grassmann` they are horizontal at the given
///     bases: changing the basis of one point changes the matrix of its own velocity only.
///
/// Raises
/// ------
/// InvalidInputError
///     Mismatched shapes or numbers of knots, non-finite entries, times that do not increase, points not orthonormal
///     (with the measured defect), closed data that do not close; carries ``knot``.
/// OutsideDomainError
///     No quasi-geodesic joins two consecutive points, or two consecutive subspaces have a principal angle of pi/2;
///     carries ``knot``, the index of the first, and ``angle``.
/// TypeError
///     ``t`` is complex, or holds dates or durations.
///
/// See Also
/// --------
/// CubicHermite : curve through points with velocities; also accepts the name of a method.
///
/// Notes
/// -----
/// The formulas of flat space are applied in tangent spaces. Quasi-geodesics between neighbours, for subspaces
/// geodesics, carry vectors from knot to knot. On the circle the result equals the formulas applied to the angle.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import estimate_velocities
/// >>> t = np.array([0.0, 1.0, 3.0])
/// >>> S = np.array([[[np.cos(a)], [np.sin(a)]] for a in t / 4])
/// >>> V = estimate_velocities(t, S, "akima")
/// >>> bool(np.allclose(V[0].ravel(), [0, 1 / 4]))
/// True
#[pyfunction]
#[pyo3(signature = (t, S, method="catmull-rom", *, closed=false, num_threads=None, manifold=None, project=false))]
pub fn estimate_velocities(
    t: &Any,
    S: &Any,
    method: &str,
    closed: bool,
    num_threads: Option<i64>,
    manifold: Option<&Any>,
    project: bool,
) -> PyResult<Numbers> {
    let estimate = read_method("method", method)?;
    let manifold = Points::read(manifold, project)?;
    let field = manifold.field([S])?;
    let mut data = SplineData::read(t, S, &manifold, field)?;
    if closed {
        manifold.close(&mut data.points);
    }
    let (shape, quotient) = (data.shape(), manifold.quotient);
    let call = Call::new(t.py(), num_threads, data.points.numbers())?
        .over(field)
        .distributed(true);
    let velocities = call.run(move |_| {
        let points = data.points.views();
        if closed {
            estimate_closed_velocities(&data.t, &points, estimate, quotient)
        } else {
            estimated(&data.t, &points, estimate, quotient)
        }
    })?;
    field
        .vectors(Array::stacked(&[velocities.len()], &velocities, shape))?
        .like(named![t, S])
}
