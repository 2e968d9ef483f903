//! The [linearised equation](super::linear_terms) of a cubic in a row outside the span of the curve.
//!
//! The curve is zero there, `w, a, b` are rows of length `k`, and `zeta` is one of length `r`:
//!
//! ```math
//! b' = b\,\omega + w\,({b_x'}^T b_x - \omega'') + a\,(\tau - b_x^T b_x),\qquad
//! \zeta(s) = \Bigl( (u, 0) + \int_0^s (w, 0)\, g^T \Bigr) g(s)
//! ```
//!
//! with the blocks `omega` and `b_x` of `x`; for subspaces with `w (2 b_x'^T b_x - b_x^T b_x')` instead.

use super::linear_terms::{CurveAtNodes, Terms, groups_of_frames, relative};
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::vectorised;
use crate::space::{Quotient, Shape};

/// The terms in a row outside the span.
struct InRow {
    k: usize,
    /// For eight nodes each, the matrices that multiply `w, a, b` from the right, shape `(k, k)`.
    groups: Vec<[Vec<Lanes>; 3]>,
    /// Frames relative to the one at the end, as [`relative`] returns them.
    frames: Vec<Lanes>,
    /// The lower block of `x` at the end, shape `(r - k, k)` in column-major order.
    last: Vec<f64>,
}

/// The terms for a row outside the span, from the blocks of vectors: `omega`, then `b`, in column-major order; `r` rows
/// in total.
pub(crate) fn in_row(shape: Shape, curve: CurveAtNodes<'_>) -> Box<dyn Terms> {
    let Shape { r, k, kind } = shape;
    let size = r * k;
    let node = |node: usize| {
        let [x, x1, x2] = curve.x.map(|x| &x[node * size..][..size]);
        let omega = |x: &[f64], i: usize, j: usize| x[i + k * j];
        let product = |x: &[f64], y: &[f64], i: usize, j: usize| -> f64 {
            let [x, y] = [(x, i), (y, j)].map(|(x, i)| &x[k * k + (r - k) * i..][..r - k]);
            x.iter().zip(y).map(|(x, y)| x * y).sum()
        };
        let turned = f64::from(u8::from(kind.quotient == Quotient::Subspaces));
        let entry = |level: usize, i: usize, j: usize| match level {
            0 => {
                let turning = product(x1, x, i, j) - product(x, x1, i, j);
                product(x1, x, i, j) - omega(x2, i, j) + turned * turning
            }
            1 => -product(x, x, i, j),
            _ => omega(x, i, j),
        };
        let matrix = |level: usize| -> Vec<f64> {
            let entries = (0..k * k).map(|at| entry(level, at / k, at % k));
            entries.collect()
        };
        std::array::from_fn::<_, 3, _>(matrix)
    };
    let nodes: Vec<[Vec<f64>; 3]> = (0..curve.x[0].len() / size).map(node).collect();
    let group = |nodes: &[[Vec<f64>; 3]]| {
        std::array::from_fn(|level| {
            let entry = |at: usize| Lanes(std::array::from_fn(|lane| nodes[lane][level][at]));
            (0..k * k).map(entry).collect()
        })
    };
    Box::new(InRow {
        k,
        groups: nodes.chunks_exact(LANES).map(group).collect(),
        frames: relative(&groups_of_frames(curve.frames, r * r), curve.end, r),
        last: curve.last[k * k..].to_vec(),
    })
}

impl InRow {
    fn r(&self) -> usize {
        self.k + self.last.len() / self.k
    }

    fn frame(&self, group: usize) -> &[Lanes] {
        let square = self.r().pow(2);
        &self.frames[group * square..][..square]
    }
}

impl Terms for InRow {
    fn dim(&self) -> usize {
        self.k
    }

    fn transported(&self) -> usize {
        self.r()
    }

    fn buffer(&self) -> usize {
        0
    }

    fn add_change(&self, group: usize, x: [&[Lanes]; 3], _: &mut [Lanes], out: &mut [Lanes]) {
        vectorised(
            #[inline(always)]
            || {
                for (matrix, x) in self.groups[group].iter().zip(x) {
                    for (x, row) in x.iter().zip(matrix.chunks_exact(self.k)) {
                        for (entry, out) in row.iter().zip(&mut *out) {
                            *out += *x * *entry;
                        }
                    }
                }
            },
        );
    }

    fn add_change_transposed(
        &self,
        group: usize,
        f: &[Lanes],
        _: &mut [Lanes],
        out: [&mut [Lanes]; 3],
    ) {
        vectorised(
            #[inline(always)]
            || {
                for (matrix, out) in self.groups[group].iter().zip(out) {
                    for (out, row) in out.iter_mut().zip(matrix.chunks_exact(self.k)) {
                        for (entry, f) in row.iter().zip(f) {
                            *out += *f * *entry;
                        }
                    }
                }
            },
        );
    }

    fn add_transported(
        &self,
        group: usize,
        (weight, w): (Lanes, &[Lanes]),
        _: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        vectorised(
            #[inline(always)]
            || {
                let rows = self.frame(group).chunks_exact(self.r());
                for (out, row) in out.iter_mut().zip(rows) {
                    for (x, entry) in w.iter().zip(row) {
                        *out += *x * weight * *entry;
                    }
                }
            },
        );
    }

    fn complete(&self, _: &mut [Lanes]) {}

    fn add_projected(
        &self,
        group: usize,
        (weight, z): (Lanes, &[Lanes]),
        _: &mut [Lanes],
        out: &mut [Lanes],
    ) {
        vectorised(
            #[inline(always)]
            || {
                let rows = self.frame(group).chunks_exact(self.r());
                for (z, row) in z.iter().zip(rows) {
                    for (out, entry) in out.iter_mut().zip(row) {
                        *out += *z * weight * *entry;
                    }
                }
            },
        );
    }

    fn arrive(&self, z: &[f64], point: &mut [f64], velocity: &mut [f64]) {
        let (shift, turning) = z.split_at(self.k);
        let columns = self.last.chunks_exact(turning.len().max(1));
        for (velocity, column) in velocity.iter_mut().zip(columns) {
            *velocity += turning.iter().zip(column).map(|(z, x)| z * x).sum::<f64>();
        }
        point.copy_from_slice(shift);
    }

    fn arrive_transposed(&self, [point, velocity]: [&[f64]; 2], z: &mut [f64]) {
        let m = self.r() - self.k;
        z[..self.k].copy_from_slice(point);
        for (i, z) in z[self.k..].iter_mut().enumerate() {
            let entries = velocity.iter().zip(self.last[i..].iter().step_by(m));
            *z = entries.map(|(v, x)| v * x).sum();
        }
    }
}
