"""Batches of boundary problems: shapes, unsolved problems, threads, bad input."""

import pickle

import numpy as np
import pytest

from stiefel_rs import (
    BoundaryBatch,
    InvalidInputError,
    OutsideDomainError,
    RiemannianCubic,
    Stiefel,
    solve_boundary,
)

M = Stiefel(4, 2)


def problems(shape, seed=3, most=1.5):
    rng = np.random.default_rng(seed)

    def tangent(S, length):
        V = M.random_tangent(S, rng)
        return M.project_tangent(S, V * length / M.norm(S, V))

    count = int(np.prod(shape))
    S0 = np.stack([M.random_point(rng) for _ in range(count)])
    S1 = np.stack([M.retract(S, tangent(S, rng.uniform(0, most))) for S in S0])
    V0 = np.stack([tangent(S, rng.uniform(0, most)) for S in S0])
    V1 = np.stack([tangent(S, rng.uniform(0, most)) for S in S1])
    return [x.reshape(*shape, 4, 2) for x in (S0, V0, S1, V1)]


def test_members_are_single_solutions():
    ends = problems((3, 5))
    batch = solve_boundary(*ends)
    assert isinstance(batch, BoundaryBatch)
    assert batch.acceleration.shape == batch.jerk.shape == (3, 5, 4, 2)
    assert batch.cost.shape == batch.converged.shape == batch.residual.shape == (3, 5)
    assert batch.converged.dtype == bool and batch.converged.all()
    assert batch.residual.max() <= 1e-12
    for i in np.ndindex(3, 5):
        curve = RiemannianCubic.from_boundary(*(x[i] for x in ends))
        # Residuals of 1e-12, carried to the start.
        assert np.allclose(batch.acceleration[i], curve.acceleration(0.0), rtol=1e-10, atol=1e-10)
        assert np.allclose(batch.jerk[i], curve.jerk(0.0), rtol=1e-10, atol=1e-10)
        assert np.isclose(batch.cost[i], curve.cost(), rtol=1e-10)


def test_one_problem_and_none():
    ends = problems((1,))
    single = solve_boundary(*(x[0] for x in ends))
    assert single.jerk.shape == (4, 2) and single.cost.shape == () and bool(single.converged)
    assert np.array_equal(single.jerk, solve_boundary(*ends).jerk[0])
    empty = solve_boundary(*(x[:0] for x in ends))
    assert empty.jerk.shape == (0, 4, 2) and empty.converged.shape == (0,)


def test_leading_axes_broadcast():
    S0, V0, S1, V1 = problems((2, 3))
    batch = solve_boundary(S0[:, :1], V0[:, :1], S1, V1)
    assert batch.cost.shape == (2, 3)
    one = solve_boundary(S0[1, 0], V0[1, 0], S1[1, 2], V1[1, 2])
    assert np.allclose(batch.jerk[1, 2], one.jerk, rtol=1e-12, atol=1e-12)


def test_what_is_not_solved_is_marked():
    S0, V0, S1, V1 = problems((4,))
    # Too fast for a curve to be integrated.
    V0[2] = M.project_tangent(S0[2], 1e9 * V0[2])
    batch = solve_boundary(S0, V0, S1, V1)
    assert batch.converged.tolist() == [True, True, False, True]
    assert np.isnan(batch.jerk[2]).all() and np.isnan(batch.acceleration[2]).all() and np.isnan(batch.cost[2])
    assert batch.residual[2] > 1e-12
    assert np.isfinite(batch.jerk[[0, 1, 3]]).all()


@pytest.mark.parametrize("name", ["S0", "V0", "S1", "V1"])
def test_bad_members_are_named(name):
    ends = dict(zip(["S0", "V0", "S1", "V1"], problems((3,)), strict=True))
    ends[name] = ends[name] + 0.1 * np.arange(3)[:, None, None]
    with pytest.raises(InvalidInputError, match=rf"{name}.*\(batch member 1\)"):
        solve_boundary(**ends)


def test_bad_arguments():
    ends = problems((2,))
    with pytest.raises(InvalidInputError, match="tol: must be between"):
        solve_boundary(*ends, tol=1.0)
    with pytest.raises(InvalidInputError, match="max_iterations: must be at least 1"):
        solve_boundary(*ends, max_iterations=0)
    with pytest.raises(TypeError):
        solve_boundary(*ends[:3], ends[3].astype(str))
    with pytest.raises(OutsideDomainError):
        rest = np.zeros((1, 2, 2))
        solve_boundary(np.eye(2)[None], rest, np.diag([1.0, -1.0])[None], rest)


def test_threads_do_not_matter():
    ends = problems((200,), most=2.5)
    batch = solve_boundary(*ends, num_threads=1)
    again = solve_boundary(*ends, num_threads=3)
    for a, b in zip(batch, again, strict=True):
        assert np.array_equal(a, b)
    assert np.array_equal(pickle.loads(pickle.dumps(batch)).jerk, batch.jerk)


@pytest.mark.parametrize("tol", [1e-12, 1e-13])
def test_ends_are_met_by_curves_from_the_start(tol):
    S0, V0, S1, V1 = problems((40,), seed=5, most=2.0)
    batch = solve_boundary(S0, V0, S1, V1, tol=tol)
    assert batch.converged.all()
    for i in range(40):
        curve = RiemannianCubic.from_initial(S0[i], V0[i], batch.acceleration[i], batch.jerk[i])
        miss = np.hypot(np.linalg.norm(curve(1.0) - S1[i]), np.linalg.norm(curve.velocity(1.0) - V1[i]))
        # Round-off of speeds up to 10.
        assert miss <= 2 * tol + 1e-13, f"the end is off by {miss:.2e}"


def test_the_order_of_problems_does_not_matter_beyond_the_tolerance():
    ends = problems((50,), most=2.0)
    batch, other = solve_boundary(*ends), solve_boundary(*(x[::-1] for x in ends))
    # Residuals of 1e-12, carried to the start.
    assert np.allclose(batch.jerk, other.jerk[::-1], rtol=1e-10, atol=1e-10)
