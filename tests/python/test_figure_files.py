"""How figures are written: print size, light and dark pages, and what shorter files keep."""

import io
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from drawn import spline

from stiefel_rs import InvalidInputError, palette

matplotlib = pytest.importorskip("matplotlib")
plotting = pytest.importorskip("stiefel_rs.plotting")
from matplotlib.figure import Figure  # noqa: E402

from stiefel_rs import figure_style, figure_svg  # noqa: E402

SVG = "{http://www.w3.org/2000/svg}"


def drawn():
    """A figure in the style, with a line of many points, equal marks and words."""
    with figure_style.context():
        figure = figure_style.new_figure(3.4, 2.6)
        ax = figure.add_subplot()
        x = np.linspace(0, 1, 40)
        ax.plot(x, np.sin(9 * x), color=palette.INK, label="sine")
        ax.plot(x, np.cos(9 * x), "o", color=palette.BLUE, markerfacecolor=palette.BACKGROUND, label="cosine")
        ax.set(xlabel="time", ylabel="value")
        ax.legend()
    return figure


def svg(figure, tmp_path):
    plotting.save(figure, tmp_path / "figure.svg")
    return (tmp_path / "figure.svg").read_text(encoding="utf-8")


def absolute(d):
    """Vertices of a path of lines, in points."""
    found, here = [], np.zeros(2)
    for command, numbers in re.findall(r"([Mlz])([^Mlz]*)", d):
        pairs = np.array(numbers.split(), dtype=float).reshape(-1, 2)
        for pair in pairs:
            here = pair if command == "M" else here + pair
            found.append(here)
    return np.array(found)


def test_lines_keep_their_vertices_to_a_hundredth_of_a_point():
    rng = np.random.default_rng(0)
    points = np.cumsum(rng.normal(size=(500, 2)), axis=0)
    commands = ["M", *["L"] * 249, "M", *["L"] * 249]
    d = "".join(f"{c} {x:.6f} {y:.6f} \n" for c, (x, y) in zip(commands, points, strict=True))
    (short,) = re.findall('d="(.*)"', figure_svg.adapted(f'<svg><path d="{d}z"/></svg>'))
    assert len(short) < 0.6 * len(d)
    # Half of the last digit, which does not add up from vertex to vertex.
    assert np.abs(absolute(short) - points).max() < 0.005 + 1e-9
    assert short.endswith("z")


def test_curves_keep_their_shape():
    d = "M 0 2.123456 \nC 0.7 2.75 1.4 2.46 1.9 1.9 \nz"
    assert 'd="M 0 2.12C 0.7 2.75 1.4 2.46 1.9 1.9z"' in figure_svg.adapted(f'<svg><path d="{d}"/></svg>')


def test_equal_marks_have_one_style_and_none_is_lost(tmp_path):
    text = svg(drawn(), tmp_path)
    root = ElementTree.fromstring(text)
    groups = [group for group in root.iter(f"{SVG}g") if len(group.findall(f"{SVG}use")) == 40]
    assert len(groups) == 1
    assert not any(use.get("class") for use in groups[0])


def test_dark_pages_have_other_colours(tmp_path):
    text = svg(drawn(), tmp_path)
    light, dark = re.search(r"<style>(.*?)@media \(prefers-color-scheme:dark\)\{(.*?)\}</style>", text).groups()
    assert palette.INK.lower() in light and palette.DARK[palette.INK] in dark
    assert palette.BLUE.lower() in light and palette.DARK[palette.BLUE] in dark
    # Every class of the text has a rule, and no colour of a light page is left on a dark one.
    classes = set(re.findall(r'class="(\w+)"', text))
    assert classes == set(re.findall(r"\.(\w+)\{", light))
    assert not [colour for colour in palette.DARK if colour.lower() in dark]


def test_text_is_text_and_nothing_is_behind_it(tmp_path):
    root = ElementTree.fromstring(svg(drawn(), tmp_path))
    words = {"".join(text.itertext()).strip() for text in root.iter(f"{SVG}text")}
    assert {"time", "value", "sine", "cosine"} <= words
    width, height = (float(root.get(side)[:-2]) for side in ("width", "height"))
    assert (width, height) == pytest.approx((72 * 3.4, 72 * 2.6))
    sheet = "".join(style.text for style in root.iter(f"{SVG}style"))
    for path in root.iter(f"{SVG}path"):
        vertices = absolute(path.get("d")) if set(path.get("d")) <= set("Mlz-. 0123456789") else np.zeros((1, 2))
        if (np.ptp(vertices, axis=0) > [0.99 * width, 0.99 * height]).all():
            (rule,) = re.findall(rf"\.{path.get('class')}\{{([^}}]*)\}}", sheet)[:1]
            assert rule == "fill: none"


def test_black_text_of_a_users_figure_is_light_on_dark_pages(tmp_path):
    figure = Figure()
    figure.text(0.5, 0.5, "black")
    text = svg(figure, tmp_path)
    name = re.search(r'<g class="(\w+)" id="text_1">', text)[1]
    assert f".{name}{{fill: {palette.DARK[palette.INK]}}}" in text


def test_colours_of_dark_pages_stand_out():
    """Contrast of WCAG 2.2: 4.5 for text, 3 for lines that say something."""

    def luminance(colour):
        rgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
        return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]

    def contrast(a, b):
        low, high = sorted((luminance(a), luminance(b)))
        return (high + 0.05) / (low + 0.05)

    paper = palette.BACKGROUND
    for colour in (palette.INK, palette.GREY):
        assert contrast(colour, paper) > 4.5
        assert contrast(palette.DARK[colour], palette.DARK[paper]) > 4.5
    # Orange and sky blue are the last two, for what has dashes or marks of its own.
    for colour in (*palette.CURVES[:3], *palette.BODY_AXES):
        assert contrast(colour, paper) > 3
        assert contrast(palette.DARK.get(colour, colour), palette.DARK[paper]) > 3


def test_png_has_200_dots_per_inch_and_pdf_no_date(tmp_path):
    ax = plotting.plot(spline(4, 2))
    for name in ("figure.png", "figure.pdf"):
        plotting.save(ax, tmp_path / name)
    png = (tmp_path / "figure.png").read_bytes()
    assert int.from_bytes(png[16:20], "big") == 680
    assert b"CreationDate" not in (tmp_path / "figure.pdf").read_bytes()


def test_the_same_figure_gives_the_same_file(tmp_path):
    assert svg(drawn(), tmp_path) == svg(drawn(), tmp_path)


def test_settings_are_left_alone(tmp_path):
    before = dict(matplotlib.rcParams)
    svg(drawn(), tmp_path)
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda path: plotting.save("figure", path / "a.svg"), "figure: a Figure or Axes expected, found str"),
        (lambda path: plotting.save(drawn(), path / "a.gif"), r"path: a name that ends in \.svg, \.png, \.pdf"),
        (lambda path: plotting.save(drawn(), path / "svg"), "expected, found 'svg'"),
    ],
)
def test_bad_arguments(tmp_path, call, message):
    with pytest.raises(InvalidInputError, match=message):
        call(tmp_path)


def test_style_is_print_size():
    with matplotlib.rc_context(plotting.STYLE):
        figure = Figure()
        ax = figure.add_subplot()
        ax.set_xlabel("time")
        assert ax.xaxis.label.get_fontsize() == figure_style.FONT_SIZE
        figure.savefig(io.BytesIO())
