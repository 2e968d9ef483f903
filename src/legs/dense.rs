//! Curves of solved legs, as polynomials between knots.

use crate::linalg::field::Field;
use crate::space::Homogeneous;

/// Polynomials in powers of `s - 1/2`, ordered by leg and then by coefficient: `x` (coordinates) and leading columns of the
/// frame (by rows).
#[derive(Debug, Clone)]
pub(crate) struct Dense {
    /// Degree of the polynomials.
    pub(crate) order: usize,
    /// Number of columns of the frame: at least those of a point.
    pub(crate) width: usize,
    x: Vec<f64>,
    frames: Vec<f64>,
    /// `x, x', x''` at both ends of each leg, and the frame at its end.
    ends: Vec<f64>,
    last_frames: Vec<f64>,
}

/// The polynomials of one leg, or of eight.
pub(crate) struct Polynomials<'a, T> {
    /// Coefficients in powers of `s - 1/2`, of `x` and of columns of the frame relative to the frame at the start.
    pub(crate) x: &'a [T],
    pub(crate) frames: &'a [T],
    /// `x, x', x''` at the start and at the end of the leg, and the frame at the end.
    pub(crate) ends: [&'a [T]; 6],
    pub(crate) last_frame: &'a [T],
}

/// The curves of solved legs.
pub(crate) trait Curves: Send + Sync {
    /// The polynomials that contain those of a leg, and the index of the leg among them.
    fn of_leg(&self, leg: usize) -> (&Dense, usize);

    /// The series of all legs about their middles, if these are known and the legs are rotations in space.
    fn rotations(&self) -> Option<Vec<RotationSeries>>;
}

/// A leg of rotations in space: coefficients in powers of `s - 1/2`.
pub(crate) struct RotationSeries {
    /// The body rate, in the time of the leg.
    pub(crate) rates: Vec<[f64; 3]>,
    /// The unit quaternion relative to that at the middle, scalar last; as many coefficients.
    pub(crate) quaternions: Vec<[f64; 4]>,
}

impl Curves for Dense {
    fn of_leg(&self, leg: usize) -> (&Dense, usize) {
        (self, leg)
    }

    fn rotations(&self) -> Option<Vec<RotationSeries>> {
        None
    }
}

impl Dense {
    /// Allocates legs with `nodes + 3` coefficients, and frames of the given width.
    pub(crate) fn new(legs: usize, nodes: usize, space: impl Homogeneous, width: usize) -> Self {
        let (d, r, order) = (space.dim(), space.size(), nodes + 2);
        Dense {
            order,
            width,
            x: vec![0.0; legs * (order + 1) * d],
            frames: vec![0.0; legs * (order + 1) * r * width],
            ends: vec![0.0; legs * 6 * d],
            last_frames: vec![0.0; legs * r * r],
        }
    }

    /// Coefficients of `x` on a leg, for `d` coordinates.
    pub(crate) fn x(&self, leg: usize, d: usize) -> &[f64] {
        let size = (self.order + 1) * d;
        &self.x[leg * size..][..size]
    }

    /// Coefficients of the columns of the frames on a leg, for `r` rows.
    pub(crate) fn frames(&self, leg: usize, r: usize) -> &[f64] {
        let size = (self.order + 1) * r * self.width;
        &self.frames[leg * size..][..size]
    }

    /// `x, x', x''` at the start or the end of a leg, for `d` coordinates.
    pub(crate) fn end(&self, leg: usize, end: usize, d: usize) -> impl Iterator<Item = &[f64]> {
        self.ends[(2 * leg + end) * 3 * d..][..3 * d].chunks_exact(d)
    }

    /// The frame at the end of a leg.
    pub(crate) fn last_frame(&self, leg: usize, square: usize) -> &[f64] {
        &self.last_frames[leg * square..][..square]
    }

    /// Writes the polynomials of a group of legs, starting at leg `first`.
    #[inline(always)]
    pub(crate) fn write<T: Field>(&mut self, first: usize, polynomials: &Polynomials<'_, T>) {
        let Polynomials {
            x,
            frames,
            ends,
            last_frame,
        } = polynomials;
        let (d, legs) = (ends[0].len(), self.last_frames.len() / last_frame.len());
        for lane in 0..T::COUNT.min(legs - first) {
            let leg = first + lane;
            copy_lane(x, lane, &mut self.x[leg * x.len()..]);
            copy_lane(frames, lane, &mut self.frames[leg * frames.len()..]);
            let last = &mut self.last_frames[leg * last_frame.len()..];
            copy_lane(last_frame, lane, last);
            let to = self.ends[leg * 6 * d..].chunks_exact_mut(d);
            for (to, x) in to.zip(ends) {
                copy_lane(x, lane, to);
            }
        }
    }
}

#[inline(always)]
fn copy_lane<T: Field>(from: &[T], lane: usize, to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from.lane(lane);
    }
}
