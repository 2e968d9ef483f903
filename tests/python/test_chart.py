"""The paper's charts compared with formulas in NumPy, differences, and 40-digit reference curves."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from stiefel_rs import Chart, Stiefel

EPS = np.finfo(float).eps
CHARTS = {"sphere": Chart.sphere(), "frame": Chart.frame()}
CUBICS = json.loads((Path(__file__).parents[1] / "data" / "cubics.json").read_text())

# The paper's initial coordinate derivatives, up to the third.
PAPER = {
    "sphere": ([np.pi / 2, np.pi], [0.1, 0.2], [1.0, 0.5], [0.1, 0.2]),
    "frame": ([np.pi / 4, np.pi, np.pi], [0.1, 0.1, 0.05], [1.0, 0.3, 0.5], [0.1, 0.1, 0.05]),
}


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


def embedding(q):
    theta, phi = q[:2]
    st, ct, sf, cf = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    e_r, e_theta, e_phi = np.array([[st * cf, st * sf, ct], [ct * cf, ct * sf, -st], [-sf, cf, 0.0]])
    if len(q) == 2:
        return e_r[:, None]
    return np.stack([e_r, np.cos(q[2]) * e_theta + np.sin(q[2]) * e_phi], axis=1)


def metric(q):
    s, c = np.sin(q[0]), np.cos(q[0])
    if len(q) == 2:
        return np.diag([1.0, s**2])
    return np.array([[1.0, 0, 0], [0, 1.0, c], [0, c, 1.0]])


def christoffel(q):
    """Gamma[k, i, j] from the derivative of the metric; only the derivative with respect to theta is nonzero."""
    d, s, c = len(q), np.sin(q[0]), np.cos(q[0])
    dg = np.zeros((d, d, d))  # dg[l, i, j] = d g_ij / d q_l
    dg[0] = np.diag([0.0, 2 * s * c]) if d == 2 else np.array([[0.0, 0, 0], [0, 0, -s], [0, -s, 0]])
    lower = (np.einsum("jli->lij", dg) + np.einsum("ilj->lij", dg) - dg) / 2
    return np.einsum("kl,lij->kij", np.linalg.inv(metric(q)), lower)


def hamiltonian(z):
    """The two Hamiltonians in the closed form of docs/mathematics.md."""
    d = len(z) // 4
    q, v, p, m = z.reshape(4, d)
    s, c = np.sin(q[0]), np.cos(q[0])
    if d == 2:
        H = p @ v + m[0] ** 2 / 2 + m[1] ** 2 / (2 * s**2)
        return H + s * c * v[1] ** 2 * m[0] - 2 * (c / s) * v[0] * v[1] * m[1]
    H = p @ v + m[0] ** 2 / 2 + (m[1] ** 2 - 2 * c * m[1] * m[2] + m[2] ** 2) / (2 * s**2)
    H -= s * v[1] * v[2] * m[0]
    H -= v[0] * v[1] * (c / s * m[1] - m[2] / s)
    return H - v[0] * v[2] * (c / s * m[2] - m[1] / s)


def difference(f, x, h=1e-3):
    """The derivative of f at x by fourth-order central differences, last axis the direction."""
    columns = []
    for e in np.eye(len(x)):
        near, far = f(x + h * e) - f(x - h * e), f(x + 2 * h * e) - f(x - 2 * h * e)
        columns.append((8 * near - far) / (12 * h))
    return np.stack(columns, axis=-1)


@pytest.fixture(params=CHARTS)
def name(request):
    return request.param


@pytest.fixture
def chart(name):
    return CHARTS[name]


@pytest.fixture
def z0(name, chart):
    q, v, a, j = PAPER[name]
    return np.concatenate([q, v, *chart.momenta(q, v, a, j)])


@pytest.fixture
def states(chart, rng):
    z = rng.standard_normal((2, 5, 4 * chart.d))
    z[..., 0] = rng.uniform(0.4, 2.7, (2, 5))
    return z


def test_attributes(chart, name):
    assert (chart.d, chart.k) == ((2, 1) if name == "sphere" else (3, 2))
    assert repr(chart) == f"Chart.{name}()"
    assert chart == getattr(Chart, name)()
    assert hash(chart) == hash(getattr(Chart, name)())
    assert Chart.sphere() != Chart.frame()


def test_embed(chart, states):
    q, v = states[..., : chart.d], states[..., chart.d : 2 * chart.d]
    S = chart.embed(q)
    assert S.shape == (2, 5, 3, chart.k)
    assert_close(S, [[embedding(x) for x in row] for row in q], 8 * EPS, "embedding")
    Stiefel(3, chart.k).check_point(S, atol=8 * EPS)
    V = chart.embed_velocity(q, v)
    for i in np.ndindex(2, 5):
        exact = difference(embedding, q[i]) @ v[i]
        # Truncation h^4/30, round-off eps/h.
        assert_close(V[i], exact, 1e-11 * (1 + np.abs(v[i]).sum()), "embedded velocity")


def test_chart_metric_is_the_canonical_metric(chart, states):
    d = chart.d
    q, v, w = states[..., :d], states[..., d : 2 * d], states[..., 2 * d : 3 * d]
    inner = Stiefel(3, chart.k).inner(chart.embed(q), chart.embed_velocity(q, v), chart.embed_velocity(q, w))
    exact = np.array([[b @ metric(a) @ c for a, b, c in zip(*row, strict=True)] for row in zip(q, v, w, strict=True)])
    assert_close(inner, exact, 64 * EPS * np.abs(v).max() * np.abs(w).max() * d, "pulled-back metric")


def test_hamiltonian_is_its_closed_form(chart, states):
    H = chart.hamiltonian(states)
    assert H.shape == (2, 5)
    for i in np.ndindex(2, 5):
        z = states[i]
        q, v, p, m = z.reshape(4, chart.d)
        size = 1 + np.abs(z).max() ** 3 / np.sin(z[0]) ** 2
        assert_close(H[i], hamiltonian(z), 32 * EPS * size, "Hamiltonian in closed form")
        g = np.linalg.inv(metric(q))
        general = p @ v + m @ g @ m / 2 - np.einsum("kij,i,j,k", christoffel(q), v, v, m)
        assert_close(H[i], general, 64 * EPS * size, "Hamiltonian from metric and Christoffel symbols")


def test_gradient_and_hessian(chart, states):
    G, D = chart.gradient(states), chart.hessian(states)
    assert G.shape == (2, 5, 4 * chart.d)
    assert D.shape == (2, 5, 4 * chart.d, 4 * chart.d)
    assert_close(D, np.swapaxes(D, -1, -2), 0.0, "symmetry of the Hessian")
    for i in np.ndindex(2, 5):
        # Truncation h^4 times fifth derivatives, which grow as sin(theta)^-7.
        bound = 1e-9 * (1 + np.abs(states[i]).max() ** 3) / np.sin(states[i][0]) ** 7
        assert_close(G[i], difference(hamiltonian, states[i]), bound, "gradient")
        assert_close(D[i], difference(chart.gradient, states[i]), bound, "Hessian")


def test_equator_is_no_singularity(chart):
    # The paper's frame Hamiltonian divides by cos(theta).
    z = np.linspace(0.3, 1.2, 4 * chart.d)
    z[0] = np.pi / 2
    for values in [chart.hamiltonian(z), chart.gradient(z), chart.hessian(z)]:
        assert np.isfinite(values).all()
    assert_close(chart.hamiltonian(z), hamiltonian(z), 64 * EPS, "Hamiltonian at theta = pi/2")


def test_momenta_and_derivatives_are_inverse(chart, states):
    q, v, a, j = np.split(states, 4, axis=-1)
    p, m = chart.momenta(q, v, a, j)
    assert p.shape == m.shape == q.shape
    back = chart.derivatives(np.concatenate([q, v, p, m], axis=-1))
    for what, measured, exact in zip(["q", "qdot", "qddot", "qdddot"], back, (q, v, a, j), strict=True):
        size = (1 + np.abs(states).max() ** 3) / np.sin(q[..., 0]).min() ** 4
        assert_close(measured, exact, 64 * EPS * size, what)


def test_momenta_of_a_polynomial_curve(chart, states):
    # m = g (a + Gamma(v, v)) along q + v t + a t^2/2 + j t^3/6; p from its time derivative.
    for z in states[0]:
        q, v, a, j = z.reshape(4, chart.d)

        def momentum(t, q=q, v=v, a=a, j=j):
            x, dx, ddx = q + t * (v + t * (a / 2 + t * j / 6)), v + t * (a + t * j / 2), a + t * j
            return metric(x) @ (ddx + np.einsum("kij,i,j", christoffel(x), dx, dx))

        rate = difference(lambda t: momentum(t[0]), np.zeros(1))[:, 0]
        m = momentum(0.0)
        p = 2 * np.einsum("kij,j,k->i", christoffel(q), v, m) - rate
        size = (1 + np.abs(z).max() ** 3) / np.sin(q[0]) ** 7
        measured = chart.momenta(q, v, a, j)
        assert_close(measured[1], m, 64 * EPS * size, "p_qdot")
        assert_close(measured[0], p, 1e-9 * size, "p_q")


def test_derivatives_are_those_of_the_flow(chart, z0):
    h = 1e-2
    t = h * np.arange(-3, 4)
    q = chart.reference(z0, t)[:, : chart.d]
    exact = chart.derivatives(z0)
    second = np.array([2, -27, 270, -490, 270, -27, 2]) @ q / (180 * h**2)
    third = np.array([1, -8, 13, 0, -13, 8, -1]) @ q / (8 * h**3)
    # Truncation h^6/560 and 7 h^4/120, round-off eps/h^2 and eps/h^3.
    assert_close(exact[2], second, 1e-10, "qddot")
    assert_close(exact[3], third, 1e-7, "qdddot")


@pytest.mark.parametrize(("map_name", "order"), [("initial_point", 1), ("midpoint", 2)])
def test_order_of_the_integrators(chart, z0, map_name, order):
    exact = chart.reference(z0, [1.0])[0]
    steps = 40 * 2 ** np.arange(5)
    errors = [np.linalg.norm(chart.integrate(z0, int(n), map=map_name)[-1] - exact) for n in steps]
    slopes = np.diff(np.log2(errors))
    assert np.abs(slopes + order).max() < 0.2, f"slopes {slopes} of errors {errors}, expected {-order}"


@pytest.mark.parametrize("map_name", ["initial_point", "midpoint"])
def test_one_step_is_symplectic(chart, z0, map_name):
    jacobian = difference(lambda z: chart.integrate(z, 1, 0.1, map_name)[-1], z0)
    zero, one = np.zeros((2 * chart.d,) * 2), np.eye(2 * chart.d)
    omega = np.block([[zero, one], [-one, zero]])
    # The Jacobian by differences carries h^4 and eps/h, about 1e-11.
    assert_close(jacobian.T @ omega @ jacobian, omega, 1e-9, "J^T Omega J - Omega")


def test_integrate_is_the_documented_method(chart, z0):
    # q1 = q0 + h H_p(q0, p1), p1 = p0 - h H_q(q0, p1); and the implicit midpoint rule.
    d, h = 2 * chart.d, 0.05
    for map_name in ["initial_point", "midpoint"]:
        path = chart.integrate(z0, 4, 0.2, map_name)
        assert path.shape == (5, 2 * d)
        assert np.array_equal(path[0], z0)
        for a, b in itertools.pairwise(path):
            middle = np.concatenate([a[:d], b[d:]]) if map_name == "initial_point" else (a + b) / 2
            G = chart.gradient(middle)
            exact = a + h * np.concatenate([G[d:], -G[:d]])
            assert_close(b, exact, 64 * EPS * (1 + np.abs(G).max()), f"defect of a {map_name} step")


def test_midpoint_is_reversible(chart, z0):
    there = chart.integrate(z0, 20, map="midpoint")
    back = chart.integrate(there[-1], 20, -1.0, "midpoint")
    assert_close(back[-1], z0, 1e-12, "there and back again")


def test_batches_of_initial_states(chart, z0):
    batch = z0 + 0.01 * np.arange(6).reshape(2, 3, 1)
    path = chart.integrate(batch, 7, map="midpoint")
    exact = chart.reference(batch, [[0.0, 0.5]])
    assert path.shape == (2, 3, 8, 4 * chart.d)
    assert exact.shape == (2, 3, 1, 2, 4 * chart.d)
    for i in np.ndindex(2, 3):
        assert np.array_equal(path[i], chart.integrate(batch[i], 7, map="midpoint")), f"member {i}"
        assert np.array_equal(exact[(*i, 0)], chart.reference(batch[i], [0.0, 0.5])), f"member {i}"
    assert chart.integrate(np.zeros((0, 4 * chart.d)), 3).shape == (0, 4, 4 * chart.d)
    assert chart.reference(z0, []).shape == (0, 4 * chart.d)
    assert chart.reference(z0, 0.5).shape == (4 * chart.d,)


def test_reference_takes_times_in_any_order(chart, z0):
    t = [1.0, -0.5, 0.0, 0.25, 1.0]
    z = chart.reference(z0, t)
    assert np.array_equal(z[2], z0)
    assert np.array_equal(z[0], z[4])
    assert_close(chart.reference(z[1], [0.5])[0], z0, 1e-13, "back from -0.5")


def covariant_state(chart, S, V, A, J):
    """The chart state of a cubic from point, velocity, covariant acceleration and jerk."""
    theta, phi = np.arccos(S[2, 0]), np.arctan2(S[1, 0], S[0, 0])
    q = [theta, phi]
    if chart.k == 2:
        e = embedding([theta, phi, 0.0])[:, 1], embedding([theta, phi, np.pi / 2])[:, 1]
        q.append(np.arctan2(e[1] @ S[:, 1], e[0] @ S[:, 1]))
    columns = np.stack([chart.embed_velocity(q, e).ravel() for e in np.eye(chart.d)], axis=1)
    v, a, j = (np.linalg.lstsq(columns, x.ravel(), rcond=None)[0] for x in (V, A, J))
    m = metric(q) @ a
    # d/dt m = g j + Gamma(v, .) m, covariant derivative of a covector.
    p = np.einsum("kij,j,k->i", christoffel(q), v, m) - metric(q) @ j
    return np.concatenate([q, v, p, m])


@pytest.mark.parametrize("entry", [c for c in CUBICS if c["n"] == 3], ids=lambda c: c.get("name", f"St3_{c['k']}"))
def test_reference_against_forty_digits(entry):
    chart = Chart.sphere() if entry["k"] == 1 else Chart.frame()
    initial = {what: np.array(x) for what, x in entry["initial"].items()}
    z = covariant_state(chart, *(initial[w] for w in ("point", "velocity", "acceleration", "jerk")))
    paper = entry.get("name", "").startswith("paper") and PAPER["sphere" if entry["k"] == 1 else "frame"]
    if paper:
        named = np.concatenate([paper[0], paper[1], *chart.momenta(*paper)])
        z[1 : chart.d] += 2 * np.pi * np.round((named[1 : chart.d] - z[1 : chart.d]) / (2 * np.pi))
        assert_close(z, named, 1e-15 * 8, "state from the file against the paper's coordinate data")
        z = named
    t = [0.5, 1.0]
    found = chart.reference(z, t)
    q, v = found[:, : chart.d], found[:, chart.d : 2 * chart.d]
    points, velocities = chart.embed(q), chart.embed_velocity(q, v)
    for i, at in enumerate(t):
        exact = entry["at"][str(at)]
        assert_close(points[i], exact["point"], 1e-13, f"point at {at}")
        assert_close(velocities[i], exact["velocity"], 1e-13, f"velocity at {at}")


def test_energy_is_bounded_over_a_long_run(chart):
    # Momenta of 1e-3: the speed stays below 1 over 100 units of time (16 revolutions), and the curve inside the chart.
    z = np.zeros(4 * chart.d)
    z[[0, chart.d + 1]] = np.pi / 2, 0.5
    z[[2 * chart.d, 3 * chart.d, 3 * chart.d + 1]] = 1e-3
    energy = chart.hamiltonian(z)
    worst = [np.abs(chart.hamiltonian(chart.integrate(z, n, 100.0, "midpoint")) - energy).max() for n in (4000, 8000)]
    # |H| is 2e-3; h |S'| = 0.02, whose square bounds the relative error; a secular drift would add 4000 h^3.
    assert worst[0] <= 0.02**2 * 2e-3, f"energy error {worst[0]:.3e}"
    assert abs(worst[0] / worst[1] - 4) < 0.4, f"energy error {worst[0]:.3e}, with half the step {worst[1]:.3e}"


@pytest.mark.parametrize("map_name", ["initial_point", "midpoint"])
def test_shooting_meets_its_ends(chart, z0, map_name):
    d = chart.d
    end = chart.reference(z0, [1.0])[0]
    ends = (z0[:d], z0[d : 2 * d], end[:d], end[d : 2 * d])
    result = chart.shoot(*ends, 25, map_name)
    report = result.report
    assert report.converged is True
    assert report.reason == "converged"
    assert report.iterations <= 5, f"{report!r}"
    assert report.residual <= report.tolerance == 1e-12
    path = result.trajectory
    assert path.shape == (26, 4 * d)
    assert np.array_equal(path[0, : 2 * d], z0[: 2 * d])
    assert_close(path[-1, : 2 * d], end[: 2 * d], 1e-12, "end of the trajectory")
    assert np.array_equal(np.concatenate(result.momenta), path[0, 2 * d :])
    assert np.array_equal(chart.integrate(path[0], 25, map=map_name), path), "shooting is the discrete flow"
    again = chart.shoot(*ends, 25, map_name, guess=result.momenta)
    assert again.report.iterations == 0, f"from its own solution: {again.report!r}"


def test_guess_may_be_any_pair(chart, z0):
    d = chart.d
    ends = (z0[:d], z0[d : 2 * d], z0[:d] + 0.1, z0[d : 2 * d])
    momenta = chart.shoot(*ends, 10).momenta
    for guess in [tuple(momenta), [list(p) for p in momenta], np.array(momenta)]:
        assert chart.shoot(*ends, 10, guess=guess).report.iterations == 0, f"{type(guess).__name__} as a guess"


def test_shooting_over_another_time(chart, z0):
    d = chart.d
    end = chart.integrate(z0, 16, 0.6, "midpoint")[-1]
    result = chart.shoot(z0[:d], z0[d : 2 * d], end[:d], end[d : 2 * d], 16, t_end=0.6)
    assert_close(np.concatenate(result.momenta), z0[2 * d :], 1e-9, "momenta of the discrete trajectory")
