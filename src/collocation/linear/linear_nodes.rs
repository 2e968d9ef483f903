//! How many Gauss nodes the linearised equations along a cubic need.

use std::sync::Arc;

use crate::collocation::lane_nodes::{FINE, LaneNodes, MOST, nodes};

/// Largest velocity, in radians: faster curves are linearised by series. Both were not timed side by side; at constant
/// speed, 12 nodes and 2.2 per radian are enough, which are 48 here.
const FASTEST: f64 = 16.0;

/// Largest Legendre coefficient of the last two degrees of the squared entries of frames, which turn about as fast as
/// variations do: with those below 3e-11, variations of points were as accurate as with 64 nodes, on rest-to-rest
/// curves and others whose speed varies on St(3,1), St(3,2), SO(3), St(4,2) and Gr(4,2). A bound on the velocity alone
/// leaves errors up to 7e-9 on such curves.
const TAIL: f64 = 1e-12;

/// The nodes with which to begin for a curve with the given largest velocity, those of the solver; `None` if it is too
/// fast.
pub(crate) fn linear_nodes(speed: f64) -> Option<Arc<LaneNodes>> {
    match speed <= FASTEST {
        true => LaneNodes::at_least(nodes(FINE, speed, MOST)),
        false => None,
    }
}

/// More nodes; `None` beyond the maximal number.
pub(crate) fn more_nodes(nodes: &LaneNodes) -> Option<Arc<LaneNodes>> {
    LaneNodes::at_least(nodes.count() + 1)
}

/// Whether functions with the given values at the nodes, one row of values per node, are resolved as far as variations
/// need.
pub(crate) fn are_resolved(nodes: &LaneNodes, values: &[f64]) -> bool {
    let count = nodes.count();
    let width = values.len() / count;
    let mut tail = vec![0.0; 2 * width];
    for (node, row) in values.chunks_exact(width).enumerate() {
        for (degree, sums) in tail.chunks_exact_mut(width).enumerate() {
            let factor = nodes.nodes.tail[degree * count + node];
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += factor * value;
            }
        }
    }
    tail.iter().all(|x| x.abs() <= TAIL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_curves_have_no_nodes() {
        assert!(linear_nodes(40.0).is_none());
        assert!(linear_nodes(f64::NAN).is_none());
    }
}
