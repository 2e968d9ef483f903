//! The curve of a solved boundary value problem as polynomials in powers of the time from its middle.
//!
//! `x` is the third integral of `x'''`, and the points `S = g e` of `k` columns `e` of the identity are the fourth
//! integral of
//!
//! ```math
//! S^{(j)} = g\,M_j\,e,\qquad M_1 = x,\qquad M_{j+1} = x\,M_j + M_j'
//! ```
//!
//! so that third derivatives are first integrals. As integrals of `S'`, they had errors of 1e-9 to 1e-8 at the ends.

use super::boundary_leg::BoundaryLeg;
use crate::collocation::embedded::chain::TAIL;
use crate::collocation::expansion::{EXACT, NodeExpansion, add_cubic};
use crate::collocation::linear::linear_terms::columns;
use crate::legs::{Dense, Polynomials};
use crate::linalg::field::{Field, accumulate};
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::space::Homogeneous;

/// The polynomials relative to the frame at the start; `None` for curves that need too many nodes, or whose fourth
/// derivative is not resolved.
pub(crate) fn boundary_curve<S: Homogeneous>(leg: &BoundaryLeg<'_, S>) -> Option<Dense> {
    let (space, nodes) = (leg.space, &leg.nodes.nodes);
    let d = space.dim();
    if nodes.len() > EXACT {
        return None;
    }
    let expansion = NodeExpansion::of(nodes);
    let start = leg.start();
    let mut x = expansion.third_integrals(&node_by_node(&leg.f, d), d);
    // The quadratic part about the middle.
    for p in 0..d {
        let [v, a, b] = start.map(|x| x[p]);
        x[p] += v + 0.5 * (a + 0.25 * b);
        x[d + p] += a + 0.5 * b;
        x[2 * d + p] += 0.5 * b;
    }
    let last = leg.last.each_ref().map(Vec::as_slice);
    let ends = [start, last].concat();
    let mut dense = Dense::new(1, nodes.len() + 1, space, columns(space));
    dense.write(
        0,
        &Polynomials {
            x: &x,
            frames: &points(leg, &expansion)?,
            ends: std::array::from_fn(|i| ends[i]),
            last_frame: &leg.frames.last,
        },
    );
    Some(dense)
}

/// Coefficients of the points, each in row-major order.
fn points<S: Homogeneous>(leg: &BoundaryLeg<'_, S>, expansion: &NodeExpansion) -> Option<Vec<f64>> {
    let (space, d) = (leg.space, leg.space.dim());
    let (r, k) = (space.size(), columns(space));
    let size = r * k;
    let mut fourth = vec![Lanes::ZERO; leg.along.len() * size];
    let mut third = vec![Lanes::ZERO; r * r];
    let frames = leg.frames.at_nodes.chunks_exact(r * r);
    let each = leg.f.chunks_exact(d).zip(&leg.along).zip(frames);
    for (((f, along), frame), out) in each.zip(fourth.chunks_exact_mut(size)) {
        space.matrix_into(f, &mut third);
        let [x, x1, x2] = along.x.each_ref().map(Vec::as_slice);
        vectorised(
            #[inline(always)]
            || {
                let [.., relative] = derivatives([x, x1, x2, &third], r, k);
                accumulate(frame, r, &relative, k, out);
            },
        );
    }
    if leg.nodes.largest_tail(&fourth, size) > TAIL {
        return None;
    }
    let mut out = expansion.fourth_integrals(&node_by_node(&fourth, size), size);
    let mut matrices = [(); 4].map(|()| vec![0.0; r * r]);
    for (matrix, x) in matrices.iter_mut().zip(leg.start()) {
        space.matrix_into(x, matrix);
    }
    let [v, second, third, _] = derivatives(matrices.each_ref().map(Vec::as_slice), r, k);
    let mut s = vec![0.0; size];
    for i in 0..k {
        s[i * k + i] = 1.0;
    }
    add_cubic([&s, &v, &second, &third], &mut out);
    Some(out)
}

/// `M_1 e, ..., M_4 e`, shape `(r, k)`, from the matrices of `x, x', x'', x'''`.
#[inline(always)]
fn derivatives<T: Field>(x: [&[T]; 4], r: usize, k: usize) -> [Vec<T>; 4] {
    let [x, x1, x2, x3] = x;
    let first = |a: &[T]| -> Vec<T> {
        let rows = a.chunks_exact(r).flat_map(|row| &row[..k]);
        rows.copied().collect()
    };
    // `out + a b`.
    let plus = |mut out: Vec<T>, a: &[T], b: &[T]| -> Vec<T> {
        accumulate(a, r, b, k, &mut out);
        out
    };
    // Rates: of `M_1`, and then of `M_2` and `M_3`.
    let [m1, rate, rate2] = [x, x1, x2].map(first);
    let m2 = plus(rate.clone(), x, &m1);
    let m2_rate = plus(plus(rate2.clone(), x, &rate), x1, &m1);
    let m2_rate2 = plus(plus(first(x3), x, &rate2), x2, &m1);
    let m2_rate2 = plus(plus(m2_rate2, x1, &rate), x1, &rate);
    let m3 = plus(m2_rate.clone(), x, &m2);
    let m3_rate = plus(plus(m2_rate2, x, &m2_rate), x1, &m2);
    let m4 = plus(m3_rate, x, &m3);
    [m1, m2, m3, m4]
}

/// Values of several functions at all nodes, from groups of eight.
fn node_by_node(values: &[Lanes], functions: usize) -> Vec<f64> {
    let groups = values.chunks_exact(functions.max(1));
    let nodes = groups.flat_map(|group| (0..LANES).map(move |lane| (group, lane)));
    nodes
        .flat_map(|(group, lane)| group.iter().map(move |x| x.0[lane]))
        .collect()
}

#[cfg(test)]
mod tests {
    use faer::{MatRef, Scale};

    use super::*;

    /// The fourth derivative is the formula of docs/mathematics.md, and lower ones those of its recurrence written out.
    #[test]
    fn derivatives_are_those_of_the_formula() {
        for (r, k) in [(2, 1), (3, 3), (5, 2), (7, 7)] {
            let matrices = [1.0, 1.7, 2.9, 4.3].map(|seed: f64| {
                let entries: Vec<f64> = (0..r * r)
                    .map(|i| (seed * (i as f64 + 1.3)).sin())
                    .collect();
                entries
            });
            let found = derivatives(matrices.each_ref().map(Vec::as_slice), r, k);
            let [x, a, b, f] = matrices
                .each_ref()
                .map(|x| MatRef::from_row_major_slice(x, r, r));
            let square = x * x;
            let second = &square + a;
            let third = &square * x + x * a * Scale(2.0) + a * x + b;
            let fourth = &square * &square
                + &square * a * Scale(3.0)
                + x * a * x * Scale(2.0)
                + a * &square
                + x * b * Scale(3.0)
                + a * a * Scale(3.0)
                + b * x
                + f;
            for (found, exact) in found.iter().zip([x.to_owned(), second, third, fourth]) {
                let found = MatRef::from_row_major_slice(found, r, k);
                let error = (found - exact.subcols(0, k)).norm_max();
                // Sums of r^3 products of four entries up to one.
                let bound = 4.0 * (r as f64).powi(4) * f64::EPSILON;
                assert!(error <= bound, "({r}, {k}): {error:.1e}");
            }
        }
    }
}
