"""A grand tour of the Palmer penguins: a smooth path of two-dimensional projections of six measurements.

Each projection is a point of St(6, 2). Joining random ones by shortest curves, as grand tours do, the picture stops and
turns at each of them; the spline through the same projections moves on smoothly.
"""

from __future__ import annotations

import csv
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from figures import command_line, nearest_turn, new_figure, save
from stiefel_rs import CubicSpline, Geodesic, Stiefel
from stiefel_rs.palette import BACKGROUND, BLUE, GREEN, GRID_GREY, INK, ORANGE, PURPLE, VERMILION

Array = NDArray[np.float64]
# Gorman, Williams, Fraser (2014), PLoS ONE 9(3): e90081, the palmerpenguins package; CC0. See data/README.md.
DATA = Path(__file__).resolve().parent / "data" / "penguins.csv"
NAMES = {"L": "bill length", "D": "bill depth", "F": "flipper length", "M": "mass", "N": "δ¹⁵N", "C": "δ¹³C"}
SPECIES = {"Adelie": (VERMILION, "o"), "Chinstrap": (PURPLE, "^"), "Gentoo": (GREEN, "s")}
SEED = 11
# Farther out than all penguins in all pictures.
RING = 4.9
FRAMES = 7
PANELS = 8


def penguins() -> tuple[Array, list[str]]:
    """Measurements, each with mean 0 and variance 1, shape (330, 6), and species."""
    with DATA.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    values = np.array([[float(x) for x in row[1:]] for row in rows])
    return (values - values.mean(axis=0)) / values.std(axis=0), [row[0] for row in rows]


def frames(count: int) -> tuple[Array, Array]:
    """Random projections, each turned in its plane to be as near as can be to the one before; times by distance."""
    M = Stiefel(6, 2)
    found = [M.random_point(rng=SEED)]
    for i in range(1, count):
        new = M.random_point(rng=SEED + i)
        found.append(new @ nearest_turn(new, found[-1]))
    steps = [M.dist(a, b) for a, b in pairwise(found)]
    return np.concatenate([[0.0], np.cumsum(steps)]), np.stack(found)


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Join random projections of six measurements by a spline, and by shortest curves."""
    X, species = penguins()
    t, S = frames(4 if quick else FRAMES)
    M = Stiefel(6, 2)
    tour = CubicSpline(t, S)
    pieces = [Geodesic(a, b) for a, b in pairwise(S)]
    h = np.diff(t)
    turns = [
        float(M.norm(b, (q.velocity(0.0) / hq) - (p.velocity(1.0) / hp)))
        for b, p, q, hp, hq in zip(S[1:-1], pieces[:-1], pieces[1:], h[:-1], h[1:], strict=True)
    ]
    inner = t[1:-1]
    jumps = M.norm(tour(inner), tour.velocity(inner) - tour.velocity(np.nextafter(inner, -np.inf)))
    dense = np.linspace(*tour.t_span, 401)
    separation = np.array([spread(X @ P, species) for P in tour(dense)])
    numbers = {
        "rows": len(X),
        "cost": tour.cost(),
        "smallest_turn_of_geodesics": min(turns),
        "largest_turn_of_geodesics": max(turns),
        "velocity_jump_of_spline": float(np.max(jumps)),
        "orthonormality_defect": float(np.abs(np.swapaxes(tour(dense), 1, 2) @ tour(dense) - np.eye(2)).max()),
        "best_separation_time": float(dense[separation.argmax()]),
        "best_separation": float(separation.max()),
    }
    draw(out, tour, (X, species), np.linspace(*tour.t_span, 4 if quick else PANELS), (dense, separation))
    return numbers


def spread(Y: Array, species: list[str]) -> float:
    """Share of the variance of a picture that is between the species."""
    labels = np.array(species)
    between = sum(np.sum(labels == s) * np.sum(Y[labels == s].mean(axis=0) ** 2) for s in SPECIES)
    return float(between / np.sum(Y**2))


def picture(ax: Axes, P: Array, data: tuple[Array, list[str]]) -> None:
    """The penguins in one projection, the axes of the measurements in it, and around it the letters of the axes."""
    Y, labels = data[0] @ P, np.array(data[1])
    for name, (colour, marker) in SPECIES.items():
        style = {"markersize": 2.2, "alpha": 0.6, "markeredgewidth": 0.0, "rasterized": True}
        ax.plot(*Y[labels == name].T, marker, color=colour, label=name, **style)
    named: list[Array] = []
    for i in np.argsort(-np.linalg.norm(P, axis=1)):
        ax.plot(*np.stack([0 * P[i], 2.8 * P[i]]).T, color=INK, linewidth=0.8)
        place = RING * P[i] / np.linalg.norm(P[i])
        # Longest first; a letter that would lie on another is left out.
        if np.linalg.norm(P[i]) > 0.4 and all(np.linalg.norm(place - other) > 0.8 for other in named):
            ax.text(*place, list(NAMES)[i], ha="center", va="center_baseline", fontsize=8)
            named.append(place)
    ax.add_patch(Circle((0, 0), RING - 0.5, fill=False, color=GRID_GREY, linewidth=0.6))
    ax.set(xlim=(-RING - 0.4, RING + 0.4), ylim=(-RING - 0.4, RING + 0.4), aspect="equal", xticks=[], yticks=[])
    ax.set_axis_off()


def draw(out: Path, tour: CubicSpline, data: tuple[Array, list[str]], times: Array, shares: Any) -> None:
    """Projections along the tour; below them, how well each separates the species."""
    columns = len(times) // 2
    figure = new_figure(5.4)
    grid = figure.add_gridspec(3, columns, height_ratios=[1, 1, 0.55])
    for i, time in enumerate(times):
        ax = figure.add_subplot(grid[i // columns, i % columns])
        picture(ax, tour(time), data)
        ax.set_title(f"t = {time:.1f}")
    letters = ", ".join(f"{letter} {name}" for letter, name in NAMES.items())
    names = ax.get_legend_handles_labels()
    figure.legend(*names, loc="outside upper center", ncols=3, markerscale=2, title=f"axes: {letters}")
    lower = figure.add_subplot(grid[2, :])
    lower.plot(*shares, color=BLUE)
    lower.plot(times, np.interp(times, *shares), "o", color=BLUE, markerfacecolor=BACKGROUND, label="pictures above")
    for i, time in enumerate(tour.t):
        lower.axvline(time, color=ORANGE, linewidth=0.9, zorder=0, label=None if i else "random projections")
    lower.set(
        xlabel="time t (canonical distance along shortest curves)", ylabel="variance\nbetween species", ylim=(0, 1)
    )
    lower.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "grand_tour")
