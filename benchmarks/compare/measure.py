"""Timing of one row: a check that results agree, then interleaved samples of all participants."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.compare.row import Rival, Row
from benchmarks.compare.virtual_environments import UnavailableError
from benchmarks.compare.workers import LostError, Worker

# Other load slows every participant down: a task whose processor time exceeds its wall time by this used threads.
SINGLE = 1.2


@dataclass(frozen=True)
class Effort:
    """How long to sample each participant of a row, in seconds and counts, and by which clock.

    Processor time excludes the time taken by other programs, so it is more reliable on a busy machine. Rows that time
    several threads always use wall time.
    """

    seconds: float
    least: int
    most: int
    clock: str = "wall"


FULL = Effort(seconds=0.8, least=3, most=60)
QUICK = Effort(seconds=0.15, least=2, most=15)


@dataclass
class Figure:
    """Times of one participant for one unit of work, in seconds; of its preparation; and properties of its result."""

    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    elapsed: float = 0.0
    clock: str = "wall"
    setup: float = 0.0
    error: float | None = None
    note: str = ""

    @property
    def times(self) -> list[float]:
        """Samples of the selected clock."""
        return self.cpu if self.clock == "cpu" else self.wall

    @property
    def best(self) -> float:
        """Shortest time: the duration without interference."""
        return min(self.times)

    @property
    def median(self) -> float:
        """Median time."""
        return median(self.times)

    @property
    def threads(self) -> float:
        """Average number of busy processors."""
        return sum(self.cpu) / sum(self.wall)

    def wants(self, effort: Effort) -> bool:
        """Whether another sample is needed."""
        if len(self.wall) < effort.least:
            # A single call of many seconds is enough.
            return self.elapsed < 10 * effort.seconds or not self.wall
        return self.elapsed < effort.seconds and len(self.wall) < effort.most


@dataclass
class Outcome:
    """Results of a row. A participant without a figure has a reason; `numbers` are the measured values of bounds."""

    row: Row
    ours: Figure | str
    rivals: dict[Rival, Figure | str]
    numbers: dict[str, float | str]


class Pool:
    """The processes, started on first use; for one that cannot be started, the reason is kept."""

    def __init__(self, starters: dict[str, tuple[Path, str, int] | str]) -> None:
        self._starters = starters
        self._running: dict[str, Worker] = {}
        self.failed: dict[str, str] = {}

    def get(self, name: str) -> Worker:
        """The process of that name.

        Raises
        ------
        UnavailableError
            If it could not be started, now or before.
        """
        if name in self._running:
            return self._running[name]
        if name in self.failed:
            raise UnavailableError(self.failed[name])
        starter = self._starters[name]
        try:
            if isinstance(starter, str):
                raise UnavailableError(starter)
            self._running[name] = Worker(*starter)
        except UnavailableError as error:
            self.failed[name] = str(error)
            raise
        return self._running[name]

    def fresh(self, name: str) -> Worker:
        """Another process of that kind, with nothing in its memory yet."""
        starter = self._starters[name]
        if isinstance(starter, str):
            raise UnavailableError(starter)
        return Worker(*starter)

    def lose(self, name: str) -> None:
        """End a process that does not respond; the next `get` starts another."""
        if name in self._running:
            self._running.pop(name).close()

    def infos(self) -> dict[str, dict[str, object]]:
        """Versions and BLAS of the running processes."""
        return {name: worker.info for name, worker in self._running.items()}

    def close(self) -> None:
        """End all processes."""
        for worker in self._running.values():
            worker.close()
        self._running.clear()


def run_row(row: Row, pool: Pool, effort: Effort) -> Outcome:
    """Compare results, then time, then measure."""
    outcome = Outcome(row, "", {}, {})
    with tempfile.TemporaryDirectory() as folder:
        ours, reference, digest = _prepare(pool, row.ours, f"{row.name}:ours", Path(folder) / "ours.npy")
        outcome.ours = ours
        exact = None
        if row.exact:
            _, exact, _ = _prepare(pool, row.ours, f"{row.name}:exact", Path(folder) / "exact.npy")
            _tell_error(ours, reference, exact)
        for i, rival in enumerate(row.rivals):
            name = f"{row.name}:{rival.task}"
            figure, result, other = _prepare(pool, rival.peer, name, Path(folder) / f"{i}.npy")
            if isinstance(figure, Figure) and reference is not None and result is not None:
                _agree(rival, reference, result, identical=other == digest)
            _tell_error(figure, result, exact)
            outcome.rivals[rival] = figure
    _sample(outcome, pool, effort)
    for bound in row.bounds:
        try:
            with pool.fresh(row.ours) as worker:
                outcome.numbers[bound.measure] = worker.ask("measure", name=bound.measure)["value"]
        except UnavailableError as error:
            outcome.numbers[bound.measure] = str(error)
    return outcome


def _prepare(pool: Pool, peer: str, name: str, path: Path) -> tuple[Figure | str, NDArray[np.float64] | None, str]:
    try:
        answer = pool.get(peer).ask("prepare", name=name, save=str(path))
    except UnavailableError as error:
        if isinstance(error, LostError):
            pool.lose(peer)
        return str(error), None, ""
    return Figure(setup=answer["setup"], note=answer["note"]), np.load(path), answer["sha256"]


def _tell_error(figure: Figure | str, result: NDArray[np.float64] | None, exact: NDArray[np.float64] | None) -> None:
    if isinstance(figure, Figure) and result is not None and exact is not None:
        figure.error = _distance(exact, result)


def _distance(expected: NDArray[np.float64], found: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(expected - found) / np.linalg.norm(expected))


def _agree(rival: Rival, ours: NDArray[np.float64], theirs: NDArray[np.float64], *, identical: bool) -> None:
    """Refuse to time two tasks with different results."""
    if rival.identical and not identical:
        raise AssertionError(f"{rival.label}: results differ in some bits")
    if rival.agree is None:
        return
    expected = ours if rival.pick is None else ours[rival.pick]
    distance = _distance(expected, theirs)
    if not distance <= rival.agree:
        raise AssertionError(f"{rival.label}: relative distance of results {distance:.1e}, above {rival.agree:.0e}")


def _sample(outcome: Outcome, pool: Pool, effort: Effort) -> None:
    """Samples taken in turn, so that slowdowns affect all equally; participants that used up their time are skipped."""
    row = outcome.row
    clock = "wall" if row.threads > 1 else effort.clock
    entries = [(row.ours, "ours", outcome.ours), *((r.peer, r.task, f) for r, f in outcome.rivals.items())]
    active = [(peer, f"{row.name}:{task}", figure) for peer, task, figure in entries if isinstance(figure, Figure)]
    for _, _, figure in active:
        figure.clock = clock
    while due := [entry for entry in active if entry[2].wants(effort)]:
        for peer, name, figure in due:
            sample = pool.get(peer).ask("sample", name=name)
            figure.wall.append(sample["wall"])
            figure.cpu.append(sample["cpu"])
            figure.elapsed += sample["elapsed"]
    for peer, name, _ in active:
        pool.get(peer).ask("drop", name=name)
