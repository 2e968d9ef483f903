"""Times of all methods, at equal numbers of steps and at equal error."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Final

from . import experiments
from .experiments import EXPERIMENTS, TIMED_METHODS, ErrorRow

WARM_UP_STEPS: Final = 5
# The methods that solve the boundary problem of GCP, and may be asked for its error.
BOUNDARY_METHODS: Final = ("initial_point_bvp", "midpoint_bvp")


@dataclass(frozen=True)
class TimingRow:
    """Shortest time of one curve with ``steps + 1`` points, and its ratio to GCP's."""

    manifold: str
    method: str
    steps: int
    seconds: float
    ratio: float


def measure_times(steps: Iterable[int], repetitions: int, progress: Callable[[], None]) -> list[TimingRow]:
    """Time all methods on both manifolds, interleaved.

    Each repetition runs every manifold, ``N`` and method once, so that slowdowns of the machine affect all alike;
    the first round is discarded. A short call of the same method precedes each measurement: otherwise the caches left
    by the previous method, and so the order in the list, would affect the times. The time is that of computing the
    points in ``R^{3 x k}`` from the data of the problem, on one thread.

    Parameters
    ----------
    steps : iterable of int
    repetitions : int
        Number of measured rounds, of which the shortest time is used.
    progress : callable
        Called after each round, ``repetitions + 1`` times.
    """
    ends = {e.name: experiments.reference(e, 1) for e in EXPERIMENTS}
    cases = [(e, n, m) for n in steps for e in EXPERIMENTS for m in TIMED_METHODS]
    samples: dict[tuple[str, int, str], list[float]] = {(e.name, n, m): [] for e, n, m in cases}
    for round_number in range(repetitions + 1):
        for e, n, m in cases:
            experiments.solve(e, m, min(n, WARM_UP_STEPS), *ends[e.name])
            begin = time.perf_counter()
            experiments.solve(e, m, n, *ends[e.name])
            if round_number:
                samples[e.name, n, m].append(time.perf_counter() - begin)
        progress()
    # The median of few rounds would include other activity of the machine, which exceeds the time of short calls.
    least = {key: min(values) for key, values in samples.items()}
    return [
        TimingRow(e.name, m, n, least[e.name, n, m], least[e.name, n, m] / least[e.name, n, "gcp"]) for e, n, m in cases
    ]


def overtaking(rows: dict[str, list[ErrorRow]]) -> dict[tuple[str, str], int | None]:
    """Smallest ``N`` at which each of the paper's integrators has a smaller error than GCP; see `overtakes`."""
    methods = experiments.METHODS[1:]
    return {(e.name, m): experiments.overtakes(e, rows[e.name], m) for e in EXPERIMENTS for m in methods}


def shortest(call: Callable[[], object], repetitions: int) -> float:
    """Shortest time of a call, in seconds, after one call that does not count."""
    call()
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


@dataclass(frozen=True)
class EqualError:
    """A method of the boundary problem at the first ``N`` with an error below GCP's: times of both at that ``N``.

    ``steps``, ``seconds`` and ``gcp_seconds`` are None where no ``N`` of the run was enough.
    """

    manifold: str
    method: str
    steps: int | None
    seconds: float | None
    gcp_seconds: float | None

    @property
    def ratio(self) -> float | None:
        """Time of the method divided by the time of GCP."""
        return None if self.seconds is None or self.gcp_seconds is None else self.seconds / self.gcp_seconds


def measure_at_equal_error(first: dict[tuple[str, str], int | None], repetitions: int) -> list[EqualError]:
    """Time the methods of `BOUNDARY_METHODS` at the ``N`` of `overtaking`, and GCP."""
    found = []
    for e in EXPERIMENTS:
        ends = experiments.reference(e, 1)
        for method in BOUNDARY_METHODS:
            n = first[e.name, method]
            if n is None:
                found.append(EqualError(e.name, method, None, None, None))
                continue
            own, gcp = (shortest(partial(experiments.solve, e, m, n, *ends), repetitions) for m in (method, "gcp"))
            found.append(EqualError(e.name, method, n, own, gcp))
    return found


def ratios(timing: list[TimingRow], method: str) -> list[float]:
    """Return times of a method divided by those of GCP, at every ``N`` on both manifolds."""
    return [t.ratio for t in timing if t.method == method]


def over(timing: list[TimingRow], method: str, other: str) -> list[float]:
    """Return times of one method divided by those of another, at every ``N`` on both manifolds."""
    seconds = {(t.manifold, t.steps, t.method): t.seconds for t in timing}
    return [
        seconds[t.manifold, t.steps, method] / seconds[t.manifold, t.steps, other] for t in timing if t.method == method
    ]
