//! Checks that a de Casteljau curve stays on one branch: no intermediate points are an angle of pi apart.
//!
//! The margin of a stage (`1 + cos` of its largest angles, see [`Margin`](crate::manifold::lane_margin::Margin)) touches
//! zero where the principal quasi-geodesic jumps to another branch. It is sampled on a grid that is finer near the
//! ends, where the first and last stages rotate fastest. Each small local minimum is refined, eight parameters at a
//! time, until it is either zero or clearly not.

use crate::error::{Error, Result};
use crate::linalg::lanes::{LANES, Lanes};

/// Number of intervals of the initial grid per degree: angles change by a small part of pi in each.
const GRID: usize = 16;

/// Grid minima above this (angles below about 115 degrees) do not reach zero between grid points.
const SMALL: f64 = 0.6;

/// A minimum below this counts as zero: an angle within about 1e-5 of pi.
const ZERO: f64 = 1e-10;

/// Number of refinements; each makes the interval about four times shorter.
const ROUNDS: usize = 18;

/// Number of refinements that follow every local minimum; later there is only one.
const SPLITS: usize = 4;

/// A rotation whose distance from the identity is at most this has angles below 145 degrees.
const FAR: f64 = 1.9;

/// Return `BranchJump` if `margins`, the least margins of all stages at eight parameters, touches zero inside `[0, 1]`.
pub(super) fn check(degree: usize, mut margins: impl FnMut(Lanes) -> Lanes) -> Result<()> {
    let intervals = GRID * degree;
    let place = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / intervals as f64).cos();
    let t: Vec<f64> = (0..=intervals).map(place).collect();
    let mut values = Vec::with_capacity(intervals + LANES);
    for block in t.chunks(LANES) {
        let mut lanes = Lanes::splat(block[0]);
        lanes.0[..block.len()].copy_from_slice(block);
        values.extend_from_slice(&margins(lanes).0[..block.len()]);
    }
    for (low, high) in dips(&t, &values) {
        follow(&mut margins, low, high, 0)?;
    }
    Ok(())
}

/// The intervals around the small local minima of sampled values.
fn dips<'a>(t: &'a [f64], values: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    let last = t.len() - 1;
    (0..t.len()).filter_map(move |i| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
        let lowest = values[i] <= values[before] && values[i] <= values[after];
        (lowest && values[i] < SMALL).then(|| (t[before], t[after]))
    })
}

/// Return `BranchJump` if the margin reaches zero between two parameters.
fn follow(
    margins: &mut impl FnMut(Lanes) -> Lanes,
    low: f64,
    high: f64,
    round: usize,
) -> Result<()> {
    let width = (high - low) / (LANES - 1) as f64;
    let t: [f64; LANES] = std::array::from_fn(|l| low + l as f64 * width);
    let values = margins(Lanes(t)).0;
    let mut best = 0;
    for l in 1..LANES {
        if values[l] < values[best] {
            best = l;
        }
    }
    if values[best] < ZERO {
        return Err(Error::BranchJump { t: t[best] });
    }
    if round == ROUNDS {
        return Ok(());
    }
    if round < SPLITS {
        return dips(&t, &values).try_for_each(|(low, high)| follow(margins, low, high, round + 1));
    }
    let (low, high) = (t[best.saturating_sub(1)], t[(best + 1).min(LANES - 1)]);
    follow(margins, low, high, round + 1)
}

/// Whether legs of at most this speed (spectral norm) are so short that the angles of all stages stay away from pi.
///
/// Points at spectral distance `d` have `|I - S_0^T S_1| <= d` and principal cosines of at least `1 - d^2 / 2`, so the
/// relative rotation `R` has `|I - R| <= d + d^2 / 2`, which bounds all angles between them. The sum of the largest
/// principal and the largest rotation angle bounds the speed of the quasi-geodesic, hence the distance of the points
/// of the next stage.
pub(super) fn is_short(leg_speed: f64, degree: usize) -> bool {
    let mut distance = leg_speed;
    for _ in 1..degree {
        let from_identity = distance + 0.5 * distance * distance;
        if from_identity > FAR {
            return false;
        }
        distance = 2.0 * ((0.5 * distance).asin() + (0.5 * from_identity).asin());
    }
    true
}
