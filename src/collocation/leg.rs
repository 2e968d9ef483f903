//! A leg of a chain: its unknowns at the nodes, and the residuals of its equations.

use crate::curve::nodes::Nodes;
use crate::linalg::field::{
    Field, accumulate, larger, largest, multiply, multiply_transposed, set_identity,
    transposed_multiply,
};
use crate::space::{Homogeneous, orthonormalise};

/// One leg, or eight of them, in the time in which it takes one unit.
///
/// Frames are relative to the frame of the knot where the leg starts, matrices in row-major order. Vectors are
/// coordinates in the frame reached, except for `last_velocity` and `last_acceleration`, which are in the frame of the
/// next knot.
pub(super) struct Leg<T> {
    /// The next knot's frame.
    pub(super) target: Vec<T>,
    /// `x` at the start, and the required value of `x` at the end.
    pub(super) velocity: Vec<T>,
    pub(super) last_velocity: Vec<T>,
    /// Tension of the curve; `None` for a cubic.
    pub(super) tension: Option<T>,
    /// `x'` and `x''` at the start.
    pub(super) acceleration: Vec<T>,
    pub(super) third: Vec<T>,
    /// `x'''` at the nodes.
    pub(super) f: Vec<T>,
    /// Frames at the nodes and at the end.
    pub(super) frames: Vec<T>,
    /// `x, x', x''` at the nodes and at the end.
    pub(super) x: [Vec<T>; 3],
    pub(super) residual: Residual<T>,
    /// The isometry between the frame reached and the frame of the next knot.
    pub(super) holonomy: Vec<T>,
    /// `last_velocity` in the frame reached.
    pub(super) wanted_velocity: Vec<T>,
    pub(super) last_acceleration: Vec<T>,
}

/// The residuals of a leg's equations.
pub(super) struct Residual<T> {
    /// `f` minus the right-hand side at the nodes.
    pub(super) f: Vec<T>,
    /// Defect of the frames before their last correction.
    frames: Vec<T>,
    /// Displacement of the end from the next knot.
    pub(super) point: Vec<T>,
    /// The velocity defect at the end.
    pub(super) velocity: Vec<T>,
    /// The largest entry.
    pub(super) size: f64,
}

/// Buffers shared by all legs.
#[derive(Clone)]
pub(super) struct Scratch<T> {
    /// One matrix per node, and one for the end.
    rates: Vec<T>,
    corrections: Vec<T>,
    matrices: Vec<T>,
    vector: Vec<T>,
}

impl<T: Field> Scratch<T> {
    pub(super) fn new(space: impl Homogeneous, nodes: usize) -> Self {
        let (d, square) = (space.dim(), space.size() * space.size());
        let zeros = |count: usize| vec![T::ZERO; count];
        Scratch {
            rates: zeros((nodes + 1) * square),
            corrections: zeros((nodes + 1) * square),
            matrices: zeros(2 * square + space.isotropy_dim() + d),
            vector: zeros(d),
        }
    }
}

impl<T: Field> Leg<T> {
    /// A leg at rest, with the given number of nodes.
    pub(super) fn new(space: impl Homogeneous, nodes: usize) -> Self {
        let (d, r) = (space.dim(), space.size());
        let zeros = |count: usize| vec![T::ZERO; count];
        let square = r * r;
        let mut frames = zeros((nodes + 1) * square);
        for frame in frames.chunks_exact_mut(square) {
            set_identity(r, frame);
        }
        Leg {
            target: zeros(square),
            velocity: zeros(d),
            last_velocity: zeros(d),
            tension: None,
            acceleration: zeros(d),
            third: zeros(d),
            f: zeros(nodes * d),
            frames,
            x: std::array::from_fn(|_| zeros((nodes + 1) * d)),
            residual: Residual {
                f: zeros(nodes * d),
                frames: zeros((nodes + 1) * square),
                point: zeros(d),
                velocity: zeros(d),
                size: f64::INFINITY,
            },
            holonomy: zeros(square),
            wanted_velocity: zeros(d),
            last_acceleration: zeros(d),
        }
    }

    /// Computes `x, x', x''` at the nodes and at the end from the unknowns.
    #[inline(always)]
    pub(super) fn set_motion(&mut self, space: impl Homogeneous, nodes: &Nodes) {
        let d = space.dim();
        let (v, a, b) = (&self.velocity, &self.acceleration, &self.third);
        let [x, x1, x2] = &mut self.x;
        for (j, s) in nodes.s.iter().chain(&[1.0]).enumerate() {
            for p in 0..d {
                x[j * d + p] = v[p] + (a[p] + b[p] * (0.5 * s)) * *s;
                x1[j * d + p] = a[p] + b[p] * *s;
                x2[j * d + p] = b[p];
            }
        }
        for (x, integral) in self.x.iter_mut().zip(nodes.at.iter().rev()) {
            accumulate(integral, nodes.len(), &self.f, d, x);
        }
    }

