"""``stiefel-rs interpolate``: reads points or poses from a file, and writes a curve or samples of it."""

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
Compute a smooth curve through the points or poses in a file.

INPUT.npz holds points on a Stiefel manifold; the curve through them is saved. Its arrays:
  t        (N,)        increasing times
  S        (N, n, k)   points: matrices with orthonormal columns
  V        (N, n, k)   velocities at the points: for the Hermite kinds;
                       the first and last for --bc-type velocities
  weights  (N,)        for --kind smoothing, optional

Kinds
  riemannian         spline of Riemannian cubics, C2: the cost is stationary
  geometric          spline of de Casteljau curves, C2: close to the Riemannian spline
  hermite            Riemannian cubics with the given velocities, C1
  geometric-hermite  de Casteljau curves with the given velocities, C1
  smoothing          passes near the points: minimises misfit + lambda * cost

In Python, stiefel_rs.load reads OUTPUT.npz. With --rate, --num or --at the curve is also
evaluated, and a second file of plain arrays is written: t (T,), S (T, n, k), and the
velocity V and the covariant acceleration A of the same shape as S.

INPUT.tum and INPUT.csv hold poses, for the kinds riemannian and smoothing: positions and
orientations as unit quaternions, scalar last (qw). Quaternions rotate vectors from the
body frame to the world frame. Poses at the times of --rate, --num or --at are written to
OUTPUT.tum or OUTPUT.csv.
  .tum, .txt  lines: timestamp tx ty tz qx qy qz qw, in s and m
  .csv        a header names the columns, in any order: t x y z qx qy qz qw, in s and m
              or in units given in the header (t [ns]); orientations only: t qx qy qz qw
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
    """Return numbers as text with all digits, which the times of poses need."""
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
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of at least 0")
    return value


def add_parser(commands: Any) -> None:
    """Add the command to the subparsers of another."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "interpolate",
        help="compute a curve through the points or poses in a file",
        description=DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "input", type=Path, metavar="INPUT", help="points in a .npz file, or poses in a .tum or .csv file"
    )
    # A metavar, since the list of all kinds is wider than a page.
    parser.add_argument(
        "--kind", choices=KINDS, default=KINDS[0], metavar="KIND", help=f"one of the kinds (default: {KINDS[0]})"
    )
    parser.add_argument(
        "--out", type=_out, required=True, metavar="OUTPUT", help="file for the curve (.npz) or its poses (.tum, .csv)"
    )
    parser.add_argument("--bc-type", choices=BC_TYPES, help="end conditions of a spline (default: natural)")
    parser.add_argument(
        "--project",
        action="store_true",
        help="replace points with a defect of at most 0.1, such as rounded ones, by the nearest on the manifold",
    )
    parser.add_argument("--lam", type=_lam, help="lambda of --kind smoothing (default: by cross-validation)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--rate", type=_rate, metavar="HZ", help="evaluate at this rate, from the first time on")
    where.add_argument("--num", type=_count, metavar="T", help="evaluate at T equidistant times including both ends")
    where.add_argument("--at", type=_times, metavar="T,T,...", help="evaluate at these times")
    parser.add_argument(
        "--samples",
        type=_npz,
        metavar="SAMPLES.npz",
        help="file for the samples of a curve through points (default: OUTPUT_samples.npz)",
    )
    parser.add_argument(
        "--rates",
        action="store_true",
        help="also write velocities to OUTPUT.csv: vx vy vz in m/s (world frame), wx wy wz in rad/s (body frame)",
    )
    parser.add_argument(
        "--plot",
        type=_picture,
        metavar="FILE",
        help=f"file for a figure of the curve ({', '.join(PICTURES)}; default: {PICTURES[0]})",
    )
    parser.set_defaults(check=lambda arguments: _check(parser, arguments))


def _check(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Reject options without effect, and files that cannot be written, before any work."""
    if arguments.bc_type is not None and arguments.kind not in SPLINES:
        parser.error(f"--bc-type needs --kind {' or '.join(SPLINES)}, found {arguments.kind}")
    if arguments.lam is not None and arguments.kind != SMOOTHING:
        parser.error(f"--lam needs --kind {SMOOTHING}, found {arguments.kind}")
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
    """Reject options that have no effect on points."""
    if arguments.out.suffix != ".npz":
        parser.error(f"--out: {str(arguments.out)!r} does not end in .npz, which a curve through points needs")
    if arguments.rates:
        parser.error("--rates needs INPUT.tum or INPUT.csv; samples of curves through points always include velocities")
    if arguments.samples is not None and not _evaluates(arguments):
        parser.error("--samples needs --rate, --num or --at")


