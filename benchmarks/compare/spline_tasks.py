"""The project's splines as tasks."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from benchmarks.compare import spline_problems
from benchmarks.compare.methods.hermite import TangentHermite
from benchmarks.compare.protocol import Measures, Task, Tasks
from benchmarks.compare.spline_problems import Knots, evaluations
from benchmarks.environment import ROOT
from benchmarks.memory import resident
from benchmarks.problems import Array
from stiefel_rs import CubicHermite, CubicSpline, Grassmann, Stiefel

MEBIBYTE = 2**20
Kind = Literal["riemannian", "geometric"]


def frames(knots: Knots) -> Array:
    """The first two columns of the rotations."""
    return np.ascontiguousarray(knots.S[:, :, :2])


def setup_task(count: int, *, kind: Kind = "riemannian", columns: int = 2, tol: float = 1e-12) -> Task:
    """The natural spline through keyframes; its points are compared."""
    knots = spline_problems.keyframes(count)
    S = knots.S if columns == 3 else frames(knots)

    def run() -> CubicSpline:
        return CubicSpline(knots.t, S, kind=kind, tol=tol)

    return Task(run, result=lambda: run()(evaluations(knots.t))[..., :2], note=lambda: character(run()))


def character(curve: CubicSpline) -> str:
    """Cost and jump of a spline."""
    return f"cost {curve.cost():.6g}, jump {jump(curve):.1g}"


def jump(curve: CubicSpline) -> float:
    """Largest jump of the covariant acceleration at a knot, in the canonical metric; for rotations, the angular one."""
    inner = np.asarray(curve.t)[1:-1]
    jumps = curve.acceleration(inner) - curve.acceleration(np.nextafter(inner, -np.inf))
    M, S = Stiefel(curve.n, curve.k), curve(inner)
    # The sides agree up to the tolerance of the spline, so their difference is tangent only to that accuracy.
    return float(np.max(M.norm(S, M.project_tangent(S, jumps)), initial=0.0))


def points_task(*, columns: int = 2) -> Task:
    """Points of the spline through the keyframes."""
    knots = spline_problems.keyframes(spline_problems.EVALUATED)
    curve = CubicSpline(knots.t, knots.S if columns == 3 else frames(knots))
    t = evaluations(knots.t)
    return Task(lambda: curve(t), units=len(t), result=lambda: curve(t)[..., :2])


def samples() -> tuple[Array, Array, Array]:
    """Times, points and velocities of the known curve."""
    knots = spline_problems.sampled()
    assert knots.V is not None
    return knots.t, knots.S, knots.V


def hermite_task(kind: Kind) -> Task:
    """Hermite interpolant of the known curve."""
    t, S, V = samples()

    def run() -> CubicHermite:
        return CubicHermite(t, S, V, kind=kind)

    return Task(run, result=lambda: run()(spline_problems.checks()))


def hermite_point_task(kind: Kind) -> Task:
    """One point of it."""
    curve = CubicHermite(*samples(), kind=kind)
    return Task(lambda: curve(0.3), result=lambda: curve(spline_problems.checks()))


def exact_task() -> Task:
    """The known curve itself."""
    n, k, _ = spline_problems.SAMPLED
    exact = spline_problems.factors(n, k, spline_problems.checks())[0]
    return Task(lambda: exact)


def hermite_error() -> float:
    """Ratio of the largest errors of the Hermite interpolant and of the tangent-space method."""
    knots, t = samples(), spline_problems.checks()
    n, k, _ = spline_problems.SAMPLED
    exact = spline_problems.factors(n, k, t)[0]
    tangent = TangentHermite(*knots)
    ours = CubicHermite(*knots)(t) - exact
    theirs = np.stack([tangent(float(x)) for x in t]) - exact
    return float(np.linalg.norm(ours, axis=(1, 2)).max() / np.linalg.norm(theirs, axis=(1, 2)).max())


def large(name: str, factor: int = 1) -> Knots:
    """Knots of the large problems, or of one with `factor` times as many."""
    if name == "long":
        knots = spline_problems.keyframes(factor * spline_problems.LONG)
        return Knots(knots.t, frames(knots))
    n, k, count = spline_problems.TALL
    return spline_problems.walk(n, k, factor * count)


def large_task(name: str) -> Task:
    """A natural spline through many points, or tall ones."""
    knots = large(name)

    def run() -> CubicSpline:
        return CubicSpline(knots.t, knots.S)

    middle = (knots.t[:-1] + knots.t[1:]) / 2
    return Task(run, result=lambda: run()(middle))


def subspaces_task() -> Task:
    """A natural spline through subspaces that are given by any bases."""
    n, k, _ = spline_problems.SUBSPACES
    knots, bases = spline_problems.subspaces()
    M = Grassmann(n, k)
    return Task(lambda: CubicSpline(knots.t, bases, manifold=M), result=lambda: np.zeros(0))


def aligned_frames_task() -> Task:
    """A natural spline through aligned bases of these subspaces as frames."""
    knots, _ = spline_problems.subspaces()
    return Task(lambda: CubicSpline(knots.t, knots.S), result=lambda: np.zeros(0))


def peak(name: str, factor: int = 1) -> float:
    """Peak memory of building a spline, including the spline, in MiB; measured in a separate process."""
    code = f"from benchmarks.compare.spline_tasks import print_peak; print_peak({name!r}, {factor})"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT)
    return float(found.stdout)


def print_peak(name: str, factor: int) -> None:
    """Print that measure for this process."""
    knots = large(name, factor)
    before = resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    curve = CubicSpline(knots.t, knots.S)
    print((resident("VmHWM") - before) / MEBIBYTE)
    del curve


def growth(name: str) -> float:
    """Ratio of the peak memory with twice the knots to that with the given ones."""
    return peak(name, 2) / peak(name)


def tasks() -> Tasks:
    """All tasks by name."""
    found: dict[str, Callable[[], Task]] = {
        "spline_points:ours": points_task,
        "spline_points:rotations": partial(points_task, columns=3),
        "spline_large/subspaces:ours": subspaces_task,
        "spline_large/subspaces:frames": aligned_frames_task,
    }
    for count in spline_problems.KEYFRAMES:
        found[f"spline_setup/{count}:ours"] = partial(setup_task, count)
        found[f"spline_setup/{count}:loose"] = partial(setup_task, count, tol=1e-8)
        found[f"spline_setup/{count}:rotations"] = partial(setup_task, count, columns=3)
        found[f"spline_setup/{count}:geometric"] = partial(setup_task, count, kind="geometric")
    for part, task in (("setup", hermite_task), ("point", hermite_point_task)):
        found[f"spline_hermite/{part}:ours"] = partial(task, "riemannian")
        found[f"spline_hermite/{part}:geometric"] = partial(task, "geometric")
        found[f"spline_hermite/{part}:exact"] = exact_task
    for name in ("long", "tall"):
        found[f"spline_large/{name}:ours"] = partial(large_task, name)
    return found


def setup_jump(count: int) -> float:
    """Largest jump of the covariant acceleration of the spline through keyframes."""
    knots = spline_problems.keyframes(count)
    return jump(CubicSpline(knots.t, frames(knots)))


def measures() -> Measures:
    """Measures other than times."""
    found: Measures = {"spline_hermite/setup:error": hermite_error}
    for count in spline_problems.KEYFRAMES:
        found[f"spline_setup/{count}:jump"] = partial(setup_jump, count)
    for name in ("long", "tall"):
        found[f"spline_large/{name}:peak"] = partial(peak, name)
        found[f"spline_large/{name}:growth"] = partial(growth, name)
    return found
