"""The curves of the study of integrators: covariant initial data, a state of the paper's chart, and the exact end."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from benchmarks.environment import ROOT
from benchmarks.problems import Array, point, tangent
from stiefel_rs import Chart, integrate_cubic
from stiefel_rs.reproduce.experiments import SPHERE, STIEFEL_3_2

CUBICS = ROOT / "tests" / "data" / "cubics.json"
NAMES = ("point", "velocity", "acceleration", "jerk")
# Steps of the splitting of order 8, used where no digits are stored.
REFERENCE_STEPS = 1000
Data = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class Case:
    """A cubic on ``0 <= t <= 1``, its end (to 40 digits if known), and chart and state if there is a chart."""

    name: str
    data: Data
    end: Array
    forty_digits: bool
    chart: Chart | None = None
    state: Array | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Sizes n and k."""
        n, k = self.data[0].shape
        return n, k

    def error(self, end: Array) -> float:
        """Frobenius distance of a computed end from the exact one."""
        return float(np.linalg.norm(end - self.end))


def random_data(n: int, k: int, velocity: float = 1.0, acceleration: float = 1.0, jerk: float = 1.0) -> Data:
    """Random point and tangent vectors of the given canonical lengths."""
    S = point(n, k, 7)
    V, A, J = (tangent(S, length, 10 + key) for key, length in enumerate((velocity, acceleration, jerk)))
    return S, V, A, J


def cases() -> list[Case]:
    """The paper's two curves, and random ones on St(5,2) and St(10,3)."""
    stored = {(c.get("name"), c["n"], c["k"]): c for c in json.loads(CUBICS.read_text())}
    found = []
    for title, key, e in (
        ("sphere, the paper's curve", ("paper-sphere", 3, 1), SPHERE),
        ("St(3,2), the paper's curve", ("paper-stiefel-3-2", 3, 2), STIEFEL_3_2),
    ):
        state = np.concatenate([e.q, e.qdot, *e.chart.momenta(e.q, e.qdot, e.qddot, e.qdddot)])
        exact = np.array(stored[key]["at"]["1.0"]["point"])
        found.append(Case(title, e.chart.covariant(state), exact, True, e.chart, state))
    random = stored[None, 5, 2]
    S, V, A, J = (np.array(random["initial"][name]) for name in NAMES)
    found.append(Case("St(5,2), random", (S, V, A, J), np.array(random["at"]["1.0"]["point"]), True))
    data = random_data(10, 3)
    found.append(Case("St(10,3), random", data, integrate_cubic(*data, REFERENCE_STEPS, order=8).point[-1], False))
    return found
