"""Exceptions of the package. Every message states the measured number."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._core import SolverReport


class StiefelError(Exception):
    """Base class of the package's exceptions.

    Attributes
    ----------
    knot : int or None
        Index of the knot of a spline that the error is about; for two consecutive knots, the first.
    problem : tuple of int or None
        Index of the problem in a sweep (`stiefel_rs.dask`) that the error is about.
    """

    knot: int | None = None
    problem: tuple[int, ...] | None = None


class InvalidInputError(StiefelError, ValueError):
    """Input with a wrong shape, non-finite, not orthonormal, not tangent, or out of range."""


class OutsideDomainError(StiefelError, ValueError):
    """No logarithm or joining curve exists, or a state is outside its chart.

    Attributes
    ----------
    angle : float or None
        The angle outside the domain, in radians.
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
        Iterations, residual and reason for stopping.
    """

    def __init__(self, message: str, report: SolverReport | None = None) -> None:
        super().__init__(message, report)
        self.report = report

    def __str__(self) -> str:
        return str(self.args[0])
