"""Figures of complex frames and of subspaces: what is drawn are the numbers of the curve."""

import numpy as np
import pytest

from stiefel_rs import CubicSpline, Grassmann, InvalidInputError, RiemannianCubic, Stiefel, integrate_cubic

pytest.importorskip("matplotlib")

from stiefel_rs import plotting

T = np.arange(4.0)


def spline(M, seed=1):
    """A spline through points of a manifold, each 0.4 from the previous one."""
    rng = np.random.default_rng(seed)
    points = [M.random_point(rng)]
    while len(points) < len(T):
        V = M.random_tangent(points[-1], rng)
        points.append(M.exp(points[-1], 0.4 * V / M.norm(points[-1], V)))
    return CubicSpline(T, points, manifold=M)


def lines(ax):
    return {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}


@pytest.mark.parametrize("C", [Stiefel, Grassmann])
@pytest.mark.parametrize(("n", "k"), [(2, 1), (3, 1), (3, 2)])
def test_few_complex_entries_are_drawn_by_their_parts(C, n, k):
    curve = spline(C(n, k, field="complex"))
    ax = curve.plot()
    drawn = lines(ax)
    assert len(drawn) == 2 * n * k
    for name, part in (("Re", np.real), ("Im", np.imag)):
        for i, j in np.ndindex(n, k):
            line = drawn[f"{name} S[{i}, {j}]"]
            np.testing.assert_array_equal(line.get_ydata(), part(curve(line.get_xdata())[:, i, j]))
    rings = [line for line in ax.lines if line.get_marker() == "o"]
    assert len(rings) == 2 * n * k
    np.testing.assert_array_equal(rings[0].get_xdata(), T)


@pytest.mark.parametrize("C", [Stiefel, Grassmann])
@pytest.mark.parametrize("field", ["real", "complex"])
def test_tall_ones_by_angles_entries_and_lengths(C, field):
    M = C(40, 3, field=field)
    curve = spline(M)
    angles, picture, speed, acceleration = plotting.overview(curve)
    line = lines(angles)["column 2"]
    at = curve(line.get_xdata())
    cosine = np.real(np.sum(np.conj(at[0, :, 1]) * at[:, :, 1], axis=-1))
    np.testing.assert_allclose(line.get_ydata(), np.degrees(np.arccos(np.clip(cosine, -1, 1))), atol=2e-6)
    shown = np.asarray(picture.images[0].get_array())
    assert shown.shape[0] == (120 if field == "real" else 240)
    # The columns of the frame one above the other, each with its imaginary parts below the real ones.
    first = curve(curve.t_span[0])
    parts = np.concatenate([first.real, first.imag]) if field == "complex" else first
    np.testing.assert_allclose(shown[:, 0], parts.T.ravel(), atol=1e-12)
    for ax, vectors in ((speed, curve.velocity), (acceleration, curve.acceleration)):
        t, length = ax.lines[0].get_data()
        np.testing.assert_allclose(length, M.norm(curve(t), vectors(t)), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("field", ["real", "complex"])
def test_a_spline_with_its_lengths(field):
    for C in (Stiefel, Grassmann):
        left, speed, _ = plotting.spline(spline(C(3, 2, field=field)))
        assert (left.name == "3d") == (field == "real")
        assert len(speed.lines[0].get_xdata()) > 100


def test_trajectories_arrays_and_errors():
    M = Stiefel(3, 2, field="complex")
    S, rng = M.random_point(0), np.random.default_rng(2)
    V, A, J = (M.random_tangent(S, rng) for _ in range(3))
    trajectory = integrate_cubic(S, V, A, J, 5)
    for ax in (plotting.plot(trajectory), plotting.plot(trajectory.point)):
        np.testing.assert_array_equal(lines(ax)["Im S[2, 1]"].get_ydata(), trajectory.point[:, 2, 1].imag)
    plotting.energy(trajectory)
    curves = [RiemannianCubic.from_initial(S, V, factor * A, J) for factor in (1.0, 1.01)]
    t, distance = plotting.error(*curves).lines[0].get_data()
    expected = np.linalg.norm(curves[0](t) - curves[1](t), axis=(1, 2))
    np.testing.assert_array_equal(distance[1:], expected[1:])


@pytest.mark.parametrize("draw", [plotting.sphere, plotting.frame, plotting.body_frame])
def test_pictures_in_space_are_those_of_real_frames(draw):
    n, k = (3, 1) if draw is plotting.sphere else (3, 2)
    for drawn in (spline(Stiefel(n, k, field="complex")), np.ones((2, n, k)) * 1j):
        with pytest.raises(InvalidInputError, match=rf"expected, found St\({n},{k},C\)"):
            draw(drawn)
