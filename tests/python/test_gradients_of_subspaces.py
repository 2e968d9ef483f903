"""Derivatives of functions of subspaces: against differences and formulas, in both modes, at special points, errors."""

import numpy as np
import pytest

jax = pytest.importorskip("jax")

from jax.test_util import check_grads  # noqa: E402

from stiefel_rs import (  # noqa: E402
    CubicSpline,
    Grassmann,
    InvalidInputError,
    OutsideDomainError,
    RiemannianCubic,
    Stiefel,
)
from stiefel_rs import jax as sj  # noqa: E402
from stiefel_rs.differentiable import cubics, subspaces, turning  # noqa: E402
from stiefel_rs.differentiable.operation import on_pairs  # noqa: E402

SHAPES = [(3, 1), (5, 2), (4, 3), (4, 2), (12, 3)]
TIMES = np.array([0.1, 0.5, 0.9])
KNOTS = np.array([0.0, 0.7, 1.6, 2.2])


@pytest.fixture(
    params=[*SHAPES, *((*shape, "complex") for shape in SHAPES)], ids=lambda words: "_".join(map(str, words))
)
def manifold(request):
    n, k, *field = request.param
    return Grassmann(n, k, field=field[0] if field else "real")


def numbers(like, rng):
    found = rng.normal(size=like.shape)
    return found + 1j * rng.normal(size=like.shape) if like.dtype.kind == "c" else found


def vector(manifold, Y, rng, length=0.6):
    V = manifold.random_tangent(Y, rng)
    return length * V / np.linalg.norm(V)


def turned(Y, rng):
    """Another basis of the same subspace."""
    square = Y[: Y.shape[1]]
    return Y @ np.linalg.qr(numbers(square, rng))[0]


def data_of(manifold, rng):
    """An operation with data for it, each."""
    Y0 = manifold.random_point(rng)
    Y1 = turned(manifold.exp(Y0, vector(manifold, Y0, rng)), rng)
    bases = [Y0]
    while len(bases) < len(KNOTS):
        bases.append(turned(manifold.exp(bases[-1], vector(manifold, bases[-1], rng, 0.5)), rng))
    at_start = [vector(manifold, Y0, rng, length) for length in (0.8, 1.0, 2.0)]
    return [
        (subspaces.EXP, [Y0, at_start[0]]),
        (subspaces.LOG, [Y0, Y1]),
        (subspaces.RIEMANNIAN_CUBIC, [Y0, at_start[0], Y1, vector(manifold, Y1, rng), TIMES]),
        # The last time is the end of the curve, and may be passed by differences.
        (subspaces.CUBIC_INITIAL, [Y0, *at_start, np.append(TIMES, 1.5)]),
        (subspaces.CUBIC_INITIAL, [Y0, *at_start, -TIMES]),
        (subspaces.cubic_spline("natural"), [KNOTS, np.array(bases), np.array([0.2, 0.7, 1.0, 2.1])]),
        (subspaces.cubic_spline("clamped"), [KNOTS, np.array(bases), np.array([2.1, 0.3])]),
        # Seconds of a day: times are rounded.
        (subspaces.cubic_spline("natural"), [KNOTS + 86400.0, np.array(bases), np.array([0.2, 1.0]) + 86400.0]),
    ]


def forward(operation, data, moves):
    exact, moved = operation._exact(data), ()
    for argument, x, move in zip(operation.arguments, data, moves, strict=True):
        moved = (*moved, argument.variation(x, exact, move, moved))
    return operation.variation(exact, moved)


def reverse(operation, data, w):
    exact = operation._exact(data)
    pulled = operation.gradients(exact, w)
    for i in reversed(range(len(pulled))):
        pulled[i] = operation.arguments[i].pullback(data[i], exact, pulled[i], pulled)
    return pulled


def inner(one, other):
    return np.sum(np.conj(one) * other).real


