"""What the compiled `RotationCurve` does, from splines of matrices: for as long as that class is not there."""

from __future__ import annotations

import numpy as np

from stiefel_rs._core import CubicSpline
from stiefel_rs.errors import InvalidInputError
from stiefel_rs.rotation_input import matrices_of, quaternions_of, unit

# Points of a leg at which the sign of a quaternion is carried on.
FINE = 64


def hat(w):
    """The skew matrices with ``hat(w) x = w x x``."""
    out = np.zeros((*w.shape[:-1], 3, 3))
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = np.moveaxis(w, -1, 0)
    return out - np.swapaxes(out, -1, -2)


def vee(A):
    """The vectors of the skew parts of matrices."""
    A = (A - np.swapaxes(A, -1, -2)) / 2
    return np.stack([A[..., 2, 1], A[..., 0, 2], A[..., 1, 0]], axis=-1)


class RotationCurve:
    def __init__(
        self, t, quaternions, bc_type="natural", *, tol=1e-12, max_iterations=200, tension=0.0, num_threads=None
    ):
        q = unit(np.asarray(quaternions, float))
        R = matrices_of(q)
        options = {"tol": tol, "max_iterations": max_iterations, "tension": tension, "num_threads": num_threads}
        if not isinstance(bc_type, str):
            pairs = zip(bc_type, (R[0], R[-1]), strict=True)
            bc_type = tuple(end if isinstance(end, str) else (end[0], g @ hat(end[1])) for end, g in pairs)
        self._set(CubicSpline(t, R, bc_type, extrapolate=True, **options), q[0])

    def _set(self, curve, first):
        self.curve = curve
        edges = [np.linspace(a, b, FINE, endpoint=False) for a, b in zip(curve.t, curve.t[1:], strict=False)]
        self._grid = np.concatenate([*edges, curve.t[-1:]])
        self._signed = carried(quaternions_of(curve(self._grid)), first)

    @staticmethod
    def of_curve(curve):
        if (curve.n, curve.k) != (3, 3) or getattr(curve, "kind", "") != "riemannian":
            raise InvalidInputError(f"curve: expected Riemannian cubics on St(3, 3), found {curve!r}")
        if np.linalg.det(curve.points[0]) < 0:
            raise InvalidInputError("curve: expected rotations, found determinant -1")
        made = RotationCurve.__new__(RotationCurve)
        made._set(curve, quaternions_of(curve.points[:1])[0])
        return made

    @staticmethod
    def batch(t, quaternions, bc_type="natural", **options):
        times = np.broadcast_to(t, np.shape(quaternions)[:-1])
        return [RotationCurve(a, q, bc_type, **options) for a, q in zip(times, quaternions, strict=True)]

    @property
    def t(self):
        return self.curve.t

    @property
    def report(self):
        return self.curve.report

    def _references(self, t):
        """Quaternions near those at `t`, with the right sign."""
        near = self._signed[np.clip(np.searchsorted(self._grid, t), 0, len(self._grid) - 1)]
        legs = np.diff(self.t)
        for at, (beyond, start) in enumerate([(t < self.t[0], 0), (t > self.t[-1], -1)]):
            for i in np.flatnonzero(beyond):
                count = 2 + int(FINE * abs(t[i] - self.t[start]) / legs[-at])
                fine = np.linspace(self.t[start], t[i], count)
                near[i] = carried(quaternions_of(self.curve(fine)), self._signed[start])[-1]
        return near

    def quaternions(self, t):
        q = quaternions_of(self.curve(t))
        return q * np.where(np.sum(q * self._references(t), axis=-1, keepdims=True) < 0, -1.0, 1.0)

    def rates(self, t, order):
        Rt = np.swapaxes(self.curve(t), -1, -2)
        if order == 1:
            return vee(Rt @ self.curve.velocity(t))
        if order == 2:
            return vee(Rt @ self.curve.acceleration(t))
        w, a = self.rates(t, 1), self.rates(t, 2)
        return vee(Rt @ self.curve.jerk(t)) - np.cross(w, a) / 2


def carried(q, first):
    """Quaternions whose sign follows that of `first` from one to the next."""
    dots = np.sum(np.concatenate([[first], q[:-1]]) * q, axis=-1)
    return q * np.cumprod(np.where(dots < 0, -1.0, 1.0))[:, None]
