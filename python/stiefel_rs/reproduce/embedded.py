"""The paper's future work: a method on the phase space as a submanifold of a Euclidean space (`integrate_embedded`).

Its order and its constraints; its errors and times compared with the chart method, with and without changes of chart,
and with the explicit splitting of the same order: on the paper's curves, and on a manifold without a chart here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from .._core import RiemannianCubic, integrate_cubic, integrate_embedded
from . import any_shape, challenges, experiments
from .challenges import EMBEDDED, LABELS, Initial
from .experiments import EXPERIMENTS, Array, ErrorRow
from .text import between, milliseconds, table

ORDER: Final = 2
# The manifold without a chart.
SHAPE: Final = (5, 2)
WITHOUT_CHART: Final = ("splitting", EMBEDDED)
HEADER: Final = ["manifold", "method", "N", "mean_error", "constraints", "seconds"]


@dataclass(frozen=True)
class Row:
    """One method on one curve with ``steps`` steps.

    Attributes
    ----------
    error : float
        Mean over the points of the grid.
    defect : float or None
        Of the embedded method, the larger of two: the largest entry of ``S^T S - I`` and of ``S^T V + V^T S`` after the
        last step, and the largest violation of any constraint, including the constraints of the momenta, at any step.
    seconds : float
        Shortest time of the whole curve.
    """

    manifold: str
    method: str
    steps: int
    error: float
    defect: float | None
    seconds: float


@dataclass(frozen=True)
class _Curve:
    """A cubic by its initial data, its exact points for a number of steps, and the methods that integrate it."""

    title: str
    initial: Initial
    exact: Callable[[int], Array]
    solvers: Mapping[str, Callable[[int], Array]]


def _curves() -> list[_Curve]:
    found = []
    for e in EXPERIMENTS:
        initial = challenges.initial_data(e, None)
        solvers = {m: partial(challenges.solve, e, m, initial, order=ORDER) for m in LABELS}
        found.append(_Curve(e.title, initial, partial(_paper_points, e), solvers))
    cubic = RiemannianCubic.from_boundary(*any_shape.problem(*SHAPE), tol=experiments.BOUNDARY_TOLERANCE)
    S, V, A, J = cubic.initial
    found.append(
        _Curve(
            f"St({SHAPE[0]},{SHAPE[1]})",
            (S, V, A, J),
            lambda n: cubic(experiments.time_grid(n)),
            {
                "splitting": lambda n: integrate_cubic(S, V, A, J, n, order=ORDER).point,
                EMBEDDED: lambda n: integrate_embedded(S, V, A, J, n).point,
            },
        )
    )
    return found


def _paper_points(experiment: experiments.Experiment, steps: int) -> Array:
    return experiments.points(experiment, experiments.reference(experiment, steps))


def defect(initial: Initial, steps: int) -> float:
    """Violation of the constraints by the embedded method; see `Row`."""
    found = integrate_embedded(*initial, steps)
    S, V = found.point[-1], found.velocity[-1]
    inner = S.T @ V
    last = max(np.abs(S.T @ S - np.eye(S.shape[1])).max(), np.abs(inner + inner.T).max())
    return max(float(last), found.constraint_drift)


def measure(steps: Iterable[int], repetitions: int) -> list[Row]:
    """Measure every method on every curve."""
    rows = []
    sizes = tuple(steps)
    for curve in _curves():
        for n in sizes:
            exact = curve.exact(n)
            calls = {m: partial(solver, n) for m, solver in curve.solvers.items()}
            seconds = challenges.times(list(calls.values()), repetitions)
            for (m, call), least in zip(calls.items(), seconds, strict=True):
                error = float(experiments.distances(call(), exact).mean())
                own = defect(curve.initial, n) if m == EMBEDDED else None
                rows.append(Row(curve.title, m, n, error, own, least))
    return rows


def manifolds(rows: list[Row]) -> list[str]:
    """Return the manifolds in the order of the rows."""
    return list(dict.fromkeys(r.manifold for r in rows))


def of(rows: list[Row], manifold: str, method: str) -> list[Row]:
    """Return the rows of one method on one curve, in increasing ``N``."""
    return [r for r in rows if r.manifold == manifold and r.method == method]


def slope(rows: list[Row], manifold: str, method: str = EMBEDDED) -> float | None:
    """Slope of log error against log ``h`` over all ``N``; None for fewer than two."""
    own = [ErrorRow(r.steps, {method: r.error}) for r in of(rows, manifold, method)]
    return experiments.slope(own, method)


def largest_defect(rows: list[Row]) -> float:
    """Largest violation of the constraints, over all curves and ``N``."""
    return max(r.defect for r in rows if r.defect is not None)


def against(rows: list[Row], other: str, what: str) -> list[float]:
    """Return the ``error`` or ``seconds`` of the embedded method divided by another method's, if both exist."""
    found = []
    for manifold in manifolds(rows):
        pairs = zip(of(rows, manifold, EMBEDDED), of(rows, manifold, other), strict=False)
        found += [getattr(own, what) / getattr(its, what) for own, its in pairs]
    return found


def csv_rows(rows: list[Row]) -> list[tuple[object, ...]]:
    """Rows of ``embedded.csv``, whose header is `HEADER`."""
    return [(r.manifold, r.method, r.steps, r.error, "" if r.defect is None else r.defect, r.seconds) for r in rows]


def section(rows: list[Row]) -> str:
    """Text of the section of ``summary.md``."""
    cells = []
    last = rows[-1].steps
    for manifold in manifolds(rows):
        least = of(rows, manifold, "splitting")[-1].seconds
        for m in LABELS:
            own = of(rows, manifold, m)
            if not own:
                continue
            order = slope(rows, manifold, m)
            worst = max((r.defect for r in own if r.defect is not None), default=None)
            numbers = [f"{own[-1].error:.2e}", "-" if order is None else f"{order:.3f}"]
            numbers += ["-" if worst is None else f"{worst:.1e}"]
            numbers += [milliseconds(own[-1].seconds), f"{own[-1].seconds / least:.3g}"]
            cells.append([manifold, LABELS[m], *numbers])
    header = ["manifold", "method", f"error, N = {last}", "slope over all N", "constraints", f"time, N = {last}"]
    ratios = [
        [LABELS[m], between(against(rows, m, "error")), between(against(rows, m, "seconds"))]
        for m in LABELS
        if m != EMBEDDED
    ]
    return f"""### A submanifold of Euclidean space

The paper's future work on the manifold: "considering it as a submanifold of a higher dimensional Euclidean space". The
phase space T*(TSt(n,k)) lies in the space of four n x k matrices (S, V, p_S, p_V). `integrate_embedded` takes the steps
of the mid-point map there, with multiples of the gradients of the constraints. Mean errors of methods of order {ORDER}
with initial values, at equal steps: the paper's curves, and a cubic on St({SHAPE[0]},{SHAPE[1]}), for which the paper
has no chart. "Constraints" is the largest violation by the embedded method, over all N: S^T S = I and
S^T V + V^T S = 0 after the last step, and these and both constraints of the momenta at all steps:

{table([*header, "splitting = 1"], cells, 2)}

Error and time of the embedded method divided by those of the other methods, at equal N, for all N and curves:

{table(["method", "error", "time"], ratios)}

Its times at equal error on the paper's curves are in the previous section. Times are the shortest of rounds that
alternate between the methods, one thread.
"""
