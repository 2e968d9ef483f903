//! The linearised equations of a cubic between given ends, preconditioned by those of flat space, and their transpose.
//!
//! The changes `a, b` of `x', x''` at the start and `phi` of `x'''` at the nodes change `x, x', x''` by `w, w', w''`,
//! and displace the end by `zeta`, as [`Terms`] says. The linearised equations are `phi` minus the derivative of the
//! right-hand side, `zeta_m` for the point, and `w(1) + [zeta_h, v]` for the velocity `v` at the end. In flat space
//! their solution is known; the rest is a smoothing operator, so that GMRES takes few products.

use super::linear_terms::Terms;
use crate::collocation::lane_nodes::LaneNodes;
use crate::collocation::motion::{flat_transposed, motion_transposed, set_motion, solve_flat};
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;

/// Selects an operator or its transpose.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Way {
    Forward,
    Transposed,
}

/// The operator, with buffers.
pub(crate) struct Operator<'a> {
    terms: &'a dyn Terms,
    nodes: &'a LaneNodes,
    tension: f64,
    /// `phi`, what the equations make of it, and `w, w', w''` at the nodes.
    f: Vec<Lanes>,
    image: Vec<Lanes>,
    x: [Vec<Lanes>; 3],
    /// The sum of what is transported to the end, by lanes and in all.
    sum: Vec<Lanes>,
    arrived: Vec<f64>,
    /// The displacement of the end, and the change of its velocity; `w` at the start. In the transpose gradients with
    /// respect to these, and to `w', w''` at the start.
    end: [Vec<f64>; 2],
    start: [Vec<f64>; 3],
    buffer: Vec<Lanes>,
}

impl<'a> Operator<'a> {
    pub(crate) fn new(terms: &'a dyn Terms, nodes: &'a LaneNodes, tension: f64) -> Self {
        let size = terms.dim() * nodes.groups();
        let zeros = |count: usize| vec![Lanes::ZERO; count];
        Operator {
            terms,
            nodes,
            tension,
            f: zeros(size),
            image: zeros(size),
            x: std::array::from_fn(|_| zeros(size)),
            sum: zeros(terms.transported()),
            arrived: vec![0.0; terms.transported()],
            end: [vec![0.0; terms.dim()], vec![0.0; terms.dim()]],
            start: std::array::from_fn(|_| vec![0.0; terms.dim()]),
            buffer: zeros(terms.buffer()),
        }
    }

    /// Number of coordinates of a vector.
    pub(crate) fn dim(&self) -> usize {
        self.terms.dim()
    }

    /// Number of unknowns: `a, b`, then `phi` by groups of nodes.
    fn size(&self) -> usize {
        (2 + self.nodes.count()) * self.terms.dim()
    }

    /// The linearised equations or their transpose, preconditioned.
    pub(crate) fn apply(&mut self, y: &[f64], out: &mut [f64], way: Way) {
        vectorised(
            #[inline(always)]
            || self.apply_inlined(y, out, way),
        );
    }

    #[inline(always)]
    fn apply_inlined(&mut self, y: &[f64], out: &mut [f64], way: Way) {
        let d = self.terms.dim();
        match way {
            Way::Forward => {
                self.respond(None, y);
                let [point, velocity] = &self.end;
                solve_flat(self.nodes, &self.image, point, velocity, out);
            }
            Way::Transposed => {
                self.respond_transposed(y);
                let [_, a, b] = &self.start;
                out[..d].copy_from_slice(a);
                out[d..2 * d].copy_from_slice(b);
                write_numbers(&self.image, &mut out[2 * d..]);
            }
        }
    }

    /// The preconditioned right-hand side for the displacement `u` and the change `w` of the velocity at the start and
    /// at the end.
    pub(crate) fn right_hand_side(&mut self, [u0, w0, u1, w1]: [&[f64]; 4]) -> Vec<f64> {
        self.respond(Some([u0, w0]), &vec![0.0; self.size()]);
        for (found, wanted) in self.end.iter_mut().zip([u1, w1]) {
            for (found, wanted) in found.iter_mut().zip(wanted) {
                *found = wanted - *found;
            }
        }
        let [point, velocity] = &self.end;
        self.image.iter_mut().for_each(|x| *x = -*x);
        let mut out = vec![0.0; self.size()];
        solve_flat(self.nodes, &self.image, point, velocity, &mut out);
        out
    }

