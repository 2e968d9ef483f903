"""Splines of rotations and poses, evaluated: name -> function of a `Draw` that returns (callable, arguments)."""

import numpy as np

from stiefel_rs import CubicSpline, PoseSpline, RotationSpline

from .arguments import some, spline_options, tension, threads

RATES = ["angular_velocity", "angular_acceleration", "angular_jerk"]
FRAMES = ["body", "world"]


def walk(d):
    """Times and quaternions a random angle apart, of any length; sometimes with a leading axis."""
    count, lead = d.of([2, 3, 6]), d.of([(), (), (2,)])
    t = np.cumsum(d.rng.uniform(0.2, 1.5, count)) + d.of([0.0, -3.0, 1e9])
    q = np.empty((*lead, count, 4))
    q[..., 0, :] = d.rng.standard_normal((*lead, 4))
    for i in range(1, count):
        q[..., i, :] = q[..., i - 1, :] + d.of([0.0, 0.2, 1.0]) * d.rng.standard_normal((*lead, 4))
    return t, q * d.of([1.0, 1.0, 1e-3, 1e200])


def end(d):
    return d.of(["natural", "clamped", (1, d.small(3)), (2, d.small(3))])


def options(d):
    ends = {"bc_type": lambda: d.of([d.word(["natural", "clamped"]), (end(d), end(d))])}
    return {**spline_options(d), **some(d, {**ends, **tension(d)})}


def matrices(q):
    """Rotation matrices of quaternions, scalar last."""
    x, y, z, w = np.moveaxis(q / np.abs(q).max(axis=-1, keepdims=True), -1, 0)
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), w * w - x * x + y * y - z * z, 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1)) / (x * x + y * y + z * z + w * w)[..., None, None]


def evaluated(make, methods):
    """Build a spline and evaluate it between its ends and beyond."""

    def call(*arguments, at=(0.0, 0.4, 1.0, 1.1), frame="body", **keywords):
        spline = make(*arguments, **keywords)
        first, last = np.max(spline.t_span[0]), np.min(spline.t_span[1])
        t = first + (last - first) * np.clip(np.asarray(at, float), 0, None if spline.extrapolate else 1)
        return spline, spline(t), *(getattr(spline, name)(t, frame=frame) for name in methods)

    return call


def rotations(d):
    t, q = walk(d)
    given = d.of([q, matrices(q)])
    return evaluated(RotationSpline, RATES), [t, given], {**options(d), **some(d, {"frame": lambda: d.word(FRAMES)})}


def from_curve(d):
    t, q = walk(d)
    curve = CubicSpline(t, matrices(q if q.ndim == 2 else q[0]))
    return evaluated(RotationSpline.from_curve, RATES), [curve], some(d, {"kind": lambda: d.word(["matrices"])})


def smoothing(d):
    t, q = walk(d)
    lam = {"lam": lambda: d.number([0.1, 1.0, 0.0]), "weights": lambda: d.rng.uniform(0.1, 2, len(t))}
    return evaluated(RotationSpline.smoothing, RATES), [t, q], some(d, {**lam, **threads(d)})


def hermite(d):
    t, q = walk(d)
    rates = d.rng.standard_normal((*q.shape[:-1], 3))
    return evaluated(RotationSpline.hermite, RATES), [t, q, rates], some(d, {"frame": lambda: d.word(FRAMES)})


def poses(d):
    t, q = walk(d)
    q = q if q.ndim == 2 else q[0]
    p = d.rng.standard_normal((len(t), 3)) * d.of([1.0, 1e-6, 1e6])
    if d.chance(0.5):
        return t, (q, p)
    T = np.zeros((len(t), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = matrices(q), p, 1
    return t, T


def pose(d):
    methods = [*RATES, "linear_velocity", "linear_acceleration", "linear_jerk", "twist"]
    ends = {"bc_type": lambda: d.word(["natural", "clamped"]), "frame": lambda: d.word(FRAMES)}
    return evaluated(PoseSpline, methods), list(poses(d)), some(d, {**ends, "extrapolate": lambda: d.chance(0.5)})


def pose_smoothing(d):
    return evaluated(PoseSpline.smoothing, ["twist"]), list(poses(d)), some(d, {"lam": lambda: d.number([0.1, 1.0])})


ROTATIONS = {
    "RotationSpline": rotations,
    "RotationSpline.from_curve": from_curve,
    "RotationSpline.smoothing": smoothing,
    "RotationSpline.hermite": hermite,
    "PoseSpline": pose,
    "PoseSpline.smoothing": pose_smoothing,
}
