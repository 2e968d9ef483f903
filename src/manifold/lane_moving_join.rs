//! Derivatives of quasi-geodesics with moving ends, at eight parameters at once.
//!
//! As [`MovingQuasiGeodesic`](super::quasi_geodesic_jet::MovingQuasiGeodesic) for one parameter: every factor of
//!
//! ```math
//! \beta = (S_0\, a_t(P) + S_1 R^T b_t(P))\, R^t
//! ```
//!
//! is a Taylor polynomial. As in [`lane_join`](super::lane_join), `a_t`, `b_t` and the power of the rotation are
//! functions of cosines, `R^t = cos(t Phi) + K sin(t Phi) / sin(Phi)` with the symmetric part `cos Phi` and the skew part
//! `K` of `R`, so neither small nor repeated angles need care.

use super::lane_angles::LaneAngles;
use super::lane_margin::{LOWEST_COSINE, Margin};
use super::lane_principal::LanePrincipal;
use crate::linalg::lane_jet::{LaneJet, SpectralJet};
use crate::linalg::lane_matrix::{LaneMatrix, diagonalise};
use crate::linalg::lanes::{LANES, Lanes, Mask};

/// Buffers for joining points of one shape.
pub(crate) struct LaneMovingJoin {
    /// Rows of a point, which distinguish one component from two.
    rows: usize,
    principal: LanePrincipal,
    /// `S0^T S1`, in principal coordinates from order 1 on.
    gram: LaneJet,
    /// `P` and `R` in principal coordinates, where `R` begins with the identity.
    symmetric: SpectralJet,
    rotation: SpectralJet,
    angles: LaneAngles,
    /// `a_t(P)` and `R^T b_t(P)`.
    start: SpectralJet,
    end: SpectralJet,
    turn: Option<Box<Turn>>,
    /// The factors of `S0` and `S1`.
    left: LaneJet,
    right: LaneJet,
    half: LaneMatrix,
    rest: LaneMatrix,
    point: LaneJet,
}

impl LaneMovingJoin {
    pub(crate) fn new(rows: usize, k: usize) -> Self {
        let spectral = || SpectralJet::zeros(k);
        let square = || LaneJet::zeros(k, k);
        LaneMovingJoin {
            rows,
            principal: LanePrincipal::new(k),
            gram: square(),
            symmetric: spectral(),
            rotation: spectral(),
            angles: LaneAngles::new(k),
            start: spectral(),
            end: spectral(),
            turn: (k > 1).then(|| Box::new(Turn::new(k))),
            left: square(),
            right: square(),
            half: LaneMatrix::zeros(k, k),
            rest: LaneMatrix::zeros(k, k),
            point: LaneJet::zeros(rows, k),
        }
    }

    /// `s0 <- beta(S0(tau), S1(tau); t + tau)` of the principal quasi-geodesic, for orders of at least 1 and `|t| <= 1`.
    #[inline(always)]
    pub(crate) fn advance(
        &mut self,
        s0: &mut LaneJet,
        s1: &LaneJet,
        t: Lanes,
        order: usize,
        margin: &mut Margin,
    ) {
        let same = s0.equals(s1, order);
        self.gram.set_product_tn(s0, s1, order);
        self.principal.gram.copy_from(&self.gram.c[0]);
        self.principal.factor_any(self.rows, margin);
        let LanePrincipal { u, z, .. } = &self.principal;
        for c in &mut self.gram.c[1..=order] {
            self.half.set_product_tn(u, c);
            c.set_product(&self.half, z);
        }
        self.polar(order);
        self.angles.compute(&self.symmetric, t, order);
        // a_t = cos(t theta) - cos(theta) b_t.
        let (cosine, ratio) = (&self.angles.cosine, &self.angles.ratio);
        self.start.set_product(-1.0, &self.symmetric, ratio, order);
        self.start.add(1.0, cosine, order);
        self.end.set_turned_back(&self.rotation, ratio, order);
        match &mut self.turn {
            None => {
                for (out, spectral) in [(&mut self.left, &self.start), (&mut self.right, &self.end)]
                {
                    out.c[0].set(0, 0, spectral.diagonal[0]);
                    for j in 1..=order {
                        out.c[j].copy_from(spectral.order(j));
                    }
                }
            }
            Some(turn) => {
                turn.compute(&self.principal, &self.rotation, t, order, margin);
                for (out, spectral, basis) in [
                    (&mut self.left, &self.start, &self.principal.u),
                    (&mut self.right, &self.end, &self.principal.z),
                ] {
                    // `gram` is not needed any more.
                    self.gram.set_spectral_product(spectral, &turn.power, order);
                    for j in 0..=order {
                        out.c[j].set_product(basis, &self.gram.c[j]);
                    }
                }
            }
        }
        self.point.fill_zero(order);
        self.point.add_product(s0, &self.left, order);
        self.point.add_product(s1, &self.right, order);
        // A curve at rest has no velocity at all, not one of the size of round-off.
        self.point.replace_where(same, s0, order);
        std::mem::swap(&mut self.point, s0);
    }

