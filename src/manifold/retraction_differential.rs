//! The derivative of the quasi-geodesic retraction with respect to the velocity.

use faer::{Mat, MatRef};

use super::stiefel::Stiefel;
use crate::error::Result;
use crate::linalg::jet::MatrixJet;
use crate::linalg::jet_exp::JetExp;
use crate::linalg::product::mul_add;

/// Quantity named in `Overflow` errors.
const DIFFERENTIAL: &str = "derivative of the retraction";

/// The derivative of `R(u) = e^X S e^Omega` at `u` in the direction `z`; all shapes `(r, k)`.
///
/// With `u = K + S Omega` and `z = L + S Psi`, to first order in `tau`,
///
/// ```math
/// D R_u[z] = \frac{d}{d\tau}\, e^{(K + \tau L) S^T - S (K + \tau L)^T}\, S\, e^{\Omega + \tau \Psi},
/// ```
///
/// which is a tangent vector at `R(u)`, computed by exponentials of Taylor polynomials of size `r` and `k`.
///
/// # Errors
/// `Shape`, `NonFinite`, `Overflow`.
pub(crate) fn retraction_differential(
    s: MatRef<'_, f64>,
    u: MatRef<'_, f64>,
    z: MatRef<'_, f64>,
) -> Result<Mat<f64>> {
    let (r, k) = s.shape();
    let manifold = Stiefel::of("S", s)?;
    let (mut left, mut right) = (MatrixJet::zeros(r, r), MatrixJet::zeros(k, k));
    for (j, vector) in [u, z].into_iter().enumerate() {
        let (normal, omega) = manifold.split(s, vector)?;
        mul_add(&mut left.c[j], 1.0, &normal, s.transpose());
        mul_add(&mut left.c[j], -1.0, s, normal.transpose());
        right.c[j] = omega;
    }
    let one = [1.0, 0.0, 0.0, 0.0];
    let (mut moving, mut turning) = (JetExp::new(r), JetExp::new(k));
    moving.compute(&one, &left, 1, DIFFERENTIAL)?;
    turning.compute(&one, &right, 1, DIFFERENTIAL)?;
    let (e, f) = (&moving.value.c, &turning.value.c);
    Ok(&e[1] * (s * &f[0]) + &e[0] * (s * &f[1]))
}
