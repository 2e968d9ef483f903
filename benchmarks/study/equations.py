"""The equations of Riemannian cubics as a first-order system, for integrators that know nothing of the manifold.

With the frame ``[s, e]``, orthogonal of size n, and blocks of the velocity ``x = [[w, -b^T], [b, 0]]``::

    s' = s w + e b,  e' = -s b^T,  w'' = K - (N - N^T),  K' = w'' w - (w'' w)^T,
    b''' = b'' w + b (N - w'') - b' P,  N = b'^T b,  P = b^T b

No unknown is kept twice: of the skew blocks only what is below the diagonal.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.problems import Array
from benchmarks.study.cases import Data

# Numbers, or heyoka expressions.
Block = NDArray[Any]

# Number of variables up to which heyoka compiles straight-line code.
STRAIGHT_LINE = 50


class FirstOrder:
    """The system for one size: packing, right-hand side, initial values."""

    def __init__(self, n: int, k: int) -> None:
        self.n, self.k, self.m = n, k, n - k
        self.lower = np.tril_indices(k, -1)
        sizes = [n * k, n * self.m, *[len(self.lower[0])] * 3, *[self.m * k] * 3]
        self.cuts = np.cumsum(sizes)[:-1]
        self.size = sum(sizes)

    def pack(self, *blocks: Block) -> Block:
        """One vector of ``s, e, w, w', K, b, b', b''``."""
        s, e, *skew = blocks[:5]
        return np.concatenate([s.ravel(), e.ravel(), *(a[self.lower] for a in skew), *(b.ravel() for b in blocks[5:])])

    def unpack(self, y: Block) -> tuple[Block, ...]:
        """The blocks of a vector."""
        s, e, *rest = np.split(y, self.cuts)
        skew = []
        for values in rest[:3]:
            a = np.zeros((self.k, self.k), dtype=y.dtype)
            a[self.lower] = values
            skew.append(a - a.T)
        tall = (b.reshape(self.m, self.k) for b in rest[3:])
        return s.reshape(self.n, self.k), e.reshape(self.n, self.m), *skew, *tall

    def derivative(self, y: Block) -> Block:
        """Right-hand side."""
        s, e, w, w1, K, b, b1, b2 = self.unpack(y)
        N = b1.T @ b
        w2 = K - (N - N.T)
        Kw = w2 @ w
        b3 = b2 @ w + b @ (N - w2) - b1 @ (b.T @ b)
        return self.pack(s @ w + e @ b, -s @ b.T, w1, w2, Kw - Kw.T, b1, b2, b3)

    def initial(self, data: Data) -> Array:
        """Start from covariant data."""
        S, V, A, J = data
        e = np.linalg.qr(np.hstack([S, np.eye(self.n)]))[0][:, self.k :]
        (w, b), (w1, b1), (w2, b2) = ((S.T @ Z, e.T @ Z) for Z in (V, A, J))
        # J is x'' + [x, x'] / 2, without the part that only rotates the complement.
        w2 = w2 - (w @ w1 - w1 @ w - b.T @ b1 + b1.T @ b) / 2
        b2 = b2 - (b @ w1 - b1 @ w) / 2
        N = b1.T @ b
        return np.asarray(self.pack(S, e, w, w1, w2 + N - N.T, b, b1, b2))

    def point(self, y: Array) -> Array:
        """Point of the manifold in a vector."""
        return y[: self.n * self.k].reshape(self.n, self.k)


def dop853(system: FirstOrder, y0: Array, rtol: float) -> Callable[[], Array]:
    """SciPy's method of order 8 from 0 to 1."""

    def solve() -> Array:
        result = solve_ivp(
            lambda _t, y: system.derivative(y), (0.0, 1.0), y0, "DOP853", rtol=rtol, atol=rtol, t_eval=(1.0,)
        )
        return system.point(result.y[:, -1])

    return solve


def heyoka(system: FirstOrder, y0: Array, tol: float) -> Callable[[], Array]:
    """Taylor method of heyoka from 0 to 1, compiled here.

    Raises
    ------
    ImportError
        If heyoka is not installed.
    """
    hy = import_module("heyoka")

    # An integrator cached on disk or in memory would make the compilation time meaningless.
    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()
    names = [f"y{i}" for i in range(system.size)]
    variables = hy.make_vars(*names)
    right = system.derivative(np.array(variables, dtype=object))
    pairs = [
        (v, f if isinstance(f, hy.expression) else hy.expression(float(f)))
        for v, f in zip(variables, right, strict=True)
    ]
    # Straight-line code runs faster but takes longer to compile.
    integrator = hy.taylor_adaptive(pairs, y0.tolist(), tol=tol, compact_mode=system.size > STRAIGHT_LINE)

    def solve() -> Array:
        integrator.time = 0.0
        integrator.state[:] = y0
        integrator.propagate_until(1.0)
        return system.point(np.array(integrator.state))

    return solve
