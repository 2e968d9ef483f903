"""Riemannian cubics from initial data: documented behaviour, reference data, SciPy, threads, Ctrl-C, bad input."""

import _thread
import copy
import itertools
import json
import pickle
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from beside import handled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from stiefel_rs import (
    ConvergenceError,
    Curve,
    Geodesic,
    InvalidInputError,
    RiemannianCubic,
    Stiefel,
    StiefelError,
)

EPS = np.finfo(float).eps
DATA = json.loads((Path(__file__).parents[1] / "data" / "cubics.json").read_text())
STATE = ["point", "velocity", "acceleration", "jerk"]


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


def numbers(entry):
    return [np.array([[float(x) for x in row] for row in entry[name]]) for name in STATE]


def random_state(n, k, seed, norms=(1.0, 1.0, 1.0)):
    rng = np.random.default_rng(seed)
    M = Stiefel(n, k)
    S = M.random_point(rng)
    vectors = [M.random_tangent(S, rng) for _ in norms]
    # The only tangent vector of St(1, 1) is zero.
    return S, *[V * (norm / (M.norm(S, V) or 1.0)) for V, norm in zip(vectors, norms, strict=True)]


def state_at(curve, t):
    return curve(t), curve.velocity(t), curve.acceleration(t), curve.jerk(t)


@pytest.fixture
def state(manifold):
    return random_state(manifold.n, manifold.k, 7)


@pytest.fixture
def curve(state):
    return RiemannianCubic.from_initial(*state)


def test_forty_digit_data():
    for entry in DATA:
        curve = RiemannianCubic.from_initial(*numbers(entry["initial"]))
        name = f"St({entry['n']}, {entry['k']})"
        for t, expected in entry["at"].items():
            for found, exact in zip(state_at(curve, float(t)), numbers(expected), strict=True):
                assert_close(found, exact, 1e-13 * max(1.0, np.abs(exact).max()), f"{name} at {t}")


def m_part(X, k):
    out = X.copy()
    out[k:, k:] = 0
    return out


def by_scipy(S, V, A, J, t):
    """The moving frame ``g' = g x`` with the equation for ``x``, in n x n matrices."""
    n, k = S.shape
    g = np.linalg.qr(np.hstack([S, np.random.default_rng(0).standard_normal((n, n - k))]))[0]
    g[:, :k] = S

    def bracket(a, b):
        return a @ b - b @ a

    def lift(W):
        x = np.zeros((n, n))
        x[:, :k] = g.T @ W
        x[:k, k:] = -x[k:, :k].T
        return x

    v, a, j = lift(V), lift(A), lift(J)
    start = np.stack([g, v, a, j - m_part(bracket(v, a), k) / 2])

    def rate(_, y):
        g, x, x1, x2 = y.reshape(4, n, n)
        turn = bracket(x, x1)
        third = m_part(bracket(x2, x), k) - bracket(turn - m_part(turn, k), x)
        return np.stack([g @ x, x1, x2, third]).ravel()

    y = solve_ivp(rate, (0, t), start.ravel(), "DOP853", rtol=3e-14, atol=1e-14).y[:, -1]
    g, x, x1, x2 = y.reshape(4, n, n)
    j = x2 + m_part(bracket(x, x1), k) / 2
    return [g[:, :k], *[(g @ w)[:, :k] for w in (x, x1, j)]]


@pytest.mark.parametrize(("n", "k"), [(3, 1), (3, 2), (5, 2)])
@pytest.mark.parametrize("t", [1.0, -2.0])
def test_against_scipy(n, k, t):
    state = random_state(n, k, 11, (1.0, 2.0, 3.0))
    curve = RiemannianCubic.from_initial(*state, t_end=t)
    for name, found, exact in zip(STATE, state_at(curve, t), by_scipy(*state, t), strict=True):
        # DOP853 at its smallest tolerance.
        assert_close(found, exact, 2e-11 * max(1.0, np.abs(exact).max()), f"{name} on St({n}, {k})")


def test_initial_data_come_back(curve, state):
    assert len(curve.initial) == 4
    for name, found, given_value in zip(STATE, curve.initial, state, strict=True):
        assert_close(found, given_value, 20 * curve.n * EPS, name)
    for found, evaluated in zip(curve.initial, state_at(curve, 0.0), strict=True):
        assert_close(found, evaluated, 50 * curve.n * EPS, "evaluated")


