"""Derivatives of curves as functions of the parameter."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike, NDArray

from .errors import InvalidInputError

if TYPE_CHECKING:
    from ._core import Curve

__all__ = ["CurveDerivative"]

MAX_ORDER = 3


@dataclass(frozen=True)
class CurveDerivative:
    """Ambient derivative of a curve, returned by `Curve.derivative`.

    Attributes
    ----------
    curve : Curve
        The differentiated curve.
    order : int
        Order of the derivative, 0 to 3.
    """

    curve: Curve
    order: int

    def __post_init__(self) -> None:
        if operator.index(self.order) not in range(MAX_ORDER + 1):
            raise InvalidInputError(f"nu: the total order must be from 0 to 3, found {self.order}")

    def __call__(
        self, t: ArrayLike, nu: int = 0, *, extrapolate: bool | None = None, num_threads: int | None = None
    ) -> NDArray[Any]:
        """Evaluate the derivative, or its own derivative of order `nu`.

        Parameters
        ----------
        t : array_like, shape T
            Parameters.
        nu : int, default 0
            Additional order of differentiation; the total order is at most 3.
        extrapolate, num_threads
            As for the curve.

        Returns
        -------
        ndarray, shape T + (n, k)
        """
        return self.derivative(nu)._values(t, extrapolate, num_threads)

    def _values(self, t: ArrayLike, extrapolate: bool | None, num_threads: int | None) -> NDArray[Any]:
        return self.curve(t, self.order, extrapolate=extrapolate, num_threads=num_threads)

    def derivative(self, nu: int = 1) -> CurveDerivative:
        """Return the derivative of order `nu` of this one."""
        if nu < 0:
            raise InvalidInputError(f"nu: must be at least 0, found {nu}")
        return CurveDerivative(self.curve, self.order + nu)

    @property
    def t_span(self) -> tuple[float, float]:
        """Interval on which the curve is defined."""
        return self.curve.t_span
