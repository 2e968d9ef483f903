//! Values of a spline of rotations at many times: where they lie, also beyond the keyframes, and on which threads.

use super::pieces::Pieces;
use super::rotation_spline::RotationSpline;
use super::series::dot;
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::simd::vectorised;
use crate::threads::{self, ALWAYS};

/// Number of times from which evaluation is parallel: below it, waking the threads takes longer than the work. The
/// number is written out in the doc comments of the `*_into` functions.
const SHARED: usize = 4096;

impl RotationSpline {
    /// Values at many times, computed from the leg or extension in which they lie and the time within it.
    pub(super) fn values_into<const N: usize>(
        &self,
        t: &[f64],
        out: &mut [[f64; N]],
        value: impl Fn(SamplePlace<'_>, f64) -> [f64; N] + Sync,
    ) -> Result<()> {
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
        let beyond = self.beyond(t)?;
        let knots = self.knots();
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

    /// The first and the last piece, extended to the requested times outside the keyframes.
    fn beyond(&self, t: &[f64]) -> Result<[Option<Beyond>; 2]> {
        let knots = self.knots();
        let legs = knots.len() - 1;
        let [mut earliest, mut latest] = [knots[0], knots[legs]];
        for t in t {
            earliest = earliest.min(*t);
            latest = latest.max(*t);
        }
        let local = |leg: usize, t: f64| (t - knots[leg]) / (knots[leg + 1] - knots[leg]);
        let side = |leg: usize, t: f64, is_needed: bool| -> Result<Option<Beyond>> {
            if !is_needed {
                return Ok(None);
            }
            let (s, piece) = (local(leg, t), &self.curve().pieces()[leg]);
            let longer = piece.restricted(s.min(0.0), s.max(1.0), Interrupt::NEVER)?;
            let mut pieces = Pieces::of_cubic(&longer, self.rotations[leg]);
            // Choose the sign of the leg's quaternion.
            let here = self.pieces().quaternion(leg, 0.5);
            if dot(pieces.quaternion(0, 0.5), here) < 0.0 {
                pieces.change_sign();
            }
            Ok(Some(Beyond { leg, pieces }))
        };
        Ok([
            side(0, earliest, earliest < knots[0])?,
            side(legs - 1, latest, latest > knots[legs])?,
        ])
    }
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
