"""Result of `solve_boundary`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class BoundaryBatch(NamedTuple):
    """Solutions of a batch of boundary problems, as initial data of Riemannian cubics.

    Attributes
    ----------
    acceleration, jerk : ndarray, shape (..., n, k)
        Covariant acceleration and covariant jerk at ``S0``, complex for complex frames; NaN for unsolved problems.
    cost : ndarray, shape (...)
        Integral of the squared covariant acceleration over ``[0, 1]``; NaN for unsolved problems.
    converged : ndarray of bool, shape (...)
        Whether the error at the end is within the tolerance.
    residual : ndarray, shape (...)
        Error at the end, in the norm of `tol` of `RiemannianCubic.from_boundary`; infinite if no curve could be
        integrated.
    """

    acceleration: NDArray[Any]
    jerk: NDArray[Any]
    cost: NDArray[np.float64]
    converged: NDArray[np.bool_]
    residual: NDArray[np.float64]


# Docstrings of the fields, for `help` and editors.
BoundaryBatch.acceleration.__doc__ = "Covariant accelerations at `S0`, shape (..., n, k); NaN for unsolved problems."
BoundaryBatch.jerk.__doc__ = "Covariant jerks at `S0`, shape (..., n, k); NaN for unsolved problems."
BoundaryBatch.cost.__doc__ = "Integrals of the squared covariant acceleration, shape (...); NaN for unsolved problems."
BoundaryBatch.converged.__doc__ = "Whether the error at the end is within the tolerance, shape (...)."
BoundaryBatch.residual.__doc__ = "Error at the end, shape (...)."
