//! A cubic between given points and velocities: its fourth derivative at Gauss nodes, and everything that follows from it.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::clamped::{Clamped, LEVELS};
use super::embedded_equation::{Embedded, EquationBuffers};
use crate::collocation::lane_matrices::polar_factor;
use crate::linalg::field::{add, larger, largest};
use crate::linalg::lanes::Lanes;
use crate::linalg::product::mul_into;
use crate::space::{Kind, Quotient};

/// What a fourth derivative adds to the second derivatives at the ends, at most.
const TO_SECOND: f64 = 1.0 / 12.0;

/// One leg. Matrices have `k` columns of `r` coordinates each, one column after another; embedded complex ones are given by
/// the first half of their columns.
#[derive(Debug, Clone)]
pub(crate) struct ClampedLeg {
    /// Sizes, and the tension in the time of the leg.
    pub(crate) equation: Embedded,
    pub(crate) nodes: Arc<Clamped>,
    /// `S(0), S'(0), S(1), S'(1)` as they are given.
    given: [Vec<f64>; LEVELS],
    /// The same with the basis that the leg reaches; and for subspaces, the matrix that turns the given basis to it, shape
    /// `(k, k)` in row-major order.
    pub(crate) data: [Vec<f64>; LEVELS],
    turn: Vec<f64>,
    /// The fourth derivative at the nodes.
    pub(crate) f: Vec<Lanes>,
}

/// Buffers of a sweep, for legs of any size.
#[derive(Debug, Clone, Default)]
pub(crate) struct ClampedScratch {
    /// `S, S', S'', S'''` at the nodes.
    s: [Vec<Lanes>; LEVELS],
    /// The fourth derivative by the equation.
    image: Vec<Lanes>,
    buffers: EquationBuffers,
}

impl ClampedLeg {
    /// A leg at rest.
    pub(crate) fn new([r, k]: [usize; 2], kind: Kind, tension: f64, nodes: &Arc<Clamped>) -> Self {
        let equation = Embedded {
            r,
            k,
            kind,
            tension,
            gram: None,
        };
        let size = equation.size();
        let data = || std::array::from_fn(|_| vec![0.0; size]);
        ClampedLeg {
            equation,
            nodes: Arc::clone(nodes),
            given: data(),
            data: data(),
            turn: (0..k * k)
                .map(|i| f64::from(u8::from(i % (k + 1) == 0)))
                .collect(),
            f: vec![Lanes::ZERO; nodes.groups() * size],
        }
    }

    /// Gives point and velocity at both ends.
    pub(crate) fn set_data(&mut self, data: [&[f64]; LEVELS]) {
        for (given, data) in self.given.iter_mut().zip(data) {
            given.copy_from_slice(data);
        }
        self.turn_data();
    }

    /// Gives points and velocities at both ends, shape `(n, 2k)` with velocities per unit of time, for a leg of duration `h`
    /// whose coordinates belong to the columns of these data.
    pub(crate) fn set_gram(&mut self, pairs: [&Mat<f64>; 2], h: f64) {
        let (r, k) = (self.equation.r, self.equation.k);
        let gram = self.equation.gram.get_or_insert_with(|| vec![0.0; r * r]);
        write_gram(pairs, h, gram);
        for (i, given) in self.given.iter_mut().enumerate() {
            for j in 0..self.equation.stored() {
                given[j * r + i * k + j] = 1.0;
            }
        }
        self.turn_data();
    }

    fn turn_data(&mut self) {
        let (equation, turn, k) = (&self.equation, &self.turn, self.equation.k);
        for (i, (data, given)) in self.data.iter_mut().zip(&self.given).enumerate() {
            match equation.kind.quotient == Quotient::Frames || i < 2 {
                true => data.copy_from_slice(given),
                false => turned_into(equation, given, |l, j| turn[l * k + j], data),
            }
        }
    }

