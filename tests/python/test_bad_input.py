"""Bad and unusual input: a typed error with the measured number or the right answer, never a NaN, never a panic."""

import copy
import itertools
import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiefel_rs import (
    Chart,
    ConvergenceError,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    InvalidInputError,
    OutsideDomainError,
    QuasiGeodesic,
    RiemannianCubic,
    Stiefel,
    StiefelError,
    orthogonal_log,
    skew_exp,
)

EPS = np.finfo(float).eps
M = Stiefel(4, 2)
SPHERE = Chart.sphere()
# Entries are multiples of 1/2: exact in every float and, times two, in integers.
S = np.eye(4, 2)
S1 = np.array([[0, 0], [0, 1], [1, 0], [0, 0.0]])
V = np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
V1 = np.array([[1, 0], [0, 0], [0, 0], [0, 1.0]])
S2 = np.array([[1, 1], [-1, 1], [1, 1], [1, -1]]) / 2
V2 = np.array([[0, 1], [-1, 0], [0, 1], [3, 0.0]])
Z0 = np.array([1, 2, 1, 0, 0, 1, 0, 1.0])
SKEW = np.array([[0, -2, 1], [2, 0, 0], [-1, 0, 0.0]])

# name -> (function of its array arguments, [(argument, good value)]).
CALLS = {
    "skew_exp": (skew_exp, [("A", SKEW)]),
    "orthogonal_log": (orthogonal_log, [("Q", np.roll(np.eye(3), 1, axis=0))]),
    "check_point": (M.check_point, [("S", S)]),
    "check_tangent": (M.check_tangent, [("S", S), ("V", V)]),
    "random_tangent": (lambda S: M.random_tangent(S, 1), [("S", S)]),
    "project": (M.project, [("Y", S + V)]),
    "project_tangent": (M.project_tangent, [("S", S), ("Z", S + V)]),
    "inner": (M.inner, [("S", S), ("V", V), ("W", V1 * 0)]),
    "norm": (M.norm, [("S", S), ("V", V)]),
    "decompose": (M.decompose, [("S", S), ("V", V)]),
    "compose": (M.compose, [("S", S), ("X", np.zeros((4, 4))), ("Omega", np.zeros((2, 2)))]),
    "retract": (M.retract, [("S", S), ("V", V)]),
    "inverse_retract": (M.inverse_retract, [("S0", S), ("S1", S1)]),
    "retract_qr": (lambda S, V: M.retract(S, V, "qr"), [("S", S), ("V", V)]),
    "retract_polar": (lambda S, V: M.retract(S, V, "polar"), [("S", S), ("V", V)]),
    "retract_cayley": (lambda S, V: M.retract(S, V, "cayley"), [("S", S), ("V", V)]),
    "inverse_qr": (lambda a, b: M.inverse_retract(a, b, "qr"), [("S0", S), ("S1", S2)]),
    "inverse_polar": (lambda a, b: M.inverse_retract(a, b, "polar"), [("S0", S), ("S1", S2)]),
    "inverse_cayley": (lambda a, b: M.inverse_retract(a, b, "cayley"), [("S0", S), ("S1", S2)]),
    "transport": (M.transport, [("S", S), ("V", V), ("W", V2)]),
    "curvature": (M.curvature, [("S", S), ("U", V), ("V", V2), ("W", V)]),
    "sectional_curvature": (M.sectional_curvature, [("S", S), ("U", V), ("V", V2)]),
    "gradient_of": (M.euclidean_to_riemannian_gradient, [("S", S), ("G", V + S)]),
    "hessian_of": (M.euclidean_to_riemannian_hessian, [("S", S), ("G", V + S), ("H", S), ("V", V)]),
    "QuasiGeodesic": (lambda a, b: QuasiGeodesic(a, b)(0.5), [("S0", S), ("S1", S1)]),
    "from_velocity": (lambda a, b: QuasiGeodesic.from_velocity(a, b)(0.5), [("S", S), ("V", V)]),
    "GeometricCubic": (lambda *x: GeometricCubic(*x)(0.5), [("S0", S), ("V0", V), ("S1", S1), ("V1", V1)]),
    "from_control_points": (lambda P: GeometricCubic.from_control_points(P)(0.5), [("P", np.stack([S, S1, S, S]))]),
    "from_initial": (
        lambda *x: RiemannianCubic.from_initial(*x)(0.5),
        [("S", S), ("V", V), ("A", V2), ("J", V)],
    ),
    "from_boundary": (
        lambda *x: RiemannianCubic.from_boundary(*x)(0.5),
        [("S0", S), ("V0", V), ("S1", S2), ("V1", S2 @ [[0, -1], [1, 0]])],
    ),
    "exp": (M.exp, [("S", S), ("V", V)]),
    "log": (M.log, [("S0", S), ("S1", S2)]),
    "dist": (M.dist, [("S0", S), ("S1", S2)]),
    "Geodesic": (lambda a, b: Geodesic(a, b)(0.5), [("S0", S), ("S1", S2)]),
    "Geodesic.from_velocity": (lambda a, b: Geodesic.from_velocity(a, b)(0.5), [("S", S), ("V", V)]),
    "GeometricPolynomial": (lambda P: GeometricPolynomial(P)(0.5), [("P", np.stack([S, S2, S]))]),
    "GeometricPolynomial.geodesic": (
        lambda P: GeometricPolynomial(P, pieces="geodesic")(0.5),
        [("P", np.stack([S, S2, S]))],
    ),
    "curve": (QuasiGeodesic.from_velocity(S, V), [("t", np.array([0.0, 1.0]))]),
    "jerk": (lambda t: GeometricCubic(S, V, S, V).jerk(t), [("t", np.array([0.0, 1.0]))]),
    "embed": (SPHERE.embed, [("q", Z0[:2])]),
    "embed_velocity": (SPHERE.embed_velocity, [("q", Z0[:2]), ("qdot", Z0[2:4])]),
    "momenta": (SPHERE.momenta, [("q", Z0[:2]), ("qdot", Z0[2:4]), ("qddot", Z0[4:6]), ("qdddot", Z0[6:])]),
    "derivatives": (SPHERE.derivatives, [("z", Z0)]),
    "hamiltonian": (SPHERE.hamiltonian, [("z", Z0)]),
    "gradient": (SPHERE.gradient, [("z", Z0)]),
    "hessian": (SPHERE.hessian, [("z", Z0)]),
    "integrate": (lambda z: SPHERE.integrate(z, 3, 0.1), [("z0", Z0)]),
    "reference": (SPHERE.reference, [("z0", Z0), ("t", np.array([0.0, 0.25]))]),
    "shoot": (
        lambda *x: SPHERE.shoot(*x, 4).trajectory,
        [("q0", Z0[:2]), ("qdot0", Z0[2:4]), ("q1", Z0[:2]), ("qdot1", Z0[2:4])],
    ),
    "guess": (
        lambda p, m: SPHERE.shoot(Z0[:2], Z0[2:4], Z0[:2], Z0[2:4], 4, guess=(p, m)).trajectory,
        [("guess", np.zeros(2)), ("guess", np.zeros(2))],
    ),
}
ARGUMENTS = [
    pytest.param(call, i, id=f"{call}-{arg}{i}") for call, (_, args) in CALLS.items() for i, (arg, _) in enumerate(args)
]


