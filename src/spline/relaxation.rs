//! Where no step leads from the flat spline to the spline: a chain of nodes through the knots, relaxed to low cost.
//!
//! Its cost is bounded below, so it comes to rest near a spline from almost anywhere, and near one that costs little. The
//! family of [`continuation`](super::continuation) may end in a fold instead.

use faer::{Mat, Scale};

use super::chain::{Chain as _, Motion};
use super::ends::{End, Ends};
use super::framed::{Framed, coordinates};
use super::joined::Joined;
use crate::cubic::node::Node;
use crate::cubic::problem::unpack;
use crate::cubic::relaxation::{CHAIN_UNKNOWNS, Chain, Held};
use crate::cubic::work::Work;
use crate::curve::{Curve, GeometricCubic};
use crate::error::Result;
use crate::manifold::QuasiGeodesic;

/// Legs of the chain for one of the spline: each a third of a radian for knots as far apart as they can be.
const LEGS: usize = 8;

impl Joined<'_> {
    /// The motion along the relaxed chain, from the velocities of a motion of `chain`; `None` if it has too many unknowns,
    /// or the work is done.
    ///
    /// # Errors
    /// `Interrupted`, where neighbours in the chain cannot be joined.
    pub(super) fn relaxed(
        &self,
        chain: &Framed<'_>,
        start: &Motion,
        ends: &Ends,
        work: &Work,
    ) -> Result<Option<Motion>> {
        if work.is_done() || 2 * chain.size() > CHAIN_UNKNOWNS {
            return Ok(None);
        }
        let velocity = |knot: usize| chain.tangent(knot, start.velocity(knot));
        let velocities: Vec<Mat<f64>> = (0..self.frames.len()).map(velocity).collect();
        let mut chain = self.nodes(&velocities, ends)?;
        chain.relax(work.left(), self.interrupt)?;
        work.count(chain.work());
        let size = coordinates(self.frames[0].as_ref(), velocities[0].as_ref()).len();
        let mut motion = Motion::zeros(size, self.frames.len());
        for (knot, frame) in self.frames.iter().enumerate() {
            let node = chain.nodes()[LEGS * knot].clone();
            let in_frame = |v: &Mat<f64>| coordinates(frame.as_ref(), v.as_ref());
            motion
                .velocity_mut(knot)
                .copy_from_slice(&in_frame(&node.velocity));
            if knot == self.len() {
                break;
            }
            let bends = unpack::<2>(&chain.start(LEGS * knot)?, node.blocks());
            let ratio = LEGS as f64;
            for (power, bend) in [2, 3].into_iter().zip(&bends) {
                let bend = in_frame(&(node.tangent(bend) * Scale(ratio.powi(power))));
                motion.bend_mut(knot)[(power as usize - 2) * size..][..size].copy_from_slice(&bend);
            }
        }
        Ok(Some(motion))
    }

    fn nodes(&self, velocities: &[Mat<f64>], ends: &Ends) -> Result<Chain> {
        let last = self.frames.len() - 1;
        let given = |knot: usize| match (ends, knot) {
            (Ends::Open([End::Velocity(_), _]), 0) => Held::All,
            (Ends::Open([_, End::Velocity(_)]), knot) if knot == last => Held::All,
            _ => Held::Point,
        };
        let mut nodes = vec![Node::new(
            &self.point(0).to_owned(),
            velocities[0].clone(),
            &self.frames[0],
        )];
        let mut held = vec![given(0)];
        let mut steps = Vec::new();
        for (leg, &h) in self.lengths.iter().enumerate() {
            let [v0, v1] = [leg, leg + 1].map(|knot| &velocities[knot] * Scale(h));
            let (s0, s1) = (self.point(leg), self.point(leg + 1));
            let between = match GeometricCubic::from_boundary(s0, v0.as_ref(), s1, v1.as_ref()) {
                Ok(curve) => sample(&curve, h),
                Err(_) => sample(&QuasiGeodesic::between(s0, s1)?, h),
            };
            for (point, velocity) in between? {
                let node = Node::new(&point, velocity, nodes[nodes.len() - 1].frame());
                nodes.push(node);
                held.push(Held::Nothing);
            }
            let like = nodes[nodes.len() - 1].frame();
            nodes.push(Node::new(&s1.to_owned(), velocities[leg + 1].clone(), like));
            held.push(given(leg + 1));
            steps.extend([h / LEGS as f64; LEGS]);
        }
        Chain::of(nodes, held, steps)
    }
}

/// Points, and velocities per unit of time, between the ends of a curve on `[0, 1]` that takes the time `h`.
fn sample(curve: &impl Curve, h: f64) -> Result<Vec<(Mat<f64>, Mat<f64>)>> {
    (1..LEGS)
        .map(|i| {
            let t = i as f64 / LEGS as f64;
            Ok((curve.point(t)?, curve.derivative(t, 1)? * Scale(1.0 / h)))
        })
        .collect()
}
