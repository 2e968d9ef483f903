//! A cubic on `[0, 1]` at Gauss nodes, with the residuals of its equations and of its ends.

use std::sync::Arc;

use crate::collocation::along::Along;
use crate::collocation::boundary::lane_frames::LaneFrames;
use crate::collocation::lane_matrices::{add_product_of_numbers, polar_factor};
use crate::collocation::lane_nodes::LaneNodes;
use crate::collocation::linear::linear_terms::{InSpan, columns};
use crate::collocation::motion::{set_motion, solve_flat};
use crate::linalg::field::{larger, largest};
use crate::linalg::lanes::Lanes;
use crate::linalg::simd::vectorised;
use crate::space::Homogeneous;

/// Maximal number of Picard iterations for `x'''`.
const MOST_SWEEPS: usize = 30;

/// Data at the ends, relative to the frame at the start.
#[derive(Debug, Clone)]
pub(crate) struct BoundaryData {
    /// The frame at the end, shape `(r, r)`, in row-major order.
    pub(crate) target: Vec<f64>,
    /// Velocities at the start and at the end, in the frames there.
    pub(crate) velocities: [Vec<f64>; 2],
    /// Tension of the curve.
    pub(crate) tension: f64,
}

/// The unknowns, what follows from them, and the residuals.
pub(crate) struct BoundaryLeg<'d, S> {
    pub(crate) space: S,
    pub(crate) nodes: Arc<LaneNodes>,
    data: &'d BoundaryData,
    /// The transpose of the frame at the end.
    back: Vec<f64>,
    /// `x'` and `x''` at the start, and `x'''` at the nodes.
    pub(crate) derivatives: [Vec<f64>; 2],
    pub(crate) f: Vec<Lanes>,
    /// `x, x', x''` at the nodes and at the end.
    pub(crate) x: [Vec<Lanes>; 3],
    pub(crate) last: [Vec<f64>; 3],
    pub(crate) along: Vec<Along>,
    pub(crate) frames: LaneFrames,
    /// The required velocity in the frame reached.
    pub(crate) wanted: Vec<f64>,
    pub(crate) residual: BoundaryResidual,
}

/// Residuals of the equations.
pub(crate) struct BoundaryResidual {
    /// `x'''` minus the right-hand side at the nodes.
    pub(crate) f: Vec<Lanes>,
    /// Displacement of the end from the given one, in the frame reached, and excess of its velocity.
    pub(crate) point: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    /// `(|S(1) - S_1|^2 + |V(1) - V_1|^2)^(1/2)`, with bases of subspaces aligned. Unlike the displacement, it does not
    /// vanish where the end is a reflection of the given one.
    pub(crate) distance: f64,
    /// The defect of the frames.
    frames: f64,
}

impl BoundaryResidual {
    /// Whether the end is as near as wanted, and the equations are satisfied along the curve.
    pub(crate) fn is_within(&self, (distance, inside): (f64, f64)) -> bool {
        self.distance <= distance && larger(largest(&self.f), self.frames) <= inside
    }
}

impl<'d, S: Homogeneous> BoundaryLeg<'d, S> {
    /// The curve with the given `x'` and `x''` at the start, and `x''' = 0`.
    pub(crate) fn new(
        space: S,
        data: &'d BoundaryData,
        derivatives: [Vec<f64>; 2],
        nodes: &Arc<LaneNodes>,
    ) -> Self {
        let (d, r, groups) = (space.dim(), space.size(), nodes.groups());
        let zeros = |count: usize| vec![0.0; count];
        let lanes = || vec![Lanes::ZERO; groups * d];
        BoundaryLeg {
            space,
            nodes: Arc::clone(nodes),
            data,
            back: (0..r * r).map(|i| data.target[i % r * r + i / r]).collect(),
            derivatives,
            f: lanes(),
            x: std::array::from_fn(|_| lanes()),
            last: std::array::from_fn(|_| zeros(d)),
            along: (0..groups).map(|_| Along::new(space)).collect(),
            frames: LaneFrames::new(space, nodes),
            wanted: zeros(d),
            residual: BoundaryResidual {
                f: lanes(),
                point: zeros(d),
                velocity: zeros(d),
                distance: f64::INFINITY,
                frames: f64::INFINITY,
            },
        }
    }

