//! Quasi-geodesics at eight parameters at once: the stages of de Casteljau's algorithm away from singularities.
//!
//! With the polar decomposition `S0^T S1 = P R` (`P` symmetric, `R` a rotation) the quasi-geodesic between two points
//! is
//!
//! ```math
//! \beta(t) = (S_0\, a_t(P) + S_1 R^T b_t(P))\, R^t,\qquad
//! b_t(\cos\theta) = \frac{\sin t\theta}{\sin\theta},\quad a_t(\cos\theta) = \cos t\theta - \cos\theta\, b_t
//! ```
//!
//! in which `a_t`, `b_t` and `R^t` are analytic functions of cosines except near -1. So small angles need no care, no
//! basis of the normal space is formed, and round-off in a cosine causes only round-off in the result. Near the edge of
//! the domain (a cosine near -1, a relative rotation near pi, two branches close to each other) a lane is marked, and
//! the caller recomputes it with [`QuasiGeodesic`](super::QuasiGeodesic).
//!
//! | k | algorithm |
//! |---|---|
//! | 1 | great circle |
//! | 2 | the rotation and reflection parts of a 2 x 2 matrix: polar decomposition and eigenvectors in closed form |
//! | 3 | one-sided Jacobi; Rodrigues' formula for `R^t` |
//! | above | one-sided Jacobi; `R^t = T_t(C) + K w_t(C)`, `C` and `K` the symmetric and the skew part of `R`, by Jacobi on `C` |

use std::f64::consts::PI;

use super::lane_margin::{DETERMINED, LOWEST_COSINE, Margin, TINY};
use super::lane_principal::LanePrincipal;
use crate::linalg::lane_matrix::{LaneMatrix, diagonalise, dot};
use crate::linalg::lanes::{LANES, Lanes, Mask};

/// For k = 2 the rotation angle is accurate up to pi itself, and only its sign needs a margin.
const NEAR_PI: f64 = PI - 1e-10;

/// Buffers for joining points of one shape.
pub(crate) struct LaneJoin {
    /// Rows of a point, which distinguish one component from two.
    rows: usize,
    general: Option<Box<GeneralJoin>>,
}

impl LaneJoin {
    pub(crate) fn new(rows: usize, k: usize) -> Self {
        LaneJoin {
            rows,
            general: (k > 2).then(|| Box::new(GeneralJoin::new(rows, k))),
        }
    }

    /// `s0 <- beta(t)` of the principal quasi-geodesic from `s0` to `s1`.
    #[inline(always)]
    pub(crate) fn advance(
        &mut self,
        s0: &mut LaneMatrix,
        s1: &LaneMatrix,
        t: Lanes,
        margin: &mut Margin,
    ) {
        match (&mut self.general, s0.cols()) {
            (Some(general), _) => general.advance(s0, s1, t, self.rows, margin),
            (None, 1) => great_circle(s0, s1, t, margin),
            (None, _) => two_frame(s0, s1, t, self.rows, margin),
        }
    }
}

/// `cos(t theta)` and `sin(t theta) / sin(theta)` from `cos(theta)`.
#[inline(always)]
fn turn(cosine: Lanes, t: Lanes) -> (Lanes, Lanes) {
    let sine = ((Lanes::ONE - cosine) * (Lanes::ONE + cosine))
        .max(Lanes::splat(TINY))
        .sqrt();
    let (sin, cos) = (t * sine.atan2(cosine)).sin_cos();
    (cos, sin / sine)
}

#[inline(always)]
fn great_circle(s0: &mut LaneMatrix, s1: &LaneMatrix, t: Lanes, margin: &mut Margin) {
    let cosine = dot(s0.col(0), s1.col(0));
    let (cos, b) = turn(cosine, t);
    let a = cos - cosine * b;
    for (x, &y) in s0.col_mut(0).iter_mut().zip(s1.col(0)) {
        *x = *x * a + y * b;
    }
    margin.see(
        Lanes::ONE + cosine,
        Lanes::splat(LOWEST_COSINE).greater(cosine),
    );
}

