//! Data of splines of rotations as Python has them: quaternions, times of batches, end conditions in the body frame.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::knots::{BcType, GivenEnds, times};
use super::prelude::*;
use crate::rotation::tangent;

/// Times, and whether all curves share them or each has a row.
pub(super) fn times_of_members(
    t: &Any,
    [members, knots]: [usize; 2],
) -> PyResult<(Vec<f64>, bool)> {
    let axes = t.getattr("ndim").and_then(|ndim| ndim.extract::<usize>());
    if !matches!(axes, Ok(2)) {
        return Ok((times(t)?, true));
    }
    if t.cast::<PyArrayDyn<f64>>().is_err() {
        // Checks the types of the numbers, row by row.
        for row in t.try_iter()? {
            times(&row?)?;
        }
    }
    let ([rows, columns], flat) = read_axes(t, "t", "(M, N)")?;
    if [rows, columns] != [members, knots] {
        return Err(unexpected("t", &tuple(&[members, knots]), &[rows, columns]));
    }
    Ok((flat, false))
}

/// Unit quaternions from entries in fours.
pub(super) fn keyframes(shape: &[usize], entries: &[f64]) -> PyResult<Vec<UnitQuaternion<f64>>> {
    if shape.last() != Some(&4) {
        return Err(unexpected("quaternions", "(..., N, 4)", shape));
    }
    let unit = |(knot, q): (usize, &[f64])| {
        let largest = q.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        if largest == 0.0 || q.iter().any(|x| !x.is_finite()) {
            let what = if largest == 0.0 {
                "of length zero"
            } else {
                "not finite"
            };
            return Err(at_knot(
                invalid!("quaternions: the quaternion at knot {knot} is {what}"),
                knot,
            ));
        }
        // Scaled by the largest entry first: squares may overflow or underflow.
        let q = Quaternion::new(q[3], q[0], q[1], q[2]) / largest;
        Ok(UnitQuaternion::from_quaternion(q))
    };
    entries.chunks_exact(4).enumerate().map(unit).collect()
}

/// End conditions whose vectors are in the body frame.
pub(super) fn ends(
    py: Python<'_>,
    bc_type: &BcType<'_>,
    rotations: &[UnitQuaternion<f64>],
) -> PyResult<GivenEnds> {
    bc_type.read_by(py, Field::Real, (3, 3), |end, object| {
        let ([size], w) = read_axes(object, "bc_type", "(3,)")?;
        if size != 3 {
            return Err(unexpected("bc_type", "(3,)", &[size]));
        }
        let rotation = match end {
            0 => rotations.first(),
            _ => rotations.last(),
        };
        let identity = UnitQuaternion::identity();
        let w = Vector3::from_column_slice(&w);
        Ok(tangent(rotation.unwrap_or(&identity), &w))
    })
}
