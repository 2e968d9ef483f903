"""Curves that were solved for lately, so that a derivative does not solve again what the value has."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from .arguments import Array

Curve = TypeVar("Curve")

# Bytes of the arguments of all that one solver keeps. Splines through 2000 rotations have 80 kB of them and take 36 MB,
# with their derivatives: six are kept, or 64 through 200. The last one is kept whatever it takes.
KEPT = 1 << 19


class Solved(Generic[Curve]):
    """What a solver makes of its arguments, the last ones kept."""

    def __init__(self, solve: Callable[..., Curve]) -> None:
        self._solve = solve
        self._kept: OrderedDict[tuple[bytes, ...], Curve] = OrderedDict()
        self._size = 0
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
            if key not in self._kept:
                self._size += _size(key)
            self._kept[key] = curve
            while self._size > KEPT and len(self._kept) > 1:
                oldest, _ = self._kept.popitem(last=False)
                self._size -= _size(oldest)
        return curve


def _size(key: tuple[bytes, ...]) -> int:
    return sum(map(len, key))
