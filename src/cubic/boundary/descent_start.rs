//! Starts of descents: points and velocities at equidistant times, along a curve that need not be a cubic.

use faer::{Mat, MatRef, Scale};

use super::guess::FlatData;
use super::problem::BoundaryProblem;
use super::relative_ends::RelativeEnds;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::{Horizontal, complete_relative};
use crate::cubic::taylor::packing::pack;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::curve::{Curve, GeometricCubic};
use crate::error::{Error, Result};
use crate::linalg::complex_embedding::{embed, nearest};
use crate::linalg::decomp::spectral_norm;
use crate::linalg::structure::row_by_row;
use crate::linalg::{orthogonal_log, skew_exp, unitary_log};
use crate::manifold::QuasiGeodesic;
use crate::manifold::carrier::{carried, turned};
use crate::manifold::quasi_geodesic::EndpointProblem;
use crate::shooting::ChainKnots;
use crate::space::{Kind, RowOrder, ScalarField};

/// Minimal number of legs of a curve: one per lane.
pub(crate) const LEGS: usize = 8;

/// Maximal number of legs, and maximal length of a leg in radians: the guess for the middle of a leg needs less than a
/// right angle. With 2.0, a descent from a rolling curve with speeds of 8 to 16 can get lost, and a descent from the
/// flat one can end at up to 400 times the cost.
const MOST_LEGS: usize = 1024;
const LONGEST_LEG: f64 = 1.5;

/// Largest derivative of `3 t^2 - 2 t^3`, the fraction of its rotation that a rolling curve has completed.
const TURN_RATE: f64 = 1.5;

/// Points and velocities at equidistant times; the first and the last ones are given.
pub(crate) struct DescentStart {
    kind: Kind,
    knots: Vec<[Mat<f64>; 2]>,
    is_unique: bool,
}

impl DescentStart {
    /// Along the cubic `c` of flat space with given displacement and end velocities: the end points of the
    /// quasi-geodesics with initial velocities `c(t)`.
    ///
    /// # Errors
    /// An error if the numbers are too large.
    pub(crate) fn along_flat(kind: Kind, ends: RelativeEnds<'_>, flat: &FlatData) -> Result<Self> {
        let (start, v0) = (&ends.initial()[0], ends.velocity);
        let count = legs(flat.largest_speed(v0), LEGS)?;
        let at = |i: usize| {
            let [c, velocity] = flat.at(i as f64 / count as f64, v0);
            let curve = QuasiGeodesic::from_velocity(start.as_ref(), c.tangent().as_ref())?;
            let velocity = carried(&curve, velocity.tangent().as_ref(), 1.0)?;
            Ok([curve.point(1.0)?, velocity])
        };
        let knots = (0..=count).map(at).collect::<Result<_>>()?;
        Ok(Self::new(kind, ends, knots))
    }

    /// Along the adjusted de Casteljau curve.
    ///
    /// # Errors
    /// An error if the curve does not exist or the numbers are too large.
    pub(crate) fn along_geometric(problem: &BoundaryProblem) -> Result<Self> {
        let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
        let [s0, v0] = problem.initial();
        let curve = GeometricCubic::from_boundary(s0.as_ref(), v0.as_ref(), s1, v1)?;
        let speed = curve.derivative(0.5, 1)?.norm_l2();
        let count = legs(speed.max(problem.speed), LEGS)?;
        let at = |i: usize| {
            let t = i as f64 / count as f64;
            Ok([curve.point(t)?, curve.derivative(t, 1)?])
        };
        let knots = (0..=count).map(at).collect::<Result<_>>()?;
        Ok(Self::new(problem.kind(), problem.relative_ends(), knots))
    }

    /// Along a cubic on `[0, 1]` with the initial data of a problem, which need not have the given end.
    ///
    /// # Errors
    /// An error if it is too fast.
    pub(crate) fn along_cubic(problem: &BoundaryProblem, cubic: &PiecewiseTaylor) -> Result<Self> {
        let ends = problem.relative_ends();
        let (r, k) = ends.end[0].shape();
        let rows = cubic.rows();
        let at = |t: f64| {
            let [mut point, mut velocity] = [(); 2].map(|()| vec![0.0; rows * k]);
            cubic.points_into(t, &mut [&mut point, &mut velocity]);
            [point, velocity].map(|x| {
                let all = MatRef::from_column_major_slice(&x, rows, k);
                problem.g.transpose() * all.subrows(0, r)
            })
        };
        let pieces = cubic.pieces.iter().map(|piece| piece.upper.min(1.0));
        let speeds = pieces.map(|t| at(t)[1].norm_l2());
        let speed = speeds.fold(at(0.0)[1].norm_l2(), f64::max);
        let count = legs(speed, LEGS)?;
        let knots = (0..=count).map(|i| at(i as f64 / count as f64));
        Ok(Self::new(problem.kind(), ends, knots.collect()))
    }

