//! Derivatives of quasi-geodesics with moving ends, at eight parameters at once.
//!
//! As [`MovingQuasiGeodesic`](super::quasi_geodesic_jet::MovingQuasiGeodesic) for one parameter: every factor of
//!
//! ```math
//! \beta = (S_0\, a_t(P) + S_1 R^T b_t(P))\, R^t
//! ```
//!
//! is a Taylor polynomial. As in [`lane_join`](super::lane_join), `a_t`, `b_t` and the power of the rotation are
//! functions of cosines, so neither small nor repeated angles need care.

use super::lane_angles::LaneAngles;
use super::lane_margin::Margin;
use super::lane_principal::LanePrincipal;
use super::lane_turn::{JoinSquare, LaneTurn};
use crate::linalg::lane_jet::{LaneJet, SpectralJet, SquareJet};
use crate::linalg::lane_matrix::LaneMatrix;
use crate::linalg::lanes::Lanes;

/// Buffers for joining points of one shape. One and two columns are known to the compiler: otherwise orders 1, 2 and 3 take
/// 5.6, 7.8 and 9.1 times as long on `St(3,1)`, 3.7, 4.5 and 4.7 times on `St(3,2)`.
pub(crate) enum LaneMovingJoin {
    One(Box<Join<[[Lanes; 1]; 1]>>),
    Two(Box<Join<[[Lanes; 2]; 2]>>),
    Any(Box<Join<LaneMatrix>>),
}

impl LaneMovingJoin {
    pub(crate) fn new(rows: usize, k: usize) -> Self {
        match k {
            1 => LaneMovingJoin::One(Box::new(Join::new(rows, k))),
            2 => LaneMovingJoin::Two(Box::new(Join::new(rows, k))),
            _ => LaneMovingJoin::Any(Box::new(Join::new(rows, k))),
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
        match self {
            LaneMovingJoin::One(join) => join.advance(s0, s1, t, order, margin),
            LaneMovingJoin::Two(join) => join.advance(s0, s1, t, order, margin),
            LaneMovingJoin::Any(join) => join.advance(s0, s1, t, order, margin),
        }
    }
}

/// The same for one kind of square matrices.
pub(crate) struct Join<M: JoinSquare> {
    /// Rows of a point, which distinguish one component from two.
    rows: usize,
    principal: LanePrincipal,
    /// Principal vectors.
    u: M,
    z: M,
    /// `S0^T S1`, in principal coordinates from order 1 on.
    gram: SquareJet<M>,
    /// `P` and `R` in principal coordinates, where `R` begins with the identity.
    symmetric: SpectralJet<M>,
    rotation: SpectralJet<M>,
    angles: LaneAngles<M>,
    /// `a_t(P)` and `R^T b_t(P)`.
    start: SpectralJet<M>,
    end: SpectralJet<M>,
    turn: M::Turn,
    /// `U^T R^{t + tau}`.
    power: SquareJet<M>,
    /// The factors of `S0` and `S1`.
    left: SquareJet<M>,
    right: SquareJet<M>,
    half: M,
    rest: M,
    point: LaneJet,
}

impl<M: JoinSquare> Join<M> {
    fn new(rows: usize, k: usize) -> Self {
        let spectral = || SpectralJet::zeros(k);
        let square = || SquareJet::zeros(k);
        Join {
            rows,
            principal: LanePrincipal::new(k),
            u: M::zeros(k),
            z: M::zeros(k),
            gram: square(),
            symmetric: spectral(),
            rotation: spectral(),
            angles: LaneAngles::new(k),
            start: spectral(),
            end: spectral(),
            turn: M::Turn::new(k),
            power: square(),
            left: square(),
            right: square(),
            half: M::zeros(k),
            rest: M::zeros(k),
            point: LaneJet::zeros(rows, k),
        }
    }

    #[inline(always)]
    fn advance(
        &mut self,
        s0: &mut LaneJet,
        s1: &LaneJet,
        t: Lanes,
        order: usize,
        margin: &mut Margin,
    ) {
        let same = s0.equals(s1, order);
        self.gram.set_gram(s0, s1, order);
        self.factor(order, margin);
        self.polar(order);
        self.angles.compute(&self.symmetric, t, order);
        // a_t = cos(t theta) - cos(theta) b_t.
        let (cosine, ratio) = (&self.angles.cosine, &self.angles.ratio);
        self.start.set_product(&self.symmetric, ratio, order);
        self.start.subtract_from(cosine, order);
        self.end.set_turned_back(&self.rotation, ratio, order);
        let (turn, power) = (&mut self.turn, &mut self.power);
        turn.power_into(&self.principal, &self.rotation, t, order, power, margin);
        for (out, spectral, basis) in [
            (&mut self.left, &self.start, &self.u),
            (&mut self.right, &self.end, &self.z),
        ] {
            // `gram` is not needed any more.
            self.gram.set_spectral_product(spectral, &self.power, order);
            for j in 0..=order {
                out.c[j].set_product(basis, &self.gram.c[j]);
            }
        }
        self.point.fill_zero(order);
        self.point.add_product(s0, &self.left, order);
        self.point.add_product(s1, &self.right, order);
        // A curve at rest has no velocity at all, not one of the size of round-off.
        self.point.replace_where(same, s0, order);
        std::mem::swap(&mut self.point, s0);
    }

