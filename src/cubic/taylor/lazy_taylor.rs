//! Taylor polynomials computed when they are first read: most of the thousands of legs of a long spline are read late
//! or never.

use std::fmt;
use std::ops::Deref;
use std::sync::LazyLock;

use super::piecewise_taylor::PiecewiseTaylor;

/// Polynomials, or the closure that computes them, which is dropped once they exist.
pub(crate) struct LazyTaylor(
    LazyLock<PiecewiseTaylor, Box<dyn FnOnce() -> PiecewiseTaylor + Send>>,
);

impl LazyTaylor {
    /// Polynomials that are not yet computed.
    pub(crate) fn of(compute: impl FnOnce() -> PiecewiseTaylor + Send + 'static) -> Self {
        LazyTaylor(LazyLock::new(Box::new(compute)))
    }
}

impl From<PiecewiseTaylor> for LazyTaylor {
    fn from(taylor: PiecewiseTaylor) -> Self {
        let lazy = LazyTaylor(LazyLock::new(Box::new(|| taylor)));
        // Frees the closure.
        LazyLock::force(&lazy.0);
        lazy
    }
}

impl Deref for LazyTaylor {
    type Target = PiecewiseTaylor;

    fn deref(&self) -> &PiecewiseTaylor {
        &self.0
    }
}

impl fmt::Debug for LazyTaylor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.deref().fmt(f)
    }
}