def _evaluates(arguments: argparse.Namespace) -> bool:
    return any(option is not None for option in (arguments.rate, arguments.num, arguments.at))


def _samples_path(arguments: argparse.Namespace) -> Path:
    path: Path = arguments.samples or arguments.out.with_name(f"{arguments.out.stem}_samples.npz")
    return path


def read(path: Path) -> Arrays:
    """Read the arrays of a file.

    Raises
    ------
    OSError
        The file cannot be read.
    InvalidInputError
        The file is not an archive of plain arrays.
    """
    try:
        # NumPy does not close a file that it cannot read, unless the caller opened it.
        with storage.naming(path), path.open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            if not isinstance(archive, np.ndarray):
                return {name: archive[name] for name in archive.files}
    except OSError:
        raise
    # Damaged bytes may raise any exception.
    except Exception as error:
        why = str(error) or type(error).__name__
        if "allow_pickle" in why:
            why = "it holds Python objects: save arrays of numbers"
        raise InvalidInputError(f"{path}: not an .npz archive of plain arrays ({why})") from error
    raise InvalidInputError(f"{path}: expected an .npz archive of t and S, found a single array")


def _array(arrays: Arrays, name: str, why: str) -> NDArray[Any]:
    if name not in arrays:
        found = ", ".join(arrays) or "none"
        raise InvalidInputError(f"{why} needs the array {name!r}; found: {found}")
    return arrays[name]


def build(
    arrays: Arrays, kind: str, bc_type: str | None = None, lam: float | None = None, *, project: bool = False
) -> Curve:
    """Construct a curve of the given kind through the points.

    Raises
    ------
    InvalidInputError
        An array is missing or invalid.
    OutsideDomainError, ConvergenceError
        No such curve exists, or none was found.
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
            raise InvalidInputError(f"V: expected shape (N, n, k), found {V.shape}")
        return CubicSpline(t, S, bc_type=((1, V[0]), (1, V[-1])), kind=SPLINES[kind], project=project)
    ends = cast(Literal["natural", "clamped", "periodic"], bc_type or "natural")
    return CubicSpline(t, S, bc_type=ends, kind=SPLINES[kind], project=project)


def evaluate(curve: Curve, t: Array) -> Arrays:
    """Return times, points, velocities and covariant accelerations."""
    return {"t": t, "S": curve(t), "V": curve.velocity(t), "A": curve.acceleration(t)}


def describe(curve: Curve, kind: str, knots: int) -> str:
    """Describe the curve in one line."""
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
    """Write the files, and report each as soon as it is written, since a later step may fail."""
    arrays = read(arguments.input)
    curve = build(arrays, arguments.kind, arguments.bc_type, arguments.lam, project=arguments.project)
    if arguments.plot is not None and curve.field == "complex":
        raise InvalidInputError("--plot draws real frames only, the points in the file are complex")
    t = _sample_times(arguments, curve)
    # Before anything is written: a time outside the curve raises.
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
        # Imported here, since matplotlib is optional and slow to import.
        from . import interpolate_figure  # noqa: PLC0415

        interpolate_figure.write(arguments.plot, curve, arrays["t"], arrays["S"])
        yield f"plot: {arguments.plot}"


def run(arguments: argparse.Namespace) -> int:
    """Run the command and return the exit code.

    Raises
    ------
    OSError
        A file cannot be read or written; without a file name, the standard output.
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
        return _fail(str(error).replace("curves take it with project=True", "--project accepts it"))
    return 0


def _fail(message: str) -> int:
    print(f"stiefel-rs: {message}", file=sys.stderr)
    return 1
