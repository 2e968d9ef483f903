"""Shared fixtures: seeded randomness and the grid of manifolds."""

import signal
import subprocess
import sys

import numpy as np
import pytest

from stiefel_rs import Stiefel

# k = 1 is the sphere, k = n the orthogonal group, (5, 3) has n < 2 k.
SHAPES = [(3, 1), (4, 2), (5, 3), (6, 6), (20, 4)]


@pytest.fixture
def rng():
    return np.random.default_rng(20240419)


@pytest.fixture(params=SHAPES, ids=lambda shape: f"St{shape[0]}_{shape[1]}")
def manifold(request):
    return Stiefel(*request.param)


@pytest.fixture
def boundary(manifold, rng):
    """Points at canonical distance of about 0.7 and velocities of norm 0.5: (S0, V0, S1, V1)."""

    def tangent(S, length):
        V = manifold.random_tangent(S, rng)
        return V * (length / manifold.norm(S, V))

    S0 = manifold.random_point(rng)
    S1 = manifold.retract(S0, tangent(S0, 0.7))
    return S0, tangent(S0, 0.5), S1, tangent(S1, 0.5)


@pytest.fixture
def spawn():
    """Start Python children that Ctrl-C can stop; whatever still runs after the test is killed."""
    # A shell that starts a job in the background makes it ignore Ctrl-C, and children inherit that.
    inherited = signal.signal(signal.SIGINT, signal.default_int_handler)
    children = []

    def start(*arguments, **pipes):
        children.append(subprocess.Popen([sys.executable, *arguments], text=True, **pipes))
        return children[-1]

    yield start
    for process in children:
        process.kill()
        process.communicate()
    signal.signal(signal.SIGINT, inherited)
