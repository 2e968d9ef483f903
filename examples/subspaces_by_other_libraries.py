"""The subspaces of reduced_model.py by SMT and UQpy: not part of the gallery, which reads what this has written.

It does not need this package: `pip install smt UQpy`, then `python subspaces_by_other_libraries.py`.
"""

from __future__ import annotations

import io
import json
from contextlib import redirect_stdout
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from smt.applications import PODI
from UQpy.dimension_reduction.grassmann_manifold.GrassmannInterpolation import GrassmannInterpolation
from UQpy.utilities.distances import GeodesicDistance
from UQpy.utilities.GrassmannPoint import GrassmannPoint

from plume import WINDS, between, computed, reduced, relative_error, solve

Array = NDArray[np.float64]
OUT = Path(__file__).parent / "data" / "subspaces_by_other_libraries.json"


def by_smt(winds: Array, bases: list[Array], directions: Array, *, frechet: bool = False) -> list[Array]:
    """Kriging in the tangent space of the basis in the middle, or of the Frechet mean, with SMT's default options."""
    options = {"frechet": frechet, "ref_index": len(winds) // 2, "frechet_guess": bases[len(winds) // 2]}
    with redirect_stdout(io.StringIO()):
        return list(PODI.interp_subspaces(winds[:, None], bases, directions[:, None], **options))


def by_uqpy(winds: Array, bases: list[Array], directions: Array) -> list[Array]:
    """Linear interpolation in the tangent space of the Karcher mean.

    One parameter raises `ValueError: Need at least 2-D data`, so there is a second here, 0 and 1 with the same points.
    Version 4.2.1 offers other methods, but does not reach them: it asks whether the method *is* the class `Surrogate`.
    """
    coordinates = np.array([[wind, second] for second in (0.0, 1.0) for wind in winds])
    points = [GrassmannPoint(basis) for basis in bases] * 2
    found = GrassmannInterpolation(None, points, coordinates, GeodesicDistance())
    return [np.asarray(found.interpolate_manifold(np.array([[wind, 0.5]])).data) for wind in directions]


def errors() -> dict[str, Any]:
    """Roots of the mean squares of the errors between the wind directions that were computed."""
    numbers: dict[str, Any] = {"versions": {name: version(name) for name in ("smt", "UQpy")}}
    for range_, winds in WINDS.items():
        directions, held_out = between(winds, 8)
        bases, directions = list(computed(winds)), directions[held_out]
        known = [solve(wind) for wind in directions]
        numbers[range_] = {}
        for name, library in (("smt", by_smt), ("smt, mean", partial(by_smt, frechet=True)), ("UQpy", by_uqpy)):
            found = zip(directions, library(winds, bases, directions), known, strict=True)
            squares = [relative_error(reduced(wind, U), u) ** 2 for wind, U, u in found]
            numbers[range_][name] = float(np.sqrt(np.mean(squares)))
    return numbers


if __name__ == "__main__":
    OUT.write_text(json.dumps(errors(), indent=1) + "\n", encoding="utf-8")
