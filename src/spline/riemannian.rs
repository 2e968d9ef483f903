//! The spline of Riemannian cubics: twice continuously differentiable, of least cost through its points.

use std::sync::Arc;

use faer::{Mat, MatRef, Scale};

use super::ends::{End, EndCondition, EndConditions, Ends};
use super::joints::{Joints, Motion, SOLVER};
use super::knots;
use super::piecewise::Piecewise;
use super::start::Links;
use crate::cubic::RiemannianCubic;
use crate::cubic::guess::FlatData;
use crate::cubic::initial::{Horizontal, complete};
use crate::cubic::path::{Path, State};
use crate::cubic::problem::pack;
use crate::cubic::reduced::Sized;
use crate::cubic::taylor::Accuracy;
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::structure::distance;
use crate::manifold::Stiefel;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::report::SolverReport;

/// How a spline is solved for.
#[derive(Clone, Copy)]
pub struct SplineOptions<'a> {
    /// Converged once no leg misses its knot, and no covariant acceleration jumps, by more than this, in the time of a leg.
    pub tolerance: f64,
    /// Newton steps at the most.
    pub max_iterations: usize,
    /// Asked before every leg of every step.
    pub interrupt: Interrupt<'a>,
}

impl Default for SplineOptions<'_> {
    /// `1e-12`, at most 50 steps.
    fn default() -> Self {
        SplineOptions {
            tolerance: 1e-12,
            max_iterations: 50,
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
    let lengths: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut motion = reduced.start(&lengths)?;
    let mut joints = Joints::new(
        reduced.blocks,
        &reduced.frames,
        &lengths,
        reduced.ends_in_coordinates(),
        options.interrupt,
    );
    let report = joints.solve(&mut motion, options.tolerance, options.max_iterations)?;
    if !report.converged {
        return Err(Error::NoConvergence {
            solver: SOLVER,
            report,
        });
    }
    let pieces = (0..lengths.len())
        .map(|leg| reduced.piece(leg, joints.vectors(&motion, leg), options.interrupt))
        .collect::<Result<_>>()?;
    Ok((Piecewise::new(t.to_vec(), pieces), report))
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

/// The points in the coordinates of their span, each the first columns of an orthogonal frame.
struct Reduced {
    n: usize,
    k: usize,
    /// Orthonormal basis of the span, where that is smaller than `R^n`.
    basis: Option<Arc<Mat<f64>>>,
    frames: Vec<Mat<f64>>,
    points: Vec<Mat<f64>>,
    ends: EndConditions,
    /// Of the problem that is solved. `St(r, r)` is solved as `St(r, r - 1)`, to which each of its components is isometric: the
    /// other columns determine the last one.
    blocks: Sized,
}

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
        let mut frames: Vec<Mat<f64>> = points
            .iter()
            .map(|point| complete(span.down(*point).as_ref()))
            .collect();
        if matches!(ends, EndConditions::Periodic) {
            let first = frames[0].clone();
            *frames.last_mut().expect("there are knots") = first;
        }
        let r = frames[0].nrows();
        let points = frames
            .iter()
            .map(|frame| frame.as_ref().subcols(0, k).to_owned())
            .collect();
        // One column has no other one: St(1, 1) stays what it is, two points.
        let columns = if r == k && k > 1 { k - 1 } else { k };
        Reduced {
            n,
            k,
            basis: span.into_basis().map(Arc::new),
            frames,
            points,
            ends,
            blocks: Sized {
                m: r - columns,
                k: columns,
            },
        }
    }

    /// A tangent vector at a knot as a vector of `m`.
    fn horizontal(&self, knot: usize, v: &Mat<f64>) -> Horizontal {
        let columns = v.as_ref().subcols(0, self.blocks.k);
        Horizontal::of_tangent(self.frames[knot].as_ref(), columns)
    }

    fn ends_in_coordinates(&self) -> Ends {
        let last = self.frames.len() - 1;
        let size =
            self.blocks.k * (self.blocks.k.saturating_sub(1)) / 2 + self.blocks.m * self.blocks.k;
        let end = |knot: usize, end: &EndCondition| match end {
            EndCondition::Velocity(_) => End::Velocity,
            EndCondition::Acceleration(a) => End::Acceleration(pack(&[self.horizontal(knot, a)])),
        };
        match &self.ends {
            EndConditions::Natural => {
                Ends::Open([0, 1].map(|_| End::Acceleration(vec![0.0; size])))
            }
            EndConditions::Each(each) => Ends::Open([end(0, &each[0]), end(last, &each[1])]),
            EndConditions::Periodic => Ends::Periodic,
        }
    }

    /// The spline of flat space.
    fn start(&self, lengths: &[f64]) -> Result<Motion> {
        let links = Links::new(&self.points)?;
        let velocities = links.spline(lengths, &self.ends)?;
        let mut bends = Vec::with_capacity(lengths.len());
        for (leg, &h) in lengths.iter().enumerate() {
            let [displacement, carried] = links.back(leg, &velocities[leg + 1])?;
            let flat = FlatData {
                displacement: self.horizontal(leg, &displacement),
                end_velocity: self.horizontal(leg, &(carried * Scale(h))),
            };
            let velocity = self.horizontal(leg, &(&velocities[leg] * Scale(h)));
            bends.push(pack(&flat.start(&velocity)));
        }
        let velocities = velocities
            .iter()
            .enumerate()
            .map(|(knot, v)| pack(&[self.horizontal(knot, v)]))
            .collect();
        Ok(Motion { velocities, bends })
    }

    /// The cubic of a leg, on `[0, 1]`.
    fn piece(
        &self,
        leg: usize,
        vectors: [Horizontal; 3],
        interrupt: Interrupt<'_>,
    ) -> Result<RiemannianCubic> {
        let vectors = if self.blocks.k < self.k {
            vectors.map(|x| full(&x))
        } else {
            vectors
        };
        let state = State::new(&self.frames[leg], vectors.each_ref());
        let mut path = Path::at(state, Accuracy::FULL);
        path.extend_to(1.0, interrupt)?;
        Ok(RiemannianCubic::of_path(
            self.n,
            self.k,
            self.basis.clone(),
            path,
            None,
        ))
    }
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
