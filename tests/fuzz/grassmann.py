"""Methods of the Grassmann manifold: name -> function of a `Draw` that returns (callable, arguments)."""

import numpy as np

from stiefel_rs import Grassmann

from .arguments import seed, some
from .manifold import ambient, size, tolerance


def manifold(d):
    return Grassmann(d.n, d.k)


def horizontal(d, Y):
    """Tangent vectors at one of a batch of points or at all of them; sometimes not horizontal."""
    V = d.tangent_of_some(Y)
    if d.chance(d.wild) or V.shape != Y.shape:
        return V
    with np.errstate(all="ignore"):
        V = V - Y @ (np.swapaxes(Y, -1, -2) @ V)
        return V - Y @ (np.swapaxes(Y, -1, -2) @ V)


def with_tangents(name, count, *options):
    def draw(d):
        Y = d.batch()
        vectors = [horizontal(d, Y) for _ in range(count)]
        return getattr(manifold(d), name), [Y, *vectors, *(o(d) for o in options)], {}

    return draw


def with_ambient(name, count):
    def draw(d):
        Y = d.batch()
        return getattr(manifold(d), name), [Y, *(ambient(d, Y) for _ in range(count))], {}

    return draw


def two_points(name):
    return lambda d: (getattr(manifold(d), name), [d.batch(), d.point()], {})


def hessian_of(d):
    Y = d.batch()
    return manifold(d).euclidean_to_riemannian_hessian, [Y, ambient(d, Y), ambient(d, Y), horizontal(d, Y)], {}


GRASSMANN = {
    "Grassmann": lambda d: (Grassmann, [d.integer([3, 4]), d.integer([1, 2])], {}),
    "Grassmann.check_point": lambda d: (manifold(d).check_point, [d.batch(), tolerance(d)], {}),
    "Grassmann.check_tangent": with_tangents("check_tangent", 1, tolerance),
    "Grassmann.is_point": lambda d: (manifold(d).is_point, [d.batch(), tolerance(d)], {}),
    "Grassmann.is_tangent": with_tangents("is_tangent", 1, tolerance),
    "Grassmann.random_point": lambda d: (manifold(d).random_point, [seed(d)], some(d, {"size": lambda: size(d)})),
    "Grassmann.random_tangent": with_tangents("random_tangent", 0, seed),
    "Grassmann.project": lambda d: (manifold(d).project, [ambient(d, d.batch())], {}),
    "Grassmann.project_tangent": with_ambient("project_tangent", 1),
    "Grassmann.inner": with_tangents("inner", 2),
    "Grassmann.norm": with_tangents("norm", 1),
    "Grassmann.principal_angles": two_points("principal_angles"),
    "Grassmann.align": two_points("align"),
    "Grassmann.projector": lambda d: (manifold(d).projector, [d.batch()], {}),
    "Grassmann.exp": with_tangents("exp", 1),
    "Grassmann.log": two_points("log"),
    "Grassmann.dist": two_points("dist"),
    "Grassmann.transport": with_tangents("transport", 2),
    "Grassmann.curvature": with_tangents("curvature", 3),
    "Grassmann.sectional_curvature": with_tangents("sectional_curvature", 2),
    "Grassmann.euclidean_to_riemannian_gradient": with_ambient("euclidean_to_riemannian_gradient", 1),
    "Grassmann.euclidean_to_riemannian_hessian": hessian_of,
}