    /// Replaces `x'''` by the right-hand side for the present motion.
    pub(crate) fn smooth(&mut self) {
        self.set_motion();
        self.set_residual_of_f();
        for (f, residual) in self.f.iter_mut().zip(&self.residual.f) {
            *f -= *residual;
        }
    }

    /// Replaces `x'''` by that of the curve with the present start, up to the given residual, by Picard's iteration.
    pub(crate) fn follow(&mut self, wanted: f64) {
        for _ in 0..MOST_SWEEPS {
            self.smooth();
            let left = largest(&self.residual.f);
            if left <= wanted || !left.is_finite() {
                break;
            }
        }
    }

    /// Computes everything that follows from the unknowns; the defect of the frames will be about as small as wanted.
    pub(crate) fn evaluate(&mut self, wanted: f64) {
        self.set_motion();
        self.set_residual_of_f();
        let speed = self.speed();
        let nodes = Arc::clone(&self.nodes);
        self.residual.frames = self.frames.update(&nodes, &self.along, speed, wanted);
        self.set_residual_at_end();
    }

    /// `x, x', x''` at the start.
    pub(crate) fn start(&self) -> [&[f64]; 3] {
        start_of(self.data, &self.derivatives)
    }

    fn set_motion(&mut self) {
        let start = start_of(self.data, &self.derivatives);
        let [x, x1, x2] = &mut self.x;
        let last = self.last.each_mut().map(Vec::as_mut_slice);
        set_motion(&self.nodes, start, &self.f, [x, x1, x2], last);
    }

    fn set_residual_of_f(&mut self) {
        let (space, d, tension) = (self.space, self.space.dim(), self.data.tension);
        let groups = self
            .along
            .iter_mut()
            .zip(self.residual.f.chunks_exact_mut(d));
        for (group, (along, residual)) in groups.enumerate() {
            let x = self.x.each_ref().map(|x| &x[group * d..][..d]);
            residual.fill(Lanes::ZERO);
            vectorised(
                #[inline(always)]
                || {
                    along.set(space, x);
                    along.add_brackets(space, residual);
                },
            );
            let each = self.f[group * d..].iter().zip(x[1]);
            for (residual, (f, x1)) in residual.iter_mut().zip(each) {
                *residual = *f - (*residual + *x1 * tension);
            }
        }
    }

    /// With `u = target^T g` at the end, and its part `q` in `H`, the displacement of the end is the skew part of `q^T
    /// u` in `m`, up to the third order.
    fn set_residual_at_end(&mut self) {
        let (space, r) = (self.space, self.space.size());
        let square = r * r;
        let mut work = vec![0.0; 4 * square];
        let (u, rest) = work.split_at_mut(square);
        let (q, rest) = rest.split_at_mut(square);
        add_product_of_numbers(&self.back, &self.frames.last, r, u);
        space.isotropy_part_into(u, q);
        if space.isotropy_dim() > 0 {
            polar_factor(q, r);
        }
        let (transposed, relative) = rest.split_at_mut(square);
        for (i, entry) in transposed.iter_mut().enumerate() {
            *entry = q[i % r * r + i / r];
        }
        relative.fill(0.0);
        add_product_of_numbers(transposed, u, r, relative);
        let BoundaryResidual {
            point, velocity, ..
        } = &mut self.residual;
        space.each_entry(
            #[inline(always)]
            |p, i, j| point[p] = space.skew_coordinate(relative, [i, j]),
        );
        space.turn_back_into(q, &self.data.velocities[1], &mut self.wanted);
        for ((out, reached), wanted) in velocity.iter_mut().zip(&self.last[0]).zip(&self.wanted) {
            *out = reached - wanted;
        }
        // Points and velocities relative to the given frame, turned by `q`.
        let (reached, wanted) = (u, transposed);
        space.matrix_into(&self.last[0], reached);
        space.matrix_into(&self.wanted, wanted);
        let velocities = q;
        velocities.fill(0.0);
        add_product_of_numbers(relative, reached, r, velocities);
        let columns = columns(space);
        let mut sum = 0.0;
        for i in 0..r {
            for j in 0..columns {
                let identity = f64::from(u8::from(i == j));
                let at = i * r + j;
                sum += (relative[at] - identity).powi(2) + (velocities[at] - wanted[at]).powi(2);
            }
        }
        self.residual.distance = sum.sqrt();
    }

