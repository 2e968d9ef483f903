"""All examples: their figures, and docs/gallery.md with their numbers."""

from __future__ import annotations

import argparse
from pathlib import Path
from textwrap import fill
from typing import Any

import attitude
import grand_tour
import moving_subspace
import reduced_order_model
from figures import FIGURES

WIDTH = 120
DOCS = FIGURES.parent.parent
EXAMPLES = {
    "attitude": attitude.main,
    "reduced_order_model": reduced_order_model.main,
    "moving_subspace": moving_subspace.main,
    "grand_tour": grand_tour.main,
}

TEXT = """\
# Gallery

Written by `make gallery`, which runs the scripts of [examples/](../examples), each of them shorter than 150 lines. One
alone: `python examples/attitude.py --out attitude.png`, with the package, SciPy and matplotlib installed.

## A satellite turns through keyframes

![Left: azimuth and elevation of the body's first axis along three curves through seven keyframes. Right: lengths of
angular velocity and angular acceleration](figures/gallery/attitude.png)

[attitude.py](../examples/attitude.py) joins seven orientations in 50 s by `CubicSpline`, as points of St(3,3), by
SciPy's `RotationSpline`, and by slerp. The natural Riemannian spline makes the integral of the squared angular
acceleration stationary: the torque that a round body needs. It takes {cost:.2f}e-3 rad²/s³, `RotationSpline`
{cost_rotation_spline:.2f}e-3, {more:.0f} % more. The angular acceleration of both is continuous; that of the natural
spline is zero at the ends. Its largest is {largest_acceleration:.2f} degrees/s², of `RotationSpline`
{largest_acceleration_rotation_spline:.2f}. The two are up to {farthest_apart:.1f} degrees apart. Slerp's angular
velocity jumps, at one keyframe by {jump_of_slerp_velocity:.1f} degrees/s, which no finite torque does.

## A reduced model

![Left: temperatures for three positions of the interface. Right: errors of the reduced models against the position of
the interface](figures/gallery/reduced_order_model.png)

[reduced_order_model.py](../examples/reduced_order_model.py) solves the heat equation on 2000 points for five positions
of the interface between two materials. The six modes (POD) that hold most of a solution are a point of St(2000,6). In
between, modes are needed without solving: those of the nearest position give an error of the reduced model of
{nearest:.1e} (root of the mean square over 49 positions); a natural spline of the entries {entries:.1e}; the same, made
orthonormal, {orthonormal:.1e}; `CubicSpline` on the manifold {spline:.1e}, {gain_entries:.1f} and
{gain_orthonormal:.1f} times less. The modes of each position itself, which need its solution, would give {own:.0e}.

The gain is that of few, far positions, and not always there. With seven positions ends count more than the manifold:
natural ends give {spline7:.1e} on it, {orthonormal7:.1e} by entries made orthonormal, SciPy's not-a-knot ends
{not_a_knot7:.1e} by the latter ({not_a_knot:.1e} with five).

## A plane that moves

![Left: three entries of a basis of the plane: of noisy windows, smoothed, and true. Right: angle to the true
plane](figures/gallery/moving_subspace.png)

[moving_subspace.py](../examples/moving_subspace.py) has 24 noisy sensors whose signals stay near a plane that turns, by
up to {turned:.0f} degrees in a minute. Windows of one second give it as their two largest principal components, with an
error of {rms_one_window:.1f} degrees (root of the mean square). Longer windows are less noisy and lag behind; the
length that is best, known here since the truth is, is {best_length} s, with {rms_best_length:.1f} degrees.
`SmoothingSpline` through the bases of the short windows, points of St(24,2) turned in their planes to be near to each
other, has {rms_smoothed:.1f} degrees, with a lambda that generalised cross-validation found from the data alone.

## A grand tour of the penguins

![Eight pictures of the penguins along the tour, and the share of the variance that is between the
species](figures/gallery/grand_tour.png)

[grand_tour.py](../examples/grand_tour.py) looks at the six measurements (bill length and depth, flipper length, mass,
two isotope ratios) of {rows} penguins, from the [data of the palmerpenguins package](../examples/data/README.md)
(CC0), through two-dimensional projections: points of St(6,2). Along shortest curves between seven random ones, at
speed 1, the velocity turns abruptly by {smallest_turn_of_geodesics:.1f} to {largest_turn_of_geodesics:.1f}; the spline
through the same seven moves on smoothly. At t = {best_separation_time:.1f} the picture separates the species best:
{best_separation:.0%} of its variance is between them.
"""


def wrapped(text: str) -> str:
    """Paragraphs in lines of the usual width; headings and tables stay."""
    paragraphs = (
        part if part.startswith(("#", "|")) else fill(part, WIDTH, break_long_words=False, break_on_hyphens=False)
        for part in text.strip().split("\n\n")
    )
    return "\n\n".join(paragraphs) + "\n"


def reduced_model(numbers: dict[str, dict[str, float]]) -> dict[str, float]:
    """Errors of the reduced models, and how much less that of the spline is."""
    names = {
        "nearest": reduced_order_model.NEAREST,
        "entries": reduced_order_model.ENTRIES,
        "orthonormal": reduced_order_model.ORTHONORMAL,
        "spline": reduced_order_model.SPLINE,
        "own": reduced_order_model.OWN,
        "not_a_knot": reduced_order_model.NOT_A_KNOT,
    }
    five = {key: numbers["five"][name] for key, name in names.items()}
    seven = {f"{key}7": numbers["seven"][name] for key, name in names.items()}
    gains = {f"gain_{key}": five[key] / five["spline"] for key in ("entries", "orthonormal")}
    return five | seven | gains


def page(numbers: dict[str, dict[str, Any]]) -> str:
    """The text with its numbers."""
    values = {name: value for each in numbers.values() for name, value in each.items()}
    costs = numbers["attitude"]["cost"], numbers["attitude"]["cost_rotation_spline"]
    more = 100 * (costs[1] / costs[0] - 1)
    values |= {"cost": 1e3 * costs[0], "cost_rotation_spline": 1e3 * costs[1], "more": more}
    values |= reduced_model(numbers["reduced_order_model"])
    return wrapped(TEXT.format(**values))


def write(folder: Path) -> None:
    """Run all examples; their page and their figures go into the folder."""
    figures = folder / FIGURES.relative_to(DOCS)
    text = page({name: main(figures / f"{name}.png") for name, main in EXAMPLES.items()})
    (folder / "gallery.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run all examples: the page and the figures of the gallery.")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder for gallery.md and figures/")
    write(parser.parse_args().out)
