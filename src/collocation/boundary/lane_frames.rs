//! Frames along a curve at Gauss nodes: the solution of `g' = g x`, `g(0) = 1`.

use crate::collocation::along::Along;
use crate::collocation::lane_matrices::{add_product, add_product_of_numbers, times_transposed};
use crate::collocation::lane_nodes::LaneNodes;
use crate::linalg::field::{larger, largest, set_identity};
use crate::linalg::lanes::Lanes;
use crate::space::Homogeneous;

/// Number of Picard iterations for frames without rotation, and additional ones per radian.
const SWEEPS: [f64; 2] = [3.0, 2.0];

/// Maximal number of Picard iterations: a motion that needs more has gone astray.
const MOST_SWEEPS: f64 = 48.0;

/// Frames with a larger defect are computed by Picard's iteration.
const AWAY: f64 = 0.3;

/// Maximal number of corrections.
const MOST_CORRECTIONS: usize = 5;

/// Frames relative to the one at the start, shape `(r, r)` in row-major order: at the nodes, by groups, and at the end.
pub(crate) struct LaneFrames {
    r: usize,
    pub(crate) at_nodes: Vec<Lanes>,
    pub(crate) last: Vec<f64>,
    defects: Vec<Lanes>,
    last_defect: Vec<f64>,
    rates: Vec<Lanes>,
    product: Vec<Lanes>,
    /// Numbers of leading entries of rows that may be nonzero: of skew matrices of `m`, and of any matrix.
    lengths: [Vec<usize>; 2],
}

impl LaneFrames {
    /// Frames without rotation.
    pub(crate) fn new(space: impl Homogeneous, nodes: &LaneNodes) -> Self {
        let r = space.size();
        let (square, groups) = (r * r, nodes.groups());
        let zeros = |count: usize| vec![Lanes::ZERO; count];
        let mut frames = LaneFrames {
            r,
            at_nodes: zeros(groups * square),
            last: vec![0.0; square],
            defects: zeros(groups * square),
            last_defect: vec![0.0; square],
            rates: zeros(groups * square),
            product: zeros(square),
            lengths: [(0..r).map(|row| space.row_len(row)).collect(), vec![r; r]],
        };
        frames.reset();
        frames
    }

    fn reset(&mut self) {
        let square = self.r * self.r;
        for frame in self.at_nodes.chunks_exact_mut(square) {
            set_identity(self.r, frame);
        }
        set_identity(self.r, &mut self.last);
    }

    /// Updates the frames for a curve, from frames along a curve nearby if the present ones are such, until their defect
    /// is about as small as wanted; returns it. It is large for curves that are too fast.
    pub(crate) fn update(
        &mut self,
        nodes: &LaneNodes,
        along: &[Along],
        speed: f64,
        wanted: f64,
    ) -> f64 {
        let mut defect = self.set_defects(nodes, along);
        let is_near = defect < AWAY;
        if !is_near {
            self.reset();
            let sweeps = (SWEEPS[0] + SWEEPS[1] * speed).ceil().min(MOST_SWEEPS);
            for _ in 0..sweeps as usize {
                self.set_defects(nodes, along);
                self.add_defects();
            }
            defect = self.set_defects(nodes, along);
        }
        for _ in 0..MOST_CORRECTIONS {
            self.correct(nodes, along);
            // A correction squares the defect.
            let left = defect * defect;
            if left <= wanted {
                return left;
            }
            let before = defect;
            defect = self.set_defects(nodes, along);
            let is_smaller = defect < before;
            if !is_smaller {
                break;
            }
        }
        defect
    }

    /// The frames at other nodes, interpolated.
    pub(crate) fn on_nodes(&self, from: &LaneNodes, to: &LaneNodes) -> Self {
        let mut out = LaneFrames {
            r: self.r,
            at_nodes: Vec::new(),
            last: self.last.clone(),
            defects: Vec::new(),
            last_defect: self.last_defect.clone(),
            rates: Vec::new(),
            product: self.product.clone(),
            lengths: self.lengths.clone(),
        };
        out.at_nodes = from.values_at(to, &self.at_nodes, self.r * self.r);
        out.defects.resize(out.at_nodes.len(), Lanes::ZERO);
        out.rates.resize(out.at_nodes.len(), Lanes::ZERO);
        out
    }

