//! Relations between neighbouring knots with frames: the rotation between the frames, the shortest curve, and how
//! vectors are carried.

use faer::Mat;

use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::taylor::packing::{pack, read_entries};
use crate::error::{Error, Result};
use crate::linalg::product::{determinant_sign, entries, mul_into};
use crate::linalg::{OrthogonalLog, skew_exp};
use crate::manifold::carrier::turned;
use crate::manifold::quasi_geodesic::EndpointProblem;
use crate::space::{Quotient, ScalarField};
use crate::spline::joining_curves::{JoiningCurve, joining_curve};

/// Relation between the two ends of a leg, matrices in column-major order.
pub(crate) struct NeighbourLink {
    /// The frame of the next knot relative to the frame of the knot where the leg starts, shape `(r, r)`.
    pub(crate) next: Vec<f64>,
    /// A vector `v` is carried to `left v right`, in the frames of the two knots; `None` if its coordinates do not
    /// change.
    pub(crate) carrying: Option<[Vec<f64>; 2]>,
    pub(crate) displacement: Vec<f64>,
}

/// The method for joining neighbours.
pub(crate) enum Joining {
    /// If frames are points: by the logarithm of the rotation between them.
    Group {
        log: OrthogonalLog,
        /// Buffers for the rotation and its logarithm.
        next: Mat<f64>,
        turn: Mat<f64>,
    },
    /// By a quasi-geodesic.
    Quotient(Box<EndpointProblem>),
}

impl Joining {
    /// For points of shape `(r, columns)`, whose equations are solved in the given blocks.
    pub(crate) fn new(blocks: Sizes, columns: usize) -> Self {
        let r = blocks.m + blocks.k;
        let is_group = match blocks.field {
            ScalarField::Real => blocks.m == 1 && blocks.quotient == Quotient::Frames,
            ScalarField::Complex => blocks.m == 0 && blocks.quotient == Quotient::Frames,
        };
        match is_group {
            true => Joining::Group {
                log: OrthogonalLog::new(r),
                next: Mat::zeros(r, r),
                turn: Mat::zeros(r, r),
            },
            false => Joining::Quotient(Box::new(EndpointProblem::new(r, columns))),
        }
    }

    /// The link from one frame to another.
    ///
    /// # Errors
    /// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`.
    pub(crate) fn link(
        &mut self,
        frames: [&Mat<f64>; 2],
        blocks: Sizes,
        columns: usize,
    ) -> Result<NeighbourLink> {
        match self {
            Joining::Group { log, next, turn } => {
                let link = in_group(frames, blocks, log, [next, turn]);
                link.map_err(|error| match error {
                    Error::OutsideLogDomain { angle } if columns < frames[0].nrows() => {
                        Error::NoJoiningCurve { angle }
                    }
                    other => other,
                })
            }
            Joining::Quotient(problem) => {
                let [s0, s1] = frames.map(|frame| frame.as_ref().subcols(0, columns));
                along(
                    &joining_curve(s0, s1, blocks.quotient, problem)?,
                    frames,
                    blocks,
                )
            }
        }
    }
}

fn in_group(
    [from, to]: [&Mat<f64>; 2],
    blocks: Sizes,
    log: &mut OrthogonalLog,
    [next, turn]: [&mut Mat<f64>; 2],
) -> Result<NeighbourLink> {
    let r = from.nrows();
    mul_into(&mut *next, 1.0, from.transpose(), to);
    log.log_into(turn.as_mut(), next.as_ref())
        .map_err(
            |error| match determinant_sign(next.clone().as_mut()) < 0.0 {
                true => Error::DifferentComponents { n: r },
                false => error,
            },
        )?;
    let mut displacement = vec![0.0; blocks.dim()];
    read_entries(|i, j| turn[(i, j)], &mut displacement, blocks);
    Ok(NeighbourLink {
        next: entries(next),
        carrying: None,
        displacement,
    })
}

fn along(
    joining_curve: &JoiningCurve,
    frames: [&Mat<f64>; 2],
    blocks: Sizes,
) -> Result<NeighbourLink> {
    let curve = &joining_curve.curve;
    let turn = match &joining_curve.turn {
        Some(turn) => turn.clone(),
        None => skew_exp(curve.omega())?,
    };
    let displacement = curve.initial_velocity();
    let displacement = displacement.as_ref().subcols(0, blocks.k);
    let left = entries(&(frames[1].transpose() * turned(curve, frames[0].as_ref(), 1.0)));
    let displacement = Horizontal::of_tangent(frames[0].as_ref(), displacement);
    Ok(NeighbourLink {
        next: entries(&(frames[0].transpose() * frames[1])),
        carrying: Some([left, entries(&turn)]),
        displacement: pack(blocks, &[displacement]),
    })
}