    /// The principal vectors of the constant term of `gram`, to whose coordinates the others change.
    #[inline(always)]
    fn factor(&mut self, order: usize, margin: &mut Margin) {
        let k = self.u.size();
        let (principal, gram) = (&mut self.principal, &mut self.gram);
        for j in 0..k {
            for i in 0..k {
                principal.gram.set(i, j, gram.c[0].at(i, j));
            }
        }
        principal.factor_any(self.rows, margin);
        self.u.set_each(
            #[inline(always)]
            |i, j| principal.u.at(i, j),
        );
        self.z.set_each(
            #[inline(always)]
            |i, j| principal.z.at(i, j),
        );
        for c in &mut gram.c[1..=order] {
            self.half.set_product_tn(&self.u, c);
            c.set_product(&self.half, &self.z);
        }
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
        let (half, rest) = (&mut self.half, &mut self.rest);
        let k = half.size();
        for i in 0..k {
            (p.diagonal[i], r.diagonal[i]) = (c[i], Lanes::ONE);
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::lanes::LANES;

    const ROWS: usize = 4;
    const ORDER: usize = 3;

    /// Frames whose first column turns from the first to the last axis by a multiple of an angle in each lane, and that also
    /// turn within their span, with arbitrary higher coefficients.
    fn frames(k: usize, angle: f64, speed: f64) -> LaneJet {
        let mut jet = LaneJet::zeros(ROWS, k);
        let turns = Lanes(std::array::from_fn(|lane| angle * lane as f64));
        let (sin, cos) = turns.sin_cos();
        let zero = Lanes::ZERO;
        let columns = [[cos, zero, zero, sin], [zero, Lanes::ONE, zero, zero]];
        let (s, c) = (turns * 1.5).sin_cos();
        for i in 0..ROWS {
            let (x, y) = (columns[0][i], columns[1][i]);
            match k {
                1 => jet.c[0].set(i, 0, x),
                _ => {
                    jet.c[0].set(i, 0, c * x + s * y);
                    jet.c[0].set(i, 1, c * y - s * x);
                }
            }
        }
        for (order, c) in jet.c.iter_mut().enumerate().skip(1) {
            for j in 0..k {
                for i in 0..ROWS {
                    let phase = (5 * i + 3 * j + 7 * order) as f64;
                    c.set(i, j, Lanes::splat(speed * phase.sin()));
                }
            }
        }
        jet
    }

    fn joined<M: JoinSquare>(k: usize, ends: [&LaneJet; 2], t: Lanes) -> (LaneJet, Margin) {
        let mut join = Join::<M>::new(ROWS, k);
        let (mut out, mut margin) = (LaneJet::zeros(ROWS, k), Margin::WIDE);
        for (to, from) in out.c.iter_mut().zip(&ends[0].c) {
            to.copy_from(from);
        }
        join.advance(&mut out, ends[1], t, ORDER, &mut margin);
        (out, margin)
    }

    /// Known sizes have other products and powers of rotations than any size, after the same factorisation. They agree to
    /// 6e-15 of the largest coefficient in all lanes that are not marked.
    fn sizes_agree<M: JoinSquare>(k: usize) {
        let t = Lanes(std::array::from_fn(|lane| lane as f64 / 7.0));
        let mut compared = 0;
        for (angle, other) in [(0.0, 0.0), (0.0, 0.3), (0.2, -0.15), (0.4, 0.39)] {
            for speed in [0.0, 1.0] {
                let (from, to) = (frames(k, angle, speed), frames(k, other, 0.7 * speed));
                let (known, margin) = joined::<M>(k, [&from, &to], t);
                let (any, expected) = joined::<LaneMatrix>(k, [&from, &to], t);
                for lane in (0..LANES).filter(|&lane| !(margin.hard[lane] || expected.hard[lane])) {
                    compared += 1;
                    let entries = |jet: &LaneJet| -> Vec<f64> {
                        let all = jet.c.iter().flat_map(|c| c.entries());
                        all.map(|x| x.0[lane]).collect()
                    };
                    let (known, any) = (entries(&known), entries(&any));
                    let largest = any.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    for (x, y) in known.iter().zip(&any) {
                        let error = (x - y).abs() / largest;
                        let place = format!("k = {k}, {angle} {other} {speed}, lane {lane}");
                        assert!(error < 3e-14, "{place}: {error:e}");
                    }
                }
            }
        }
        assert!(compared >= 40, "{compared} of 64 lanes are compared");
    }

    #[test]
    fn one_column_of_known_size_is_joined_as_any() {
        sizes_agree::<[[Lanes; 1]; 1]>(1);
    }

    #[test]
    fn two_columns_of_known_size_are_joined_as_any() {
        sizes_agree::<[[Lanes; 2]; 2]>(2);
    }
}
