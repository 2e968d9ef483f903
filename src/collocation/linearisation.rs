//! The equations of a leg linearised at a few coarse nodes, in terms of its initial values.

use super::leg::Leg;
use super::nodes::{Grid, Nodes};
use crate::linalg::field::{
    Field, accumulate, factor, multiply, multiply_transposed, substitute, transposed_multiply,
};
use crate::space::Homogeneous;

/// Buffers that legs share: a leg and the derivative of its equations at the coarse nodes.
pub(super) struct Linearisation<T> {
    /// `x, x', x''` and integrals of `-F`, at the coarse nodes.
    x: [Vec<T>; 3],
    sources: [Vec<T>; 3],
    /// Of `x'` and `x` at the end.
    last_sources: [Vec<T>; 2],
    frames: Vec<T>,
    /// The derivative of the right-hand side by `x, x', x''` at a node.
    by_x: [Vec<T>; 3],
    system: Vec<T>,
    /// By `dx_0, dx_0', dx_0''` and constant: `phi`, `eta`, `x` and `x'` at the end.
    pub(super) forms: Vec<T>,
    pub(super) eta: Vec<T>,
    pub(super) last: [Vec<T>; 2],
    node: Vec<T>,
    pub(super) conditions: Vec<T>,
    pub(super) matrices: Vec<T>,
    at_nodes: Vec<T>,
}

impl<T: Field> Linearisation<T> {
    pub(super) fn new(space: impl Homogeneous, grid: &Grid) -> Self {
        let (d, h) = (space.dim(), space.isotropy_dim());
        let (count, square) = (grid.coarse.len(), space.size() * space.size());
        let zeros = |count: usize| vec![T::ZERO; count];
        let vectors = || std::array::from_fn(|_| zeros(count * d));
        let wide = 3 * d + 1;
        Linearisation {
            x: vectors(),
            sources: vectors(),
            last_sources: std::array::from_fn(|_| zeros(d)),
            frames: zeros(count * square),
            by_x: std::array::from_fn(|_| zeros(d * d)),
            system: zeros(count * d * count * d),
            forms: zeros(count * d * wide),
            eta: zeros((d + h) * wide),
            last: std::array::from_fn(|_| zeros(d * wide)),
            node: zeros(d * wide),
            conditions: zeros(4 * d * d),
            matrices: zeros(4 * square + 3 * (d + h)),
            at_nodes: zeros(grid.fine.len() * d),
        }
    }

    /// The leg and what is left of its equations at the coarse nodes.
    #[inline(always)]
    pub(super) fn interpolate(&mut self, space: impl Homogeneous, grid: &Grid, leg: &Leg<T>) {
        let (d, square) = (space.dim(), space.size() * space.size());
        let (fine, s) = (grid.fine.len(), self);
        let (v, a, b) = (&leg.velocity, &leg.acceleration, &leg.third);
        for (j, t) in grid.coarse.s.iter().enumerate() {
            for p in 0..d {
                s.x[0][j * d + p] = v[p] + (a[p] + b[p] * (0.5 * t)) * *t;
                s.x[1][j * d + p] = a[p] + b[p] * *t;
                s.x[2][j * d + p] = b[p];
            }
        }
        for (times, integral) in grid.down.iter().enumerate().skip(1) {
            accumulate(integral, fine, &leg.f, d, &mut s.x[3 - times]);
            let source = &mut s.sources[3 - times];
            source.fill(T::ZERO);
            accumulate(integral, fine, &leg.residual.f, d, source);
            negate(source);
        }
        for (source, integral) in s
            .last_sources
            .iter_mut()
            .zip([&grid.fine.at[3], &grid.fine.at[2]])
        {
            source.fill(T::ZERO);
            accumulate(&integral[fine * fine..], fine, &leg.residual.f, d, source);
            negate(source);
        }
        s.frames.fill(T::ZERO);
        accumulate(
            &grid.down[0],
            fine,
            &leg.frames[..fine * square],
            square,
            &mut s.frames,
        );
    }

    /// `phi` by `dx_0, dx_0', dx_0''` and constant.
    #[inline(always)]
    pub(super) fn solve_for_phi(&mut self, space: impl Homogeneous, grid: &Grid) {
        let (d, count) = (space.dim(), grid.coarse.len());
        let (size, wide) = (count * d, 3 * d + 1);
        let [integral, double, triple] = [1, 2, 3].map(|times| &grid.coarse.at[times]);
        for (j, t) in grid.coarse.s.iter().enumerate() {
            self.set_derivative(space, j);
            let Linearisation {
                by_x: [k0, k1, k2],
                system,
                forms,
                sources,
                ..
            } = &mut *self;
            for p in 0..d {
                let row = j * d + p;
                let [k0, k1, k2] = [&k0[p * d..][..d], &k1[p * d..][..d], &k2[p * d..][..d]];
                let system = &mut system[row * size..][..size];
                for (i, system) in system.chunks_exact_mut(d).enumerate() {
                    let at = j * count + i;
                    let (once, twice, thrice) = (integral[at], double[at], triple[at]);
                    for q in 0..d {
                        let mut sum = k0[q] * thrice + k2[q] * once;
                        if space.isotropy_dim() > 0 {
                            sum += k1[q] * twice;
                        }
                        system[q] = -sum;
                    }
                }
                system[row] += T::constant(1.0);
                let forms = &mut forms[row * wide..][..wide];
                let mut constant = T::ZERO;
                for q in 0..d {
                    forms[q] = k0[q];
                    forms[d + q] = k0[q] * *t + k1[q];
                    forms[2 * d + q] = k0[q] * (0.5 * t * t) + k1[q] * *t + k2[q];
                    let [x, x1, x2] = sources.each_ref().map(|source| source[j * d + q]);
                    constant += k0[q] * x;
                    constant += k1[q] * x1;
                    constant += k2[q] * x2;
                }
                forms[3 * d] = constant;
            }
        }
        let Linearisation { system, forms, .. } = &mut *self;
        factor(size, system);
        substitute(size, system, wide, forms);
    }

