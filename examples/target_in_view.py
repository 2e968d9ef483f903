"""A camera flies past a target: keyframes optimised by gradient, so that it turns gently and keeps the target in view.

Pointing exactly at the target takes large angular accelerations where the camera passes it. The target may be a few
degrees off the middle of the picture; the keyframes of a RotationSpline are moved until the integral of the squared
angular acceleration is least. Derivatives of the spline by its keyframes come from stiefel_rs.jax.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from figures import command_line, new_figure, save
from stiefel_rs import RotationSpline
from stiefel_rs.jax import rotation_spline
from stiefel_rs.palette import BLUE, ORANGE, VERMILION

Array = NDArray[np.float64]
# In s and m: along a straight line, past a target that is 6 m off it, 4 m lower.
DURATION, SPEED, TARGET = 8.0, 6.0, np.array([0.0, 6.0, -4.0])
KEYFRAMES, TIMES = 13, 241
# The target may be so many degrees off the middle of the picture; what is beyond is weighed so much, in rad^2/s^4 per
# squared rad.
ALLOWED, WEIGHT = 8.0, 1e4
STYLES = {
    "keyframes point at the target": {"color": VERMILION, "linestyle": "--"},
    "keyframes optimised": {"color": BLUE, "linestyle": "-"},
}


def positions(t: Array) -> Array:
    """Where the camera is."""
    return np.stack([SPEED * (t - DURATION / 2), 0 * t, 0 * t], axis=-1)


def directions(t: Array) -> Array:
    """Unit vectors from the camera to the target."""
    away = TARGET - positions(t)
    return np.asarray(away / np.linalg.norm(away, axis=-1, keepdims=True))


def pointing(t: Array) -> Array:
    """Quaternions of cameras whose first axis points at the target, the second one level."""
    forward = directions(t)
    left = np.cross([0.0, 0.0, 1.0], forward)
    left /= np.linalg.norm(left, axis=-1, keepdims=True)
    return np.asarray(Rotation.from_matrix(np.stack([forward, left, np.cross(forward, left)], axis=-1)).as_quat())


def first_axis(q: Any) -> Any:
    """The first axis of the camera in the world."""
    x, y, z, w = jnp.moveaxis(q, -1, 0)
    return jnp.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)


def rates(q: Any, h: float) -> Any:
    """Mean body rates between neighbouring times, to the second order in their distance."""
    a, s, b, r = q[:-1, :3], q[:-1, 3:], q[1:, :3], q[1:, 3:]
    return 2 * (s * b - r * a - jnp.cross(a, b)) / h


def objective(knots: Array, t: Array) -> Any:
    """What is minimised, a function of the keyframes: mean squared acceleration and mean squared excess of angles."""
    wanted, h = directions(t), float(t[1] - t[0])
    allowed = 2 * np.sin(np.radians(ALLOWED) / 2)

    @jax.jit
    def value(flat: Any) -> Any:
        q = rotation_spline(knots, flat.reshape(-1, 4), t)
        accelerations = jnp.diff(rates(q, h), axis=0) / h
        # At most the allowed chord counts as that: the root of zero, on target, has no derivative.
        squares = jnp.sum((first_axis(q) - wanted) ** 2, axis=-1)
        excess = jnp.sqrt(jnp.maximum(squares, allowed**2)) - allowed
        return jnp.mean(jnp.sum(accelerations**2, axis=-1)) + WEIGHT * jnp.mean(excess**2)

    return jax.value_and_grad(value)


def off_target(curve: RotationSpline, t: Array) -> Array:
    """Angles between the camera's first axis and the target, in degrees."""
    axes = Rotation.from_quat(curve(t)).apply([1.0, 0.0, 0.0])
    cosines = np.einsum("ij,ij->i", axes, directions(t))
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Optimise the keyframes of a camera that flies past a target."""
    jax.config.update("jax_enable_x64", True)
    knots, t = np.linspace(0, DURATION, KEYFRAMES), np.linspace(0, DURATION, TIMES)
    start = pointing(knots)
    calls = objective(knots, t)

    def both(flat: Array) -> tuple[float, Array]:
        # A quaternion may have any length; that of 1 keeps the problem well scaled.
        value, gradient = calls(flat)
        return float(value), np.asarray(gradient)

    steps = 10 if quick else 400
    found = minimize(both, start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": steps, "maxfun": 2 * steps})
    curves = {
        name: RotationSpline(knots, keyframes)
        for name, keyframes in zip(STYLES, (start, found.x.reshape(-1, 4)), strict=True)
    }
    fine = np.linspace(0, DURATION, 2001)
    numbers: dict[str, Any] = {
        "iterations": int(found.nit),
        "objective": float(found.fun),
        "start": both(start.ravel())[0],
    }
    for name, curve in zip(("pointing", "optimised"), curves.values(), strict=True):
        peak = float(np.degrees(np.linalg.norm(curve(fine, 2), axis=-1).max()))
        numbers[name] = {"cost": curve.cost(), "peak": peak, "off": float(off_target(curve, fine).max())}
    draw(out, fine, curves)
    return numbers


def draw(out: Path, t: Array, curves: dict[str, RotationSpline]) -> None:
    """Angles off the target, and angular accelerations."""
    figure = new_figure()
    angles, accelerations = figure.subplots(1, 2)
    for name, curve in curves.items():
        label = f"{name}: cost {curve.cost():.2f} rad²/s³"
        angles.plot(t, off_target(curve, t), label=label, **STYLES[name])
        lengths = np.degrees(np.linalg.norm(curve(t, 2), axis=-1))
        accelerations.plot(t, lengths, **STYLES[name])
    angles.axhline(ALLOWED, color=ORANGE, linewidth=1.0, label="largest angle allowed")
    angles.set(xlabel="time (s)", ylabel="target off the middle of the\npicture (degrees)")
    accelerations.set(xlabel="time (s)", ylabel="angular acceleration (degrees/s²)")
    for ax in (angles, accelerations):
        ax.set(xlim=(0, DURATION), ylim=(0, None))
    figure.legend(*angles.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "target_in_view")
