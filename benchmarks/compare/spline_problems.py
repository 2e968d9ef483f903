"""Points to interpolate: keyframes of a rotation, samples of a known curve, long random walks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.problems import Array, Field, Frames, adjoint, geodesic_end, point, tangent

KEYFRAMES = (4, 10, 50, 200)
# Number of keyframes of the spline whose evaluation is timed.
EVALUATED = 50
EVALUATIONS = 1001
LONG = 10_000
TALL = (1000, 5, 100)
SUBSPACES = (2000, 6, 12)
SAMPLED = (5, 2, 7)
# For the known curve: the ends of the interval in the paper's section 5.2, and the times at which errors are measured.
INTERVAL = 1.1
CHECKS = 101


@dataclass(frozen=True)
class Knots:
    """Times and points `(N, n, k)`; velocities if they are known, quaternions of rotations with the scalar first."""

    t: Array
    S: Frames
    V: Frames | None = None
    quaternions: Array | None = None


def evaluations(t: Array) -> Array:
    """Times at which a spline is evaluated, including both ends."""
    return np.linspace(t[0], t[-1], EVALUATIONS)


def keyframes(count: int) -> Knots:
    """Rotations, each 0.3 to 1.2 rad from the previous one about a new axis, 0.5 to 1.5 s later; on St(3, 3)."""
    rng = np.random.default_rng([20240419, 13, count])
    axes = rng.standard_normal((count - 1, 3))
    half = rng.uniform(0.3, 1.2, count - 1) / 2
    axes *= (np.sin(half) / np.linalg.norm(axes, axis=1))[:, None]
    q = np.zeros((count, 4))
    q[0, 0] = 1
    for i, (w, v) in enumerate(zip(np.cos(half), axes, strict=True)):
        a, b = q[i, 0], q[i, 1:]
        q[i + 1] = np.concatenate([[a * w - b @ v], a * v + w * b + np.cross(b, v)])
        q[i + 1] /= np.linalg.norm(q[i + 1])
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, count - 1))])
    return Knots(t, rotations(q), quaternions=q)


def rotations(q: Array) -> Array:
    """Matrices `(N, 3, 3)` of unit quaternions `(N, 4)`, the scalar first."""
    w, x, y, z = np.moveaxis(np.asarray(q), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def walk(n: int, k: int, count: int, field: Field = "real") -> Knots:
    """Points of St(n, k), each at canonical distance 0.5 from the previous one; times 0, 1 and so on."""
    points = [point(n, k, 14, field=field)]
    for i in range(count - 1):
        points.append(_orthonormal(geodesic_end(points[-1], tangent(points[-1], 0.5, 15 + i))))
    return Knots(np.arange(count, dtype=np.float64), np.stack(points))


def _orthonormal(S: Frames) -> Frames:
    """Orthonormal columns that differ from those of S by round-off; QR alone may change their signs or phases."""
    Q, R = np.linalg.qr(S)
    d = np.diagonal(R)
    return np.asarray(Q * (d / np.abs(d)))


def subspaces() -> tuple[Knots, Frames]:
    """Aligned bases of subspaces at distance 0.5 from their neighbours, and other bases of the same subspaces."""
    n, k, count = SUBSPACES
    bases = [point(n, k, 23)]
    for i in range(count - 1):
        Y, V = bases[-1], tangent(bases[-1], 1.0, 24 + i)
        V = V - Y @ (adjoint(Y) @ V)
        bases.append(_orthonormal(geodesic_end(Y, V * (0.5 / np.linalg.norm(V)))))
    knots = Knots(np.arange(count, dtype=np.float64), np.stack(bases))
    return knots, knots.S @ point(k, k, 23, (count,))


def factors(n: int, k: int, t: Array) -> tuple[Array, Array]:
    """Orthogonal factors of `Y0 + t Y1 + t^2 Y2 + t^3 Y3`, and their derivatives: the curve of the paper's section 5.2.

    Zimmermann (2020), "Hermite interpolation and data processing errors on Riemannian matrix manifolds"; the entries
    are uniform in [0, 1], [0, 1/2], [0, 1/2] and [0, 1/5]. The derivative is that of a QR factorisation whose `R` has
    a positive diagonal: `Q L + (I - Q Q^T) Y' R^{-1}`, `L` skew with the lower triangle of `Q^T Y' R^{-1}`.
    """
    rng = np.random.default_rng([20240419, 16, n, k])
    coefficients = [scale * rng.random((n, k)) for scale in (1.0, 0.5, 0.5, 0.2)]
    x = t[:, None, None]
    Y = sum(c * x**i for i, c in enumerate(coefficients))
    dY = sum(i * c * x ** (i - 1) for i, c in enumerate(coefficients) if i)
    Q, R = np.linalg.qr(Y)
    sign = np.sign(np.diagonal(R, axis1=-2, axis2=-1))
    Q, R = Q * sign[:, None, :], R * sign[:, :, None]
    W = np.swapaxes(np.linalg.solve(np.swapaxes(R, -2, -1), np.swapaxes(dY, -2, -1)), -2, -1)
    inner = np.swapaxes(Q, -2, -1) @ W
    low = np.tril(inner, -1)
    return Q, Q @ (low - np.swapaxes(low, -2, -1)) + W - Q @ inner


def sampled() -> Knots:
    """That curve on St(5, 2) at the 7 Chebyshev points of its interval."""
    n, k, count = SAMPLED
    t = -INTERVAL * np.cos((2 * np.arange(count) + 1) * np.pi / (2 * count))
    return Knots(t, *factors(n, k, t))


def checks() -> Array:
    """Times at which the interpolant is compared with that curve."""
    t = sampled().t
    return np.linspace(t[0], t[-1], CHECKS)
