"""Energy over long times, and the drift of the quantities that the splittings preserve to round-off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.problems import Array
from benchmarks.study.cases import Data, random_data
from benchmarks.study.work import EMBEDDED, Map, Order
from stiefel_rs import Chart, ChartTrajectory, CubicTrajectory, StiefelError, integrate_cubic, integrate_embedded

STEP = 0.05
ACCELERATIONS = (0.2, 0.5)
GROWING = "St(3,2), random"
# Points of a curve in the figure; each is the largest error in its part of the time.
SHARES = 50
DRIFT_STEPS = (100, 1_000, 10_000, 100_000)
DRIFT_SIZES = ((3, 1), (3, 2), (5, 2), (10, 3))
DRIFT_TIME = 10.0
ORDERS = (2, 4, 6, 8)
CHART_METHODS: dict[str, tuple[Map, Order]] = {
    "chart, initial point": ("initial_point", 1),
    "chart, midpoint": ("midpoint", 2),
    "chart, exponential midpoint": ("exponential_midpoint", 2),
    "chart, Cayley midpoint": ("cayley_midpoint", 2),
    "chart, midpoint, order 4": ("midpoint", 4),
    "chart, midpoint, order 6": ("midpoint", 6),
    "chart, midpoint, order 8": ("midpoint", 8),
}


def bounded(acceleration: float) -> Data:
    """A start on the sphere with the acceleration orthogonal to the velocity and no jerk: the speed stays bounded."""
    S, V, A = (np.array(column)[:, None] for column in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, acceleration)))
    return S, V, A, np.zeros((3, 1))


def bounded_name(acceleration: float) -> str:
    """Name of such a curve."""
    return f"sphere, acceleration {acceleration}"


def growing() -> Data:
    """Random data on St(3,2), for which, as for almost all data, the speed grows without bound."""
    return random_data(3, 2, 1.0, 0.3, 0.3)


@dataclass(frozen=True)
class Energy:
    """Relative energy errors of one method along one curve, or the reason why it stopped."""

    curve: str
    method: str
    t: Array
    error: Array
    speeds: tuple[float, float]
    refused: str = ""

    @property
    def growth(self) -> float:
        """Ratio of the largest errors in the last and the first tenth."""
        tenth = max(1, len(self.error) // 10)
        # An error of zero counts as one of round-off.
        return float(self.error[-tenth:].max() / max(self.error[:tenth].max(), np.finfo(float).eps))


def _energy(curve: str, method: str, t_end: float, run: Callable[[], CubicTrajectory | ChartTrajectory]) -> Energy:
    try:
        trajectory = run()
    except StiefelError as error:
        return Energy(curve, method, np.empty(0), np.empty(0), (np.nan, np.nan), str(error))
    energy = trajectory.energy
    relative = np.abs(energy[1:] / energy[0] - 1)
    share = np.array([part.max() for part in np.array_split(relative, SHARES)])
    speed = np.linalg.norm(trajectory.velocity, axis=(1, 2))
    t = t_end * np.arange(1, SHARES + 1) / SHARES
    return Energy(curve, method, t, share, (float(speed.min()), float(speed.max())))


def _energies(curve: str, data: Data, t_end: float, chart: Chart) -> list[Energy]:
    steps = round(t_end / STEP)
    runs: dict[str, Callable[[], CubicTrajectory | ChartTrajectory]] = {
        f"splitting, order {order}": partial(integrate_cubic, *data, steps, t_end, order) for order in ORDERS
    }
    runs[EMBEDDED] = partial(integrate_embedded, *data, steps, t_end)
    for name, (map_, chart_order) in CHART_METHODS.items():
        runs[name] = partial(chart.integrate_across, *data, steps, t_end, map_, order=chart_order)
    return [_energy(curve, name, t_end, run) for name, run in runs.items()]


def energies(bounded_time: float, growing_time: float) -> list[Energy]:
    """All methods along all curves with the same step."""
    found = []
    for acceleration in ACCELERATIONS:
        found += _energies(bounded_name(acceleration), bounded(acceleration), bounded_time, Chart.sphere())
    return found + _energies(GROWING, growing(), growing_time, Chart.frame())


@dataclass(frozen=True)
class Drift:
    """Largest deviations of the invariants over a run of the splitting of order 6."""

    n: int
    k: int
    steps: int
    momentum: float
    constraint: float
    orthonormality: float


def drifts(steps: tuple[int, ...]) -> list[Drift]:
    """Drifts over the same time with increasing numbers of steps."""
    found = []
    for n, k in DRIFT_SIZES:
        for count in steps:
            trajectory = integrate_cubic(*random_data(n, k, 1.0, 0.3, 0.3), count, DRIFT_TIME)
            point = trajectory.point
            gram = np.swapaxes(point, 1, 2) @ point - np.eye(k)
            defect = float(np.linalg.norm(gram, axis=(1, 2)).max())
            found.append(Drift(n, k, count, trajectory.momentum_drift, trajectory.constraint_drift, defect))
    return found
