//! Derivatives of a quasi-geodesic with moving end points: one stage of de Casteljau's algorithm, differentiated.
//!
//! With the polar decomposition `S0^T S1 = P R` (`P` symmetric, `R` a rotation) the quasi-geodesic is a composition of
//! functions that are analytic even where principal angles vanish or repeat:
//!
//! ```math
//! \beta = (S_0\, a_t(P) + S_1 R^T b_t(P))\, R^t,\qquad
//! a_t = \frac{s_{1-t}}{s_1},\quad b_t = \frac{s_t}{s_1},\quad s_t = \frac{\sin t\Theta}{\Theta},\quad \cos\Theta = P
//! ```
//!
//! Every function is evaluated on truncated Taylor polynomials. The inverse functions (polar factor, angle, logarithm)
//! start from the factorisation at the point and gain one order per linear solve, which is elementwise in the
//! eigenbasis. There are no difference quotients and no derivatives of singular vectors, so repeated singular values
//! need no special treatment.

use faer::{Mat, MatRef};

use super::grassmann::alignment::unique_alignment;
use super::quasi_geodesic::{EndpointProblem, QuasiGeodesic};
use crate::error::{Error, Result};
use crate::linalg::SkewSchur;
use crate::linalg::jet::{MatrixJet, ORDER, ScalarJet};
use crate::linalg::jet_exp::JetExp;
use crate::linalg::orthogonal_log::inverse_dexp;
use crate::linalg::product::{mul_add, mul_into};
use crate::linalg::skew_schur::apply_ad_function;
use crate::linalg::structure::check_range;

/// Quantity named in `Overflow` errors.
const DERIVATIVES: &str = "derivative of a de Casteljau curve";

/// A series is truncated when the next term, including its derivatives up to the third, is below this.
const TRUNCATION: f64 = 1e-17;

/// Buffers for points of one shape.
pub(crate) struct MovingQuasiGeodesic {
    curve: QuasiGeodesic,
    problem: EndpointProblem,
    schur: SkewSchur,
    /// `S0 U` and `S1 Z`, shape `(r, k)`.
    start: MatrixJet,
    end: MatrixJet,
    /// For subspaces, `S1` in the basis nearest to `S0`.
    aligned: Mat<f64>,
    wide: MatrixJet,
    gram: MatrixJet,
    symmetric: MatrixJet,
    rotation: MatrixJet,
    angle_squared: MatrixJet,
    argument: MatrixJet,
    sine: MatrixJet,
    cosine: MatrixJet,
    whole: MatrixJet,
    inverse: MatrixJet,
    weight: MatrixJet,
    log: MatrixJet,
    power: JetExp,
    work: [MatrixJet; 2],
    small: [Mat<f64>; 2],
}

impl MovingQuasiGeodesic {
    pub(crate) fn new(r: usize, k: usize) -> Self {
        let square = || MatrixJet::zeros(k, k);
        let tall = || MatrixJet::zeros(r, k);
        MovingQuasiGeodesic {
            curve: QuasiGeodesic::zeros(r, k),
            problem: EndpointProblem::new(r, k),
            schur: SkewSchur::new(k),
            start: tall(),
            end: tall(),
            aligned: Mat::zeros(r, k),
            wide: tall(),
            gram: square(),
            symmetric: square(),
            rotation: square(),
            angle_squared: square(),
            argument: square(),
            sine: square(),
            cosine: square(),
            whole: square(),
            inverse: square(),
            weight: square(),
            log: square(),
            power: JetExp::new(k),
            work: [square(), square()],
            small: [Mat::zeros(k, k), Mat::zeros(k, k)],
        }
    }

    /// `out(tau) = beta(S0(tau), S1(tau); t + tau)` up to the given order.
    ///
    /// # Errors
    /// The errors of [`QuasiGeodesic::between`].
    pub(crate) fn jet_into(
        &mut self,
        s0: &MatrixJet,
        s1: &MatrixJet,
        t: f64,
        order: usize,
        out: &mut MatrixJet,
    ) -> Result<()> {
        self.curve
            .join(s0.c[0].as_ref(), s1.c[0].as_ref(), &mut self.problem)?;
        self.start
            .set_product_constant(s0, self.problem.principal.u.as_ref(), order);
        self.end
            .set_product_constant(s1, self.problem.principal.z.as_ref(), order);
        self.interpolate(t, order, out)?;
        // Then the rotation: `U^T R^t`.
        self.logarithm(order)?;
        self.power
            .compute(&[t, 1.0, 0.0, 0.0], &self.log, order, DERIVATIVES)?;
        for j in 0..=order {
            mul_into(
                &mut self.work[0].c[j],
                1.0,
                self.problem.principal.u.transpose(),
                &self.power.value.c[j],
            );
        }
        out.set_product(&self.wide, &self.work[0], order);
        Ok(())
    }

