//! One allocation for all legs.

use std::mem;

/// An array that is handed out piece by piece.
pub(crate) struct Room<'a, T>(&'a mut [T]);

impl<'a, T> Room<'a, T> {
    pub(crate) fn new(all: &'a mut [T]) -> Self {
        Room(all)
    }

    /// The next `count` numbers.
    pub(crate) fn take(&mut self, count: usize) -> &'a mut [T] {
        let (first, rest) = mem::take(&mut self.0).split_at_mut(count);
        self.0 = rest;
        first
    }
}
