//! Curves of low cost that splines start from: a chain of points with velocities, relaxed until its cost falls no further.
//!
//! Between neighbours `(S, V)` and `(S', V')`, a time `h` apart, the cost of the cubic of flat space is a sum of squares,
//!
//! ```math
//! \int |D_t S'|^2 dt \approx \frac1h |W - V|^2 + \frac{12}{h} \Bigl| \frac{\Delta}{h} - \frac{V + W}{2} \Bigr|^2
//! ```
//!
//! with the displacement `Delta` along the quasi-geodesic and `W` the velocity `V'` in a frame that moves along it. The sum
//! over the chain is bounded below, so the Levenberg-Marquardt method on its nodes comes to a curve near a Riemannian cubic
//! from almost anywhere.
//!
//! # Source
//! Levenberg (1944), Quart. Appl. Math. 2, 164-168; Marquardt (1963), SIAM J. Appl. Math. 11, 431-441. The discrete cost is our
//! own.

use faer::Mat;

use super::node::{Link, Node, weights};
use super::problem::unpack;
use super::reduced::Sized;
use super::shooting::SOLVER;
use super::work::work_of_join;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::tridiagonal::BlockTridiagonal;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// Unknowns of a node up to which chains are relaxed: the Jacobian costs one difference per unknown and node. A spline through
/// eight frames of St(12,6) (102 unknowns) took 26 s with chains and 5 s without, before work was limited.
pub(crate) const CHAIN_UNKNOWNS: usize = 64;

/// Steps of the method at the most.
const MAX_STEPS: usize = 60;

/// The cost has come to rest where a step lowers it by less than this share.
const AT_REST: f64 = 1e-7;

/// The first damping relative to the mean diagonal, its factors after failure and success, and the largest.
const DAMPING: f64 = 1e-3;
const RAISE: f64 = 8.0;
const LOWER: f64 = 0.2;
const MAX_DAMPING: f64 = 1e6;

/// Share of the mean diagonal by which small entries are damped.
const FLOOR: f64 = 1e-3;

/// Differences of the residuals of a leg.
const DIFFERENCE: f64 = 1e-6;

/// What of a node is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    Nothing,
    Point,
    /// Point and velocity.
    All,
}

/// A chain of nodes, some of them given.
pub(crate) struct Chain {
    nodes: Vec<Node>,
    held: Vec<Held>,
    /// Times that the legs take.
    steps: Vec<f64>,
    cost: f64,
    endpoints: EndpointProblem,
    /// Legs that were evaluated so far.
    evaluated: usize,
}

