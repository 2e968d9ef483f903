"""The command ``stiefel-rs``."""

from __future__ import annotations

import argparse
import os
import platform
import sys
from pathlib import Path
from typing import Final

import numpy as np
from tqdm import tqdm  # type: ignore[import-untyped]

from . import __version__, _core, conjecture, control_points, exact, explore, interpolate, manifest, paper, report
from .errors import StiefelError

EXIT_FAILURE: Final = 1
EXIT_INTERRUPTED: Final = 130
# As a shell names a program that ended with SIGPIPE.
EXIT_BROKEN_PIPE: Final = 141
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


def parser() -> argparse.ArgumentParser:
    """Build the argument parser of the command."""
    top = argparse.ArgumentParser(prog="stiefel-rs", description="Smooth curves on Stiefel manifolds.")
    top.add_argument("--version", action="version", version=f"stiefel-rs {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    reproduce = commands.add_parser("reproduce", help="write the tables and figures of arXiv 2404.19407")
    reproduce.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="output folder (default: out)")
    default = ",".join(map(str, paper.DEFAULT_STEPS))
    reproduce.add_argument(
        "--steps", type=_steps, metavar="N,N,...", help=f"numbers of steps, 2 or more each (default: {default})"
    )
    quick = ",".join(map(str, paper.QUICK_STEPS))
    reproduce.add_argument("--quick", action="store_true", help=f"steps {quick} and fewer repetitions of the timing")
    interpolate.add_parser(commands)
    explore.add_parser(commands)
    commands.add_parser("info", help="versions, threads and CPU features")
    return top


def info() -> int:
    """Print versions, threads and CPU features."""
    lines = {
        "stiefel-rs": __version__,
        "Python": platform.python_version(),
        "NumPy": np.__version__,
        "platform": platform.platform(),
        "threads": _core.num_threads(),
        "SIMD": " ".join(_core.simd_features()) or "none",
    }
    for name, value in lines.items():
        print(f"{name + ':':<12}{value}")
    return 0


def reproduce(folder: Path, steps: tuple[int, ...], repetitions: int, curves: int) -> int:
    """Write the tables, then the figures, then the manifest of both, and print where they are.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    tables, figures = folder / "tables", folder / "figures"
    for path in (tables, figures):
        path.mkdir(parents=True, exist_ok=True)
    # That of an earlier run would speak of files that are about to be replaced.
    (folder / manifest.NAME).unlink(missing_ok=True)
    total = len(steps) * len(paper.EXPERIMENTS) + repetitions + 1 + FIGURES
    with tqdm(total=total, disable=not sys.stderr.isatty(), desc="reproduce", leave=False) as bar:

        def progress() -> None:
            bar.update()

        rows: dict[str, list[paper.ErrorRow]] = {}
        for experiment in paper.EXPERIMENTS:
            rows[experiment.name] = []
            for n in steps:
                rows[experiment.name].append(paper.mean_errors(experiment, n))
                progress()
        results = report.Results(rows, paper.measure_times(steps, repetitions, progress))
        study = conjecture.measure(curves)
        written = {"tables": report.write_all(tables, results) + conjecture.write_all(tables, study)}
        costs = exact.measure()
        written["tables"] += exact.write_tables(tables, costs, results)
        alternatives = control_points.measure()
        written["tables"] += control_points.write_tables(tables, alternatives)
        try:
            # Here, since matplotlib is optional and slow to import.
            from . import conjecture_figure, control_points_figure, exact_figure, paper_figures  # noqa: PLC0415
        except ImportError as error:
            missing = error
        else:
            written["figures"] = paper_figures.write_all(figures, rows, progress)
            written["figures"] += exact_figure.write(figures, costs, progress)
            written["figures"] += conjecture_figure.write(figures, study)
            written["figures"] += control_points_figure.write(figures, alternatives, progress)
    settings = {"steps": list(steps), "repetitions": repetitions, "curves": curves}
    record = manifest.write(folder, [path for paths in written.values() for path in paths], settings)
    for line in report.headline(results):
        print(line)
    for name, paths in written.items():
        print(f"{name}: {len(paths)} files in {folder / name}")
    print(f"summary: {tables / 'summary.md'}")
    print(f"manifest: {record}")
    if "figures" not in written:
        print(f"stiefel-rs: no figures ({missing}): pip install 'stiefel-rs[plot]'", file=sys.stderr)
        return EXIT_FAILURE
    return 0


def _reproduce(arguments: argparse.Namespace) -> int:
    steps = arguments.steps or (paper.QUICK_STEPS if arguments.quick else paper.DEFAULT_STEPS)
    try:
        if arguments.quick:
            return reproduce(arguments.out, steps, QUICK_REPETITIONS, conjecture.QUICK_RANDOM_CURVES)
        return reproduce(arguments.out, steps, REPETITIONS, conjecture.RANDOM_CURVES)
    except BrokenPipeError:
        # Of what is printed, not of the folder.
        raise
    except OSError as error:
        print(f"stiefel-rs: cannot write to {arguments.out}: {error.strerror or error}", file=sys.stderr)
        return EXIT_FAILURE
    except StiefelError as error:
        print(f"stiefel-rs: {error}", file=sys.stderr)
        return EXIT_FAILURE


def _run(argv: list[str] | None) -> int:
    arguments = parser().parse_args(argv)
    match arguments.command:
        case "info":
            return info()
        case "interpolate":
            arguments.check(arguments)
            return interpolate.run(arguments)
        case "explore":
            arguments.check(arguments)
            return explore.run(arguments)
        case _:
            return _reproduce(arguments)


def _unwritten(error: OSError) -> int:
    """Say what could not be read or written; a file has a name, the output has none."""
    if error.filename is None:
        # Else Python tries to write the rest of it when it ends, and fails with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return EXIT_BROKEN_PIPE
    print(f"stiefel-rs: {error.filename or 'standard output'}: {error.strerror or error}", file=sys.stderr)
    return EXIT_FAILURE


def main(argv: list[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process) and return its exit code."""
    try:
        try:
            return _run(argv)
        finally:
            # Here, where its failure can be told; there is no output where it was closed.
            if sys.stdout is not None:
                sys.stdout.flush()
    except KeyboardInterrupt:
        print("stiefel-rs: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    except OSError as error:
        return _unwritten(error)
