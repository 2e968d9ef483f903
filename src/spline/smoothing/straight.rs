//! Geodesics near data: a smoothing spline must be at least as good as each of them, or it is not a minimum.

use faer::Mat;

use super::smoothing_equations::SmoothingData;
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::manifold::grassmann::joining::join_spans;
use crate::manifold::quasi_geodesic::EndpointProblem;
use crate::manifold::{Geodesic, Stiefel};
use crate::space::Quotient;

const SOLVER: &str = "smoothing spline";

/// A geodesic traversed at constant speed.
pub(crate) struct Straight {
    /// Its points at the knots.
    pub(crate) points: Vec<Mat<f64>>,
    /// The sum of weights times squared distances to the data.
    pub(crate) misfit: f64,
}

impl Straight {
    /// The one nearest to the data among the geodesics between the first, the middle and the last datum, and the
    /// constant curve at the middle datum. `None` if the logarithms of all of them fail.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn nearest(
        lengths: &[f64],
        data: &SmoothingData,
        quotient: Quotient,
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
            match Straight::between(ends, &times, data, quotient) {
                Ok(found) if nearest.as_ref().is_none_or(|one| found.misfit < one.misfit) => {
                    nearest = Some(found);
                }
                Ok(_) | Err(_) => {}
            }
        }
        Ok(nearest)
    }

    fn between(
        ends: [usize; 2],
        times: &[f64],
        data: &SmoothingData,
        quotient: Quotient,
    ) -> Result<Self> {
        let [from, to] = ends.map(|datum| data.point(datum).as_ref());
        let [start, end] = ends.map(|datum| times[data.knots()[datum]]);
        let manifold = Stiefel::of("S", from)?;
        let points = if start < end {
            let share = |time: &f64| (time - start) / (end - start);
            match quotient {
                Quotient::Frames => {
                    let curve: Geodesic = manifold.geodesic_between(from, to)?;
                    let points = times.iter().map(|time| curve.point(share(time)));
                    points.collect::<Result<Vec<_>>>()?
                }
                Quotient::Subspaces => {
                    let mut problem = EndpointProblem::new(manifold.n(), manifold.k());
                    let (curve, _) = join_spans(from, to, &mut problem)?;
                    let points = times.iter().map(|time| curve.point(share(time)));
                    points.collect::<Result<Vec<_>>>()?
                }
            }
        } else {
            vec![from.to_owned(); times.len()]
        };
        let misfit = data.misfit(&manifold, &points, quotient)?;
        Ok(Straight { points, misfit })
    }
}
