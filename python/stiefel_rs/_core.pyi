from collections.abc import Iterable
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
    "log_pullback",
    "log_variation",
    "num_threads",
    "orthogonal_log",
    "orthogonal_log_pullback",
    "orthogonal_log_variation",
    "simd_features",
    "skew_exp",
    "skew_exp_pullback",
    "skew_exp_variation",
    "solve_boundary",
]

__VERSION__: Final[str]

def num_threads() -> int:
    """Number of threads of the global pool."""

def simd_features() -> list[str]:
    """The vector instruction sets that this processor offers and the kernels may use."""

@overload
def skew_exp(A: NDArray[np.complexfloating[Any, Any]], *, num_threads: int | None = None) -> _ComplexArray:
    """Exponential of a skew-symmetric or skew-Hermitian matrix: a rotation or a unitary matrix, to round-off.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Real and skew-symmetric, or complex and skew-Hermitian: ``|A + A^H| / 2 <= 1e-12 |A|``.
    num_threads : int, optional
        Threads for a batch; by default those of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``e^A``, with ``|Q^H Q - I|_2`` at most ``m * 1e-15``; complex128 where ``A`` is complex, else float64.

    Raises
    ------
    InvalidInputError
        Not square, not finite, not skew-symmetric or skew-Hermitian (with the measured defect).

    Notes
    -----
    Closed forms for ``m <= 3`` (complex: ``m <= 2``); even and odd polynomials in ``A^2`` with squaring for moderate norms,
    the real Schur form of Ward and Gray (1978) or the Hermitian eigenproblem for large ones.

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
    """Exponential of a skew-symmetric or skew-Hermitian matrix: a rotation or a unitary matrix, to round-off.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Real and skew-symmetric, or complex and skew-Hermitian: ``|A + A^H| / 2 <= 1e-12 |A|``.
    num_threads : int, optional
        Threads for a batch; by default those of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``e^A``, with ``|Q^H Q - I|_2`` at most ``m * 1e-15``; complex128 where ``A`` is complex, else float64.

    Raises
    ------
    InvalidInputError
        Not square, not finite, not skew-symmetric or skew-Hermitian (with the measured defect).

    Notes
    -----
    Closed forms for ``m <= 3`` (complex: ``m <= 2``); even and odd polynomials in ``A^2`` with squaring for moderate norms,
    the real Schur form of Ward and Gray (1978) or the Hermitian eigenproblem for large ones.

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
    """Principal skew logarithm of a rotation (real, all angles below pi) or of a unitary matrix (angles in (-pi, pi]).

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Real and orthogonal of determinant +1, or complex and unitary: ``|Q^H Q - I| <= 1e-9``.
    num_threads : int, optional
        Threads for a batch; by default those of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``L = -L^H`` with ``e^L = Q``, complex128 where ``Q`` is complex, else float64. Backward error at most 1e-13 for ``m``
        up to 50, repeated and clustered angles and angles of ``pi - 1e-10`` included.

    Raises
    ------
    InvalidInputError
        Not square, not finite, not orthogonal or unitary (with the measured defect).
    OutsideDomainError
        Only for real ``Q``: determinant -1, or an angle that is pi to working precision; carries ``angle``. No real
        logarithm is principal there; ``orthogonal_log(Q.astype(complex))`` returns the complex one.

    Notes
    -----
    Real: closed forms for ``m <= 3``; above, the skew Schur form of ``(Q - Q^T) / 2``, or the symmetric eigenproblem of
    ``(Q + Q^T) / 2`` and the skew Schur form inside of each group of equal cosines, and one Newton correction.

    Complex: closed forms for ``m <= 2``; above, the eigenproblem of one Hermitian combination of ``Q`` and ``Q^H``, that
    of another one inside of each group of equal eigenvalues, and one Newton correction. On the eigenspace of -1 the
    logarithm is ``i pi``. To working precision the angles pi and -pi are the same: those closer to -pi than ``4 m eps`` are
    returned as pi.

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
    """Principal skew logarithm of a rotation (real, all angles below pi) or of a unitary matrix (angles in (-pi, pi]).

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Real and orthogonal of determinant +1, or complex and unitary: ``|Q^H Q - I| <= 1e-9``.
    num_threads : int, optional
        Threads for a batch; by default those of the global pool.

    Returns
    -------
    ndarray, shape (..., m, m)
        ``L = -L^H`` with ``e^L = Q``, complex128 where ``Q`` is complex, else float64. Backward error at most 1e-13 for ``m``
        up to 50, repeated and clustered angles and angles of ``pi - 1e-10`` included.

    Raises
    ------
    InvalidInputError
        Not square, not finite, not orthogonal or unitary (with the measured defect).
    OutsideDomainError
        Only for real ``Q``: determinant -1, or an angle that is pi to working precision; carries ``angle``. No real
        logarithm is principal there; ``orthogonal_log(Q.astype(complex))`` returns the complex one.

    Notes
    -----
    Real: closed forms for ``m <= 3``; above, the skew Schur form of ``(Q - Q^T) / 2``, or the symmetric eigenproblem of
    ``(Q + Q^T) / 2`` and the skew Schur form inside of each group of equal cosines, and one Newton correction.

    Complex: closed forms for ``m <= 2``; above, the eigenproblem of one Hermitian combination of ``Q`` and ``Q^H``, that
    of another one inside of each group of equal eigenvalues, and one Newton correction. On the eigenspace of -1 the
    logarithm is ``i pi``. To working precision the angles pi and -pi are the same: those closer to -pi than ``4 m eps`` are
    returned as pi.

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
    """Derivative of the exponential of a skew-symmetric matrix in a direction.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Skew-symmetric or skew-Hermitian, as for :func:`skew_exp`.
    dA : array_like, shape (..., m, m)
        Direction, of which the skew-symmetric or skew-Hermitian part counts.

    Returns
    -------
    ndarray, shape (..., m, m)
        Derivative of ``skew_exp(A + h * dA)`` by ``h`` at 0, to about ``m * 1e-15``.

    Raises
    ------
    InvalidInputError
        As :func:`skew_exp`; shape.
    """

def skew_exp_pullback(A: ArrayLike, W: ArrayLike) -> _Frames:
    """Gradient of ``sum(W * skew_exp(A))``: the transpose of :func:`skew_exp_variation`.

    Parameters
    ----------
    A : array_like, shape (..., m, m)
        Skew-symmetric or skew-Hermitian, as for :func:`skew_exp`.
    W : array_like, shape (..., m, m)
        Derivatives of a function by the entries of the exponential.

    Returns
    -------
    ndarray, shape (..., m, m)
        The skew-symmetric ``G`` with ``sum(G * dA) == sum(W * skew_exp_variation(A, dA))``, of complex matrices the
        real parts with conjugate ``G`` and ``W``.

    Raises
    ------
    InvalidInputError
        As :func:`skew_exp`; shape.
    """

def orthogonal_log_variation(Q: ArrayLike, dQ: ArrayLike) -> _Frames:
    """Derivative of the principal logarithm of a rotation in a direction.

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Rotation or unitary matrix, as for :func:`orthogonal_log`; no angle of a unitary one is pi.
    dQ : array_like, shape (..., m, m)
        Direction, of which the part tangent at Q counts.

    Returns
    -------
    ndarray, shape (..., m, m)
        The derivative, skew-symmetric.

    Raises
    ------
    InvalidInputError, OutsideDomainError
        As :func:`orthogonal_log`; shape.
    """

def orthogonal_log_pullback(Q: ArrayLike, W: ArrayLike) -> _Frames:
    """Gradient of ``sum(W * orthogonal_log(Q))``: the transpose of :func:`orthogonal_log_variation`.

    Parameters
    ----------
    Q : array_like, shape (..., m, m)
        Rotation or unitary matrix, as for :func:`orthogonal_log`; no angle of a unitary one is pi.
    W : array_like, shape (..., m, m)
        Derivatives of a function by the entries of the logarithm.

    Returns
    -------
    ndarray, shape (..., m, m)
        The ``G`` tangent at Q with ``sum(G * dQ) == sum(W * orthogonal_log_variation(Q, dQ))`` for ``dQ`` tangent at Q.

    Raises
    ------
    InvalidInputError, OutsideDomainError
        As :func:`orthogonal_log`; shape.
    """

def exp_variation(S: ArrayLike, V: ArrayLike, dS: ArrayLike, dV: ArrayLike) -> _Frames:
    """Derivative of ``Stiefel.exp`` (canonical metric) at ``S``, ``V``, by changes of both that keep them point and tangent vector.

    Parameters
    ----------
    S, V, dS, dV : array_like, shape (n, k)
        Real or complex.

    Returns
    -------
    ndarray, shape (n, k)

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal, not tangent.
    """

def exp_pullback(S: ArrayLike, V: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames]:
    """Gradients of ``sum(W * exp(S, V))`` by ``S`` and ``V``: the transpose of :func:`exp_variation`.

    Parameters
    ----------
    S, V, W : array_like, shape (n, k)
        Real or complex; of complex matrices the real part of the product with the conjugate of ``W``.

    Returns
    -------
    tuple of ndarray, each of shape (n, k)

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal, not tangent.
    """

def log_variation(S0: ArrayLike, S1: ArrayLike, dS0: ArrayLike, dS1: ArrayLike) -> _Frames:
    """Derivative of ``Stiefel.log`` (canonical metric) at ``S0``, ``S1``, by changes of both that keep them points.

    Parameters
    ----------
    S0, S1, dS0, dS1 : array_like, shape (n, k)
        Real or complex.

    Returns
    -------
    ndarray, shape (n, k)

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal.
    OutsideDomainError, ConvergenceError
        As :meth:`Stiefel.log`; ends that are conjugate along the geodesic.
    """

def log_pullback(S0: ArrayLike, S1: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames]:
    """Gradients of ``sum(W * log(S0, S1))`` by ``S0`` and ``S1``: the transpose of :func:`log_variation`.

    Parameters
    ----------
    S0, S1, W : array_like, shape (n, k)
        Real or complex; of complex matrices the real part of the product with the conjugate of ``W``.

    Returns
    -------
    tuple of ndarray, each of shape (n, k)

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal.
    OutsideDomainError, ConvergenceError
        As :func:`log_variation`.
    """

def _as_numpy(name: str, object: object) -> Any: ...
def _check_unmasked(name: str, object: object) -> None: ...
def _in_library_of(argument: object, value: Any) -> Any: ...
def _restored(form: dict[str, Any]) -> Curve: ...

@final
class SolverReport:
    """How an iteration ended."""

    def __new__(
        cls, converged: bool, iterations: int, residual: float, tolerance: float, reason: str
    ) -> SolverReport: ...
    @property
    def converged(self) -> bool:
        """Whether ``residual <= tolerance``."""
    @property
    def iterations(self) -> int:
        """Newton steps taken."""
    @property
    def residual(self) -> float:
        """Euclidean norm of the residual at the returned iterate."""
    @property
    def tolerance(self) -> float:
        """The tolerance that was asked for."""
    @property
    def reason(self) -> str:
        """``"converged"``, ``"max_iterations"``, ``"stagnated"``, ``"diverged"``, ``"singular_jacobian"``, ``"not_minimal"`` or
        ``"work_limit"``.
        """

@final
class LogReport:
    """How a Riemannian logarithm was found, and what is known of it.

    The fields are numbers for a single pair of points, arrays of the batch's shape for a batch.
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
        """Whether the residual is at the level of round-off. A logarithm that is returned always has converged."""
    @property
    def iterations(self) -> int | NDArray[np.int64]:
        """Newton steps that led to it: the first attempt from a close start, and those from the start that found it."""
    @property
    def residual(self) -> float | _Array:
        """``|exp(S0, V) - S1|``, Frobenius norm."""
    @property
    def length(self) -> float | _Array:
        """Length of the geodesic in the manifold's metric."""
    @property
    def certainly_shortest(self) -> bool | NDArray[np.bool_]:
        """Whether the geodesic is certainly the shortest: it is shorter than the known bound of the injectivity radius
        (canonical ``sqrt(4/5) pi``, Euclidean ``pi``; of the metrics between none is known), or the case is closed (``k =
        1``, ``k = n``, canonical also ``k = n - 1``). Otherwise it may be or not.
        """

