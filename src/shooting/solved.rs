//! The legs of a solved chain: their middles, and polynomials that are made of these when they are asked for.

use std::sync::OnceLock;

use super::chain::Group;
use super::series::Series;
use crate::collocation::{Curves, Dense};
use crate::linalg::field::Field;
use crate::linalg::simd::vectorised;
use crate::space::Homogeneous;

/// Terms that curves have more than the equations need, for their third derivatives.
const FOR_DERIVATIVES: usize = 4;

/// Groups of legs, of which the last one may have fewer.
pub(super) struct Solved<T, S> {
    space: S,
    legs: usize,
    groups: Vec<SolvedGroup<T>>,
}

struct SolvedGroup<T> {
    middle: [Vec<T>; 3],
    order: usize,
    polynomials: OnceLock<Dense>,
}

impl<T: Field, S: Homogeneous> Solved<T, S> {
    pub(super) fn new(space: S, legs: usize, groups: &[Group<'_, T>]) -> Self {
        let solved = |group: &Group<'_, T>| SolvedGroup {
            order: group.leg.order + FOR_DERIVATIVES,
            middle: group.leg.middle().map(<[T]>::to_vec),
            polynomials: OnceLock::new(),
        };
        Solved {
            space,
            legs,
            groups: groups.iter().map(solved).collect(),
        }
    }

    fn polynomials(&self, first: usize, group: &SolvedGroup<T>) -> Dense {
        let (space, d, order) = (self.space, self.space.dim(), group.order);
        let mut dense = Dense::new(T::COUNT.min(self.legs - first), order, space);
        let mut series = Series::new(space, order);
        let mut ends: [Vec<T>; 6] = std::array::from_fn(|_| vec![T::ZERO; d]);
        vectorised(
            #[inline(always)]
            || {
                let middle = group.middle.each_ref().map(|x| &x[..]);
                series.set_curve(space, middle, order);
                series.set_frames(space, order + 2);
                let (first, last) = ends.split_at_mut(3);
                for (derivative, (first, last)) in first.iter_mut().zip(last).enumerate() {
                    series.at_ends(d, order + 3, derivative, [first, last]);
                }
                dense.write_series(space, [&series.x, &series.frames], &ends);
            },
        );
        dense
    }
}

impl<T: Field + Send + Sync, S: Homogeneous> Curves for Solved<T, S> {
    fn of_leg(&self, leg: usize) -> (&Dense, usize) {
        let first = leg - leg % T::COUNT;
        let group = &self.groups[leg / T::COUNT];
        let polynomials = group
            .polynomials
            .get_or_init(|| self.polynomials(first, group));
        (polynomials, leg - first)
    }
}
