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

from figures import command_line, draw_triads, keyframe_lines, new_figure, save
from stiefel_rs import CubicSpline
from stiefel_rs.palette import BLUE, INK, ORANGE, VERMILION

Array = NDArray[np.float64]
# Two pairs of targets, 12 s apart, and slews of more than a minute. Yaw, pitch and roll in degrees.
TIMES = np.array([0.0, 60.0, 72.0, 140.0, 152.0, 230.0])
ANGLES = np.array([[0, 0, 0], [110, -15, 5], [140, -45, -35], [230, 35, -45], [255, 45, 35], [375, 0, 0]], dtype=float)
# Keyframes at nearly even times, without large turns.
EVEN_TIMES = np.array([0.0, 8.0, 15.0, 25.0, 32.0, 40.0, 50.0])
EVEN_ANGLES = np.array(
    [[0, 0, 0], [35, 20, 0], [80, 45, 30], [120, 10, 75], [170, -30, 60], [215, -40, 10], [270, 0, 0]], dtype=float
)
CURVES = {
    "natural Riemannian spline": {"color": BLUE, "linestyle": "-", "linewidth": 2.0},
    "SciPy RotationSpline": {"color": VERMILION, "linestyle": "--", "linewidth": 1.6},
    "slerp": {"color": INK, "linestyle": ":", "linewidth": 1.4},
}
TRIADS = 16
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


def apart(spline: CubicSpline, scipy: RotationSpline, t: Array) -> float:
    """Largest angle between two curves in degrees."""
    return float(np.degrees((scipy(t).inv() * Rotation.from_matrix(spline(t))).magnitude().max()))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Join keyframes of an attitude; compare angular velocity, angular acceleration and cost."""
    keyframes = Rotation.from_euler("ZYX", ANGLES, degrees=True)
    spline = CubicSpline(TIMES, keyframes.as_matrix())
    scipy, slerp = RotationSpline(TIMES, keyframes), Slerp(TIMES, keyframes)
    t = np.linspace(*spline.t_span, 101 if quick else 601)
    ours, theirs = angular(spline, t), (scipy(t, 1), scipy(t, 2))
    # Slerp turns at a constant rate between the keyframes.
    legs = (keyframes[1:] * keyframes[:-1].inv()).as_rotvec()
    rates = legs / np.diff(TIMES)[:, None]
    leg = np.clip(np.searchsorted(TIMES, t, side="right") - 1, 0, len(rates) - 1)
    even = Rotation.from_euler("ZYX", EVEN_ANGLES, degrees=True)
    even_spline, even_scipy = CubicSpline(EVEN_TIMES, even.as_matrix()), RotationSpline(EVEN_TIMES, even)
    numbers = {
        "largest_turn": float(np.degrees(np.linalg.norm(legs, axis=1).max())),
        "cost": spline.cost(),
        "cost_rotation_spline": cost_of(lambda s: scipy(s, 2), TIMES),
        "cost_check": cost_of(lambda s: angular(spline, s)[1], TIMES),
        "largest_acceleration": float(np.degrees(np.linalg.norm(ours[1], axis=1).max())),
        "largest_acceleration_rotation_spline": float(np.degrees(np.linalg.norm(theirs[1], axis=1).max())),
        "jump_of_slerp_velocity": float(np.degrees(np.linalg.norm(np.diff(rates, axis=0), axis=1).max())),
        "end_acceleration": float(np.linalg.norm(ours[1][[0, -1]], axis=1).max()),
        "keyframe_error": float(np.abs(spline(TIMES) - keyframes.as_matrix()).max()),
        "farthest_apart": apart(spline, scipy, t),
        "even_apart": apart(even_spline, even_scipy, np.linspace(*even_spline.t_span, 601)),
        "even_cost": even_spline.cost(),
        "even_cost_rotation_spline": cost_of(lambda s: even_scipy(s, 2), EVEN_TIMES),
    }
    turning = [ours[0], theirs[0], rates[leg]], [ours[1], theirs[1]]
    curves = [spline(t), scipy(t).as_matrix(), slerp(t).as_matrix()]
    draw(out, t, (curves, turning), keyframes.as_matrix()[:, :, 0])
    return numbers


def draw(out: Path, t: Array, curves: tuple[Any, Any], keyframes: Array) -> None:
    """Where the body's first axis points, lengths of angular velocity and acceleration, and the axes of the body."""
    figure = new_figure(5.4)
    grid = figure.add_gridspec(3, 2, width_ratios=[1, 1.1], height_ratios=[1, 1, 0.85])
    left, upper = figure.add_subplot(grid[:2, 0]), figure.add_subplot(grid[0, 1])
    lower = figure.add_subplot(grid[1, 1], sharex=upper)
    matrices, rates = curves
    for i, (R, (name, style)) in enumerate(zip(matrices, CURVES.items(), strict=True)):
        left.plot(*sky(R[:, :, 0]), label=name, **style)
        upper.plot(t, np.degrees(np.linalg.norm(rates[0][i], axis=1)), **style)
        if i < 2:
            lower.plot(t, np.degrees(np.linalg.norm(rates[1][i], axis=1)), **style)
    left.plot(*sky(keyframes), "o", color=ORANGE, markeredgecolor=INK, label="keyframes", zorder=5)
    left.set(xlabel="azimuth of the body's first axis (degrees)", ylabel="its elevation (degrees)")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    upper.set_ylabel("angular velocity\n(degrees/s)")
    upper.tick_params(labelbottom=False)
    lower.set(ylabel="angular acceleration\n(degrees/s²)", xlabel="time (s)")
    rows = figure.add_subplot(grid[2, :])
    shown = np.linspace(0, len(t) - 1, TRIADS).astype(int)
    for height, R in zip((1, 0), matrices[:2], strict=True):
        draw_triads(rows, np.column_stack([t[shown], np.full(TRIADS, height)]), R[shown], 0.2)
    rows.set(xlabel="time (s); axes of the body: first red, second green, third blue", ylim=(-0.6, 1.6))
    rows.set_yticks([1, 0], ["natural\nspline", "SciPy"])
    rows.grid(visible=False)
    for ax in (upper, lower, rows):
        ax.set_xlim(t[0] - 6, t[-1] + 6)
        keyframe_lines(ax, TIMES)
    save(figure, out)


def sky(axis: Array) -> tuple[Array, Array]:
    """Azimuth, without jumps, and elevation in degrees."""
    azimuth = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    return np.degrees(azimuth), np.degrees(np.arcsin(np.clip(axis[:, 2], -1, 1)))


if __name__ == "__main__":
    command_line(main, "attitude")
