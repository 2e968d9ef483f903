"""A reduced model of a plume in any wind: modes between the wind directions that were computed, as subspaces.

For some wind directions the full model is solved on 1600 points, which gives the six modes that hold most of the result
(POD). What matters is their span, not their signs and order: a point of the Grassmann manifold Gr(1600, 6). A spline
through these points gives modes for every direction in between; with them the model is six ordinary equations.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from figures import command_line, new_figure, save
from plume import PERIOD, WINDS, Array, between, computed, modes, reduced, relative_error, solve
from stiefel_rs.palette import BLUE, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION
from subspace_curves import ENDS, GEODESICS, LOCAL, MEAN, NEAREST, SPLINE, TANGENT, M, mean, of_frames, ways

OWN, FLOOR = "modes of the direction itself", "floor"
LIBRARIES = Path(__file__).parent / "data" / "subspaces_by_other_libraries.json"


def errors_of(curves: dict[str, Any], directions: Array) -> dict[str, Array]:
    """Relative errors of the reduced models, and of the nearest approximation by modes of the direction itself."""
    found: dict[str, list[float]] = {name: [] for name in (*curves, OWN, FLOOR)}
    for wind in directions:
        u = solve(wind)
        own = modes(u)
        for name, U in [*((name, curve(wind)) for name, curve in curves.items()), (OWN, own)]:
            found[name].append(relative_error(reduced(wind, U), u))
        found[FLOOR].append(relative_error(own @ (own.T @ u), u))
    return {name: np.array(each) for name, each in found.items()}


def largest_angle(U: Array, W: Array) -> float:
    """Largest principal angle between subspaces in degrees."""
    return float(np.degrees(M.principal_angles(U, W).max()))


def with_half_the_step(parts: int) -> float:
    """Error of the periodic spline through twice as many subspaces."""
    winds = np.linspace(0, PERIOD, 2 * len(WINDS["circle"]) - 1)
    directions, held_out = between(winds, parts)
    errors = errors_of({SPLINE: ways(winds, computed(winds))[SPLINE]}, directions[held_out])
    return root_mean_square(errors[SPLINE])


def root_mean_square(errors: Array) -> float:
    """Root of the mean of the squares."""
    return float(np.sqrt(np.mean(errors**2)))


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Interpolate the modes of a plume in the wind; compare the errors of the reduced models."""
    numbers: dict[str, Any] = {}
    drawn = []
    for range_, winds in WINDS.items():
        points = computed(winds)
        curves = ways(winds, points)
        raised: dict[str, str] = {}
        if range_ == "quarter":
            frames, raised = of_frames(winds, points)
            curves |= frames
        directions, held_out = between(winds, 2 if quick else 8)
        errors = errors_of(curves, directions)
        numbers[range_] = {name: root_mean_square(each[held_out]) for name, each in errors.items()}
        numbers[range_] |= {"neighbours": largest_angle(points[:-1], points[1:]), "raised": raised}
        numbers[range_] |= {"from_middle": largest_angle(points[len(points) // 2], points)}
        numbers[range_] |= {"from_mean": largest_angle(mean(winds, points), points)}
        drawn.append((winds, directions, errors))
    draw(out, drawn)
    numbers["circle"]["half_the_step"] = with_half_the_step(2 if quick else 4)
    return numbers | {"libraries": json.loads(LIBRARIES.read_text(encoding="utf-8"))}


STYLES: dict[str, dict[str, Any]] = {
    NEAREST: {"color": INK, "linestyle": ":"},
    GEODESICS: {"color": VERMILION, "linestyle": "-."},
    TANGENT: {"color": ORANGE, "linestyle": (0, (5, 1.5))},
    MEAN: {"color": PURPLE, "linewidth": 1.2},
    LOCAL: {"color": INK, "linewidth": 0.7},
    SPLINE: {"color": BLUE, "linewidth": 2.0},
    ENDS: {"color": GREEN, "linewidth": 2.0, "linestyle": "--"},
    OWN: {"color": SKY, "linestyle": (0, (1, 1)), "linewidth": 2.0},
}
LABELS = {SPLINE: "spline, natural (left), periodic (right)"}


def draw(out: Path, drawn: list[tuple[Array, Array, dict[str, Array]]]) -> None:
    """Errors of the reduced models against the direction of the wind, for both ranges."""
    figure = new_figure(4.4)
    axes = figure.subplots(1, len(drawn), sharey=True, width_ratios=[1, 1.6])
    for ax, (winds, directions, errors) in zip(axes, drawn, strict=True):
        for name, style in STYLES.items():
            if name in errors:
                ax.semilogy(directions, errors[name], label=LABELS.get(name, name), **style)
        height = np.full(len(winds), errors[OWN].min() / 1.6)
        ax.plot(winds, height, "^", color=INK, label="modes computed", clip_on=False)
        ax.set(xlabel="wind direction (degrees)", xlim=(winds[0], winds[-1]), xticks=winds[:: len(winds) // 6])
    axes[0].set_ylabel("relative error of the reduced model")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "reduced_model")
