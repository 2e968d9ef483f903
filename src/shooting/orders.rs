//! How many terms the series of legs have.

/// Orders of series.
#[derive(Clone, Copy)]
pub(super) struct Orders {
    /// Where nothing turns, and more for a radian.
    still: f64,
    radian: f64,
    /// What the last terms may contribute to `x'` and to the frame's derivative.
    pub(super) accuracy: f64,
}

/// Terms at most. Frames need many where velocities grow fast along a leg: with 40, splines through knots 0.6 rad apart with a tension
/// of 45 and more in the time of a leg are lost.
pub(super) const MOST: usize = 64;

/// Terms at most of the legs of a linearised curve, more are cut in two: by the estimate that a leg costs the square of its terms, 15 and
/// 3.75 a radian. Not measured.
pub(super) const LONGEST: usize = 40;

/// Terms that a leg gets more where the present ones leave out too much; anything from 1 to 5 takes as long.
const MORE: usize = 3;

/// Accuracies of the first and the last residuals. Of series of 300 legs with random `x, x', x''` half have accuracies of 1e-4 and
/// 1e-12 with `5 + 2.5 s` and `13 + 3.5 s` terms, where `s` is the bound of the velocity. With 1e-12 for the last ones the derivative of
/// a closed spline through three knots by a rotation of all data is off by 5e-11.
const ROUGH: f64 = 1e-4;
pub(super) const FINE: f64 = 1e-13;

/// The same where the start is wanted that leads to the end: `x''` there leaves out some fifty times as much as `x'`.
pub(super) const FINEST: f64 = 1e-14;

/// A step leaves a hundredth of the residual, and a tenth of that is not to be error. With all terms from the start splines through
/// 100 to 400 points take 1.1 to 1.3 times as long.
const SHARE: f64 = 1e-3;

impl Orders {
    /// To begin with.
    pub(super) fn first() -> Self {
        Orders::of(ROUGH)
    }

    /// For the solution.
    pub(super) fn last() -> Self {
        Orders::of(FINE)
    }

    /// For a solution whose start is wanted.
    pub(super) fn finest() -> Self {
        Orders::of(FINEST)
    }

    /// After a step that left so much.
    pub(super) fn after(residual: f64) -> Self {
        Orders::of((SHARE * residual).clamp(FINE, ROUGH))
    }

    fn of(accuracy: f64) -> Self {
        let digits = -accuracy.log10();
        Orders {
            still: 1.0 + digits,
            radian: 2.0 + 0.125 * digits,
            accuracy,
        }
    }

    /// For a leg with that bound of its velocity, in its own time, which has shown to need some more.
    pub(super) fn of_leg(self, speed: f64, more: usize) -> usize {
        // A speed that is not finite is the largest.
        let order = (self.still + self.radian * speed).ceil();
        match order < MOST as f64 {
            true => (order as usize + more).min(MOST),
            false => MOST,
        }
    }

    /// What a leg needs more, where it needed some more and its last terms contribute `tail`.
    pub(super) fn more(self, more: usize, tail: f64) -> usize {
        match tail <= self.accuracy {
            true => more,
            false => (more + MORE).min(MOST),
        }
    }
}