def test_contract(curve, manifold):
    assert isinstance(curve, Curve)
    assert (curve.n, curve.k, curve.t_span) == (manifold.n, manifold.k, (0.0, 1.0))
    assert curve.report is None
    assert isinstance(curve.steps, int)
    assert 1 <= curve.steps < 20
    assert repr(curve) == f"<RiemannianCubic on St({curve.n}, {curve.k}), t_span (0.0, 1.0), {curve.steps} steps>"
    core = (curve.n, curve.k)
    for f in [curve, curve.velocity, curve.acceleration, curve.jerk]:
        single = f(0.25)
        assert single.shape == core
        assert single.dtype == np.float64
        values = f(np.linspace(0, 1, 6).reshape(2, 3))
        assert values.shape == (2, 3, *core)
        assert f([]).shape == (0, *core)
        assert_close(f(np.float32(0.25)), single, 0.0, "float32 scalar")
        assert_close(values[1, 2], f(1.0), 100 * curve.n * EPS * (1 + np.abs(values).max()), "one of many")


def test_ambient_derivatives_are_derivatives(curve):
    h = 2e-3
    for nu in [1, 2, 3]:
        d = [(curve(0.5 + s, nu - 1) - curve(0.5 - s, nu - 1)) / (2 * s) for s in (h, 2 * h, 3 * h)]
        size = 1 + np.abs(curve(0.5, nu - 1)).max()
        # Round-off 4 eps/h, truncation h^6.
        assert_close(1.5 * d[0] - 0.6 * d[1] + 0.1 * d[2], curve(0.5, nu), 5e-12 * size, f"derivative {nu}")


def test_energy_and_momentum(curve, manifold):
    assert isinstance(curve.energy, float)
    assert curve.momentum.shape == (curve.n, curve.n)
    assert_close(curve.momentum, -curve.momentum.T, 20 * curve.n * EPS, "skew")
    for t in [0.0, 0.5, 1.0]:
        S, V, A, J = state_at(curve, t)
        energy = manifold.norm(S, A) ** 2 / 2 - manifold.inner(S, J, V)
        assert_close(energy, curve.energy, 200 * curve.n * EPS, f"energy at {t}")
        later = RiemannianCubic.from_initial(S, V, A, J)
        assert_close(later.momentum, curve.momentum, 200 * curve.n * EPS, f"momentum from {t}")


def test_cost_is_the_integral(curve, manifold):
    x, w = np.polynomial.legendre.leggauss(40)
    for part in [curve, curve.restricted(0.2, 2.0)]:
        a, b = part.t_span
        t = a + (b - a) * (x + 1) / 2
        exact = np.sum((b - a) * w / 2 * manifold.norm(part(t), part.acceleration(t)) ** 2)
        assert_close(part.cost(), exact, 1e-12 * exact, "cost")


def test_parts_reversals_other_parameters(curve):
    t = np.linspace(0.0, 1.0, 5)
    bound = 100 * curve.n * EPS
    part, more = curve.restricted(0.25, 0.75), curve.restricted(-1, 2)
    assert (part.t_span, more.t_span) == ((0.25, 0.75), (-1.0, 2.0))
    assert_close(part(t), curve(t), bound, "part")
    assert_close(more(3 * t - 1), curve(3 * t - 1), bound, "more")
    back = curve.reversed()
    assert back.t_span == curve.t_span
    assert_close(back(1 - t), curve(t), bound, "reversed")
    assert_close(back.jerk(1 - t), -curve.jerk(t), 10 * bound, "jerk reversed")
    other = curve.reparametrised(3.0, 5.0)
    assert other.t_span == (3.0, 5.0)
    assert_close(other(3 + 2 * t), curve(t), bound, "other parameter")
    assert_close(8 * other.jerk(3 + 2 * t), curve.jerk(t), 10 * bound, "jerk at the other parameter")
    assert_close(8 * other.cost(), curve.cost(), 1e-13 * curve.cost(), "cost at the other parameter")


def test_outside_of_the_interval(curve, state):
    far = RiemannianCubic.from_initial(*state, t_end=3.0)
    before = RiemannianCubic.from_initial(*state, t_end=-2.0)
    assert before.t_span == (-2.0, 0.0)
    bound = 200 * curve.n * EPS
    assert_close(curve([1.5, 3.0]), far([1.5, 3.0]), bound, "after")
    assert_close(curve([-2.0, 0.5]), [before(-2.0), far(0.5)], bound, "before")
    # For any number of threads, a call extends the curve once.
    t = np.linspace(-2, 3, 1000)
    assert np.array_equal(curve(t, num_threads=1), curve(t))
    assert np.array_equal(curve.jerk(t, num_threads=2), curve.jerk(t))


