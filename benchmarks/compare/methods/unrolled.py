"""Riemannian cubics and splines by a fixed number of steps in JAX, so that its own derivatives go through all of them.

This is the alternative to derivatives of solutions: Runge-Kutta steps of fixed size and a fixed number of Newton steps,
compiled, and differentiated in reverse mode by JAX.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)

# Number of steps of the Runge-Kutta method of order 4: errors of 1e-8 for the data of the comparison.
STEPS = 32
NEWTON = 6


def _runge_kutta(rate: Any, state: Any, steps: int) -> Any:
    """Integrate over one unit of time; all states, including the first."""
    h = 1.0 / steps

    def moved(y: Any, z: Any, factor: float) -> Any:
        return jax.tree.map(lambda a, b: a + factor * b, y, z)

    def step(y: Any, _: None) -> tuple[Any, Any]:
        k1 = rate(y)
        k2 = rate(moved(y, k1, h / 2))
        k3 = rate(moved(y, k2, h / 2))
        k4 = rate(moved(y, k3, h))
        slope = jax.tree.map(lambda a, b, c, d: (a + 2 * b + 2 * c + d) / 6, k1, k2, k3, k4)
        y = moved(y, slope, h)
        return y, y

    _, after = jax.lax.scan(step, state, None, length=steps)
    return jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), state, after)


def boundary_points(S0: Any, V0: Any, S1: Any, V1: Any) -> Any:
    """Points at 0, 1/STEPS, ..., 1 of the cubic between two points of St(n, k) with given velocities."""
    n, k = S0.shape
    frame = _completed(S0)
    mask = jnp.ones((n, n)).at[k:, k:].set(0.0)

    def skew(tangent: Any) -> Any:
        low = frame.T @ tangent
        matrix = jnp.zeros((n, n)).at[:, :k].set(low).at[:k, k:].set(-low[k:].T)
        return matrix.at[:k, :k].set(0.5 * (low[:k] - low[:k].T))

    def bracket(x: Any, y: Any) -> Any:
        return x @ y - y @ x

    def rate(state: Any) -> Any:
        g, x, a, b = state
        turn = bracket(x, a) * (1.0 - mask)
        return g @ x, a, b, bracket(b, x) * mask - bracket(turn, x)

    rows, columns = jnp.nonzero(jnp.tril(mask, -1), size=(k * (k - 1)) // 2 + (n - k) * k)

    def unpacked(y: Any) -> Any:
        matrix = jnp.zeros((n, n)).at[rows, columns].set(y)
        return matrix - matrix.T

    d = rows.shape[0]
    x0 = skew(V0)

    def states(y: Any) -> Any:
        return _runge_kutta(rate, (frame, x0, unpacked(y[:d]), unpacked(y[d:])), STEPS)

    def rest(y: Any) -> Any:
        g, x, _, _ = states(y)
        point, velocity = g[-1][:, :k] - S1, g[-1] @ x[-1][:, :k] - V1
        carried = [g[-1].T @ z for z in (point, velocity)]
        parts = [jnp.zeros((n, n)).at[:, :k].set(z) for z in carried]
        return jnp.concatenate([part[rows, columns] for part in parts])

    y = jnp.zeros(2 * d)
    for _ in range(NEWTON):
        y = y - jnp.linalg.solve(jax.jacfwd(rest)(y), rest(y))
    return states(y)[0][:, :, :k]


def _completed(S: Any) -> Any:
    """An orthogonal matrix whose first columns are those of a frame, by Gram-Schmidt on fixed vectors."""
    n, k = S.shape
    columns = [S[:, i] for i in range(k)]
    fixed = jax.random.normal(jax.random.key(0), (n, n))
    for i in range(k, n):
        v = fixed[:, i]
        for _ in range(2):
            basis = jnp.stack(columns, axis=1)
            v = v - basis @ (basis.T @ v)
        columns.append(v / jnp.linalg.norm(v))
    return jnp.stack(columns, axis=1)


def spline_rotations(t: Any, R: Any, steps: int) -> Any:
    """Rotations of the natural spline through keyframes, at `steps` + 1 equal times of every leg."""
    h = t[1:] - t[:-1]
    targets = jnp.swapaxes(R[:-1], -1, -2) @ R[1:]

    def hat(w: Any) -> Any:
        x, y, z = w
        return jnp.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])

    def axis(Q: Any) -> Any:
        return 0.5 * jnp.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]])

    def rate(state: Any) -> Any:
        g, w, a, b = state
        # Body rates: w''' = w'' x w.
        return g @ hat(w), a, b, jnp.cross(b, w)

    def leg(z: Any) -> Any:
        return _runge_kutta(rate, (jnp.eye(3), z[:3], z[3:6], z[6:]), steps)

    def ends(z: Any, target: Any) -> Any:
        """The residual of the point, and rate and acceleration at the end."""
        g, w, a, _ = leg(z)
        return jnp.concatenate([axis(target.T @ g[-1]), w[-1], a[-1]])

    units = jnp.stack([1 / h, 1 / h**2], axis=1)

    def newton(z: Any) -> Any:
        found = jax.vmap(ends)(z, targets)
        slopes = jax.vmap(jax.jacfwd(ends))(z, targets)
        one, two = units[:, 0, None], units[:, 1, None]
        zero = jnp.zeros((1, 3))
        # Rows of a leg: its acceleration at the start, its point, its rate at the end; the acceleration of the last
        # leg.
        before = jnp.concatenate([zero, found[:-1, 6:] * two[:-1]])
        after = jnp.concatenate([z[1:, :3] * one[1:], zero])
        last = found[:, 3:6] * one - after
        last = last.at[-1].set(found[-1, 6:] * two[-1])
        right = jnp.concatenate([z[:, 3:6] * two - before, found[:, :3], last], axis=1)
        count = z.shape[0]
        identity = jnp.eye(9)
        diagonal = jnp.concatenate(
            [
                jnp.broadcast_to(identity[3:6], (count, 3, 9)) * two[..., None],
                slopes[:, :3],
                (slopes[:, 3:6] * one[..., None]).at[-1].set(slopes[-1, 6:] * two[-1]),
            ],
            axis=1,
        )
        lower = jnp.zeros((count, 9, 9)).at[1:, :3].set(-slopes[:-1, 6:] * two[:-1, :, None])
        upper = jnp.zeros((count, 9, 9)).at[:-1, 6:, :3].set(-jnp.eye(3) * one[1:, :, None])
        return z - _block_tridiagonal(lower, diagonal, upper, right)

    turns = jax.vmap(axis)(targets)
    z = jnp.concatenate([turns, jnp.zeros_like(turns), jnp.zeros_like(turns)], axis=1)
    for _ in range(NEWTON):
        z = newton(z)
    return R[:-1, None] @ jax.vmap(lambda z: leg(z)[0])(z)


def _block_tridiagonal(lower: Any, diagonal: Any, upper: Any, right: Any) -> Any:
    """Solve by block elimination."""

    def down(carry: Any, row: Any) -> tuple[Any, Any]:
        before, known = carry
        a, b, c, f = row
        pivot = b - a @ before
        solved = jnp.linalg.solve(pivot, jnp.concatenate([c, (f - a @ known)[:, None]], axis=1))
        carry = solved[:, :-1], solved[:, -1]
        return carry, carry

    start = jnp.zeros(lower.shape[1:]), jnp.zeros(right.shape[1:])
    _, (factors, known) = jax.lax.scan(down, start, (lower, diagonal, upper, right))

    def up(after: Any, row: Any) -> tuple[Any, Any]:
        factor, f = row
        x = f - factor @ after
        return x, x

    _, found = jax.lax.scan(up, jnp.zeros(right.shape[1:]), (factors, known), reverse=True)
    return found
