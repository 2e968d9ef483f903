//! What is computed when it is first asked for, and kept.

use std::sync::{Arc, OnceLock};

use crate::error::Result;

/// A value that all clones share, once there is one.
pub(super) struct Kept<T>(Arc<OnceLock<T>>);

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Kept(Arc::default())
    }
}

impl<T> Clone for Kept<T> {
    fn clone(&self) -> Self {
        Kept(Arc::clone(&self.0))
    }
}

impl<T> Kept<T> {
    /// The value, made by `make` where there is none yet; two threads may both make it.
    ///
    /// # Errors
    /// Those of `make`: nothing is kept then.
    pub(super) fn get(&self, make: impl FnOnce() -> Result<T>) -> Result<&T> {
        if let Some(value) = self.0.get() {
            return Ok(value);
        }
        let value = make()?;
        Ok(self.0.get_or_init(|| value))
    }
}
