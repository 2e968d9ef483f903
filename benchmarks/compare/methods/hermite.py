"""Hermite interpolation on St(n, k) in tangent spaces: points and velocities in, a C1 curve out; NumPy and SciPy.

Zimmermann (2020), "Hermite interpolation and data processing errors on Riemannian matrix manifolds", SIAM J. Sci.
Comput. 42, A2593-A2619: between two knots the curve is `Exp_q(c(t))`, where `q` is the later knot and `c` the cubic of
its tangent space from `Log_q(p)` to 0 with the velocities `d Log_q(V_p)` and `V_q`; the first of these is a central
difference with step 1e-4 (eq. 25). The paper's code is a collection of scripts; this is the same method, with the
logarithm of `stiefel_log`.
"""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from benchmarks.compare.methods.stiefel_log import stiefel_log, symmetric_exp

Array = NDArray[np.float64]
STEP = 1e-4
LOG_TOLERANCE = 1e-11


def stiefel_exp(S: Array, V: Array) -> Array:
    """End of the canonical geodesic from S with velocity V."""
    k = S.shape[1]
    A = S.T @ V
    Q, R = np.linalg.qr(V - S @ A)
    generator = np.block([[(A - A.T) / 2, -R.T], [R, np.zeros((len(R), len(R)))]])
    return np.asarray(np.hstack([S, Q]) @ symmetric_exp(generator)[:, :k])


class TangentHermite:
    """The curve: prepared once, then evaluated at one time after another."""

    def __init__(self, t: Array, S: Array, V: Array) -> None:
        self.t, self.S, self.V = t.tolist(), S, V
        legs = range(len(t) - 1)
        self.displacements = [stiefel_log(S[i + 1], S[i], tolerance=LOG_TOLERANCE) for i in legs]
        self.carried = [self._carry(i) for i in legs]

    def _carry(self, leg: int) -> Array:
        """Derivative of `Log_q` along the velocity at the earlier knot."""
        p, q, v = self.S[leg], self.S[leg + 1], self.V[leg]
        ends = [stiefel_log(q, stiefel_exp(p, h * v), tolerance=LOG_TOLERANCE) for h in (STEP, -STEP)]
        return np.asarray((ends[0] - ends[1]) / (2 * STEP))

    def __call__(self, t: float) -> Array:
        """Point at a time between the first knot and the last."""
        leg = min(max(bisect_right(self.t, t) - 1, 0), len(self.t) - 2)
        h = self.t[leg + 1] - self.t[leg]
        x = (t - self.t[leg]) / h
        rest = 1 - x
        velocities = h * x * rest * (rest * self.carried[leg] - x * self.V[leg + 1])
        return stiefel_exp(self.S[leg + 1], (1 + 2 * x) * rest**2 * self.displacements[leg] + velocities)
