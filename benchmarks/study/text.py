"""Tables and sentences of the study; every number comes from the run."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tabulate import tabulate  # type: ignore[import-untyped]

from benchmarks.durations import seconds as duration
from benchmarks.study.cases import REFERENCE_STEPS, Case
from benchmarks.study.long_runs import Drift, Energy
from benchmarks.study.work import ACCURATE, EMBEDDED, Cost, Solve, fastest_below

# Relative energy errors below this are round-off; growth up to this factor counts as none.
ROUND_OFF = 1e-13
LEVEL = 1.1
SECOND_ORDER = ("splitting, order 2", EMBEDDED, "chart, midpoint")
PEERS = ("heyoka", "SciPy DOP853")
# The largest speed represents that of the curve. A method has left the curve if its largest speed differs by more than
# this fraction, or if its energy error exceeds the energy.
REFERENCE_METHOD = "splitting, order 8"
SAME_SPEED = 0.1


def table(rows: Sequence[Sequence[object]], headers: Sequence[str]) -> str:
    """A Markdown table."""
    return str(tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True))


def _listed(names: Sequence[str]) -> str:
    """Join names of methods, which contain commas."""
    return ", ".join(f"*{name}*" for name in names)


def references(cases: list[Case], checks: dict[str, float]) -> str:
    """The origin of the exact ends, and the distance of the Taylor method from them."""
    other = f"{REFERENCE_STEPS} steps of the splitting of order 8"
    return "\n".join(
        f"- {case.name}: {'40 digits' if case.forty_digits else other}; Taylor is {checks[case.name]:.1e} off."
        for case in cases
    )


def compilation(solves: list[Solve]) -> str:
    """Compilation times of heyoka."""
    found: dict[str, list[float]] = {}
    for solve in solves:
        if solve.method == "heyoka":
            found.setdefault(solve.case, []).append(solve.compile_seconds)
    if not found:
        return "it was left out of this run."
    return "; ".join(f"{case}, {min(s):.2g} to {max(s):.2g} s by tolerance" for case, s in found.items()) + "."


def work_table(solves: list[Solve]) -> str:
    """Fastest accurate solve of each method."""
    rows = []
    for case in dict.fromkeys(solve.case for solve in solves):
        best = sorted(fastest_below([s for s in solves if s.case == case], ACCURATE).values(), key=lambda s: s.best)
        rows += [
            (case, s.method, s.parameter, f"{s.error:.1e}", f"{duration(s.best)} ({duration(s.median)})",
             f"{s.best / best[0].best:.3g}")
            for s in best
        ]  # fmt: skip
    return table(rows, ("curve", "method", "with", "error", "time", "over the fastest"))


def work_text(solves: list[Solve]) -> str:
    """The methods that win, and those that never reach the accuracy."""
    lines = []
    for case in dict.fromkeys(solve.case for solve in solves):
        found = [s for s in solves if s.case == case]
        best = fastest_below(found, ACCURATE)
        missing = [m for m in dict.fromkeys(s.method for s in found) if m not in best]
        smallest = min(found, key=lambda s: s.error)
        text = f"- {case}: "
        if best:
            winner = min(best.values(), key=lambda s: s.best)
            text += f"{winner.method} is the fastest at that error"
            text += "".join(
                f", {best[peer].best / winner.best:.3g} times as fast as {peer}"
                for peer in PEERS if peer in best and peer != winner.method
            )  # fmt: skip
            ours = [s for m, s in best.items() if m not in PEERS]
            if ours and winner.method in PEERS:
                nearest = min(ours, key=lambda s: s.best)
                text += f" and {nearest.best / winner.best:.3g} times as fast as {nearest.method}, the fastest of ours"
            text += "; "
        text += f"the smallest error of all is {smallest.error:.1e} ({smallest.method}, {smallest.parameter})"
        if missing:
            text += f"; above {ACCURATE:.0e} with every parameter tried: {_listed(missing)}"
        lines.append(text + ".")
    return "\n".join(lines)


def second_order_table(solves: list[Solve]) -> str:
    """Errors and times of one step of the methods of order 2, at equal steps."""
    found: dict[tuple[str, str], dict[str, Solve]] = {}
    for solve in solves:
        if solve.method in SECOND_ORDER:
            found.setdefault((solve.case, solve.parameter), {})[solve.method] = solve
    rows = [
        (case, parameter, *(
            f"{by[m].error:.1e}, {duration(by[m].best / int(parameter.split()[0]))}" if m in by else ""
            for m in SECOND_ORDER
        ))
        for (case, parameter), by in found.items() if EMBEDDED in by
    ]  # fmt: skip
    return table(rows, ("curve", "with", *SECOND_ORDER))


def energy_table(energies: list[Energy]) -> str:
    """Energy errors of all methods."""
    exact = {e.curve: e.speeds[1] for e in energies if e.method == REFERENCE_METHOD}
    rows = [
        (e.curve, e.method, "stopped", "", "", e.refused)
        if e.refused
        else (
            e.curve, e.method, f"{e.error.max():.1e}", f"{e.growth:.2g}", f"{e.speeds[1]:.4g}",
            "left the curve" if abs(e.speeds[1] / exact[e.curve] - 1) > SAME_SPEED or e.error.max() > 1 else "",
        )
        for e in energies
    ]  # fmt: skip
    return table(rows, ("curve", "method", "largest error", "growth", "largest speed", "what became of it"))


def energy_text(energies: list[Energy]) -> str:
    """Growth of the errors, in words and numbers."""
    lines = []
    for curve in dict.fromkeys(e.curve for e in energies):
        ran = [e for e in energies if e.curve == curve and not e.refused]
        stopped = [e.method for e in energies if e.curve == curve and e.refused]
        # The growth of round-off does not characterise a method.
        level = [e for e in ran if e.error.max() <= ROUND_OFF]
        kept = [e for e in ran if e.growth <= LEVEL and e not in level]
        grown = [e for e in ran if e not in kept and e not in level]
        parts = [
            f"{words} for {_listed(names)}"
            for words, names in (
                (f"stays below {ROUND_OFF:.0e}", [e.method for e in level]),
                (f"does not grow (by a factor of {LEVEL:g} at most)", [e.method for e in kept]),
                ("grows", [f"{e.method}: {e.growth:.2g} times" for e in grown]),
            )
            if names
        ]
        end = f"; {_listed(stopped)} did not get to the end" if stopped else ""
        lines.append(f"- {curve}: the error {'; it '.join(parts)}{end}.")
    return "\n".join(lines)


def drift_table(drifts: list[Drift]) -> str:
    """All three drifts."""
    rows = [
        (f"St({d.n},{d.k})", d.steps, f"{d.momentum:.1e}", f"{d.constraint:.1e}", f"{d.orthonormality:.1e}")
        for d in drifts
    ]
    return table(rows, ("manifold", "steps", "momentum", "constraint", "orthonormality"))


def drift_text(drifts: list[Drift]) -> str:
    """The largest drifts."""
    most = max(d.steps for d in drifts)
    found = [d for d in drifts if d.steps == most]
    values = ", ".join(
        f"{name} {max(getattr(d, name) for d in found):.1e}" for name in ("momentum", "constraint", "orthonormality")
    )
    return f"Largest of all sizes after {most} steps: {values}. St(3,2) has no constraint."


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Least-squares slope of log y over log x."""
    u, v = [math.log(a) for a in x], [math.log(b) for b in y]
    mean_u, mean_v = sum(u) / len(u), sum(v) / len(v)
    covariance = sum((a - mean_u) * (b - mean_v) for a, b in zip(u, v, strict=True))
    return covariance / sum((a - mean_u) ** 2 for a in u)


