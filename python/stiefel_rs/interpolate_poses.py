"""``stiefel-rs interpolate`` for trajectories: reads poses from a text file, and writes samples of their curve."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from . import trajectory_files
from .errors import InvalidInputError, StiefelError
from .sample_times import at_rate
from .trajectory_files import CSV_SUFFIX, EXACT, TUM_SUFFIXES, Recording

Array = NDArray[np.float64]
SUFFIXES: Final = (*TUM_SUFFIXES, CSV_SUFFIX)
SMOOTHING: Final = "smoothing"
KINDS: Final = ("riemannian", SMOOTHING)
BC_TYPES: Final = ("natural", "clamped", "periodic")
LINEAR: Final = ("vx", "vy", "vz")
ANGULAR: Final = ("wx", "wy", "wz")


def is_trajectory(path: Path) -> bool:
    """Whether the name of a file says that it holds poses."""
    return path.suffix.lower() in SUFFIXES


def check(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Reject options that have no effect on poses."""
    name = f"INPUT{arguments.input.suffix.lower()}"
    if arguments.kind not in KINDS:
        parser.error(f"--kind {arguments.kind} needs INPUT.npz; for {name}: {' or '.join(KINDS)}")
    if arguments.bc_type not in (None, *BC_TYPES):
        parser.error(f"--bc-type {arguments.bc_type} needs INPUT.npz; for {name}: {', '.join(BC_TYPES)}")
    for option in ("samples", "plot"):
        if getattr(arguments, option) is not None:
            parser.error(f"--{option} needs INPUT.npz")
    if not is_trajectory(arguments.out):
        parser.error(f"--out: {str(arguments.out)!r} does not end in {', '.join(TUM_SUFFIXES)} or {CSV_SUFFIX}")
    if arguments.project:
        parser.error("--project needs INPUT.npz; quaternions are normalised anyway")
    if arguments.rate is arguments.num is arguments.at is None:
        parser.error(f"{name} needs --rate, --num or --at")
    if arguments.rates and arguments.out.suffix.lower() != CSV_SUFFIX:
        parser.error(f"--rates needs OUTPUT{CSV_SUFFIX}: TUM files have no columns for velocities")


def write(arguments: argparse.Namespace) -> Iterator[str]:
    """Write the file, and yield lines about it."""
    found, out = trajectory_files.read(arguments.input), arguments.out
    suffix = trajectory_files.suffix_of(out)
    if found.positions is None and suffix != CSV_SUFFIX:
        raise InvalidInputError(
            f"{arguments.input}: no positions, which {out} needs; write a {CSV_SUFFIX} file instead"
        )
    offsets, stamps = _samples(arguments, found.stamps)
    spline = build(found, arguments.kind, arguments.bc_type, arguments.lam)
    poses = spline(offsets)
    quaternions, positions = poses if isinstance(poses, tuple) else (poses, None)
    others = _rates(spline, offsets, positions is not None) if arguments.rates else {}
    trajectory_files.write(out, stamps, quaternions, positions, suffix=suffix, others=others)
    what = "rotations" if positions is None else "poses"
    yield f"{len(found.stamps)} {what} in {_offset(found.stamps[-1], found.stamps[0]):.6g} s, {arguments.kind}"
    yield f"{what}: {out}, {len(stamps)} times"


def build(found: Recording, kind: str, bc_type: str | None = None, lam: float | None = None) -> Any:
    """Make a spline of the poses in a file, with times counted from the first.

    Raises
    ------
    InvalidInputError
        The poses are invalid.
    OutsideDomainError, ConvergenceError
        No such curve exists, or none was found.
    ImportError
        SciPy, which splines of positions need, is not installed.
    """
    # Imported here, since SciPy is optional and slow to import.
    from .pose import PoseSpline  # noqa: PLC0415
    from .rotation import RotationSpline  # noqa: PLC0415

    spline: Any = RotationSpline if found.positions is None else PoseSpline
    t = np.array([_offset(stamp, found.stamps[0]) for stamp in found.stamps])
    try:
        if kind == SMOOTHING:
            return spline.smoothing(t, found.poses, lam=lam)
        return spline(t, found.poses, bc_type or BC_TYPES[0])
    except StiefelError as error:
        if error.knot is not None:
            line = found.lines[error.knot]
            error.args = (f"{found.name}, line {line}: {error.args[0]}", *error.args[1:])
        raise


def _offset(stamp: Decimal, first: Decimal) -> float:
    # Exact: float64 resolves time stamps of 1e9 s to 1.2e-7 s only.
    return float(EXACT.subtract(stamp, first))


def _samples(arguments: argparse.Namespace, knots: Sequence[Decimal]) -> tuple[Array, list[str]]:
    """Return the times to evaluate at, counted from the first knot, and the time stamps as text."""
    first, last = knots[0], knots[-1]
    span = _offset(last, first)
    if arguments.at is not None:
        try:
            stamps = [EXACT.create_decimal(text) for text in arguments.at]
        except ArithmeticError as error:
            raise InvalidInputError(f"--at: not times in digits: {', '.join(arguments.at)}") from error
        for stamp in stamps:
            if not (stamp.is_finite() and first <= stamp <= last):
                raise InvalidInputError(f"--at: {stamp} s is outside the times of the poses, {first} to {last} s")
        if any(after <= before for before, after in itertools.pairwise(stamps)):
            raise InvalidInputError("--at: the times of poses must increase")
        offsets = np.array([_offset(stamp, first) for stamp in stamps])
    else:
        offsets = np.linspace(0, span, arguments.num) if arguments.rate is None else at_rate(span, arguments.rate)
        stamps = [EXACT.add(first, Decimal(repr(offset))) for offset in offsets.tolist()]
    return offsets, [_text(stamp) for stamp in stamps]


def _text(stamp: Decimal) -> str:
    """Return the shortest digits of a float64 if they are exact, else all digits."""
    short = repr(float(stamp))
    return short if Decimal(short) == stamp else str(stamp)


def _rates(spline: Any, t: Array, positions: bool) -> dict[str, Array]:
    """Return columns of velocities: linear in the world frame, in m/s, and angular in the body frame, in rad/s."""
    columns = dict(zip(LINEAR, spline.linear_velocity(t, frame="world").T, strict=True)) if positions else {}
    return columns | dict(zip(ANGULAR, spline.angular_velocity(t, frame="body").T, strict=True))
