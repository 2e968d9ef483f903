"""Times at which a curve is evaluated, on the command line."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .errors import InvalidInputError

MAX_SAMPLES: Final = 10_000_000
# Rounding error at the end, as a fraction of a step, up to which the end is included.
_ROUNDING: Final = 1e-9


def at_rate(span: float, rate: float) -> NDArray[np.float64]:
    """Return 0, 1/rate, 2/rate, ... up to `span`.

    Raises
    ------
    InvalidInputError
        There would be too many times.
    """
    steps = span * rate + _ROUNDING
    if steps >= MAX_SAMPLES:
        raise InvalidInputError(f"--rate {rate:g}: {steps:.3g} times in {span:g} s, must be at most {MAX_SAMPLES}")
    return np.minimum(np.arange(math.floor(steps) + 1) / rate, span)
