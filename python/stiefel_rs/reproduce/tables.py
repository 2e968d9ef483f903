"""The tables of the paper's comparison as CSV, Markdown and LaTeX, and the summary that reads them."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]

from .._core import Stiefel
from ..errors import ConvergenceError, OutsideDomainError
from . import experiments
from .experiments import ALL_METHODS, EXPERIMENTS, MAPS, METHODS, SPHERE, STIEFEL_3_2, ErrorRow, Experiment, TimingRow

LABELS: Final = {
    "gcp": "GCP",
    "reference": "reference",
    "initial_point_ivp": "initial-point IVP",
    "initial_point_bvp": "initial-point BVP",
    "midpoint_ivp": "mid-point IVP",
    "midpoint_bvp": "mid-point BVP",
    "splitting_2": "splitting 2 IVP",
    "splitting_4": "splitting 4 IVP",
    "splitting_6": "splitting 6 IVP",
    "splitting_8": "splitting 8 IVP",
    "exact_bvp": "exact cubic BVP",
}
MAP_LABELS: Final = {"initial_point": "initial-point", "midpoint": "mid-point"}
LONG_RUN_STEP: Final = 0.01
LONG_RUN_ENDS: Final = (1, 2, 3)


@dataclass(frozen=True)
class Results:
    """Everything that was measured in one run; `rows` by the name of the experiment, in increasing ``N``."""

    rows: dict[str, list[ErrorRow]]
    timing: list[TimingRow]


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    """Write one table; floats keep every digit."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    return path


def _table(header: Sequence[str], rows: Sequence[Sequence[object]], style: str = "pipe") -> str:
    align = ["right" if str(cell)[:1].isdigit() else "left" for cell in rows[0]] if rows else None
    return str(tabulate(rows, header, tablefmt=style, disable_numparse=True, colalign=align))


def write_error_tables(folder: Path, experiment: Experiment, rows: list[ErrorRow]) -> list[Path]:
    """Write the mean errors of one experiment as CSV, Markdown (``.md``) and LaTeX (``.tex``, booktabs)."""
    stem = folder / experiment.name
    exact = [(r.steps, r.h, *(r.errors[m] for m in ALL_METHODS)) for r in rows]
    paths = [write_csv(stem.with_suffix(".csv"), ["N", "h", *ALL_METHODS], exact)]
    rounded = [[str(r.steps), f"{r.h:.4g}", *(f"{r.errors[m]:.4e}" for m in ALL_METHODS)] for r in rows]
    slopes = ["order", ""] + [_slope_text(rows, m) for m in ALL_METHODS]
    header = ["N", "h", *(LABELS[m] for m in ALL_METHODS)]
    for suffix, style in ((".md", "pipe"), (".tex", "latex_booktabs")):
        path = stem.with_suffix(suffix)
        path.write_text(_table(header, [*rounded, slopes], style) + "\n", encoding="utf-8")
        paths.append(path)
    return paths


def write_all(folder: Path, results: Results) -> list[Path]:
    """Write every table and the summary into `folder`, which must exist; the paths written."""
    paths = [p for e in EXPERIMENTS for p in write_error_tables(folder, e, results.rows[e.name])]
    timing = [(t.manifold, t.method, t.steps, t.seconds, t.ratio) for t in results.timing]
    header = ["manifold", "method", "N", "seconds_per_curve", "ratio_to_gcp"]
    paths.append(write_csv(folder / "timing.csv", header, timing))
    path = folder / "summary.md"
    path.write_text(summary(results), encoding="utf-8")
    return [*paths, path]


def _slope_text(rows: list[ErrorRow], method: str) -> str:
    value = experiments.slope(rows, method)
    return "-" if value is None else f"{value:.3f}"


