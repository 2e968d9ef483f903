"""Rows of the Riemannian cubics."""

from __future__ import annotations

from benchmarks.compare import cubic_problems
from benchmarks.compare.row import Bound, Rival, Row

MS, US = 1e-3, 1e-6
RESIDUAL = 1e-12


def cubics() -> list[Row]:
    """Initial value problems, points of their dense output, boundary value problems."""
    return [*_initial(), *_paper_boundary(), *_random_boundary()]


def _initial() -> list[Row]:
    dop853 = Rival("scipy", "dop853", "SciPy DOP853, embedded equation", agree=1e-11)
    solve = Row(
        "cubic_initial/sphere",
        "`RiemannianCubic.from_initial`, the paper's S^2 data, [0, 1]",
        (Rival("heyoka", "heyoka", "heyoka, embedded equation", agree=1e-11), dop853),
        seconds=7 * US,
        ahead=1,
        bounds=(Bound("cubic_initial/sphere:error", "error of position at t = 1", 1e-15),),
        exact=True,
    )
    points = Row(
        "cubic_points/sphere",
        "1000 points of `RiemannianCubic.from_initial`, the paper's S^2 data",
        (Rival("heyoka", "heyoka", "heyoka, continuous output", agree=1e-11),),
        unit="point",
    )
    return [solve, points]


def _paper_boundary() -> list[Row]:
    sphere = (
        Rival("heyoka", "heyoka", "heyoka, Newton on its variational equations", agree=1e-11),
        Rival("heyoka", "compact", "heyoka, the same in compact mode", agree=1e-11),
        Rival("scipy", "bvp", "SciPy solve_bvp, embedded equation", agree=1e-10),
        Rival("scipy", "shooting", "SciPy DOP853 and root, embedded equation", agree=1e-10),
    )
    frame = (Rival("scipy", "shooting", "SciPy DOP853 and root, equation on SO(3)", agree=1e-10),)
    return [
        Row(
            f"cubic_boundary/{name}",
            f"`RiemannianCubic.from_boundary`, the paper's {what} data",
            rivals,
            seconds=us * US,
            exact=True,
        )
        for name, what, us, rivals in (("sphere", "S^2", 100, sphere), ("frame", "St(3,2)", 250, frame))
    ]


def _random_boundary() -> list[Row]:
    reach = dict(zip(cubic_problems.RANDOM, (5, 40, None), strict=True))
    shooting = Rival("scipy", "shooting", "SciPy DOP853 and root, equation on SO(10)", agree=1e-9)
    parts = Rival("scipy", "qr_lift", "NumPy: only QR and lift of one point", agree=None, best_of=False)
    rivals = {(10, 3): (shooting,), (1000, 5): (parts,)}
    rows = [
        Row(
            f"cubic_boundary/{n},{k}",
            f"`RiemannianCubic.from_boundary`, St({n},{k})",
            rivals.get((n, k), ()),
            seconds=None if ms is None else ms * MS,
            bounds=(Bound(f"cubic_boundary/{n},{k}:residual", "defect at the end", RESIDUAL),),
        )
        for (n, k), ms in reach.items()
    ]
    work = "`RiemannianCubic.from_boundary`, the 20 dimensions of St(1000,5) without QR and lift"
    inner = Row("cubic_boundary/reduced", work, seconds=40 * MS)
    return [*rows, inner]