    /// The gradient with respect to `(u_0, w_0, u_1, w_1)` of a function of the solution, from the solution of the
    /// transposed equations.
    pub(crate) fn right_hand_side_transposed(&mut self, y: &[f64]) -> [Vec<f64>; 4] {
        self.respond_transposed(y);
        let [mut velocity, ..] = self.start.clone();
        let mut point = self.projected_to_start(&self.arrived.clone());
        for x in point.iter_mut().chain(&mut velocity) {
            *x = -*x;
        }
        let [by_point, by_velocity] = self.end.clone();
        [point, velocity, by_point, by_velocity]
    }

    /// The displacements at the nodes, one node after another, by that of the start and the change of the velocity
    /// there.
    pub(crate) fn displacements(&mut self, start: [&[f64]; 2], y: &[f64]) -> Vec<f64> {
        let (terms, d, size) = (self.terms, self.terms.dim(), self.terms.transported());
        self.set_vectors(Some(start[1]), y);
        let groups = self.nodes.groups();
        let mut rates = vec![Lanes::ZERO; groups * size];
        for (group, rate) in rates.chunks_exact_mut(size).enumerate() {
            let w = &self.x[0][group * d..][..d];
            terms.add_transported(group, (Lanes::ONE, w), &mut self.buffer, rate);
            terms.complete(rate);
        }
        let first = self.transported_start(start[0]);
        let mut moved: Vec<Lanes> = first.iter().copied().cycle().take(rates.len()).collect();
        self.nodes.add_integrals(1, &rates, size, &mut moved);
        let mut out = vec![0.0; self.nodes.count() * d];
        let mut found = vec![Lanes::ZERO; d];
        for (group, z) in moved.chunks_exact(size).enumerate() {
            found.fill(Lanes::ZERO);
            terms.add_projected(group, (Lanes::ONE, z), &mut self.buffer, &mut found);
            let at_nodes = out.chunks_exact_mut(d).skip(group * LANES);
            for (lane, out) in at_nodes.take(LANES).enumerate() {
                for (out, x) in out.iter_mut().zip(&found) {
                    *out = x.0[lane];
                }
            }
        }
        out
    }

    /// The transpose of [`displacements`](Operator::displacements): the gradients with respect to the start and to `y`.
    pub(crate) fn displacements_transposed(
        &mut self,
        by_displacements: &[f64],
    ) -> ([Vec<f64>; 2], Vec<f64>) {
        let (terms, d, size) = (self.terms, self.terms.dim(), self.terms.transported());
        let groups = self.nodes.groups();
        let mut loads = vec![Lanes::ZERO; groups * size];
        let mut gradient = vec![Lanes::ZERO; d];
        for (group, load) in loads.chunks_exact_mut(size).enumerate() {
            let at_nodes = &by_displacements[group * LANES * d..];
            for (p, x) in gradient.iter_mut().enumerate() {
                *x = Lanes(std::array::from_fn(|lane| at_nodes[lane * d + p]));
            }
            terms.add_transported(group, (Lanes::ONE, &gradient), &mut self.buffer, load);
            terms.complete(load);
        }
        let mut total = vec![0.0; size];
        for load in loads.chunks_exact(size) {
            for (total, x) in total.iter_mut().zip(load) {
                *total += x.sum();
            }
        }
        let mut rates = vec![Lanes::ZERO; groups * size];
        self.nodes
            .add_transposed_integrals(1, &loads, size, &mut rates);
        self.x.iter_mut().for_each(|x| x.fill(Lanes::ZERO));
        for (group, rate) in rates.chunks_exact(size).enumerate() {
            let out = &mut self.x[0][group * d..][..d];
            terms.add_projected(group, (Lanes::ONE, rate), &mut self.buffer, out);
        }
        self.image.fill(Lanes::ZERO);
        let x = self.x.each_ref().map(Vec::as_slice);
        let start = self.start.each_mut().map(Vec::as_mut_slice);
        motion_transposed(self.nodes, x, &vec![0.0; d], &mut self.image, start);
        let [w, a, b] = self.start.clone();
        let mut y = [a, b, vec![0.0; self.nodes.count() * d]].concat();
        write_numbers(&self.image, &mut y[2 * d..]);
        ([self.projected_to_start(&total), w], y)
    }

