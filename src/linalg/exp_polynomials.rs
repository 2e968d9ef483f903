//! Polynomials for the even and the odd part of the exponential of a skew matrix, and their evaluation.
//!
//! # Source
//! Polynomials fitted to the imaginary axis: Bader, Blanes, Seydaoglu (2015), SIAM J. Matrix Anal. Appl. 36, 594-613.

use super::scalar::SquareBuffer;
use super::simd::vectorised;
use super::square::{LANES, Square};

/// Polynomials in `B = A^2` for the even and the odd part. Up to degree 4 each power is a product; above, the
/// coefficients from `powers` on are multiplied by `B^powers` in one Horner step.
pub(super) struct Scheme {
    /// The largest norm of `A` for which `|cos x - even(-x^2)|` and `|sin x - x odd(-x^2)|` are at most `2^-54`.
    pub(super) limit: f64,
    pub(super) powers: usize,
    pub(super) even: &'static [f64],
    pub(super) odd: &'static [f64],
}

/// Interpolation of `(cos x - 1) / x^2` and `(sin x - x) / x^3` in `x^2` at the Chebyshev points of `[0, limit^2]`. It
/// is exact at 0, and for the same error admits a norm up to a third larger than the Taylor polynomial.
#[rustfmt::skip]
pub(super) const SCHEMES: [Scheme; 6] = [
    Scheme { limit: 0.000227, powers: 1,
        even: &[1.0, 0.49999999892647917],
        odd: &[1.0, 0.1666666664519625] },
    Scheme { limit: 0.008261, powers: 2,
        even: &[1.0, 0.4999999999991914, 0.04166657188326635],
        odd: &[1.0, 0.16666666666655117, 0.008333319792844365] },
    Scheme { limit: 0.05388, powers: 3,
        even: &[1.0, 0.499999999999981, 0.041666666549097855, 0.0013887808922722297],
        odd: &[1.0, 0.16666666666666455, 0.008333333320270022, 0.00019840069870945357] },
    Scheme { limit: 0.1741, powers: 4,
        even: &[1.0, 0.49999999999999817, 0.041666666664749, 0.001388888572542734,
        2.4784886881822717e-05],
        odd: &[1.0, 0.1666666666666665, 0.008333333333158988, 0.00019841266965212826,
        2.754213628674306e-06] },
    Scheme { limit: 0.7189, powers: 3,
        even: &[1.0, 0.4999999999999999, 0.04166666666665189, 0.0013888888885553372,
        2.4801584547014487e-05, 2.7556290689001687e-07, 2.06996248830853e-09],
        odd: &[1.0, 0.16666666666666666, 0.008333333333332348, 0.0001984126983904452,
        2.755731738631664e-06, 2.5051422264281525e-08, 1.594089970302928e-10] },
    Scheme { limit: 1.684, powers: 4,
        even: &[1.0, 0.5, 0.04166666666666579, 0.0013888888888824184,
        2.4801587283323645e-05, 2.7557316691423217e-07, 2.0876566164063676e-09, 1.1462770642855358e-11,
        4.605407096549608e-14],
        odd: &[1.0, 0.16666666666666666, 0.008333333333333286, 0.00019841269841235692,
        2.755731921434689e-06, 2.5052107048956896e-08, 1.605894315072643e-10, 7.642956974951286e-13,
        2.7196871475899573e-15] },
];

pub(super) fn last_scheme() -> &'static Scheme {
    &SCHEMES[SCHEMES.len() - 1]
}

/// `out = c_0 I + c_1 B + c_2 B^2 + ..`, with as many powers as given.
pub(super) fn combine<S: SquareBuffer>(out: &mut S, powers: &[S], c: &[f64]) {
    for (part, target) in out.parts_mut().iter_mut().enumerate() {
        let power = |j: usize| &powers[j].parts()[part];
        match powers.len() {
            1 => combine_powers(target, [0].map(power), c),
            2 => combine_powers(target, [0, 1].map(power), c),
            3 => combine_powers(target, [0, 1, 2].map(power), c),
            4.. => combine_powers(target, [0, 1, 2, 3].map(power), c),
            0 => {}
        }
    }
    out.add_to_diagonal(c[0]);
}

fn combine_powers<const N: usize>(out: &mut Square, powers: [&Square; N], c: &[f64]) {
    let powers = powers.map(Square::lanes);
    let weights: [f64; N] = std::array::from_fn(|j| c[j + 1]);
    let target = out.lanes_mut();
    vectorised(
        #[inline(always)]
        || {
            for (k, sums) in target.iter_mut().enumerate() {
                let terms: [&[f64; LANES]; N] = std::array::from_fn(|j| &powers[j][k]);
                for l in 0..LANES {
                    let mut sum = weights[0] * terms[0][l];
                    for j in 1..N {
                        sum += weights[j] * terms[j][l];
                    }
                    sums[l] = sum;
                }
            }
        },
    );
}

/// Combines two or three powers to both polynomials, which overwrite the first two powers.
pub(super) fn combine_in_place<S: SquareBuffer>(powers: &mut [S], even: &[f64], odd: &[f64]) {
    let (first, rest) = powers.split_at_mut(2);
    let [x, y] = first else { return };
    let parts = x.parts_mut().iter_mut().zip(y.parts_mut());
    for (part, (x, y)) in parts.enumerate() {
        combine_parts(x, y, rest.first().map(|z| &z.parts()[part]), even, odd);
    }
    x.add_to_diagonal(even[0]);
    y.add_to_diagonal(odd[0]);
}

fn combine_parts(x: &mut Square, y: &mut Square, z: Option<&Square>, even: &[f64], odd: &[f64]) {
    let (x_lanes, y_lanes) = (x.lanes_mut(), y.lanes_mut());
    let (even, odd) = (&even[..4], &odd[..4]);
    vectorised(
        #[inline(always)]
        || match z {
            Some(z) => {
                for ((x, y), z) in x_lanes.iter_mut().zip(y_lanes).zip(z.lanes()) {
                    for l in 0..LANES {
                        let (p, q, r) = (x[l], y[l], z[l]);
                        x[l] = even[1] * p + even[2] * q + even[3] * r;
                        y[l] = odd[1] * p + odd[2] * q + odd[3] * r;
                    }
                }
            }
            None => {
                for (x, y) in x_lanes.iter_mut().zip(y_lanes) {
                    for l in 0..LANES {
                        let (p, q) = (x[l], y[l]);
                        x[l] = even[1] * p + even[2] * q;
                        y[l] = odd[1] * p + odd[2] * q;
                    }
                }
            }
        },
    );
}
