"""Copy the docstrings of the compiled module into its stub, for editors: ``python -m tools.stub_docstrings``.

Docstrings are written once, as documentation comments in ``src/python``. Run this after each build that changes them.
Signatures and types in the stub are written by hand and left unchanged.
"""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from stiefel_rs import _core

STUB = Path(__file__).parents[1] / "python" / "stiefel_rs" / "_core.pyi"


def definitions(tree: ast.Module) -> Iterator[tuple[str, ast.ClassDef | ast.FunctionDef]]:
    """Yield the public classes, functions, methods and properties of a stub with their qualified names."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
            yield node.name, node
            for member in node.body if isinstance(node, ast.ClassDef) else []:
                if isinstance(member, ast.FunctionDef) and (
                    member.name == "__call__" or not member.name.startswith("_")
                ):
                    yield f"{node.name}.{member.name}", member


def compiled_docstring(name: str, module: ModuleType) -> str:
    """Return the docstring of an object of the compiled module."""
    found: object = module
    for part in name.split("."):
        found = getattr(found, part)
    text = inspect.getdoc(found)
    if not text:
        raise ValueError(f"{name} has no docstring")
    return text


def differences(stub: str, module: ModuleType) -> list[str]:
    """Return the names whose docstring in the stub differs from the compiled one."""
    found = [(name, (ast.get_docstring(node) or "").rstrip()) for name, node in definitions(ast.parse(stub))]
    return [name for name, text in found if text != compiled_docstring(name, module)]


def literal(text: str, indent: str) -> str:
    """Return a docstring as source whose lines after the first are indented."""
    first, *others = text.splitlines()
    lines = [first, *(f"{indent}{line}" if line else "" for line in others)]
    # A quotation mark next to the quotes of the literal would belong to them.
    start = ('r"""' if "\\" in text else '"""') + (" " if text.startswith('"') else "")
    end = f"\n{indent}" if others else " " if text.endswith('"') else ""
    return start + "\n".join(lines) + end + '"""'


def with_docstrings(stub: str, module: ModuleType) -> str:
    """Return the stub with the docstrings of the compiled module in place of its own."""
    source = stub.encode()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    edits = []
    for name, node in definitions(ast.parse(stub)):
        body, indent = node.body[0], " " * (node.col_offset + 4)
        text = literal(compiled_docstring(name, module), indent)
        if isinstance(node, ast.FunctionDef) or ast.get_docstring(node) is not None:
            start = len(source[: starts[body.lineno - 1] + body.col_offset].rstrip())
            end = starts[(body.end_lineno or 0) - 1] + (body.end_col_offset or 0)
            edits.append((start, end, f"\n{indent}{text}"))
        else:
            decorators = body.decorator_list if isinstance(body, ast.FunctionDef) else []
            start = starts[min([body.lineno, *(decorator.lineno for decorator in decorators)]) - 1]
            edits.append((start, start, f"{indent}{text}\n\n"))
    for start, end, text in sorted(edits, reverse=True):
        source = source[:start] + text.encode() + source[end:]
    return source.decode()


if __name__ == "__main__":
    STUB.write_text(with_docstrings(STUB.read_text(encoding="utf-8"), _core), encoding="utf-8")
