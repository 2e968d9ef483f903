"""The exceptions of the package. Every message carries the measured number."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._core import SolverReport


class StiefelError(Exception):
    """Base class of the package's exceptions.

    Attributes
    ----------
    knot : int or None
        Index of the knot of a spline that the error is about: the first one, where it is about two neighbours.
    problem : tuple of int or None
        Index of the problem of a sweep (`stiefel_rs.dask`) that the error is about.
    """

    knot: int | None = None
    problem: tuple[int, ...] | None = None


class InvalidInputError(StiefelError, ValueError):
    """Wrong shape, not finite, not orthonormal, not tangent, or a number out of its range."""


class OutsideDomainError(StiefelError, ValueError):
    """No logarithm, no joining curve, or a state outside of its chart.

    Attributes
    ----------
    angle : float or None
        The angle that is out of the domain, in radians.
    """

    def __init__(self, message: str, angle: float | None = None) -> None:
        super().__init__(message, angle)
        self.angle = angle

    def __str__(self) -> str:
        return str(self.args[0])


class ConvergenceError(StiefelError, RuntimeError):
    """An iteration stopped without reaching its tolerance.

    Attributes
    ----------
    report : SolverReport or None
        How far it got, and why it stopped.
    """

    def __init__(self, message: str, report: SolverReport | None = None) -> None:
        super().__init__(message, report)
        self.report = report

    def __str__(self) -> str:
        return str(self.args[0])
