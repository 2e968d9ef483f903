//! The curve of a solved leg as polynomials in powers of the time from its middle: points and `x`.
//!
//! The points are integrals of their fourth derivative. The rest `E` of the frame follows from `E' = -S V^T E`.

use faer::{Mat, MatRef};

use super::clamped::LEVELS;
use super::clamped_leg::ClampedLeg;
use super::embedded_equation::Embedded;
use crate::collocation::expansion::{NodeExpansion, add_cubic};
use crate::curve::nodes::Nodes;
use crate::legs::{Dense, Polynomials};
use crate::linalg::field::accumulate;
use crate::linalg::lanes::LANES;
use crate::linalg::simd::vectorised;
use crate::linalg::structure::row_by_row;
use crate::space::Homogeneous;

/// Largest number of Picard iterations for the rest of the frame; they stop where it no longer changes.
const MOST_SWEEPS: usize = 60;

/// Change of a frame below which it is round-off.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// The covariant acceleration and its derivative, `x'` and `x''` as matrices, from the derivatives of a curve.
pub(crate) fn covariant_derivatives(
    [s, v, second, third]: [MatRef<'_, f64>; LEVELS],
) -> [Mat<f64>; 2] {
    let omega = s.transpose() * v;
    let square = v.transpose() * v;
    let a = &square + &omega * &omega;
    let rate = s.transpose() * second + &square;
    let b = v.transpose() * second + &omega * (s.transpose() * second) - &a * &omega;
    let acceleration = second - v * &omega + s * &a;
    let next = third - second * &omega - v * (&rate * faer::Scale(2.0))
        + v * &a
        + s * (&b * faer::Scale(2.0) + b.transpose());
    [acceleration, next]
}

/// The polynomials of a leg relative to its frame at the start, given the map from the coordinates of the leg to that frame.
pub(crate) fn polynomials(
    space: impl Homogeneous,
    leg: &ClampedLeg,
    to_frame: MatRef<'_, f64>,
) -> Dense {
    let nodes = &leg.nodes.nodes.nodes;
    let (r, k, count) = (space.size(), leg.equation.k, nodes.len());
    let expansion = NodeExpansion::of(nodes);
    let square = r * r;
    let curve = LegCurve::new(leg, to_frame);
    let rest = rest_of_frames(&curve, nodes, r);

    let mut x = Vec::with_capacity(count * space.dim());
    for node in 0..count {
        let [s, v] = [0, 1].map(|level| curve.at_nodes[level][node].as_ref());
        let e = matrix_of(&rest.values[node * r * (r - k)..], r, r - k);
        x.extend(coordinates(space, [s, e.as_ref()], v));
    }
    let x = expansion.values(&x, space.dim());

    let start = Mat::from_fn(r, r - k, |i, j| f64::from(u8::from(i == k + j)));
    let ends = [(0, start), (1, matrix_of(&rest.last, r, r - k))];
    let mut vectors: Vec<Vec<f64>> = Vec::new();
    let mut last_frame = vec![0.0; square];
    for (end, e) in &ends {
        let derivatives = curve.at_end(*end);
        let [s, v, ..] = derivatives.each_ref().map(Mat::as_ref);
        let [acceleration, next] = covariant_derivatives(derivatives.each_ref().map(Mat::as_ref));
        for vector in [v, acceleration.as_ref(), next.as_ref()] {
            vectors.push(coordinates(space, [s, e.as_ref()], vector));
        }
        for i in 0..r {
            for j in 0..r {
                last_frame[i * r + j] = if j < k { s[(i, j)] } else { e[(i, j - k)] };
            }
        }
    }
    let mut dense = Dense::new(1, count + 1, space, k);
    let polynomials = Polynomials {
        x: &x,
        frames: &curve.points(&expansion),
        ends: std::array::from_fn(|i| vectors[i].as_slice()),
        last_frame: &last_frame,
    };
    dense.write(0, &polynomials);
    dense
}

/// A leg in the coordinates of its first frame.
struct LegCurve<'l> {
    leg: &'l ClampedLeg,
    to_frame: MatRef<'l, f64>,
    /// `S` and `S'` at the nodes.
    at_nodes: [Vec<Mat<f64>>; 2],
}

impl<'l> LegCurve<'l> {
    fn new(leg: &'l ClampedLeg, to_frame: MatRef<'l, f64>) -> Self {
        let (size, groups) = (leg.equation.size(), leg.nodes.groups());
        let all = leg.derivatives();
        let at = |level: usize, node: usize| {
            let lanes = &all[level][node / LANES * size..][..size];
            let entries: Vec<f64> = lanes.iter().map(|x| x.0[node % LANES]).collect();
            mapped(leg, to_frame, &entries)
        };
        let at_nodes =
            [0, 1].map(|level| (0..groups * LANES).map(|node| at(level, node)).collect());
        LegCurve {
            leg,
            to_frame,
            at_nodes,
        }
    }

