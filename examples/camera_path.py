"""A camera moved by hand: keyframes of a recorded path interpolated, noisy poses smoothed, against the poses left out.

Ten seconds recorded at 100 Hz by motion capture; see data/README.md for source and licence.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_interp_spline, make_smoothing_spline
from scipy.spatial import transform
from scipy.spatial.transform import Rotation, Slerp

from figures import command_line, new_figure, save
from stiefel_rs import PoseSpline, read_tum
from stiefel_rs.palette import BLUE, GREEN, INK, ORANGE, VERMILION

Array = NDArray[np.float64]
Poses = tuple[Rotation, Array]
Curve = Callable[[Array], Poses]
PATH: Final = Path(__file__).resolve().parent / "data" / "freiburg1_xyz.tum"
# Keyframes are every m-th pose.
EVERY: Final = (2, 4, 10, 20, 50, 100)
# Where errors of the poses are as large as those of the curves.
NOISY: Final = (2, 4)
RATE: Final = 100
OURS, SCIPY, SLERP, B_SPLINE, SMOOTHED, COMPONENTS = (
    "PoseSpline", "SciPy RotationSpline, CubicSpline", "slerp and straight lines", "B-spline of quaternions",
    "PoseSpline.smoothing", "smoothing splines of quaternions",
)  # fmt: skip
STYLES: Final[dict[str, dict[str, Any]]] = {
    OURS: {"color": BLUE, "linestyle": "-", "marker": "o"},
    SCIPY: {"color": VERMILION, "linestyle": "--", "marker": "x"},
    B_SPLINE: {"color": GREEN, "linestyle": "-.", "marker": "+"},
    SLERP: {"color": INK, "linestyle": ":", "marker": "s", "markersize": 4},
}


def from_seven(values: Array) -> Poses:
    """Poses from quaternions that need not have length 1, and positions."""
    return Rotation.from_quat(values[:, :4]), values[:, 4:]


def curves(t: Array, poses: Poses, *, noisy: bool) -> dict[str, Curve]:
    """All curves through keyframes and, if they are noisy, near them."""
    rotations, positions = poses
    quaternions = rotations.as_quat()
    signs = np.cumprod(np.r_[1, np.sign(np.sum(quaternions[1:] * quaternions[:-1], axis=1))])
    seven = np.hstack([signs[:, None] * quaternions, positions])
    spline, scipy, slerp = PoseSpline(t, poses), transform.RotationSpline(t, rotations), Slerp(t, rotations)
    cubic, components = CubicSpline(t, positions), make_interp_spline(t, seven)
    found: dict[str, Curve] = {
        OURS: spline,
        SCIPY: lambda s: (scipy(s), cubic(s)),
        B_SPLINE: lambda s: from_seven(components(s)),
        SLERP: lambda s: (slerp(s), np.stack([np.interp(s, t, x) for x in positions.T], axis=-1)),
    }
    if noisy:
        each = [make_smoothing_spline(t, column) for column in seven.T]
        found[SMOOTHED] = PoseSpline.smoothing(t, poses)
        found[COMPONENTS] = lambda s: from_seven(np.stack([curve(s) for curve in each], axis=-1))
    return found


def errors(found: Poses, poses: Poses) -> tuple[float, float]:
    """Roots of the mean squared errors of rotations, in degrees, and of positions, in mm."""
    angles = np.degrees((found[0].inv() * poses[0]).magnitude())
    distances = 1e3 * np.linalg.norm(found[1] - poses[1], axis=1)
    return float(np.sqrt(np.mean(angles**2))), float(np.sqrt(np.mean(distances**2)))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Interpolate and smooth every m-th pose of a camera; compare with the poses in between."""
    stamps, (quaternions, positions) = read_tum(PATH)
    t, rotations = stamps - stamps[0], Rotation.from_quat(quaternions)
    table: dict[int, dict[str, tuple[float, float]]] = {}
    for m in EVERY[::3] if quick else EVERY:
        kept = np.arange(0, len(t), m)
        between = np.setdiff1d(np.arange(kept[-1]), kept)
        found = curves(t[kept], (rotations[kept], positions[kept]), noisy=m in NOISY)
        truth = rotations[between], positions[between]
        table[m] = {name: errors(curve(t[between]), truth) for name, curve in found.items()}
        if m == NOISY[0]:
            near = found
    dense = np.linspace(0, t[-2], 10 * len(t))
    numbers = {
        "poses": len(t),
        "seconds": float(t[-1]),
        "errors": {str(m): row for m, row in table.items()},
        "accelerations": {name: accelerations(near[name], dense) for name in (OURS, SMOOTHED)},
    }
    draw(out, table, near)
    return numbers


def accelerations(curve: Any, t: Array) -> tuple[float, float]:
    """Roots of the mean squared accelerations, angular in degrees/s² and linear in m/s²."""
    angular, linear = curve.angular_acceleration(t), curve.linear_acceleration(t)
    size = [np.sqrt(np.mean(np.sum(vectors**2, axis=1))) for vectors in (angular, linear)]
    return float(np.degrees(size[0])), float(size[1])


def draw(out: Path, table: dict[int, Any], near: dict[str, Any]) -> None:
    """Errors relative to ours against the time between keyframes, and angular velocities through and near the noise."""
    figure = new_figure(3.3)
    axes = figure.subplots(1, 3, width_ratios=[1, 1, 1.2])
    times = np.array(list(table)) / RATE
    for i, (ax, name) in enumerate(zip(axes[:2], ("rotation", "position"), strict=True)):
        for label, style in STYLES.items():
            ax.plot(times, [row[label][i] / row[OURS][i] for row in table.values()], label=label, **style)
        ax.set(xscale="log", xlabel="time between keyframes (s)", title=f"error of the {name}")
        ax.set_xticks(times, [f"{time:g}" for time in times])
        ax.minorticks_off()
    axes[0].set_ylabel("error / error of PoseSpline")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, columnspacing=1)
    t = np.linspace(4, 5, 500)
    for label, color, width in ((OURS, BLUE, 0.9), (SMOOTHED, ORANGE, 2.0)):
        rate = np.degrees(near[label].angular_velocity(t)[:, 0])
        axes[2].plot(t, rate, color=color, linewidth=width, label=label)
    axes[2].set(xlabel="time (s)", ylabel="body rate, first axis (degrees/s)")
    figure.legend(*axes[2].get_legend_handles_labels(), loc="outside upper right")
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "camera_path")
