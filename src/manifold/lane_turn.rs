//! Powers of moving rotations, at eight parameters at once: `R^t = cos(t Phi) + K sin(t Phi) / sin(Phi)` with the symmetric
//! part `cos Phi` and the skew part `K` of `R`, or the multiple of an angle in the plane.

use super::lane_angles::LaneAngles;
use super::lane_margin::{LOWEST_COSINE, Margin};
use super::lane_principal::LanePrincipal;
use crate::linalg::jet::ORDER;
use crate::linalg::lane_jet::{SpectralJet, SquareJet};
use crate::linalg::lane_matrix::{LaneMatrix, diagonalise};
use crate::linalg::lane_square::LaneSquare;
use crate::linalg::lanes::{LANES, Lanes, Mask};

/// Computes powers of the moving rotation `R = U W Z^T`, where `W` begins with the identity.
pub(crate) trait LaneTurn<M: LaneSquare> {
    fn new(k: usize) -> Self;

    /// `out = U^T R^{t + tau}`; `turning` is `W`.
    fn power_into(
        &mut self,
        principal: &LanePrincipal,
        turning: &SpectralJet<M>,
        t: Lanes,
        order: usize,
        out: &mut SquareJet<M>,
        margin: &mut Margin,
    );
}

/// Square matrices with the method for powers of rotations of their size.
pub(crate) trait JoinSquare: LaneSquare {
    type Turn: LaneTurn<Self>
    where
        Self: Sized;
}

impl JoinSquare for [[Lanes; 1]; 1] {
    type Turn = NoTurn;
}

impl JoinSquare for [[Lanes; 2]; 2] {
    type Turn = PlaneTurn;
}

impl JoinSquare for LaneMatrix {
    type Turn = SpaceTurn;
}

/// The only rotation of a line.
pub(crate) struct NoTurn;

impl LaneTurn<[[Lanes; 1]; 1]> for NoTurn {
    fn new(_: usize) -> Self {
        NoTurn
    }

    #[inline(always)]
    fn power_into(
        &mut self,
        _: &LanePrincipal,
        _: &SpectralJet<[[Lanes; 1]; 1]>,
        _: Lanes,
        order: usize,
        out: &mut SquareJet<[[Lanes; 1]; 1]>,
        _: &mut Margin,
    ) {
        out.c[0] = [[Lanes::ONE]];
        for c in &mut out.c[1..=order] {
            c.fill_zero();
        }
    }
}

/// Rotations of the plane commute: with the angle `phi` of `R` and the angle of `U`, which is a rotation as well,
/// `U^T R^{t + tau}` is the rotation by `(t + tau) phi` minus the angle of `U`.
pub(crate) struct PlaneTurn;

/// A rotation of the plane as its cosine and its sine.
type PlaneRotation = (Lanes, Lanes);

impl LaneTurn<[[Lanes; 2]; 2]> for PlaneTurn {
    fn new(_: usize) -> Self {
        PlaneTurn
    }

    #[inline(always)]
    fn power_into(
        &mut self,
        principal: &LanePrincipal,
        turning: &SpectralJet<[[Lanes; 2]; 2]>,
        t: Lanes,
        order: usize,
        out: &mut SquareJet<[[Lanes; 2]; 2]>,
        margin: &mut Margin,
    ) {
        let LanePrincipal { u, rotation, .. } = principal;
        let cosine = rotation.at(0, 0);
        let phi = plane_angle(rotation.at(1, 0).atan2(cosine), turning, order);
        let powers = plane_power(&phi, t, order);
        let (u_cos, u_sin) = (u.at(0, 0), u.at(1, 0));
        for (out, (cos, sin)) in out.c[..=order].iter_mut().zip(powers) {
            let (cos, sin) = (u_cos * cos + u_sin * sin, u_cos * sin - u_sin * cos);
            *out = [[cos, sin], [-sin, cos]];
        }
        // The power is accurate here too, but near a half turn the caller decides whether it is determined.
        let low = Lanes::splat(LOWEST_COSINE).greater(cosine);
        margin.see(Lanes::ONE + cosine, low);
    }
}

