"""`python -m benchmarks.logarithms`: logarithms of random pairs beside the shortest geodesic of 50 random starts.

Most pairs of random points are farther apart than the injectivity radius. The other method is the algebraic one, from
random completions: the logarithm of an orthogonal matrix whose first columns are given is made horizontal by rotating
the others. The shapes have fewer columns than rows.

Source: Zimmermann (2017), "A matrix-algebraic algorithm for the Riemannian logarithm on the Stiefel manifold under the
canonical metric", SIAM J. Matrix Anal. Appl. 38, 322-342, algorithm 3.1.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from benchmarks.problems import Array
from stiefel_rs import ConvergenceError, OutsideDomainError, Stiefel, orthogonal_log, skew_exp

SHAPES = ((4, 2), (5, 3), (6, 3), (20, 15))
STARTS = 50
STEPS = 300
# Largest entry of the vertical part that counts as horizontal.
HORIZONTAL = 1e-10
# Relative excess of a length that counts as longer.
LONGER = 1e-7


def rotations(rng: np.random.Generator, count: int, m: int) -> Array:
    """Random rotations of shape `(count, m, m)`."""
    q, r = np.linalg.qr(rng.standard_normal((count, m, m)))
    q *= np.sign(np.diagonal(r, axis1=1, axis2=2))[:, None, :]
    q[:, :, 0] *= np.sign(np.linalg.det(q))[:, None]
    return np.asarray(q)


def shortest(rng: np.random.Generator, S0: Array, S1: Array) -> float:
    """Length of the shortest geodesic that the random starts find; infinite if they find none."""
    n, k = S0.shape
    normal = np.linalg.qr(np.hstack([S0, np.eye(n)]))[0][:, k:]
    first = np.vstack([S0.T @ S1, normal.T @ S1])
    rest = np.linalg.qr(np.hstack([first, np.eye(n)]))[0][:, k:n]
    if np.linalg.det(np.hstack([first, rest])) < 0:
        rest[:, 0] *= -1
    V = np.concatenate([np.broadcast_to(first, (STARTS, n, k)), rest @ rotations(rng, STARTS, n - k)], axis=2)
    best = np.inf
    for _ in range(STEPS):
        if len(V) == 0:
            break
        # A start that comes to a half turn is given up.
        V = V[np.abs(np.linalg.eigvals(V) + 1).min(axis=1) > LONGER]
        L = orthogonal_log(V)
        C = L[:, k:, k:]
        done = np.abs(C).max(axis=(1, 2)) < HORIZONTAL
        squares = 0.5 * (L[:, :k, :k] ** 2).sum(axis=(1, 2)) + (L[:, k:, :k] ** 2).sum(axis=(1, 2))
        best = min(best, np.sqrt(squares[done].min(initial=np.inf)))
        V, C = V[~done].copy(), C[~done]
        if len(V):
            V[:, :, k:] = V[:, :, k:] @ skew_exp(-C)
    return float(best)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.logarithms", description=__doc__)
    parser.add_argument("--pairs", type=int, default=2000, help="pairs of each shape")
    parser.add_argument("--shapes", nargs="*", default=[f"{n},{k}" for n, k in SHAPES])
    options = parser.parse_args()
    shapes = [[int(x) for x in shape.split(",")] for shape in options.shapes]
    if any(k >= n for n, k in shapes):
        parser.error("--shapes: n,k with k < n")
    for n, k in shapes:
        rng = np.random.default_rng([21, n, k])
        points = np.linalg.qr(rng.standard_normal((2 * options.pairs, n, k)))[0]
        manifold = Stiefel(n, k)
        errors = longer = shorter = compared = 0
        slowest = worst = 0.0
        for S0, S1 in zip(points[::2], points[1::2], strict=True):
            started = time.perf_counter()
            try:
                found = float(manifold.norm(S0, manifold.log(S0, S1)))
            except (ConvergenceError, OutsideDomainError):
                found = math.nan
            slowest = max(slowest, time.perf_counter() - started)
            errors += math.isnan(found)
            other = shortest(rng, S0, S1)
            if math.isnan(found) or math.isinf(other):
                continue
            compared += 1
            longer += found > other * (1 + LONGER)
            shorter += other > found * (1 + LONGER)
            worst = max(worst, found / other)
        print(
            f"St({n},{k}): {options.pairs} pairs, {errors} errors, slowest {1e3 * slowest:.1f} ms; of {compared} "
            f"compared {longer} longer (at most {worst:.4f} times) and {shorter} shorter than by {STARTS} starts"
        )


if __name__ == "__main__":
    main()