    /// The derivative of the right-hand side by `x, x', x''` at a coarse node, shape `(d, d)` each.
    #[inline(always)]
    fn set_derivative(&mut self, space: impl Homogeneous, node: usize) {
        let (d, h, square) = (
            space.dim(),
            space.isotropy_dim(),
            space.size() * space.size(),
        );
        let Linearisation {
            x,
            by_x: [k0, k1, k2],
            matrices,
            ..
        } = &mut *self;
        let (x0, rest) = matrices.split_at_mut(square);
        let (x1, rest) = rest.split_at_mut(square);
        let (x2, rest) = rest.split_at_mut(square);
        let (direction, rest) = rest.split_at_mut(square);
        let (column, rest) = rest.split_at_mut(d);
        let (other, rest) = rest.split_at_mut(d);
        let (isotropy, turning) = rest.split_at_mut(h);
        for (matrix, x) in [&mut *x0, &mut *x1, &mut *x2].into_iter().zip(x) {
            space.matrix_into(&x[node * d..], matrix);
        }
        if h > 0 {
            space.isotropy_bracket_into(x0, x1, turning);
        }
        for q in 0..d {
            column.fill(T::ZERO);
            column[q] = T::constant(1.0);
            space.matrix_into(column, direction);
            space.bracket_into(direction, x0, column);
            write_column(k2, d, q, column);
            space.bracket_into(x2, direction, column);
            if h == 0 {
                write_column(k0, d, q, column);
                continue;
            }
            space.isotropy_bracket_into(direction, x1, isotropy);
            space.act_into(isotropy, x0, other);
            subtract(column, other);
            space.act_into(turning, direction, other);
            subtract(column, other);
            write_column(k0, d, q, column);
            space.isotropy_bracket_into(x0, direction, isotropy);
            space.act_into(isotropy, x0, other);
            negate(other);
            write_column(k1, d, q, other);
        }
    }

    /// `eta` at the end by `dx_0, dx_0', dx_0''` and constant, coordinates of `m` before those of `h`.
    #[inline(always)]
    pub(super) fn set_eta(&mut self, space: impl Homogeneous, grid: &Grid, leg: &Leg<T>) {
        let (d, r, count) = (space.dim(), space.size(), grid.coarse.len());
        let (square, wide) = (r * r, 3 * d + 1);
        let end = &leg.frames[grid.fine.len() * square..];
        let Linearisation {
            frames,
            forms,
            eta,
            node,
            matrices,
            ..
        } = &mut *self;
        eta.fill(T::ZERO);
        let turn = &mut matrices[..square];
        for (j, t) in grid.coarse.s.iter().enumerate() {
            // dx at the node.
            node.fill(T::ZERO);
            for p in 0..d {
                node[p * wide + p] = T::constant(1.0);
                node[p * wide + d + p] = T::constant(*t);
                node[p * wide + 2 * d + p] = T::constant(0.5 * t * t);
            }
            let triple = &grid.coarse.at[3][j * count..][..count];
            accumulate(triple, count, forms, d * wide, node);
            transposed_multiply(r, end, &frames[j * square..], turn);
            let weight = grid.coarse.weights[j];
            add_turned(space, turn, weight, node, wide, eta);
        }
        self.add_source_of_eta(space, &grid.fine, leg);
    }

