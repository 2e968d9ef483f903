"""Methods of the manifold: name -> function of a `Draw` that returns (callable, arguments)."""

from stiefel_rs import Stiefel

from .arguments import RETRACTIONS, seed, some


def manifold(d):
    return Stiefel(d.n, d.k, metric=d.of(["canonical", "euclidean", 0.0, -0.3, None]) if d.chance(0.4) else None)


def with_tangents(name, count, *options):
    def draw(d):
        S = d.batch()
        return (
            getattr(manifold(d), name),
            [S, *(d.tangent_of_some(S) for _ in range(count)), *(o(d) for o in options)],
            {},
        )

    return draw


def two_points(name, *options):
    def draw(d):
        return getattr(manifold(d), name), [d.batch(), d.point(), *(o(d) for o in options)], {}

    return draw


def compose(d):
    X = d.rng.uniform(-1, 1, (d.n, d.n))
    Omega = d.rng.uniform(-1, 1, (d.k, d.k))
    return manifold(d).compose, [d.point(), X - X.T, Omega - Omega.T], {}


def composed(d):
    """Consistent arguments by construction."""
    M, S = manifold(d), d.point()
    return M.compose, [S, *M.decompose(S, d.tangent(S))], {}


def ambient(d, S):
    return d.rng.standard_normal(S.shape) * (d.of([1e-300, 1e-8, 1e8, 1e300]) if d.chance(d.wild) else 1.0)


def with_ambient(name, count):
    def draw(d):
        S = d.batch()
        return getattr(manifold(d), name), [S, *(ambient(d, S) for _ in range(count))], {}

    return draw


def hessian_of(d):
    S = d.batch()
    return manifold(d).euclidean_to_riemannian_hessian, [S, ambient(d, S), ambient(d, S), d.tangent(S)], {}


def retraction(d):
    return d.word(RETRACTIONS)


def tolerance(d):
    return d.number([1e-8, 1e-10])


def size(d):
    return d.of([None, 2, (2, 2), (), 0, (0, 3), -1, 2**40, (2**40, 2**40), "ab", 2.5, [2], None])


MANIFOLD = {
    "Stiefel.check_point": lambda d: (manifold(d).check_point, [d.batch(), tolerance(d)], {}),
    "Stiefel.check_tangent": with_tangents("check_tangent", 1, tolerance),
    "Stiefel.is_point": lambda d: (manifold(d).is_point, [d.batch(), tolerance(d)], {}),
    "Stiefel.is_tangent": with_tangents("is_tangent", 1, tolerance),
    "Stiefel.random_point": lambda d: (manifold(d).random_point, [seed(d)], some(d, {"size": lambda: size(d)})),
    "Stiefel.random_tangent": with_tangents("random_tangent", 0, seed),
    "Stiefel.project": with_ambient("project", 0),
    "Stiefel.project_any": lambda d: (manifold(d).project, [ambient(d, d.batch())], {}),
    "Stiefel.project_tangent": with_ambient("project_tangent", 1),
    "Stiefel.inner": with_tangents("inner", 2),
    "Stiefel.norm": with_tangents("norm", 1),
    "Stiefel.decompose": with_tangents("decompose", 1),
    "Stiefel.compose": lambda d: d.of([compose, composed])(d),
    "Stiefel.exp": with_tangents("exp", 1),
    "Stiefel.log": lambda d: (
        *two_points("log")(d)[:2],
        some(d, {"full_output": lambda: d.of([True, False, 3, None])}),
    ),
    "Stiefel.dist": two_points("dist"),
    "Stiefel.retract": with_tangents("retract", 1, retraction),
    "Stiefel.inverse_retract": two_points("inverse_retract", retraction),
    "Stiefel.transport": with_tangents("transport", 2),
    "Stiefel.curvature": with_tangents("curvature", 3),
    "Stiefel.sectional_curvature": with_tangents("sectional_curvature", 2),
    "Stiefel.euclidean_to_riemannian_gradient": with_ambient("euclidean_to_riemannian_gradient", 1),
    "Stiefel.euclidean_to_riemannian_hessian": hessian_of,
}
