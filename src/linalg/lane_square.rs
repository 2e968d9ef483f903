//! Eight small square matrices at once, of a size that the compiler knows or of any size.
//!
//! With a known size all loops are unrolled: derivatives of geometric cubics on `St(n, 1)` and `St(n, 2)` spend most of
//! their time in products of such matrices.

use std::ops::IndexMut;

use super::lane_matrix::{LaneMatrix, dot};
use super::lanes::Lanes;

/// Square matrices: `[[Lanes; K]; K]` by columns, or [`LaneMatrix`].
pub(crate) trait LaneSquare {
    /// The entries of a diagonal matrix.
    type Diagonal: IndexMut<usize, Output = Lanes>;

    fn zeros(size: usize) -> Self;
    fn zero_diagonal(size: usize) -> Self::Diagonal;
    fn size(&self) -> usize;
    fn at(&self, i: usize, j: usize) -> Lanes;
    fn set(&mut self, i: usize, j: usize, value: Lanes);

    /// Sets every entry to a function of its place.
    #[inline(always)]
    fn set_each(&mut self, entry: impl Fn(usize, usize) -> Lanes) {
        for j in 0..self.size() {
            for i in 0..self.size() {
                self.set(i, j, entry(i, j));
            }
        }
    }

    #[inline(always)]
    fn fill_zero(&mut self) {
        self.set_each(
            #[inline(always)]
            |_, _| Lanes::ZERO,
        );
    }

    #[inline(always)]
    fn copy_from(&mut self, other: &Self) {
        self.set_each(
            #[inline(always)]
            |i, j| other.at(i, j),
        );
    }

    /// Adds to every entry the sum of a function of its place and of one more index.
    #[inline(always)]
    fn add_sums(&mut self, term: impl Fn(usize, usize, usize) -> Lanes) {
        let k = self.size();
        for j in 0..k {
            for i in 0..k {
                let mut sum = self.at(i, j);
                for l in 0..k {
                    sum += term(i, j, l);
                }
                self.set(i, j, sum);
            }
        }
    }

    /// `self += a b`.
    #[inline(always)]
    fn add_product(&mut self, a: &Self, b: &Self) {
        self.add_sums(
            #[inline(always)]
            |i, j, l| a.at(i, l) * b.at(l, j),
        );
    }

    /// `self = a b`.
    #[inline(always)]
    fn set_product(&mut self, a: &Self, b: &Self) {
        self.fill_zero();
        self.add_product(a, b);
    }

    /// `self -= a b`.
    #[inline(always)]
    fn subtract_product(&mut self, a: &Self, b: &Self) {
        self.add_sums(
            #[inline(always)]
            |i, j, l| -(a.at(i, l) * b.at(l, j)),
        );
    }

    /// `self += a^T b`.
    #[inline(always)]
    fn add_product_tn(&mut self, a: &Self, b: &Self) {
        self.add_sums(
            #[inline(always)]
            |i, j, l| a.at(l, i) * b.at(l, j),
        );
    }

    /// `self = a^T b`.
    #[inline(always)]
    fn set_product_tn(&mut self, a: &Self, b: &Self) {
        self.fill_zero();
        self.add_product_tn(a, b);
    }

    /// `self += alpha a b^T`.
    #[inline(always)]
    fn add_scaled_product_nt(&mut self, alpha: f64, a: &Self, b: &Self) {
        self.add_sums(
            #[inline(always)]
            |i, j, l| a.at(i, l) * (b.at(j, l) * alpha),
        );
    }

    /// `self += a^T b` for matrices of the same number of columns and any number of rows.
    #[inline(always)]
    fn add_gram(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        for j in 0..self.size() {
            for i in 0..self.size() {
                self.set(i, j, self.at(i, j) + dot(a.col(i), b.col(j)));
            }
        }
    }

    /// `out += a self` for a matrix of any number of rows.
    #[inline(always)]
    fn add_product_to(&self, a: &LaneMatrix, out: &mut LaneMatrix) {
        for j in 0..self.size() {
            for l in 0..self.size() {
                let x = self.at(l, j);
                for (out, y) in out.col_mut(j).iter_mut().zip(a.col(l)) {
                    *out += *y * x;
                }
            }
        }
    }
}

impl<const K: usize> LaneSquare for [[Lanes; K]; K] {
    type Diagonal = [Lanes; K];

    fn zeros(size: usize) -> Self {
        assert_eq!(size, K);
        [[Lanes::ZERO; K]; K]
    }

    fn zero_diagonal(_: usize) -> [Lanes; K] {
        [Lanes::ZERO; K]
    }

    #[inline(always)]
    fn size(&self) -> usize {
        K
    }

    #[inline(always)]
    fn at(&self, i: usize, j: usize) -> Lanes {
        self[j][i]
    }

    #[inline(always)]
    fn set(&mut self, i: usize, j: usize, value: Lanes) {
        self[j][i] = value;
    }
}

/// With the products of the matrix, which are made for columns.
impl LaneSquare for LaneMatrix {
    type Diagonal = Vec<Lanes>;

    fn zeros(size: usize) -> Self {
        LaneMatrix::zeros(size, size)
    }

    fn zero_diagonal(size: usize) -> Vec<Lanes> {
        vec![Lanes::ZERO; size]
    }

    #[inline(always)]
    fn size(&self) -> usize {
        self.cols()
    }

    #[inline(always)]
    fn at(&self, i: usize, j: usize) -> Lanes {
        self.at(i, j)
    }

    #[inline(always)]
    fn set(&mut self, i: usize, j: usize, value: Lanes) {
        self.set(i, j, value);
    }

    #[inline(always)]
    fn fill_zero(&mut self) {
        self.fill_zero();
    }

    #[inline(always)]
    fn copy_from(&mut self, other: &Self) {
        self.copy_from(other);
    }

    #[inline(always)]
    fn add_product(&mut self, a: &Self, b: &Self) {
        self.add_product(a, b);
    }

    #[inline(always)]
    fn set_product(&mut self, a: &Self, b: &Self) {
        self.set_product(a, b);
    }

    #[inline(always)]
    fn subtract_product(&mut self, a: &Self, b: &Self) {
        self.subtract_product(a, b);
    }

    #[inline(always)]
    fn add_product_tn(&mut self, a: &Self, b: &Self) {
        self.add_product_tn(a, b);
    }

    #[inline(always)]
    fn set_product_tn(&mut self, a: &Self, b: &Self) {
        self.set_product_tn(a, b);
    }

    #[inline(always)]
    fn add_scaled_product_nt(&mut self, alpha: f64, a: &Self, b: &Self) {
        self.add_scaled_product_nt(alpha, a, b);
    }

    #[inline(always)]
    fn add_product_to(&self, a: &LaneMatrix, out: &mut LaneMatrix) {
        out.add_product(a, self);
    }
}
