"""What `help` and editors show: every public callable and property has a docstring, every callable a signature."""

import inspect
import subprocess
import sys

import pytest

import stiefel_rs

CLASSES = [name for name in stiefel_rs.__all__ if isinstance(getattr(stiefel_rs, name), type)]
# Inherited from Python: tuples, exceptions, dataclasses.
INHERITED = {name for base in (BaseException, tuple, object) for name in dir(base)}


def members(name):
    found = getattr(stiefel_rs, name)
    public = [member for member in dir(found) if member == "__call__" or not member.startswith("_")]
    # Variables of a class have no docstrings: for errors, the docstring of the class describes them.
    return [member for member in public if getattr(found, member) is not None]


CASES = [(name, member) for name in CLASSES for member in members(name) if member not in INHERITED - {"__call__"}]
CALLABLE = [(name, member) for name, member in CASES if callable(getattr(getattr(stiefel_rs, name), member))]


@pytest.mark.parametrize(("name", "member"), CASES)
def test_members_have_docstrings(name, member):
    text = inspect.getdoc(getattr(getattr(stiefel_rs, name), member))
    assert text and "Call self as a function" not in text and "Alias for field" not in text


@pytest.mark.parametrize(("name", "member"), CALLABLE)
def test_methods_have_signatures(name, member):
    signature = inspect.signature(getattr(getattr(stiefel_rs, name), member))
    kinds = [parameter.kind for parameter in signature.parameters.values()]
    assert inspect.Parameter.VAR_POSITIONAL not in kinds


@pytest.mark.parametrize("name", stiefel_rs.__all__)
def test_names_have_docstrings(name):
    assert name == "__version__" or inspect.getdoc(getattr(stiefel_rs, name))


def test_a_curve_says_how_it_is_called():
    curve = stiefel_rs.QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
    parameters = inspect.signature(curve).parameters
    assert list(parameters) == ["t", "nu", "extrapolate", "num_threads"]
    assert "Position" in inspect.getdoc(type(curve).__call__)
    assert repr(curve) == "<QuasiGeodesic on St(2, 1), t_span (0.0, 1.0)>"


@pytest.mark.parametrize("name", ["explore", "plotting", "pymanopt", "reproduce"])
def test_subpackages_are_attributes(name):
    line = f"import stiefel_rs; print(stiefel_rs.{name}.__name__, {name!r} in dir(stiefel_rs))"
    found = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True, check=True)
    assert found.stdout.split() == [f"stiefel_rs.{name}", "True"]


def test_rotations_poses_and_files_are_imported_on_first_use():
    line = (
        "import sys, stiefel_rs; names = ('pose', 'rotation', 'storage', 'trajectory_files')\n"
        "print([name for name in names if f'stiefel_rs.{name}' in sys.modules])\n"
        "print(stiefel_rs.rotation.RotationSpline is stiefel_rs.RotationSpline)\n"
        "print(stiefel_rs.storage.load is stiefel_rs.load)"
    )
    found = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines() == ["[]", "True", "True"]


def test_help_works_without_the_extras():
    lines = [
        "import sys, pydoc, inspect",
        "sys.modules.update(dict.fromkeys(['jax', 'torch', 'dask', 'matplotlib', 'pymanopt']))",
        "import stiefel_rs",
        "assert 'RotationSpline' in pydoc.render_doc(stiefel_rs)",
        "assert 'interpolates rotations given as quaternions' in inspect.getdoc(stiefel_rs)",
        "assert dict(inspect.getmembers(stiefel_rs))['CubicSpline'] is stiefel_rs.CubicSpline",
        "assert not hasattr(stiefel_rs, 'torch')",
        "stiefel_rs.jax",
    ]
    found = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False)
    assert "AttributeError: stiefel_rs.jax: " in found.stderr
    assert "pip install 'stiefel-rs[jax]'" in found.stderr


def test_an_attribute_that_is_none_is_named():
    with pytest.raises(AttributeError, match="module 'stiefel_rs' has no attribute 'plot'"):
        _ = stiefel_rs.plot
