"""Sections of ``summary.md`` beyond the paper: energy and momentum, and an independent recomputation."""

from __future__ import annotations

from typing import Final

import numpy as np

from .._core import Stiefel
from ..errors import ConvergenceError, OutsideDomainError
from . import experiments, flows
from .experiments import EXPERIMENTS, MAPS, METHODS, STIEFEL_3_2, ErrorRow
from .text import LABELS, MAP_LABELS, table

LONG_RUN_STEP: Final = 0.01
LONG_RUN_ENDS: Final = (1, 2, 3)


def energy() -> str:
    """Energy and momentum along the discrete flows."""
    cells = []
    for e in EXPERIMENTS:
        for m in MAPS:
            for n in flows.FLOW_STEPS:
                d = flows.drift(e, m, n)
                cyclic = ", ".join(f"p_{name}: {values.max():.1g}" for name, values in d.cyclic.items())
                energy = f"{np.abs(d.energy).max():.4e}"
                cells.append([e.title, MAP_LABELS[m], str(n), energy, cyclic, f"{d.other.max():.4e}"])
    header = ["manifold", "method", "N", "energy", "cyclic momenta", "other two momenta"]
    return f"""### Energy and momentum along the discrete flows

Largest deviation from the initial value over 0 <= t <= 1:

{table(header, cells, 2)}

`phi` is cyclic in both charts and `psi` on St(3,2): both methods keep their momenta. The exact flow keeps all three
components of the momentum of rotations. The other two are not momenta of coordinates; the methods keep them, and the
energy, only to their order: the deviations fall by about 10 (order 1) or 100 (order 2) from N = 10 to N = 100. The dip
of the initial-point method in the energy figure of the sphere is a change of sign.

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
                    energy = flows.drift(e, m, round(t_end / LONG_RUN_STEP), t_end).energy
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
    return table(["manifold", "method", *(f"t <= {t_end}" for t_end in LONG_RUN_ENDS)], cells, 2)


def independent(rows: dict[str, list[ErrorRow]]) -> str:
    """Compare the mean errors with those of an independent program."""
    cells = []
    worst = 0.0
    for e in EXPERIMENTS:
        for row in rows[e.name]:
            if row.steps not in e.independent:
                continue
            for m, expected in zip(METHODS, e.independent[row.steps], strict=True):
                difference = row.errors[m] / expected - 1
                worst = max(worst, abs(difference))
                measured = f"{row.errors[m]:.4e}"
                cells.append([e.title, str(row.steps), LABELS[m], f"{expected:.4e}", measured, f"{difference:+.1e}"])
    if not cells:
        sizes = ", ".join(str(n) for n in STIEFEL_3_2.independent)
        return f"### Independent recomputation\n\nNone of its N ({sizes}) was run.\n"
    header = ["manifold", "N", "method", "independent", "measured", "relative difference"]
    return f"""### Independent recomputation (NumPy/mpmath)

Mean errors from an independent program, printed to five digits, compared with this run. Largest relative
difference: {worst:.1e} (half a unit of the fifth digit is 5e-5 at most).

{table(header, cells, 3)}
"""
