//! Velocities from points, in Python.

use super::piecewise::Data;
use super::points::Points;
use super::prelude::*;
use crate::space::Quotient;
use crate::spline::{
    VelocityEstimate, estimate_closed_velocities, estimate_velocities as estimated,
};

/// The estimate of a word, the argument `name`.
fn read_method(name: &str, method: &str) -> PyResult<VelocityEstimate> {
    let expected = "'catmull-rom', 'akima' or 'natural'";
    VelocityEstimate::from_word(method)
        .ok_or_else(|| invalid!("{name}: expected {expected}, found {method:?}"))
}

/// Velocities at knots: given, or to be estimated.
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

/// Velocities of a smooth curve at its knots, from the points alone.
///
/// Parameters
/// ----------
/// t : array_like, shape (N,)
///     Times, increasing, two or more.
/// S : array_like, shape (N, n, k)
///     Points with orthonormal columns.
/// method : "catmull-rom", "akima" or "natural", default "catmull-rom"
///     ``"catmull-rom"``, the parabola through three neighbours. ``"akima"``, a mean of the slopes on both sides that
///     does not overshoot beside jumps and at rest (weights of SciPy's ``method="makima"``). ``"natural"``, the
///     velocities of the natural cubic spline in tangent spaces.
/// closed : bool, default False
///     Whether the curve is closed: the last point is the first one, and so is its velocity.
/// num_threads : int, optional
///     Threads; by default those of the global pool.
/// manifold : Stiefel or Grassmann, optional
///     What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
///     whichever, and the last one of a closed curve is any basis of the first subspace.
/// project : bool, default False
///     Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
///     Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.
///
/// Returns
/// -------
/// ndarray, shape (N, n, k)
///     Tangent vectors at the points, per unit of ``t``. On a :class:`Grassmann` they are horizontal at the given bases: a basis that is
///     turned turns its own velocity, and no other.
///
/// Raises
/// ------
/// InvalidInputError
///     Shapes or numbers of knots that do not match, not finite, times that do not increase, not orthonormal (with the
///     measured defect), ends that do not close; carries ``knot``.
/// OutsideDomainError
///     Neighbours that no quasi-geodesic joins, or subspaces with a principal angle of pi/2 between them; carries ``knot``, the first of
///     the two, and ``angle``.
/// TypeError
///     Complex times, dates and durations.
///
/// See Also
/// --------
/// CubicHermite : the curve through points with velocities; takes the name of a method for them.
///
/// Notes
/// -----
/// The formulas of flat space in tangent spaces; quasi-geodesics between neighbours carry vectors from knot to knot, of subspaces
/// geodesics. On the circle exactly those for the angle.
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
    let mut data = Data::read(t, S, &manifold, field)?;
    if closed {
        manifold.close(&mut data.points);
    }
    let (shape, quotient) = (data.shape(), manifold.quotient);
    let call = Call::new(t.py(), num_threads, data.points.numbers())?.over(field);
    let velocities = call.run(move |_| {
        let points = data.points.views();
        if closed {
            estimate_closed_velocities(&data.t, &points, estimate, quotient)
        } else {
            estimated(&data.t, &points, estimate, quotient)
        }
    })?;
    field
        .numbers(Array::stacked(&[velocities.len()], &velocities, shape))?
        .like(named![t, S])
}
