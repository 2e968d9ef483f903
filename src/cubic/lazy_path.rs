//! A path computed when it is first read: most of the thousands of legs of a long spline are read late or never.

use std::fmt;
use std::ops::Deref;
use std::sync::LazyLock;

use super::path::Path;

/// A path, or the closure that computes it, which is dropped once the path exists.
pub(crate) struct LazyPath(LazyLock<Path, Box<dyn FnOnce() -> Path + Send>>);

impl LazyPath {
    /// A path that is not yet computed.
    pub(crate) fn of(path: impl FnOnce() -> Path + Send + 'static) -> Self {
        LazyPath(LazyLock::new(Box::new(path)))
    }
}

impl From<Path> for LazyPath {
    fn from(path: Path) -> Self {
        let lazy = LazyPath(LazyLock::new(Box::new(|| path)));
        // Frees the closure.
        LazyLock::force(&lazy.0);
        lazy
    }
}

impl Deref for LazyPath {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl fmt::Debug for LazyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.deref().fmt(f)
    }
}
