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

from figures import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION, command_line, new_figure, save
from plume import WINDS, Array, between, modes, reduced, relative_error, solve
from subspace_curves import ENDS, GEODESICS, NATURAL, NEAREST, TANGENT, of_frames, ways

OWN, FLOOR = "own", "floor"
LIBRARIES = Path(__file__).parent / "data" / "subspaces_by_other_libraries.json"


def errors_of(winds: Array, directions: Array) -> tuple[dict[str, Array], dict[str, str]]:
    """Relative errors of the reduced models, and what was raised for frames."""
    points = np.stack([modes(solve(wind)) for wind in winds])
    known = [solve(wind) for wind in directions]
    curves, raised = ways(winds, points), {}
    for name, curve in of_frames(winds, points).items():
        if isinstance(curve, str):
            raised[name] = curve
        else:
            curves[name] = curve
    errors = {
        name: [relative_error(reduced(wind, way(wind)), u) for wind, u in zip(directions, known, strict=True)]
        for name, way in curves.items()
    }
    own = [modes(u) for u in known]
    errors[OWN] = [relative_error(reduced(*each), u) for *each, u in zip(directions, own, known, strict=True)]
    errors[FLOOR] = [relative_error(U @ (U.T @ u), u) for U, u in zip(own, known, strict=True)]
    return {name: np.array(each) for name, each in errors.items()}, raised


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Interpolate the modes of a plume in the wind; compare the errors of the reduced models."""
    numbers: dict[str, Any] = {}
    drawn = []
    for range_, winds in WINDS.items():
        directions, held_out = between(winds, 2 if quick else 8)
        errors, raised = errors_of(winds, directions)
        numbers[range_] = {name: float(np.sqrt(np.mean(each[held_out] ** 2))) for name, each in errors.items()} | raised
        drawn.append((winds, directions, errors))
    draw(out, drawn)
    return numbers | {"libraries": json.loads(LIBRARIES.read_text(encoding="utf-8"))}


STYLES = {
    NEAREST: {"color": BLACK, "linestyle": ":"},
    GEODESICS: {"color": VERMILION, "linestyle": "-."},
    TANGENT: {"color": ORANGE, "linestyle": (0, (5, 1.5))},
    NATURAL: {"color": GREEN, "linewidth": 1.2},
    ENDS: {"color": BLUE, "linewidth": 2.0},
    OWN: {"color": SKY, "linestyle": (0, (1, 1)), "linewidth": 2.0},
}


def draw(out: Path, drawn: list[tuple[Array, Array, dict[str, Array]]]) -> None:
    """Errors of the reduced models against the direction of the wind, for both ranges."""
    figure = new_figure(height=5.0)
    axes = figure.subplots(1, len(drawn), sharey=True)
    for ax, (winds, directions, errors) in zip(axes, drawn, strict=True):
        for name, style in STYLES.items():
            ax.semilogy(directions, errors[name], label=name, **style)
        ax.plot(winds, np.full(len(winds), errors[OWN].min() / 1.6), "^", color=BLACK)
        ax.set(
            xlabel="wind direction in degrees (triangles: modes computed)",
            xlim=(winds[0], winds[-1]),
            xticks=winds[::2],
        )
    axes[0].set_ylabel("relative error of the reduced model")
    axes[0].legend(loc="upper center", ncols=2, bbox_to_anchor=(0.5, 1.2))
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "reduced_model")