def test_both_modes_against_differences(manifold, rng):
    step = 1e-5
    for operation, data in data_of(manifold, rng):
        moves = [numbers(x, rng) for x in data]
        ends = [
            operation.value(*operation._exact([x + s * m for x, m in zip(data, moves, strict=True)]))
            for s in (step, -step)
        ]
        expected = (ends[0] - ends[1]) / (2 * step)
        found = forward(operation, data, moves)
        # Times late in a day are rounded, and differences show it.
        bound = 1e-8 if np.abs(data[-1]).max() < 100 else 1e-5
        np.testing.assert_allclose(found, expected, rtol=0, atol=bound * (1 + np.abs(expected).max()))
        w = numbers(found, rng)
        pulled = sum(inner(g, m) for g, m in zip(reverse(operation, data, w), moves, strict=True))
        assert pulled == pytest.approx(inner(w, found), abs=1e-12 * np.linalg.norm(w) * np.linalg.norm(found))


def test_bases_and_subspaces(manifold, rng):
    """What a variation of a curve says without its bases, and that another first basis turns all of them."""
    Y0 = manifold.random_point(rng)
    V0 = vector(manifold, Y0, rng)
    Y1 = manifold.exp(Y0, vector(manifold, Y0, rng))
    V1 = vector(manifold, Y1, rng)
    curve = RiemannianCubic.from_boundary(Y0, V0, Y1, V1, manifold=manifold)
    data, still = [Y0, V0, Y1, V1, TIMES], 0 * V0
    w0 = vector(manifold, Y0, rng, 1.0)
    found = forward(subspaces.RIEMANNIAN_CUBIC, data, [still, w0, still, still, 0 * TIMES])
    expected = curve.point_variation(TIMES, still, w0, still, still)
    for t, one, other in zip(TIMES, found, expected, strict=True):
        assert np.abs(manifold.project_tangent(curve(t), one) - other).max() < 1e-13
    square = Y0[: Y0.shape[1]]
    turn = numbers(square, rng)
    turn = turn - turn.conj().T
    found = forward(subspaces.RIEMANNIAN_CUBIC, data, [Y0 @ turn, V0 @ turn, still, still, 0 * TIMES])
    assert np.abs(found - curve(TIMES) @ turn).max() < 1e-12


def test_special_points_have_finite_derivatives(rng):
    for n, k in [(3, 1), (4, 2), (5, 2), (4, 3), (12, 3)]:
        Y, zero = np.eye(n)[:, :k], np.zeros((n, k))
        permuted = np.eye(n)[:, ::-1][:, :k]
        signs = np.diag((-1.0) ** np.arange(k))
        # A direction along one coordinate: repeated and vanishing angles.
        V = np.zeros((n, k))
        V[-1, 0] = 0.7
        cases = [
            (subspaces.EXP, [permuted, zero]),
            (subspaces.EXP, [Y, V]),
            (subspaces.LOG, [Y, Y]),
            (subspaces.LOG, [Y, Y @ signs]),
            (subspaces.RIEMANNIAN_CUBIC, [Y, zero, Y @ signs, zero, TIMES]),
            (subspaces.CUBIC_INITIAL, [permuted, zero, zero, zero, TIMES]),
            (subspaces.CUBIC_INITIAL, [Y, V, zero, zero, np.zeros(2)]),
            (subspaces.cubic_spline("natural"), [KNOTS, np.array(4 * [Y]), TIMES]),
            (subspaces.cubic_spline("natural"), [KNOTS, np.array(4 * [Y]), np.zeros(0)]),
        ]
        for operation, data in cases:
            value = operation.value(*operation._exact(data))
            for gradient in reverse(operation, data, rng.normal(size=value.shape)):
                assert np.isfinite(gradient).all()
                assert np.abs(gradient).max(initial=0.0) < 1e2


