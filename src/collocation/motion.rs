//! `x, x', x''` at Gauss nodes and at the end, from their values at the start and `x'''` at the nodes, and the solution
//! of the equations of flat space; with the transposes of both.

use super::lane_nodes::LaneNodes;
use crate::linalg::lanes::{LANES, Lanes};

/// The changes of `x'` and `x''` at the start that move the end of a curve of flat space by one unit in the point and
/// in the velocity.
const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// Sets `x, x', x''` at the nodes and at the end, from their values at the start and `x'''` at the nodes.
pub(super) fn set_motion(
    nodes: &LaneNodes,
    [v, a, b]: [&[f64]; 3],
    f: &[Lanes],
    mut x: [&mut [Lanes]; 3],
    mut last: [&mut [f64]; 3],
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
    for p in 0..d {
        last[0][p] = v[p] + a[p] + 0.5 * b[p];
        last[1][p] = a[p] + b[p];
        last[2][p] = b[p];
    }
    for (level, (x, last)) in x.iter_mut().zip(&mut last).enumerate() {
        nodes.add_integrals(3 - level, f, d, x);
        nodes.add_integrals_to_end(3 - level, f, d, last);
    }
}

/// The transpose of [`set_motion`]: the gradient with respect to `x, x', x''` at the start, and added to `f` the one
/// with respect to `x'''` at the nodes, from those with respect to `x, x', x''` at the nodes and to `x` at the end.
pub(super) fn motion_transposed(
    nodes: &LaneNodes,
    by_x: [&[Lanes]; 3],
    by_last: &[f64],
    f: &mut [Lanes],
) -> [Vec<f64>; 3] {
    let d = by_last.len();
    let mut start = [by_last.to_vec(), by_last.to_vec(), by_last.to_vec()];
    start[2].iter_mut().for_each(|x| *x *= 0.5);
    for (group, s) in nodes.s.iter().enumerate() {
        for p in 0..d {
            let [w, a, b] = by_x.map(|x| x[group * d + p]);
            let by_start = [w, *s * w + a, *s * (*s * w * 0.5 + a) + b];
            for (sum, x) in start.iter_mut().zip(by_start) {
                sum[p] += x.0.iter().sum::<f64>();
            }
        }
    }
    for (level, x) in by_x.into_iter().enumerate() {
        nodes.add_transposed_integrals(3 - level, x, d, f);
    }
    nodes.add_transposed_integrals_to_end(3, by_last, f);
    start
}

/// Sets `x'` and `x''` at the start and `x'''` at the nodes, one after another, to those of the curve of flat space
/// with the given `x'''` whose end is displaced, and changed in its velocity, as given.
pub(super) fn solve_flat(
    nodes: &LaneNodes,
    f: &[Lanes],
    point: &[f64],
    velocity: &[f64],
    out: &mut [f64],
) {
    let d = point.len();
    let mut at_end = [vec![0.0; d], vec![0.0; d]];
    let [by_point, by_velocity] = &mut at_end;
    nodes.add_integrals_to_end(3, f, d, by_velocity);
    for (f, factor) in f.chunks_exact(d).zip(to_point(nodes)) {
        for (sum, f) in by_point.iter_mut().zip(f) {
            *sum += (*f * factor).0.iter().sum::<f64>();
        }
    }
    let (a, rest) = out.split_at_mut(d);
    let (b, phi) = rest.split_at_mut(d);
    for i in 0..d {
        let (p, q) = (point[i] - by_point[i], velocity[i] - by_velocity[i]);
        a[i] = FLAT[0][0] * p + FLAT[0][1] * q;
        b[i] = FLAT[1][0] * p + FLAT[1][1] * q;
    }
    for (phi, f) in phi.chunks_exact_mut(LANES).zip(f) {
        phi.copy_from_slice(&f.0);
    }
}

/// The transpose of [`solve_flat`]: sets `f`, and returns the gradients with respect to the displacement and to the
/// change of the velocity.
pub(super) fn flat_transposed(
    nodes: &LaneNodes,
    d: usize,
    y: &[f64],
    f: &mut [Lanes],
) -> [Vec<f64>; 2] {
    let (a, rest) = y.split_at(d);
    let (b, phi) = rest.split_at(d);
    let by_missing = |part: usize| -> Vec<f64> {
        let each = a.iter().zip(b);
        let each = each.map(|(a, b)| FLAT[0][part] * a + FLAT[1][part] * b);
        each.collect()
    };
    let [point, velocity] = [0, 1].map(by_missing);
    for (f, phi) in f.iter_mut().zip(phi.chunks_exact(LANES)) {
        f.0.copy_from_slice(phi);
    }
    for (f, factor) in f.chunks_exact_mut(d).zip(to_point(nodes)) {
        for (f, point) in f.iter_mut().zip(&point) {
            *f -= factor * *point;
        }
    }
    let back: Vec<f64> = velocity.iter().map(|x| -x).collect();
    nodes.add_transposed_integrals_to_end(3, &back, f);
    [point, velocity]
}

/// Weights of the integral of the third integral: `(1 - s)^3 / 6` times those of the nodes.
fn to_point(nodes: &LaneNodes) -> impl Iterator<Item = Lanes> + '_ {
    let each = nodes.s.iter().zip(&nodes.weights);
    each.map(|(s, weight)| {
        let left = Lanes::ONE - *s;
        left * left * left * *weight * (1.0 / 6.0)
    })
}
