//! The acceleration of a geometric polynomial as a residual vector, whose squared norm is the cost, and its derivative
//! with respect to the inner control points.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use super::collocation::Collocation;
use super::curve::Curve;
use super::de_casteljau::{DeCasteljauWorkspace, GeometricPolynomial};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::decomp::thin_q;
use crate::linalg::jet::MatrixJet;
use crate::linalg::product::{axpy, mul_add, mul_into};
use crate::manifold::QuasiGeodesic;

/// Solver named in errors.
pub(super) const SOLVER: &str = "control points of minimal cost";

/// The difference scheme for derivatives. In the second derivative at the ends, where the weights are small, the
/// round-off of the points is magnified some thousand times; the step sizes balance it against the truncation error.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Differences {
    /// Half the work, accurate to about 1e-6: for all steps but the last.
    Forward,
    /// Accurate to about 1e-8.
    Central,
}

impl Differences {
    fn step(self) -> f64 {
        match self {
            Differences::Forward => 5e-7,
            Differences::Central => 2e-5,
        }
    }
}

/// Round-off of a point.
const POINT_ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// `|(I - FACTOR S S^T) A|_F` is the canonical norm of a tangent vector `A`.
const FACTOR: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// One unknown: the rotation of an inner control point in the plane of two columns of its frame.
#[derive(Clone, Copy)]
struct PointTurn {
    point: usize,
    /// Index of the second column: below `k` a column of the point, otherwise one of its complement.
    other: usize,
    column: usize,
}

/// A polynomial with movable control points, except for the first two and the last two, which represent the boundary
/// data.
pub(super) struct AccelerationResidual {
    curve: GeometricPolynomial,
    work: DeCasteljauWorkspace,
    scratch: Option<MatrixJet>,
    grid: Collocation,
    turns: Vec<PointTurn>,
    /// For each control point, an orthogonal matrix of shape `(r, r)`, whose last columns span the complement of the
    /// point.
    frames: Vec<Mat<f64>>,
    values: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    small: [Mat<f64>; 2],
    tall: Mat<f64>,
}

impl AccelerationResidual {
    /// Built from a curve in the coordinates of its frame, with the given number of nodes.
    pub(super) fn new(curve: GeometricPolynomial, nodes: usize) -> Self {
        let (r, k, degree) = (curve.n(), curve.k(), curve.degree());
        let turns_of = |point| {
            (0..k).flat_map(move |column| {
                (column + 1..r).map(move |other| PointTurn {
                    point,
                    other,
                    column,
                })
            })
        };
        let turns = (2..degree.saturating_sub(1)).flat_map(turns_of).collect();
        let size = r * k * nodes;
        AccelerationResidual {
            work: curve.workspace(),
            scratch: None,
            grid: Collocation::new(nodes),
            turns,
            frames: curve.reduced_points().iter().map(complete).collect(),
            values: vec![0.0; size],
            first: vec![0.0; size],
            second: vec![0.0; size],
            small: std::array::from_fn(|_| Mat::zeros(k, k)),
            tall: Mat::zeros(r, k),
            curve,
        }
    }

    pub(super) fn into_curve(self) -> GeometricPolynomial {
        self.curve
    }

