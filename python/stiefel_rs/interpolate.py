"""``stiefel-rs interpolate``: points or poses from a file, a curve or samples of it into another."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, Literal, cast

import numpy as np
from numpy.typing import NDArray

from . import _core, interpolate_poses, storage
from ._core import CubicHermite, CubicSpline, Curve
from .errors import InvalidInputError, StiefelError
from .sample_times import MAX_SAMPLES, at_rate

Array = NDArray[np.float64]
Arrays = dict[str, NDArray[Any]]
Kind = Literal["riemannian", "geometric"]
HERMITE: Final[dict[str, Kind]] = {"hermite": "riemannian", "geometric-hermite": "geometric"}
SPLINES: Final[dict[str, Kind]] = {"riemannian": "riemannian", "geometric": "geometric"}
SMOOTHING: Final = interpolate_poses.SMOOTHING
KINDS: Final = (*SPLINES, *HERMITE, SMOOTHING)
BC_TYPES: Final = ("natural", "clamped", "periodic", "velocities")
PICTURES: Final = (".png", ".pdf", ".svg")

DESCRIPTION: Final = """\
Join the points or poses of a file by a curve.

INPUT.npz is joined by a curve on a Stiefel manifold, which is saved. It holds the arrays
  t        (N,)        times, increasing
  S        (N, n, k)   points: matrices with orthonormal columns
  V        (N, n, k)   velocities at the points: for the Hermite kinds;
                       the first and last for --bc-type velocities
  weights  (N,)        for --kind smoothing, if wanted

Kinds
  riemannian         spline of Riemannian cubics, C2: stationary cost through the points
  geometric          spline of de Casteljau curves, C2: near to it
  hermite            Riemannian cubics with the given velocities, C1
  geometric-hermite  de Casteljau curves with the given velocities, C1
  smoothing          passes by the points: least misfit plus lambda times cost

OUTPUT.npz is what Python's stiefel_rs.load reads. With --rate, --num or --at the curve
is evaluated too, into a second file of plain arrays: t (T,), S (T, n, k), and the
velocity V and the covariant acceleration A of the same shape.

INPUT.tum and INPUT.csv hold poses, of kind riemannian or smoothing. They are written at
the times of --rate, --num or --at to OUTPUT.tum or OUTPUT.csv.
  .tum, .txt  lines: timestamp tx ty tz qx qy qz qw, in s and m
  .csv        a header names the columns, in any order: t x y z qx qy qz qw, in s and m
              or in units that it names, as t [ns]; orientations only: t qx qy qz qw
