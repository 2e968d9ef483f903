"""Rows of gradients: compared with the value alone, and with JAX through an unrolled solver."""

from __future__ import annotations

from benchmarks.compare import gradient_problems
from benchmarks.compare.row import Rival, Row

# Runge-Kutta steps of the unrolled solver have errors of 1e-7 for boundary problems, and of 1e-3 for splines.
UNROLLED = "JAX through an unrolled solver"


def gradients() -> list[Row]:
    """Rows for a spline and for boundary problems."""
    count = gradient_problems.KEYFRAMES
    work = f"value and gradient of a function of a spline of {count} rotations, by `stiefel_rs.jax`"
    rows = [_row("spline", work, at_most=2.0, unrolled=Rival("jax", "unrolled", UNROLLED, agree=1e-2))]
    for n, k in gradient_problems.SHAPES:
        work = f"value and gradient of a boundary problem on St({n},{k}), by its first velocity"
        rival = Rival("jax", "unrolled", UNROLLED, agree=1e-5) if (n, k) in gradient_problems.UNROLLED else None
        rows.append(_row(f"{n},{k}", work, at_most=1.5, unrolled=rival))
    return rows


def _row(name: str, work: str, *, at_most: float, unrolled: Rival | None) -> Row:
    value = Rival("stiefel_rs", "value", "the value alone", at_most=at_most, agree=None, best_of=False)
    rivals = (value,) if unrolled is None else (value, unrolled)
    return Row(f"gradient/{name}", work, rivals, ahead=None if unrolled is None else 1)
