"""Cache of recently solved curves and projected arguments, so that derivatives reuse those of the value."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from .arguments import Array, Shape

Solution = TypeVar("Solution")

# Largest count of numbers that the solutions of a solver may occupy, curves with their derivatives: 256 MB, 100 splines
# through 200 rotations. The last solution is always kept.
KEPT = 1 << 25


def core_shape(frame: Array) -> Shape:
    """Return the shape in the core, where complex frames are embedded in real ones of twice the size."""
    n, k = frame.shape[-2:]
    return (2 * n, 2 * k) if frame.dtype.kind == "c" else (n, k)


def numbers_of_piece(n: int, k: int) -> int:
    """Estimate how many numbers the derivative of a piece of a spline stores."""
    rows = min(n, 4 * k)
    dimension = (rows - k) * k + k * (k - 1) // 2
    at_points = 80 * dimension**2 + 20 * rows**2 if dimension <= 64 else 0
    return at_points + 20 * dimension**2 + 8 * n * k + 500


def numbers_of_cubic(n: int, k: int) -> int:
    """Estimate how many numbers the derivative of a single cubic stores: five matrices of the span at each of 24 nodes.

    Fast curves, which are linearised in legs, may store ten times as many.
    """
    rows = min(n, 4 * k)
    return 100 * n * k + 150 * rows**2 + 2000


class Solved(Generic[Solution]):
    """A solver that caches its last solutions."""

    def __init__(self, solve: Callable[..., Solution], numbers: Callable[..., int]) -> None:
        self._solve, self._numbers = solve, numbers
        self._kept: OrderedDict[tuple[tuple[Shape, bytes], ...], tuple[Solution, int]] = OrderedDict()
        self._size = 0
        self._lock = threading.Lock()

    def __call__(self, data: Sequence[Array]) -> Solution:
        """Return the solution for the given arguments."""
        key = tuple((x.shape, x.tobytes()) for x in data)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key][0]
        solution = self._solve(*data)
        numbers = self._numbers(*data) + sum(len(entries) for _, entries in key) // 8
        with self._lock:
            if key not in self._kept:
                self._size += numbers
            self._kept[key] = solution, numbers
            while self._size > KEPT and len(self._kept) > 1:
                _, (_, freed) = self._kept.popitem(last=False)
                self._size -= freed
        return solution