def replaced(call, i, value):
    function, args = CALLS[call]
    return function(*[value if j == i else good for j, (_, good) in enumerate(args)])


def good(call, i):
    return CALLS[call][1][i][1]


def flat(result):
    return [np.asarray(x) for x in (result if isinstance(result, tuple) else (result,)) if x is not None]


def assert_same(a, b, what):
    for x, y in zip(flat(a), flat(b), strict=True):
        assert np.array_equal(x, y), f"{what}: {x} differs from {y}"


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite(call, i, bad):
    value = good(call, i).copy()
    value.flat[-1] = bad
    with pytest.raises(InvalidInputError, match="not finite") as caught:
        replaced(call, i, value)
    name = CALLS[call][1][i][0]
    assert str(caught.value).startswith((name + ":", "control points:")), f"{caught.value} does not name {name}"


def wrong_shapes(x, name):
    if name == "t":
        return []
    if name == "P":
        return [x[0], x[:1], x[None], x[:, :0], x[..., :0], np.swapaxes(x, 1, 2), np.zeros(())]
    shapes = [np.zeros(()), x[..., :-1], np.concatenate([x, x], axis=-1), np.zeros((*x.shape[:-1], 0))]
    if x.ndim == 2:
        shapes += [x[0], x[:-1], x[:, :0], x[:0, :0], np.zeros((0, 7, 9))]
    if x.ndim == 2 and x.shape[0] != x.shape[1]:
        shapes += [x.T]
    return shapes + [np.zeros((0, 9))] * (x.ndim == 1)


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
def test_wrong_shapes(call, i):
    name, value = CALLS[call][1][i]
    for bad in wrong_shapes(value, name):
        with pytest.raises(InvalidInputError) as caught:
            replaced(call, i, bad)
            pytest.fail(f"{call}: {name} of shape {bad.shape} was taken")
        assert name in str(caught.value) or "shape" in str(caught.value), str(caught.value)


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
def test_not_real_numbers(call, i):
    value = good(call, i)
    for bad in [value.astype(complex), value.astype(str), value.astype(object), None, "text", {}, object()]:
        with pytest.raises(TypeError):
            replaced(call, i, bad)
            pytest.fail(f"{call}: {bad!r} was taken")
    for bad in [value.astype("m8[s]"), value.astype("M8[s]"), value.astype(bytes)]:
        with pytest.raises(TypeError):
            replaced(call, i, bad)
    with pytest.raises((TypeError, ValueError)):
        replaced(call, i, [[1.0, 2.0], [3.0]])


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
def test_same_kind_types(call, i):
    value = good(call, i)
    expected = replaced(call, i, value)
    kinds = ["f4", "f8", "g", ">f8", "<f4", ">f4"]
    if np.array_equal(value, value.astype("f2")):
        kinds.append("f2")
    if np.array_equal(value, np.round(value)):
        kinds += ["i1", "i4", ">i8", "i8"] + ["u1", "u8"] * bool(value.min() >= 0)
    if set(np.unique(value)) <= {0.0, 1.0}:
        kinds.append("?")
    for kind in kinds:
        assert_same(replaced(call, i, value.astype(kind)), expected, f"dtype {kind}")
    assert_same(replaced(call, i, value.tolist()), expected, "nested lists")


