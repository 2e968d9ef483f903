"""The comparison of control points on random boundary problems: its samples, and a short run of the whole."""

import itertools

import numpy as np
import pytest

from benchmarks.boundary import control_points
from benchmarks.boundary.control_points import BASE, DEGREES, EXACT, methods


@pytest.fixture(scope="module")
def tallies():
    return [control_points.measure(n, k, 6) for n, k in ((3, 1), (4, 2))]


def test_every_problem_is_solved_and_compared(tallies):
    for tally in tallies:
        assert tally.unsolved == 0
        for name in methods():
            sample = tally.samples[name]
            assert len(sample.distances) == len(sample.build) == len(sample.point) == 6 and not sample.failures
        assert len(tally.samples[EXACT].build) == 6


def test_higher_degrees_come_nearer(tallies):
    for tally in tallies:
        names = [BASE, *(f"`minimal_cost`, degree {degree}" for degree in DEGREES)]
        means = [np.exp(np.log(tally.samples[name].distances).mean()) for name in names]
        assert all(after < before / 2 for before, after in itertools.pairwise(means)), means


def test_geodesics_on_the_sphere_are_quasi_geodesics(tallies):
    base, geodesic = (tallies[0].samples[name].distances for name in (BASE, '`pieces="geodesic"`'))
    # Distances of at least 1e-4, compared with the residual of the exact cubic.
    np.testing.assert_allclose(geodesic, base, rtol=1e-7)


def test_what_was_refused_is_said():
    refused = control_points.Sample(distances=[np.nan])
    refused.failures["OutsideDomainError"] += 1
    tally = control_points.Tally(4, 2, 3, {name: refused for name in (*methods(), EXACT)})
    text = control_points._refused([tally])
    assert text.startswith("Left out") and "1 OutsideDomainError" in text and "3 boundary problems" in text
    assert control_points._gain(control_points.Sample(distances=[1.0]), refused) == control_points.REFUSED


def test_short_run_writes_the_page(tmp_path, capsys):
    path = tmp_path / "page.md"
    control_points.main(["--count", "1", "--out", str(path)])
    page = path.read_text()
    assert page in capsys.readouterr().out
    assert "{" not in page and "nan" not in page
    for n, k in control_points.SHAPES:
        assert f"St({n},{k})" in page
