"""Derivatives of splines with respect to their data, compared with differences; gradients, with derivatives."""

import numpy as np
import pytest

from stiefel_rs import CubicSpline, InvalidInputError, OutsideDomainError, RiemannianCubic, Stiefel, load

T = np.array([0.0, 0.7, 1.9, 2.4, 3.5])
SHAPES = [(3, 1), (3, 2), (3, 3), (5, 2), (20, 2)]
ENDS = ["natural", "clamped", "periodic", "velocities", "accelerations"]


def tangent_part(S, Y):
    G = np.swapaxes(S, -1, -2) @ Y
    return Y - S @ (G + np.swapaxes(G, -1, -2)) / 2


class Family:
    """Data that depend on one parameter, and their derivatives at 0."""

    def __init__(self, shape, ends, rng):
        self.M, self.ends = Stiefel(*shape), ends
        points = [self.M.random_point(rng)]
        for _ in T[1:]:
            V = self.M.random_tangent(points[-1], rng)
            points.append(self.M.exp(points[-1], V * (0.5 / self.M.norm(points[-1], V))))
        self.S = np.stack(points)
        self.dS = np.stack([self.tangent(S, rng) for S in points])
        if ends == "periodic":
            self.S[-1], self.dS[-1] = self.S[0], self.dS[0]
        self.dt = rng.uniform(-0.3, 0.3, len(T))
        self.V = [self.M.random_tangent(S, rng) for S in (self.S[0], self.S[-1])]
        self.shifts = rng.standard_normal((2, *shape)) / np.sqrt(np.prod(shape))

    def tangent(self, S, rng):
        """Of length 1: truncation errors of differences grow with its fifth power."""
        V = self.M.random_tangent(S, rng)
        return V / self.M.norm(S, V)

    def at(self, h, **options):
        S = self.M.exp(self.S, h * self.dS)
        if self.ends == "periodic":
            S[-1] = S[0]
        bc_type = self.ends
        if self.ends in {"velocities", "accelerations"}:
            order = 1 + (self.ends == "accelerations")
            vectors = [tangent_part(S[i], self.V[i] + h * self.shifts[i]) for i in (0, -1)]
            bc_type = tuple((order, V) for V in vectors)
        return CubicSpline(T + h * self.dt, S, bc_type, extrapolate=True, **options)

    @property
    def dbc(self):
        if self.ends not in {"velocities", "accelerations"}:
            return None
        changes = []
        for i in (0, -1):
            inner = self.dS[i].T @ self.V[i] + self.S[i].T @ self.shifts[i]
            changes.append(self.shifts[i] - self.S[i] @ (inner + inner.T) / 2)
        return tuple(changes)

    def product(self, gradient):
        GS, Gt, Gbc = gradient
        total = np.sum(GS * self.dS) + Gt @ self.dt
        for G, d in zip(Gbc, self.dbc or (0.0, 0.0), strict=True):
            total += 0.0 if G is None else np.sum(G * d)
        return total


def difference(f, h=2e-3):
    """The derivative by central differences of fourth order."""
    return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)


@pytest.fixture(params=SHAPES, ids=str)
def shape(request):
    return request.param


@pytest.mark.parametrize("ends", ENDS)
def test_points_and_cost_change_as_differences(shape, ends, rng):
    family = Family(shape, ends, rng)
    curve = family.at(0.0)
    t = np.array([[0.3, 2.0], [1.0, 3.2]])
    found = curve.point_variation(t, family.dS, family.dt, family.dbc)
    assert found.shape == (2, 2, *shape)
    expected = difference(lambda h: family.at(h)(t))
    # Splines are solved to 1e-12, which is divided by the step; and the fifth derivative times 5e-13.
    assert np.abs(found - expected).max() < 1e-8 * (1 + np.abs(expected).max())
    W = rng.standard_normal(found.shape)
    gradient = curve.point_pullback(t, W)
    assert gradient[0].shape == curve.points.shape
    assert gradient[1].shape == T.shape
    assert [G is None for G in gradient[2]] == [ends in {"natural", "periodic"}] * 2
    assert family.product(gradient) == pytest.approx(np.sum(W * found), rel=1e-9, abs=1e-9)
    rate = difference(lambda h: family.at(h).cost())
    assert family.product(curve.cost_gradient()) == pytest.approx(rate, rel=1e-8, abs=1e-8)


def test_times_stay_by_default(rng):
    family = Family((3, 3), "natural", rng)
    curve = family.at(0.0)
    whole = curve.point_variation(1.0, family.dS, 0 * family.dt, (None, None))
    np.testing.assert_array_equal(curve.point_variation(1.0, family.dS), whole)


