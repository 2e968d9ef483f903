"""Errors of geodesics, cubics and splines of complex frames and of subspaces, as stated in `docs/accuracy.md`."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
import scipy.interpolate

from benchmarks.accuracy import __main__ as page_of
from benchmarks.accuracy import curve_errors as errors
from benchmarks.accuracy.curve_cases import curve_cases, random_cubic
from benchmarks.accuracy.fixed_point import embedded
from benchmarks.accuracy.frame_cases import frame, frame_cases, name_of, subspace, subspace_cases
from benchmarks.accuracy.frame_errors import Reference, ShotErrors, measure
from benchmarks.accuracy.frame_reference import singular_values
from benchmarks.accuracy.torus import Torus
from benchmarks.environment import ROOT
from stiefel_rs import GeometricCubic, Grassmann, Stiefel

# Those with 200 rows take seconds.
SHOTS = [shot for shot in frame_cases() + subspace_cases() if shot.manifold.n < 100]
MANIFOLDS = [Stiefel(4, 2, field="complex"), Stiefel(5, 3), Grassmann(4, 2, field="complex"), Grassmann(5, 2)]
each_manifold = pytest.mark.parametrize("M", MANIFOLDS, ids=name_of)


def identifier(case):
    kind = getattr(case, "kind", "geodesic")
    return f"{kind}, {case.name}, {name_of(case.manifold)}"


def difference(reference, X, expected):
    """Largest difference between an embedded matrix of integers and one of mpmath."""
    n, k = expected.rows, expected.cols
    scale = mpmath.mpf(2) ** reference.F.bits
    top, low = (X[:n, :k], X[n:, :k]) if reference.complex else (X, 0 * X)
    pairs = ((i, j) for i in range(n) for j in range(k))
    return max(abs(mpmath.mpc(int(top[i, j]), int(low[i, j])) / scale - expected[i, j]) for i, j in pairs)


def projected(reference):
    """The exact point and velocity of a reference as matrices of mpmath."""
    scale = mpmath.mpf(2) ** reference.F.bits
    n, k = reference.shot.point.shape

    def entry(X, i, j):
        low = int(X[n + i, j]) if reference.complex else 0
        return mpmath.mpc(int(X[i, j]), low) / scale

    return (
        mpmath.matrix([[entry(X, i, j) for j in range(k)] for i in range(n)])
        for X in (reference.point, reference.velocity)
    )


@pytest.mark.parametrize("n,k", [(2, 1), (3, 2), (2, 2)])
def test_reference_geodesic_of_frames_agrees_with_mpmath(n, k):
    """With the exponential of matrices of size n."""
    reference = Reference(frame("random", n, k, 1.2))
    with mpmath.workdps(70):
        S, V = projected(reference)
        assert mpmath.mnorm(S.H * S - mpmath.eye(k), "f") < 1e-60
        assert mpmath.mnorm(S.H * V + V.H * S, "f") < 1e-60
        U = V - S * (S.H * V) / 2
        assert difference(reference, reference.end, mpmath.expm(U * S.H - S * U.H) * S) < 1e-60


@pytest.mark.parametrize("M", [Grassmann(4, 2), Grassmann(4, 2, field="complex"), Grassmann(3, 2)], ids=name_of)
def test_reference_geodesic_of_subspaces_agrees_with_mpmath(M):
    """With the cosines and sines of the singular values of the velocity."""
    reference = Reference(subspace("angles", M, [1.1, 0.3][: M.n - M.k]))
    with mpmath.workdps(70):
        Y, V = projected(reference)
        Q, angles, Wh = mpmath.svd_c(V, full_matrices=False)
        cos, sin = (mpmath.diag([f(x) for x in angles]) for f in (mpmath.cos, mpmath.sin))
        assert difference(reference, reference.end, (Y * Wh.H * cos + Q * sin) * Wh) < 1e-60
        assert np.abs(singular_values(reference.shot.velocity) - np.array(list(map(float, angles)))).max() < 1e-15


@pytest.mark.parametrize("shot", SHOTS, ids=identifier)
def test_geodesic_and_logarithm(shot):
    found, bounds = measure(Reference(shot)), ShotErrors.bounds(shot)
    assert not found.above(bounds), f"{found} against {bounds}"


def test_errors_of_geodesics_are_seen():
    shot = frame("random", 4, 2, 0.5)
    reference, wrong = Reference(shot), Reference(replace(shot, velocity=shot.velocity * (1 + 1e-12)))
    reference.end, reference.velocity = wrong.end, wrong.velocity
    found = measure(reference)
    assert found.above(ShotErrors.bounds(shot)) == ["exp", "log"]
    assert found.log == pytest.approx(1e-12 * np.linalg.norm(shot.velocity), rel=1e-2)
    reference.target = wrong.target
    assert measure(reference).above(ShotErrors.bounds(shot)) == ["exp"]


def smooth(M, t):
    """A curve of frames, or of bases that do not turn in their subspace, with its derivative, by a formula."""
    torus = Torus.of(M, dense=True)
    angles = np.outer(np.sin(t), np.arange(1, torus.dim + 1)) / 3
    rates = np.outer(np.cos(t), np.arange(1, torus.dim + 1)) / 3
    return torus.at(angles), torus.velocity(angles, rates)


@pytest.mark.parametrize("M", [M for M in MANIFOLDS if M != Stiefel(5, 3)], ids=name_of)
def test_torus(M):
    t, h = np.array([0.3, 1.1]), 1e-3
    S, V = smooth(M, t)
    M.check_point(S)
    M.check_tangent(S, V)
    far, near = (smooth(M, t + s * h)[0] - smooth(M, t - s * h)[0] for s in (2, 1))
    assert np.abs((8 * near - far) / (12 * h) - V).max() < 1e-11
    torus = Torus.of(M, dense=True)
    exact = scipy.interpolate.CubicSpline(np.arange(4.0), np.random.default_rng(1).standard_normal((4, torus.dim)))
    x, weights = np.polynomial.legendre.leggauss(8)
    times = (np.arange(3)[:, None] + (x + 1) / 2).ravel()
    points, second = torus.at(exact(times)), torus.velocity(exact(times), exact(times, 2))
    squares = errors.norm(M, points, second) ** 2
    assert torus.cost(exact) == pytest.approx(np.tile(weights / 2, 3) @ squares, rel=1e-12)


@each_manifold
def test_formulas_of_the_equation(M, rng):
    """Norm and curvature by the manifold itself; the connection by parallel transport."""
    S = M.random_point(rng)
    A, V, W = (M.random_tangent(S, rng) for _ in range(3))
    assert errors.norm(M, S, V) == pytest.approx(M.norm(S, V), rel=1e-14)
    assert np.abs(errors.curvature(M, S, A, V) - M.curvature(S, A, V, V)).max() < 1e-12 * np.linalg.norm(V) ** 2
    h = 1e-3
    moved = [M.transport(S, s * h * V, W) for s in (-2, -1, 1, 2)]
    slope = (8 * (moved[2] - moved[1]) - (moved[3] - moved[0])) / (12 * h)
    # A parallel field.
    assert np.abs(slope + errors.connection(M, S, V, W)).max() < 1e-8


@pytest.mark.parametrize("problem", curve_cases(), ids=identifier)
def test_cubic_or_spline(problem):
    found, bounds = errors.curve_errors(problem, errors.solve(problem)), errors.CurveErrors.bounds()
    assert not found.above(bounds), f"{found} against {bounds}"


@each_manifold
def test_other_curves_do_not_solve_the_equation(M):
    problem = random_cubic(M)
    (S0, S1), (V0, V1) = problem.points, problem.velocities
    assert errors.equation(M, GeometricCubic(S0, V0, S1, V1, manifold=M)) > 1e-4


def test_embedded_frames_have_the_same_errors():
    """An embedding in real frames of twice the size, as a second reference: costs are halved."""
    problem = random_cubic(Stiefel(4, 2, field="complex"))
    points, velocities = (np.stack([embedded(x) for x in part]) for part in (problem.points, problem.velocities))
    real = replace(problem, manifold=Stiefel(8, 4), points=points, velocities=velocities)
    curve, other = errors.solve(problem), errors.solve(real)
    assert np.abs(embedded(curve(0.4)) - other(0.4)).max() < 1e-11
    assert curve.cost() == pytest.approx(other.cost() / 2, rel=1e-11)
    assert errors.equation(real.manifold, other) < 1e-12


def test_committed_page_has_all_sections_and_lines():
    parts = page_of.split((ROOT / "docs" / "accuracy.md").read_text())
    assert list(parts) == ["", *page_of.SECTIONS]
    assert list(page_of.split(page_of.TEMPLATE.read_text())) == list(parts)
    *_, frames, subspaces, curves = parts.values()
    for text, cases in ((frames, frame_cases()), (subspaces, subspace_cases()), (curves, curve_cases())):
        rows = [line for line in text.splitlines() if "St(" in line or "Gr(" in line]
        table = [line for line in rows if line.startswith("|")]
        assert len(table) == len(cases)
        assert all(
            case.name in line and name_of(case.manifold) in line for case, line in zip(cases, table, strict=True)
        )


def test_a_run_of_some_sections_keeps_the_others(monkeypatch):
    fields = {heading: (lambda: {"table": "| new |", "skewness": "0"}) for heading in page_of.SECTIONS}
    monkeypatch.setattr(page_of, "SECTIONS", fields)
    whole = page_of.page()
    old = whole.replace("| new |", "| old |")
    found = page_of.split(page_of.page(["subspaces"], old))
    renewed = [heading for heading, part in found.items() if "| new |" in part]
    assert renewed == [heading for heading in page_of.SECTIONS if "subspaces" in heading]
    assert page_of.page(["subspaces"], whole) == whole
    # A section that the page does not have yet.
    assert page_of.page(["nothing"], "") == whole