    pub(crate) fn tension(&self) -> f64 {
        self.data.tension
    }

    /// The largest entry of `x'` and `x''` at the nodes.
    pub(crate) fn largest_derivative(&self) -> f64 {
        larger(largest(&self.x[1]), largest(&self.x[2]))
    }

    /// The largest of the last Legendre coefficients of the frames' derivative.
    pub(crate) fn tail(&mut self) -> f64 {
        let nodes = Arc::clone(&self.nodes);
        self.frames.tail(&nodes, &self.along)
    }

    /// Number of multiplications of a product with the linearised equations.
    pub(crate) fn multiplications(&self) -> f64 {
        let (d, r) = (self.space.dim(), self.space.size());
        let sizes = [d, r, columns(self.space), self.nodes.count()];
        let [d, r, columns, count] = sizes.map(|size| size as f64);
        count * (3.0 * count * d + 2.0 * r * r * columns + 6.0 * d * r)
    }

    /// The largest velocity at a node.
    pub(crate) fn speed(&self) -> f64 {
        let d = self.space.dim();
        let mut most = 0.0;
        for x in self.x[0].chunks_exact(d) {
            let mut squares = Lanes::ZERO;
            for x in x {
                squares += *x * *x;
            }
            most = larger(most, largest(&[squares]));
        }
        most.sqrt()
    }

    /// The residuals, preconditioned.
    pub(crate) fn flat_step(&self) -> Vec<f64> {
        let mut out = vec![0.0; (2 + self.nodes.count()) * self.space.dim()];
        let residual = &self.residual;
        solve_flat(
            &self.nodes,
            &residual.f,
            &residual.point,
            &residual.velocity,
            &mut out,
        );
        out
    }

    /// The unknowns, in the order of steps.
    pub(crate) fn unknowns(&self) -> Vec<f64> {
        let f = self.f.iter().flat_map(|f| f.0);
        self.derivatives.concat().into_iter().chain(f).collect()
    }

    /// Sets the unknowns to earlier ones plus a fraction of a step.
    pub(crate) fn set_unknowns(&mut self, before: &[f64], step: &[f64], share: f64) {
        let all = before.iter().zip(step).map(|(x, step)| x + share * step);
        let derivatives = self
            .derivatives
            .iter_mut()
            .flat_map(|derivative| derivative.iter_mut());
        let f = self.f.iter_mut().flat_map(|f| f.0.iter_mut());
        for (x, now) in derivatives.chain(f).zip(all) {
            *x = now;
        }
    }

    /// The linearised equations at the curve: what the end has to reach turns with its frame.
    pub(crate) fn terms(&self) -> InSpan<S, &[Along]> {
        let frames = (self.frames.at_nodes.as_slice(), self.frames.last.as_slice());
        InSpan::new(self.space, &self.along, frames, &self.wanted)
    }

    /// The same curve on more nodes.
    pub(crate) fn on_nodes(&self, nodes: &Arc<LaneNodes>) -> Self {
        let mut out = Self::new(self.space, self.data, self.derivatives.clone(), nodes);
        out.f = self.nodes.values_at(nodes, &self.f, self.space.dim());
        out.frames = self.frames.on_nodes(&self.nodes, nodes);
        out
    }
}

fn start_of<'a>(data: &'a BoundaryData, [a, b]: &'a [Vec<f64>; 2]) -> [&'a [f64]; 3] {
    [&data.velocities[0], a, b]
}