def test_logarithm_next_to_a_right_angle():
    """Angles add up to pi - 2e-9 on a plane of lines: the derivative of the angle is still exact."""
    gap = 1e-9
    theta = np.pi / 2 - gap
    Y0, Y1 = np.array([[1.0], [0.0], [0.0]]), np.array([[np.cos(theta)], [np.sin(theta)], [0.0]])
    ahead = np.array([[-np.sin(theta)], [np.cos(theta)], [0.0]])
    moved = forward(subspaces.LOG, [Y0, Y1], [0 * Y0, ahead])
    np.testing.assert_allclose(moved, [[0.0], [1.0], [0.0]], rtol=0, atol=1e-7)
    across = forward(subspaces.LOG, [Y0, Y1], [0 * Y0, np.array([[0.0], [0.0], [1.0]])])
    np.testing.assert_allclose(across, [[0.0], [0.0], [theta / np.sin(theta)]], rtol=0, atol=1e-7)


@pytest.mark.parametrize(("n", "k", "field"), [(4, 2, "real"), (5, 3, "real"), (2, 1, "complex"), (4, 2, "complex")])
def test_logarithm_of_conjugate_subspaces_has_no_derivative(n, k, field):
    def pair(gap):
        theta = np.pi / 2 - gap
        Y0, Y1 = np.eye(n, k), np.eye(n, k)
        for i in range(min(k, n - k)):
            Y1[[i, k + i], i] = np.cos(theta), np.sin(theta)
        return [Y.astype(complex) if field == "complex" else Y for Y in (Y0, Y1)]

    w = np.ones((n, k))
    for gradient in reverse(subspaces.LOG, pair(1e-9), w):
        assert np.isfinite(gradient).all()
    with pytest.raises(
        OutsideDomainError, match=r"not differentiable: .* largest principal angles? (add up to|is) 3\.14159"
    ) as caught:
        reverse(subspaces.LOG, pair(1e-13), w)
    assert caught.value.angle == pytest.approx(np.pi / 2)


def test_gradients_of_some_arguments_are_those_of_all(manifold, rng):
    Y0 = manifold.random_point(rng)
    Y1 = manifold.exp(Y0, vector(manifold, Y0, rng))
    V0, V1 = vector(manifold, Y0, rng), vector(manifold, Y1, rng)
    for module in (cubics, subspaces):
        operation = on_pairs(module.RIEMANNIAN_CUBIC) if Y0.dtype.kind == "c" else module.RIEMANNIAN_CUBIC
        # Near tangent vectors, so that frames have a part of the vectors' gradients.
        data = [Y0, V0 + 1e-4 * numbers(Y0, rng), Y1, V1 + 1e-4 * numbers(Y0, rng)]
        raw = [np.stack([x.real, x.imag], axis=-1) if Y0.dtype.kind == "c" else x for x in data]
        w = rng.normal(size=operation.values(*raw, TIMES).shape)
        every = operation.pullbacks([*raw, TIMES], w)
        for wanted in np.eye(5, dtype=bool):
            some = operation.pullbacks([*raw, TIMES], w, wanted)
            for found, expected, is_wanted in zip(some, every, wanted, strict=True):
                np.testing.assert_allclose(found, expected if is_wanted else 0.0 * expected, rtol=0, atol=1e-12)


def test_logarithm_undoes_the_exponential(manifold, rng):
    Y = manifold.random_point(rng)
    V = vector(manifold, Y, rng)
    dY, dV = numbers(Y, rng), numbers(Y, rng)
    end = manifold.exp(Y, V)
    moved = forward(subspaces.EXP, [Y, V], [dY, dV])
    back = forward(subspaces.LOG, [Y, end], [dY, moved])
    expected = subspaces.EXP.arguments[1].variation(
        V, (Y, V), dV, (subspaces.EXP.arguments[0].variation(Y, (), dY, ()),)
    )
    np.testing.assert_allclose(back, expected, rtol=0, atol=1e-12)


def test_fast_curves_are_halved_and_too_fast_ones_refused():
    """Lines of a plane at constant rates, where bases do not turn."""
    t = np.linspace(0.0, 1.0, 5)

    def circle(rate):
        return lambda times: rate * np.stack([-np.sin(rate * times), np.cos(rate * times)], axis=-1)[..., None]

    found = turning.Turning(circle(200.0), 0.0, np.array([0.0]), t)
    assert 500 < len(found.nodes) < 5000
    ahead = np.stack([-np.sin(200.0 * found.nodes), np.cos(200.0 * found.nodes)], axis=-1)[..., None]
    assert np.abs(found.forward(ahead)).max() == 0.0
    with pytest.raises(InvalidInputError, match=r"too fast .* point_variation"):
        turning.Turning(circle(1e6), 0.0, np.array([0.0]), t)


