//! Values of a spline of rotations at many times: where they lie, also beyond the keyframes, and on which threads.

use super::pieces::Pieces;
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::linalg::simd::vectorised;
use crate::threads::{self, ALWAYS};

/// Number of times from which evaluation is parallel: below it, waking the threads takes longer than the work. The
/// number is written out in the doc comments of the `*_into` functions.
const SHARED: usize = 4096;

/// Values at many finite times, computed from the leg between knots, or the extension before the first or after the
/// last one, in which they lie, and the time within it.
pub(super) fn values_into<const N: usize>(
    knots: &[f64],
    beyond: &[Option<Beyond>; 2],
    t: &[f64],
    out: &mut [[f64; N]],
    value: impl Fn(SamplePlace<'_>, f64) -> [f64; N] + Sync,
) -> Result<()> {
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    // Consecutive times often lie in the same leg, or in the next one.
    let is_in = |leg: usize, t: f64| match knots.get(leg..leg + 2) {
        Some(ends) => ends[0] <= t && t < ends[1],
        None => false,
    };
    let some = |t: &[f64], out: &mut [[f64; N]]| {
        let mut leg = 0;
        for (t, out) in t.iter().zip(out) {
            if !is_in(leg, *t) {
                leg += 1;
                if !is_in(leg, *t) {
                    let after = knots.partition_point(|knot| knot <= t);
                    leg = after.clamp(1, knots.len() - 1) - 1;
                }
            }
            let s = (t - knots[leg]) / (knots[leg + 1] - knots[leg]);
            let side = match t {
                t if *t < first => &beyond[0],
                t if *t > last => &beyond[1],
                _ => &None,
            };
            let place = side
                .as_ref()
                .map_or(SamplePlace::Leg(leg), SamplePlace::Beyond);
            *out = value(place, s);
        }
    };
    if t.len() < SHARED {
        vectorised(|| some(t, out));
    } else {
        let parts = t.chunks(SHARED / 4).zip(out.chunks_mut(SHARED / 4));
        threads::map_parts(
            parts,
            ALWAYS,
            || (),
            |(), _, (t, out)| {
                vectorised(|| some(t, out));
                Ok(())
            },
        )?;
    }
    Ok(())
}

/// Checks that times are finite and that there is room for as many values.
///
/// # Errors
/// `Shape`, `NonFinite` with the index of the time.
pub(super) fn check_request<V>(t: &[f64], out: &[V]) -> Result<()> {
    if t.len() != out.len() {
        return Err(Error::Shape {
            name: "out",
            expected: format!("room for {} values", t.len()),
            found: out.len().to_string(),
        });
    }
    for (index, &t) in t.iter().enumerate() {
        check_parameter(t).map_err(|error| match error {
            Error::NonFinite { name, .. } => Error::NonFinite { name, index },
            other => other,
        })?;
    }
    Ok(())
}

/// The leg or extension in which a time lies.
pub(super) enum SamplePlace<'a> {
    Leg(usize),
    Beyond(&'a Beyond),
}

/// A leg extended beyond the keyframes.
pub(super) struct Beyond {
    pub(super) leg: usize,
    pub(super) pieces: Pieces,
}
