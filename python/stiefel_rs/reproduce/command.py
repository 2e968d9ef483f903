"""The command line of the comparison."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Final

from tqdm import tqdm  # type: ignore[import-untyped]

from ..errors import StiefelError
from . import conjecture, control_points, exact, experiments, manifest, tables

EXIT_FAILURE: Final = 1
MAX_STEPS: Final = 1_000_000
REPETITIONS: Final = 7
QUICK_REPETITIONS: Final = 3
FIGURES: Final = 9


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
        "reproduce", help="write the tables and figures of arXiv 2404.19407"
    )
    parser.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="output folder (default: out)")
    default = ",".join(map(str, experiments.DEFAULT_STEPS))
    parser.add_argument(
        "--steps", type=_steps, metavar="N,N,...", help=f"numbers of steps, 2 or more each (default: {default})"
    )
    quick = ",".join(map(str, experiments.QUICK_STEPS))
    parser.add_argument("--quick", action="store_true", help=f"steps {quick} and fewer repetitions of the timing")


def write(folder: Path, steps: tuple[int, ...], repetitions: int, curves: int) -> int:
    """Write the tables, then the figures, then the manifest of both, and print where they are.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    table_folder, figure_folder = folder / "tables", folder / "figures"
    for path in (table_folder, figure_folder):
        path.mkdir(parents=True, exist_ok=True)
    # That of an earlier run would speak of files that are about to be replaced.
    (folder / manifest.NAME).unlink(missing_ok=True)
    total = len(steps) * len(experiments.EXPERIMENTS) + repetitions + 1 + FIGURES
    with tqdm(total=total, disable=not sys.stderr.isatty(), desc="reproduce", leave=False) as bar:

        def progress() -> None:
            bar.update()

        rows: dict[str, list[experiments.ErrorRow]] = {}
        for experiment in experiments.EXPERIMENTS:
            rows[experiment.name] = []
            for n in steps:
                rows[experiment.name].append(experiments.mean_errors(experiment, n))
                progress()
        results = tables.Results(rows, experiments.measure_times(steps, repetitions, progress))
        study = conjecture.measure(curves)
        written = {"tables": tables.write_all(table_folder, results) + conjecture.write_all(table_folder, study)}
        costs = exact.measure()
        written["tables"] += exact.write_tables(table_folder, costs, results)
        alternatives = control_points.measure()
        written["tables"] += control_points.write_tables(table_folder, alternatives)
        try:
            # Here, since matplotlib is optional and slow to import.
            from . import conjecture_figure, control_points_figure, exact_figure, figures  # noqa: PLC0415
        except ImportError as error:
            missing = error
        else:
            written["figures"] = figures.write_all(figure_folder, rows, progress)
            written["figures"] += exact_figure.write(figure_folder, costs, progress)
            written["figures"] += conjecture_figure.write(figure_folder, study)
            written["figures"] += control_points_figure.write(figure_folder, alternatives, progress)
    settings = {"steps": list(steps), "repetitions": repetitions, "curves": curves}
    record = manifest.write(folder, [path for paths in written.values() for path in paths], settings)
    for line in tables.headline(results):
        print(line)
    for name, paths in written.items():
        print(f"{name}: {len(paths)} files in {folder / name}")
    print(f"summary: {table_folder / 'summary.md'}")
    print(f"manifest: {record}")
    if "figures" not in written:
        print(f"stiefel-rs: no figures ({missing}): pip install 'stiefel-rs[plot]'", file=sys.stderr)
        return EXIT_FAILURE
    return 0


def run(arguments: argparse.Namespace) -> int:
    """Do what the command line says and return the exit code."""
    steps = arguments.steps or (experiments.QUICK_STEPS if arguments.quick else experiments.DEFAULT_STEPS)
    try:
        if arguments.quick:
            return write(arguments.out, steps, QUICK_REPETITIONS, conjecture.QUICK_RANDOM_CURVES)
        return write(arguments.out, steps, REPETITIONS, conjecture.RANDOM_CURVES)
    except BrokenPipeError:
        # Of what is printed, not of the folder.
        raise
    except OSError as error:
        print(f"stiefel-rs: cannot write to {arguments.out}: {error.strerror or error}", file=sys.stderr)
        return EXIT_FAILURE
    except StiefelError as error:
        print(f"stiefel-rs: {error}", file=sys.stderr)
        return EXIT_FAILURE
