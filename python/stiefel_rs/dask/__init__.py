"""Batches on a cluster: boundary problems, splines and maps of manifolds for `dask.array`. Needs the extra `dask`.

Evaluation is lazy. Tasks are pure functions of arrays, each on one thread; results equal those of the package in one
process to the last bit. The guide is `docs/dask.md`.
"""

from ._boundary import solve_boundary
from ._evaluate import evaluate
from ._grassmann import Grassmann
from ._maps import orthogonal_log, skew_exp
from ._records import Outcome
from ._splines import splines
from ._stiefel import Stiefel
from ._store import from_zarr
from ._sweep import Sweep

__all__ = [
    "Grassmann",
    "Outcome",
    "Stiefel",
    "Sweep",
    "evaluate",
    "from_zarr",
    "orthogonal_log",
    "skew_exp",
    "solve_boundary",
    "splines",
]
