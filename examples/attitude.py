"""A satellite turns through keyframes: natural Riemannian spline, SciPy's RotationSpline, and slerp.

Rotations are points of St(3, 3). The natural spline has the least integral of the squared angular acceleration among
all curves near to it through the keyframes: the torque that a round body needs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, RotationSpline, Slerp

from figures import BLACK, BLUE, ORANGE, VERMILION, command_line, new_figure, save
from stiefel_rs import CubicSpline

Array = NDArray[np.float64]
TIMES = np.array([0.0, 8.0, 15.0, 25.0, 32.0, 40.0, 50.0])
# Yaw, pitch and roll in degrees.
ANGLES = np.array(
    [[0, 0, 0], [35, 20, 0], [80, 45, 30], [120, 10, 75], [170, -30, 60], [215, -40, 10], [270, 0, 0]], dtype=float
)
CURVES = {
    "natural Riemannian spline": {"color": BLUE, "linestyle": "-", "linewidth": 2.0},
    "SciPy RotationSpline": {"color": VERMILION, "linestyle": "--", "linewidth": 1.6},
    "slerp": {"color": BLACK, "linestyle": ":", "linewidth": 1.6},
}
GAUSS = 16


def angular(curve: CubicSpline, t: Array) -> tuple[Array, Array]:
    """Angular velocity and acceleration in the frame of space: of `R'` and of the covariant acceleration, at `R`."""
    R = np.swapaxes(curve(t), -1, -2)
    W = np.stack([curve.velocity(t) @ R, curve.acceleration(t) @ R])
    w, a = np.stack([W[..., 2, 1] - W[..., 1, 2], W[..., 0, 2] - W[..., 2, 0], W[..., 1, 0] - W[..., 0, 1]], -1) / 2
    return w, a


def cost_of(accelerations: Any, knots: Array) -> float:
    """Integral of the squared angular acceleration, by Gauss's rule between the knots."""
    x, w = np.polynomial.legendre.leggauss(GAUSS)
    h = np.diff(knots)[:, None]
    t = knots[:-1, None] + h * (x + 1) / 2
    squares = np.sum(accelerations(t.ravel()) ** 2, axis=1).reshape(t.shape)
    return float(np.sum(squares * w * h / 2))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Join keyframes of an attitude; compare angular velocity, angular acceleration and cost."""
    keyframes = Rotation.from_euler("ZYX", ANGLES, degrees=True)
    spline = CubicSpline(TIMES, keyframes.as_matrix())
    scipy, slerp = RotationSpline(TIMES, keyframes), Slerp(TIMES, keyframes)
    t = np.linspace(*spline.t_span, 101 if quick else 1001)
    ours, theirs = angular(spline, t), (scipy(t, 1), scipy(t, 2))
    # Slerp turns at a constant rate between the keyframes.
    rates = (keyframes[1:] * keyframes[:-1].inv()).as_rotvec() / np.diff(TIMES)[:, None]
    leg = np.clip(np.searchsorted(TIMES, t, side="right") - 1, 0, len(rates) - 1)
    numbers = {
        "cost": spline.cost(),
        "cost_rotation_spline": cost_of(lambda s: scipy(s, 2), TIMES),
        "cost_check": cost_of(lambda s: angular(spline, s)[1], TIMES),
        "largest_acceleration": float(np.degrees(np.linalg.norm(ours[1], axis=1).max())),
        "largest_acceleration_rotation_spline": float(np.degrees(np.linalg.norm(theirs[1], axis=1).max())),
        "jump_of_slerp_velocity": float(np.degrees(np.linalg.norm(np.diff(rates, axis=0), axis=1).max())),
        "end_acceleration": float(np.linalg.norm(ours[1][[0, -1]], axis=1).max()),
        "keyframe_error": float(np.abs(spline(TIMES) - keyframes.as_matrix()).max()),
        "farthest_apart": float(np.degrees((scipy(t).inv() * Rotation.from_matrix(spline(t))).magnitude().max())),
    }
    paths = [R[:, :, 0] for R in (spline(t), scipy(t).as_matrix(), slerp(t).as_matrix())]
    turning = [ours[0], theirs[0], rates[leg]], [ours[1], theirs[1]]
    draw(out, t, (paths, turning), keyframes.as_matrix()[:, :, 0], numbers)
    return numbers


def draw(out: Path, t: Array, curves: tuple[Any, Any], keyframes: Array, numbers: dict[str, Any]) -> None:
    """Where the body's first axis points, and lengths of angular velocity and acceleration."""
    figure = new_figure()
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.1])
    left = figure.add_subplot(grid[:, 0])
    paths, rates = curves
    for path, (name, style) in zip(paths, CURVES.items(), strict=True):
        left.plot(*sky(path), label=name, **style)
    left.plot(*sky(keyframes), "o", color=ORANGE, markeredgecolor=BLACK, label="keyframes", zorder=5)
    left.set(xlabel="azimuth of the body's first axis (degrees)", ylabel="its elevation (degrees)")
    left.legend(loc="upper left")
    upper = figure.add_subplot(grid[0, 1])
    lower = figure.add_subplot(grid[1, 1], sharex=upper)
    costs = (numbers["cost"], numbers["cost_rotation_spline"])
    for i, (name, style) in enumerate(CURVES.items()):
        upper.plot(t, np.degrees(np.linalg.norm(rates[0][i], axis=1)), **style)
        if i < 2:
            label = f"{name}: {1e3 * costs[i]:.2f}"
            lower.plot(t, np.degrees(np.linalg.norm(rates[1][i], axis=1)), label=label, **style)
    upper.set(ylabel="angular velocity\n(degrees/s)")
    upper.tick_params(labelbottom=False)
    lower.set(xlabel="time (s)", ylabel="angular acceleration\n(degrees/s²)", ylim=(0, 2.3))
    lower.set_title("in the legend: cost, the integral of its square, in 10⁻³ rad²/s³", fontsize=9)
    lower.legend(loc="upper center")
    for ax in (upper, lower):
        for time in TIMES:
            ax.axvline(time, color=ORANGE, linewidth=0.8, alpha=0.7)
    save(figure, out)


def sky(axis: Array) -> tuple[Array, Array]:
    """Azimuth, without jumps, and elevation in degrees."""
    azimuth = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    return np.degrees(azimuth), np.degrees(np.arcsin(np.clip(axis[:, 2], -1, 1)))


if __name__ == "__main__":
    command_line(main, "attitude")
