//! Geodesics near data: no smoothing spline is worse than any of them, and one that is found to be is no minimum.

use faer::Mat;

use super::fit::Data;
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::{Geodesic, Stiefel};

const SOLVER: &str = "smoothing spline";

/// A geodesic that is run through at constant speed.
pub(super) struct Straight {
    /// Where it is at the knots.
    pub(super) points: Vec<Mat<f64>>,
    /// The sum of weights times squared distances to the data.
    pub(super) misfit: f64,
}

impl Straight {
    /// The nearest to the data of the geodesics between the first, the middle and the last datum, and of standing still at the
    /// middle one. `None` where logarithms of all of them fail.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn nearest(
        lengths: &[f64],
        data: &Data,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Self>> {
        let mut times = vec![0.0];
        for h in lengths {
            times.push(times[times.len() - 1] + h);
        }
        let (middle, last) = (data.len() / 2, data.len() - 1);
        let mut nearest: Option<Straight> = None;
        for ends in [[0, last], [0, middle], [middle, last], [middle, middle]] {
            interrupt.check(SOLVER)?;
            match Straight::between(ends, &times, data) {
                Ok(found) if nearest.as_ref().is_none_or(|one| found.misfit < one.misfit) => {
                    nearest = Some(found);
                }
                Ok(_) | Err(_) => {}
            }
        }
        Ok(nearest)
    }

    fn between(ends: [usize; 2], times: &[f64], data: &Data) -> Result<Self> {
        let [from, to] = ends.map(|datum| data.point(datum).as_ref());
        let [start, end] = ends.map(|datum| times[data.knots()[datum]]);
        let manifold = Stiefel::of("S", from)?;
        let points = if start < end {
            let curve: Geodesic = manifold.geodesic_between(from, to)?;
            let at = |time: &f64| curve.point((time - start) / (end - start));
            times.iter().map(at).collect::<Result<Vec<_>>>()?
        } else {
            vec![from.to_owned(); times.len()]
        };
        let misfit = data.misfit(&manifold, &points)?;
        Ok(Straight { points, misfit })
    }
}
