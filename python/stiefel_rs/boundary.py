"""What `solve_boundary` returns."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class BoundaryBatch(NamedTuple):
    """Riemannian cubics of a batch of boundary problems, at their start.

    Attributes
    ----------
    acceleration, jerk : ndarray, shape (..., n, k)
        Covariant acceleration and covariant jerk at ``S0``, complex for complex frames; NaN where a problem is
        not solved.
    cost : ndarray, shape (...)
        The integral of the squared covariant acceleration over ``[0, 1]``; NaN where a problem is not solved.
    converged : ndarray of bool, shape (...)
        Whether the end is met to the tolerance.
    residual : ndarray, shape (...)
        How far the end is missed, in the norm of `tol` of `RiemannianCubic.from_boundary`; infinite where no
        curve could be integrated.
    """

    acceleration: NDArray[Any]
    jerk: NDArray[Any]
    cost: NDArray[np.float64]
    converged: NDArray[np.bool_]
    residual: NDArray[np.float64]


# What `help` and editors show of the fields.
BoundaryBatch.acceleration.__doc__ = (
    "Covariant accelerations at `S0`, shape (..., n, k); NaN where a problem is not solved."
)
BoundaryBatch.jerk.__doc__ = "Covariant jerks at `S0`, shape (..., n, k); NaN where a problem is not solved."
BoundaryBatch.cost.__doc__ = (
    "Integrals of the squared covariant acceleration, shape (...); NaN where a problem is not solved."
)
BoundaryBatch.converged.__doc__ = "Whether the end is met to the tolerance, shape (...)."
BoundaryBatch.residual.__doc__ = "How far the end is missed, shape (...)."