    /// As `jet_into`, for the geodesic between the spans of the columns, with the bases `e^{tX} S0` without the factor
    /// `R^t`, for any basis of the end; returns the cosine of the largest principal angle.
    ///
    /// # Errors
    /// `RightAngle`, `Overflow`, `Decomposition`.
    pub(crate) fn span_jet_into(
        &mut self,
        s0: &MatrixJet,
        s1: &MatrixJet,
        t: f64,
        order: usize,
        out: &mut MatrixJet,
    ) -> Result<f64> {
        let (turn, cosine) = unique_alignment(s0.c[0].as_ref(), s1.c[0].as_ref())?;
        mul_into(&mut self.aligned, 1.0, &s1.c[0], &turn);
        self.curve
            .join(s0.c[0].as_ref(), self.aligned.as_ref(), &mut self.problem)?;
        let principal = &self.problem.principal;
        let end_factor = &mut self.small[0];
        mul_into(&mut *end_factor, 1.0, &turn, &principal.z);
        self.start
            .set_product_constant(s0, principal.u.as_ref(), order);
        self.end
            .set_product_constant(s1, end_factor.as_ref(), order);
        self.interpolate(t, order, out)?;
        out.set_product_constant(&self.wide, self.problem.principal.u.transpose(), order);
        Ok(cosine)
    }

    /// `wide = start a_t(P) + end R^T b_t(P)` for the joined ends; overwrites `out`.
    fn interpolate(&mut self, t: f64, order: usize, out: &mut MatrixJet) -> Result<()> {
        self.polar(order)?;
        self.angles(order)?;
        // Interpolation in the aligned frame: `start a_t(P) + end R^T b_t(P)`.
        self.sine(&one_jet(), order)?;
        std::mem::swap(&mut self.sine, &mut self.whole);
        self.invert_whole(order);
        self.sine(&[1.0 - t, -1.0, 0.0, 0.0], order)?;
        self.weight.set_product(&self.sine, &self.inverse, order);
        self.wide.set_product(&self.start, &self.weight, order);
        self.sine(&[t, 1.0, 0.0, 0.0], order)?;
        self.weight.set_product(&self.sine, &self.inverse, order);
        self.start.set_product_nt(&self.end, &self.rotation, order);
        out.set_product(&self.start, &self.weight, order);
        self.wide.add(1.0, out, order);
        Ok(())
    }

    /// Computes `(S0 U)^T (S1 Z) = P R` with `P_0 = diag(c)`, `R_0 = I` order by order; each order solves `C w + w C =
    /// given` for a skew `w`.
    fn polar(&mut self, order: usize) -> Result<()> {
        self.gram.set_product_tn(&self.start, &self.end, order);
        let (p, r, c) = (
            &mut self.symmetric,
            &mut self.rotation,
            &self.problem.principal.cosines,
        );
        let k = c.len();
        p.set_scalar(0.0, order);
        r.set_scalar(1.0, order);
        for i in 0..k {
            p.c[0][(i, i)] = c[i];
        }
        for j in 1..=order {
            // Symmetric part of R_j from R R^T = I, then T = M_j - sum P_i R_{j-i} without the unknown part.
            let [half, rest] = &mut self.small;
            half.fill(0.0);
            rest.copy_from(&self.gram.c[j]);
            for i in 1..j {
                mul_add(&mut *half, -0.5, &r.c[i], r.c[j - i].transpose());
                mul_add(&mut *rest, -1.0, &p.c[i], &r.c[j - i]);
            }
            for b in 0..k {
                for a in 0..k {
                    rest[(a, b)] -= c[a] * half[(a, b)];
                }
            }
            for b in 0..k {
                for a in b + 1..k {
                    let sum = c[a] + c[b];
                    if sum.abs() <= f64::EPSILON {
                        // The two smallest cosines are c and -c: two branches have equal length.
                        return Err(Error::NoJoiningCurve { angle: c[a].acos() });
                    }
                    let w = (rest[(a, b)] - rest[(b, a)]) / sum;
                    half[(a, b)] += w;
                    half[(b, a)] -= w;
                    rest[(a, b)] -= c[a] * w;
                    rest[(b, a)] += c[b] * w;
                }
            }
            r.c[j].copy_from(&*half);
            p.c[j].copy_from(&*rest);
        }
        Ok(())
    }