    /// One step of Picard's iteration for the frames, `g <- 1 + int g x`, for large defects.
    #[inline(always)]
    pub(super) fn sweep_frames(
        &mut self,
        space: impl Homogeneous,
        nodes: &Nodes,
        scratch: &mut Scratch<T>,
    ) {
        self.set_defect(space, nodes, scratch);
        for (frame, defect) in self.frames.iter_mut().zip(&self.residual.frames) {
            *frame += *defect;
        }
    }

    /// One Newton step for the frames. With the defect `e = 1 + int g x - g`, and `g` as the fundamental matrix, `g <-
    /// g + e + (int e x g^T) g`.
    #[inline(always)]
    pub(super) fn correct_frames(
        &mut self,
        space: impl Homogeneous,
        nodes: &Nodes,
        scratch: &mut Scratch<T>,
    ) {
        self.set_defect(space, nodes, scratch);
        let (r, d) = (space.size(), space.dim());
        let square = r * r;
        let Scratch {
            rates,
            corrections,
            matrices,
            ..
        } = scratch;
        let (matrix, product) = matrices[..2 * square].split_at_mut(square);
        let at_nodes = self.residual.frames.chunks_exact(square);
        let each = at_nodes
            .zip(self.frames.chunks_exact(square))
            .zip(self.x[0].chunks_exact(d));
        for (rate, ((defect, frame), x)) in rates.chunks_exact_mut(square).zip(each) {
            space.matrix_into(x, matrix);
            multiply(r, defect, matrix, product);
            multiply_transposed(r, product, frame, rate);
        }
        corrections.fill(T::ZERO);
        accumulate(&nodes.at[1], nodes.len(), rates, square, corrections);
        let all = corrections
            .chunks_exact(square)
            .zip(self.residual.frames.chunks_exact(square))
            .zip(self.frames.chunks_exact_mut(square));
        for ((correction, defect), frame) in all {
            multiply(r, correction, frame, product);
            for ((frame, defect), product) in frame.iter_mut().zip(defect).zip(&*product) {
                *frame += *defect + *product;
            }
        }
    }

    /// `e = 1 + int g x - g` at the nodes and at the end.
    #[inline(always)]
    fn set_defect(&mut self, space: impl Homogeneous, nodes: &Nodes, scratch: &mut Scratch<T>) {
        let (r, d) = (space.size(), space.dim());
        let square = r * r;
        let matrix = &mut scratch.matrices[..square];
        let rates = &mut scratch.rates;
        let frames = self
            .frames
            .chunks_exact(square)
            .zip(self.x[0].chunks_exact(d));
        for (rate, (frame, x)) in rates.chunks_exact_mut(square).zip(frames) {
            space.matrix_into(x, matrix);
            multiply(r, frame, matrix, rate);
        }
        let defects = self.residual.frames.chunks_exact_mut(square);
        for (defect, frame) in defects.zip(self.frames.chunks_exact(square)) {
            set_identity(r, defect);
            for (defect, frame) in defect.iter_mut().zip(frame) {
                *defect -= *frame;
            }
        }
        accumulate(
            &nodes.at[1],
            nodes.len(),
            rates,
            square,
            &mut self.residual.frames,
        );
    }

    /// Replaces `f` by the right-hand side.
    #[inline(always)]
    pub(super) fn smooth(
        &mut self,
        space: impl Homogeneous,
        nodes: &Nodes,
        scratch: &mut Scratch<T>,
    ) {
        self.set_residual_of_f(space, nodes, scratch);
        for (f, residual) in self.f.iter_mut().zip(&self.residual.f) {
            *f -= *residual;
        }
        self.set_motion(space, nodes);
    }

    #[inline(always)]
    fn set_residual_of_f(
        &mut self,
        space: impl Homogeneous,
        nodes: &Nodes,
        scratch: &mut Scratch<T>,
    ) {
        let d = space.dim();
        for j in 0..nodes.len() {
            let x = self.x.each_ref().map(|x| &x[j * d..][..d]);
            let (work, out) = (&mut scratch.matrices, &mut scratch.vector);
            space.third_derivative_into(x, work, out);
            if let Some(tension) = self.tension {
                for (out, x) in out.iter_mut().zip(x[1]) {
                    *out += tension * *x;
                }
            }
            for p in 0..d {
                self.residual.f[j * d + p] = self.f[j * d + p] - out[p];
            }
        }
    }

