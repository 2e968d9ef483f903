//! Points and tangent vectors as they come: what is on the manifold to the precision of its numbers, or is to be projected,
//! is replaced by the nearest that there is on the manifold.
//!
//! The letters of arguments say what they are: S, Y and P are points; U, V, W, A and J tangent vectors at the point named
//! before them; all others are any matrices.

use super::error::of_complex;
use super::prelude::*;
use crate::linalg::structure::{check_finite, norm};
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::manifold::{Grassmann, Stiefel};
use crate::space::Quotient;

/// The defect up to which points in single precision are points, and their vectors, relative to their length, tangent:
/// a hundred times the round-off of an entry.
pub(super) const SINGLE: f64 = 1e-5;

/// The same for points and vectors that are asked to be projected.
const PROJECTED: f64 = 0.1;

/// What a matrix may be off the manifold, and be replaced.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Projection {
    /// By the round-off of its numbers.
    OfRoundOff,
    /// By up to a tenth.
    Wanted,
}

impl Projection {
    /// The argument `project`.
    pub(super) fn of(project: bool) -> Self {
        match project {
            true => Projection::Wanted,
            false => Projection::OfRoundOff,
        }
    }

    /// The largest defect of what is replaced; `None` where nothing is.
    fn limit(self, single: bool) -> Option<f64> {
        match self {
            Projection::Wanted => Some(PROJECTED),
            Projection::OfRoundOff => single.then_some(SINGLE),
        }
    }
}

/// What an argument is.
enum Role {
    Point,
    Vector,
    Matrix,
}

fn role(name: &str) -> Role {
    match name.as_bytes().first() {
        Some(b'S' | b'Y' | b'P') => Role::Point,
        Some(b'U' | b'V' | b'W' | b'A' | b'J') => Role::Vector,
        _ => Role::Matrix,
    }
}

/// The exception for an error of a member of a batch with the given leading axes.
type Place = fn(&Error, usize, &[usize]) -> PyErr;

/// Arguments with their names, put on a manifold.
///
/// # Errors
/// `InvalidInputError` for what is off by more than is allowed. What the core refuses anyway, such as other shapes and numbers
/// that are not finite, is left to it.
pub(super) fn on_manifold<const N: usize>(
    names: [&'static str; N],
    batches: &mut [Batch; N],
    quotient: Quotient,
    projection: Projection,
    place: Place,
) -> PyResult<()> {
    let mut point = None;
    for (i, name) in names.into_iter().enumerate() {
        let (before, rest) = batches.split_at_mut(i);
        match role(name) {
            Role::Point => {
                put_points(name, &mut rest[0], projection, place)?;
                point = Some(i);
            }
            Role::Vector => {
                if let Some(point) = point {
                    put_vectors(
                        name,
                        &before[point],
                        &mut rest[0],
                        quotient,
                        projection,
                        place,
                    )?;
                }
            }
            Role::Matrix => {}
        }
    }
    Ok(())
}

/// Points, put on the manifold.
pub(super) fn put_points(
    name: &'static str,
    points: &mut Batch,
    projection: Projection,
    place: Place,
) -> PyResult<()> {
    let Some(limit) = projection.limit(points.single) else {
        return Ok(());
    };
    let field = points.field();
    points.replace(field, place, |_, point| {
        let Ok(manifold) = Stiefel::of(name, point) else {
            return Ok(None);
        };
        if check_finite(name, point).is_err()
            || manifold.check_point(name, point, POINT_TOLERANCE).is_ok()
        {
            return Ok(None);
        }
        manifold.check_point(name, point, limit / field.length(1.0))?;
        manifold.project(point).map(Some)
    })
}

/// Vectors, put into tangent spaces.
pub(super) fn put_vectors(
    name: &'static str,
    points: &Batch,
    vectors: &mut Batch,
    quotient: Quotient,
    projection: Projection,
    place: Place,
) -> PyResult<()> {
    let Some(limit) = projection.limit(points.single || vectors.single) else {
        return Ok(());
    };
    let alike = (points.len(), points.rows, points.cols);
    if (vectors.len(), vectors.rows, vectors.cols) != alike {
        return Ok(());
    }
    let field = vectors.field();
    vectors.replace(field, place, |i, vector| {
        let point = points.get(i);
        if check_finite(name, vector).is_err() || check_finite(name, point).is_err() {
            return Ok(None);
        }
        let limit = core_tolerance(limit, field.length(1.0), vector);
        match quotient {
            Quotient::Frames => {
                let manifold = Stiefel::of(name, point)?;
                if manifold
                    .check_tangent(name, point, vector, TANGENT_TOLERANCE)
                    .is_ok()
                {
                    return Ok(None);
                }
                manifold.check_tangent(name, point, vector, limit)?;
                manifold.project_tangent(point, vector).map(Some)
            }
            Quotient::Subspaces => {
                let manifold = Grassmann::of(name, point)?;
                if manifold
                    .check_tangent(name, point, vector, TANGENT_TOLERANCE)
                    .is_ok()
                {
                    return Ok(None);
                }
                manifold.check_tangent(name, point, vector, limit)?;
                manifold.project_tangent(point, vector).map(Some)
            }
        }
    })
}

/// The tolerance of the core for one that counts relative to the length of a vector where that exceeds 1: the core multiplies by
/// its own norm, in which complex vectors are longer; `unit` is a unit of it.
pub(super) fn core_tolerance(atol: f64, unit: f64, vector: MatRef<'_, f64>) -> f64 {
    match norm(vector) {
        long if long > 1.0 / unit => atol,
        long => atol / unit / long.max(1.0),
    }
}

impl Batch {
    /// Replaces members by what `member` makes of them, or leaves them.
    fn replace(
        &mut self,
        field: Field,
        place: Place,
        member: impl Fn(usize, MatRef<'_, f64>) -> Result<Option<Mat<f64>>>,
    ) -> PyResult<()> {
        for i in 0..self.len() {
            let replaced = member(i, self.get(i)).map_err(|error| match field {
                Field::Real => error,
                Field::Complex => of_complex(error),
            });
            match replaced {
                Ok(None) => {}
                Ok(Some(matrix)) => write(matrix.as_ref(), self.row_mut(i)),
                Err(error) => return Err(place(&error, i, &self.shape)),
            }
        }
        Ok(())
    }
}

/// [`Place`] of the points at knots.
pub(super) fn at_knot_of(error: &Error, knot: usize, _: &[usize]) -> PyErr {
    Error::AtKnot {
        knot,
        source: Box::new(error.clone()),
    }
    .into()
}
