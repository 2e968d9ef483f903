//! Values that are computed on first use and cached.

use std::sync::{Arc, OnceLock};

use crate::error::Result;

/// A value that is shared by all clones once it is computed.
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
    /// Returns the value, computed by `make` if there is none yet; two threads may both compute it.
    ///
    /// # Errors
    /// Those of `make`, after which no value is stored.
    pub(super) fn get(&self, make: impl FnOnce() -> Result<T>) -> Result<&T> {
        if let Some(value) = self.0.get() {
            return Ok(value);
        }
        let value = make()?;
        Ok(self.0.get_or_init(|| value))
    }
}
