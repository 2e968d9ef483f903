"""Records of solved problems: one structured array element per problem."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import stiefel_rs
from stiefel_rs._core import SolverReport
from stiefel_rs.errors import ConvergenceError, InvalidInputError, OutsideDomainError, StiefelError

from ._blocks import Number
from ._errors import of_problem

OnError = Literal["raise", "mark"]

# Largest length in bytes: exceeds all messages of the package; longer ones are truncated.
MESSAGE = 300
SOLVER = ("converged", "iterations", "residual")
FAILURE = ("code", "message")


class Outcome(IntEnum):
    """Outcome of a problem of a sweep: the values of the field ``code``."""

    SOLVED = 0
    INVALID_INPUT = 1
    OUTSIDE_DOMAIN = 2
    NO_CONVERGENCE = 3
    OTHER = 4


def record(fields: Sequence[str], arrays: dict[str, tuple[int, ...]], number: Number = np.float64) -> np.dtype[Any]:
    """Return the type of a record with the given fields; `arrays` has the shapes of arrays of `number`."""
    plain: dict[str, Any] = {
        "cost": np.float64,
        "converged": np.bool_,
        "iterations": np.int64,
        "residual": np.float64,
        "code": np.int8,
        "message": f"S{MESSAGE}",
    }
    return np.dtype([(name, number, arrays[name]) if name in arrays else (name, plain[name]) for name in fields])


def choose(fields: Sequence[str] | None, known: Sequence[str], default: Sequence[str]) -> tuple[str, ...]:
    """Return the requested fields in their usual order; raise if one is unknown."""
    if fields is None:
        return tuple(default)
    if not isinstance(fields, Iterable):
        raise TypeError(f"fields: expected names, found {fields!r}")
    asked = {fields} if isinstance(fields, str) else set(fields)
    if unknown := asked - set(known):
        raise InvalidInputError(f"fields: {sorted(unknown)} not among {tuple(known)}")
    if not asked:
        raise InvalidInputError(f"fields: expected at least one of {tuple(known)}")
    return tuple(name for name in known if name in asked)


def store_report(records: NDArray[Any], index: tuple[int, ...], report: SolverReport | None) -> None:
    """Set the fields of the solver; for a closed form they are True, 0 and 0."""
    values = {"converged": True, "iterations": 0, "residual": 0.0}
    if report is not None:
        values = {name: getattr(report, name) for name in SOLVER}
    store(records, index, **values)


def store(records: NDArray[Any], index: tuple[int, ...], **values: Any) -> None:
    """Set the given fields, except those that the records do not have."""
    for name, value in values.items():
        if name in (records.dtype.names or ()):
            records[name][index] = value


def each(
    records: NDArray[Any], origin: tuple[int, ...], on_error: OnError, solve: Callable[[tuple[int, ...]], None]
) -> None:
    """Solve the problems of a block one after the other; raise errors with the index of the problem, or mark them."""
    for index in np.ndindex(records.shape):
        try:
            solve(index)
        except StiefelError as error:
            if on_error == "raise":
                raise of_problem(error, tuple(a + i for a, i in zip(origin, index, strict=True))) from None
            mark(records, index, error)


def mark(records: NDArray[Any], index: tuple[int, ...], error: StiefelError) -> None:
    """Set the record of a failed problem: numbers to NaN, and code and message of the error."""
    for name in records.dtype.names or ():
        if records.dtype[name].base in (np.float64, np.complex128):
            records[name][index] = np.nan
    report = getattr(error, "report", None)
    store(
        records,
        index,
        converged=False,
        iterations=-1 if report is None else report.iterations,
        residual=np.nan if report is None else report.residual,
        code=_code(error),
        message=str(error).encode("ascii", "replace")[:MESSAGE],
    )


def _code(error: StiefelError) -> Outcome:
    if isinstance(error, InvalidInputError):
        return Outcome.INVALID_INPUT
    if isinstance(error, OutsideDomainError):
        return Outcome.OUTSIDE_DOMAIN
    return Outcome.NO_CONVERGENCE if isinstance(error, ConvergenceError) else Outcome.OTHER


def require_version(expected: str) -> None:
    """Raise unless this process has the same version of the package as the client that made the graph."""
    if stiefel_rs.__version__ != expected:
        raise RuntimeError(f"this worker has stiefel_rs {stiefel_rs.__version__}, the client {expected}")
