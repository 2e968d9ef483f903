//! The conditions at the ends of a spline.

use crate::spline::ends::{EndCondition, EndConditions};

/// The condition at an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Given {
    /// No condition: zero acceleration.
    Nothing,
    Velocity,
    Acceleration,
    /// The velocity and the acceleration of the other end.
    OtherEnd,
}

impl Given {
    pub(crate) fn of(ends: &EndConditions) -> [Given; 2] {
        match ends {
            EndConditions::Natural => [Given::Nothing; 2],
            EndConditions::Periodic => [Given::OtherEnd; 2],
            EndConditions::Each(each) => each.each_ref().map(|end| match end {
                EndCondition::Velocity(_) => Given::Velocity,
                EndCondition::Acceleration(_) => Given::Acceleration,
            }),
        }
    }

    /// The order of the given derivative.
    pub(crate) fn order(self) -> Option<usize> {
        match self {
            Given::Velocity => Some(1),
            Given::Acceleration => Some(2),
            _ => None,
        }
    }
}
