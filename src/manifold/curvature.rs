//! The curvature of `St(n, k)`, for every metric of the alpha family, in `O(n k^2)`.
//!
//! A tangent vector `S A + B`, `S^T B = 0`, is represented by the pair `(A, B)`. The space is `SO(n) / SO(n-k)` with an
//! invariant metric, so with the weight `w` of the metric
//!
//! ```math
//! \begin{aligned}
//! \Lambda(A,B)(C,D) &= \big( \tfrac12 ([A,C] - B^T D + D^T B),\ w B C - (1 - w) D A \big) \\
//! R(x, y) &= [\Lambda(x), \Lambda(y)] - \Lambda([x,y]_m) - \mathrm{ad}([x,y]_h) \\
//! [x,y]_m &= ([A,C] - B^T D + D^T B,\ B C - D A),\qquad [x,y]_h = D B^T - B D^T
//! \end{aligned}
//! ```
//!
//! # Source
//! Kobayashi, Nomizu (1969), "Foundations of Differential Geometry" II, chapter X, theorem 2.3 and section 3 (invariant
//! connections). The Levi-Civita map of the alpha family is our own derivation, checked against the embedded
//! Christoffel term in `tests/curvature/`.

use faer::{Mat, MatRef, Scale};

use super::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::linalg::structure::{check_range, frobenius_inner, norm, skew_part};

/// Area spanned by unit vectors below which the sectional curvature would lose more than half of its digits.
pub(super) const SMALLEST_AREA: f64 = 1.5e-8;

/// A tangent vector, as its direction (a pair of length 1, or 0 if no part of the vector is tangent) and its length.
struct Arrow {
    direction: Pair,
    length: f64,
    /// Fraction of the given matrix that is tangent, in the Frobenius norm: 1 up to the matrix's round-off, which may
    /// be all that remains of a very short vector.
    share: f64,
}

/// `S A + B` as the pair of `A`, skew `(k, k)`, and `B`, `(n, k)` with `S^T B = 0`.
struct Pair {
    a: Mat<f64>,
    b: Mat<f64>,
}

impl Pair {
    /// `self + factor * other`.
    fn plus(&self, factor: f64, other: &Pair) -> Pair {
        Pair {
            a: &self.a + &other.a * Scale(factor),
            b: &self.b + &other.b * Scale(factor),
        }
    }

    fn inner(&self, other: &Pair, weight: f64) -> f64 {
        weight * frobenius_inner(self.a.as_ref(), other.a.as_ref())
            + frobenius_inner(self.b.as_ref(), other.b.as_ref())
    }

    fn length(&self, weight: f64) -> f64 {
        norm(self.b.as_ref()).hypot(norm(self.a.as_ref()) * weight.sqrt())
    }

    fn rescaled(&self, length: f64) -> Pair {
        // Divide: the factor 1 / length would overflow for very short vectors.
        let divide = |x: &Mat<f64>| Mat::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / length);
        Pair {
            a: divide(&self.a),
            b: divide(&self.b),
        }
    }
}

/// `[A, C] - B^T D + D^T B`.
fn skew_bracket(x: &Pair, y: &Pair) -> Mat<f64> {
    let half = &x.a * &y.a - x.b.transpose() * &y.b;
    skew_part(half.as_ref()) * Scale(2.0)
}

/// The part of the bracket in the tangent space.
fn bracket(x: &Pair, y: &Pair) -> Pair {
    Pair {
        a: skew_bracket(x, y),
        b: &x.b * &y.a - &y.b * &x.a,
    }
}

/// The Levi-Civita map `Lambda(x) y`.
fn connection(x: &Pair, y: &Pair, weight: f64) -> Pair {
    Pair {
        a: skew_bracket(x, y) * Scale(0.5),
        b: &x.b * &y.a * Scale(weight) - &y.b * &x.a * Scale(1.0 - weight),
    }
}

/// `R(x, y) z`.
fn tensor(x: &Pair, y: &Pair, z: &Pair, weight: f64) -> Pair {
    let forth = connection(x, &connection(y, z, weight), weight);
    let back = connection(y, &connection(x, z, weight), weight);
    let rest = connection(&bracket(x, y), z, weight);
    let mut out = forth.plus(-1.0, &back).plus(-1.0, &rest);
    // (D B^T - B D^T) F, smaller products first.
    out.b += &x.b * (y.b.transpose() * &z.b) - &y.b * (x.b.transpose() * &z.b);
    out
}

