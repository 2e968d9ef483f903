"""The stub has the docstrings of the compiled module, for editors; ``make stub`` copies them."""

import ast
import inspect
import types

import pytest

from stiefel_rs import _core
from tools import stub_docstrings

STUB = stub_docstrings.STUB.read_text(encoding="utf-8")
SMALL = '''from typing import overload

class Ball:
    # The radius.
    @property
    def radius(self) -> float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def grow(
        self, by: float
    ) -> None:
        """Say something else."""

@overload
def weigh(ball: Ball) -> float: ...
@overload
def weigh(ball: int) -> int: ...
'''


def small_module():
    class Ball:
        """A ball."""

        @property
        def radius(self):
            return 1.0

        def grow(self, by):
            r"""Grow the ball.

            Notes
            -----
            By ``\\delta r``.
            """

    def weigh(ball):
        """Return the weight."""

    Ball.radius.__doc__ = '"metres" is the unit; zero is "a point"'
    module = types.ModuleType("small")
    module.Ball, module.weigh = Ball, weigh
    return module


def test_the_stub_has_the_docstrings_of_the_module():
    assert stub_docstrings.differences(STUB, _core) == []


def test_writing_them_again_changes_nothing():
    assert stub_docstrings.with_docstrings(STUB, _core) == STUB


def test_every_public_object_of_the_module_is_in_the_stub():
    names = {name for name, _ in stub_docstrings.definitions(ast.parse(STUB))}
    for name, value in vars(_core).items():
        if name.startswith("_") or not callable(value):
            continue
        assert name in names
        if inspect.isclass(value):
            members = {f"{name}.{member}" for member in vars(value) if not member.startswith("_")}
            assert members <= names


def test_docstrings_are_put_into_a_stub_without_them():
    module = small_module()
    written = stub_docstrings.with_docstrings(SMALL, module)
    assert stub_docstrings.differences(SMALL, module) == ["Ball", "Ball.radius", "Ball.grow", "weigh", "weigh"]
    assert stub_docstrings.differences(written, module) == []
    assert stub_docstrings.with_docstrings(written, module) == written
    assert "Say something else" not in written
    assert "def __eq__(self, other: object, /) -> bool: ...\n" in written


def test_an_object_without_a_docstring_is_named():
    module = small_module()
    module.weigh.__doc__ = None
    with pytest.raises(ValueError, match="weigh has no docstring"):
        stub_docstrings.with_docstrings(SMALL, module)