    /// `Y = Theta^2` from `cos sqrt(Y) = P`: the derivative of the cosine in the eigenbasis is the divided
    /// difference `-sinc((a+b)/2) sinc((a-b)/2) / 2`, which never vanishes below pi.
    fn angles(&mut self, order: usize) -> Result<()> {
        let k = self.problem.principal.cosines.len();
        self.angle_squared.set_scalar(0.0, order);
        for i in 0..k {
            self.angle_squared.c[0][(i, i)] = self.curve.angles()[i].powi(2);
        }
        for j in 1..=order {
            self.argument.copy_from(&self.angle_squared, j);
            self.series(Parity::Even, j)?;
            for b in 0..k {
                for a in 0..k {
                    let (x, y) = (self.curve.angles()[a], self.curve.angles()[b]);
                    let difference = -0.5 * sinc(0.5 * (x + y)) * sinc(0.5 * (x - y));
                    let missing = self.symmetric.c[j][(a, b)] - self.cosine.c[j][(a, b)];
                    self.angle_squared.c[j][(a, b)] = missing / difference;
                }
            }
        }
        Ok(())
    }

    /// `sine = sin(t Theta) / Theta`, an entire function of `Y = Theta^2`: its series for `|t| <= 1`, angle doubling
    /// beyond.
    fn sine(&mut self, t: &ScalarJet, order: usize) -> Result<()> {
        let doublings = t[0].abs().log2().ceil().max(0.0) as i32;
        let shrink = 0.5_f64.powi(doublings);
        let t: ScalarJet = t.map(|x| x * shrink);
        self.argument
            .set_scaled(&scalar_product(&t, &t), &self.angle_squared, order);
        self.series(Parity::Odd, order)?;
        self.work[0].set_scaled(&t, &self.sine, order);
        std::mem::swap(&mut self.work[0], &mut self.sine);
        if doublings > 0 {
            self.series(Parity::Even, order)?;
        }
        for _ in 0..doublings {
            let [sine, cosine] = &mut self.work;
            sine.set_product(&self.sine, &self.cosine, order);
            sine.rescale(2.0, order);
            cosine.set_product(&self.cosine, &self.cosine, order);
            cosine.rescale(2.0, order);
            cosine.add_identity(-1.0);
            std::mem::swap(sine, &mut self.sine);
            std::mem::swap(cosine, &mut self.cosine);
        }
        Ok(())
    }

    /// `cosine = cos sqrt(W)` or `sine = sin sqrt(W) / sqrt(W)` for the argument `W`, by Horner's rule.
    fn series(&mut self, parity: Parity, order: usize) -> Result<()> {
        check_range(DERIVATIVES, self.argument.c[0].as_ref())?;
        let largest =
            (0..self.argument.c[0].ncols()).fold(0.0_f64, |m, i| m.max(self.argument.c[0][(i, i)]));
        let (target, offset) = match parity {
            Parity::Even => (&mut self.cosine, 0),
            Parity::Odd => (&mut self.sine, 1),
        };
        let factors = (1..=series_terms(largest))
            .rev()
            .map(|j| -1.0 / ((2 * j + offset - 1) * (2 * j + offset)) as f64);
        match self.argument.c[0].ncols() {
            1 => small_series::<1>(&self.argument, factors, target, order),
            2 => small_series::<2>(&self.argument, factors, target, order),
            3 => small_series::<3>(&self.argument, factors, target, order),
            4 => small_series::<4>(&self.argument, factors, target, order),
            _ => {
                let product = &mut self.work[1];
                target.set_scalar(1.0, order);
                for factor in factors {
                    product.set_product(target, &self.argument, order);
                    product.rescale(factor, order);
                    product.add_identity(1.0);
                    std::mem::swap(target, product);
                }
            }
        }
        Ok(())
    }

    /// `inverse = whole^{-1}`; the constant term is diagonal.
    fn invert_whole(&mut self, order: usize) {
        let k = self.problem.principal.cosines.len();
        self.inverse.set_scalar(0.0, order);
        for i in 0..k {
            self.inverse.c[0][(i, i)] = 1.0 / sinc(self.curve.angles()[i]);
        }
        for j in 1..=order {
            let sum = &mut self.small[0];
            sum.fill(0.0);
            for i in 1..=j {
                mul_add(&mut *sum, 1.0, &self.whole.c[i], &self.inverse.c[j - i]);
            }
            for b in 0..k {
                for a in 0..k {
                    self.inverse.c[j][(a, b)] = -self.inverse.c[0][(a, a)] * sum[(a, b)];
                }
            }
        }
    }