/// The matrix times three lengths, in increasing order: a product of the large ones may overflow where the result does
/// not.
pub(super) fn by_lengths(unit: Mat<f64>, mut lengths: [f64; 3]) -> Mat<f64> {
    lengths.sort_by(f64::total_cmp);
    let [low, middle, high] = lengths;
    unit * Scale(low * high) * Scale(middle)
}

impl Stiefel {
    /// The curvature tensor `R(U, V) W` at `s`; all shapes `(n, k)`.
    ///
    /// ```math
    /// R(X,Y)Z = D_X D_Y Z - D_Y D_X Z - D_{[X,Y]} Z
    /// ```
    ///
    /// With this sign, `R(U,V)W = <V,W> U - <U,W> V` on the unit sphere, and Riemannian cubics satisfy `D_t^3 S' +
    /// R(D_t S', S') S' = 0`.
    ///
    /// # Accuracy
    /// `5e-15 k` relative to `|U| |V| |W|`, asserted in `tests/curvature/` for the canonical and the Euclidean metric.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Overflow`.
    pub fn curvature(
        &self,
        s: MatRef<'_, f64>,
        u: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        w: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("S", s, POINT_TOLERANCE)?;
        let [x, y, z] = [
            self.arrow("U", s, u)?,
            self.arrow("V", s, v)?,
            self.arrow("W", s, w)?,
        ];
        let weight = self.metric().weight();
        let unit = tensor(&x.direction, &y.direction, &z.direction, weight);
        let out = by_lengths(unit.b + s * unit.a, [x.length, y.length, z.length]);
        check_range("curvature", out.as_ref())?;
        Ok(out)
    }

    /// The sectional curvature of the plane spanned by `u` and `v` at `s`; shapes `(n, k)`.
    ///
    /// ```math
    /// \frac{\langle R(U,V)V, U \rangle}{|U|^2 |V|^2 - \langle U, V \rangle^2}
    /// ```
    ///
    /// It is 1 on the sphere, `|[X,Y]|^2 / 4` for an orthonormal pair on the rotations, and between 0 and 5/4 for the
    /// canonical metric.
    ///
    /// # Accuracy
    /// `5e-15 k` divided by the area spanned by unit vectors along `u` and `v`; asserted in `tests/curvature/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `LinearlyDependent` if that area is below 1.5e-8;
    /// `Overflow`.
    /// # Source
    /// The bound: Zimmermann, Stoye (2025), "High curvature means low rank", arXiv 2403.01879.
    pub fn sectional_curvature(
        &self,
        s: MatRef<'_, f64>,
        u: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<f64> {
        self.check_point("S", s, POINT_TOLERANCE)?;
        let weight = self.metric().weight();
        let (x, y) = (self.arrow("U", s, u)?, self.arrow("V", s, v)?);
        // A vector whose tangent part is only round-off spans no area.
        let mut area = x.share.min(y.share);
        if area > SMALLEST_AREA {
            let (x, y) = (x.direction, y.direction);
            let first = y.plus(-x.inner(&y, weight), &x);
            area = first.length(weight);
            if area > SMALLEST_AREA {
                let unit = first.rescaled(area);
                let second = unit.plus(-x.inner(&unit, weight), &x);
                let across = second.rescaled(second.length(weight));
                let value = tensor(&x, &across, &across, weight).inner(&x, weight);
                if value.is_finite() {
                    return Ok(value);
                }
                return Err(Error::Overflow {
                    quantity: "sectional curvature",
                });
            }
        }
        Err(Error::LinearlyDependent {
            names: "U and V",
            area,
            tolerance: SMALLEST_AREA,
        })
    }

    /// Direction and length of the tangent part of `v`, after checking that `v` is tangent.
    fn arrow(&self, name: &'static str, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Arrow> {
        self.check_tangent(name, s, v, TANGENT_TOLERANCE)?;
        // Scaled first, so that the products of the split neither overflow nor underflow.
        let size = norm(v);
        let unit = if size > 0.0 { size } else { 1.0 };
        let scaled = Mat::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)] / unit);
        let (b, a) = self.split(s, scaled.as_ref())?;
        let share = norm(b.as_ref()).hypot(norm(a.as_ref()));
        let pair = Pair { a, b };
        let length = pair.length(self.metric().weight());
        Ok(Arrow {
            direction: if length > 0.0 {
                pair.rescaled(length)
            } else {
                pair
            },
            length: length * size,
            share,
        })
    }
}
