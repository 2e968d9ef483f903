"""Every public type of the crate has an example, which `cargo test --doc` runs."""

import re
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "src"

# Types without an example, by path, with the reason.
EXCEPTIONS: dict[str, str] = {}

MODULE = re.compile(r"^(pub )?mod (\w+);", re.MULTILINE)
USE = re.compile(r"^pub use ([\w:]+?)(?:::\{([^}]*)\})?;", re.MULTILINE)
TYPE = re.compile(r"^((?:///.*\n)*)(?:#\[[^\]]*\]\n)*pub (?:struct|enum|trait) (\w+)", re.MULTILINE)
EXAMPLE = re.compile(r"^/// # Examples\n(?:///.*\n)*?/// ```\n(?:///.*\n)*?///.*\bassert", re.MULTILINE)


def source_of(module):
    """The text of a module, given by the path of names from the root."""
    if not module:
        return (SOURCES / "lib.rs").read_text(encoding="utf-8")
    file = SOURCES.joinpath(*module).with_suffix(".rs")
    return (file if file.exists() else SOURCES.joinpath(*module, "mod.rs")).read_text(encoding="utf-8")


def exported(source):
    """Names that a module re-exports from its own modules: pairs of the path to a module and a name in it."""
    for path, names in USE.findall(source):
        *parents, last = path.split("::")
        if names:
            yield from ((*parents, last, name.strip()) for name in names.split(",") if name.strip())
        else:
            yield (*parents, last)


def types_of(module, names=None):
    """The documentation of the types of a module that a user can name: all public ones, or those with given names."""
    source = source_of(module)
    for documentation, name in TYPE.findall(source):
        if names is None or name in names:
            yield "::".join((*module, name)), documentation
    if names is None:
        for public, name in MODULE.findall(source):
            if public:
                yield from types_of((*module, name))
    for *path, name in exported(source):
        if names is None or name in names:
            yield from types_of((*module, *path), {name})


TYPES = dict(types_of(()))


@pytest.mark.parametrize("path", TYPES)
def test_public_type_has_an_example_that_asserts(path):
    assert bool(EXAMPLE.search(TYPES[path])) != (path in EXCEPTIONS)


def test_types_are_found_where_they_are_exported():
    exports = {"cubic::boundary::search::SearchOptions", "chart::sphere::Sphere", "spline::ends::EndCondition"}
    assert exports | {"error::Error", "curve::curve::Curve", "linalg::decomp::Svd"} <= TYPES.keys()
    # Not public: used only inside the crate.
    assert "chart::tangent_lift::TangentLift" not in TYPES


def test_exceptions_exist():
    assert EXCEPTIONS.keys() <= TYPES.keys()
