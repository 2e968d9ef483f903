//! Directions along a chain of knots, or along a curve.

/// Direction from a knot to the next one, or back; from the start of a curve to its end, or back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Direction {
    Forward,
    Backward,
}
