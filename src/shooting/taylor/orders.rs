//! Numbers of terms of the series of legs.

use crate::space::Homogeneous;

/// Orders of series, as a linear function of speed.
#[derive(Clone, Copy)]
pub(crate) struct Orders {
    /// Order without rotation, and additional order per radian.
    still: f64,
    radian: f64,
    /// Allowed contribution of the last terms to `x'` and to the frame's derivative.
    pub(crate) accuracy: f64,
}

/// Maximal number of terms. Frames need many if velocities grow fast along a leg: with 40, splines through knots 0.6
/// rad apart with a tension of 45 or more in the time of a leg are not solved.
pub(crate) const MOST: usize = 64;

/// Maximal number of terms of the legs of a linearised curve; legs that need more are split, and treated one by one.
/// With 40, 143 of the 199 legs of a spline through rotations 0.75 rad apart are, since eight at once take as many
/// terms as the fastest.
pub(crate) const LONGEST: usize = 56;

/// Number of terms added to a leg whose truncation error is too large; anything from 1 to 5 takes as long.
const MORE: usize = 3;

/// Accuracies of the first and the last residuals. In 300 legs with random `x, x', x''`, half of the series reach
/// accuracies of 1e-4 and 1e-12 with `5 + 2.5 s` and `13 + 3.5 s` terms, where `s` is the bound on the velocity. With
/// 1e-12 for the last ones, the derivative of a closed spline through three knots with respect to a rotation of all
/// data is off by 5e-11.
const ROUGH: f64 = 1e-4;
pub(crate) const FINE: f64 = 1e-13;

/// Accuracy if the start that leads to the end is needed: the truncation error of `x''` there is some fifty times that
/// of `x'`.
pub(crate) const FINEST: f64 = 1e-14;

/// A step leaves a hundredth of the residual, of which a tenth may be truncation error. With all terms from the start,
/// splines through 100 to 400 points take 1.1 to 1.3 times as long.
const SHARE: f64 = 1e-3;

/// The same in chains of points with three rows, where terms are cheap and steps often leave less. With 1e-3, splines
/// through 10, 50, 200 and 2000 rotations up to 1.2 rad apart take 1.13, 1.07, 1.01 and 1.27 times as long. With 1e-4
/// and no equations of far starts kept in more rows too, splines on St(5,2), Gr(6,3) and complex St(3,1) take 1.04,
/// 1.02 and 1.04 times as long.
const SHARE_IN_THREE_ROWS: f64 = 1e-4;

impl Orders {
    /// Orders for the first residual.
    pub(crate) fn first() -> Self {
        Orders::of(ROUGH)
    }

    /// Orders for the solution.
    pub(crate) fn last() -> Self {
        Orders::of(FINE)
    }

    /// Orders for a solution whose start is needed.
    pub(crate) fn finest() -> Self {
        Orders::of(FINEST)
    }

    /// Orders after a step that left the given residual.
    pub(crate) fn after(residual: f64) -> Self {
        Orders::within(SHARE * residual)
    }

    /// The same in a chain between given points.
    pub(crate) fn after_in(space: impl Homogeneous, residual: f64) -> Self {
        match space.size() {
            3 => Orders::within(SHARE_IN_THREE_ROWS * residual),
            _ => Orders::after(residual),
        }
    }

    fn within(accuracy: f64) -> Self {
        Orders::of(accuracy.clamp(FINE, ROUGH))
    }

    fn of(accuracy: f64) -> Self {
        let digits = -accuracy.log10();
        Orders {
            still: 1.0 + digits,
            radian: 2.0 + 0.125 * digits,
            accuracy,
        }
    }

    /// The order for a leg with the given bound on its velocity, in its own time, and the given number of additional
    /// terms.
    pub(crate) fn of_leg(self, speed: f64, more: usize) -> usize {
        // A speed that is not finite gives the maximal order.
        let order = (self.still + self.radian * speed).ceil();
        match order < MOST as f64 {
            true => (order as usize + more).min(MOST),
            false => MOST,
        }
    }

    /// The number of additional terms that a leg needs, if it had `more` of them and its last terms contribute `tail`.
    pub(crate) fn more(self, more: usize, tail: f64) -> usize {
        match tail <= self.accuracy {
            true => more,
            false => (more + MORE).min(MOST),
        }
    }
}