def layouts(x):
    """The same numbers in memory in every way NumPy knows."""
    yield "Fortran", np.asfortranarray(x)
    readonly = x.copy()
    readonly.flags.writeable = False
    yield "read-only", readonly
    yield (
        "negative strides",
        np.ascontiguousarray(x[tuple([slice(None, None, -1)] * x.ndim)])[tuple([slice(None, None, -1)] * x.ndim)],
    )
    wide = np.full(tuple(3 * s + 2 for s in x.shape), np.nan)
    view = wide[tuple([slice(1, 1 + 3 * s, 3) for s in x.shape])]
    view[...] = x
    yield "sliced", view
    packed = np.zeros(x.shape, dtype=[("byte", "i1"), ("value", "f8")])
    packed["value"] = x
    yield "field of a packed record", packed["value"]
    raw = np.zeros(8 * x.size + 1, dtype="u1")
    shifted = raw[1:].view("f8").reshape(x.shape)
    shifted[...] = x
    yield "one byte off alignment", shifted
    pair = np.zeros((*x.shape, 2))
    pair[..., 1] = x
    yield "imaginary part", pair.view(complex)[..., 0].imag
    yield "matrix subclass", x.view(type("Sub", (np.ndarray,), {}))
    yield "masked array with no mask", np.ma.masked_array(x)
    yield "buffer", memoryview(np.ascontiguousarray(x))


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
def test_memory_layouts(call, i):
    value = good(call, i)
    expected = replaced(call, i, value)
    for what, array in layouts(value):
        before = np.array(array)
        assert_same(replaced(call, i, array), expected, what)
        assert np.array_equal(np.asarray(array), before), f"{what}: the argument was changed"


def test_broadcast_views_are_taken():
    batch = np.broadcast_to(SKEW, (4, 3, 3))
    assert_same(skew_exp(batch), np.stack([skew_exp(SKEW)] * 4), "stride 0")