/// `M = q Rot(omega) + r Refl(phi)` gives `R = Rot(omega)` and `P = q I + r Refl(phi + omega)`, whose eigenvalues are
/// `q + r` and `q - r`; the second is negative if `det M` is, and this is then the principal branch.
#[inline(always)]
fn two_frame(s0: &mut LaneMatrix, s1: &LaneMatrix, t: Lanes, rows: usize, margin: &mut Margin) {
    let half = Lanes::splat(0.5);
    let m = |i: usize, j: usize| dot(s0.col(i), s1.col(j));
    let (m00, m10, m01, m11) = (m(0, 0), m(1, 0), m(0, 1), m(1, 1));
    let (e, h) = ((m00 + m11) * half, (m10 - m01) * half);
    let (f, g) = ((m00 - m11) * half, (m10 + m01) * half);
    let q = (e * e + h * h).sqrt();
    let safe_q = q.max(Lanes::splat(TINY));
    let (e, h) = (e / safe_q, h / safe_q);
    let r = (f * f + g * g).sqrt();
    let safe_r = r.max(Lanes::splat(TINY));
    let (f, g) = (f / safe_r, g / safe_r);
    let (larger, smaller) = (q + r, q - r);
    let omega = h.atan2(e);
    let (sin, cos) = (t * omega).sin_cos();
    // Mean and half difference of the two weights, the factors of the identity and of the reflection.
    let ((cos1, b1), (cos2, b2)) = (turn(larger, t), turn(smaller, t));
    let (a1, a2) = (cos1 - larger * b1, cos2 - smaller * b2);
    let (a_mean, a_half) = ((a1 + a2) * half, (a1 - a2) * half);
    let (b_mean, b_half) = ((b1 + b2) * half, (b1 - b2) * half);
    // Refl(phi - t omega), then Refl(phi + omega - t omega); Rot((t - 1) omega).
    let (fb, gb) = (f * cos + g * sin, g * cos - f * sin);
    let (fa, ga) = (fb * e - gb * h, gb * e + fb * h);
    let (eb, hb) = (cos * e + sin * h, sin * e - cos * h);
    let left = mixture(a_mean, cos, sin, a_half, fa, ga);
    let right = mixture(b_mean, eb, hb, b_half, fb, gb);
    let (first, second) = s0.two_columns();
    for (i, (x, y)) in first.iter_mut().zip(second).enumerate() {
        let (u, v) = (s1.at(i, 0), s1.at(i, 1));
        (*x, *y) = (
            *x * left[0][0] + *y * left[1][0] + u * right[0][0] + v * right[1][0],
            *x * left[0][1] + *y * left[1][1] + u * right[0][1] + v * right[1][1],
        );
    }
    let hard = [
        Lanes::splat(LOWEST_COSINE).greater(smaller),
        Lanes::splat(DETERMINED).greater(q + q),
        omega.abs().greater(Lanes::splat(NEAR_PI)),
        // O(2) has two components.
        r.greater(if rows == 2 { q } else { Lanes::splat(f64::MAX) }),
    ];
    let least = (Lanes::ONE + smaller).min(Lanes::ONE + e).min(q + q);
    for mask in hard {
        margin.see(least, mask);
    }
}

/// `a Rot + b Refl` by rows, each given by its cosine and sine.
#[inline(always)]
fn mixture(a: Lanes, cos: Lanes, sin: Lanes, b: Lanes, f: Lanes, g: Lanes) -> [[Lanes; 2]; 2] {
    [
        [a * cos + b * f, b * g - a * sin],
        [a * sin + b * g, a * cos - b * f],
    ]
}

struct GeneralJoin {
    principal: LanePrincipal,
    gram: LaneMatrix,
    symmetric: LaneMatrix,
    vectors: LaneMatrix,
    power: LaneMatrix,
    work: LaneMatrix,
    point: LaneMatrix,
}

impl GeneralJoin {
    fn new(rows: usize, k: usize) -> Self {
        let square = || LaneMatrix::zeros(k, k);
        GeneralJoin {
            principal: LanePrincipal::new(k),
            gram: square(),
            symmetric: square(),
            vectors: square(),
            power: square(),
            work: square(),
            point: LaneMatrix::zeros(rows, k),
        }
    }

