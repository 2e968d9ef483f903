"""Allowed outcomes of a call: a result without NaN for input without NaN, or an informative error."""

import math

import numpy as np

from stiefel_rs import StiefelError

ERRORS = (StiefelError, TypeError, ValueError, OverflowError, MemoryError)
DEPTH = 3


def finite_input(values):
    """Whether each of the arguments consists of finite numbers, or can be converted to them; words count as finite."""
    for value in values:
        if isinstance(value, (str, bytes, bool, int)) or value is None or callable(value):
            continue
        if isinstance(value, (tuple, list)) and any(isinstance(x, str) for x in value):
            continue
        try:
            if not np.isfinite(np.asarray(value, float)).all():
                return False
        except Exception:
            return False
    return True


def attributes(thing):
    """Public properties of an object of the package, by name."""
    names = [x for x in dir(type(thing)) if not x.startswith("_") and not callable(getattr(type(thing), x, None))]
    return {name: getattr(thing, name) for name in names}


def not_finite(result, path="result", depth=DEPTH):
    """The first attribute with a NaN or an infinity, or None."""
    if isinstance(result, np.ndarray):
        if result.dtype.kind == "f" and not np.isfinite(result).all():
            return f"{path} has {np.count_nonzero(~np.isfinite(result))} entries that are not finite"
        return None
    if isinstance(result, (float, np.floating)):
        return None if math.isfinite(result) else f"{path} = {result}"
    parts = {}
    if isinstance(result, (tuple, list)):
        parts = {f"[{i}]": x for i, x in enumerate(result)}
    elif depth and type(result).__module__.startswith("stiefel_rs"):
        parts = {f".{name}": x for name, x in attributes(result).items()}
    for name, part in parts.items():
        if found := not_finite(part, path + name, depth - 1):
            return found
    return None
