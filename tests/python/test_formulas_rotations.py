"""The formulas of docs/mathematics.md for rotations and poses, compared with the package."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiefel_rs import CubicSpline, PoseSpline, RotationSpline, Stiefel

KNOTS = np.array([0.0, 0.7, 1.5, 2.1])
INSIDE = np.array([0.2, 0.9, 1.1, 1.9])
# Step of central differences of fourth order: error below 1e-9 for these curves.
STEP = 1e-3


@pytest.fixture
def rotations(rng):
    steps = Rotation.from_rotvec(0.8 * rng.standard_normal((4, 3)))
    turned = [steps[0]]
    for i in range(1, 4):
        turned.append(turned[-1] * steps[i])
    return Rotation.concatenate(turned)


@pytest.fixture(params=[0.0, 2.0])
def tension(request):
    return request.param


@pytest.fixture
def spline(rotations, tension):
    return RotationSpline(KNOTS, rotations.as_quat(), tension=tension)


def derivative(curve, t, h=STEP):
    return (8 * (curve(t + h) - curve(t - h)) - (curve(t + 2 * h) - curve(t - 2 * h))) / (12 * h)


def product(p, q):
    """Hamilton product, scalar last."""
    vector = p[..., 3:] * q[..., :3] + q[..., 3:] * p[..., :3] + np.cross(p[..., :3], q[..., :3])
    return np.concatenate([vector, p[..., 3:] * q[..., 3:] - np.sum(p[..., :3] * q[..., :3], -1, keepdims=True)], -1)


def hat(w):
    x, y, z = np.moveaxis(w, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)


def matrices(spline, t):
    return Rotation.from_quat(spline(t)).as_matrix()


def test_rate_of_matrices_and_quaternions(spline):
    t, w = INSIDE, spline(INSIDE, 1)
    R = matrices(spline, t)
    assert np.allclose(derivative(lambda s: matrices(spline, s), t), R @ hat(w), atol=1e-9)
    assert np.allclose(derivative(spline, t), product(spline(t), np.pad(w, ((0, 0), (0, 1)))) / 2, atol=1e-9)


def test_metric_and_covariant_derivatives(rotations):
    curve = CubicSpline(KNOTS, rotations.as_matrix())
    spline, M = RotationSpline.from_curve(curve), Stiefel(3, 3)
    w, a, j = (spline(INSIDE, order) for order in (1, 2, 3))
    R = matrices(spline, INSIDE)
    assert np.allclose(curve(INSIDE), R, atol=1e-12)
    assert np.allclose(curve.velocity(INSIDE), R @ hat(w), atol=1e-11)
    assert np.allclose(curve.acceleration(INSIDE), R @ hat(a), atol=1e-10)
    assert np.allclose(curve.jerk(INSIDE), R @ hat(j + np.cross(w, a) / 2), atol=1e-9)
    assert np.allclose(M.norm(R[0], R[0] @ hat(w[0])), np.linalg.norm(w[0]))


def test_covariant_derivative_of_a_field(spline):
    # D_t W = W' + Gamma(R', W), with the Christoffel function of the canonical metric where P = 0.
    def field(s):
        u = np.stack([np.sin(s), s**2, np.cos(2 * s)], axis=-1)
        return matrices(spline, s) @ hat(u)

    t = INSIDE
    R, w = matrices(spline, t), spline(t, 1)
    V, W = R @ hat(w), field(t)
    gamma = (V @ np.swapaxes(W, 1, 2) + W @ np.swapaxes(V, 1, 2)) @ R / 2
    u = np.stack([np.sin(t), t**2, np.cos(2 * t)], axis=-1)
    du = np.stack([np.cos(t), 2 * t, -2 * np.sin(2 * t)], axis=-1)
    assert np.allclose(derivative(field, t) + gamma, R @ hat(du + np.cross(w, u) / 2), atol=1e-9)


def test_equation_and_its_first_integral(spline, tension):
    t = INSIDE
    w, a, j = (spline(t, order) for order in (1, 2, 3))
    assert np.allclose(derivative(lambda s: spline(s, 3), t), np.cross(j, w) + tension * a, atol=1e-7)
    # Two times on the second piece.
    constants = j - np.cross(a, w) - tension * w
    assert np.allclose(constants[1], constants[2], atol=1e-9)
    if tension == 0:
        assert np.isclose(np.linalg.norm(j[1]), np.linalg.norm(j[2]), rtol=1e-10)


def test_cost(spline, tension):
    x, weights = np.polynomial.legendre.leggauss(24)
    h = np.diff(KNOTS)[:, None]
    t = KNOTS[:-1, None] + h * (x + 1) / 2
    w, a = (spline(t.ravel(), order).reshape(*t.shape, 3) for order in (1, 2))
    integrand = np.sum(a**2, axis=-1) + tension * np.sum(w**2, axis=-1)
    assert np.isclose(spline.cost(), np.sum(integrand * weights * h / 2), rtol=1e-12)


def test_series(spline, tension):
    t, terms = 1.0, 24
    w, a, j = (spline(t, order) for order in (1, 2, 3))
    rates, quaternions = [w, a, j / 2], [spline(t)]
    for k in range(1, terms):
        pairs = [(i, k + 1 - i) for i in range(k + 2) if i > k + 1 - i]
        total = sum((i - n) * np.cross(rates[i], rates[n]) for i, n in pairs) + tension * rates[k]
        rates.append(total / ((k + 1) * (k + 2)))
    for k in range(terms):
        total = sum(product(quaternions[i], np.append(rates[k - i], 0)) for i in range(k + 1))
        quaternions.append(total / (2 * (k + 1)))
    s = 0.2
    assert np.allclose(sum(c * s**k for k, c in enumerate(rates)), spline(t + s, 1), atol=1e-11)
    assert np.allclose(sum(c * s**k for k, c in enumerate(quaternions)), spline(t + s), atol=1e-11)


def test_rotation_between_opposite_times(spline):
    middle, s = 1.1, np.array([0.05, 0.2, 0.3])

    def between(s):
        return product(spline(middle - s) * [-1, -1, -1, 1], spline(middle + s))

    ends = spline(middle - s, 1), spline(middle + s, 1)
    even, odd = (ends[1] + ends[0]) / 2, (ends[1] - ends[0]) / 2
    v, w = between(s)[:, :3], between(s)[:, 3:]
    rates = np.hstack([w * even + np.cross(v, odd), -np.sum(even * v, axis=-1, keepdims=True)])
    assert np.allclose(derivative(between, s), rates, atol=1e-9)
    assert np.allclose(between(-s), between(s) * [-1, -1, -1, 1], atol=1e-14)
    assert np.allclose(between(np.zeros(1)), [0, 0, 0, 1], atol=1e-14)


def test_rotations_about_one_axis_are_cubics_of_the_angle():
    half = np.array([0.0, 0.4, 0.3, 0.9]) / 2
    spline = RotationSpline(KNOTS, np.stack([0 * half, 0 * half, np.sin(half), np.cos(half)], axis=-1))
    assert np.allclose(derivative(lambda s: spline(s, 3), INSIDE), 0, atol=1e-8)


def test_world_frame(spline):
    w, a, j = (spline(INSIDE, order) for order in (1, 2, 3))
    R = matrices(spline, INSIDE)

    def turned(u):
        return np.einsum("tij,tj->ti", R, u)

    velocity, acceleration = spline.angular_velocity, spline.angular_acceleration
    assert np.allclose(velocity(INSIDE, "world"), turned(w))
    assert np.allclose(acceleration(INSIDE, "world"), turned(a))
    assert np.allclose(spline.angular_jerk(INSIDE, "world"), turned(j))
    assert np.allclose(derivative(lambda s: velocity(s, "world"), INSIDE), turned(a), atol=1e-8)
    assert np.allclose(derivative(lambda s: acceleration(s, "world"), INSIDE), turned(j + np.cross(w, a)), atol=1e-7)


def test_twists(rotations, rng):
    T = np.tile(np.eye(4), (4, 1, 1))
    T[:, :3, :3], T[:, :3, 3] = rotations.as_matrix(), rng.standard_normal((4, 3))
    spline, t = PoseSpline(KNOTS, T), INSIDE
    rate, inverse = derivative(spline, t), np.linalg.inv(spline(t))
    for frame, expected in (("body", inverse @ rate), ("world", rate @ inverse)):
        twist = spline.twist(t, frame)
        matrix = np.zeros((4, 4, 4))
        matrix[:, :3, :3], matrix[:, :3, 3] = hat(twist[:, :3]), twist[:, 3:]
        assert np.allclose(matrix, expected, atol=1e-8)


def test_velocities_of_positions(rotations, rng):
    p = rng.standard_normal((4, 3))
    v = PoseSpline(KNOTS, (rotations, p)).linear_velocity(KNOTS)
    h, step = np.diff(KNOTS)[:, None], np.diff(p, axis=0)
    left = (2 * v[:-2] + 4 * v[1:-1]) / h[:-1] + (4 * v[1:-1] + 2 * v[2:]) / h[1:]
    assert np.allclose(left, 6 * (step[:-1] / h[:-1] ** 2 + step[1:] / h[1:] ** 2))
