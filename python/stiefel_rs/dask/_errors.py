"""Errors of tasks, with the index of the problem in the whole sweep."""

from __future__ import annotations

import re
from collections.abc import Sequence

from stiefel_rs.errors import ConvergenceError, OutsideDomainError, StiefelError

_MEMBER = re.compile(r" \(batch member (\d+)\)$")


def of_problem(error: StiefelError, problem: tuple[int, ...]) -> StiefelError:
    """Return the error with the index of its problem in the message and in the attribute `problem`."""
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
    """Return an error of a block that starts at `origin` as an error of the problem in the whole sweep."""
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
    """Return an index as text; for a single axis, a number."""
    return str(problem[0]) if len(problem) == 1 else str(problem)
