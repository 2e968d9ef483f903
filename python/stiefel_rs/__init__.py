"""Smooth curves on Stiefel manifolds.

Quasi-geodesics, geometric cubics (adjusted de Casteljau) and Riemannian cubics on any St(n, k), splines of them,
rotations, poses and subspaces; and the symplectic integrators and shooting of arXiv 2404.19407 in charts of St(3,1)
and St(3,2). `RotationSpline` interpolates rotations given as quaternions, as matrices or as SciPy's `Rotation`, and
`PoseSpline` rotations with positions.
"""

import typing as _typing

from . import _core
from ._core import (
    Chart,
    ChartTrajectory,
    CubicHermite,
    CubicSpline,
    CubicTrajectory,
    Curve,
    DerivativeBounds,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    LogReport,
    PiecewiseCurve,
    QuasiGeodesic,
    RiemannianCubic,
    ShootingResult,
    SmoothingSpline,
    SolverReport,
    Stiefel,
    estimate_velocities,
    integrate_cubic,
    integrate_embedded,
    orthogonal_log,
    skew_exp,
    solve_boundary,
)
from .boundary import BoundaryBatch
from .curve_derivative import CurveDerivative
from .errors import ConvergenceError, InvalidInputError, OutsideDomainError, StiefelError
from .lazy import MODULES as _MODULES
from .lazy import SUBPACKAGES as _SUBPACKAGES
from .lazy import attribute as _attribute

__version__ = _core.__VERSION__

__all__ = [
    "BoundaryBatch",
    "Chart",
    "ChartTrajectory",
    "ConvergenceError",
    "CubicHermite",
    "CubicSpline",
    "CubicTrajectory",
    "Curve",
    "CurveDerivative",
    "DerivativeBounds",
    "Geodesic",
    "GeometricCubic",
    "GeometricPolynomial",
    "Grassmann",
    "InvalidInputError",
    "LogReport",
    "OutsideDomainError",
    "PiecewiseCurve",
    "PoseSpline",
    "QuasiGeodesic",
    "RiemannianCubic",
    "RotationSpline",
    "ShootingResult",
    "SmoothingSpline",
    "SolverReport",
    "Stiefel",
    "StiefelError",
    "__version__",
    "estimate_velocities",
    "integrate_cubic",
    "integrate_embedded",
    "load",
    "orthogonal_log",
    "read_trajectory",
    "read_tum",
    "skew_exp",
    "solve_boundary",
    "write_trajectory",
    "write_tum",
]


if _typing.TYPE_CHECKING:
    from . import dask as dask
    from . import explore as explore
    from . import jax as jax
    from . import plotting as plotting
    from . import pymanopt as pymanopt
    from . import reproduce as reproduce
    from . import torch as torch
    from .pose import PoseSpline
    from .rotation import RotationSpline
    from .storage import load
    from .trajectory_files import read_trajectory, read_tum, write_trajectory, write_tum
else:

    def __getattr__(name):
        found = globals()[name] = _attribute(name)
        return found

    def __dir__():
        return sorted({*globals(), *_MODULES, *_SUBPACKAGES})
