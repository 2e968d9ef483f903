"""Keyframes and the bias of a gyro fitted together to noisy rates and a few noisy orientations, by Adam from optax.

The model is a RotationSpline. Each step takes the derivative of the misfit at a few measurements, picked at random, by
the keyframes and by the bias, through the spline: stiefel_rs.jax.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from figures import command_line, new_figure, save
from stiefel_rs import RotationSpline
from stiefel_rs.jax import rotation_spline
from stiefel_rs.palette import BLUE, INK, VERMILION

Array = NDArray[np.float64]
# In s, rad and rad/s: a gyro at 50 Hz, orientations every half second.
DURATION, GYRO_RATE, ORIENTATION_RATE = 20.0, 50.0, 2.0
GYRO_NOISE, ORIENTATION_NOISE, BIAS = 0.02, np.radians(3.0), np.array([0.05, -0.03, 0.02])
KEYFRAMES, STEPS, BATCH = 41, 400, 64
# Rates of the model are those between times so far apart.
H = 0.01


def truth() -> RotationSpline:
    """A body that tumbles."""
    rng = np.random.default_rng(3)
    steps = Rotation.from_rotvec(0.5 * rng.normal(size=(16, 3)))
    turned = [Rotation.identity()]
    for step in steps[1:]:
        turned.append(turned[-1] * step)
    return RotationSpline(np.linspace(0, DURATION, 16), Rotation.concatenate(turned).as_quat())


def measured(curve: RotationSpline) -> dict[str, Array]:
    """Rates with a bias, and orientations, both with noise."""
    rng = np.random.default_rng(4)
    t = np.arange(0.1, DURATION - 0.1, 1 / GYRO_RATE)
    at = np.arange(0.0, DURATION + 1e-9, 1 / ORIENTATION_RATE)
    noise = Rotation.from_rotvec(ORIENTATION_NOISE * rng.normal(size=(len(at), 3)))
    return {
        "t": t,
        "gyro": np.asarray(curve(t, 1)) + BIAS + GYRO_NOISE * rng.normal(size=(len(t), 3)),
        "at": at,
        "orientations": (Rotation.from_quat(curve(at)) * noise).as_quat(),
    }


def relative(p: Any, q: Any) -> Any:
    """Rotation vectors from one orientation to another one near by, to the second order."""
    a, s, b, r = p[:, :3], p[:, 3:], q[:, :3], q[:, 3:]
    scalar = jnp.sum(a * b, axis=-1, keepdims=True) + s * r
    return 2 * jnp.sign(scalar) * (s * b - r * a - jnp.cross(a, b))


def misfit(model: dict[str, Any], batch: dict[str, Any], knots: Array) -> Any:
    """Mean squares of residuals in units of their noise."""
    t, at = batch["t"], batch["at"]
    q = rotation_spline(knots, model["keyframes"], jnp.concatenate([t - H / 2, t + H / 2, at]))
    before, after, here = jnp.split(q, [len(t), 2 * len(t)])
    rates = relative(before, after) / H - batch["gyro"] + model["bias"]
    turns = relative(here, batch["orientations"])
    return jnp.mean((rates / GYRO_NOISE) ** 2) + jnp.mean((turns / ORIENTATION_NOISE) ** 2)


def fit(data: dict[str, Array], knots: Array, steps: int) -> tuple[dict[str, Any], list[float]]:
    """Run Adam on random measurements, from the measured orientations next to the keyframes."""
    rng = np.random.default_rng(5)
    nearest = np.abs(knots[:, None] - data["at"]).argmin(axis=1)
    model = {"keyframes": jnp.asarray(data["orientations"][nearest]), "bias": jnp.zeros(3)}
    adam = optax.adam(optax.cosine_decay_schedule(0.02, steps))
    state, losses = adam.init(model), []

    @jax.jit
    def step(model: Any, state: Any, batch: Any) -> Any:
        loss, gradient = jax.value_and_grad(misfit)(model, batch, knots)
        updates, state = adam.update(gradient, state)
        return optax.apply_updates(model, updates), state, loss

    for _ in range(steps):
        rates = rng.choice(len(data["t"]), BATCH, replace=False)
        turns = rng.choice(len(data["at"]), BATCH // 4, replace=False)
        batch = {"t": data["t"][rates], "gyro": data["gyro"][rates]}
        batch |= {"at": data["at"][turns], "orientations": data["orientations"][turns]}
        model, state, loss = step(model, state, batch)
        losses.append(float(loss))
    return model, losses


def error(q: Array, wanted: Array) -> float:
    """Root of the mean square of the angles between orientations, in degrees."""
    angles = (Rotation.from_quat(q).inv() * Rotation.from_quat(wanted)).magnitude()
    return float(np.degrees(np.sqrt(np.mean(angles**2))))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Fit keyframes and the bias of a gyro to noisy rates and orientations."""
    jax.config.update("jax_enable_x64", True)
    curve, knots = truth(), np.linspace(0, DURATION, KEYFRAMES)
    data = measured(curve)
    model, losses = fit(data, knots, 40 if quick else STEPS)
    t = np.linspace(0, DURATION, 1001)
    fitted = RotationSpline(knots, np.asarray(model["keyframes"]))
    through = RotationSpline(data["at"], data["orientations"])
    numbers = {
        "first": float(np.mean(losses[:5])),
        "last": float(np.mean(losses[-5:])),
        "bias_off": float(np.linalg.norm(np.asarray(model["bias"]) - BIAS) / np.linalg.norm(BIAS)),
        "measured": error(data["orientations"], curve(data["at"])),
        "through": error(through(t), curve(t)),
        "fitted": error(fitted(t), curve(t)),
    }
    draw(out, t, {"true": curve, "through the measured orientations": through, "fitted": fitted}, losses)
    return numbers


def draw(out: Path, t: Array, curves: dict[str, RotationSpline], losses: list[float]) -> None:
    """One component of the rate, and the misfit of each step."""
    figure = new_figure()
    left, right = figure.subplots(1, 2)
    styles = [{"color": INK, "linewidth": 2.5}, {"color": VERMILION, "linestyle": ":"}, {"color": BLUE}]
    for (name, curve), style in zip(curves.items(), styles, strict=True):
        left.plot(t, np.asarray(curve(t, 1))[:, 2], label=name, **style)
    left.set(xlabel="time (s)", ylabel="third component of the body rate (rad/s)", xlim=(0, 10))
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    right.semilogy(losses, color=BLUE, linewidth=0.8)
    right.set(xlabel="step", ylabel="misfit of the measurements of a step", ylim=(1, 100), yticks=[1, 10, 100])
    right.set_yticks([2, 5, 20, 50], ["2", "5", "20", "50"], minor=True)
    right.set_yticklabels(["1", "10", "100"])
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "gyro_fit")
