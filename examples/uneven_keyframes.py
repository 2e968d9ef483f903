"""Keyframes at uneven times: a pan/tilt camera that turns far and fast, by RotationSpline and by SciPy's.

Both curves have a continuous angular acceleration. One makes the integral of its square stationary; the other makes the
rotation vector between keyframes a cubic polynomial of time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import transform
from scipy.spatial.transform import Rotation

from figures import command_line, keyframe_lines, new_figure, save
from stiefel_rs import ConvergenceError, RotationSpline
from stiefel_rs.palette import BLUE, INK, ORANGE, VERMILION

Array = NDArray[np.float64]
# The longest interval is ten times the shortest.
TIMES = np.array([0.0, 2.0, 2.5, 4.5, 4.8, 7.8])
# Pan and tilt in degrees.
ANGLES = np.array([[10, 20], [-120, -20], [-120, -10], [100, 40], [150, 40], [-70, -20]], dtype=float)
CURVES = {
    "stiefel_rs RotationSpline": {"color": BLUE, "linestyle": "-", "linewidth": 2.0},
    "SciPy RotationSpline": {"color": VERMILION, "linestyle": "--", "linewidth": 1.6},
}
GAUSS = 32
DENSE = 200


def rotations(angles: Array) -> Rotation:
    """Directions of the camera: pan about the vertical axis, then tilt."""
    return Rotation.from_euler("ZY", angles, degrees=True)


def turns(keyframes: Rotation) -> Array:
    """Angles between neighbours in degrees."""
    return np.asarray(np.degrees((keyframes[:-1].inv() * keyframes[1:]).magnitude()))


def cost_of(accelerations: Callable[[Array], Array], knots: Array) -> float:
    """Integral of the squared angular acceleration, by Gauss's rule between the knots."""
    x, w = np.polynomial.legendre.leggauss(GAUSS)
    h = np.diff(knots)[:, None]
    t = knots[:-1, None] + h * (x + 1) / 2
    squares = np.sum(accelerations(t.ravel()) ** 2, axis=1).reshape(t.shape)
    return float(np.sum(squares * w * h / 2))


def lengths(curve: Any, t: Array, order: int) -> Array:
    """Length of angular velocity (1) or acceleration (2) in degrees."""
    return np.asarray(np.degrees(np.linalg.norm(curve(t, order), axis=1)))


def dense(knots: Array) -> Array:
    """Times between all knots."""
    return np.unique(np.concatenate([np.linspace(*ends, DENSE) for ends in pairwise(knots)]))


def random_keyframes(rng: np.random.Generator) -> tuple[Array, Rotation]:
    """Four to six keyframes, short and long intervals in turn; the largest turn has 100 to 150 degrees."""
    while True:
        count = int(rng.integers(4, 7))
        short = np.arange(count - 1) % 2 == rng.integers(2)
        steps = np.where(short, rng.uniform(0.3, 0.5, count - 1), rng.uniform(2, 6, count - 1))
        angles = np.stack([rng.uniform(-150, 150, count), rng.uniform(-40, 40, count)], axis=-1)
        if 100 < turns(rotations(angles)).max() < 150:
            return np.r_[0, np.cumsum(steps)], rotations(angles)


def compare_many(number: int) -> dict[str, float]:
    """SciPy's cost and peak acceleration relative to ours, for random keyframes."""
    rng = np.random.default_rng(0)
    costs: list[float] = []
    peaks: list[float] = []
    for _ in range(number):
        knots, keyframes = random_keyframes(rng)
        theirs, t = transform.RotationSpline(knots, keyframes), dense(knots)
        try:
            ours = RotationSpline(knots, keyframes)
        except ConvergenceError:
            continue
        costs.append(cost_of(partial(theirs, order=2), knots) / ours.cost())
        peaks.append(lengths(theirs, t, 2).max() / lengths(ours, t, 2).max())
    found: dict[str, float] = {"many": number, "failed": number - len(costs)}
    for name, ratios in (("cost", costs), ("peak", peaks)):
        found |= {f"{name}_{q}": float(np.quantile(ratios, q / 100)) for q in (10, 50, 90)}
        found[f"{name}_lower"] = int(np.sum(np.less(ratios, 1)))
    return found


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Join uneven keyframes of a pan/tilt camera; compare angular velocity, angular acceleration and cost."""
    keyframes, t = rotations(ANGLES), dense(TIMES)
    ours, theirs = RotationSpline(TIMES, keyframes), transform.RotationSpline(TIMES, keyframes)
    # Ours with the angular velocities that SciPy's has at its ends.
    ends = RotationSpline(TIMES, keyframes, ((1, theirs(TIMES[0], 1)), (1, theirs(TIMES[-1], 1))))
    numbers = {
        "largest_turn": float(turns(keyframes).max()),
        "cost": ours.cost(),
        "cost_check": cost_of(partial(ours, order=2), TIMES),
        "cost_scipy": cost_of(partial(theirs, order=2), TIMES),
        "cost_same_ends": ends.cost(),
        "peak": float(lengths(ours, t, 2).max()),
        "peak_scipy": float(lengths(theirs, t, 2).max()),
        "peak_same_ends": float(lengths(ends, t, 2).max()),
        "peak_time_scipy": float(t[lengths(theirs, t, 2).argmax()]),
        "largest_rate": float(lengths(ours, t, 1).max()),
        "largest_rate_scipy": float(lengths(theirs, t, 1).max()),
        "largest_rotation_vector": float(np.degrees(np.linalg.norm(theirs.interpolator(t), axis=1).max())),
        "turned": float(np.degrees(ours.arc_length())),
        "least_turned": float(turns(keyframes).sum()),
    } | {f"random_{name}": value for name, value in compare_many(20 if quick else 1000).items()}
    draw(out, t, dict(zip(CURVES, (ours, theirs), strict=True)), numbers)
    return numbers


def draw(out: Path, t: Array, curves: dict[str, Any], numbers: dict[str, Any]) -> None:
    """Lengths of angular velocity and angular acceleration against time."""
    figure = new_figure(height=3.4)
    costs = numbers["cost"], numbers["cost_scipy"]
    axes = figure.subplots(1, 2)
    for order, ax in zip((1, 2), axes, strict=True):
        for (name, curve), cost in zip(curves.items(), costs, strict=True):
            ax.plot(t, lengths(curve, t, order), label=f"{name}: cost {cost:.1f} rad²/s³", **CURVES[name])
        keyframe_lines(ax, TIMES)
        marker = {"color": ORANGE, "markeredgecolor": INK, "clip_on": False, "zorder": 5}
        ax.plot(TIMES, np.zeros(len(TIMES)), "o", label="keyframes", **marker)
        ax.set(xlabel="time (s)", xlim=(TIMES[0], TIMES[-1] + 0.1))
        ax.set_ylim(bottom=0)
        ax.set(ylabel="angular velocity (degrees/s)" if order == 1 else "angular acceleration (degrees/s²)")
    peaks = (f"peak {numbers[name]:.0f} degrees/s²" for name in ("peak", "peak_scipy"))
    lines = axes[1].lines[: len(curves)]
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2}
    axes[1].legend(lines, peaks, columnspacing=1, handlelength=1.8, **place)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "uneven_keyframes")
