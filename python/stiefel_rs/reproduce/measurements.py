"""All measurements of a run, and its settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Final

from . import (
    any_shape,
    challenges,
    control_points,
    embedded,
    exact,
    experiments,
    geometry,
    near_start,
    readings,
    retractions,
    timing,
)
from .experiments import EXPERIMENTS, ErrorRow
from .timing import EqualError, TimingRow


@dataclass(frozen=True)
class Settings:
    """Settings of a run.

    Attributes
    ----------
    steps : tuple of int
        Numbers of steps ``N``, in increasing order.
    repetitions : int
        Number of repetitions of the timing.
    curves, wide_curves : int
        Numbers of random curves per manifold: in the setting of the conjecture, and in all settings.
    quick : bool
        Whether ``--quick`` was given.
    """

    steps: tuple[int, ...]
    repetitions: int
    curves: int
    wide_curves: int
    quick: bool

    def text(self) -> str:
        """Describe the run in one sentence."""
        name = "A `--quick` run, with fewer cases than a full one" if self.quick else "A full run"
        return (
            f"{name}: N = {', '.join(map(str, self.steps))}; {self.curves} random cubics of each manifold for the "
            f"conjecture; times are the shortest of {self.repetitions}."
        )

    def record(self) -> dict[str, Any]:
        """Return the settings as the manifest has them."""
        return asdict(self) | {"steps": list(self.steps)}


FULL: Final = Settings(experiments.DEFAULT_STEPS, 7, 1000, 30, quick=False)
QUICK: Final = Settings(experiments.QUICK_STEPS, 3, 20, 6, quick=True)


@dataclass(frozen=True)
class Measurements:
    """Everything measured in one run; `rows` by the name of the experiment, in increasing ``N``."""

    settings: Settings
    rows: dict[str, list[ErrorRow]]
    timing: list[TimingRow]
    overtaking: dict[tuple[str, str], int | None]
    equal_error: list[EqualError]
    geometry: geometry.Geometry
    readings: list[readings.Reading]
    near_start: list[near_start.Row]
    study: retractions.Study
    challenges: challenges.Challenges
    exact: list[exact.Comparison]
    control_points: list[control_points.Row]
    shapes: list[any_shape.Row]
    embedded: list[embedded.Row]


def steps_of_progress(settings: Settings) -> int:
    """How often `measure` calls `progress`."""
    return len(settings.steps) * len(EXPERIMENTS) + settings.repetitions + 1 + 2


def measure(settings: Settings, progress: Callable[[], None]) -> Measurements:
    """Measure everything; `progress` is called as often as `steps_of_progress` says."""
    rows: dict[str, list[ErrorRow]] = {}
    for e in EXPERIMENTS:
        rows[e.name] = []
        for n in settings.steps:
            rows[e.name].append(experiments.mean_errors(e, n))
            progress()
    times = timing.measure_times(settings.steps, settings.repetitions, progress)
    study = retractions.measure(settings.curves, settings.wide_curves)
    progress()
    first = timing.overtaking(rows)
    found = Measurements(
        settings=settings,
        rows=rows,
        timing=times,
        overtaking=first,
        equal_error=timing.measure_at_equal_error(first, settings.repetitions),
        geometry=geometry.measure(),
        readings=readings.measure(settings.steps),
        near_start=near_start.measure(),
        study=study,
        challenges=challenges.measure(settings.repetitions),
        exact=exact.measure(),
        control_points=control_points.measure(),
        shapes=any_shape.measure(settings.repetitions),
        embedded=embedded.measure(settings.steps, settings.repetitions),
    )
    progress()
    return found
