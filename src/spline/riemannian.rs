//! The spline of Riemannian cubics: twice continuously differentiable, of least cost through its points.

use std::sync::Arc;

use faer::{Mat, MatRef, Scale};

use super::ambient::Ambient;
use super::chain::{Motion, Space, links, pieces};
use super::ends::{End, EndCondition, EndConditions, Ends};
use super::framed::{Framed, coordinates};
use super::iteration::Outcome;
use super::knots::{Lengths, is_small};
use super::piecewise::Piecewise;
use super::{knots, solve};
use crate::cubic::RiemannianCubic;
use crate::cubic::initial::complete;
use crate::cubic::problem::entries;
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::distance;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::manifold::{QuasiGeodesic, Stiefel};
use crate::report::{SolverReport, StopReason};

const SOLVER: &str = "spline of Riemannian cubics";

/// How a spline is solved for.
#[derive(Clone, Copy)]
pub struct SplineOptions<'a> {
    /// Converged once no leg misses its knot, and no covariant acceleration jumps, by more than this, in the time of a leg.
    pub tolerance: f64,
    /// Steps at the most, of fixed-point iteration and of Newton's method together.
    pub max_iterations: usize,
    /// Asked before every leg of every step.
    pub interrupt: Interrupt<'a>,
}

impl Default for SplineOptions<'_> {
    /// `1e-12`, at most 200 steps.
    fn default() -> Self {
        SplineOptions {
            tolerance: 1e-12,
            max_iterations: 200,
            interrupt: Interrupt::NEVER,
        }
    }
}

/// The spline of Riemannian cubics through points: velocity and covariant acceleration are continuous.
///
/// Among all curves through the points with the given ends it makes the cost `J` stationary; with natural ends
/// (`EndConditions::Natural`) it is what a cubic spline is in flat space.
///
/// # Arguments
/// * `t` - times, increasing; `points` - one at each, shape `(n, k)`
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (times, ends that do not close); in `AtKnot` `NotOrthonormal`, `NoJoiningCurve`,
/// `OutsideLogDomain` and `DifferentComponents` (no curve starts from there to the next point), `NotTangent`; `NoConvergence`,
/// `Interrupted`.
pub fn cubic_spline(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
    options: &SplineOptions<'_>,
) -> Result<(Piecewise<RiemannianCubic>, SolverReport)> {
    let manifold = knots::check(t, points)?;
    check_ends(&manifold, points, ends)?;
    let reduced = Reduced::new(points, ends);
    let curves = links(&reduced.points)?;
    let lengths = Lengths::of(t);
    let (pieces, outcome) = if is_small(&reduced.points) {
        reduced.solve_in_frames(&curves, lengths, options)?
    } else {
        reduced.solve_in_ambient(curves, lengths, options)?
    };
    let report = outcome.report(options.tolerance);
    if report.converged {
        return Ok((Piecewise::new(t.to_vec(), pieces), report));
    }
    Err(Error::NoConvergence {
        solver: SOLVER,
        report,
    })
}