    /// Sets `e = 1 + int g x - g` at the nodes and at the end; returns the largest entry.
    fn set_defects(&mut self, nodes: &LaneNodes, along: &[Along]) -> f64 {
        let (r, square) = (self.r, self.r * self.r);
        let frames = self.at_nodes.chunks_exact(square);
        let each = self.rates.chunks_exact_mut(square).zip(frames);
        for ((rate, frame), along) in each.zip(along) {
            times_skew(frame, &along.x[0], r, &self.lengths[0], rate);
        }
        let frames = self.at_nodes.chunks_exact(square);
        for (defect, frame) in self.defects.chunks_exact_mut(square).zip(frames) {
            set_identity(r, defect);
            for (defect, frame) in defect.iter_mut().zip(frame) {
                *defect -= *frame;
            }
        }
        set_identity(r, &mut self.last_defect);
        for (defect, frame) in self.last_defect.iter_mut().zip(&self.last) {
            *defect -= frame;
        }
        nodes.add_integrals(1, &self.rates, square, &mut self.defects);
        nodes.add_integrals_to_end(1, &self.rates, square, &mut self.last_defect);
        larger(largest(&self.defects), largest(&self.last_defect))
    }

    /// Picard's iteration.
    fn add_defects(&mut self) {
        for (frame, defect) in self.at_nodes.iter_mut().zip(&self.defects) {
            *frame += *defect;
        }
        for (frame, defect) in self.last.iter_mut().zip(&self.last_defect) {
            *frame += defect;
        }
    }

    /// One Newton step with the defect `e` and `g` as the fundamental matrix: `g <- g + e + (int e x g^T) g`.
    fn correct(&mut self, nodes: &LaneNodes, along: &[Along]) {
        let (r, square) = (self.r, self.r * self.r);
        let each = self.defects.chunks_exact(square).zip(along);
        let frames = self.at_nodes.chunks_exact(square);
        let rates = self.rates.chunks_exact_mut(square);
        for ((rate, frame), (defect, along)) in rates.zip(frames).zip(each) {
            times_skew(defect, &along.x[0], r, &self.lengths[0], &mut self.product);
            times_transposed(&self.product, frame, r, &self.lengths[1], rate);
        }
        // The defects are no longer needed apart from the frames.
        let before = self.at_nodes.clone();
        let last_before = self.last.clone();
        self.add_defects();
        self.defects.fill(Lanes::ZERO);
        self.last_defect.fill(0.0);
        nodes.add_integrals(1, &self.rates, square, &mut self.defects);
        nodes.add_integrals_to_end(1, &self.rates, square, &mut self.last_defect);
        let all = self
            .defects
            .chunks_exact(square)
            .zip(before.chunks_exact(square));
        for ((turn, before), frame) in all.zip(self.at_nodes.chunks_exact_mut(square)) {
            add_product(turn, before, r, frame);
        }
        add_product_of_numbers(&self.last_defect, &last_before, r, &mut self.last);
    }

    /// The largest entry of the last two Legendre coefficients of `g'`.
    pub(crate) fn tail(&mut self, nodes: &LaneNodes, along: &[Along]) -> f64 {
        let square = self.r * self.r;
        self.set_defects(nodes, along);
        nodes.largest_tail(&self.rates, square)
    }
}

/// `out = a x` for the skew matrix of an element of `m`.
fn times_skew(a: &[Lanes], x: &[Lanes], r: usize, lengths: &[usize], out: &mut [Lanes]) {
    // `x = -x^T`.
    times_transposed(a, x, r, lengths, out);
    for out in out {
        *out = -*out;
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::linalg::skew_exp;
    use crate::space::{Kind, Shape, in_space};

    /// Frames along a geodesic, `x` constant, from frames at rest and from those of a slower one.
    #[test]
    fn constant_generators_give_exponentials() {
        for (r, k) in [(2, 1), (3, 2), (4, 4), (6, 3), (9, 2)] {
            let shape = Shape {
                r,
                k,
                kind: Kind::REAL_FRAMES,
            };
            in_space!(shape, |space| {
                let nodes = LaneNodes::at_least(24).unwrap();
                let mut frames = LaneFrames::new(space, &nodes);
                for size in [1.0, 2.0] {
                    let x: Vec<f64> = (0..space.dim())
                        .map(|p| size * (1.0 + p as f64).sin() / (space.dim() as f64).sqrt())
                        .collect();
                    let lanes: Vec<Lanes> = x.iter().map(|x| Lanes::splat(*x)).collect();
                    let rest = vec![Lanes::ZERO; space.dim()];
                    let along: Vec<Along> = (0..nodes.groups())
                        .map(|_| {
                            let mut along = Along::new(space);
                            along.set(space, [&lanes, &rest, &rest]);
                            along
                        })
                        .collect();
                    frames.update(&nodes, &along, size, 1e-30);
                    let mut matrix = vec![0.0; r * r];
                    space.matrix_into(&x, &mut matrix);
                    let exact = skew_exp(Mat::from_fn(r, r, |i, j| matrix[i * r + j]).as_ref());
                    let exact = exact.unwrap();
                    for i in 0..r {
                        for j in 0..r {
                            let error = (frames.last[i * r + j] - exact[(i, j)]).abs();
                            assert!(error < 3e-15 * size, "({r}, {k}): {error:.1e}");
                        }
                    }
                    assert!(frames.tail(&nodes, &along) < 1e-13);
                }
            });
        }
    }
}
