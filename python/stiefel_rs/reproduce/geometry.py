"""Statements of the paper about its curves and maps, each as a number: geodesics, end data, flatness, symplecticity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from .._core import GeometricCubic, RiemannianCubic, Stiefel, orthogonal_log, skew_exp
from ..errors import InvalidInputError, OutsideDomainError
from . import experiments
from .experiments import EXPERIMENTS, MAPS, SPHERE, STIEFEL_3_2, Array, Experiment, Map

SEED: Final = 20240419
SAMPLES: Final = 200
CIRCLES: Final = 20
# Equal to round-off: distances of points and tangent vectors of length about 1.
ROUND_OFF: Final = 1e-12
# Of central differences with the step below, whose error is of order step^2.
DIFFERENCE_STEP: Final = 1e-5
DIFFERENCE_BOUND: Final = 1e-7
# Angles between two points of the sphere are drawn this far from pi/2 and pi at least.
ANGLE_MARGIN: Final = 0.05


def geodesic_distance(n: int, k: int, rng: np.random.Generator) -> float:
    """Largest distance of the end points of quasi-geodesics and geodesics of length 1, random starts."""
    manifold, largest = Stiefel(n, k), 0.0
    for _ in range(SAMPLES):
        S = manifold.random_point(rng)
        V = manifold.random_tangent(S, rng)
        V /= manifold.norm(S, V)
        largest = max(largest, float(np.linalg.norm(manifold.retract(S, V) - manifold.exp(S, V))))
    return largest


def counterexample() -> tuple[float, float, float]:
    """``|X|``, ``|Omega|`` and the distance to the geodesic for a velocity with ``K Omega = 0`` on St(4,3)."""
    manifold, S = Stiefel(4, 3), np.eye(4, 3)
    omega = np.zeros((3, 3))
    omega[0, 1], omega[1, 0] = -1.0, 1.0
    K = np.zeros((4, 3))
    K[3, 2] = 1.0
    V = S @ omega + K
    X, found = manifold.decompose(S, V)
    distance = np.linalg.norm(manifold.retract(S, V) - manifold.exp(S, V))
    return float(np.linalg.norm(X)), float(np.linalg.norm(found)), float(distance)


def printed_end(S0: Array, S1: Array) -> Array:
    """End of the quasi-geodesic by Proposition 1 as printed, with its ``n x n`` logarithm."""
    identity = np.eye(len(S0))
    X = orthogonal_log((identity - 2 * S1 @ S1.T) @ (identity - 2 * S0 @ S0.T)) / 2
    omega = orthogonal_log(S0.T @ skew_exp(-X) @ S1)
    return np.asarray(skew_exp(X) @ S0 @ skew_exp(omega))


def joined_on_the_sphere(rng: np.random.Generator) -> tuple[int, int]:
    """Count the pairs of points of the sphere that Proposition 1 joins, of `SAMPLES` below and beyond pi/2 each."""
    joined = [0, 0]
    manifold = Stiefel(3, 1)
    for beyond in (0, 1):
        for _ in range(SAMPLES):
            S = manifold.random_point(rng)
            V = manifold.random_tangent(S, rng)
            angle = beyond * math.pi / 2 + rng.uniform(ANGLE_MARGIN, math.pi / 2 - ANGLE_MARGIN)
            end = manifold.exp(S, angle / float(manifold.norm(S, V)) * V)
            try:
                joined[beyond] += bool(np.linalg.norm(printed_end(S, end) - end) < ROUND_OFF)
            except (InvalidInputError, OutsideDomainError):
                continue  # The logarithm of -1 in O(1).
    return joined[0], joined[1]


def end_defect() -> float:
    """Largest defect of GCP's end points and end velocities on the two experiments (Theorem 1)."""
    largest = 0.0
    for e in EXPERIMENTS:
        data = experiments.boundary_data(e, *experiments.reference(e, 1))
        curve = GeometricCubic(*data)
        found = (curve(0.0), curve.velocity(0.0), curve(1.0), curve.velocity(1.0))
        largest = max(largest, *(float(np.linalg.norm(a - b)) for a, b in zip(found, data, strict=True)))
    return largest


def circle_error(rng: np.random.Generator) -> float:
    """Largest distance of GCP and the exact cubic on St(2,1), a flat manifold, for random boundary data."""
    t, largest = experiments.time_grid(100), 0.0
    for _ in range(CIRCLES):
        angles, speeds = rng.uniform(-1.0, 1.0, 2), rng.uniform(-2.0, 2.0, 2)
        data = []
        for angle, speed in zip(angles, speeds, strict=True):
            c, s = math.cos(angle), math.sin(angle)
            data += [np.array([[c], [s]]), speed * np.array([[-s], [c]])]
        a, b = GeometricCubic(*data), RiemannianCubic.from_boundary(*data, tol=experiments.BOUNDARY_TOLERANCE)
        largest = max(largest, float(experiments.distances(a(t), b(t)).max()))
    return largest