def headline(results: Results) -> list[str]:
    """One line for each experiment, for the terminal."""
    lines = []
    for e in EXPERIMENTS:
        rows = results.rows[e.name]
        orders = ", ".join(f"{LABELS[m]} {_slope_text(rows, m)}" for m in METHODS[1:])
        last = rows[-1]
        lines.append(f"{e.title}: mean error of GCP {last.errors['gcp']:.4e} at N = {last.steps}; orders: {orders}")
    return lines


def _percent(x: float) -> str:
    return f"{100 * x:.4g} %"


def _gcp_error() -> str:
    cells = []
    mean = {e.name: experiments.mean_errors(e, 100).errors["gcp"] for e in EXPERIMENTS}
    for e in EXPERIMENTS:
        error = mean[e.name]
        measured = f"{error:.4e} = {_percent(error)}"
        cells.append([e.title, _percent(e.paper_error), measured, f"{e.diameter:.4g}", _percent(error / e.diameter)])
    header = ["manifold", "paper", "mean error, N = 100", "largest distance", "mean error / largest distance"]
    excess = SPHERE.paper_error / mean[SPHERE.name]
    return f"""## 1, 2. Mean error of GCP

The paper: relative mean errors of "around 0.080 %" on the sphere and "0.45 %" on St(3,2), the mean error over the
largest distance of two points.

{_table(header, cells)}

The largest Frobenius distance of two points is `2 sqrt(k)`, that of `S` and `-S`, since
`|S - T|^2 = 2 k - 2 tr(S^T T)` and both lie in St(3,k) for k < 3: 2 on the sphere, 2.828 on St(3,2).

On St(3,2) the paper's 0.45 % is the mean error before any division; divided by the largest distance it is smaller by
the factor 2.828. On the sphere the paper's 0.080 % is {excess:.2g} times the mean error, and {2 * excess:.2g} times the
mean error over the largest distance. It does not follow from the stated initial data under any reading of them that was
tried:

{_conventions()}
"""


def _conventions() -> str:
    cells = []
    for e in EXPERIMENTS:
        for name, found in experiments.gcp_error_by_convention(e, 100).items():
            if isinstance(found, str):
                cells.append([e.title, name, found, "-", "-"])
            else:
                mean, largest = found
                cells.append([e.title, name, _percent(mean), _percent(mean / e.diameter), _percent(largest)])
    header = ["manifold", "qddot, qdddot read as", "mean error of GCP", "over largest distance", "largest error"]
    return _table(header, cells)


def _constant_error(results: Results) -> str:
    cells = []
    for e in EXPERIMENTS:
        rows = results.rows[e.name]
        errors = [r.errors["gcp"] for r in rows]
        change = abs(errors[-1] / errors[-2] - 1) if len(errors) > 1 else None
        cells.append(
            [
                e.title,
                f"{rows[0].steps} to {rows[-1].steps}",
                f"{errors[0]:.4e} to {errors[-1]:.4e}",
                " to ".join(f"{r.errors['gcp'] * (r.steps + 1) / r.steps:.4e}" for r in (rows[0], rows[-1])),
                "-" if change is None else _percent(change),
                _slope_text(rows, "gcp"),
            ]
        )
    header = ["manifold", "N", "mean error", "times (N + 1) / N", "change from the last N but one", "slope"]
    return f"""## 3. The error of GCP stays constant as h decreases

{_table(header, cells)}

GCP is one fixed curve, another one than the Riemannian cubic; only the grid on which the mean is taken changes. Both
ends count among the N + 1 points and have no error, so the mean over the grid is N / (N + 1) times the trapezoidal
value of the mean over time: hence the rise at small N. Without that factor the error is constant.
"""


def _orders(results: Results) -> str:
    cells = []
    for e in EXPERIMENTS:
        rows = results.rows[e.name]
        for m in METHODS[1:]:
            cells.append([e.title, LABELS[m], _slope_text(rows, m), _slope_text(rows[-2:], m)])
    header = ["manifold", "method", "slope over all N", "slope between the two largest N"]
    return f"""## 4. Order 1 of the initial-point method, order 2 of the mid-point method

{_table(header, cells)}

IVP: initial value problem. BVP: after shooting on the discrete flow, so that its end positions and end velocities are
those of the reference. Slopes are least-squares fits of log mean error against log h.
"""


