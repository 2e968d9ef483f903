//! Truncated Taylor polynomials of eight small matrices at once, as [`MatrixJet`](super::jet::MatrixJet) for one.

use super::jet::ORDER;
use super::lane_matrix::LaneMatrix;
use super::lane_square::LaneSquare;
use super::lanes::{LANES, Lanes, Mask};

/// A matrix polynomial; operations take the highest order to compute.
pub(crate) struct LaneJet {
    /// Coefficients of orders `0..=ORDER`.
    pub(crate) c: [LaneMatrix; ORDER + 1],
}

impl LaneJet {
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        LaneJet {
            c: std::array::from_fn(|_| LaneMatrix::zeros(rows, cols)),
        }
    }

    /// `self += a b` for a polynomial `b` of square matrices.
    #[inline(always)]
    pub(crate) fn add_product<M: LaneSquare>(
        &mut self,
        a: &LaneJet,
        b: &SquareJet<M>,
        order: usize,
    ) {
        for j in 0..=order {
            for i in 0..=j {
                b.c[j - i].add_product_to(&a.c[i], &mut self.c[j]);
            }
        }
    }

    /// The lanes in which all coefficients are the same.
    #[inline(always)]
    pub(crate) fn equals(&self, other: &LaneJet, order: usize) -> Mask {
        let mut same = [true; LANES];
        for (a, b) in self.c[..=order].iter().zip(&other.c) {
            for (x, y) in a.entries().iter().zip(b.entries()) {
                for l in 0..LANES {
                    same[l] &= x.0[l] == y.0[l];
                }
            }
        }
        Mask(same)
    }

    /// Takes the coefficients of another polynomial in some lanes.
    #[inline(always)]
    pub(crate) fn replace_where(&mut self, lanes: Mask, other: &LaneJet, order: usize) {
        for (to, from) in self.c[..=order].iter_mut().zip(&other.c) {
            for (x, y) in to.entries_mut().iter_mut().zip(from.entries()) {
                *x = lanes.select(*y, *x);
            }
        }
    }

    #[inline(always)]
    pub(crate) fn fill_zero(&mut self, order: usize) {
        for c in &mut self.c[..=order] {
            c.fill_zero();
        }
    }
}

/// A polynomial of square matrices.
pub(crate) struct SquareJet<M> {
    /// Coefficients of orders `0..=ORDER`.
    pub(crate) c: [M; ORDER + 1],
}

impl<M: LaneSquare> SquareJet<M> {
    pub(crate) fn zeros(k: usize) -> Self {
        SquareJet {
            c: std::array::from_fn(|_| M::zeros(k)),
        }
    }

    /// `self = a^T b`.
    #[inline(always)]
    pub(crate) fn set_gram(&mut self, a: &LaneJet, b: &LaneJet, order: usize) {
        for j in 0..=order {
            self.c[j].fill_zero();
            for i in 0..=j {
                self.c[j].add_gram(&a.c[i], &b.c[j - i]);
            }
        }
    }

    /// `self = d b` for a polynomial `d` with a diagonal constant term.
    #[inline(always)]
    pub(crate) fn set_spectral_product(
        &mut self,
        d: &SpectralJet<M>,
        b: &SquareJet<M>,
        order: usize,
    ) {
        for j in 0..=order {
            let (out, from) = (&mut self.c[j], &b.c[j]);
            out.set_each(
                #[inline(always)]
                |i, l| d.diagonal[i] * from.at(i, l),
            );
            for i in 1..=j {
                out.add_product(d.order(i), &b.c[j - i]);
            }
        }
    }
}

/// A polynomial of square matrices with a diagonal constant term: a function of a symmetric polynomial, in the
/// eigenbasis of that one's constant term.
pub(crate) struct SpectralJet<M: LaneSquare> {
    pub(crate) diagonal: M::Diagonal,
    /// Coefficients of orders `1..=ORDER`.
    higher: [M; ORDER],
}

impl<M: LaneSquare> SpectralJet<M> {
    pub(crate) fn zeros(k: usize) -> Self {
        SpectralJet {
            diagonal: M::zero_diagonal(k),
            higher: std::array::from_fn(|_| M::zeros(k)),
        }
    }

    #[inline(always)]
    fn size(&self) -> usize {
        self.higher[0].size()
    }

    /// The coefficient of order `j >= 1`.
    #[inline(always)]
    pub(crate) fn order(&self, j: usize) -> &M {
        &self.higher[j - 1]
    }

    #[inline(always)]
    pub(crate) fn order_mut(&mut self, j: usize) -> &mut M {
        &mut self.higher[j - 1]
    }