@pytest.mark.parametrize("shape", [(0, 2, 3), (0, 0, 0), (2, 0, 3, 2)])
@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
def test_an_empty_batch_still_has_a_shape_to_check(function, shape):
    with pytest.raises(InvalidInputError, match="shape"):
        function(np.zeros(shape))


def test_incompatible_batches():
    with pytest.raises(InvalidInputError, match="broadcast"):
        M.inner(np.zeros((2, 4, 2)), np.zeros((3, 4, 2)), V)
    with pytest.raises(InvalidInputError, match="broadcast"):
        SPHERE.embed_velocity(np.ones((2, 2)), np.ones((3, 2)))


@pytest.mark.parametrize("call", [c for c, (_, a) in CALLS.items() if a[0][0] in ("S", "S0", "P", "Q")])
def test_not_orthonormal_carries_the_defect(call):
    value = good(call, 0) * (1 + 1e-5)
    point = value[0] if value.ndim == 3 else value
    defect = np.linalg.norm(point.T @ point - np.eye(point.shape[1]))
    with pytest.raises(InvalidInputError, match=r"not orthonormal.*" + f"{defect:.3e}"[:5]):
        replaced(call, 0, value)


@pytest.mark.parametrize(("call", "i"), [("check_tangent", 1), ("inner", 1), ("inner", 2), ("norm", 1)])
def test_not_tangent_carries_the_defect(call, i):
    with pytest.raises(InvalidInputError, match=r"not tangent.*1\.414"):
        replaced(call, i, S)


OTHER_TANGENTS = [("decompose", 1), ("retract", 1), ("from_velocity", 1), ("GeometricCubic", 1), ("GeometricCubic", 3)]


@pytest.mark.parametrize(("call", "i"), OTHER_TANGENTS)
def test_not_tangent(call, i):
    with pytest.raises(InvalidInputError, match=r"not tangent"):
        replaced(call, i, good(call, i) + S + S1)


def test_not_skew_carries_the_defect():
    with pytest.raises(InvalidInputError, match=r"not skew-symmetric.*1\.732"):
        skew_exp(SKEW + np.eye(3))


def test_rank_deficient_carries_the_singular_value():
    with pytest.raises(InvalidInputError, match="singular value"):
        M.project(np.ones((4, 2)))
    with pytest.raises(InvalidInputError):
        M.project(np.zeros((4, 2)))


@pytest.mark.parametrize("theta", [0.0, -0.1, np.pi, 4.0, -1e300, 1e300])
@pytest.mark.parametrize("name", ["sphere", "frame"])
def test_outside_of_the_chart_carries_the_angle(theta, name):
    chart = getattr(Chart, name)()
    z = np.full(4 * chart.d, 0.5)
    z[0] = theta
    q, x = z[: chart.d], np.full(chart.d, 0.5)
    for call in [
        lambda: chart.embed(q),
        lambda: chart.embed_velocity(q, x),
        lambda: chart.momenta(q, x, x, x),
        lambda: chart.derivatives(z),
        lambda: chart.hamiltonian(z),
        lambda: chart.gradient(z),
        lambda: chart.hessian(z),
        lambda: chart.integrate(z, 2),
        lambda: chart.reference(z, [0.5]),
        lambda: chart.shoot(q, x, x, x, 3),
        lambda: chart.shoot(x, x, q, x, 3),
    ]:
        with pytest.raises(OutsideDomainError, match="theta") as caught:
            call()
        assert caught.value.angle == theta


@pytest.mark.parametrize("call", [QuasiGeodesic, lambda a, b: GeometricCubic.from_control_points([a, a, b, b])])
def test_points_that_no_curve_joins(call):
    for a, b in [
        ([[1.0], [0.0], [0.0]], [[-1.0], [0.0], [0.0]]),
        (np.eye(3), np.diag([1.0, 1.0, -1.0])),
        (np.eye(4), np.diag([1.0, 1.0, -1.0, -1.0])),
        ([[1.0]], [[-1.0]]),
    ]:
        with pytest.raises(OutsideDomainError) as caught:
            call(a, b)
        assert abs(caught.value.angle - np.pi) <= 1e-14, f"carried angle {caught.value.angle!r}"


