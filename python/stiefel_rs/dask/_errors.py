"""Errors of tasks name the member of the whole sweep that they are about."""

from __future__ import annotations

import re
from collections.abc import Sequence

from stiefel_rs.errors import ConvergenceError, OutsideDomainError, StiefelError

_MEMBER = re.compile(r" \(batch member (\d+)\)$")


def of_problem(error: StiefelError, problem: tuple[int, ...]) -> StiefelError:
    """Return the same error, said of this problem; carries the index as `problem`."""
    text = f"problem {label(problem)}: {error}" if problem else str(error)
    if isinstance(error, OutsideDomainError):
        located: StiefelError = type(error)(text, error.angle)
    elif isinstance(error, ConvergenceError):
        located = type(error)(text, error.report)
    else:
        located = type(error)(text)
    located.knot = error.knot
    located.problem = problem
    return located


def of_batch(error: StiefelError, origin: tuple[int, ...], shape: Sequence[int]) -> StiefelError:
    """Return the same error of a batch at `origin`, said of the member of the whole."""
    found = _MEMBER.search(str(error))
    inside = _unravelled(int(found[1]), shape) if found else (0,) * len(origin)
    plain = type(error)(_MEMBER.sub("", str(error)))
    plain.__dict__.update(error.__dict__)
    return of_problem(plain, tuple(start + i for start, i in zip(origin, inside, strict=True)))


def _unravelled(flat: int, shape: Sequence[int]) -> tuple[int, ...]:
    index: list[int] = []
    for size in reversed(shape):
        flat, inside = divmod(flat, size)
        index.append(inside)
    return tuple(reversed(index))


def label(problem: tuple[int, ...]) -> str:
    """Text of an index: a number on one axis."""
    return str(problem[0]) if len(problem) == 1 else str(problem)