    /// Computes the residuals for the current motion and frames.
    #[inline(always)]
    pub(super) fn set_residual(
        &mut self,
        space: impl Homogeneous,
        nodes: &Nodes,
        scratch: &mut Scratch<T>,
    ) {
        self.set_residual_of_f(space, nodes, scratch);
        let (r, d) = (space.size(), space.dim());
        let (square, count) = (r * r, nodes.len());
        // With u = target^T g at the end, and its part q in H, the displacement of the end is the logarithm of q^T u.
        let u = &mut scratch.corrections[..square];
        transposed_multiply(r, &self.target, &self.frames[count * square..], u);
        space.isotropy_part_into(u, &mut self.holonomy);
        if space.isotropy_dim() > 0 {
            orthonormalise(r, &mut self.holonomy, &mut scratch.matrices);
        }
        let relative = &mut scratch.matrices[..square];
        transposed_multiply(r, &self.holonomy, u, relative);
        space.each_entry(
            #[inline(always)]
            |p, i, j| self.residual.point[p] = space.skew_coordinate(relative, [i, j]),
        );
        space.turn_back_into(
            &self.holonomy,
            &self.last_velocity,
            &mut self.wanted_velocity,
        );
        for p in 0..d {
            self.residual.velocity[p] = self.x[0][count * d + p] - self.wanted_velocity[p];
        }
        let reached = &self.x[1][count * d..];
        space.turn_into(&self.holonomy, reached, &mut self.last_acceleration);
        self.residual.size = self.largest_residual();
    }

    /// The largest residual; NaN is propagated.
    #[inline(always)]
    fn largest_residual(&self) -> f64 {
        let Residual {
            f,
            frames,
            point,
            velocity,
            ..
        } = &self.residual;
        let equations = larger(larger(largest(f), largest(point)), largest(velocity));
        larger(equations, largest(frames))
    }

    /// The largest entry of the last two Legendre coefficients of `g'`: if it is round-off, so is the truncation error
    /// of the polynomials.
    #[inline(always)]
    pub(super) fn tail(
        &mut self,
        space: impl Homogeneous,
        nodes: &Nodes,
        scratch: &mut Scratch<T>,
    ) -> f64 {
        self.set_defect(space, nodes, scratch);
        let (count, square) = (nodes.len(), space.size() * space.size());
        let tail = &mut scratch.corrections[..2 * square];
        tail.fill(T::ZERO);
        accumulate(
            &nodes.tail,
            count,
            &scratch.rates[..count * square],
            square,
            tail,
        );
        largest(tail)
    }

    /// The largest velocity at a node.
    #[inline(always)]
    pub(super) fn speed(&self, space: impl Homogeneous) -> f64 {
        let squares = self.x[0].chunks_exact(space.dim()).map(|x| {
            let mut sum = T::ZERO;
            for x in x {
                sum += *x * *x;
            }
            sum.value()
        });
        squares.fold(0.0, larger).sqrt()
    }

    /// Sets frames without rotation.
    #[inline(always)]
    pub(super) fn reset_frames(&mut self, space: impl Homogeneous) {
        let r = space.size();
        for frame in self.frames.chunks_exact_mut(r * r) {
            set_identity(r, frame);
        }
    }

    /// Largest defect of the frames before their last correction.
    #[inline(always)]
    pub(super) fn largest_defect_of_frames(&self) -> f64 {
        largest(&self.residual.frames)
    }

    /// The same leg on other nodes: values and first integrals of the polynomials through the old nodes, at the new
    /// ones.
    #[inline(always)]
    pub(super) fn on_nodes(
        &mut self,
        space: impl Homogeneous,
        [from, to]: [&Nodes; 2],
        [values, integral]: [&[f64]; 2],
        scratch: &mut Scratch<T>,
    ) -> Self {
        let (d, square) = (space.dim(), space.size() * space.size());
        let mut out = Leg::new(space, to.len());
        out.target.copy_from_slice(&self.target);
        out.velocity.copy_from_slice(&self.velocity);
        out.last_velocity.copy_from_slice(&self.last_velocity);
        out.acceleration.copy_from_slice(&self.acceleration);
        out.third.copy_from_slice(&self.third);
        out.tension = self.tension;
        let count = from.len();
        accumulate(values, count, &self.f, d, &mut out.f);
        // g = 1 + int g x.
        self.set_defect(space, from, scratch);
        for frame in out.frames.chunks_exact_mut(square) {
            set_identity(space.size(), frame);
        }
        let rates = &scratch.rates[..count * square];
        accumulate(integral, count, rates, square, &mut out.frames);
        out.set_motion(space, to);
        out
    }
}