@final
class Stiefel:
    """The Stiefel manifold St(n, k) of n x k matrices with orthonormal columns, real or complex.

    Points and tangent vectors are arrays of shape ``(..., n, k)``; leading axes are batches and broadcast.

    Parameters
    ----------
    n, k : int
        ``1 <= k <= n``.
    metric : "canonical", "euclidean" or float, default "canonical"
        A float is the parameter ``alpha > -1`` of the family of Hueper, Markina, Silva Leite (2021), in which
        ``|V|^2 = |K|^2 + |Omega|^2 / (2 (alpha + 1))`` for ``V = S Omega + K``: canonical 0, Euclidean -1/2.
    field : "real" or "complex", default "real"
        With ``"complex"``, complex frames, ``S^H S = I``: the unitary group for ``k = n``. Arrays of complex numbers are taken and
        returned; in all formulas the transpose is the conjugate transpose, and inner products are real parts.

    Raises
    ------
    InvalidInputError
        Unless ``1 <= k <= n`` and the metric is one of these. Methods raise it for arrays of another shape, numbers that are
        not finite, points that are not orthonormal and vectors that are not tangent, with the measured defect and the
        member of the batch.

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
        """Rows of a point."""
    @property
    def k(self) -> int:
        """Columns of a point."""
    @property
    def field(self) -> str:
        """ "real" or "complex": what numbers points consist of."""
    @property
    def alpha(self) -> float:
        """Parameter of the metric: 0 for the canonical, -1/2 for the Euclidean one."""
    @property
    def dim(self) -> int:
        """Real dimension of the manifold, ``n k - k (k + 1) / 2``; of complex frames ``2 n k - k^2``."""
    def check_point(self, S: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``S`` is a point: ``|S^T S - I| <= atol`` (Frobenius), by default 1e-9, for arrays in
        single precision 1e-5.

        Raises
        ------
        InvalidInputError
            With the measured defect.
        """
    def check_tangent(self, S: ArrayLike, V: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``V`` is tangent at ``S``: ``|S^T V + V^T S| / 2 <= atol max(1, |V|)``, by default 1e-9, in
        single precision 1e-5.

        Raises
        ------
        InvalidInputError
            With the measured defect.
        """
    def is_point(self, S: ArrayLike, atol: float | None = None) -> Any:
        """Whether ``S`` is a point, as :meth:`check_point` measures it; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for numbers that are not finite.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 2)
        >>> bool(M.is_point(np.eye(3, 2))), bool(M.is_point(np.ones((3, 2))))
        (True, False)
        """
    def is_tangent(self, S: ArrayLike, V: ArrayLike, atol: float | None = None) -> Any:
        """Whether ``V`` is tangent at ``S``, as :meth:`check_tangent` measures it; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for numbers that are not finite, and where ``S`` is no point.
        """
    def random_point(
        self, rng: np.random.Generator | int | None = None, size: int | tuple[int, ...] | None = None
    ) -> _Frames:
        """Uniformly distributed points (Haar measure), shape ``size + (n, k)``.

        Parameters
        ----------
        rng : numpy.random.Generator or seed, optional
            What `numpy.random.default_rng` takes.
        size : int or tuple of int, optional
            Leading axes; a single point by default.
        """
    def random_tangent(self, S: ArrayLike, rng: np.random.Generator | int | None = None) -> _Frames:
        """Normally distributed tangent vectors at ``S``: standard normal matrices, projected. Shape of ``S``.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        rng : numpy.random.Generator or seed, optional
            What `numpy.random.default_rng` takes. The vectors are independent of ``S``, also where ``S`` is made with the same
            seed, or by a generator in the same state.
        """
    def project(self, Y: ArrayLike) -> _Frames:
        """Nearest point in the Frobenius norm: the polar factor of ``Y``, shape (..., n, k).

        Raises
        ------
        InvalidInputError
            ``Y`` has no full column rank (with its smallest singular value), or is not finite.
        """
    def project_tangent(self, S: ArrayLike, Z: ArrayLike) -> _Frames:
        """Orthogonal projection ``Z - S sym(S^T Z)`` on the tangent space at ``S``, shape (..., n, k)."""
    def inner(self, S: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Array:
        """Inner product of tangent vectors at ``S`` in the manifold's metric, shape (...); canonical:
        ``tr V^T (I - S S^T / 2) W``.
        """
    def norm(self, S: ArrayLike, V: ArrayLike) -> _Array:
        """Norm of a tangent vector at ``S`` in the manifold's metric, shape (...)."""
    def decompose(self, S: ArrayLike, V: ArrayLike) -> tuple[_Frames, _Frames]:
        """The paper's pair ``(X, Omega)`` of a tangent vector, ``V = X S + S Omega``.

        Returns
        -------
        X : ndarray, shape (..., n, n)
            ``V S^T - S V^T + 2 S V^T S S^T``, skew-symmetric.
        Omega : ndarray, shape (..., k, k)
            ``S^T V``, skew-symmetric.
        """
    def compose(self, S: ArrayLike, X: ArrayLike, Omega: ArrayLike) -> _Frames:
        """The tangent vector ``V = X S + S Omega`` of the paper's pair, shape (..., n, k)."""
    def exp(self, S: ArrayLike, V: ArrayLike) -> _Frames:
        """The Riemannian exponential of tangent vectors ``V`` at ``S``, shape (..., n, k).

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), or too long for a number.
        """
    @overload
    def log(self, S0: ArrayLike, S1: ArrayLike, *, full_output: Literal[False] = False) -> _Frames:
        """The Riemannian logarithm: tangent vectors at ``S0`` with ``exp(S0, V) = S1``, shape (..., n, k).

        Parameters
        ----------
        S0, S1 : array_like, shape (..., n, k)
            Points.
        full_output : bool, default False
            Also return a report.

        Returns
        -------
        V : ndarray, shape (..., n, k)
        report : LogReport
            Only with ``full_output``: iterations, residual, length, and whether the geodesic is certainly the shortest.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal (with the measured defect).
        OutsideDomainError
            Antipodal points, a relative rotation by pi, different components of O(n); carries ``angle``.
        ConvergenceError
            No geodesic was found, far beyond the injectivity radius; carries ``report``.

        Notes
        -----
        Newton's method on the exponential with the exact inverse derivative; far points by Newton's method for the
        shortest rotation over the fibre (see Zimmermann, Hueper 2022 for the formulation). Below ``0.89 pi`` the answer
        is the shortest geodesic (canonical metric).

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
        """The Riemannian logarithm: tangent vectors at ``S0`` with ``exp(S0, V) = S1``, shape (..., n, k).

        Parameters
        ----------
        S0, S1 : array_like, shape (..., n, k)
            Points.
        full_output : bool, default False
            Also return a report.

        Returns
        -------
        V : ndarray, shape (..., n, k)
        report : LogReport
            Only with ``full_output``: iterations, residual, length, and whether the geodesic is certainly the shortest.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal (with the measured defect).
        OutsideDomainError
            Antipodal points, a relative rotation by pi, different components of O(n); carries ``angle``.
        ConvergenceError
            No geodesic was found, far beyond the injectivity radius; carries ``report``.

        Notes
        -----
        Newton's method on the exponential with the exact inverse derivative; far points by Newton's method for the
        shortest rotation over the fibre (see Zimmermann, Hueper 2022 for the formulation). Below ``0.89 pi`` the answer
        is the shortest geodesic (canonical metric).

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
        """The Riemannian distance of points, shape (...): the length of the geodesic of :meth:`log`.

        Raises
        ------
        InvalidInputError, OutsideDomainError, ConvergenceError
            As :meth:`log`.
        """
    def retract(self, S: ArrayLike, V: ArrayLike, kind: _Retraction = "quasi_geodesic") -> _Frames:
        """The point that a retraction maps a tangent vector at ``S`` to, shape (..., n, k).

        The order is that of ``|retract(S, t V) - exp(S, t V)| = O(t^p)``, canonical metric / Euclidean metric:

        ==================  ===================================================  =======
        kind                formula                                              order
        ==================  ===================================================  =======
        "quasi_geodesic"    ``e^X S e^Omega``, ``X = K S^T - S K^T``             2 / 2
        "qr"                orthonormal factor of ``S + V``, positive diagonal   2 / 2
        "polar"             ``(S + V) (I + V^T V)^(-1/2)``                       2 / 3
        "cayley"            ``(I - W/2)^-1 (I + W/2) S``, ``W S = V``            3 / 2
        ==================  ===================================================  =======

        On the sphere (k = 1) and on the rotations (k = n) quasi-geodesics are the geodesics, and all others but "qr" on the
        rotations are of order 3.

        Parameters
        ----------
        S, V : array_like, shape (..., n, k)
            Points and tangent vectors.
        kind : str, default "quasi_geodesic"
            One of the table.

        Returns
        -------
        ndarray, shape (..., n, k)

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), an unknown kind, or a vector so long
            that ``S + V`` has lost ``S``.

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
        """The tangent vector at ``S0`` that a retraction maps to ``S1``, shape (..., n, k).

        With ``M = S0^T S1``, "qr" has an inverse where the leading principal minors of ``M`` are positive, "polar" where its
        eigenvalues have positive real parts, "cayley" where -1 is none of them; it is unique, and it is checked before it is
        returned. "quasi_geodesic" has its principal branch at almost all pairs.

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
            No unique tangent vector leads there, with the measured number; "quasi_geodesic" carries an ``angle``.

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
        """Parallel transport of ``W`` along the geodesic ``t -> exp(S, t V)`` from ``S`` to ``exp(S, V)``, shape (..., n, k).

        The Levi-Civita transport of the manifold's metric, whichever that is. It keeps lengths and angles to round-off.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        V, W : array_like, shape (..., n, k)
            Tangent vectors at ``S``: the initial velocity of the geodesic, and what is transported.

        Returns
        -------
        ndarray, shape (..., n, k)
            Tangent vectors at ``exp(S, V)``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), or ``V`` longer than about 1e5.

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
        """The curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``S``, shape (..., n, k).

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
            Shape, not finite, not orthonormal, not tangent (with the measured defect), or a result too large for a number.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, U, V = np.eye(3)[:, :, None]
        >>> M.curvature(S, U, V, 2 * V).ravel()
        array([0., 2., 0.])
        """
    def sectional_curvature(self, S: ArrayLike, U: ArrayLike, V: ArrayLike) -> _Array:
        """The sectional curvature of the planes of ``U`` and ``V`` at ``S``, shape (...).

        1 on the sphere (k = 1), between 0 and 5/4 for the canonical metric of real frames.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        U, V : array_like, shape (..., n, k)
            Tangent vectors at ``S``, not parallel.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InvalidInputError
            ``U`` and ``V`` are linearly dependent (with the area that unit vectors along them span); shape, not finite, not
            orthonormal, not tangent.

        Examples
        --------
        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, U, V = np.eye(3)[:, :, None]
        >>> float(M.sectional_curvature(S, U, V))
        1.0
        """
    def euclidean_to_riemannian_gradient(self, S: ArrayLike, G: ArrayLike) -> _Frames:
        """The Riemannian gradient of a function with the Euclidean gradient ``G`` at ``S``, shape (..., n, k).

        It is the tangent vector with ``inner(S, gradient, V) = sum(G * V)`` for every tangent ``V``: ``G - S G^T S`` for the
        canonical metric, ``project_tangent(S, G)`` for the Euclidean one. For complex frames ``G`` is the matrix with
        ``df = Re sum(conj(G) * V)``: derivatives by the real parts, plus i times those by the imaginary parts.

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        G : array_like, shape (..., n, k)
            Partial derivatives with respect to the entries; any matrix.

        Returns
        -------
        ndarray, shape (..., n, k)

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal (with the measured defect).

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
        """The Riemannian Hessian applied to the tangent vector ``V`` at ``S``, shape (..., n, k).

        Parameters
        ----------
        S : array_like, shape (..., n, k)
            Points.
        G, H : array_like, shape (..., n, k)
            The Euclidean gradient, and the Euclidean Hessian applied to ``V``; any matrices.
        V : array_like, shape (..., n, k)
            Tangent vectors at ``S``.

        Returns
        -------
        ndarray, shape (..., n, k)
            The covariant derivative of the gradient along ``V``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect).

        Examples
        --------
        The Hessian of ``sum(A * S)``, linear in ``S``, comes from the curvature of the embedding alone:

        >>> from stiefel_rs import Stiefel
        >>> M = Stiefel(3, 1)
        >>> S, V, A = np.eye(3)[:, :, None]
        >>> M.euclidean_to_riemannian_hessian(S, 2 * S, 0 * V, V).ravel()
        array([ 0., -2.,  0.])
        """