    /// `log R` about `Omega = log R_0`: at each new order, the residual of `e^{-L} R = I` is mapped back by the inverse
    /// derivative of the exponential in the Schur basis of `Omega`.
    fn logarithm(&mut self, order: usize) -> Result<()> {
        let k = self.problem.principal.cosines.len();
        self.log.set_scalar(0.0, order);
        self.log.c[0].copy_from(self.curve.omega());
        if k == 1 {
            return Ok(());
        }
        self.schur.compute(self.curve.omega())?;
        for j in 1..=order {
            self.power
                .compute(&[-1.0, 0.0, 0.0, 0.0], &self.log, j, DERIVATIVES)?;
            // In the frame of the factorisation R = U R~ Z^T.
            let residual = &mut self.work[0].c[j];
            residual.fill(0.0);
            for i in 0..=j {
                let [left, right] = &mut self.small;
                mul_into(
                    &mut *left,
                    1.0,
                    &self.problem.principal.u,
                    &self.rotation.c[i],
                );
                mul_into(
                    &mut *right,
                    1.0,
                    &left,
                    self.problem.principal.z.transpose(),
                );
                mul_add(&mut *residual, 1.0, &self.power.value.c[j - i], &right);
            }
            let [left, right] = &mut self.small;
            let v = self.schur.basis();
            conjugate(right, v.transpose(), residual.as_ref(), v, left);
            for b in 0..k {
                for a in b..k {
                    let entry = 0.5 * (right[(a, b)] - right[(b, a)]);
                    right[(a, b)] = entry;
                    right[(b, a)] = -entry;
                }
            }
            apply_ad_function(self.schur.angles(), right.as_mut(), |x, _| inverse_dexp(x));
            conjugate(&mut self.log.c[j], v, right.as_ref(), v.transpose(), left);
        }
        Ok(())
    }
}

/// Selects one of the two trigonometric series.
#[derive(Clone, Copy)]
enum Parity {
    Even,
    Odd,
}

/// `I + f_1 W (I + f_2 W (I + ...))`, evaluated from the last factor to the first, without storing matrices.
fn small_series<const K: usize>(
    argument: &MatrixJet,
    factors: impl Iterator<Item = f64>,
    target: &mut MatrixJet,
    order: usize,
) {
    let zero = [[[0.0; K]; K]; ORDER + 1];
    let (mut w, mut sum) = (zero, zero);
    for m in 0..=order {
        for j in 0..K {
            for i in 0..K {
                w[m][j][i] = argument.c[m][(i, j)];
            }
        }
    }
    for i in 0..K {
        sum[0][i][i] = 1.0;
    }
    for factor in factors {
        let mut product = zero;
        for m in 0..=order {
            for part in 0..=m {
                for j in 0..K {
                    for l in 0..K {
                        let entry = factor * w[m - part][j][l];
                        for i in 0..K {
                            product[m][j][i] += sum[part][l][i] * entry;
                        }
                    }
                }
            }
        }
        for i in 0..K {
            product[0][i][i] += 1.0;
        }
        sum = product;
    }
    for m in 0..=order {
        for j in 0..K {
            for i in 0..K {
                target.c[m][(i, j)] = sum[m][j][i];
            }
        }
    }
}

/// Number of terms of `cos sqrt(w)` for arguments up to `w`, including derivatives up to the third (the factor `j^3`).
pub(super) fn series_terms(w: f64) -> usize {
    let mut size = 1.0;
    for j in 1.. {
        size *= w.max(1.0) / ((2 * j - 1) * (2 * j)) as f64;
        if size * (j * j * j) as f64 <= TRUNCATION {
            return j;
        }
    }
    unreachable!("the factorial wins")
}

/// `out = l m r`.
fn conjugate(
    out: &mut Mat<f64>,
    l: MatRef<'_, f64>,
    m: MatRef<'_, f64>,
    r: MatRef<'_, f64>,
    work: &mut Mat<f64>,
) {
    mul_into(&mut *work, 1.0, l, m);
    mul_into(&mut *out, 1.0, &work, r);
}

fn one_jet() -> ScalarJet {
    let mut one = [0.0; ORDER + 1];
    one[0] = 1.0;
    one
}

fn scalar_product(a: &ScalarJet, b: &ScalarJet) -> ScalarJet {
    let mut out = [0.0; ORDER + 1];
    for i in 0..=ORDER {
        for j in 0..=ORDER - i {
            out[i + j] += a[i] * b[j];
        }
    }
    out
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}
