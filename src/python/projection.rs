//! Which matrices are projected to the manifold before they are used: the argument `project`.

/// Largest defect of points in single precision, and of their vectors relative to their length: a hundred times the
/// round-off of an entry of `float32`.
pub(super) const SINGLE: f64 = 1e-5;

/// The same for points and vectors with `project=True`.
pub(super) const PROJECTED: f64 = 0.1;

/// Defects up to which a matrix is projected to the manifold.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Projection {
    /// Up to the round-off of its numbers.
    OfRoundOff,
    /// Up to a tenth.
    Wanted,
}

impl Projection {
    /// The argument `project`.
    pub(super) fn of(project: bool) -> Self {
        match project {
            true => Projection::Wanted,
            false => Projection::OfRoundOff,
        }
    }

    /// The largest defect of a matrix that is projected; `None` if none is.
    pub(super) fn limit(self, single: bool) -> Option<f64> {
        match self {
            Projection::Wanted => Some(PROJECTED),
            Projection::OfRoundOff => single.then_some(SINGLE),
        }
    }
}
