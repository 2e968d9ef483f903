//! Stopping a long computation from outside.
//!
//! The caller passes a callback; loops call it between pieces of work of bounded size. The core installs no signal
//! handler.

use crate::error::{Error, Result};

/// A callback that long loops poll; `true` means stop.
///
/// # Examples
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
/// use faer::mat;
/// use stiefel_rs::{Curve, Error, Interrupt, Quantity, QuasiGeodesic};
/// let curve = QuasiGeodesic::from_velocity(mat![[1.0], [0.0]].as_ref(), mat![[0.0], [1.0]].as_ref())?;
/// let stop = AtomicBool::new(false);
/// let question = || stop.load(Ordering::Relaxed);
/// let sample = || curve.sample(&[0.0, 0.5, 1.0], Quantity::Derivative(0), Interrupt::new(&question));
/// assert_eq!(sample()?.len(), 3);
/// stop.store(true, Ordering::Relaxed);
/// assert!(matches!(sample(), Err(Error::Interrupted { .. })));
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
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

    /// Return `Interrupted` if the caller asked to stop.
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
