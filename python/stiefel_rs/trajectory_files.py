"""Trajectories in text files: the TUM format, and CSV with a header.

Quaternions are scalar last and rotate vectors from the body frame to the world frame, as in SciPy; times are in
seconds, positions in metres.
"""

from __future__ import annotations

import decimal
import itertools
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import storage
from .errors import InvalidInputError
from .pose_arrays import as_components, floats, unit_quaternions
from .trajectory_columns import CSV_NAMES, TUM, TUM_NAMES, Layout, csv_layout

__all__ = ["read_trajectory", "read_tum", "write_trajectory", "write_tum"]

Array = NDArray[np.float64]
PathLike = str | os.PathLike[str]

TUM_SUFFIXES: Final = (".tum", ".txt")
CSV_SUFFIX: Final = ".csv"

# Three thousand years in seconds. Larger times are nanoseconds without a unit.
LATEST: Final = 1e11
# Enough digits to add a float64 to a time stamp of 1e9 s, whatever the context of the user.
EXACT: Final = decimal.Context(prec=50)
# Number of rows formatted at once.
_CHUNK: Final = 4096


@dataclass(frozen=True)
class Recording:
    """Poses of a file, with exact time stamps.

    Attributes
    ----------
    name : str
        Name of the file.
    lines : list of int
        Line number of each pose.
    stamps : list of Decimal
        Increasing times in seconds.
    quaternions : numpy.ndarray, shape (N, 4)
    positions : numpy.ndarray, shape (N, 3), or None
        In metres; None for a file of orientations.
    """

    name: str
    lines: list[int]
    stamps: list[Decimal]
    quaternions: Array
    positions: Array | None

    @property
    def t(self) -> Array:
        """Times in seconds, shape (N,).

        Raises
        ------
        InvalidInputError
            Two times are the same float64.
        """
        times = np.array([float(stamp) for stamp in self.stamps])
        for i in np.flatnonzero(np.diff(times) <= 0)[:1]:
            raise _wrong_time(self, i, "is the same as", " for a float; count times from a closer origin")
        return times

    @property
    def poses(self) -> Any:
        """Pair (quaternions, positions), or quaternions alone."""
        return self.quaternions if self.positions is None else (self.quaternions, self.positions)


def read_tum(path: PathLike) -> tuple[Array, tuple[Array, Array]]:
    r"""Read a trajectory in the TUM format.

    Lines hold ``timestamp tx ty tz qx qy qz qw``, separated by blanks; empty lines and lines that start with ``#`` are
    skipped.

    Parameters
    ----------
    path : str or os.PathLike
        Name of the file, of any suffix.

    Returns
    -------
    t : numpy.ndarray, shape (N,)
        Increasing time stamps in seconds. At 1e9 s, neighbouring float64 numbers are 1.2e-7 s apart.
    poses : tuple of numpy.ndarray
        Quaternions (N, 4), scalar last, and positions (N, 3) in metres, ready for ``PoseSpline(t, poses)``. Quaternions
        are normalised, since files often have four decimals; those whose norm is 1 up to rounding are returned
        unchanged. Signs are kept.

    Raises
    ------
    InvalidInputError
        Wrong number of columns, an entry that is not a finite number, a quaternion whose norm differs from 1 by more
        than 0.01, times that do not increase, or no poses. The message names the file, the line and the number.
    OSError
        The file cannot be read.

    See Also
    --------
    write_tum, read_trajectory

    Examples
    --------
    >>> import os, tempfile
    >>> import stiefel_rs
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "poses.tum")
    ...     with open(path, "w") as file:
    ...         _ = file.write("0.0 1 2 3 0 0 0 1\n0.5 1 2 4 0 0 0.6 0.8\n")
    ...     t, (quaternions, positions) = stiefel_rs.read_tum(path)
    >>> t
    array([0. , 0.5])
    >>> positions[1], quaternions[1]
    (array([1., 2., 4.]), array([0. , 0. , 0.6, 0.8]))
    """
    found = read(path, TUM_SUFFIXES[0])
    return found.t, found.poses


def write_tum(path: PathLike, t: ArrayLike, poses: Any) -> None:
    """Write a trajectory in the TUM format.

    Parameters
    ----------
    path : str or os.PathLike
        Name of the file. An existing file is replaced once the new one is complete, with the same permissions, and
        stays as it is if writing fails.
    t : array_like, shape (N,)
        Increasing times in seconds.
    poses : tuple, scipy.spatial.transform.RigidTransform or array_like
        A pair (rotations, positions): unit quaternions (N, 4), scalar last, matrices (N, 3, 3) or a SciPy ``Rotation``,
        and positions (N, 3) in metres. Or a SciPy ``RigidTransform``, or matrices (N, 4, 4).

    Raises
    ------
    InvalidInputError
        Wrong shapes, entries that are not finite, times that do not increase or exceed 1e11 s, quaternions whose norm
        differs from 1 by more than 0.01, or matrices that are not rotations.
    OSError
        The file cannot be written.

    See Also
    --------
    read_tum, write_trajectory

    Notes
    -----
    Numbers are written with all their digits: `read_tum` returns the same float64 for times, positions and unit
    quaternions.

    The file is written whole or not at all, whether writing raises or the process ends in the middle of it; a process
    that is killed may leave a file ``.stiefel_rs-*.part`` beside it. This does not hold for a loss of power, since the
    file is not forced to the disk, nor for devices and pipes, which are written directly.
    """
    _write_poses(path, TUM_SUFFIXES[0], t, poses)