fn check_ends(manifold: &Stiefel, points: &[MatRef<'_, f64>], ends: &EndConditions) -> Result<()> {
    let last = points.len() - 1;
    match ends {
        EndConditions::Natural => Ok(()),
        EndConditions::Periodic => {
            let gap = distance(points[0], points[last]);
            if gap <= POINT_TOLERANCE {
                return Ok(());
            }
            let error = Error::InvalidArgument {
                name: "S",
                requirement: "the first point again (the ends are periodic), this far from it",
                found: gap,
            };
            Err(error.at_knot(last))
        }
        EndConditions::Each(each) => {
            for (knot, end) in [(0, &each[0]), (last, &each[1])] {
                manifold
                    .check_tangent(
                        "bc_type",
                        points[knot],
                        end.vector().as_ref(),
                        TANGENT_TOLERANCE,
                    )
                    .map_err(|error| error.at_knot(knot))?;
            }
            Ok(())
        }
    }
}

/// The problem in the coordinates of the span of its data.
struct Reduced {
    space: Space,
    points: Vec<Mat<f64>>,
    ends: EndConditions,
}

type Solved = (Vec<RiemannianCubic>, Outcome);

impl Reduced {
    fn new(points: &[MatRef<'_, f64>], ends: &EndConditions) -> Self {
        let (n, k) = points[0].shape();
        let mut spanning: Vec<MatRef<'_, f64>> = points.to_vec();
        if let EndConditions::Each(each) = ends {
            spanning.extend(each.iter().map(|end| end.vector().as_ref()));
        }
        let span = Span::of(&spanning);
        let down = |vector: &Mat<f64>| span.down(vector.as_ref());
        let ends = match ends {
            EndConditions::Each(each) => {
                EndConditions::Each(Box::new(each.each_ref().map(|end| match end {
                    EndCondition::Velocity(v) => EndCondition::Velocity(down(v)),
                    EndCondition::Acceleration(a) => EndCondition::Acceleration(down(a)),
                })))
            }
            other => other.clone(),
        };
        let mut points: Vec<Mat<f64>> = points.iter().map(|point| span.down(*point)).collect();
        close(&mut points, &ends);
        let basis = span.into_basis().map(Arc::new);
        Reduced {
            space: Space { n, k, basis },
            points,
            ends,
        }
    }

    /// Velocity, or acceleration, at an end in units of the mean leg.
    fn ends_with(&self, mean: f64, coordinates: impl Fn(usize, &Mat<f64>) -> Vec<f64>) -> Ends {
        let last = self.points.len() - 1;
        let end = |knot: usize, end: &EndCondition| match end {
            EndCondition::Velocity(v) => End::Velocity(coordinates(knot, &(v * Scale(mean)))),
            EndCondition::Acceleration(a) => {
                // One factor after the other: their product may overflow.
                let a = a * Scale(mean) * Scale(mean);
                End::Acceleration(coordinates(knot, &a))
            }
        };
        match &self.ends {
            EndConditions::Natural => {
                let zero = Mat::zeros(self.points[0].nrows(), self.points[0].ncols());
                Ends::Open([0, last].map(|knot| End::Acceleration(coordinates(knot, &zero))))
            }
            EndConditions::Each(each) => Ends::Open([end(0, &each[0]), end(last, &each[1])]),
            EndConditions::Periodic => Ends::Periodic,
        }
    }

    fn solve_in_frames(
        &self,
        curves: &[QuasiGeodesic],
        lengths: Lengths,
        options: &SplineOptions<'_>,
    ) -> Result<Solved> {
        let mut frames: Vec<Mat<f64>> = self.points.iter().map(|p| complete(p.as_ref())).collect();
        close(&mut frames, &self.ends);
        let ends = self.ends_with(lengths.mean, |knot, v| {
            coordinates(frames[knot].as_ref(), v.as_ref())
        });
        let chain_at = |share: f64| {
            let (frames, legs) = (frames.clone(), lengths.legs.clone());
            Framed::new(curves, frames, legs, share, options.interrupt)
        };
        if frames[0].nrows() == 1 {
            // Nothing moves.
            let motion = Motion::zeros(0, self.points.len());
            let pieces = pieces(&chain_at(1.0)?, &motion, &self.space, options.interrupt)?;
            return Ok((pieces, Outcome::nothing_to_do()));
        }
        let (motion, outcome) = solve::in_frames(&chain_at, &ends, options)?;
        if outcome.reason != StopReason::Converged {
            return Ok((Vec::new(), outcome));
        }
        let chain = chain_at(1.0)?;
        let pieces = pieces(&chain, &motion, &self.space, options.interrupt)?;
        Ok((pieces, outcome))
    }

    fn solve_in_ambient(
        &self,
        curves: Vec<QuasiGeodesic>,
        lengths: Lengths,
        options: &SplineOptions<'_>,
    ) -> Result<Solved> {
        let ends = self.ends_with(lengths.mean, |_, v| entries(v));
        let points = self.points.clone();
        let chain = Ambient::new(points, curves, lengths.legs, options.interrupt);
        let (motion, outcome) = solve::in_ambient(&chain, &ends, options)?;
        if outcome.reason != StopReason::Converged {
            return Ok((Vec::new(), outcome));
        }
        let pieces = pieces(&chain, &motion, &self.space, options.interrupt)?;
        Ok((pieces, outcome))
    }
}

/// The last is the first, to the last bit, where the curve closes.
fn close(knots: &mut [Mat<f64>], ends: &EndConditions) {
    if matches!(ends, EndConditions::Periodic) {
        let first = knots[0].clone();
        knots[knots.len() - 1] = first;
    }
}
