//! Knots of few dimensions with frames: chains and parts are made of these.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::framed::Framed;
use super::reduced_knots::ReducedKnots;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// Knots in a row.
pub(super) struct Joined<'a> {
    /// The point as first columns, shape `(r, r)`.
    pub(super) frames: Arc<[Mat<f64>]>,
    /// Of a point.
    columns: usize,
    /// Of the legs, in units of time.
    pub(super) lengths: Vec<f64>,
    /// Of the curves.
    tension: f64,
    pub(super) interrupt: Interrupt<'a>,
}

impl<'a> Joined<'a> {
    /// For knots and their frames, and curves in a tension.
    pub(super) fn new(
        knots: &ReducedKnots,
        frames: Vec<Mat<f64>>,
        tension: f64,
        interrupt: Interrupt<'a>,
    ) -> Self {
        Joined {
            frames: frames.into(),
            columns: knots.shape().1,
            lengths: knots.lengths.clone(),
            tension,
            interrupt,
        }
    }

    /// The point of a knot.
    pub(super) fn point(&self, knot: usize) -> MatRef<'_, f64> {
        self.frames[knot].as_ref().subcols(0, self.columns)
    }

    /// How many legs.
    pub(super) fn len(&self) -> usize {
        self.lengths.len()
    }

    /// The same knots, passed backwards.
    pub(super) fn reversed(&self) -> Self {
        Joined {
            frames: self.frames.iter().rev().cloned().collect(),
            columns: self.columns,
            lengths: self.lengths.iter().rev().copied().collect(),
            tension: self.tension,
            interrupt: self.interrupt,
        }
    }

    /// The chain whose legs are the part `share` of the way between the knots.
    ///
    /// # Errors
    /// In `AtKnot` `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`.
    pub(super) fn chain(&self, share: f64) -> Result<Framed<'a>> {
        let (frames, lengths) = (Arc::clone(&self.frames), self.lengths.clone());
        let chain = Framed::new(frames, self.columns, lengths, share, self.interrupt)?;
        Ok(chain.in_tension(self.tension))
    }

    /// `count` legs in a row from the leg `first` on; after the last one comes the first one again.
    pub(super) fn part(&self, first: usize, count: usize) -> Self {
        let leg = |i: usize| (first + i) % self.len();
        // The last knot of a closed chain is the first one: the knot where the next leg starts, unless there is none.
        let knot = |i: usize| match i {
            i if i == count => leg(i - 1) + 1,
            i => leg(i),
        };
        let frames = (0..=count).map(|i| self.frames[knot(i)].clone());
        Joined {
            frames: frames.collect(),
            columns: self.columns,
            lengths: (0..count).map(|i| self.lengths[leg(i)]).collect(),
            tension: self.tension,
            interrupt: self.interrupt,
        }
    }
}
