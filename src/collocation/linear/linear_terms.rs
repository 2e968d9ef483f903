//! The terms by which the linearised equations of a cubic differ from those of a curve at rest, at Gauss nodes.
//!
//! A variation is described by the displacement `p = (g^{-1} dg)_m` of the point, and by the changes `w, a, b` of `x, x', x''`
//! relative to the rotation of the whole space that displaces the point. They satisfy
//!
//! ```math
//! \begin{aligned}
//! p' &= w + [p, x]_m, \qquad w' = a + [[p, x]_h, x], \qquad a' = b + [[p, x]_h, x'], \\
//! b' &= [b, x]_m + [x'', w]_m - [[w, x']_h + [x, a]_h, x] - [[x, x']_h, w] + \tau a + [[p, x]_h, x'']
//! \end{aligned}
//! ```
//!
//! In a row outside the span of the curve, where the curve is zero, the entries of `p, w, a, b` are rows of length `k`, and
//!
//! ```math
//! \begin{aligned}
//! p' &= w + p\,\omega, \qquad w' = a - p\,b_x^T b_x, \qquad a' = b - p\,b_x^T b_x', \\
//! b' &= b\,\omega + w\,({b_x'}^T b_x - \omega'') + a\,(\tau - b_x^T b_x) - p\,b_x^T b_x''
//! \end{aligned}
//! ```
//!
//! with the blocks `omega` and `b_x` of `x`; for subspaces with `w (2 b_x'^T b_x - b_x^T b_x')` instead.
//!
//! # Source
//! Derived here, by differentiating `g' = g x` and the equation of cubics in the frame of the curve.

use crate::collocation::along::Along;
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::space::{Homogeneous, Quotient, Shape, in_space};

/// Number of vectors that describe a variation at one time: `p, w, a, b`.
pub(crate) const LEVELS: usize = 4;

/// Selects an operator or its transpose.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Way {
    Forward,
    Transposed,
}

impl Way {
    pub(crate) fn inverse(self) -> Self {
        match self {
            Way::Forward => Way::Transposed,
            Way::Transposed => Way::Forward,
        }
    }
}

/// The terms at groups of eight nodes, as linear functions of `p, w, a, b`, one after another.
pub(crate) trait Terms: Send + Sync {
    /// Number of coordinates of each vector.
    fn dim(&self) -> usize;

    /// Number of eights of numbers that `set` needs as a buffer.
    fn buffer(&self) -> usize;

    /// Sets the terms, or what their transpose gives.
    fn set(&self, group: usize, way: Way, y: &[Lanes], buffer: &mut [Lanes], out: &mut [Lanes]);
}

/// The terms for variations in the span, from coordinates of `x, x', x''` at the nodes, one node after another; the
/// number of nodes is a multiple of eight.
pub(crate) fn in_span(shape: Shape, x: [&[f64]; 3], tension: f64) -> Box<dyn Terms> {
    in_space!(shape, |space| Box::new(InSpan::new(space, x, tension)))
}

/// The terms in the span of the curve.
struct InSpan<S> {
    space: S,
    groups: Vec<Along>,
    tension: f64,
}

impl<S: Homogeneous> InSpan<S> {
    fn new(space: S, x: [&[f64]; 3], tension: f64) -> Self {
        let d = space.dim();
        let group = |group: usize| {
            let vectors = x.map(|x| {
                let entry = |p: usize, lane: usize| x[(group * LANES + lane) * d + p];
                let vector = (0..d).map(|p| Lanes(std::array::from_fn(|lane| entry(p, lane))));
                vector.collect::<Vec<_>>()
            });
            let mut along = Along::new(space);
            along.set(space, vectors.each_ref().map(Vec::as_slice));
            along
        };
        InSpan {
            space,
            groups: (0..x[0].len() / (d * LANES)).map(group).collect(),
            tension,
        }
    }