@final
class Grassmann:
    """The Grassmann manifold Gr(n, k) of k-dimensional subspaces of R^n, or of C^n.

    A point is an orthonormal basis ``Y`` of a subspace, an array of shape ``(..., n, k)``; all bases of a subspace are the same
    point. Tangent vectors at ``Y`` are matrices ``V`` of that shape with ``Y^T V = 0``; their length is ``|V|`` (Frobenius). Results
    belong to the given basis: a tangent vector ``V`` at ``Y`` is ``V Q`` at ``Y Q``. Leading axes are batches and broadcast.

    Parameters
    ----------
    n, k : int
        ``1 <= k <= n``.
    field : "real" or "complex", default "real"
        With ``"complex"``, subspaces of C^n. Arrays of complex numbers are taken and returned; in all formulas the transpose is
        the conjugate transpose, and inner products are real parts. Lines, ``k = 1``, are the states of quantum mechanics:
        ``Grassmann(2, 1, field="complex")`` is the sphere of radius 1/2.

    Raises
    ------
    InvalidInputError
        Unless ``1 <= k <= n``. Methods raise it for arrays of another shape, numbers that are not finite, points that are not
        orthonormal and vectors that are not horizontal, with the measured defect and the member of the batch.

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

    def __new__(cls, n: int, k: int, *, field: Literal["real", "complex"] = "real") -> Grassmann: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def n(self) -> int:
        """Rows of a basis."""
    @property
    def k(self) -> int:
        """Dimension of the subspaces, columns of a basis."""
    @property
    def dim(self) -> int:
        """Dimension of the manifold, ``k (n - k)``, twice that for a complex one."""
    @property
    def field(self) -> str:
        """ "real" or "complex"."""
    def check_point(self, Y: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``Y`` is a point: ``|Y^T Y - I| <= atol`` (Frobenius), by default 1e-9, for arrays in
        single precision 1e-5.

        Raises
        ------
        InvalidInputError
            With the measured defect.
        """
    def check_tangent(self, Y: ArrayLike, V: ArrayLike, atol: float | None = None) -> None:
        """Raise unless every member of ``V`` is horizontal at ``Y``: ``|Y^T V| <= atol max(1, |V|)``, by default 1e-9, in
        single precision 1e-5.

        Raises
        ------
        InvalidInputError
            With the measured defect.
        """
    def is_point(self, Y: ArrayLike, atol: float | None = None) -> Any:
        """Whether ``Y`` is an orthonormal basis, as :meth:`check_point` measures it; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for numbers that are not finite.
        """
    def is_tangent(self, Y: ArrayLike, V: ArrayLike, atol: float | None = None) -> Any:
        """Whether ``V`` is horizontal at ``Y``, as :meth:`check_tangent` measures it; shape (...).

        Returns
        -------
        bool, or ndarray of bool
            False for numbers that are not finite, and where ``Y`` is no orthonormal basis.
        """
    def random_point(
        self, rng: np.random.Generator | int | None = None, size: int | tuple[int, ...] | None = None
    ) -> _Frames:
        """Bases of uniformly distributed subspaces (Haar measure), shape ``size + (n, k)``.

        Parameters
        ----------
        rng : numpy.random.Generator or seed, optional
            What `numpy.random.default_rng` takes.
        size : int or tuple of int, optional
            Leading axes; a single point by default.
        """
    def random_tangent(self, Y: ArrayLike, rng: np.random.Generator | int | None = None) -> _Frames:
        """Normally distributed tangent vectors at ``Y``: standard normal matrices, projected. Shape of ``Y``.

        Parameters
        ----------
        Y : array_like, shape (..., n, k)
            Points.
        rng : numpy.random.Generator or seed, optional
            What `numpy.random.default_rng` takes. The vectors are independent of ``Y``, also where ``Y`` is made with the same
            seed, or by a generator in the same state.
        """
    def project(self, Y: ArrayLike) -> _Frames:
        """Orthonormal basis of the column space of ``Y`` nearest to ``Y``: its polar factor, shape (..., n, k).

        Raises
        ------
        InvalidInputError
            ``Y`` has no full column rank (with its smallest singular value), or is not finite.
        """
    def project_tangent(self, Y: ArrayLike, Z: ArrayLike) -> _Frames:
        """Orthogonal projection ``Z - Y Y^T Z`` on the tangent space at ``Y``, shape (..., n, k)."""
    def inner(self, Y: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Array:
        """Inner product of tangent vectors at ``Y``, ``tr V^T W``, of complex ones its real part, shape (...)."""
    def norm(self, Y: ArrayLike, V: ArrayLike) -> _Array:
        """Norm of a tangent vector at ``Y``, ``|V|`` (Frobenius), shape (...)."""
    def principal_angles(self, Y0: ArrayLike, Y1: ArrayLike) -> _Array:
        """Principal angles between subspaces, shape (..., k), in ``[0, pi / 2]``, decreasing as those of
        `scipy.linalg.subspace_angles`.

        Small angles are as accurate as large ones: from sines and cosines (Knyazev, Argentati 2002). At least ``2 k - n`` of them
        are exactly zero.

        Examples
        --------
        Two planes of R^3 that meet in the first axis:

        >>> from stiefel_rs import Grassmann
        >>> Y1 = [[1.0, 0.0], [0.0, np.cos(1e-20)], [0.0, np.sin(1e-20)]]
        >>> Grassmann(3, 2).principal_angles(np.eye(3, 2), Y1).tolist()
        [1e-20, 0.0]
        """
    def align(self, Y0: ArrayLike, Y1: ArrayLike) -> _Frames:
        """The basis of the subspace of ``Y1`` that is nearest to ``Y0`` (Frobenius), shape (..., n, k).

        ``Y1 Q`` with the orthogonal polar factor ``Q`` of ``Y1^T Y0``; also ``exp(Y0, log(Y0, Y1))``.

        Raises
        ------
        OutsideDomainError
            A principal angle is ``pi / 2`` to working precision, and the nearest basis is not unique; carries ``angle``.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(5, 2)
        >>> Y = M.random_point(rng=0)
        >>> bool(abs(M.align(Y, Y @ [[0, 1], [-1, 0]]) - Y).max() < 1e-15)
        True
        """
    def projector(self, Y: ArrayLike) -> _Frames:
        """Orthogonal projectors ``Y Y^T`` on the subspaces, shape (..., n, n): the same for all bases of a subspace."""
    def exp(self, Y: ArrayLike, V: ArrayLike) -> _Frames:
        """The Riemannian exponential of tangent vectors ``V`` at ``Y``, shape (..., n, k).

        Returns
        -------
        ndarray, shape (..., n, k)
            ``(Y W cos(S) + Q sin(S)) W^T`` for ``V = Q S W^T``: of all bases of the subspace the one that is reached without turning
            within it.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not horizontal (with the measured defect), or too long for a number.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> M.exp([[1], [0], [0]], [[0], [np.pi / 3], [0]]).round(6).ravel().tolist()
        [0.5, 0.866025, 0.0]
        """
    def log(self, Y0: ArrayLike, Y1: ArrayLike) -> _Frames:
        """The Riemannian logarithm: tangent vectors ``V`` at ``Y0`` for which ``exp(Y0, V)`` spans the subspace of ``Y1``,
        shape (..., n, k).

        In closed form. Independent of the basis ``Y1``. ``exp(Y0, log(Y0, Y1))`` is ``align(Y0, Y1)``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal (with the measured defect).
        OutsideDomainError
            The largest principal angle is ``pi / 2`` to working precision, and several shortest geodesics lead there; carries
            ``angle``.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> M.log([[1], [0], [0]], [[-0.6], [0.8], [0]]).round(6).ravel().tolist()
        [0.0, -0.927295, 0.0]
        """
    def dist(self, Y0: ArrayLike, Y1: ArrayLike) -> _Array:
        """The Riemannian distance of subspaces, ``sqrt(sum(principal_angles ** 2))``, shape (...).

        Defined also where an angle is ``pi / 2`` and :meth:`log` is not. For different bases of one subspace it is round-off, not 0.
        """
    def transport(self, Y: ArrayLike, V: ArrayLike, W: ArrayLike) -> _Frames:
        """Parallel transport of ``W`` along the geodesic ``t -> exp(Y, t V)`` to the basis ``exp(Y, V)``, shape (..., n, k).

        It keeps lengths and angles to round-off.

        Parameters
        ----------
        Y : array_like, shape (..., n, k)
            Points.
        V, W : array_like, shape (..., n, k)
            Tangent vectors at ``Y``: the initial velocity of the geodesic, and what is transported.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not horizontal (with the measured defect).

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
        """The curvature tensor ``R(U, V) W = D_U D_V W - D_V D_U W - D_[U,V] W`` at ``Y``, shape (..., n, k).

        ``U V^T W - V U^T W + W (V^T U - U^T V)``; for lines (k = 1) that is ``<V, W> U - <U, W> V``, with the sign of
        :meth:`Stiefel.curvature`.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not horizontal (with the measured defect), or a result too large for a number.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(3, 1)
        >>> Y, U, V = np.eye(3)[:, :, None]
        >>> M.curvature(Y, U, V, 2 * V).ravel()
        array([0., 2., 0.])
        """
    def sectional_curvature(self, Y: ArrayLike, U: ArrayLike, V: ArrayLike) -> _Array:
        """The sectional curvature of the planes of ``U`` and ``V`` at ``Y``, shape (...): between 0 and 2, and 1 where ``k`` or
        ``n - k`` is 1.

        Raises
        ------
        InvalidInputError
            ``U`` and ``V`` are linearly dependent (with the area that unit vectors along them span); shape, not finite, not
            orthonormal, not horizontal.

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M = Grassmann(4, 2)
        >>> Y, U = np.eye(4, 2), np.eye(4, 2, -2)
        >>> float(M.sectional_curvature(Y, U, U[:, ::-1] * [1, -1]).round(14))
        2.0
        """
    def euclidean_to_riemannian_gradient(self, Y: ArrayLike, G: ArrayLike) -> _Frames:
        """The Riemannian gradient ``G - Y Y^T G`` of a function with the Euclidean gradient ``G`` at ``Y``, shape (..., n, k).

        The function has to depend on the subspace alone, ``f(Y Q) = f(Y)`` for orthogonal ``Q``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal (with the measured defect).

        Examples
        --------
        >>> from stiefel_rs import Grassmann
        >>> M, A = Grassmann(4, 2), np.diag([1.0, 2.0, 3.0, 4.0])
        >>> Y = M.random_point(rng=0)
        >>> bool(abs(M.euclidean_to_riemannian_gradient(Y, A @ Y) - (A @ Y - Y @ Y.T @ A @ Y)).max() < 1e-14)
        True
        """
    def euclidean_to_riemannian_hessian(self, Y: ArrayLike, G: ArrayLike, H: ArrayLike, V: ArrayLike) -> _Frames:
        """The Riemannian Hessian applied to the tangent vector ``V`` at ``Y``, ``(I - Y Y^T) H - V Y^T G``, shape (..., n, k).

        Parameters
        ----------
        Y : array_like, shape (..., n, k)
            Points.
        G, H : array_like, shape (..., n, k)
            The Euclidean gradient, and the Euclidean Hessian applied to ``V``, of a function that depends on the subspace alone.
        V : array_like, shape (..., n, k)
            Tangent vectors at ``Y``.

        Returns
        -------
        ndarray, shape (..., n, k)
            The covariant derivative of the gradient along ``V``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not horizontal (with the measured defect).

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
    """A smooth curve on St(n, k).

    Of complex frames where one of the arrays that it is made of is complex: points and vectors are complex then, and inner
    products of vectors in costs and lengths real parts of Hermitian ones.

    All curves share this protocol. Calls with a scalar ``t`` return shape ``(n, k)``, with an array of shape ``T``
    return ``T + (n, k)``. Many parameters are evaluated in parallel without the interpreter lock; results are
    bit-identical for any number of threads.
    """

    @property
    def n(self) -> int:
        """Rows of a point."""
    @property
    def k(self) -> int:
        """Columns of a point."""
    @property
    def field(self) -> str:
        """ "real" or "complex": what numbers points consist of."""
    @property
    def manifold(self) -> Stiefel | Grassmann:
        """The manifold of the points: a :class:`Stiefel`, or a :class:`Grassmann` for a curve of subspaces."""
    @property
    def t_span(self) -> tuple[float, float]:
        """The interval that the curve is made for."""
    def __call__(
        self, t: ArrayLike, nu: int = 0, *, extrapolate: bool | None = None, num_threads: int | None = None
    ) -> _Frames:
        """Position, or the ambient derivative of order ``nu``, at ``t``: what ``curve(t)`` returns.

        Parameters
        ----------
        t : array_like, shape T
            Parameters, any finite numbers; the curve is made for ``t_span``.
        nu : int, default 0
            Order of the derivative, 0 to 3; exact, by differentiating the algorithm.
        extrapolate : bool, optional
            Whether the curve goes on outside of ``t_span``, or parameters there raise, but for those that miss an end by 4 units in
            the last place of the larger one, which count as that end. By default as the spline was made, ``extrapolate``; all other
            curves go on.
        num_threads : int, optional
            Threads; by default those of the global pool.

        Returns
        -------
        ndarray, shape T + (n, k)

        Raises
        ------
        InvalidInputError
            ``t`` not finite or outside, ``nu`` out of range.
        OutsideDomainError
            Intermediate points that no unique quasi-geodesic joins: outside of ``t_span``, or for far or fast data.
        """
    def velocity(self, t: ArrayLike, *, extrapolate: bool | None = None, num_threads: int | None = None) -> _Frames:
        """Velocity ``S'`` at ``t``, shape ``T + (n, k)``; arguments as of ``curve(t)``."""
    def acceleration(self, t: ArrayLike, *, extrapolate: bool | None = None, num_threads: int | None = None) -> _Frames:
        """Covariant acceleration ``D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``; arguments as of ``curve(t)``."""
    def jerk(self, t: ArrayLike, *, extrapolate: bool | None = None, num_threads: int | None = None) -> _Frames:
        """Covariant jerk ``D_t D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``; arguments as of ``curve(t)``."""
    def derivative(self, nu: int = 1) -> CurveDerivative:
        """The ambient derivative of order ``nu`` as a function of ``t``.

        Parameters
        ----------
        nu : int, default 1
            Order, 0 to 3.

        Returns
        -------
        CurveDerivative
            Called as the curve is; it has a ``derivative`` too.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> velocity = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).derivative()
        >>> velocity(0.0).round(6).ravel().tolist()
        [0.0, 1.570796]
        """
    def cost(self) -> float:
        """The cost: integral of ``|D_t S'|^2`` over ``t_span``, canonical metric; in tension of ``|D_t S'|^2 + tension |S'|^2``.

        Relative error 1e-12, or round-off of the acceleration where that is more.

        Raises
        ------
        ConvergenceError
            The quadrature does not settle.
        """
    def arc_length(self, t0: float | None = None, t1: float | None = None) -> float:
        """Length of the curve between two parameters, canonical metric.

        Relative error 1e-12, or round-off of the velocity where that is more.

        Parameters
        ----------
        t0, t1 : float, optional
            The ends, ``t0 <= t1``; by default those of ``t_span``.

        Raises
        ------
        InvalidInputError
            Not finite, ``t1`` before ``t0``.
        ConvergenceError
            The quadrature does not settle.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).arc_length(0.0, 0.5)  # doctest: +ELLIPSIS
        0.78539816339...
        """
    def resample(self, count: int, *, num_threads: int | None = None) -> _Array:
        """Parameters at which the curve is to be evaluated for points at equal distances along it.

        ``curve(curve.resample(count))`` is the curve at constant speed.

        Parameters
        ----------
        count : int
            Number of points, two or more; the first and the last one are the ends of ``t_span``.
        num_threads : int, optional
            Threads; by default those of the global pool.

        Returns
        -------
        ndarray, shape (count,)
            Increasing; lengths between neighbours agree to 1e-12 of the whole. Equal steps for a curve that rests.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).resample(3).round(12).tolist()
        [0.0, 0.5, 1.0]
        """
    def derivative_bounds(self) -> DerivativeBounds:
        """The largest norms of velocity, covariant acceleration and covariant jerk over ``t_span``, canonical metric.

        True bounds for Riemannian cubics and their splines, at most 1e-3 above the largest norms, or 1e-4 of those of lower
        order where these are more than ten times as large in the length of a piece as unit of time; the largest norms of
        a dense and refined sample for other curves. See :class:`DerivativeBounds`.

        Raises
        ------
        ConvergenceError
            A cubic so long and fast that bounds would need too many samples.

        Examples
        --------
        >>> from stiefel_rs import QuasiGeodesic
        >>> curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
        >>> round(curve.derivative_bounds().velocity, 6)
        1.570796
        """
    def save(self, path: str | PathLike[str]) -> None:
        """Write the curve to a file, all its numbers, so that :func:`load` gives back the same curve to the last bit.

        Parameters
        ----------
        path : str or os.PathLike
            Name of the file, usually one that ends in ``.npz``. A file that is there is replaced, once the new one is written.

        Notes
        -----
        An archive of plain arrays (``numpy.load`` reads it, with no pickle inside), with the version of its form.
        """
    def plot(self, *, ax: Any = None, num: int = 200, **style: Any) -> Any:
        """Draw the curve, as ``stiefel_rs.plotting.plot`` does; needs matplotlib (extra ``plot``).

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a figure of its own if not given.
        num : int, optional
            Number of points.
        **style
            Passed on to the lines.

        Returns
        -------
        matplotlib.axes.Axes
            Where it was drawn.

        Raises
        ------
        ImportError
            There is no matplotlib.
        """
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: object) -> Self: ...

