//! A path that is made when it is asked for: of the thousands of legs of a long spline most are never read, or long after.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use super::path::Path;

/// Makes the paths of some legs.
pub(crate) type Legs = dyn Fn(usize) -> Path + Send + Sync;

/// A path, or the leg that it is made of.
pub(crate) struct LazyPath {
    path: OnceLock<Path>,
    leg: Option<(Arc<Legs>, usize)>,
}

impl LazyPath {
    /// That of a leg.
    pub(crate) fn of_leg(legs: Arc<Legs>, leg: usize) -> Self {
        LazyPath {
            path: OnceLock::new(),
            leg: Some((legs, leg)),
        }
    }
}

impl From<Path> for LazyPath {
    fn from(path: Path) -> Self {
        LazyPath {
            path: OnceLock::from(path),
            leg: None,
        }
    }
}

impl Deref for LazyPath {
    type Target = Path;

    fn deref(&self) -> &Path {
        self.path.get_or_init(|| {
            let (legs, leg) = self.leg.as_ref().expect("a path or a leg");
            legs(*leg)
        })
    }
}

impl fmt::Debug for LazyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.deref().fmt(f)
    }
}