    /// The terms, from the matrices of `p, w, a, b`; `z` holds an element of `h`.
    #[inline(always)]
    fn forward(
        &self,
        along: &Along,
        [p, w, a, b]: [&[Lanes]; LEVELS],
        z: &mut [Lanes],
        [by_p, by_w, by_a, by_b]: [&mut [Lanes]; LEVELS],
    ) {
        let (space, [x, x1, x2]) = (self.space, &along.x);
        if !space.is_symmetric() {
            space.add_bracket(p, x, 1.0, by_p);
        }
        if space.isotropy_dim() > 0 {
            z.fill(Lanes::ZERO);
            space.add_isotropy_bracket(p, x, -1.0, z);
            space.subtract_action(z, x, by_w);
            space.subtract_action(z, x1, by_a);
            space.subtract_action(z, x2, by_b);
        }
        along.add_change(space, [w, a, b], z, by_b);
    }

    /// The transpose: `<[p, x], q> = <p, [x, q]>`.
    #[inline(always)]
    fn transposed(
        &self,
        Along { x, turning }: &Along,
        [p, w, a, b]: [&[Lanes]; LEVELS],
        z: &mut [Lanes],
        [by_p, by_w, by_a, by_b]: [&mut [Lanes]; LEVELS],
    ) {
        let (space, [x, x1, x2]) = (self.space, x);
        if !space.is_symmetric() {
            space.add_bracket(x, p, 1.0, by_p);
            space.add_bracket(x, b, 1.0, by_b);
            space.add_bracket(b, x2, 1.0, by_w);
        }
        if space.isotropy_dim() > 0 {
            z.fill(Lanes::ZERO);
            space.add_isotropy_bracket(x, w, 1.0, z);
            space.add_isotropy_bracket(x1, a, 1.0, z);
            space.add_isotropy_bracket(x2, b, 1.0, z);
            space.subtract_action(z, x, by_p);
            z.fill(Lanes::ZERO);
            space.add_isotropy_bracket(x, b, 1.0, z);
            space.subtract_action(z, x, by_a);
            z.fill(Lanes::ZERO);
            space.add_isotropy_bracket(x, b, -1.0, z);
            space.subtract_action(z, x1, by_w);
            space.subtract_action(&turning[1], b, by_w);
        }
    }
}

impl<S: Homogeneous> Terms for InSpan<S> {
    fn dim(&self) -> usize {
        self.space.dim()
    }

    fn buffer(&self) -> usize {
        LEVELS * self.space.size().pow(2) + self.space.isotropy_dim()
    }

    fn set(&self, group: usize, way: Way, y: &[Lanes], buffer: &mut [Lanes], out: &mut [Lanes]) {
        vectorised(
            #[inline(always)]
            || {
                let (d, square) = (self.space.dim(), self.space.size().pow(2));
                let (matrices, z) = buffer.split_at_mut(LEVELS * square);
                for (matrix, vector) in matrices.chunks_exact_mut(square).zip(y.chunks_exact(d)) {
                    self.space.matrix_into(vector, matrix);
                }
                out.fill(Lanes::ZERO);
                let (along, y_matrices) = (&self.groups[group], levels(square, matrices));
                let [.., a, b] = levels(d, y);
                match way {
                    Way::Forward => {
                        self.forward(along, y_matrices, z, levels_mut(d, out));
                        add(&mut out[3 * d..], self.tension, a);
                    }
                    Way::Transposed => {
                        self.transposed(along, y_matrices, z, levels_mut(d, out));
                        add(&mut out[2 * d..], self.tension, b);
                    }
                }
            },
        );
    }
}

/// The terms in a row outside the span.
struct InRow {
    k: usize,
    /// For eight nodes each, the matrices of [`PAIRS`], shape `(k, k)`, which multiply rows from the right.
    groups: Vec<[Vec<Lanes>; 7]>,
}

