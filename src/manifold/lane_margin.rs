//! How near stages at eight parameters come to the edge of the domain of quasi-geodesics.

use crate::linalg::lanes::{LANES, Lanes, Mask};

/// Lanes with a smaller cosine are recomputed by the caller: functions of cosines lose accuracy as `1 / sin(theta)^2`.
pub(super) const LOWEST_COSINE: f64 = -0.9;

/// Smallest sum of the two smallest cosines for which the polar factor is sufficiently well determined.
pub(super) const DETERMINED: f64 = 0.1;

/// Replaces zero in quotients of small numbers that have a limit.
pub(super) const TINY: f64 = 1e-150;

/// Distance of a stage from the edge of its domain.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margin {
    /// The smallest of `1 + cos` over principal angles and relative rotation angles, and of the sum of the two smallest
    /// cosines: zero where the branch of the curve changes.
    pub(crate) least: Lanes,
    /// Lanes that the caller must recompute.
    pub(crate) hard: [bool; LANES],
}

impl Margin {
    pub(crate) const WIDE: Margin = Margin {
        least: Lanes([2.0; LANES]),
        hard: [false; LANES],
    };

    #[inline(always)]
    pub(super) fn see(&mut self, least: Lanes, hard: Mask) {
        self.least = self.least.min(least);
        for l in 0..LANES {
            self.hard[l] |= hard.0[l];
        }
    }
}
