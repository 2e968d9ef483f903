"""Rows of derivatives, lengths and costs of curves, which no other library computes."""

from __future__ import annotations

from benchmarks.compare.row import Rival, Row

GEOMETRIC = ((3, 1), (3, 2), (50, 5))
RIEMANNIAN = ((3, 1), (3, 2), (10, 3))
# Ratio to the positions that counts as fast.
QUANTITIES = {"velocity": 3.0, "second derivative": 5.0, "acceleration": 6.0}
COVARIANT = {"acceleration": 4.0, "jerk": 4.0}
# Seconds of a geometric cubic on St(3,2).
INTEGRALS = {"arc_length": 0.5e-3, "cost": 0.2e-3, "resample": 0.5e-3, "derivative_bounds": 0.5e-3}
# Control points of minimal cost: degree and shapes.
MINIMAL = 5
FREE = ((3, 1), (3, 2), (5, 3))


def derivatives() -> list[Row]:
    """Derivatives at 1000 points beside the positions there, and integrals."""
    rows = [
        _row("GeometricCubic", shape, quantity, at_most)
        for shape in GEOMETRIC
        for quantity, at_most in QUANTITIES.items()
    ]
    rows += [
        _row("RiemannianCubic", shape, quantity, at_most)
        for shape in RIEMANNIAN
        for quantity, at_most in COVARIANT.items()
    ]
    integrals = [
        Row(f"derivatives/{name}", f"`{name}` of `GeometricCubic`, St(3,2)", seconds=seconds)
        for name, seconds in INTEGRALS.items()
    ]
    return rows + integrals + [_minimal(shape) for shape in FREE]


def _minimal(shape: tuple[int, int]) -> Row:
    n, k = shape
    cubic = Rival("stiefel_rs", "cubic", "the exact cubic", at_most=1.0, agree=None, best_of=False)
    work = f"`GeometricPolynomial.minimal_cost`, degree {MINIMAL}, St({n},{k})"
    return Row(f"derivatives/minimal_cost/{n},{k}", work, (cubic,))


def _row(curve: str, shape: tuple[int, int], quantity: str, at_most: float) -> Row:
    n, k = shape
    positions = Rival("stiefel_rs", "positions", "positions there", at_most=at_most, agree=None, best_of=False)
    return Row(
        f"derivatives/{curve}/{n},{k}/{quantity}",
        f"{quantity} of `{curve}` at 1000 points, St({n},{k})",
        (positions,),
        unit="point",
    )