HUGE = [2**31, 2**62, 2**63 - 1, 10**30]
NUMBER_ERRORS = (StiefelError, TypeError, ValueError, OverflowError, MemoryError)


@pytest.mark.parametrize("steps", [0, -1, -(2**63)])
def test_steps_out_of_range(steps):
    for call in [lambda: SPHERE.integrate(Z0, steps), lambda: SPHERE.shoot(*Z0.reshape(4, 2), steps)]:
        with pytest.raises(InvalidInputError, match=f"steps.*{steps}"):
            call()


@pytest.mark.parametrize("steps", [1.5, 2.0, "3", None, [3], 2**62, 2**63 - 1, 10**30])
def test_steps_of_the_wrong_kind_or_huge(steps):
    for call in [lambda: SPHERE.integrate(Z0, steps), lambda: SPHERE.shoot(*Z0.reshape(4, 2), steps)]:
        with pytest.raises(NUMBER_ERRORS):
            call()


def test_integer_likes_are_integers():
    for steps in [np.int64(3), np.uint8(3), np.array(3)]:
        assert SPHERE.integrate(Z0, steps, 0.1).shape == (4, 8)


@pytest.mark.parametrize("t_end", [np.nan, np.inf, -np.inf])
def test_end_time_not_finite(t_end):
    with pytest.raises(InvalidInputError, match="t_end"):
        SPHERE.integrate(Z0, 3, t_end)
    with pytest.raises(InvalidInputError, match="t_end"):
        SPHERE.shoot(*Z0.reshape(4, 2)[[0, 1, 0, 1]], 3, t_end=t_end)


@pytest.mark.parametrize("t_end", [0, 1e-300, 5e-324])
def test_no_time_no_motion(t_end):
    for name in ["initial_point", "midpoint"]:
        moved = np.abs(SPHERE.integrate(Z0, 3, t_end, name) - Z0).max()
        # The velocities and forces of Z0 are below 10.
        assert moved <= 10 * t_end, f"moved by {moved:.3e} in t_end={t_end}"


@pytest.mark.parametrize("t_end", [1e3, 1e100, 1e308, -1e308])
@pytest.mark.parametrize("name", ["initial_point", "midpoint"])
def test_huge_times(t_end, name):
    finite_or_typed(lambda: SPHERE.integrate(Z0, 3, t_end, name))
    finite_or_typed(lambda: SPHERE.shoot(*Z0.reshape(4, 2)[[0, 1, 0, 1]], 3, name, t_end=t_end).trajectory)


def test_unknown_map():
    with pytest.raises(InvalidInputError, match="'simpson'"):
        SPHERE.integrate(Z0, 3, map="simpson")
    for bad in [None, 3, b"midpoint"]:
        with pytest.raises(TypeError):
            SPHERE.integrate(Z0, 3, map=bad)


@pytest.mark.parametrize("tol", [np.nan, -1.0])
def test_tolerance_out_of_range(tol):
    with pytest.raises(InvalidInputError, match="tol"):
        SPHERE.shoot(*Z0.reshape(4, 2)[[0, 1, 0, 1]], 3, tol=tol)
    with pytest.raises(InvalidInputError, match="atol"):
        M.check_point(S, atol=tol)


def test_threads_out_of_range():
    for bad in [0, -1, 2**40]:
        for call in [skew_exp, orthogonal_log]:
            with pytest.raises(InvalidInputError, match=f"num_threads.*{bad}"):
                call(np.eye(2) * 0, num_threads=bad)
        with pytest.raises(InvalidInputError, match=f"num_threads.*{bad}"):
            QuasiGeodesic(S, S)(0.5, num_threads=bad)
    for bad in [1.5, "2", 10**30]:
        with pytest.raises(NUMBER_ERRORS):
            skew_exp(SKEW, num_threads=bad)


@pytest.mark.parametrize(("n", "k"), [(0, 0), (3, 0), (0, 1), (2, 3), (-1, 1), (3, -1), (-3, -3)])
def test_manifolds_that_do_not_exist(n, k):
    with pytest.raises(InvalidInputError, match=f"n = {n}, k = {k}"):
        Stiefel(n, k)