    /// Replaces the fourth derivative by that of the equation, and for subspaces the basis at the end by the one which a
    /// horizontal curve reaches. Returns the change, as second derivatives at the ends feel it.
    pub(crate) fn sweep(&mut self, scratch: &mut ClampedScratch) -> f64 {
        let ClampedScratch { s, image, buffers } = scratch;
        let equation = &self.equation;
        let (k, size) = (equation.k, equation.size());
        for all in s.iter_mut().chain([&mut *image]) {
            all.resize(self.f.len(), Lanes::ZERO);
        }
        buffers.resize(equation);
        let data = self.data.each_ref().map(Vec::as_slice);
        self.nodes.derivatives_into(data, &self.f, s);
        let mut drift = vec![0.0; k * k];
        let groups = image.chunks_exact_mut(size).zip(&self.nodes.nodes.weights);
        for (group, (image, weights)) in groups.enumerate() {
            let s = s.each_ref().map(|s| &s[group * size..][..size]);
            equation.fourth_derivative_into(s, buffers, image);
            if equation.kind.quotient == Quotient::Subspaces {
                let products = equation.product([s[0], s[1]], buffers);
                for (drift, product) in drift.iter_mut().zip(products) {
                    *drift += (*product * *weights).sum();
                }
            }
        }
        let mut change = 0.0;
        for (f, image) in self.f.iter().zip(&*image) {
            change = larger(change, largest(&[*f - *image]));
        }
        std::mem::swap(&mut self.f, image);
        change *= TO_SECOND;
        if self.equation.kind.quotient == Quotient::Subspaces {
            change = larger(change, self.turn_by(&drift));
        }
        change
    }

    /// Sets the basis in which the given point at the end is reached, the given one times a matrix.
    pub(crate) fn set_turn(&mut self, turn: MatRef<'_, f64>) {
        let k = self.equation.k;
        for (i, entry) in self.turn.iter_mut().enumerate() {
            *entry = turn[(i / k, i % k)];
        }
        self.turn_data();
    }

    /// For subspaces, what turns the given basis at the end to the one that the leg reaches.
    pub(crate) fn turn(&self) -> Option<Mat<f64>> {
        let k = self.equation.k;
        let turn = || MatRef::from_row_major_slice(&self.turn, k, k).to_owned();
        (self.equation.kind.quotient == Quotient::Subspaces).then(turn)
    }

    /// Turns the basis at the end against its drift; returns the largest entry.
    fn turn_by(&mut self, drift: &[f64]) -> f64 {
        let k = self.equation.k;
        let before = self.turn.clone();
        let mut most = 0.0;
        for i in 0..k {
            for j in 0..k {
                // Entry `(l, j)` of the skew part.
                let turned =
                    |l: usize| before[i * k + l] * 0.5 * (drift[l * k + j] - drift[j * k + l]);
                let change: f64 = (0..k).map(turned).sum();
                self.turn[i * k + j] -= change;
                most = larger(most, change.abs());
            }
        }
        polar_factor(&mut self.turn, k);
        self.turn_data();
        most
    }

    /// `S, S', S'', S'''` at the nodes.
    pub(crate) fn derivatives(&self) -> [Vec<Lanes>; LEVELS] {
        let mut out = std::array::from_fn(|_| vec![Lanes::ZERO; self.f.len()]);
        let data = self.data.each_ref().map(Vec::as_slice);
        self.nodes.derivatives_into(data, &self.f, &mut out);
        out
    }

    /// How far the curve is from the manifold: the largest entry of `S^T S - 1` at the nodes, and for subspaces of `S^T V`.
    ///
    /// A solution of the equation for `S''''` between points of the manifold need not stay there.
    pub(crate) fn defect(&self, scratch: &mut ClampedScratch) -> f64 {
        let k = self.equation.k;
        scratch.buffers.resize(&self.equation);
        let [points, velocities, ..] = self.derivatives();
        let size = self.equation.size();
        let mut most = 0.0;
        for (s, v) in points.chunks_exact(size).zip(velocities.chunks_exact(size)) {
            let products = self.equation.product([s, s], &mut scratch.buffers);
            for (i, product) in products.iter().enumerate() {
                let identity = Lanes::splat(f64::from(u8::from(i % (k + 1) == 0)));
                most = larger(most, largest(&[*product - identity]));
            }
            if self.equation.kind.quotient == Quotient::Subspaces {
                most = larger(
                    most,
                    largest(self.equation.product([s, v], &mut scratch.buffers)),
                );
            }
        }
        most
    }

