"""The stub agrees with the compiled module; every public name is documented; every example runs."""

import doctest
import inspect
import subprocess
import sys

import numpy as np
import pytest
from beside import HANGS

import stiefel_rs
from stiefel_rs import _core, angular_motion, errors, pose_motion, rotation_motion

MODULES = [stiefel_rs, _core, errors, angular_motion, rotation_motion, pose_motion]


def documented():
    """All (name, object) pairs with docstrings: modules, their public names, and public members of classes."""
    found = {}
    for module in MODULES:
        found[module.__name__] = module
        for name, value in vars(module).items():
            if name.startswith("_") or not (inspect.isclass(value) or callable(value)):
                continue
            if not getattr(value, "__module__", "").startswith("stiefel_rs"):
                continue
            found[f"stiefel_rs.{name}"] = value
            if inspect.isclass(value):
                for member, attribute in vars(value).items():
                    if not member.startswith("_"):
                        found[f"stiefel_rs.{name}.{member}"] = attribute
    return found


DOCUMENTED = documented()


def test_stub_agrees_with_the_module():
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "stiefel_rs._core"],
        capture_output=True,
        text=True,
        timeout=HANGS,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_all_lists_the_public_names():
    for name in stiefel_rs.__all__:
        assert hasattr(stiefel_rs, name), f"__all__ lists {name}, which does not exist"
    public = {n for n, v in vars(stiefel_rs).items() if not n.startswith("_") and not inspect.ismodule(v)}
    assert public <= set(stiefel_rs.__all__), f"not in __all__: {sorted(public - set(stiefel_rs.__all__))}"


@pytest.mark.parametrize("name", [n for n in stiefel_rs.__all__ if n != "__version__"])
def test_public_names_are_documented(name):
    doc = inspect.getdoc(getattr(stiefel_rs, name))
    assert doc, f"{name} has no docstring"
    assert len(doc.splitlines()[0]) > 10, f"{name}: {doc!r}"


@pytest.mark.parametrize("name", sorted(n for n in DOCUMENTED if n.count(".") == 2))
def test_public_members_are_documented(name):
    # Fields of reports are listed under Attributes of their class.
    owner = DOCUMENTED[name.rsplit(".", 1)[0]]
    field = name.rsplit(".", 1)[1]
    listed = f"\n{field} :" in (inspect.getdoc(owner) or "")
    assert listed or inspect.getdoc(DOCUMENTED[name]), f"{name} has no docstring"


@pytest.mark.parametrize(
    "name",
    [
        "Chart",
        "CubicHermite",
        "CubicSpline",
        "GeometricCubic",
        "GeometricPolynomial",
        "Grassmann",
        "PoseSpline",
        "QuasiGeodesic",
        "RiemannianCubic",
        "RotationSpline",
        "SmoothingSpline",
        "Stiefel",
        "estimate_velocities",
        "integrate_cubic",
        "integrate_embedded",
        "orthogonal_log",
        "skew_exp",
        "solve_boundary",
    ],
)
def test_entry_points_have_an_example(name):
    assert doctest.DocTestParser().get_examples(getattr(stiefel_rs, name).__doc__), f"{name} has no example"


@pytest.mark.parametrize("name", sorted(n for n, v in DOCUMENTED.items() if ">>>" in (inspect.getdoc(v) or "")))
def test_examples_run(name):
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(DOCUMENTED[name]), {"np": np}, name, None, 0)
    said = []
    results = doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    assert results.failed == 0, "".join(said)
    assert results.attempted > 0


@pytest.mark.parametrize(
    "name",
    [
        "Chart",
        "CubicHermite",
        "CubicSpline",
        "GeometricCubic",
        "GeometricPolynomial",
        "Grassmann",
        "PoseSpline",
        "QuasiGeodesic",
        "RiemannianCubic",
        "RotationSpline",
        "SmoothingSpline",
        "Stiefel",
        "estimate_velocities",
        "integrate_cubic",
        "integrate_embedded",
        "orthogonal_log",
        "skew_exp",
        "solve_boundary",
    ],
)
def test_signatures_can_be_read(name):
    value = getattr(stiefel_rs, name)
    members = [value] if not inspect.isclass(value) else [m for n, m in vars(value).items() if not n.startswith("_")]
    for member in members:
        if callable(member):
            inspect.signature(member)


def test_names_and_versions_agree():
    assert stiefel_rs.__version__ == _core.__VERSION__
    for name in stiefel_rs.__all__:
        value = getattr(stiefel_rs, name)
        if inspect.isclass(value):
            assert value.__module__.split(".")[0] == "stiefel_rs", f"{name} says it lives in {value.__module__}"


def test_no_plotting_library_is_loaded():
    code = "import sys, stiefel_rs; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
