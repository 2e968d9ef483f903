//! Advice for splines that are not found because their times are uneven.

use super::chain::Chain;
use super::flat_spline::flat_spline;
use super::low_cost::FAST;
use crate::error::Error;
use crate::report::StopReason;
use crate::solve::gmres::norm;
use crate::spline::ends::{Ends, gives_velocity};

/// Intervals that differ by at most this factor count as even: up to it, no spline through near knots is
/// [fast](FAST).
const EVEN: f64 = 3.0;

/// Adds to an error about all knots the interval on which the spline of flat space is fastest, if it is fast there and
/// the interval is much longer than a neighbour.
pub(crate) fn advised(error: Error, chain: &impl Chain, ends: &Ends) -> Error {
    let is_cut_short = error
        .report()
        .is_some_and(|report| report.reason == StopReason::MaxIterations);
    if is_cut_short || gives_velocity(ends) {
        return error;
    }
    let Ok(start) = flat_spline(chain, ends) else {
        return error;
    };
    let lengths = chain.lengths();
    let speed = |leg: usize| {
        let at = |knot| lengths[leg] * norm(start.velocity(knot));
        at(leg).max(at(leg + 1))
    };
    let ratio = |leg: usize| {
        let count = lengths.len();
        let beside = match ends {
            Ends::Periodic => [Some((leg + count - 1) % count), Some((leg + 1) % count)],
            Ends::Open(_) => [leg.checked_sub(1), Some(leg + 1)],
        };
        let beside = beside
            .into_iter()
            .flatten()
            .filter_map(|leg| lengths.get(leg));
        lengths[leg] / beside.fold(f64::INFINITY, |least, h| least.min(*h))
    };
    let uneven = (0..lengths.len()).filter(|&leg| ratio(leg) > EVEN);
    let fastest = uneven.max_by(|&one, &other| speed(one).total_cmp(&speed(other)));
    match fastest.filter(|&leg| speed(leg) > FAST) {
        Some(knot) => Error::UnevenTimes {
            source: Box::new(error),
            speed: speed(knot),
            ratio: ratio(knot),
        }
        .at_knot(knot),
        None => error,
    }
}