    /// Number of equations.
    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// Number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.turns.len()
    }

    /// Norm of the residual of a resting curve, caused by round-off: smaller residuals count as zero.
    pub(super) fn noise(&self) -> f64 {
        let points = self.grid.len() as f64;
        POINT_ROUND_OFF * points * points * (self.len() as f64 / points).sqrt()
    }

    /// Size of the part of the last residual's curve that the nodes do not resolve.
    pub(super) fn unresolved(&self) -> f64 {
        self.grid.unresolved(&self.values)
    }

    /// The covariant accelerations at the nodes, times the square roots of the weights, so that the squared norm is the
    /// cost.
    ///
    /// # Errors
    /// An error if the curve does not exist at a node.
    pub(super) fn residual_into(&mut self, out: &mut [f64]) -> Result<()> {
        let (r, k) = (self.curve.n(), self.curve.k());
        let columns = k * self.grid.len();
        let values = MatMut::from_column_major_slice_mut(&mut self.values, r, columns);
        let (nodes, work, scratch) = (&self.grid.nodes, &mut self.work, &mut self.scratch);
        self.curve.positions_into(nodes, work, scratch, values)?;
        self.grid
            .derivatives_into(&self.values, &mut self.first, &mut self.second);
        for (i, out) in out.chunks_mut(r * k).enumerate() {
            let part = i * r * k..(i + 1) * r * k;
            let view = |x| MatRef::from_column_major_slice(x, r, k);
            let s = view(&self.values[part.clone()]);
            let v = view(&self.first[part.clone()]);
            self.tall.copy_from(view(&self.second[part]));
            let mut out = MatMut::from_column_major_slice_mut(out, r, k);
            add_christoffel(&mut self.tall, s, v, &mut self.small);
            let root = self.grid.weights[i].sqrt();
            mul_into(&mut self.small[0], 1.0, s.transpose(), &self.tall);
            mul_into(out.rb_mut(), -root * FACTOR, s, &self.small[0]);
            axpy(out, root, &self.tall);
        }
        Ok(())
    }

    /// The derivative with respect to all rotations, one column each; `residual` must belong to the current control
    /// points.
    ///
    /// # Errors
    /// An error if a curve does not exist; `Interrupted`.
    pub(super) fn jacobian_into(
        &mut self,
        out: &mut Mat<f64>,
        residual: &[f64],
        differences: Differences,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let step = differences.step();
        let (mut ahead, mut behind) = (vec![0.0; self.len()], residual.to_vec());
        let width = match differences {
            Differences::Forward => step,
            Differences::Central => 2.0 * step,
        };
        let centre = self.curve.clone();
        for l in 0..self.turns.len() {
            interrupt.check(SOLVER)?;
            let turn = self.turns[l];
            let found = self.turned_residual_into(&mut ahead, &centre, turn, step);
            let found = match differences {
                Differences::Forward => found,
                Differences::Central => found
                    .and_then(|()| self.turned_residual_into(&mut behind, &centre, turn, -step)),
            };
            self.curve.restore_point(turn.point, &centre);
            found?;
            for i in 0..ahead.len() {
                out[(i, l)] = (ahead[i] - behind[i]) / width;
            }
        }
        Ok(())
    }

    /// The residual of the curve `centre` after one rotation; the curve stays changed.
    fn turned_residual_into(
        &mut self,
        out: &mut [f64],
        centre: &GeometricPolynomial,
        turn: PointTurn,
        angle: f64,
    ) -> Result<()> {
        let point = &centre.reduced_points()[turn.point];
        let turned = turned(point, &self.frames[turn.point], turn, angle);
        self.curve.replace_point(turn.point, &turned)?;
        self.residual_into(out)
    }

    fn point_and_frame(&self, i: usize) -> (&Mat<f64>, &Mat<f64>) {
        (&self.curve.reduced_points()[i], &self.frames[i])
    }

    /// The inner control points, retracted along `scale` times a step in the coordinates of the rotations.
    ///
    /// # Errors
    /// An error if a step is too large for a floating-point number.
    pub(super) fn moved(&self, step: &[f64], scale: f64) -> Result<Vec<Mat<f64>>> {
        let degree = self.curve.degree();
        let mut velocities: Vec<Mat<f64>> = (2..degree - 1)
            .map(|i| Mat::zeros(self.curve.reduced_points()[i].nrows(), self.curve.k()))
            .collect();
        for (turn, x) in self.turns.iter().zip(step) {
            let (point, frame) = self.point_and_frame(turn.point);
            let velocity = &mut velocities[turn.point - 2];
            for i in 0..point.nrows() {
                velocity[(i, turn.column)] += scale * x * frame[(i, turn.other)];
                if turn.other < point.ncols() {
                    velocity[(i, turn.other)] -= scale * x * point[(i, turn.column)];
                }
            }
        }
        let retract = |(i, velocity): (usize, &Mat<f64>)| {
            let (point, _) = self.point_and_frame(i + 2);
            QuasiGeodesic::from_velocity(point.as_ref(), velocity.as_ref())?.point(1.0)
        };
        velocities.iter().enumerate().map(retract).collect()
    }

    /// The inner control points.
    pub(super) fn inner(&self) -> Vec<Mat<f64>> {
        let points = self.curve.reduced_points();
        points[2..points.len() - 2].to_vec()
    }

    /// Replaces the inner control points.
    ///
    /// # Errors
    /// An error if they cannot be joined.
    pub(super) fn set_inner(&mut self, points: &[Mat<f64>]) -> Result<()> {
        for (i, point) in points.iter().enumerate() {
            self.curve.replace_point(i + 2, point)?;
            self.frames[i + 2] = complete(point);
        }
        Ok(())
    }
}

/// The rotated control point: the quasi-geodesic in that direction is a rotation of one plane.
fn turned(point: &Mat<f64>, frame: &Mat<f64>, turn: PointTurn, angle: f64) -> Mat<f64> {
    let (sin, cos) = angle.sin_cos();
    let mut out = point.clone();
    for i in 0..point.nrows() {
        let (x, y) = (point[(i, turn.column)], frame[(i, turn.other)]);
        out[(i, turn.column)] = cos * x + sin * y;
        if turn.other < point.ncols() {
            out[(i, turn.other)] = cos * y - sin * x;
        }
    }
    out
}

/// `a += Gamma(V, V)` at `s`, for the canonical metric: `V (V^T S) + S (V^T V - V^T S S^T V)`.
fn add_christoffel(
    a: &mut Mat<f64>,
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
    small: &mut [Mat<f64>; 2],
) {
    let [along, normal] = small;
    mul_into(&mut *along, 1.0, s.transpose(), v);
    mul_into(&mut *normal, 1.0, v.transpose(), v);
    mul_add(&mut *normal, -1.0, along.transpose(), &*along);
    mul_add(&mut *a, 1.0, v, along.transpose());
    mul_add(a, 1.0, s, &*normal);
}

/// An orthogonal matrix whose first columns are the point.
fn complete(point: &Mat<f64>) -> Mat<f64> {
    let (r, k) = point.shape();
    let spanning = Mat::from_fn(r, k + r, |i, j| match j.checked_sub(k) {
        None => point[(i, j)],
        Some(column) => f64::from(u8::from(i == column)),
    });
    thin_q(spanning.as_ref())
}
