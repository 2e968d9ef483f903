//! Shortening a broken geodesic: a start for metrics without a fibre to descend over.
//!
//! The path along a canonical geodesic is slightly perturbed and divided by nodes; each node in turn moves towards the
//! midpoint of its neighbours. As long as the two geodesics at a node are short, this is a gradient descent step of
//! length 1 for the sum of the squared lengths, which decreases in every step. So the path stays on its side of every
//! saddle, and converges to a geodesic without conjugate points.
//!
//! # Source
//! Noakes (1998), "A global algorithm for geodesics", J. Austral. Math. Soc. A 65, 37-50. Deviation: over-relaxed
//! gradient descent steps instead of geodesics over two pieces, which need not be short.

use faer::{Mat, MatRef, Scale};

use super::descent::{complement, generic_skew};
use super::report::SOLVER;
use super::shooting::{CLOSE_CONTRACTION, CLOSE_STEPS, GeodesicShooting, write_block};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::SkewExp;
use crate::linalg::product::product;

/// The optimal factor for four pieces in a flat space, `2 / (1 + sin(pi / 4))`.
const RELAXATION: f64 = 1.17;

/// Maximal number of sweeps per call: a flat valley takes more, and is left to the damped iteration.
const SWEEPS: usize = 20;

/// Angle of the perturbation that breaks symmetries.
const DISTURBANCE: f64 = 0.1;

/// Residual tolerance of the geodesics between nodes.
const LEG_TOLERANCE: f64 = 1e-9;

/// The result of shortening a path.
pub(super) struct Shortened {
    /// Generator of the geodesic with the velocity of the first piece, over the duration of all pieces.
    pub(super) generator: Mat<f64>,
    pub(super) length: f64,
}

/// A broken geodesic between the points, in the metric of a given weight.
pub(super) struct Path {
    weight: f64,
    nodes: Vec<Mat<f64>>,
    exp: SkewExp,
    turn: SkewExp,
}

impl Path {
    /// The perturbed path along a canonical generator, in the given number of pieces.
    ///
    /// # Errors
    /// The errors of the exponential.
    pub(super) fn along(
        target: &Mat<f64>,
        canonical: MatRef<'_, f64>,
        weight: f64,
        pieces: usize,
    ) -> Result<Self> {
        let (m, k) = target.shape();
        let mut exp = SkewExp::new(m);
        let (mut rotation, mut generic) = (Mat::zeros(m, m), Mat::zeros(m, m));
        write_block(&generic_skew(m), generic.as_mut(), 0, m, 1.0);
        let mut disturbance = Mat::zeros(m, m);
        exp.exp_into(disturbance.as_mut(), generic.as_ref(), DISTURBANCE)?;
        let mut nodes = vec![Mat::from_fn(m, k, |i, j| f64::from(u8::from(i == j)))];
        for j in 1..pieces {
            exp.exp_into(rotation.as_mut(), canonical, j as f64 / pieces as f64)?;
            nodes.push(&disturbance * rotation.as_ref().subcols(0, k));
        }
        nodes.push(target.clone());
        Ok(Path {
            weight,
            nodes,
            exp,
            turn: SkewExp::new(k),
        })
    }

    /// Sweeps until the corner angles are at most `corner`, relative to the length of a piece; `None` if pieces are too
    /// long.
    ///
    /// # Errors
    /// `Interrupted`, and the errors of the exponential.
    pub(super) fn shorten(
        &mut self,
        corner: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<Option<Shortened>> {
        for _ in 0..SWEEPS {
            interrupt.check(SOLVER)?;
            match self.sweep()? {
                Some(largest) if largest > corner => {}
                Some(_) => break,
                None => return Ok(None),
            }
        }
        self.result()
    }

    /// Moves every inner node; returns the largest corner angle, relative to the piece before it.
    fn sweep(&mut self) -> Result<Option<f64>> {
        let mut largest = 0.0_f64;
        for i in 1..self.nodes.len() - 1 {
            let frame = frame(&self.nodes[i]);
            let Some((back, length)) = self.leg(&frame, &self.nodes[i - 1])? else {
                return Ok(None);
            };
            let Some((ahead, _)) = self.leg(&frame, &self.nodes[i + 1])? else {
                return Ok(None);
            };
            let middle = (back + ahead) * Scale(0.5 * RELAXATION);
            largest = largest.max(middle.norm_l2() / length);
            self.nodes[i] = self.moved(&frame, &middle)?;
        }
        Ok(Some(largest))
    }

    fn result(&mut self) -> Result<Option<Shortened>> {
        let pieces = self.nodes.len() - 1;
        let mut length = 0.0;
        let mut generator = None;
        for i in 0..pieces {
            let Some((leg, piece)) = self.leg(&frame(&self.nodes[i]), &self.nodes[i + 1])? else {
                return Ok(None);
            };
            length += piece;
            generator.get_or_insert(leg);
        }
        Ok(generator.map(|leg| Shortened {
            generator: leg * Scale(pieces as f64),
            length,
        }))
    }

    /// Generator, in the coordinates of the frame, and length of the short geodesic to a node.
    fn leg(&self, frame: &Mat<f64>, to: &Mat<f64>) -> Result<Option<(Mat<f64>, f64)>> {
        let target = product(frame.transpose(), to);
        let mut shooting = GeodesicShooting::new(&target, self.weight);
        shooting.start_close();
        let outcome = shooting.run(LEG_TOLERANCE, CLOSE_CONTRACTION, CLOSE_STEPS)?;
        let (a, b) = shooting.norms();
        let length = b.hypot(a * self.weight.sqrt());
        Ok(outcome.converged.then_some((shooting.generator, length)))
    }

    /// End of the geodesic with generator `L`: `g e^L [I; 0] e^{nu A}`.
    fn moved(&mut self, frame: &Mat<f64>, generator: &Mat<f64>) -> Result<Mat<f64>> {
        let (m, k) = self.nodes[0].shape();
        let (mut rotation, mut turn) = (Mat::zeros(m, m), Mat::zeros(k, k));
        self.exp
            .exp_into(rotation.as_mut(), generator.as_ref(), 1.0)?;
        let twice = 2.0 * self.weight;
        let a = generator.as_ref().submatrix(0, 0, k, k);
        self.turn
            .exp_into(turn.as_mut(), a, (1.0 - twice) / twice)?;
        let end = rotation.as_ref().subcols(0, k) * &turn;
        Ok(frame * end)
    }
}

/// A node completed to an orthogonal matrix.
fn frame(node: &Mat<f64>) -> Mat<f64> {
    let (m, k) = node.shape();
    let mut frame = Mat::zeros(m, m);
    frame.as_mut().subcols_mut(0, k).copy_from(node);
    frame
        .as_mut()
        .subcols_mut(k, m - k)
        .copy_from(&complement(node.as_ref()));
    frame
}
