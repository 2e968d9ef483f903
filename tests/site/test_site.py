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


@pytest.mark.parametrize(("system", "choice"), [("light", "dark"), ("dark", "light")])
def test_figures_follow_the_choice_of_the_reader(page, system, choice):
    page.resize(1400)
    page.prefer(system)
    page.open("index.html")
    # SVG files ask for the scheme of the element that shows them.
    scheme = "return getComputedStyle(document.querySelector('.md-content img')).colorScheme"
    assert page.browser.execute_script(scheme) == system
    page.browser.find_element("css selector", "label.md-header__button[for^=__palette]:not([hidden])").click()
    assert page.browser.execute_script(scheme) == choice


@pytest.mark.parametrize("word", FIRST)
def test_search_finds_a_page_that_helps(page, word):
    page.resize(1400)
    assert page.search(word)[0].split("#")[0] in FIRST[word]