def test_special_cases(manifold):
    S, V, *_ = random_state(manifold.n, manifold.k, 3, (2.0, 1.0, 1.0))
    zero = np.zeros_like(S)
    t = np.linspace(-1, 2, 7)
    still = RiemannianCubic.from_initial(S, zero, zero, zero, 1e6)
    assert_close(still(t), S, 4 * EPS, "no velocity")
    assert still.cost() == 0.0
    straight = RiemannianCubic.from_initial(S, V, zero, zero)
    assert_close(straight(t), Geodesic.from_velocity(S, V)(t), 100 * manifold.n * EPS, "geodesic")


def test_tolerance():
    state = random_state(5, 2, 2)
    exact = RiemannianCubic.from_initial(*state)
    steps, errors = [], []
    for tol in [1e-3, 1e-6, 1e-9, 1e-12]:
        curve = RiemannianCubic.from_initial(*state, tol=tol)
        errors.append(np.abs(curve(1.0) - exact(1.0)).max())
        assert errors[-1] < 20 * tol, f"tolerance {tol}: error {errors[-1]:.2e}"
        steps.append(curve.steps)
    assert errors == sorted(errors, reverse=True)


def layouts(x):
    yield np.asfortranarray(x)
    wide = np.full((2 * x.shape[0], 3 * x.shape[1]), np.nan)
    wide[::2, ::3] = x
    yield wide[::2, ::3]
    yield x[::-1, ::-1].copy()[::-1, ::-1]
    frozen = x.copy()
    frozen.flags.writeable = False
    yield frozen
    yield x.astype(">f8")
    yield x.tolist()
    shifted = np.zeros(x.nbytes + 1, np.uint8)[1:].view(np.float64).reshape(x.shape)
    shifted[:] = x
    yield shifted


def test_layouts_and_types():
    S = np.eye(4, 2)
    V = np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
    expected = RiemannianCubic.from_initial(S, V, V, V)(0.5)
    for versions in zip(layouts(S), layouts(V), layouts(V), layouts(V), strict=True):
        assert np.array_equal(RiemannianCubic.from_initial(*versions)(0.5), expected)
    for kind in ["i1", "i8", "f4", "f2", "g"]:
        values = [x.astype(kind) for x in (S, V, V, V)]
        assert np.array_equal(RiemannianCubic.from_initial(*values)(0.5), expected), kind
    t = np.linspace(0, 1, 8)
    curve = RiemannianCubic.from_initial(S, V, V, V)
    for version in [t[::-1][::-1], t.astype(">f8"), t.tolist(), np.repeat(t, 2)[::2]]:
        assert np.array_equal(curve(version), curve(t))


def test_input_is_copied():
    state = [x.copy() for x in random_state(4, 2, 5)]
    curve = RiemannianCubic.from_initial(*state)
    expected = curve(0.5)
    for x in state:
        x[:] = np.nan
    assert np.array_equal(curve(0.5), expected)
    curve.initial[0][:] = np.nan
    assert np.all(np.isfinite(curve.initial[0]))


def test_it_cannot_be_constructed_directly():
    for arguments, keywords in [((), {}), (random_state(3, 1, 1), {}), ((1,), {"tol": 2})]:
        with pytest.raises(TypeError, match=r"from_initial.*from_boundary"):
            RiemannianCubic(*arguments, **keywords)


def test_copies_and_pickles(state):
    curve = RiemannianCubic.from_initial(*state, t_end=2.0, tol=1e-15)
    assert copy.copy(curve) is curve
    assert copy.deepcopy([curve])[0] is curve
    t = np.linspace(-0.5, 2.5, 7)
    bound = 500 * curve.n * EPS
    curves = [curve, curve.restricted(0.5, 1.0), curve.reversed(), curve.reparametrised(-5, -4)]
    for original, protocol in itertools.product(curves, range(2, pickle.HIGHEST_PROTOCOL + 1)):
        again = pickle.loads(pickle.dumps(original, protocol))
        assert isinstance(again, RiemannianCubic)
        assert again.t_span == original.t_span
        assert again.report is None
        a, b = original.t_span
        moments = a + (b - a) * t / 2
        size = 1 + np.abs(original(moments)).max()
        assert_close(again(moments), original(moments), bound * size, "pickled")
        assert_close(again.cost(), original.cost(), 1e-12 * original.cost(), "cost of the pickled")


