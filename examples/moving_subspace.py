"""Noisy sensors whose signals stay near a plane that moves: the plane as a point of St(24, 2), smoothed.

Every window of measurements gives the plane of its two largest principal components. A short window is noisy, a long
one lags behind. The smoothing spline takes short windows and decides by cross-validation how much to believe them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from figures import command_line, nearest_turn, new_figure, save
from stiefel_rs import SmoothingSpline, Stiefel, skew_exp
from stiefel_rs.palette import BLUE, GREEN, INK, SKY, VERMILION

Array = NDArray[np.float64]
SEED = 7
SENSORS, DIMENSION = 24, 2
DURATION = 60.0
RATE = 25
NOISE = 0.2
WINDOW = 1.0
LONGER = (1, 3, 5, 7, 9, 13, 17)


def truth(t: Array, rng: np.random.Generator) -> Array:
    """Orthonormal bases of the plane, (T, 24, 2): two rotations, one after the other, at rates that change."""
    S = Stiefel(SENSORS, DIMENSION).random_point(rng=rng)
    A, B = (W - W.T for W in rng.standard_normal((2, SENSORS, SENSORS)) / SENSORS)
    x = (t / DURATION)[:, None, None]
    return skew_exp(4 * np.sin(2 * np.pi * x) * A) @ (skew_exp(3 * x * x * B) @ S)


def measurements(t: Array, U: Array, rng: np.random.Generator) -> Array:
    """Sensor readings: two oscillations in the plane, and noise everywhere."""
    signal = np.stack([np.sin(2 * np.pi * 1.3 * t), np.cos(2 * np.pi * 2.1 * t)], axis=1) * np.sqrt(2)
    return np.einsum("tnk,tk->tn", U, signal) + NOISE * rng.standard_normal((len(t), SENSORS))


def planes(windows: Array, length: int) -> Array:
    """Principal planes of so many windows around each; bases turned to be near to those before."""
    found: list[Array] = []
    for i in range(len(windows)):
        near = windows[max(0, i - length // 2) : i + length // 2 + 1].reshape(-1, SENSORS)
        U = np.linalg.svd(near, full_matrices=False)[2][:DIMENSION].T
        found.append(U @ nearest_turn(U, found[-1]) if found else U)
    return np.stack(found)


def angles(U: Array, W: Array) -> Array:
    """Largest angle between the planes, in degrees."""
    # By its sine: exact for small angles too.
    sine = np.linalg.norm(W - U @ (np.swapaxes(U, -1, -2) @ W), ord=2, axis=(-2, -1))
    return np.degrees(np.arcsin(np.minimum(sine, 1.0)))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Follow a moving plane from noisy windows of data."""
    rng = np.random.default_rng(SEED)
    duration = DURATION / 2 if quick else DURATION
    t = (np.arange(int(duration * RATE)) + 0.5) / RATE
    windows = measurements(t, truth(t, rng), rng).reshape(-1, int(WINDOW * RATE), SENSORS)
    middle = (np.arange(len(windows)) + 0.5) * WINDOW
    exact = truth(middle, np.random.default_rng(SEED))
    found = {length: planes(windows, length) for length in LONGER}
    curve = SmoothingSpline(middle, found[1])
    errors = {length: angles(exact, each) for length, each in found.items()}
    smoothed = angles(exact, curve(middle))
    rms = {length: float(np.sqrt(np.mean(error**2))) for length, error in errors.items()}
    best = min(rms, key=lambda length: rms[length])
    numbers = {
        "lambda": curve.lam,
        "rms_one_window": rms[1],
        "best_length": best,
        "rms_best_length": rms[best],
        "rms_smoothed": float(np.sqrt(np.mean(smoothed**2))),
        "turned": float(angles(exact[:1], exact).max()),
    }
    dense = np.linspace(*curve.t_span, 401)
    near = curve(middle)
    entries = (exact @ nearest_turn(exact, near), found[1] @ nearest_turn(found[1], near), curve(dense))
    draw(out, (middle, dense), entries, [errors[1], errors[best], smoothed], numbers)
    return numbers


def draw(out: Path, times: tuple[Array, Array], entries: Any, errors: list[Array], numbers: dict[str, Any]) -> None:
    """Some entries of the basis, and the angle to the true plane."""
    figure = new_figure(3.6)
    grid = figure.add_gridspec(1, 2)
    left, right = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
    middle, dense = times
    exact, noisy, smooth = entries
    shown = np.argsort(-np.ptp(exact[:, :, 0], axis=0))[:3]
    for i, (sensor, colour) in enumerate(zip(shown, (BLUE, VERMILION, GREEN), strict=True)):
        left.plot(middle, noisy[:, sensor, 0], ".", color=colour, markersize=4, alpha=0.6)
        left.plot(middle, exact[:, sensor, 0], "--", color=INK, linewidth=1, label=None if i else "truth")
        left.plot(dense, smooth[:, sensor, 0], color=colour, label=f"sensor {sensor}")
    left.set(xlabel="time (s)", ylabel="entry of the plane's first basis vector\n(dots: windows, lines: spline)")
    left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    labels = (
        f"windows of {WINDOW:g} s: rms {numbers['rms_one_window']:.1f}°",
        f"best longer windows, {numbers['best_length']} s: rms {numbers['rms_best_length']:.1f}°",
        f"smoothing spline: rms {numbers['rms_smoothed']:.1f}°",
    )
    styles = ({"color": SKY, "linestyle": ":"}, {"color": VERMILION, "linestyle": "--"}, {"color": BLUE})
    for error, label, style in zip(errors, labels, styles, strict=True):
        right.plot(middle, error, label=label, **style)
    right.set(xlabel="time (s)", ylabel="angle to the true plane (degrees)", ylim=(0, None))
    right.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0))
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "moving_subspace")
