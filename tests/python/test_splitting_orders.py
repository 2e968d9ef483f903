"""Orders of convergence of integrate_cubic on complex frames, real subspaces and complex subspaces."""

import numpy as np
import pytest

from stiefel_rs import Grassmann, RiemannianCubic, Stiefel, integrate_cubic

MANIFOLDS = [
    Stiefel(3, 1, field="complex"),
    Stiefel(3, 2, field="complex"),
    Stiefel(3, 3, field="complex"),
    Stiefel(9, 2, field="complex"),
    Grassmann(4, 2),
    Grassmann(2, 1, field="complex"),
    Grassmann(5, 2, field="complex"),
]
# Steps of all runs: nearly of the asymptotic order, with errors above 3e-15.
STEPS = {2: (128, 256, 512), 4: (64, 128, 256), 6: (28, 56), 8: (20, 30)}
# Measured orders: 2.00, 4.00 to 4.06, 5.92 to 6.25, and 8.1 to 9.4, since the leading error of order 8 only dominates
# near round-off.
RANGES = {2: (1.99, 2.01), 4: (3.9, 4.1), 6: (5.7, 6.4), 8: (7.5, 10.0)}


@pytest.fixture(params=MANIFOLDS, ids=repr)
def problem(request):
    """A manifold, unit initial data, and the cubic by Taylor expansion."""
    M, rng = request.param, np.random.default_rng(3)
    Y = M.random_point(rng)
    vectors = (M.random_tangent(Y, rng) for _ in range(3))
    data = Y, *(V / M.norm(Y, V) for V in vectors)
    # Subspaces are curved more.
    t_end = 4.0 if isinstance(M, Stiefel) else 3.0
    return M, data, RiemannianCubic.from_initial(*data, t_end, manifold=M)


def errors(problem, order, steps):
    """Largest errors of points, velocities and accelerations."""
    M, data, exact = problem
    found = integrate_cubic(*data, steps, exact.t_span[1], order, manifold=M)
    pairs = [
        (found.point, exact(found.t)),
        (found.velocity, exact.velocity(found.t)),
        (found.acceleration, exact.acceleration(found.t)),
    ]
    return [abs(values - reference).max() for values, reference in pairs]


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_errors_are_powers_of_the_step(order, problem):
    steps = np.array(STEPS[order])
    found = np.array([errors(problem, order, count) for count in steps])
    slopes = -np.diff(np.log(found), axis=0) / np.diff(np.log(steps))[:, None]
    least, most = RANGES[order]
    assert least < slopes.min(), f"orders {slopes}, errors {found}"
    assert slopes.max() < most, f"orders {slopes}, errors {found}"


def test_points_stay_on_the_manifold(problem):
    """And velocities tangent, for all orders: by construction, to round-off."""
    M, data, _ = problem
    for order in STEPS:
        found = integrate_cubic(*data, 20, 2.0, order, manifold=M)
        M.check_point(found.point, atol=1e-14)
        M.check_tangent(found.point, found.velocity, atol=1e-14)
        # Measured at most 7e-16.
        assert found.momentum_drift < 1e-14
