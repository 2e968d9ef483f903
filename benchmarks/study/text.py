"""Tables and sentences of the study; every number comes from the run."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tabulate import tabulate  # type: ignore[import-untyped]

from benchmarks.durations import seconds as duration
from benchmarks.study.cases import REFERENCE_STEPS, Case
from benchmarks.study.long_runs import Drift, Energy
from benchmarks.study.work import ACCURATE, EMBEDDED, Cost, Solve, fastest_below

# Relative energy errors below this are round-off.
ROUND_OFF = 1e-13
SECOND_ORDER = ("splitting, order 2", EMBEDDED, "chart, midpoint")
SHOWN_STEPS = ("10 steps", "100 steps", "1000 steps")
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
        f"- {case.name}: {'40 digits' if case.forty_digits else other}; Taylor: {checks[case.name]:.1e}."
        for case in cases
    )


def compilation(solves: list[Solve]) -> str:
    """Compilation times of heyoka."""
    found: dict[str, list[float]] = {}
    for solve in solves:
        if solve.method == "heyoka":
            found.setdefault(solve.case, []).append(solve.compile_seconds)
    if not found:
        return "not measured."
    return "; ".join(f"{case}, {min(s):.2g} to {max(s):.2g} s" for case, s in found.items()) + "."


def work_table(solves: list[Solve]) -> str:
    """Fastest accurate solve of each method."""
    rows = []
    for case in dict.fromkeys(solve.case for solve in solves):
        best = sorted(fastest_below([s for s in solves if s.case == case], ACCURATE).values(), key=lambda s: s.best)
        for solve in best:
            slower = f"{solve.best / best[0].best:.3g}"
            rows.append((case, solve.method, solve.parameter, f"{solve.error:.1e}", duration(solve.best), slower))
    return table(rows, ("curve", "method", "with", "error", "time", "over the fastest"))


def work_text(solves: list[Solve]) -> str:
    """The smallest errors, and the methods that never reach the required one."""
    lines = []
    for case in dict.fromkeys(solve.case for solve in solves):
        found = [s for s in solves if s.case == case]
        best = fastest_below(found, ACCURATE)
        missing = [m for m in dict.fromkeys(s.method for s in found) if m not in best]
        smallest = min(found, key=lambda s: s.error)
        text = f"- {case}: the smallest error is {smallest.error:.1e} ({smallest.method}, {smallest.parameter})"
        if missing:
            text += f"; never below {ACCURATE:.0e}: {_listed(missing)}"
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
        for (case, parameter), by in found.items() if EMBEDDED in by and parameter in SHOWN_STEPS
    ]  # fmt: skip
    return table(rows, ("curve", "with", *SECOND_ORDER))


def _clause(message: str) -> str:
    """First clause of an error message, without its numbers."""
    return message.partition(",")[0].partition(" = ")[0]


def energy_table(energies: list[Energy]) -> str:
    """Energy errors of all methods."""
    exact = {e.curve: e.speeds[1] for e in energies if e.method == REFERENCE_METHOD}
    rows = [
        (e.curve, e.method, "stopped", "", "", _clause(e.refused))
        if e.refused
        else (
            # The growth of round-off says nothing about a method.
            e.curve, e.method, f"{e.error.max():.1e}",
            f"{e.growth:.2g}" if e.error.max() > ROUND_OFF else "round-off",
            f"{e.speeds[1]:.4g}",
            "left the curve" if abs(e.speeds[1] / exact[e.curve] - 1) > SAME_SPEED or e.error.max() > 1 else "",
        )
        for e in energies
    ]  # fmt: skip
    return table(rows, ("curve", "method", "largest error", "growth", "largest speed", "outcome"))


def drift_table(drifts: list[Drift]) -> str:
    """All three drifts."""
    rows = [
        (f"St({d.n},{d.k})", d.steps, f"{d.momentum:.1e}", f"{d.constraint:.1e}", f"{d.orthonormality:.1e}")
        for d in drifts
    ]
    return table(rows, ("manifold", "steps", "momentum", "constraint", "orthonormality"))


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Least-squares slope of log y over log x."""
    u, v = [math.log(a) for a in x], [math.log(b) for b in y]
    mean_u, mean_v = sum(u) / len(u), sum(v) / len(v)
    covariance = sum((a - mean_u) * (b - mean_v) for a, b in zip(u, v, strict=True))
    return covariance / sum((a - mean_u) ** 2 for a in u)


def cost_table(costs: list[Cost]) -> str:
    """Times of a step."""
    rows = [(f"St({c.n},{c.k})", c.rows, *(duration(seconds) for seconds in c.step.values())) for c in costs]
    return table(rows, ("manifold", "r", *costs[0].step))


def cost_text(costs: list[Cost]) -> str:
    """Measured orders, from the sizes where products dominate."""
    lines = []
    large = [c for c in costs if c.rows >= 10]
    if len({c.rows for c in large}) > 1:
        orders = {m: slope([c.rows for c in large], [c.step[m] for c in large]) for m in costs[0].step}
        values = ", ".join(f"{method} {order:.2f}" for method, order in orders.items())
        lines.append(
            f"- Fitted powers of r, from r = {min(c.rows for c in large)} to {max(c.rows for c in large)}: {values}. "
            "The limit is 3; small products are slower than large ones."
        )
    by = {(c.n, c.k): c for c in costs}
    if (50, 5) in by and (1000, 5) in by:
        ratios = ", ".join(f"{m} {by[1000, 5].step[m] / by[50, 5].step[m]:.2f}" for m in costs[0].step)
        lines.append(f"- Time on St(1000,5) divided by that on St(50,5): {ratios}.")
    ratio = [c.step["Taylor"] / c.step["splitting, order 2"] for c in costs]
    lines.append(
        f"- A Taylor step takes {min(ratio):.3g} to {max(ratio):.3g} times as long as a step of the splitting of order "
        "2."
    )
    return "\n".join(lines)
