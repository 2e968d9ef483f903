//! The legs of a solved chain as curves.

use faer::{Mat, MatMut, MatRef, Scale};

use super::clamped::LEVELS;
use super::clamped_leg::ClampedLeg;
use super::leg_polynomials::{covariant_derivatives, polynomials};
use crate::collocation::expansion::EXACT;
use crate::legs::Dense;
use crate::linalg::complex_embedding::times_i;
use crate::linalg::decomp::thin_q;
use crate::linalg::field::add;
use crate::linalg::product::mul_add;
use crate::space::Homogeneous;

/// The legs of a solution.
pub(crate) struct SolvedChain {
    pub(crate) legs: Vec<ClampedLeg>,
    pub(crate) lengths: Vec<f64>,
    /// Velocities at the knots, per unit of time.
    pub(crate) velocities: Vec<f64>,
    /// Point and velocity at each knot, shape `(n, 2k)`.
    pub(crate) pairs: Vec<Mat<f64>>,
}

impl SolvedChain {
    /// Covariant acceleration and third vector at the start of a leg, in its time.
    pub(crate) fn derivatives(&self, leg: usize) -> [Mat<f64>; 2] {
        let (this, k) = (&self.legs[leg], self.legs[leg].equation.k);
        let n = self.pairs[leg].nrows();
        let lifted = |which: usize| {
            let mut x = vec![0.0; this.equation.size()];
            this.at_end(0, which, &mut x);
            let mut out = vec![0.0; n * k];
            let (first, _) = out.split_at_mut(n * this.equation.stored());
            lift(
                &self.pairs[leg..][..2],
                self.lengths[leg],
                1.0,
                &mut x,
                first,
            );
            complete(&mut out, n, this.equation.stored());
            MatRef::from_column_major_slice(&out, n, k).to_owned()
        };
        let (s, v) = self.pairs[leg].as_ref().split_at_col(k);
        let v = v * Scale(self.lengths[leg]);
        let [second, third] = [0, 1].map(lifted);
        covariant_derivatives([s, v.as_ref(), second.as_ref(), third.as_ref()])
    }

    /// An orthonormal basis of the span of a leg that begins with the point at its start, and the map from the coordinates
    /// of the leg to those in the basis; `None` if the coordinates are those of the points.
    pub(crate) fn basis(&self, leg: usize) -> Option<[Mat<f64>; 2]> {
        let (n, k) = (self.pairs[leg].nrows(), self.legs[leg].equation.k);
        if self.legs[leg].equation.r == n {
            return None;
        }
        let mut data = Mat::zeros(n, LEVELS * k);
        for (end, pair) in self.pairs[leg..][..2].iter().enumerate() {
            data.as_mut()
                .subcols_mut(end * 2 * k, 2 * k)
                .copy_from(pair);
            for column in data.as_mut().subcols_mut(end * 2 * k + k, k).col_iter_mut() {
                column.iter_mut().for_each(|x| *x *= self.lengths[leg]);
            }
        }
        let mut basis = thin_q(data.as_ref());
        let point = self.pairs[leg].as_ref().subcols(0, k);
        basis.as_mut().subcols_mut(0, k).copy_from(point);
        let to_basis = basis.transpose() * &data;
        Some([basis, to_basis])
    }

    /// For subspaces, what turns the basis at the next knot to the one that each leg reaches; `None` if legs are integrated,
    /// which reach it only to the tolerance.
    pub(crate) fn turns(&self) -> Option<Vec<Mat<f64>>> {
        let exact = |(i, leg): (usize, &ClampedLeg)| leg.turn().filter(|_| self.is_polynomial(i));
        self.legs.iter().enumerate().map(exact).collect()
    }

    /// Whether polynomials of a leg are accurate.
    pub(crate) fn is_polynomial(&self, leg: usize) -> bool {
        self.legs[leg].nodes.count() <= EXACT
    }

    /// The polynomials of a leg relative to its first frame, in the coordinates of a basis that begins with the point.
    pub(crate) fn polynomials(
        &self,
        space: impl Homogeneous,
        leg: usize,
        to_basis: MatRef<'_, f64>,
    ) -> Dense {
        polynomials(space, &self.legs[leg], to_basis)
    }
}

/// Adds a multiple of the matrix with given coordinates, which are overwritten, in a leg between two knots: the stored
/// columns of both.
pub(crate) fn lift(pairs: &[Mat<f64>], h: f64, factor: f64, x: &mut [f64], out: &mut [f64]) {
    if x.len() == out.len() {
        return add(out, factor, x);
    }
    let (n, size) = pairs[0].shape();
    let (r, k) = (2 * size, size / 2);
    for column in x.chunks_exact_mut(r) {
        for (i, block) in column.chunks_exact_mut(k).enumerate() {
            let scale = if i % 2 == 0 { 1.0 } else { h };
            block.iter_mut().for_each(|x| *x *= scale);
        }
    }
    let stored = out.len() / n;
    let x = MatRef::from_column_major_slice(&*x, r, stored);
    let mut out = MatMut::from_column_major_slice_mut(out, n, stored);
    for (end, pair) in pairs.iter().enumerate() {
        mul_add(&mut out, factor, pair, x.subrows(end * size, size));
    }
}

/// Writes the columns of a matrix with `n` rows that are not stored.
pub(crate) fn complete(out: &mut [f64], n: usize, stored: usize) {
    let (first, rest) = out.split_at_mut(n * stored);
    times_i(first, n, rest);
}