impl Chain {
    /// Of given nodes, and legs that take the given times.
    ///
    /// # Errors
    /// Where neighbours cannot be joined.
    pub(crate) fn of(nodes: Vec<Node>, held: Vec<Held>, steps: Vec<f64>) -> Result<Self> {
        let (r, k) = nodes[0].velocity.shape();
        let mut endpoints = EndpointProblem::new(r, k);
        let cost = cost(&nodes, &steps, &mut endpoints)?;
        Ok(Chain {
            evaluated: steps.len(),
            nodes,
            held,
            steps,
            cost,
            endpoints,
        })
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Lowers the cost until it rests, or more than the given work is done.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn relax(&mut self, most: f64, interrupt: Interrupt<'_>) -> Result<()> {
        let mut damping = DAMPING;
        for _ in 0..MAX_STEPS {
            interrupt.check(SOLVER)?;
            if self.work() > most {
                return Ok(());
            }
            let Ok((matrix, gradient)) = self.normal_equations() else {
                return Ok(());
            };
            let before = self.cost;
            while !self.step(&matrix, &gradient, damping) {
                damping *= RAISE;
                if damping > MAX_DAMPING {
                    return Ok(());
                }
            }
            damping *= LOWER;
            if before - self.cost <= AT_REST * before {
                return Ok(());
            }
        }
        Ok(())
    }

    /// `J^T J` and `J^T r` over all nodes; where something is given, that of an unknown that has come to rest.
    fn normal_equations(&mut self) -> Result<(BlockTridiagonal, Vec<f64>)> {
        let (size, legs) = (self.unknowns(), self.legs());
        let mut matrix = BlockTridiagonal::zeros(legs + 1, size);
        let mut gradient = vec![0.0; (legs + 1) * size];
        let mut beside = self.beside(0)?;
        for i in 0..legs {
            let next = self.beside(i + 1)?;
            let (jacobian, base) = self.jacobian(i, [&beside, &next])?;
            beside = next;
            let square = jacobian.transpose() * &jacobian;
            let right = jacobian.transpose() * Mat::from_fn(base.len(), 1, |row, _| base[row]);
            let block =
                |row: usize, column: usize| square.submatrix(row * size, column * size, size, size);
            matrix.diagonal[i] += block(0, 0);
            matrix.diagonal[i + 1] += block(1, 1);
            matrix.above[i] += block(0, 1);
            for unknown in 0..2 * size {
                gradient[i * size + unknown] += right[(unknown, 0)];
            }
        }
        for node in 0..=legs {
            for unknown in self.given(node) {
                matrix.diagonal[node][(unknown, unknown)] = 1.0;
            }
        }
        Ok((matrix, gradient))
    }

    /// Unknowns of a node that are given: its point comes first.
    fn given(&self, node: usize) -> std::ops::Range<usize> {
        let size = self.unknowns();
        match self.held[node] {
            Held::Nothing => 0..0,
            Held::Point => 0..size / 2,
            Held::All => 0..size,
        }
    }

    /// A node with its point moved a little along each of its coordinates; none where the point is given.
    fn beside(&mut self, node: usize) -> Result<Vec<Node>> {
        let size = self.unknowns();
        (self.given(node).end..size / 2)
            .map(|unknown| {
                let mut change = vec![0.0; size];
                change[unknown] = DIFFERENCE;
                self.nodes[node].moved(&change)
            })
            .collect()
    }

    /// Derivative of the residual of a leg with respect to what is not given at its ends, and the residual. By differences for
    /// the points; in the velocities it is linear.
    fn jacobian(&mut self, i: usize, beside: [&[Node]; 2]) -> Result<(Mat<f64>, Vec<f64>)> {
        let (size, step) = (self.unknowns(), self.steps[i]);
        let (half, [from, to]) = (size / 2, [&self.nodes[i], &self.nodes[i + 1]]);
        let link = Link::new(from, to, &mut self.endpoints)?;
        let base = link.residual(from, to, step)?;
        let mut jacobian = Mat::zeros(base.len(), 2 * size);
        for (side, moved) in beside.into_iter().enumerate() {
            for (unknown, moved) in moved.iter().enumerate() {
                let [from, to] = if side == 0 {
                    [moved, to]
                } else {
                    [from, moved]
                };
                let there = Link::new(from, to, &mut self.endpoints)?.residual(from, to, step)?;
                for (row, (b, a)) in there.iter().zip(&base).enumerate() {
                    jacobian[(row, side * size + unknown)] = (b - a) / DIFFERENCE;
                }
            }
        }
        self.evaluated += 1 + beside.map(<[Node]>::len).iter().sum::<usize>();
        let [turning, lagging] = weights(step);
        if self.held[i] != Held::All {
            for unknown in 0..half {
                jacobian[(unknown, half + unknown)] = -turning;
                jacobian[(half + unknown, half + unknown)] = -lagging;
            }
        }
        if self.held[i + 1] != Held::All {
            for unknown in 0..half {
                let mut unit = vec![0.0; half];
                unit[unknown] = 1.0;
                let [unit] = unpack(&unit, to.blocks());
                for (row, w) in link.carried(from, &to.tangent(&unit))?.iter().enumerate() {
                    jacobian[(row, size + half + unknown)] = turning * w;
                    jacobian[(half + row, size + half + unknown)] = -lagging * w;
                }
            }
        }
        Ok((jacobian, base))
    }

    /// Tries a step; whether it lowers the cost.
    fn step(&mut self, matrix: &BlockTridiagonal, gradient: &[f64], damping: f64) -> bool {
        let (size, count) = (self.unknowns(), gradient.len());
        let entries = |block: &Mat<f64>| (0..size).map(|i| block[(i, i)]).sum::<f64>();
        let mean = matrix.diagonal.iter().map(entries).sum::<f64>() / count as f64;
        let mut damped = matrix.clone();
        for block in &mut damped.diagonal {
            for i in 0..size {
                block[(i, i)] += damping * (block[(i, i)] + FLOOR * mean);
            }
        }
        let Some(change) = damped.solve(gradient) else {
            return false;
        };
        let mut nodes = self.nodes.clone();
        for i in 0..nodes.len() {
            if self.held[i] == Held::All {
                continue;
            }
            let mut change: Vec<f64> = change[i * size..][..size].iter().map(|x| -x).collect();
            change[self.given(i)].fill(0.0);
            match self.nodes[i].moved(&change) {
                Ok(moved) => nodes[i] = moved,
                Err(_) => return false,
            }
        }
        self.evaluated += self.legs();
        match cost(&nodes, &self.steps, &mut self.endpoints) {
            Ok(cost) if cost < self.cost => {
                (self.nodes, self.cost) = (nodes, cost);
                true
            }
            _ => false,
        }
    }

    /// Of one node.
    fn unknowns(&self) -> usize {
        let Sized { m, k } = self.nodes[0].blocks();
        k * (k - 1) + 2 * m * k
    }

    /// What all legs that were evaluated took, in the unit of the work of integrations.
    pub(crate) fn work(&self) -> f64 {
        self.evaluated as f64 * work_of_join(self.nodes[0].blocks())
    }

    /// Number of legs.
    pub(super) fn legs(&self) -> usize {
        self.nodes.len() - 1
    }

    /// `(x', x'')` at the start of a leg, in a parameter that runs from 0 to 1 on it.
    ///
    /// # Errors
    /// Where it cannot be joined.
    pub(crate) fn start(&mut self, i: usize) -> Result<Vec<f64>> {
        let [from, to] = [&self.nodes[i], &self.nodes[i + 1]];
        let [delta, v, w] = Link::new(from, to, &mut self.endpoints)?.velocities(from, to)?;
        let step = self.steps[i];
        let entries = || delta.iter().zip(v.iter().zip(&w));
        let a = entries().map(|(delta, (v, w))| 6.0 * delta - step * (4.0 * v + 2.0 * w));
        let second = entries().map(|(delta, (v, w))| -12.0 * delta + step * 6.0 * (v + w));
        Ok(a.chain(second).collect())
    }
}

/// The cost of a chain.
fn cost(nodes: &[Node], steps: &[f64], endpoints: &mut EndpointProblem) -> Result<f64> {
    let mut sum = 0.0;
    for (pair, step) in nodes.windows(2).zip(steps) {
        let [from, to] = [&pair[0], &pair[1]];
        let residual = Link::new(from, to, endpoints)?.residual(from, to, *step)?;
        sum += residual.iter().map(|r| r * r).sum::<f64>();
    }
    if sum.is_finite() {
        return Ok(sum);
    }
    Err(Error::Overflow { quantity: "cost" })
}