def cost_table(costs: list[Cost]) -> str:
    """Times of a step."""
    rows = [
        (f"St({c.n},{c.k})", c.rows, *(duration(seconds) for seconds in c.step.values()), c.taylor_steps) for c in costs
    ]
    return table(rows, ("manifold", "r", *costs[0].step, "Taylor steps timed"))


def cost_text(costs: list[Cost]) -> str:
    """Measured orders, from the sizes where products dominate."""
    lines = []
    large = [c for c in costs if c.rows >= 10]
    if len({c.rows for c in large}) > 1:
        orders = {m: slope([c.rows for c in large], [c.step[m] for c in large]) for m in costs[0].step}
        values = ", ".join(f"{method} {order:.2f}" for method, order in orders.items())
        lines.append(
            f"- Fitted powers of r for r from {min(c.rows for c in large)} to {max(c.rows for c in large)}: {values}; "
            "3 is the limit, from below: small products do not reach the speed of large ones."
        )
    by = {(c.n, c.k): c for c in costs}
    if (50, 5) in by and (1000, 5) in by:
        ratios = ", ".join(f"{m} {by[1000, 5].step[m] / by[50, 5].step[m]:.2f}" for m in costs[0].step)
        lines.append(f"- Twenty times the rows at k = 5, St(1000,5) over St(50,5): {ratios}.")
    ratio = [c.step["Taylor"] / c.step["splitting, order 2"] for c in costs]
    lines.append(
        f"- A Taylor step takes {min(ratio):.3g} to {max(ratio):.3g} times as long as one of the splitting of order 2."
    )
    return "\n".join(lines)