@pytest.mark.parametrize("t_end", [0.0, -0.0, np.nan, np.inf, -np.inf])
def test_bad_times(t_end):
    with pytest.raises(InvalidInputError, match="t_end"):
        RiemannianCubic.from_initial(*random_state(3, 1, 1), t_end=t_end)


def test_messages_are_short():
    curve = RiemannianCubic.from_initial(*random_state(3, 1, 1))
    for call in (
        lambda: curve.reparametrised(0, 1e-320),
        lambda: RiemannianCubic.from_initial(*random_state(3, 1, 1), tol=1e300),
    ):
        with pytest.raises(InvalidInputError, match=r"found \d\.?\d*e-?3\d\d$"):
            call()
    with pytest.raises(InvalidInputError, match=r"^S: expected shape \(n, k\), found \(3,\)$"):
        RiemannianCubic.from_initial(np.eye(3)[0], *random_state(3, 1, 1)[1:])


@pytest.mark.parametrize("tol", [0.0, -1.0, 1e-18, 0.2, np.nan, np.inf])
def test_bad_tolerances(tol):
    with pytest.raises(InvalidInputError, match=r"^tol: must be between 1e-17 and 0\.1"):
        RiemannianCubic.from_initial(*random_state(3, 1, 1), tol=tol)


# Steps.
AT_ONCE, LIMIT = 100, 100_000


@pytest.mark.parametrize("t_end", [1e6, -1e6, 1e300])
@pytest.mark.parametrize(("n", "k"), [(3, 1), (3, 2), (20, 4)])
def test_too_far_is_refused_at_once(n, k, t_end):
    state = random_state(n, k, 1)
    with pytest.raises(ConvergenceError) as caught:
        RiemannianCubic.from_initial(*state, t_end=t_end)
    assert not caught.value.report.converged
    assert 0 < caught.value.report.residual <= abs(t_end)
    assert caught.value.report.reason == "max_iterations"
    # By a forecast of the steps, long before the limit of 100000.
    assert caught.value.report.iterations <= AT_ONCE
    curve = RiemannianCubic.from_initial(*state)
    for call in [lambda: curve(t_end), lambda: curve.jerk([0.0, t_end]), lambda: curve.restricted(-2e6, 2e6)]:
        with pytest.raises(ConvergenceError) as caught:
            call()
        assert caught.value.report.iterations <= AT_ONCE


@pytest.mark.parametrize("method", ["restricted", "reparametrised"])
def test_bad_intervals(method):
    make = getattr(RiemannianCubic.from_initial(*random_state(3, 1, 1)), method)
    for start, end in [(1, 1), (1, 0), (np.nan, 1), (0, np.nan), (0, np.inf), (-1e308, 1e308)]:
        with pytest.raises(InvalidInputError):
            make(start, end)
    with pytest.raises(TypeError):
        make("0", 1)


@pytest.mark.parametrize("i", range(4))
def test_bad_matrices(i):
    state = list(random_state(5, 2, 1))
    name = "SVAJ"[i]

    def replaced(value):
        values = state.copy()
        values[i] = value
        return RiemannianCubic.from_initial(*values)

    for bad in [np.nan, np.inf]:
        value = state[i].copy()
        value[-1, -1] = bad
        with pytest.raises(InvalidInputError, match=f"{name}: .*not finite"):
            replaced(value)
    for value in [state[i][:-1], state[i][:, :1], state[i][None], state[i][0], np.zeros((0, 0)), np.zeros((5, 0)), 1.0]:
        with pytest.raises(InvalidInputError):
            replaced(value)
    for value in [state[i].astype(object), state[i].astype(str), None, "text", object()]:
        with pytest.raises(TypeError):
            replaced(value)
    with pytest.raises(InvalidInputError, match=rf"{name}: .* exceeds"):
        replaced(state[i] + 1e-3 * state[0])


SCALES = st.sampled_from([0.0, 1e-320, 1e-300, 1e-160, 1e-8, 1.0, 1e3, 1e150, 1e300])
TIMES = st.sampled_from([0.0, 1e-320, 1e-300, 1e-8, -1.0, 1.0, -3.0, 3.0, 1e150, 1e300])
SIZES = st.integers(1, 6).flatmap(lambda n: st.tuples(st.just(n), st.integers(1, n)))