def symplectic_defect(experiment: Experiment, step_map: Map) -> float:
    """Largest entry of ``M^T J M - J`` for the differential ``M`` of one step, by central differences."""
    z, d = experiments.initial_state(experiment), 2 * experiment.chart.d
    columns = []
    for direction in DIFFERENCE_STEP * np.eye(2 * d):
        ends = [experiment.chart.integrate(z + s * direction, 1, 0.1, step_map)[-1] for s in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2 * DIFFERENCE_STEP))
    M = np.array(columns).T
    J = np.block([[np.zeros((d, d)), np.eye(d)], [-np.eye(d), np.zeros((d, d))]])
    return float(np.abs(M.T @ J @ M - J).max())


def printed_sphere_hamiltonian(z: Array) -> float:
    """Return the paper's Hamiltonian on the sphere, transcribed."""
    theta, _, td, pd, p_t, p_p, p_td, p_pd = z
    s2 = math.sin(2 * theta)
    fraction = (-pd * td * p_pd * s2 + p_pd**2 / 2) / math.sin(theta) ** 2
    return float(pd**2 * p_td * s2 / 2 + pd * p_p + td * p_t + p_td**2 / 2 + fraction)


def printed_hamiltonian(z: Array, *, one_bracket: bool) -> float:
    """Return the paper's Hamiltonian on St(3,2), transcribed.

    The bracket that is opened after ``(1 - cos 2 theta)^3`` closes after the next fraction (`one_bracket`), or each
    fraction is read alone.
    """
    theta, _, _, td, pd, sd, p_t, p_p, p_s, p_td, p_pd, p_sd = z
    s, c, s2, c2, tan = math.sin(theta), math.cos(theta), math.sin(2 * theta), math.cos(2 * theta), math.tan(theta)
    first = -pd * td * p_pd * s2 / 8 + pd * td * p_sd * s / 4 + sd * td * p_pd * s / 4
    second = -sd * td * p_sd * s2 / 8 + p_pd**2 / 4 - p_pd * p_sd * c / 2 + p_sd**2 / 4
    factor = (1 - c2) ** 3
    fractions = factor * (first + second) if one_bracket else factor * first + second
    middle = -((-p_pd + p_sd / c) ** 2) / 2 - (-p_pd / c + p_sd) ** 2 / 2
    middle += p_pd**2 - p_pd * p_sd * c - p_pd * p_sd / c + p_sd**2
    rest = pd * p_p + sd * p_s + td * p_t - p_td**2 / 2 - p_td * (pd * sd * s - p_td)
    denominator = s**6 * tan**2
    return float((fractions / (c2 + 1) + middle * s**4 + rest * denominator) / denominator)


def sphere_hamiltonian_difference(rng: np.random.Generator) -> float:
    """Largest relative difference of the printed Hamiltonian to the metric's on the sphere, at random states."""
    states = rng.uniform(-1.0, 1.0, (SAMPLES, 8))
    states[:, 0] = rng.uniform(0.4, 2.7, SAMPLES)
    exact = SPHERE.chart.hamiltonian(states)
    printed = np.array([printed_sphere_hamiltonian(z) for z in states])
    return float((np.abs(printed - exact) / (1 + np.abs(exact))).max())


def hamiltonian_differences(rng: np.random.Generator) -> tuple[float, float]:
    """Largest relative difference of both readings to the canonical metric's Hamiltonian, at random states."""
    states = rng.uniform(-1.0, 1.0, (SAMPLES, 12))
    states[:, 0] = rng.uniform(0.4, 1.2, SAMPLES)
    exact = STIEFEL_3_2.chart.hamiltonian(states)
    scale = 1 + np.abs(exact)
    differences = []
    for one_bracket in (True, False):
        printed = np.array([printed_hamiltonian(z, one_bracket=one_bracket) for z in states])
        differences.append(float((np.abs(printed - exact) / scale).max()))
    return differences[0], differences[1]


@dataclass(frozen=True)
class Geometry:
    """Everything measured.

    Attributes
    ----------
    sphere_distance, frame_distance : float
        Of quasi-geodesics and geodesics on St(3,1) and St(3,2).
    counterexample : tuple of float
        See `counterexample`.
    joined : tuple of int
        See `joined_on_the_sphere`.
    end_defect, circle_error : float
        Of GCP.
    symplectic : float
        Largest defect of both maps on both manifolds.
    hamiltonian : tuple of float
        See `hamiltonian_differences`.
    sphere_hamiltonian : float
        See `sphere_hamiltonian_difference`.
    """

    sphere_distance: float
    frame_distance: float
    counterexample: tuple[float, float, float]
    joined: tuple[int, int]
    end_defect: float
    circle_error: float
    symplectic: float
    hamiltonian: tuple[float, float]
    sphere_hamiltonian: float


def measure() -> Geometry:
    """Measure everything."""
    rng = np.random.default_rng(SEED)
    return Geometry(
        sphere_distance=geodesic_distance(3, 1, rng),
        frame_distance=geodesic_distance(3, 2, rng),
        counterexample=counterexample(),
        joined=joined_on_the_sphere(rng),
        end_defect=end_defect(),
        circle_error=circle_error(rng),
        symplectic=max(symplectic_defect(e, m) for e in EXPERIMENTS for m in MAPS),
        hamiltonian=hamiltonian_differences(rng),
        sphere_hamiltonian=sphere_hamiltonian_difference(rng),
    )
