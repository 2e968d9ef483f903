"""Every page of the site on a wide and on a small screen, and what its search finds."""

import pytest
from page import SIGNATURES, TABLES

# The first result for each word is one of these pages.
FIRST = {
    "rotation": {"guides/interpolate_rotations_and_poses.html"},
    "quaternion": {"guides/interpolate_rotations_and_poses.html"},
    "pose": {"guides/interpolate_rotations_and_poses.html"},
    "Grassmann": {"guides/interpolate_subspaces_and_complex_frames.html", "reference/manifold.html"},
    "hermite": {"guides/interpolate_many_points.html", "reference/splines.html"},
    "uncertainty": {"what_it_does_not_do.html"},
}


def test_tables_and_signatures_fit_a_wide_screen(page, path):
    page.resize(1400)
    page.open(path)
    assert page.scrolling(TABLES) == []
    assert page.scrolling(SIGNATURES) == []


def test_pages_fit_a_small_screen(page, path):
    page.resize(400)
    page.open(path)
    assert page.width() <= 400
    assert page.scrolling(SIGNATURES) == []


@pytest.mark.parametrize("word", FIRST)
def test_search_finds_a_page_that_helps(page, word):
    page.resize(1400)
    assert page.search(word)[0].split("#")[0] in FIRST[word]
