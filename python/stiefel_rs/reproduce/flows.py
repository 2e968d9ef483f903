"""Energy and momentum along the discrete flows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from . import experiments
from .experiments import Array, Experiment, Map

FLOW_STEPS: Final = (10, 100)


def spatial_momentum(experiment: Experiment, z: Array) -> Array:
    """Momentum of the rotations of space, shape ``(..., 3)``, of the states `z`, shape ``(..., 4 d)``.

    Component i is ``p_q . xi_i + p_qdot . (D xi_i) qdot`` for the infinitesimal rotation ``xi_i`` about axis i. The
    third is ``p_phi``, since ``phi`` is cyclic in both charts. The exact flow keeps all three.
    """
    d = experiment.chart.d
    z = np.moveaxis(z, -1, 0)
    theta, theta_dot, phi_dot = z[0], z[d], z[d + 1]
    sin, cos = np.sin(theta), np.cos(theta)
    components = []
    for phi in (z[1], z[1] - math.pi / 2):
        s, c = np.sin(phi), np.cos(phi)
        field = (-s, -c * cos / sin, c / sin)
        rate = (
            -c * phi_dot,
            c / sin**2 * theta_dot + s * cos / sin * phi_dot,
            -c * cos / sin**2 * theta_dot - s / sin * phi_dot,
        )
        components.append(sum(z[2 * d + i] * field[i] + z[3 * d + i] * rate[i] for i in range(d)))
    return np.stack([*components, z[2 * d + 1]], axis=-1)


@dataclass(frozen=True)
class Drift:
    """Deviations from the initial values along one discrete flow, each of shape ``(steps + 1,)``.

    Attributes
    ----------
    energy : ndarray
        ``H(z_n) - H(z_0)``.
    cyclic : mapping of str to ndarray
        ``|p - p(0)|`` of the momenta of the cyclic coordinates: ``phi``, and ``psi`` on St(3,2).
    other : ndarray
        Norm of the deviation of the other two components of the spatial momentum.
    """

    t: Array
    energy: Array
    cyclic: Mapping[str, Array]
    other: Array


def drift(experiment: Experiment, step_map: Map, steps: int, t_end: float = 1.0) -> Drift:
    """Energy and momenta along the discrete flow from the paper's initial state."""
    chart, d = experiment.chart, experiment.chart.d
    z = chart.integrate(experiments.initial_state(experiment), steps, t_end, step_map)
    energy = chart.hamiltonian(z)
    momentum = spatial_momentum(experiment, z)
    cyclic = {name: np.abs(z[:, 2 * d + i] - z[0, 2 * d + i]) for i, name in ((1, "phi"), (2, "psi")) if i < d}
    other = np.linalg.norm(momentum[:, :2] - momentum[0, :2], axis=1)
    return Drift(t_end * experiments.time_grid(steps), energy - energy[0], cyclic, np.asarray(other))
