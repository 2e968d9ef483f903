//! The linearised boundary value problem along a cubic on `[0, 1]`, and its transpose.
//!
//! Let `R` map `y = (p, w, a, b)` to the [terms](super::linear_terms) with brackets and tension, and let `G` solve `p' = w`,
//! `w' = a`, `a' = b`, `b' = 0` with such terms as sources, for `p` and `w` that vanish at both ends. If `y_0` is the cubic
//! polynomial with given `p` and `w` at the ends, then
//!
//! ```math
//! y = y_0 + G R\,y
//! ```
//!
//! an equation of the second kind with a smoothing kernel. At Gauss nodes it is solved by GMRES, which
//! converges faster than linearly ([`Operator`]). Functions of `y` have gradients with respect to the data at the ends
//! through `lambda = gradient + R^T G^T lambda`, at the same cost.
//!
//! # Source
//! Atkinson (1997), "The Numerical Solution of Integral Equations of the Second Kind", sec. 3.1 (collocation); Kelley, Xue
//! (1996), "GMRES and integral operators", SIAM J. Sci. Comput. 17, 217-226.

use std::fmt::{Debug, Formatter};
use std::sync::Arc;

use super::linear_operator::{Equations, FLAT, Limits, Operator, by_missing};
use super::linear_terms::{LEVELS, Way, in_row, in_span};
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::add;
use crate::solve::gmres::dot;
use crate::space::Shape;

/// The linearised equations at Gauss nodes, for given data at the ends.
pub(crate) struct LinearBoundary {
    equations: Equations,
}

/// A variation for given data at the ends.
pub(crate) struct BoundaryResponse {
    /// `p` at the nodes, one row of nodes per coordinate.
    pub(crate) displacements: Vec<f64>,
    /// `a` and `b` at the start.
    pub(crate) start: [Vec<f64>; 2],
}

impl Debug for LinearBoundary {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        let mut fields = formatter.debug_struct("LinearBoundary");
        fields.field("nodes", &self.equations.nodes.len());
        fields.finish_non_exhaustive()
    }
}

impl LinearBoundary {
    /// The equations in the span of a curve, from coordinates of `x, x', x''` at the nodes, one node after another.
    pub(crate) fn in_span(shape: Shape, nodes: &Arc<Nodes>, x: [&[f64]; 3], tension: f64) -> Self {
        let equations = Equations::new(nodes, in_span(shape, x, tension));
        LinearBoundary { equations }
    }

    /// The equations of a row outside the span, from the blocks of `x, x', x''` at the nodes, `omega` before `b`.
    pub(crate) fn in_row(shape: Shape, nodes: &Arc<Nodes>, x: [&[f64]; 3], tension: f64) -> Self {
        let equations = Equations::new(nodes, in_row(shape, x, tension));
        LinearBoundary { equations }
    }

