"""Docstrings of splines of rotations and of poses name the unit of every quantity."""

import inspect
import re

import pytest

from stiefel_rs import PoseSpline, RotationSpline

CLASSES = [RotationSpline, PoseSpline]
# "s", "rad", "m" as words, also in "rad/s^2" and "1/s^2"; not in "SciPy's" or "`s`".
UNIT = re.compile(r"(?<![\w'`(])(?:rad|s|m|1/s)(?:/s)?(?:\^-?\w+)?(?![\w`(])|dimensionless")
# Arguments that are quantities.
QUANTITIES = {"t", "times", "t0", "t1", "bc_type", "curve", "lam", "order", "poses", "rates", "tension", "weights"}
# Members without a quantity: rotations, names, flags, and the outcome of a solver, which has its own docstrings.
WITHOUT = {"rotations", "kind", "extrapolate", "report", "rotation", "from_curve", "smoothing", "hermite"}


def public(cls):
    """Docstrings by name; that of the class describes its constructor."""
    names = [name for name in dir(cls) if name == "__call__" or not name.startswith("_")]
    return {"class": inspect.getdoc(cls)} | {name: inspect.getdoc(getattr(cls, name)) for name in names}


def section(text, title):
    """Text of a section of a docstring, empty if there is none."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=^\S[^\n]*\n-+\n|\Z)", text, flags=re.DOTALL | re.MULTILINE)
    return found[1] if found else ""


def arguments(text):
    """Descriptions of the arguments in a docstring, by name."""
    parts = re.split(r"^(\w[\w, ]*?)(?: :.*)?\n(?=    )", section(text, "Parameters"), flags=re.MULTILINE)
    names, texts = parts[1::2], parts[2::2]
    return {name: what for each, what in zip(names, texts, strict=True) for name in each.split(", ")}


TAKEN = [
    (cls, member, name, what)
    for cls in CLASSES
    for member, text in public(cls).items()
    for name, what in arguments(text).items()
    if name in QUANTITIES
]
GIVEN = [(cls, member) for cls in CLASSES for member in public(cls) if member not in {*WITHOUT, "class"}]


def names_unit(text):
    return UNIT.search(text) is not None


@pytest.mark.parametrize(("cls", "member", "name", "what"), TAKEN, ids=lambda part: getattr(part, "__name__", None))
def test_arguments_name_their_unit(cls, member, name, what):
    # The arguments of a class are described once.
    assert names_unit(what) or re.match(r"\s+As for (?:the class|`\w+`)", what), f"{cls.__name__}.{member}: {name}"


@pytest.mark.parametrize(("cls", "member"), GIVEN)
def test_results_name_their_unit(cls, member):
    text = public(cls)[member]
    # Properties have no section.
    assert names_unit(section(text, "Returns") or text), f"{cls.__name__}.{member}"


def test_every_argument_is_known():
    found = {name for cls in CLASSES for text in public(cls).values() for name in arguments(text)}
    others = {"rotations", "project", "extrapolate", "tol", "max_iterations", "num_threads", "kind", "frame", "w"}
    assert found == QUANTITIES | others
    assert len(TAKEN) > 30
    assert len(GIVEN) > 25


def test_words_that_are_not_units():
    for text in ("Alias of `t`, as in SciPy.", "Evaluate `s` of SciPy's class", "Times as given", "spline(s) or m(s)"):
        assert not names_unit(text)
    for text in ("Times, in s.", "In rad/s^2.", "in s^3; 0", "1/s^2, as", "In m (", "rad^2/s^3", "In rad/s^order"):
        assert names_unit(text)