    /// What `-F` does to `eta`, by all nodes.
    #[inline(always)]
    fn add_source_of_eta(&mut self, space: impl Homogeneous, nodes: &Nodes, leg: &Leg<T>) {
        let (d, r, count) = (space.dim(), space.size(), nodes.len());
        let (square, wide) = (r * r, 3 * d + 1);
        let Linearisation {
            at_nodes,
            matrices,
            eta,
            ..
        } = &mut *self;
        at_nodes.fill(T::ZERO);
        let triple = &nodes.at[3][..count * count];
        accumulate(triple, count, &leg.residual.f, d, at_nodes);
        let (matrix, rest) = matrices.split_at_mut(square);
        let (product, rest) = rest.split_at_mut(square);
        let sum = &mut rest[..square];
        sum.fill(T::ZERO);
        let each = at_nodes
            .chunks_exact(d)
            .zip(leg.frames.chunks_exact(square));
        for ((x, frame), weight) in each.zip(&nodes.weights) {
            space.matrix_into(x, matrix);
            multiply(r, frame, matrix, product);
            multiply_transposed(r, product, frame, matrix);
            for (sum, x) in sum.iter_mut().zip(&*matrix) {
                *sum -= *x * *weight;
            }
        }
        let end = &leg.frames[count * square..];
        transposed_multiply(r, end, sum, product);
        multiply(r, product, end, matrix);
        space.each_entry(
            #[inline(always)]
            |p, i, j| eta[p * wide + 3 * d] += matrix[i * r + j],
        );
        space.each_isotropy_entry(
            #[inline(always)]
            |p, i, j| eta[(d + p) * wide + 3 * d] += matrix[i * r + j],
        );
    }

    /// Changes of `x - Ad_q^{-1} v` and of `Ad_q x'`, turned back, at the end: by `dx_0, dx_0', dx_0''` and constant.
    #[inline(always)]
    pub(super) fn set_last(&mut self, space: impl Homogeneous, grid: &Grid, leg: &Leg<T>) {
        let (d, h, count) = (space.dim(), space.isotropy_dim(), grid.coarse.len());
        let (square, wide, fine) = (space.size() * space.size(), 3 * d + 1, grid.fine.len());
        let Linearisation {
            last,
            last_sources,
            forms,
            eta,
            matrices,
            ..
        } = &mut *self;
        for (order, last) in last.iter_mut().enumerate() {
            last.fill(T::ZERO);
            for p in 0..d {
                let row = &mut last[p * wide..][..wide];
                if order == 0 {
                    row[p] = T::constant(1.0);
                    row[d + p] = T::constant(1.0);
                    row[2 * d + p] = T::constant(0.5);
                } else {
                    row[d + p] = T::constant(1.0);
                    row[2 * d + p] = T::constant(1.0);
                }
                row[3 * d] = last_sources[order][p];
            }
            let integral = &grid.coarse.at[3 - order][count * count..];
            accumulate(integral, count, forms, d * wide, last);
            if h == 0 {
                continue;
            }
            // The frame that is reached turns by the part of eta in h.
            let (matrix, rest) = matrices.split_at_mut(square);
            let (isotropy, rest) = rest.split_at_mut(h);
            let turned = &mut rest[..d];
            let vector = match order {
                0 => &leg.wanted_velocity[..],
                _ => &leg.x[1][fine * d..],
            };
            space.matrix_into(vector, matrix);
            for column in 0..wide {
                for (p, z) in isotropy.iter_mut().enumerate() {
                    *z = eta[(d + p) * wide + column];
                }
                space.act_into(isotropy, matrix, turned);
                for (p, x) in turned.iter().enumerate() {
                    last[p * wide + column] += *x;
                }
            }
        }
    }
}

/// `eta += weight Ad_turn dx` for every column of `dx`, shape `(d, columns)`.
#[inline(always)]
fn add_turned<T: Field, S: Homogeneous>(
    space: S,
    turn: &[T],
    weight: f64,
    dx: &[T],
    columns: usize,
    eta: &mut [T],
) {
    let d = space.dim();
    space.each_entry(
        #[inline(always)]
        |p, i, j| {
            add_turned_entry(
                space,
                turn,
                weight,
                dx,
                [i, j],
                &mut eta[p * columns..][..columns],
            )
        },
    );
    space.each_isotropy_entry(
        #[inline(always)]
        |p, i, j| {
            let out = &mut eta[(d + p) * columns..][..columns];
            add_turned_entry(space, turn, weight, dx, [i, j], out);
        },
    );
}

/// The same for entry `(i, j)` of the skew matrix.
#[inline(always)]
fn add_turned_entry<T: Field, S: Homogeneous>(
    space: S,
    turn: &[T],
    weight: f64,
    dx: &[T],
    [i, j]: [usize; 2],
    out: &mut [T],
) {
    let (r, columns) = (space.size(), out.len());
    space.each_entry(
        #[inline(always)]
        |q, a, b| {
            // Of Ad_turn (E_ab - E_ba).
            let entry = turn[i * r + a] * turn[j * r + b] - turn[i * r + b] * turn[j * r + a];
            let entry = entry * weight;
            for (out, dx) in out.iter_mut().zip(&dx[q * columns..][..columns]) {
                *out += entry * *dx;
            }
        },
    );
}

#[inline(always)]
pub(super) fn write_column<T: Field>(out: &mut [T], columns: usize, column: usize, entries: &[T]) {
    for (row, entry) in out.chunks_exact_mut(columns).zip(entries) {
        row[column] = *entry;
    }
}

#[inline(always)]
fn subtract<T: Field>(to: &mut [T], from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to -= *from;
    }
}

#[inline(always)]
fn negate<T: Field>(values: &mut [T]) {
    for value in values {
        *value = -*value;
    }
}
