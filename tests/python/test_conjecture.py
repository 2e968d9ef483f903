"""The study of the paper's conjecture: its numbers agree with the methods, and its verdicts follow from them."""

import numpy as np
import pytest

from stiefel_rs import Stiefel
from stiefel_rs.reproduce import conjecture, experiments, retraction_pairs, retractions
from stiefel_rs.reproduce.retraction_pairs import Comparison


@pytest.fixture(scope="module")
def study():
    return retractions.measure(4, 2)


def test_closeness_is_the_distance_to_the_exponential(study):
    found = {(c.manifold, c.retraction): c for c in study.closeness}
    # Cayley on the sphere: the angle 2 atan(t / 2), shorter by t^3 / 12.
    cayley = found["sphere", "Cayley"]
    t = retractions.LENGTHS[0]
    np.testing.assert_allclose(cayley.distance, 2 * np.sin((t - 2 * np.arctan(t / 2)) / 2), rtol=1e-12)
    for name, e in ((e.name, e) for e in experiments.EXPERIMENTS):
        assert found[name, "exponential"].distance == 0
        for retraction in retractions.retractions(e):
            expected = {"Cayley": 3, "exponential": None}.get(retraction, 2)
            exponent = found[name, retraction].exponent
            assert exponent is None if expected is None else abs(exponent - expected) < 0.1


def test_the_papers_maps_have_the_papers_errors(study):
    for e in study.errors:
        if e.curve == "paper" and e.retraction == retractions.COORDINATES:
            experiment = next(x for x in experiments.EXPERIMENTS if x.name == e.manifold)
            method = f"{retractions.MAPS[e.retraction][e.order - 1]}_{e.problem.lower()}"
            # Printed to five digits.
            index = experiments.METHODS.index(method)
            np.testing.assert_allclose(e.error, experiment.independent[e.steps][index], rtol=1e-4)


def test_errors_of_another_retraction_are_those_of_its_method(study):
    experiment = experiments.STIEFEL_3_2
    z0 = experiments.initial_state(experiment)
    exact = experiments.points(experiment, experiments.reference(experiment, 20))
    found = experiment.chart.integrate(z0, 20, map="cayley_midpoint")
    mean = np.linalg.norm(experiments.points(experiment, found) - exact, axis=(1, 2)).mean()
    error = next(
        e.error
        for e in study.errors
        if (e.manifold, e.curve, e.problem, e.order, e.steps, e.retraction)
        == ("stiefel_3_2", "paper", "IVP", 2, 20, "Cayley")
    )
    np.testing.assert_allclose(error, mean, rtol=1e-12)


def test_random_curves_are_within_their_bounds():
    for e in experiments.EXPERIMENTS:
        M = Stiefel(3, e.chart.k)
        for z, _ in zip(retractions.random_states(e), range(20), strict=False):
            S, V, A, J = e.chart.covariant(z)
            lengths = [float(M.norm(S, X)) for X in (V, A, J)]
            assert all(0 < length < bound for length, bound in zip(lengths, (1.0, 3.0, 3.0), strict=True))


def test_comparisons_cover_every_pair(study):
    found = retraction_pairs.comparisons(study)
    assert len(found) == 2 * 2 * 2 * (3 + 6)
    for c in found:
        assert c.cases == (len(retractions.STEPS) if c.curves == "paper" else 2)
        assert 0 <= c.wins <= c.cases and c.ratio > 0
        assert (c.ratio < 1 or c.wins < c.cases) and (c.ratio > 1 or c.wins > 0)


def row(ratio, wins, cases=4):
    return Comparison("sphere", "paper", "IVP", 2, "exponential", "Cayley", wins, cases, ratio)


def test_the_verdict_follows_the_numbers():
    assert "holds in every case" in retraction_pairs.verdict([row(0.5, 4), row(0.9, 4)])
    mixed = retraction_pairs.verdict([row(0.5, 4), row(0.9, 3), row(1.2, 0)])
    assert "false as a rule without exceptions and holds as a tendency" in mixed
    assert "wrong for exponential against Cayley on sphere, paper (error 1.20 times as large)" in mixed
    assert "2 of 3 rows" in mixed and "in 7 of 12 single cases" in mixed
    against = retraction_pairs.verdict([row(1.5, 0), row(1.1, 1)])
    assert "false, as a rule and as a tendency" in against


def test_the_conjecture_is_read_against_the_midpoint_method(study):
    found = conjecture.outcomes(study)
    assert [(x.manifold, x.curves, x.retraction) for x in found] == [
        *(("sphere", curves, name) for curves in ("paper", "random") for name in ("exponential", "Cayley")),
        *(
            ("stiefel_3_2", curves, name)
            for curves in ("paper", "random")
            for name in ("exponential", "Cayley", "quasi-geodesic")
        ),
    ]
    bvp = [e for e in study.errors if (e.manifold, e.problem, e.order) == ("sphere", "BVP", 2)]
    error = {(e.curve, e.steps, e.retraction): e.error for e in bvp}
    for x in found[:4]:
        keys = [("paper", n) for n in retractions.STEPS]
        if x.curves == "random":
            keys = [(f"random {i}", retractions.RANDOM_STEPS) for i in range(1, 5)]
        expected = [error[(*key, x.retraction)] / error[(*key, retractions.COORDINATES)] for key in keys]
        np.testing.assert_array_equal(x.ratios, expected)
        assert x.wins == sum(ratio < 1 for ratio in expected) and x.cases == len(keys)
    assert conjecture.totals(found, "random") == (sum(x.wins for x in found if x.curves == "random"), 4 * 5)


def test_random_curves_beyond_the_wide_ones_are_in_the_setting_of_the_conjecture(study):
    cases = {(e.problem, e.order) for e in study.errors if e.curve == "random 3"}
    assert cases == {retractions.STATED}
    assert {(e.problem, e.order) for e in study.errors if e.curve == "random 2"} == set(retractions.CASES)


def test_sections(study, tmp_path):
    (path,) = retractions.write_table(tmp_path, study)
    assert len(path.read_text(encoding="utf-8").splitlines()) == 1 + len(study.errors)
    for text in (conjecture.section(study), retraction_pairs.section(study)):
        assert text.startswith("### ") and "nan" not in text.lower()
    assert "4 random cubics" in conjecture.section(study)
    assert "2 random cubics" in retraction_pairs.section(study)
