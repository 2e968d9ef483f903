//! Eight numbers at a time, one per curve parameter: arithmetic and elementary functions without branches.
//!
//! The loops over the eight lanes are left to the compiler, which turns them into vector instructions if the caller
//! runs inside a [`Width`](super::simd::Width). No fused multiply-add is used, so results are bit-identical on
//! every processor.
//!
//! # Source
//! Polynomials and the splitting of pi/2: Sun's fdlibm (`k_sin.c`, `k_cos.c`, `s_atan.c`, `e_rem_pio2.c`), in a form
//! without branches.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Number of lanes: one AVX-512 register, two of AVX2, four of SSE2 or NEON.
pub(crate) const LANES: usize = 8;

/// Eight numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

/// Eight truth values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mask(pub(crate) [bool; LANES]);

impl Mask {
    /// Whether any lane is true.
    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.0.iter().fold(false, |any, lane| any | lane)
    }
}

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> Lanes {
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        out[l] = f(l);
    }
    Lanes(out)
}

impl Lanes {
    /// Zero in every lane.
    pub(crate) const ZERO: Lanes = Lanes([0.0; LANES]);
    /// One in every lane.
    pub(crate) const ONE: Lanes = Lanes([1.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Self {
        Lanes([x; LANES])
    }

    /// The sum of all lanes, by halves: one after another, each addition would wait for the one before.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }

    /// Absolute value.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        each(|l| self.0[l].abs())
    }

    /// Square root.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        each(|l| self.0[l].sqrt())
    }

    /// The larger of two numbers; neither may be NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.greater(other).select(self, other)
    }

    /// The smaller of two numbers; neither may be NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.greater(other).select(other, self)
    }

    /// The lanes in which `self > other`.
    #[inline(always)]
    pub(crate) fn greater(self, other: Self) -> Mask {
        let mut out = [false; LANES];
        for l in 0..LANES {
            out[l] = self.0[l] > other.0[l];
        }
        Mask(out)
    }

    /// The magnitude of `self` with the sign of `sign`.
    #[inline(always)]
    pub(crate) fn copysign(self, sign: Self) -> Self {
        each(|l| self.0[l].copysign(sign.0[l]))
    }

    /// Sine and cosine, to about one unit in the last place (absolute) for `|x| <= 1e5`:
    /// the product with the first part of pi/2 is exact there.
    #[inline(always)]
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let turns = self * Lanes::splat(std::f64::consts::FRAC_2_PI);
        // Adding and subtracting 1.5 * 2^52 rounds to an integer, whose lowest bits are those of the sum.
        let shifted = turns + Lanes::splat(ROUNDER);
        let whole = shifted - Lanes::splat(ROUNDER);
        let mut quadrant = [0_u64; LANES];
        for l in 0..LANES {
            quadrant[l] = shifted.0[l].to_bits();
        }
        let r = self - whole * Lanes::splat(PIO2_HIGH) - whole * Lanes::splat(PIO2_LOW);
        let z = r * r;
        let sine = r + r * z * polynomial(z, &SIN);
        let half = z * Lanes::splat(0.5);
        let w = Lanes::ONE - half;
        let cosine = w + ((Lanes::ONE - w - half) + z * z * polynomial(z, &COS));
        let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let odd = quadrant[l] & 1 == 1;
            let (s, c) = (sine.0[l].to_bits(), cosine.0[l].to_bits());
            let (s, c) = if odd { (c, s) } else { (s, c) };
            let (sign_s, sign_c) = (quadrant[l] << 62, (quadrant[l] + 1) << 62);
            sin[l] = f64::from_bits(s ^ (sign_s & SIGN));
            cos[l] = f64::from_bits(c ^ (sign_c & SIGN));
        }
        (Lanes(sin), Lanes(cos))
    }

    /// The angle of the point `(x, y)` with `y = self`, in `[-pi, pi]`; zero at the origin.
    #[inline(always)]
    pub(crate) fn atan2(self, x: Self) -> Self {
        let (a, b) = (self.abs(), x.abs());
        let (low, high) = (a.min(b), a.max(b).max(Lanes::splat(f64::MIN_POSITIVE)));
        let reduce = low.greater(high * Lanes::splat(TAN_PI_8));
        let numerator = reduce.select(low - high, low);
        let denominator = reduce.select(low + high, high);
        let q = numerator / denominator;
        let z = q * q;
        let offset = reduce.select(Lanes::splat(std::f64::consts::FRAC_PI_4), Lanes::ZERO);
        let angle = offset + (q - q * z * polynomial(z, &ATAN));
        let angle = a
            .greater(b)
            .select(Lanes::splat(std::f64::consts::FRAC_PI_2) - angle, angle);
        let angle = Lanes::ZERO
            .greater(x)
            .select(Lanes::splat(std::f64::consts::PI) - angle, angle);
        angle.copysign(self)
    }
}

impl Mask {
    /// `a` in the lanes that are true, `b` in the others.
    #[inline(always)]
    pub(crate) fn select(self, a: Lanes, b: Lanes) -> Lanes {
        each(|l| if self.0[l] { a.0[l] } else { b.0[l] })
    }
}

const SIGN: u64 = 1 << 63;

const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// The first 33 bits of pi/2, and the remainder.
const PIO2_HIGH: f64 = 1.570_796_326_734_125_6;
const PIO2_LOW: f64 = 6.077_100_506_506_192e-11;

const TAN_PI_8: f64 = 0.414_213_562_373_095_03;

const SIN: [f64; 6] = [
    -0.166_666_666_666_666_32,
    0.008_333_333_333_322_49,
    -0.000_198_412_698_298_579_5,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

const COS: [f64; 6] = [
    0.041_666_666_666_666_6,
    -0.001_388_888_888_887_411,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

const ATAN: [f64; 11] = [
    0.333_333_333_333_329_3,
    -0.199_999_999_998_764_83,
    0.142_857_142_725_034_66,
    -0.111_111_104_054_623_56,
    0.090_908_871_334_365_07,
    -0.076_918_762_050_448_3,
    0.066_610_731_373_875_31,
    -0.058_335_701_337_905_735,
    0.049_768_779_946_159_324,
    -0.036_531_572_744_216_916,
    0.016_285_820_115_365_782,
];

/// Horner's rule.
#[inline(always)]
fn polynomial<const N: usize>(z: Lanes, coefficients: &[f64; N]) -> Lanes {
    let mut sum = Lanes::splat(coefficients[N - 1]);
    for j in (0..N - 1).rev() {
        sum = sum * z + Lanes::splat(coefficients[j]);
    }
    sum
}

impl Add for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn add(self, other: Lanes) -> Lanes {
        each(|l| self.0[l] + other.0[l])
    }
}

impl Sub for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn sub(self, other: Lanes) -> Lanes {
        each(|l| self.0[l] - other.0[l])
    }
}

impl Mul for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, other: Lanes) -> Lanes {
        each(|l| self.0[l] * other.0[l])
    }
}

impl Mul<f64> for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, other: f64) -> Lanes {
        each(|l| self.0[l] * other)
    }
}

impl Div for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn div(self, other: Lanes) -> Lanes {
        each(|l| self.0[l] / other.0[l])
    }
}

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        each(|l| -self.0[l])
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Lanes) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Lanes) {
        *self = *self - other;
    }
}