def read_trajectory(path: PathLike) -> tuple[Array, Any]:
    r"""Read a trajectory: TUM or CSV, by the suffix of the file.

    ``.tum`` and ``.txt`` files are read as `read_tum` does. A ``.csv`` file has a header that names the columns, in any
    order: ``t``, ``time`` or ``timestamp``; ``qx``, ``qy``, ``qz``, ``qw``; and, unless it holds orientations only,
    ``x``, ``y``, ``z`` or ``tx``, ``ty``, ``tz``. Other columns are skipped. Times are in seconds and positions in
    metres; other units (ms, us, ns; cm, mm) are given in brackets in the header, as in ``timestamp [ns]``, and
    converted. The header of the EuRoC data sets (``#timestamp, p_RS_R_x [m], ..., q_RS_w [], ...``) is accepted too;
    its times are in nanoseconds.

    Parameters
    ----------
    path : str or os.PathLike
        Name of the file; it ends in ``.tum``, ``.txt`` or ``.csv``.

    Returns
    -------
    t : numpy.ndarray, shape (N,)
        Times in seconds, increasing.
    poses : tuple of numpy.ndarray, or numpy.ndarray
        Quaternions (N, 4), scalar last, and positions (N, 3) in metres, ready for ``PoseSpline(t, poses)``. For a file
        without positions, the quaternions alone, ready for ``RotationSpline(t, poses)``.

    Raises
    ------
    InvalidInputError
        As for `read_tum`; also an unknown suffix, or a header with missing or duplicate columns or an unknown unit.
    OSError
        The file cannot be read.

    See Also
    --------
    write_trajectory, read_tum

    Examples
    --------
    >>> import os, tempfile
    >>> import stiefel_rs
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "attitude.csv")
    ...     with open(path, "w") as file:
    ...         _ = file.write("time [ms],qw,qx,qy,qz\n0,1,0,0,0\n40,0.8,0,0,0.6\n")
    ...     t, quaternions = stiefel_rs.read_trajectory(path)
    >>> t
    array([0.  , 0.04])
    >>> quaternions[1]
    array([0. , 0. , 0.6, 0.8])
    """
    found = read(path)
    return found.t, found.poses


def write_trajectory(path: PathLike, t: ArrayLike, poses: Any) -> None:
    """Write a trajectory: TUM or CSV, by the suffix of the file.

    Parameters
    ----------
    path : str or os.PathLike
        Name of the file; it ends in ``.tum``, ``.txt`` or ``.csv``. An existing file is replaced once the new one is
        complete, with the same permissions, and stays as it is if writing fails.
    t : array_like, shape (N,)
        Increasing times in seconds.
    poses : tuple, scipy.spatial.transform.RigidTransform, scipy.spatial.transform.Rotation or array_like
        As for `write_tum`; for a ``.csv`` file also rotations without positions: unit quaternions (N, 4), scalar last,
        matrices (N, 3, 3) or a SciPy ``Rotation``.

    Raises
    ------
    InvalidInputError
        As for `write_tum`; also an unknown suffix.
    OSError
        The file cannot be written.

    See Also
    --------
    read_trajectory, write_tum

    Notes
    -----
    The header of a CSV file is ``t,x,y,z,qx,qy,qz,qw``, in seconds and metres, or ``t,qx,qy,qz,qw``. Numbers are
    written with all their digits, and the file is written whole or not at all, as by `write_tum`.
    """
    _write_poses(path, suffix_of(path), t, poses)


def suffix_of(path: PathLike) -> str:
    """Return the suffix of a file of poses, in lower case.

    Raises
    ------
    InvalidInputError
        The suffix is not one of a file of poses.
    """
    suffix = Path(os.fsdecode(path)).suffix.lower()
    if suffix not in (*TUM_SUFFIXES, CSV_SUFFIX):
        raise InvalidInputError(f"{os.fsdecode(path)}: does not end in {', '.join(TUM_SUFFIXES)} or {CSV_SUFFIX}")
    return suffix


def read(path: PathLike, suffix: str | None = None) -> Recording:
    """Read the poses of a file, in the format of its suffix or of a given one."""
    name, suffix = os.fsdecode(path), suffix or suffix_of(path)
    # Bytes that are not text become entries that are not numbers.
    with storage.naming(path), open(path, encoding="utf-8-sig", errors="replace") as file:
        lines = ((number, text) for number, line in enumerate(file, 1) if (text := line.strip()))
        try:
            layout = csv_layout(lines) if suffix == CSV_SUFFIX else TUM
        except InvalidInputError as error:
            raise _wrong(name, error.knot, str(error)) from None
        return _collect(name, lines, layout)


def _wrong(name: str, line: int | None, message: str) -> InvalidInputError:
    return InvalidInputError(f"{name}: {message}" if line is None else f"{name}, line {line}: {message}")


