"""Additions to the stubs for the reference pages: docstrings and defaults of the compiled module."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import griffe

import stiefel_rs
import stiefel_rs._core as compiled

ROLE = re.compile(r":(?:meth|func|class):`([^`]+)`")
NO_BREAK = "\u00a0"
SHAPE = re.compile(r"(ndarray|array_like), ((?:each of )?shape)")
TYPED = re.compile(r"^(?P<name>\w+(?:, \w+)*) : (?P<kind>.+?)(?P<rest>, optional|, default .*|)$", flags=re.MULTILINE)
SEE_ALSO = re.compile(r"^See Also\n-+\n(?:\S.*\n?)+", flags=re.MULTILINE)
SEEN = re.compile(r"^(\w+) : ", flags=re.MULTILINE)
# Public names of the subpackages, as griffe finds them: not all can be imported where the site is built.
EXPORTS: dict[str, set[str]] = {}
TABLE = re.compile(
    r"^(?P<rule>=+(?: +=+)+)\n(?P<head>.+\n)(?P=rule)\n(?P<rows>(?:.+\n)*?)(?P=rule)\n?", flags=re.MULTILINE
)


class CompiledDocstrings(griffe.Extension):
    """Creates the objects of `_core` from its stubs, with the texts of the compiled module."""

    def on_package(self, *, pkg: griffe.Module, loader: griffe.GriffeLoader, **_: Any) -> None:
        """Replace griffe's result for the compiled module by its stubs, completed."""
        if pkg.name != "stiefel_rs":
            return
        # The compiled module is not a subpackage: its names are those of the package.
        for name, module in pkg.modules.items():
            if name == "_core":
                continue
            EXPORTS[name] = {str(export) for export in module.exports or ()}
        _translate(pkg)
        for name, found in list(_stubs(pkg, loader).members.items()):
            if name not in stiefel_rs.__all__:
                continue
            if isinstance(found, griffe.Class):
                _complete_class(found, getattr(compiled, name))
            elif isinstance(found, griffe.Function):
                _complete(found, getattr(compiled, name))
            # In place of the alias: compiled objects state that they belong to the package.
            pkg.del_member(name)
            pkg.set_member(name, found)


def _translate(found: griffe.Module | griffe.Class) -> None:
    """Translate the texts of the parts written in Python."""
    for member in found.members.values():
        if isinstance(member, griffe.Alias) or member.name == "_core":
            continue
        if member.docstring:
            public = [part for part in found.path.split(".")[1:] if not part.startswith("_")]
            member.docstring.value = markdown(member.docstring.value, ".".join(public))
        if isinstance(member, griffe.Module | griffe.Class):
            _translate(member)


def _stubs(pkg: griffe.Module, loader: griffe.GriffeLoader) -> griffe.Module:
    path = Path(compiled.__file__).parent / "_core.pyi"
    return griffe.visit(
        "_core",
        filepath=path,
        code=path.read_text(encoding="utf-8"),
        parent=pkg,
        docstring_parser=loader.docstring_parser,
        lines_collection=loader.lines_collection,
        modules_collection=loader.modules_collection,
    )


def _complete_class(found: griffe.Class, runtime: type) -> None:
    """Docstrings of a class and its members; overloads become one method, `__new__` the signature of the class."""
    found.docstring = _docstring(found, runtime)
    for name, versions in found.overloads.items():
        if versions:
            found.set_member(name, versions[-1])
    found.overloads.clear()
    for name, member in list(found.members.items()):
        if name == "__new__":
            _use_as_signature(found, runtime)
        elif isinstance(member, griffe.Function | griffe.Attribute):
            _complete(member, getattr(runtime, name))


def _use_as_signature(found: griffe.Class, runtime: type) -> None:
    made = found.members["__new__"]
    found.del_member("__new__")
    # Classes that are only created by static methods accept any arguments, and refuse them.
    if isinstance(made, griffe.Function) and "_args" not in made.parameters:
        made.name = "__init__"
        _take_defaults(made, runtime)
        found.set_member("__init__", made)


def _complete(found: griffe.Function | griffe.Attribute, runtime: object) -> None:
    found.docstring = _docstring(found, runtime)
    if isinstance(found, griffe.Function):
        _take_defaults(found, runtime)


def _take_defaults(found: griffe.Function, runtime: object) -> None:
    """Take the defaults from the compiled function, since stubs may abbreviate them."""
    try:
        stated = inspect.signature(runtime).parameters  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return
    for parameter in found.parameters:
        if parameter.name in stated and stated[parameter.name].default is not inspect.Parameter.empty:
            default = stated[parameter.name].default
            parameter.default = "..." if default is ... else repr(default)


def _docstring(found: griffe.Object, runtime: object) -> griffe.Docstring | None:
    text = inspect.getdoc(runtime)
    if not text:
        return None
    owner = found.name if isinstance(found, griffe.Class) else found.parent.name if found.parent else ""
    return griffe.Docstring(markdown(text, owner), parent=found, parser=griffe.Parser.numpy)


def markdown(text: str, owner: str) -> str:
    """The Markdown equivalent of the reStructuredText in a docstring of that class."""
    text = TABLE.sub(_table, text)
    text = SHAPE.sub(rf"\1,{NO_BREAK}\2", TYPED.sub(_as_text, text))
    text = SEE_ALSO.sub(lambda section: SEEN.sub(r"[`\1`][stiefel_rs.\1]: ", section[0]), text)
    return ROLE.sub(lambda role: f"[`{role[1]}`][{_path(role[1], owner)}]", text)


def _table(found: re.Match[str]) -> str:
    starts = [column.start() for column in re.finditer("=+", found["rule"])]
    cells = [
        [line[start:end].strip() for start, end in zip(starts, [*starts[1:], None], strict=True)]
        for line in (found["head"] + found["rows"]).splitlines()
    ]
    # A line without a first cell continues the line above.
    rows: list[list[str]] = []
    for line in cells:
        if line[0] or not rows:
            rows.append(line)
        else:
            rows[-1] = [f"{above} {below}".strip() for above, below in zip(rows[-1], line, strict=True)]
    head, *body = (f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in rows)
    return "\n".join([head, "|---" * len(starts) + "|", *body]) + "\n"


def _as_text(line: re.Match[str]) -> str:
    """A type that is a sentence rather than an expression: griffe keeps text that it cannot compile."""
    kind = line["kind"]
    if kind.startswith("{"):
        # griffe would take the first choice for the default.
        *choices, last = kind.strip("{}").split(", ")
        kind = f"{', '.join(choices)}{NO_BREAK}or {last}"
    elif '"' in kind:
        kind = kind.replace(" ", NO_BREAK, 1)
    return f"{line['name']} : {kind}{line['rest']}"


def _path(name: str, owner: str) -> str:
    """The full name to which a role refers: a public name, of a subpackage first, or a method of the class."""
    if name.startswith("stiefel_rs."):
        return name
    package = owner.partition(".")[0]
    if name.partition(".")[0] in EXPORTS.get(package, ()):
        return f"stiefel_rs.{package}.{name}"
    if name in stiefel_rs.__all__ or "." in name:
        return f"stiefel_rs.{name}"
    return f"stiefel_rs.{owner}.{name}"