@settings(max_examples=150, deadline=None)
@given(size=SIZES, seed=st.integers(0, 2**32 - 1), scales=st.tuples(SCALES, SCALES, SCALES), t_end=TIMES)
def test_any_data_give_a_curve_or_a_typed_error(size, seed, scales, t_end):
    try:
        curve = RiemannianCubic.from_initial(*random_state(*size, seed, scales), t_end=t_end)
        assert curve.steps <= LIMIT
        S = curve(curve.t_span)
        defect = np.abs(np.swapaxes(S, -1, -2) @ S - np.eye(size[1])).max()
        assert defect < 1e-13 + 8 * EPS * curve.steps, f"orthonormality {defect:.2e}"
        values = [curve.energy, curve.cost(), *curve.initial, curve.momentum, curve.jerk(curve.t_span)]
        assert all(np.all(np.isfinite(x)) for x in values)
    except ConvergenceError as error:
        assert error.report.iterations <= LIMIT
    except StiefelError as error:
        assert max(scales) > 1.0 or abs(t_end) > 3.0 or t_end == 0.0, f"moderate data refused: {error}"


@pytest.mark.parametrize("scales", [(0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 0, 1e-5), (0, 1e-5, 1), (1e-9, 0, 1)])
@pytest.mark.parametrize(("n", "k"), [(2, 1), (3, 1), (3, 2), (5, 2), (4, 4)])
def test_series_with_missing_orders(n, k, scales):
    # If only one vector is nonzero, only every second or third Taylor coefficient at the start is nonzero.
    curve = RiemannianCubic.from_initial(*random_state(n, k, 4, scales), t_end=3.0)
    again = RiemannianCubic.from_initial(*state_at(curve, 0.7), t_end=2.3)
    assert_close(again([0.0, 1.0, 2.3]), curve([0.7, 1.7, 3.0]), 2e-13, "from another start")
    S = curve(np.linspace(0, 3, 40))
    assert_close(np.swapaxes(S, -1, -2) @ S, np.eye(k), 8 * EPS * (curve.steps + n), "orthonormality")


@settings(max_examples=60, deadline=None)
@given(size=SIZES, seed=st.integers(0, 2**32 - 1), t=st.floats(-3.0, 3.0))
def test_a_cubic_is_determined_by_any_of_its_states(size, seed, t):
    curve = RiemannianCubic.from_initial(*random_state(*size, seed))
    again = RiemannianCubic.from_initial(*state_at(curve, t))
    moments = np.linspace(0, 1, 4)
    # Errors at t grow on the way back, together with the derivatives there.
    rates = [np.abs(curve(t, nu)).max() for nu in (1, 2, 3)]
    bound = 1e-13 * (1 + abs(t)) ** 3 * (1 + max(rates))
    assert_close(again(moments - t), curve(moments), bound, "the same curve from elsewhere")


def test_sixteen_threads_share_a_curve():
    curve = RiemannianCubic.from_initial(*random_state(8, 3, 1))
    grids = [np.linspace(0, 1, 20), np.linspace(-1, 2, 2000)]

    def work(_):
        return [
            curve(grids[0], 2),
            curve(grids[1]),
            curve.jerk(grids[0]),
            curve.restricted(-1, 3).cost(),
            *curve.initial,
        ]

    expected = work(0)
    with ThreadPoolExecutor(16) as pool:
        for result in pool.map(work, range(32)):
            for i, (found, exact) in enumerate(zip(result, expected, strict=True)):
                assert np.array_equal(found, exact), f"result {i} differs between threads"


def test_ten_thousand_solves_in_threads():
    states = [random_state(3, 1, seed) for seed in range(100)]
    expected = [RiemannianCubic.from_initial(*state)(1.0) for state in states]

    def work(i):
        return np.array_equal(RiemannianCubic.from_initial(*states[i % 100])(1.0), expected[i % 100])

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(10_000), chunksize=100))


def test_a_call_that_looks_short_looks_for_ctrl_c():
    """Its data look slow, so it runs in place; an endless number of steps follows."""
    e = np.eye(12)
    curve = RiemannianCubic.from_initial(e[:, :3], e[:, 3:6], 0 * e[:, :3], 0 * e[:, :3])
    with handled() as handler:
        assert handler.outcome(partial(_thread.interrupt_main), partial(curve, 8e3)) == "stopped"


def test_momentum_that_does_not_fit_is_refused():
    S, V, A = np.zeros((3, 20_000, 1))
    S[0], V[1], A[2] = 1, 1, 1
    curve = RiemannianCubic.from_initial(S, V, A, A)
    with pytest.raises(InvalidInputError, match="16384"):
        curve.momentum  # noqa: B018
    assert np.isfinite(curve.energy)
