//! A way to stop a long computation from outside.
//!
//! The caller hands in a question ("stop?"); loops ask it between pieces of work of bounded size. The core
//! installs no signal handler.

use crate::error::{Error, Result};

/// A question that long loops ask; `true` means stop.
#[derive(Clone, Copy, Default)]
pub struct Interrupt<'a> {
    question: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl<'a> Interrupt<'a> {
    /// Never stops.
    pub const NEVER: Interrupt<'static> = Interrupt { question: None };

    /// Stops as soon as `question` answers `true`.
    pub fn new(question: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Interrupt {
            question: Some(question),
        }
    }

    /// Error `Interrupted` where the caller asked to stop.
    ///
    /// # Errors
    /// `Interrupted`.
    pub fn check(&self, solver: &'static str) -> Result<()> {
        match self.question {
            Some(question) if question() => Err(Error::Interrupted { solver }),
            _ => Ok(()),
        }
    }
}
