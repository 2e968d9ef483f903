//! Retractions and their inverses, in `O(n k^2)`.
//!
//! A retraction maps a tangent vector `V` at `S` to a point such that `t -> R(S, t V)` has the velocity `V` at 0. Its
//! distance from the geodesic with the same velocity depends on the metric. The table gives the order `p` of `|R(S,
//! tV) - exp(S, tV)| = O(t^p)`; `tests/retraction/orders.rs` measures each entry.
//!
//! | | canonical metric | Euclidean metric | `k = 1` (sphere) | `k = n` (rotations) | inverse defined where |
//! |---|---|---|---|---|---|
//! | quasi-geodesic | 2 | 2 | exact | exact | principal angles below pi, no rotation by pi |
//! | QR | 2 | 2 | 3 | 2 | leading principal minors of `S0^T S1` positive |
//! | polar | 2 | 3 | 3 | 3 | eigenvalues of `S0^T S1` with positive real part |
//! | Cayley | 3 | 2 | 3 | 3 | no eigenvalue -1 of `S0^T S1` |
//!
//! So the polar retraction is of second order for the Euclidean metric, and the Cayley retraction for the canonical
//! one. You can use any other function of `(S, V)` as a retraction; the crate does not require one of these.

use faer::{Mat, MatRef, Scale};

use super::only_bases::advised;
use super::quasi_geodesic::{QuasiGeodesic, Turning};
use super::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::linalg::decomp::{
    Svd, newton_schulz, polar_factor, smallest_real_part, solve_matrix, solve_upper, thin_qr,
};
use crate::linalg::gram_factors::CholeskyQr;
use crate::linalg::jet::MatrixJet;
use crate::linalg::lyapunov::{TriangularSolver, solve_symmetric};
use crate::linalg::structure::{check_range, distance, norm, orthonormality_defect, skew_part};

/// An inverse is returned only if its retraction reaches the point this closely: the tolerance of points, with a margin
/// for points that use it up.
const VERIFIED: f64 = 10.0 * POINT_TOLERANCE;

/// For longer vectors the Cayley transform loses more than half of its digits.
const CAYLEY_LIMIT: f64 = 1e8;

/// A Cayley transform with a larger orthonormality defect is wrong; one or two Newton-Schulz steps reduce a smaller one to
/// round-off.
const NEARLY_ORTHONORMAL: f64 = 1e-6;

/// Length of `V` up to which the condition number of `(S + V)^T (S + V) = I + V^T V` is at most 2, so that its factors
/// give those of `S + V` to round-off.
const SHORT: f64 = 1.0;

/// A map from tangent vectors to points, and its inverse.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Retraction;
/// let s = mat![[1.0], [0.0], [0.0]];
/// let v = mat![[0.0], [0.5], [0.0]];
/// for retraction in Retraction::ALL {
///     let y = retraction.retract(s.as_ref(), v.as_ref())?;
///     let back = retraction.inverse_retract(s.as_ref(), y.as_ref())?;
///     assert!((back - &v).norm_l2() < 1e-15);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Retraction {
    /// The quasi-geodesic at 1: see [`QuasiGeodesic`].
    ///
    /// ```math
    /// e^{X} S e^{\Omega},\qquad X = K S^T - S K^T
    /// ```
    #[default]
    QuasiGeodesic,
    /// The orthonormal factor of `S + V`, whose triangular factor has a positive diagonal.
    ///
    /// The inverse is `V = S_1 R - S_0` with the triangular solution `R` of the linear equation
    ///
    /// ```math
    /// M R + R^T M^T = 2 I,\qquad M = S_0^T S_1
    /// ```
    ///
    /// It is solved in `O(k^3)` by an elimination of `M`, whose pivots show whether there is a solution with positive
    /// diagonal.
    ///
    /// Source: Absil, Mahony, Sepulchre (2008), example 4.1.3; the equation: Kaneko, Fiori, Tanaka (2013), IEEE Trans. Signal
    /// Process. 61, 883-894, section III, who solve it column by column in `O(k^4)`.
    Qr,
    /// The orthonormal polar factor of `S + V`, the point nearest to it.
    ///
    /// ```math
    /// (S + V)(I + V^T V)^{-1/2}
    /// ```
    ///
    /// The inverse is `V = S_1 P - S_0` with the symmetric positive definite solution of `M P + P M^T = 2 I`, which
    /// exists and is unique if every eigenvalue of `M = S_0^T S_1` has a positive real part (Lyapunov's theorem).
    ///
    /// Source: Kaneko, Fiori, Tanaka (2013), section III. Deviation: the equation is solved by the matrix sign iteration.
    Polar,
    /// The Cayley transform of the skew matrix `W = P V S^T - S V^T P`, `P = I - S S^T / 2`, for which `W S = V`.
    ///
    /// ```math
    /// (I - \tfrac12 W)^{-1} (I + \tfrac12 W) S = (2 S + K)\, N^{-1} - S,\qquad N = I - \tfrac12 \Omega + \tfrac14 K^T K
    /// ```
    ///
    /// The right-hand form takes one `k x k` solve. The inverse has a closed form too: `N = 2 (I + S_0^T S_1)^{-1}`,
    /// `Omega = N^T - N`, `K = (I - S_0 S_0^T) S_1 N`.
    ///
    /// Source: Wen, Yin (2013), Math. Program. 142, 397-434 (the retraction, with a `2k x 2k` solve); Zhu (2017),
    /// Comput. Optim. Appl. 67, 73-110. Deviation: block elimination of the same matrix, from which the inverse is read
    /// off.
    Cayley,
}

