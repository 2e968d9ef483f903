//! Whether a de Casteljau curve stays on one branch: intermediate points never an angle of pi apart.
//!
//! The margin of a stage (`1 + cos` of its largest angles, see [`Margin`](crate::manifold::lane_join::Margin)) touches
//! zero where the principal quasi-geodesic jumps to another branch. It is sampled on a grid, and each local minimum
//! that is small is followed, eight parameters at a time, until it is a zero or clearly is not.

use crate::error::{Error, Result};
use crate::linalg::lanes::{LANES, Lanes};

/// Intervals of the first grid: an angle turns by a small part of pi in one.
const GRID: usize = 32;

/// Minima above this on the grid (angles below about 115 degrees) do not fall to zero between its points.
const SMALL: f64 = 0.6;

/// A minimum below this is a zero: an angle within about 1e-5 of pi.
const ZERO: f64 = 1e-10;

/// Each round makes an interval about four times shorter.
const ROUNDS: usize = 16;

/// Rotations this far from the identity have angles below 145 degrees.
const FAR: f64 = 1.9;

/// Error `BranchJump` where `margins`, the least margins of all stages at eight parameters, touch zero inside of `[0, 1]`.
pub(super) fn check(mut margins: impl FnMut(Lanes) -> Lanes) -> Result<()> {
    let (mut grid, step) = ([0.0; GRID + LANES], 1.0 / GRID as f64);
    for first in (0..=GRID).step_by(LANES) {
        let t = |l: usize| ((first + l) as f64 * step).min(1.0);
        let values = margins(Lanes(std::array::from_fn(t)));
        grid[first..first + LANES].copy_from_slice(&values.0);
    }
    for i in 0..=GRID {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(GRID));
        let lowest = grid[i] <= grid[before] && grid[i] <= grid[after];
        if lowest && grid[i] < SMALL {
            let (t, least) = minimum(&mut margins, before as f64 * step, after as f64 * step);
            if least < ZERO {
                return Err(Error::BranchJump { t });
            }
        }
    }
    Ok(())
}

/// Whether legs of at most this speed (spectral norm) are so short that no stage can come near an angle of pi.
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

/// The smallest margin between two parameters, and where it is.
fn minimum(margins: &mut impl FnMut(Lanes) -> Lanes, mut low: f64, mut high: f64) -> (f64, f64) {
    let (mut place, mut least) = (low, f64::INFINITY);
    for _ in 0..ROUNDS {
        let width = (high - low) / (LANES - 1) as f64;
        let t: [f64; LANES] = std::array::from_fn(|l| low + l as f64 * width);
        for (t, margin) in t.into_iter().zip(margins(Lanes(t)).0) {
            if margin < least {
                (place, least) = (t, margin);
            }
        }
        if least < ZERO {
            break;
        }
        (low, high) = ((place - width).max(low), (place + width).min(high));
    }
    (place, least)
}
