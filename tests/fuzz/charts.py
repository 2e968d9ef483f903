"""Charts and their methods: name -> function of a `Draw` that returns (callable, arguments)."""

import numpy as np

from stiefel_rs import Chart

from .arguments import MAPS, some


def chart(d):
    return d.of([Chart.sphere, Chart.frame])()


def with_parts(name):
    """Coordinates and derivatives, (q,), (q, qdot) or (q, qdot, qddot, qdddot)."""

    def draw(d):
        c = chart(d)
        lead = d.of([(), (), (2,), (0,), (2, 2)])
        count = {"embed": 1, "embed_velocity": 2, "discretize": 2, "momenta": 4}[name]
        parts = [d.near((*lead, c.d)), *(d.small((*lead, c.d)) for _ in range(count - 1))]
        return getattr(c, name), parts, some(d, {"map": lambda: d.word(MAPS)}) if name == "discretize" else {}

    return draw


def state(d, c, lead=()):
    return np.concatenate([d.near((*lead, c.d)), d.small((*lead, 3 * c.d))], axis=-1)


def with_state(name):
    def draw(d):
        c = chart(d)
        return getattr(c, name), [state(d, c, d.of([(), (), (2,), (0,)]))], {}

    return draw


def on_chart(d, c):
    """Initial data of a cubic on St(3, 1) or St(3, 2)."""
    d.n, d.k, d.seen = 3, c.k, []
    S = d.point()
    return [S, d.tangent(S), d.tangent(S), d.tangent(S)]


def across(name):
    def draw(d):
        c = chart(d)
        data = on_chart(d, c)
        if name == "state":
            return c.state, data, {}
        if name == "reference_across":
            return c.reference_across, [*data, np.linspace(0, 0.5, d.of([0, 1, 3]))], {}
        return c.integrate_across, [*data, d.integer([1, 3, 10])], stepping(d)

    return draw


def stepping(d):
    order = {"order": lambda: d.of([None, 1, 2, 4, 6, 8, 3, -1, 2**40, "2"])}
    return some(d, {"t_end": lambda: d.number([1.0, 0.1, -0.5]), "map": lambda: d.word(MAPS), **order})


def integrate(d):
    c = chart(d)
    return c.integrate, [state(d, c, d.of([(), (), (2,), (0,)])), d.integer([1, 3, 10])], stepping(d)


def reference(d):
    c = chart(d)
    return (
        c.reference,
        [state(d, c), d.of([np.zeros(0), np.array([0.0, 0.25]), np.array([0.5]), np.array([-1, 1.0])])],
        {},
    )


def shoot(d):
    c = chart(d)
    data = [d.near(c.d, 0.1), d.small(c.d), d.near(c.d, 0.1), d.small(c.d)]
    guess = {"guess": lambda: d.of([None, (np.zeros(c.d), np.zeros(c.d)), 3, (), (np.zeros(c.d),), "ab"])}
    numbers = {"tol": lambda: d.number([1e-12, 1e-8]), "max_iterations": lambda: d.integer([0, 1, 50])}
    # The number of steps is work that the caller asks for: shooting takes any number, since it only stores one
    # trajectory at the end.
    return c.shoot, [*data, d.of([0, -1, 1, 4, 10])], {**stepping(d), **some(d, {**numbers, **guess})}


CHART = {
    "Chart.sphere": lambda d: (Chart.sphere, [], {}),
    "Chart.frame": lambda d: (Chart.frame, [], {}),
    **{f"Chart.{name}": with_parts(name) for name in ["embed", "embed_velocity", "momenta", "discretize"]},
    **{
        f"Chart.{name}": with_state(name) for name in ["derivatives", "hamiltonian", "gradient", "hessian", "covariant"]
    },
    **{f"Chart.{name}": across(name) for name in ["state", "integrate_across", "reference_across"]},
    "Chart.integrate": integrate,
    "Chart.reference": reference,
    "Chart.shoot": shoot,
}