    #[inline(always)]
    fn advance(
        &mut self,
        s0: &mut LaneMatrix,
        s1: &LaneMatrix,
        t: Lanes,
        rows: usize,
        margin: &mut Margin,
    ) {
        let k = s0.cols();
        self.principal.gram.set_product_tn(s0, s1);
        self.principal.factor(rows, margin);
        if k == 3 {
            self.power_in_space(t, margin);
        } else {
            self.power_by_jacobi(t, margin);
        }
        // S0 (U a G) + S1 (Z b G) with G = U^T R^t.
        let LanePrincipal { u, z, cosines, .. } = &mut self.principal;
        self.work.set_product_tn(u, &self.power);
        for (i, &cosine) in cosines.iter().enumerate() {
            let (cos, b) = turn(cosine, t);
            let a = cos - cosine * b;
            for x in u.col_mut(i) {
                *x = *x * a;
            }
            for x in z.col_mut(i) {
                *x = *x * b;
            }
        }
        self.gram.set_product(u, &self.work);
        self.point.set_product(s0, &self.gram);
        self.gram.set_product(z, &self.work);
        self.point.add_product(s1, &self.gram);
        s0.copy_from(&self.point);
    }

    /// `R^t = I + sin(t theta) u + (1 - cos(t theta)) u^2` with the unit axis `u` of `R`.
    #[inline(always)]
    fn power_in_space(&mut self, t: Lanes, margin: &mut Margin) {
        let r = |i: usize, j: usize| self.principal.rotation.at(i, j);
        let half = Lanes::splat(0.5);
        let w = [
            (r(2, 1) - r(1, 2)) * half,
            (r(0, 2) - r(2, 0)) * half,
            (r(1, 0) - r(0, 1)) * half,
        ];
        let cosine = (r(0, 0) + r(1, 1) + r(2, 2) - Lanes::ONE) * half;
        let sine = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
            .max(Lanes::splat(TINY))
            .sqrt();
        let angle = sine.atan2(cosine);
        let (first, _) = (t * angle).sin_cos();
        let (second, _) = (t * angle * half).sin_cos();
        let (first, second) = (first / sine, second / sine);
        let second = second * second * 2.0;
        for j in 0..3 {
            for i in 0..3 {
                self.power.set(i, j, second * w[i] * w[j]);
            }
        }
        // second * |w|^2 = 1 - cos(t angle).
        let diagonal = Lanes::ONE - second * sine * sine;
        for j in 0..3 {
            let (next, last) = ((j + 1) % 3, (j + 2) % 3);
            self.power.set(j, j, self.power.at(j, j) + diagonal);
            self.power
                .set(next, j, self.power.at(next, j) + first * w[last]);
            self.power
                .set(last, j, self.power.at(last, j) - first * w[next]);
        }
        margin.see(
            Lanes::ONE + cosine,
            Lanes::splat(LOWEST_COSINE).greater(cosine),
        );
    }

    /// `R^t = T_t(C) + K w_t(C)`: functions of the symmetric part only, so the rotation planes need not be separated.
    #[inline(always)]
    fn power_by_jacobi(&mut self, t: Lanes, margin: &mut Margin) {
        let k = self.symmetric.cols();
        let half = Lanes::splat(0.5);
        for j in 0..k {
            for i in 0..k {
                let mean =
                    (self.principal.rotation.at(i, j) + self.principal.rotation.at(j, i)) * half;
                self.symmetric.set(i, j, mean);
            }
        }
        let converged = diagonalise(&mut self.symmetric, &mut self.vectors);
        let mut least = Lanes::ONE;
        for i in 0..k {
            let cosine = self.symmetric.at(i, i);
            let (cos, weight) = turn(cosine, t);
            for l in 0..k {
                let x = self.vectors.at(l, i);
                self.work.set(l, i, x * cos);
                self.gram.set(l, i, x * weight);
            }
            least = least.min(cosine);
        }
        self.power.set_product_nt(&self.work, &self.vectors);
        self.symmetric.set_product_nt(&self.gram, &self.vectors);
        for j in 0..k {
            for i in 0..k {
                let skew =
                    (self.principal.rotation.at(i, j) - self.principal.rotation.at(j, i)) * half;
                self.work.set(i, j, skew);
            }
        }
        self.power.add_product(&self.work, &self.symmetric);
        margin.see(
            Lanes::ONE + least,
            Lanes::splat(LOWEST_COSINE).greater(least),
        );
        margin.see(Lanes::ONE + least, Mask([!converged; LANES]));
    }
}
