//! Covariant derivatives along eight curves, or at eight parameters, at once; the formulas are those of
//! [`covariant`](super::covariant).

use crate::linalg::jet::MatrixJet;
use crate::linalg::lane_matrix::{LaneMatrix, dot};
use crate::linalg::lanes::Lanes;
use crate::linalg::simd::{Eight, Width};

/// Number of columns up to which eight matrices at once are faster than one after another: an acceleration takes 1.3 us
/// instead of 6.5 us on St(50,5), and 24 us instead of 9 us on St(30,10).
pub(crate) const FEW_COLUMNS: usize = 6;

/// Points and ambient derivatives of eight curves, and buffers, for one shape.
pub(crate) struct LaneCovariant {
    /// Derivatives of orders 0 to 3, from Taylor coefficients.
    derivatives: [LaneMatrix; 4],
    acceleration: LaneMatrix,
    jerk: LaneMatrix,
    /// `S^T S'`, `S'^T S'` and further products.
    small: [LaneMatrix; 6],
    parts: [LaneMatrix; 2],
    normal: LaneMatrix,
}

impl LaneCovariant {
    pub(crate) fn new(rows: usize, k: usize) -> Self {
        let tall = || LaneMatrix::zeros(rows, k);
        LaneCovariant {
            derivatives: std::array::from_fn(|_| tall()),
            acceleration: tall(),
            jerk: tall(),
            small: std::array::from_fn(|_| LaneMatrix::zeros(k, k)),
            parts: std::array::from_fn(|_| LaneMatrix::zeros(k, k)),
            normal: tall(),
        }
    }

    /// Reads Taylor coefficients up to an order, of up to eight curves.
    pub(crate) fn read(&mut self, jets: &[MatrixJet], order: usize) {
        for (lane, jet) in jets.iter().enumerate() {
            let factorials = [1.0, 1.0, 2.0, 6.0];
            let all = self.derivatives.iter_mut().zip(&jet.c).zip(factorials);
            for ((to, from), factorial) in all.take(order + 1) {
                to.set_lane(lane, factorial, from.as_ref());
            }
        }
    }

    /// `D_t S'`.
    pub(crate) fn acceleration(&mut self) -> &LaneMatrix {
        Eight::run(
            #[inline(always)]
            || self.accelerate(),
        );
        &self.acceleration
    }

    /// `D_t D_t S'`.
    pub(crate) fn jerk(&mut self) -> &LaneMatrix {
        Eight::run(
            #[inline(always)]
            || {
                self.accelerate();
                self.differentiate();
            },
        );
        &self.jerk
    }

    /// Squared canonical norms of velocity, covariant acceleration, jerk (of subspaces: of its normal part), and the
    /// squared norm of `S''`; those above the given order are zero.
    pub(crate) fn squared_norms(&mut self, order: usize, subspaces: bool) -> [Lanes; 4] {
        Eight::run(
            #[inline(always)]
            || {
                let mut out = [Lanes::ZERO; 4];
                out[0] = self.squared_norm(1, false);
                if order > 1 {
                    self.accelerate();
                    out[1] = self.squared_norm(2, false);
                    let second = self.derivatives[2].entries();
                    out[3] = dot(second, second);
                }
                if order > 2 {
                    // The products of `accelerate` are still there.
                    self.differentiate();
                    out[2] = self.squared_norm(3, subspaces);
                }
                out
            },
        )
    }

    /// `|K|^2 + |Omega|^2 / 2` of the velocity (1), the acceleration (2) or the jerk (3) `K + S Omega`, or `|K|^2` alone.
    #[inline(always)]
    fn squared_norm(&mut self, which: usize, normal_only: bool) -> Lanes {
        let [s, v, ..] = &self.derivatives;
        let vector = [v, &self.acceleration, &self.jerk][which - 1];
        let [along, rest] = &mut self.parts;
        along.set_product_tn(s, vector);
        self.normal.copy_from(vector);
        self.normal.subtract_product(s, along);
        // A component along S of size eps |V| is left, which may be all of a short normal part.
        rest.set_product_tn(s, &self.normal);
        self.normal.subtract_product(s, rest);
        let normal = dot(self.normal.entries(), self.normal.entries());
        if normal_only {
            return normal;
        }
        let (k, mut skew) = (along.cols(), Lanes::ZERO);
        for j in 0..k {
            for i in 0..j {
                let twice = along.at(i, j) - along.at(j, i);
                skew += twice * twice;
            }
        }
        normal + skew * 0.25
    }

    /// `S'' + S' (S'^T S) + S S'^T P S'`; leaves `S^T S'`, `S'^T S'` and `S'^T P S'` in the first buffers.
    #[inline(always)]
    fn accelerate(&mut self) {
        let [s, v, d2, _] = &self.derivatives;
        let [along, square, normal, work, ..] = &mut self.small;
        along.set_product_tn(s, v);
        square.set_product_tn(v, v);
        work.set_product_tn(along, along);
        for ((out, x), y) in (normal.entries_mut().iter_mut())
            .zip(square.entries())
            .zip(work.entries())
        {
            *out = *x - *y;
        }
        work.set_transposed(along);
        self.acceleration.copy_from(d2);
        self.acceleration.add_product(v, work);
        self.acceleration.add_product(s, normal);
    }

    /// The jerk from the results of [`LaneCovariant::accelerate`].
    #[inline(always)]
    fn differentiate(&mut self) {
        let [s, v, d2, d3] = &self.derivatives;
        let (a, out) = (&self.acceleration, &mut self.jerk);
        let [along, square, normal, work, rate, factor] = &mut self.small;
        // The factor of S'': S'^T S. That of the acceleration is half of it.
        out.copy_from(d3);
        work.set_transposed(along);
        out.add_product(d2, work);
        work.scale(0.5);
        out.add_product(a, work);
        // The factor of S': S''^T S + S'^T S' + S'^T P S' + a^T S / 2.
        factor.set_product_tn(d2, s);
        work.set_product_tn(a, s);
        factor.add_scaled(0.5, work);
        factor.add_scaled(1.0, square);
        factor.add_scaled(1.0, normal);
        out.add_product(v, factor);
        // The factor of S is the symmetric part, doubled, of
        // S''^T P S' - (S'^T S') (S^T S') + S'^T P a / 2.
        rate.set_product_tn(d2, v);
        work.set_product_tn(v, a);
        rate.add_scaled(0.5, work);
        factor.set_product_tn(d2, s);
        rate.subtract_product(factor, along);
        rate.subtract_product(square, along);
        factor.set_product_tn(s, a);
        factor.scale(0.5);
        work.set_product_tn(along, factor);
        rate.add_scaled(-1.0, work);
        let k = rate.cols();
        for j in 0..k {
            for i in 0..k {
                factor.set(i, j, rate.at(i, j) + rate.at(j, i));
            }
        }
        out.add_product(s, factor);
    }
}
