"""Sections of ``summary.md`` behind the claims: the step and the errors, flatness, the two maps, times."""

from __future__ import annotations

from . import timing
from .experiments import EXPERIMENTS, METHODS, TIMED_METHODS, ErrorRow
from .measurements import Measurements
from .paper_tables import slope_text
from .text import LABELS, between, milliseconds, percent, table


def constant_part(rows: list[ErrorRow]) -> list[float]:
    """Mean errors of GCP times ``(N + 1) / N``: without the two ends, which are exact."""
    return [r.errors["gcp"] * (r.steps + 1) / r.steps for r in rows]


def step(found: Measurements) -> str:
    """Compare the error of GCP, which does not depend on the step, with the integrators' errors, which decrease."""
    cells = []
    for e in EXPERIMENTS:
        rows = found.rows[e.name]
        constant = constant_part(rows)
        spread = max(constant) / min(constant) - 1
        span = " to ".join(f"{r.errors['gcp']:.4e}" for r in (rows[0], rows[-1]))
        numbers = [span, between(constant, 5), percent(spread)]
        cells.append([e.title, f"{rows[0].steps} to {rows[-1].steps}", *numbers])
    orders = [
        [e.title, LABELS[m], slope_text(found.rows[e.name], m), slope_text(found.rows[e.name][-2:], m)]
        for e in EXPERIMENTS
        for m in METHODS[1:]
    ]
    return f"""### The error and the step

GCP is one fixed curve; only the grid changes over which the mean is taken. Both ends count among the N + 1 points and
have no error, so the mean is N / (N + 1) times the mean over time by the trapezoidal rule. Without that factor:

{table(["manifold", "N", "mean error of GCP", "times (N + 1) / N", "its spread"], cells, 2)}

Slopes of log mean error against log h, least squares (IVP: initial values; BVP: boundary values, met by shooting on the
discrete flow):

{table(["manifold", "method", "slope over all N", "slope between the two largest N"], orders, 2)}
"""


def flatness(found: Measurements) -> str:
    """Where GCP is exact."""
    cells = [["St(2,1), flat", f"{found.geometry.circle_error:.1e}"]]
    for e in EXPERIMENTS:
        cells.append([e.title, f"{found.rows[e.name][-1].errors['gcp']:.1e}"])
    return f"""### Exact where the manifold is flat

In Euclidean space the de Casteljau algorithm gives the exact cubic, and likewise on St(2,1), the circle, which is flat:
the largest distance between GCP and the Riemannian cubic for random boundary data, compared with the mean errors on the
paper's curves at N = {found.settings.steps[-1]}:

{table(["manifold", "error of GCP"], cells)}
"""


def gains(rows: list[ErrorRow], problem: str) -> list[float]:
    """Errors of the initial-point method divided by the errors of the mid-point method, by ``N``."""
    return [r.errors[f"initial_point_{problem}"] / r.errors[f"midpoint_{problem}"] for r in rows]


def two_maps(found: Measurements) -> str:
    """Compare the mid-point method with the initial-point method."""
    cells = [
        [e.title, problem.upper(), *(f"{x:.3g}" for x in gains(found.rows[e.name], problem))]
        for e in EXPERIMENTS
        for problem in ("ivp", "bvp")
    ]
    header = ["manifold", "problem", *(f"N = {n}" for n in found.settings.steps)]
    return f"""### The mid-point map against the initial-point map

Mean error of the initial-point method, order 1, divided by the mid-point method's, order 2:

{table(header, cells, 2)}

The paper sees a trend towards its conjecture here. Both maps come from the same retraction, linear in coordinates: the
gain is due to order 2 instead of order 1, and does not tell about better retractions.
"""


def _time_table(found: Measurements, methods: tuple[str, ...]) -> str:
    sizes = found.settings.steps
    ratio = {(t.manifold, t.method, t.steps): t.ratio for t in found.timing}
    seconds = {(t.manifold, t.method, t.steps): t.seconds for t in found.timing}
    cells = []
    for e in EXPERIMENTS:
        cells.append([e.title, "GCP, time", *(milliseconds(seconds[e.name, "gcp", n]) for n in sizes)])
        for m in methods:
            cells.append([e.title, LABELS[m], *(f"{ratio[e.name, m, n]:.3g}" for n in sizes)])
    return table(["manifold", "time, GCP = 1", *(f"N = {n}" for n in sizes)], cells, 2)


def _overtaking(found: Measurements) -> str:
    equal = {(x.manifold, x.method): x for x in found.equal_error}
    cells = []
    for e in EXPERIMENTS:
        for m in METHODS[1:]:
            n = found.overtaking[e.name, m]
            row = equal.get((e.name, m))
            ratio = "-" if row is None or row.ratio is None else f"{row.ratio:.3g}"
            cells.append([e.title, LABELS[m], "no N of this run" if n is None else f"N = {n}", ratio])
    return table(["manifold", "method", "smaller error than GCP from", "its time there, GCP = 1"], cells, 2)


def times(found: Measurements) -> str:
    """Compare the times of the paper's methods, at equal ``N`` and at equal error."""
    shooting = "; ".join(
        f"{LABELS[f'{m}_ivp'].removesuffix(' IVP')} {between(timing.over(found.timing, f'{m}_bvp', f'{m}_ivp'))}"
        for m in ("initial_point", "midpoint")
    )
    return f"""### Times

One curve with N + 1 points, one thread, as multiples of GCP's time:

{_time_table(found, METHODS[1:])}

Time with shooting (BVP) over time without (IVP): {shooting}.

At equal error: the first N at which a method's mean error is below GCP's and, for boundary values, its time there, with
GCP's for as many points as the unit:

{_overtaking(found)}

GCP and the BVP methods solve the same problem, so they are compared like with like; an IVP method is given the initial
acceleration and jerk, which in a boundary value problem are the unknowns. Times are the shortest of repetitions that
alternate between all methods, of this implementation on one machine; they change from run to run.
"""


def chart_free_times(found: Measurements) -> str:
    """Compare the times of the reference and of the methods without charts."""
    methods = tuple(m for m in TIMED_METHODS if m not in METHODS)
    return f"""### Times of the methods without charts

As above. The reference is a Taylor method of order 26 in the chart; the exact cubic is found by shooting, again for
every curve:

{_time_table(found, methods)}
"""