"""


def _out(text: str) -> Path:
    path = Path(text)
    if path.suffix != ".npz" and not interpolate_poses.is_trajectory(path):
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .npz, .tum, .txt or .csv")
    return path


def _npz(text: str) -> Path:
    path = Path(text)
    if path.suffix != ".npz":
        raise argparse.ArgumentTypeError(f"{text!r} does not end in .npz")
    return path


def _picture(text: str) -> Path:
    path = Path(text)
    if not path.suffix:
        return path.with_name(f"{path.name.rstrip('.')}{PICTURES[0]}")
    if path.suffix.lower() not in PICTURES:
        raise argparse.ArgumentTypeError(f"{text!r} does not end in {', '.join(PICTURES[:-1])} or {PICTURES[-1]}")
    return path


def _times(text: str) -> list[str]:
    """Numbers with all their digits, which the times of poses need."""
    parts = [part.strip() for part in text.split(",")]
    try:
        for part in parts:
            float(part)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a comma-separated list of numbers") from None
    return parts


def _count(text: str) -> int:
    if text.isascii() and text.isdigit() and 2 <= int(text) <= MAX_SAMPLES:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 2 to {MAX_SAMPLES}")


def _rate(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < np.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return value


def _lam(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not value >= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of zero or more")
    return value


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers of another."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "interpolate",
        help="a curve through the points or poses of a file",
        description=DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "input", type=Path, metavar="INPUT", help="points in an .npz file, poses in a .tum or .csv file"
    )
    # By a word: all of them in a row are wider than a page.
    parser.add_argument(
        "--kind", choices=KINDS, default=KINDS[0], metavar="KIND", help=f"one of the kinds (default: {KINDS[0]})"
    )
    parser.add_argument(
        "--out", type=_out, required=True, metavar="OUTPUT", help="where the curve (.npz) or its poses (.tum, .csv) go"
    )
    parser.add_argument("--bc-type", choices=BC_TYPES, help="ends of a spline (default: natural)")
    parser.add_argument(
        "--project",
        action="store_true",
        help="replace points that are off the manifold by up to 0.1, such as rounded ones, by the nearest ones",
    )
    parser.add_argument("--lam", type=_lam, help="lambda of --kind smoothing (default: by cross-validation)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--rate", type=_rate, metavar="HZ", help="evaluate so often in a second, from the first time on")
    where.add_argument("--num", type=_count, metavar="T", help="evaluate at T equidistant times, both ends included")
    where.add_argument("--at", type=_times, metavar="T,T,...", help="evaluate at these times")
    parser.add_argument(
        "--samples",
        type=_npz,
        metavar="SAMPLES.npz",
        help="where that goes for points (default: OUTPUT_samples.npz)",
    )
    parser.add_argument(
        "--rates",
        action="store_true",
        help="velocities in OUTPUT.csv too: vx vy vz in m/s in the world's frame, wx wy wz in rad/s in the body's",
    )
    parser.add_argument(
        "--plot",
        type=_picture,
        metavar="FILE",
        help=f"figure of the curve ({', '.join(PICTURES)}; default: {PICTURES[0]})",
    )
    parser.set_defaults(check=lambda arguments: _check(parser, arguments))


def _check(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Refuse options that would be without effect, and files that could not be written, before any work."""
    if arguments.bc_type is not None and arguments.kind not in SPLINES:
        parser.error(f"--bc-type goes with --kind {' or '.join(SPLINES)}, not {arguments.kind}")
    if arguments.lam is not None and arguments.kind != SMOOTHING:
        parser.error(f"--lam goes with --kind {SMOOTHING}, not {arguments.kind}")
    poses = interpolate_poses.is_trajectory(arguments.input)
    (interpolate_poses.check if poses else _check_points)(parser, arguments)
    name = f"INPUT{arguments.input.suffix.lower()}" if poses else "INPUT.npz"
    files = [(name, arguments.input), ("--out", arguments.out), ("--plot", arguments.plot)]
    if not poses and _evaluates(arguments):
        files.append(("--samples", _samples_path(arguments)))
    named: dict[Path, str] = {}
    for name, path in files:
        if path is not None and (other := named.setdefault(path.resolve(), name)) != name:
            parser.error(f"{other} and {name} are the same file: {path}")
    for name, path in files[1:]:
        if path is not None and not path.parent.is_dir():
            parser.error(f"{name}: there is no folder {path.parent}")
        if path is not None and path.is_dir():
            parser.error(f"{name}: {path} is a folder")


