//! Which derivative is given at each end of a spline.

use crate::spline::ends::{EndCondition, EndConditions};

/// The condition at an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GivenEnd {
    /// No condition: zero acceleration.
    Nothing,
    Velocity,
    Acceleration,
    /// The velocity and the acceleration of the other end.
    OtherEnd,
}

impl GivenEnd {
    pub(crate) fn of(ends: &EndConditions) -> [GivenEnd; 2] {
        match ends {
            EndConditions::Natural => [GivenEnd::Nothing; 2],
            EndConditions::Periodic => [GivenEnd::OtherEnd; 2],
            EndConditions::Each(each) => each.each_ref().map(|end| match end {
                EndCondition::Velocity(_) => GivenEnd::Velocity,
                EndCondition::Acceleration(_) => GivenEnd::Acceleration,
            }),
        }
    }

    /// The order of the given derivative.
    pub(crate) fn order(self) -> Option<usize> {
        match self {
            GivenEnd::Velocity => Some(1),
            GivenEnd::Acceleration => Some(2),
            _ => None,
        }
    }
}