@final
class DerivativeBounds:
    """The largest norms of the derivatives of a curve, canonical metric.

    Made by :meth:`Curve.derivative_bounds`.
    """

    def __new__(
        cls, velocity: float, acceleration: float, jerk: float, guarantee: Literal["enclosure", "sampling"]
    ) -> DerivativeBounds: ...
    @property
    def velocity(self) -> float:
        """The largest norm of the velocity."""
    @property
    def acceleration(self) -> float:
        """The largest norm of the covariant acceleration."""
    @property
    def jerk(self) -> float:
        """The largest norm of the covariant jerk."""
    @property
    def guarantee(self) -> str:
        """``"enclosure"``: the norms are nowhere larger (but for round-off), and the numbers at most 1e-3 of themselves above
        the largest norms (1e-4 of a derivative of lower order where that is more than ten times as large, in the length of a
        piece as unit of time). ``"sampling"``: the largest norms of a dense sample, refined around the largest.
        """

@final
class QuasiGeodesic(Curve):
    """Quasi-geodesic ``beta(t) = e^{tX} S e^{t Omega}`` between two points.

    Parameters
    ----------
    S0, S1 : array_like, shape (n, k)
        Points with orthonormal columns; ``beta(0) = S0``, ``beta(1) = S1``. The principal branch, whose normal part
        ``|K|`` is the shortest; another branch may be shorter in all, by a smaller ``Omega``. Almost every two points are
        joined.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal (with the measured defect).
    OutsideDomainError
        Antipodal points, a relative rotation by pi, different components of O(n); carries ``angle``.

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
        """The quasi-geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k).

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect).
        """

@disjoint_base
class GeometricPolynomial(Curve):
    """Geometric polynomial of any degree: de Casteljau's algorithm with quasi-geodesics or geodesics.

    Parameters
    ----------
    P : array_like, shape (degree + 1, n, k)
        Control points with orthonormal columns, two or more. The curve starts in the first and ends in the last, with
        ``degree`` times the velocities of the first and the last piece between them.
    pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
        Quasi-geodesics are in closed form; geodesics (canonical metric) take a logarithm for every stage of every
        point, and derivatives a linear system. On a :class:`Grassmann` the two are the same.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the first given one on.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal (with the measured defect).
    OutsideDomainError
        Consecutive points that cannot be joined, or intermediate points that reach an angle of pi inside of the
        interval, where the curve would jump; with geodesics, consecutive points that are not within the injectivity
        radius; consecutive subspaces with a principal angle of pi/2. Carries ``angle``, or the distance.

    Notes
    -----
    Krakowski, Machado, Silva Leite, Batista (2017); with geodesics Park, Ravani (1995). Work is done in ``min(n, (degree + 1) k)`` dimensions.

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
        """What the curve is made of: "quasi_geodesic" or "geodesic"."""
    @property
    def control_points(self) -> _Frames:
        """The control points, shape (degree + 1, n, k)."""
    @property
    def degree(self) -> int:
        """One less than the number of control points."""
    @property
    def report(self) -> SolverReport | None:
        """How the search for control points of minimal cost ended; None for curves that were not searched.

        Its residual is the norm of the part of the acceleration that moves of the control points change to first order.
        """
    @staticmethod
    def minimal_cost(
        S0: ArrayLike, V0: ArrayLike, S1: ArrayLike, V1: ArrayLike, *, degree: int = 5, project: bool = False
    ) -> GeometricPolynomial:
        """The curve of a given degree with given end points and end velocities whose cost is least.

        Parameters
        ----------
        S0, V0 : array_like, shape (n, k)
            Initial point and velocity.
        S1, V1 : array_like, shape (n, k)
            Final point and velocity, at ``t = 1``.
        degree : int, default 5
            From 3 (the geometric cubic, nothing is free) to 10. Higher degrees come closer to the Riemannian cubic, by
            about a factor of ten each, and take longer to build and to evaluate.
        project : bool, default False
            As for the class.

        Returns
        -------
        GeometricPolynomial
            ``cost()`` is a local minimum, to 1e-12 relative; ``report`` says how the search ended.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect); a degree out of range; an end
            velocity too long to be met; more than 2000 free numbers.
        OutsideDomainError
            Control points that cannot be joined, or a curve that would jump; carries ``angle``.
        ConvergenceError
            The search found no minimum; carries ``report``.

        Notes
        -----
        Gauss-Newton iteration on the inner control points, from those of the geometric cubic. It is a local minimum:
        other starting points may lead to other curves.

        The search may take longer than the exact cubic does, ``RiemannianCubic.from_boundary``, whose points are quick
        too: this is for where a curve in closed form is wanted.

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
        """The curve of degree five with given end points, end velocities and covariant end accelerations, in closed form.

        Parameters
        ----------
        S0, V0, A0 : array_like, shape (n, k)
            Initial point, velocity and covariant acceleration.
        S1, V1, A1 : array_like, shape (n, k)
            The same at ``t = 1``.
        project : bool, default False
            As for the class.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect); an end velocity or acceleration
            too long to be met.
        OutsideDomainError
            Inner control points that cannot be joined, or a curve that would jump; carries ``angle``.

        Notes
        -----
        Meets its data to round-off. With the accelerations of a Riemannian cubic it is near that cubic; curves that
        share an end acceleration join with continuous acceleration.

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
        Points with orthonormal columns; ``gamma(0) = S0``, ``gamma(1) = S1``. The geodesic of ``Stiefel.log``: the
        shortest one up to ``0.89 pi`` (canonical metric).
    metric : "canonical", "euclidean" or float, default "canonical"
        The metric whose geodesic it is, as for ``Stiefel``. The covariant ``acceleration`` and ``jerk`` and the
        ``cost`` are those of the canonical metric for every curve, so they vanish for canonical geodesics only.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, and the bases of the curve turn as little as possible.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal (with the measured defect).
    OutsideDomainError
        Antipodal points, a relative rotation by pi, different components of O(n); carries ``angle``.
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
        """The geodesic from the point ``S`` with initial velocity ``V``, both of shape (n, k). All else as for the class.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), or too long for a number.
        """
    @property
    def length(self) -> float:
        """Length over ``[0, 1]`` in the metric of the geodesic."""

