//! Splines through rotations whose neighbours are near each other, from their quaternions: without points, frames and
//! curves that join them, which the solver of other splines starts from.

use std::sync::Arc;

use faer::Mat;
use nalgebra::{UnitQuaternion, Vector3};

use super::chains::flat_spline::flat_spline_along;
use super::chains::framed::blocks;
use super::chains::framed_solver::{fastest, polynomials_of_legs};
use super::chains::low_cost::{is_far, is_fast};
use super::chains::solution::Effort;
use super::chains::solve::work_of_legs;
use super::ends::{End, Ends};
use super::options::SplineOptions;
use super::piecewise::Piecewise;
use crate::cubic::RiemannianCubic;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::tension::check_leg_tension;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::legs::{Curves, Knots};
use crate::linalg::lanes::Lanes;
use crate::report::{SolverReport, Strategy};
use crate::shooting;
use crate::solve::tridiagonal::Unturned;
use crate::space::{FixedFrames, Kind};

/// Largest deviation of a squared quaternion's length from 1 that counts as round-off.
const ROUND_OFF: f64 = 1e-14;

/// The solution for rotations.
pub(crate) struct SolvedRotations {
    pub(crate) report: SolverReport,
    pub(crate) curves: Arc<dyn Curves>,
    /// In units of the mean duration of a leg.
    lengths: Vec<f64>,
    tension: f64,
}

/// Solves the equations of a spline through rotations from the flat start; the vectors of the ends are in the body
/// frame, per unit of time. `None` if neighbours are far apart, if the spline is fast, and if the equations are not
/// solved: other starts are then worth trying, and data may be invalid.
///
/// # Errors
/// `InvalidArgument` (tension), `Overflow` (times that differ too much), `Interrupted`.
pub(crate) fn near_rotations(
    t: &[f64],
    rotations: &[UnitQuaternion<f64>],
    ends: &Ends,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<Option<SolvedRotations>> {
    let legs = t.len() - 1;
    let unit = (t[legs] - t[0]) / legs as f64;
    let lengths: Vec<f64> = t.windows(2).map(|t| (t[1] - t[0]) / unit).collect();
    // Multiply one factor at a time: the product of the factors may overflow.
    let tension = options.tension * unit * unit;
    let longest = lengths.iter().fold(0.0_f64, |most, h| most.max(*h));
    check_leg_tension(tension * longest * longest, true)?;
    let Some(NeighbourTurns { targets, steps }) = NeighbourTurns::new(rotations) else {
        return Ok(None);
    };
    let ends = in_units(ends, unit);
    let knots = Knots {
        lengths: &lengths,
        targets: targets.iter().map(<[f64; 9]>::as_slice).collect(),
        ends: &ends,
        tension,
    };
    let mut motion = flat_spline_along(&knots, &steps, &mut Unturned(3))?;
    let space = FixedFrames::<3, 2>;
    let (velocities, derivatives) = motion.entries.split_at_mut(3 * t.len());
    if knots.speed(space, velocities) > fastest(&ends) {
        return Ok(None);
    }
    let work = work_of_legs(legs, solved_blocks(), options);
    let effort = Effort::new(options, &work, interrupt);
    let may_go_on = |products| work.may_go_on(products);
    let options = effort.options(&may_go_on);
    let (report, curves) =
        shooting::solve::<Lanes, _>(space, &knots, velocities, derivatives, &options)?;
    let curves = curves.filter(|_| report.converged && !is_fast(&ends, &motion, &lengths));
    Ok(curves.map(|curves| SolvedRotations {
        report: report.found_by(Strategy::Direct),
        curves: curves.into(),
        lengths,
        tension,
    }))
}

/// The blocks of `St(3, 2)`, as which rotations are solved.
fn solved_blocks() -> Sizes {
    blocks(Kind::REAL_FRAMES, [3, 3])
}

impl SolvedRotations {
    /// The curve of matrices, of which those at the knots are given.
    pub(crate) fn curve(&self, t: &[f64], matrices: Vec<Mat<f64>>) -> Piecewise<RiemannianCubic> {
        let of_leg = polynomials_of_legs(
            Arc::clone(&self.curves),
            matrices.into(),
            (solved_blocks(), 3),
            (self.tension, self.lengths.clone()),
        );
        let piece = |leg| RiemannianCubic::of_leg(3, 3, None, of_leg(leg), (0.0, 1.0));
        Piecewise::new(t.to_vec(), (0..self.lengths.len()).map(piece).collect())
    }
}

/// The rotations from one knot to the next.
struct NeighbourTurns {
    /// Their matrices, in column-major order.
    targets: Vec<[f64; 9]>,
    /// The coordinates of their vectors, in radians, one after another.
    steps: Vec<f64>,
}

impl NeighbourTurns {
    /// `None` if one of them is far from the identity, or for quaternions that are not of unit length.
    fn new(rotations: &[UnitQuaternion<f64>]) -> Option<Self> {
        let is_unit = |q: &UnitQuaternion<f64>| (q.coords.norm_squared() - 1.0).abs() <= ROUND_OFF;
        if !rotations.iter().all(is_unit) {
            return None;
        }
        let (mut targets, mut steps) = (Vec::new(), Vec::new());
        for pair in rotations.windows(2) {
            // The product of the inverse with the same quaternion is not exactly one.
            let turn = match pair[0] == pair[1] {
                true => UnitQuaternion::identity(),
                false => pair[0].inverse() * pair[1],
            };
            let vector = turn.scaled_axis();
            if is_far(vector.norm()) {
                return None;
            }
            let mut target = [0.0; 9];
            target.copy_from_slice(turn.to_rotation_matrix().matrix().as_slice());
            targets.push(target);
            steps.extend(coordinates(&vector));
        }
        Some(NeighbourTurns { targets, steps })
    }
}

/// The coordinates of a vector `w` on `St(3, 2)`: the entries `(0, 1)`, `(2, 0)` and `(2, 1)` of the matrix `hat(w)`.
fn coordinates(w: &Vector3<f64>) -> [f64; 3] {
    [-w.z, -w.y, w.x]
}

/// The conditions at the ends in coordinates, in another unit of time.
fn in_units(ends: &Ends, unit: f64) -> Ends {
    let scaled = |w: &[f64]| -> Vec<f64> {
        let w = Vector3::from_column_slice(w);
        coordinates(&w).iter().map(|x| unit * x).collect()
    };
    match ends {
        Ends::Periodic => Ends::Periodic,
        Ends::Open(each) => Ends::Open(each.each_ref().map(|end| match end {
            End::Velocity(w) => End::Velocity(scaled(w)),
            End::Acceleration(a) => End::Acceleration(scaled(a).iter().map(|x| unit * x).collect()),
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cubic::taylor::packing::read_entries;

    #[test]
    fn coordinates_are_those_of_the_matrices() {
        let w = Vector3::new(0.3, -0.7, 1.1);
        let matrix = w.cross_matrix();
        let mut expected = [0.0; 3];
        read_entries(|i, j| matrix[(i, j)], &mut expected, solved_blocks());
        assert_eq!(coordinates(&w), expected);
    }
}
