from collections.abc import Iterable, Sequence
from os import PathLike
from typing import Any, Final, Literal, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, disjoint_base

from .boundary import BoundaryBatch
from .curve_derivative import CurveDerivative

_Array = NDArray[np.float64]
# Of float64, or of complex128 for complex frames.
_Frames = NDArray[Any]
_Field = Literal["real", "complex"]
_ComplexArray = NDArray[np.complex128]
_Map = Literal[
    "initial_point",
    "midpoint",
    "exponential",
    "exponential_midpoint",
    "cayley",
    "cayley_midpoint",
    "quasi_geodesic",
    "quasi_geodesic_midpoint",
]
_Order = Literal[1, 2, 4, 6, 8]
_End = Literal["natural", "clamped"] | tuple[Literal[1, 2], ArrayLike]
_BcType = Literal["natural", "clamped", "periodic"] | tuple[_End, _End]
_Velocities = Literal["catmull-rom", "akima", "natural"]
_Retraction = Literal["quasi_geodesic", "qr", "polar", "cayley"]

__all__ = [
    "__VERSION__",
    "Chart",
    "ChartTrajectory",
    "CubicHermite",
    "CubicSpline",
    "CubicTrajectory",
    "Curve",
    "DerivativeBounds",
    "Geodesic",
    "GeometricCubic",
    "GeometricPolynomial",
    "Grassmann",
    "LogReport",
    "PiecewiseCurve",
    "QuasiGeodesic",
    "RiemannianCubic",
    "RotationCurve",
    "ShootingResult",
    "SmoothingSpline",
    "SolverReport",
    "Stiefel",
    "_as_numpy",
    "_check_unmasked",
    "_in_library_of",
    "_restored",
    "estimate_velocities",
    "exp_pullback",
    "exp_variation",
    "integrate_cubic",
    "integrate_embedded",
    "interpolated_rotations",
    "log_pullback",
    "log_variation",
    "num_threads",
    "orthogonal_log",
    "orthogonal_log_pullback",
    "orthogonal_log_variation",
    "rotations_with_rates",
    "sampled_rotations",
    "simd_features",
    "skew_exp",
    "skew_exp_pullback",
    "skew_exp_variation",
    "smoothed_rotations",
    "solve_boundary",
]

__VERSION__: Final[str]

def num_threads() -> int:
    """Return the number of threads of the global pool."""

def simd_features() -> list[str]:
    """Return the SIMD instruction sets that this processor offers and that the library may use."""

@overload
def skew_exp(A: NDArray[np.complexfloating[Any, Any]], *, num_threads: int | None = None) -> _ComplexArray:
    """Return the exponential of a skew-symmetric or skew-Hermitian matrix.

    The result is a rotation or a unitary matrix, to round-off.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Real and skew-symmetric, or complex and skew-Hermitian: ``|A + A^H| / 2 <= 1e-12 |A|``.
    num_threads : int, optional
        Number of threads for a batch; by default the size of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``e^A``, with ``|Q^H Q - I|_2`` at most ``m * 1e-15``; complex128 if ``A`` is complex, else float64.

    Raises
    ------
    InvalidInputError
        Not square, not finite, or not skew-symmetric or skew-Hermitian (with the measured defect).

    Notes
    -----
    Closed forms for ``m <= 3`` (complex: ``m <= 2``); even and odd polynomials in ``A^2`` with squaring for moderate
    norms; the real Schur form of Ward and Gray (1978) or the Hermitian eigenvalue problem for large norms.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import skew_exp
    >>> bool(np.allclose(skew_exp([[0.0, -np.pi / 2], [np.pi / 2, 0.0]]), [[0, -1], [1, 0]]))
    True
    >>> bool(np.allclose(skew_exp([[0, 1j * np.pi / 2], [1j * np.pi / 2, 0]]), [[0, 1j], [1j, 0]]))
    True
    """

@overload
def skew_exp(A: ArrayLike, *, num_threads: int | None = None) -> _Array:
    """Return the exponential of a skew-symmetric or skew-Hermitian matrix.

    The result is a rotation or a unitary matrix, to round-off.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Real and skew-symmetric, or complex and skew-Hermitian: ``|A + A^H| / 2 <= 1e-12 |A|``.
    num_threads : int, optional
        Number of threads for a batch; by default the size of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``e^A``, with ``|Q^H Q - I|_2`` at most ``m * 1e-15``; complex128 if ``A`` is complex, else float64.

    Raises
    ------
    InvalidInputError
        Not square, not finite, or not skew-symmetric or skew-Hermitian (with the measured defect).

    Notes
    -----
    Closed forms for ``m <= 3`` (complex: ``m <= 2``); even and odd polynomials in ``A^2`` with squaring for moderate
    norms; the real Schur form of Ward and Gray (1978) or the Hermitian eigenvalue problem for large norms.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import skew_exp
    >>> bool(np.allclose(skew_exp([[0.0, -np.pi / 2], [np.pi / 2, 0.0]]), [[0, -1], [1, 0]]))
    True
    >>> bool(np.allclose(skew_exp([[0, 1j * np.pi / 2], [1j * np.pi / 2, 0]]), [[0, 1j], [1j, 0]]))
    True
    """

@overload
def orthogonal_log(Q: NDArray[np.complexfloating[Any, Any]], *, num_threads: int | None = None) -> _ComplexArray:
    """Return the principal skew logarithm of a rotation or a unitary matrix.

    The angles of a rotation (real) must be below pi; those of a unitary matrix lie in (-pi, pi].

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Real and orthogonal with determinant +1, or complex and unitary: ``|Q^H Q - I| <= 1e-9``.
    num_threads : int, optional
        Number of threads for a batch; by default the size of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``L = -L^H`` with ``e^L = Q``; complex128 if ``Q`` is complex, else float64. The backward error is at most 1e-13
        for ``m`` up to 50, even for repeated and clustered angles and for angles of ``pi - 1e-10``.

    Raises
    ------
    InvalidInputError
        Not square, not finite, or not orthogonal or unitary (with the measured defect).
    OutsideDomainError
        Only for real ``Q``: the determinant is -1, or an angle is pi to working precision, so that no real principal
        logarithm exists; carries ``angle``. ``orthogonal_log(Q.astype(complex))`` returns the complex logarithm.

    Notes
    -----
    Real: closed forms for ``m <= 3``; for larger ``m``, the skew Schur form of ``(Q - Q^T) / 2``, or the symmetric
    eigenvalue problem of ``(Q + Q^T) / 2`` and the skew Schur form within each group of equal cosines, and one Newton
    correction.

    Complex: closed forms for ``m <= 2``; for larger ``m``, the eigenvalue problem of a Hermitian combination of ``Q``
    and ``Q^H``, a second one within each group of equal eigenvalues, and one Newton correction. On the eigenspace of -1
    the logarithm is ``i pi``. To working precision the angles pi and -pi are the same: angles closer to -pi than
    ``4 m eps`` are returned as pi.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import orthogonal_log
    >>> bool(np.allclose(orthogonal_log([[0, -1], [1, 0]]), [[0, -np.pi / 2], [np.pi / 2, 0]]))
    True
    >>> bool(np.allclose(orthogonal_log(np.diag([1j, -1])), np.diag([0.5j * np.pi, 1j * np.pi])))
    True
    """

@overload
def orthogonal_log(Q: ArrayLike, *, num_threads: int | None = None) -> _Array:
    """Return the principal skew logarithm of a rotation or a unitary matrix.

    The angles of a rotation (real) must be below pi; those of a unitary matrix lie in (-pi, pi].

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Real and orthogonal with determinant +1, or complex and unitary: ``|Q^H Q - I| <= 1e-9``.
    num_threads : int, optional
        Number of threads for a batch; by default the size of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``L = -L^H`` with ``e^L = Q``; complex128 if ``Q`` is complex, else float64. The backward error is at most 1e-13
        for ``m`` up to 50, even for repeated and clustered angles and for angles of ``pi - 1e-10``.

    Raises
    ------
    InvalidInputError
        Not square, not finite, or not orthogonal or unitary (with the measured defect).
    OutsideDomainError
        Only for real ``Q``: the determinant is -1, or an angle is pi to working precision, so that no real principal
        logarithm exists; carries ``angle``. ``orthogonal_log(Q.astype(complex))`` returns the complex logarithm.

    Notes
    -----
    Real: closed forms for ``m <= 3``; for larger ``m``, the skew Schur form of ``(Q - Q^T) / 2``, or the symmetric
    eigenvalue problem of ``(Q + Q^T) / 2`` and the skew Schur form within each group of equal cosines, and one Newton
    correction.

    Complex: closed forms for ``m <= 2``; for larger ``m``, the eigenvalue problem of a Hermitian combination of ``Q``
    and ``Q^H``, a second one within each group of equal eigenvalues, and one Newton correction. On the eigenspace of -1
    the logarithm is ``i pi``. To working precision the angles pi and -pi are the same: angles closer to -pi than
    ``4 m eps`` are returned as pi.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import orthogonal_log
    >>> bool(np.allclose(orthogonal_log([[0, -1], [1, 0]]), [[0, -np.pi / 2], [np.pi / 2, 0]]))
    True
    >>> bool(np.allclose(orthogonal_log(np.diag([1j, -1])), np.diag([0.5j * np.pi, 1j * np.pi])))
    True
    """

def skew_exp_variation(A: ArrayLike, dA: ArrayLike) -> _Frames:
    """Return the derivative of :func:`skew_exp` in a direction.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Skew-symmetric or skew-Hermitian, as for :func:`skew_exp`.
    dA : array_like, shape (..., m, m)
        Direction, of which only the skew-symmetric or skew-Hermitian part is used.

    Returns
    -------
    ndarray, shape (..., m, m)
        Derivative of ``skew_exp(A + h * dA)`` with respect to ``h`` at 0, to about ``m * 1e-15``.

    Raises
    ------
    InvalidInputError
        As for :func:`skew_exp`, or mismatched shapes.
    """

def skew_exp_pullback(A: ArrayLike, W: ArrayLike) -> _Frames:
    """Return the gradient of ``sum(W * skew_exp(A))``: the transpose of :func:`skew_exp_variation`.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Skew-symmetric or skew-Hermitian, as for :func:`skew_exp`.
    W : array_like, shape (..., m, m)
        Derivatives of a function with respect to the entries of the exponential.

    Returns
    -------
    ndarray, shape (..., m, m)
        The skew-symmetric ``G`` with ``sum(G * dA) == sum(W * skew_exp_variation(A, dA))``; for complex matrices the
        equation holds for the real parts with conjugate ``G`` and ``W``.

    Raises
    ------
    InvalidInputError
        As for :func:`skew_exp`, or mismatched shapes.
    """

def orthogonal_log_variation(Q: ArrayLike, dQ: ArrayLike) -> _Frames:
    """Return the derivative of :func:`orthogonal_log` in a direction.

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Rotation or unitary matrix, as for :func:`orthogonal_log`; a unitary matrix must not have an angle of pi.
    dQ : array_like, shape (..., m, m)
        Direction, of which only the part tangent at ``Q`` is used.

    Returns
    -------
    ndarray, shape (..., m, m)
        The derivative, skew-symmetric or skew-Hermitian.

    Raises
    ------
    InvalidInputError, OutsideDomainError
        As for :func:`orthogonal_log`, or mismatched shapes; two angles next to pi, or next to pi and -pi, where the
        logarithm is not differentiable.
    """

def orthogonal_log_pullback(Q: ArrayLike, W: ArrayLike) -> _Frames:
    """Return the gradient of ``sum(W * orthogonal_log(Q))``: the transpose of :func:`orthogonal_log_variation`.

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Rotation or unitary matrix, as for :func:`orthogonal_log`; a unitary matrix must not have an angle of pi.
    W : array_like, shape (..., m, m)
        Derivatives of a function with respect to the entries of the logarithm.

    Returns
    -------
    ndarray, shape (..., m, m)
        The ``G`` tangent at ``Q`` with ``sum(G * dQ) == sum(W * orthogonal_log_variation(Q, dQ))`` for ``dQ`` tangent
        at ``Q``.

    Raises
    ------
    InvalidInputError, OutsideDomainError
        As for :func:`orthogonal_log`, or mismatched shapes; two angles next to pi, or next to pi and -pi, where the
        logarithm is not differentiable.
    """

def exp_variation(S: ArrayLike, V: ArrayLike, dS: ArrayLike, dV: ArrayLike) -> _Frames:
    """Return the derivative of ``Stiefel.exp`` (canonical metric) at ``(S, V)``.

    Parameters
    ----------
    S, V, dS, dV : array_like, shape (n, k)
        Point, tangent vector and their variations along a family of points and tangent vectors; real or complex.

    Returns
    -------
    ndarray, shape (n, k)

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, point not orthonormal, vector not tangent.
    """

def exp_pullback(S: ArrayLike, V: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames]:
    """Return the gradients of ``sum(W * exp(S, V))`` with respect to ``S`` and ``V``.

    The transpose of :func:`exp_variation`.

    Parameters
    ----------
    S, V, W : array_like, shape (n, k)
        Real or complex; for complex matrices, the gradients of ``Re sum(conj(W) * exp(S, V))``.

    Returns
    -------
    tuple of ndarray, each of shape (n, k)

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, point not orthonormal, vector not tangent.
    """

def log_variation(S0: ArrayLike, S1: ArrayLike, dS0: ArrayLike, dS1: ArrayLike) -> _Frames:
    """Return the derivative of ``Stiefel.log`` (canonical metric) at ``(S0, S1)``.

    Parameters
    ----------
    S0, S1, dS0, dS1 : array_like, shape (n, k)
        Points and their variations along a family of points; real or complex.

    Returns
    -------
    ndarray, shape (n, k)

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal.
    OutsideDomainError, ConvergenceError
        As for :meth:`Stiefel.log`, or the points are conjugate along the geodesic.
    """

def log_pullback(S0: ArrayLike, S1: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames]:
    """Return the gradients of ``sum(W * log(S0, S1))`` with respect to ``S0`` and ``S1``.

    The transpose of :func:`log_variation`.

    Parameters
    ----------
    S0, S1, W : array_like, shape (n, k)
        Real or complex; for complex matrices, the gradients of ``Re sum(conj(W) * log(S0, S1))``.

    Returns
    -------
    tuple of ndarray, each of shape (n, k)

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal.
    OutsideDomainError, ConvergenceError
        As for :func:`log_variation`.
    """

def _as_numpy(name: str, object: object) -> Any: ...
def _check_unmasked(name: str, object: object) -> None: ...
def _in_library_of(argument: object, value: Any) -> Any: ...
def _restored(form: dict[str, Any]) -> Curve: ...

@final
class SolverReport:
    """Outcome of an iterative solver."""

    def __new__(
        cls,
        converged: bool,
        iterations: int,
        residual: float,
        tolerance: float,
        reason: str,
        strategy: str | None = None,
    ) -> SolverReport: ...
    @property
    def converged(self) -> bool:
        """Whether ``residual <= tolerance``."""
    @property
    def iterations(self) -> int:
        """Newton steps taken."""
    @property
    def residual(self) -> float:
        """Euclidean norm of the residual at the final iterate."""
    @property
    def tolerance(self) -> float:
        """Requested tolerance."""
    @property
    def reason(self) -> str:
        """Reason for stopping.

        One of ``"converged"``, ``"max_iterations"``, ``"stagnated"``, ``"diverged"``, ``"singular_jacobian"``,
        ``"not_minimal"`` and ``"work_limit"``.
        """
    @property
    def strategy(self) -> str | None:
        """What found the solution of a boundary value problem, or a spline of Riemannian cubics.

        ``"direct"`` (Newton's method from the curve of flat space or from a guess), ``"descent"`` (to a curve of least
        cost first) or ``"continuation"`` (from a curve with other ends); None if nothing did, and for other solvers.
        """

@final
class LogReport:
    """Report on a Riemannian logarithm.

    Fields are numbers for a single pair of points, and arrays of the shape of the batch for a batch.
    """

    def __new__(
        cls,
        converged: bool | NDArray[np.bool_],
        iterations: int | NDArray[np.int64],
        residual: float | _Array,
        length: float | _Array,
        certainly_shortest: bool | NDArray[np.bool_],
    ) -> LogReport: ...
    @property
    def converged(self) -> bool | NDArray[np.bool_]:
        """Whether the residual is at the level of round-off; always True for a logarithm that is returned."""
    @property
    def iterations(self) -> int | NDArray[np.int64]:
        """Newton steps of the successful solve, including the first attempt at close points."""
    @property
    def residual(self) -> float | _Array:
        """Frobenius norm ``|exp(S0, V) - S1|``."""
    @property
    def length(self) -> float | _Array:
        """Length of the geodesic in the manifold's metric."""
    @property
    def certainly_shortest(self) -> bool | NDArray[np.bool_]:
        """Whether the geodesic is known to be the shortest.

        True if it is shorter than the known bound of the injectivity radius (canonical ``sqrt(4/5) pi``, Euclidean
        ``pi``; no bound is known for the metrics between), or has a closed form (``k = 1``, ``k = n``, canonical also
        ``k = n - 1``). If False, the geodesic may still be the shortest.
        """