    /// Sets the equations, the displacement of the end and the change of its velocity, for the unknowns and for `u` and
    /// `w` at the start, which are zero if not given.
    #[inline(always)]
    fn respond(&mut self, start: Option<[&[f64]; 2]>, y: &[f64]) {
        let (terms, d) = (self.terms, self.terms.dim());
        self.set_vectors(start.map(|[_, w]| w), y);
        self.sum.fill(Lanes::ZERO);
        for group in 0..self.nodes.groups() {
            let at = group * d;
            let x = self.x.each_ref().map(|x| &x[at..][..d]);
            let change = &mut self.image[at..][..d];
            change.fill(Lanes::ZERO);
            terms.add_change(group, x, &mut self.buffer, change);
            for ((change, f), x1) in change.iter_mut().zip(&self.f[at..]).zip(x[1]) {
                *change = *f - (*change + *x1 * self.tension);
            }
            let weighted = (self.nodes.weights[group], x[0]);
            terms.add_transported(group, weighted, &mut self.buffer, &mut self.sum);
        }
        terms.complete(&mut self.sum);
        for (z, sum) in self.arrived.iter_mut().zip(&self.sum) {
            *z = sum.sum();
        }
        if let Some([u, _]) = start {
            let first = self.transported_start(u);
            for (z, first) in self.arrived.iter_mut().zip(first) {
                *z += first.0[0];
            }
        }
        let [point, velocity] = &mut self.end;
        terms.arrive(&self.arrived, point, velocity);
    }

    /// The transpose of `respond`, with that of the equations of flat space: the gradients with respect to the end, to
    /// what is transported there, to `w, w', w''` at the start, and in `image` to `phi`.
    #[inline(always)]
    fn respond_transposed(&mut self, y: &[f64]) {
        let (terms, d) = (self.terms, self.terms.dim());
        let [by_point, by_velocity] = &mut self.end;
        flat_transposed(self.nodes, y, &mut self.f, [by_point, by_velocity]);
        terms.arrive_transposed([by_point, by_velocity], &mut self.arrived);
        for (lanes, x) in self.sum.iter_mut().zip(&self.arrived) {
            *lanes = Lanes::splat(*x);
        }
        for group in 0..self.nodes.groups() {
            let at = group * d;
            let f = &self.f[at..][..d];
            let [w, a, b] = self.x.each_mut().map(|x| &mut x[at..][..d]);
            for x in [&mut *w, &mut *a, &mut *b] {
                x.fill(Lanes::ZERO);
            }
            terms.add_change_transposed(group, f, &mut self.buffer, [&mut *w, &mut *a, &mut *b]);
            for (a, f) in a.iter_mut().zip(f) {
                *a += *f * self.tension;
            }
            for x in w.iter_mut().chain(a).chain(b) {
                *x = -*x;
            }
            let weighted = (self.nodes.weights[group], self.sum.as_slice());
            terms.add_projected(group, weighted, &mut self.buffer, w);
        }
        self.image.copy_from_slice(&self.f);
        let x = self.x.each_ref().map(Vec::as_slice);
        let start = self.start.each_mut().map(Vec::as_mut_slice);
        motion_transposed(self.nodes, x, by_velocity, &mut self.image, start);
    }

    /// Sets `phi`, `w, w', w''` at the nodes, and `w` at the end.
    #[inline(always)]
    fn set_vectors(&mut self, first: Option<&[f64]>, y: &[f64]) {
        let d = self.terms.dim();
        let (a, rest) = y.split_at(d);
        let (b, phi) = rest.split_at(d);
        for (lanes, numbers) in self.f.iter_mut().zip(phi.chunks_exact(LANES)) {
            lanes.0.copy_from_slice(numbers);
        }
        let ([_, velocity], [start, ..]) = (&mut self.end, &mut self.start);
        match first {
            Some(first) => start.copy_from_slice(first),
            None => start.fill(0.0),
        }
        let x = self.x.each_mut().map(Vec::as_mut_slice);
        set_motion(self.nodes, [start, a, b], &self.f, x, [velocity]);
    }

    /// The displacement of the start, transported to the end; the same in all lanes.
    fn transported_start(&mut self, u: &[f64]) -> Vec<Lanes> {
        let u: Vec<Lanes> = u.iter().map(|x| Lanes::splat(*x)).collect();
        let mut out = vec![Lanes::ZERO; self.terms.transported()];
        let last = self.nodes.groups();
        self.terms
            .add_transported(last, (Lanes::ONE, &u), &mut self.buffer, &mut out);
        self.terms.complete(&mut out);
        out
    }

    /// Its transpose.
    fn projected_to_start(&mut self, z: &[f64]) -> Vec<f64> {
        let z: Vec<Lanes> = z.iter().map(|x| Lanes::splat(*x)).collect();
        let mut out = vec![Lanes::ZERO; self.terms.dim()];
        let last = self.nodes.groups();
        self.terms
            .add_projected(last, (Lanes::ONE, &z), &mut self.buffer, &mut out);
        out.iter().map(|x| x.0[0]).collect()
    }
}

#[inline(always)]
fn write_numbers(lanes: &[Lanes], out: &mut [f64]) {
    for (out, lanes) in out.chunks_exact_mut(LANES).zip(lanes) {
        out.copy_from_slice(&lanes.0);
    }
}