@final
class GeometricCubic(GeometricPolynomial):
    """Geometric cubic polynomial by the adjusted de Casteljau algorithm, from boundary data.

    Parameters
    ----------
    S0, V0 : array_like, shape (n, k)
        Initial point and velocity.
    S1, V1 : array_like, shape (n, k)
        Final point and velocity, at ``t = 1``.
    pieces : "quasi_geodesic" or "geodesic", default "quasi_geodesic"
        Geodesics (canonical metric) come much nearer to the Riemannian cubic for ``k > 1``, where they differ from
        quasi-geodesics, and take a logarithm for every stage of every point; not for ``k = n - 1``, where they are in
        closed form as well. For ``k = 1`` the curve is the same, and a point takes many times as long. On a :class:`Grassmann`
        the two are the same.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
        first given one on.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal, not tangent (with the measured defect); an end velocity too long to be
        met.
    OutsideDomainError
        Inner control points that cannot be joined, or intermediate points that reach an angle of pi inside of the
        interval, where the curve would jump; of subspaces a principal angle of pi/2 between consecutive control points, or
        in a third of an end velocity. Carries ``angle``.

    Notes
    -----
    Meets its boundary data to round-off and is close to the Riemannian cubic with the same data, not equal to it. A
    third of each end velocity must be the velocity of the principal quasi-geodesic between its ends (on the sphere,
    speeds below ``3 pi``); longer ones are refused.

    arXiv 2404.19407 and Krakowski, Machado, Silva Leite, Batista (2017).

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
        """The geometric cubic with control points ``P``, shape (4, n, k).

        Parameters
        ----------
        P : array_like, shape (4, n, k)
            Control points with orthonormal columns.
        manifold : Stiefel or Grassmann, optional
            What the points stand for, as for the class.
        project : bool, default False
            Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
            Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal (with the measured defect).
        OutsideDomainError
            Consecutive points that cannot be joined; carries ``angle``.
        """

@final
class RiemannianCubic(Curve):
    """Riemannian cubic: a critical curve of the integral of the squared covariant acceleration.

    Made by :meth:`from_initial` or :meth:`from_boundary`; it cannot be constructed directly.

    Notes
    -----
    Solves ``D_t^3 S' + R(D_t S', S') S' = tension D_t S'`` (canonical metric) on any St(n, k), without charts, by a Taylor method of
    order 20 in ``min(n, 4 k)`` dimensions, to round-off. Pieces of a :class:`CubicSpline` may instead be one polynomial
    about the middle of the piece, of an order that depends on how fast it turns. Outside of ``t_span`` the curve is
    integrated on, for each call anew: :meth:`restricted` gives a curve that keeps it.

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
        """The Riemannian cubic with given initial data.

        Parameters
        ----------
        S, V, A, J : array_like, shape (n, k)
            Point, velocity, covariant acceleration and covariant jerk at ``t = 0``.
        t_end : float, default 1.0
            The curve is made for the times between 0 and this one, which may be negative.
        tol : float, default 1e-17
            What a step leaves out, relative to the state, between 1e-17 (round-off) and 0.1. Points are orthonormal to
            about ``tol`` too, and no better.
        tension : float, default 0.0
            The curve makes the integral of ``|A|^2 + tension |V|^2`` stationary; not negative, in units of ``1 / t^2``.
        manifold : Stiefel or Grassmann, optional
            What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
            whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
            first given one on.
        project : bool, default False
            Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
            Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), ``t_end`` zero, ``tol`` or
            ``tension`` out of range.
        ConvergenceError
            More steps than 100000, or than fit into a gigabyte: ``t_end`` is too large for the speed. Carries
            ``report``; its residual is the time that was left.
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
        """A Riemannian cubic on ``[0, 1]`` with given end points and end velocities.

        Parameters
        ----------
        S0, V0 : array_like, shape (n, k)
            Initial point and velocity.
        S1, V1 : array_like, shape (n, k)
            Final point and velocity. Data with defects up to 1e-9, rounded decimals for example, stand for the nearest exact
            ones.
        tol : float, default 1e-12
            The largest distance of the end point and end velocity from ``S1`` and ``V1``, Frobenius norm of both
            together. Where an end speed exceeds 10 the velocity counts relative to the larger end speed; ``32 eps`` times that
            speed, about 1e-12 for 140 and never more than 1e-9, is the least tolerance (``report.tolerance``).
        max_iterations : int, default 50
            Newton steps from the first start, and from any other, at most; steps of descents, up to 300 of each, have the
            limit of work only. With 12 or fewer a first start that runs out of them ends the search. More than 50 raise the
            limit of work, about two seconds, in proportion.
        guess : pair (A, J) of array_like, optional
            Covariant acceleration and covariant jerk at ``S0`` to start from, shape (n, k) each; by default those of the
            cubic of flat space. On a :class:`Grassmann` they are horizontal at ``S0``.
        tension : float, default 0.0
            The curve makes the integral of ``|A|^2 + tension |V|^2`` stationary, its :meth:`Curve.cost`: a cubic for 0, near a
            geodesic but for both ends where it is large. At most 64: what is off at the start grows along the curve as
            ``exp(sqrt(tension) t)``.
        all_found : bool, default False
            Look for more solutions and return all that are found: by Newton's method from the cubic of flat space (or the
            guess), by descents from there and from cubics of flat space that make one or two full turns more, and along
            families of boundary data from curves that make a full turn more. On a :class:`Grassmann` by the same
            descents, whose cubics of flat space turn a principal direction by pi or 2 pi more, and by Newton's method from random
            initial data; with real lines (``k = 1``) on the sphere, to both unit vectors of the last line.
        manifold : Stiefel or Grassmann, optional
            What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
            whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
            first given one on.
        project : bool, default False
            Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
            Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

        Returns
        -------
        RiemannianCubic, or list of RiemannianCubic
            With ``all_found`` a list, the cheapest first (:meth:`Curve.cost`). There may be others: on the sphere there
            are infinitely many.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), ``tol`` not between 1e-15 and 0.1,
            ``max_iterations`` less than 1, ``tension`` not between 0 and 64.
        OutsideDomainError
            Points in different components of O(n); carries ``angle``.
        ConvergenceError
            No solution to ``tol`` is found, or the curve takes more Taylor steps than are allowed: the data, or a guess,
            are too fast. Carries ``report``; its residual is what the end is off, or the time that was left.

        Notes
        -----
        Cubics with given ends are stationary, not unique. Newton's method, with exact derivatives of the flow, starts from the
        cubic of flat space, or from the guess. If displacement and speeds are at most 2, its solution is returned. Otherwise
        (and without a guess) a chain of cubics descends to a curve of least cost: from a curve that rolls evenly from one
        velocity to the other, for end speeds up to 16 also from the cubic of flat space, and from the de Casteljau curve where
        more than one quasi-geodesic joins the points. The cheapest is returned. Where that would take more work than a problem
        may (dimensions from 57 on, as of St(15,5), SO(12) and complex St(10,4)) it is the solution from the cubic of flat space,
        and not known to be the cheapest. Compare solutions by :meth:`Curve.cost`.

        Opposite points, or nearly so, with end speeds below 1e-5 may be refused: their solutions are nearly a whole family
        (seen on St(3,1), St(4,1) and most on St(6,3), not on St(3,2) and St(4,2)).

        A problem is given up after the work of about two seconds. Ctrl-C ends the search at once.
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
        """A Riemannian cubic on ``[0, 1]`` with given end points and end velocities.

        Parameters
        ----------
        S0, V0 : array_like, shape (n, k)
            Initial point and velocity.
        S1, V1 : array_like, shape (n, k)
            Final point and velocity. Data with defects up to 1e-9, rounded decimals for example, stand for the nearest exact
            ones.
        tol : float, default 1e-12
            The largest distance of the end point and end velocity from ``S1`` and ``V1``, Frobenius norm of both
            together. Where an end speed exceeds 10 the velocity counts relative to the larger end speed; ``32 eps`` times that
            speed, about 1e-12 for 140 and never more than 1e-9, is the least tolerance (``report.tolerance``).
        max_iterations : int, default 50
            Newton steps from the first start, and from any other, at most; steps of descents, up to 300 of each, have the
            limit of work only. With 12 or fewer a first start that runs out of them ends the search. More than 50 raise the
            limit of work, about two seconds, in proportion.
        guess : pair (A, J) of array_like, optional
            Covariant acceleration and covariant jerk at ``S0`` to start from, shape (n, k) each; by default those of the
            cubic of flat space. On a :class:`Grassmann` they are horizontal at ``S0``.
        tension : float, default 0.0
            The curve makes the integral of ``|A|^2 + tension |V|^2`` stationary, its :meth:`Curve.cost`: a cubic for 0, near a
            geodesic but for both ends where it is large. At most 64: what is off at the start grows along the curve as
            ``exp(sqrt(tension) t)``.
        all_found : bool, default False
            Look for more solutions and return all that are found: by Newton's method from the cubic of flat space (or the
            guess), by descents from there and from cubics of flat space that make one or two full turns more, and along
            families of boundary data from curves that make a full turn more. On a :class:`Grassmann` by the same
            descents, whose cubics of flat space turn a principal direction by pi or 2 pi more, and by Newton's method from random
            initial data; with real lines (``k = 1``) on the sphere, to both unit vectors of the last line.
        manifold : Stiefel or Grassmann, optional
            What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
            whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
            first given one on.
        project : bool, default False
            Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
            Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

        Returns
        -------
        RiemannianCubic, or list of RiemannianCubic
            With ``all_found`` a list, the cheapest first (:meth:`Curve.cost`). There may be others: on the sphere there
            are infinitely many.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect), ``tol`` not between 1e-15 and 0.1,
            ``max_iterations`` less than 1, ``tension`` not between 0 and 64.
        OutsideDomainError
            Points in different components of O(n); carries ``angle``.
        ConvergenceError
            No solution to ``tol`` is found, or the curve takes more Taylor steps than are allowed: the data, or a guess,
            are too fast. Carries ``report``; its residual is what the end is off, or the time that was left.

        Notes
        -----
        Cubics with given ends are stationary, not unique. Newton's method, with exact derivatives of the flow, starts from the
        cubic of flat space, or from the guess. If displacement and speeds are at most 2, its solution is returned. Otherwise
        (and without a guess) a chain of cubics descends to a curve of least cost: from a curve that rolls evenly from one
        velocity to the other, for end speeds up to 16 also from the cubic of flat space, and from the de Casteljau curve where
        more than one quasi-geodesic joins the points. The cheapest is returned. Where that would take more work than a problem
        may (dimensions from 57 on, as of St(15,5), SO(12) and complex St(10,4)) it is the solution from the cubic of flat space,
        and not known to be the cheapest. Compare solutions by :meth:`Curve.cost`.

        Opposite points, or nearly so, with end speeds below 1e-5 may be refused: their solutions are nearly a whole family
        (seen on St(3,1), St(4,1) and most on St(6,3), not on St(3,2) and St(4,2)).

        A problem is given up after the work of about two seconds. Ctrl-C ends the search at once.
        """
    @property
    def report(self) -> SolverReport | None:
        """How the boundary value problem was solved; None for a curve from initial data."""
    @property
    def initial(self) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, each of shape (n, k)."""
    @property
    def tension(self) -> float:
        """The tension: 0 for a cubic."""
    @property
    def energy(self) -> float:
        """The conserved energy ``|D_t S'|^2 / 2 - <D_t D_t S', S'> + tension |S'|^2 / 2``."""
    @property
    def momentum(self) -> _Frames:
        """The conserved spatial momentum, a skew matrix of shape (n, n); for ``n`` up to 16384."""
    @property
    def steps(self) -> int:
        """Number of polynomials that the curve consists of: the steps of its integration, or 1 for a piece of a spline that
        was solved without integration.
        """
    def restricted(self, start: float, end: float) -> RiemannianCubic:
        """The same curve made for ``[start, end]``: a part of ``t_span``, or more.

        Raises
        ------
        InvalidInputError
            ``start >= end``, not finite.
        ConvergenceError
            The curve cannot be integrated on so far; carries ``report``.
        """
    def reparametrised(self, start: float, end: float) -> RiemannianCubic:
        """The same points at other times: ``t_span`` becomes ``[start, end]``.

        Raises
        ------
        InvalidInputError
            ``start >= end``, not finite, or so near or far that speeds leave the range of numbers.
        """
    def reversed(self) -> RiemannianCubic:
        """The curve run backwards over the same interval."""
    def initial_variation(
        self, dS0: ArrayLike, dV0: ArrayLike, dS1: ArrayLike, dV1: ArrayLike
    ) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """How the initial data change where the boundary data do: implicit function theorem.

        On a :class:`Grassmann` data and results are horizontal vectors at the bases of the curve, ``curve(t)``, which at the end is the
        given basis up to a turn; how the bases turn is left out.

        Parameters
        ----------
        dS0, dV0, dS1, dV1 : array_like, shape (n, k)
            Ambient derivatives of the boundary data along a family of data. So ``S.T @ dS`` is skew, and
            ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` vanishes, at both ends.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, a variation that leaves the constraints (with the measured defect).
        OutsideDomainError
            The ends are conjugate along the curve, to 1e-11: the solution does not depend smoothly on them. ``angle`` is
            None.

        Notes
        -----
        Exact derivatives of the flow, no differences. Any Riemannian cubic is the solution of the boundary value problem
        of its own ends; this is the derivative of that solution.
        """
    def point_variation(self, t: ArrayLike, dS0: ArrayLike, dV0: ArrayLike, dS1: ArrayLike, dV1: ArrayLike) -> _Frames:
        """How points of the curve change where the boundary data do.

        On a :class:`Grassmann` data and results are horizontal vectors at the bases of the curve, ``curve(t)``, which at the end is the
        given basis up to a turn; how the bases turn is left out.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        dS0, dV0, dS1, dV1 : array_like, shape (n, k)
            As in :meth:`initial_variation`.

        Returns
        -------
        ndarray, shape T + (n, k)
            Ambient derivatives of the points.

        Raises
        ------
        InvalidInputError, OutsideDomainError
            As :meth:`initial_variation`.
        """
    def point_pullback(self, t: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Gradient with respect to the boundary data of ``sum(W * curve(t))``: the transpose of :meth:`point_variation`.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        W : array_like, shape T + (n, k)
            Derivatives of a function by the points of the curve there; any matrices.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            ``(GS0, GV0, GS1, GV1)``: ``sum(W * point_variation(t, dS0, dV0, dS1, dV1))`` is ``sum(GS0 * dS0) + sum(GV0 * dV0) +
            sum(GS1 * dS1) + sum(GV1 * dV1)`` for every variation of the boundary data.

        Raises
        ------
        InvalidInputError
            Shape, not finite.
        OutsideDomainError
            The ends are conjugate along the curve, to 1e-11: the solution does not depend smoothly on them. ``angle`` is
            None.

        Notes
        -----
        One solution of the linear equations, whatever the number of parameters.
        """
    def cost_gradient(self) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Gradient of the cost with respect to the boundary data.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            ``(GS0, GV0, GS1, GV1)``: the cost changes by ``sum(GS0 * dS0) + sum(GV0 * dV0) + sum(GS1 * dS1) +
            sum(GV1 * dV1)`` for every variation of the boundary data as in :meth:`initial_variation`.

        Notes
        -----
        By the first variation of the cost at a critical curve: no equation has to be solved.
        """
    def initial_point_variation(
        self, t: ArrayLike, dS: ArrayLike, dV: ArrayLike, dA: ArrayLike, dJ: ArrayLike
    ) -> _Frames:
        """How points of the curve change where its initial data do.

        On a :class:`Grassmann` data and results are horizontal vectors at the bases of the curve, ``curve(t)``, which at the end is the
        given basis up to a turn; how the bases turn is left out.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        dS, dV, dA, dJ : array_like, shape (n, k)
            Ambient derivatives of point, velocity, covariant acceleration and covariant jerk at the start of ``t_span``, along a
            family of data. So ``S.T @ dS`` is skew, and ``S.T @ dV + dV.T @ S + dS.T @ V + V.T @ dS`` vanishes, for A and J too.

        Returns
        -------
        ndarray, shape T + (n, k)
            Ambient derivatives of the points.

        Raises
        ------
        InvalidInputError
            Shape, not finite, a variation that leaves the constraints (with the measured defect).
        """
    def initial_point_pullback(self, t: ArrayLike, W: ArrayLike) -> tuple[_Frames, _Frames, _Frames, _Frames]:
        """Gradient with respect to the initial data of ``sum(W * curve(t))``: the transpose of :meth:`initial_point_variation`.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        W : array_like, shape T + (n, k)
            Derivatives of a function by the points of the curve there; any matrices.

        Returns
        -------
        tuple of ndarray, each of shape (n, k)
            ``(GS, GV, GA, GJ)``: ``sum(W * initial_point_variation(t, dS, dV, dA, dJ))`` is ``sum(GS * dS) + sum(GV * dV) +
            sum(GA * dA) + sum(GJ * dJ)`` for every variation of the initial data.

        Raises
        ------
        InvalidInputError
            Shape, not finite.
        """

@disjoint_base
class PiecewiseCurve(Curve):
    """A curve through points, made of cubics that follow one another.

    Made by :class:`CubicSpline` and :class:`CubicHermite`.
    """

    @property
    def t(self) -> _Array:
        """The times between which the pieces run; read-only, shape (N,)."""
    @property
    def points(self) -> _Frames:
        """The points at these times, as given or projected; read-only, shape (N, n, k)."""
    @property
    def kind(self) -> str:
        """``"riemannian"`` or ``"geometric"``: what the pieces are."""
    @property
    def extrapolate(self) -> bool:
        """Whether the first and the last piece go on outside of ``t_span``."""
    @property
    def report(self) -> SolverReport | None:
        """How the spline was solved for; None where nothing had to be solved for all pieces together."""
    @property
    def pieces(self) -> list[RiemannianCubic] | list[GeometricCubic]:
        """The ``N - 1`` pieces, each on ``[0, 1]``."""

@final
class CubicHermite(PiecewiseCurve):
    """Curve through points with given velocities, once continuously differentiable.

    Parameters
    ----------
    t : array_like, shape (N,)
        Times, increasing, two or more.
    S : array_like, shape (N, n, k)
        Points with orthonormal columns.
    V : array_like, shape (N, n, k), or str
        Tangent vectors at the points: velocities per unit of ``t``. Or the name of a method of
        :func:`estimate_velocities`: ``"catmull-rom"``, ``"akima"`` or ``"natural"``.
    kind : "riemannian" or "geometric", default "riemannian"
        Pieces are Riemannian cubics, or geometric cubics: for pieces that other programs evaluate by de Casteljau's algorithm from
        control points. On small manifolds they take longer to find.
    extrapolate : bool, default False
        Whether the first and the last piece go on outside of ``[t[0], t[-1]]``; by default times there are errors.
    num_threads : int, optional
        Threads; by default those of the global pool.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
        first given one on.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shapes or numbers of knots that do not match, not finite, times that do not increase, not orthonormal, not tangent
        (with the measured defect). Names the knot, and carries it as ``knot``.
    OutsideDomainError
        Neighbours that no curve joins; carries ``knot``, the first of the two, and ``angle``.
    ConvergenceError
        No Riemannian cubic is found between two neighbours; carries ``knot`` and ``report``.
    TypeError
        Complex times, dates and durations.

    See Also
    --------
    CubicSpline : from points alone, twice continuously differentiable.

    Notes
    -----
    Pieces are made independently of each other, in parallel.

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
        """The velocities at the knots, as given or as estimated, shape (N, n, k); read-only."""

@final
class CubicSpline(PiecewiseCurve):
    """Spline of cubics through points: velocity and covariant acceleration are continuous.

    Parameters
    ----------
    t : array_like, shape (N,)
        Times, increasing, two or more.
    S : array_like, shape (N, n, k)
        Points with orthonormal columns.
    bc_type : str or pair, default "natural"
        What holds at the ends: ``"natural"``, no covariant acceleration; ``"clamped"``, no velocity; ``"periodic"``, the
        last point is the first one and velocity and covariant acceleration agree there. Or a pair of conditions for the
        first and the last point: each ``"natural"``, ``"clamped"``, ``(1, V)`` with a velocity or ``(2, A)`` with a
        covariant acceleration, tangent vectors of shape (n, k).
    kind : "riemannian" or "geometric", default "riemannian"
        Pieces are Riemannian cubics: stationary cost. Or geometric cubics (adjusted de Casteljau): close to it, and found in
        a half to a twentieth of the time from St(4, 2) to St(20, 4), in about the same time on the sphere and St(3, 2), and
        in up to twice the time on the rotations St(3, 3); to evaluate it takes longer, 1.1 times on the sphere, 5 times on
        St(3, 3).
    extrapolate : bool, default False
        Whether the first and the last piece go on outside of ``[t[0], t[-1]]``; by default times there are errors.
    tol : float, default 1e-12
        The largest distance by which a piece may miss its knot, and jump of the covariant acceleration, in the time of
        the piece.
    max_iterations : int, default 200
        Steps at the most. More than 200 raise the limit of work, about two seconds, in proportion.
    tension : float, default 0.0
        A spline in tension, of Riemannian pieces: stationary for the integral of ``|A|^2 + tension |V|^2``, near geodesics
        between the points where it is large. Not negative, in units of ``1 / t^2``; at most 64 by the square of the longest
        leg, since what is off at the start of a leg grows as ``exp(sqrt(tension) t)``, and 6.25 for points with more than 12 rows
        and more than ``4 k``, also in the span of all points.
    num_threads : int, optional
        Threads; by default those of the global pool.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
        first given one on.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shapes or numbers of knots that do not match, not finite, times that do not increase, not orthonormal, not tangent
        (with the measured defect), ends that do not close, ``tension`` out of range. Names the knot, and carries it as ``knot``.
    OutsideDomainError
        Neighbours that no curve joins, or no unique shortest one; carries ``knot``, the first of the two, and ``angle``.
    ConvergenceError
        No spline is found; carries ``report``.
    TypeError
        Complex times, dates and durations.

    See Also
    --------
    CubicHermite : through points with given velocities.

    Notes
    -----
    With Riemannian pieces: stationary for the integral of the squared covariant acceleration among the curves through
    the points with these ends, what a cubic spline is in flat space. Solved for all pieces at once, in time linear in
    their number.

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
        """The end conditions, as given: a word, or a pair; arrays are read-only."""
    def point_variation(
        self,
        t: ArrayLike,
        dS: ArrayLike,
        dt: ArrayLike | None = None,
        dbc: tuple[ArrayLike | None, ArrayLike | None] | None = None,
    ) -> _Frames:
        """How points of the spline change where its data do: implicit function theorem.

        On a :class:`Grassmann` variations are horizontal vectors at the bases of the curve, ``curve(t)`` at its knots, which are those
        of ``S`` up to turns. A periodic curve comes back with its first basis turned by ``Q = curve(t[0])^H curve(t[-1])``.

        Parameters
        ----------
        t : array_like, shape T
            Times.
        dS : array_like, shape (N, n, k)
            Ambient derivatives of the points along a family of data: ``S.T @ dS`` is skew for each. With periodic ends the last
            is the first, on a :class:`Grassmann` ``dS[-1] = dS[0] @ Q``.
        dt : array_like, shape (N,), optional
            Derivatives of the times; by default they stay.
        dbc : pair of array_like, shape (n, k), or None, optional
            Ambient derivatives of the vectors at the first and at the last knot, where ``bc_type`` gives one: ``S.T @ dV + dV.T @ S +
            dS.T @ V + V.T @ dS`` vanishes. By default, and for None, zero: right for vectors that are zero, as with
            ``"clamped"``, and stay so.

        Returns
        -------
        ndarray, shape T + (n, k)
            Ambient derivatives of the points at the times ``t``, which stay.

        Raises
        ------
        InvalidInputError
            Shape, not finite, a variation that leaves the constraints (with the measured defect); a spline with
            ``kind="geometric"``, or solved with so large a tolerance that it is off by more than 1e-6.
        OutsideDomainError
            The spline does not depend smoothly on its data, to 1e-11. ``angle`` is None.

        Notes
        -----
        Exact derivatives, no differences: the accelerations at the ends of the pieces by points and velocities there, and a linear
        system for the velocities, in time linear in the number of knots.
        """
    def point_pullback(
        self, t: ArrayLike, W: ArrayLike
    ) -> tuple[_Frames, _Array, tuple[_Frames | None, _Frames | None]]:
        """Gradient with respect to the data of ``sum(W * curve(t))``: the transpose of :meth:`point_variation`.

        Parameters
        ----------
        t : array_like, shape T
            Times.
        W : array_like, shape T + (n, k)
            Derivatives of a function by the points of the curve there; any matrices.

        Returns
        -------
        GS : ndarray, shape (N, n, k)
            With respect to the points. With periodic ends that by the point at both ends is the sum of the first and the last, on a
            :class:`Grassmann` ``GS[0] + GS[-1] Q^H`` with ``Q`` of :meth:`point_variation`.
        Gt : ndarray, shape (N,)
            With respect to the times.
        Gbc : tuple
            With respect to the vectors at the first and at the last knot, shape (n, k); None where ``bc_type`` gives none.

        Raises
        ------
        InvalidInputError
            Shape, not finite; a spline with ``kind="geometric"``, or solved with so large a tolerance that it is off by more than
            1e-6.
        OutsideDomainError
            The spline does not depend smoothly on its data, to 1e-11. ``angle`` is None.

        Notes
        -----
        ``sum(W * point_variation(t, dS, dt, dbc))`` is the sum of the products of these with the variations. One solution of the
        linear system, whatever the number of times.
        """
    def cost_gradient(self) -> tuple[_Frames, _Array, tuple[_Frames | None, _Frames | None]]:
        """Gradient of the cost with respect to points, times and end conditions.

        Returns
        -------
        GS : ndarray, shape (N, n, k)
            With respect to the points. With periodic ends that by the point at both ends is the sum of the first and the last, on a
            :class:`Grassmann` ``GS[0] + GS[-1] Q^H`` with ``Q`` of :meth:`point_variation`.
        Gt : ndarray, shape (N,)
            With respect to the times.
        Gbc : tuple
            With respect to the vectors at the first and at the last knot, shape (n, k); None where ``bc_type`` gives none.

        Raises
        ------
        InvalidInputError
            A spline with ``kind="geometric"``, or solved with so large a tolerance that it is off by more than 1e-6.
        OutsideDomainError
            An acceleration is given and the spline does not depend smoothly on its data, to 1e-11. ``angle`` is None.

        Notes
        -----
        By the first variation of the cost: no equation has to be solved unless ``bc_type`` gives an acceleration.
        """

@final
class SmoothingSpline(PiecewiseCurve):
    """Spline near points rather than through them: closeness to data against cost.

    Makes ``sum_i weights[i] d(S(t[i]), S[i])^2 + lam J`` stationary, with the Riemannian distance ``d`` and the integral ``J`` of the
    squared covariant acceleration.

    Parameters
    ----------
    t : array_like, shape (N,)
        Times in order; they may repeat.
    S : array_like, shape (N, n, k)
        Data: points with orthonormal columns.
    weights : array_like, shape (N,), optional
        Positive; all 1 by default.
    lam : float, optional
        Weight of the cost, 0 or more, in units of squared distance times the cube of a time; 0 is the natural spline through the
        data, ``inf`` geodesic regression. By default the one that generalised cross-validation finds, for three points or more.
    extrapolate : bool, default False
        Whether the first and the last piece go on outside of ``[t[0], t[-1]]``; by default times there are errors.
    tol : float, default 1e-11
        The largest distance by which a piece may miss its knot, jump of the covariant acceleration, and lack of balance at a
        knot, in the time of the piece.
    max_iterations : int, default 200
        Steps at the most. More than 200 raise the limit of work, about two seconds, in proportion.
    num_threads : int, optional
        Threads; by default those of the global pool.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
        first given one on.
    w : array_like, optional
        Another name of `weights`, which SciPy's functions have.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Raises
    ------
    InvalidInputError
        Shapes or numbers that do not match, not finite, times that fall, weights that are not positive, not orthonormal (with the
        measured defect). Names the knot, counted by distinct times, and carries it as ``knot``.
    OutsideDomainError
        Neighbours that no curve joins; carries ``knot``, the first of the two, and ``angle``.
    ConvergenceError
        No spline is found; carries ``report``.
    TypeError
        Complex times, dates and durations.

    See Also
    --------
    CubicSpline : through the points.

    Notes
    -----
    ``t`` are the distinct times, ``points`` the points of the curve there.

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
        """The weight of the cost, given or found."""
    @property
    def misfit(self) -> float:
        """``sum_i weights[i] d(S(t[i]), S[i])^2``."""
    @property
    def degrees_of_freedom(self) -> float:
        """How many data the curve could follow, between 2 and their number: the trace of the influence matrix of the smoothing
        spline in flat space.
        """

@final
class RotationCurve:
    """Curve of rotations in unit quaternions: the form in which :class:`RotationSpline` evaluates.

    Parameters
    ----------
    t : array_like, shape (N,)
        Times, increasing, two or more, in seconds.
    quaternions : array_like, shape (N, 4)
        Rotations as quaternions, scalar last, of any length but zero.
    bc_type : str or pair, default "natural"
        ``"natural"``, ``"clamped"``, ``"periodic"`` or a pair of ends, each ``"natural"``, ``"clamped"``, ``(1, w)`` with a body rate
        in rad/s or ``(2, a)`` with its derivative in rad/s^2, of shape (3,).
    tol : float, default 1e-12
        As of :class:`CubicSpline`.
    max_iterations : int, default 200
        As of :class:`CubicSpline`.
    tension : float, default 0.0
        As of :class:`CubicSpline`, in 1/s^2.
    num_threads : int, optional
        Threads; by default those of the global pool.

    Raises
    ------
    InvalidInputError
        Shapes that do not match, not finite, a quaternion of length zero, times that do not increase.
    OutsideDomainError
        Neighbours half a turn apart; carries ``knot``, the first of the two, and ``angle``.
    ConvergenceError
        No spline is found; carries ``report``.

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
        num_threads: int | None = None,
    ) -> RotationCurve: ...
    @staticmethod
    def of_curve(curve: CubicSpline | SmoothingSpline | CubicHermite, start: ArrayLike | None = None) -> RotationCurve:
        """The quaternion form of a curve of Riemannian cubics on ``St(3, 3)``.

        Parameters
        ----------
        curve : CubicSpline, CubicHermite or SmoothingSpline
            Of ``kind="riemannian"``, of rotation matrices.
        start : array_like, shape (4,), optional
            A quaternion near that of the first knot, scalar last: the sign there is that of `start`.

        Raises
        ------
        InvalidInputError
            A curve of another kind or on another manifold, or one of reflections.

        Returns
        -------
        RotationCurve
            Beyond its ends the end pieces go on, also where ``curve`` refuses such times.
        """
    @staticmethod
    def batch(
        t: ArrayLike,
        quaternions: ArrayLike,
        bc_type: _BcType = "natural",
        *,
        tol: float = 1e-12,
        max_iterations: int = 200,
        tension: float = 0.0,
        num_threads: int | None = None,
    ) -> list[RotationCurve]:
        """Many curves at once, on several threads.

        Parameters
        ----------
        t : array_like, shape (N,) or (M, N)
            Times in seconds, of all curves or of each.
        quaternions : array_like, shape (M, N, 4)
            Rotations as quaternions, scalar last.
        bc_type : str or pair, default "natural"
            As of the class, of every member.
        tol, max_iterations, tension, num_threads
            As of the class.

        Returns
        -------
        list of RotationCurve

        Raises
        ------
        InvalidInputError, OutsideDomainError, ConvergenceError
            As of the class, of the first member that fails; names the member.
        """
    def quaternions(self, t: ArrayLike) -> _Array:
        """Unit quaternions at times.

        Parameters
        ----------
        t : array_like, shape (T,)
            Times in seconds; beyond the keyframes the end pieces go on.

        Returns
        -------
        ndarray, shape (T, 4)
            Scalar last, continuous in `t`; at the first keyframe the given one, made a unit quaternion.
        """
    def rates(self, t: ArrayLike, order: int) -> _Array:
        """Body rates at times, or derivatives of them.

        Parameters
        ----------
        t : array_like, shape (T,)
            Times in seconds; beyond the keyframes the end pieces go on.
        order : int
            1, 2 or 3: the body rate ``w`` in rad/s, its derivative in rad/s^2, its second derivative in rad/s^3.

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
        """The times of the keyframes in seconds; read-only, shape (N,)."""
    @property
    def report(self) -> SolverReport | None:
        """How the spline was solved for."""

@final
class ShootingResult:
    """A discrete trajectory that meets its boundary data."""

    @property
    def trajectory(self) -> _Array:
        """The states, shape (steps + 1, 4 d)."""
    @property
    def momenta(self) -> tuple[_Array, _Array]:
        """The initial momenta ``(p_q, p_qdot)``, each of shape (d,)."""
    @property
    def report(self) -> SolverReport:
        """How the search ended."""

@final
class ChartTrajectory:
    """A curve that passes from chart to chart, at times of shape ``T``; ``(steps + 1,)`` for a discrete trajectory."""

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
        """The Hamiltonian, shape T."""
    @property
    def momentum(self) -> _Array:
        """Momentum of the rotations of space about the three axes, which a Riemannian cubic keeps, shape T + (3,)."""
    @property
    def states(self) -> _Array:
        """``(q, qdot, p_q, p_qdot)`` of the rotated point ``rotations @ point`` in the chart, shape T + (4 d,)."""
    @property
    def rotations(self) -> _Array:
        """Which of the three charts: a cyclic permutation of the axes, the identity for the chart itself, shape T + (3, 3)."""
    @property
    def transitions(self) -> list[int]:
        """The positions, in C order, at which the chart is another than before."""

@final
class CubicTrajectory:
    """A discrete trajectory of a Riemannian cubic. Its arrays are read-only."""

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
        """The Hamiltonian ``|A|^2 / 2 - <J, V>`` in the canonical metric, shape (steps + 1,)."""
    @property
    def momentum_drift(self) -> float:
        """Largest deviation of the spatial momentum from its start: ``|A|^2 = tr(A^T A) / 2``."""
    @property
    def constraint_drift(self) -> float:
        """Largest violation of the constraints: of ``mu_h = [x, p]_h`` in the same norm for `integrate_cubic`; of ``S^T S = I``
        and of skew ``S^T V``, ``S^T p_S`` and ``S^T p_V``, Frobenius norm, for `integrate_embedded`.
        """
    def __copy__(self) -> CubicTrajectory: ...
    def __deepcopy__(self, _memo: object) -> CubicTrajectory: ...

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
    """Riemannian cubics on ``[0, 1]`` with given end points and end velocities, for a batch of problems.

    Each is that of :meth:`RiemannianCubic.from_boundary`, up to ``tol``. Points with up to three rows, and displacement and
    speeds up to 2, are solved for eight abreast, where a solution depends, within ``tol``, on which problems stand beside
    it; the others, and those that this does not solve, one by one. On a :class:`Grassmann` all are solved one by one, to the last
    bit as by :meth:`RiemannianCubic.from_boundary`.

    Parameters
    ----------
    S0, V0 : array_like, shape (..., n, k)
        Initial points and velocities; leading axes broadcast.
    S1, V1 : array_like, shape (..., n, k)
        Final points and velocities.
    tol : float, default 1e-12
        The largest distance of the end from ``S1`` and ``V1``, as in :meth:`RiemannianCubic.from_boundary`.
    max_iterations : int, default 50
        Newton steps for one problem, as there.
    num_threads : int, optional
        Threads; by default those of the global pool. Results are the same for any number.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever; vectors, and the results, are horizontal, ``Y^T V = 0``.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Returns
    -------
    BoundaryBatch
        Named tuple of ``acceleration`` and ``jerk``, covariant, at ``S0``, shape (..., n, k); ``cost``, the integral of the
        squared covariant acceleration, ``converged`` and ``residual``, shape (...). Where a problem is not solved,
        ``converged`` is False, ``residual`` what the nearest end was off, and the others NaN.

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal, not tangent (with the measured defect and the member of the batch), ``tol`` not
        between 1e-15 and 0.1, ``max_iterations`` less than 1.
    OutsideDomainError
        Points in different components of O(n); subspaces with a principal angle of pi/2 between them.

    See Also
    --------
    RiemannianCubic.from_initial : the curve from ``S0, V0, acceleration, jerk``.
    stiefel_rs.dask.solve_boundary : batches that do not fit into memory, and more fields.

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
    """Velocities of a smooth curve at its knots, from the points alone.

    Parameters
    ----------
    t : array_like, shape (N,)
        Times, increasing, two or more.
    S : array_like, shape (N, n, k)
        Points with orthonormal columns.
    method : "catmull-rom", "akima" or "natural", default "catmull-rom"
        ``"catmull-rom"``, the parabola through three neighbours. ``"akima"``, a mean of the slopes on both sides that
        does not overshoot beside jumps and at rest (weights of SciPy's ``method="makima"``). ``"natural"``, the
        velocities of the natural cubic spline in tangent spaces.
    closed : bool, default False
        Whether the curve is closed: the last point is the first one, and so is its velocity.
    num_threads : int, optional
        Threads; by default those of the global pool.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, and the last one of a closed curve is any basis of the first subspace.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Returns
    -------
    ndarray, shape (N, n, k)
        Tangent vectors at the points, per unit of ``t``. On a :class:`Grassmann` they are horizontal at the given bases: a basis that is
        turned turns its own velocity, and no other.

    Raises
    ------
    InvalidInputError
        Shapes or numbers of knots that do not match, not finite, times that do not increase, not orthonormal (with the
        measured defect), ends that do not close; carries ``knot``.
    OutsideDomainError
        Neighbours that no quasi-geodesic joins, or subspaces with a principal angle of pi/2 between them; carries ``knot``, the first of
        the two, and ``angle``.
    TypeError
        Complex times, dates and durations.

    See Also
    --------
    CubicHermite : the curve through points with velocities; takes the name of a method for them.

    Notes
    -----
    The formulas of flat space in tangent spaces; quasi-geodesics between neighbours carry vectors from knot to knot, of subspaces
    geodesics. On the circle exactly those for the angle.

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
    """The Riemannian cubic with the given initial data, by equal steps of an explicit symplectic splitting.

    Any shape, no chart, no equation to solve: each step is a sequence of exact flows. Points stay orthonormal, spatial
    momentum and constraint conserved, to round-off; the energy has no drift.

    Parameters
    ----------
    S, V, A, J : array_like, shape (n, k)
        Point, and velocity, covariant acceleration and covariant jerk at it.
    steps : int
        Equal steps over ``[0, t_end]``, at least 1.
    t_end : float, default 1.0
        Negative to run backwards, not zero.
    order : {2, 4, 6, 8}, default 6
        Order of the method: 1, 4, 5 or 12 exponentials per step; in tension 1, 5, 9 or 17.
    tension : float, default 0.0
        As in :meth:`RiemannianCubic.from_initial`.
    manifold : Stiefel or Grassmann, optional
        What the points stand for; by default the frames that the arrays are. On a :class:`Grassmann` they are bases of subspaces,
        whichever, vectors are horizontal, ``Y^T V = 0``, and the bases of the curve turn as little as possible, ``Y^T Y' = 0``, from the
        first given one on.
    project : bool, default False
        Whether points that are off the manifold by up to 0.1 are replaced by the nearest ones, and vectors by their tangent parts.
        Without it points may be off by 1e-9, arrays in single precision by 1e-5; the latter are always replaced.

    Returns
    -------
    CubicTrajectory

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal, not tangent, ``steps < 1``, ``t_end`` zero, unknown order, ``tension`` out of
        range, an exponential by more than 100 radians where ``n > 3``, a result too large for a number.

    Notes
    -----
    ``H = <mu, x> + |p|^2 / 2 - tension |x|^2 / 2`` on the cotangent bundle of ``SO(n) x m`` (Crouch, Silva Leite 1995), split into its two
    terms. Compositions of order 4, 6 and 8 made for such splittings; the Rust documentation of ``SplittingOrder`` has
    their error constants.

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

    The phase space is the paper's, ``T*(TSt(n, k))``, as a submanifold of four copies of the ``n x k`` matrices: any
    shape, no chart. Order 2. ``S^T S = I``, ``S^T V + V^T S = 0``, the momentum constraints and the spatial momentum hold
    to round-off, the energy has no drift. `integrate_cubic` solves no equation: it is faster, and its errors are smaller.

    Parameters
    ----------
    S, V, A, J : array_like, shape (n, k)
        Point, and velocity, covariant acceleration and covariant jerk at it.
    steps : int
        Equal steps over ``[0, t_end]``, at least 1.
    t_end : float, default 1.0
        Negative to run backwards, not zero.
    map : {"midpoint"}, default "midpoint"
        Discretization map of the ambient space, ``R_d(q, v) = (q - v/2, q + v/2)``. Its cotangent lift keeps
        quadratic constraints.
    project : bool, default False
        As for :func:`integrate_cubic`.

    Returns
    -------
    CubicTrajectory

    Raises
    ------
    InvalidInputError
        Shape, not finite, not orthonormal, not tangent, ``steps < 1``, ``t_end`` zero, unknown map, a result too large
        for a number.
    ConvergenceError
        A step is too long for its implicit equations; carries ``report``.

    Notes
    -----
    ``H = <p_S S^T + p_V V^T, X> + |p_V S^T - S p_V^T|^2 / 4`` with ``X = V S^T - S V^T - S (S^T V - V^T S) S^T / 2``,
    Frobenius products. A step is the implicit midpoint rule of the ambient space, after which multiples of the gradients
    of the constraints make ``S^T p_S`` and ``S^T p_V`` skew. arXiv 2404.19407 names such a method as future work;
    discretization maps: Barbero-Linan, Martin de Diego (2023); constraints: Jay (1996), Hairer, Lubich, Wanner (2006),
    section VII.1.4.

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
    """A chart of the paper: ``Chart.sphere()`` for St(3,1), ``Chart.frame()`` for St(3,2).

    Coordinates ``q`` have ``d`` entries: ``(theta, phi)`` or ``(theta, phi, psi)``, radians, ``0 < theta < pi``. A
    state is ``z = (q, qdot, p_q, p_qdot)``, shape ``(..., 4 d)``; leading axes are batches and broadcast.

    Notes
    -----
    arXiv 2404.19407, sections on St(3,1) and St(3,2). The Hamiltonian of the frame chart follows from
    the canonical metric; unlike the paper's longer form it does not divide by ``cos(theta)``.

    Examples
    --------
    The paper's curve on the sphere, and its end after 100 mid-point steps:

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
        """The sphere St(3,1): ``(theta, phi)``, metric ``diag(1, sin(theta)^2)``."""
    @staticmethod
    def frame() -> Chart:
        """The 2-frames St(3,2): ``(theta, phi, psi)``, the canonical metric
        ``dtheta^2 + dphi^2 + dpsi^2 + 2 cos(theta) dphi dpsi``.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def d(self) -> int:
        """Dimension of the chart, 2 or 3."""
    @property
    def k(self) -> int:
        """Columns of an embedded point, 1 or 2."""
    def embed(self, q: ArrayLike) -> _Array:
        """The point of coordinates ``q``, shape (..., d) -> (..., 3, k).

        Raises
        ------
        OutsideDomainError
            Unless ``0 < theta < pi``; carries ``angle``. The same holds for every method.
        """
    def embed_velocity(self, q: ArrayLike, qdot: ArrayLike) -> _Array:
        """The velocity of coordinates ``q``, ``qdot``, shapes (..., d) -> (..., 3, k)."""
    def momenta(self, q: ArrayLike, qdot: ArrayLike, qddot: ArrayLike, qdddot: ArrayLike) -> tuple[_Array, _Array]:
        """Momenta ``(p_q, p_qdot)`` of a curve from its coordinate derivatives up to the third, all of shape (..., d).

        Notes
        -----
        ``p_qdot = g (qddot + Gamma(qdot, qdot))`` and
        ``p_q[i] = 2 Gamma[k, i, j] qdot[j] p_qdot[k] - d/dt p_qdot[i]``.
        """
    def derivatives(self, z: ArrayLike) -> tuple[_Array, _Array, _Array, _Array]:
        """Coordinate derivatives ``(q, qdot, qddot, qdddot)`` of the curve through a state, each of shape (..., d)."""
    def hamiltonian(self, z: ArrayLike) -> _Array:
        """The Hamiltonian, shape (..., 4 d) -> (...)."""
    def gradient(self, z: ArrayLike) -> _Array:
        """The exact gradient of the Hamiltonian, shape (..., 4 d)."""
    def hessian(self, z: ArrayLike) -> _Array:
        """The exact Hessian of the Hamiltonian, shape (..., 4 d, 4 d)."""
    def state(self, S: ArrayLike, V: ArrayLike, A: ArrayLike, J: ArrayLike) -> _Array:
        """The state of the cubic with the given point, velocity, covariant acceleration and covariant jerk.

        Parameters
        ----------
        S, V, A, J : array_like, shape (3, k)
            A point and three tangent vectors.

        Returns
        -------
        ndarray, shape (4 d,)
            ``(q, qdot, p_q, p_qdot)``, angles in ``[-pi, pi]``.

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent (with the measured defect).
        OutsideDomainError
            The first column of ``S`` is a pole of the chart. `integrate_across` and `reference_across` take it.

        Notes
        -----
        ``p_qdot[i] = <d_i S, A>`` and ``p_q[i] = Gamma[k, i, j] qdot[j] p_qdot[k] - <d_i S, J>``.
        """
    def covariant(self, z: ArrayLike) -> tuple[_Array, _Array, _Array, _Array]:
        """Point, velocity, covariant acceleration and covariant jerk ``(S, V, A, J)`` of a state: the inverse of `state`.

        Shape (..., 4 d) -> four of shape (..., 3, k).
        """
    def discretize(self, x: ArrayLike, v: ArrayLike, map: _Map = "initial_point") -> _Array:
        """The two points of a discretization map of the tangent bundle.

        Parameters
        ----------
        x, v : array_like, shape (..., 2 d)
            A position with its velocity, ``(q, qdot)``, and the vector ``(dq, dqdot)``.
        map : str, default "initial_point"
            As for `integrate`.

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
        """The symplectic one-step method of a discretization map.

        ==========================  =========================================================================  =====
        map                         ``R_d(x, v)``, ``x = (q, qdot)``                                           order
        ==========================  =========================================================================  =====
        "initial_point"             ``(x, x + v)``                                                             1
        "midpoint"                  ``(x - v/2, x + v/2)``                                                     2
        "exponential"               ``(x, rho(x, v))``, ``rho`` the Riemannian exponential, lifted             1
        "exponential_midpoint"      ``(rho(x, -v/2), rho(x, v/2))``                                            2
        "cayley"                    with the Cayley retraction                                                 1
        "cayley_midpoint"           the same                                                                   2
        "quasi_geodesic"            with the paper's quasi-geodesics; on the sphere they are the geodesics     1
        "quasi_geodesic_midpoint"   the same                                                                   2
        ==========================  =========================================================================  =====

        The methods of a retraction commute with the rotations of space and keep the momentum of all three.

        Parameters
        ----------
        z0 : array_like, shape (..., 4 d)
            Initial state.
        steps : int
            Equal steps over ``[0, t_end]``, at least 1.
        t_end : float, default 1.0
        map : str, default "initial_point"
            One of the table.
        order : int, optional
            Order of the method: by default that of the map. 2, 4, 6 and 8 compose a step from 1, 5, 9 and 17 shorter
            ones; with a map of order 1 each of them is a half step of its adjoint and a half step of itself.

        Returns
        -------
        ndarray, shape (..., steps + 1, 4 d)

        Raises
        ------
        InvalidInputError
            Not finite, ``steps < 1``, unknown map or order.
        OutsideDomainError
            The trajectory leaves the chart; carries ``angle``.
        ConvergenceError
            A step is too large for its implicit equations; carries ``report``.

        Notes
        -----
        arXiv 2404.19407, from the cotangent lift of the discretization map (Barbero-Linan, Martin de Diego 2023).
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
        """The discrete trajectory across charts: as `integrate`, with no pole in the way.

        A state with ``sin(theta) < 1/2`` moves before its next step to another chart by a cyclic permutation of the
        axes, an isometry, and its cotangent lift: the method stays symplectic.

        Parameters
        ----------
        S, V, A, J : array_like, shape (3, k)
            Any point, the poles too; velocity, covariant acceleration and covariant jerk.
        steps : int
            Equal steps over ``[0, t_end]``, at least 1.
        t_end : float, default 1.0
        map, order
            As for `integrate`. The trajectory of a map from a retraction does not depend on the charts; the maps
            linear in coordinates are another method in each chart, of the same order.

        Returns
        -------
        ChartTrajectory

        Raises
        ------
        InvalidInputError
            Shape, not finite, not orthonormal, not tangent; ``steps < 1``, unknown map or order.
        OutsideDomainError, ConvergenceError
            A step is too long for a chart, or for its implicit equations.

        Examples
        --------
        A geodesic over the pole and once around:

        >>> from stiefel_rs import Chart
        >>> S, V = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [2 * np.pi]])
        >>> path = Chart.sphere().integrate_across(S, V, 0 * S, 0 * S, 40, map="exponential_midpoint")
        >>> bool(abs(path.point[-1] - S).max() < 1e-13)
        True
        >>> len(path.transitions) > 0
        True
        """
    def reference(self, z0: ArrayLike, t: ArrayLike) -> _Array:
        """The exact flow: states at the times ``t``, from ``z0`` at time 0.

        Parameters
        ----------
        z0 : array_like, shape (..., 4 d)
        t : array_like, shape T
            Finite times in any order.

        Returns
        -------
        ndarray, shape (...,) + T + (4 d,)
            Error at most 1e-13 for curves of the size of the paper's.

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
        """The exact flow across charts: as `reference`, with no pole in the way.

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
            Shape, not finite, not orthonormal, not tangent.
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
        """Shooting: the discrete trajectory with given ends.

        Parameters
        ----------
        q0, qdot0, q1, qdot1 : array_like, shape (d,)
            Coordinates and velocities at time 0 and ``t_end``. Angles are not wrapped: give the branch that is meant.
        steps : int
            At least 1.
        map : str, default "midpoint"
            As for `integrate`.
        t_end : float, default 1.0
        tol : float, default 1e-12
            Euclidean norm of the end's defect.
        max_iterations : int, default 50
            Newton steps.
        guess : pair of array_like, each of shape (d,), optional
            Initial momenta ``(p_q, p_qdot)`` to start from.
        order : int, optional
            As for `integrate`.

        Returns
        -------
        ShootingResult

        Raises
        ------
        InvalidInputError
            Wrong shapes, not finite, ``steps < 1``, unknown map or order, ``tol`` negative or not finite, ``t_end = 0``.
        OutsideDomainError
            An end, or the trajectory that the iteration starts from, is outside of the chart; carries ``angle``.
        ConvergenceError
            No trajectory found; carries ``report``. One step has none in general: the end point of a single step does
            not depend on all of the momenta.

        Notes
        -----
        Damped Newton iteration on the initial momenta; the Jacobian is the exact derivative of the discrete flow.
        """
