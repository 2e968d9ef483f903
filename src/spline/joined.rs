//! Knots of few dimensions with frames, and the quasi-geodesics that join them: chains and parts are made of these.

use faer::Mat;

use super::framed::Framed;
use super::reduced_knots::ReducedKnots;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::QuasiGeodesic;

/// Knots in a row.
pub(super) struct Joined<'a> {
    pub(super) points: Vec<Mat<f64>>,
    /// The point as first columns, shape `(r, r)`.
    pub(super) frames: Vec<Mat<f64>>,
    /// From each knot to the next one.
    pub(super) curves: Vec<QuasiGeodesic>,
    /// Of the legs, in units of time.
    pub(super) lengths: Vec<f64>,
    pub(super) interrupt: Interrupt<'a>,
}

impl<'a> Joined<'a> {
    pub(super) fn new(
        knots: &ReducedKnots,
        frames: Vec<Mat<f64>>,
        curves: Vec<QuasiGeodesic>,
        interrupt: Interrupt<'a>,
    ) -> Self {
        Joined {
            points: knots.points.clone(),
            frames,
            curves,
            lengths: knots.lengths.clone(),
            interrupt,
        }
    }

    /// How many legs.
    pub(super) fn len(&self) -> usize {
        self.curves.len()
    }

    /// The same knots, passed backwards.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(super) fn reversed(&self) -> Result<Self> {
        let curves = self.curves.iter().rev().map(QuasiGeodesic::reversed);
        Ok(Joined {
            points: self.points.iter().rev().cloned().collect(),
            frames: self.frames.iter().rev().cloned().collect(),
            curves: curves.collect::<Result<_>>()?,
            lengths: self.lengths.iter().rev().copied().collect(),
            interrupt: self.interrupt,
        })
    }

    /// The chain whose legs are the part `share` of the way between the knots.
    ///
    /// # Errors
    /// Those of an exponential.
    pub(super) fn chain(&self, share: f64) -> Result<Framed<'a>> {
        let (frames, lengths) = (self.frames.clone(), self.lengths.clone());
        Framed::new(&self.curves, frames, lengths, share, self.interrupt)
    }

    /// `count` legs in a row from the leg `first` on; after the last one comes the first one again.
    pub(super) fn part(&self, first: usize, count: usize) -> Self {
        let leg = |i: usize| (first + i) % self.len();
        // The last knot of a closed chain is the first one: the knot where the next leg starts, unless there is none.
        let knot = |i: usize| match i {
            i if i == count => leg(i - 1) + 1,
            i => leg(i),
        };
        let knots = 0..=count;
        Joined {
            points: knots
                .clone()
                .map(|i| self.points[knot(i)].clone())
                .collect(),
            frames: knots.map(|i| self.frames[knot(i)].clone()).collect(),
            curves: (0..count).map(|i| self.curves[leg(i)].clone()).collect(),
            lengths: (0..count).map(|i| self.lengths[leg(i)]).collect(),
            interrupt: self.interrupt,
        }
    }
}
