"""The command line of the comparison."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from tqdm import tqdm  # type: ignore[import-untyped]

from ..errors import StiefelError
from . import manifest, measurements, summary, write_tables
from .measurements import FULL, QUICK, Settings

EXIT_FAILURE: Final = 1
MAX_STEPS: Final = 1_000_000
FIGURES: Final = 13


def _steps(text: str) -> tuple[int, ...]:
    """Parse a comma-separated list of ``N``: distinct, in increasing order."""
    try:
        values = {int(part) for part in text.split(",")}
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a comma-separated list of integers") from None
    for value in values:
        if not 2 <= value <= MAX_STEPS:
            # With N = 1 the end point of the discrete flow does not depend on the unknown momenta.
            raise argparse.ArgumentTypeError(f"each N must be from 2 to {MAX_STEPS}, found {value}")
    return tuple(sorted(values))


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers of another."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "reproduce", help="recompute the statements, tables and figures of arXiv 2404.19407"
    )
    parser.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="output folder (default: out)")
    default = ",".join(map(str, FULL.steps))
    parser.add_argument(
        "--steps", type=_steps, metavar="N,N,...", help=f"numbers of steps, each at least 2 (default: {default})"
    )
    quick = ",".join(map(str, QUICK.steps))
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"steps {quick}, {QUICK.curves} random curves instead of {FULL.curves}, fewer repetitions of the timing",
    )
    parser.add_argument("--report", action="store_true", help="also write report.pdf (extra: report)")


def _draw(folder: Path, found: measurements.Measurements, progress: Callable[[], None]) -> list[Path]:
    """Write every figure and return the paths.

    Raises
    ------
    ImportError
        matplotlib is not installed.
    """
    # Imported here, since matplotlib is optional and slow to import.
    from . import conjecture_figure, control_points_figure, exact_figure, figures, paper_figures  # noqa: PLC0415

    paths = paper_figures.write_all(folder, found.rows, progress)
    paths += figures.write_all(folder, found.rows, progress)
    paths += exact_figure.write(folder, found.exact, progress)
    paths += conjecture_figure.write(folder, found.study)
    return paths + control_points_figure.write(folder, found.control_points, progress)


def _say(folder: Path, found: measurements.Measurements, written: dict[str, list[Path]], record: Path) -> None:
    for line in summary.headline(found):
        print(line)
    for name in ("tables", "figures"):
        if name in written:
            print(f"{name}: {len(written[name])} files in {folder / name}")
    print(f"summary: {folder / 'tables' / 'summary.md'}")
    for path in written.get("report", []):
        print(f"report: {path}")
    print(f"manifest: {record}")


def write(folder: Path, settings: Settings, *, report: bool = False) -> int:
    """Write the tables, the figures and the report, then the manifest, and print where they are.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    for name in ("tables", "figures"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    # Files of an earlier run describe files that this run replaces.
    for name in (manifest.NAME, manifest.REPORT):
        (folder / name).unlink(missing_ok=True)
    missing: ImportError | None = None
    total = measurements.steps_of_progress(settings) + FIGURES
    with tqdm(total=total, disable=not sys.stderr.isatty(), desc="reproduce", leave=False) as bar:
        found = measurements.measure(settings, bar.update)
        written = {"tables": write_tables.write_all(folder / "tables", found)}
        try:
            written["figures"] = _draw(folder / "figures", found, bar.update)
            if report:
                from . import pdf  # noqa: PLC0415

                written["report"] = [pdf.write(folder)]
        except ImportError as error:
            missing = error
    record = manifest.write(folder, [path for paths in written.values() for path in paths], settings.record())
    _say(folder, found, written, record)
    if missing is not None:
        what, extra = ("report", "report") if "figures" in written else ("figures", "plot")
        print(f"stiefel-rs: no {what} ({missing}): pip install 'stiefel-rs[{extra}]'", file=sys.stderr)
        return EXIT_FAILURE
    return 0


def run(arguments: argparse.Namespace) -> int:
    """Run the command and return the exit code."""
    settings = QUICK if arguments.quick else FULL
    if arguments.steps:
        settings = replace(settings, steps=arguments.steps)
    try:
        return write(arguments.out, settings, report=arguments.report)
    except BrokenPipeError:
        # An error of the standard output, not of the folder.
        raise
    except OSError as error:
        print(f"stiefel-rs: cannot write to {arguments.out}: {error.strerror or error}", file=sys.stderr)
        return EXIT_FAILURE
    except StiefelError as error:
        print(f"stiefel-rs: {error}", file=sys.stderr)
        return EXIT_FAILURE