def test_integrals_of_turning(rng):
    """Against the closed form of a rotating rate, before and after the start, forward and transposed."""
    t = np.array([-0.4, 0.0, 0.3, 1.7, 0.3])
    rates = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    found = turning.Turning(lambda times: np.broadcast_to(rates, (len(times), 3, 2)), 0.0, np.array([0.0, 1.0]), t)
    shifts = np.zeros((len(found.nodes), 3, 2))
    shifts[:, 0, 1] = np.cos(3 * found.nodes)
    turns = found.forward(shifts)
    expected = np.sin(3 * t) / 3
    np.testing.assert_allclose(turns[:, 0, 1], expected, rtol=0, atol=1e-13)
    np.testing.assert_allclose(turns[:, 1, 0], -expected, rtol=0, atol=1e-13)
    w = rng.normal(size=turns.shape)
    assert inner(found.back(w), shifts) == pytest.approx(inner(w, turns), abs=1e-13)


@pytest.fixture
def double_precision():
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


@pytest.mark.usefixtures("double_precision")
@pytest.mark.parametrize("manifold", [Grassmann(4, 2), Grassmann(3, 1, field="complex")], ids=repr)
def test_jax(manifold, rng):
    functions = [sj.exp, sj.log, sj.riemannian_cubic, sj.cubic_initial, sj.cubic_initial, sj.cubic_spline]
    for function, (operation, data) in zip(functions, data_of(manifold, rng), strict=False):

        def on_subspaces(*data, function=function):
            return function(*data, manifold=manifold)

        np.testing.assert_allclose(on_subspaces(*data), operation.value(*data), rtol=0, atol=1e-14)
        check_grads(on_subspaces, data, order=1, modes=["fwd", "rev"], atol=1e-6, rtol=1e-6, eps=1e-5)
    _, bases, _ = data_of(manifold, rng)[5][1]
    found = sj.cubic_spline(KNOTS, bases, KNOTS, manifold=manifold)
    np.testing.assert_allclose(found, CubicSpline(KNOTS, bases, manifold=manifold)(KNOTS), rtol=0, atol=1e-14)
    one = jax.grad(lambda Y: abs(sj.log(bases[0], Y, manifold=manifold)[0, 0]))
    np.testing.assert_allclose(jax.jit(jax.vmap(one))(bases[1:])[1], one(bases[2]), rtol=0, atol=1e-13)


def test_manifolds_that_do_not_fit():
    Y = np.eye(4)[:, :2]
    V = np.zeros((4, 2))
    np.testing.assert_array_equal(sj.exp(Y, V, manifold=Stiefel(4, 2)), sj.exp(Y, V))
    with pytest.raises(InvalidInputError, match="canonical metric"):
        sj.exp(Y, V, manifold=Stiefel(4, 2, metric="euclidean"))
    with pytest.raises(InvalidInputError, match=r"has no points of shape \(4, 2\)"):
        sj.log(Y, Y, manifold=Grassmann(4, 1))
    for one, other in ((Y + 0j, Y), (Y, Y + 0j)):
        with pytest.raises(InvalidInputError, match="no complex points"):
            sj.log(one, other, manifold=Grassmann(4, 2))
    with pytest.raises(InvalidInputError, match="N >= 2"):
        sj.cubic_spline(KNOTS[:0], np.zeros((0, 4, 2)), 0.1, manifold=Grassmann(4, 2))
    with pytest.raises(TypeError, match="expected a Stiefel or a Grassmann, found tuple"):
        sj.log(Y, Y, manifold=(4, 2))
    with pytest.raises(InvalidInputError, match=r"V: not horizontal: \|Y\^H V\| = 0.5"):
        sj.exp(Y, 0.5 * Y, manifold=Grassmann(4, 2))