    fn mapped(&self, x: &[f64]) -> Mat<f64> {
        mapped(self.leg, self.to_frame, x)
    }

    /// `S, S', S'', S'''` at an end.
    fn at_end(&self, end: usize) -> [Mat<f64>; LEVELS] {
        let leg = self.leg;
        let mut x = vec![0.0; leg.equation.size()];
        std::array::from_fn(|level| match level {
            0 | 1 => self.mapped(&leg.data[2 * end + level]),
            _ => {
                leg.at_end(end, level - 2, &mut x);
                self.mapped(&x)
            }
        })
    }

    /// Coefficients of the points, each in row-major order.
    fn points(&self, expansion: &NodeExpansion) -> Vec<f64> {
        let leg = self.leg;
        let (size, k, r) = (leg.equation.size(), leg.equation.k, self.to_frame.nrows());
        let count = leg.nodes.count();
        let mut f = Vec::with_capacity(count * r * k);
        for node in 0..count {
            let lanes = &leg.f[node / LANES * size..][..size];
            let entries: Vec<f64> = lanes.iter().map(|x| x.0[node % LANES]).collect();
            f.extend(row_by_row(self.mapped(&entries).as_ref()));
        }
        let mut out = expansion.fourth_integrals(&f, r * k);
        let start = self
            .at_end(0)
            .map(|x| row_by_row(x.as_ref()).collect::<Vec<f64>>());
        add_cubic(start.each_ref().map(Vec::as_slice), &mut out);
        out
    }
}

/// The matrix with given stored entries in the coordinates of a frame.
fn mapped(leg: &ClampedLeg, to_frame: MatRef<'_, f64>, x: &[f64]) -> Mat<f64> {
    let Embedded { r, k, .. } = leg.equation;
    to_frame * MatRef::from_column_major_slice(&leg.equation.all_columns(x), r, k)
}

/// The rest of the frames, each in row-major order: its values at the nodes and at the end.
#[derive(Default)]
struct Rest {
    values: Vec<f64>,
    last: Vec<f64>,
}

fn rest_of_frames(curve: &LegCurve<'_>, nodes: &Nodes, r: usize) -> Rest {
    let (k, count) = (curve.leg.equation.k, nodes.len());
    let size = r * (r - k);
    if size == 0 {
        return Rest::default();
    }
    let start = |out: &mut [f64]| {
        for e in out.chunks_exact_mut(size) {
            e.fill(0.0);
            for j in 0..r - k {
                e[(k + j) * (r - k) + j] = 1.0;
            }
        }
    };
    let mut rates = vec![0.0; count * size];
    let mut values = vec![0.0; (count + 1) * size];
    start(&mut values);
    let mut before = values.clone();
    for _ in 0..MOST_SWEEPS {
        for node in 0..count {
            let [s, v] = [0, 1].map(|level| &curve.at_nodes[level][node]);
            let e = matrix_of(&values[node * size..], r, r - k);
            let rate = s * (v.transpose() * e);
            for i in 0..r {
                for j in 0..r - k {
                    rates[node * size + i * (r - k) + j] = -rate[(i, j)];
                }
            }
        }
        std::mem::swap(&mut before, &mut values);
        start(&mut values);
        vectorised(
            #[inline(always)]
            || accumulate(&nodes.at[1], count, &rates, size, &mut values),
        );
        let pairs = values.iter().zip(&before);
        let change = pairs.fold(0.0_f64, |most, (now, before)| {
            most.max((now - before).abs())
        });
        if change <= ROUND_OFF {
            break;
        }
    }
    let last = values.split_off(count * size);
    Rest { values, last }
}

/// The coordinates of a tangent vector in a frame `[s, e]`.
fn coordinates(
    space: impl Homogeneous,
    [s, e]: [MatRef<'_, f64>; 2],
    v: MatRef<'_, f64>,
) -> Vec<f64> {
    let (omega, normal, k) = (s.transpose() * v, e.transpose() * v, s.ncols());
    let mut out = vec![0.0; space.dim()];
    space.each_entry(|p, i, j| {
        let entry = match i < k {
            true => 0.5 * (omega[(i, j)] - omega[(j, i)]),
            false => normal[(i - k, j)],
        };
        out[p] = entry * space.scale(i, j);
    });
    out
}

fn matrix_of(entries: &[f64], rows: usize, columns: usize) -> Mat<f64> {
    MatRef::from_row_major_slice(&entries[..rows * columns], rows, columns).to_owned()
}
