"""Every table of a run, and the summary, written into one folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import astuple
from pathlib import Path

from .. import __version__
from . import any_shape, challenges, claims, conjecture, control_points, embedded, exact, retractions, summary
from .manifest import processor
from .measurements import Measurements
from .near_start import STEPS as NEAR_STEPS
from .paper_tables import write_paper_tables, write_wide_tables
from .readings import ERRORS
from .text import write_csv


def _near_start(folder: Path, found: Measurements) -> Path:
    rows = [
        (r.experiment.name, r.method, n, near, largest)
        for r in found.near_start
        for n, near, largest in zip(NEAR_STEPS, r.near, r.largest, strict=True)
    ]
    header = ["manifold", "method", "N", "error_near_start", "largest_error"]
    return write_csv(folder / "near_start.csv", header, rows)


def _readings(folder: Path, found: Measurements) -> Path:
    rows = [(r.experiment.name, r.name, *r.errors) for r in found.readings]
    return write_csv(folder / "readings.csv", ["manifold", "reading", *ERRORS], rows)


def _timing(folder: Path, found: Measurements) -> Path:
    header = ["manifold", "method", "N", "seconds_per_curve", "ratio_to_gcp"]
    return write_csv(folder / "timing.csv", header, map(astuple, found.timing))


def _equal_error(folder: Path, found: Measurements) -> Path:
    rows = [(x.manifold, x.method, x.steps or "", x.seconds or "", x.gcp_seconds or "") for x in found.equal_error]
    return write_csv(folder / "equal_error.csv", ["manifold", "method", "N", "seconds", "gcp_seconds"], rows)


def _shape_times(folder: Path, found: Measurements) -> Path:
    rows = [(r.n, r.k, r.build_seconds, r.point_seconds) for r in found.shapes]
    return write_csv(folder / "any_shape_times.csv", ["n", "k", "build_seconds", "point_seconds"], rows)


def _run(folder: Path, found: Measurements) -> Path:
    path = folder / "run.json"
    content = {"version": __version__, "processor": processor(), "text": found.settings.text()}
    path.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def write_all(folder: Path, found: Measurements) -> list[Path]:
    """Write every table and the summary into `folder`, which must exist; return the paths."""
    path = folder / "summary.md"
    path.write_text(summary.text(found), encoding="utf-8")
    tables: dict[str, tuple[Sequence[str], Iterable[Sequence[object]]]] = {
        "claims": (claims.CSV_HEADER, claims.csv_rows(found)),
        "challenges": challenges.csv_table(found.challenges),
        "conjecture_outcomes": (conjecture.HEADER, conjecture.csv_rows(found.study)),
        "cost": (exact.HEADER, exact.csv_rows(found.exact)),
        "any_shape": (any_shape.HEADER, any_shape.csv_rows(found.shapes)),
        "embedded": (embedded.HEADER, embedded.csv_rows(found.embedded)),
        "control_points": (control_points.HEADER, control_points.csv_rows(found.control_points)),
    }
    return [
        *write_paper_tables(folder, found.rows),
        *write_wide_tables(folder, found.rows),
        *retractions.write_table(folder, found.study),
        *(write(folder, found) for write in (_near_start, _readings, _timing, _equal_error, _shape_times, _run)),
        *(write_csv(folder / f"{name}.csv", header, rows) for name, (header, rows) in tables.items()),
        path,
    ]