@final
class Stiefel:
    """Stiefel manifold St(n, k) of n x k matrices with orthonormal columns, real or complex.

    Points and tangent vectors are arrays of shape ``(..., n, k)``; leading axes are batches and broadcast.

    Parameters
    ----------
    n, k : int
        Numbers of rows and columns, ``1 <= k <= n``.
    metric : "canonical", "euclidean" or float, default "canonical"
        A float is the parameter ``alpha > -1`` of the family of metrics of Hueper, Markina, Silva Leite (2021), in
        which ``|V|^2 = |K|^2 + |Omega|^2 / (2 (alpha + 1))`` for ``V = S Omega + K``: canonical 0, Euclidean -1/2.
    field : "real" or "complex", default "real"
        With ``"complex"``, frames satisfy ``S^H S = I`` (the unitary group for ``k = n``), and methods take and return
        complex arrays. In all formulas the transpose is the conjugate transpose, and inner products are real parts.

    Raises
    ------
    InvalidInputError
        ``k`` outside ``1 <= k <= n``, or unknown metric or field. Methods raise it for arrays of a wrong shape,
        non-finite entries, points that are not orthonormal and vectors that are not tangent; the message states the
        measured defect and the member of the batch.

    Examples
    --------
    >>> from stiefel_rs import Stiefel
    >>> M = Stiefel(5, 2)
    >>> M.dim
    7
    >>> S = M.random_point(rng=0)
    >>> V = M.random_tangent(S, rng=1)
    >>> bool(abs(M.inverse_retract(S, M.retract(S, 0.1 * V)) - 0.1 * V).max() < 1e-14)
    True
    """

    def __new__(cls, n: int, k: int, *, metric: str | float | None = None, field: _Field = "real") -> Stiefel: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def n(self) -> int:
        """Number of rows of a point."""
    @property
    def k(self) -> int:
        """Number of columns of a point."""
    @property
    def field(self) -> _Field:
        """Field of the entries: "real" or "complex"."""
    @property
    def alpha(self) -> float:
        """Parameter of the metric: 0 for the canonical, -1/2 for the Euclidean metric."""
    @property
    def dim(self) -> int:
        """Real dimension of the manifold: ``n k - k (k + 1) / 2``, for complex frames ``2 n k - k^2``."""
    def check_point(self, S: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``S`` is a point: ``|S^T S - I| <= atol`` (Frobenius norm).

        The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.

        Raises
        ------
        InvalidInputError
            A member is not a point; the message states the measured defect.
        """
    def check_tangent(self, S: ArrayLike, V: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``V`` is tangent at ``S``: ``|S^T V + V^T S| / 2 <= atol max(1, |V|)``.

        The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.

        Raises
        ------
        InvalidInputError
            A member is not tangent; the message states the measured defect.
        """
    def is_point(self, S: ArrayLike, atol: float | None = None) -> Any:
        """Return whether ``S`` is a point, by the criterion of :meth:`check_point`; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for entries that are not finite.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 2)
        >>> bool(M.is_point(np.eye(3, 2))), bool(M.is_point(np.ones((3, 2))))
        (True, False)
        """
    def is_tangent(self, S: ArrayLike, V: ArrayLike, atol: float | None = None) -> Any:
        """Return whether ``V`` is tangent at ``S``, by the criterion of :meth:`check_tangent`; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for entries that are not finite, and if ``S`` is not a point.
        """
    def random_point(
        self, rng: np.random.Generator | int | None = None, size: int | tuple[int, ...] | None = None
    ) -> _Frames:
        """Draw uniformly distributed points (Haar measure), shape ``size + (n, k)``.

        Parameters
        ----------
        rng : numpy.random.Generator or seed, optional
            Generator, or seed for `numpy.random.default_rng`.
        size : int or tuple of int, optional
            Leading axes; by default a single point.
        """
    def random_tangent(self, S: ArrayLike, rng: np.random.Generator | int | None = None) -> _Frames:
        """Draw tangent vectors at ``S``, projections of standard normal matrices; shape of ``S``.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        rng : numpy.random.Generator or seed, optional
            Generator, or seed for `numpy.random.default_rng`. The vectors are independent of ``S`` even if ``S`` was
            drawn with the same seed, or by a generator in the same state.
        """
    def project(self, Y: ArrayLike) -> _Frames:
        """Return the nearest point in the Frobenius norm, the polar factor of ``Y``, shape (..., n, k).

        Raises
        ------
        InvalidInputError
            ``Y`` does not have full column rank (the message states its smallest singular value), or is not finite.
        """
    def project_tangent(self, S: ArrayLike, Z: ArrayLike) -> _Frames:
        """Project ``Z`` orthogonally to the tangent space at ``S``: ``Z - S sym(S^T Z)``, shape (..., n, k)."""
    def inner(self, S: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Array:
        """Return the inner product of tangent vectors at ``S`` in the manifold's metric, shape (...).

        For the canonical metric, ``tr V^T (I - S S^T / 2) W``.
        """
    def norm(self, S: ArrayLike, V: ArrayLike) -> _Array:
        """Return the norm of a tangent vector at ``S`` in the manifold's metric, shape (...)."""
    def decompose(self, S: ArrayLike, V: ArrayLike) -> tuple[_Frames, _Frames]:
        """Return the pair ``(X, Omega)`` that represents a tangent vector, ``V = X S + S Omega``.

        The parametrisation of arXiv 2404.19407.

        Returns
        -------
        X : ndarray, shape (..., n, n)
            ``V S^T - S V^T + 2 S V^T S S^T``, skew-symmetric.
        Omega : ndarray, shape (..., k, k)
            ``S^T V``, skew-symmetric.
        """
    def compose(self, S: ArrayLike, X: ArrayLike, Omega: ArrayLike) -> _Frames:
        """Return the tangent vector ``V = X S + S Omega`` of a pair of :meth:`decompose`, shape (..., n, k)."""
    def exp(self, S: ArrayLike, V: ArrayLike) -> _Frames:
        """Return the Riemannian exponential of tangent vectors ``V`` at ``S``, shape (..., n, k).

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
            a vector so long that the result overflows.
        """
    @overload
    def log(self, S0: ArrayLike, S1: ArrayLike, *, full_output: Literal[False] = False) -> _Frames:
        """Return the Riemannian logarithm: the ``V`` at ``S0`` with ``exp(S0, V) = S1``, shape (..., n, k).

        Parameters
        ----------
        S0, S1 : array_like, shape (..., n, k)
            Points.
        full_output : bool, default False
            If True, also return a report.

        Returns
        -------
        V : ndarray, shape (..., n, k)
            Initial velocities of the geodesics.
        report : LogReport
            Iterations, residual, length, and whether the geodesic is known to be the shortest; only with
            ``full_output=True``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
        OutsideDomainError
            Antipodal points, a relative rotation by pi, or different components of O(n); carries ``angle``.
        ConvergenceError
            No geodesic was found, far beyond the injectivity radius; carries ``report``.

        Notes
        -----
        Newton's method on the exponential, with the exact inverse derivative. For distant points, Newton's method for
        the shortest rotation over the fibre (formulation of Zimmermann, Hueper 2022). Below a distance of ``0.89 pi``
        the result is the shortest geodesic (canonical metric).

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(5, 2)
        >>> S = M.random_point(rng=0)
        >>> V = 0.5 * M.random_tangent(S, rng=1)
        >>> W, report = M.log(S, M.exp(S, V), full_output=True)
        >>> bool(abs(W - V).max() < 1e-13), report.certainly_shortest
        (True, True)
        """
    @overload
    def log(self, S0: ArrayLike, S1: ArrayLike, *, full_output: Literal[True]) -> tuple[_Frames, LogReport]:
        """Return the Riemannian logarithm: the ``V`` at ``S0`` with ``exp(S0, V) = S1``, shape (..., n, k).

        Parameters
        ----------
        S0, S1 : array_like, shape (..., n, k)
            Points.
        full_output : bool, default False
            If True, also return a report.

        Returns
        -------
        V : ndarray, shape (..., n, k)
            Initial velocities of the geodesics.
        report : LogReport
            Iterations, residual, length, and whether the geodesic is known to be the shortest; only with
            ``full_output=True``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
        OutsideDomainError
            Antipodal points, a relative rotation by pi, or different components of O(n); carries ``angle``.
        ConvergenceError
            No geodesic was found, far beyond the injectivity radius; carries ``report``.

        Notes
        -----
        Newton's method on the exponential, with the exact inverse derivative. For distant points, Newton's method for
        the shortest rotation over the fibre (formulation of Zimmermann, Hueper 2022). Below a distance of ``0.89 pi``
        the result is the shortest geodesic (canonical metric).

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(5, 2)
        >>> S = M.random_point(rng=0)
        >>> V = 0.5 * M.random_tangent(S, rng=1)
        >>> W, report = M.log(S, M.exp(S, V), full_output=True)
        >>> bool(abs(W - V).max() < 1e-13), report.certainly_shortest
        (True, True)
        """
    def dist(self, S0: ArrayLike, S1: ArrayLike) -> _Array:
        """Return the Riemannian distance between points, the length of the geodesic of :meth:`log`, shape (...).

        Raises
        ------
        InvalidInputError, OutsideDomainError, ConvergenceError
            As for :meth:`log`.
        """
    def retract(self, S: ArrayLike, V: ArrayLike, kind: _Retraction = "quasi_geodesic") -> _Frames:
        """Apply a retraction to tangent vectors at ``S``, shape (..., n, k).

        The order is the ``p`` in ``|retract(S, t V) - exp(S, t V)| = O(t^p)``, canonical metric / Euclidean metric:

        ==================  ===================================================  =======
        kind                formula                                              order
        ==================  ===================================================  =======
        "quasi_geodesic"    ``e^X S e^Omega``, ``X = K S^T - S K^T``             2 / 2
        "qr"                orthonormal factor of ``S + V``, positive diagonal   2 / 2
        "polar"             ``(S + V) (I + V^T V)^(-1/2)``                       2 / 3
        "cayley"            ``(I - W/2)^-1 (I + W/2) S``, ``W S = V``            3 / 2
        ==================  ===================================================  =======

        On the sphere (k = 1) and on the rotations (k = n) quasi-geodesics are geodesics, and the other retractions have
        order 3, except "qr" on the rotations.

        Parameters
        ----------
        S, V : array_like, shape (..., n, k)
            Points and tangent vectors.
        kind : str, default "quasi_geodesic"
            A kind from the table.

        Returns
        -------
        ndarray, shape (..., n, k)

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), an
            unknown kind, or a vector so long that ``S`` is lost in the rounding of ``S + V``.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(5, 2)
        >>> S = M.random_point(rng=0)
        >>> V = M.random_tangent(S, rng=1)
        >>> bool(abs(M.retract(S, V, kind="polar") - M.project(S + V)).max() < 1e-15)
        True
        """
    def inverse_retract(self, S0: ArrayLike, S1: ArrayLike, kind: _Retraction = "quasi_geodesic") -> _Frames:
        """Return the tangent vector at ``S0`` that a retraction maps to ``S1``, shape (..., n, k).

        With ``M = S0^T S1``, "qr" has an inverse if the leading principal minors of ``M`` are positive, "polar" if its
        eigenvalues have positive real parts, "cayley" if -1 is not an eigenvalue; the inverse is then unique, and is
        verified before it is returned. "quasi_geodesic" has a principal branch for almost all pairs of points.

        Parameters
        ----------
        S0, S1 : array_like, shape (..., n, k)
            Points.
        kind : str, default "quasi_geodesic"
            "quasi_geodesic", "qr", "polar" or "cayley".

        Returns
        -------
        ndarray, shape (..., n, k)

        Raises
        ------
        OutsideDomainError
            No unique tangent vector leads to ``S1``; the message states the measured quantity. "quasi_geodesic" carries
            ``angle``.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(5, 2)
        >>> S = M.random_point(rng=0)
        >>> V = 0.3 * M.random_tangent(S, rng=1)
        >>> S1 = M.retract(S, V, kind="cayley")
        >>> bool(abs(M.inverse_retract(S, S1, kind="cayley") - V).max() < 1e-14)
        True
        """
    def transport(self, S: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Frames:
        """Transport ``W`` in parallel along the geodesic ``t -> exp(S, t V)`` to ``exp(S, V)``, shape (..., n, k).

        The Levi-Civita transport of the manifold's metric. It preserves lengths and angles to round-off.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        V, W : array_like, shape (..., n, k)
            Tangent vectors at ``S``: the initial velocity of the geodesic, and the vector to transport.

        Returns
        -------
        ndarray, shape (..., n, k)
            Tangent vectors at ``exp(S, V)``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
            ``V`` longer than about 1e5.

        References
        ----------
        Nguyen, Sommer (2024), arXiv 2408.06054.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, V = [[1.0], [0.0], [0.0]], [[0.0], [np.pi / 2], [0.0]]
        >>> bool(abs(M.transport(S, V, [[0.0], [1.0], [2.0]]) - [[-1.0], [0.0], [2.0]]).max() < 1e-15)
        True
        """
    def curvature(self, S: ArrayLike, U: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Frames:
        """Evaluate the curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``S``, shape (..., n, k).

        With this sign ``R(U, V) W = <V, W> U - <U, W> V`` on the unit sphere.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        U, V, W : array_like, shape (..., n, k)
            Tangent vectors at ``S``.

        Returns
        -------
        ndarray, shape (..., n, k)

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
            a result that overflows.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, U, V = np.eye(3)[:, :, None]
        >>> M.curvature(S, U, V, 2 * V).ravel()
        array([0., 2., 0.])
        """
    def sectional_curvature(self, S: ArrayLike, U: ArrayLike, V: ArrayLike) -> _Array:
        """Return the sectional curvature of the planes spanned by ``U`` and ``V`` at ``S``, shape (...).

        It is 1 on the sphere (k = 1), and between 0 and 5/4 for the canonical metric of real frames.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        U, V : array_like, shape (..., n, k)
            Tangent vectors at ``S``, linearly independent.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InvalidInputError
            ``U`` and ``V`` are linearly dependent (the message states the area that their unit vectors span); wrong
            shape, non-finite entries, points not orthonormal, vectors not tangent.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, U, V = np.eye(3)[:, :, None]
        >>> float(M.sectional_curvature(S, U, V))
        1.0
        """
    def euclidean_to_riemannian_gradient(self, S: ArrayLike, G: ArrayLike) -> _Frames:
        """Return the Riemannian gradient of a function with the Euclidean gradient ``G`` at ``S``, shape (..., n, k).

        It is the tangent vector with ``inner(S, gradient, V) = sum(G * V)`` for every tangent ``V``: ``G - S G^T S``
        for the canonical metric, ``project_tangent(S, G)`` for the Euclidean one. For complex frames ``G`` is the
        matrix with ``df = Re sum(conj(G) * V)``: the derivatives by the real parts plus i times the derivatives by the
        imaginary parts.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        G : array_like, shape (..., n, k)
            Partial derivatives with respect to the entries; need not be tangent.

        Returns
        -------
        ndarray, shape (..., n, k)

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal (with the measured defect).

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(4, 2)
        >>> S = M.random_point(rng=0)
        >>> G = np.diag([1.0, 2.0, 3.0, 4.0]) @ S
        >>> bool(abs(M.euclidean_to_riemannian_gradient(S, G) - (G - S @ G.T @ S)).max() < 1e-14)
        True
        """
    def euclidean_to_riemannian_hessian(self, S: ArrayLike, G: ArrayLike, H: ArrayLike, V: ArrayLike) -> _Frames:
        """Apply the Riemannian Hessian to the tangent vector ``V`` at ``S``, shape (..., n, k).

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        G, H : array_like, shape (..., n, k)
            Euclidean gradient, and Euclidean Hessian applied to ``V``; need not be tangent.
        V : array_like, shape (..., n, k)
            Tangent vectors at ``S``.

        Returns
        -------
        ndarray, shape (..., n, k)
            Covariant derivative of the gradient along ``V``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect).

        Examples
        --------
        The function ``sum(A * S)`` is linear in ``S``, so its Hessian comes from the curvature of the embedding alone:

        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, V, A = np.eye(3)[:, :, None]
        >>> M.euclidean_to_riemannian_hessian(S, 2 * S, 0 * V, V).ravel()
        array([ 0., -2.,  0.])
        """

@final
class Grassmann:
    """Grassmann manifold Gr(n, k) of k-dimensional subspaces of R^n or C^n.

    A point is represented by an orthonormal basis ``Y``, an array of shape ``(..., n, k)``; all bases of a subspace
    represent the same point. Tangent vectors at ``Y`` are horizontal: matrices ``V`` of the same shape with
    ``Y^T V = 0``, of length ``|V|`` (Frobenius norm). A tangent vector depends on the basis: ``V`` at ``Y`` is ``V Q``
    at ``Y Q``. Leading axes are batches and broadcast.

    Parameters
    ----------
    n, k : int
        Dimensions of the space and of the subspaces, ``1 <= k <= n``.
    field : "real" or "complex", default "real"
        With ``"complex"``, subspaces of C^n; methods take and return complex arrays. In all formulas the transpose is
        the conjugate transpose, and inner products are real parts. For ``k = 1`` the points are the states of quantum
        mechanics: ``Grassmann(2, 1, field="complex")`` is the sphere of radius 1/2.

    Raises
    ------
    InvalidInputError
        ``k`` outside ``1 <= k <= n``, or unknown field. Methods raise it for arrays of a wrong shape, non-finite
        entries, bases that are not orthonormal and vectors that are not horizontal; the message states the measured
        defect and the member of the batch.

    References
    ----------
    Edelman, Arias, Smith (1998), section 2.5; Bendokat, Zimmermann, Absil (2024), "A Grassmann manifold handbook".

    Examples
    --------
    >>> from stiefel_rs import Grassmann
    >>> M = Grassmann(5, 2)
    >>> M.dim
    6
    >>> Y = M.random_point(rng=0)
    >>> V = 0.3 * M.random_tangent(Y, rng=1)
    >>> bool(abs(M.log(Y, M.exp(Y, V)) - V).max() < 1e-13)
    True
    """

    def __new__(cls, n: int, k: int, *, field: _Field = "real") -> Grassmann: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def n(self) -> int:
        """Dimension of the ambient space: number of rows of a basis."""
    @property
    def k(self) -> int:
        """Dimension of the subspaces: number of columns of a basis."""
    @property
    def dim(self) -> int:
        """Real dimension of the manifold: ``k (n - k)``, for complex subspaces ``2 k (n - k)``."""
    @property
    def field(self) -> _Field:
        """Field of the entries: "real" or "complex"."""
    def check_point(self, Y: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``Y`` is an orthonormal basis: ``|Y^T Y - I| <= atol`` (Frobenius norm).

        The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.

        Raises
        ------
        InvalidInputError
            A member is not orthonormal; the message states the measured defect.
        """
    def check_tangent(self, Y: ArrayLike, V: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``V`` is horizontal at ``Y``: ``|Y^T V| <= atol max(1, |V|)``.

        The default of ``atol`` is 1e-9, for arrays in single precision 1e-5.

        Raises
        ------
        InvalidInputError
            A member is not horizontal; the message states the measured defect.
        """
    def is_point(self, Y: ArrayLike, atol: float | None = None) -> Any:
        """Return whether ``Y`` is an orthonormal basis, by the criterion of :meth:`check_point`; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for entries that are not finite.
        """
    def is_tangent(self, Y: ArrayLike, V: ArrayLike, atol: float | None = None) -> Any:
        """Return whether ``V`` is horizontal at ``Y``, by the criterion of :meth:`check_tangent`; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for entries that are not finite, and if ``Y`` is not an orthonormal basis.
        """
    def random_point(
        self, rng: np.random.Generator | int | None = None, size: int | tuple[int, ...] | None = None
    ) -> _Frames:
        """Draw bases of uniformly distributed subspaces (Haar measure), shape ``size + (n, k)``.

        Parameters
        ----------
        rng : numpy.random.Generator or seed, optional
            Generator, or seed for `numpy.random.default_rng`.
        size : int or tuple of int, optional
            Leading axes; by default a single point.
        """
    def random_tangent(self, Y: ArrayLike, rng: np.random.Generator | int | None = None) -> _Frames:
        """Draw tangent vectors at ``Y``, projections of standard normal matrices; shape of ``Y``.

        Parameters
        ----------
        Y : array_like, shape (..., n, k)
            Points.
        rng : numpy.random.Generator or seed, optional
            Generator, or seed for `numpy.random.default_rng`. The vectors are independent of ``Y`` even if ``Y`` was
            drawn with the same seed, or by a generator in the same state.
        """
    def project(self, Y: ArrayLike) -> _Frames:
        """Return the orthonormal basis of the column space of ``Y`` nearest to ``Y``, shape (..., n, k).

        This is the polar factor of ``Y``.

        Raises
        ------
        InvalidInputError
            ``Y`` does not have full column rank (the message states its smallest singular value), or is not finite.
        """
    def project_tangent(self, Y: ArrayLike, Z: ArrayLike) -> _Frames:
        """Project ``Z`` orthogonally to the tangent space at ``Y``: ``Z - Y Y^T Z``, shape (..., n, k)."""
    def inner(self, Y: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Array:
        """Return the inner product ``Re tr V^H W`` of tangent vectors at ``Y``, shape (...)."""
    def norm(self, Y: ArrayLike, V: ArrayLike) -> _Array:
        """Return the norm of a tangent vector at ``Y``: ``|V|`` (Frobenius norm), shape (...)."""
    def principal_angles(self, Y0: ArrayLike, Y1: ArrayLike) -> _Array:
        """Return the principal angles between subspaces, shape (..., k), in ``[0, pi / 2]``, in decreasing order.

        The order is the same as in `scipy.linalg.subspace_angles`. Small angles are as accurate as large ones, because
        sines and cosines are used (Knyazev, Argentati 2002). At least ``2 k - n`` angles are exactly zero.

        Examples
        --------
        Two planes of R^3 that share the first axis:

        >>> from stiefel_rs import Grassmann
        >>> Y1 = [[1.0, 0.0], [0.0, np.cos(1e-20)], [0.0, np.sin(1e-20)]]
        >>> Grassmann(3, 2).principal_angles(np.eye(3, 2), Y1).tolist()
        [1e-20, 0.0]
        """
    def align(self, Y0: ArrayLike, Y1: ArrayLike) -> _Frames:
        """Return the basis of the subspace of ``Y1`` nearest to ``Y0`` in the Frobenius norm, shape (..., n, k).

        This is ``Y1 Q`` with the orthogonal polar factor ``Q`` of ``Y1^T Y0``, which equals ``exp(Y0, log(Y0, Y1))``.

        Raises
        ------
        OutsideDomainError
            A principal angle is ``pi / 2`` to working precision, so that the nearest basis is not unique; carries
            ``angle``.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(5, 2)
        >>> Y = M.random_point(rng=0)
        >>> bool(abs(M.align(Y, Y @ [[0, 1], [-1, 0]]) - Y).max() < 1e-15)
        True
        """
    def projector(self, Y: ArrayLike) -> _Frames:
        """Return the orthogonal projectors ``Y Y^T`` to the subspaces, shape (..., n, n); independent of the bases."""
    def exp(self, Y: ArrayLike, V: ArrayLike) -> _Frames:
        """Return the Riemannian exponential of tangent vectors ``V`` at ``Y``, shape (..., n, k).

        Returns
        -------
        ndarray, shape (..., n, k)
            ``(Y W cos(S) + Q sin(S)) W^T`` for ``V = Q S W^T``: the basis of the end point reached by the horizontal
            lift of the geodesic.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect),
            or a vector so long that the result overflows.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> M.exp([[1], [0], [0]], [[0], [np.pi / 3], [0]]).round(6).ravel().tolist()
        [0.5, 0.866025, 0.0]
        """
    def log(self, Y0: ArrayLike, Y1: ArrayLike) -> _Frames:
        """Return the Riemannian logarithm, the ``V`` at ``Y0`` such that ``exp(Y0, V)`` spans the subspace of ``Y1``.

        The result has shape (..., n, k) and a closed form, and does not depend on the choice of the basis ``Y1``.
        ``exp(Y0, log(Y0, Y1))`` is ``align(Y0, Y1)``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
        OutsideDomainError
            The largest principal angle is ``pi / 2`` to working precision, so that several shortest geodesics join the
            subspaces; carries ``angle``.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> M.log([[1], [0], [0]], [[-0.6], [0.8], [0]]).round(6).ravel().tolist()
        [0.0, -0.927295, 0.0]
        """
    def dist(self, Y0: ArrayLike, Y1: ArrayLike) -> _Array:
        """Return the Riemannian distance of subspaces, ``sqrt(sum(principal_angles ** 2))``, shape (...).

        It is also defined if an angle is ``pi / 2``, where :meth:`log` raises. For different bases of the same subspace
        the result is round-off, not exactly 0.
        """
    def transport(self, Y: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Frames:
        """Transport ``W`` in parallel along the geodesic ``t -> exp(Y, t V)`` to ``exp(Y, V)``, shape (..., n, k).

        The transport preserves lengths and angles to round-off.

        Parameters
        ----------
        Y : array_like, shape (..., n, k)
            Points.
        V, W : array_like, shape (..., n, k)
            Tangent vectors at ``Y``: the initial velocity of the geodesic, and the vector to transport.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect).

        References
        ----------
        Edelman, Arias, Smith (1998), theorem 2.4.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> Y, V = [[1.0], [0.0], [0.0]], [[0.0], [np.pi / 2], [0.0]]
        >>> bool(abs(M.transport(Y, V, [[0.0], [1.0], [2.0]]) - [[-1.0], [0.0], [2.0]]).max() < 1e-15)
        True
        """
    def curvature(self, Y: ArrayLike, U: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Frames:
        """Evaluate the curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``Y``, shape (..., n, k).

        It is ``U V^T W - V U^T W + W (V^T U - U^T V)``; for lines (k = 1), ``<V, W> U - <U, W> V``. The sign agrees
        with :meth:`Stiefel.curvature`.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect),
            or a result that overflows.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> Y, U, V = np.eye(3)[:, :, None]
        >>> M.curvature(Y, U, V, 2 * V).ravel()
        array([0., 2., 0.])
        """
    def sectional_curvature(self, Y: ArrayLike, U: ArrayLike, V: ArrayLike) -> _Array:
        """Return the sectional curvature of the planes spanned by ``U`` and ``V`` at ``Y``, shape (...).

        It is between 0 and 2, and 1 if ``k`` or ``n - k`` is 1.

        Raises
        ------
        InvalidInputError
            ``U`` and ``V`` are linearly dependent (the message states the area that their unit vectors span); wrong
            shape, non-finite entries, points not orthonormal, vectors not horizontal.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(4, 2)
        >>> Y, U = np.eye(4, 2), np.eye(4, 2, -2)
        >>> float(M.sectional_curvature(Y, U, U[:, ::-1] * [1, -1]).round(14))
        2.0
        """
    def euclidean_to_riemannian_gradient(self, Y: ArrayLike, G: ArrayLike) -> _Frames:
        """Return the Riemannian gradient ``G - Y Y^T G`` for the Euclidean gradient ``G``, shape (..., n, k).

        The function must depend on the subspace alone, ``f(Y Q) = f(Y)`` for orthogonal ``Q``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal (with the measured defect).

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M, A = Grassmann(4, 2), np.diag([1.0, 2.0, 3.0, 4.0])
        >>> Y = M.random_point(rng=0)
        >>> bool(abs(M.euclidean_to_riemannian_gradient(Y, A @ Y) - (A @ Y - Y @ Y.T @ A @ Y)).max() < 1e-14)
        True
        """
    def euclidean_to_riemannian_hessian(self, Y: ArrayLike, G: ArrayLike, H: ArrayLike, V: ArrayLike) -> _Frames:
        """Apply the Riemannian Hessian to the tangent vector ``V`` at ``Y``, shape (..., n, k).

        The result is ``(I - Y Y^T) H - V Y^T G``.

        Parameters
        ----------
        Y : array_like, shape (..., n, k)
            Points.
        G, H : array_like, shape (..., n, k)
            Euclidean gradient, and Euclidean Hessian applied to ``V``, of a function that depends on the subspace
            alone.
        V : array_like, shape (..., n, k)
            Tangent vectors at ``Y``.

        Returns
        -------
        ndarray, shape (..., n, k)
            Covariant derivative of the gradient along ``V``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not horizontal (with the measured defect).

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M, A = Grassmann(3, 1), np.diag([1.0, 2.0, 3.0])
        >>> Y, V, _ = np.eye(3)[:, :, None]
        >>> M.euclidean_to_riemannian_hessian(Y, A @ Y, A @ V, V).ravel()
        array([0., 1., 0.])
        """

@disjoint_base
class Curve:
    """Smooth curve on a Stiefel or Grassmann manifold: the base class of all curves.

    If one of the arrays that define the curve is complex, the frames are complex, points and vectors are complex, and
    inner products in costs and lengths are the real parts of Hermitian products.

    All curves share this protocol. Calls with a scalar ``t`` return shape ``(n, k)``, calls with an array of shape
    ``T`` return ``T + (n, k)``. Many parameters are evaluated in parallel and without the GIL; results are
    bit-identical for any number of threads.
    """

    @property
    def n(self) -> int:
        """Number of rows of a point."""
    @property
    def k(self) -> int:
        """Number of columns of a point."""
    @property
    def field(self) -> _Field:
        """Field of the entries: "real" or "complex"."""
    @property
    def manifold(self) -> Stiefel | Grassmann:
        """Manifold of the points: a :class:`Stiefel`, or a :class:`Grassmann` for a curve of subspaces."""
    @property
    def t_span(self) -> tuple[float, float]:
        """Interval ``(start, end)`` on which the curve is defined."""
    def __call__(
        self, t: ArrayLike, nu: int = 0, *, extrapolate: bool | None = None, num_threads: int | None = None
    ) -> _Frames:
        """Position, or ambient derivative of order ``nu``, at ``t``; ``curve(t)`` calls this.

        Parameters
        ----------
        t : array_like, shape T
            Parameters, any finite numbers; the curve is defined on ``t_span`` and may extend beyond it.
        nu : int, default 0
            Order of the derivative, 0 to 3; exact, by differentiating the algorithm.
        extrapolate : bool, optional
            If True, evaluate the curve outside ``t_span`` too; if False, parameters outside raise. Parameters within 4
            ulp of an end (of the larger end in absolute value) count as that end. By default splines use their own
            ``extrapolate``, and all other curves are evaluated everywhere.
        num_threads : int, optional
            Number of threads; by default the size of the global pool.

        Returns
        -------
        ndarray, shape T + (n, k)

        Raises
        ------
        InvalidInputError
            ``t`` not finite or outside ``t_span``, ``nu`` out of range.
        OutsideDomainError
            No unique quasi-geodesic joins two intermediate points: outside ``t_span``, or for distant or fast data.
        """
    def velocity(self, t: ArrayLike, *, extrapolate: bool | None = None, num_threads: int | None = None) -> _Frames:
        """Return the velocity ``S'`` at ``t``, shape ``T + (n, k)``.

        The arguments are the same as for ``curve(t)``.
        """
    def acceleration(self, t: ArrayLike, *, extrapolate: bool | None = None, num_threads: int | None = None) -> _Frames:
        """Return the covariant acceleration ``D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``.

        The arguments are the same as for ``curve(t)``.
        """
    def jerk(self, t: ArrayLike, *, extrapolate: bool | None = None, num_threads: int | None = None) -> _Frames:
        """Return the covariant jerk ``D_t D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``.

        The arguments are the same as for ``curve(t)``.
        """
    def derivative(self, nu: int = 1) -> CurveDerivative:
        """Return the ambient derivative of order ``nu`` as a function of ``t``.

        Parameters
        ----------
        nu : int, default 1
            Order, 0 to 3.

        Returns
        -------
        CurveDerivative
            Callable like the curve; has a method ``derivative`` too.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> velocity = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).derivative()
        >>> velocity(0.0).round(6).ravel().tolist()
        [0.0, 1.570796]
        """
    def cost(self) -> float:
        """Return the cost: the integral of ``|D_t S'|^2`` over ``t_span``, canonical metric.

        With tension, the integral of ``|D_t S'|^2 + tension |S'|^2``.

        The relative error is 1e-12, or the round-off of the acceleration if that is larger.

        Raises
        ------
        ConvergenceError
            The quadrature did not converge.
        """
    def arc_length(self, t0: float | None = None, t1: float | None = None) -> float:
        """Return the length of the curve between two parameters, canonical metric.

        The relative error is 1e-12, or the round-off of the velocity or of the times if that is larger: 1e-6 for
        pieces of 0.01 s at Unix times.

        Parameters
        ----------
        t0, t1 : float, optional
            The ends, ``t0 <= t1``; by default the ends of ``t_span``.

        Raises
        ------
        InvalidInputError
            ``t0`` or ``t1`` not finite, ``t1 < t0``.
        ConvergenceError
            The quadrature did not converge.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).arc_length(0.0, 0.5)  # doctest: +ELLIPSIS
        0.78539816339...
        """
    def resample(self, count: int, *, num_threads: int | None = None) -> _Array:
        """Return parameters at which points of the curve are equally spaced in arc length.

        ``curve(curve.resample(count))`` samples the curve at constant speed.

        Parameters
        ----------
        count : int
            Number of parameters, at least two; the first and the last are the ends of ``t_span``.
        num_threads : int, optional
            Number of threads; by default the size of the global pool.

        Returns
        -------
        ndarray, shape (count,)
            Increasing; the lengths between neighbours agree to 1e-12 of the total length. Equally spaced for a constant
            curve.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).resample(3).round(12).tolist()
        [0.0, 0.5, 1.0]
        """
    def derivative_bounds(self) -> DerivativeBounds:
        """Bound the norms of velocity, covariant acceleration and covariant jerk over ``t_span``, canonical metric.

        For Riemannian cubics and their splines these are upper bounds, at most 1e-3 relative above the largest norms,
        or 1e-4 of a derivative of lower order if that is more than ten times as large, with the duration of a piece as
        the unit of time. For other curves they are the largest norms of a dense, refined sample. See
        :class:`DerivativeBounds`.

        Raises
        ------
        ConvergenceError
            The cubic is so long and fast that bounds would need too many samples.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
        >>> round(curve.derivative_bounds().velocity, 6)
        1.570796
        """
    def save(self, path: str | PathLike[str]) -> None:
        """Save all numbers of the curve to a file, from which :func:`load` restores the curve to the last bit.

        Parameters
        ----------
        path : str or os.PathLike
            Name of the file, usually ending in ``.npz``. An existing file is replaced once the new one is complete.

        Notes
        -----
        The file is an archive of plain arrays without pickles, which ``numpy.load`` reads too, and states the version
        of its format.
        """
    def plot(self, *, ax: Any = None, num: int = 200, **style: Any) -> Any:
        """Draw the curve with ``stiefel_rs.plotting.plot``; needs matplotlib (extra ``plot``).

        Curves with more than 60 matrix entries are drawn as an overview: angles of the columns to the start, speed,
        length of the covariant acceleration, and an image of all entries.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; by default those of a new figure.
        num : int, optional
            Number of points.
        **style
            Keyword arguments for the lines.

        Returns
        -------
        matplotlib.axes.Axes
            The axes with the curve.

        Raises
        ------
        ImportError
            matplotlib is not installed.
        """
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: object) -> Self: ...

@final
class DerivativeBounds:
    """Largest norms of the derivatives of a curve, canonical metric.

    Returned by :meth:`Curve.derivative_bounds`.
    """

    def __new__(
        cls, velocity: float, acceleration: float, jerk: float, guarantee: Literal["enclosure", "sampling"]
    ) -> DerivativeBounds: ...
    @property
    def velocity(self) -> float:
        """Largest norm of the velocity."""
    @property
    def acceleration(self) -> float:
        """Largest norm of the covariant acceleration."""
    @property
    def jerk(self) -> float:
        """Largest norm of the covariant jerk."""
    @property
    def guarantee(self) -> str:
        """How the numbers were found: ``"enclosure"`` or ``"sampling"``.

        ``"enclosure"``: upper bounds (up to round-off) that exceed the largest norms by at most 1e-3 relative, or by at
        most 1e-4 of a derivative of lower order if that is more than ten times as large, with the duration of a piece
        as the unit of time. ``"sampling"``: largest norms of a dense sample, refined around the maximum.
        """

@final
class QuasiGeodesic(Curve):
    """Quasi-geodesic ``beta(t) = e^{tX} S e^{t Omega}`` between two points.

    Parameters
    ----------
    S0, S1 : array_like, shape (n, k)
        Points with orthonormal columns; ``beta(0) = S0``, ``beta(1) = S1``. The curve is the principal branch, whose
        normal part ``|K|`` is minimal; another branch may be shorter in total because its ``Omega`` is smaller. Almost
        all pairs of points are joined.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    OutsideDomainError
        Antipodal points, a relative rotation by pi, or different components of O(n); carries ``angle``.

    Notes
    -----
    arXiv 2404.19407, Proposition 1; evaluated in ``O(n k^2)`` by a thin factorisation.

    Examples
    --------
    >>> from stiefel_rs import QuasiGeodesic
    >>> curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
    >>> curve(0.5).round(6).ravel().tolist()
    [0.707107, 0.707107]
    """

    def __new__(cls, S0: ArrayLike, S1: ArrayLike, *, project: bool = False) -> QuasiGeodesic: ...
    @staticmethod
    def from_velocity(S: ArrayLike, V: ArrayLike, *, project: bool = False) -> QuasiGeodesic:
        """Return the quasi-geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect).
        """

@disjoint_base
class GeometricPolynomial(Curve):
    """Geometric polynomial of any degree: de Casteljau's algorithm with quasi-geodesics or geodesics.

    Parameters
    ----------
    P : array_like, shape (degree + 1, n, k)
        At least two control points with orthonormal columns. The curve starts at the first and ends at the last; its
        end velocities are ``degree`` times the velocities of the first and the last piece between control points.
    pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
        Curves between control points. Quasi-geodesics have a closed form; geodesics (canonical metric) need a logarithm
        for every stage of every evaluated point, and a linear system for derivatives. On a :class:`Grassmann` the two
        are the same.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, and the curve consists of bases that start at the first given one and turn as
        little as possible, ``Y^T Y' = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    OutsideDomainError
        Consecutive points cannot be joined, or intermediate points reach an angle of pi inside the interval, where the
        curve would jump; with geodesics, consecutive points are not within the injectivity radius; consecutive
        subspaces have a principal angle of pi/2. Carries ``angle``, or the distance.

    Notes
    -----
    Krakowski, Machado, Silva Leite, Batista (2017); with geodesics Park, Ravani (1995). Computations take place in
    ``min(n, (degree + 1) k)`` dimensions.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import GeometricPolynomial
    >>> curve = GeometricPolynomial(np.eye(3)[:, :, None])
    >>> curve.degree
    2
    >>> bool(np.allclose(curve(1.0), np.eye(3)[:, 2:]))
    True
    """

    def __new__(
        cls,
        P: ArrayLike,
        *,
        pieces: Literal["quasi_geodesic", "geodesic"] = "quasi_geodesic",
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> GeometricPolynomial: ...
    @property
    def pieces(self) -> str:
        """Kind of the pieces: "quasi_geodesic" or "geodesic"."""
    @property
    def control_points(self) -> _Frames:
        """Control points, shape (degree + 1, n, k)."""
    @property
    def degree(self) -> int:
        """Degree: the number of control points minus one."""
    @property
    def report(self) -> SolverReport | None:
        """Outcome of the search for control points of minimal cost; None for other curves.

        The residual is the norm of the part of the acceleration that changes to first order with the control points.
        """
    @staticmethod
    def minimal_cost(
        S0: ArrayLike, V0: ArrayLike, S1: ArrayLike, V1: ArrayLike, *, degree: int = 5, project: bool = False
    ) -> GeometricPolynomial:
        """Return a curve of minimal cost among those of a given degree with given end points and end velocities.

        Parameters
        ----------
        S0, V0 : array_like, shape (n, k)
            Initial point and velocity.
        S1, V1 : array_like, shape (n, k)
            Final point and velocity, at ``t = 1``.
        degree : int, default 5
            From 3 (the geometric cubic, which has no free control point) to 10. Each additional degree reduces the
            distance to the Riemannian cubic about tenfold, and increases the time to construct and evaluate the curve.
        project : bool, default False
            As for the class.

        Returns
        -------
        GeometricPolynomial
            Its cost is a local minimum, to 1e-12 relative; ``report`` has the outcome of the search.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect); a
            degree out of range; an end velocity too long for the construction; or
            ``(degree - 3) * degree * (degree - 1) / 2 * r * k**2 * dim St(r, k)`` with ``r = min(n, 4 k)`` above 1.1e7,
            which would take minutes.
        OutsideDomainError
            Control points cannot be joined, or the curve would jump; carries ``angle``.
        ConvergenceError
            The search found no minimum; carries ``report``.

        Notes
        -----
        Gauss-Newton iteration on the inner control points, started from those of the geometric cubic. The result is a
        local minimum: other starting points may lead to other curves.

        The search may take longer than ``RiemannianCubic.from_boundary``, which solves for the exact cubic and is fast
        to evaluate too. Use this if a curve in closed form is needed.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import GeometricCubic, GeometricPolynomial
        >>> S0, V0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
        >>> S1, V1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
        >>> cubic = GeometricCubic(S0, V0, S1, V1)
        >>> better = GeometricPolynomial.minimal_cost(S0, V0, S1, V1, degree=6)
        >>> bool(better.cost() < cubic.cost())
        True
        """
    @staticmethod
    def quintic(
        S0: ArrayLike,
        V0: ArrayLike,
        A0: ArrayLike,
        S1: ArrayLike,
        V1: ArrayLike,
        A1: ArrayLike,
        *,
        project: bool = False,
    ) -> GeometricPolynomial:
        """Return the curve of degree five with given end points, velocities and covariant accelerations.

        The construction is in closed form.

        Parameters
        ----------
        S0, V0, A0 : array_like, shape (n, k)
            Initial point, velocity and covariant acceleration.
        S1, V1, A1 : array_like, shape (n, k)
            Final point, velocity and covariant acceleration, at ``t = 1``.
        project : bool, default False
            As for the class.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect); an
            end velocity or acceleration too long for the construction.
        OutsideDomainError
            Inner control points cannot be joined, or the curve would jump; carries ``angle``.

        Notes
        -----
        The curve meets its data to round-off. With the end accelerations of a Riemannian cubic it is close to that
        cubic. Curves that share an end point, velocity and acceleration join with continuous acceleration.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import GeometricPolynomial
        >>> S0, V0, A0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
        >>> S1, V1, A1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:], np.zeros((3, 1))
        >>> curve = GeometricPolynomial.quintic(S0, V0, A0, S1, V1, A1)
        >>> bool(np.allclose(curve.acceleration(0.0), A0))
        True
        """

@final
class Geodesic(Curve):
    """Riemannian geodesic between two points.

    Parameters
    ----------
    S0, S1 : array_like, shape (n, k)
        Points with orthonormal columns; ``gamma(0) = S0``, ``gamma(1) = S1``. The geodesic is that of ``Stiefel.log``,
        the shortest up to a distance of ``0.89 pi`` (canonical metric).
    metric : "canonical", "euclidean" or float, default "canonical"
        Metric of the geodesic, as for ``Stiefel``. The covariant ``acceleration`` and ``jerk`` and the ``cost`` use the
        canonical metric for every curve, so they vanish for canonical geodesics only.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, and the curve consists of bases that start at the first given one and turn as
        little as possible, ``Y^T Y' = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
    OutsideDomainError
        Antipodal points, a relative rotation by pi, or different components of O(n); carries ``angle``.
    ConvergenceError
        No geodesic was found; carries ``report``.

    Notes
    -----
    Edelman, Arias, Smith (1998); Hueper, Markina, Silva Leite (2021) for the family of metrics.

    Examples
    --------
    >>> from stiefel_rs import Geodesic
    >>> curve = Geodesic([[1.0], [0.0]], [[0.0], [1.0]])
    >>> curve(0.5).round(6).ravel().tolist()
    [0.707107, 0.707107]
    """

    def __new__(
        cls,
        S0: ArrayLike,
        S1: ArrayLike,
        *,
        metric: str | float | None = None,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> Geodesic: ...
    @staticmethod
    def from_velocity(
        S: ArrayLike,
        V: ArrayLike,
        *,
        metric: str | float | None = None,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> Geodesic:
        """Return the geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).

        Other arguments are the same as for the class.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect), or
            a vector so long that the result overflows.
        """
    @property
    def length(self) -> float:
        """Length over ``[0, 1]`` in the metric of the geodesic."""

@final
class GeometricCubic(GeometricPolynomial):
    """Geometric cubic: the adjusted de Casteljau curve with given boundary data.

    Parameters
    ----------
    S0, V0 : array_like, shape (n, k)
        Initial point and velocity.
    S1, V1 : array_like, shape (n, k)
        Final point and velocity, at ``t = 1``.
    pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
        Curves between control points. Geodesics (canonical metric) come much closer to the Riemannian cubic for
        ``k > 1``, where they differ from quasi-geodesics, but need a logarithm for every stage of every evaluated
        point, except for ``k = n - 1``, where they have a closed form too. For ``k = 1`` both give the same curve, but
        evaluating geodesics takes many times as long. On a :class:`Grassmann` the two are the same.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
        start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect); an end
        velocity too long for the construction.
    OutsideDomainError
        Inner control points cannot be joined, or intermediate points reach an angle of pi inside the interval, where
        the curve would jump; for subspaces, a principal angle of pi/2 between the inner control points. Carries
        ``angle``.

    Notes
    -----
    The curve meets its boundary data to round-off. It is close to the Riemannian cubic with the same data, but not
    equal to it. A third of each end velocity must be the initial velocity of a principal quasi-geodesic (on the sphere,
    speeds below ``3 pi``); longer velocities are refused.

    arXiv 2404.19407; Krakowski, Machado, Silva Leite, Batista (2017).

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import GeometricCubic
    >>> S0, V0 = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
    >>> S1, V1 = np.eye(3)[:, 1:2], np.eye(3)[:, 2:]
    >>> curve = GeometricCubic(S0, V0, S1, V1)
    >>> curve(np.linspace(0, 1, 5)).shape
    (5, 3, 1)
    >>> bool(np.allclose(curve.velocity(1.0), V1))
    True
    """

    def __new__(
        cls,
        S0: ArrayLike,
        V0: ArrayLike,
        S1: ArrayLike,
        V1: ArrayLike,
        *,
        pieces: Literal["quasi_geodesic", "geodesic"] = "quasi_geodesic",
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> GeometricCubic: ...
    @staticmethod
    def from_control_points(
        P: ArrayLike, *, manifold: Stiefel | Grassmann | None = None, project: bool = False
    ) -> GeometricCubic:
        """Return the geometric cubic with control points ``P``, shape (4, n, k).

        Parameters
        ----------
        P : array_like, shape (4, n, k)
            Control points with orthonormal columns.
        manifold : Stiefel or Grassmann, optional
            Manifold of the points, as for the class.
        project : bool, default False
            If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
            by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
            arrays in single precision are always projected.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal (with the measured defect).
        OutsideDomainError
            Consecutive points cannot be joined; carries ``angle``.
        """

@final
class RiemannianCubic(Curve):
    """Riemannian cubic: a critical curve of the integral of the squared covariant acceleration.

    Constructed by :meth:`from_initial` or :meth:`from_boundary`; the class cannot be called.

    Notes
    -----
    Solves ``D_t^3 S' + R(D_t S', S') S' = tension D_t S'`` (canonical metric) on any St(n, k), without charts, by a
    Taylor method of order 20 in ``min(n, 4 k)`` dimensions, to round-off. The solution of a boundary problem and a
    piece of a :class:`CubicSpline` may instead be a single polynomial about its midpoint, whose order depends on how
    fast it turns. Outside ``t_span`` each call integrates the curve anew; :meth:`restricted` returns a curve that
    stores the longer integration.

    Noakes, Heinzinger, Paden (1989); Crouch, Silva Leite (1995); Silva Leite, Camarinha, Crouch (2000) for tension.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import RiemannianCubic
    >>> S, V, A, J = np.eye(3)[:, :1], np.eye(3)[:, 1:2], 2 * np.eye(3)[:, 2:], np.zeros((3, 1))
    >>> curve = RiemannianCubic.from_initial(S, V, A, J)
    >>> curve(np.linspace(0, 1, 5)).shape
    (5, 3, 1)
    >>> bool(np.allclose(curve.acceleration(0.0), A))
    True
    >>> other = RiemannianCubic.from_boundary(S, V, curve(1.0), curve.velocity(1.0))
    >>> bool(np.allclose(other(0.5), curve(0.5))), other.report.converged
    (True, True)
    """

    def __new__(cls, *_args: object, **_kwargs: object) -> RiemannianCubic: ...
    @staticmethod
    def from_initial(
        S: ArrayLike,
        V: ArrayLike,
        A: ArrayLike,
        J: ArrayLike,
        t_end: float = 1.0,
        *,
        tol: float = 1e-17,
        tension: float = 0.0,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> RiemannianCubic:
        """Return the Riemannian cubic with given initial data.

        Parameters
        ----------
        S, V, A, J : array_like, shape (n, k)
            Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
        t_end : float, default 1.0
            End of ``t_span``, which starts at 0; may be negative.
        tol : float, default 1e-17
            Local error of a step, relative to the state, between 1e-17 (round-off) and 0.1. The orthonormality defect
            of points is about ``tol`` too.
        tension : float, default 0.0
            Weight of the squared velocity: the integral of ``|A|^2 + tension |V|^2`` is stationary. At least 0, in
            units of ``1 / t^2``.
        manifold : Stiefel or Grassmann, optional
            Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the
            points are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of
            bases that start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
        project : bool, default False
            If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
            by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
            arrays in single precision are always projected.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect),
            ``t_end`` zero, ``tol`` or ``tension`` out of range.
        ConvergenceError
            The integration needs more than 100000 steps, or more than fit into one gigabyte: ``t_end`` is too large for
            the speed. Carries ``report``, whose residual is the remaining time.
        """
    @overload
    @staticmethod
    def from_boundary(
        S0: ArrayLike,
        V0: ArrayLike,
        S1: ArrayLike,
        V1: ArrayLike,
        *,
        tol: float = 1e-12,
        max_iterations: int = 50,
        guess: Iterable[ArrayLike] | None = None,
        tension: float = 0.0,
        all_found: Literal[False] = False,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> RiemannianCubic:
        """Return a Riemannian cubic on ``[0, 1]`` with given end points and end velocities.

        Parameters
        ----------
        S0, V0 : array_like, shape (n, k)
            Initial point and velocity.
        S1, V1 : array_like, shape (n, k)
            Final point and velocity. Data with defects up to 1e-9, such as rounded decimals, are replaced by the
            nearest exact ones.
        tol : float, default 1e-12
            Largest error of end point and end velocity, as the Frobenius norm of both together. If an end speed exceeds
            10, the velocity error is relative to the larger end speed. The tolerance is at least ``32 eps`` times that
            speed (about 1e-12 at speed 140), but this bound never exceeds 1e-9; ``report.tolerance`` is the tolerance
            used.
        max_iterations : int, default 50
            Largest number of Newton steps from each starting point. Descent steps, up to 300 per descent, are bounded
            by the work limit only. If this is 12 or less, only Newton's method from the first start is tried. More than
            50 raise the work limit, about two seconds, in proportion.
        guess : pair (A, J) of array_like, optional
            Covariant acceleration and covariant jerk at ``S0``, shape (n, k) each, from which Newton's method starts;
            by default those of the cubic in flat space. On a :class:`Grassmann` they are horizontal at ``S0``.
        tension : float, default 0.0
            Weight of the squared velocity: the integral of ``|A|^2 + tension |V|^2``, which is :meth:`Curve.cost`, is
            stationary. 0 gives a cubic; for large values the curve is close to a geodesic except near its ends. Between
            0 and 64: an error at the start grows along the curve as ``exp(sqrt(tension) t)``.
        all_found : bool, default False
            If True, search for further solutions and return all that are found: by Newton's method from the cubic in
            flat space (or the guess), by descents from it and from cubics in flat space with one or two extra full
            turns, and by continuation in the boundary data from curves with an extra full turn. On a
            :class:`Grassmann`, by the same descents, where the cubics in flat space turn a principal direction by an
            extra pi or 2 pi, and by Newton's method from random initial data; for real lines (``k = 1``) on the sphere,
            with both unit vectors of the last line as end points.
        manifold : Stiefel or Grassmann, optional
            Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the
            points are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of
            bases that start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
        project : bool, default False
            If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
            by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
            arrays in single precision are always projected.

        Returns
        -------
        RiemannianCubic, or list of RiemannianCubic
            With ``all_found`` a list, sorted by increasing :meth:`Curve.cost`. It need not be complete: on the sphere
            there are infinitely many solutions.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect),
            ``tol`` not between 1e-15 and 0.1, ``max_iterations`` less than 1, ``tension`` not between 0 and 64.
        OutsideDomainError
            The points lie in different components of O(n), or a principal angle between subspaces is pi/2; carries
            ``angle``.
        ConvergenceError
            No solution to ``tol`` was found, or the curve needs more Taylor steps than are allowed because the data or
            the guess are too fast. Carries ``report``, whose residual is the error at the end, or the remaining time.

        Notes
        -----
        Cubics with given ends are stationary, not unique. If displacement and speeds are at most 2, Newton's method
        starts from the cubic in flat space; from a guess it starts at any distance. If it fails, and for other data,
        chains of cubics descend to local minima of the cost: from a curve that rolls evenly from one velocity to the
        other; for end speeds up to 16 also from the cubic in flat space; and from the de Casteljau curve if several
        quasi-geodesics join the points. The solution of least cost is returned. If the descents would exceed the work
        limit (dimension 57 or more, as for St(15,5), SO(12) and complex St(10,4)), the solution from the cubic in flat
        space is preferred, which need not have the least cost. ``report.strategy`` says how the solution was found, and
        :meth:`Curve.cost` compares solutions.

        Of subspaces, several solutions are compared if they are more than 1.4 apart or speeds exceed 2, complex ones if
        they are more than 1.2 apart or speeds exceed 1.4.

        Between opposite points with slow ends, solutions nearly form a continuous family: some are refused with end
        speeds below 1e-5 on St(6,3), below 1e-3 on St(10,3), and none on spheres.

        The search stops at a work limit of about two seconds. Ctrl-C stops it at once.
        """
    @overload
    @staticmethod
    def from_boundary(
        S0: ArrayLike,
        V0: ArrayLike,
        S1: ArrayLike,
        V1: ArrayLike,
        *,
        tol: float = 1e-12,
        max_iterations: int = 50,
        guess: Iterable[ArrayLike] | None = None,
        tension: float = 0.0,
        all_found: Literal[True],
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> list[RiemannianCubic]:
        """Return a Riemannian cubic on ``[0, 1]`` with given end points and end velocities.

        Parameters
        ----------
        S0, V0 : array_like, shape (n, k)
            Initial point and velocity.
        S1, V1 : array_like, shape (n, k)
            Final point and velocity. Data with defects up to 1e-9, such as rounded decimals, are replaced by the
            nearest exact ones.
        tol : float, default 1e-12
            Largest error of end point and end velocity, as the Frobenius norm of both together. If an end speed exceeds
            10, the velocity error is relative to the larger end speed. The tolerance is at least ``32 eps`` times that
            speed (about 1e-12 at speed 140), but this bound never exceeds 1e-9; ``report.tolerance`` is the tolerance
            used.
        max_iterations : int, default 50
            Largest number of Newton steps from each starting point. Descent steps, up to 300 per descent, are bounded
            by the work limit only. If this is 12 or less, only Newton's method from the first start is tried. More than
            50 raise the work limit, about two seconds, in proportion.
        guess : pair (A, J) of array_like, optional
            Covariant acceleration and covariant jerk at ``S0``, shape (n, k) each, from which Newton's method starts;
            by default those of the cubic in flat space. On a :class:`Grassmann` they are horizontal at ``S0``.
        tension : float, default 0.0
            Weight of the squared velocity: the integral of ``|A|^2 + tension |V|^2``, which is :meth:`Curve.cost`, is
            stationary. 0 gives a cubic; for large values the curve is close to a geodesic except near its ends. Between
            0 and 64: an error at the start grows along the curve as ``exp(sqrt(tension) t)``.
        all_found : bool, default False
            If True, search for further solutions and return all that are found: by Newton's method from the cubic in
            flat space (or the guess), by descents from it and from cubics in flat space with one or two extra full
            turns, and by continuation in the boundary data from curves with an extra full turn. On a
            :class:`Grassmann`, by the same descents, where the cubics in flat space turn a principal direction by an
            extra pi or 2 pi, and by Newton's method from random initial data; for real lines (``k = 1``) on the sphere,
            with both unit vectors of the last line as end points.
        manifold : Stiefel or Grassmann, optional
            Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the
            points are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of
            bases that start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
        project : bool, default False
            If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors
            by their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5;
            arrays in single precision are always projected.

        Returns
        -------
        RiemannianCubic, or list of RiemannianCubic
            With ``all_found`` a list, sorted by increasing :meth:`Curve.cost`. It need not be complete: on the sphere
            there are infinitely many solutions.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect),
            ``tol`` not between 1e-15 and 0.1, ``max_iterations`` less than 1, ``tension`` not between 0 and 64.
        OutsideDomainError
            The points lie in different components of O(n), or a principal angle between subspaces is pi/2; carries
            ``angle``.
        ConvergenceError
            No solution to ``tol`` was found, or the curve needs more Taylor steps than are allowed because the data or
            the guess are too fast. Carries ``report``, whose residual is the error at the end, or the remaining time.

        Notes
        -----
        Cubics with given ends are stationary, not unique. If displacement and speeds are at most 2, Newton's method
        starts from the cubic in flat space; from a guess it starts at any distance. If it fails, and for other data,
        chains of cubics descend to local minima of the cost: from a curve that rolls evenly from one velocity to the
        other; for end speeds up to 16 also from the cubic in flat space; and from the de Casteljau curve if several
        quasi-geodesics join the points. The solution of least cost is returned. If the descents would exceed the work
        limit (dimension 57 or more, as for St(15,5), SO(12) and complex St(10,4)), the solution from the cubic in flat
        space is preferred, which need not have the least cost. ``report.strategy`` says how the solution was found, and
        :meth:`Curve.cost` compares solutions.

        Of subspaces, several solutions are compared if they are more than 1.4 apart or speeds exceed 2, complex ones if
        they are more than 1.2 apart or speeds exceed 1.4.

        Between opposite points with slow ends, solutions nearly form a continuous family: some are refused with end
        speeds below 1e-5 on St(6,3), below 1e-3 on St(10,3), and none on spheres.

        The search stops at a work limit of about two seconds. Ctrl-C stops it at once.
        """
    @property
    def report(self) -> SolverReport | None:
        """Outcome of the boundary value solver; None for a curve from initial data."""
    @property
    def initial(self) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, shape (n, k) each."""
    @property
    def tension(self) -> float:
        """Weight of the squared velocity; 0 for a cubic."""
    @property
    def energy(self) -> float:
        """Conserved energy ``|D_t S'|^2 / 2 - <D_t D_t S', S'> + tension |S'|^2 / 2``."""
    @property
    def momentum(self) -> _Frames:
        """Conserved spatial momentum, a skew-symmetric matrix of shape (n, n); for ``n`` up to 16384."""
    @property
    def steps(self) -> int:
        """Number of polynomials in the curve.

        The number of integration steps, or 1 for a solution of a boundary problem or a piece of a spline that was found
        without integration.
        """
    def restricted(self, start: float, end: float) -> RiemannianCubic:
        """Return the same curve on ``[start, end]``, which may extend beyond ``t_span``.

        Raises
        ------
        InvalidInputError
            ``start >= end``, or not finite.
        ConvergenceError
            The curve cannot be integrated that far; carries ``report``.
        """
    def reparametrised(self, start: float, end: float) -> RiemannianCubic:
        """Return the curve with its parameter transformed linearly so that ``t_span`` becomes ``[start, end]``.

        Raises
        ------
        InvalidInputError
            ``start >= end``, not finite, or so close or far apart that speeds overflow or underflow.
        """
    def reversed(self) -> RiemannianCubic:
        """Return the curve run backwards over the same interval."""
    def initial_variation(
        self, dS0: ArrayLike, dV0: ArrayLike, dS1: ArrayLike, dV1: ArrayLike
    ) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Differentiate the initial data with respect to the boundary data, by the implicit function theorem.

        On a :class:`Grassmann` data and results belong to the bases of the curve, ``curve(t)``; at the end this basis
        differs from the given one by an orthogonal matrix. Derivatives of points are horizontal, ``S^H dS = 0``: the
        rotation of the bases themselves is left out. Vectors stay horizontal along the family, so that their
        derivatives satisfy ``S^H dV = -dS^H V`` and are horizontal if the point is fixed.

        Parameters
        ----------
        dS0, dV0, dS1, dV1 : array_like, shape (n, k)
            Ambient derivatives of the boundary data along a family of data: at both ends ``S.T @ dS`` is skew, and
            ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` is zero.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of
            ``t_span``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, or a variation that violates the constraints (with the measured defect).
        OutsideDomainError
            The ends are conjugate along the curve, to 1e-11, so that the solution does not depend smoothly on them;
            ``angle`` is None.

        Notes
        -----
        Derivatives are exact, not finite differences. Any Riemannian cubic solves the boundary value problem of its own
        ends; this is the derivative of that solution.
        """
    def point_variation(self, t: ArrayLike, dS0: ArrayLike, dV0: ArrayLike, dS1: ArrayLike, dV1: ArrayLike) -> _Frames:
        """Differentiate points of the curve with respect to the boundary data.

        On a :class:`Grassmann` data and results belong to the bases of the curve, ``curve(t)``; at the end this basis
        differs from the given one by an orthogonal matrix. Derivatives of points are horizontal, ``S^H dS = 0``: the
        rotation of the bases themselves is left out. Vectors stay horizontal along the family, so that their
        derivatives satisfy ``S^H dV = -dS^H V`` and are horizontal if the point is fixed.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        dS0, dV0, dS1, dV1 : array_like, shape (n, k)
            As for :meth:`initial_variation`.

        Returns
        -------
        ndarray, shape T + (n, k)
            Ambient derivatives of the points.

        Raises
        ------
        InvalidInputError, OutsideDomainError
            As for :meth:`initial_variation`.
        """
    def point_pullback(self, t: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Return the gradient of ``sum(W * curve(t))`` with respect to the boundary data.

        The transpose of :meth:`point_variation`.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        W : array_like, shape T + (n, k)
            Derivatives of a function with respect to the points ``curve(t)``; need not be tangent.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            ``(GS0, GV0, GS1, GV1)``: ``sum(W * point_variation(t, dS0, dV0, dS1, dV1))`` equals ``sum(GS0 * dS0) +
            sum(GV0 * dV0) + sum(GS1 * dS1) + sum(GV1 * dV1)`` for every variation of the boundary data.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries.
        OutsideDomainError
            The ends are conjugate along the curve, to 1e-11, so that the solution does not depend smoothly on them;
            ``angle`` is None.

        Notes
        -----
        Solves one linear system, whatever the number of parameters.
        """
    def cost_gradient(self) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Return the gradient of the cost with respect to the boundary data.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            ``(GS0, GV0, GS1, GV1)``: the cost changes by ``sum(GS0 * dS0) + sum(GV0 * dV0) + sum(GS1 * dS1) +
            sum(GV1 * dV1)`` for every variation of the boundary data as in :meth:`initial_variation`.

        Notes
        -----
        Uses the first variation of the cost at a critical curve, so no equation has to be solved.
        """
    def initial_point_variation(
        self, t: ArrayLike, dS: ArrayLike, dV: ArrayLike, dA: ArrayLike, dJ: ArrayLike
    ) -> _Frames:
        """Differentiate points of the curve with respect to its initial data.

        On a :class:`Grassmann` data and results belong to the bases of the curve, ``curve(t)``; at the end this basis
        differs from the given one by an orthogonal matrix. Derivatives of points are horizontal, ``S^H dS = 0``: the
        rotation of the bases themselves is left out. Vectors stay horizontal along the family, so that their
        derivatives satisfy ``S^H dV = -dS^H V`` and are horizontal if the point is fixed.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        dS, dV, dA, dJ : array_like, shape (n, k)
            Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of
            ``t_span``, along a family of data: ``S.T @ dS`` is skew, and ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS``
            is zero, likewise for A and J.

        Returns
        -------
        ndarray, shape T + (n, k)
            Ambient derivatives of the points.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, or a variation that violates the constraints (with the measured defect).
        """
    def initial_point_pullback(self, t: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Return the gradient of ``sum(W * curve(t))`` with respect to the initial data.

        The transpose of :meth:`initial_point_variation`.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        W : array_like, shape T + (n, k)
            Derivatives of a function with respect to the points ``curve(t)``; need not be tangent.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            ``(GS, GV, GA, GJ)``: ``sum(W * initial_point_variation(t, dS, dV, dA, dJ))`` equals
            ``sum(GS * dS) + sum(GV * dV) + sum(GA * dA) + sum(GJ * dJ)`` for every variation of the initial data.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries.
        """

@disjoint_base
class PiecewiseCurve(Curve):
    """Piecewise curve through points, made of cubics: the base class of splines.

    Constructed by :class:`CubicSpline`, :class:`CubicHermite` and :class:`SmoothingSpline`.
    """

    @property
    def t(self) -> _Array:
        """Times of the knots; read-only, shape (N,)."""
    @property
    def points(self) -> _Frames:
        """Points of the curve at the knots, as given, projected or smoothed; read-only, shape (N, n, k)."""
    @property
    def kind(self) -> str:
        """Kind of the pieces: ``"riemannian"`` or ``"geometric"``."""
    @property
    def extrapolate(self) -> bool:
        """Whether the first and the last piece are continued outside ``t_span`` by default."""
    @property
    def report(self) -> SolverReport | None:
        """Outcome of the solver; None if the pieces were constructed independently."""
    @property
    def pieces(self) -> list[RiemannianCubic] | list[GeometricCubic]:
        """The ``N - 1`` pieces, each as a curve on ``[0, 1]``."""

@final
class CubicHermite(PiecewiseCurve):
    """Curve through points with given velocities, continuously differentiable.

    Parameters
    ----------
    t : array_like, shape (N,)
        At least two increasing times.
    S : array_like, shape (N, n, k)
        Points with orthonormal columns.
    V : array_like, shape (N, n, k), or str
        Tangent vectors at the points: velocities per unit of ``t``. A string names a method of
        :func:`estimate_velocities`: ``"catmull-rom"``, ``"akima"`` or ``"natural"``.
    kind : "riemannian" or "geometric", default "riemannian"
        Pieces: Riemannian cubics, or geometric cubics, which other programs can evaluate from control points by de
        Casteljau's algorithm. On small manifolds geometric cubics take longer to construct.
    extrapolate : bool, default False
        If True, the first and the last piece are continued outside ``[t[0], t[-1]]``; by default such times raise.
    num_threads : int, optional
        Number of threads; by default the size of the global pool.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
        start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Mismatched shapes or numbers of knots, non-finite entries, times that do not increase, points not orthonormal,
        vectors not tangent (with the measured defect). Names the knot; carries ``knot``.
    OutsideDomainError
        No curve joins two consecutive points; carries ``knot``, the index of the first, and ``angle``.
    ConvergenceError
        No Riemannian cubic was found between two consecutive points; carries ``knot`` and ``report``.
    TypeError
        ``t`` is complex, or holds dates or durations.

    See Also
    --------
    CubicSpline : twice continuously differentiable curve through points alone.

    Notes
    -----
    The pieces are constructed independently of each other, in parallel.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import CubicHermite
    >>> t = np.array([0.0, 1.0, 3.0])
    >>> S = np.array([[[np.cos(a)], [np.sin(a)]] for a in t / 4])
    >>> V = np.array([[[-np.sin(a)], [np.cos(a)]] for a in t / 4]) / 4
    >>> curve = CubicHermite(t, S, V)
    >>> bool(np.allclose(curve(2.0).ravel(), [np.cos(0.5), np.sin(0.5)]))
    True
    """

    def __new__(
        cls,
        t: ArrayLike,
        S: ArrayLike,
        V: ArrayLike | _Velocities,
        kind: Literal["riemannian", "geometric"] = "riemannian",
        *,
        extrapolate: bool = False,
        num_threads: int | None = None,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> CubicHermite: ...
    @property
    def velocities(self) -> _Frames:
        """Velocities at the knots, as given or estimated, shape (N, n, k); read-only."""

@final
class CubicSpline(PiecewiseCurve):
    """Spline of cubics through points, with continuous velocity and covariant acceleration.

    Parameters
    ----------
    t : array_like, shape (N,)
        At least two increasing times.
    S : array_like, shape (N, n, k)
        Points with orthonormal columns.
    bc_type : str or pair, default "natural"
        End conditions: ``"natural"``, zero covariant acceleration; ``"clamped"``, zero velocity; ``"periodic"``, the
        last point equals the first, and velocity and covariant acceleration agree there. Or a pair of conditions for
        the first and the last point: each ``"natural"``, ``"clamped"``, ``(1, V)`` with a velocity or ``(2, A)`` with a
        covariant acceleration, tangent vectors of shape (n, k).
    kind : "riemannian" or "geometric", default "riemannian"
        Pieces: Riemannian cubics, for which the cost is stationary, or geometric cubics (adjusted de Casteljau), whose
        cost is close to it. A geometric spline is found in about a twentieth of the time on St(20, 4), but takes about
        3, 6 and 10 times as long on the sphere, St(3, 2) and St(3, 3). Evaluation takes longer: 5 times on St(3, 3).
    extrapolate : bool, default False
        If True, the first and the last piece are continued outside ``[t[0], t[-1]]``; by default such times raise.
    tol : float, default 1e-12
        Largest distance between the end of a piece and its knot, and largest jump of the covariant acceleration, with
        the duration of the piece as the unit of time; where a descent finds the spline, that of the parts of the piece.
    max_iterations : int, default 200
        Largest number of steps, not counting descents. More than 200 raise the work limit, about two seconds, in
        proportion.
    tension : float, default 0.0
        Weight of the squared velocity, for Riemannian pieces: the integral of ``|A|^2 + tension |V|^2`` is stationary,
        and for large values the curve is close to geodesics between the points. In units of ``1 / t^2``, at least 0,
        and at most 64 divided by the square of the longest interval between knots, since an error at its start grows as
        ``exp(sqrt(tension) t)``. If the columns of all points span more than ``max(12, 4 k)`` dimensions, the limit is
        6.25 instead of 64.
    num_threads : int, optional
        Number of threads; by default the size of the global pool.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
        start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Mismatched shapes or numbers of knots, non-finite entries, times that do not increase, points not orthonormal,
        vectors not tangent (with the measured defect), periodic data that do not close, ``tension`` out of range. Names
        the knot; carries ``knot``.
    OutsideDomainError
        No curve, or no unique shortest one, joins two consecutive points; carries ``knot``, the index of the first, and
        ``angle``.
    ConvergenceError
        No spline was found; carries ``report``, and ``knot`` if the interval after it is much longer than a neighbour
        and the curve would be fast there.
    TypeError
        ``t`` is complex, or holds dates or durations.

    See Also
    --------
    CubicHermite : curve through points with given velocities.

    Notes
    -----
    With Riemannian pieces the integral of the squared covariant acceleration is stationary among the curves through the
    points with these end conditions, as for cubic splines in flat space. All pieces are solved for at once, in time
    linear in their number.

    Noakes, Heinzinger, Paden (1989); Crouch, Silva Leite (1995).

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import CubicSpline
    >>> from scipy.interpolate import CubicSpline as Flat
    >>> t, angle = np.arange(5.0), np.array([0.0, 0.4, 1.0, 0.7, 0.2])
    >>> curve = CubicSpline(t, np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None])
    >>> flat = Flat(t, angle, bc_type="natural")
    >>> bool(np.allclose(curve(2.5).ravel(), [np.cos(flat(2.5)), np.sin(flat(2.5))]))
    True
    """

    def __new__(
        cls,
        t: ArrayLike,
        S: ArrayLike,
        bc_type: _BcType = "natural",
        kind: Literal["riemannian", "geometric"] = "riemannian",
        *,
        extrapolate: bool = False,
        tol: float = 1e-12,
        max_iterations: int = 200,
        tension: float = 0.0,
        num_threads: int | None = None,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
    ) -> CubicSpline: ...
    @property
    def bc_type(self) -> _BcType:
        """End conditions as given: a string or a pair; arrays are read-only."""
    def point_variation(
        self,
        t: ArrayLike,
        dS: ArrayLike,
        dt: ArrayLike | None = None,
        dbc: tuple[ArrayLike | None, ArrayLike | None] | None = None,
    ) -> _Frames:
        """Differentiate points of the spline with respect to its data, by the implicit function theorem.

        On a :class:`Grassmann` variations belong to the bases of the curve at its knots, ``curve(t)``, which differ
        from ``S`` by orthogonal matrices; those of points are horizontal, those of vectors satisfy
        ``S^H dV = -dS^H V``. At the end of a periodic curve the first basis returns multiplied by
        ``Q = curve(t[0])^H curve(t[-1])``.

        Parameters
        ----------
        t : array_like, shape T
            Times.
        dS : array_like, shape (N, n, k)
            Ambient derivatives of the points along a family of data: ``S.T @ dS`` is skew for each. With periodic ends
            the last equals the first; on a :class:`Grassmann` ``dS[-1] = dS[0] @ Q``.
        dt : array_like, shape (N,), optional
            Derivatives of the times of the knots; by default zero.
        dbc : pair of array_like, shape (n, k), or None, optional
            Ambient derivatives of the vectors in ``bc_type`` at the first and at the last knot:
            ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` is zero. By default, and for None, zero; this is valid for
            vectors that remain zero, as with ``"clamped"``.

        Returns
        -------
        ndarray, shape T + (n, k)
            Ambient derivatives of the points at the fixed times ``t``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, or a variation that violates the constraints (with the measured defect); a
            spline with ``kind="geometric"``, or one solved with so large a tolerance that its error exceeds 1e-6.
        OutsideDomainError
            The spline does not depend smoothly on its data, to 1e-11; ``angle`` is None.

        Notes
        -----
        Derivatives are exact, not finite differences: they combine the derivatives of the accelerations at the ends of
        the pieces with respect to points and velocities there, and a linear system for the velocities, in time linear
        in the number of knots.
        """
    def point_pullback(
        self, t: ArrayLike, W: ArrayLike
    ) -> tuple[_Frames, _Array, tuple[_Frames | None, _Frames | None]]:
        """Return the gradient of ``sum(W * curve(t))`` with respect to the data.

        The transpose of :meth:`point_variation`.

        Parameters
        ----------
        t : array_like, shape T
            Times.
        W : array_like, shape T + (n, k)
            Derivatives of a function with respect to the points ``curve(t)``; need not be tangent.

        Returns
        -------
        GS : ndarray, shape (N, n, k)
            With respect to the points. With periodic ends the gradient by the common end point is the sum of the first
            and the last entry; on a :class:`Grassmann`, ``GS[0] + GS[-1] Q^H`` with the ``Q`` of
            :meth:`point_variation`.
        Gt : ndarray, shape (N,)
            With respect to the times.
        Gbc : tuple
            With respect to the vectors in ``bc_type`` at the first and at the last knot, shape (n, k); None if there is
            none.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries; a spline with ``kind="geometric"``, or one solved with so large a tolerance
            that its error exceeds 1e-6.
        OutsideDomainError
            The spline does not depend smoothly on its data, to 1e-11; ``angle`` is None.

        Notes
        -----
        ``sum(W * point_variation(t, dS, dt, dbc))`` equals the sum of the products of the gradients with the
        variations. Solves one linear system, whatever the number of times.
        """
    def cost_gradient(self) -> tuple[_Frames, _Array, tuple[_Frames | None, _Frames | None]]:
        """Return the gradient of the cost with respect to points, times and end conditions.

        Returns
        -------
        GS : ndarray, shape (N, n, k)
            With respect to the points. With periodic ends the gradient by the common end point is the sum of the first
            and the last entry; on a :class:`Grassmann`, ``GS[0] + GS[-1] Q^H`` with the ``Q`` of
            :meth:`point_variation`.
        Gt : ndarray, shape (N,)
            With respect to the times.
        Gbc : tuple
            With respect to the vectors in ``bc_type`` at the first and at the last knot, shape (n, k); None if there is
            none.

        Raises
        ------
        InvalidInputError
            A spline with ``kind="geometric"``, or one solved with so large a tolerance that its error exceeds 1e-6.
        OutsideDomainError
            ``bc_type`` gives an acceleration, and the spline does not depend smoothly on its data, to 1e-11; ``angle``
            is None.

        Notes
        -----
        Uses the first variation of the cost; an equation has to be solved only if ``bc_type`` gives an acceleration.
        """

@final
class SmoothingSpline(PiecewiseCurve):
    """Smoothing spline: a curve near data points that trades distance to the data against cost.

    Makes ``sum_i weights[i] d(S(t[i]), S[i])^2 + lam J`` stationary, where ``d`` is the Riemannian distance and ``J``
    the integral of the squared covariant acceleration.

    Parameters
    ----------
    t : array_like, shape (N,)
        Nondecreasing times.
    S : array_like, shape (N, n, k)
        Data points with orthonormal columns.
    weights : array_like, shape (N,), optional
        Positive weights; by default 1.
    lam : float, optional
        Weight of the cost, at least 0, in units of squared distance times the cube of time: 0 gives the natural spline
        through the data, ``inf`` geodesic regression. By default chosen by generalised cross-validation, which needs at
        least three points.
    extrapolate : bool, default False
        If True, the first and the last piece are continued outside ``[t[0], t[-1]]``; by default such times raise.
    tol : float, default 1e-11
        Largest distance between the end of a piece and its knot, jump of the covariant acceleration, and imbalance of
        the stationarity equations at a knot, with the duration of the piece as the unit of time.
    max_iterations : int, default 200
        Largest number of steps. More than 200 raise the work limit, about two seconds, in proportion.
    num_threads : int, optional
        Number of threads; by default the size of the global pool.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
        start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    w : array_like, optional
        Alias of `weights`, as in SciPy.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Raises
    ------
    InvalidInputError
        Mismatched shapes or lengths, non-finite entries, decreasing times, weights that are not positive, points not
        orthonormal (with the measured defect). Names the knot, counted by distinct times; carries ``knot``.
    OutsideDomainError
        No curve joins two consecutive points; carries ``knot``, the index of the first, and ``angle``.
    ConvergenceError
        No spline was found; carries ``report``.
    TypeError
        ``t`` is complex, or holds dates or durations.

    See Also
    --------
    CubicSpline : curve through the points.

    Notes
    -----
    The attribute ``t`` holds the distinct times, ``points`` the points of the curve at these times.

    Reinsch (1967) in flat space; Samir, Absil, Srivastava, Klassen (2012) on manifolds; Craven, Wahba (1979) for
    cross-validation.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import SmoothingSpline
    >>> t = np.linspace(0, 1, 20)
    >>> angle = t**2 + 0.01 * np.random.default_rng(0).standard_normal(20)
    >>> curve = SmoothingSpline(t, np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None])
    >>> bool(abs(np.arctan2(*curve(0.5)[::-1, 0]) - 0.25) < 0.01), curve.degrees_of_freedom < 10
    (True, True)
    """

    def __new__(
        cls,
        t: ArrayLike,
        S: ArrayLike,
        weights: ArrayLike | None = None,
        lam: float | None = None,
        *,
        extrapolate: bool = False,
        tol: float = 1e-11,
        max_iterations: int = 200,
        num_threads: int | None = None,
        manifold: Stiefel | Grassmann | None = None,
        project: bool = False,
        w: ArrayLike | None = None,
    ) -> SmoothingSpline: ...
    @property
    def lam(self) -> float:
        """Weight of the cost, as given or as found by cross-validation."""
    @property
    def misfit(self) -> float:
        """Weighted sum of squared distances to the data, ``sum_i weights[i] d(S(t[i]), S[i])^2``."""
    @property
    def degrees_of_freedom(self) -> float:
        """Effective number of degrees of freedom, between 2 and the number of data.

        The trace of the influence matrix of the smoothing spline in flat space.
        """

@final
class RotationCurve:
    """Curve of rotations as unit quaternions: the form that :class:`RotationSpline` evaluates.

    Parameters
    ----------
    t : array_like, shape (N,)
        At least two increasing times, in seconds.
    quaternions : array_like, shape (N, 4)
        Rotations as quaternions, scalar last, of any nonzero length.
    bc_type : str or pair, default "natural"
        ``"natural"``, ``"clamped"``, ``"periodic"`` or a pair of end conditions, each ``"natural"``, ``"clamped"``,
        ``(1, w)`` with a body rate in rad/s or ``(2, a)`` with its derivative in rad/s^2, of shape (3,).
    tol : float, default 1e-12
        As for :class:`CubicSpline`.
    max_iterations : int, default 200
        As for :class:`CubicSpline`.
    tension : float, default 0.0
        As for :class:`CubicSpline`, in 1/s^2.
    extrapolate : bool, default True
        Whether ``curve`` continues its end pieces; this form always does.
    num_threads : int, optional
        Number of threads; by default the size of the global pool.

    Raises
    ------
    InvalidInputError
        Mismatched shapes, non-finite entries, a quaternion of length zero, times that do not increase.
    OutsideDomainError
        Two consecutive rotations are half a turn apart; carries ``knot``, the index of the first, and ``angle``.
    ConvergenceError
        No spline was found; carries ``report``, and ``knot`` if the interval after it explains why.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs._core import RotationCurve
    >>> half = np.array([0.0, 0.5, 0.25])
    >>> q = np.stack([0 * half, 0 * half, np.sin(half), np.cos(half)], axis=-1)
    >>> curve = RotationCurve([0.0, 1.0, 2.0], q)
    >>> bool(np.allclose(curve.quaternions([1.0]), q[1]))
    True
    """

    def __new__(
        cls,
        t: ArrayLike,
        quaternions: ArrayLike,
        bc_type: _BcType = "natural",
        *,
        tol: float = 1e-12,
        max_iterations: int = 200,
        tension: float = 0.0,
        extrapolate: bool = True,
        num_threads: int | None = None,
    ) -> RotationCurve: ...
    @staticmethod
    def of_curve(curve: CubicSpline | SmoothingSpline | CubicHermite, start: ArrayLike | None = None) -> RotationCurve:
        """Convert a curve of Riemannian cubics on ``St(3, 3)`` to quaternion form.

        Parameters
        ----------
        curve : CubicSpline, CubicHermite or SmoothingSpline
            A curve of rotation matrices with ``kind="riemannian"``.
        start : array_like, shape (4,), optional
            Quaternion near the rotation at the first knot, scalar last: fixes the sign of the quaternions.

        Raises
        ------
        InvalidInputError
            The curve is of another kind or on another manifold, or its matrices have determinant -1.

        Returns
        -------
        RotationCurve
            The end pieces are continued beyond the first and the last knot, even if ``curve`` raises for such times.
        """
    def quaternions(self, t: ArrayLike) -> _Array:
        """Evaluate unit quaternions at times.

        Parameters
        ----------
        t : array_like, shape (T,)
            Times in seconds; the end pieces are continued beyond the keyframes.

        Returns
        -------
        ndarray, shape (T, 4)
            Scalar last, continuous in `t`; at the first keyframe equal to the given one, normalised.
        """
    def rates(self, t: ArrayLike, order: int) -> _Array:
        """Evaluate body rates at times, or their derivatives.

        Parameters
        ----------
        t : array_like, shape (T,)
            Times in seconds; the end pieces are continued beyond the keyframes.
        order : int
            1, 2 or 3: body rate in rad/s, its first derivative in rad/s^2, its second derivative in rad/s^3.

        Returns
        -------
        ndarray, shape (T, 3)
        """
    def __copy__(self, /) -> RotationCurve: ...
    def __deepcopy__(self, _memo: object, /) -> RotationCurve: ...
    @property
    def curve(self) -> CubicSpline | SmoothingSpline | CubicHermite:
        """The same curve on ``St(3, 3)``."""
    @property
    def t(self) -> _Array:
        """Times of the keyframes in seconds; read-only, shape (N,)."""
    @property
    def report(self) -> SolverReport | None:
        """Outcome of the solver."""

@final
class ShootingResult:
    """Discrete trajectory with given ends, found by :meth:`Chart.shoot`."""

    @property
    def trajectory(self) -> _Array:
        """States, shape (steps + 1, 4 d)."""
    @property
    def momenta(self) -> tuple[_Array, _Array]:
        """Initial momenta ``(p_q, p_qdot)``, each of shape (d,)."""
    @property
    def report(self) -> SolverReport:
        """Outcome of the solver."""

@final
class ChartTrajectory:
    """Curve across charts, at times of shape ``T``; ``(steps + 1,)`` for a discrete trajectory."""

    @property
    def point(self) -> _Array:
        """Points, shape T + (3, k)."""
    @property
    def velocity(self) -> _Array:
        """Velocities, shape T + (3, k)."""
    @property
    def acceleration(self) -> _Array:
        """Covariant accelerations, shape T + (3, k)."""
    @property
    def jerk(self) -> _Array:
        """Covariant jerks, shape T + (3, k)."""
    @property
    def energy(self) -> _Array:
        """Hamiltonian, shape T."""
    @property
    def momentum(self) -> _Array:
        """Momentum of rotations of space about the three axes, conserved along a Riemannian cubic, shape T + (3,)."""
    @property
    def states(self) -> _Array:
        """States ``(q, qdot, p_q, p_qdot)`` of the points ``rotations @ point`` in the chart, shape T + (4 d,)."""
    @property
    def rotations(self) -> _Array:
        """Chart of each point as a cyclic permutation of the axes, shape T + (3, 3); identity: the original chart."""
    @property
    def transitions(self) -> list[int]:
        """Indices, in C order, at which the chart differs from the one before."""

@final
class CubicTrajectory:
    """Discrete trajectory of a Riemannian cubic; its arrays are read-only."""

    @property
    def t(self) -> _Array:
        """Times, shape (steps + 1,)."""
    @property
    def point(self) -> _Frames:
        """Points, shape (steps + 1, n, k)."""
    @property
    def velocity(self) -> _Frames:
        """Velocities, shape (steps + 1, n, k)."""
    @property
    def acceleration(self) -> _Frames:
        """Covariant accelerations, shape (steps + 1, n, k)."""
    @property
    def jerk(self) -> _Frames:
        """Covariant jerks, shape (steps + 1, n, k)."""
    @property
    def energy(self) -> _Array:
        """Hamiltonian ``|A|^2 / 2 - <J, V>`` in the canonical metric, shape (steps + 1,)."""
    @property
    def momentum_drift(self) -> float:
        """Largest deviation of the spatial momentum from its initial value, in the norm ``|A|^2 = tr(A^T A) / 2``."""
    @property
    def constraint_drift(self) -> float:
        """Largest violation of the constraints.

        For `integrate_cubic`, of ``mu_h = [x, p]_h`` in the norm of `momentum_drift`. For `integrate_embedded`, of
        ``S^T S = I`` and of the skew symmetry of ``S^T V``, ``S^T p_S`` and ``S^T p_V``, Frobenius norm.
        """
    def __copy__(self) -> CubicTrajectory: ...
    def __deepcopy__(self, _memo: object) -> CubicTrajectory: ...

def interpolated_rotations(
    t: ArrayLike,
    quaternions: ArrayLike,
    bc_type: _BcType = "natural",
    *,
    tol: float = 1e-12,
    max_iterations: int = 200,
    tension: float = 0.0,
    extrapolate: bool = True,
    num_threads: int | None = None,
) -> list[RotationCurve]:
    """Splines through the rotations of many members, as :class:`RotationCurve` makes one.

    Parameters
    ----------
    t : array_like, shape (N,) or (M, N)
        Times in seconds, shared by all curves or one row per curve.
    quaternions : array_like, shape (M, N, 4)
        Rotations as quaternions, scalar last, of any nonzero length.
    bc_type : str or pair, default "natural"
        End conditions of all curves, as for :class:`RotationCurve`.
    tol, max_iterations, tension, extrapolate, num_threads
        As for :class:`RotationCurve`.

    Returns
    -------
    list of RotationCurve

    Raises
    ------
    InvalidInputError, OutsideDomainError, ConvergenceError
        As for :class:`RotationCurve`, for the first curve that fails; the message names it.
    """

def rotations_with_rates(
    t: ArrayLike,
    quaternions: ArrayLike,
    rates: ArrayLike,
    *,
    named: bool,
    extrapolate: bool,
    num_threads: int | None,
) -> list[RotationCurve]:
    """Curves through rotations with given rates; once continuously differentiable.

    Parameters
    ----------
    t : array_like, shape (N,) or (M, N)
        Times in seconds, shared by all curves or one row per curve.
    quaternions : array_like, shape (M, N, 4)
        Rotations as quaternions, scalar last, of any nonzero length.
    rates : array_like, shape (M, N, 3)
        Rates in the body frame, in rad/s.
    named : bool
        Whether errors name the curve that fails.
    extrapolate, num_threads
        As for :class:`RotationCurve`.

    Returns
    -------
    list of RotationCurve
        With :class:`CubicHermite` as ``curve``.

    Raises
    ------
    InvalidInputError, OutsideDomainError, ConvergenceError
        As for :class:`RotationCurve`. For half turns whose direction the rates do not decide, ``OutsideDomainError``.
    """

def smoothed_rotations(
    t: ArrayLike,
    quaternions: ArrayLike,
    weights: ArrayLike | None,
    lam: float | None,
    *,
    named: bool,
    tol: float,
    max_iterations: int,
    extrapolate: bool,
    num_threads: int | None,
) -> list[RotationCurve]:
    """Smoothing splines near rotations.

    Parameters
    ----------
    t : array_like, shape (N,) or (M, N)
        Times in seconds, not decreasing, shared by all curves or one row per curve.
    quaternions : array_like, shape (M, N, 4)
        Rotations as quaternions, scalar last, of any nonzero length.
    weights : array_like, shape (N,), optional
        As for :class:`SmoothingSpline`; the same for all curves.
    lam, tol, max_iterations, extrapolate, num_threads
        As for :class:`SmoothingSpline`.
    named : bool
        Whether errors name the curve that fails.

    Returns
    -------
    list of RotationCurve
        With :class:`SmoothingSpline` as ``curve``.

    Raises
    ------
    InvalidInputError, OutsideDomainError, ConvergenceError
        As for :class:`SmoothingSpline`.
    """

def sampled_rotations(curves: Sequence[RotationCurve], t: ArrayLike, order: int) -> _Array:
    """Evaluate many curves at the same times or at times of their own.

    Parameters
    ----------
    curves : list of RotationCurve, length M
    t : array_like, shape (T,) or (M, T)
        Times in seconds; the end pieces are continued beyond the keyframes.
    order : {0, 1, 2, 3}
        0 for unit quaternions, scalar last; 1, 2 and 3 for body rates in rad/s^order.

    Returns
    -------
    ndarray, shape (M, T, 4) or (M, T, 3)
    """

def solve_boundary(
    S0: ArrayLike,
    V0: ArrayLike,
    S1: ArrayLike,
    V1: ArrayLike,
    *,
    tol: float = 1e-12,
    max_iterations: int = 50,
    num_threads: int | None = None,
    manifold: Stiefel | Grassmann | None = None,
    project: bool = False,
) -> BoundaryBatch:
    """Solve for Riemannian cubics on ``[0, 1]`` with given end points and end velocities, for a batch of problems.

    Each solution agrees with :meth:`RiemannianCubic.from_boundary` up to ``tol``. Problems with at most three rows, and
    with displacement and speeds at most 2, are solved in groups of eight; within ``tol`` their solutions depend on the
    problems beside them. The remaining problems, and those that this does not solve, are solved one by one. On a
    :class:`Grassmann` all are solved one by one, with the same result to the last bit as
    :meth:`RiemannianCubic.from_boundary`.

    Parameters
    ----------
    S0, V0 : array_like, shape (..., n, k)
        Initial points and velocities; leading axes broadcast.
    S1, V1 : array_like, shape (..., n, k)
        Final points and velocities.
    tol : float, default 1e-12
        Largest error of end point and end velocity, as in :meth:`RiemannianCubic.from_boundary`.
    max_iterations : int, default 50
        Largest number of Newton steps per problem, as in :meth:`RiemannianCubic.from_boundary`.
    num_threads : int, optional
        Number of threads; by default the size of the global pool. Results do not depend on it.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces; vectors and results are horizontal, ``Y^T V = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Returns
    -------
    BoundaryBatch
        Named tuple of ``acceleration`` and ``jerk``, covariant, at ``S0``, shape (..., n, k); ``cost``, the integral of
        the squared covariant acceleration, ``converged`` and ``residual``, shape (...). For a problem that is not
        solved, ``converged`` is False, ``residual`` is the smallest error at the end, and the other fields are NaN.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect and the
        member of the batch), ``tol`` not between 1e-15 and 0.1, ``max_iterations`` less than 1.
    OutsideDomainError
        Points in different components of O(n), or subspaces with a principal angle of pi/2 between them.

    See Also
    --------
    RiemannianCubic.from_initial : curve from ``S0, V0, acceleration, jerk``.
    stiefel_rs.dask.solve_boundary : batches larger than memory, with more fields.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import RiemannianCubic, solve_boundary
    >>> angle = np.linspace(0.1, 1.5, 1000)
    >>> S0, rest = np.eye(3)[:, :1], np.zeros((3, 1))
    >>> S1 = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)[..., None]
    >>> batch = solve_boundary(S0, rest, S1, rest)
    >>> batch.jerk.shape, bool(batch.converged.all())
    ((1000, 3, 1), True)
    >>> bool(np.allclose(batch.cost, 12 * angle**2))
    True
    >>> curve = RiemannianCubic.from_initial(S0, rest, batch.acceleration[7], batch.jerk[7])
    >>> bool(np.allclose(curve(1.0), S1[7]))
    True
    """

def estimate_velocities(
    t: ArrayLike,
    S: ArrayLike,
    method: _Velocities = "catmull-rom",
    *,
    closed: bool = False,
    num_threads: int | None = None,
    manifold: Stiefel | Grassmann | None = None,
    project: bool = False,
) -> _Frames:
    """Estimate the velocities of a smooth curve at its knots, from the points alone.

    Parameters
    ----------
    t : array_like, shape (N,)
        At least two increasing times.
    S : array_like, shape (N, n, k)
        Points with orthonormal columns.
    method : "catmull-rom", "akima" or "natural", default "catmull-rom"
        ``"catmull-rom"``, the parabola through three neighbours. ``"akima"``, a weighted mean of the slopes on both
        sides that does not overshoot next to jumps and rests (weights of SciPy's ``method="makima"``). ``"natural"``,
        the velocities of the natural cubic spline in tangent spaces.
    closed : bool, default False
        Whether the curve is closed: the last point and velocity equal the first.
    num_threads : int, optional
        Number of threads; by default the size of the global pool.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, and the last point of a closed curve is any basis of the first subspace.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Returns
    -------
    ndarray, shape (N, n, k)
        Tangent vectors at the points, per unit of ``t``. On a :class:`Grassmann` they are horizontal at the given
        bases: changing the basis of one point changes the matrix of its own velocity only.

    Raises
    ------
    InvalidInputError
        Mismatched shapes or numbers of knots, non-finite entries, times that do not increase, points not orthonormal
        (with the measured defect), closed data that do not close; carries ``knot``.
    OutsideDomainError
        No quasi-geodesic joins two consecutive points, or two consecutive subspaces have a principal angle of pi/2;
        carries ``knot``, the index of the first, and ``angle``.
    TypeError
        ``t`` is complex, or holds dates or durations.

    See Also
    --------
    CubicHermite : curve through points with velocities; also accepts the name of a method.

    Notes
    -----
    The formulas of flat space are applied in tangent spaces. Quasi-geodesics between neighbours, for subspaces
    geodesics, carry vectors from knot to knot. On the circle the result equals the formulas applied to the angle.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import estimate_velocities
    >>> t = np.array([0.0, 1.0, 3.0])
    >>> S = np.array([[[np.cos(a)], [np.sin(a)]] for a in t / 4])
    >>> V = estimate_velocities(t, S, "akima")
    >>> bool(np.allclose(V[0].ravel(), [0, 1 / 4]))
    True
    """

def integrate_cubic(
    S: ArrayLike,
    V: ArrayLike,
    A: ArrayLike,
    J: ArrayLike,
    steps: int,
    t_end: float = 1.0,
    order: int = 6,
    *,
    tension: float = 0.0,
    manifold: Stiefel | Grassmann | None = None,
    project: bool = False,
) -> CubicTrajectory:
    """Integrate a Riemannian cubic with given initial data, by equal steps of an explicit symplectic splitting.

    Works for any n and k, without charts and without solving equations: each step is a sequence of exact flows.
    Orthonormality, spatial momentum and the constraint are preserved to round-off; the energy does not drift.

    Parameters
    ----------
    S, V, A, J : array_like, shape (n, k)
        Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
    steps : int
        Number of equal steps over ``[0, t_end]``, at least 1.
    t_end : float, default 1.0
        End time, not zero; negative to integrate backwards.
    order : {2, 4, 6, 8}, default 6
        Order of the method, with 1, 4, 5 or 12 exponentials per step; with tension 1, 5, 9 or 17.
    tension : float, default 0.0
        As for :meth:`RiemannianCubic.from_initial`.
    manifold : Stiefel or Grassmann, optional
        Manifold of the points; by default Stiefel, real or complex like the arrays. On a :class:`Grassmann` the points
        are arbitrary bases of subspaces, vectors are horizontal, ``Y^T V = 0``, and the curve consists of bases that
        start at the first given one and turn as little as possible, ``Y^T Y' = 0``.
    project : bool, default False
        If True, points with a defect of at most 0.1 are replaced by the nearest points of the manifold, and vectors by
        their tangent parts. Otherwise the defect must be at most 1e-9, for arrays in single precision 1e-5; arrays in
        single precision are always projected.

    Returns
    -------
    CubicTrajectory

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal, vectors not tangent, ``steps < 1``, ``t_end`` zero,
        unknown order, ``tension`` out of range, an exponential that turns by more than 100 radians if ``n > 3``, a
        result that overflows.

    Notes
    -----
    The Hamiltonian ``H = <mu, x> + |p|^2 / 2 - tension |x|^2 / 2`` on the cotangent bundle of ``SO(n) x m`` (Crouch,
    Silva Leite 1995) is split into two terms. The compositions of order 4, 6 and 8 are designed for such splittings;
    the Rust documentation of ``SplittingOrder`` lists their error constants.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import integrate_cubic
    >>> S = np.array([[1.0], [0.0], [0.0]])
    >>> V, A, J = np.array([[0.0], [1.0], [0.0]]), np.array([[0.0], [0.0], [1.0]]), np.zeros((3, 1))
    >>> trajectory = integrate_cubic(S, V, A, J, 20, order=8)
    >>> trajectory.point.shape
    (21, 3, 1)
    >>> bool(np.ptp(trajectory.energy) < 1e-9)
    True
    """

def integrate_embedded(
    S: ArrayLike,
    V: ArrayLike,
    A: ArrayLike,
    J: ArrayLike,
    steps: int,
    t_end: float = 1.0,
    map: Literal["midpoint"] = "midpoint",
    *,
    project: bool = False,
) -> CubicTrajectory:
    """Integrate a Riemannian cubic by equal steps of a symplectic method in the embedding.

    The phase space is that of arXiv 2404.19407, ``T*(TSt(n, k))``, as a submanifold of four copies of the ``n x k``
    matrices; any n and k, without charts. The order is 2. ``S^T S = I``, ``S^T V + V^T S = 0``, the momentum
    constraints and the spatial momentum hold to round-off, and the energy does not drift. :func:`integrate_cubic` does
    not solve equations; it is faster and more accurate.

    Parameters
    ----------
    S, V, A, J : array_like, shape (n, k)
        Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
    steps : int
        Number of equal steps over ``[0, t_end]``, at least 1.
    t_end : float, default 1.0
        End time, not zero; negative to integrate backwards.
    map : {"midpoint"}, default "midpoint"
        Discretization map of the ambient space, ``R_d(q, v) = (q - v/2, q + v/2)``. Its cotangent lift preserves
        quadratic constraints.
    project : bool, default False
        As for :func:`integrate_cubic`.

    Returns
    -------
    CubicTrajectory

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, points not orthonormal, vectors not tangent, ``steps < 1``, ``t_end`` zero,
        unknown map, a result that overflows.
    ConvergenceError
        A step is too long for its implicit equations to be solved; carries ``report``.

    Notes
    -----
    ``H = <p_S S^T + p_V V^T, X> + |p_V S^T - S p_V^T|^2 / 4`` with ``X = V S^T - S V^T - S (S^T V - V^T S) S^T / 2``,
    Frobenius products. A step is the implicit midpoint rule of the ambient space; then multiples of the gradients of
    the constraints are added to make ``S^T p_S`` and ``S^T p_V`` skew. arXiv 2404.19407 names such a method as future
    work. Discretization maps: Barbero-Linan, Martin de Diego (2023); constraints: Jay (1996), Hairer, Lubich, Wanner
    (2006), section VII.1.4.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import integrate_embedded
    >>> S = np.array([[1.0], [0.0], [0.0]])
    >>> V, A, J = np.array([[0.0], [1.0], [0.0]]), np.array([[0.0], [0.0], [1.0]]), np.zeros((3, 1))
    >>> trajectory = integrate_embedded(S, V, A, J, 20)
    >>> trajectory.point.shape
    (21, 3, 1)
    >>> bool(trajectory.constraint_drift < 1e-14)
    True
    """

@final
class Chart:
    """Coordinate chart of arXiv 2404.19407: ``Chart.sphere()`` for St(3,1), ``Chart.frame()`` for St(3,2).

    Coordinates ``q`` have ``d`` entries: ``(theta, phi)`` or ``(theta, phi, psi)``, radians, ``0 < theta < pi``. A
    state is ``z = (q, qdot, p_q, p_qdot)``, shape ``(..., 4 d)``; leading axes are batches and broadcast.

    Notes
    -----
    See the sections of arXiv 2404.19407 on St(3,1) and St(3,2). The Hamiltonian of the frame chart is derived from the
    canonical metric; unlike the longer form in the paper it does not divide by ``cos(theta)``.

    Examples
    --------
    A curve of the paper on the sphere, and its end after 100 midpoint steps:

    >>> import numpy as np
    >>> from stiefel_rs import Chart
    >>> chart = Chart.sphere()
    >>> q, qdot, qddot, qdddot = [np.pi / 2, np.pi], [0.1, 0.2], [1.0, 0.5], [0.1, 0.2]
    >>> z0 = np.concatenate([q, qdot, *chart.momenta(q, qdot, qddot, qdddot)])
    >>> trajectory = chart.integrate(z0, 100, map="midpoint")
    >>> trajectory.shape
    (101, 8)
    >>> exact = chart.reference(z0, [1.0])
    >>> bool(abs(trajectory[-1] - exact[0]).max() < 1e-4)
    True
    """

    @staticmethod
    def sphere() -> Chart:
        """Return the chart of the sphere St(3,1): ``(theta, phi)``, metric ``diag(1, sin(theta)^2)``."""
    @staticmethod
    def frame() -> Chart:
        """Return the chart of the 2-frames St(3,2): ``(theta, phi, psi)``, with the canonical metric.

        The metric is ``dtheta^2 + dphi^2 + dpsi^2 + 2 cos(theta) dphi dpsi``.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def d(self) -> int:
        """Dimension of the chart, 2 or 3."""
    @property
    def k(self) -> int:
        """Number of columns of an embedded point, 1 or 2."""
    def embed(self, q: ArrayLike) -> _Array:
        """Return the points with coordinates ``q``: shape (..., d) -> (..., 3, k).

        Raises
        ------
        OutsideDomainError
            ``theta`` is not in ``(0, pi)``; carries ``angle``. The same holds for every method.
        """
    def embed_velocity(self, q: ArrayLike, qdot: ArrayLike) -> _Array:
        """Return the ambient velocities for coordinates ``q`` and rates ``qdot``: shape (..., d) -> (..., 3, k)."""
    def momenta(self, q: ArrayLike, qdot: ArrayLike, qddot: ArrayLike, qdddot: ArrayLike) -> tuple[_Array, _Array]:
        """Return the momenta ``(p_q, p_qdot)`` of a curve from its coordinate derivatives up to the third.

        All arrays have shape (..., d).

        Notes
        -----
        ``p_qdot = g (qddot + Gamma(qdot, qdot))`` and
        ``p_q[i] = 2 Gamma[k, i, j] qdot[j] p_qdot[k] - d/dt p_qdot[i]``.
        """
    def derivatives(self, z: ArrayLike) -> tuple[_Array, _Array, _Array, _Array]:
        """Return the coordinate derivatives ``(q, qdot, qddot, qdddot)`` of a state, each of shape (..., d)."""
    def hamiltonian(self, z: ArrayLike) -> _Array:
        """Evaluate the Hamiltonian, shape (..., 4 d) -> (...)."""
    def gradient(self, z: ArrayLike) -> _Array:
        """Evaluate the exact gradient of the Hamiltonian, shape (..., 4 d)."""
    def hessian(self, z: ArrayLike) -> _Array:
        """Evaluate the exact Hessian of the Hamiltonian, shape (..., 4 d, 4 d)."""
    def state(self, S: ArrayLike, V: ArrayLike, A: ArrayLike, J: ArrayLike) -> _Array:
        """Return the state of the cubic with the given point, velocity, covariant acceleration and covariant jerk.

        Parameters
        ----------
        S, V, A, J : array_like, shape (3, k)
            Point, velocity, covariant acceleration and covariant jerk.

        Returns
        -------
        ndarray, shape (4 d,)
            State ``(q, qdot, p_q, p_qdot)``, angles in ``[-pi, pi]``.

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect).
        OutsideDomainError
            The first column of ``S`` is a pole of the chart; :meth:`integrate_across` and :meth:`reference_across`
            accept it.

        Notes
        -----
        ``p_qdot[i] = <d_i S, A>`` and ``p_q[i] = Gamma[k, i, j] qdot[j] p_qdot[k] - <d_i S, J>``.
        """
    def covariant(self, z: ArrayLike) -> tuple[_Array, _Array, _Array, _Array]:
        """Return point, velocity, covariant acceleration and covariant jerk ``(S, V, A, J)`` of a state.

        The inverse of :meth:`state`. Shape (..., 4 d) -> four arrays of shape (..., 3, k).
        """
    def discretize(self, x: ArrayLike, v: ArrayLike, map: _Map = "initial_point") -> _Array:
        """Evaluate a discretization map of the tangent bundle: two points for each vector.

        Parameters
        ----------
        x, v : array_like, shape (..., 2 d)
            A position with its velocity, ``(q, qdot)``, and a vector ``(dq, dqdot)`` at it.
        map : str, default "initial_point"
            As for :meth:`integrate`.

        Returns
        -------
        ndarray, shape (..., 2, 2 d)
            ``R_d(x, v) = (x_0, x_1)``.
        """
    def integrate(
        self,
        z0: ArrayLike,
        steps: int,
        t_end: float = 1.0,
        map: _Map = "initial_point",
        *,
        order: _Order | None = None,
    ) -> _Array:
        """Integrate by the symplectic one-step method of a discretization map.

        ==========================  =========================================================================  =====
        map                         ``R_d(x, v)``, ``x = (q, qdot)``                                           order
        ==========================  =========================================================================  =====
        "initial_point"             ``(x, x + v)``                                                             1
        "midpoint"                  ``(x - v/2, x + v/2)``                                                     2
        "exponential"               ``(x, rho(x, v))``, ``rho`` the Riemannian exponential, lifted             1
        "exponential_midpoint"      ``(rho(x, -v/2), rho(x, v/2))``                                            2
        "cayley"                    as "exponential", with the Cayley retraction                               1
        "cayley_midpoint"           as "exponential_midpoint", with the Cayley retraction                      2
        "quasi_geodesic"            as "exponential", with quasi-geodesics; the same on the sphere             1
        "quasi_geodesic_midpoint"   as "exponential_midpoint", with quasi-geodesics; the same on the sphere    2
        ==========================  =========================================================================  =====

        The maps of a retraction (all but the first two) commute with rotations of space, so that all three components
        of the momentum are conserved.

        Parameters
        ----------
        z0 : array_like, shape (..., 4 d)
            Initial state.
        steps : int
            Number of equal steps over ``[0, t_end]``, at least 1.
        t_end : float, default 1.0
            End time.
        map : str, default "initial_point"
            A map from the table.
        order : int, optional
            Order of the method; by default the order of the map. Orders 2, 4, 6 and 8 compose each step of 1, 5, 9 and
            17 shorter ones; with a map of order 1 each shorter step is a half step of the adjoint method followed by a
            half step of the method.

        Returns
        -------
        ndarray, shape (..., steps + 1, 4 d)

        Raises
        ------
        InvalidInputError
            Non-finite entries, ``steps < 1``, unknown map or order.
        OutsideDomainError
            The trajectory leaves the chart; carries ``angle``.
        ConvergenceError
            A step is too long for its implicit equations to be solved; carries ``report``.

        Notes
        -----
        arXiv 2404.19407, by the cotangent lift of the discretization map (Barbero-Linan, Martin de Diego 2023).
        """
    def integrate_across(
        self,
        S: ArrayLike,
        V: ArrayLike,
        A: ArrayLike,
        J: ArrayLike,
        steps: int,
        t_end: float = 1.0,
        map: _Map = "midpoint",
        *,
        order: _Order | None = None,
    ) -> ChartTrajectory:
        """Integrate as :meth:`integrate` does, changing charts to avoid their poles.

        A state with ``sin(theta) < 1/2`` is moved to another chart before its next step, by a cyclic permutation of the
        axes, which is an isometry, and its cotangent lift; so the method remains symplectic.

        Parameters
        ----------
        S, V, A, J : array_like, shape (3, k)
            Point, which may be a pole, velocity, covariant acceleration and covariant jerk.
        steps : int
            Number of equal steps over ``[0, t_end]``, at least 1.
        t_end : float, default 1.0
            End time.
        map, order
            As for :meth:`integrate`. With a map of a retraction the trajectory does not depend on the charts; the maps
            "initial_point" and "midpoint", which are linear in coordinates, give a different method of the same order
            in each chart.

        Returns
        -------
        ChartTrajectory

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent; ``steps < 1``, unknown map or
            order.
        OutsideDomainError, ConvergenceError
            A step is too long for a chart, or for its implicit equations to be solved.

        Examples
        --------
        A geodesic over the pole, once around the sphere:

        >>> from stiefel_rs import Chart
        >>> S, V = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [2 * np.pi]])
        >>> path = Chart.sphere().integrate_across(S, V, 0 * S, 0 * S, 40, map="exponential_midpoint")
        >>> bool(abs(path.point[-1] - S).max() < 1e-13)
        True
        >>> len(path.transitions) > 0
        True
        """
    def reference(self, z0: ArrayLike, t: ArrayLike) -> _Array:
        """Evaluate the exact flow: states at the times ``t``, from ``z0`` at time 0.

        Parameters
        ----------
        z0 : array_like, shape (..., 4 d)
            State at time 0.
        t : array_like, shape T
            Finite times in any order.

        Returns
        -------
        ndarray, shape (...,) + T + (4 d,)
            States with an error of at most 1e-13, for curves of the size of those in the paper.

        Raises
        ------
        OutsideDomainError
            The curve leaves the chart; carries ``angle``.
        ConvergenceError
            Too many steps; carries ``report``.

        Notes
        -----
        Taylor method of order 26 with variable steps (Jorba, Zou 2005).
        """
    def reference_across(self, S: ArrayLike, V: ArrayLike, A: ArrayLike, J: ArrayLike, t: ArrayLike) -> ChartTrajectory:
        """Evaluate the exact flow as :meth:`reference` does, changing charts to avoid their poles.

        Parameters
        ----------
        S, V, A, J : array_like, shape (3, k)
            Point, velocity, covariant acceleration and covariant jerk at time 0.
        t : array_like, shape T
            Finite times in any order.

        Returns
        -------
        ChartTrajectory

        Raises
        ------
        InvalidInputError
            Wrong shape, non-finite entries, points not orthonormal, vectors not tangent.
        ConvergenceError
            Too many steps; carries ``report``.
        """
    def shoot(
        self,
        q0: ArrayLike,
        qdot0: ArrayLike,
        q1: ArrayLike,
        qdot1: ArrayLike,
        steps: int,
        map: _Map = "midpoint",
        *,
        t_end: float = 1.0,
        tol: float = 1e-12,
        max_iterations: int = 50,
        guess: tuple[ArrayLike, ArrayLike] | None = None,
        order: _Order | None = None,
    ) -> ShootingResult:
        """Find the discrete trajectory with given ends by shooting.

        Parameters
        ----------
        q0, qdot0, q1, qdot1 : array_like, shape (d,)
            Coordinates and velocities at time 0 and ``t_end``. Angles are not wrapped: pass the intended branch.
        steps : int
            Number of equal steps, at least 1.
        map : str, default "midpoint"
            As for :meth:`integrate`.
        t_end : float, default 1.0
            End time.
        tol : float, default 1e-12
            Largest Euclidean norm of the error at the end.
        max_iterations : int, default 50
            Largest number of Newton steps.
        guess : pair of array_like, each of shape (d,), optional
            Initial momenta ``(p_q, p_qdot)`` to start from.
        order : int, optional
            As for :meth:`integrate`.

        Returns
        -------
        ShootingResult

        Raises
        ------
        InvalidInputError
            Wrong shapes, non-finite entries, ``steps < 1``, unknown map or order, ``tol`` negative or not finite,
            ``t_end = 0``.
        OutsideDomainError
            An end, or the trajectory of the initial guess, is outside the chart; carries ``angle``.
        ConvergenceError
            No trajectory was found; carries ``report``. In general none exists for ``steps = 1``, because the end point
            of a single step does not depend on all of the momenta.

        Notes
        -----
        Damped Newton iteration on the initial momenta, with the exact derivative of the discrete flow as Jacobian.
        """