def _verdict(timing: list[TimingRow], method: str) -> str:
    slower = []
    for e in EXPERIMENTS:
        sizes = [str(t.steps) for t in timing if (t.manifold, t.method) == (e.name, method) and t.ratio < 1]
        if sizes:
            slower.append(f"{e.title} at N = {', '.join(sizes)}")
    text = f"GCP is slower on {' and on '.join(slower)}" if slower else "GCP is faster at every N, on both manifolds"
    return f"- Against {LABELS[method]}: {text}."


def _cost(results: Results) -> str:
    sizes = sorted({t.steps for t in results.timing})
    ratio = {(t.manifold, t.method, t.steps): t.ratio for t in results.timing}
    seconds = {(t.manifold, t.method, t.steps): t.seconds for t in results.timing}
    cells = []
    for e in EXPERIMENTS:
        times = [f"{1e3 * seconds[e.name, 'gcp', n]:.3g} ms" for n in sizes]
        cells.append([e.title, "GCP, time of one curve", *times])
        for m in experiments.TIMED_METHODS[1:]:
            cells.append([e.title, LABELS[m], *(f"{ratio[e.name, m, n]:.3g}" for n in sizes)])
    verdict = "\n".join(_verdict(results.timing, m) for m in experiments.TIMED_METHODS[1:])
    return f"""## 5. Relative cost: the claim that GCP is faster

{_table(["manifold", "time, as a multiple of that of GCP", *(f"N = {n}" for n in sizes)], cells)}

{verdict}

One curve with N + 1 points, one thread, median of repetitions that alternate between all methods. These are the times
of this implementation on this machine in this run; they change from run to run. At small N the building of the curve
and the call from Python are most of the time of GCP. GCP and the BVP methods solve the same
problem (end points and end velocities), so GCP against BVP is the comparison of like with like; an IVP method is given
the initial acceleration and jerk, which in a boundary value problem are the unknowns. The reference is a Taylor method
of order 26 in the chart. The splittings and the exact cubic use no chart; the exact cubic is found by shooting, anew
for every curve.
"""


def _overtaking(results: Results) -> str:
    cells = []
    for e in EXPERIMENTS:
        rows = results.rows[e.name]
        for m in METHODS[1:]:
            n = experiments.overtakes(e, rows, m)
            last = rows[-1]
            where = f"not up to N = {last.steps}" if n is None else f"N = {n}"
            cells.append([e.title, LABELS[m], where, f"{last.errors['gcp'] / last.errors[m]:.3g}"])
    largest = results.rows[SPHERE.name][-1].steps
    header = [
        "manifold",
        "method",
        "smaller error than GCP from",
        f"error of GCP / error of the method at N = {largest}",
    ]
    return f"""## 6. The retraction method reaches smaller errors for small h

{_table(header, cells)}
"""


def _symplectic() -> str:
    cells = []
    for e in EXPERIMENTS:
        for m in MAPS:
            for n in experiments.FLOW_STEPS:
                d = experiments.drift(e, m, n)
                cyclic = ", ".join(f"p_{name}: {values.max():.1g}" for name, values in d.cyclic.items())
                energy = f"{np.abs(d.energy).max():.4e}"
                cells.append([e.title, MAP_LABELS[m], str(n), energy, cyclic, f"{d.other.max():.4e}"])
    header = ["manifold", "method", "N", "energy", "cyclic momenta", "other two momenta"]
    return f"""## 7. Energy and momentum along the discrete flows

Largest deviation from the initial value over 0 <= t <= 1:

{_table(header, cells)}

`phi` is cyclic in both charts and `psi` on St(3,2): both methods keep their momenta. The exact flow keeps all three
components of the momentum of rotations; the other two are no coordinates' momenta, and the methods keep them only to
their order, as they do the energy: both fall by about 10 (order 1) or 100 (order 2) from N = 10 to N = 100. The dip of
the initial-point method in the energy figure of the sphere is a change of sign.

Over longer times at the fixed step h = {LONG_RUN_STEP:g}, largest energy deviation:

{_long_runs()}

So over 0 <= t <= 1 the energy error is small and of the order of the method. An error bounded in time cannot be seen
with these data: the curves speed up, and the error grows with the end time. On St(3,2) the curve also passes close to
the pole of the chart (small `sin theta`), where a fixed step in its coordinates fails.
"""


