"""Lines of the report: one per comparison; and the targets of this project, with whether they are reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from benchmarks.compare.measure import SINGLE, Figure, Outcome
from benchmarks.compare.row import Rival
from benchmarks.durations import seconds

# Medians that exceed the shortest time by this factor are told.
NOISY = 1.15


@dataclass(frozen=True)
class Line:
    """One line of the table; `reached` is None if there is no target, `judged` what a target is compared with."""

    work: str
    ours: str
    other: str
    figure: str
    ratio: str = ""
    reach: str = ""
    reached: bool | None = None
    judged: str = ""

    def cells(self) -> tuple[str, ...]:
        """Texts of the cells."""
        return self.work, self.ours, self.other, self.figure, self.ratio


def shown(outcome: Outcome) -> list[Line]:
    """Lines of one row for readers of the page: comparisons with other libraries, or our time if there are none."""
    lines = lines_of(outcome)
    others = {rival.label for rival in outcome.row.rivals if not rival.peer.startswith("stiefel_rs")}
    return [line for line in lines if line.other in others] or [replace(lines[0], other="", figure="", ratio="")]


def verdicts(outcomes: Sequence[Outcome]) -> str:
    """How many targets are met, and a line for each that is missed."""
    judged = [line for outcome in outcomes for line in lines_of(outcome) if line.reached is not None]
    missed = [f"missed: {line.work}: {line.judged}, {line.reach}" for line in judged if not line.reached]
    return "\n".join([f"{len(judged) - len(missed)} of {len(judged)} targets are met", *missed])


def lines_of(outcome: Outcome) -> list[Line]:
    """Lines of one row: its own target, its rivals, its bounds."""
    ours = _figure(outcome.ours)
    work = outcome.row.title
    lines = [_against(work, ours, outcome, rival) for rival in outcome.row.rivals]
    own = _own(work, ours, outcome)
    # Our own target stands in the first line that has no other.
    free = next((i for i, line in enumerate(lines) if not line.reach), None)
    if free is not None:
        lines[free] = replace(lines[free], reach=own.reach, reached=own.reached, judged=own.judged)
    elif own.reach or not lines:
        lines.insert(0, own)
    for bound in outcome.row.bounds:
        value = outcome.numbers[bound.measure]
        found = f"{value:.3g}" if isinstance(value, float) else f"skipped: {value}"
        if bound.bound is None:
            lines.append(Line(work, f"{bound.label}: {found}", "", ""))
            continue
        reached = value <= bound.bound if isinstance(value, float) else None
        text = f"{bound.label}: {found}"
        lines.append(Line(work, text, "", "", "", f"<= {bound.bound:.3g}", reached, text))
    return lines


def _own(work: str, ours: str, outcome: Outcome) -> Line:
    target = outcome.row.seconds
    reached = outcome.ours.best <= target if target is not None and isinstance(outcome.ours, Figure) else None
    return Line(work, ours, "", "", "", f"<= {seconds(target)}" if target is not None else "", reached, ours)


def _against(work: str, ours: str, outcome: Outcome, rival: Rival) -> Line:
    figure = outcome.rivals[rival]
    if not (isinstance(figure, Figure) and isinstance(outcome.ours, Figure)):
        return Line(work, ours, rival.label, _figure(figure), "", _reach(outcome, rival))
    ratio = figure.best / outcome.ours.best
    reached = [ratio >= 1 / rival.at_most] if rival.at_most is not None else []
    if _is_best(outcome, rival):
        assert outcome.row.ahead is not None
        reached.append(ratio >= outcome.row.ahead)
    verdict = all(reached) if reached else None
    judged = f"{ours} beside {_figure(figure)}, ratio {ratio:.3g}"
    return Line(work, ours, rival.label, _figure(figure), f"{ratio:.3g}", _reach(outcome, rival), verdict, judged)


def _is_best(outcome: Outcome, rival: Rival) -> bool:
    """Whether the target relative to the best rival is judged on this rival."""
    times = {r: f.best for r, f in outcome.rivals.items() if isinstance(f, Figure) and r.best_of}
    return outcome.row.ahead is not None and bool(times) and min(times, key=lambda r: times[r]) is rival


def _reach(outcome: Outcome, rival: Rival) -> str:
    if rival.at_most is not None:
        return f"<= {rival.at_most:g} times the other" if rival.at_most > 1 else f"ratio >= {1 / rival.at_most:.3g}"
    return f"ratio >= {outcome.row.ahead:g}" if _is_best(outcome, rival) else ""


def _figure(figure: Figure | str) -> str:
    if isinstance(figure, str):
        return f"skipped: {figure}"
    threads = f", on {figure.threads:.1f} threads" if figure.threads > SINGLE else ""
    setup = f", after {seconds(figure.setup)} of compilation" if figure.setup else ""
    error = f", error {figure.error:.1g}" if figure.error is not None else ""
    note = f", {figure.note}" if figure.note else ""
    median = f" (median {seconds(figure.median)})" if figure.median > NOISY * figure.best else ""
    return f"{seconds(figure.best)}{median}{threads}{error}{setup}{note}"
