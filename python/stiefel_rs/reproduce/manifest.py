"""Settings, environment and file digests of a run of ``stiefel-rs reproduce``: ``manifest.json``."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
from collections.abc import Iterable, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, Final

import numpy as np

from .. import __version__, _core
from . import retractions

NAME: Final = "manifest.json"
REPORT: Final = "report.pdf"
FORMAT: Final = 1
# Files with wall clock times, which differ in each run.
MEASURED: Final = frozenset(
    {
        *("timing.csv", "equal_error.csv", "challenges.csv", "any_shape_times.csv", "claims.csv"),
        *("embedded.csv", "summary.md", REPORT),
    }
)


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def processor() -> str:
    """Name of the processor, as the system gives it."""
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        found = None
    return found[1].strip() if found else platform.processor() or platform.machine()


def digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def environment() -> dict[str, Any]:
    """Versions, processor and threads of this process."""
    return {
        "versions": {
            "stiefel-rs": __version__,
            "python": platform.python_version(),
            "numpy": np.__version__,
            "matplotlib": _version("matplotlib"),
        },
        "platform": platform.platform(),
        "processor": {"name": processor(), "count": os.cpu_count(), "simd": list(_core.simd_features())},
        "threads": _core.num_threads(),
    }


def _digests(folder: Path, paths: Iterable[Path]) -> dict[str, str]:
    return {path.relative_to(folder).as_posix(): digest(path) for path in sorted(paths)}


def build(folder: Path, written: Iterable[Path], settings: dict[str, Any]) -> dict[str, Any]:
    """Build the manifest of the files `written` below `folder`.

    Parameters
    ----------
    folder : Path
        Output folder of the run; names in the manifest are relative to it.
    written : iterable of Path
        The files, which must exist; duplicates count once.
    settings : dict
        Settings of the run that affect its numbers.

    Returns
    -------
    dict
        ``tables``, identical for runs with the same settings and versions on the same processor; ``measured``, files
        with wall clock times; ``figures``; and ``run``, settings and environment.
    """
    kinds: dict[str, set[Path]] = {"tables": set(), "measured": set(), "figures": set()}
    for path in written:
        figure = path.suffix in (".png", ".svg", ".pdf")
        kinds["measured" if path.name in MEASURED else "figures" if figure else "tables"].add(path)
    made = {"settings": {"seed": retractions.SEED, **settings}, **environment()}
    return {"format": FORMAT, "run": made, **{kind: _digests(folder, paths) for kind, paths in kinds.items()}}


def write(folder: Path, written: Sequence[Path], settings: dict[str, Any]) -> Path:
    """Write ``manifest.json`` into `folder` and return its path.

    Raises
    ------
    OSError
        A file cannot be read or written.
    """
    path = folder / NAME
    text = json.dumps(build(folder, written, settings), indent=2, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
    return path