def _check_points(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Refuse options that have no effect on points."""
    if arguments.out.suffix != ".npz":
        parser.error(f"--out: {str(arguments.out)!r} does not end in .npz, as the curve through points does")
    if arguments.rates:
        parser.error("--rates needs INPUT.tum or INPUT.csv; the samples of points have their velocities")
    if arguments.samples is not None and not _evaluates(arguments):
        parser.error("--samples needs --rate, --num or --at")


def _evaluates(arguments: argparse.Namespace) -> bool:
    return any(option is not None for option in (arguments.rate, arguments.num, arguments.at))


def _samples_path(arguments: argparse.Namespace) -> Path:
    path: Path = arguments.samples or arguments.out.with_name(f"{arguments.out.stem}_samples.npz")
    return path


def read(path: Path) -> Arrays:
    """Arrays of a file.

    Raises
    ------
    OSError
        The file cannot be read.
    InvalidInputError
        It is no archive of plain arrays.
    """
    try:
        # NumPy leaves a file open that it cannot read, unless the file is its caller's.
        with storage.naming(path), path.open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            if not isinstance(archive, np.ndarray):
                return {name: archive[name] for name in archive.files}
    except OSError:
        raise
    # Whatever a reader of archives makes of damaged bytes.
    except Exception as error:
        why = str(error) or type(error).__name__
        if "allow_pickle" in why:
            why = "it holds Python objects: save arrays of numbers"
        raise InvalidInputError(f"{path}: not an .npz archive of plain arrays ({why})") from error
    raise InvalidInputError(f"{path}: one array, where an .npz archive of t and S is needed")


def _array(arrays: Arrays, name: str, why: str) -> NDArray[Any]:
    if name not in arrays:
        found = ", ".join(arrays) or "none"
        raise InvalidInputError(f"no array {name!r}, which {why} needs; the file has: {found}")
    return arrays[name]


def build(
    arrays: Arrays, kind: str, bc_type: str | None = None, lam: float | None = None, *, project: bool = False
) -> Curve:
    """Curve of the given kind through the points.

    Raises
    ------
    InvalidInputError
        An array is missing, or wrong.
    OutsideDomainError, ConvergenceError
        There is no such curve, or it was not found.
    """
    why = f"--kind {kind}"
    t, S = _array(arrays, "t", why), _array(arrays, "S", why)
    if kind in HERMITE:
        return CubicHermite(t, S, _array(arrays, "V", why), kind=HERMITE[kind], project=project)
    if kind == SMOOTHING:
        return _core.SmoothingSpline(t, S, weights=arrays.get("weights"), lam=lam, project=project)
    if bc_type == "velocities":
        V = _array(arrays, "V", f"--bc-type {bc_type}")
        if V.ndim != 3 or len(V) < 2:
            raise InvalidInputError(f"V: shape (N, n, k) expected, found {V.shape}")
        return CubicSpline(t, S, bc_type=((1, V[0]), (1, V[-1])), kind=SPLINES[kind], project=project)
    ends = cast(Literal["natural", "clamped", "periodic"], bc_type or "natural")
    return CubicSpline(t, S, bc_type=ends, kind=SPLINES[kind], project=project)


def evaluate(curve: Curve, t: Array) -> Arrays:
    """Return times, points, velocities and covariant accelerations."""
    return {"t": t, "S": curve(t), "V": curve.velocity(t), "A": curve.acceleration(t)}


def describe(curve: Curve, kind: str, knots: int) -> str:
    """Say what was found, in a line."""
    field = ",C" if curve.field == "complex" else ""
    parts = [f"St({curve.n},{curve.k}{field}), {knots} points, {kind}: cost {curve.cost():.6g}"]
    report = getattr(curve, "report", None)
    if report is not None and hasattr(report, "iterations"):
        parts.append(f"{report.iterations} iterations")
    if kind == SMOOTHING:
        parts.append(f"lambda {curve.lam:.3g}")  # type: ignore[attr-defined]
    return ", ".join(parts)


def _sample_times(arguments: argparse.Namespace, curve: Curve) -> Array | None:
    first, last = curve.t_span
    if arguments.rate is not None:
        return np.minimum(first + at_rate(last - first, arguments.rate), last)
    if arguments.num is not None:
        return np.linspace(first, last, arguments.num)
    return None if arguments.at is None else np.array([float(time) for time in arguments.at])


def _write(arguments: argparse.Namespace) -> Iterator[str]:
    """Write the files, and name each once it is there: what follows may fail."""
    arrays = read(arguments.input)
    curve = build(arrays, arguments.kind, arguments.bc_type, arguments.lam, project=arguments.project)
    if arguments.plot is not None and curve.field == "complex":
        raise InvalidInputError("--plot draws real frames, the points of the file are complex")
    t = _sample_times(arguments, curve)
    # Before anything is written: a time outside of the curve is an error.
    samples = None if t is None else evaluate(curve, t)
    curve.save(arguments.out)
    yield describe(curve, arguments.kind, len(arrays["t"]))
    yield f"curve: {arguments.out}"
    if samples is not None:
        path = _samples_path(arguments)
        with storage.replacing(path) as file:
            np.savez(file, **cast(Any, samples))
        yield f"samples: {path}, {len(samples['t'])} times"
    if arguments.plot is not None:
        # Here, since matplotlib is optional and slow to import.
        from . import interpolate_figure  # noqa: PLC0415

        interpolate_figure.write(arguments.plot, curve, arrays["t"], arrays["S"])
        yield f"plot: {arguments.plot}"


def run(arguments: argparse.Namespace) -> int:
    """Do what the command line says and return the exit code.

    Raises
    ------
    OSError
        A file cannot be read or written; without its name, what is printed cannot be.
    """
    poses = interpolate_poses.is_trajectory(arguments.input)
    try:
        for line in (interpolate_poses.write if poses else _write)(arguments):
            print(line)
    except ImportError as error:
        if poses:
            return _fail(str(error))
        return _fail(f"no figure ({error}): pip install 'stiefel-rs[plot]'")
    except (StiefelError, ValueError, TypeError) as error:
        return _fail(str(error).replace("curves take it with project=True", "--project takes it"))
    return 0


def _fail(message: str) -> int:
    print(f"stiefel-rs: {message}", file=sys.stderr)
    return 1