    /// The coefficient of order `j >= 1` of `a b`.
    #[inline(always)]
    fn coefficient_of_product(a: &Self, b: &Self, j: usize, out: &mut M) {
        let (x, y) = (a.order(j), b.order(j));
        out.set_each(
            #[inline(always)]
            |i, l| a.diagonal[i] * y.at(i, l) + x.at(i, l) * b.diagonal[l],
        );
        for i in 1..j {
            out.add_product(a.order(i), b.order(j - i));
        }
    }

    /// `self = a b`.
    #[inline(always)]
    pub(crate) fn set_product(&mut self, a: &Self, b: &Self, order: usize) {
        for i in 0..self.size() {
            self.diagonal[i] = a.diagonal[i] * b.diagonal[i];
        }
        for j in 1..=order {
            Self::coefficient_of_product(a, b, j, &mut self.higher[j - 1]);
        }
    }

    /// `self = self b + constant I`, highest order first: a coefficient depends on itself and on lower ones.
    #[inline(always)]
    pub(crate) fn horner_step(&mut self, b: &Self, constant: f64, work: &mut M, order: usize) {
        for j in (1..=order).rev() {
            Self::coefficient_of_product(self, b, j, work);
            self.order_mut(j).copy_from(work);
        }
        for i in 0..self.size() {
            self.diagonal[i] = self.diagonal[i] * b.diagonal[i] + Lanes::splat(constant);
        }
    }

    /// `self = r^T b` for a polynomial `r` whose constant term is the identity.
    #[inline(always)]
    pub(crate) fn set_turned_back(&mut self, r: &Self, b: &Self, order: usize) {
        for i in 0..self.size() {
            self.diagonal[i] = b.diagonal[i];
        }
        for j in 1..=order {
            let (out, x, y) = (&mut self.higher[j - 1], r.order(j), b.order(j));
            out.set_each(
                #[inline(always)]
                |i, l| y.at(i, l) + x.at(l, i) * b.diagonal[l],
            );
            for i in 1..j {
                out.add_product_tn(r.order(i), b.order(j - i));
            }
        }
    }

    /// `self = s a` with a scalar polynomial of order 2.
    #[inline(always)]
    pub(crate) fn set_scaled(&mut self, s: [Lanes; 3], a: &Self, order: usize) {
        let k = self.size();
        for i in 0..k {
            self.diagonal[i] = s[0] * a.diagonal[i];
        }
        for j in 1..=order {
            let out = &mut self.higher[j - 1];
            out.set_each(
                #[inline(always)]
                |i, l| s[0] * a.order(j).at(i, l),
            );
            for m in 1..j.min(3) {
                let from = a.order(j - m);
                for l in 0..k {
                    for i in 0..k {
                        out.set(i, l, out.at(i, l) + s[m] * from.at(i, l));
                    }
                }
            }
            if j < 3 {
                for l in 0..k {
                    out.set(l, l, out.at(l, l) + s[j] * a.diagonal[l]);
                }
            }
        }
    }

    /// `self = a^{-1}`.
    #[inline(always)]
    pub(crate) fn set_inverse(&mut self, a: &Self, order: usize) {
        for i in 0..self.size() {
            self.diagonal[i] = Lanes::ONE / a.diagonal[i];
        }
        let diagonal = &self.diagonal;
        for j in 1..=order {
            // Without the constant term of `a`: sum over m of a_m inverse_{j - m}.
            let (done, rest) = self.higher.split_at_mut(j - 1);
            let (out, from) = (&mut rest[0], a.order(j));
            out.set_each(
                #[inline(always)]
                |i, l| from.at(i, l) * diagonal[l],
            );
            for m in 1..j {
                out.add_product(a.order(m), &done[j - m - 1]);
            }
            for l in 0..out.size() {
                for i in 0..out.size() {
                    out.set(i, l, -(diagonal[i] * out.at(i, l)));
                }
            }
        }
    }

    /// `self = other - self`.
    #[inline(always)]
    pub(crate) fn subtract_from(&mut self, other: &Self, order: usize) {
        for i in 0..self.size() {
            self.diagonal[i] = other.diagonal[i] - self.diagonal[i];
        }
        for (to, from) in self.higher[..order].iter_mut().zip(&other.higher) {
            for l in 0..to.size() {
                for i in 0..to.size() {
                    to.set(i, l, from.at(i, l) - to.at(i, l));
                }
            }
        }
    }

    /// `self = constant I`.
    #[inline(always)]
    pub(crate) fn set_constant(&mut self, constant: f64, order: usize) {
        for i in 0..self.size() {
            self.diagonal[i] = Lanes::splat(constant);
        }
        for c in &mut self.higher[..order] {
            c.fill_zero();
        }
    }
}
