//! Points and tangent vectors as given: those on the manifold to the precision of their numbers, and those to be projected,
//! are replaced by the nearest exact ones.
//!
//! The letters of arguments tell their role: S, Y and P are points; U, V, W, A and J tangent vectors at the point named
//! before them; all others are arbitrary matrices.

use super::batch::Failure;
use super::prelude::*;
use super::projection::Projection;
use crate::linalg::structure::{check_finite, norm};
use crate::manifold::Stiefel;
use crate::manifold::stiefel::POINT_TOLERANCE;
use crate::manifold::tangent::{check_vector, check_vector_to, tangent_part};
use crate::space::Quotient;

/// Role of an argument.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Point,
    Vector,
    Matrix,
}

/// Role of an argument by its name.
pub(super) fn role(name: &'static str) -> (Role, &'static str) {
    let role = match name.as_bytes().first() {
        Some(b'S' | b'Y' | b'P') => Role::Point,
        Some(b'U' | b'V' | b'W' | b'A' | b'J') => Role::Vector,
        _ => Role::Matrix,
    };
    (role, name)
}

/// The exception for an error of a member of a batch with the given leading axes.
type MemberError = fn(&Error, usize, &[usize]) -> PyErr;

/// Least number of members in a task of the thread pool.
const TOGETHER: usize = 64;

/// Work of a projection per number, relative to an exponential.
const WORK: f64 = 10.0;

/// Puts arguments on a manifold, without the interpreter.
///
/// # Errors
/// `InvalidInputError` for a defect above the limit. Input that the core rejects, such as wrong shapes and numbers that
/// are not finite, is left to it.
pub(super) fn on_manifold<const N: usize>(
    py: Python<'_>,
    roles: [(Role, &'static str); N],
    batches: [Batch; N],
    quotient: Quotient,
    projection: Projection,
    place: MemberError,
) -> PyResult<[Batch; N]> {
    if batches
        .iter()
        .all(|batch| projection.limit(batch.single).is_none())
    {
        return Ok(batches);
    }
    let (field, shape) = (batches[N - 1].field(), batches[N - 1].shape.clone());
    let numbers: f64 = batches.iter().map(Batch::numbers).sum();
    let call = Call::new(py, None, WORK * numbers)?.over(field);
    let (batches, failure) = call.run_any(move |interrupt| {
        let mut batches = batches;
        let failure = put(roles, &mut batches, quotient, projection, interrupt).err();
        (batches, failure)
    })?;
    match failure {
        Some((member, error)) => Err(place(&call.explained(error), member, &shape)),
        None => Ok(batches),
    }
}

fn put<const N: usize>(
    roles: [(Role, &'static str); N],
    batches: &mut [Batch; N],
    quotient: Quotient,
    projection: Projection,
    interrupt: Interrupt<'_>,
) -> std::result::Result<(), Failure> {
    let mut point = None;
    for (i, (role, name)) in roles.into_iter().enumerate() {
        let (before, rest) = batches.split_at_mut(i);
        match (role, point) {
            (Role::Point, _) => {
                put_points(name, &mut rest[0], projection, interrupt)?;
                point = Some(i);
            }
            (Role::Vector, Some(point)) => {
                let points: &Batch = &before[point];
                put_vectors(
                    name,
                    points,
                    &mut rest[0],
                    (quotient, projection),
                    interrupt,
                )?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn put_points(
    name: &'static str,
    points: &mut Batch,
    projection: Projection,
    interrupt: Interrupt<'_>,
) -> std::result::Result<(), Failure> {
    let Some(limit) = projection.limit(points.single) else {
        return Ok(());
    };
    let limit = limit / points.field().length(1.0);
    points.replace(interrupt, |_, point| {
        let Ok(manifold) = Stiefel::of(name, point) else {
            return Ok(None);
        };
        let is_point = || manifold.check_point(name, point, POINT_TOLERANCE).is_ok();
        if check_finite(name, point).is_err() || is_point() {
            return Ok(None);
        }
        manifold.check_point(name, point, limit)?;
        manifold.project(point).map(Some)
    })
}

fn put_vectors(
    name: &'static str,
    points: &Batch,
    vectors: &mut Batch,
    (quotient, projection): (Quotient, Projection),
    interrupt: Interrupt<'_>,
) -> std::result::Result<(), Failure> {
    let Some(limit) = projection.limit(points.single || vectors.single) else {
        return Ok(());
    };
    let alike = (points.len(), points.rows, points.cols);
    if (vectors.len(), vectors.rows, vectors.cols) != alike {
        return Ok(());
    }
    let unit = vectors.field().length(1.0);
    vectors.replace(interrupt, |i, vector| {
        let point = points.get(i);
        if Stiefel::of(name, point).is_err()
            || check_finite(name, vector).is_err()
            || check_finite(name, point).is_err()
            || check_vector(quotient, name, point, vector).is_ok()
        {
            return Ok(None);
        }
        let tolerance = core_tolerance(limit, unit, vector);
        check_vector_to(tolerance, quotient, name, point, vector)?;
        Ok(Some(tangent_part(quotient, point, vector)))
    })
}

/// Converts a tolerance relative to `max(1, |v|)` to the core, which multiplies by its own norm, in which complex
/// vectors are longer; `unit` is one unit of it.
pub(super) fn core_tolerance(atol: f64, unit: f64, vector: MatRef<'_, f64>) -> f64 {
    match norm(vector) {
        long if long > 1.0 / unit => atol,
        long => atol / unit / long.max(1.0),
    }
}

impl Batch {
    /// Replaces members by the values of `member`, or leaves them; returns the error of the first that fails.
    fn replace(
        &mut self,
        interrupt: Interrupt<'_>,
        member: impl Fn(usize, MatRef<'_, f64>) -> Result<Option<Mat<f64>>> + Sync,
    ) -> std::result::Result<(), Failure> {
        let (rows, cols) = (self.rows, self.cols);
        self.change(TOGETHER, |i, row| {
            interrupt.check("projection")?;
            if let Some(matrix) = member(i, MatRef::from_row_major_slice(row, rows, cols))? {
                write(matrix.as_ref(), row);
            }
            Ok(())
        })
    }
}

/// [`MemberError`] of the points at knots.
pub(super) fn at_knot_of(error: &Error, knot: usize, _: &[usize]) -> PyErr {
    Error::AtKnot {
        knot,
        source: Box::new(error.clone()),
    }
    .into()
}
