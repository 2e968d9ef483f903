//! The linearised equations of a cubic between given ends, preconditioned by those of flat space.
//!
//! The changes `a, b` of `x', x''` at the start and `phi` of `x'''` at the nodes change `x, x', x''` by `w, w', w''`, and
//! the end by
//!
//! ```math
//! \zeta = \int_0^1 \operatorname{Ad}_{g(1)^{-1} g} w\, ds
//! ```
//!
//! in the frame reached there. The linearised equations are `phi` minus the derivative of the right-hand side, `zeta_m`
//! for the point, and `w(1) + [zeta_h, v]` for the velocity, with the wanted velocity `v` in the frame reached.

use super::boundary_leg::{BoundaryLeg, columns, set_motion};
use crate::collocation::lane_matrices::{add_product, times_transposed};
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::space::Homogeneous;

/// The operator at a curve.
pub(crate) struct BoundaryLinear<'l, 'd, S> {
    leg: &'l BoundaryLeg<'d, S>,
    /// Frames at the nodes relative to the one at the end, and their leading columns, times the weights.
    relative: Vec<Lanes>,
    weighted: Vec<Lanes>,
    /// The skew matrix of the wanted velocity.
    wanted: Vec<f64>,
    lengths: Vec<usize>,
    /// `phi`, its image, and `w, w', w''` at the nodes and at the end.
    f: Vec<Lanes>,
    image: Vec<Lanes>,
    x: [Vec<Lanes>; 3],
    last: [Vec<f64>; 3],
    matrices: Vec<Lanes>,
    buffer: Vec<Lanes>,
}

impl<'l, 'd, S: Homogeneous> BoundaryLinear<'l, 'd, S> {
    pub(crate) fn new(leg: &'l BoundaryLeg<'d, S>) -> Self {
        let (space, groups) = (leg.space, leg.nodes.groups());
        let (d, r) = (space.dim(), space.size());
        let (square, columns) = (r * r, columns(space));
        let zeros = |count: usize| vec![Lanes::ZERO; count];
        let mut relative = zeros(groups * square);
        let back: Vec<Lanes> = (0..square)
            .map(|i| Lanes::splat(leg.frames.last[i % r * r + i / r]))
            .collect();
        let frames = leg.frames.at_nodes.chunks_exact(square);
        for (frame, out) in frames.zip(relative.chunks_exact_mut(square)) {
            add_product(&back, frame, r, out);
        }
        let mut weighted = zeros(groups * r * columns);
        let parts = relative.chunks_exact(square).zip(&leg.nodes.weights);
        for ((frame, weight), out) in parts.zip(weighted.chunks_exact_mut(r * columns)) {
            for (row, out) in frame.chunks_exact(r).zip(out.chunks_exact_mut(columns)) {
                for (out, x) in out.iter_mut().zip(row) {
                    *out = *x * *weight;
                }
            }
        }
        let mut wanted = vec![0.0; square];
        space.matrix_into(&leg.wanted, &mut wanted);
        BoundaryLinear {
            leg,
            relative,
            weighted,
            wanted,
            lengths: vec![r; columns],
            f: zeros(groups * d),
            image: zeros(groups * d),
            x: std::array::from_fn(|_| zeros(groups * d)),
            last: std::array::from_fn(|_| vec![0.0; d]),
            matrices: zeros(3 * square),
            buffer: zeros(space.isotropy_dim() + 2 * r * columns + square),
        }
    }

