//! The legs of a solved chain: their middles, and polynomials that are computed from these on demand.

use std::sync::OnceLock;

use super::chain::LegGroup;
use crate::legs::{Curves, Dense, Polynomials, RotationSeries};
use crate::linalg::field::{Field, transposed_multiply};
use crate::shooting::taylor::rotation_series::is_of_rotations;
use crate::shooting::taylor::series::{LegSeries, at_ends};
use crate::space::{Homogeneous, axis};

/// Number of additional terms of the curves, needed for their third derivatives.
const FOR_DERIVATIVES: usize = 4;

/// Groups of legs; the last group may have fewer.
pub(crate) struct SolvedSeries<T, S> {
    space: S,
    legs: usize,
    groups: Vec<SolvedGroup<T>>,
}

struct SolvedGroup<T> {
    middle: [Vec<T>; 3],
    tension: Option<T>,
    order: usize,
    polynomials: OnceLock<Dense>,
}

impl<T: Field, S: Homogeneous> SolvedSeries<T, S> {
    pub(crate) fn new(space: S, legs: usize, groups: &[LegGroup<'_, T>]) -> Self {
        let solved = |group: &LegGroup<'_, T>| SolvedGroup {
            order: group.leg.order + FOR_DERIVATIVES,
            middle: group.leg.middle().map(<[T]>::to_vec),
            tension: group.leg.tension,
            polynomials: OnceLock::new(),
        };
        SolvedSeries {
            space,
            legs,
            groups: groups.iter().map(solved).collect(),
        }
    }

    fn polynomials(&self, first: usize, group: &SolvedGroup<T>) -> Dense {
        let (space, d, order) = (self.space, self.space.dim(), group.order);
        let mut dense = Dense::new(T::COUNT.min(self.legs - first), order, space, space.size());
        let mut series = LegSeries::new(space, order);
        let mut ends: [Vec<T>; 6] = std::array::from_fn(|_| vec![T::ZERO; d]);
        space.vectorised(
            #[inline(always)]
            || {
                let middle = group.middle.each_ref().map(|x| &x[..]);
                series.set_curve(space, middle, group.tension, order);
                series.set_frames(space, order + 2);
                let (first, last) = ends.split_at_mut(3);
                for (derivative, (first, last)) in first.iter_mut().zip(last).enumerate() {
                    series.at_ends(d, order + 3, derivative, [first, last]);
                }
                write_series(space, &series, &ends, &mut dense);
            },
        );
        dense
    }
}

impl<T: Field + Send + Sync, S: Homogeneous> Curves for SolvedSeries<T, S> {
    fn of_leg(&self, leg: usize) -> (&Dense, usize) {
        let first = leg - leg % T::COUNT;
        let group = &self.groups[leg / T::COUNT];
        let polynomials = group
            .polynomials
            .get_or_init(|| self.polynomials(first, group));
        (polynomials, leg - first)
    }

    fn rotations(&self) -> Option<Vec<RotationSeries>> {
        let space = self.space;
        if !is_of_rotations(space) {
            return None;
        }
        let longest = self.groups.iter().map(|group| group.order).max()?;
        let mut series = LegSeries::new(space, longest);
        let mut all = Vec::with_capacity(self.legs);
        space.vectorised(
            #[inline(always)]
            || {
                for group in &self.groups {
                    let middle = group.middle.each_ref().map(|x| &x[..]);
                    series.set_curve(space, middle, group.tension, group.order);
                    series.set_turns(space, group.order + 2);
                    for lane in 0..T::COUNT.min(self.legs - all.len()) {
                        all.push(rotation_series(&series, group.order + 3, lane));
                    }
                }
            },
        );
        Some(all)
    }
}

/// The leg in a lane, from the series of its group after [`LegSeries::set_turns`].
#[inline(always)]
fn rotation_series<T: Field>(series: &LegSeries<T>, terms: usize, lane: usize) -> RotationSeries {
    let rates = series.matrices.chunks_exact(9).take(terms);
    let rates = rates.map(|x| axis(x).map(|w| w.lane(lane)));
    let quaternions = series.frames.chunks_exact(4).take(terms);
    let quaternions = quaternions.map(|p| [p[1], p[2], p[3], p[0]].map(|p| p.lane(lane)));
    RotationSeries {
        rates: rates.collect(),
        quaternions: quaternions.collect(),
    }
}

/// Writes the series of a group of legs, and `x, x', x''` at both ends.
#[inline(always)]
fn write_series<T: Field>(
    space: impl Homogeneous,
    series: &LegSeries<T>,
    ends: &[Vec<T>; 6],
    dense: &mut Dense,
) {
    let (d, r, terms) = (space.dim(), space.size(), dense.order + 1);
    let square = r * r;
    let (mut start, mut end) = (vec![T::ZERO; square], vec![T::ZERO; square]);
    let frames = &series.frames[..terms * square];
    at_ends(frames, square, 0, [&mut start, &mut end]);
    let mut relative = vec![T::ZERO; terms * square];
    let known = frames.chunks_exact(square);
    for (c, out) in known.zip(relative.chunks_exact_mut(square)) {
        transposed_multiply(r, &start, c, out);
    }
    let mut last = vec![T::ZERO; square];
    transposed_multiply(r, &start, &end, &mut last);
    let polynomials = Polynomials {
        x: &series.x[..terms * d],
        frames: &relative,
        ends: ends.each_ref().map(|x| &x[..]),
        last_frame: &last,
    };
    dense.write(0, &polynomials);
}
