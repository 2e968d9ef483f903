"""Invalid and unusual input: a typed error with the measured defect, or the correct result, never a panic."""

import copy
import itertools
import pickle
import re

import numpy as np
import pytest
from public_calls import ARGUMENTS, CALLS, S1, SKEW, SPHERE, Z0, M, S, V, flat, good, replaced

from stiefel_rs import (
    Chart,
    ConvergenceError,
    CubicSpline,
    GeometricCubic,
    InvalidInputError,
    OutsideDomainError,
    QuasiGeodesic,
    RotationSpline,
    SmoothingSpline,
    Stiefel,
    StiefelError,
    orthogonal_log,
    skew_exp,
)


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
    said = str(caught.value)
    assert re.match(f"(knot [0-9]+: )?({name}|control points):", said), f"{said} does not name {name}"


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
def test_masked_entries_are_refused(call, i):
    name, value = CALLS[call][1][i][0], good(call, i)
    masked = np.ma.array(value, dtype=float)
    assert_same(replaced(call, i, masked), replaced(call, i, value), f"{call}, nothing masked")
    masked[(0,) * value.ndim] = np.ma.masked
    for form in [masked] + [list(masked)] * (value.ndim > 1):
        with pytest.raises(InvalidInputError, match=f"{name}: 1 of {value.size} entries is masked"):
            replaced(call, i, form)


def test_masked_parameters_are_refused():
    curve, t = QuasiGeodesic(S, S1), np.ma.array([0.0, 0.5, 1.0], mask=[False, True, True])
    with pytest.raises(InvalidInputError, match="t: 2 of 3 entries are masked; fill or remove them"):
        curve(t)
    with pytest.raises(InvalidInputError, match="t: 1 of 1 entries is masked"):
        curve([0.0, np.ma.masked, 1.0])
    weights = np.ma.array([1.0, 1.0, 1.0], mask=[True, False, False])
    with pytest.raises(InvalidInputError, match="weights: 1 of 3 entries is masked"):
        SmoothingSpline([0.0, 1.0, 2.0], [S, S1, S], weights, lam=1.0)


def wrong_shapes(x, name):
    if name == "t":
        return []
    if x.ndim == 3:
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


# Instead of velocities, the name of an estimation method is accepted.
TAKES_WORDS = {("CubicHermite", 2), ("CubicHermite.geometric", 2)}


# Matrices, points and vectors may be complex; times may not.
TAKES_COMPLEX = {
    *("skew_exp", "orthogonal_log"),
    *("QuasiGeodesic", "from_velocity", "Geodesic", "Geodesic.from_velocity", "GeometricCubic", "from_control_points"),
    *("GeometricPolynomial", "GeometricPolynomial.geodesic", "from_initial", "from_boundary", "solve_boundary"),
    *("integrate_embedded", "CubicHermite", "CubicHermite.geometric", "CubicSpline", "CubicSpline.geometric"),
    *("bc_type", "SmoothingSpline", "estimate_velocities"),
}


@pytest.mark.parametrize(("call", "i"), ARGUMENTS)
def test_not_real_numbers(call, i):
    value = good(call, i)
    words = [] if (call, i) in TAKES_WORDS else ["text"]
    taken = call in TAKES_COMPLEX and CALLS[call][1][i][0] != "t"
    others = [] if taken else [value.astype(complex)]
    for bad in [*others, value.astype(str), value.astype(object), None, *words, {}, object()]:
        with pytest.raises(TypeError):
            replaced(call, i, bad)
            pytest.fail(f"{call}: {bad!r} was taken")
    for bad in [value.astype("m8[s]"), value.astype("M8[s]"), value.astype(bytes)]:
        with pytest.raises(TypeError):
            replaced(call, i, bad)
    with pytest.raises((TypeError, ValueError)):
        replaced(call, i, [[1.0, 2.0], [3.0]])


def test_items_of_different_shapes_are_named():
    ragged, knots = [[0.0, 1.0], [0.0]], [0.0, 1.0]
    calls = {
        "A": lambda: skew_exp(ragged),
        "S": lambda: M.exp(ragged, V),
        "V": lambda: M.exp(S, ragged),
        "t": lambda: CubicSpline(knots, [S, S1])(ragged),
        "rotations": lambda: RotationSpline(knots, ragged),
    }
    for name, call in calls.items():
        with pytest.raises(InvalidInputError, match=f"^{name}: found items of different shapes$") as caught:
            call()
        assert isinstance(caught.value.__cause__, ValueError), name


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
    """The same numbers in every memory layout that NumPy supports."""
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


POINTS = ("S", "S0", "P", "Q", "Y", "Y0")


@pytest.mark.parametrize("call", [c for c, (_, a) in CALLS.items() if a[0][0] in POINTS and "project" not in c[-7:]])
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


@pytest.mark.parametrize("steps", [1.5, 2.0, "3", None, [3]])
def test_steps_of_the_wrong_kind(steps):
    for call in [lambda: SPHERE.integrate(Z0, steps), lambda: SPHERE.shoot(*Z0.reshape(4, 2), steps)]:
        with pytest.raises(NUMBER_ERRORS):
            call()


@pytest.mark.parametrize("steps", HUGE[1:])
def test_more_steps_than_fit_in_memory(steps):
    with pytest.raises(MemoryError, match="cannot hold"):
        SPHERE.integrate(Z0, steps)
    # Before the iteration, which would never finish its first flow.
    with pytest.raises(InvalidInputError, match=r"steps: .*fit in memory"):
        SPHERE.shoot(*Z0.reshape(4, 2)[[0, 1, 0, 1]], steps)


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
