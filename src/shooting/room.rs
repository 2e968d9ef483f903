//! One allocation for all legs.

use std::mem;

/// Numbers that are given out piece by piece.
pub(super) struct Room<'a, T>(&'a mut [T]);

impl<'a, T> Room<'a, T> {
    pub(super) fn new(all: &'a mut [T]) -> Self {
        Room(all)
    }

    /// The next so many of them.
    pub(super) fn take(&mut self, count: usize) -> &'a mut [T] {
        let (first, rest) = mem::take(&mut self.0).split_at_mut(count);
        self.0 = rest;
        first
    }
}
