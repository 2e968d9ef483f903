//! Retractions and their inverses for arrays, with batches.

use super::prelude::*;
use super::stiefel::PyStiefel;
use crate::manifold::Retraction;

fn read_retraction(kind: &str) -> PyResult<Retraction> {
    Retraction::from_name(kind).ok_or_else(|| {
        let names = Retraction::ALL.map(|r| format!("'{}'", r.name()));
        invalid!("kind: expected {}, found '{kind}'", names.join(", "))
    })
}

#[pymethods]
impl PyStiefel {
    /// The point that a retraction maps a tangent vector at ``S`` to, shape (..., n, k).
    ///
    /// The order is that of ``|retract(S, t V) - exp(S, t V)| = O(t^p)``, canonical metric / Euclidean metric:
    ///
    /// ==================  ===================================================  =======
    /// kind                formula                                              order
    /// ==================  ===================================================  =======
    /// "quasi_geodesic"    ``e^X S e^Omega``, ``X = K S^T - S K^T``             2 / 2
    /// "qr"                orthonormal factor of ``S + V``, positive diagonal   2 / 2
    /// "polar"             ``(S + V) (I + V^T V)^(-1/2)``                       2 / 3
    /// "cayley"            ``(I - W/2)^-1 (I + W/2) S``, ``W S = V``            3 / 2
    /// ==================  ===================================================  =======
    ///
    /// On the sphere (k = 1) and on the rotations (k = n) quasi-geodesics are the geodesics, and all others but "qr" on the
    /// rotations are of order 3.
    ///
    /// Parameters
    /// ----------
    /// S, V : array_like, shape (..., n, k)
    ///     Points and tangent vectors.
    /// kind : str, default "quasi_geodesic"
    ///     One of the table.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect), an unknown kind, or a vector so long
    ///     that ``S + V`` has lost ``S``.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(5, 2)
    /// >>> S = M.random_point(rng=0)
    /// >>> V = M.random_tangent(S, rng=1)
    /// >>> bool(abs(M.retract(S, V, kind="polar") - M.project(S + V)).max() < 1e-15)
    /// True
    #[pyo3(signature = (S, V, kind="quasi_geodesic"))]
    fn retract(&self, S: &Any, V: &Any, kind: &str) -> PyResult<Array> {
        let retraction = read_retraction(kind)?;
        self.map_matrices(named![S, V], move |_, [s, v]| retraction.retract(s, v))
    }

    /// The tangent vector at ``S0`` that a retraction maps to ``S1``, shape (..., n, k).
    ///
    /// With ``M = S0^T S1``, "qr" has an inverse where the leading principal minors of ``M`` are positive, "polar" where its
    /// eigenvalues have positive real parts, "cayley" where -1 is none of them; it is unique, and it is checked before it is
    /// returned. "quasi_geodesic" has its principal branch at almost all pairs.
    ///
    /// Parameters
    /// ----------
    /// S0, S1 : array_like, shape (..., n, k)
    ///     Points.
    /// kind : str, default "quasi_geodesic"
    ///     "quasi_geodesic", "qr", "polar" or "cayley".
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n, k)
    ///
    /// Raises
    /// ------
    /// OutsideDomainError
    ///     No unique tangent vector leads there, with the measured number; "quasi_geodesic" carries an ``angle``.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import Stiefel
    /// >>> M = Stiefel(5, 2)
    /// >>> S = M.random_point(rng=0)
    /// >>> V = 0.3 * M.random_tangent(S, rng=1)
    /// >>> S1 = M.retract(S, V, kind="cayley")
    /// >>> bool(abs(M.inverse_retract(S, S1, kind="cayley") - V).max() < 1e-14)
    /// True
    #[pyo3(signature = (S0, S1, kind="quasi_geodesic"))]
    fn inverse_retract(&self, S0: &Any, S1: &Any, kind: &str) -> PyResult<Array> {
        let retraction = read_retraction(kind)?;
        self.map_matrices(named![S0, S1], move |_, [s0, s1]| {
            retraction.inverse_retract(s0, s1)
        })
    }
}
