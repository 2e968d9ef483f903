"""Shared fixtures: seeded randomness and the grid of manifolds."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import skips
from beside import HANGS

from stiefel_rs import Stiefel

try:
    from hypothesis import HealthCheck, settings
except ImportError:  # The tests of a release only need pytest.
    pass
else:
    # The same examples in every run, without time limits for running or generating them. New examples, and the code
    # that repeats a failure: pytest --hypothesis-profile=explore
    CLOCKLESS = {"deadline": None, "print_blob": True, "suppress_health_check": [HealthCheck.too_slow]}
    settings.register_profile("explore", **CLOCKLESS)
    settings.register_profile("fixed", derandomize=True, **CLOCKLESS)
    settings.load_profile("fixed")

# k = 1 is the sphere, k = n the orthogonal group, (5, 3) has n < 2 k.
SHAPES = [(3, 1), (4, 2), (5, 3), (6, 6), (20, 4)]


def pytest_terminal_summary(terminalreporter, config):
    """Print the seed of the test order: quiet runs have no header."""
    seed = config.getoption("randomly_seed", None)
    if seed is not None:
        terminalreporter.write_line(f"order of the tests: --randomly-seed={seed}")
    # Replaces pytest's list of skipped tests.
    for line in skips.lines(skips.reasons(terminalreporter.stats.get("skipped", []))):
        terminalreporter.write_line(line)


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


@pytest.fixture(scope="session")
def quick(tmp_path_factory):
    """Folder of a quick run of `reproduce` on one thread, and the finished process; for all tests that only read."""
    folder = tmp_path_factory.mktemp("quick")
    # A file of an earlier run, which is not part of this one.
    (folder / "tables").mkdir()
    (folder / "tables" / "old.csv").write_text("a\n", encoding="utf-8")
    # A file with this name would be taken for the report of this run.
    (folder / "report.pdf").write_bytes(b"")
    words = [sys.executable, "-m", "stiefel_rs", "reproduce", "--quick", "--out", str(folder)]
    env = os.environ | {"RAYON_NUM_THREADS": "1"}
    return folder, subprocess.run(words, capture_output=True, text=True, timeout=HANGS, check=False, env=env)


@pytest.fixture
def spawn():
    """Start Python children that Ctrl-C can stop; kill those still running after the test."""
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
