"""Gradients in PyTorch: `gradcheck`, forward mode, batches, values. Run by `make test-torch`."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="not installed: PyTorch; make test-torch installs it")

from torch.autograd import forward_ad  # noqa: E402

import stiefel_rs  # noqa: E402
from stiefel_rs import (  # noqa: E402
    CubicSpline,
    GeometricCubic,
    Grassmann,
    InvalidInputError,
    RiemannianCubic,
    RotationSpline,
    Stiefel,
)
from stiefel_rs import torch as st  # noqa: E402

# A warning of PyTorch, from within its transformations.
pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:FutureWarning")

SHAPES = [(3, 1), (3, 3), (5, 2), (4, 4), (12, 3)]
TIMES = np.array([0.1, 0.4, 0.9])
KNOTS = np.array([0.0, 0.7, 1.6, 2.2])
# A quarter turn, in whole numbers.
QUARTER = torch.tensor([[0, -1], [1, 0]])


@pytest.fixture(
    params=[*SHAPES, *((*shape, "complex") for shape in SHAPES)], ids=lambda words: "_".join(map(str, words))
)
def manifold(request):
    n, k, *field = request.param
    return Stiefel(n, k, field=field[0] if field else "real")


def vector(manifold, S, rng, length=0.6):
    V = manifold.random_tangent(S, rng)
    return length * V / manifold.norm(S, V)


def near(manifold, rng):
    """A point, a tangent vector there, another point, a tangent vector there."""
    S0 = manifold.random_point(rng)
    S1 = manifold.exp(S0, vector(manifold, S0, rng, 0.5))
    return S0, vector(manifold, S0, rng), S1, vector(manifold, S1, rng)


def frames(manifold, rng):
    points = [manifold.random_point(rng)]
    while len(points) < len(KNOTS):
        points.append(manifold.exp(points[-1], vector(manifold, points[-1], rng, 0.5)))
    return np.array(points)


def check(function, *arguments):
    """Both modes compared with central differences; for complex arguments in a few random directions."""
    tensors = [torch.tensor(x, requires_grad=True) for x in arguments]
    options = {"check_forward_ad": True, "fast_mode": any(x.is_complex() for x in tensors)}
    assert torch.autograd.gradcheck(function, tensors, eps=1e-5, atol=1e-6, rtol=1e-6, **options)


def test_matrix_functions(rng):
    for m in (1, 2, 3, 4, 7):
        A = rng.normal(size=(m, m))
        A = (A - A.T) / np.linalg.norm(A)
        check(st.skew_exp, A)
        check(st.orthogonal_log, stiefel_rs.skew_exp(A))


def test_complex_matrix_functions(rng):
    for m in (1, 2, 3, 5):
        A = rng.normal(size=(m, m)) + 1j * rng.normal(size=(m, m))
        A = (A - A.conj().T) / np.linalg.norm(A)
        check(st.skew_exp, A)
        check(st.orthogonal_log, stiefel_rs.skew_exp(A))
    conjugate = torch.tensor(A).conj()
    assert conjugate.is_conj()
    torch.testing.assert_close(st.skew_exp(conjugate), st.skew_exp(conjugate.resolve_conj()))


def test_maps_of_points_and_vectors(manifold, rng):
    S0, V, S1, _ = near(manifold, rng)
    for function in (st.exp, st.retract):
        check(function, S0, V)
    for function in (st.log, st.inverse_retract):
        check(function, S0, S1)


def test_curves(manifold, rng):
    data = near(manifold, rng)
    for function in (st.geometric_cubic, st.riemannian_cubic):
        check(function, *data, TIMES)
    S, V, A, J = data[0], *(vector(manifold, data[0], rng) for _ in range(3))
    check(lambda *data: st.cubic_initial(*data, torch.tensor(TIMES)), S, V, A, J)


def test_splines(manifold, rng):
    check(st.cubic_spline, KNOTS, frames(manifold, rng), TIMES)
    q = np.array([1.0, -0.5, 0.2, 2.0]) + 0.4 * rng.normal(size=(len(KNOTS), 4))
    check(lambda *data: st.rotation_spline(*data, "clamped"), KNOTS, q, TIMES)


def test_values_are_those_of_the_package(manifold, rng):
    S0, V0, S1, V1 = near(manifold, rng)
    A, J = vector(manifold, S0, rng), vector(manifold, S0, rng)
    points = frames(manifold, rng)
    q = rng.normal(size=(len(KNOTS), 4))
    pairs = [
        (st.exp(S0, V0), manifold.exp(S0, V0)),
        (st.log(S0, S1), manifold.log(S0, S1)),
        (st.retract(S0, V0), manifold.retract(S0, V0)),
        (st.inverse_retract(S0, S1), manifold.inverse_retract(S0, S1)),
        (st.geometric_cubic(S0, V0, S1, V1, TIMES), GeometricCubic(S0, V0, S1, V1)(TIMES)),
        (st.riemannian_cubic(S0, V0, S1, V1, TIMES), RiemannianCubic.from_boundary(S0, V0, S1, V1)(TIMES)),
        (st.cubic_initial(S0, V0, A, J, TIMES), RiemannianCubic.from_initial(S0, V0, A, J)(TIMES)),
        (st.cubic_spline(KNOTS, points, TIMES), CubicSpline(KNOTS, points)(TIMES)),
        (st.rotation_spline(KNOTS, q, TIMES), RotationSpline(KNOTS, q)(TIMES)),
    ]
    for found, wanted in pairs:
        np.testing.assert_allclose(found.numpy(), wanted, rtol=0, atol=1e-13)


def test_transformations_mix(rng):
    manifold = Stiefel(5, 2)
    S0, V0, S1, V1 = map(torch.tensor, near(manifold, rng))
    batch, times = torch.stack([V0, 0.5 * V0, 0.0 * V0]), torch.tensor(TIMES)

    def reach(V):
        return torch.sin(st.riemannian_cubic(S0, V, S1, V1, times)).sum()

    gradient = torch.func.grad(reach)
    one_by_one = torch.stack([gradient(V) for V in batch])
    torch.testing.assert_close(torch.func.vmap(gradient)(batch), one_by_one, rtol=0, atol=1e-13)

    def curve(V):
        return st.riemannian_cubic(S0, V, S1, V1, times)

    torch.testing.assert_close(torch.func.jacfwd(curve)(V0), torch.func.jacrev(curve)(V0), rtol=0, atol=1e-12)
    E = torch.tensor(rng.normal(size=(5, 2)))
    _, moved = torch.func.jvp(curve, (V0,), (E,))
    wanted = torch.einsum("mnkij,ij->mnk", torch.func.jacrev(curve)(V0), E)
    torch.testing.assert_close(moved, wanted, rtol=0, atol=1e-12)


def test_single_precision_in_and_out(rng):
    S0, V0, S1, V1 = (torch.tensor(x, dtype=torch.float32) for x in near(Stiefel(5, 2), rng))
    V0.requires_grad_()
    found = st.riemannian_cubic(S0, V0, S1, V1, torch.tensor(TIMES, dtype=torch.float32))
    assert found.dtype == torch.float32
    found.sum().backward()
    assert V0.grad.dtype == torch.float32
    assert torch.isfinite(V0.grad).all()


def test_bad_input():
    S = torch.eye(4, dtype=torch.float64)[:, :2]
    with pytest.raises(InvalidInputError, match="S: columns are not orthonormal"):
        st.exp(1.1 * S, 0 * S)
    with pytest.raises(InvalidInputError, match="found a tensor on meta"):
        st.exp(S.to("meta"), S)
    with pytest.raises(InvalidInputError, match="A: not skew"):
        st.skew_exp(torch.eye(2, dtype=torch.complex128))
    with pytest.raises(TypeError, match="t: expected real numbers"):
        st.riemannian_cubic(S, 0 * S, S, 0 * S, torch.tensor([0.5j]))


def test_kinds_of_arrays(rng):
    manifold = Stiefel(5, 2)
    S0, V0, S1, V1 = near(manifold, rng)
    wanted = st.riemannian_cubic(S0, V0, S1, V1, np.array([0.3])).numpy()
    # Numbers and lists are converted to the kind of the others; arrays may be read-only or reversed.
    S0.setflags(write=False)
    backwards = np.ascontiguousarray(V0[::-1])[::-1]
    for t in (0.3, [0.3], (0.3,)):
        found = st.riemannian_cubic(S0, backwards, S1, V1, t)
        np.testing.assert_allclose(found.numpy().reshape(5, 2), wanted[0], rtol=0, atol=1e-15)
    listed = st.riemannian_cubic(S0, backwards, S1, V1, [torch.tensor(0.3, dtype=torch.float64)])
    np.testing.assert_allclose(listed.numpy(), wanted, rtol=0, atol=1e-15)
    single = st.riemannian_cubic(*(x.astype(np.float32) for x in (S0, V0, S1, V1)), [0.3])
    assert single.dtype == torch.float32
    imaginary = torch.complex(torch.zeros(2, 2), torch.tensor([[0.0, 1.0], [-1.0, 0.0]])).conj().imag
    assert imaginary.is_neg()
    torch.testing.assert_close(st.skew_exp(imaginary), st.skew_exp(imaginary.resolve_neg()))


def test_methods_take_tensors(rng):
    manifold = Stiefel(4, 2, field="complex")
    S, V = (torch.tensor(x) for x in near(manifold, rng)[:2])
    found = manifold.exp(S.conj(), V.conj())
    assert isinstance(found, torch.Tensor) and found.dtype == torch.complex128
    torch.testing.assert_close(found, manifold.exp(S.conj().resolve_conj(), V.conj().resolve_conj()), rtol=0, atol=0)
    with pytest.raises(TypeError, match=r"requires a gradient; use the functions of stiefel_rs\.torch"):
        manifold.exp(S.requires_grad_(), V)
    torch.set_default_device("meta")
    try:
        assert manifold.norm(S.detach(), V).device.type == "cpu"
    finally:
        torch.set_default_device(None)


def test_functions_of_numpy_refuse_tensors_that_are_differentiated():
    A = torch.tensor([[0.0, -0.3], [0.3, 0.0]], dtype=torch.float64)
    advice = r"use the functions of stiefel_rs\.torch, or detach\(\)$"
    with forward_ad.dual_level():
        dual = forward_ad.make_dual(A, A)
        for argument in (dual, [dual, dual]):
            with pytest.raises(TypeError, match=f"^A: a tensor that has a tangent; {advice}"):
                stiefel_rs.skew_exp(argument)
        assert isinstance(stiefel_rs.skew_exp(A), torch.Tensor)
    with pytest.raises(TypeError, match=f"^A: a tensor that requires a gradient; {advice}"):
        stiefel_rs.skew_exp([A, A.clone().requires_grad_()])
    np.testing.assert_allclose(stiefel_rs.skew_exp([A, 2 * A])[1], stiefel_rs.skew_exp(2 * A), rtol=0, atol=0)
    with pytest.raises(
        TypeError, match=r"^A: a tensor without data of its own.*; use the functions of stiefel_rs\.torch$"
    ):
        torch.func.vmap(lambda A: torch.as_tensor(stiefel_rs.skew_exp(A)).sum())(A[None])
    with pytest.raises(TypeError, match=r"^A: a tensor that requires a gradient"):
        torch.func.grad(lambda A: torch.as_tensor(stiefel_rs.skew_exp(A)).sum())(A)


def test_another_default_device():
    A = torch.tensor([[0.0, -0.3], [0.3, 0.0]], dtype=torch.float64)
    wanted = st.retract(torch.eye(2, dtype=torch.float64), A)
    torch.set_default_device("meta")
    try:
        found = st.retract(torch.eye(2, dtype=torch.float64, device="cpu"), A)
    finally:
        torch.set_default_device("cpu")
    torch.testing.assert_close(found, wanted)


def test_tracing_is_refused_or_left_out():
    A = torch.tensor([[0.0, -0.3], [0.3, 0.0]], dtype=torch.float64)
    with pytest.raises(NotImplementedError, match="cannot be traced"):
        torch.func.linearize(st.skew_exp, A)
    compiled = torch.compile(lambda A: 2.0 * st.skew_exp(A), backend="eager")
    torch.testing.assert_close(compiled(A), 2.0 * st.skew_exp(A))


def test_forward_over_reverse_by_a_cotangent():
    A = torch.tensor([[0.0, -0.3], [0.3, 0.0]], dtype=torch.float64)
    gradient = lambda w: torch.func.grad(lambda A: (w * st.skew_exp(A)).sum())(A)  # noqa: E731
    _, moved = torch.func.jvp(gradient, (A,), (2.0 * A,))
    torch.testing.assert_close(moved, gradient(2.0 * A))
    with pytest.raises(NotImplementedError, match="second derivatives are not available"):
        torch.func.hessian(lambda A: st.skew_exp(A).sin().sum())(A)


def test_second_derivatives_say_that_there_are_none():
    A = torch.tensor([[0.0, -0.3], [0.3, 0.0]], dtype=torch.float64, requires_grad=True)
    (gradient,) = torch.autograd.grad(torch.sin(st.skew_exp(A)).sum(), A, create_graph=True)
    with pytest.raises(NotImplementedError, match="second derivatives are not available"):
        gradient.sum().backward()


@pytest.mark.parametrize("field", ["real", "complex"])
@pytest.mark.parametrize(("n", "k"), [(3, 1), (5, 2), (4, 3), (12, 3)])
def test_subspaces(n, k, field, rng):
    manifold = Grassmann(n, k, field=field)
    bases = frames(manifold, rng)
    Y, Y1 = bases[0], bases[1]
    at_start = [vector(manifold, Y, rng) for _ in range(3)]
    calls = [
        (st.exp, [Y, at_start[0]]),
        (st.log, [Y, Y1]),
        (st.riemannian_cubic, [Y, at_start[0], Y1, vector(manifold, Y1, rng), TIMES]),
        (st.cubic_initial, [Y, *at_start, TIMES]),
        (st.cubic_spline, [KNOTS, bases, TIMES]),
    ]
    for function, data in calls:
        check(lambda *given, function=function: function(*given, manifold=manifold), *data)
    found = st.cubic_spline(KNOTS, bases, TIMES, manifold=manifold)
    wanted = CubicSpline(KNOTS, bases, manifold=manifold)(TIMES)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-14)


@pytest.fixture(params=[torch.float32, torch.float64], ids=["single", "double"])
def default(request):
    """The default dtype of PyTorch."""
    before = torch.get_default_dtype()
    torch.set_default_dtype(request.param)
    yield request.param
    torch.set_default_dtype(before)


@pytest.mark.parametrize("kind", [torch.int64, torch.int8, torch.bool])
def test_integers_and_booleans_have_the_default_precision(kind, default):
    A = QUARTER.to(kind) if kind != torch.bool else torch.zeros((2, 2), dtype=kind)
    found, eps = st.skew_exp(A), torch.finfo(default).eps
    assert found.dtype == default
    np.testing.assert_allclose(found, stiefel_rs.skew_exp(A.to(torch.float64)), rtol=0, atol=4 * eps)


def test_python_numbers_have_double_precision(default):
    assert st.skew_exp(QUARTER.tolist()).dtype == torch.float64


def test_integers_do_not_change_the_precision_of_others(default):
    kinds = [torch.float16, torch.bfloat16, torch.float32, torch.float64, torch.complex64, torch.complex128]
    results = [torch.float32, torch.float32, *kinds[2:]]
    S = torch.eye(3, dtype=torch.int64)[:, :2]
    for kind, wanted in zip(kinds, results, strict=True):
        V = torch.zeros((3, 2), dtype=kind)
        for frame in (S, S.to(torch.int8), S.to(torch.bool)):
            assert st.exp(frame, V).dtype == wanted
        assert st.exp(V + S, torch.zeros((3, 2), dtype=torch.int64)).dtype == wanted


def test_autocast_does_not_lower_the_precision(rng):
    data = [torch.tensor(x, dtype=torch.float32) for x in near(Stiefel(4, 2), rng)]
    S0, V0, S1, _ = data
    times = torch.tensor(TIMES, dtype=torch.float32)
    calls = [
        lambda: st.retract(S0, V0),
        lambda: st.inverse_retract(S0, S1),
        lambda: st.geometric_cubic(*data, times),
        lambda: st.riemannian_cubic(*data, times),
    ]
    for call in calls:
        wanted = call()
        with torch.autocast("cpu", dtype=torch.bfloat16):
            found = call()
        assert found.dtype == torch.float32
        torch.testing.assert_close(found, wanted, rtol=0, atol=0)
