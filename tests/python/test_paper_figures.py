"""The paper's figures: legends list what is drawn, and zooms separate overlapping curves."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from stiefel_rs.reproduce import (
    conjecture,
    conjecture_figure,
    experiments,
    figures,
    paper_figures,
    paper_tables,
    retractions,
)

NAMES = ["GCP", "Retraction", "Mid-point Retraction"]


@pytest.fixture(scope="module")
def rows():
    return {e.name: [experiments.mean_errors(e, n) for n in (5, 10, 20)] for e in experiments.EXPERIMENTS}


@pytest.fixture(scope="module")
def study():
    return retractions.measure(4, 2)


def legend(figure):
    own = [*figure.legends, *(ax.get_legend() for ax in figure.axes if ax.get_legend())]
    return [text.get_text() for found in own for text in found.get_texts()]


@pytest.mark.parametrize("panel", paper_tables.PANELS)
def test_errors_are_those_of_the_papers_three_methods(rows, panel):
    experiment = paper_tables.PANELS[panel]
    own = rows[experiment.name]
    figure = paper_figures.error_figure(experiment, own)
    methods = ("gcp", "initial_point_bvp", "midpoint_bvp")
    (ax,) = figure.axes
    assert [list(line.get_ydata()) for line in ax.lines] == [[r.errors[m] for r in own] for m in methods]
    slopes = [experiments.slope(own, m) for m in methods]
    assert legend(figure) == [f"{name}, slope {s:.2f}" for name, s in zip(NAMES, slopes, strict=True)]
    # The styles can be told apart without colour.
    assert len({line.get_linestyle() for line in ax.lines}) == len({line.get_marker() for line in ax.lines}) == 3


def test_zooms_show_the_curves_apart():
    figure = paper_figures.trajectory_figure()
    assert legend(figure) == ["reference", "GCP", "Retraction, N = 10", "Mid-point Retraction, N = 10"]
    for ax, shown in zip(figure.axes[1:], ("initial_point_bvp", "midpoint_bvp"), strict=True):
        half = ax.get_xlim()[1]
        marked = [line.get_xydata()[0] for line in ax.lines if line.get_linestyle() == "None"]
        distances = dict(zip(("reference", "gcp", "initial_point_bvp", "midpoint_bvp"), marked, strict=True))
        assert 0.5 * half < np.linalg.norm(distances[shown]) < half


def test_wide_figure_has_every_method_and_the_zoom_the_ones_of_order_2(rows):
    figure = figures.error_figure(experiments.SPHERE, rows["sphere"])
    wide, zoom = figure.axes
    assert len(wide.lines) == len(legend(figure)) == len(experiments.ALL_METHODS)
    drawn = [line.get_label().split(",")[0] for line in zoom.lines]
    assert drawn == ["mid-point IVP", "mid-point BVP", "splitting 2 IVP"]
    # A single N has neither slope nor zoom.
    assert len(figures.error_figure(experiments.SPHERE, rows["sphere"][:1]).axes) == 1


def test_conjecture_figure_draws_the_ratios(study):
    figure = conjecture_figure.figure(study)
    assert sorted(legend(figure)) == ["Cayley", "exponential", "quasi-geodesic"]
    found = conjecture.outcomes(study)
    paper = [list(line.get_ydata()) for ax in figure.axes[::2] for line in ax.lines[1:]]
    assert paper == [list(x.ratios) for x in found if x.curves == "paper"]
    random = [list(line.get_xdata()) for ax in figure.axes[1::2] for line in ax.lines[1:]]
    assert random == [sorted(x.ratios) for x in found if x.curves == "random"]


def test_wide_study_has_a_row_for_each_retraction(study):
    figure = conjecture_figure.wide_figure(study)
    assert len(figure.axes) == 8
    for ax, experiment in zip(figure.axes, 2 * [e for e in experiments.EXPERIMENTS for _ in range(2)], strict=True):
        marks = [line for line in ax.lines if line.get_marker() == "D"]
        # Without the map with which the others are compared; the legend's own markers contain no points.
        assert sum(len(line.get_xdata()) for line in marks) == len(retractions.retractions(experiment)) - 1
