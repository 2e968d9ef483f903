//! A node of a discrete curve, and what a leg between two of them costs.

use faer::{Mat, Scale};

use super::guess::carry;
use super::initial::Horizontal;
use super::problem::{pack, unpack};
use super::reduced::Sized;
use crate::curve::Curve;
use crate::error::Result;
use crate::linalg::SkewExp;
use crate::linalg::decomp::thin_q;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// A point of the chain: an orthogonal frame whose first columns are the point, and the velocity in it.
#[derive(Clone)]
pub(crate) struct Node {
    frame: Mat<f64>,
    pub(crate) velocity: Mat<f64>,
}

impl Node {
    /// With the other columns of the frame as near as possible to those of `like`.
    pub(crate) fn new(point: &Mat<f64>, velocity: Mat<f64>, like: &Mat<f64>) -> Self {
        let (r, k) = point.shape();
        let columns = Mat::from_fn(
            r,
            r,
            |i, j| if j < k { point[(i, j)] } else { like[(i, j)] },
        );
        Node {
            frame: thin_q(columns.as_ref()),
            velocity,
        }
    }

    pub(crate) fn point(&self) -> Mat<f64> {
        let k = self.velocity.ncols();
        self.frame.as_ref().subcols(0, k).to_owned()
    }

    /// Moved along tangent vectors with the packed coordinates `change`: the point by the first, the velocity by the second.
    pub(crate) fn moved(&self, change: &[f64]) -> Result<Self> {
        let [along, faster] = unpack(change, self.blocks()).map(|x| self.tangent(&x));
        let curve = QuasiGeodesic::from_velocity(self.point().as_ref(), along.as_ref())?;
        let velocity = &self.velocity + faster;
        Ok(Self::new(
            &curve.point(1.0)?,
            carry(&curve, velocity.as_ref(), 1.0)?,
            &self.frame,
        ))
    }

    pub(crate) fn blocks(&self) -> Sized {
        let (r, k) = self.velocity.shape();
        Sized { m: r - k, k }
    }

    /// The frame, shape `(r, r)`, with the point as first columns.
    pub(crate) fn frame(&self) -> &Mat<f64> {
        &self.frame
    }

    pub(crate) fn tangent(&self, x: &Horizontal) -> Mat<f64> {
        let k = x.omega.nrows();
        let (point, others) = self.frame.as_ref().split_at_col(k);
        point * &x.omega + others * &x.normal
    }
}

/// The quasi-geodesic from node to node, and what it carries.
pub(super) struct Link {
    curve: QuasiGeodesic,
    /// By which it turns in itself.
    turn: Mat<f64>,
}

impl Link {
    /// # Errors
    /// Where the nodes cannot be joined.
    pub(super) fn new(from: &Node, to: &Node, problem: &mut EndpointProblem) -> Result<Self> {
        let (r, k) = from.velocity.shape();
        let mut curve = QuasiGeodesic::zeros(r, k);
        curve.join(from.point().as_ref(), to.point().as_ref(), problem)?;
        let mut turn = Mat::zeros(k, k);
        SkewExp::new(k).exp_into(turn.as_mut(), curve.omega(), 1.0)?;
        Ok(Link { curve, turn })
    }

    /// A tangent vector at the second node in a frame at the first one, packed.
    pub(super) fn carried(&self, from: &Node, v: &Mat<f64>) -> Result<Vec<f64>> {
        let back = carry(&self.curve, v.as_ref(), -1.0)?;
        let back = Horizontal::of_tangent(from.frame.as_ref(), back.as_ref());
        Ok(pack(&[Horizontal {
            omega: self.turn.transpose() * &back.omega * &self.turn,
            normal: &back.normal * &self.turn,
        }]))
    }

    /// Mean velocity, initial velocity and end velocity, packed, in a frame that moves along the quasi-geodesic without turning
    /// in itself.
    ///
    /// In the frame `e^{tX} g\, diag(e^{t Omega}, I)` the velocity of the quasi-geodesic is `(omega, b e^{t Omega})`; the mean
    /// of its ends stands for the mean.
    pub(super) fn velocities(&self, from: &Node, to: &Node) -> Result<[Vec<f64>; 3]> {
        let horizontal = |v: &Mat<f64>| Horizontal::of_tangent(from.frame.as_ref(), v.as_ref());
        let delta = horizontal(&self.curve.initial_velocity());
        let mean = Horizontal {
            normal: (&delta.normal * &self.turn + &delta.normal) * Scale(0.5),
            omega: delta.omega,
        };
        let start = horizontal(&from.velocity);
        Ok([
            pack(&[mean]),
            pack(&[start]),
            self.carried(from, &to.velocity)?,
        ])
    }

    /// The residual where it takes the time `step`, packed: `2d` numbers, the sum of their squares the cost.
    pub(super) fn residual(&self, from: &Node, to: &Node, step: f64) -> Result<Vec<f64>> {
        let [delta, v, w] = self.velocities(from, to)?;
        let [turning, lagging] = weights(step);
        let turn = v.iter().zip(&w).map(|(v, w)| turning * (w - v));
        let lag = delta
            .iter()
            .zip(v.iter().zip(&w))
            .map(|(delta, (v, w))| lagging * (2.0 * delta / step - (v + w)));
        Ok(turn.chain(lag).collect())
    }
}

/// Factors of `W - V` and of `2 Delta / h - (V + W)` in the residual of a leg that takes the time `step`.
pub(super) fn weights(step: f64) -> [f64; 2] {
    [1.0, 3.0_f64.sqrt()].map(|factor| factor / step.sqrt())
}