@pytest.mark.parametrize(("n", "k"), [(2**62, 2**61), (2**32, 2**32), (10**30, 1), (2.0, 1), ("3", 1), (None, 1)])
def test_manifolds_of_odd_sizes(n, k):
    try:
        dim = Stiefel(n, k).dim
    except NUMBER_ERRORS:
        return
    assert dim == n * k - k * (k + 1) // 2, f"dimension of St({n}, {k}) is not {dim}"


@pytest.mark.parametrize("size", [-1, (2, -1), "ab", 2.0, (2.0,), 10**18, (10**10, 10**10), {}])
def test_bad_sizes_of_random_points(size):
    with pytest.raises((StiefelError, TypeError, ValueError, MemoryError)):
        M.random_point(0, size)


@pytest.mark.parametrize("seed", [-1, "x", 1.5, object()])
def test_bad_seeds(seed):
    with pytest.raises((TypeError, ValueError)):
        M.random_point(seed)


def failed_shot():
    with pytest.raises(ConvergenceError) as caught:
        SPHERE.shoot([1, 1], [0.1, 0.1], [2, 1], [0.1, 0.1], 5, max_iterations=0)
    return caught.value


def test_no_iterations_is_a_convergence_error_with_a_report():
    error = failed_shot()
    report = error.report
    assert (report.converged, report.iterations, report.reason) == (False, 0, "max_iterations")
    assert report.residual > report.tolerance == 1e-12
    assert f"{report.residual:.2e}"[:4] in str(error)


def test_hierarchy():
    assert issubclass(StiefelError, Exception)
    assert not issubclass(StiefelError, (ValueError, RuntimeError))
    for error, base in [
        (InvalidInputError, ValueError),
        (OutsideDomainError, ValueError),
        (ConvergenceError, RuntimeError),
    ]:
        assert issubclass(error, StiefelError)
        assert issubclass(error, base)


def raised():
    for call in [lambda: M.check_point(2 * S), lambda: orthogonal_log(-np.eye(2)), lambda: SPHERE.embed([4, 0])]:
        with pytest.raises(StiefelError) as caught:
            call()
        yield caught.value
    yield failed_shot()


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
@pytest.mark.parametrize("which", range(4), ids=["invalid", "angle", "chart", "convergence"])
def test_exceptions_survive_copies(duplicate, which):
    error = next(itertools.islice(raised(), which, None))
    twin = duplicate(error)
    assert type(twin) is type(error)
    assert str(twin) == str(error)
    assert getattr(twin, "angle", None) == getattr(error, "angle", None)
    assert repr(getattr(twin, "report", None)) == repr(getattr(error, "report", None))


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
@pytest.mark.parametrize("value", [M, Chart.sphere(), Chart.frame()], ids=repr)
def test_values_survive_copies(duplicate, value):
    assert duplicate(value) == value
    assert hash(duplicate(value)) == hash(value)


def finite_or_typed(call):
    """A finite result without a warning, or one of the exceptions of the contract."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            result = call()
        except (StiefelError, TypeError, ValueError) as error:
            assert "nan" not in str(error).lower().replace("found nan", ""), f"a NaN in the message: {error}"
            return
    for x in flat(result):
        assert np.isfinite(x).all(), f"finite input, result {x}"


EXTREME = [5e-324, 1e-310, 1e-160, 1e100, 1e155, 1e200, 1e308]


# The reference takes its 100 000 steps before it gives up, a minute each; far parameters have a test of their own.
QUICK = [a for a in ARGUMENTS if a.values[0] not in ("reference", "jerk")]


@pytest.mark.parametrize(("call", "i"), QUICK)
@pytest.mark.parametrize("scale", EXTREME)
def test_extreme_scales(call, i, scale):
    # |entries| stay below 1.8e308: the input is finite.
    value = good(call, i)
    largest = max(1.0, np.abs(value).max())
    finite_or_typed(lambda: replaced(call, i, value * (scale / largest)))
    finite_or_typed(lambda: replaced(call, i, np.full_like(value, scale)))


@pytest.mark.parametrize("scale", EXTREME)
@pytest.mark.parametrize("nu", [0, 1, 2, 3])
def test_extreme_curves(scale, nu):
    finite_or_typed(lambda: QuasiGeodesic.from_velocity(S, V * (scale / 2))([0.0, 0.5, 1.0], nu))
    finite_or_typed(lambda: QuasiGeodesic(S, S1)([scale, -scale], nu))
    finite_or_typed(lambda: GeometricCubic(S, V * (scale / 2), S1, V1)([0.0, 0.5, 1.0], nu))


@pytest.mark.parametrize("method", ["curve({t}, 0)", "curve({t}, 1)", "curve({t}, 3)", "curve.jerk({t})"])
@pytest.mark.parametrize("t", [1e16, 1e155, 1e200, 1e308])
def test_far_parameters_return(t, method):
    # A process of its own: a loop without end in compiled code cannot be stopped from inside.
    code = f"""