impl Retraction {
    /// All retractions.
    pub const ALL: [Retraction; 4] = [
        Retraction::QuasiGeodesic,
        Retraction::Qr,
        Retraction::Polar,
        Retraction::Cayley,
    ];

    /// The name: `quasi_geodesic`, `qr`, `polar` or `cayley`.
    pub fn name(self) -> &'static str {
        match self {
            Retraction::QuasiGeodesic => "quasi_geodesic",
            Retraction::Qr => "qr",
            Retraction::Polar => "polar",
            Retraction::Cayley => "cayley",
        }
    }

    /// The retraction with the given name.
    pub fn from_name(name: &str) -> Option<Self> {
        Retraction::ALL.into_iter().find(|r| r.name() == name)
    }

    /// The point reached from `s` by the tangent vector `v`; shapes `(n, k)`.
    ///
    /// # Accuracy
    /// Orthonormality defect at most `1e-14` for `|V| <= 10` (up to St(30, 12)), asserted in `tests/retraction/`. The
    /// error is that of a change of `v` by `eps |v|`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `RankDeficient` (QR, polar) if `v` is so long that `S + V`
    /// is numerically rank-deficient; `InvalidArgument` (Cayley) if `|V| > 1e8`; `Overflow`; `Decomposition`.
    pub fn retract(self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
        if self == Retraction::QuasiGeodesic {
            return quasi_geodesic_end(s, v);
        }
        let manifold = Stiefel::of("S", s)?;
        manifold.check_point("S", s, POINT_TOLERANCE)?;
        manifold.check_tangent("V", s, v, TANGENT_TOLERANCE)?;
        self.retract_unchecked(&manifold, s, v)
    }

    fn retract_unchecked(
        self,
        manifold: &Stiefel,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        match self {
            Retraction::QuasiGeodesic => quasi_geodesic_end(s, v),
            Retraction::Qr => qr_retract(s, v),
            Retraction::Polar => polar_factor("S + V", sum(s, v)?.as_ref()),
            Retraction::Cayley => cayley_retract(manifold, s, v),
        }
    }

    /// The tangent vector at `s0` whose retraction is `s1`; shapes `(n, k)`.
    ///
    /// For QR, polar and Cayley there is at most one, and it is returned only if its retraction reaches `s1` to `1e-8`.
    /// The quasi-geodesic retraction has many inverses; the principal one is returned.
    ///
    /// # Accuracy
    /// `|R(S0, V) - S1| <= 1e-13` for points at distance up to 1, asserted in `tests/retraction/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `OutsideRetractionDomain` with the measured pivot, eigenvalue, singular
    /// value or distance, in `OnlyBases` if the points look like mere bases; the errors of [`QuasiGeodesic::between`].
    pub fn inverse_retract(self, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        if self == Retraction::QuasiGeodesic {
            return Ok(QuasiGeodesic::between(s0, s1)?.initial_velocity());
        }
        let manifold = Stiefel::of("S0", s0)?;
        manifold.check_point("S0", s0, POINT_TOLERANCE)?;
        manifold.check_point("S1", s1, POINT_TOLERANCE)?;
        let found = self.inverse_of_points(&manifold, s0, s1);
        found.map_err(|error| advised(error, s0, s1))
    }

    fn inverse_of_points(
        self,
        manifold: &Stiefel,
        s0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        let product = s0.transpose() * s1;
        let v = match self {
            Retraction::Cayley => cayley_inverse(manifold, s0, s1, product.as_ref())?,
            Retraction::Polar => {
                let factor = polar_inverse_factor(product.as_ref())?;
                tangent_from_factor(manifold, s0, s1, &product, &factor)?
            }
            _ => {
                let factor = qr_inverse_factor(product.as_ref())?;
                tangent_from_factor(manifold, s0, s1, &product, &factor)?
            }
        };
        self.verify(manifold, s0, s1, v)
    }

    /// Returns `v` if its retraction is `s1`, otherwise an error.
    fn verify(
        self,
        manifold: &Stiefel,
        s0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v: Mat<f64>,
    ) -> Result<Mat<f64>> {
        // A vector too long to be retracted is no inverse; its defect counts as the whole distance.
        let miss = match self.retract_unchecked(manifold, s0, v.as_ref()) {
            Ok(y) => distance(y.as_ref(), s1),
            Err(_) => distance(s0, s1),
        };
        if miss <= VERIFIED {
            return Ok(v);
        }
        Err(self.outside(
            "distance of the retraction from the target",
            miss,
            "at most 1e-8",
        ))
    }

    fn outside(self, quantity: &'static str, value: f64, requirement: &'static str) -> Error {
        Error::OutsideRetractionDomain {
            retraction: self.name(),
            quantity,
            value,
            requirement,
        }
    }
}

