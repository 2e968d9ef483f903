"""Formulas of arXiv 2404.19407 as printed, with n x n matrices, and test points."""

import numpy as np
from scipy.linalg import schur

EPS = np.finfo(float).eps
# k = 1 is the sphere, k = n the orthogonal group, (4, 3) has n < 2 k.
SHAPES = [(3, 1), (3, 2), (5, 2), (4, 3), (6, 3), (4, 4)]
# A point is random or consists of the first columns of the identity; a velocity may lack one of its parts, or both.
POINTS = ["random point", "coordinate columns"]
VELOCITIES = ["both parts", "Omega = 0", "X = 0", "zero"]


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


def point(manifold, kind, rng):
    """A point of one of the `POINTS`; on O(n), in the component of the identity."""
    if kind == "coordinate columns":
        return np.eye(manifold.n, manifold.k)
    S = manifold.random_point(rng)
    if manifold.k == manifold.n:
        S[:, 0] *= np.sign(np.linalg.det(S))
    return S


def velocity(manifold, S, kind, rng, length=0.9):
    """A tangent vector of one of the `VELOCITIES`; zero if the requested part is always zero."""
    V = manifold.random_tangent(S, rng)
    V *= length / manifold.norm(S, V)
    Omega = S.T @ V
    return {"both parts": V, "Omega = 0": V - S @ Omega, "X = 0": S @ Omega, "zero": 0 * V}[kind]


def expm(A):
    """The exponential by scaling, its series and squaring: SciPy's waits for threads on a busy machine."""
    halvings = 1 + max(0, int(np.ceil(np.log2(max(np.abs(A).sum(axis=1).max(), EPS)))))
    I = np.eye(len(A))  # noqa: E741
    E = I
    # The rest of the series is below 0.5^15 / 15! = 2e-17.
    for j in range(14, 0, -1):
        E = I + A @ E / (2**halvings * j)
    for _ in range(halvings):
        E = E @ E
    return E


def log(Q):
    """The principal logarithm of an orthogonal matrix, which must be real: its complex Schur form is diagonal."""
    T, U = schur(Q, output="complex")
    L = (U * (1j * np.angle(np.diag(T)))) @ U.conj().T
    # An eigenvalue -1 yields pi here.
    assert np.abs(L.imag).max() < 1e-6, f"no real principal logarithm: imaginary part {np.abs(L.imag).max():.3e}"
    return L.real


def reflection(S):
    """`I - 2 S S^T`."""
    return np.eye(len(S)) - 2 * S @ S.T


def pair(S, V):
    """Equation (4)."""
    return V @ S.T - S @ V.T + 2 * S @ V.T @ S @ S.T, S.T @ V


def inner(S, V1, V2):
    """Equation (5)."""
    return np.trace(V1.T @ (np.eye(len(S)) - S @ S.T / 2) @ V2)


def joining_pair(S0, S1):
    """Equation (6)."""
    X = log(reflection(S1) @ reflection(S0)) / 2
    return X, log(S0.T @ expm(-X) @ S1)


def quasi_geodesic(S, X, Omega, t):
    """Equation (7)."""
    return expm(t * X) @ S @ expm(t * Omega)


def difference(f, t, h=1e-3):
    """A derivative by central differences of order 4."""
    return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h)


class Theorem1:
    """`X_0 .. X_5`, `Omega_0 .. Omega_5` and the curve (11) for data `S0, V0, S3, V3`, as in section 3."""

    def __init__(self, S0, V0, S3, V3):
        self.S0 = S0
        self.X0 = (V0 @ S0.T - S0 @ V0.T + 2 * S0 @ V0.T @ S0 @ S0.T) / 3
        self.O0 = S0.T @ V0 / 3
        self.S1 = expm(self.X0) @ S0 @ expm(self.O0)
        self.X2 = -(V3 @ S3.T - S3 @ V3.T + 2 * S3 @ V3.T @ S3 @ S3.T) / 3
        self.O2 = -S3.T @ V3 / 3
        self.S2 = expm(self.X2) @ S3 @ expm(self.O2)
        self.X1 = log(reflection(self.S2) @ reflection(self.S1)) / 2
        self.O1 = log(self.S1.T @ expm(-self.X1) @ self.S2)

    def stages(self, t):
        """`X_3, Omega_3, X_4, Omega_4, X_5, Omega_5` at `t`; exponentials of `-X` are transposes."""
        S0, S1, S2, I = self.S0, self.S1, self.S2, np.eye(len(self.S0))  # noqa: E741
        e0, e1, e2 = expm(t * self.X0), expm(t * self.X1), expm(-t * self.X2)
        X3 = log((I - 2 * e1 @ S1 @ S1.T @ e1.T) @ (I - 2 * e0 @ S0 @ S0.T @ e0.T)) / 2
        O3 = log(expm(-t * self.O0) @ S0.T @ e0.T @ expm(-X3) @ e1 @ S1 @ expm(t * self.O1))
        X4 = log((I - 2 * e2 @ S2 @ S2.T @ e2.T) @ (I - 2 * e1 @ S1 @ S1.T @ e1.T)) / 2
        O4 = log(expm(-t * self.O1) @ S1.T @ e1.T @ expm(-X4) @ e2 @ S2 @ expm(-t * self.O2))
        e3, e4 = expm(t * X3), expm(t * X4)
        X5 = log((I - 2 * e4 @ e1 @ S1 @ S1.T @ e1.T @ e4.T) @ (I - 2 * e3 @ e0 @ S0 @ S0.T @ e0.T @ e3.T)) / 2
        left = expm(-t * O3) @ expm(-t * self.O0) @ S0.T @ e0.T @ e3.T
        O5 = log(left @ expm(-X5) @ e4 @ e1 @ S1 @ expm(t * self.O1) @ expm(t * O4))
        return X3, O3, X4, O4, X5, O5

    def __call__(self, t):
        X3, O3, _, _, X5, O5 = self.stages(t)
        left = expm(t * X5) @ expm(t * X3) @ expm(t * self.X0)
        return left @ self.S0 @ expm(t * self.O0) @ expm(t * O3) @ expm(t * O5)