import numpy as np
from stiefel_rs import GeometricCubic, StiefelError
S, V = np.eye(4, 2), np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
curve = GeometricCubic(S, V, S, V)
try:
    print(bool(np.isfinite({method.format(t=t)}).all()))
except StiefelError:
    print(True)
"""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=5, check=False)
    except subprocess.TimeoutExpired:
        pytest.fail(f"{method.format(t=t)} does not return")
    assert done.stdout == "True\n", f"{method.format(t=t)}: {done.stdout}{done.stderr[-300:]}"


@pytest.mark.parametrize("scale", EXTREME)
def test_extreme_costs(scale):
    curve = QuasiGeodesic.from_velocity(S, V * (scale / 2))
    finite_or_typed(curve.cost)
    if scale >= 1e155:
        with pytest.raises(StiefelError):
            curve.cost()
            pytest.fail(f"the cost is beyond 1e308, returned {curve.cost()}")


@pytest.mark.parametrize("m", [2, 3, 4, 5, 9])
@pytest.mark.parametrize("scale", EXTREME)
def test_exponential_of_extreme_matrices_is_a_rotation(m, scale, rng):
    A = rng.standard_normal((m, m))
    A -= A.T
    A = A / np.abs(A).max()
    if scale > 1 and np.linalg.norm(A, 2) > np.finfo(float).max / scale:
        with pytest.raises(InvalidInputError, match="too large"):  # an angle is no number any more
            skew_exp(A * scale)
        return
    R = skew_exp(A * scale)
    defect = np.linalg.norm(R.T @ R - np.eye(m))
    assert defect <= m * 1e-15, f"orthogonality defect {defect:.3e} at entries of {scale}"


numbers = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([0.0, -0.0, 1.0, -1.0, np.pi, np.pi / 2, 1e-16, 1e16]),
    st.floats(-4, 4),
)


@pytest.mark.parametrize(
    "call", [c for c in CALLS if c not in ("random_tangent", "reference", "shoot", "guess", "jerk")]
)
@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_any_finite_input_gives_a_finite_result_or_a_typed_error(call, data):
    function, args = CALLS[call]
    values = []
    for _, value in args:
        noise = np.array(data.draw(st.lists(numbers, min_size=value.size, max_size=value.size))).reshape(value.shape)
        second = np.arange(value.size).reshape(value.shape) == 1
        # Good values, good values with one entry replaced, and noise.
        values.append(data.draw(st.sampled_from([value, np.where(second, noise, value), noise])))
    finite_or_typed(lambda: function(*values))


@given(
    st.lists(numbers, min_size=16, max_size=16),
    st.lists(numbers, min_size=4, max_size=4),
    st.sampled_from(["initial_point", "midpoint"]),
    st.sampled_from([1.0, -1.0, 1e-8, 10.0]),
)
@settings(deadline=None, max_examples=100)
def test_shooting_at_anything(entries, guess, name, t_end):
    for points in [entries[:8], np.mod(entries[8:], 3.0)]:
        ends = np.array(points).reshape(4, 2)
        finite_or_typed(lambda ends=ends: SPHERE.shoot(*ends, 4, name, t_end=t_end).trajectory)
        finite_or_typed(lambda ends=ends: SPHERE.shoot(*ends, 4, name, guess=(guess[:2], guess[2:])).trajectory)