def test_a_stored_spline_has_the_same_derivatives(rng, tmp_path):
    family = Family((4, 2), "velocities", rng)
    curve = family.at(0.0)
    curve.save(tmp_path / "curve.npz")
    again = load(tmp_path / "curve.npz")
    for one, other in zip(curve.cost_gradient()[:2], again.cost_gradient()[:2], strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_is_refused(rng):
    family = Family((3, 2), "natural", rng)
    curve, dS = family.at(0.0), family.dS
    for call, problem in [
        (lambda: family.at(0.0, kind="geometric").cost_gradient(), "kind='riemannian'"),
        (lambda: curve.point_variation(1.0, dS[1:]), "dS: expected shape a matrix for each of 5 knots"),
        (lambda: curve.point_variation(1.0, dS, family.dt[1:]), "dt: expected shape one for each of 5 knots"),
        (lambda: curve.point_variation(1.0, dS, 0.5), r"dt: expected shape \(N,\)"),
        (lambda: curve.point_variation(1.0, dS + family.S), "knot 0.*dS"),
        (lambda: curve.point_variation(1.0, dS, None, (dS[0], None)), "no vector is given"),
        (lambda: curve.point_variation(1.0, dS, None, dS[:1]), "dbc: expected a pair"),
        (lambda: curve.point_pullback([1.0, 2.0], dS), r"W: expected shape \(2, 3, 2\)"),
    ]:
        with pytest.raises(InvalidInputError, match=problem):
            call()
    closed = Family((3, 2), "periodic", rng)
    closed.dS[-1] = 0.0
    with pytest.raises(InvalidInputError, match=r"knot 4.*periodic"):
        closed.at(0.0).point_variation(1.0, closed.dS)
    loose = CubicSpline(T, family.S, tol=0.05)
    if loose.report.residual > 1e-5:
        with pytest.raises(InvalidInputError, match="smaller tolerance"):
            loose.cost_gradient()


def test_conjugate_ends_of_a_spline():
    # At rest at both ends of a half great circle: a family of solutions.
    e = np.eye(3)
    S = np.stack([e[:, :1], -e[:, :1]])
    try:
        curve = CubicSpline([0.0, 1.0], S, "clamped")
    except OutsideDomainError:
        return
    with pytest.raises(OutsideDomainError, match="conjugate"):
        curve.point_pullback(0.5, e[:, :1])


@pytest.mark.parametrize("n", [1, 2, 3])
def test_points_that_cannot_move(n):
    curve = CubicSpline([0.0, 1.0, 3.0], np.ones((3, 1, 1)))
    GS, Gt, _ = curve.point_pullback(np.linspace(0, 3, n), np.ones((n, 1, 1)))
    assert not GS.any()
    assert not Gt.any()


# Above 64 dimensions by products with the derivative.
@pytest.mark.parametrize("shape", [(1, 1), (3, 1), (4, 2), (3, 3), (20, 2), (20, 5)])
def test_gradients_of_single_cubics(shape, rng):
    M = Stiefel(*shape)
    S = M.random_point(rng)
    V, A, J = (M.random_tangent(S, rng) for _ in range(3))
    curve = RiemannianCubic.from_initial(S, V, A, J)
    t = np.array([1.0, 0.2, -0.3, 0.7])
    W = rng.standard_normal((4, *shape))
    S1, V1 = curve(1.0), curve(1.0, 1)

    def change(S, V, dS):
        Y = rng.standard_normal(shape)
        inner = dS.T @ V + S.T @ Y
        return Y - S @ (inner + inner.T) / 2

    dS, dS1 = M.random_tangent(S, rng), M.random_tangent(S1, rng)
    ends = dS, change(S, V, dS), dS1, change(S1, V1, dS1)
    starts = dS, *(change(S, Y, dS) for Y in (V, A, J))
    for variation, pullback, data in [
        (curve.point_variation, curve.point_pullback, ends),
        (curve.initial_point_variation, curve.initial_point_pullback, starts),
    ]:
        products = [np.sum(G * d) for G, d in zip(pullback(t, W), data, strict=True)]
        assert sum(products) == pytest.approx(np.sum(W * variation(t, *data)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("bc_type", ["natural", "clamped", ("natural", "natural")])
def test_short_units_of_time(bc_type):
    """Vectors that vanish at the ends have round-off that is large in a short unit of time."""
    M, rng = Stiefel(4, 2), np.random.default_rng(0)
    S = [M.random_point(rng)]
    for _ in range(3):
        S.append(M.exp(S[-1], 0.4 * M.random_tangent(S[-1], rng)))
    S, t = np.stack(S), np.array([0, 0.8, 1.5, 3.0])
    dS = np.stack([M.project_tangent(point, rng.standard_normal((4, 2))) for point in S])
    expected = CubicSpline(t, S, bc_type).point_variation(0.5, dS)
    for unit in (1e-4, 1e-9, 1e-100):
        found = CubicSpline(unit * t, S, bc_type).point_variation(0.5 * unit, dS)
        assert np.abs(found - expected).max() < 1e-12
