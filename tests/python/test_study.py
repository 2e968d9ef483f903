"""The study of integrators: its equations, its curves, its comparisons, and a short run of the whole."""

import numpy as np
import pytest

from benchmarks.study.__main__ import main
from benchmarks.study.cases import cases, random_data
from benchmarks.study.equations import FirstOrder, dop853
from benchmarks.study.long_runs import Energy, bounded, energies
from benchmarks.study.text import energy_table, slope
from benchmarks.study.work import COST_SIZES, Solve, costs, fastest_below, solves
from stiefel_rs import RiemannianCubic, Stiefel

EPS = np.finfo(float).eps
CASES = cases()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_reference_is_met_by_the_taylor_method_and_by_dop853(case):
    n, k = case.shape
    assert case.error(RiemannianCubic.from_initial(*case.data)(1.0)) <= 10 * n * EPS
    system = FirstOrder(n, k)
    # DOP853 requests 1e-11 in every step and takes some ten of them.
    assert case.error(dop853(system, system.initial(case.data), 1e-11)()) <= 1e-9


@pytest.mark.parametrize(("n", "k"), [(3, 1), (3, 2), (4, 4), (6, 3)])
def test_equations_pack_and_unpack(n, k):
    system = FirstOrder(n, k)
    S, V, A, J = random_data(n, k)
    y = system.initial((S, V, A, J))
    assert y.shape == (system.size,)
    assert np.array_equal(system.pack(*system.unpack(y)), y)
    assert np.array_equal(system.point(y), S)
    assert np.linalg.norm(system.point(system.derivative(y)) - V) <= 10 * n * EPS


def test_random_data_are_tangent_and_of_the_lengths_asked_for():
    S, *tangents = random_data(5, 2, 1.0, 0.5, 0.25)
    M = Stiefel(5, 2)
    for V, length in zip(tangents, (1.0, 0.5, 0.25), strict=True):
        M.check_tangent(S, V)
        assert abs(M.norm(S, V) - length) <= 20 * EPS


def test_every_method_converges():
    found = solves(CASES[0], peers=False)
    for method in dict.fromkeys(s.method for s in found):
        errors = [s.error for s in found if s.method == method]
        assert min(errors[1:]) < errors[0] / 10, (method, errors)


def test_speed_of_the_bounded_curve_stays_bounded():
    S, V, A, J = bounded(0.2)
    curve = RiemannianCubic.from_initial(S, V, A, J, 200.0)
    speed = np.linalg.norm(curve(np.linspace(0, 200, 2001), 1), axis=(1, 2))
    assert 0.99 < speed.min() and speed.max() < 1.62


def test_energy_error_of_splittings_is_level_where_the_speed_is_bounded():
    found = [e for e in energies(100.0, 5.0) if "sphere" in e.curve and e.method == "splitting, order 4"]
    assert len(found) == 2
    for e in found:
        assert 1e-12 < e.error.max() < 1e-7 and e.growth < 2, (e.curve, e.error.max(), e.growth)


def test_methods_that_leave_the_curve_are_named():
    def made(method, speed, error=1e-3):
        return Energy("c", method, np.ones(1), np.full(1, error), (1.0, speed))

    found = [
        made("splitting, order 8", 1.6),
        made("near", 1.65),
        made("far", 5e3),
        made("slow", 1.1),
        made("e", 1.6, 2),
    ]
    lines = energy_table(found).splitlines()[2:]
    assert ["left the curve" in line for line in lines] == [False, False, True, True, True]


def test_growth_of_round_off_and_stopped_methods_have_no_number():
    exact = Energy("c", "splitting, order 8", np.ones(1), np.full(1, 1e-15), (1.0, 1.6))
    stopped = Energy("c", "m", np.empty(0), np.empty(0), (np.nan, np.nan), "steps: too few, must be 1 = 1")
    first, second = (line.split("|")[1:-1] for line in energy_table([exact, stopped]).splitlines()[2:])
    assert [cell.strip() for cell in first[2:4]] == ["1.0e-15", "round-off"]
    assert [cell.strip() for cell in second[2:]] == ["stopped", "", "", "steps: too few"]


def test_sizes_stand_in_the_order_of_their_rows():
    rows = [cost.rows for cost in costs(((5, 2), (3, 1), (4, 1), (9, 1)), 1)]
    assert rows == [3, 4, 4, 5]
    assert [min(n, 4 * k) for n, k in COST_SIZES] == sorted(min(n, 4 * k) for n, k in COST_SIZES)


def test_fastest_is_chosen_among_the_accurate():
    def made(method, error, time):
        return Solve("c", method, "", lambda: np.zeros(0), error, times=[2 * time, time])

    best = fastest_below([made("a", 1e-3, 1.0), made("a", 1e-11, 3.0), made("a", 1e-12, 2.0), made("b", 1, 1)], 1e-10)
    assert list(best) == ["a"] and best["a"].best == 2.0 and best["a"].median == 3.0


def test_slope_of_a_power():
    assert abs(slope([1, 2, 4, 8], [5, 40, 320, 2560]) - 3) <= 10 * EPS


def test_short_run_writes_page_and_figures(tmp_path, capsys):
    main(["--quick", "--out", str(tmp_path / "page.md")])
    page = (tmp_path / "page.md").read_text()
    assert page in capsys.readouterr().out
    figures = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert figures == [f"integrators_{name}.svg" for name in ("cost", "drift", "energy", "work")]
    for name in figures:
        assert f"(figures/{name})" in page
        assert 1_000 < (tmp_path / "figures" / name).stat().st_size < 200_000
    assert "splitting, order 8" in page and "{" not in page and "nan" not in page
