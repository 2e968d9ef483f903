"""A path through two-qubit gates: the Hamiltonian of a spline on U(4) is smooth, that of geodesics jumps.

By Schroedinger's equation `i U' = H U`, a curve of unitary matrices has the Hamiltonian `H = i U' U^H`. Its covariant
acceleration is `-i H' U` in the bi-invariant metric of U(4), which is the canonical metric of complex frames. So a
Riemannian spline makes the integral of `|H'|^2` stationary: the Hamiltonian changes as little as the gates allow.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from figures import command_line, new_figure, save
from hamiltonians import Array, Geodesics, Spline, nearest_phase
from stiefel_rs.palette import BLUE, GREEN, INK, PURPLE, VERMILION

GEODESICS, STOPPING = "geodesics", "geodesics with stops"
NATURAL, CLAMPED = "natural spline", "clamped spline"
COLOURS = {GEODESICS: VERMILION, STOPPING: PURPLE, NATURAL: GREEN, CLAMPED: BLUE}
R = np.sqrt(0.5)
GATES = {
    "I": np.eye(4),
    "CNOT": np.eye(4)[[0, 1, 3, 2]],
    "CZ": np.diag([1, 1, 1, -1]),
    "iSWAP": np.array([[1, 0, 0, 0], [0, 0, 1j, 0], [0, 1j, 0, 0], [0, 0, 0, 1]]),
    "SWAP": np.eye(4)[[0, 2, 1, 3]],
    "CH": np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, R, R], [0, 0, R, -R]]),
}
TIMES = np.arange(float(len(GATES)))
DENSE = 200
# Points of Gauss's rule between two gates.
GAUSS = 20


def gates() -> Array:
    """The gates, with the phases that are near to those of the gate before."""
    found = [np.eye(4, dtype=complex)]
    for each in list(GATES.values())[1:]:
        found.append(nearest_phase(found[-1], each))
    return np.stack(found)


def paths(points: Array) -> dict[str, Any]:
    """Hamiltonians of the curves through the gates; with stops, the share 3 s^2 - 2 s^3 of a geodesic is done at s."""
    return {
        GEODESICS: Geodesics(points, np.ones_like, np.zeros_like),
        STOPPING: Geodesics(points, lambda s: 6 * s * (1 - s), lambda s: 6 - 12 * s),
        NATURAL: Spline(points, "natural"),
        CLAMPED: Spline(points, "clamped"),
    }


def farthest(H: Any, points: Array) -> float:
    """Largest distance from the gates of the solution of Schroedinger's equation that starts at the first."""
    U, distances = points[0], []
    for (start, end), target in zip(pairwise(TIMES), points[1:], strict=True):

        def right(t: float, y: Array, last: float = np.nextafter(end, start)) -> Array:
            # At the gate itself the Hamiltonian is that of the next interval.
            return np.asarray(-1j * H(np.array([min(t, last)]))[0] @ y.reshape(4, 4)).ravel()

        U = solve_ivp(right, (start, end), U.ravel(), "DOP853", rtol=1e-12, atol=1e-13).y[:, -1].reshape(4, 4)
        distances.append(np.linalg.norm(U - target))
    return float(max(distances))


def dense() -> Array:
    """Times; those of gates twice, at the end of an interval and at the start of the next."""
    return np.concatenate([np.linspace(a, np.nextafter(b, a), DENSE) for a, b in pairwise(TIMES)])


def largest(matrices: Array, order: Any = "fro") -> float:
    """Largest norm of the matrices."""
    return float(np.linalg.norm(matrices, order, axis=(-2, -1)).max())


def measure(H: Any, points: Array) -> dict[str, float]:
    """Size, jumps, slew rate and cost of a Hamiltonian; how far Schroedinger's equation passes the gates."""
    t, inner = dense(), TIMES[1:-1]
    values, before = H(t), np.nextafter(inner, 0)
    x, w = np.polynomial.legendre.leggauss(GAUSS)
    nodes = TIMES[:-1, None] + (x + 1) / 2
    squares = np.sum(np.abs(H.rate(nodes.ravel())) ** 2, axis=(1, 2)).reshape(nodes.shape)
    return {
        "not_hermitian": largest(values - np.swapaxes(values.conj(), 1, 2)),
        "trace": float(np.abs(np.trace(values, axis1=1, axis2=2)).max()),
        "largest": largest(values, 2),
        "jump": largest(H(inner) - H(before)),
        "at_ends": largest(values[[0, -1]]),
        "slew": largest(H.rate(t)),
        "jump_of_slew": largest(H.rate(inner) - H.rate(before)),
        "cost": float(np.sum(squares @ w) / 2),
        "farthest": farthest(H, points),
    }


def main(out: Path, *, quick: bool = False) -> dict[str, Any]:
    """Lead a smooth path through two-qubit gates; compare its Hamiltonian with that of geodesics."""
    points = gates()
    curves = paths(points)
    if quick:
        del curves[STOPPING]
    numbers: dict[str, Any] = {name: measure(H, points) for name, H in curves.items()}
    for name in (NATURAL, CLAMPED):
        numbers[name] |= {"own_cost": curves[name].curve.cost(), "length": curves[name].curve.arc_length()}
    draw(out, curves)
    return numbers


def pauli_components(H: Array) -> Array:
    """Components of Hermitian matrices in the 15 products of two Pauli matrices that have trace 0, shape (m, 15)."""
    pauli = np.array([[[1, 0], [0, 1]], [[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])
    products = np.stack([np.kron(a, b) for a in pauli for b in pauli])[1:]
    return np.asarray(np.einsum("pij,mji->mp", products, H).real / 4)


def draw(out: Path, curves: dict[str, Any]) -> None:
    """Pauli components of the Hamiltonians, and their slew rates."""
    figure = new_figure(4.2)
    axes = figure.subplots(2, len(curves), sharex=True, sharey="row")
    t = dense()
    for column, (name, H) in zip(axes.T, curves.items(), strict=True):
        column[0].plot(t, pauli_components(H(t)), color=COLOURS[name], linewidth=0.9)
        column[1].plot(t, np.linalg.norm(H.rate(t), axis=(1, 2)), color=COLOURS[name])
        column[0].set_title(name)
        for ax in column:
            ax.set(xlim=(TIMES[0], TIMES[-1]), xticks=TIMES)
        column[1].set_xticklabels(list(GATES), rotation=90)
        if name == GEODESICS:
            for time in TIMES:
                column[1].annotate("", (time, 12), (time, 0), arrowprops={"arrowstyle": "->", "color": COLOURS[name]})
            column[1].text(0.1, 12.6, "H jumps at the gates", color=INK)
    axes[0, 0].set_ylabel("Pauli components of H")
    axes[1, 0].set_ylabel("slew rate |dH/dt|")
    save(figure, out)


if __name__ == "__main__":
    command_line(main, "quantum_gates")