/// For each matrix of [`InRow`], the levels of the vector that it multiplies and of the term.
const PAIRS: [[usize; 2]; 7] = [[0, 0], [0, 1], [0, 2], [0, 3], [1, 3], [2, 3], [3, 3]];

/// The terms for a row outside the span, from the blocks of `x, x', x''` at the nodes, one node after another: `omega`,
/// then `b`, in column-major order; `r` rows in total.
pub(crate) fn in_row(shape: Shape, x: [&[f64]; 3], tension: f64) -> Box<dyn Terms> {
    let Shape { r, k, kind } = shape;
    let size = r * k;
    let node = |node: usize| {
        let [x, x1, x2] = x.map(|x| &x[node * size..][..size]);
        let omega = |x: &[f64], i: usize, j: usize| x[i + k * j];
        let product = |x: &[f64], y: &[f64], i: usize, j: usize| -> f64 {
            let [x, y] = [(x, i), (y, j)].map(|(x, i)| &x[k * k + (r - k) * i..][..r - k]);
            x.iter().zip(y).map(|(x, y)| x * y).sum()
        };
        let turned = f64::from(u8::from(kind.quotient == Quotient::Subspaces));
        let identity = |i: usize, j: usize| f64::from(u8::from(i == j));
        let entry = |which: usize, i: usize, j: usize| match which {
            0 | 6 => omega(x, i, j),
            1 => -product(x, x, i, j),
            2 => -product(x, x1, i, j),
            3 => -product(x, x2, i, j),
            4 => {
                let turning = product(x1, x, i, j) - product(x, x1, i, j);
                product(x1, x, i, j) - omega(x2, i, j) + turned * turning
            }
            _ => tension * identity(i, j) - product(x, x, i, j),
        };
        let matrix = |which: usize| -> Vec<f64> {
            let entries = (0..k * k).map(|at| entry(which, at / k, at % k));
            entries.collect()
        };
        std::array::from_fn::<_, 7, _>(matrix)
    };
    let nodes: Vec<[Vec<f64>; 7]> = (0..x[0].len() / size).map(node).collect();
    let group = |nodes: &[[Vec<f64>; 7]]| {
        std::array::from_fn(|which| {
            let entry = |at: usize| Lanes(std::array::from_fn(|lane| nodes[lane][which][at]));
            (0..k * k).map(entry).collect()
        })
    };
    let groups = nodes.chunks_exact(LANES).map(group).collect();
    Box::new(InRow { k, groups })
}

impl Terms for InRow {
    fn dim(&self) -> usize {
        self.k
    }

    fn buffer(&self) -> usize {
        0
    }

    fn set(&self, group: usize, way: Way, y: &[Lanes], _: &mut [Lanes], out: &mut [Lanes]) {
        let k = self.k;
        vectorised(
            #[inline(always)]
            || {
                out.fill(Lanes::ZERO);
                for (matrix, [from, to]) in self.groups[group].iter().zip(PAIRS) {
                    for (at, entry) in matrix.iter().enumerate() {
                        let (row, column) = (from * k + at / k, to * k + at % k);
                        match way {
                            Way::Forward => out[column] += y[row] * *entry,
                            Way::Transposed => out[row] += y[column] * *entry,
                        }
                    }
                }
            },
        );
    }
}

/// The parts of the given size.
fn levels<T>(size: usize, all: &[T]) -> [&[T]; LEVELS] {
    std::array::from_fn(|level| &all[level * size..][..size])
}

fn levels_mut<T>(size: usize, all: &mut [T]) -> [&mut [T]; LEVELS] {
    let (p, rest) = all.split_at_mut(size);
    let (w, rest) = rest.split_at_mut(size);
    let (a, b) = rest.split_at_mut(size);
    [p, w, a, b]
}

#[inline(always)]
fn add(sum: &mut [Lanes], factor: f64, other: &[Lanes]) {
    for (sum, x) in sum.iter_mut().zip(other) {
        *sum += *x * factor;
    }
}