def _long_runs() -> str:
    cells = []
    for e in EXPERIMENTS:
        for m in MAPS:
            row = [e.title, MAP_LABELS[m]]
            for t_end in LONG_RUN_ENDS:
                try:
                    energy = experiments.drift(e, m, round(t_end / LONG_RUN_STEP), t_end).energy
                    row.append(f"{np.abs(energy).max():.4e}")
                except OutsideDomainError:
                    row.append("leaves the chart")
                except ConvergenceError:
                    row.append("implicit step fails")
            cells.append(row)
        t = LONG_RUN_ENDS[-1] * experiments.time_grid(300)
        z, d = e.chart.reference(experiments.initial_state(e), t), e.chart.d
        velocity = e.chart.embed_velocity(z[:, :d], z[:, d : 2 * d])
        speed = Stiefel(3, e.chart.k).norm(experiments.points(e, z), velocity)
        shown = [(np.sin(z[t <= end, 0]).min(), speed[t <= end][-1]) for end in LONG_RUN_ENDS]
        cells.append([e.title, "smallest `sin theta` of the reference", *(f"{sine:.4f}" for sine, _ in shown)])
        cells.append([e.title, "speed of the reference at the end", *(f"{v:.2f}" for _, v in shown)])
    return _table(["manifold", "method", *(f"t <= {t_end}" for t_end in LONG_RUN_ENDS)], cells)


def _independent(results: Results) -> str:
    cells = []
    worst = 0.0
    for e in EXPERIMENTS:
        for row in results.rows[e.name]:
            if row.steps not in e.independent:
                continue
            for m, expected in zip(METHODS, e.independent[row.steps], strict=True):
                difference = row.errors[m] / expected - 1
                worst = max(worst, abs(difference))
                measured = f"{row.errors[m]:.4e}"
                cells.append([e.title, str(row.steps), LABELS[m], f"{expected:.4e}", measured, f"{difference:+.1e}"])
    if not cells:
        sizes = ", ".join(str(n) for n in STIEFEL_3_2.independent)
        return f"## Independent recomputation\n\nNone of its N ({sizes}) was run.\n"
    header = ["manifold", "N", "method", "independent", "measured", "relative difference"]
    return f"""## Independent recomputation (NumPy/mpmath)

Mean errors from an independent program, printed to five digits, beside those of this run. Largest relative
difference: {worst:.1e} (half a unit of the fifth digit is 5e-5 at most).

{_table(header, cells)}
"""


def summary(results: Results) -> str:
    """Text of ``summary.md``: the claims of the paper one by one, beside what was measured."""
    intro = """# The comparison of arXiv 2404.19407, recomputed

Mean Frobenius distance to the reference curve over the N + 1 grid points of 0 <= t <= 1, h = 1 / N. GCP is the
geometric cubic polynomial of the adjusted de Casteljau algorithm with the end points and end velocities of the
reference. Initial data as stated in the paper, read as coordinate derivatives in its charts. Each heading is a claim of
the paper; what was measured is below it.
"""
    sections = [
        intro,
        _gcp_error(),
        _constant_error(results),
        _orders(results),
        _cost(results),
        _overtaking(results),
        _symplectic(),
        _independent(results),
    ]
    return "\n".join(sections)
