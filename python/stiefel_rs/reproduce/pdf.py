"""``report.pdf`` from the tables and figures of a run, by Typst. Importing this module imports typst."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import typst

from .manifest import REPORT

TEMPLATE: Final = Path(__file__).with_name("report.typ")


@contextmanager
def _source(folder: Path) -> Iterator[Path]:
    """Copy the template into `folder`, since Typst reads only files below its root."""
    with TemporaryDirectory(dir=folder) as place:
        yield Path(shutil.copy(TEMPLATE, place))


def pages(folder: Path, ppi: float) -> list[bytes]:
    """Return the pages of the report on the run in `folder` as PNG images."""
    with _source(folder) as source:
        found = typst.compile(source, root=folder, format="png", ppi=ppi)
    return found if isinstance(found, list) else [found]


def write(folder: Path) -> Path:
    """Write the report on the run in `folder`, which must have its tables and figures; return the path."""
    path = folder / REPORT
    with _source(folder) as source:
        typst.compile(source, output=path, root=folder)
    return path