fn quasi_geodesic_end(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let curve = QuasiGeodesic::from_velocity(s, v)?;
    let (k, mut coordinates) = (curve.k(), MatrixJet::zeros(2 * curve.k(), curve.k()));
    curve.coordinates_into(1.0, 0, &mut Turning::new(k), &mut coordinates)?;
    let end = curve.frame() * &coordinates.c[0];
    check_range("retraction", end.as_ref())?;
    Ok(end)
}

/// `S + V`, checked to be finite.
fn sum(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let sum = s + v;
    check_range("S + V", sum.as_ref())?;
    Ok(sum)
}

fn qr_retract(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let mut sum = sum(s, v)?;
    if norm(v) <= SHORT
        && let Some(factors) = CholeskyQr::new(sum.as_ref())
    {
        factors.orthonormalise(sum.as_mut());
        return Ok(sum);
    }
    let scale = sum.norm_max();
    let (q, r) = thin_qr((sum * Scale(1.0 / scale)).as_ref());
    // Without round-off every singular value of S + V is at least 1.
    let diagonal = (0..r.ncols()).map(|j| r[(j, j)] * scale);
    let (smallest, largest) = diagonal.fold((f64::INFINITY, 0.0_f64), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    if smallest <= s.nrows() as f64 * f64::EPSILON * largest {
        return Err(Error::RankDeficient {
            name: "S + V",
            smallest,
            largest,
        });
    }
    Ok(q)
}

/// `(2 S + K) N^{-1} - S` from the QR factors of `S + K/2 = Q C`, for which `C^T C = I + K^T K / 4`: `2 Q (I - C^{-T}
/// Omega C^{-1} / 2)^{-1} C^{-T} - S`, in which nothing is squared.
fn cayley_retract(manifold: &Stiefel, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let length = norm(v);
    let refused = Error::InvalidArgument {
        name: "norm of V",
        requirement: "at most 1e8 for the Cayley retraction",
        found: length,
    };
    if length > CAYLEY_LIMIT {
        return Err(refused);
    }
    let k = manifold.k();
    let (normal, omega) = manifold.split(s, v)?;
    let (q, c) = factors_of_half(s, &normal, length);
    // C^{-T}, lower triangular, and C^{-T} Omega C^{-1}.
    let mut inverse = Mat::<f64>::identity(k, k);
    solve_upper(c.as_ref(), inverse.as_mut());
    let turned = skew_part((inverse.transpose() * omega * &inverse).as_ref());
    let shifted = Mat::from_fn(k, k, |i, j| {
        f64::from(u8::from(i == j)) - 0.5 * turned[(i, j)]
    });
    // Never singular, since its symmetric part is the identity.
    let Some(solution) = solve_matrix(shifted.as_ref(), inverse.transpose()) else {
        return Err(refused);
    };
    let y = &q * solution * Scale(2.0) - s;
    // The point is only accurate to eps |V|, the effect of changing V in its last digit; the steps remove the resulting
    // orthonormality defect.
    let defect = orthonormality_defect(y.as_ref());
    if defect > NEARLY_ORTHONORMAL {
        return Err(refused);
    }
    let once = newton_schulz(&y);
    // One step squares the defect.
    match defect * defect <= f64::EPSILON {
        true => Ok(once),
        false => Ok(newton_schulz(&once)),
    }
}

/// The QR factors of `S + K/2`, where `K` is at most as long as `length`.
fn factors_of_half(s: MatRef<'_, f64>, k: &Mat<f64>, length: f64) -> (Mat<f64>, Mat<f64>) {
    let mut half = s + k * Scale(0.5);
    if 0.5 * length <= SHORT
        && let Some(factors) = CholeskyQr::new(half.as_ref())
    {
        factors.orthonormalise(half.as_mut());
        return (half, factors.r().to_owned());
    }
    thin_qr(half.as_ref())
}

/// The triangular `R` for which `S1 R - S0` is tangent.
fn qr_inverse_factor(product: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let k = product.nrows();
    // A pivot of the size of round-off has no reliable sign.
    let solver = TriangularSolver::new(product, k as f64 * f64::EPSILON).map_err(|pivot| {
        Retraction::Qr.outside(
            "first ratio of leading principal minors of S0^T S1 that is not above round-off",
            pivot,
            "positive",
        )
    })?;
    Ok(solver.solve(twice_identity(k).as_ref()))
}

/// The symmetric `P` for which `S1 P - S0` is tangent.
fn polar_inverse_factor(product: MatRef<'_, f64>) -> Result<Mat<f64>> {
    if let Some(factor) = solve_symmetric(product, twice_identity(product.nrows()).as_ref()) {
        return Ok(factor);
    }
    Err(Retraction::Polar.outside(
        "smallest real part of an eigenvalue of S0^T S1",
        smallest_real_part(product)?,
        "positive",
    ))
}

fn twice_identity(k: usize) -> Mat<f64> {
    Mat::<f64>::identity(k, k) * Scale(2.0)
}

/// `S1 F - S0`, tangent to round-off: its two parts are computed separately.
fn tangent_from_factor(
    manifold: &Stiefel,
    s0: MatRef<'_, f64>,
    s1: MatRef<'_, f64>,
    product: &Mat<f64>,
    factor: &Mat<f64>,
) -> Result<Mat<f64>> {
    check_range("inverse retraction", factor.as_ref())?;
    let (normal, _) = manifold.split(s0, (s1 * factor).as_ref())?;
    Ok(normal + s0 * skew_part((product * factor).as_ref()))
}

fn cayley_inverse(
    manifold: &Stiefel,
    s0: MatRef<'_, f64>,
    s1: MatRef<'_, f64>,
    product: MatRef<'_, f64>,
) -> Result<Mat<f64>> {
    let k = manifold.k();
    let shifted = product + Mat::<f64>::identity(k, k);
    let mut svd = Svd::new(k, k);
    svd.compute(shifted.as_ref())?;
    let smallest = svd.s(k - 1);
    let outside = || {
        Retraction::Cayley.outside(
            "smallest singular value of I + S0^T S1",
            smallest,
            "above round-off",
        )
    };
    if smallest <= 4.0 * k as f64 * f64::EPSILON {
        return Err(outside());
    }
    let factor = solve_matrix(shifted.as_ref(), twice_identity(k).as_ref()).ok_or_else(outside)?;
    let (normal, _) = manifold.split(s0, (s1 * &factor).as_ref())?;
    let omega = factor.transpose() - &factor;
    Ok(normal + s0 * omega)
}