    /// `gram = P R` order by order, with `P_0 = diag(c)` and `R_0 = I`: each order solves `C w + w C = given` for a skew
    /// `w`.
    #[inline(always)]
    fn polar(&mut self, order: usize) {
        let (p, r, c) = (
            &mut self.symmetric,
            &mut self.rotation,
            &self.principal.cosines,
        );
        let (half, rest, k) = (&mut self.half, &mut self.rest, c.len());
        p.diagonal.copy_from_slice(c);
        r.diagonal.fill(Lanes::ONE);
        for j in 1..=order {
            // The symmetric part of R_j from R R^T = I, then gram_j - sum P_i R_{j-i} without the unknown part.
            half.fill_zero();
            rest.copy_from(&self.gram.c[j]);
            for i in 1..j {
                half.add_scaled_product_nt(-0.5, r.order(i), r.order(j - i));
                rest.subtract_product(p.order(i), r.order(j - i));
            }
            for b in 0..k {
                for a in 0..k {
                    rest.set(a, b, rest.at(a, b) - c[a] * half.at(a, b));
                }
            }
            for b in 0..k {
                for a in b + 1..k {
                    let w = (rest.at(a, b) - rest.at(b, a)) / (c[a] + c[b]);
                    half.set(a, b, half.at(a, b) + w);
                    half.set(b, a, half.at(b, a) - w);
                    rest.set(a, b, rest.at(a, b) - c[a] * w);
                    rest.set(b, a, rest.at(b, a) + c[b] * w);
                }
            }
            r.order_mut(j).copy_from(half);
            p.order_mut(j).copy_from(rest);
        }
    }
}

/// The power of the rotation.
struct Turn {
    rotation: LaneMatrix,
    cosine: SpectralJet,
    symmetric: LaneMatrix,
    vectors: LaneMatrix,
    /// `U^T V`, and `U^T K V`.
    left: LaneMatrix,
    skew: LaneJet,
    angles: LaneAngles,
    work: LaneMatrix,
    sum: LaneMatrix,
    /// `U^T R^{t + tau}`.
    power: LaneJet,
}

impl Turn {
    fn new(k: usize) -> Self {
        let square = || LaneMatrix::zeros(k, k);
        Turn {
            rotation: square(),
            cosine: SpectralJet::zeros(k),
            symmetric: square(),
            vectors: square(),
            left: square(),
            skew: LaneJet::zeros(k, k),
            angles: LaneAngles::new(k),
            work: square(),
            sum: square(),
            power: LaneJet::zeros(k, k),
        }
    }

    #[inline(always)]
    fn compute(
        &mut self,
        principal: &LanePrincipal,
        turning: &SpectralJet,
        t: Lanes,
        order: usize,
        margin: &mut Margin,
    ) {
        let LanePrincipal { u, z, rotation, .. } = principal;
        let k = rotation.cols();
        split(rotation, &mut self.symmetric, &mut self.skew.c[0]);
        let converged = diagonalise(&mut self.symmetric, &mut self.vectors);
        let mut least = Lanes::ONE;
        for i in 0..k {
            self.cosine.diagonal[i] = self.symmetric.at(i, i);
            least = least.min(self.cosine.diagonal[i]);
        }
        let low = Lanes::splat(LOWEST_COSINE).greater(least);
        margin.see(Lanes::ONE + least, low);
        margin.see(Lanes::ONE + least, Mask([!converged; LANES]));
        self.left.set_product_tn(u, &self.vectors);
        for j in 0..=order {
            if j > 0 {
                self.work.set_product(u, turning.order(j));
                self.rotation.set_product_nt(&self.work, z);
                split(&self.rotation, &mut self.symmetric, &mut self.skew.c[j]);
                self.work.set_product_tn(&self.vectors, &self.symmetric);
                self.cosine
                    .order_mut(j)
                    .set_product(&self.work, &self.vectors);
            }
            self.work.set_product_tn(u, &self.skew.c[j]);
            self.skew.c[j].set_product(&self.work, &self.vectors);
        }
        self.angles.compute(&self.cosine, t, order);
        let (cosine, ratio) = (&self.angles.cosine, &self.angles.ratio);
        for j in 0..=order {
            // [U^T V cos(t Phi) + U^T K V sin(t Phi) / sin(Phi)] V^T.
            self.sum.fill_zero();
            for i in 0..=j {
                match i {
                    0 => self
                        .sum
                        .add_scaled_columns(&self.skew.c[j], &ratio.diagonal),
                    _ => self.sum.add_product(&self.skew.c[j - i], ratio.order(i)),
                }
            }
            match j {
                0 => self.sum.add_scaled_columns(&self.left, &cosine.diagonal),
                _ => self.sum.add_product(&self.left, cosine.order(j)),
            }
            self.power.c[j].set_product_nt(&self.sum, &self.vectors);
        }
    }
}

/// The symmetric and the skew part of a matrix.
#[inline(always)]
fn split(a: &LaneMatrix, symmetric: &mut LaneMatrix, skew: &mut LaneMatrix) {
    let (k, half) = (a.cols(), Lanes::splat(0.5));
    for j in 0..k {
        for i in 0..k {
            let (x, y) = (a.at(i, j), a.at(j, i));
            symmetric.set(i, j, (x + y) * half);
            skew.set(i, j, (x - y) * half);
        }
    }
}
