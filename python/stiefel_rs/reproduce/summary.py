"""Text of ``summary.md``: claims on the first page, the paper's figures and tables, evidence, other results."""

from __future__ import annotations

from . import (
    any_shape,
    beyond,
    challenges,
    claims,
    conjecture,
    control_points,
    embedded,
    evidence,
    exact,
    experiments,
    near_start,
    readings,
    retraction_pairs,
)
from .experiments import EXPERIMENTS
from .measurements import Measurements
from .paper_tables import PANELS, paper_table
from .text import LABELS


def _first_page(found: Measurements) -> str:
    return f"""# arXiv 2404.19407 recomputed: what holds

{found.settings.text()}

The numbers in the paper's figures and tables are not printed in its text, so they are recomputed here, not compared.
Errors are mean Frobenius distances to the exact curve over the N + 1 points of 0 <= t <= 1, h = 1 / N; GCP is the curve
of the adjusted de Casteljau algorithm. The paper's statements are shortened; the place is their section. "Much" means
a factor of {claims.MUCH:g} or more. IVP: initial values, with acceleration and jerk given. BVP: boundary values, met
by shooting. Compositions are several mid-point steps in place of one, for a higher order; splittings are explicit
symplectic integrators of this library, without charts.

## The statements of the paper

{claims.page(claims.read(found))}
"""


def _figures(found: Measurements) -> str:
    tables = "\n\n".join(
        f"""### Figure 2{panel}: mean errors, {experiment.title}

{paper_table(found.rows[experiment.name])}"""
        for panel, experiment in PANELS.items()
    )
    return f"""## The paper's figures and tables

Methods and names are the paper's: GCP, Retraction (initial-point map) and Mid-point Retraction, both with shooting.

### Figure 1: trajectories on the sphere

![Trajectories on the sphere](../figures/figure_1.png)

{tables}

### Figure 3: mean errors against the step

![Mean errors on the sphere](../figures/figure_3a.png)
![Mean errors on St(3,2)](../figures/figure_3b.png)
"""


def sections(found: Measurements) -> list[str]:
    """Return the parts of the summary in order."""
    steps = found.settings.steps
    behind = [
        readings.section(found.readings, steps),
        evidence.flatness(found),
        evidence.step(found),
        near_start.section(found.near_start),
        evidence.two_maps(found),
        conjecture.section(found.study),
        evidence.times(found),
        challenges.chart_section(found.challenges.poles),
        challenges.implicit_section(found.challenges.equal),
        embedded.section(found.embedded),
    ]
    further = [
        retraction_pairs.section(found.study),
        exact.section(found.exact, found.rows),
        any_shape.section(found.shapes),
        evidence.chart_free_times(found),
        control_points.section(found.control_points),
        beyond.energy(),
        beyond.independent(found.rows),
    ]
    heads = ["## What the verdicts rest on\n", "## Beyond the paper\n"]
    return [_first_page(found), _figures(found), heads[0], *behind, heads[1], *further]


def text(found: Measurements) -> str:
    """Text of ``summary.md``."""
    return "\n".join(sections(found))


def headline(found: Measurements) -> list[str]:
    """One line for each experiment, for the terminal."""
    lines = []
    for e in EXPERIMENTS:
        rows = found.rows[e.name]
        slopes = {m: experiments.slope(rows, m) for m in experiments.METHODS[1:]}
        orders = ", ".join(f"{LABELS[m]} {'-' if s is None else f'{s:.3f}'}" for m, s in slopes.items())
        last = rows[-1]
        lines.append(f"{e.title}: mean error of GCP {last.errors['gcp']:.4e} at N = {last.steps}; orders: {orders}")
    return lines