    /// Whether variations are bounded for all data at the ends: otherwise the ends may be conjugate.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn is_regular(&self, interrupt: Interrupt<'_>) -> Result<bool> {
        // Irregular data, which no variation that vanishes at the ends leaves out.
        let d = self.equations.dim();
        let ends: Vec<f64> = (0..4 * d).map(|i| (1.0 + 1.7 * i as f64).sin()).collect();
        let right = self.polynomials(std::array::from_fn(|end| &ends[end * d..][..d]));
        let limits = Limits::ROUGH;
        let found =
            Operator::new(&self.equations).solve(&right, Way::Forward, limits, interrupt)?;
        Ok(found.is_some())
    }

    /// The variation with the given `p` and `w` at the start and at the end, in the frames there; `None` if the
    /// equations are not solved to round-off.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn solve(
        &self,
        ends: [&[f64]; 4],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<BoundaryResponse>> {
        let (d, count) = (self.equations.dim(), self.equations.nodes.len());
        let mut operator = Operator::new(&self.equations);
        let right = self.polynomials(ends);
        let Some(mut y) = operator.solve(&right, Way::Forward, Limits::FINE, interrupt)? else {
            return Ok(None);
        };
        operator.set_terms(&y, Way::Forward);
        let mut derivatives = operator.set_flat();
        for (p, derivatives) in derivatives.iter_mut().enumerate() {
            let [u0, w0, u1, w1] = ends.map(|end| end[p]);
            for (derivative, [point, velocity]) in derivatives.iter_mut().zip(FLAT) {
                *derivative += point * (u1 - u0 - w0) + velocity * (w1 - w0);
            }
        }
        y.truncate(d * count);
        Ok(Some(BoundaryResponse {
            displacements: y,
            start: [0, 1].map(|i| derivatives.iter().map(|derivative| derivative[i]).collect()),
        }))
    }

    /// The gradient with respect to `p` and `w` at the start and at the end of a function of the variation, from its
    /// gradient with respect to `p` at the nodes, one row per coordinate, and to `a` and `b` at the start; `None` as for
    /// [`LinearBoundary::solve`].
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn pull_back(
        &self,
        by_displacements: &[f64],
        [by_a, by_b]: [&[f64]; 2],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<[Vec<f64>; 4]>> {
        let (d, count) = (self.equations.dim(), self.equations.nodes.len());
        let mut operator = Operator::new(&self.equations);
        let by_derivatives: Vec<[f64; 2]> = by_a.iter().zip(by_b).map(|(a, b)| [*a, *b]).collect();
        let mut right = vec![0.0; LEVELS * d * count];
        if by_derivatives.iter().flatten().any(|x| *x != 0.0) {
            operator.set_flat_transposed(&right, &by_derivatives);
            operator.set_terms_of_sources();
            right.copy_from_slice(&operator.sources);
        }
        add(&mut right, 1.0, by_displacements);
        let Some(lambda) = operator.solve(&right, Way::Transposed, Limits::FINE, interrupt)? else {
            return Ok(None);
        };
        let basis = self.end_basis();
        let mut out: [Vec<f64>; 4] = std::array::from_fn(|end| {
            let by_end = |p: usize| {
                let levels = basis[end].iter().enumerate();
                levels
                    .map(|(level, basis)| dot(&lambda[(level * d + p) * count..], basis))
                    .sum()
            };
            (0..d).map(by_end).collect()
        });
        for (p, by_derivatives) in by_derivatives.iter().enumerate() {
            let [point, velocity] = by_missing(by_derivatives);
            out[0][p] -= point;
            out[1][p] -= point + velocity;
            out[2][p] += point;
            out[3][p] += velocity;
        }
        Ok(Some(out))
    }

    /// `y_0`.
    fn polynomials(&self, ends: [&[f64]; 4]) -> Vec<f64> {
        let (d, count, basis) = (
            self.equations.dim(),
            self.equations.nodes.len(),
            self.end_basis(),
        );
        let mut y = vec![0.0; LEVELS * d * count];
        for (i, row) in y.chunks_exact_mut(count).enumerate() {
            for (end, basis) in ends.iter().zip(&basis) {
                add(row, end[i % d], &basis[i / d]);
            }
        }
        y
    }

    /// For each of `p` and `w` at the start and at the end, the cubic polynomial that is one there and zero for the
    /// others, and its derivatives, at the nodes.
    fn end_basis(&self) -> [[Vec<f64>; LEVELS]; 4] {
        // Coefficients from the constant on.
        const CUBICS: [[f64; 4]; 4] = [
            [1.0, 0.0, -3.0, 2.0],
            [0.0, 1.0, -2.0, 1.0],
            [0.0, 0.0, 3.0, -2.0],
            [0.0, 0.0, -1.0, 1.0],
        ];
        CUBICS.map(|[c0, c1, c2, c3]| {
            let at = |value: &dyn Fn(f64) -> f64| {
                self.equations.nodes.s.iter().map(|s| value(*s)).collect()
            };
            [
                at(&|s| c0 + s * (c1 + s * (c2 + s * c3))),
                at(&|s| c1 + s * (2.0 * c2 + s * 3.0 * c3)),
                at(&|s| 2.0 * c2 + s * 6.0 * c3),
                at(&|_| 6.0 * c3),
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collocation::linear_nodes;
    use crate::solve::gmres::norm;
    use crate::space::{Homogeneous, Kind, Quotient, in_space};

    /// Coordinates of a curve that is no cubic: the equations are linear along any curve. `zero` entries vanish.
    fn curve(nodes: &Nodes, size: usize, zero: impl Fn(usize) -> bool) -> [Vec<f64>; 3] {
        std::array::from_fn(|derivative| {
            let at = |s: &f64| -> Vec<f64> {
                let entry = |p: usize| match zero(p) {
                    true => 0.0,
                    false => ((p + 1) as f64 * 0.9 + s + 1.1 * derivative as f64).sin(),
                };
                (0..size).map(entry).collect()
            };
            nodes.s.iter().flat_map(at).collect()
        })
    }

    fn views(x: &[Vec<f64>; 3]) -> [&[f64]; 3] {
        x.each_ref().map(Vec::as_slice)
    }

    fn numbers(count: usize, seed: f64) -> Vec<f64> {
        let number = |i: usize| (seed + 1.7 * i as f64).sin();
        (0..count).map(number).collect()
    }

    /// Solves forward and transposed with unrelated numbers; the two must agree.
    fn assert_transposed(equations: &LinearBoundary) {
        let (d, count) = (equations.equations.dim(), equations.equations.nodes.len());
        let ends = numbers(4 * d, 0.3);
        let parts: [&[f64]; 4] = std::array::from_fn(|end| &ends[end * d..][..d]);
        let found = equations.solve(parts, Interrupt::NEVER).unwrap().unwrap();
        let by_displacements = numbers(d * count, 0.7);
        let by_start = [numbers(d, 1.1), numbers(d, 1.9)];
        let [by_a, by_b] = by_start.each_ref().map(Vec::as_slice);
        let [a, b] = &found.start;
        let value = dot(&by_displacements, &found.displacements) + dot(by_a, a) + dot(by_b, b);
        let gradient = equations.pull_back(&by_displacements, [by_a, by_b], Interrupt::NEVER);
        let gradient = gradient.unwrap().unwrap().concat();
        let size = norm(&gradient) * norm(&ends);
        let error = (dot(&gradient, &ends) - value).abs() / size;
        assert!(error < 1e-13, "{d}: {error:.1e}");
    }

    fn shapes() -> impl Iterator<Item = Shape> {
        let sizes = [(2, 1), (3, 1), (3, 2), (3, 3), (5, 2), (7, 3)];
        sizes.into_iter().flat_map(|(r, k)| {
            let kinds = [Quotient::Frames, Quotient::Subspaces].map(Kind::real);
            let kinds = kinds
                .into_iter()
                .filter(move |kind| r > k || *kind == Kind::REAL_FRAMES);
            kinds.map(move |kind| Shape { r, k, kind })
        })
    }

    #[test]
    fn the_transpose_is_one() {
        for shape in shapes() {
            let d = in_space!(shape, |space| space.dim());
            let nodes = linear_nodes(1.0).unwrap();
            for tension in [0.0, 3.0] {
                for zero in [0, 2] {
                    let x = curve(&nodes, d, |p| zero > 0 && p % zero == 0);
                    let equations = LinearBoundary::in_span(shape, &nodes, views(&x), tension);
                    assert_transposed(&equations);
                }
                let x = curve(&nodes, shape.r * shape.k, |_| false);
                let equations = LinearBoundary::in_row(shape, &nodes, views(&x), tension);
                assert_transposed(&equations);
            }
        }
    }

    /// A row outside the span is one more row of the space, in which the curve is zero.
    #[test]
    fn rows_are_those_of_a_larger_space() {
        for shape in shapes() {
            let Shape { r, k, kind } = shape;
            let larger = Shape { r: r + 1, ..shape };
            let nodes = linear_nodes(2.0).unwrap();
            // The blocks, with a skew `omega` that is zero for subspaces.
            let mut blocks = curve(&nodes, r * k, |_| false);
            for x in blocks.iter_mut().flat_map(|x| x.chunks_exact_mut(r * k)) {
                let b = x.to_vec();
                for at in 0..k * k {
                    let (i, j) = (at % k, at / k);
                    x[at] = match kind.quotient {
                        Quotient::Frames => b[i + k * j] - b[j + k * i],
                        Quotient::Subspaces => 0.0,
                    };
                }
            }
            let row = LinearBoundary::in_row(shape, &nodes, views(&blocks), 0.5);
            let d = in_space!(larger, |space| space.dim());
            let mut places = vec![0; k];
            let x = blocks.each_ref().map(|x| {
                let mut all = Vec::new();
                for x in x.chunks_exact(r * k) {
                    let mut coordinates = vec![0.0; d];
                    in_space!(larger, |space| space.each_entry(|p, i, j| {
                        match i.checked_sub(k) {
                            None => coordinates[p] = x[i + k * j],
                            Some(i) if i < r - k => {
                                coordinates[p] = x[k * k + i + (r - k) * j];
                            }
                            Some(_) => places[j] = p,
                        }
                    }));
                    all.extend(coordinates);
                }
                all
            });
            let whole = LinearBoundary::in_span(larger, &nodes, views(&x), 0.5);
            let ends = numbers(4 * k, 0.9);
            let short: [&[f64]; 4] = std::array::from_fn(|end| &ends[end * k..][..k]);
            let long = short.map(|end| {
                let mut long = vec![0.0; d];
                for (place, x) in places.iter().zip(end) {
                    long[*place] = *x;
                }
                long
            });
            let found = row.solve(short, Interrupt::NEVER).unwrap().unwrap();
            let long = long.each_ref().map(Vec::as_slice);
            let expected = whole.solve(long, Interrupt::NEVER).unwrap().unwrap();
            let count = nodes.len();
            for (j, place) in places.iter().enumerate() {
                let [found, expected] = [
                    &found.displacements[j * count..][..count],
                    &expected.displacements[place * count..][..count],
                ];
                for (x, y) in found.iter().zip(expected) {
                    assert!((x - y).abs() < 1e-12, "{shape:?}: {x} {y}");
                }
            }
        }
    }
}
