"""Figures as files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from .. import figure_style
from ..errors import InvalidInputError

FORMATS: Final = (".svg", ".png", ".pdf")


def save(figure: Figure | Axes, path: str | os.PathLike[str]) -> None:
    """Write a figure in print size, in the format that the name of the file says.

    Parameters
    ----------
    figure : Figure or Axes
        A figure, or axes of one.
    path : path-like
        Name that ends in ``.svg`` (no background; browsers show text, axes and grid light on dark pages), ``.png`` (200
        dots per inch) or ``.pdf``. An existing file is replaced.

    Raises
    ------
    InvalidInputError
        `figure` is neither, or the name has another ending.
    OSError
        The file cannot be written.
    """
    found: Any = figure.figure if isinstance(figure, Axes) else figure
    if not isinstance(found, FigureBase):
        raise InvalidInputError(f"figure: a Figure or Axes expected, found {type(figure).__name__}")
    place = Path(path)
    if place.suffix.lower() not in FORMATS:
        raise InvalidInputError(f"path: a name that ends in {', '.join(FORMATS)} expected, found {place.name!r}")
    # Of a part of a figure the whole.
    whole: Any = found.figure
    figure_style.write(whole, place)
