"""Curves that were solved for lately, so that a derivative does not solve again what the value has."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from .arguments import Array

Curve = TypeVar("Curve")

# A batch of this size is differentiated without solving twice; a spline of 200 rotations holds some 0.5 MB.
KEPT = 64


class Solved(Generic[Curve]):
    """What a solver makes of its arguments, the last ones kept."""

    def __init__(self, solve: Callable[..., Curve]) -> None:
        self._solve = solve
        self._kept: OrderedDict[tuple[bytes, ...], Curve] = OrderedDict()
        self._lock = threading.Lock()

    def __call__(self, data: Sequence[Array]) -> Curve:
        """Return the curve of the given arguments."""
        key = tuple(x.tobytes() + repr(x.shape).encode() for x in data)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        curve = self._solve(*data)
        with self._lock:
            self._kept[key] = curve
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        return curve
