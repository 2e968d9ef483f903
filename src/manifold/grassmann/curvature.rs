//! The curvature of `Gr(n, k)`, a symmetric space, in `O(n k^2)`.
//!
//! # Source
//! Kobayashi, Nomizu (1969), "Foundations of Differential Geometry" II, chapter XI, theorem 3.2: `R(X, Y) Z = -[[X, Y],
//! Z]`, here for the skew matrices `V Y^T - Y V^T`; Wong (1968), "Sectional curvatures of Grassmann manifolds", PNAS
//! 60, 75-79 (the bound).

use faer::{Mat, MatRef};

use super::{Grassmann, horizontal_part};
use crate::error::{Error, Result};
use crate::linalg::structure::{check_range, frobenius_inner, norm};
use crate::manifold::curvature::{SMALLEST_AREA, by_lengths};
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};

/// A tangent vector, as its direction of length 1 (or 0 if no part of the vector is horizontal) and its length.
struct HorizontalArrow {
    direction: Mat<f64>,
    length: f64,
    /// Fraction of the given matrix that is horizontal: 1 up to the matrix's round-off, which may be all that remains
    /// of a very short vector.
    share: f64,
}

/// `V / length`. A factor `1 / length` would overflow for very short vectors.
fn rescaled(v: MatRef<'_, f64>, length: f64) -> Mat<f64> {
    let length = if length > 0.0 { length } else { 1.0 };
    Mat::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)] / length)
}

/// `U V^T W - V U^T W + W (V^T U - U^T V)`, smaller products first.
fn tensor(u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    let turn = v.transpose() * u;
    u * (v.transpose() * w) - v * (u.transpose() * w) + w * (&turn - turn.transpose())
}

/// `v` without its component along the unit vector `u`, and the length of the result.
fn across(u: &Mat<f64>, v: &Mat<f64>) -> (Mat<f64>, f64) {
    let along = frobenius_inner(u.as_ref(), v.as_ref());
    let rest = Mat::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)] - along * u[(i, j)]);
    let length = norm(rest.as_ref());
    (rest, length)
}

impl Grassmann {
    /// The curvature tensor `R(U, V) W` at `y`; all shapes `(n, k)`.
    ///
    /// ```math
    /// R(U,V)W = D_U D_V W - D_V D_U W - D_{[U,V]} W = U V^T W - V U^T W + W (V^T U - U^T V)
    /// ```
    ///
    /// The sign is the one of [`Stiefel::curvature`](crate::Stiefel::curvature): `R(U,V)W = <V,W> U - <U,W> V` on the
    /// unit sphere and for lines (`k = 1`).
    ///
    /// # Accuracy
    /// `5e-15 k` relative to `|U| |V| |W|`, asserted in `tests/grassmann/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `Overflow`.
    pub fn curvature(
        &self,
        y: MatRef<'_, f64>,
        u: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        w: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("Y", y, POINT_TOLERANCE)?;
        let [u, v, w] = [
            self.arrow("U", y, u)?,
            self.arrow("V", y, v)?,
            self.arrow("W", y, w)?,
        ];
        let unit = tensor(&u.direction, &v.direction, &w.direction);
        let out = by_lengths(unit, [u.length, v.length, w.length]);
        check_range("curvature", out.as_ref())?;
        Ok(out)
    }

    /// The sectional curvature of the plane spanned by `u` and `v` at `y`; shapes `(n, k)`.
    ///
    /// ```math
    /// \frac{\langle R(U,V)V, U \rangle}{|U|^2 |V|^2 - \langle U, V \rangle^2}
    /// ```
    ///
    /// Between 0 and 2; equal to 1 if `k` or `n - k` is 1.
    ///
    /// # Accuracy
    /// `5e-15 k` divided by the area spanned by unit vectors along `u` and `v`; asserted in `tests/grassmann/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`; `LinearlyDependent` if that area is below 1.5e-8;
    /// `Overflow`.
    pub fn sectional_curvature(
        &self,
        y: MatRef<'_, f64>,
        u: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<f64> {
        self.check_point("Y", y, POINT_TOLERANCE)?;
        let (u, v) = (self.arrow("U", y, u)?, self.arrow("V", y, v)?);
        let (first, length) = across(&u.direction, &v.direction);
        let area = length.min(u.share).min(v.share);
        if area <= SMALLEST_AREA {
            return Err(Error::LinearlyDependent {
                names: "U and V",
                area,
                tolerance: SMALLEST_AREA,
            });
        }
        let (second, length) = across(&u.direction, &rescaled(first.as_ref(), length));
        let v = rescaled(second.as_ref(), length);
        let turned = tensor(&u.direction, &v, &v);
        Ok(frobenius_inner(turned.as_ref(), u.direction.as_ref()))
    }

    /// Direction and length of the horizontal part of `v`, after checking that `v` is horizontal.
    fn arrow(
        &self,
        name: &'static str,
        y: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<HorizontalArrow> {
        self.check_tangent(name, y, v, TANGENT_TOLERANCE)?;
        // Scaled first, so that the products of the projection neither overflow nor underflow.
        let size = norm(v);
        let part = horizontal_part(y, rescaled(v, size).as_ref());
        let share = norm(part.as_ref());
        Ok(HorizontalArrow {
            direction: rescaled(part.as_ref(), share),
            length: share * size,
            share,
        })
    }
}