    /// Along a rolling curve: its velocity changes linearly from the initial to the end velocity, and the space rotates
    /// so that the curve ends at the given point. It consists of the first columns of `e^{s(t) Omega} g(t)`, where `g'
    /// = g ((1 - t) x_0 + t x_1)`, `s = 3 t^2 - 2 t^3` and `e^Omega g(1)` is the frame at the end point. That frame is
    /// carried along a quasi-geodesic if it is unique, else any frame is used. The number of legs is a multiple of `multiple`.
    ///
    /// # Errors
    /// An error if the numbers are too large.
    pub(crate) fn rolling(kind: Kind, ends: RelativeEnds<'_>, multiple: usize) -> Result<Self> {
        let [s1, v1] = ends.end.each_ref().map(|x| x.as_ref());
        let (r, k) = s1.shape();
        let along = frame_along(&ends.initial()[0], s1);
        let is_unique = along.is_ok();
        let frame = along.unwrap_or_else(|_| complete_relative(kind.field, s1));
        let (first, last) = (ends.velocity, Horizontal::of_tangent(frame.as_ref(), v1));
        let velocity = |t: f64| first.clone().plus(-t, first).plus(t, &last);
        let log = |a: MatRef<'_, f64>| match kind.field {
            ScalarField::Real => orthogonal_log(a),
            // If it is not unique, it must still be an embedded complex matrix.
            ScalarField::Complex => {
                let rows = RowOrder { r, k };
                let a = rows.halves(rows.halves(a).transpose());
                let log = embed(unitary_log(nearest(a.transpose()).as_ref())?.as_ref());
                let log = rows.blocks(rows.blocks(log.as_ref()).transpose());
                Ok(log.transpose().to_owned())
            }
        };
        let roll = |count: usize| {
            let step = 1.0 / count as f64;
            let mut frames = vec![Mat::<f64>::identity(r, r)];
            for i in 0..count {
                let x = velocity(step * (i as f64 + 0.5)).matrix() * Scale(step);
                frames.push(&frames[i] * skew_exp(x.as_ref())?);
            }
            let turn = log((&frame * frames[count].transpose()).as_ref())?;
            Result::Ok((frames, turn))
        };
        let matrices = [first.matrix(), last.matrix()];
        let [initial, end] = matrices.each_ref().map(|x| spectral_norm(x.as_ref()));
        let speed = initial?.max(end?);
        let (_, turn) = roll(legs(speed, multiple)?)?;
        let speed = speed + TURN_RATE * spectral_norm(turn.as_ref())?;
        let count = legs(speed, multiple)?;
        let (frames, turn) = roll(count)?;
        let step = 1.0 / count as f64;
        let at = |i: usize| {
            let t = step * i as f64;
            let [share, rate] = [t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)];
            let turned = skew_exp((&turn * Scale(share)).as_ref())?;
            let point = frames[i].as_ref().subcols(0, k);
            let velocity = &frames[i] * velocity(t).tangent() + &turn * point * Scale(rate);
            Ok([&turned * point, turned * velocity])
        };
        let knots = (0..=count).map(at).collect::<Result<_>>()?;
        Ok(DescentStart {
            is_unique,
            ..Self::new(kind, ends, knots)
        })
    }

    fn new(kind: Kind, ends: RelativeEnds<'_>, mut knots: Vec<[Mat<f64>; 2]>) -> Self {
        let last = knots.len() - 1;
        knots[0] = ends.initial();
        knots[last].clone_from(ends.end);
        DescentStart {
            kind,
            knots,
            is_unique: true,
        }
    }

    /// Whether the data determine the start, because a unique quasi-geodesic joins the end points.
    pub(crate) fn is_unique(&self) -> bool {
        self.is_unique
    }

    pub(crate) fn legs(&self) -> usize {
        self.knots.len() - 1
    }

    /// The frame at a knot, shape `(r, r)`, and the velocity in it, in the time of a leg.
    pub(crate) fn at(&self, knot: usize) -> (Mat<f64>, Vec<f64>) {
        let [point, velocity] = &self.knots[knot];
        let frame = match knot {
            0 => Mat::identity(point.nrows(), point.nrows()),
            _ => complete_relative(self.kind.field, point.as_ref()),
        };
        let velocity = Horizontal::of_tangent(frame.as_ref(), velocity.as_ref());
        let step = 1.0 / self.legs() as f64;
        let (r, k) = point.shape();
        let velocity = pack(Sizes::of_kind(r - k, k, self.kind), &[velocity]);
        let velocity = velocity.iter().map(|x| step * x).collect();
        (frame, velocity)
    }

    /// The knots, with velocities in the time of a leg.
    pub(crate) fn chain_knots(&self) -> ChainKnots {
        let mut knots = ChainKnots::default();
        for knot in 0..self.knots.len() {
            let (frame, velocity) = self.at(knot);
            knots.frames.extend(row_by_row(frame.as_ref()));
            knots.velocities.extend(velocity);
        }
        knots
    }
}

/// The identity, the frame at the start, carried along a quasi-geodesic to the end point.
fn frame_along(s0: &Mat<f64>, s1: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let (r, k) = s1.shape();
    let mut curve = QuasiGeodesic::zeros(r, k);
    curve.join(s0.as_ref(), s1, &mut EndpointProblem::new(r, k))?;
    let mut turn = Mat::identity(r, r);
    turn.submatrix_mut(0, 0, k, k)
        .copy_from(skew_exp(curve.omega())?);
    Ok(turned(&curve, turn.as_ref(), 1.0))
}

/// Number of legs for a curve of the given speed, rounded up to a multiple.
///
/// # Errors
/// `Overflow` of the speed if there would be too many legs; this start is then not available.
fn legs(speed: f64, multiple: usize) -> Result<usize> {
    let groups = (speed / (LONGEST_LEG * multiple as f64)).ceil();
    match groups <= (MOST_LEGS / multiple) as f64 {
        true => Ok(multiple * (groups as usize).max(1)),
        false => Err(Error::Overflow { quantity: "speed" }),
    }
}