/// The angle of `R = U W Z^T`, from that of `U Z^T`; its derivative is `cos sin' - sin cos'` of `W`.
#[inline(always)]
fn plane_angle(
    start: Lanes,
    turning: &SpectralJet<[[Lanes; 2]; 2]>,
    order: usize,
) -> [Lanes; ORDER + 1] {
    let w = |j: usize| match j {
        0 => (Lanes::ONE, Lanes::ZERO),
        _ => (turning.order(j).at(0, 0), turning.order(j).at(1, 0)),
    };
    let mut phi = [Lanes::ZERO; ORDER + 1];
    phi[0] = start;
    for j in 1..=order {
        let mut sum = Lanes::ZERO;
        for i in 1..=j {
            let ((cos, sin), (d_cos, d_sin)) = (w(j - i), w(i));
            sum += (cos * d_sin - sin * d_cos) * i as f64;
        }
        phi[j] = sum * (1.0 / j as f64);
    }
    phi
}

/// The rotation by `(t + tau) phi`, whose derivatives are `cos' = -sin psi'` and `sin' = cos psi'` for that angle `psi`.
#[inline(always)]
fn plane_power(phi: &[Lanes; ORDER + 1], t: Lanes, order: usize) -> [PlaneRotation; ORDER + 1] {
    let mut powers = [(Lanes::ZERO, Lanes::ZERO); ORDER + 1];
    let (sin, cos) = (t * phi[0]).sin_cos();
    powers[0] = (cos, sin);
    for j in 1..=order {
        let (mut c, mut s) = (Lanes::ZERO, Lanes::ZERO);
        for i in 1..=j {
            let psi = t * phi[i] + phi[i - 1];
            let rate = psi * (i as f64 / j as f64);
            let (cos, sin) = powers[j - i];
            c -= rate * sin;
            s += rate * cos;
        }
        powers[j] = (c, s);
    }
    powers
}

/// Rotations of a space of at least three dimensions, by functions of their symmetric part.
pub(crate) struct SpaceTurn {
    rotation: LaneMatrix,
    cosine: SpectralJet<LaneMatrix>,
    symmetric: LaneMatrix,
    vectors: LaneMatrix,
    /// `U^T V`, and `U^T K V`.
    left: LaneMatrix,
    skew: SquareJet<LaneMatrix>,
    angles: LaneAngles<LaneMatrix>,
    work: LaneMatrix,
    sum: LaneMatrix,
}

impl LaneTurn<LaneMatrix> for SpaceTurn {
    fn new(k: usize) -> Self {
        let square = || LaneMatrix::zeros(k, k);
        SpaceTurn {
            rotation: square(),
            cosine: SpectralJet::zeros(k),
            symmetric: square(),
            vectors: square(),
            left: square(),
            skew: SquareJet::zeros(k),
            angles: LaneAngles::new(k),
            work: square(),
            sum: square(),
        }
    }

    #[inline(always)]
    fn power_into(
        &mut self,
        principal: &LanePrincipal,
        turning: &SpectralJet<LaneMatrix>,
        t: Lanes,
        order: usize,
        out: &mut SquareJet<LaneMatrix>,
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
                let cosine = self.cosine.order_mut(j);
                cosine.set_product(&self.work, &self.vectors);
            }
            self.work.set_product_tn(u, &self.skew.c[j]);
            self.skew.c[j].set_product(&self.work, &self.vectors);
        }
        self.angles.compute(&self.cosine, t, order);
        let (cosine, ratio) = (&self.angles.cosine, &self.angles.ratio);
        for j in 0..=order {
            // [U^T V cos(t Phi) + U^T K V sin(t Phi) / sin(Phi)] V^T.
            let sum = &mut self.sum;
            sum.fill_zero();
            for i in 0..=j {
                match i {
                    0 => sum.add_scaled_columns(&self.skew.c[j], &ratio.diagonal),
                    _ => sum.add_product(&self.skew.c[j - i], ratio.order(i)),
                }
            }
            match j {
                0 => sum.add_scaled_columns(&self.left, &cosine.diagonal),
                _ => sum.add_product(&self.left, cosine.order(j)),
            }
            out.c[j].set_product_nt(sum, &self.vectors);
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