    /// The linearised equations, preconditioned.
    pub(crate) fn apply(&mut self, y: &[f64], out: &mut [f64]) {
        let leg = self.leg;
        let (space, d, r) = (leg.space, leg.space.dim(), leg.space.size());
        let (square, columns) = (r * r, columns(space));
        let (a, rest) = y.split_at(d);
        let (b, phi) = rest.split_at(d);
        for (lanes, numbers) in self.f.iter_mut().zip(phi.chunks_exact(LANES)) {
            lanes.0.copy_from_slice(numbers);
        }
        let [x, x1, x2] = &mut self.x;
        let last = self.last.each_mut().map(Vec::as_mut_slice);
        set_motion(
            &leg.nodes,
            [&vec![0.0; d], a, b],
            &self.f,
            [x, x1, x2],
            last,
        );
        let (z, rest) = self.buffer.split_at_mut(space.isotropy_dim());
        let (lower, rest) = rest.split_at_mut(r * columns);
        let (turned, sum) = rest.split_at_mut(r * columns);
        sum.fill(Lanes::ZERO);
        for (group, along) in leg.along.iter().enumerate() {
            let at = group * d;
            let mut matrices = self.matrices.chunks_exact_mut(square);
            for x in &self.x {
                space.matrix_into(&x[at..][..d], matrices.next().unwrap_or_default());
            }
            let (w, rest) = self.matrices.split_at(square);
            let (w1, w2) = rest.split_at(square);
            let change = &mut self.image[at..][..d];
            change.fill(Lanes::ZERO);
            vectorised(
                #[inline(always)]
                || along.add_change(space, [w, w1, w2], z, change),
            );
            let each = self.f[at..].iter().zip(&self.x[1][at..]);
            for (change, (f, x1)) in change.iter_mut().zip(each) {
                *change = *f - (*change + *x1 * leg.tension());
            }
            // `Ad_h w` is twice the skew part of `h y h^T`, for the part `y` of `w` below the diagonal.
            for (j, out) in lower.chunks_exact_mut(r).enumerate() {
                for (i, out) in out.iter_mut().enumerate() {
                    *out = if i > j { w[i * r + j] } else { Lanes::ZERO };
                }
            }
            times_transposed(
                &self.relative[group * square..][..square],
                lower,
                r,
                &self.lengths,
                turned,
            );
            let weighted = &self.weighted[group * r * columns..][..r * columns];
            add_rows(turned, weighted, columns, r, sum);
        }
        let total: Vec<f64> = sum.iter().map(|sum| sum.0.iter().sum()).collect();
        let mut point = vec![0.0; d];
        space.each_entry(|p, i, j| point[p] = 2.0 * space.skew_coordinate(&total, [i, j]));
        let mut isotropy = vec![0.0; space.isotropy_dim()];
        space.each_isotropy_entry(|p, i, j| {
            isotropy[p] = -2.0 * space.skew_coordinate(&total, [i, j])
        });
        let mut velocity = self.last[0].clone();
        if space.isotropy_dim() > 0 {
            space.subtract_action(&isotropy, &self.wanted, &mut velocity);
        }
        precondition(leg, &self.image, &point, &velocity, out);
    }
}

impl<S: Homogeneous> BoundaryLeg<'_, S> {
    /// The residuals, preconditioned.
    pub(crate) fn flat_step(&self) -> Vec<f64> {
        let mut out = vec![0.0; (2 + self.nodes.count()) * self.space.dim()];
        let residual = &self.residual;
        precondition(
            self,
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
}

/// `out += a b^T` for `a` and `b` of shape `(r, columns)`.
fn add_rows(a: &[Lanes], b: &[Lanes], columns: usize, r: usize, out: &mut [Lanes]) {
    vectorised(
        #[inline(always)]
        || {
            for (a, out) in a.chunks_exact(columns).zip(out.chunks_exact_mut(r)) {
                for (b, out) in b.chunks_exact(columns).zip(out) {
                    let mut sum = *out;
                    for (a, b) in a.iter().zip(b) {
                        sum += *a * *b;
                    }
                    *out = sum;
                }
            }
        },
    );
}

/// The solution of the equations of flat space for `phi`, for the displacement and for the velocity of the end.
fn precondition<S: Homogeneous>(
    leg: &BoundaryLeg<'_, S>,
    f: &[Lanes],
    point: &[f64],
    velocity: &[f64],
    out: &mut [f64],
) {
    let (d, nodes) = (leg.space.dim(), &leg.nodes);
    let mut at_end = [vec![0.0; d], vec![0.0; d]];
    let [by_point, by_velocity] = &mut at_end;
    nodes.add_integrals_to_end(3, f, d, by_velocity);
    // The integral of the third integral: `(1 - s)^3 / 6` times the function.
    for ((f, s), weight) in f.chunks_exact(d).zip(&nodes.s).zip(&nodes.weights) {
        let left = Lanes::ONE - *s;
        let factor = left * left * left * *weight * (1.0 / 6.0);
        for (sum, f) in by_point.iter_mut().zip(f) {
            *sum += (*f * factor).0.iter().sum::<f64>();
        }
    }
    let (a, rest) = out.split_at_mut(d);
    let (b, phi) = rest.split_at_mut(d);
    for i in 0..d {
        let (p, q) = (point[i] - by_point[i], velocity[i] - by_velocity[i]);
        a[i] = 6.0 * p - 2.0 * q;
        b[i] = 6.0 * q - 12.0 * p;
    }
    for (phi, f) in phi.chunks_exact_mut(LANES).zip(f) {
        phi.copy_from_slice(&f.0);
    }
}
