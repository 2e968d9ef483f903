"""A heated rod of two materials whose interface moves: a reduced model between the positions that were computed.

For some positions of the interface the heat equation is solved on 2000 points; the six modes that hold most of its
solution (POD) are a point of St(2000, 6). A curve through these points gives modes for every position in between, with
which the heat equation is six ordinary equations.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline as ScipySpline
from scipy.linalg import solve_banded

from figures import command_line, new_figure, save
from stiefel_rs import CubicSpline, Stiefel
from stiefel_rs.palette import BLUE, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION

Array = NDArray[np.float64]
N, MODES = 2000, 6
STEPS, DURATION = 100, 1.0
# Diffusivity left of the interface and right of it, and the width over which it changes.
LEFT, RIGHT, WIDTH = 0.1, 2.1, 0.1
POSITIONS = np.linspace(0.3, 0.7, 5)
NEAREST, ENTRIES, ORTHONORMAL = "modes of the nearest position", "entries interpolated", "the same, made orthonormal"
SPLINE, OWN, NOT_A_KNOT = "spline on St(2000,6)", "modes of the position itself", "not-a-knot, orthonormal"


def operator(interface: float) -> tuple[Array, Array]:
    """Diagonals of `-(a u')'` by finite volumes, with temperature 0 at the ends: the main one and the one beside it."""
    faces = np.arange(N + 1) / N
    a = (LEFT + (RIGHT - LEFT) / (1 + np.exp((interface - faces) / WIDTH))) * N**2
    main = a[:-1] + a[1:]
    main[[0, -1]] += a[[0, -1]]
    return main, -a[1:-1]


def solve(interface: float) -> Array:
    """The full model: temperatures `(N, STEPS)` from 0, heated evenly, by the implicit Euler method."""
    main, beside = operator(interface)
    dt, u, found = DURATION / STEPS, np.zeros(N), []
    bands = np.stack([np.append(0.0, dt * beside), 1 + dt * main, np.append(dt * beside, 0.0)])
    for _ in range(STEPS):
        u = solve_banded((1, 1), bands, u + dt)
        found.append(u)
    return np.stack(found, axis=1)


def reduced(interface: float, U: Array) -> Array:
    """The same with the solution in the span of U (Galerkin); as written for orthonormal columns."""
    main, beside = operator(interface)
    AU = main[:, None] * U
    AU[:-1] += beside[:, None] * U[1:]
    AU[1:] += beside[:, None] * U[:-1]
    dt, z, found = DURATION / STEPS, np.zeros(U.shape[1]), []
    system, heat = np.eye(U.shape[1]) + dt * U.T @ AU, dt * U.sum(axis=0)
    for _ in range(STEPS):
        z = np.linalg.solve(system, z + heat)
        found.append(z)
    return U @ np.stack(found, axis=1)


def modes(snapshots: Array, near: Array | None) -> Array:
    """The modes that hold most of the snapshots; their signs as in the modes of the position before."""
    U = np.linalg.svd(snapshots, full_matrices=False)[0][:, :MODES]
    return U if near is None else U * np.sign(np.sum(U * near, axis=0))


def curves(positions: Array) -> dict[str, Callable[[float], Array]]:
    """Ways to have modes in between."""
    S: list[Array] = []
    for each in positions:
        S.append(modes(solve(each), S[-1] if S else None))
    M, points = Stiefel(N, MODES), np.stack(S)
    entries, free = (ScipySpline(positions, points, bc_type=ends) for ends in ("natural", "not-a-knot"))
    return {
        NEAREST: lambda x: points[np.abs(positions - x).argmin()],
        ENTRIES: entries,
        ORTHONORMAL: lambda x: M.project(entries(x)),
        SPLINE: CubicSpline(positions, points),
        NOT_A_KNOT: lambda x: M.project(free(x)),
    }


def errors_of(positions: Array, tested: Array, known: list[Array]) -> dict[str, Array]:
    """Relative errors of the reduced models where the full one is known."""
    ways = curves(positions)

    def error(x: float, U: Array, u: Array) -> float:
        return float(np.linalg.norm(reduced(x, U) - u) / np.linalg.norm(u))

    found = {name: [error(x, way(x), u) for x, u in zip(tested, known, strict=True)] for name, way in ways.items()}
    found[OWN] = [error(x, modes(u, None), u) for x, u in zip(tested, known, strict=True)]
    return {name: np.array(each) for name, each in found.items()}


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Interpolate the modes of a heat equation; compare the errors of the reduced models."""
    tested = np.linspace(POSITIONS[0], POSITIONS[-1], 9 if quick else 49)
    known = [solve(x) for x in tested]
    errors = errors_of(POSITIONS, tested, known)
    draw(out, tested, known, errors)
    numbers = {"five": {name: float(np.sqrt(np.mean(each**2))) for name, each in errors.items()}}
    if not quick:
        seven = errors_of(np.linspace(POSITIONS[0], POSITIONS[-1], 7), tested, known)
        numbers["seven"] = {name: float(np.sqrt(np.mean(each**2))) for name, each in seven.items()}
    return numbers


STYLES = {
    NEAREST: {"color": INK, "linestyle": ":"},
    ENTRIES: {"color": VERMILION, "linestyle": (0, (5, 1.5))},
    ORTHONORMAL: {"color": ORANGE, "linestyle": "-."},
    SPLINE: {"color": BLUE, "linewidth": 2.0},
    OWN: {"color": SKY, "linestyle": (0, (1, 1)), "linewidth": 2.0},
}


def draw(out: Path, tested: Array, known: list[Array], errors: dict[str, Array]) -> None:
    """Temperatures, and errors of the reduced models against the position of the interface."""
    figure = new_figure(3.4)
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.4])
    x = (np.arange(N) + 0.5) / N
    looks = ((GREEN, "-"), (PURPLE, "--"), (INK, "-."))
    for i, (colour, dashes) in zip((0, len(tested) // 2, -1), looks, strict=True):
        left.plot(x, known[i][:, -1], color=colour, linestyle=dashes, label=f"interface at {tested[i]:.2f}")
        left.axvline(tested[i], color=colour, linewidth=0.8, linestyle=dashes)
    left.set(xlabel="place on the rod (its length is 1)", ylabel=f"temperature at time {DURATION:g}")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper left")
    for name, style in STYLES.items():
        right.semilogy(tested, errors[name], label=name, **style)
    right.plot(POSITIONS, np.full(len(POSITIONS), errors[OWN].min() / 2), "^", color=INK, label="modes computed")
    right.set(xlabel="position of the interface", ylabel="relative error of the reduced model")
    figure.legend(*right.get_legend_handles_labels(), loc="outside upper right", ncols=2)
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "reduced_order_model")
