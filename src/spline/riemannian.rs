//! The spline of Riemannian cubics: twice continuously differentiable, of least cost through its points.

use std::sync::Arc;

use faer::{Mat, MatRef, Scale};
use rayon::prelude::*;

use super::ambient::Ambient;
use super::chain::Motion;
use super::ends::{End, EndCondition, EndConditions, Ends};
use super::framed::{Framed, coordinates};
use super::iteration::Outcome;
use super::piecewise::Piecewise;
use super::{knots, solve};
use crate::cubic::RiemannianCubic;
use crate::cubic::initial::{Coordinates, Horizontal, complete};
use crate::cubic::path::{Path, State};
use crate::cubic::problem::{entries, unpack};
use crate::cubic::reduced::Sized;
use crate::cubic::taylor::Accuracy;
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::distance;
use crate::manifold::quasi_geodesic::EndpointProblem;
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
    let (pieces, outcome) = if reduced.is_small() {
        reduced.solve_in_frames(&curves, &lengths, options)?
    } else {
        reduced.solve_in_ambient(curves, &lengths, options)?
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

/// Lengths of legs in units of their mean: neither large nor small.
struct Lengths {
    legs: Vec<f64>,
    mean: f64,
}

impl Lengths {
    fn of(t: &[f64]) -> Self {
        let legs = t.len() - 1;
        let mean = t[legs] / legs as f64 - t[0] / legs as f64;
        Lengths {
            legs: t
                .windows(2)
                .map(|pair| (pair[1] - pair[0]) / mean)
                .collect(),
            mean,
        }
    }
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

/// Quasi-geodesics between neighbours.
///
/// # Errors
/// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`, in `AtKnot` of the first of the two.
fn links(points: &[Mat<f64>]) -> Result<Vec<QuasiGeodesic>> {
    let (n, k) = points[0].shape();
    points
        .par_windows(2)
        .enumerate()
        .with_min_len(16)
        .map_init(
            || EndpointProblem::new(n, k),
            |problem, (knot, pair)| {
                let mut curve = QuasiGeodesic::zeros(n, k);
                curve
                    .join(pair[0].as_ref(), pair[1].as_ref(), problem)
                    .map_err(|error| error.at_knot(knot))?;
                Ok(curve)
            },
        )
        .collect()
}

/// The points in the coordinates of their span.
struct Reduced {
    n: usize,
    k: usize,
    /// Orthonormal basis of the span, where that is smaller than `R^n`.
    basis: Option<Arc<Mat<f64>>>,
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
        if matches!(ends, EndConditions::Periodic) {
            let first = points[0].clone();
            *points.last_mut().expect("there are knots") = first;
        }
        Reduced {
            n,
            k,
            basis: span.into_basis().map(Arc::new),
            points,
            ends,
        }
    }

    /// Whether a leg spans everything.
    fn is_small(&self) -> bool {
        self.points[0].nrows() <= 4 * self.k
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
                let zero = Mat::zeros(self.points[0].nrows(), self.k);
                Ends::Open([0, last].map(|knot| End::Acceleration(coordinates(knot, &zero))))
            }
            EndConditions::Each(each) => Ends::Open([end(0, &each[0]), end(last, &each[1])]),
            EndConditions::Periodic => Ends::Periodic,
        }
    }

    fn solve_in_frames(
        &self,
        curves: &[QuasiGeodesic],
        lengths: &Lengths,
        options: &SplineOptions<'_>,
    ) -> Result<Solved> {
        let (r, k) = self.points[0].shape();
        // `St(r, r)` is solved as `St(r, r - 1)`, to which each of its components is isometric: the other columns determine the
        // last one. One column has no other one: St(1, 1) stays what it is, two points.
        let columns = if r == k && k > 1 { k - 1 } else { k };
        let blocks = Sized {
            m: r - columns,
            k: columns,
        };
        let mut frames: Vec<Mat<f64>> = self.points.par_iter().map(framed).collect();
        if matches!(self.ends, EndConditions::Periodic) {
            let first = frames[0].clone();
            *frames.last_mut().expect("there are knots") = first;
        }
        let ends = self.ends_with(lengths.mean, |knot, v| {
            coordinates(frames[knot].as_ref(), v.as_ref(), blocks)
        });
        let chain_at = |share: f64| {
            let legs = &lengths.legs;
            Framed::new(blocks, curves, &frames, legs, share, options.interrupt)
        };
        let (motion, outcome) = if r == 1 {
            // Nothing moves.
            let motion = Motion::zeros(0, self.points.len());
            (motion, Outcome::nothing_to_do())
        } else {
            solve::in_frames(&chain_at, &ends, options)?
        };
        if outcome.reason != StopReason::Converged {
            return Ok((Vec::new(), outcome));
        }
        let piece = |leg: usize| {
            let start = motion.start(leg, lengths.legs[leg]);
            let vectors = unpack::<3>(&start, blocks);
            let vectors = if columns < k {
                vectors.map(|x| full(&x))
            } else {
                vectors
            };
            let state = State::new(&frames[leg], vectors.each_ref());
            self.piece(self.basis.clone(), state, options.interrupt)
        };
        let legs = (0..lengths.legs.len()).into_par_iter();
        Ok((legs.map(piece).collect::<Result<_>>()?, outcome))
    }

    fn solve_in_ambient(
        &self,
        curves: Vec<QuasiGeodesic>,
        lengths: &Lengths,
        options: &SplineOptions<'_>,
    ) -> Result<Solved> {
        let (r, k) = self.points[0].shape();
        let ends = self.ends_with(lengths.mean, |_, v| entries(v));
        let points = self.points.clone();
        let chain = Ambient::new(points, curves, &lengths.legs, options.interrupt);
        let (motion, outcome) = solve::in_ambient(&chain, &ends, options)?;
        if outcome.reason != StopReason::Converged {
            return Ok((Vec::new(), outcome));
        }
        let piece = |leg: usize| {
            let start = motion.start(leg, lengths.legs[leg]);
            let vector =
                |i: usize| MatRef::from_column_major_slice(&start[r * k * i..][..r * k], r, k);
            let data = [self.points[leg].as_ref(), vector(0), vector(1), vector(2)];
            let data = Coordinates::of_checked(data, 1.0);
            let frame = match (&self.basis, data.frame) {
                (Some(basis), Some(frame)) => Some(basis.as_ref() * frame),
                (_, frame) => frame,
            };
            let state = State::of_coordinates(data.blocks, data.entries);
            self.piece(frame.map(Arc::new), state, options.interrupt)
        };
        let legs = (0..lengths.legs.len()).into_par_iter();
        Ok((legs.map(piece).collect::<Result<_>>()?, outcome))
    }

    /// The cubic of a leg, on `[0, 1]`.
    fn piece(
        &self,
        frame: Option<Arc<Mat<f64>>>,
        state: State,
        interrupt: Interrupt<'_>,
    ) -> Result<RiemannianCubic> {
        let mut path = Path::at(state, Accuracy::FULL);
        path.extend_to(1.0, interrupt)?;
        Ok(RiemannianCubic::of_path(self.n, self.k, frame, path, None))
    }
}

fn framed(point: &Mat<f64>) -> Mat<f64> {
    complete(point.as_ref())
}

/// The vector of `St(r, r)` that is a given one of `St(r, r - 1)`.
fn full(x: &Horizontal) -> Horizontal {
    let k = x.omega.nrows();
    let omega = Mat::from_fn(k + 1, k + 1, |i, j| match (i < k, j < k) {
        (true, true) => x.omega[(i, j)],
        (false, true) => x.normal[(0, j)],
        (true, false) => -x.normal[(0, i)],
        (false, false) => 0.0,
    });
    Horizontal {
        omega,
        normal: Mat::zeros(0, k + 1),
    }
}