    /// The second (0) or third (1) derivative at an end.
    pub(crate) fn at_end(&self, end: usize, which: usize, out: &mut [f64]) {
        let data = self.data.each_ref().map(Vec::as_slice);
        self.nodes.at_end(end, which, data, &self.f, out);
    }

    /// The second derivative at the end in the given basis.
    pub(crate) fn turn_back(&self, x: &mut [f64]) {
        if self.equation.kind.quotient == Quotient::Frames {
            return;
        }
        let (turn, k, before) = (&self.turn, self.equation.k, x.to_vec());
        turned_into(&self.equation, &before, |l, j| turn[j * k + l], x);
    }

    /// The same leg on other nodes.
    pub(crate) fn on_nodes(&self, nodes: &Arc<Clamped>) -> Self {
        let Embedded {
            r,
            k,
            kind,
            tension,
            ..
        } = self.equation;
        let mut out = Self::new([r, k], kind, tension, nodes);
        out.given.clone_from(&self.given);
        out.data.clone_from(&self.data);
        out.turn.clone_from(&self.turn);
        out.equation.gram.clone_from(&self.equation.gram);
        let size = self.equation.size();
        out.f = self.nodes.nodes.values_at(&nodes.nodes, &self.f, size);
        out
    }

    /// The largest of the last two Legendre coefficients of the fourth derivative.
    pub(crate) fn tail(&self) -> f64 {
        self.nodes.nodes.largest_tail(&self.f, self.equation.size())
    }

    /// The largest entry of the fourth derivative.
    pub(crate) fn largest(&self) -> f64 {
        largest(&self.f)
    }

    /// The largest velocity at a node.
    pub(crate) fn largest_speed(&self) -> f64 {
        let [_, velocities, ..] = self.derivatives();
        let mut most = 0.0;
        for v in velocities.chunks_exact(self.equation.size()) {
            most = larger(most, largest(&[self.equation.square(v)]));
        }
        most.sqrt()
    }

    /// Number of multiplications of a sweep.
    pub(crate) fn multiplications(&self) -> f64 {
        let sizes = [
            self.equation.r,
            self.equation.k,
            self.equation.stored(),
            self.nodes.count(),
        ];
        let [r, k, stored, count] = sizes.map(|size| size as f64);
        let gram = if self.equation.gram.is_some() {
            3.0 * r * r * stored
        } else {
            0.0
        };
        count * (4.0 * count * r * stored + 11.0 * r * k * stored + gram)
    }
}

/// `out = x turn`, for the entries of a square matrix.
fn turned_into(
    equation: &Embedded,
    x: &[f64],
    turn: impl Fn(usize, usize) -> f64,
    out: &mut [f64],
) {
    let (r, all) = (equation.r, equation.all_columns(x));
    for (j, out) in out.chunks_exact_mut(r).enumerate() {
        out.fill(0.0);
        for (l, column) in all.chunks_exact(r).enumerate() {
            add(out, turn(l, j), column);
        }
    }
}

/// Products of the columns `S_0, h V_0, S_1, h V_1`.
fn write_gram(pairs: [&Mat<f64>; 2], h: f64, gram: &mut [f64]) {
    let size = pairs[0].ncols();
    let (r, mut product) = (2 * size, Mat::zeros(size, size));
    let factor = |i: usize| if i < size / 2 { 1.0 } else { h };
    for (row, col) in [(0, 0), (1, 1), (0, 1)] {
        mul_into(&mut product, 1.0, pairs[row].transpose(), pairs[col]);
        for j in 0..size {
            for i in 0..size {
                let entry = product[(i, j)] * (factor(i) * factor(j));
                gram[(row * size + i) * r + col * size + j] = entry;
                gram[(col * size + j) * r + row * size + i] = entry;
            }
        }
    }
}
