//! Truncated Taylor polynomials of eight small matrices at once, as [`Jet`](super::jet::Jet) for one.

use super::jet::ORDER;
use super::lane_matrix::LaneMatrix;
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

    /// `self = a^T b`.
    #[inline(always)]
    pub(crate) fn set_product_tn(&mut self, a: &LaneJet, b: &LaneJet, order: usize) {
        for j in 0..=order {
            self.c[j].set_product_tn(&a.c[0], &b.c[j]);
            for i in 1..=j {
                self.c[j].add_product_tn(&a.c[i], &b.c[j - i]);
            }
        }
    }

    /// `self += a b`.
    #[inline(always)]
    pub(crate) fn add_product(&mut self, a: &LaneJet, b: &LaneJet, order: usize) {
        for j in 0..=order {
            for i in 0..=j {
                self.c[j].add_product(&a.c[i], &b.c[j - i]);
            }
        }
    }

    /// `self = d b` for a polynomial `d` with a diagonal constant term.
    #[inline(always)]
    pub(crate) fn set_spectral_product(&mut self, d: &SpectralJet, b: &LaneJet, order: usize) {
        for j in 0..=order {
            let (out, from) = (&mut self.c[j], &b.c[j]);
            for l in 0..from.cols() {
                for (i, x) in d.diagonal.iter().enumerate() {
                    out.set(i, l, *x * from.at(i, l));
                }
            }
            for i in 1..=j {
                out.add_product(d.order(i), &b.c[j - i]);
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

/// A polynomial of square matrices with a diagonal constant term: a function of a symmetric polynomial, in the
/// eigenbasis of that one's constant term.
pub(crate) struct SpectralJet {
    pub(crate) diagonal: Vec<Lanes>,
    /// Coefficients of orders `1..=ORDER`.
    higher: [LaneMatrix; ORDER],
}

impl SpectralJet {
    pub(crate) fn zeros(k: usize) -> Self {
        SpectralJet {
            diagonal: vec![Lanes::ZERO; k],
            higher: std::array::from_fn(|_| LaneMatrix::zeros(k, k)),
        }
    }

    /// The coefficient of order `j >= 1`.
    #[inline(always)]
    pub(crate) fn order(&self, j: usize) -> &LaneMatrix {
        &self.higher[j - 1]
    }

    #[inline(always)]
    pub(crate) fn order_mut(&mut self, j: usize) -> &mut LaneMatrix {
        &mut self.higher[j - 1]
    }

    /// `self = factor a b`.
    #[inline(always)]
    pub(crate) fn set_product(
        &mut self,
        factor: f64,
        a: &SpectralJet,
        b: &SpectralJet,
        order: usize,
    ) {
        let k = self.diagonal.len();
        for i in 0..k {
            self.diagonal[i] = a.diagonal[i] * b.diagonal[i] * factor;
        }
        for j in 1..=order {
            let out = &mut self.higher[j - 1];
            for l in 0..k {
                for i in 0..k {
                    let left = a.diagonal[i] * b.order(j).at(i, l);
                    out.set(i, l, left + a.order(j).at(i, l) * b.diagonal[l]);
                }
            }
            for i in 1..j {
                out.add_product(a.order(i), b.order(j - i));
            }
            for x in out.entries_mut() {
                *x = *x * factor;
            }
        }
    }

    /// `self = r^T b` for a polynomial `r` whose constant term is the identity.
    #[inline(always)]
    pub(crate) fn set_turned_back(&mut self, r: &SpectralJet, b: &SpectralJet, order: usize) {
        let k = self.diagonal.len();
        self.diagonal.copy_from_slice(&b.diagonal);
        for j in 1..=order {
            let out = &mut self.higher[j - 1];
            for l in 0..k {
                for i in 0..k {
                    let turned = r.order(j).at(l, i) * b.diagonal[l];
                    out.set(i, l, b.order(j).at(i, l) + turned);
                }
            }
            for i in 1..j {
                out.add_product_tn(r.order(i), b.order(j - i));
            }
        }
    }

    /// `self = s a` with a scalar polynomial of order 2.
    #[inline(always)]
    pub(crate) fn set_scaled(&mut self, s: [Lanes; 3], a: &SpectralJet, order: usize) {
        let k = self.diagonal.len();
        for i in 0..k {
            self.diagonal[i] = s[0] * a.diagonal[i];
        }
        for j in 1..=order {
            let out = &mut self.higher[j - 1];
            for l in 0..k {
                for i in 0..k {
                    let mut sum = s[0] * a.order(j).at(i, l);
                    for m in 1..j.min(3) {
                        sum += s[m] * a.order(j - m).at(i, l);
                    }
                    out.set(i, l, sum);
                }
                if j < 3 {
                    out.set(l, l, out.at(l, l) + s[j] * a.diagonal[l]);
                }
            }
        }
    }

    /// `self = a^{-1}`.
    #[inline(always)]
    pub(crate) fn set_inverse(&mut self, a: &SpectralJet, order: usize) {
        let k = self.diagonal.len();
        for i in 0..k {
            self.diagonal[i] = Lanes::ONE / a.diagonal[i];
        }
        for j in 1..=order {
            // Without the constant term of `a`: sum over m of a_m inverse_{j - m}.
            let (done, rest) = self.higher.split_at_mut(j - 1);
            let out = &mut rest[0];
            for l in 0..k {
                for i in 0..k {
                    out.set(i, l, a.order(j).at(i, l) * self.diagonal[l]);
                }
            }
            for m in 1..j {
                out.add_product(a.order(m), &done[j - m - 1]);
            }
            for l in 0..k {
                for i in 0..k {
                    out.set(i, l, -(self.diagonal[i] * out.at(i, l)));
                }
            }
        }
    }

    /// `self += alpha other`.
    #[inline(always)]
    pub(crate) fn add(&mut self, alpha: f64, other: &SpectralJet, order: usize) {
        for (x, y) in self.diagonal.iter_mut().zip(&other.diagonal) {
            *x += *y * alpha;
        }
        for (to, from) in self.higher[..order].iter_mut().zip(&other.higher) {
            for (x, y) in to.entries_mut().iter_mut().zip(from.entries()) {
                *x += *y * alpha;
            }
        }
    }

    /// `self = I`.
    #[inline(always)]
    pub(crate) fn set_identity(&mut self, order: usize) {
        self.diagonal.fill(Lanes::ONE);
        for c in &mut self.higher[..order] {
            c.fill_zero();
        }
    }

    /// `self += I`.
    #[inline(always)]
    pub(crate) fn add_identity(&mut self) {
        for x in &mut self.diagonal {
            *x += Lanes::ONE;
        }
    }
}