def _collect(name: str, lines: Iterable[tuple[int, str]], layout: Layout) -> Recording:
    numbers, stamps, rows = [], [], []
    for number, text in lines:
        if text.startswith("#"):
            continue
        try:
            entries = _entries(text, layout)
            rows.append([_number(*entry) for entry in zip(layout.names, entries, strict=True)])
        except InvalidInputError as error:
            raise _wrong(name, number, str(error)) from None
        stamps.append(_stamp(entries[0], layout.time_exponent))
        numbers.append(number)
    if not rows:
        raise _wrong(name, None, "expected at least one pose, found none")
    table = np.array(rows)
    try:
        quaternions = unit_quaternions(table[:, -4:])
    except InvalidInputError as error:
        raise _wrong(name, numbers[error.knot or 0], str(error)) from None
    positions = table[:, 1:-4] / layout.parts_of_metre if len(layout.names) == len(TUM_NAMES) else None
    found = Recording(name, numbers, stamps, quaternions, positions)
    for i, (before, after) in enumerate(itertools.pairwise(stamps)):
        if after <= before:
            raise _wrong_time(found, i, "does not come after", "")
    if stamps[-1] > LATEST:
        unit = "give the unit in the header, as in timestamp [ns]" if layout is not TUM else "TUM files are in seconds"
        raise _wrong(name, numbers[-1], f"time {stamps[-1]} s exceeds {LATEST:g} s, probably not in seconds; {unit}")
    return found


def _entries(text: str, layout: Layout) -> list[str]:
    parts = layout.split(text)
    if len(parts) != layout.width:
        what = f" ({' '.join(layout.names)})" if layout is TUM else ", as in the header"
        raise InvalidInputError(f"expected {layout.width} columns{what}, found {len(parts)}")
    return [parts[index] for index in layout.indices]


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = None
    # Python accepts 1_000 as a number; files do not contain such numbers.
    if value is None or "_" in text:
        raise InvalidInputError(f"{name} is {text[:40]!r}, not a number")
    if not math.isfinite(value):
        raise InvalidInputError(f"{name} is {text[:40]}, not finite")
    return value


def _stamp(text: str, exponent: int) -> Decimal:
    try:
        return EXACT.create_decimal(text).scaleb(exponent, EXACT)
    # An exponent of twenty digits, which float reads as zero.
    except decimal.InvalidOperation:
        return EXACT.create_decimal_from_float(float(text))


def _wrong_time(found: Recording, before: int, why: str, advice: str) -> InvalidInputError:
    """Return an error about two consecutive times, the first of them at index `before`."""
    first, second = found.stamps[before : before + 2]
    message = f"time {second} s {why} {first} s in line {found.lines[before]}{advice}"
    return _wrong(found.name, found.lines[before + 1], message)


def _write_poses(path: PathLike, suffix: str, t: ArrayLike, poses: Any) -> None:
    times = floats("t", t, (None,))
    if (bad := np.flatnonzero(np.diff(times) <= 0)).size:
        after, before = float(times[bad[0] + 1]), float(times[bad[0]])
        raise InvalidInputError(f"t: entry {bad[0] + 1} is {after!r}, which does not come after {before!r}")
    if (times > LATEST).any():
        raise InvalidInputError(f"t: {float(times[-1])!r} s exceeds {LATEST:g} s, which `read_trajectory` refuses")
    quaternions, positions = as_components(poses)
    if not len(times) or len(times) != len(quaternions):
        raise InvalidInputError(
            f"t and poses: expected the same number, at least one, found {len(times)} and {len(quaternions)}"
        )
    stamps = [repr(time) for time in times.tolist()]
    write(path, stamps, quaternions, positions, suffix=suffix)


def write(
    path: PathLike,
    stamps: Sequence[str],
    quaternions: Array,
    positions: Array | None,
    *,
    suffix: str,
    others: Mapping[str, Array] | None = None,
) -> None:
    """Write unit quaternions and positions with times as text; a CSV file may have other columns, of shape (N,).

    Raises
    ------
    InvalidInputError
        A TUM file needs positions, and there are none.
    """
    others = others or {}
    if suffix != CSV_SUFFIX and positions is None:
        raise InvalidInputError(
            f"{os.fsdecode(path)}: expected positions; a {CSV_SUFFIX} file may hold rotations alone"
        )
    names = [CSV_NAMES[0], *(CSV_NAMES[4:] if positions is None else CSV_NAMES[1:]), *others]
    head, separator = (",".join(names), ",") if suffix == CSV_SUFFIX else (f"# {' '.join(TUM_NAMES)}", " ")
    columns = [quaternions] if positions is None else [positions, quaternions]
    table = np.column_stack([*columns, *others.values()])
    with storage.replacing(path) as file:
        file.write(f"{head}\n".encode())
        for start in range(0, len(table), _CHUNK):
            end = start + _CHUNK
            rows = zip(stamps[start:end], table[start:end].tolist(), strict=True)
            file.write("".join(f"{separator.join([stamp, *map(repr, row)])}\n" for stamp, row in rows).encode())
