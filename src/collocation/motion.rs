//! `x, x', x''` at Gauss nodes and at the end, from their values at the start and `x'''` at the nodes, and the solution
//! of the equations of flat space; with the transposes of both.

use super::lane_nodes::LaneNodes;
use crate::linalg::lanes::{LANES, Lanes};

/// The changes of `x'` and `x''` at the start that move the end of a curve of flat space by one unit in the point and
/// in the velocity.
const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// Sets `x, x', x''` at the nodes, and the first of them at the end, from their values at the start and `x'''` at the
/// nodes.
#[inline(always)]
pub(super) fn set_motion<const N: usize>(
    nodes: &LaneNodes,
    [v, a, b]: [&[f64]; 3],
    f: &[Lanes],
    x: [&mut [Lanes]; 3],
    last: [&mut [f64]; N],
) {
    let d = v.len();
    for (group, s) in nodes.s.iter().enumerate() {
        for p in 0..d {
            let at = group * d + p;
            x[0][at] = (*s * (0.5 * b[p]) + Lanes::splat(a[p])) * *s + Lanes::splat(v[p]);
            x[1][at] = *s * b[p] + Lanes::splat(a[p]);
            x[2][at] = Lanes::splat(b[p]);
        }
    }
    for (level, x) in x.into_iter().enumerate() {
        nodes.add_integrals(3 - level, f, d, x);
    }
    for (level, last) in last.into_iter().enumerate() {
        for (p, last) in last.iter_mut().enumerate() {
            *last = [v[p] + a[p] + 0.5 * b[p], a[p] + b[p], b[p]][level];
        }
        nodes.add_integrals_to_end(3 - level, f, d, last);
    }
}

/// The transpose of [`set_motion`]: sets the gradient with respect to `x, x', x''` at the start, and adds to `f` the
/// one with respect to `x'''` at the nodes, from those with respect to `x, x', x''` at the nodes and to `x` at the end.
#[inline(always)]
pub(super) fn motion_transposed(
    nodes: &LaneNodes,
    by_x: [&[Lanes]; 3],
    by_last: &[f64],
    f: &mut [Lanes],
    mut start: [&mut [f64]; 3],
) {
    let d = by_last.len();
    for (start, factor) in start.iter_mut().zip([1.0, 1.0, 0.5]) {
        for (start, last) in start.iter_mut().zip(by_last) {
            *start = factor * last;
        }
    }
    for (group, s) in nodes.s.iter().enumerate() {
        for p in 0..d {
            let [w, a, b] = by_x.map(|x| x[group * d + p]);
            let by_start = [w, *s * w + a, *s * (*s * w * 0.5 + a) + b];
            for (sum, x) in start.iter_mut().zip(by_start) {
                sum[p] += x.sum();
            }
        }
    }
    for (level, x) in by_x.into_iter().enumerate() {
        nodes.add_transposed_integrals(3 - level, x, d, f);
    }
    nodes.add_transposed_integrals_to_end(3, by_last, f);
}

/// Sets `x'` and `x''` at the start and `x'''` at the nodes, one after another, to those of the curve of flat space
/// with the given `x'''` whose end is displaced, and changed in its velocity, as given.
#[inline(always)]
pub(super) fn solve_flat(
    nodes: &LaneNodes,
    f: &[Lanes],
    point: &[f64],
    velocity: &[f64],
    out: &mut [f64],
) {
    let d = point.len();
    let (a, rest) = out.split_at_mut(d);
    let (b, phi) = rest.split_at_mut(d);
    // First what `x'''` contributes at the end.
    a.fill(0.0);
    b.fill(0.0);
    for (f, factor) in f.chunks_exact(d).zip(to_point(nodes)) {
        for (sum, f) in a.iter_mut().zip(f) {
            *sum += (*f * factor).sum();
        }
    }
    nodes.add_integrals_to_end(3, f, d, b);
    for i in 0..d {
        let (p, q) = (point[i] - a[i], velocity[i] - b[i]);
        a[i] = FLAT[0][0] * p + FLAT[0][1] * q;
        b[i] = FLAT[1][0] * p + FLAT[1][1] * q;
    }
    for (phi, f) in phi.chunks_exact_mut(LANES).zip(f) {
        phi.copy_from_slice(&f.0);
    }
}

/// The transpose of [`solve_flat`]: sets `f`, and the gradients with respect to the displacement and to the change of
/// the velocity.
#[inline(always)]
pub(super) fn flat_transposed(
    nodes: &LaneNodes,
    y: &[f64],
    f: &mut [Lanes],
    [point, velocity]: [&mut [f64]; 2],
) {
    let d = point.len();
    let (a, rest) = y.split_at(d);
    let (b, phi) = rest.split_at(d);
    for i in 0..d {
        point[i] = FLAT[0][0] * a[i] + FLAT[1][0] * b[i];
        velocity[i] = FLAT[0][1] * a[i] + FLAT[1][1] * b[i];
    }
    // First the negative.
    for (f, phi) in f.iter_mut().zip(phi.chunks_exact(LANES)) {
        f.0.copy_from_slice(phi);
        *f = -*f;
    }
    for (f, factor) in f.chunks_exact_mut(d).zip(to_point(nodes)) {
        for (f, point) in f.iter_mut().zip(&*point) {
            *f += factor * *point;
        }
    }
    nodes.add_transposed_integrals_to_end(3, velocity, f);
    f.iter_mut().for_each(|f| *f = -*f);
}

/// Weights of the integral of the third integral: `(1 - s)^3 / 6` times those of the nodes.
#[inline(always)]
fn to_point(nodes: &LaneNodes) -> impl Iterator<Item = Lanes> + '_ {
    let each = nodes.s.iter().zip(&nodes.weights);
    each.map(|(s, weight)| {
        let left = Lanes::ONE - *s;
        left * left * left * *weight * (1.0 / 6.0)
    })
}
